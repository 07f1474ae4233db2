//! The terms as the documents and textbooks print them, in f32: what the crate's forms are measured against.

use brdf::Vector;
use std::f32::consts::PI;

/// cosθ of a half vector as a shader takes it: normalise, then the component along the normal.
fn normal_dot(h: Vector<f32>) -> f32 {
    h.z / h.dot(h).sqrt()
}

/// The Fresnel equations, with 1 − F for what is transmitted.
pub(crate) fn dielectric(c: f32, eta: f32) -> [f32; 2] {
    let square = eta * eta - 1.0 + c * c;
    if square < 0.0 {
        return [1.0, 0.0];
    }
    let g = square.sqrt();
    let (rs, rp) = ((c - g) / (c + g), (eta * eta * c - g) / (eta * eta * c + g));
    let f = 0.5 * (rs * rs + rp * rp);
    [f, 1.0 - f]
}

pub(crate) fn conductor(c: f32, n: f32, k: f32) -> [f32; 2] {
    let s2 = 1.0 - c * c;
    let t0 = n * n - k * k - s2;
    let root = (t0 * t0 + 4.0 * n * n * k * k).sqrt();
    let (a, b2) = ((0.5 * (root + t0)).sqrt(), 0.5 * (root - t0));
    let fs = ((a - c) * (a - c) + b2) / ((a + c) * (a + c) + b2);
    let (minus, plus) = (a * c - s2, a * c + s2);
    let fq = (minus * minus + b2 * c * c) / (plus * plus + b2 * c * c);
    let f = 0.5 * fs * (1.0 + fq);
    [f, 1.0 - f]
}

/// Mihaylov, eq. 3.6.
pub(crate) fn conductor_approx(c: f32, n: f32, k: f32) -> f32 {
    let square = n * n + k * k;
    let p = (square * c * c - 2.0 * n * c + 1.0) / (square * c * c + 2.0 * n * c + 1.0);
    let s = (square - 2.0 * n * c + c * c) / (square + 2.0 * n * c + c * c);
    0.5 * (p + s)
}

pub(crate) fn schlick(c: f32, f0: f32) -> [f32; 2] {
    let f = f0 + (1.0 - f0) * (1.0 - c).powf(5.0);
    [f, 1.0 - f]
}

pub(crate) fn schlick_from_indices(c: f32, a: f32, b: f32) -> [f32; 2] {
    schlick(c, ((a - b) / (a + b)).powf(2.0))
}

pub(crate) fn lazanyi_uncorrected(c: f32, n: f32, k: f32) -> f32 {
    ((n - 1.0) * (n - 1.0) + 4.0 * n * (1.0 - c).powf(5.0) + k * k) / ((n + 1.0) * (n + 1.0) + k * k)
}

pub(crate) fn lazanyi(c: f32, n: f32, k: f32, a: f32, e: f32) -> f32 {
    (lazanyi_uncorrected(c, n, k) - a * c * (1.0 - c).powf(e)).max(0.0)
}

/// Beckmann's distribution by cosθ, Elek, App. B.
pub(crate) fn beckmann(h: Vector<f32>, m: f32) -> f32 {
    let c2 = normal_dot(h) * normal_dot(h);
    let tan2 = (1.0 - c2) / c2;
    (-tan2 / (m * m)).exp() / (PI * m * m * c2 * c2)
}

/// Walter et al. 2007, eq. 33, as most shaders have it.
pub(crate) fn ggx(h: Vector<f32>, m: f32) -> f32 {
    let c2 = normal_dot(h) * normal_dot(h);
    let d = c2 * (m * m - 1.0) + 1.0;
    m * m / (PI * d * d)
}

pub(crate) fn blinn(h: Vector<f32>, m: f32) -> f32 {
    normal_dot(h).powf(2.0 / (m * m) - 2.0) / (PI * m * m)
}

pub(crate) fn gaussian(h: Vector<f32>, m: f32, c: f32) -> f32 {
    let angle = normal_dot(h).acos() / m;
    c * (-angle * angle).exp()
}

/// G by the two dot products with a unit half vector, and V as G/(4·NL·NV).
pub(crate) fn v_cavity(wi: Vector<f32>, wo: Vector<f32>) -> [f32; 2] {
    let h = (wi + wo).normalized();
    let vh = wo.dot(h);
    let g = (2.0 * h.z * wo.z / vh).min(2.0 * h.z * wi.z / vh).min(1.0);
    [g, g / (4.0 * wi.z * wo.z)]
}

pub(crate) fn kelemen(wi: Vector<f32>, wo: Vector<f32>) -> [f32; 2] {
    let vh = wo.dot((wi + wo).normalized());
    let v = 1.0 / (4.0 * vh * vh);
    [v * 4.0 * wi.z * wo.z, v]
}

/// Λ of GGX from tan² = (1−c²)/c² and the width in the azimuth of the direction, Heitz 2014, eq. 72 and 80.
fn lambda_ggx(w: Vector<f32>, ax: f32, ay: f32) -> f32 {
    let sin2 = 1.0 - w.z * w.z;
    if sin2 <= 0.0 {
        return 0.0;
    }
    let width2 = (w.x * w.x * ax * ax + w.y * w.y * ay * ay) / sin2;
    ((1.0 + width2 * (sin2 / (w.z * w.z))).sqrt() - 1.0) / 2.0
}

pub(crate) fn smith_ggx(wi: Vector<f32>, wo: Vector<f32>, ax: f32, ay: f32) -> [f32; 2] {
    let g = 1.0 / (1.0 + lambda_ggx(wi, ax, ay) + lambda_ggx(wo, ax, ay));
    [g, g / (4.0 * wi.z * wo.z)]
}

pub(crate) fn smith_ggx_separable(wi: Vector<f32>, wo: Vector<f32>, ax: f32, ay: f32) -> [f32; 2] {
    let g = 1.0 / ((1.0 + lambda_ggx(wi, ax, ay)) * (1.0 + lambda_ggx(wo, ax, ay)));
    [g, g / (4.0 * wi.z * wo.z)]
}

/// Mihaylov, eq. 4.15–4.23 with its errata, by angles.
pub(crate) fn oren_nayar(wi: Vector<f32>, wo: Vector<f32>, sigma: f32) -> [f32; 2] {
    let v = sigma * sigma;
    let (ti, to) = (wi.z.acos(), wo.z.acos());
    let (alpha, beta) = (ti.max(to), ti.min(to));
    let (si, so) = ((1.0 - wi.z * wi.z).sqrt(), (1.0 - wo.z * wo.z).sqrt());
    let c = if si * so > 0.0 { (wi.x * wo.x + wi.y * wo.y) / (si * so) } else { 0.0 };
    let c1 = 1.0 - 0.5 * v / (v + 0.33);
    let dent = if c < 0.0 { (2.0 * beta / PI).powf(3.0) } else { 0.0 };
    let c2 = 0.45 * v / (v + 0.09) * (alpha.sin() - dent);
    let c3 = 0.125 * v / (v + 0.09) * (4.0 * alpha * beta / (PI * PI)).powf(2.0);
    let direct = c1 + c * c2 * beta.tan() + (1.0 - c.abs()) * c3 * (0.5 * (alpha + beta)).tan();
    [direct, 0.17 * v / (v + 0.13) * (1.0 - c * (2.0 * beta / PI).powf(2.0))]
}

pub(crate) fn oren_nayar_qualitative(wi: Vector<f32>, wo: Vector<f32>, sigma: f32, albedo: f32) -> f32 {
    let v = sigma * sigma;
    let (ti, to) = (wi.z.acos(), wo.z.acos());
    let (si, so) = ((1.0 - wi.z * wi.z).sqrt(), (1.0 - wo.z * wo.z).sqrt());
    let c = if si * so > 0.0 { (wi.x * wo.x + wi.y * wo.y) / (si * so) } else { 0.0 };
    let (a, b) = (1.0 - 0.5 * v / (v + 0.57), 0.45 * v / (v + 0.09));
    albedo / PI * (a + b * c.max(0.0) * ti.max(to).sin() * ti.min(to).tan())
}

/// Snell's law as the documents have it: cos² = 1 − sin²/η².
pub(crate) fn cos_t(c: f32, eta: f32) -> f32 {
    (1.0 - (1.0 - c * c) / (eta * eta)).max(0.0).sqrt()
}

pub(crate) fn transmittance(sigma: f32, d: f32, i: f32, o: f32) -> f32 {
    (-sigma * d * (1.0 / i + 1.0 / o)).exp()
}

pub(crate) fn phong(wi: Vector<f32>, wo: Vector<f32>, n: f32) -> f32 {
    let mirrored = Vector::new(-wi.x, -wi.y, wi.z);
    (n + 2.0) / (2.0 * PI) * mirrored.dot(wo).max(0.0).powf(n)
}

pub(crate) fn blinn_phong(wi: Vector<f32>, wo: Vector<f32>, n: f32) -> f32 {
    let factor = (n + 2.0) * (n + 4.0) / (8.0 * PI * (n + 2f32.powf(-n / 2.0)));
    factor * normal_dot(wi + wo).powf(n)
}

/// Elek, eq. 1 with its erratum.
pub(crate) fn torrance_sparrow(wi: Vector<f32>, wo: Vector<f32>, n: f32, k: f32, m: f32) -> f32 {
    let vh = wo.dot((wi + wo).normalized());
    conductor(vh, n, k)[0] * beckmann(wi + wo, m) * v_cavity(wi, wo)[1]
}
