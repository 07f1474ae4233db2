//! The search for the direction that reflects most: corners, then uphill between them, then a round number.

use super::energy::{Albedo, Effort, albedo, watched};
use super::pairs::Class;
use super::report::{Check, Finding, Place};
use super::subject::{Fixed, Pair, Subject, Watch};
use super::verdict::Verdict;
use crate::frame::Vector;
use core::sync::atomic::{AtomicUsize, Ordering};
use rayon::prelude::*;

/// Polar angles, in degrees, that every check integrates at: models fail at the normal, or towards grazing.
pub const THETAS: [f64; 10] = [0.0, 45.0, 60.0, 75.0, 80.0, 85.0, 88.0, 89.0, 89.5, 89.9];

/// Azimuths, in degrees, for a subject that was measured to be anisotropic.
pub(super) const AZIMUTHS: [f64; 3] = [0.0, 90.0, 35.0];

/// The widest gap between angles, in degrees, that is not looked into: isotropic, anisotropic.
const STEPS: [f64; 2] = [1.0, 4.5];

/// Azimuths, in degrees, that are looked into if f is anisotropic. 180° would do for a reciprocal subject.
const LOOKS: [f64; 8] = [0.0, 22.5, 45.0, 67.5, 90.0, 112.5, 135.0, 157.5];

/// What a look into a gap costs: enough for some percent.
const GLANCE: Effort = Effort { target: 1e-2, evaluations: 1_500, replicates: 0, samples: 0, seed: 1 };

/// Albedo is continuous in θ: what stays below this at every angle that was looked at is not searched any closer.
const WORTH_CLIMBING: f64 = 0.7;

/// Bumps of one marginal that are integrated in earnest.
const BUMPS: usize = 3;

/// Where to integrate, and how hard.
pub(super) struct Plan<'a> {
    pub(super) thetas: &'a [f64],
    pub(super) azimuths: &'a [f64],
    pub(super) effort: Effort,
    /// What an albedo of 1 may be exceeded by.
    pub(super) tolerance: f64,
    pub(super) progress: Option<&'a (dyn Fn(usize, usize) + Sync)>,
}

/// What the integrals found.
pub(super) struct Energy {
    /// One for each marginal.
    pub(super) findings: Vec<Finding>,
    /// Every albedo at a corner.
    pub(super) albedos: Vec<Albedo>,
    pub(super) evaluations: usize,
    pub(super) watch: Watch,
}

/// A cheap albedo, for a search.
pub(super) fn glance(subject: &dyn Subject, theta: f64, phi: f64, fixed: Fixed) -> (Albedo, Watch) {
    watched(subject, theta, phi, fixed, &GLANCE)
}

/// Energy of both marginals: a finding each, and every albedo at a corner.
pub(super) fn energy(subject: &dyn Subject, plan: &Plan<'_>) -> Energy {
    let anisotropic = plan.azimuths.len() > 1;
    let mut jobs = Vec::new();
    for fixed in Fixed::BOTH {
        for &phi in plan.azimuths {
            jobs.extend(plan.thetas.iter().map(|&theta| (theta, phi, fixed)));
        }
    }
    // Bumps between the corners become corners, and two refinements follow.
    let between = gaps(plan.thetas, STEPS[usize::from(anisotropic)]);
    let looks: &[f64] = if anisotropic { &LOOKS } else { plan.azimuths };
    let mut evaluations = 0;
    let mut bumps = Vec::new();
    let mut watch = Watch::default();
    for fixed in Fixed::BOTH {
        let glances: Vec<(f64, f64)> =
            looks.iter().flat_map(|&phi| between.iter().map(move |&theta| (theta, phi))).collect();
        for &phi in plan.azimuths {
            let (ridges, spent) = ridges(subject, fixed, phi, plan.thetas, plan.effort.seed);
            // A glance cannot tell what a ridge is worth.
            bumps.extend(ridges.into_iter().map(|theta| (theta, phi, fixed)));
            evaluations += spent;
        }
        let seen: Vec<(Albedo, Watch)> =
            glances.par_iter().map(|&(theta, phi)| glance(subject, theta, phi, fixed)).collect();
        let mut high: Vec<Albedo> = Vec::new();
        for (albedo, met) in seen {
            evaluations += albedo.evaluations;
            watch = watch.with(met);
            high.push(albedo);
        }
        high.sort_by(|a, b| a.phi.total_cmp(&b.phi).then(a.theta.total_cmp(&b.theta)));
        let beside =
            |i: usize, j: Option<&Albedo>| j.is_none_or(|j| j.phi != high[i].phi || j.peak().1 <= high[i].peak().1);
        let top = |&i: &usize| {
            high[i].peak().1 >= WORTH_CLIMBING
                && beside(i, i.checked_sub(1).and_then(|i| high.get(i)))
                && beside(i, high.get(i + 1))
        };
        let mut high: Vec<Albedo> = (0..high.len()).filter(top).map(|i| high[i].clone()).collect();
        high.sort_by(|a, b| b.peak().1.total_cmp(&a.peak().1));
        let mut chosen: Vec<(f64, f64, Fixed)> = Vec::new();
        for albedo in &high {
            // The slopes of a bump that was chosen are not another.
            let apart = |&(theta, phi, _): &(f64, f64, Fixed)| (theta - albedo.theta).abs() > 5.0 || phi != albedo.phi;
            if chosen.len() < BUMPS && chosen.iter().all(apart) {
                chosen.push((albedo.theta, albedo.phi, fixed));
            }
        }
        bumps.extend(chosen);
    }
    jobs.extend(bumps);
    let total = jobs.len() + Fixed::BOTH.len();
    let done = AtomicUsize::new(0);
    let advance = || {
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        if let Some(progress) = plan.progress {
            progress(done, total);
        }
    };
    let settled: Vec<(Albedo, Watch)> = jobs
        .par_iter()
        .map(|&(theta, phi, fixed)| {
            let settled = settle(subject, theta, phi, fixed, plan);
            advance();
            settled
        })
        .collect();
    let mut albedos = Vec::new();
    for (albedo, met) in settled {
        evaluations += albedo.evaluations;
        watch = watch.with(met);
        albedos.push(albedo);
    }
    let results: Vec<(Finding, usize)> = Fixed::BOTH
        .par_iter()
        .map(|&fixed| {
            let corners: Vec<&Albedo> = albedos.iter().filter(|albedo| albedo.fixed == fixed).collect();
            let result = marginal(subject, &corners, &between, fixed, plan);
            advance();
            result
        })
        .collect();
    evaluations += results.iter().map(|(_, evaluations)| evaluations).sum::<usize>();
    Energy { findings: results.into_iter().map(|(finding, _)| finding).collect(), albedos, evaluations, watch }
}

/// Angles that leave no gap between these of more than `step`.
fn gaps(thetas: &[f64], step: f64) -> Vec<f64> {
    let mut sorted = thetas.to_vec();
    sorted.sort_by(f64::total_cmp);
    let inside = |pair: &[f64]| {
        let (low, width) = (pair[0], pair[1] - pair[0]);
        let parts = (width / step).ceil().clamp(1.0, 90.0 / step) as usize;
        (1..parts).map(move |part| low + width * part as f64 / parts as f64).collect::<Vec<_>>()
    };
    sorted.windows(2).flat_map(inside).collect()
}

/// Polar angles where f has a ridge narrower than the gaps, whatever the free direction: the most prominent ones, and what the
/// look cost.
///
/// At steps of 0.1°, f is compared with itself ½° and 1½° to either side: for free directions all over the hemisphere, of which a
/// lobe passes over few at one angle and a ridge lifts many; and for the mirror, the retro direction and one beside them,
/// which see a ridge that takes both directions.
fn ridges(subject: &dyn Subject, fixed: Fixed, phi: f64, thetas: &[f64], seed: u32) -> (Vec<f64>, usize) {
    const STEP: f64 = 0.1;
    const FREE: usize = 32;
    const MOST: usize = 3;
    const PROMINENT: f64 = 1.03;
    let low = thetas.iter().copied().fold(f64::INFINITY, f64::min);
    let high = thetas.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let channels = subject.channels();
    if high <= low || channels == 0 {
        return (Vec::new(), 0);
    }
    let angles: Vec<f64> = (0..=((high - low) / STEP) as usize).map(|i| low + STEP * i as f64).collect();
    let free: Vec<Vector<f64>> = (0..FREE).map(|i| Class::Hemisphere.pair(i, seed).0).collect();
    // f summed over the channels, by free direction and angle; the last rows follow the fixed direction around.
    let follows: [f64; 3] = [180.0, 0.0, 90.0];
    let rows: Vec<Vec<f64>> = (0..FREE + follows.len())
        .into_par_iter()
        .map(|row| {
            let place = |&theta: &f64| {
                let at = |phi: f64| Vector::from_angles(theta.to_radians(), phi.to_radians());
                let other = free.get(row).copied().unwrap_or_else(|| at(phi + follows[(row - FREE) % follows.len()]));
                if fixed == Fixed::View { (other, at(phi)) } else { (at(phi), other) }
            };
            let pairs: Vec<Pair> = angles.iter().map(place).collect();
            let mut f = vec![0.0; pairs.len() * channels];
            subject.evaluate_many(&pairs, &mut f);
            let sum = |f: &[f64]| f.iter().filter(|f| f.is_finite()).sum::<f64>();
            f.chunks_exact(channels).map(sum).collect()
        })
        .collect();
    let lift = |row: &[f64], i: usize| {
        let over = |away: usize| {
            let beside = row[i.saturating_sub(away)].max(row[(i + away).min(row.len() - 1)]);
            row[i] / beside.max(1e-9)
        };
        over(5).max(over(15))
    };
    let prominence = |i: usize| {
        let (spread, following) = rows.split_at(FREE);
        let mut lifts: Vec<f64> = spread.iter().map(|row| lift(row, i)).collect();
        // The upper quartile: a ridge may lift some of the directions alone.
        lifts.sort_by(f64::total_cmp);
        following.iter().map(|row| lift(row, i)).fold(lifts[3 * lifts.len() / 4], f64::max)
    };
    let lifted: Vec<f64> = (0..angles.len()).map(prominence).collect();
    let mut tops: Vec<usize> = (1..angles.len().saturating_sub(1))
        .filter(|&i| lifted[i] > PROMINENT && lifted[i] >= lifted[i - 1] && lifted[i] >= lifted[i + 1])
        .collect();
    tops.sort_by(|&a, &b| lifted[b].total_cmp(&lifted[a]));
    tops.truncate(MOST);
    (tops.into_iter().map(|i| (angles[i] * 10.0).round() / 10.0).collect(), FREE * angles.len())
}

/// The verdict on an albedo, of its worst channel, and that channel. A pass takes agreement and finite samples.
pub(super) fn judge(albedo: &Albedo, tolerance: f64) -> (Verdict, usize) {
    let mut worst = (Verdict::Pass, 0);
    for (channel, (&value, &error)) in albedo.value.iter().zip(&albedo.error).enumerate() {
        let verdict = Verdict::of(value, error, 1.0, tolerance);
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
fn settle(subject: &dyn Subject, theta: f64, phi: f64, fixed: Fixed, plan: &Plan<'_>) -> (Albedo, Watch) {
    let (mut result, mut watch) = watched(subject, theta, phi, fixed, &plan.effort);
    for factor in [4, 16] {
        // What is not finite stays so.
        if (judge(&result, plan.tolerance).0 != Verdict::Inconclusive && result.agrees) || result.non_finite > 0 {
            break;
        }
        let spent = result.evaluations;
        let (harder, met) = watched(subject, theta, phi, fixed, &plan.effort.scaled(factor));
        result = harder;
        watch = watch.with(met);
        result.evaluations += spent;
    }
    (result, watch)
}

fn marginal(
    subject: &dyn Subject,
    corners: &[&Albedo],
    between: &[f64],
    fixed: Fixed,
    plan: &Plan<'_>,
) -> (Finding, usize) {
    let rank = |albedo: &Albedo| {
        let (verdict, channel) = judge(albedo, plan.tolerance);
        (verdict, albedo.value.get(channel).copied().unwrap_or(0.0))
    };
    let worst = corners.iter().copied().reduce(|a, b| {
        let (ra, rb) = (rank(a), rank(b));
        if rb.0.cmp(&ra.0).then(rb.1.total_cmp(&ra.1)).is_gt() { b } else { a }
    });
    // A corner that is as bad within rounding is the rounder angle.
    let as_bad = |albedo: &&Albedo| {
        let (a, b) = (rank(albedo), worst.map_or((Verdict::Pass, 0.0), rank));
        plan.thetas.contains(&albedo.theta) && a.0 == b.0 && a.1 >= b.1 - 3e-4 * b.1.abs()
    };
    let worst =
        corners.iter().copied().filter(as_bad).reduce(|a, b| if rank(b).1 > rank(a).1 { b } else { a }).or(worst);
    let Some(worst) = worst else {
        return (finding(subject, None, fixed, plan.tolerance), 0);
    };
    if worst.peak().1 < WORTH_CLIMBING {
        return (finding(subject, Some(worst), fixed, plan.tolerance), 0);
    }
    let (refined, evaluations) = climb(subject, corners, between, worst, plan);
    let chosen = refined.as_ref().filter(|refined| rank(refined) >= rank(worst)).unwrap_or(worst);
    (finding(subject, Some(chosen), fixed, plan.tolerance), evaluations)
}

/// The neighbours of a number in a list, or itself at an end.
fn neighbours(of: f64, all: impl Iterator<Item = f64>) -> (f64, f64) {
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    for x in all {
        if x < of {
            low = low.max(x);
        }
        if x > of {
            high = high.min(x);
        }
    }
    (if low.is_finite() { low } else { of }, if high.is_finite() { high } else { of })
}

/// Golden section between the neighbours of the worst corner, in its azimuth too if there are several, then the roundest
/// angles that are nearly as bad; nothing if the corner is that.
fn climb(
    subject: &dyn Subject,
    corners: &[&Albedo],
    between: &[f64],
    worst: &Albedo,
    plan: &Plan<'_>,
) -> (Option<Albedo>, usize) {
    let channel = judge(worst, plan.tolerance).1;
    let rough = Effort { target: 3.0 * plan.effort.target, replicates: 0, ..plan.effort };
    let mut spent = 0;
    let mut at = |theta: f64, phi: f64| {
        let albedo = albedo(subject, theta, phi, worst.fixed, &rough);
        spent += albedo.evaluations;
        albedo.value[channel]
    };
    let same = corners.iter().filter(|albedo| albedo.phi == worst.phi).map(|albedo| albedo.theta);
    let range = neighbours(worst.theta, same.chain(between.iter().copied()));
    let start = (worst.theta, worst.value[channel]);
    let mut best = golden(range, start, |theta| at(theta, worst.phi));
    let mut phi = worst.phi;
    if plan.azimuths.len() > 1 {
        let around = (phi - LOOKS[1], phi + LOOKS[1]);
        let turned = golden(around, (phi, best.1), |phi| at(best.0, phi));
        (phi, best.1) = (turned.0, turned.1);
        best = golden(range, best, |theta| at(theta, phi));
    }
    let enough = best.1 - worst.error[channel] - 1e-3 * best.1.abs();
    if worst.value[channel] >= enough {
        return (None, spent);
    }
    let mut angles = (best.0, phi);
    for step in [5.0, 1.0, 0.5, 0.1, 0.01] {
        let round = |x: f64| ((x / step).round() * step * 100.0).round() / 100.0;
        let (theta, phi) = (round(best.0), round(phi));
        if (0.0..90.0).contains(&theta) && at(theta, phi) >= enough {
            angles = (theta, phi);
            break;
        }
    }
    let (refined, _) = settle(subject, angles.0, angles.1, worst.fixed, plan);
    spent += refined.evaluations;
    (Some(refined), spent)
}

/// The best of a golden section of five steps and of what is known already: where, and how much.
fn golden((mut low, mut high): (f64, f64), known: (f64, f64), mut at: impl FnMut(f64) -> f64) -> (f64, f64) {
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let mut best = known;
    if high <= low {
        return best;
    }
    let (mut a, mut b) = (high - golden * (high - low), low + golden * (high - low));
    let (mut fa, mut fb) = (at(a), at(b));
    for _ in 0..5 {
        for found in [(a, fa), (b, fb)] {
            if found.1 > best.1 {
                best = found;
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
    best
}

fn finding(subject: &dyn Subject, albedo: Option<&Albedo>, fixed: Fixed, tolerance: f64) -> Finding {
    let mut finding = Finding { limit: 1.0 + tolerance, ..Finding::new(Check::Energy) };
    let Some(albedo) = albedo.filter(|albedo| !albedo.value.is_empty()) else {
        finding.note = "nothing to integrate".into();
        return finding;
    };
    let (verdict, channel) = judge(albedo, tolerance);
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
