//! BRDFs whose verdicts are known, for the tests of the checker. Written here in f64, apart from the crate's own terms.

use super::subject::{FromFn, from_fn};
use crate::frame::{Vector, half_vector};
use core::f64::consts::{FRAC_1_PI, PI};

pub(super) type Function = Box<dyn Fn(Vector<f64>, Vector<f64>, &mut [f64]) + Send + Sync>;

/// A one-channel subject, 0 below the horizon.
pub(super) fn one(
    name: &str,
    f: impl Fn(Vector<f64>, Vector<f64>) -> f64 + Send + Sync + 'static,
) -> FromFn<Function> {
    from_fn(
        name,
        1,
        Box::new(move |wi: Vector<f64>, wo: Vector<f64>, out: &mut [f64]| {
            out[0] = if wi.z > 0.0 && wo.z > 0.0 { f(wi, wo) } else { 0.0 };
        }) as Function,
    )
}

pub(super) fn tan_squared(h: Vector<f64>) -> f64 {
    h.sin_squared() / (h.z * h.z)
}

pub(super) fn beckmann(h: Vector<f64>, alpha: f64) -> f64 {
    let (t, a) = (tan_squared(h), alpha * alpha);
    (1.0 + t) * (1.0 + t) * (-t / a).exp() / (PI * a)
}

pub(super) fn ggx(h: Vector<f64>, alpha: f64) -> f64 {
    let (s, a) = (h.sin_squared(), alpha * alpha);
    let n = h.length_squared();
    let q = s / n + h.z * h.z / n * a;
    a / (PI * q * q)
}

/// G/(4 NL NV) of the V-cavity.
pub(super) fn v_cavity(wi: Vector<f64>, wo: Vector<f64>) -> f64 {
    let h = half_vector(wi, wo);
    let (low, high) = (wi.z.min(wo.z), wi.z.max(wo.z));
    0.5 / (high * (2.0 * low).max(h.length_squared() / (2.0 * h.z)))
}

/// G/(4 NL NV) of Smith's height-correlated form for GGX.
pub(super) fn smith(wi: Vector<f64>, wo: Vector<f64>, alpha: f64) -> f64 {
    let a = alpha * alpha;
    let g = |v: Vector<f64>| (a + (1.0 - a) * v.z * v.z).sqrt();
    0.5 / (wi.z * g(wo) + wo.z * g(wi))
}

pub(super) fn schlick(wi: Vector<f64>, wo: Vector<f64>, f0: f64) -> f64 {
    let vh = 0.5 * half_vector(wi, wo).length_squared().sqrt();
    f0 + (1.0 - f0) * (1.0 - vh).powi(5)
}

pub(super) fn lambert() -> FromFn<Function> {
    one("Lambert", |_, _| FRAC_1_PI)
}

pub(super) fn torrance_sparrow(alpha: f64) -> FromFn<Function> {
    one(&format!("Torrance–Sparrow α={alpha}"), move |wi, wo| {
        beckmann(half_vector(wi, wo), alpha) * v_cavity(wi, wo)
    })
}

pub(super) fn ggx_smith(alpha: f64) -> FromFn<Function> {
    one(&format!("GGX Smith α={alpha}"), move |wi, wo| ggx(half_vector(wi, wo), alpha) * smith(wi, wo, alpha))
}
