//! Microfacet models, with the terms that belong together and with those that do not.

use crate::{Case, Energy, judge_all, one};
use brdf::check::Cause;
use brdf::{Vector, half_vector};
use std::f64::consts::{FRAC_1_PI, PI};

pub(crate) fn tan_squared(h: Vector<f64>) -> f64 {
    h.sin_squared() / (h.z * h.z)
}

pub(crate) fn beckmann(h: Vector<f64>, alpha: f64) -> f64 {
    let (t, a) = (tan_squared(h), alpha * alpha);
    (1.0 + t) * (1.0 + t) * (-t / a).exp() / (PI * a)
}

pub(crate) fn ggx(h: Vector<f64>, alpha: f64) -> f64 {
    let (s, n, a) = (h.sin_squared(), h.length_squared(), alpha * alpha);
    let q = s / n + h.z * h.z / n * a;
    a / (PI * q * q)
}

/// GGX with a width along each tangent.
pub(crate) fn ggx_anisotropic(h: Vector<f64>, ax: f64, ay: f64) -> f64 {
    let n = h.length_squared();
    let q = (h.x / ax).powi(2) + (h.y / ay).powi(2) + h.z * h.z;
    n * n / (PI * ax * ay * q * q)
}

/// G/(4 NL NV), Smith's height-correlated form for GGX.
pub(crate) fn smith(wi: Vector<f64>, wo: Vector<f64>, ax: f64, ay: f64) -> f64 {
    let g = |v: Vector<f64>| ((ax * v.x).powi(2) + (ay * v.y).powi(2) + v.z * v.z).sqrt();
    0.5 / (wi.z * g(wo) + wo.z * g(wi))
}

/// G₁ of Smith for GGX.
pub(crate) fn g1(v: Vector<f64>, alpha: f64) -> f64 {
    2.0 * v.z / (v.z + (v.z * v.z + alpha * alpha * v.sin_squared()).sqrt())
}

/// G/(4 NL NV) of the V-cavity.
pub(crate) fn v_cavity(wi: Vector<f64>, wo: Vector<f64>) -> f64 {
    let h = half_vector(wi, wo);
    let (low, high) = (wi.z.min(wo.z), wi.z.max(wo.z));
    0.5 / (high * (2.0 * low).max(h.length_squared() / (2.0 * h.z)))
}

pub(crate) fn schlick(wi: Vector<f64>, wo: Vector<f64>, f0: f64) -> f64 {
    let vh = 0.5 * half_vector(wi, wo).length_squared().sqrt();
    f0 + (1.0 - f0) * (1.0 - vh).max(0.0).powi(5)
}

pub(crate) fn ggx_smith(alpha: f64) -> impl Fn(Vector<f64>, Vector<f64>) -> f64 + Send + Sync {
    move |wi, wo| ggx(half_vector(wi, wo), alpha) * smith(wi, wo, alpha, alpha)
}

pub(crate) fn torrance_sparrow(alpha: f64) -> impl Fn(Vector<f64>, Vector<f64>) -> f64 + Send + Sync {
    move |wi, wo| beckmann(half_vector(wi, wo), alpha) * v_cavity(wi, wo)
}

#[test]
fn terms_that_belong_together_pass() {
    let mut cases: Vec<Case> = Vec::new();
    // D·G of one surface, F = 1: a share of the visible facets' light, at most 1.
    for alpha in [1e-4, 1e-3, 0.01, 0.1, 0.3, 1.0] {
        cases.push(one(format!("GGX Smith α={alpha}"), ggx_smith(alpha)).energy(Energy::Pass));
        cases.push(one(format!("Torrance–Sparrow α={alpha}"), torrance_sparrow(alpha)));
    }
    for (ax, ay) in [(0.05, 0.5), (0.001, 0.1), (0.3, 0.6)] {
        cases.push(one(format!("anisotropic GGX {ax} × {ay}"), move |wi, wo| {
            ggx_anisotropic(half_vector(wi, wo), ax, ay) * smith(wi, wo, ax, ay)
        }));
    }
    // G₁·G₁ is less than the height-correlated G.
    cases.push(one("GGX Smith separable α=.5", |wi, wo| {
        ggx(half_vector(wi, wo), 0.5) * g1(wi, 0.5) * g1(wo, 0.5) / (4.0 * wi.z * wo.z)
    }));
    cases.push(one("GGX Schlick F₀=.04 α=.2", |wi, wo| ggx_smith(0.2)(wi, wo) * schlick(wi, wo, 0.04)));
    // Known: ≤ .991.
    cases.push(
        one("GGX Kelemen α=.5", |wi, wo| {
            let h = half_vector(wi, wo);
            ggx(h, 0.5) / h.length_squared()
        })
        .energy(Energy::Grid),
    );
    cases.push(one("GGX Kelemen α=.1", |wi, wo| {
        let h = half_vector(wi, wo);
        ggx(h, 0.1) / h.length_squared()
    }));
    // A weight of 0.04 below, 0.96 above, sum 1: energy of a mixture.
    cases.push(one("Lambert ∕ GGX mixture", |wi, wo| 0.5 * FRAC_1_PI + 0.5 * ggx_smith(1e-3)(wi, wo)));
    judge_all(&cases);
}

#[test]
fn terms_that_do_not_fail() {
    judge_all(&[
        one("GGX without G α=.1", |wi, wo| ggx(half_vector(wi, wo), 0.1) / (4.0 * wi.z * wo.z))
            .reaches(29.0)
            .cause(Cause::Unmasked),
        // The mask of smoother facets hides too little.
        one("GGX α=.8, G of α=.1", |wi, wo| ggx(half_vector(wi, wo), 0.8) * smith(wi, wo, 0.1, 0.1)).grid(),
        one("Cook–Torrance, π for 4, α=.3", |wi, wo| torrance_sparrow(0.3)(wi, wo) * 4.0 / PI)
            .energy(Energy::Fail(4.0 / PI, 0.01))
            .cause(Cause::PiForQuarter),
        // Schlick–GGX with k = α/2 for image lighting and k = (r+1)²/8 for lights: the former is no less than Smith's G.
        one("UE4 GGX r=.5", |wi, wo| {
            let (alpha, k) = (0.25, 1.5 * 1.5 / 8.0);
            let g = |c: f64| 1.0 / (c * (1.0 - k) + k);
            ggx(half_vector(wi, wo), alpha) * g(wi.z) * g(wo.z) / 4.0
        })
        .grid(),
        one("Implicit G α=.3", |wi, wo| ggx(half_vector(wi, wo), 0.3) / 4.0).grid(),
        one("Neumann G α=.3", |wi, wo| ggx(half_vector(wi, wo), 0.3) / (4.0 * wi.z.max(wo.z))).grid(),
        one("Ashikhmin–Premože α=.3", |wi, wo| ggx(half_vector(wi, wo), 0.3) / (4.0 * (wi.z + wo.z - wi.z * wo.z)))
            .grid(),
    ]);
}
