//! The documents' materials, functions from their parameters.
//!
//! Each is a struct whose [`Default`] is what the documents show, and which makes a [`Material`]. By name, with numbers to change:
//!
//! ```
//! use brdf::material::built_in;
//!
//! let mut patina = built_in::by_name("patina").unwrap();
//! patina.set("extent", 0.75)?;
//! let material = patina.material()?;
//! assert_eq!(material.parts().len(), 2);
//! assert!(patina.set("extend", 0.75).is_err());
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```

pub mod lacquer;
pub mod paint;
pub mod patinated;
pub mod rust;
pub mod worn;

use super::field::Scalar;
use super::parts::{Material, MaterialError};
use crate::texture::ramp::RampError;
use alloc::boxed::Box;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use core::fmt;
use core::ops::RangeInclusive;

/// A number that a built-in material may be asked to change.
#[derive(Debug)]
pub struct Parameter<'a> {
    /// Its name.
    pub name: &'static str,
    /// The number.
    pub value: &'a mut f64,
    /// What it may be.
    pub range: RangeInclusive<f64>,
}

impl<'a> Parameter<'a> {
    pub(super) fn new(name: &'static str, value: &'a mut f64, range: RangeInclusive<f64>) -> Self {
        Parameter { name, value, range }
    }
}

/// A material of the documents, with its parameters.
pub trait BuiltIn {
    /// The numbers that may be changed.
    fn parameters(&mut self) -> Vec<Parameter<'_>>;

    /// The material.
    ///
    /// # Errors
    /// Where the parameters make no [`Material`].
    fn material(&self) -> Result<Material, MaterialError>;
}

/// A number that a built-in material does not take.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParameterError(String);

impl fmt::Display for ParameterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl core::error::Error for ParameterError {}

/// A built-in material under its name.
pub struct Named {
    /// The name that material files and the command line use.
    pub name: &'static str,
    /// What it shows.
    pub about: &'static str,
    of: Box<dyn BuiltIn + Send + Sync>,
}

impl fmt::Debug for Named {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Named").field("name", &self.name).field("about", &self.about).finish_non_exhaustive()
    }
}

impl Named {
    /// Changes a number.
    ///
    /// # Errors
    /// Where there is none of this name, or it may not be this.
    pub fn set(&mut self, name: &str, value: f64) -> Result<(), ParameterError> {
        let material = self.name;
        let mut parameters = self.of.parameters();
        let names = parameters.iter().map(|parameter| parameter.name).collect::<Vec<_>>().join(", ");
        let Some(parameter) = parameters.iter_mut().find(|parameter| parameter.name == name) else {
            return Err(ParameterError(format!("{material} has no parameter `{name}`; it has {names}")));
        };
        let (low, high) = (parameter.range.start(), parameter.range.end());
        if !parameter.range.contains(&value) {
            return Err(ParameterError(format!("{name} of {material} is {value}, allowed is {low} to {high}")));
        }
        *parameter.value = value;
        Ok(())
    }

    /// The numbers that may be changed: their names, values and ranges.
    pub fn parameters(&mut self) -> Vec<Parameter<'_>> {
        self.of.parameters()
    }

    /// The material.
    ///
    /// # Errors
    /// Where the parameters make no [`Material`].
    pub fn material(&self) -> Result<Material, MaterialError> {
        self.of.material()
    }
}

/// Every built-in material.
pub fn all() -> Vec<Named> {
    fn named(name: &'static str, about: &'static str, of: impl BuiltIn + Send + Sync + 'static) -> Named {
        Named { name, about, of: Box::new(of) }
    }
    use paint::{CarPaint, Sparkle};
    use patinated::{Patina, Scattering, Timeline};
    Vec::from([
        named(
            "car_paint",
            "chromium flakes under a tinted coat, glints that conserve energy (Elek, §4.1)",
            CarPaint::default(),
        ),
        named(
            "car_paint_as_printed",
            "the same with the documents' flake normals and model (Elek, §4.1)",
            CarPaint { sparkle: Sparkle::AsPrinted, ..CarPaint::default() },
        ),
        named("patina", "copper under a growing film of patina, by Kubelka and Munk (Elek, §4.2)", Patina::default()),
        named(
            "patina_as_printed",
            "copper under Cu₂O with the documents' diffuse term and model (Elek, §4.2)",
            Patina { scattering: Scattering::AsPrinted, ..Patina::default() },
        ),
        named("patina_over_time", "five colours of patina in bands, by age (Mihaylov, §3.3.2)", Timeline::default()),
        named(
            "rusty_iron",
            "iron with spots of rust by a noise mask (Mihaylov, §3.3.1, §4.3)",
            rust::RustyIron::default(),
        ),
        named(
            "worn_metal",
            "polished metal with scratches and dirt (Mihaylov, §3.2, §4.2)",
            worn::WornMetal::default(),
        ),
        named(
            "brushed_steel",
            "grooves along v: from pole to pole of a sphere (Mihaylov, §3.1.4)",
            worn::BrushedSteel::default(),
        ),
        named(
            "turned_steel",
            "grooves along u: around the axis, as of a pot's bottom (Mihaylov, §3.1.4)",
            worn::BrushedSteel { turn: 0.0, ..worn::BrushedSteel::default() },
        ),
        named("orange_lacquer", "a lacquer of varying thickness (Elek, fig. 10)", lacquer::Lacquer::orange()),
        named("purple_lacquer", "a lacquer of varying thickness (Elek, fig. 10)", lacquer::Lacquer::purple()),
        named(
            "varnished_concrete",
            "a blue varnish over Oren–Nayar concrete (Elek, fig. 10)",
            lacquer::Varnish::default(),
        ),
        named("coated_ceramic", "a white body under a clear glaze", lacquer::Ceramic::default()),
    ])
}

/// The built-in material of this name.
pub fn by_name(name: &str) -> Option<Named> {
    all().into_iter().find(|material| material.name == name)
}

/// The built-in material of this name, with numbers changed.
///
/// # Errors
/// In one line: where there is no such material or number, or it may not be this.
pub fn with(name: &str, changes: &[(String, f64)]) -> Result<Material, ParameterError> {
    let Some(mut found) = by_name(name) else {
        let names = all().iter().map(|material| material.name).collect::<Vec<_>>().join(", ");
        return Err(ParameterError(format!("`{name}` is no built-in material; there are {names}")));
    };
    for (name, value) in changes {
        found.set(name, *value)?;
    }
    found.material().map_err(|error| ParameterError(error.to_string()))
}

/// A mask of a map in [0, 1] at a stage from 0 to 1, the light shades first: 0 everywhere at 0 and 1 everywhere at 1, whatever the softness.
fn by_stage(map: Scalar, stage: f64, softness: f64) -> Scalar {
    // The edge moves from just above the map to just below it. A hair more than its half width, which f32 holds beside 1 + 1, keeps out
    // rounding, and a map of just 0 from a sharp edge.
    let beyond = softness + 1e-6;
    map.above(1.0 + beyond - stage * (1.0 + 2.0 * beyond), softness)
}

/// Colours of a part that make no ramp.
fn no_ramp(part: usize, error: &RampError) -> MaterialError {
    MaterialError { part, layer: None, key: None, problem: error.to_string() }
}
