//! Limits in which a model must become another one, and identities that its terms obey. For tests of one's own.
//!
//! ```
//! use brdf::check::{limits, Verdict};
//!
//! // GGX with Smith's masking keeps the projected area of what is visible: Heitz 2014, eq. 23.
//! let alpha = 0.3;
//! let furnace = limits::weak_white_furnace(
//!     |h| brdf::distribution::ggx(h, alpha),
//!     |v, _h| 2.0 * v.z / (v.z + (v.z * v.z + alpha * alpha * (1.0 - v.z * v.z)).sqrt()),
//!     &[0.0, 45.0, 80.0],
//!     1,
//! );
//! assert_eq!(furnace.verdict, Verdict::Pass, "{furnace}");
//! ```

use super::energy::{Albedo, Effort, albedo};
use super::family::{Family, Parameter};
use super::pairs::{Class, turned};
use super::report::{Check, Finding, Place};
use super::subject::{Fixed, Pair, Subject, from_fn};
use super::verdict::{TOLERANCE, Verdict};
use super::{Cause, Options, Profile};
use crate::frame::Vector;

/// The relative difference that a limit may be missed by: parameters at a limit are rarely exact, and the forms for either
/// side cancel differently.
pub const AGREEMENT: f64 = 1e-5;

/// Below this f, in sr⁻¹, differences are absolute.
const FLOOR: f64 = 1e-3;

/// Whether two subjects are the same function, at `samples` pairs of each class: a stack whose coat has the index 1 and its
/// base, a conductor of κ = 0 and a dielectric.
///
/// The value is the largest |f − g|/max(|f|, |g|, 1e-3 sr⁻¹) over pairs where both are finite; it fails above `tolerance`, for
/// which [`AGREEMENT`] is meant. Fails as well where one is finite and the other is not, and where their channels differ.
pub fn agreement(a: &dyn Subject, b: &dyn Subject, samples: usize, seed: u32, tolerance: f64) -> Finding {
    let mut worst = Worst::default();
    if a.channels() != b.channels() {
        let note = format!("{} channels against {}", a.channels(), b.channels());
        return Finding { verdict: Verdict::Fail, note, ..Finding::new(Check::Limit) };
    }
    for class in Class::ALL {
        let pairs: Vec<Pair> = (0..samples).map(|i| class.pair(i, seed)).collect();
        worst.compare(&pairs, &values(a, &pairs), &values(b, &pairs));
    }
    worst.finding(a, tolerance, format!("{} against {}", a.name(), b.name()))
}

/// Whether f is unchanged by a common rotation of both directions about the normal: what an anisotropic model must be where
/// its two widths are equal.
///
/// As [`agreement`] of the subject with itself, turned.
pub fn isotropy(subject: &dyn Subject, samples: usize, seed: u32) -> Finding {
    let mut worst = Worst::default();
    for class in Class::ALL {
        let pairs: Vec<Pair> = (0..samples).map(|i| class.pair(i, seed)).collect();
        let turn = |(i, &(wi, wo)): (usize, &Pair)| {
            let angle = 2.399_963_229_728_653 * (i + 1) as f64;
            (turned(wi, angle), turned(wo, angle))
        };
        // A rotation rounds: where the half vector nearly vanishes that is much, and no anisotropy.
        let turned: Vec<Pair> = pairs.iter().enumerate().map(turn).collect();
        worst.compare(&pairs, &values(subject, &pairs), &values(subject, &turned));
    }
    worst.finding(subject, AGREEMENT, "turned about the normal".into())
}

/// ∫ D(h)·cosθ_h dω_h = 1 of a distribution of normals, given as a subject whose `wi` is the normal and whose `wo` does not
/// matter. Returns the finding and the number of evaluations.
pub fn normalisation(distribution: &dyn Subject, seed: u32) -> (Finding, usize) {
    let found = albedo(distribution, 0.0, 0.0, Fixed::View, &Effort { seed, ..EFFORT });
    let evaluations = found.evaluations;
    (unity(Check::Normalisation, [found]), evaluations)
}

/// Heitz's weak white furnace: ∫ G₁(v, h)·max(v·h, 0)·D(h)/v.z dω_h = 1 for every view v, whatever the roughness.
///
/// `d` is the distribution of normals, `g1` the masking of a view and a normal; both are functions of local unit directions above
/// the horizon. Holds if and only if D and G belong together: G of another α, or of another D, misses it. The value is the integral
/// that is farthest from 1; `thetas` are the polar angles of the views in degrees.
///
/// Source: Heitz 2014, "Understanding the masking-shadowing function in microfacet-based BRDFs", eq. 23.
pub fn weak_white_furnace(
    d: impl Fn(Vector<f64>) -> f64 + Sync,
    g1: impl Fn(Vector<f64>, Vector<f64>) -> f64 + Sync,
    thetas: &[f64],
    seed: u32,
) -> Finding {
    let visible = from_fn("visible normals", 1, |h: Vector<f64>, v: Vector<f64>, f: &mut [f64]| {
        let facing = h.dot(v);
        f[0] = if h.z > 0.0 && facing > 0.0 { d(h) * g1(v, h) * facing / (v.z * h.z) } else { 0.0 };
    });
    let effort = Effort { seed, ..EFFORT };
    unity(Check::Normalisation, thetas.iter().map(|&theta| albedo(&visible, theta, 0.0, Fixed::View, &effort)))
}

const EFFORT: Effort = Effort { target: 2e-5, evaluations: 200_000, replicates: 16, samples: 1024, seed: 1 };

/// The integral farthest from 1, judged from both sides.
fn unity(check: Check, integrals: impl IntoIterator<Item = Albedo>) -> Finding {
    let mut finding = Finding { limit: 1.0 + TOLERANCE, ..Finding::new(check) };
    let mut farthest = -1.0;
    for found in integrals {
        for (channel, (&value, &error)) in found.value.iter().zip(&found.error).enumerate() {
            let away = (value - 1.0).abs();
            if away > farthest {
                farthest = away;
                finding.verdict = Verdict::of(away, error, 0.0, TOLERANCE);
                if finding.verdict == Verdict::Pass && (!found.agrees || found.non_finite > 0) {
                    finding.verdict = Verdict::Inconclusive;
                }
                (finding.value, finding.error) = (value, error);
                finding.place = Place::Marginal { theta: found.theta, phi: found.phi, fixed: found.fixed };
                finding.channel = Some((channel, String::new()));
            }
        }
    }
    finding
}

fn values(subject: &dyn Subject, pairs: &[Pair]) -> Vec<f64> {
    let mut f = vec![0.0; pairs.len() * subject.channels()];
    subject.evaluate_many(pairs, &mut f);
    f
}

/// The largest difference so far, its channel and its pair.
#[derive(Default)]
struct Worst(Option<(f64, usize, Pair)>);

impl Worst {
    fn compare(&mut self, pairs: &[Pair], f: &[f64], g: &[f64]) {
        let n = (f.len() / pairs.len().max(1)).max(1);
        for ((&pair, f), g) in pairs.iter().zip(f.chunks_exact(n)).zip(g.chunks_exact(n)) {
            for (channel, (&f, &g)) in f.iter().zip(g).enumerate() {
                let difference = match (f.is_finite(), g.is_finite()) {
                    (true, true) => (f - g).abs() / f.abs().max(g.abs()).max(FLOOR),
                    (false, false) => 0.0,
                    _ => f64::INFINITY,
                };
                if self.0.is_none_or(|(worst, ..)| difference > worst) {
                    self.0 = Some((difference, channel, pair));
                }
            }
        }
    }

    fn finding(self, subject: &dyn Subject, tolerance: f64, note: String) -> Finding {
        let Some((value, channel, (wi, wo))) = self.0 else { return Finding::new(Check::Limit) };
        Finding {
            verdict: if value > tolerance { Verdict::Fail } else { Verdict::Pass },
            value,
            limit: tolerance,
            place: Place::Pair { wi, wo },
            channel: Some((channel, subject.channel_name(channel))),
            note,
            ..Finding::new(Check::Limit)
        }
    }
}

/// Whether what stands before the letter of an axis may name a width: nothing does not, nor what names coordinates.
fn is_width(stem: &str) -> bool {
    // Whole words: `stretch_x` is a width, though it has an `st` in it.
    let coordinates = ["tex", "texcoord", "coord", "coords", "uv", "st", "pos", "position", "offset"];
    !stem.is_empty() && !stem.split('_').any(|word| coordinates.contains(&word))
}

/// The parameters of a family at which it must be isotropic: two widths that are equal (names that end in x and y, or in u
/// and v; alone those are coordinates), an anisotropy of 0.
fn isotropic_limits(parameters: &[Parameter]) -> Vec<Vec<f64>> {
    let defaults: Vec<f64> = parameters.iter().map(|parameter| parameter.default).collect();
    let mut limits = Vec::new();
    for (i, a) in parameters.iter().enumerate() {
        let name = a.name.to_lowercase();
        if name.starts_with("aniso") && a.low <= 0.0 && a.high >= 0.0 {
            let mut values = defaults.clone();
            values[i] = 0.0;
            limits.push(values);
        }
        for (j, b) in parameters.iter().enumerate().skip(i + 1) {
            let other = b.name.to_lowercase();
            let along = [("x", "y"), ("u", "v")]
                .into_iter()
                .any(|(x, y)| name.strip_suffix(x).is_some_and(|s| is_width(s) && other.strip_suffix(y) == Some(s)));
            let (low, high) = (a.low.max(b.low), a.high.min(b.high));
            if along && low <= high {
                for share in [0.25, 0.9] {
                    let mut values = defaults.clone();
                    values[i] = low + share * (high - low);
                    values[j] = values[i];
                    limits.push(values);
                }
            }
        }
    }
    limits
}

/// What the names of a family's parameters promise: nothing, or one finding about isotropy.
pub(super) fn of_family(family: &dyn Family, options: &Options<'_>) -> Option<Finding> {
    let parameters = family.parameters();
    let found = isotropic_limits(parameters).into_iter().map(|values| {
        let mut finding = isotropy(&*family.subject(&values), 64, options.seed);
        let names = parameters.iter().map(|parameter| parameter.name.clone());
        finding.parameters = names.zip(values).collect();
        finding
    });
    let mut worst = found.reduce(|a, b| if b.value > a.value { b } else { a })?;
    worst.binding = options.profile == Profile::Strict;
    if worst.verdict == Verdict::Fail {
        worst.cause = Cause::AnisotropicLimit.text().into();
    }
    Some(worst)
}

#[cfg(test)]
mod tests {
    use super::super::corpus::{beckmann, ggx, ggx_smith, lambert, one};
    use super::super::family::Scale;
    use super::*;

    #[test]
    fn terms_that_belong_together_pass_the_furnace() {
        let g1 = |alpha: f64| {
            move |v: Vector<f64>, _: Vector<f64>| {
                2.0 * v.z / (v.z + (v.z * v.z + alpha * alpha * v.sin_squared()).sqrt())
            }
        };
        let thetas = [0.0, 30.0, 60.0, 85.0];
        for alpha in [0.01, 0.1, 0.5, 1.0] {
            let finding = weak_white_furnace(|h| ggx(h, alpha), g1(alpha), &thetas, 3);
            assert_eq!(finding.verdict, Verdict::Pass, "{finding}");
        }
        // Another α in G, another D, and the V-cavity's G₁ with any D.
        assert_eq!(weak_white_furnace(|h| ggx(h, 0.5), g1(0.25), &thetas, 3).verdict, Verdict::Fail);
        assert_eq!(weak_white_furnace(|h| beckmann(h, 0.5), g1(0.5), &thetas, 3).verdict, Verdict::Fail);
        let cavity = |v: Vector<f64>, h: Vector<f64>| (2.0 * h.z * v.z / v.dot(h)).min(1.0);
        let finding = weak_white_furnace(|h| beckmann(h, 0.5), cavity, &thetas, 3);
        assert_eq!(finding.verdict, Verdict::Pass, "{finding}");
    }

    #[test]
    fn distributions_are_normalised_or_not() {
        let d = one("D", |h, _| ggx(h, 0.2));
        assert_eq!(normalisation(&d, 1).0.verdict, Verdict::Pass);
        let unscaled = one("πD", |h, _| core::f64::consts::PI * ggx(h, 0.2));
        let finding = normalisation(&unscaled, 1).0;
        assert!(finding.verdict == Verdict::Fail && (finding.value - core::f64::consts::PI).abs() < 1e-3, "{finding}");
    }

    #[test]
    fn limits_by_name() {
        let parameter =
            |name: &str| Parameter { name: name.into(), low: 0.0, high: 1.0, default: 0.5, scale: Scale::Linear };
        let named =
            |names: &[&str]| isotropic_limits(&names.iter().map(|name| parameter(name)).collect::<Vec<_>>()).len();
        assert_eq!(named(&["alpha_x", "alpha_y", "tint"]), 2);
        assert_eq!(named(&["nu", "rs", "nv"]), 2);
        assert_eq!(named(&["u", "v"]), 0);
        assert_eq!(named(&["tex_u", "tex_v"]), 0);
        assert_eq!(named(&["stretch_x", "stretch_y"]), 2);
        assert_eq!(named(&["anisotropic"]), 1);
        assert_eq!(named(&["roughness", "f0", "max"]), 0);
    }

    #[test]
    fn rotations_and_twins() {
        assert_eq!(isotropy(&ggx_smith(0.05), 64, 1).verdict, Verdict::Pass);
        let brushed = one("brushed", |wi, wo| 0.2 + 0.1 * wi.x * wo.x);
        assert_eq!(isotropy(&brushed, 64, 1).verdict, Verdict::Fail);
        assert_eq!(agreement(&lambert(), &lambert(), 64, 1, AGREEMENT).verdict, Verdict::Pass);
        assert_eq!(agreement(&lambert(), &brushed, 64, 1, AGREEMENT).verdict, Verdict::Fail);
    }
}
