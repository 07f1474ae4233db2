//! Parts of material files: layers, brushed metals, whole stacks, and the relief of each.

use super::{DescriptionError, FINITE, NOT_NEGATIVE, POSITIVE, Reader, SHARE, whole, within};
use crate::layered::description::Description;
use crate::layered::description::tree::{Entry, Table, suggestion};
use crate::layered::{ALPHA_RANGE, K_RANGE, Model, N_RANGE, Widths};
use crate::material::field::{Colour, Scalar};
use crate::material::finish::{
    Body, Boundary, BrushedMetal, Coat, Encoding, Finish, Flakes, Layers, Relief, STEP_RANGE, STRENGTH_RANGE,
};
use crate::material::{glint, metal};
use crate::texture::image::Filter;
use alloc::boxed::Box;
use alloc::format;
use alloc::vec::Vec;

/// The keys of a part.
pub(super) const PART: &[&str] =
    &["cover", "reflectivity", "relief", "layer", "brushed", "stack", "model", "widths", "returns", "scatter"];
/// Those that only layers have.
const OF_LAYERS: [&str; 4] = ["model", "widths", "returns", "scatter"];

const FIELD: &str = "a number or a field";
const INTERFACE: &str = "a table such as { dielectric = { n = 1.5 }, alpha = 0.1 }";

impl Reader<'_> {
    /// What a part is made of.
    pub(super) fn finish(&mut self, part: &Table<'_>) -> Result<Finish, DescriptionError> {
        let kinds: Vec<_> = ["layer", "brushed", "stack"].iter().filter_map(|key| part.get(key)).collect();
        let kind = match kinds.as_slice() {
            [kind] => kind,
            [] => return Err(part.place.error("missing one of `layer`, `brushed`, `stack`")),
            [first, second, ..] => {
                let problem = format!("a part is of one kind, and {} is given already", first.place);
                return Err(second.place.error(problem));
            }
        };
        let body = if part.get("layer").is_some() {
            Body::Layers(self.layers(part, kind)?)
        } else if let Some(stray) = OF_LAYERS.iter().find_map(|key| part.get(key)) {
            return Err(stray.place.error(format!("belongs to a part with `layer`, and {} is given", kind.place)));
        } else if part.get("brushed").is_some() {
            Body::Brushed(Box::new(self.brushed(kind)?))
        } else {
            Body::Whole(Box::new(stack(kind)?))
        };
        let reflectivity = match part.get("reflectivity") {
            Some(entry) => self.colour(&entry, &SHARE)?,
            None => Colour::Constant([1.0; 3]),
        };
        let relief = part.get("relief").map(|entry| self.relief(&entry)).transpose()?;
        Ok(Finish { body, relief, reflectivity })
    }

    fn layers(&mut self, part: &Table<'_>, list: &Entry<'_>) -> Result<Layers, DescriptionError> {
        let model = part.get("model").map_or(Ok(Model::Conserving), |entry| model(&entry))?;
        let widths = part.get("widths").map_or(Ok(model.widths()), |entry| widths(&entry))?;
        let returns = part.get("returns").map_or(Ok(false), |entry| entry.flag())?;
        let scatter = part.get("scatter").map(|entry| self.colour(&entry, &SHARE)).transpose()?;
        let items = list.items("a list of tables from the top, in TOML each under [[part.layer]]")?;
        let coats = items.iter().map(|item| self.coat(item)).collect::<Result<_, _>>()?;
        Ok(Layers { model, widths, coats, returns, scatter })
    }

    fn coat(&mut self, entry: &Entry<'_>) -> Result<Coat, DescriptionError> {
        let layer = entry.table(&["interface", "medium", "flakes"], "a table with the key `interface`")?;
        let mut coat = Coat::new(self.boundary(&layer.require("interface", INTERFACE)?)?);
        if let Some(medium) = layer.get("medium") {
            let medium = medium.table(&["sigma", "thickness"], "a table such as { sigma = 1.0, thickness = 0.5 }")?;
            coat.sigma = self.colour(&medium.require("sigma", FIELD)?, &NOT_NEGATIVE)?;
            coat.thickness = self.scalar(&medium.require("thickness", FIELD)?, &NOT_NEGATIVE)?;
        }
        coat.flakes = layer.get("flakes").map(|entry| self.flakes(&entry)).transpose()?;
        Ok(coat)
    }

    fn boundary(&mut self, entry: &Entry<'_>) -> Result<Boundary, DescriptionError> {
        let interface = entry.table(&["dielectric", "conductor", "diffuse", "alpha"], INTERFACE)?;
        let kinds: Vec<_> =
            ["dielectric", "conductor", "diffuse"].iter().filter_map(|key| interface.get(key)).collect();
        let kind = match kinds.as_slice() {
            [kind] => kind,
            [] => return Err(interface.place.error("missing one of `dielectric`, `conductor`, `diffuse`")),
            [first, second, ..] => {
                let problem = format!("an interface is of one kind, and {} is given already", first.place);
                return Err(second.place.error(problem));
            }
        };
        if interface.get("diffuse").is_some() {
            if let Some(alpha) = interface.get("alpha") {
                let problem = "a diffuse base has no microfacet width; its roughness is `diffuse.sigma`";
                return Err(alpha.place.error(problem));
            }
            let table = kind.table(&["albedo", "sigma"], "a table such as { albedo = 0.5, sigma = 0.3 }")?;
            let albedo = self.colour(&table.require("albedo", FIELD)?, &SHARE)?;
            let steepest = 0.0..=core::f64::consts::FRAC_PI_2;
            let sigma = table.get("sigma").map_or(Ok(Scalar::Constant(0.0)), |entry| self.scalar(&entry, &steepest))?;
            return Ok(Boundary::Diffuse { albedo, sigma });
        }
        let (n, k) = if interface.get("dielectric").is_some() {
            let table = kind.table(&["n"], "a table such as { n = 1.5 }")?;
            (self.colour(&table.require("n", FIELD)?, &N_RANGE)?, Colour::Constant([0.0; 3]))
        } else {
            self.index(&kind.table(&["metal", "n", "k"], "a table such as { metal = \"copper\" }")?)?
        };
        let what = "a number or a field, the width of the microfacets, beside `dielectric` or `conductor`";
        Ok(Boundary::Microfacet { n, k, alpha: self.scalar(&interface.require("alpha", what)?, &ALPHA_RANGE)? })
    }

    /// The index of a metal, by its name or by n and k.
    fn index(&mut self, table: &Table<'_>) -> Result<(Colour, Colour), DescriptionError> {
        let Some(metal) = table.get("metal") else {
            if table.get("n").or_else(|| table.get("k")).is_none() {
                return Err(table.place.error("missing either `metal` or `n` and `k`"));
            }
            let n = self.colour(&table.require("n", FIELD)?, &N_RANGE)?;
            return Ok((n, self.colour(&table.require("k", FIELD)?, &K_RANGE)?));
        };
        if let Some(index) = table.get("n").or_else(|| table.get("k")) {
            return Err(index.place.error(format!("give either this or the metal, and {} is given", metal.place)));
        }
        let name = metal.text()?;
        let Some(known) = metal::by_name(name) else {
            let names = metal::METALS.iter().map(|metal| metal.name);
            return Err(metal.place.error(format!("unknown metal {name:?}, {}", suggestion(name, names))));
        };
        Ok((Colour::Constant(known.n), Colour::Constant(known.k)))
    }

    fn flakes(&mut self, entry: &Entry<'_>) -> Result<Flakes, DescriptionError> {
        let what = "a table such as { spacing = 0.002, resolution = 4 } or { normals = { image = \"flakes.png\" } }";
        let table = entry.table(&["spacing", "resolution", "seed", "normals"], what)?;
        let Some(normals) = table.get("normals") else {
            return Ok(Flakes::Glints {
                spacing: within(&table.require("spacing", "a length, the side of a flake's own square")?, &POSITIVE)?,
                resolution: whole(&table.require("resolution", "a whole number")?, 1..=glint::FINEST)?,
                seed: table.get("seed").map_or(Ok(0), |entry| whole(&entry, 0..=u32::MAX))?,
            });
        };
        if let Some(other) = ["spacing", "resolution", "seed"].iter().find_map(|key| table.get(key)) {
            let problem = format!("give either this or a map of normals, and {} is given", normals.place);
            return Err(other.place.error(problem));
        }
        // The documents look flakes up without filtering: a mean of normals is no flake's.
        Ok(Flakes::AsPrinted { normals: self.normals(&normals, Filter::Nearest)? })
    }

    fn relief(&mut self, entry: &Entry<'_>) -> Result<Relief, DescriptionError> {
        let what = "a table such as { height = { noise = { frequency = 8.0, amplitude = 0.01 } }, step = 0.004 } or \
                    { normals = { image = \"normals.png\" } }";
        let table = entry.table(&["height", "step", "normals", "encoding", "strength"], what)?;
        let (keys, of) = match (table.get("height"), table.get("normals")) {
            (Some(height), None) => (["encoding", "strength"], height),
            (None, Some(normals)) => (["step", "step"], normals),
            (Some(height), Some(normals)) => {
                let problem = format!("a relief is of one kind, and {} is given already", height.place);
                return Err(normals.place.error(problem));
            }
            (None, None) => return Err(table.place.error(format!("missing `height` or `normals`, expected {what}"))),
        };
        if let Some(stray) = keys.iter().find_map(|key| table.get(key)) {
            return Err(stray.place.error(format!("does not belong to a relief of this kind, {}", of.place)));
        }
        if table.get("height").is_some() {
            let step = table.require("step", "a length, over which slopes are taken")?;
            return Ok(Relief::Height { height: self.scalar(&of, &FINITE)?, step: within(&step, &STEP_RANGE)? });
        }
        let encoding = match table.get("encoding") {
            Some(entry) => encoding(&entry)?,
            None => Encoding::Rgb,
        };
        let strength = table.get("strength").map_or(Ok(1.0), |entry| within(&entry, &STRENGTH_RANGE))?;
        Ok(Relief::Map { normals: self.normals(&of, Filter::Bilinear)?, encoding, strength })
    }

    fn brushed(&mut self, entry: &Entry<'_>) -> Result<BrushedMetal, DescriptionError> {
        let what = "a table such as { metal = \"chromium\", along = 0.05, across = 0.3 }";
        let table = entry.table(&["metal", "n", "k", "along", "across", "turn"], what)?;
        let (n, k) = self.index(&table)?;
        let mut width = |key| self.scalar(&table.require(key, "the width along or across the grooves")?, &ALPHA_RANGE);
        let (along, across) = (width("along")?, width("across")?);
        let turn = table.get("turn").map_or(Ok(Scalar::Constant(0.0)), |entry| self.scalar(&entry, &FINITE))?;
        Ok(BrushedMetal { n, k, along, across, turn })
    }
}

fn encoding(entry: &Entry<'_>) -> Result<Encoding, DescriptionError> {
    match entry.text()? {
        "rgb" => Ok(Encoding::Rgb),
        "alpha_green" => Ok(Encoding::AlphaGreen),
        other => {
            let allowed = suggestion(other, ["rgb", "alpha_green"].into_iter());
            Err(entry.place.error(format!("unknown encoding {other:?}, {allowed}")))
        }
    }
}

fn model(entry: &Entry<'_>) -> Result<Model, DescriptionError> {
    let name = entry.text()?;
    let names = Model::CLOSED_FORM.iter().map(|model| model.name());
    match Model::from_name(name) {
        Some(model) if Model::CLOSED_FORM.contains(&model) => Ok(model),
        Some(_) => {
            let problem = format!("layers that vary take no model {name:?}, a part with `stack` does; ");
            Err(entry.place.error(problem + &suggestion(name, names)))
        }
        None => Err(entry.place.error(format!("unknown model {name:?}, {}", suggestion(name, names)))),
    }
}

fn widths(entry: &Entry<'_>) -> Result<Widths, DescriptionError> {
    let name = entry.text()?;
    let names = Widths::ALL.iter().map(|rule| rule.name());
    let unknown = || entry.place.error(format!("unknown rule {name:?}, {}", suggestion(name, names)));
    Widths::from_name(name).ok_or_else(unknown)
}

/// A stack file's tree within a part.
fn stack(entry: &Entry<'_>) -> Result<crate::layered::Stack<f64, 3>, DescriptionError> {
    let described = Description::from_node(entry.node).and_then(|description| {
        // A description of one channel holds for three.
        description.stack::<f64, 3>()
    });
    described.map_err(|error| {
        let separator = if error.key.is_empty() { "" } else { "." };
        let key = format!("{}{separator}{}", entry.place.path, error.key);
        DescriptionError { line: error.line.or(entry.place.line), key, ..error }
    })
}
