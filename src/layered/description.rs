//! Stack files: a stack as an artist writes it down, in TOML or as the same tree in JSON.
//!
//! ```toml
//! name  = "clear coat over copper"
//! model = "conserving"                      # one of Model::ALL; conserving where absent
//! widths = "variance"                       # one of Widths::ALL; the model's where absent
//! [[layer]]                                 # from the top
//! interface = { dielectric = { n = 1.5 }, alpha = 0.1 }
//! medium    = { sigma = [0.0, 0.1, 0.2], thickness = 0.5 }
//! [[layer]]
//! interface = { conductor = { metal = "copper" }, alpha = 0.3 }   # or { n = [..], k = [..] }
//! # or a base: interface = { diffuse = { albedo = [..], sigma = 0.3 } }
//! ```
//!
//! `n`, `k`, `albedo` and the medium's `sigma` are a number or a list of one number for each channel; all lists have
//! the same length, numbers hold for every channel. Indices are those of the materials themselves, against vacuum.
//! Whatever is not understood is refused, with the line, the key and what is allowed there; so is a medium that absorbs under the last
//! layer, which would do nothing. The ranges are those of [`Stack::new`], which is asked.

pub(crate) mod tree;

use super::error::Problem;
use super::{Interface, Layer, Medium, Model, Stack, StackError, Widths};
use crate::material::metal;
use crate::real::Real;
use alloc::borrow::ToOwned;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec;
use alloc::vec::Vec;
use core::fmt;
use tree::{Entry, Place, suggestion};
pub use tree::{Node, Value};

/// Why a description was refused, in one line: where, what is wrong and what is allowed.
#[derive(Clone, Debug, PartialEq)]
pub struct DescriptionError {
    /// The line of the file, counted from 1; none where the tree did not come from a file or the whole is at fault.
    pub line: Option<usize>,
    /// The path of the key, `layer[1].interface.alpha`; empty where the file is not TOML.
    pub key: String,
    /// What is wrong, and what is allowed.
    pub problem: String,
}

impl fmt::Display for DescriptionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.line, self.key.as_str()) {
            (Some(line), "") => write!(f, "line {line}: {}", self.problem),
            (Some(line), key) => write!(f, "line {line}, {key}: {}", self.problem),
            (None, "") => write!(f, "{}", self.problem),
            (None, key) => write!(f, "{key}: {}", self.problem),
        }
    }
}

impl core::error::Error for DescriptionError {}

/// What is expected of a [`Quantity`].
const CHANNELS: &str = "a number, or a list of one number for each channel";

/// A number for every channel or one for each, and where it was written.
#[derive(Clone, Debug, PartialEq)]
struct Quantity {
    values: Vec<f64>,
    /// The line of each number of a list; none for a number that holds for every channel.
    lines: Option<Vec<Option<usize>>>,
    place: Place,
}

impl Quantity {
    /// A number for every channel, or a list of one for each.
    fn read(entry: &Entry<'_>) -> Result<Self, DescriptionError> {
        let (values, lines) = match &entry.node.value {
            Value::Number(number) => (vec![*number], None),
            _ => {
                let items = entry.items(CHANNELS)?;
                if items.is_empty() {
                    return Err(entry.place.error(format!("found an empty list, expected {CHANNELS}")));
                }
                let values = items.iter().map(Entry::number).collect::<Result<_, _>>()?;
                (values, Some(items.iter().map(|item| item.place.line).collect()))
            }
        };
        Ok(Quantity { values, lines, place: entry.place.clone() })
    }

    /// A number that is the same for every channel.
    fn read_scalar(entry: &Entry<'_>) -> Result<Self, DescriptionError> {
        Ok(Quantity { values: vec![entry.number()?], lines: None, place: entry.place.clone() })
    }

    /// What the number is where nobody wrote it.
    fn zero(place: &Place) -> Self {
        Quantity { values: vec![0.0], lines: None, place: place.clone() }
    }

    fn at<R: Real>(&self, channel: usize) -> R {
        R::from_f64(self.values[if self.lines.is_some() { channel } else { 0 }])
    }

    fn each<R: Real, const C: usize>(&self, channel: impl Fn(usize) -> usize) -> [R; C] {
        core::array::from_fn(|c| self.at(channel(c)))
    }

    fn place_of(&self, index: usize) -> Place {
        match &self.lines {
            Some(lines) => self.place.item(index, lines.get(index).copied().flatten()),
            None => self.place.clone(),
        }
    }
}

/// An [`Interface`] as written.
#[derive(Clone, Debug, PartialEq)]
enum Boundary {
    Microfacet { n: Quantity, k: Quantity, alpha: Quantity },
    Diffuse { albedo: Quantity, sigma: Quantity, place: Place },
}

/// A [`Layer`] as written.
#[derive(Clone, Debug, PartialEq)]
struct Described {
    boundary: Boundary,
    sigma: Quantity,
    thickness: Quantity,
    /// Where the medium was written, if it was.
    medium: Option<Place>,
    place: Place,
}

impl Described {
    fn layer<R: Real, const C: usize>(&self, channel: impl Fn(usize) -> usize + Copy) -> Layer<R, C> {
        let interface = match &self.boundary {
            Boundary::Microfacet { n, k, alpha } => {
                Interface::Microfacet { n: n.each(channel), k: k.each(channel), alpha: alpha.at(0) }
            }
            Boundary::Diffuse { albedo, sigma, .. } => {
                Interface::Diffuse { albedo: albedo.each(channel), sigma: sigma.at(0) }
            }
        };
        Layer { interface, medium: Medium { sigma: self.sigma.each(channel), thickness: self.thickness.at(0) } }
    }

    /// What a [`StackError`] calls by this key.
    fn quantity(&self, key: &str) -> Option<&Quantity> {
        match (key, &self.boundary) {
            ("interface.n", Boundary::Microfacet { n, .. }) => Some(n),
            ("interface.k", Boundary::Microfacet { k, .. }) => Some(k),
            ("interface.alpha", Boundary::Microfacet { alpha, .. }) => Some(alpha),
            ("interface.diffuse.albedo", Boundary::Diffuse { albedo, .. }) => Some(albedo),
            ("interface.diffuse.sigma", Boundary::Diffuse { sigma, .. }) => Some(sigma),
            ("medium.sigma", _) => Some(&self.sigma),
            ("medium.thickness", _) => Some(&self.thickness),
            _ => None,
        }
    }

    /// What is said of a medium that absorbs under this layer, if it is the last.
    fn buried(&self) -> Option<DescriptionError> {
        let absorbs = |quantity: &Quantity| quantity.values.iter().any(|value| *value != 0.0);
        let problem =
            "no light comes back through a medium under the last layer: leave it out, or put a layer under it";
        let place = self.medium.as_ref().filter(|_| absorbs(&self.sigma) && absorbs(&self.thickness));
        place.map(|place| place.error(problem))
    }

    /// The quantities that may be lists.
    fn quantities(&self) -> impl Iterator<Item = &Quantity> {
        let interface = match &self.boundary {
            Boundary::Microfacet { n, k, .. } => [Some(n), Some(k)],
            Boundary::Diffuse { albedo, .. } => [Some(albedo), None],
        };
        interface.into_iter().flatten().chain([&self.sigma])
    }
}

/// A stack as it was written down, checked: every number is in the range that [`Stack::new`] asks for.
///
/// ```
/// use brdf::layered::{Model, description::Description};
///
/// let file = r#"
/// name = "varnish over grey"
/// [[layer]]
/// interface = { dielectric = { n = 1.5 }, alpha = 0.1 }
/// [[layer]]
/// interface = { diffuse = { albedo = 0.5 } }
/// "#;
/// let description = Description::from_toml(file)?;
/// assert_eq!((description.channels(), description.model), (1, None));
/// let stack = description.stack::<f32, 3>()?;
/// assert_eq!((stack.layers().len(), stack.model()), (2, Model::Conserving));
///
/// let error = Description::from_toml(&file.replace("0.1", "2")).unwrap_err();
/// assert_eq!(error.to_string(), "line 4, layer[0].interface.alpha: 2 is not allowed, it must be in [0.0001, 1]");
/// # Ok::<(), brdf::layered::description::DescriptionError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// What the artist calls it.
    pub name: Option<String>,
    /// The model that was asked for; [`Description::stack`] takes the default where there is none.
    pub model: Option<Model>,
    /// The rule of widths that was asked for; [`Description::stack`] takes the model's where there is none.
    pub widths: Option<Widths>,
    layers: Vec<Described>,
    /// The length of every list, and the first of them.
    lists: Option<(usize, Place)>,
}

impl Description {
    /// Reads a stack file.
    ///
    /// # Errors
    ///
    /// The first thing that is not TOML or not understood, or else the topmost number that is out of range.
    pub fn from_toml(text: &str) -> Result<Self, DescriptionError> {
        Self::from_node(&Node::from_toml(text)?)
    }

    /// Reads the tree of a stack file, whatever language it was written in.
    ///
    /// # Errors
    ///
    /// The first thing that is not understood, or else the topmost number that is out of range.
    pub fn from_node(node: &Node) -> Result<Self, DescriptionError> {
        let root = Entry { node, place: Place { path: String::new(), line: node.line } };
        let root = root.table(&["name", "model", "widths", "layer"], "a table with the key `layer`")?;
        let name = root.get("name").map(|name| name.text()).transpose()?.map(ToOwned::to_owned);
        let model = root.get("model").map(|entry| model(&entry)).transpose()?;
        let widths = root.get("widths").map(|entry| widths(&entry)).transpose()?;
        let layer = root.get("layer");
        let items = match &layer {
            Some(layer) => layer.items("a list of tables, in TOML each under [[layer]]")?,
            None => Vec::new(),
        };
        let layers = items.iter().map(described).collect::<Result<Vec<_>, _>>()?;
        let description = Description { name, model, widths, lists: lists(&layers)?, layers };

        // One channel at a time, as their number is only known now.
        let channels = (0..description.channels()).filter_map(|c| description.build::<f64, 1>(|_| c).err());
        match channels.min_by_key(|error| error.layer) {
            Some(error) if error.layer.is_none() => {
                Err(root.place.key("layer", layer.and_then(|layer| layer.place.line)).error(error.problem.to_string()))
            }
            Some(error) => Err(description.refusal::<f64>(&error)),
            None => match description.layers.last().and_then(Described::buried) {
                Some(buried) => Err(buried),
                None => Ok(description),
            },
        }
    }

    /// The number of channels: the length of the lists, 3 with a metal, 1 where there are only scalars.
    pub fn channels(&self) -> usize {
        self.lists.as_ref().map_or(1, |(length, _)| *length)
    }

    /// The stack, with scalars spread over all `C` channels.
    ///
    /// # Errors
    ///
    /// The lists do not have `C` numbers, or a number is out of range once it is rounded to `R`.
    pub fn stack<R: Real, const C: usize>(&self) -> Result<Stack<R, C>, DescriptionError> {
        match &self.lists {
            Some((length, place)) if *length != C => {
                Err(place.error(format!("this gives the stack {}, {C} asked for", plural(*length))))
            }
            _ => self.build(|c| c).map_err(|error| self.refusal::<R>(&error)),
        }
    }

    fn build<R: Real, const C: usize>(
        &self,
        channel: impl Fn(usize) -> usize + Copy,
    ) -> Result<Stack<R, C>, StackError> {
        let layers = self.layers.iter().map(|layer| layer.layer(channel)).collect();
        let stack = Stack::new(self.model.unwrap_or_default(), layers)?;
        Ok(match self.widths {
            Some(widths) => stack.with_widths(widths),
            None => stack,
        })
    }

    /// The same error, where it was written.
    fn refusal<R: Real>(&self, error: &StackError) -> DescriptionError {
        let Some((index, layer)) = error.layer.and_then(|i| Some((i, self.layers.get(i)?))) else {
            return DescriptionError { line: None, key: error.key.to_owned(), problem: error.problem.to_string() };
        };
        let written = layer.quantity(error.key);
        if let (Some(written), Problem::OutOfRange { value, allowed }) = (written, &error.problem) {
            let rounded = |v: &f64| R::from_f64(*v).to_f64();
            let is_it = |v: &f64| rounded(v) == *value || (v.is_nan() && value.is_nan());
            let at = written.values.iter().position(is_it).unwrap_or(0);
            let original = written.values.get(at).copied().unwrap_or(*value);
            let and = if value.is_finite() { "" } else { "finite and " };
            let problem = if original == *value || value.is_nan() {
                format!("{} is not allowed, it must be {and}{allowed}", short(*value))
            } else {
                let number = core::any::type_name::<R>();
                format!("{} is {} in {number}, it must be {and}{allowed}", short(original), short(*value))
            };
            return written.place_of(at).error(problem);
        }
        let place = match (&layer.boundary, written) {
            (_, Some(written)) => written.place.clone(),
            (Boundary::Diffuse { place, .. }, None) => place.clone(),
            _ => Place { path: format!("layer[{index}].{}", error.key), line: layer.place.line },
        };
        place.error(error.problem.to_string())
    }
}

/// A number without hundreds of digits.
fn short(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || !size.is_finite() || (1e-6..1e16).contains(&size) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

fn plural(channels: usize) -> String {
    if channels == 1 { "1 channel".to_owned() } else { format!("{channels} channels") }
}

fn model(entry: &Entry<'_>) -> Result<Model, DescriptionError> {
    let name = entry.text()?;
    let names = Model::ALL.iter().map(|model| model.name());
    let unknown = || entry.place.error(format!("unknown model {name:?}, {}", suggestion(name, names)));
    Model::from_name(name).ok_or_else(unknown)
}

fn widths(entry: &Entry<'_>) -> Result<Widths, DescriptionError> {
    let name = entry.text()?;
    let names = Widths::ALL.iter().map(|rule| rule.name());
    let unknown = || entry.place.error(format!("unknown rule {name:?}, {}", suggestion(name, names)));
    Widths::from_name(name).ok_or_else(unknown)
}

fn described(entry: &Entry<'_>) -> Result<Described, DescriptionError> {
    let layer = entry.table(&["interface", "medium"], "a table with the key `interface`")?;
    let boundary = boundary(&layer.require("interface", INTERFACE)?)?;
    let (sigma, thickness) = match layer.get("medium") {
        Some(medium) => {
            let medium = medium.table(&["sigma", "thickness"], "a table such as { sigma = 1.0, thickness = 0.5 }")?;
            let sigma = Quantity::read(&medium.require("sigma", CHANNELS)?)?;
            (sigma, Quantity::read_scalar(&medium.require("thickness", "a number")?)?)
        }
        None => (Quantity::zero(&layer.place), Quantity::zero(&layer.place)),
    };
    let medium = layer.get("medium").map(|medium| medium.place);
    Ok(Described { boundary, sigma, thickness, medium, place: layer.place })
}

const INTERFACE: &str = "a table such as { dielectric = { n = 1.5 }, alpha = 0.1 }";

fn boundary(entry: &Entry<'_>) -> Result<Boundary, DescriptionError> {
    let interface = entry.table(&["dielectric", "conductor", "diffuse", "alpha"], INTERFACE)?;
    let mut kinds = interface.entries.iter().filter(|(key, _)| key != "alpha");
    let Some((name, node)) = kinds.next() else {
        return Err(interface.place.error("missing one of `dielectric`, `conductor`, `diffuse`"));
    };
    let kind = Entry { node, place: interface.place.key(name, node.line) };
    if let Some((key, node)) = kinds.next() {
        let problem = format!("an interface is of one kind, and {} is given already", kind.place);
        return Err(interface.place.key(key, node.line).error(problem));
    }
    let kind_is = |kind: &str| name == kind;
    if kind_is("diffuse") {
        if let Some(alpha) = interface.get("alpha") {
            return Err(alpha.place.error("a diffuse base has no microfacet width; its roughness is `diffuse.sigma`"));
        }
        return diffuse(&kind);
    }
    let (n, k) = if kind_is("dielectric") { dielectric(&kind)? } else { conductor(&kind)? };
    let alpha =
        interface.require("alpha", "a number, the width of the microfacets, beside `dielectric` or `conductor`")?;
    Ok(Boundary::Microfacet { n, k, alpha: Quantity::read_scalar(&alpha)? })
}

fn dielectric(entry: &Entry<'_>) -> Result<(Quantity, Quantity), DescriptionError> {
    let table = entry.table(&["n"], "a table such as { n = 1.5 }")?;
    Ok((Quantity::read(&table.require("n", CHANNELS)?)?, Quantity::zero(&table.place)))
}

fn conductor(entry: &Entry<'_>) -> Result<(Quantity, Quantity), DescriptionError> {
    let table = entry.table(&["metal", "n", "k"], "a table such as { metal = \"copper\" }")?;
    let Some(metal) = table.get("metal") else {
        if table.entries.is_empty() {
            return Err(table.place.error("missing either `metal` or `n` and `k`"));
        }
        let read = |key| Quantity::read(&table.require(key, CHANNELS)?);
        return Ok((read("n")?, read("k")?));
    };
    if let Some(index) = table.get("n").or_else(|| table.get("k")) {
        return Err(index.place.error(format!("give either this or the metal, and {} is given", metal.place)));
    }
    let name = metal.text()?;
    let Some(known) = metal::by_name(name) else {
        let names = metal::METALS.iter().map(|metal| metal.name);
        return Err(metal.place.error(format!("unknown metal {name:?}, {}", suggestion(name, names))));
    };
    let index = |values: [f64; 3]| Quantity {
        values: values.to_vec(),
        lines: Some(vec![metal.place.line; 3]),
        place: metal.place.clone(),
    };
    Ok((index(known.n), index(known.k)))
}

fn diffuse(entry: &Entry<'_>) -> Result<Boundary, DescriptionError> {
    let table = entry.table(&["albedo", "sigma"], "a table such as { albedo = 0.5, sigma = 0.3 }")?;
    let albedo = Quantity::read(&table.require("albedo", CHANNELS)?)?;
    let sigma = match table.get("sigma") {
        Some(sigma) => Quantity::read_scalar(&sigma)?,
        None => Quantity::zero(&table.place),
    };
    Ok(Boundary::Diffuse { albedo, sigma, place: table.place })
}

/// The length that all lists have, and the first of them.
fn lists(layers: &[Described]) -> Result<Option<(usize, Place)>, DescriptionError> {
    let mut lists = layers.iter().flat_map(Described::quantities).filter(|quantity| quantity.lines.is_some());
    let Some(first) = lists.next() else { return Ok(None) };
    let length = first.values.len();
    match lists.find(|list| list.values.len() != length) {
        Some(other) => {
            let problem = format!("{}, but {} has {}", plural(other.values.len()), first.place, plural(length));
            Err(other.place.error(problem))
        }
        None => Ok(Some((length, first.place.clone()))),
    }
}
