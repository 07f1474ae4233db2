//! Gradient noise, and the fractal sums of it that rust, patina and scratches are made of.
//!
//! Perlin 2002, "Improving Noise": a lattice of unit cells, at each corner one of twelve gradients, those to the edges of a cube; between
//! them a fade whose first and second derivative are 0 at the corners, so that noise has two continuous derivatives. Which
//! gradient a corner has is a hash of its place and a seed ([`random_words`]), in place of a permutation table: integers, and
//! therefore the same lattice to the bit in every precision and in WGSL; no table to bind; no period below 2³² cells.
//!
//! Noise of a surface is noise of space at its points: no seams and no parametrisation. In two dimensions pass z = 0 (and not another
//! whole number: there too the noise is that of a plane of corners, 0 at each of them).
//!
//! Coordinates are in [−2³¹, 2³¹]; in f32 the noise is smooth up to about 10⁴, past which the spacing of the coordinates shows. What
//! is not finite counts as a corner: 0.

use crate::frame::Vector;
use crate::random::random_words;
use crate::real::Real;

/// 1/1.0363538 less 1.4e-6, the room that rounding in f32 takes: the sum before it has 1.0363538 for its least upper bound.
const SCALE: f64 = 63_237.0 / 65_536.0;
/// How far each octave is shifted against the one below, in cells: without it all octaves are 0 where the first one is.
const SHIFT: Vector<f64> = Vector::new(391.0 / 1024.0, 633.0 / 1024.0, 241.0 / 1024.0);
/// An octave more would be below the spacing of f64 in one cell of the first.
const MOST_OCTAVES: u32 = 32;

/// Gradient noise at a point, in [−1, 1].
///
/// $$n(p) = s\sum_{c\in\{0,1\}^3} g_c\cdot(f - c)\prod_i w(c_i, f_i),\qquad w(0, t) = 1 - w(1, t),\; w(1, t) = t^3(10 - 15t + 6t^2)$$
///
/// In plain text: the eight corners' g·(f − c), f = p − ⌊p⌋, mixed by the fade 6t⁵ − 15t⁴ + 10t³ along each axis; s = 0.96492.
/// The weights w are those of corner c.
///
/// * 0 at every lattice point, with the slope s·g there; of mean 0 over all seeds.
/// * Without s the least upper bound is the maximum over f of Σ w·(the two largest |f_i − c_i|), 1.0363538 at (0.355, 0.481, 0.5).
///
/// Source: Perlin 2002, "Improving Noise"; the hash is Jarzynski & Olano 2020.
#[inline]
pub fn gradient<R: Real>(p: Vector<R>, seed: u32) -> R {
    let cell = Cell::new(p, seed);
    mixed(cell.heights(), cell.share.map(fade)) * R::from_f64(SCALE)
}

/// The slope of [`gradient`]: its derivatives along x, y and z.
///
/// In plain text: the corners' gradients mixed as the heights are, plus the slope of the fade, 30t²(1 − t)², times the difference of
/// the heights across the cell.
///
/// Each component is in [−3.62, 3.62]. What tilts the normal of a surface (Mihaylov 2013, §3.3.1), without the three evaluations and the
/// step of a difference: [`bump::tilted`](crate::texture::bump::tilted).
#[inline]
pub fn gradient_slope<R: Real>(p: Vector<R>, seed: u32) -> Vector<R> {
    let cell = Cell::new(p, seed);
    let [a, b, c, d, e, f, g, h] = cell.heights();
    let [u, v, w] = cell.share.map(fade);
    let [du, dv, dw] = cell.share.map(fade_slope);
    let [x, y, z] = cell.gradients();
    let along = |corners: [R; 8], difference: R| (mixed(corners, [u, v, w]) + difference) * R::from_f64(SCALE);
    Vector::new(
        along(x, du * flat_mixed([b - a, d - c, f - e, h - g], v, w)),
        along(y, dv * flat_mixed([c - a, d - b, g - e, h - f], u, w)),
        along(z, dw * flat_mixed([e - a, f - b, g - c, h - d], u, v)),
    )
}

/// Fractal noise: octaves of [`gradient`] noise, each finer and weaker than the one before.
///
/// $$\sum_{k<\text{octaves}} a\,\text{gain}^k\; n_k(p\,\nu\,\text{lacunarity}^k)$$
///
/// In plain text: Σ amplitude·gainᵏ·gradient(p·frequency·lacunarityᵏ + k·shift, seed + k).
///
/// * `amplitude`, `frequency`, `octaves`: Mihaylov 2013, §4.3. There `gain` is 1/2 and `lacunarity` 2.
/// * In ± amplitude·(1 − gainᵒᶜᵗᵃᵛᵉˢ)/(1 − gain) for gain in [0, 1); with one octave amplitude·gradient(p·frequency, seed).
/// * More than 32 octaves count as 32, none give 0.
///
/// Source: Perlin 1985; Musgrave 1989 for the names.
#[inline]
pub fn fractal<R: Real>(
    p: Vector<R>,
    seed: u32,
    amplitude: R,
    frequency: R,
    octaves: u32,
    gain: R,
    lacunarity: R,
) -> R {
    let mut sum = R::ZERO;
    each_octave(p, [amplitude, frequency], octaves, [gain, lacunarity], |k, place, amplitude, _| {
        sum = sum + amplitude * gradient(place, seed.wrapping_add(k));
    });
    sum
}

/// The slope of [`fractal`] noise: its derivatives along x, y and z.
///
/// In plain text: Σ amplitude·gainᵏ·frequency·lacunarityᵏ·gradient_slope(the octave's point). With gain·lacunarity = 1 every octave is as steep as
/// the first.
#[inline]
pub fn fractal_slope<R: Real>(
    p: Vector<R>,
    seed: u32,
    amplitude: R,
    frequency: R,
    octaves: u32,
    gain: R,
    lacunarity: R,
) -> Vector<R> {
    let mut sum = Vector::new(R::ZERO, R::ZERO, R::ZERO);
    each_octave(p, [amplitude, frequency], octaves, [gain, lacunarity], |k, place, amplitude, frequency| {
        sum = sum + gradient_slope(place, seed.wrapping_add(k)) * (amplitude * frequency);
    });
    sum
}

/// Ridged fractal noise: [`fractal`] of 1 − |n|, whose ridges lie where the noise is 0: wandering lines, as cracks are.
///
/// In plain text: Σ amplitude·gainᵏ·(1 − |gradient(p·frequency·lacunarityᵏ + k·shift, seed + k)|).
///
/// In [0, amplitude·(1 − gainᵒᶜᵗᵃᵛᵉˢ)/(1 − gain)]. The crest of a ridge is sharp: the slope changes its sign there. Straight lines are those of [`super::scratch`]. Points stretched
/// along an axis (divide that coordinate) give the documents' brushed look (Mihaylov 2013, §3.1.4).
///
/// Source: Musgrave 1994, "ridged multifractal", without its feedback from one octave to the next.
#[inline]
pub fn ridged<R: Real>(p: Vector<R>, seed: u32, amplitude: R, frequency: R, octaves: u32, gain: R, lacunarity: R) -> R {
    let mut sum = R::ZERO;
    each_octave(p, [amplitude, frequency], octaves, [gain, lacunarity], |k, place, amplitude, _| {
        sum = sum + amplitude * (R::ONE - gradient(place, seed.wrapping_add(k)).abs());
    });
    sum
}

/// Calls for each octave with its number, its point, its amplitude and its frequency.
#[inline]
fn each_octave<R: Real>(
    p: Vector<R>,
    [mut amplitude, mut frequency]: [R; 2],
    octaves: u32,
    [gain, lacunarity]: [R; 2],
    mut octave: impl FnMut(u32, Vector<R>, R, R),
) {
    for k in 0..octaves.min(MOST_OCTAVES) {
        let shift = SHIFT.cast::<R>() * R::from_f64(f64::from(k));
        octave(k, p * frequency + shift, amplitude, frequency);
        (amplitude, frequency) = (amplitude * gain, frequency * lacunarity);
    }
}

/// The cell of a point. Corners are in order of x, then y, then z.
struct Cell<R> {
    /// Where in the cell the point lies, in [0, 1] along each axis.
    share: [R; 3],
    /// The gradients at the corners.
    corners: [R; 24],
}

impl<R: Real> Cell<R> {
    #[inline(always)]
    fn new(p: Vector<R>, seed: u32) -> Self {
        let p = [p.x, p.y, p.z];
        let cell = p.map(R::floor);
        // Just below a whole number the difference rounds to 1; of an infinity it is NaN, which becomes 0.
        let share = core::array::from_fn(|i| (p[i] - cell[i]).saturate());
        Cell { share, corners: R::at_cell(cell, |cell| gradients(cell, seed)) }
    }

    /// The x, y and z of the gradients at the eight corners.
    #[inline(always)]
    fn gradients(&self) -> [[R; 8]; 3] {
        core::array::from_fn(|axis| core::array::from_fn(|corner| self.corners[3 * corner + axis]))
    }

    /// What the gradient of each corner gives at the point.
    #[inline(always)]
    fn heights(&self) -> [R; 8] {
        let [x, y, z] = self.share;
        let [gx, gy, gz] = self.gradients();
        core::array::from_fn(|corner| {
            let from = |share: R, axis: usize| if corner >> axis & 1 == 1 { share - R::ONE } else { share };
            gx[corner] * from(x, 0) + gy[corner] * from(y, 1) + gz[corner] * from(z, 2)
        })
    }
}

/// The gradients at the corners of a cell.
#[inline(always)]
fn gradients(cell: [i32; 3], seed: u32) -> [f64; 24] {
    let [x, y, z] = cell.map(i32::cast_unsigned);
    // All hashes before the first lookup: the compiler then takes several at once.
    let mut words = [0; 8];
    for corner in 0..8u32 {
        let [dx, dy, dz] = [corner & 1, (corner >> 1) & 1, corner >> 2];
        let place = [x.wrapping_add(dx), y.wrapping_add(dy), z.wrapping_add(dz), seed];
        [words[corner as usize], ..] = random_words(place);
    }
    let mut gradients = [0.0; 24];
    for corner in 0..8 {
        // In [0, 12).
        let edge = EDGES[(((words[corner] >> 16) * 12) >> 16) as usize];
        for axis in 0..3 {
            gradients[3 * corner + axis] = f64::from(edge[axis]);
        }
    }
    gradients
}

/// The directions to the edges of the cube [−1, 1]³.
const EDGES: [[f32; 3]; 12] = [
    [0.0, 1.0, 1.0],
    [0.0, -1.0, 1.0],
    [0.0, 1.0, -1.0],
    [0.0, -1.0, -1.0],
    [1.0, 0.0, 1.0],
    [-1.0, 0.0, 1.0],
    [1.0, 0.0, -1.0],
    [-1.0, 0.0, -1.0],
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
    [1.0, -1.0, 0.0],
    [-1.0, -1.0, 0.0],
];

/// 6t⁵ − 15t⁴ + 10t³.
#[inline(always)]
fn fade<R: Real>(t: R) -> R {
    t * t * t * (t * (t * R::from_f64(6.0) - R::from_f64(15.0)) + R::from_f64(10.0))
}

/// 30t²(1 − t)².
#[inline(always)]
fn fade_slope<R: Real>(t: R) -> R {
    let product = t * (R::ONE - t);
    R::from_f64(30.0) * product * product
}

/// a + t(b − a).
#[inline(always)]
fn between<R: Real>(a: R, b: R, t: R) -> R {
    a + t * (b - a)
}

#[inline(always)]
fn flat_mixed<R: Real>([a, b, c, d]: [R; 4], s: R, t: R) -> R {
    between(between(a, b, s), between(c, d, s), t)
}

#[inline(always)]
fn mixed<R: Real>([a, b, c, d, e, f, g, h]: [R; 8], [u, v, w]: [R; 3]) -> R {
    between(flat_mixed([a, b, c, d], u, v), flat_mixed([e, f, g, h], u, v), w)
}

#[cfg(test)]
#[path = "noise_tests.rs"]
mod tests;
