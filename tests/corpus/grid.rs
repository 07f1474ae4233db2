//! Albedos by another method: a product rule in angles, fine enough for lobes that are wide.

use brdf::Vector;
use brdf::check::{Finding, Fixed, Place, Subject, TOLERANCE, Verdict};
use std::f64::consts::{FRAC_PI_2, PI};

/// Points across the polar angle and around.
const POINTS: [usize; 2] = [220, 128];

/// The largest albedo of a channel with one direction fixed.
///
/// Midpoints in φ, which is exponentially accurate for a periodic function, and in x with θ = π/2·(1 − (1−x)³), which crowds the
/// grazing angles where masking bends.
pub(crate) fn albedo(subject: &dyn Subject, theta: f64, phi: f64, fixed: Fixed) -> f64 {
    let at = Vector::from_angles(theta.to_radians(), phi.to_radians());
    let mut sums = vec![0.0; subject.channels()];
    let mut f = vec![0.0; subject.channels()];
    for i in 0..POINTS[0] {
        let rest = 1.0 - (i as f64 + 0.5) / POINTS[0] as f64;
        let polar = FRAC_PI_2 * (1.0 - rest.powi(3));
        let step = FRAC_PI_2 * 3.0 * rest * rest / POINTS[0] as f64;
        let weight = polar.sin() * polar.cos() * step * 2.0 * PI / POINTS[1] as f64;
        for j in 0..POINTS[1] {
            let free = Vector::from_angles(polar, phi.to_radians() + 2.0 * PI * (j as f64 + 0.5) / POINTS[1] as f64);
            match fixed {
                Fixed::View => subject.evaluate(free, at, &mut f),
                Fixed::Light => subject.evaluate(at, free, &mut f),
            }
            for (sum, f) in sums.iter_mut().zip(&f) {
                *sum += f * weight;
            }
        }
    }
    sums.into_iter().fold(f64::NEG_INFINITY, f64::max)
}

/// What the grid may be off by where it is used.
const OFF: f64 = 2e-3;

/// Whether a finding is what the grid finds: at its own angle, and no less than at every fifth degree.
pub(crate) fn agrees(subject: &dyn Subject, fixed: Fixed, finding: &Finding) -> bool {
    let Place::Marginal { theta, phi, .. } = finding.place else { return false };
    // Beyond, a lobe is narrower in azimuth than the grid.
    let here = if theta <= 88.0 { albedo(subject, theta, phi, fixed) } else { finding.value };
    let thetas = (0..11).map(|i| 8.0 * f64::from(i)).chain([84.0]);
    let most = thetas.map(|theta| albedo(subject, theta, phi, fixed)).fold(here, f64::max);
    let off = OFF * most.max(1.0);
    let verdict = match most {
        most if most > 1.0 + TOLERANCE + off => finding.verdict == Verdict::Fail,
        most if most < 1.0 + TOLERANCE - off => finding.verdict == Verdict::Pass,
        _ => true,
    };
    verdict && (finding.value - here).abs() <= off && finding.value >= most - off
}
