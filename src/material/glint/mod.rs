//! Flakes that glint, with the same energy at every place and every distance.
//!
//! Twin: `wgsl/glint.wgsl`, of this module and the one inside it. [`factor`] multiplies the D of a Beckmann interface of
//! V-cavities: where few flakes lie under a pixel the lobe breaks into grains, from afar it is Beckmann's own.
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
//! That is all that the masking of V-cavities asks of a distribution (Heitz 2014). Therefore the normals that a view
//! sees integrate to its cosine *in each cell*, and with F = 1 no cell reflects more than arrives, from any view: not on
//! the average over cells only. Under Smith's masking the mean over cells is as bright as Beckmann's and a single cell
//! need not be.
//!
//! # Level of detail
//!
//! The side of a cell is the footprint, between two powers of two of the [`Flakes::spacing`], whose values are mixed in
//! proportion; N grows with the square of the side. g depends continuously on the footprint: it changes by at most
//! 4^J·Δ/side while the footprint changes by Δ. A mixture of w of the coarser level has (1−w)² + w²/4 of the finer one's
//! variance. Neighbouring cells are not mixed. From N = 2¹⁴·4^J on, where the
//! standard deviation of g is below half a per cent, g is 1.
//!
//! Over cells the mean of g is 1 and its variance (4^J·Σw²/2 − 1)/N, w the shares of the up to four leaves that h lies between: (2·4^J/9 − 1)/N
//! on the average over h. N up to 128 is dealt by the bits of a hash, so that it is the binomial distribution itself; above,
//! by half of N plus √(N/128) times what 128 bits deviate from 64: the same mean and variance, bounded by 0 and N, and equal
//! to the other rule at 128. What is left of a flake is dealt as one; that is continuous too.
//!
//! # Beside the published models
//!
//! Deliot & Belcour 2023 draw the number of flakes that reflect at a half vector by an approximate binomial law for each cell of
//! slopes *independently*. Where that is done the mean over cells is right, and the integral over directions of one cell
//! strays from 1 by the deviation of Poisson's law, 1/√N: by 1 where a pixel sees one flake (measured in
//! `glint::tests::independent_leaves_would_not_conserve`). Dealing costs 2J−1 hashes, and some for each
//! of the four leaves around, at two levels of detail; and leaves nothing to stray. Kemppinen et al. 2025 (doi
//! 10.1145/3763282) place points of a process in four dimensions, in constant time and without memory, converge to
//! Beckmann's lobe and draw directions from the points; of the energy of a single pixel their abstract says nothing. What
//! this has not: flakes that stay while the level of detail changes; a footprint of two axes, as Deliot & Belcour's; and
//! directions drawn from the grains. Here they are drawn from the lobe, and weigh up to g.
//!
//! In f32 on one core (release, `glint::tests::it_costs_this_much`): 60 to 70 ns where no grain is left, 160 to 175 ns for footprints
//! within one spacing, between them 420 to 570 (J = 3), 490 to 640 (J = 5) and up to 970 ns (J = 8).

mod deal;

pub use deal::leaf;

use crate::frame::Vector;
use crate::random::random_words;
use crate::real::Real;
use deal::corners;

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
/// In [0, 4^J]; 1 from N = 2¹⁴·4^J on. Finite for every input; where `h.z` ≤ 0, where D is 0, it is some number in that range.
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
    let (mut ratio, mut level, mut finer) = (footprint / flakes.spacing, 0, R::ONE);
    while level < COARSEST && ratio.to_f64() >= 2.0 {
        (ratio, level, finer) = (ratio * R::HALF, level + 1, finer * R::HALF);
    }
    let share = (ratio - R::ONE).saturate();
    let grain = |level: u32, finer: R| {
        let count = flakes.count / (finer * finer);
        if count.to_f64() >= FINE * f64::from(side * side) {
            return R::ONE;
        }
        let key = cell(position, flakes.spacing, finer, level, flakes.seed);
        interpolated(key, count, resolution, column, row) / count * R::from_f64(f64::from(side * side))
    };
    let near = grain(level, finer);
    if share.to_f64() <= 0.0 {
        return near;
    }
    near * (R::ONE - share) + grain(level + 1, finer * R::HALF) * share
}

/// From so many flakes for each leaf on the lobe has no grain: 2¹⁴.
const FINE: f64 = 16384.0;

/// The coarsest level of detail but one: a footprint of a million spacings.
const COARSEST: u32 = 20;

/// [`leaf`] between the centres of the leaves, at a column and a row in [0, 2^J − 1].
fn interpolated<R: Real>(key: [u32; 4], count: R, resolution: u32, column: R, row: R) -> R {
    let last = (1u32 << resolution) - 2;
    let (i, j) = ((column.to_f64() as u32).min(last), (row.to_f64() as u32).min(last));
    let u = (column - R::from_f64(f64::from(i))).saturate();
    let v = (row - R::from_f64(f64::from(j))).saturate();
    let [a, b, c, d] = corners(key, count, resolution, i, j);
    let (low, high) = (a * (R::ONE - u) + b * u, c * (R::ONE - u) + d * u);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution;

    const ALPHA: f64 = 0.3;

    fn flakes(count: f64, resolution: u32) -> Flakes<f64> {
        Flakes { spacing: 0.01, count, resolution, seed: 7 }
    }

    /// The middle of a cell of side 0.01, far from the borders of all coarser ones.
    fn place(cell: u32) -> Vector<f64> {
        let [x, y, z, _] = random_words([cell, 1, 2, 3]).map(|word| f64::from(word % 1000) - 500.0);
        Vector::new(x + 0.37, y + 0.41, z + 0.43) * 0.01
    }

    /// x with ½(1+erf(x)) = s, by bisection.
    fn slope_of(s: f64) -> f64 {
        let (mut low, mut high) = (-9.0, 9.0);
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if rank(middle) < s { low = middle } else { high = middle }
        }
        low
    }

    /// Two points for each leaf along each axis: g is bilinear about each, so that their mean is its integral.
    fn nodes(resolution: u32) -> Vec<f64> {
        let count = 2 << resolution;
        (0..count).map(|i| ALPHA * slope_of((f64::from(i) + 0.5) / f64::from(count))).collect()
    }

    #[test]
    fn the_lobe_of_every_cell_is_normalised() {
        for (resolution, count) in [(2, 1.0), (3, 0.4), (3, 5.0), (4, 90.0), (4, 700.5)] {
            let (nodes, flakes) = (nodes(resolution), flakes(count, resolution));
            for cell in 0..12 {
                let footprint = 0.004 * 1.7f64.powi(cell as i32);
                let (mut sum, mut seen) = (0.0, [0.0; 3]);
                for (&x, &y) in nodes.iter().flat_map(|x| nodes.iter().map(move |y| (x, y))) {
                    let h = Vector::new(x, y, 1.0);
                    let g = factor(h, ALPHA, &flakes, place(cell), footprint);
                    sum += g;
                    // The facets that a view sees: G₁·(V·m)⁺/(NV·NM), G₁ = min(1, 2·NM·NV/(V·m)).
                    for (seen, theta) in seen.iter_mut().zip([0.4f64, 1.2, 1.56]) {
                        let view = Vector::from_angles(theta, 0.7);
                        let projected = view.dot(h).max(0.0);
                        *seen += g * projected.min(2.0 * view.z) / view.z;
                    }
                }
                let count = (nodes.len() * nodes.len()) as f64;
                // s is known to 1e-15 and g changes by up to 4^J·2^J over [0, 1] in it.
                let tolerance = 1e-14 * f64::from(1u32 << (3 * resolution)) + 1e-12;
                assert!((sum / count - 1.0).abs() < tolerance, "{resolution} {count} {footprint}: {}", sum / count);
                for seen in seen {
                    // A facet weighs up to 2 to a view, and V·m/NV carries its rounding into both facets of a cavity.
                    assert!((seen / count - 1.0).abs() < 1e3 * tolerance, "{resolution} {footprint}: {}", seen / count);
                }
            }
        }
    }

    /// ∫ D·g·cosθ dω itself, over slopes: dω = cos³θ dx dy.
    #[test]
    fn the_measure_is_that_of_the_distribution() {
        const STEPS: i32 = 500;
        let flakes = flakes(1.0, 2);
        for cell in 0..4 {
            let step = 10.0 * ALPHA / f64::from(STEPS);
            let mut sum = 0.0;
            for i in 0..STEPS * STEPS {
                let at = |i: i32| step * (f64::from(i) + 0.5) - 5.0 * ALPHA;
                let h = Vector::new(at(i % STEPS), at(i / STEPS), 1.0);
                let cos_fourth = h.length_squared().powi(-2);
                sum += distribution::beckmann(h, ALPHA) * factor(h, ALPHA, &flakes, place(cell), 0.01) * cos_fourth;
            }
            // The midpoint rule: step²/24 of the mean second derivative; g ≤ 16 bends by 16·4·16·P/α² on 7 lines each way, P
            // by 4/α²: step²/α² = 4e-4 of about 8. Beyond 5α lies 3e-12 of the lobe.
            assert!((sum * step * step - 1.0).abs() < 3e-3, "{}", sum * step * step);
        }
    }

    #[test]
    fn cells_have_the_stated_mean_and_variance() {
        const CELLS: u32 = 40_000;
        let resolution = 3;
        let side = f64::from(1 << resolution);
        // Between the leaves (5, 2) and (6, 3), at .3 and .6.
        let h = Vector::new(slope_of((5.0 + 0.5 + 0.3) / side), slope_of((2.0 + 0.5 + 0.6) / side), 1.0);
        let h = Vector::new(h.x * ALPHA, h.y * ALPHA, h.z);
        let squares = (0.7f64.powi(2) + 0.3f64.powi(2)) * (0.4f64.powi(2) + 0.6f64.powi(2));
        for count in [1.0, 2.0, 16.0, 100.0, 1000.0] {
            let (mut mean, mut second, mut fourth) = (0.0, 0.0, 0.0);
            for cell in 0..CELLS {
                let position = Vector::new(f64::from(cell % 200) + 0.5, f64::from(cell / 200) + 0.5, 0.5) * 0.01;
                let g = factor(h, ALPHA, &flakes(count, resolution), position, 0.01) - 1.0;
                mean += g / f64::from(CELLS);
                second += g * g / f64::from(CELLS);
                fourth += g.powi(4) / f64::from(CELLS);
            }
            let want = (side * side * squares / 2.0 - 1.0) / count;
            let error = ((fourth - second * second) / f64::from(CELLS)).sqrt();
            println!("{count}: mean {mean:.4}, variance {second:.4} of {want:.4}, standard error {error:.4}");
            // Four deviations; ten such numbers stray once in 1600 seeds.
            assert!(mean.abs() < 4.0 * (want / f64::from(CELLS)).sqrt(), "{count}: {mean}");
            assert!((second - want).abs() < 4.0 * error, "{count}: {second} {want} ± {error}");
        }
    }

    /// What the exact sum buys: leaves that are drawn one by one do not add up.
    #[test]
    fn independent_leaves_would_not_conserve() {
        let (cells, leaves) = (2000u32, 64u32);
        let mut second = 0.0;
        for cell in 0..cells {
            // One flake a cell: each leaf has it with the probability 1/64.
            let hit = |leaf: u32| random_words([cell, leaf, 9, 9])[0] < u32::MAX / leaves;
            let total = f64::from((0..leaves).filter(|leaf| hit(*leaf)).count() as u32);
            second += (total - 1.0).powi(2) / f64::from(cells);
        }
        // The deviation of Poisson's law, 1; four standard errors √(3/2000).
        assert!((second - 1.0).abs() < 4.0 * (3.0f64 / 2000.0).sqrt(), "{second}");
    }

    #[test]
    fn it_fades_into_the_lobe() {
        let flakes = flakes(1.0, 3);
        let h = Vector::new(0.1, -0.2, 1.0);
        let mut before = f64::INFINITY;
        for octave in 0..9 {
            // At a whole octave one level alone: N = 4^octave.
            let footprint = 0.01 * f64::from(1u32 << octave);
            let spread =
                (0..4000).map(|cell| (factor(h, ALPHA, &flakes, place(cell) * 300.0, footprint) - 1.0).powi(2));
            let deviation = (spread.sum::<f64>() / 4000.0).sqrt();
            // At most all of the weight on one leaf: 4^J/2.
            let most = (31.0 / f64::from(1u32 << (2 * octave))).sqrt();
            assert!(deviation < before && deviation < 1.1 * most, "{octave}: {deviation} {most}");
            before = deviation;
        }
        for footprint in [1.3e1, 1e3, 1e30, f64::INFINITY] {
            assert_eq!(factor(h, ALPHA, &flakes, place(3), footprint), 1.0);
        }
    }

    #[test]
    fn levels_are_independent() {
        // The first cell of each level, under many seeds.
        let (h, position) = (Vector::new(0.05, 0.1, 1.0), Vector::new(0.001, 0.001, 0.001));
        let (mut product, mut squares) = (0.0, [0.0; 2]);
        for seed in 0..2000 {
            let flakes = Flakes { seed, ..flakes(4.0, 2) };
            let [fine, coarse] = [0.01, 0.02].map(|footprint| factor(h, ALPHA, &flakes, position, footprint) - 1.0);
            product += fine * coarse;
            squares = [squares[0] + fine * fine, squares[1] + coarse * coarse];
        }
        // Four standard errors of a correlation that is 0.
        let correlation = product / (squares[0] * squares[1]).sqrt();
        assert!(correlation.abs() < 4.0 / 2000f64.sqrt(), "{correlation}");
    }

    #[test]
    fn it_changes_no_faster_with_the_footprint_than_stated() {
        let (flakes, h) = (flakes(1.5, 3), Vector::new(0.12, 0.21, 1.0));
        for cell in 0..300 {
            let (mut before, mut at) = (factor(h, ALPHA, &flakes, place(cell), 0.005), 0.005);
            while at < 3.0 {
                let next = at * 1.01;
                let g = factor(h, ALPHA, &flakes, place(cell), next);
                // The side of the finer cell; a step may reach across an octave.
                let side = 0.01 * (at / 0.01).log2().floor().exp2().max(1.0);
                assert!((g - before).abs() <= 64.0 * (next - at) / side + 1e-9, "{cell} {at}: {before} {g}");
                (before, at) = (g, next);
            }
        }
    }

    #[test]
    fn single_precision_is_double_precision() {
        for resolution in [2, 5, 8] {
            for cell in 0..2000 {
                let flakes = flakes(1.0, resolution);
                let [a, b, c, _] = random_words([cell, 8, 8, 8]).map(|word| f64::from(word) / 4_294_967_296.0);
                let (h, footprint) = (Vector::new(a - 0.5, b - 0.5, 1.0).cast::<f32>(), (0.005 + 0.1 * c) as f32);
                let (position, alpha) = (place(cell).cast::<f32>(), ALPHA as f32);
                let single = factor(h, alpha, &flakes.cast(), position, footprint);
                let same = flakes.cast::<f32>().cast::<f64>();
                let double = factor(h.cast(), f64::from(alpha), &same, position.cast(), f64::from(footprint));
                let tolerance = 1e-5 * f64::from(1u32 << (2 * resolution));
                assert!((f64::from(single) - double).abs() < tolerance, "{resolution} {cell}: {single} {double}");
            }
        }
    }

    #[test]
    fn it_is_a_number_whatever_comes() {
        let wild = [0.0f32, -0.0, 1e-38, 1e-4, 0.5, 1.0, -1.0, 1e9, -1e20, f32::MAX, f32::INFINITY, f32::NAN];
        for (i, a) in wild.into_iter().enumerate() {
            for (j, b) in wild.into_iter().enumerate() {
                for (k, c) in wild.into_iter().enumerate() {
                    let flakes = Flakes { spacing: b, count: c, resolution: (i * j + k) as u32, seed: k as u32 };
                    for (flakes, alpha, position, footprint) in [
                        (flakes, 0.3, Vector::new(a, b, c), a),
                        (flakes.cast(), a, Vector::new(1.0, a, 2.0), 0.1),
                        (Flakes { spacing: 0.1, count: 2.0, ..flakes }, c, Vector::new(a, b, c), a),
                    ] {
                        let g = factor(Vector::new(a, c, b), alpha, &flakes, position, footprint);
                        assert!((0.0..=65536.0).contains(&g), "{a} {b} {c}: {g}");
                    }
                }
            }
        }
    }

    #[cfg(feature = "check")]
    #[test]
    fn one_cell_is_plausible() {
        for cell in [1, 2] {
            let flakes = flakes(3.0, 3);
            crate::check::assert_plausible(&crate::check::from_fn("a cell of flakes", 1, move |wi, wo, f| {
                let g = factor(wi + wo, ALPHA, &flakes, place(cell), 0.012);
                f[0] = crate::microfacet::facets(wi, wo, ALPHA).lobe * g;
            }));
        }
    }

    /// `cargo test --release --lib glint::tests::it_costs -- --ignored --nocapture`: nanoseconds a call.
    #[test]
    #[ignore = "a measurement"]
    fn it_costs_this_much() {
        for resolution in [3, 5, 8] {
            for footprint in [0.01f32, 0.045, 0.2, 1.0, 1e4] {
                let flakes = flakes(1.0, resolution).cast::<f32>();
                let (start, mut sum) = (std::time::Instant::now(), 0.0);
                for i in 0..400_000 {
                    let h = Vector::new((i % 512) as f32 * 0.001, (i % 257) as f32 * 0.001, 1.0);
                    sum += factor(h, 0.3, &flakes, Vector::new(i as f32 * 0.003, 0.5, 0.5), footprint);
                }
                let cost = start.elapsed().as_nanos() as f64 / 4e5;
                println!(
                    "J = {resolution}, footprint {:5} spacings: {cost:6.1} ns, mean {:.3}",
                    footprint / 0.01,
                    sum / 4e5
                );
            }
        }
    }
}
