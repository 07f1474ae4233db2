//! Proofs, by interval arithmetic: that a function of two directions is never negative and always finite.
//!
//! Every other check samples. [`prove`] bounds the function over whole boxes of directions and parameters, cuts those on
//! which the bounds leave it open, and ends with one [`Answer`] for each property: [`Answer::Proved`], [`Answer::Disproved`]
//! by a point, or [`Answer::Undecided`] with the boxes that are left.
//!
//! ```
//! use brdf::check::prove::{self, Answer, Directions, Formula, Options};
//! use brdf::{Real, Vector};
//!
//! /// A Lambert surface that someone dented.
//! struct Dented;
//! impl Formula for Dented {
//!     fn evaluate<R: Real>(&self, wi: Vector<R>, _wo: Vector<R>, _parameters: &[R]) -> R {
//!         let off = wi.z - R::from_f64(0.7);
//!         R::FRAC_1_PI * off.squared() - R::from_f64(0.0001)
//!     }
//! }
//! let isotropic = Options { directions: Directions { isotropic: true, ..Default::default() }, ..Default::default() };
//! let proof = prove::formula("dented", &Dented, &[], &isotropic);
//! assert_eq!(proof.finite, Answer::Proved);
//! let Answer::Disproved(witness) = proof.sign else { panic!() };
//! assert_eq!(witness.wi.z, 0.7);
//! ```
//!
//! # What is proved
//!
//! A statement about the function as a formula over the real numbers, its constants those of f64: not about its rounding
//! in f32, which is the matter of [`crate::interval::WgslInterval`] and of the line PRECISION. Bounds are rounded
//! outwards ([`Enclosure`]), relying on the standard library's functions being good to 4 ε.
//!
//! * *Not negative*: no point of the box has a value below 0. Where there is no value, that is the other property's matter.
//! * *Finite*: at every point each operation on the way to the value is defined, and finite in the range of f32.
//! * *Disproved*: a point at which f64 gives a value below 0 that exact arithmetic confirms; or one at which f64 gives
//!   infinity or NaN.
//! * *Undecided*: neither. Bounds that do not know that two occurrences of one variable are the same (x − x), a pole
//!   that is not met exactly, a branch with too many ways, and a division that a `select` guards stay so, however small the box.
//!
//! Directions are unit vectors of a box of cosines and azimuths; what a formula does with |w| = 1 beyond that, the bounds
//! do not know.

#[cfg(feature = "shader")]
mod builtins;
mod display;
mod domain;
mod enclosure;
mod search;
#[cfg(feature = "shader")]
mod shaders;

pub use domain::{Directions, Domain, Edge, Region};
pub use enclosure::Enclosure;
#[cfg(feature = "shader")]
pub use shaders::ShaderFormula;

use super::Verdict;
use super::family::Parameter;
use crate::frame::Vector;
use crate::real::Real;

/// A function that has bounds over boxes as well as values at points.
pub trait Provable: Sync {
    /// What a report calls it.
    fn name(&self) -> String;

    /// The parameters and their ranges, which are part of the box.
    fn parameters(&self) -> &[Parameter];

    /// Bounds of the least channel for each row: the three components of wi, those of wo, and the parameters. A row's bounds
    /// are total only if every channel's are.
    fn enclose(&self, rows: &[Enclosure], count: usize) -> Vec<Enclosure>;

    /// The least channel in f64, or one that is not finite.
    fn value(&self, wi: Vector<f64>, wo: Vector<f64>, parameters: &[f64]) -> f64;
}

/// A function in Rust over any [`Real`], as this crate's terms are.
pub trait Formula: Sync {
    /// f for unit directions with the normal along +z, and the parameters in the order that they were given.
    fn evaluate<R: Real>(&self, wi: Vector<R>, wo: Vector<R>, parameters: &[R]) -> R;
}

/// How long to try, and over which directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The directions of the box.
    pub directions: Directions,
    /// The boxes to bound at most.
    pub boxes: usize,
}

impl Default for Options {
    fn default() -> Self {
        Options { directions: Directions::default(), boxes: 100_000 }
    }
}

/// What came of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Proof {
    /// The name of the function.
    pub subject: String,
    /// The box that the answers are about.
    pub domain: Domain,
    /// Whether it is nowhere negative.
    pub sign: Answer,
    /// Whether it is everywhere finite.
    pub finite: Answer,
    /// The boxes that were bounded.
    pub boxes: usize,
}

impl Proof {
    /// [`Verdict::Fail`] if a property is disproved, [`Verdict::Pass`] if both are proved.
    pub fn verdict(&self) -> Verdict {
        self.sign.verdict().max(self.finite.verdict())
    }
}

/// The answer about one property.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    /// It holds on the whole box.
    Proved,
    /// It does not hold at this point.
    Disproved(Witness),
    /// Neither is shown; it does hold on the rest of the box.
    Undecided(Rest),
}

impl Answer {
    /// What it means for a gate.
    pub fn verdict(&self) -> Verdict {
        match self {
            Answer::Proved => Verdict::Pass,
            Answer::Disproved(_) => Verdict::Fail,
            Answer::Undecided(_) => Verdict::Inconclusive,
        }
    }
}

/// A point at which a property does not hold, rounded to few digits.
#[derive(Clone, Debug, PartialEq)]
pub struct Witness {
    /// A number for each axis of the domain.
    pub point: Vec<f64>,
    /// The direction of the light.
    pub wi: Vector<f64>,
    /// The direction of the view.
    pub wo: Vector<f64>,
    /// The value in f64.
    pub value: f64,
}

/// Where a property is open.
#[derive(Clone, Debug, PartialEq)]
pub struct Rest {
    /// Its share of the box, along the axes as they are searched.
    pub share: f64,
    /// The boxes left.
    pub count: usize,
    /// The largest of them, and the bounds there.
    pub worst: Vec<(Region, Enclosure)>,
}

/// Tries to prove a function nowhere negative and everywhere finite.
///
/// The same options give the same answers, on any number of threads.
pub fn prove(subject: &dyn Provable, options: &Options) -> Proof {
    let domain = Domain::new(subject.parameters(), options.directions);
    search::prove(subject, domain, options)
}

/// [`prove`] for a formula in Rust and the ranges of its parameters.
pub fn formula(name: &str, formula: &impl Formula, parameters: &[Parameter], options: &Options) -> Proof {
    prove(&Named { name, formula, parameters }, options)
}

struct Named<'a, F> {
    name: &'a str,
    formula: &'a F,
    parameters: &'a [Parameter],
}

impl<F: Formula> Provable for Named<'_, F> {
    fn name(&self) -> String {
        self.name.to_owned()
    }
    fn parameters(&self) -> &[Parameter] {
        self.parameters
    }
    fn enclose(&self, rows: &[Enclosure], _: usize) -> Vec<Enclosure> {
        let value = |row: &[Enclosure]| match row {
            [ix, iy, iz, ox, oy, oz, parameters @ ..] => {
                self.formula.evaluate(Vector::new(*ix, *iy, *iz), Vector::new(*ox, *oy, *oz), parameters)
            }
            _ => Enclosure::ANYTHING,
        };
        rows.chunks(6 + self.parameters.len()).map(value).collect()
    }
    fn value(&self, wi: Vector<f64>, wo: Vector<f64>, parameters: &[f64]) -> f64 {
        self.formula.evaluate(wi, wo, parameters)
    }
}

#[cfg(test)]
mod tests;
