//! Helmholtz reciprocity: f(wi, wo) = f(wo, wi).

use super::pairs::{self, Class, climb};
use super::report::{Check, Finding, Place};
use super::subject::{Pair, Subject};
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

/// Pairs that are compared at once.
const BLOCK: usize = 256;

/// A subject compared with itself, the directions swapped.
pub(super) struct Comparison<'a> {
    subject: &'a dyn Subject,
    channels: usize,
    pub(super) evaluations: usize,
}

/// The two values of the channel that differs most, and by how much.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Difference {
    pub(super) relative: f64,
    pub(super) channel: usize,
    pub(super) forth: f64,
    pub(super) back: f64,
}

impl<'a> Comparison<'a> {
    pub(super) fn new(subject: &'a dyn Subject) -> Self {
        Comparison { subject, channels: subject.channels().max(1), evaluations: 0 }
    }

    fn evaluate(&mut self, pairs: &[Pair]) -> Vec<f64> {
        let mut f = vec![0.0; pairs.len() * self.channels];
        self.subject.evaluate_many(pairs, &mut f);
        self.evaluations += pairs.len();
        f
    }

    /// The largest relative difference over the channels, where both are finite.
    fn largest(forth: &[f64], back: &[f64]) -> Difference {
        let mut worst = Difference::default();
        for (channel, (&f, &g)) in forth.iter().zip(back).enumerate() {
            let relative = (f - g).abs() / f.abs().max(g.abs()).max(FLOOR);
            if f.is_finite() && g.is_finite() && relative > worst.relative {
                worst = Difference { relative, channel, forth: f, back: g };
            }
        }
        worst
    }

    /// The difference at each pair.
    pub(super) fn differences(&mut self, pairs: &[Pair]) -> Vec<Difference> {
        let both: Vec<Pair> = pairs.iter().copied().chain(pairs.iter().map(|&(wi, wo)| (wo, wi))).collect();
        let f = self.evaluate(&both);
        let (forth, back) = f.split_at(pairs.len() * self.channels);
        forth
            .chunks_exact(self.channels)
            .zip(back.chunks_exact(self.channels))
            .map(|(f, g)| Self::largest(f, g))
            .collect()
    }

    fn difference(&mut self, pair: Pair) -> Difference {
        self.differences(&[pair]).pop().unwrap_or_default()
    }

    /// What [`ROUNDINGS`] half ULPs of either direction do to f at each pair, relatively.
    ///
    /// Measured by moving the directions by just that, not by a derivative: where the half vector nearly vanishes, f bends
    /// within 1e-13.
    fn roundings(&mut self, pairs: &[Pair]) -> Vec<f64> {
        const STEP: f64 = ROUNDINGS * 0.5 * f64::EPSILON;
        const TURNS: usize = 7;
        let mut moved = Vec::with_capacity(TURNS * pairs.len());
        for &(wi, wo) in pairs {
            moved.push((wi, wo));
            for turn in 0..TURNS - 1 {
                let shift = |v: Vector<f64>, on: bool| {
                    let frame = Frame::from_normal(v);
                    // The third is along the direction: a subject may rely on its length in one order only.
                    let axis = [frame.tangent, frame.bitangent, frame.normal][turn % 3];
                    if on { v + axis * STEP } else { v }
                };
                moved.push((shift(wi, turn < 3), shift(wo, turn >= 3)));
            }
        }
        let f = self.evaluate(&moved);
        let n = self.channels;
        f.chunks_exact(TURNS * n)
            .map(|f| {
                let (still, moved) = f.split_at(n);
                moved.chunks_exact(n).fold(0.0, |most, f| Self::largest(still, f).relative.max(most))
            })
            .collect()
    }

    /// The difference at each pair, and what of it rounding explains: a violation is 0 and the difference, else the other way
    /// round.
    pub(super) fn judged(&mut self, pairs: &[Pair]) -> Vec<(Difference, f64)> {
        let differences = self.differences(pairs);
        let doubtful: Vec<usize> = (0..pairs.len()).filter(|&i| differences[i].relative > TOLERANCE).collect();
        let mut explained = vec![0.0; pairs.len()];
        if !doubtful.is_empty() {
            let chosen: Vec<Pair> = doubtful.iter().map(|&i| pairs[i]).collect();
            for (&i, rounding) in doubtful.iter().zip(self.roundings(&chosen)) {
                if differences[i].relative <= rounding {
                    explained[i] = differences[i].relative;
                }
            }
        }
        differences.into_iter().zip(explained).collect()
    }
}

/// Compares both orders of `samples` pairs of each [`Class`], then climbs from the worst ones.
///
/// The difference of a pair is |f − g| / max(|f|, |g|, [`FLOOR`]), and a violation if it exceeds [`TOLERANCE`] and also
/// what the rounding of the directions can do there, by f's measured sensitivity to them. Returns the finding and the numbers
/// of evaluations, pairs and restarts.
pub fn reciprocity(subject: &dyn Subject, samples: usize, seed: u32) -> (Finding, [usize; 3]) {
    const RESTARTS: usize = 4;
    const GENERATIONS: u32 = 30;
    let mut comparison = Comparison::new(subject);
    // The worst excess over what rounding explains, per class.
    let mut worst: Vec<(f64, Pair)> = Vec::new();
    let mut violations = 0;
    let mut rounding_only = 0.0f64;
    for class in Class::ALL {
        let mut best: Option<(f64, Pair)> = None;
        for block in (0..samples).step_by(BLOCK) {
            let pairs: Vec<Pair> = (block..samples.min(block + BLOCK)).map(|i| class.pair(i, seed)).collect();
            for ((difference, explained), pair) in comparison.judged(&pairs).into_iter().zip(pairs) {
                let difference = difference.relative;
                if explained > 0.0 {
                    rounding_only = rounding_only.max(explained);
                    continue;
                }
                violations += usize::from(difference > TOLERANCE);
                if best.is_none_or(|(d, ..)| difference > d) {
                    best = Some((difference, pair));
                }
            }
        }
        worst.extend(best);
    }
    worst.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut top = worst.first().copied();
    for (i, &(_, pair)) in worst.iter().take(RESTARTS).enumerate() {
        let (pair, difference) = climb(pair, seed ^ i as u32, GENERATIONS, |pairs, values| {
            for (value, (difference, explained)) in values.iter_mut().zip(comparison.judged(pairs)) {
                *value = if explained > 0.0 { 0.0 } else { difference.relative };
            }
        });
        if top.is_none_or(|(d, ..)| difference > d) {
            top = Some((difference, pair));
        }
    }
    let normal = Vector::new(0.0, 0.0, 1.0);
    let (value, pair) = top.unwrap_or((0.0, (normal, normal)));
    let (value, (wi, wo)) = rounded(&mut comparison, value, pair);
    let Difference { channel, forth: f, back: g, .. } = comparison.difference((wi, wo));
    let verdict = if value > TOLERANCE { Verdict::Fail } else { Verdict::Pass };
    let mut note = String::new();
    if verdict == Verdict::Fail {
        note = format!(
            "f={f:.6e}, swapped {g:.6e}, differ by {:.1e} sr⁻¹; {violations} sampled pairs violate",
            (f - g).abs()
        );
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
fn rounded(comparison: &mut Comparison<'_>, value: f64, pair: Pair) -> (f64, Pair) {
    for round in pairs::rounder(pair) {
        let difference = comparison.difference(round).relative;
        if value > TOLERANCE && difference > 0.5 * value {
            return (difference, round);
        }
    }
    (value, pair)
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
    }
}
