//! Helmholtz reciprocity: f(wi, wo) = f(wo, wi).

use super::pairs::{Class, climb};
use super::report::{Check, Finding, Place};
use super::subject::Subject;
use super::verdict::Verdict;
use crate::frame::{Frame, Vector};

/// The relative difference that counts as rounding.
///
/// A formula of some tens of operations that is not arranged symmetrically differs by ~1e-14 between its two orders. 1e-9
/// leaves room for a condition number of 1e5. Where a lobe is steeper than that its condition is measured, see
/// [`reciprocity`].
pub const TOLERANCE: f64 = 1e-9;

/// Below this f, in sr⁻¹, differences are absolute: a millionth of a white Lambert surface's 1/π.
pub const FLOOR: f64 = 3e-7;

/// Half ULPs that a subject's directions may be off by on the way to f: the roundings of a normalisation, a half vector and
/// a scalar product, three components each.
const ROUNDINGS: f64 = 32.0;

struct Comparison<'a> {
    subject: &'a dyn Subject,
    forth: Vec<f64>,
    back: Vec<f64>,
    evaluations: usize,
}

impl Comparison<'_> {
    /// The largest relative difference over the channels, where f is finite, and its channel.
    fn difference(&mut self, wi: Vector<f64>, wo: Vector<f64>) -> (f64, usize) {
        self.fill(wi, wo, false);
        self.fill(wo, wi, true);
        self.largest(|f, g| (f - g).abs() / f.abs().max(g.abs()).max(FLOOR))
    }

    fn fill(&mut self, wi: Vector<f64>, wo: Vector<f64>, back: bool) {
        let f = if back { &mut self.back } else { &mut self.forth };
        f.fill(0.0);
        self.subject.evaluate(wi, wo, f);
        self.evaluations += 1;
    }

    fn largest(&self, difference: impl Fn(f64, f64) -> f64) -> (f64, usize) {
        let mut worst = (0.0, 0);
        for (channel, (&f, &g)) in self.forth.iter().zip(&self.back).enumerate() {
            if f.is_finite() && g.is_finite() {
                let d = difference(f, g);
                if d > worst.0 {
                    worst = (d, channel);
                }
            }
        }
        worst
    }

    /// What [`ROUNDINGS`] half ULPs of either direction do to f at this pair, relatively.
    ///
    /// Measured by moving the directions by just that, not by a derivative: where the half vector nearly vanishes, f bends
    /// within 1e-13.
    fn rounding(&mut self, wi: Vector<f64>, wo: Vector<f64>) -> f64 {
        const STEP: f64 = ROUNDINGS * 0.5 * f64::EPSILON;
        let mut steepest = 0.0f64;
        for turn in 0..6 {
            let shift = |v: Vector<f64>, on: bool| {
                let frame = Frame::from_normal(v);
                // The third is along the direction: a subject may rely on its length in one order only.
                let axis = [frame.tangent, frame.bitangent, frame.normal][turn % 3];
                if on { v + axis * STEP } else { v }
            };
            self.fill(wi, wo, false);
            self.fill(shift(wi, turn < 3), shift(wo, turn >= 3), true);
            steepest = steepest.max(self.largest(|f, g| (f - g).abs() / f.abs().max(g.abs()).max(FLOOR)).0);
        }
        steepest
    }
}

/// Compares both orders of `samples` pairs of each [`Class`], then climbs from the worst ones.
///
/// The difference of a pair is |f − g| / max(|f|, |g|, [`FLOOR`]), and a violation if it exceeds [`TOLERANCE`] and also
/// what the rounding of the directions can do there, by f's measured sensitivity to them. Returns the finding and the numbers
/// of evaluations, pairs and restarts.
pub fn reciprocity(subject: &dyn Subject, samples: usize, seed: u32) -> (Finding, [usize; 3]) {
    const RESTARTS: usize = 4;
    const STEPS: u32 = 200;
    let n = subject.channels();
    let mut comparison = Comparison { subject, forth: vec![0.0; n], back: vec![0.0; n], evaluations: 0 };
    // The worst excess over what rounding explains, per class.
    let mut worst: Vec<(f64, Vector<f64>, Vector<f64>)> = Vec::new();
    let mut violations = 0;
    let mut rounding_only = 0.0f64;
    for class in Class::ALL {
        let mut best: Option<(f64, Vector<f64>, Vector<f64>)> = None;
        for i in 0..samples {
            let (wi, wo) = class.pair(i, seed);
            let (difference, _) = comparison.difference(wi, wo);
            if difference > TOLERANCE {
                let rounding = comparison.rounding(wi, wo);
                if difference > rounding {
                    violations += 1;
                } else {
                    rounding_only = rounding_only.max(difference);
                    continue;
                }
            }
            if best.is_none_or(|(d, ..)| difference > d) {
                best = Some((difference, wi, wo));
            }
        }
        worst.extend(best);
    }
    worst.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut top = worst.first().copied();
    for (i, &(_, wi, wo)) in worst.iter().take(RESTARTS).enumerate() {
        let (pair, difference) = climb((wi, wo), seed ^ i as u32, STEPS, |a, b| {
            let (difference, _) = comparison.difference(a, b);
            if difference > TOLERANCE && difference <= comparison.rounding(a, b) { 0.0 } else { difference }
        });
        if top.is_none_or(|(d, ..)| difference > d) {
            top = Some((difference, pair.0, pair.1));
        }
    }
    let (value, wi, wo) = top.unwrap_or((0.0, Vector::new(0.0, 0.0, 1.0), Vector::new(0.0, 0.0, 1.0)));
    let (value, wi, wo) = rounded(&mut comparison, value, wi, wo);
    let (_, channel) = comparison.difference(wi, wo);
    let [f, g] = [&comparison.forth, &comparison.back].map(|f| f.get(channel).copied().unwrap_or(0.0));
    let verdict = if value > TOLERANCE { Verdict::Fail } else { Verdict::Pass };
    let mut note = String::new();
    if verdict == Verdict::Fail {
        note = format!(
            "f={f:.6e}, swapped {g:.6e}, differ by {:.1e} sr⁻¹; {violations} sampled pairs violate",
            (f - g).abs()
        );
        if cosine_is_in(subject, samples.min(512), seed) {
            note.push_str("; f/cos is reciprocal: the subject seems to return f·cos");
        }
    } else if rounding_only > TOLERANCE {
        note = format!("up to {rounding_only:.1e} where rounding of the directions explains it");
    }
    let finding = Finding {
        verdict,
        value,
        limit: TOLERANCE,
        place: if value > 0.0 { Place::Pair { wi, wo } } else { Place::Everywhere },
        channel: (value > 0.0).then(|| (channel, subject.channel_name(channel))),
        note,
        ..Finding::new(Check::Reciprocity)
    };
    (finding, [comparison.evaluations, samples * Class::ALL.len(), RESTARTS])
}

/// The pair with whole degrees, if it violates as well, else with tenths, else as it is.
fn rounded(
    comparison: &mut Comparison<'_>,
    value: f64,
    wi: Vector<f64>,
    wo: Vector<f64>,
) -> (f64, Vector<f64>, Vector<f64>) {
    for step in [5.0, 1.0, 0.1] {
        let [a, b] = [wi, wo].map(|v| {
            let round = |degrees: f64| ((degrees / step).round() * step).to_radians();
            let theta = round(v.sin_squared().sqrt().atan2(v.z).to_degrees());
            Vector::from_angles(theta, round(v.y.atan2(v.x).to_degrees()))
        });
        if a.z > 1e-6 && b.z > 1e-6 {
            let (difference, _) = comparison.difference(a, b);
            if value > TOLERANCE && difference > 0.5 * value {
                return (difference, a, b);
            }
        }
    }
    (value, wi, wo)
}

/// Whether f/cos_i is symmetric where f is not: the sign of a subject that returns f·cos.
fn cosine_is_in(subject: &dyn Subject, samples: usize, seed: u32) -> bool {
    let n = subject.channels();
    let (mut f, mut g) = (vec![0.0; n], vec![0.0; n]);
    (0..samples).all(|i| {
        let (wi, wo) = Class::Hemisphere.pair(i, seed);
        subject.evaluate(wi, wo, &mut f);
        subject.evaluate(wo, wi, &mut g);
        f.iter().zip(&g).all(|(f, g)| {
            let (f, g) = (f / wi.z, g / wo.z);
            (f - g).abs() <= 1e-7 * f.abs().max(g.abs()).max(FLOOR)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::super::corpus::*;
    use super::*;
    use crate::frame::half_vector;

    #[test]
    fn symmetric_models_pass() {
        for subject in [lambert(), torrance_sparrow(0.001), torrance_sparrow(0.3), ggx_smith(0.01), ggx_smith(1.0)] {
            let (finding, _) = reciprocity(&subject, 512, 3);
            assert_eq!(finding.verdict, Verdict::Pass, "{finding}");
        }
        // The half vector normalised and the distribution through 1 − NH²: the same function, rounded worse.
        let clumsy = one("clumsy GGX", |wi, wo| {
            let h = half_vector(wo, wi).normalized();
            let nh = h.z;
            let a = 1e-4;
            let q = 1.0 + (a - 1.0) * nh * nh;
            a / (core::f64::consts::PI * q * q) * (1.0 - (1.0 - wi.dot(h)).powi(5)) * smith(wi, wo, 0.01)
        });
        let (finding, _) = reciprocity(&clumsy, 512, 3);
        assert_eq!(finding.verdict, Verdict::Pass, "{finding}");
    }

    #[test]
    fn asymmetric_models_fail() {
        let slightly = one("slightly", |wi, wo| 0.3 * (1.0 + 1e-6 * wi.z * wo.z * wo.z));
        let narrowly = one("narrowly", |wi, wo| {
            let h = half_vector(wi, wo);
            ggx(h, 1e-3) * smith(wi, wo, 1e-3) * (1.0 + 1e-3 * wi.z)
        });
        for subject in [slightly, narrowly] {
            let (finding, _) = reciprocity(&subject, 512, 3);
            assert_eq!(finding.verdict, Verdict::Fail, "{finding}");
        }
        let shaded = one("f·cos", |wi, wo| ggx(half_vector(wi, wo), 0.3) * smith(wi, wo, 0.3) * wi.z);
        let (finding, _) = reciprocity(&shaded, 512, 3);
        assert!(finding.note.contains("f·cos"), "{finding}");
    }
}
