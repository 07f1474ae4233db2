//! Where the terms are measured: points of a low-discrepancy sequence, and what is made of them.

use brdf::Vector;
use std::f64::consts::PI;

/// Coordinates of a point, as many as the term of most arguments takes.
pub(crate) const DIMENSIONS: usize = 13;

/// A point of the unit cube.
pub(crate) type Point = [f64; DIMENSIONS];

/// The point `index` of a low-discrepancy sequence in the unit cube (Roberts 2018, an additive recurrence).
pub(crate) fn point(index: u64) -> Point {
    // The root of x¹⁴ = x + 1.
    const G: f64 = 1.052_710_920_147_558_2;
    let mut step = 1.0;
    [(); DIMENSIONS].map(|()| {
        step /= G;
        // In 2⁻⁶⁴: a product would lose the digits that tell late points apart.
        let step = (step * 18_446_744_073_709_551_616.0) as u64;
        (step.wrapping_mul(index).wrapping_add(1 << 63) >> 11) as f64 * 1.110_223_024_625_156_5e-16
    })
}

/// From `low` to `high`, uniform in the logarithm.
pub(crate) fn log(u: f64, low: f64, high: f64) -> f64 {
    low * (high / low).powf(u)
}

/// Which of `n` equal parts of [0, 1) a number is in, and where in it.
fn part(u: f64, n: u32) -> (u32, f64) {
    let v = u * f64::from(n);
    (v as u32, v.fract())
}

/// A cosine in [1e-6, 1]: half log-spaced, a quarter uniform, a quarter log-spaced below 1, and the end.
pub(crate) fn cosine(u: f64) -> f32 {
    let (kind, v) = part(u, 4);
    let cosine = match kind {
        0 | 1 => log(0.5 * (f64::from(kind) + v), 1e-6, 1.0),
        2 if v < 0.004 => 1.0,
        2 => v,
        _ => 1.0 - log(v, 1e-8, 0.5),
    };
    (cosine as f32).max(1e-6)
}

/// A number of [0, 1], both ends and numbers close to them included.
pub(crate) fn share(u: f64) -> f32 {
    if u < 0.01 { 0.0 } else { cosine((u - 0.01) / 0.99) }
}

/// A relative index of a dielectric in [1/4, 4]: half log-spaced, half at a log-spaced distance from 1.
fn eta(u: f64) -> f32 {
    (match part(u, 4) {
        (0, v) => 1.0 + log(v, 1e-7, 1.0),
        (1, v) => 1.0 - log(v, 1e-7, 0.5),
        _ => log(u * 2.0 - 1.0, 0.25, 4.0),
    }) as f32
}

/// A cosine close to the critical angle of an index below 1, on either side of it.
fn near_critical(n: f32, u: f64) -> f32 {
    let critical = (1.0 - f64::from(n).powi(2)).sqrt();
    let (side, v) = part(u, 2);
    let side = if side == 0 { 1.0 } else { -1.0 };
    ((critical * (1.0 + side * log(v, 1e-8, 0.5))) as f32).clamp(1e-6, 1.0)
}

/// A cosine and a relative index; for half of the indices < 1 the cosine is close to the critical angle.
pub(crate) fn incidence(p: &[f64]) -> Vec<f32> {
    let eta = eta(p[1]);
    let cosine = if eta < 1.0 && p[2] < 0.5 { near_critical(eta, p[0]) } else { cosine(p[0]) };
    vec![cosine, eta]
}

/// A complex index, n in [.02, 8] and κ in [0, 12], with κ = 0, tiny κ and n near 1.
pub(crate) fn index(u: f64, v: f64) -> [f32; 2] {
    let n = match part(u, 8) {
        (0, _) => 1.0,
        (1, v) => 1.0 + log(v, 1e-7, 1.0),
        (2, v) => 1.0 - log(v, 1e-7, 0.5),
        (3, v) => 0.02 + 7.98 * v,
        _ => log(u * 2.0 - 1.0, 0.02, 8.0),
    };
    let k = match part(v, 8) {
        (0, _) => 0.0,
        (1, v) => log(v, 1e-12, 1e-3),
        (2 | 3, _) => 12.0 * (v * 4.0).fract(),
        _ => log(v * 2.0 - 1.0, 1e-3, 12.0),
    };
    [n as f32, k as f32]
}

/// A cosine and a complex index, a quarter of those with n < 1 close to the critical angle of κ = 0.
pub(crate) fn conductor(p: &[f64]) -> Vec<f32> {
    let [n, k] = index(p[1], p[2]);
    let cosine = if n < 1.0 && p[3] < 0.25 { near_critical(n, p[0]) } else { cosine(p[0]) };
    vec![cosine, n, k]
}

/// A width in [1e-4, 1].
pub(crate) fn alpha(u: f64) -> f32 {
    // Rounding must not leave the domain.
    (log(u, 1e-4, 1.0) as f32).clamp(1.0e-4, 1.0)
}

/// A unit direction; some azimuths are those of an axis.
pub(crate) fn direction(cos: f64, turn: f64) -> Vector<f32> {
    let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
    let phi = 2.0 * PI * if turn < 0.05 { (turn * 80.0).floor() / 4.0 } else { turn };
    Vector::<f64>::new(sin * phi.cos(), sin * phi.sin(), cos).cast()
}

/// A direction above the horizon, to a cosine of 1e-6.
pub(crate) fn upper(u: f64, turn: f64) -> Vector<f32> {
    direction(f64::from(cosine(u)), turn)
}

/// A half vector of any length whose tan θ is 1e-3 to 1e4 times `alpha`, at most 1e6.
pub(crate) fn half(alpha: f32, p: &[f64]) -> Vector<f32> {
    let times = if p[0] < 0.7 { log(p[0] / 0.7, 1e-3, 10.0) } else { log(p[0] / 0.3 - 7.0 / 3.0, 1.0, 1e4) };
    let tan = (f64::from(alpha) * times).min(1e6);
    let cos = 1.0 / (1.0 + tan * tan).sqrt();
    let phi = 2.0 * PI * p[1];
    let length = 2.0 * f64::from(cosine(p[2])).max(1e-3);
    (Vector::new(tan * phi.cos(), tan * phi.sin(), 1.0) * (cos * length)).cast()
}

/// Pairs of directions whose half vector lies within a few widths of the normal, and pairs of any directions.
pub(crate) fn pair(alpha: f32, p: &[f64]) -> [Vector<f32>; 2] {
    let wi = upper(p[0], p[1]);
    if p[4] < 0.4 {
        return [wi, upper(p[2], p[3])];
    }
    // wo = wi mirrored about a normal h drawn from the lobe.
    let tan = f64::from(alpha) * log(p[2], 1e-3, 4.0);
    let phi = 2.0 * PI * p[3];
    let h = Vector::new(tan * phi.cos(), tan * phi.sin(), 1.0).normalized();
    let w = wi.cast::<f64>();
    let wo = h * (2.0 * w.dot(h)) - w;
    [wi, if wo.z > 1e-6 { wo.normalized().cast() } else { upper(p[2], p[3]) }]
}

/// Pairs of which a fifth have azimuths close to each other or opposite.
pub(crate) fn diffuse_pair(p: &[f64]) -> [Vector<f32>; 2] {
    let wi = upper(p[0], p[1]);
    let turn = match part(p[4], 10) {
        (0, _) => p[1] + log(p[3], 1e-8, 0.1),
        (1, _) => p[1] + 0.5 + log(p[3], 1e-8, 0.1),
        _ => p[3],
    };
    [wi, upper(p[2], turn.fract())]
}

/// The components of vectors, then further numbers.
pub(crate) fn flat(vectors: &[Vector<f32>], numbers: &[f32]) -> Vec<f32> {
    vectors.iter().flat_map(|v| [v.x, v.y, v.z]).chain(numbers.iter().copied()).collect()
}
