//! Fields of material files: numbers and colours that vary over a surface.

use super::{DescriptionError, FINITE, NOT_NEGATIVE, Reader, whole, within};
use crate::layered::description::Value;
use crate::layered::description::tree::{Entry, Table, suggestion};
use crate::material::field::{Colour, FREQUENCY_RANGE, Lookup, Noise, Property, Scalar, Scratches};
use crate::texture::image::{Encoding, Filter};
use crate::texture::ramp::{Ramp, RampError, Stop};
use alloc::boxed::Box;
use alloc::format;
use alloc::string::ToString;
use alloc::vec::Vec;
use core::ops::RangeInclusive;

const SCALAR: &str = "a number, a property such as \"occlusion\", or a table such as { noise = { frequency = 2.0 } }";
const COLOUR: &str =
    "a number, a list of three numbers, or a table such as { ramp = [[0, 0, 0], [1, 1, 1]], by = \"v\" }";
const CELLS: &str = "a number of cells in a unit of length, or three";
/// A shader unrolls a sum.
const MOST_TERMS: usize = 16;
/// A shader holds the stops of a ramp in an array.
const MOST_STOPS: usize = 64;

/// The keys that say what a number is, each with all the keys of its table; `of` alone scales.
const SCALARS: [(&str, &[&str]); 11] = [
    ("noise", &["noise"]),
    ("ridged", &["ridged"]),
    ("scratches", &["scratches"]),
    ("image", &["image", "channel", "repeat"]),
    ("sum", &["sum"]),
    ("product", &["product"]),
    ("mix", &["mix", "by"]),
    ("levels", &["levels", "of"]),
    ("above", &["above", "softness", "of"]),
    ("extent", &["extent", "transition", "of"]),
    ("of", &["of", "scale", "offset"]),
];

/// The keys that say what a colour is, each with all the keys of its table.
const COLOURS: [(&str, &[&str]); 7] = [
    ("grey", &["grey"]),
    ("ramp", &["ramp", "at", "by"]),
    ("bands", &["bands", "at", "softness", "by"]),
    ("image", &["image", "srgb", "repeat"]),
    ("colour", &["colour", "scale"]),
    ("mix", &["mix", "by"]),
    ("film", &["film"]),
];

/// The table at an entry by the first of the kinds that it has the key of.
fn kind<'a>(
    entry: &Entry<'a>,
    kinds: &'static [(&'static str, &'static [&'static str])],
    what: &str,
) -> Result<(&'static str, Table<'a>), DescriptionError> {
    let Value::Table(entries) = &entry.node.value else { return Err(entry.expected(what)) };
    let found = kinds.iter().find(|(name, _)| entries.iter().any(|(key, _)| key == name));
    let names = kinds.iter().map(|(name, _)| *name);
    match (found, entries.first()) {
        (Some((name, keys)), _) => Ok((name, entry.table(keys, what)?)),
        (None, Some((key, node))) => {
            let place = entry.place.key(key, node.line);
            Err(place.error(format!("unknown key, {}", suggestion(key, names))))
        }
        (None, None) => Err(entry.place.error(format!("found an empty table, expected {what}"))),
    }
}

impl Reader<'_> {
    /// A number that may vary; where it does not it must lie in a range.
    pub(super) fn scalar(
        &mut self,
        entry: &Entry<'_>,
        range: &RangeInclusive<f64>,
    ) -> Result<Scalar, DescriptionError> {
        match &entry.node.value {
            Value::Number(_) => Ok(Scalar::Constant(within(entry, range)?)),
            Value::Text(name) => {
                let names = Property::ALL.iter().map(|(name, _)| *name);
                let found = Property::ALL.iter().find(|(known, _)| known == name);
                let unknown = || entry.place.error(format!("unknown property {name:?}, {}", suggestion(name, names)));
                found.map(|(_, property)| Scalar::Of(*property)).ok_or_else(unknown)
            }
            _ => self.nested(entry, |reader| reader.varying(entry)),
        }
    }

    fn varying(&mut self, entry: &Entry<'_>) -> Result<Scalar, DescriptionError> {
        let (name, table) = kind(entry, &SCALARS, SCALAR)?;
        let own = table.require(name, SCALAR)?;
        let optional = |key: &str, default: f64, range: &RangeInclusive<f64>| {
            table.get(key).map_or(Ok(default), |entry| within(&entry, range))
        };
        let of = |reader: &mut Self| reader.scalar(&table.require("of", SCALAR)?, &FINITE).map(Box::new);
        Ok(match name {
            "noise" => Scalar::Fractal(noise(&own)?),
            "ridged" => Scalar::Ridged(noise(&own)?),
            "scratches" => Scalar::Scratches(scratches(&own)?),
            "image" => {
                let image = self.image(&own, Encoding::Linear, Filter::Bilinear)?;
                let channel = table.get("channel").map_or(Ok(0), |entry| channel(&entry))?;
                Scalar::Image(Lookup { image, repeat: repeat(&table)? }, channel)
            }
            "sum" => self.folded(&own, Scalar::Sum)?,
            "product" => self.folded(&own, Scalar::Product)?,
            "mix" => {
                let [a, b] = pair(&own)?;
                let (a, b) = (self.scalar(&a, &FINITE)?, self.scalar(&b, &FINITE)?);
                Scalar::mix(a, b, self.scalar(&table.require("by", SCALAR)?, &FINITE)?)
            }
            "levels" => {
                let [black, white] = pair(&own)?;
                let (black, white) = (within(&black, &FINITE)?, within(&white, &FINITE)?);
                Scalar::Levels { of: of(self)?, black, white }
            }
            "above" => {
                let (at, softness) = (within(&own, &FINITE)?, optional("softness", 0.0, &NOT_NEGATIVE)?);
                Scalar::Threshold { of: of(self)?, at, softness }
            }
            "extent" => {
                let (extent, transition) = (within(&own, &FINITE)?, optional("transition", 0.0, &NOT_NEGATIVE)?);
                Scalar::Extent { of: of(self)?, extent, transition }
            }
            _ => {
                let (factor, offset) = (optional("scale", 1.0, &FINITE)?, optional("offset", 0.0, &FINITE)?);
                Scalar::Scaled { of: of(self)?, factor, offset }
            }
        })
    }

    /// A list of numbers as one, two at a time.
    fn folded(
        &mut self,
        entry: &Entry<'_>,
        two: impl Fn(Box<Scalar>, Box<Scalar>) -> Scalar,
    ) -> Result<Scalar, DescriptionError> {
        let items = entry.items("a list of numbers and fields")?;
        if !(1..=MOST_TERMS).contains(&items.len()) {
            let problem = format!("there are {} terms, a list has 1 to {MOST_TERMS}", items.len());
            return Err(entry.place.error(problem));
        }
        let terms = items.iter().map(|item| self.scalar(item, &FINITE)).collect::<Result<Vec<_>, _>>()?;
        let folded = terms.into_iter().reduce(|sum, term| two(Box::new(sum), Box::new(term)));
        folded.ok_or_else(|| entry.place.error("there are no terms"))
    }

    /// A colour that may vary; where it does not each channel must lie in a range.
    pub(super) fn colour(
        &mut self,
        entry: &Entry<'_>,
        range: &RangeInclusive<f64>,
    ) -> Result<Colour, DescriptionError> {
        match &entry.node.value {
            Value::Number(_) | Value::List(_) => Ok(Colour::Constant(triple(entry, range)?)),
            Value::Table(_) => self.nested(entry, |reader| reader.varying_colour(entry, range)),
            _ => Err(entry.expected(COLOUR)),
        }
    }

    fn varying_colour(&mut self, entry: &Entry<'_>, range: &RangeInclusive<f64>) -> Result<Colour, DescriptionError> {
        let (name, table) = kind(entry, &COLOURS, COLOUR)?;
        let own = table.require(name, COLOUR)?;
        Ok(match name {
            "grey" => Colour::Grey(self.scalar(&own, range)?),
            "ramp" | "bands" => {
                let by = self.scalar(&table.require("by", SCALAR)?, &FINITE)?;
                let softness = table.get("softness").map_or(Ok(0.0), |entry| within(&entry, &NOT_NEGATIVE))?;
                let ramp = ramp(&own, table.get("at").as_ref(), range, name == "bands")?;
                if name == "bands" { Colour::Bands(ramp, softness, by) } else { Colour::Ramp(ramp, by) }
            }
            "image" => {
                let is_srgb = table.get("srgb").map_or(Ok(true), |entry| entry.flag())?;
                let encoding = if is_srgb { Encoding::Srgb } else { Encoding::Linear };
                let image = self.image(&own, encoding, Filter::Bilinear)?;
                Colour::Image(Lookup { image, repeat: repeat(&table)? })
            }
            "colour" => {
                let colour = self.colour(&own, &FINITE)?;
                Colour::Scaled(Box::new(colour), self.scalar(&table.require("scale", SCALAR)?, &FINITE)?)
            }
            "mix" => {
                let [a, b] = pair(&own)?;
                let (a, b) = (self.colour(&a, range)?, self.colour(&b, range)?);
                Colour::mix(a, b, self.scalar(&table.require("by", SCALAR)?, &FINITE)?)
            }
            _ => {
                let what = "a table such as { absorption = 1.0, scattering = 4.0, thickness = 0.1, ground = 0.5 }";
                let film = own.table(&["absorption", "scattering", "thickness", "ground"], what)?;
                let rate = |key| triple(&film.require(key, "a number or a list of three")?, &NOT_NEGATIVE);
                Colour::Film {
                    absorption: rate("absorption")?,
                    scattering: rate("scattering")?,
                    thickness: self.scalar(&film.require("thickness", SCALAR)?, &NOT_NEGATIVE)?,
                    ground: Box::new(self.colour(&film.require("ground", COLOUR)?, range)?),
                }
            }
        })
    }

    /// The lookup of an image that holds normals: `{ image = "file", repeat = 1000 }`.
    pub(super) fn normals(&mut self, entry: &Entry<'_>, filter: Filter) -> Result<Lookup, DescriptionError> {
        let what = "a table such as { image = \"normals.png\", repeat = 4 }";
        let table = entry.table(&["image", "repeat"], what)?;
        let image = self.image(&table.require("image", "the name of an image file")?, Encoding::Linear, filter)?;
        Ok(Lookup { image, repeat: repeat(&table)? })
    }
}

fn noise(entry: &Entry<'_>) -> Result<Noise, DescriptionError> {
    let keys = &["seed", "amplitude", "frequency", "octaves", "gain", "lacunarity"];
    let table = entry.table(keys, "a table such as { seed = 1, frequency = 2.0, octaves = 5 }")?;
    let frequency = triple(&table.require("frequency", CELLS)?, &FREQUENCY_RANGE)?;
    let number = |key, default| table.get(key).map_or(Ok(default), |entry| within(&entry, &FINITE));
    Ok(Noise {
        seed: table.get("seed").map_or(Ok(0), |entry| whole(&entry, 0..=u32::MAX))?,
        amplitude: number("amplitude", 1.0)?,
        frequency,
        octaves: table.get("octaves").map_or(Ok(1), |entry| whole(&entry, 1..=Noise::MOST_OCTAVES))?,
        gain: number("gain", 0.5)?,
        lacunarity: number("lacunarity", 2.0)?,
    })
}

fn scratches(entry: &Entry<'_>) -> Result<Scratches, DescriptionError> {
    let keys = &["seed", "frequency", "density", "width", "layers"];
    let table = entry.table(keys, "a table such as { frequency = 2.0, width = 0.01, layers = 8 }")?;
    let frequency = triple(&table.require("frequency", CELLS)?, &FREQUENCY_RANGE)?;
    let number = |key, default, range| table.get(key).map_or(Ok(default), |entry| within(&entry, range));
    let usual = Scratches::new(0, 1.0);
    Ok(Scratches {
        seed: table.get("seed").map_or(Ok(0), |entry| whole(&entry, 0..=u32::MAX))?,
        frequency,
        density: number("density", usual.density, &(0.0..=1.0))?,
        width: number("width", usual.width, &(0.0..=0.375))?,
        layers: table.get("layers").map_or(Ok(1), |entry| whole(&entry, 1..=Scratches::MOST_LAYERS))?,
    })
}

/// One number for three channels, or three.
pub(super) fn triple(entry: &Entry<'_>, range: &RangeInclusive<f64>) -> Result<[f64; 3], DescriptionError> {
    if matches!(entry.node.value, Value::Number(_)) {
        return Ok([within(entry, range)?; 3]);
    }
    let items = entry.items("a number or a list of three numbers")?;
    match items.as_slice() {
        [a, b, c] => Ok([within(a, range)?, within(b, range)?, within(c, range)?]),
        _ => Err(entry.place.error(format!("found a list of {}, expected three numbers", items.len()))),
    }
}

fn pair<'a>(entry: &Entry<'a>) -> Result<[Entry<'a>; 2], DescriptionError> {
    let items = entry.items("a list of two")?;
    let count = items.len();
    items.try_into().map_err(|_| entry.place.error(format!("found a list of {count}, expected two")))
}

/// How often an image repeats along u and v: `repeat`, a number or two; once where it is absent.
fn repeat(table: &Table<'_>) -> Result<[f64; 2], DescriptionError> {
    let Some(entry) = table.get("repeat") else { return Ok([1.0; 2]) };
    if matches!(entry.node.value, Value::Number(_)) {
        return Ok([within(&entry, &FREQUENCY_RANGE)?; 2]);
    }
    let [u, v] = pair(&entry)?;
    Ok([within(&u, &FREQUENCY_RANGE)?, within(&v, &FREQUENCY_RANGE)?])
}

fn channel(entry: &Entry<'_>) -> Result<usize, DescriptionError> {
    const CHANNELS: [&str; 4] = ["r", "g", "b", "a"];
    let name = entry.text()?;
    let unknown = || entry.place.error(format!("unknown channel {name:?}, {}", suggestion(name, CHANNELS.into_iter())));
    CHANNELS.iter().position(|known| *known == name).ok_or_else(unknown)
}

/// The colours of a ramp, and where they stand if that is written.
fn ramp(
    entry: &Entry<'_>,
    at: Option<&Entry<'_>>,
    range: &RangeInclusive<f64>,
    banded: bool,
) -> Result<Ramp<3>, DescriptionError> {
    let items = entry.items("a list of colours")?;
    if !(1..=MOST_STOPS).contains(&items.len()) {
        let problem = format!("there are {} colours, a ramp has 1 to {MOST_STOPS}", items.len());
        return Err(entry.place.error(problem));
    }
    let mut colours = Vec::new();
    for item in &items {
        let [r, g, b] = triple(item, range)?;
        colours.push([r as f32, g as f32, b as f32]);
    }
    let Some(at) = at else {
        let ramp = if banded { Ramp::banded(&colours) } else { Ramp::even(&colours) };
        return ramp.map_err(|error| entry.place.error(error.to_string()));
    };
    let places = at.items("a list of one position for each colour")?;
    if places.len() != colours.len() {
        let problem = format!("there are {} positions for {} colours", places.len(), colours.len());
        return Err(at.place.error(problem));
    }
    let positions = places.iter().map(|place| within(place, &FINITE)).collect::<Result<Vec<_>, _>>()?;
    let stops = positions.into_iter().zip(colours).map(|(at, colour)| Stop { at: at as f32, colour });
    Ramp::new(stops).map_err(|error| match error {
        RampError::Descending { stop } => {
            let place = places.get(stop).map_or(&at.place, |place| &place.place);
            place.error("positioned below the colour before it: give positions in ascending order")
        }
        _ => at.place.error(error.to_string()),
    })
}
