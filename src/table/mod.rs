//! Tables in place of terms, as Elek 2010, §3.1 keeps them: F of a material over the angle, D over angle and width.
//!
//! Twin: `wgsl/table.wgsl`, which reads texels through functions that the importing shader supplies, from textures or
//! storage buffers. [`FresnelTable`] and [`FresnelAtlas`] hold F, [`DistributionTable`] D; all interpolate linearly
//! between texels that lie at the ends of the range: texel i of n stands for i/(n−1).
//!
//! Tables are approximations, whose errors `tests/tables.rs` measures. What they save depends on the machine and on the term
//! (`cargo bench --bench terms`): on a CPU a table of F over the root costs less than a tenth of the exact conductor, one of D
//! several times the exact Beckmann.
//!
//! A filtering sampler does the same in one fetch where the coordinate is ((n−1)·u + ½)/n along each axis; hardware
//! keeps 8 bits of the fraction between texels. Mip levels mix widths and must stay off (Elek 2010, §3.1).

mod distribution;
mod fresnel;
mod half;

pub use distribution::{DistributionTable, SIDE, Shape};
pub use fresnel::{ENTRIES, FresnelAtlas, FresnelTable};
pub use half::Half;

use crate::layered::{ALPHA_RANGE, K_RANGE, N_RANGE};
use crate::real::Sealed;
use core::fmt;
use core::ops::RangeInclusive;

/// The texels that a table may have along an axis: what every WebGPU device takes of a texture.
pub const LENGTHS: RangeInclusive<usize> = 2..=8192;

/// What the texels of a table are equally spaced in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mapping {
    /// As printed. F: the angle of incidence. D: the eighth root of the angle, and the width.
    #[default]
    Angle,
    /// What needs no angle and bends less. F: the square root of the cosine. D: the eighth root of sin², and the fourth
    /// root of the width.
    Root,
}

/// A number that tables store. Sealed: `f32`, [`Half`], and `u8`, which stands for 0 to 1 in steps of 1/255.
pub trait Texel: Copy + fmt::Debug + PartialEq + Send + Sync + 'static + Sealed {
    /// The largest number that it stores.
    const LARGEST: f64;
    /// The nearest one to `x` in [0, [`LARGEST`](Texel::LARGEST)].
    fn encode(x: f64) -> Self;
    /// The number that it stores.
    fn decode(self) -> f64;
}

impl Texel for f32 {
    const LARGEST: f64 = f32::MAX as f64;
    fn encode(x: f64) -> Self {
        x as f32
    }
    #[inline(always)]
    fn decode(self) -> f64 {
        f64::from(self)
    }
}

impl Sealed for Half {}
impl Texel for Half {
    const LARGEST: f64 = 65_504.0;
    fn encode(x: f64) -> Self {
        Half::from_f64(x)
    }
    #[inline(always)]
    fn decode(self) -> f64 {
        self.to_f64()
    }
}

impl Sealed for u8 {}
impl Texel for u8 {
    const LARGEST: f64 = 1.0;
    fn encode(x: f64) -> Self {
        // A cast saturates, and cuts off what is left of a rounding.
        (255.0 * x + 0.5) as u8
    }
    #[inline(always)]
    fn decode(self) -> f64 {
        f64::from(self) * (1.0 / 255.0)
    }
}

/// Why there is no such table.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum TableError {
    /// A number of texels along an axis outside [`LENGTHS`].
    Length(usize),
    /// An index outside [`N_RANGE`] or [`K_RANGE`].
    Index {
        /// The channel, counted from 0.
        channel: usize,
        /// The real part of its index.
        n: f64,
        /// The imaginary part.
        k: f64,
    },
    /// A least width outside [`ALPHA_RANGE`], or no less than 1.
    Width(f64),
    /// A texel that its type cannot hold.
    Overflow {
        /// The width whose row it is in.
        alpha: f64,
        /// The value.
        value: f64,
        /// The largest that there is.
        largest: f64,
    },
    /// A table of another length or mapping than those of the atlas.
    Mismatch {
        /// The length of the table.
        entries: usize,
        /// Its mapping.
        mapping: Mapping,
    },
    /// An atlas that has all rows of [`LENGTHS`].
    Full,
}

impl fmt::Display for TableError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TableError::Length(given) => {
                write!(f, "{given} texels along an axis, but there must be {} to {}", LENGTHS.start(), LENGTHS.end())
            }
            TableError::Index { channel, n, k } => {
                write!(f, "channel {channel}: n = {n}, κ = {k}, but n must be in [0.001, 1000] and κ in [0, 1000]")
            }
            TableError::Width(least) => write!(f, "a least width of {least}, but it must be in [0.0001, 1)"),
            TableError::Overflow { alpha, value, largest } => write!(
                f,
                "a texel at width {alpha:.5} is {value:.0}, but the largest that its type holds is {largest}: start at a \
                 larger width, or store another type or mapping"
            ),
            TableError::Mismatch { entries, mapping } => {
                write!(f, "a table of {entries} entries over {mapping:?} differs from those that the atlas holds")
            }
            TableError::Full => write!(f, "an atlas holds at most {} tables", LENGTHS.end()),
        }
    }
}

impl core::error::Error for TableError {}

/// Refuses a number of texels outside [`LENGTHS`].
fn check_length(length: usize) -> Result<(), TableError> {
    if LENGTHS.contains(&length) { Ok(()) } else { Err(TableError::Length(length)) }
}

/// Refuses an index outside the ranges of a stack.
fn check_index(channel: usize, n: f64, k: f64) -> Result<(), TableError> {
    let inside = N_RANGE.contains(&n) && K_RANGE.contains(&k);
    if inside { Ok(()) } else { Err(TableError::Index { channel, n, k }) }
}

/// Refuses a least width outside [`ALPHA_RANGE`].
fn check_width(least: f64) -> Result<(), TableError> {
    let inside = ALPHA_RANGE.contains(&least) && (least as f32) < 1.0;
    if inside { Ok(()) } else { Err(TableError::Width(least)) }
}
