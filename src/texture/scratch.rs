//! Scratches: thin straight grooves of finite length, strewn at random.
//!
//! Where noise is 0 there are lines, but they wander ([`noise::ridged`](super::noise::ridged)). A tool that slips leaves a straight
//! groove. Here each is where the surface cuts a flat ellipsoid: a disc of random direction in each cell of a lattice, whole within its
//! cell. As with noise there are no seams and no parametrisation, and the same discs to the bit in every precision and in WGSL.
//!
//! Coordinates are in [−2³¹, 2³¹]; what is not finite counts as smooth: 0.

use crate::frame::Vector;
use crate::random::random_words;
use crate::real::Real;

/// How far each layer is shifted against the one before, in cells: as octaves of noise are.
const SHIFT: Vector<f64> = Vector::new(391.0 / 1024.0, 633.0 / 1024.0, 241.0 / 1024.0);
/// The radius of a disc in cells: with its centre within ⅛ of the cell's along each axis it stays inside.
const RADIUS: f64 = 0.375;
/// The least width that counts: below it no coordinate in f32 would meet a disc.
const LEAST_WIDTH: f64 = 1.0 / 65_536.0;
/// As many as 64 layers leave nothing to scratch.
const MOST_LAYERS: u32 = 64;

/// How deep scratches are at a point: 0 between them, 1 in the middle of one.
///
/// $$\max_k\;\mathrm{saturate}\Bigl(1 - \frac{|q_k|^2}{r^2} - \frac{(q_k\cdot n_k)^2}{w^2}\Bigr)$$
///
/// In plain text: the largest over layers k of saturate(1 − |q|²/r² − (q·n)²/w²), q = p + k·shift − c from the centre c of the disc
/// in its cell, r = 3/8, n the unit normal of the disc.
///
/// * `p`: the point, in cells. A scratch is up to ¾ of a cell long, and shallower and narrower towards its ends.
/// * `density` in [0, 1]: the share of cells that have a disc, 0 for none.
/// * `width`: half the width of a scratch in its middle, in cells; from 2⁻¹⁶ to 3/8, and clamped there.
/// * `layers`: how many lattices of discs are laid over one another, at most 64.
///
/// In [0, 1] and continuous, with a slope of at most 2/r + 2/w.
#[inline]
pub fn scratches<R: Real>(p: Vector<R>, seed: u32, density: R, width: R, layers: u32) -> R {
    let width = width.max(R::from_f64(LEAST_WIDTH)).min(R::from_f64(RADIUS));
    let mut deepest = R::ZERO;
    for k in 0..layers.min(MOST_LAYERS) {
        let place = p + SHIFT.cast::<R>() * R::from_f64(f64::from(k));
        deepest = deepest.max(scratch(place, seed.wrapping_add(k), density, width));
    }
    deepest
}

/// The scratch of the cell that a point is in.
#[inline(always)]
fn scratch<R: Real>(p: Vector<R>, seed: u32, density: R, width: R) -> R {
    let p = [p.x, p.y, p.z];
    let cell = p.map(R::floor);
    let [nx, ny, nz, x, y, z, draw] = R::at_cell(cell, |cell| disc(cell.map(i32::cast_unsigned), seed));
    // Just below a whole number the difference rounds to 1; of an infinity it is NaN, which becomes 0: outside every disc.
    let share = [0, 1, 2].map(|i: usize| (p[i] - cell[i]).saturate());
    let q = Vector::new(share[0] - x, share[1] - y, share[2] - z);
    let n = Vector::new(nx, ny, nz);
    let off = q.x * n.x + q.y * n.y + q.z * n.z;
    let off = off * off / (n.x * n.x + n.y * n.y + n.z * n.z);
    let from = q.x * q.x + q.y * q.y + q.z * q.z;
    let depth = R::ONE - from * R::from_f64(1.0 / (RADIUS * RADIUS)) - off / (width * width);
    R::select(draw.lt(density), depth.saturate(), R::ZERO)
}

/// The disc of a cell: a normal of any length, the centre, and a number in [0, 1) that decides whether there is one. Exact in f32.
#[inline(always)]
fn disc([x, y, z]: [u32; 3], seed: u32) -> [f64; 7] {
    let [a, b, c, d] = random_words([x, y, z, seed]);
    // Odd numbers: no normal is 0.
    let odd = |byte: u32| f64::from(2 * (byte & 255) + 1) - 256.0;
    let [nx, ny, nz] = [a, b, c].map(|word| odd(word >> 24));
    let [x, y, z] = [a, b, c].map(|word| 0.5 + odd(word >> 16) / 2048.0);
    [nx, ny, nz, x, y, z, f64::from(d >> 8) / 16_777_216.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a low-discrepancy sequence in 40³ cells about the origin.
    fn points(count: u32) -> impl Iterator<Item = Vector<f64>> {
        let steps = [0.819_172_513_396_164_4, 0.671_043_606_703_789_3, 0.549_700_477_901_970_3];
        (0..count).map(move |i| {
            let [x, y, z] = steps.map(|step| ((f64::from(i) + 0.5) * step).fract() * 40.0 - 20.0);
            Vector::new(x, y, z)
        })
    }

    #[test]
    fn the_middle_is_deepest_and_the_ends_are_shallow() {
        for cell in [[0, 0, 0], [3, -2, 7], [-1, -1, -1]] {
            let [nx, ny, nz, x, y, z, _] = disc(cell.map(i32::cast_unsigned), 5);
            let [i, j, k] = cell.map(f64::from);
            let middle = Vector::new(i + x, j + y, k + z);
            let depth = |p: Vector<f64>| scratches(p, 5, 1.0, 0.05, 1);
            // The place rounds in units of up to 8.
            assert!((depth(middle) - 1.0).abs() < 1e-12);
            let n = Vector::new(nx, ny, nz) * (1.0 / (nx * nx + ny * ny + nz * nz).sqrt());
            // Along the disc a parabola that ends at its radius; across it one that ends at its half width.
            let along = n.cross(Vector::new(0.0, 0.0, 1.0));
            let along = along * (1.0 / along.dot(along).sqrt());
            for t in [0.1, 0.2, 0.3, 0.37] {
                assert!((depth(middle + along * t) - (1.0 - (t / 0.375f64).powi(2))).abs() < 1e-12, "{cell:?} {t}");
                let across = 0.05 * t;
                let want = 1.0 - (across / 0.375f64).powi(2) - (across / 0.05f64).powi(2);
                assert!((depth(middle + n * across) - want).abs() < 1e-12, "{cell:?} {t}");
            }
            assert_eq!([along * 0.376, n * 0.0501].map(|aside| depth(middle + aside)), [0.0; 2]);
        }
    }

    #[test]
    fn what_is_scratched_is_the_volume_of_the_ellipsoids() {
        // 4π/3·a·b·c with the axes r, r and 1/√(1/r² + 1/w²), times the density. Independent points: 5 standard deviations of the share.
        const COUNT: u32 = 200_000;
        for (density, width) in [(1.0, 0.3), (0.5, 0.3), (1.0, 0.05), (0.0, 0.3)] {
            let hits = points(COUNT).filter(|p| scratches(*p, 9, density, width, 1) > 0.0).count();
            let r: f64 = 0.375;
            let volume = 4.0 / 3.0 * core::f64::consts::PI * r * r / (r.powi(-2) + width.powi(-2)).sqrt();
            let want = density * volume;
            let spread = (want * (1.0 - want) / f64::from(COUNT)).sqrt();
            // Whether a cell has a disc is one draw for each of 40³ cells.
            let drawn = (density * (1.0 - density) / 64_000.0).sqrt() * volume;
            let share = hits as f64 / f64::from(COUNT);
            assert!((share - want).abs() <= 5.0 * (spread + drawn), "{density} {width}: {share} {want}");
        }
    }

    #[test]
    fn layers_only_add() {
        for p in points(5_000) {
            let mut before = 0.0;
            for layers in 0..6 {
                let depth = scratches(p, 3, 0.7, 0.1, layers);
                assert!((before..=1.0).contains(&depth), "{p:?} {layers}: {before} {depth}");
                before = depth;
            }
        }
    }

    #[test]
    fn slopes_are_bounded_across_cells_too() {
        let (width, step) = (0.04, 1e-4);
        let most = 2.0 / RADIUS + 2.0 / width;
        for p in points(20_000) {
            // Onto a face of a cell and to both sides of it, and from any point on.
            for p in [p, Vector::new(p.x.round() - 0.5 * step, p.y, p.z)] {
                for by in [Vector::new(step, 0.0, 0.0), Vector::new(0.0, step, 0.0), Vector::new(0.0, 0.0, step)] {
                    let [a, b] = [p, p + by].map(|p| scratches(p, 1, 1.0, width, 3));
                    assert!((a - b).abs() <= most * step + 1e-12, "{p:?}: {a} {b}");
                }
            }
        }
    }

    #[test]
    fn nothing_panics_and_what_is_not_finite_is_smooth() {
        for wild in [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e300, -1e300, 0.0, -1.0] {
            let p = Vector::new(wild, 0.5, 0.5);
            let depth = scratches(p, 0, 1.0, 0.1, 4);
            assert!((0.0..=1.0).contains(&depth) && (wild.is_finite() || depth == 0.0), "{wild}: {depth}");
            for (density, width) in [(wild, 0.1), (1.0, wild)] {
                let depth = scratches(Vector::new(0.4, 0.5, 0.6), 0, density, width, u32::MAX);
                assert!((0.0..=1.0).contains(&depth), "{density} {width}: {depth}");
            }
        }
    }
}
