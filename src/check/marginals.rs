//! The search for the direction that reflects most: corners, then uphill between them, then a round number.

use super::energy::{Albedo, Effort, albedo};
use super::report::{Check, Finding, Place};
use super::subject::{Fixed, Subject};
use super::verdict::{TOLERANCE, Verdict};
use core::sync::atomic::{AtomicUsize, Ordering};
use rayon::prelude::*;

/// Polar angles, in degrees, that every check integrates at: models fail at the normal, or towards grazing.
pub const THETAS: [f64; 10] = [0.0, 45.0, 60.0, 75.0, 80.0, 85.0, 88.0, 89.0, 89.5, 89.9];

/// Azimuths, in degrees, for a subject that was measured to be anisotropic.
pub(super) const AZIMUTHS: [f64; 3] = [0.0, 90.0, 35.0];

/// The widest gap between angles, in degrees, that is not looked into: total reflection at a rough interface makes bumps of
/// about 10°.
const STEP: f64 = 3.0;

/// What a look into a gap costs: enough for some percent.
const GLANCE: Effort = Effort { target: 1e-2, evaluations: 1_500, replicates: 0, samples: 0, seed: 1 };

/// Albedo is continuous in θ: what stays below this at every angle that was looked at is not searched any closer.
const WORTH_CLIMBING: f64 = 0.7;

/// Where to integrate, and how hard.
pub(super) struct Plan<'a> {
    pub(super) thetas: &'a [f64],
    pub(super) azimuths: &'a [f64],
    pub(super) effort: Effort,
    pub(super) progress: Option<&'a (dyn Fn(usize, usize) + Sync)>,
}

/// Energy of both marginals: a finding each, and every albedo at a corner.
pub(super) fn energy(subject: &dyn Subject, plan: &Plan<'_>) -> (Vec<Finding>, Vec<Albedo>, usize) {
    let mut jobs = Vec::new();
    for fixed in Fixed::BOTH {
        for &phi in plan.azimuths {
            jobs.extend(plan.thetas.iter().map(|&theta| (theta, phi, fixed)));
        }
    }
    // Bumps between the corners become corners, and two refinements follow.
    let glances: Vec<(f64, f64, Fixed)> = Fixed::BOTH
        .iter()
        .flat_map(|&fixed| plan.azimuths.iter().map(move |&phi| (phi, fixed)))
        .flat_map(|(phi, fixed)| gaps(plan.thetas).into_iter().map(move |theta| (theta, phi, fixed)))
        .collect();
    let seen: Vec<Albedo> =
        glances.par_iter().map(|&(theta, phi, fixed)| albedo(subject, theta, phi, fixed, &GLANCE)).collect();
    let bumps: Vec<(f64, f64, Fixed)> = seen
        .chunk_by(|a, b| (a.fixed, a.phi) == (b.fixed, b.phi))
        .filter_map(|row| row.iter().reduce(|a, b| if b.peak().1 > a.peak().1 { b } else { a }))
        .filter(|albedo| albedo.peak().1 >= WORTH_CLIMBING)
        .map(|albedo| (albedo.theta, albedo.phi, albedo.fixed))
        .collect();
    jobs.extend(bumps);
    let total = jobs.len() + Fixed::BOTH.len();
    let done = AtomicUsize::new(0);
    let advance = || {
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        if let Some(progress) = plan.progress {
            progress(done, total);
        }
    };
    let albedos: Vec<Albedo> = jobs
        .par_iter()
        .map(|&(theta, phi, fixed)| {
            let albedo = settle(subject, theta, phi, fixed, &plan.effort);
            advance();
            albedo
        })
        .collect();
    let results: Vec<(Finding, usize)> = Fixed::BOTH
        .par_iter()
        .map(|&fixed| {
            let corners: Vec<&Albedo> = albedos.iter().filter(|albedo| albedo.fixed == fixed).collect();
            let result = marginal(subject, &corners, &gaps(plan.thetas), fixed, &plan.effort);
            advance();
            result
        })
        .collect();
    let evaluations = albedos.iter().chain(&seen).map(|albedo| albedo.evaluations).sum::<usize>()
        + results.iter().map(|(_, evaluations)| evaluations).sum::<usize>();
    (results.into_iter().map(|(finding, _)| finding).collect(), albedos, evaluations)
}

/// Angles that leave no gap between these of more than [`STEP`].
fn gaps(thetas: &[f64]) -> Vec<f64> {
    let mut sorted = thetas.to_vec();
    sorted.sort_by(f64::total_cmp);
    let inside = |pair: &[f64]| {
        let (low, width) = (pair[0], pair[1] - pair[0]);
        let parts = (width / STEP).ceil().clamp(1.0, 90.0 / STEP) as usize;
        (1..parts).map(move |part| low + width * part as f64 / parts as f64).collect::<Vec<_>>()
    };
    sorted.windows(2).flat_map(inside).collect()
}

/// The verdict on an albedo, of its worst channel, and that channel. A pass takes agreement and finite samples.
pub(super) fn judge(albedo: &Albedo) -> (Verdict, usize) {
    let mut worst = (Verdict::Pass, 0);
    for (channel, (&value, &error)) in albedo.value.iter().zip(&albedo.error).enumerate() {
        let verdict = Verdict::of(value, error, 1.0, TOLERANCE);
        if verdict > worst.0 || (verdict == worst.0 && value > albedo.value[worst.1]) {
            worst = (verdict, channel);
        }
    }
    if worst.0 == Verdict::Pass && (!albedo.agrees || albedo.non_finite > 0) {
        worst.0 = Verdict::Inconclusive;
    }
    worst
}

/// An albedo, worked on harder while its verdict is not clear.
fn settle(subject: &dyn Subject, theta: f64, phi: f64, fixed: Fixed, effort: &Effort) -> Albedo {
    let mut result = albedo(subject, theta, phi, fixed, effort);
    for factor in [4, 16] {
        if judge(&result).0 != Verdict::Inconclusive && result.agrees {
            break;
        }
        let spent = result.evaluations;
        result = albedo(subject, theta, phi, fixed, &effort.scaled(factor));
        result.evaluations += spent;
    }
    result
}

fn marginal(
    subject: &dyn Subject,
    corners: &[&Albedo],
    between: &[f64],
    fixed: Fixed,
    effort: &Effort,
) -> (Finding, usize) {
    let rank = |albedo: &Albedo| {
        let (verdict, channel) = judge(albedo);
        (verdict, albedo.value.get(channel).copied().unwrap_or(0.0))
    };
    let worst = corners.iter().copied().reduce(|a, b| {
        let (ra, rb) = (rank(a), rank(b));
        if rb.0.cmp(&ra.0).then(rb.1.total_cmp(&ra.1)).is_gt() { b } else { a }
    });
    let Some(worst) = worst else {
        return (finding(subject, None, fixed), 0);
    };
    if worst.peak().1 < WORTH_CLIMBING {
        return (finding(subject, Some(worst), fixed), 0);
    }
    let (refined, evaluations) = climb(subject, corners, between, worst, effort);
    let chosen = refined.as_ref().filter(|refined| rank(refined) >= rank(worst)).unwrap_or(worst);
    (finding(subject, Some(chosen), fixed), evaluations)
}

/// Golden section between the neighbours of the worst corner, then the roundest angle that is nearly as bad; nothing if
/// the corner is that.
fn climb(
    subject: &dyn Subject,
    corners: &[&Albedo],
    between: &[f64],
    worst: &Albedo,
    effort: &Effort,
) -> (Option<Albedo>, usize) {
    let same = corners.iter().filter(|albedo| albedo.phi == worst.phi).map(|albedo| albedo.theta);
    let same = same.chain(between.iter().copied());
    let (mut low, mut high) = (worst.theta, worst.theta);
    for theta in same {
        if theta < worst.theta && (low == worst.theta || theta > low) {
            low = theta;
        }
        if theta > worst.theta && (high == worst.theta || theta < high) {
            high = theta;
        }
    }
    let channel = judge(worst).1;
    let rough = Effort { target: 3.0 * effort.target, replicates: 0, ..*effort };
    let mut spent = 0;
    let mut at = |theta: f64| {
        let albedo = albedo(subject, theta, worst.phi, worst.fixed, &rough);
        spent += albedo.evaluations;
        albedo.value[channel]
    };
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let mut best = (worst.theta, worst.value[channel]);
    let (mut a, mut b) = (high - golden * (high - low), low + golden * (high - low));
    let (mut fa, mut fb) = (at(a), at(b));
    for _ in 0..5 {
        for (theta, value) in [(a, fa), (b, fb)] {
            if value > best.1 {
                best = (theta, value);
            }
        }
        if fa > fb {
            (high, b, fb) = (b, a, fa);
            a = high - golden * (high - low);
            fa = at(a);
        } else {
            (low, a, fa) = (a, b, fb);
            b = low + golden * (high - low);
            fb = at(b);
        }
    }
    let enough = best.1 - worst.error[channel] - 1e-3 * best.1.abs();
    if worst.value[channel] >= enough {
        return (None, spent);
    }
    let mut angle = best.0;
    for step in [5.0, 1.0, 0.5, 0.1, 0.01] {
        let round = ((best.0 / step).round() * step * 100.0).round() / 100.0;
        if (0.0..90.0).contains(&round) && at(round) >= enough {
            angle = round;
            break;
        }
    }
    let refined = settle(subject, angle, worst.phi, worst.fixed, effort);
    spent += refined.evaluations;
    (Some(refined), spent)
}

fn finding(subject: &dyn Subject, albedo: Option<&Albedo>, fixed: Fixed) -> Finding {
    let mut finding = Finding { limit: 1.0 + TOLERANCE, ..Finding::new(Check::Energy) };
    let Some(albedo) = albedo.filter(|albedo| !albedo.value.is_empty()) else {
        finding.note = "nothing to integrate".into();
        return finding;
    };
    let (verdict, channel) = judge(albedo);
    finding.verdict = verdict;
    finding.value = albedo.value[channel];
    finding.error = albedo.error[channel];
    finding.place = Place::Marginal { theta: albedo.theta, phi: albedo.phi, fixed };
    finding.channel = Some((channel, subject.channel_name(channel)));
    if !albedo.agrees {
        finding.note = format!(
            "cubature and its cross-check ({:.4} ± {:.4}) disagree",
            albedo.cross_check[channel], albedo.standard_error[channel]
        );
    } else if albedo.non_finite > 0 {
        finding.note = format!("{} samples were not finite and count as 0", albedo.non_finite);
    }
    finding
}
