//! What makes a stack invalid, and the message that says so.

use super::{ALPHA_RANGE, Interface, K_RANGE, Layer, N_RANGE};
use crate::real::Real;
use core::fmt;
use core::ops::RangeInclusive;

/// Why a list of layers is not a stack: which layer, which key, what is wrong and what is allowed.
#[derive(Clone, Debug, PartialEq)]
pub struct StackError {
    /// The layer, counted from 0 at the top; none where the stack as a whole is at fault.
    pub layer: Option<usize>,
    /// The key in a stack file's terms: `interface.alpha`, `medium.sigma`.
    pub key: &'static str,
    /// What is wrong, and the allowed range.
    pub problem: Problem,
}

/// What is wrong with a key of a stack.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Problem {
    /// A number outside what is allowed.
    OutOfRange {
        /// The number.
        value: f64,
        /// The allowed range, in words.
        allowed: &'static str,
    },
    /// There is no layer.
    Empty,
    /// A diffuse base has layers under it.
    DiffuseNotLast,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Problem::OutOfRange { value, allowed } => {
                let finite = if value.is_finite() { "" } else { "finite and " };
                write!(f, "{value} is not allowed, it must be {finite}{allowed}")
            }
            Problem::Empty => write!(f, "a stack needs at least one layer"),
            Problem::DiffuseNotLast => write!(f, "a diffuse base is opaque, so it must be the last layer"),
        }
    }
}

impl fmt::Display for StackError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.layer {
            Some(layer) => write!(f, "layer {} (from the top), {}: {}", layer + 1, self.key, self.problem),
            None => write!(f, "{}: {}", self.key, self.problem),
        }
    }
}

impl core::error::Error for StackError {}

/// Checks every number of a list of layers.
pub(super) fn validate<R: Real, const C: usize>(layers: &[Layer<R, C>]) -> Result<(), StackError> {
    if layers.is_empty() {
        return Err(StackError { layer: None, key: "layer", problem: Problem::Empty });
    }
    for (index, layer) in layers.iter().enumerate() {
        let check = |key: &'static str, values: &[R], allowed: &'static str, ok: fn(f64) -> bool| {
            let offender = values.iter().map(|v| v.to_f64()).find(|v| !v.is_finite() || !ok(*v));
            match offender {
                Some(value) => {
                    Err(StackError { layer: Some(index), key, problem: Problem::OutOfRange { value, allowed } })
                }
                None => Ok(()),
            }
        };
        match &layer.interface {
            Interface::Microfacet { n, k, alpha } => {
                check("interface.n", n, "in [0.001, 1000]", |v| within(&N_RANGE, v))?;
                check("interface.k", k, "in [0, 1000]", |v| within(&K_RANGE, v))?;
                check("interface.alpha", &[*alpha], "in [0.0001, 1]", |v| within(&ALPHA_RANGE, v))?;
            }
            Interface::Diffuse { albedo, sigma } => {
                check("interface.diffuse.albedo", albedo, "in [0, 1]", |v| (0.0..=1.0).contains(&v))?;
                // With room for π/2 as it is written by hand, 1.5708.
                check("interface.diffuse.sigma", &[*sigma], "in [0, π/2]", |v| {
                    (0.0..=core::f64::consts::FRAC_PI_2 + 4e-6).contains(&v)
                })?;
                if index + 1 < layers.len() {
                    let problem = Problem::DiffuseNotLast;
                    return Err(StackError { layer: Some(index), key: "interface.diffuse", problem });
                }
            }
        }
        check("medium.sigma", &layer.medium.sigma, "0 or greater", |v| v >= 0.0)?;
        check("medium.thickness", &[layer.medium.thickness], "0 or greater", |v| v >= 0.0)?;
    }
    Ok(())
}

/// A number that was rounded from f64 to f32 may fall below the limit by half an ULP.
fn within(range: &RangeInclusive<f64>, value: f64) -> bool {
    value >= range.start() * (1.0 - f64::from(f32::EPSILON)) && value <= *range.end()
}
