//! Directional albedos, by the crate's own judge, and maxima over a grid.

use brdf::Vector;
use brdf::check::{self, Effort, Fixed};

/// ∫ f·cos dω with one direction at `theta` degrees, `f(wi, wo)` in sr⁻¹.
///
/// # Panics
///
/// If the integral is not clear to 1e-3 of albedos above 1: such a number must not enter a record.
pub(crate) fn albedo(theta: f64, fixed: Fixed, f: impl Fn(Vector<f64>, Vector<f64>) -> f64 + Sync) -> f64 {
    let subject = check::from_fn("a printed form", 1, |wi, wo, out| {
        out[0] = if wi.z > 0.0 && wo.z > 0.0 { f(wi, wo) } else { 0.0 };
    });
    let result = check::albedo(&subject, theta, 0.0, fixed, &Effort { samples: 256, ..Effort::default() });
    let value = result.value[0];
    assert!(result.agrees && result.error[0] < 1e-3 * value.abs().max(1.0), "unclear integral: {result:?}");
    value
}

/// The same for what a light from one direction leaves in a shader, π·f·NL.
pub(crate) fn albedo_of_radiance(
    theta: f64,
    fixed: Fixed,
    radiance: impl Fn(Vector<f64>, Vector<f64>) -> f64 + Sync,
) -> f64 {
    albedo(theta, fixed, |wi, wo| radiance(wi, wo) / (std::f64::consts::PI * wi.z))
}

/// A direction from angles in degrees.
pub(crate) fn direction(theta: f64, phi: f64) -> Vector<f64> {
    Vector::from_angles(theta.to_radians(), phi.to_radians())
}

/// The largest |f(c)| over cosines in [0, 1], and its angle in degrees.
pub(crate) fn worst_cosine(f: impl Fn(f64) -> f64) -> (f64, f64) {
    let steps = 20_000;
    (0..=steps).map(|i| f64::from(i) / f64::from(steps)).fold((0.0, 0.0), |worst, c| {
        let value = f(c).abs();
        if value > worst.0 { (value, c.acos().to_degrees()) } else { worst }
    })
}

/// The least and the largest value over cosines in [0, 1].
pub(crate) fn range_over_cosines(f: impl Fn(f64) -> f64) -> (f64, f64) {
    let steps = 20_000;
    (0..=steps)
        .map(|i| f(f64::from(i) / f64::from(steps)))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
}

/// The least and the largest value over pairs with both polar angles up to `limit` degrees.
pub(crate) fn range_over_pairs(limit: f64, f: impl Fn(Vector<f64>, Vector<f64>) -> f64) -> (f64, f64) {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for i in 0..=45 {
        for o in 0..=45 {
            for azimuth in 0..=18 {
                let wi = direction(limit * f64::from(i) / 45.0, 0.0);
                let wo = direction(limit * f64::from(o) / 45.0, 10.0 * f64::from(azimuth));
                let value = f(wi, wo);
                (low, high) = (low.min(value), high.max(value));
            }
        }
    }
    (low, high)
}
