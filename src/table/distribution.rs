//! Beckmann's distribution over the angle and the width.

use super::{Mapping, TableError, Texel, check_length, check_width};
use crate::distribution;
use crate::frame::Vector;
use crate::real::Real;
use alloc::vec::Vec;

/// The columns, and the rows, of a table of D as printed: 0.5 MB of [`Half`](super::Half).
pub const SIDE: usize = 512;

/// Beckmann's D, tabulated over the angle of the half vector and the width, interpolated linearly in both.
///
/// $$D(\theta, m) \approx \mathrm{lerp}\bigl(T_{ij}\bigr),\quad i = (N-1)\,(2\theta/\pi)^{1/8}$$
///
/// In plain text, [`Mapping::Angle`], as printed: texel (i, j) of N×M holds D at θ = u⁸·π/2 and m = m₀ + (1−m₀)·v with u = i/(N−1),
/// v = j/(M−1), and is looked up at u = (2θ/π)^(1/8), three square roots. (The text says that u⁸ takes three multiplications, which is
/// how it is *made*; looked up at u = cos⁸θ, a table of D over u is wrong by 47 % of the peak at m = .01.)
/// [`Mapping::Root`]: texel (i, j) holds πm²·D at sin²θ = u⁸ and m = v⁴.
///
/// * `m`: the width, in [m₀, 1], clamped there. m₀ in [1e-4, 1) is a parameter: over the angle, where a texel holds D itself,
///   [`Half`](super::Half) overflows for m < .0022 and so takes m₀ ≥ .0023 only.
///
/// Largest error relative to the peak 1/(πm²), 512×512, [`Half`](super::Half): over the angle ≤ .2 % at the width of a row, where
/// equal steps of the angle are wrong by .58 % at m = .02 and 2.2 % at .01. Between rows in equal steps of m it is 13 % at m = .005,
/// 2.5 % at .01, .71 % at .02, .15 % at .05. Over the root ≤ .2 % for every m in [1e-4, 1].
///
/// Source: Elek 2010, §3.1, "Distribution term".
///
/// ```
/// use brdf::table::{DistributionTable, Half, Mapping, SIDE};
/// use brdf::{Vector, distribution};
///
/// let table = DistributionTable::<Half>::new(SIDE, SIDE, 1e-4, Mapping::Root)?;
/// assert_eq!(size_of_val(table.texels()), 512 * 1024);
/// let (h, m) = (Vector::new(0.1, 0.0, 1.0), 0.15_f64);
/// let peak = distribution::beckmann(Vector::new(0.0, 0.0, 1.0), m);
/// assert!((table.evaluate(h, m) - distribution::beckmann(h, m)).abs() < 0.002 * peak);
/// # Ok::<(), brdf::table::TableError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct DistributionTable<T = f32> {
    texels: Vec<T>,
    shape: Shape,
    mapping: Mapping,
}

/// What a shader must know of a [`DistributionTable`] beside its texels: `table::Shape` of WGSL.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "bytemuck", derive(bytemuck::Pod, bytemuck::Zeroable))]
#[repr(C)]
pub struct Shape {
    /// The texels over the angle.
    pub columns: u32,
    /// The texels over the width.
    pub rows: u32,
    /// The least width, m₀.
    pub least: f32,
    /// Rows for each unit of m ([`Mapping::Angle`]) or of its fourth root ([`Mapping::Root`]).
    pub rate: f32,
}

impl<T: Texel> DistributionTable<T> {
    /// Tabulates [`distribution::beckmann`] for widths from `least` on.
    ///
    /// # Errors
    /// [`TableError::Length`], [`TableError::Width`], and [`TableError::Overflow`] where a texel is larger than `T` can hold.
    pub fn new(columns: usize, rows: usize, least: f64, mapping: Mapping) -> Result<Self, TableError> {
        check_length(columns)?;
        check_length(rows)?;
        check_width(least)?;
        let least = least as f32;
        let (origin, span) = match mapping {
            Mapping::Angle => (f64::from(least), 1.0 - f64::from(least)),
            Mapping::Root => (0.0, 1.0),
        };
        let shape =
            Shape { columns: columns as u32, rows: rows as u32, least, rate: ((rows - 1) as f64 / span) as f32 };
        let mut texels = Vec::with_capacity(columns * rows);
        for j in 0..rows {
            let place = origin + j as f64 / f64::from(shape.rate);
            for i in 0..columns {
                let eighth = (i as f64 / (columns - 1) as f64).squared().squared().squared();
                let (alpha, value) = match mapping {
                    Mapping::Angle => {
                        let (cos, sin) = (0.25 * eighth).unit_circle();
                        (place, distribution::beckmann(Vector::new(sin, 0.0, cos), place))
                    }
                    Mapping::Root => {
                        let alpha = place.squared().squared();
                        (alpha, normalised(eighth, alpha))
                    }
                };
                if value > T::LARGEST {
                    return Err(TableError::Overflow { alpha, value, largest: T::LARGEST });
                }
                texels.push(T::encode(value));
            }
        }
        Ok(DistributionTable { texels, shape, mapping })
    }

    /// D in sr⁻¹; `h` of any length with h.z > 0, else 0, as of [`distribution::beckmann`].
    ///
    /// `alpha` is clamped to [m₀, 1].
    #[inline(always)]
    pub fn evaluate<R: Real>(&self, h: Vector<R>, alpha: R) -> R {
        let (h, one) = (h.widen(), R::Wide::ONE);
        let above = h.z.gt(R::Wide::ZERO);
        let z = R::Wide::select(above, h.z, one);
        let s = h.sin_squared();
        let Shape { columns, rows, least, rate } = self.shape;
        let [least, rate] = [least, rate].map(|x| R::Wide::from_f64(f64::from(x)));
        let m = alpha.widen().max(least).min(one);
        let (eighth, row, scale) = match self.mapping {
            Mapping::Angle => {
                let angle = R::angle_wide(s.sqrt(), z) * R::Wide::from_f64(core::f64::consts::FRAC_2_PI);
                (angle, (m - least) * rate, one)
            }
            Mapping::Root => (s / (s + z * z), m.sqrt().sqrt() * rate, one / (R::Wide::PI * m * m)),
        };
        let (columns, rows) = (columns as usize, rows as usize);
        let column = eighth.sqrt().sqrt().sqrt() * R::Wide::from_f64((columns - 1) as f64);
        let cells = [columns - 1, rows - 1];
        let value = R::Wide::bilinear([column, row], cells, |i, j| self.texels[j * columns + i].decode());
        R::narrow(R::Wide::select(above, value * scale, R::Wide::ZERO))
    }

    /// The texels, row by row of one width, each from the normal to the horizon.
    pub fn texels(&self) -> &[T] {
        &self.texels
    }

    /// The size of the table, and where its rows lie.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// What the texels are equally spaced in.
    pub fn mapping(&self) -> Mapping {
        self.mapping
    }
}

/// πm²·D at this sin²θ; at m = 0 its limit, 1 at the normal and 0 elsewhere.
fn normalised(sin_squared: f64, alpha: f64) -> f64 {
    if sin_squared == 0.0 {
        return 1.0;
    }
    let h = Vector::new(Real::sqrt(sin_squared), 0.0, Real::sqrt(1.0 - sin_squared));
    let value = distribution::beckmann(h, alpha) * core::f64::consts::PI * alpha * alpha;
    // The width of the first row is 0, where D itself is 0/0.
    if alpha > 0.0 { value } else { 0.0 }
}
