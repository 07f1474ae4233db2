//! Material files: a material as an artist writes it down, in TOML or as the same tree in JSON.
//!
//! The grammar stands in the documentation of [`material`](super). Whatever is not understood is refused in one line, with the line of the
//! file, the key and what is allowed there; so are constants outside the range of what they stand for. Fields that vary are clamped to
//! it point by point.
//!
//! Images are loaded by the caller, from beside the file or from anywhere: [`read_file`] asks for each by its name and says how its
//! bytes are to be understood.

mod fields;
mod finishes;

use super::built_in;
use super::parts::{Material, Part};
use super::{MaterialError, Scalar};
use crate::layered::description::tree::{DEEPEST, Entry, Place, Table, suggestion};
pub use crate::layered::description::{DescriptionError, Node, Value};
use crate::texture::image::{self, Filter, Image};
use alloc::borrow::ToOwned;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use core::ops::RangeInclusive;

/// A material as it was written down, checked.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialFile {
    /// What the artist calls it; where absent, the name of the built-in material that it is.
    pub name: Option<String>,
    /// The material.
    pub material: Material,
}

/// An image that a material file names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageRequest<'a> {
    /// The file, as written.
    pub file: &'a str,
    /// What its bytes stand for: colours are sRGB unless the file says `srgb = false`, everything else is linear. Of no meaning where
    /// the image holds numbers and not bytes.
    pub encoding: image::Encoding,
}

/// Reads a material file. `load` is asked once for each image in each encoding, and once more where it is looked up both filtered, as
/// colours, numbers and normals are, and not, as the normals of flakes are.
///
/// ```
/// use brdf::material::description::read_file;
///
/// let file = r#"
/// name = "spotted"
/// [[part]]
/// layer = [{ interface = { conductor = { metal = "iron" }, alpha = 0.2 } }]
/// [[part]]
/// cover = { above = 0.5, softness = 0.1, of = "occlusion" }
/// layer = [{ interface = { diffuse = { albedo = [0.4, 0.1, 0.04], sigma = 0.5 } } }]
/// "#;
/// let no_images = |image: brdf::material::description::ImageRequest| Err(format!("there is no {}", image.file));
/// let read = read_file(file, no_images)?;
/// assert_eq!(read.material.parts().len(), 2);
///
/// let error = read_file(&file.replace("0.2", "2"), no_images).unwrap_err();
/// let line = "line 4, part[0].layer[0].interface.alpha: 2 is not allowed, it must be in [0.0001, 1]";
/// assert_eq!(error.to_string(), line);
/// # Ok::<(), brdf::material::description::DescriptionError>(())
/// ```
///
/// # Errors
///
/// The first thing that is not TOML, not understood or out of range, and what `load` says of an image.
pub fn read_file(
    text: &str,
    load: impl FnMut(ImageRequest<'_>) -> Result<Image, String>,
) -> Result<MaterialFile, DescriptionError> {
    read_node(&Node::from_toml(text)?, load)
}

/// Reads the tree of a material file, whatever language it was written in.
///
/// # Errors
/// As [`read_file`].
pub fn read_node(
    node: &Node,
    mut load: impl FnMut(ImageRequest<'_>) -> Result<Image, String>,
) -> Result<MaterialFile, DescriptionError> {
    Reader { load: &mut load, images: Vec::new(), depth: 0 }.file(node)
}

/// What loads an image.
type Load<'a> = dyn FnMut(ImageRequest<'_>) -> Result<Image, String> + 'a;

/// What is known while a file is read.
struct Reader<'a> {
    load: &'a mut Load<'a>,
    images: Vec<(String, image::Encoding, Filter, Image)>,
    /// How many fields the one that is read lies in.
    depth: usize,
}

impl Reader<'_> {
    fn file(mut self, node: &Node) -> Result<MaterialFile, DescriptionError> {
        let root = Entry { node, place: Place { path: String::new(), line: node.line } };
        let keys = "a table with the key `part`, or `material` for a built-in one";
        let root = root.table(&["name", "material", "parameters", "part"], keys)?;
        let name = root.get("name").map(|name| name.text()).transpose()?.map(ToOwned::to_owned);
        let Some(built_in) = root.get("material") else {
            if let Some(parameters) = root.get("parameters") {
                return Err(parameters.place.error("belongs to a built-in material: name one by `material = \"…\"`"));
            }
            let material = self.parts(&root)?;
            return Ok(MaterialFile { name, material });
        };
        if let Some(part) = root.get("part") {
            let problem = format!("a material is built-in or made of parts, and {} is given", built_in.place);
            return Err(part.place.error(problem));
        }
        let material = changed(&built_in, root.get("parameters").as_ref())?;
        Ok(MaterialFile { name: name.or(Some(built_in.text()?.to_owned())), material })
    }

    /// A material of parts.
    fn parts(&mut self, root: &Table<'_>) -> Result<Material, DescriptionError> {
        let entry = root.require("part", "a list of tables, in TOML each under [[part]], the ground first")?;
        let items = entry.items("a list of tables, in TOML each under [[part]]")?;
        let parts =
            items.iter().enumerate().map(|(index, item)| self.part(index, item)).collect::<Result<Vec<_>, _>>()?;
        let images = core::mem::take(&mut self.images).into_iter().map(|(.., image)| image).collect();
        Material::new(parts, images).map_err(|error| misplaced(&error, &entry.place, &items))
    }

    fn part(&mut self, index: usize, entry: &Entry<'_>) -> Result<Part, DescriptionError> {
        let part = entry.table(finishes::PART, "a table with one of the keys `layer`, `brushed`, `stack`")?;
        let cover = match part.get("cover") {
            Some(cover) if index == 0 => {
                return Err(cover.place.error("the first part is the ground and covers nothing: leave it out"));
            }
            Some(cover) => self.scalar(&cover, &(0.0..=1.0))?,
            None => Scalar::Constant(1.0),
        };
        Ok(Part { cover, finish: self.finish(&part)? })
    }

    /// The index of an image, which is loaded unless it was.
    fn image(
        &mut self,
        entry: &Entry<'_>,
        encoding: image::Encoding,
        filter: Filter,
    ) -> Result<usize, DescriptionError> {
        let file = entry.text()?;
        let known = self
            .images
            .iter()
            .position(|(name, as_is, filtered, _)| name == file && *as_is == encoding && *filtered == filter);
        if let Some(index) = known {
            return Ok(index);
        }
        if file.is_empty() {
            return Err(entry.place.error("found an empty name, expected that of an image file"));
        }
        let image = (self.load)(ImageRequest { file, encoding }).map_err(|problem| {
            // A decoder may speak in several lines.
            entry.place.error(format!("{file:?} cannot be used: {}", problem.trim().replace(['\n', '\r'], ", ")))
        })?;
        self.images.push((file.to_owned(), encoding, filter, image.with_filter(filter)));
        Ok(self.images.len() - 1)
    }

    /// One level deeper; files nest as deep as [`DEEPEST`], trees from elsewhere may not either.
    fn nested<T>(
        &mut self,
        entry: &Entry<'_>,
        read: impl FnOnce(&mut Self) -> Result<T, DescriptionError>,
    ) -> Result<T, DescriptionError> {
        if self.depth >= DEEPEST {
            return Err(entry.place.error(format!("fields within more than {DEEPEST} others: write a simpler one")));
        }
        self.depth += 1;
        let result = read(self);
        self.depth -= 1;
        result
    }
}

/// A built-in material with numbers changed.
fn changed(entry: &Entry<'_>, parameters: Option<&Entry<'_>>) -> Result<Material, DescriptionError> {
    let name = entry.text()?;
    let Some(mut material) = built_in::by_name(name) else {
        let names: Vec<_> = built_in::all().iter().map(|material| material.name).collect();
        let problem = format!("unknown material {name:?}, {}", suggestion(name, names.into_iter()));
        return Err(entry.place.error(problem));
    };
    if let Some(parameters) = parameters {
        let Value::Table(entries) = &parameters.node.value else {
            return Err(parameters.expected("a table of numbers"));
        };
        for (key, node) in entries {
            let number = Entry { node, place: parameters.place.key(key, node.line) };
            let value = number.number()?;
            material.set(key, value).map_err(|error| number.place.error(error.to_string()))?;
        }
    }
    material.material().map_err(|error| entry.place.error(error.to_string()))
}

/// An error of [`Material::new`] where it was written.
fn misplaced(error: &MaterialError, list: &Place, parts: &[Entry<'_>]) -> DescriptionError {
    let Some(part) = parts.get(error.part) else { return list.error(error.problem.clone()) };
    let (mut node, mut place) = (Some(part.node), part.place.clone());
    if let Some(layer) = error.layer {
        let layers = node.and_then(|node| under(node, "layer"));
        let item = match layers.map(|layers| &layers.value) {
            Some(Value::List(items)) => items.get(layer),
            _ => None,
        };
        let line = item.and_then(|item| item.line);
        (node, place) = (item, place.key("layer", line).item(layer, line));
    }
    if let Some(key) = error.key {
        let written = node.and_then(|node| under(node, key));
        place = place.key(key, written.and_then(|node| node.line).or(place.line));
    }
    place.error(error.problem.clone())
}

/// What a table has under a key.
fn under<'a>(node: &'a Node, wanted: &str) -> Option<&'a Node> {
    match &node.value {
        Value::Table(entries) => entries.iter().find(|(key, _)| key == wanted).map(|(_, node)| node),
        _ => None,
    }
}

/// A number in a range.
fn within(entry: &Entry<'_>, range: &RangeInclusive<f64>) -> Result<f64, DescriptionError> {
    let number = entry.number()?;
    if range.contains(&number) { Ok(number) } else { Err(outside(&entry.place, number, range)) }
}

/// A whole number in a range.
fn whole(entry: &Entry<'_>, range: RangeInclusive<u32>) -> Result<u32, DescriptionError> {
    let number = entry.number()?;
    let word = number as u32;
    if f64::from(word) == number && range.contains(&word) {
        return Ok(word);
    }
    let (low, high) = (range.start(), range.end());
    Err(entry.place.error(format!("{number} is not allowed, it must be a whole number in [{low}, {high}]")))
}

/// What is said of a number that is not in a range.
fn outside(place: &Place, number: f64, range: &RangeInclusive<f64>) -> DescriptionError {
    let short = |x: f64| if x != 0.0 && !(1e-6..1e16).contains(&x.abs()) { format!("{x:e}") } else { format!("{x}") };
    let [number, low, high] = [number, *range.start(), *range.end()].map(short);
    place.error(format!("{number} is not allowed, it must be in [{low}, {high}]"))
}

/// The largest number of a file: squares of it are still numbers in f64, and it is one in f32.
const LARGEST: f64 = 1e30;
/// Every number that a file may have.
const FINITE: RangeInclusive<f64> = -LARGEST..=LARGEST;
/// Those that are not negative.
const NOT_NEGATIVE: RangeInclusive<f64> = 0.0..=LARGEST;
/// Those that are above 0.
const POSITIVE: RangeInclusive<f64> = 1e-30..=LARGEST;
/// Shares and reflectances.
const SHARE: RangeInclusive<f64> = 0.0..=1.0;
