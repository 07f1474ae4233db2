//! Flakes that glint, with the same energy at every place and every distance.
//!
//! Twin: `wgsl/glint.wgsl`. [`factor`] multiplies the D of a Beckmann interface of V-cavities: where few flakes lie under a pixel
//! the lobe breaks into grains, from afar it is Beckmann's own.
//!
//! # The construction
//!
//! The slopes (x, y) of Beckmann's normals become even by s = ½(1+erf(x/α)) and t = ½(1+erf(y/α)): D·cos dω = ds dt.
//! The square of (s, t) is cut into 2^J × 2^J leaves. A cell of space, of the side of the footprint, holds N flakes, and N
//! is *dealt* to the leaves: halved again and again, the rows and the columns in turn, n flakes into Binomial(n, ½) and the rest.
//! What one half gains the other loses, so the leaves hold N flakes exactly, whatever the random numbers were. With hats about the
//! centres of the leaves (linear, constant beyond the outermost, each of the same mass)
//!
//! $$g(h) = \frac{4^J}{N}\sum_{ij} n_{ij}\,\mathrm{hat}_{ij}(s,t),\qquad \int D\,g\cos\theta\,d\omega = \int_0^1\!\!\int_0^1 g\,ds\,dt = 1$$
//!
//! In plain text: g = 4^J/N·Σ n_ij·hat_ij(s, t); the integral of D·g·cos over the hemisphere is 1 in every cell.
//!
//! A flake is a V-cavity: its two facets (x, y) and (−x, −y) are dealt together, so that g(h) is the same at opposite slopes.
//! That is all that the masking of V-cavities asks of a distribution (Heitz 2014, §5.2). Therefore the normals that a view sees integrate to
//! its cosine *in each cell*, and with F = 1 no cell reflects more than arrives, from any view: not on the average over
//! cells only. Under Smith's masking the mean over cells is as bright as Beckmann's and a single cell need not be.
//!
//! # Level of detail
//!
//! The side of a cell is the footprint, between two powers of two of the [`Flakes::spacing`], whose values are mixed in
//! proportion; N grows with the square of the side. g depends continuously on the footprint: it changes by at most
//! 4^J·Δ/side while the footprint changes by Δ. Neighbouring cells are not mixed. Where N > 2¹⁴·4^J, and the
//! standard deviation of g is below half a per cent, g is 1.
//!
//! Over cells the mean of g is 1 and its variance (4^J·Σw²/2 − 1)/N, w the shares of the up to four leaves that h lies between: (2·4^J/9 − 1)/N
//! on the average over h. N up to 128 is dealt by the bits of a hash, so that it is the binomial distribution itself; above,
//! by half of N plus √(N/128) times what 128 bits deviate from 64: the same mean and variance, bounded by 0 and N, and equal
//! to the other rule at 128. Real-valued counts are dealt as their whole part, and the rest to one side; that is continuous too.
//!
//! # Beside the published models
//!
//! Chermain et al. 2021 and Deliot & Belcour 2023 draw the count of the flakes that reflect at a half vector by an approximate binomial
//! law for each cell of space and direction *independently*: the mean over cells is right, the integral over directions of one
//! cell is not 1 (at N = 1 and 1024 leaves it would deviate by about 1). Kemppinen et al. 2025 draw points of a process in four
//! dimensions, in constant time, which also conserves on the average. Splitting costs 2J−1 hashes at each leaf where they take one,
//! and buys the exact sum. The price is in `glint::tests::it_costs_this_much`.

use crate::frame::Vector;
use crate::random::random_words;
use crate::real::Real;

/// The largest [`Flakes::resolution`].
pub const FINEST: u32 = 8;

/// The flakes of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Flakes<R> {
    /// The side of the smallest cell, > 0, in the units of the position: about the distance between flakes.
    pub spacing: R,
    /// How many flakes a cell of that side holds, > 0: 1 if the spacing is the distance between them.
    pub count: R,
    /// J: a flake's own lobe is as wide as a 2^−J-th of the distribution of each slope. From 1 to [`FINEST`], clamped.
    pub resolution: u32,
    /// Another seed, other flakes.
    pub seed: u32,
}

impl<R: Real> Flakes<R> {
    /// The same flakes over another number type.
    pub fn cast<S: Real>(&self) -> Flakes<S> {
        let Flakes { spacing, count, resolution, seed } = *self;
        Flakes { spacing: S::from_f64(spacing.to_f64()), count: S::from_f64(count.to_f64()), resolution, seed }
    }
}

/// What D is multiplied with at a place: how many more flakes than usual mirror in this direction.
///
/// * `h`: the local half vector, of any length. `alpha`: the width of the lobe in [1e-4, 1], the same along both axes.
/// * `position`: of the place, in the space that the flakes lie in: the object's, or (u, v, 0). `footprint`: the
///   width there that a pixel covers.
///
/// In [0, 4^J]; 1 where N > 2¹⁴·4^J. Finite for every input; where `h.z` ≤ 0, where D is 0, it is some number in that range.
/// A `spacing` or `count` that is not positive leaves 1.
///
/// Error in f32: 1e-5·4^J absolute, and another cell within an ULP of its border. Source: the [module](self).
pub fn factor<R: Real>(h: Vector<R>, alpha: R, flakes: &Flakes<R>, position: Vector<R>, footprint: R) -> R {
    let resolution = flakes.resolution.clamp(1, FINEST);
    let side = 1u32 << resolution;
    if !(flakes.spacing.to_f64() > 0.0 && flakes.count.to_f64() > 0.0) {
        return R::ONE;
    }
    let upper = h.z.gt(R::ZERO);
    let inverse = R::ONE / (R::select(upper, h.z, R::ONE) * alpha);
    let place = |slope: R| {
        let last = R::from_f64(f64::from(side - 1));
        (rank(slope * inverse) * R::from_f64(f64::from(side)) - R::HALF).max(R::ZERO).min(last)
    };
    let (column, row) = (place(h.x), place(h.y));
    // The footprint in sides of the finer of the two cells, in [1, 2), and how much finer than it the spacing is.
    let (mut ratio, mut level, mut finer) = ((footprint / flakes.spacing).max(R::ONE), 0, R::ONE);
    while level < COARSEST && ratio.to_f64() >= 2.0 {
        (ratio, level, finer) = (ratio * R::HALF, level + 1, finer * R::HALF);
    }
    let share = (ratio - R::ONE).saturate();
    let grain = |level: u32, finer: R| {
        let count = flakes.count / (finer * finer);
        if count.to_f64() > FINE * f64::from(side * side) {
            return R::ONE;
        }
        let key = cell(position, flakes.spacing, finer, level, flakes.seed);
        interpolated(key, count, resolution, column, row) * (R::from_f64(f64::from(side * side)) / count)
    };
    let near = grain(level, finer);
    let far = grain(level + 1, finer * R::HALF);
    near * (R::ONE - share) + far * share
}

/// Past so many flakes for each leaf the lobe has no grain: 2¹⁴.
const FINE: f64 = 16384.0;

/// The coarsest level of detail but one: a footprint of a million spacings.
const COARSEST: u32 = 20;

/// How many flakes of a cell have facets in one leaf: half of those dealt to it and its opposite.
///
/// * `key`: four random words of the cell. `count`: how many flakes the cell holds, ≥ 0. `resolution`: J, from 1 to [`FINEST`],
///   clamped. `column`, `row`: of the leaf, below 2^J, along the first and the second slope.
///
/// The sum over all leaves is `count`; leaf (i, j) has as many as (2^J−1−i, 2^J−1−j). Exact, and the same to the bit
/// in every precision and in WGSL, for a `count` up to 128 with up to 16 binary digits behind the point.
pub fn leaf<R: Real>(key: [u32; 4], count: R, resolution: u32, column: u32, row: u32) -> R {
    let resolution = resolution.clamp(1, FINEST);
    let last = (1u32 << resolution) - 1;
    let opposite = column > last / 2;
    let (column, row) = if opposite { (last.wrapping_sub(column), last.wrapping_sub(row)) } else { (column, row) };
    let (mut held, mut node) = (count, 1u32);
    // The first digit of the column is the side that was folded away.
    for step in 0..2 * resolution - 1 {
        if held.to_f64() <= 0.0 {
            break;
        }
        let digit = if step & 1 == 0 {
            row >> (resolution - 1 - step / 2) & 1
        } else {
            column >> (resolution - 2 - step / 2) & 1
        };
        let left = dealt(held, random_words([key[0], key[1], key[2], key[3].wrapping_add(node)]));
        held = if digit == 0 { left } else { (held - left).max(R::ZERO) };
        node = 2 * node + digit;
    }
    held * R::HALF
}

/// How many of `count` flakes go to the left, by 128 random bits: see the [module](self).
fn dealt<R: Real>(count: R, words: [u32; 4]) -> R {
    let bits = words.iter().rev().fold(0u128, |bits, word| bits << 32 | u128::from(*word));
    let number = count.to_f64();
    if number < 128.0 {
        let whole = number as u32;
        let ones = (bits & ((1 << whole) - 1)).count_ones();
        let next = R::from_f64(f64::from((bits >> whole) as u32 & 1));
        R::from_f64(f64::from(ones)) + (count - R::from_f64(f64::from(whole))) * next
    } else {
        let deviation = R::from_f64(f64::from(bits.count_ones()) - 64.0);
        R::HALF * count + deviation * (count * R::from_f64(1.0 / 128.0)).sqrt()
    }
}

/// [`leaf`] between the centres of the leaves, at a column and a row in [0, 2^J − 1].
fn interpolated<R: Real>(key: [u32; 4], count: R, resolution: u32, column: R, row: R) -> R {
    let last = (1u32 << resolution) - 2;
    let (i, j) = ((column.to_f64() as u32).min(last), (row.to_f64() as u32).min(last));
    let u = (column - R::from_f64(f64::from(i))).saturate();
    let v = (row - R::from_f64(f64::from(j))).saturate();
    let at = |i, j| leaf(key, count, resolution, i, j);
    let low = at(i, j) * (R::ONE - u) + at(i + 1, j) * u;
    let high = at(i, j + 1) * (R::ONE - u) + at(i + 1, j + 1) * u;
    low * (R::ONE - v) + high * v
}

/// The random words of the cell that a position lies in.
fn cell<R: Real>(position: Vector<R>, spacing: R, finer: R, level: u32, seed: u32) -> [u32; 4] {
    // Farther out than 2³⁰ cells, where f32 has no digits left, all is one cell.
    const FAR: f64 = 1_073_741_824.0;
    let index = |x: R| {
        let x = (x / spacing * finer).max(R::from_f64(-FAR)).min(R::from_f64(FAR)).to_f64();
        let whole = x as i32;
        (if f64::from(whole) > x { whole - 1 } else { whole }).cast_unsigned()
    };
    random_words([index(position.x), index(position.y), index(position.z), seed ^ (level << 27)])
}

/// ½(1+erf(x)): the share of a Gaussian distribution of slopes that is below x·α.
fn rank<R: Real>(x: R) -> R {
    let distance = x.abs();
    let square = distance * distance;
    let inside = square.le(R::EXP_LIMIT);
    let power = (-R::select(inside, square, R::ZERO)).exp();
    let tail = R::select(inside, R::HALF * power * distance.erfcx(), R::ZERO);
    R::select(x.lt(R::ZERO), tail, R::ONE - tail)
}
