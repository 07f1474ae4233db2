//! Finite and not negative, by class of input; and what single precision costs.

use super::pairs::{Class, climb};
use super::report::{Check, Finding, Place};
use super::subject::{Pair, Subject, Watch};
use super::verdict::Verdict;
use crate::frame::Vector;

/// How far below 0 f may be, in sr⁻¹, before the model and not its rounding is at fault: in double and in single precision,
/// some thousand times the rounding of numbers near 1.
pub(super) const NEGATIVE: [f64; 2] = [1e-12, 1e-4];

/// Pairs that are put to the subject at once.
const BLOCK: usize = 256;

/// Of the way downhill.
const GENERATIONS: u32 = 40;

/// Counts of one defect over the classes, and its worst case.
#[derive(Default)]
struct Tally {
    counts: Vec<(&'static str, usize)>,
    total: usize,
    worst: Option<(f64, usize, Pair)>,
}

impl Tally {
    fn add(&mut self, class: &'static str, badness: f64, channel: usize, pair: Pair) {
        self.total += 1;
        match self.counts.last_mut() {
            Some((name, count)) if *name == class => *count += 1,
            _ => self.counts.push((class, 1)),
        }
        if self.worst.is_none_or(|(worst, ..)| badness > worst) {
            self.worst = Some((badness, channel, pair));
        }
    }

    fn classes(&self, samples: usize) -> String {
        let each: Vec<String> = self.counts.iter().map(|(name, count)| format!("{name} {count}/{samples}")).collect();
        each.join(", ")
    }
}

/// Puts `samples` pairs of every [`Class`] to the subject, in double precision and, where it has that, in single.
///
/// Returns the findings and the number of evaluations.
pub fn sanity(subject: &dyn Subject, samples: usize, seed: u32) -> (Vec<Finding>, usize) {
    let mut evaluations = 0;
    let mut findings = Vec::new();
    let channels = subject.channels().max(1);
    for single in [false, true] {
        let mut evaluate = |pairs: &[Pair]| {
            evaluations += pairs.len();
            if single { narrow(subject, pairs) } else { Some(wide(subject, pairs)) }
        };
        if evaluate(&[(Vector::new(0.6, 0.0, 0.8), Vector::new(0.0, 0.6, 0.8))]).is_none() {
            continue;
        }
        let (mut broken, mut negative) = (Tally::default(), Tally::default());
        let mut least: Option<(f64, Pair)> = None;
        for class in Class::ALL {
            for block in (0..samples).step_by(BLOCK) {
                let pairs: Vec<Pair> = (block..samples.min(block + BLOCK)).map(|i| class.pair(i, seed)).collect();
                let Some(f) = evaluate(&pairs) else { continue };
                for (&pair, f) in pairs.iter().zip(f.chunks_exact(channels)) {
                    for (channel, &f) in f.iter().enumerate() {
                        if !f.is_finite() {
                            broken.add(class.name(), pair.0.z.min(pair.1.z), channel, pair);
                            continue;
                        }
                        if -f > NEGATIVE[usize::from(single)] {
                            negative.add(class.name(), -f, channel, pair);
                        }
                        if f < least.map_or(f64::INFINITY, |(f, _)| f) {
                            least = Some((f, pair));
                        }
                    }
                }
            }
        }
        // Values below 0 that no sample met are looked for downhill from the least one.
        if let (None, Some((_, start))) = (&negative.worst, least) {
            let (pair, value) = climb(start, seed, GENERATIONS, |pairs, values| {
                let f = evaluate(pairs).unwrap_or_default();
                for (value, f) in values.iter_mut().zip(f.chunks_exact(channels)) {
                    *value = f.iter().filter(|f| f.is_finite()).fold(f64::NEG_INFINITY, |a, f| a.max(-f));
                }
            });
            if value > NEGATIVE[usize::from(single)] {
                let f = evaluate(&[pair]).unwrap_or_default();
                let channel = f.iter().position(|f| -f == value).unwrap_or(0);
                negative.add("found downhill", value, channel, pair);
            }
        }
        findings.push(defect(subject, Check::Finite, single, &broken, 0.0, samples));
        findings.push(defect(subject, Check::Sign, single, &negative, least.map_or(0.0, |(f, _)| f), samples));
    }
    findings.extend(horizon(subject, samples, seed, &mut evaluations));
    (findings, evaluations)
}

/// Takes into account what the integrals met on their way: they refine towards defects that samples miss.
pub(super) fn heed(subject: &dyn Subject, watch: &Watch, findings: &mut [Finding]) {
    let place = |(wi, wo): Pair| Place::Pair { wi, wo };
    for finding in findings.iter_mut().filter(|finding| !finding.single && finding.verdict == Verdict::Pass) {
        match (finding.check, watch.broken_at, watch.least) {
            (Check::Finite, Some((channel, pair)), _) => {
                finding.value = watch.broken as f64;
                finding.place = place(pair);
                finding.channel = Some((channel, subject.channel_name(channel)));
            }
            (Check::Sign, _, Some((least, channel, pair))) if -least > NEGATIVE[0] => {
                finding.value = least;
                finding.place = place(pair);
                finding.channel = Some((channel, subject.channel_name(channel)));
            }
            _ => continue,
        }
        finding.verdict = Verdict::Fail;
        finding.note = "met by the integrals alone".into();
    }
}

/// f of each pair in double precision.
fn wide(subject: &dyn Subject, pairs: &[Pair]) -> Vec<f64> {
    let mut f = vec![0.0; pairs.len() * subject.channels()];
    subject.evaluate_many(pairs, &mut f);
    f
}

/// f of each pair in single precision, if there is such a thing.
fn narrow(subject: &dyn Subject, pairs: &[Pair]) -> Option<Vec<f64>> {
    let pairs: Vec<_> = pairs.iter().map(|(wi, wo)| (wi.cast::<f32>(), wo.cast::<f32>())).collect();
    let mut f = vec![0.0f32; pairs.len() * subject.channels()];
    subject.evaluate_single_many(&pairs, &mut f).then(|| f.into_iter().map(f64::from).collect())
}

fn defect(subject: &dyn Subject, check: Check, single: bool, tally: &Tally, passing: f64, samples: usize) -> Finding {
    let (value, place, channel) = match tally.worst {
        None => (passing, Place::Everywhere, None),
        Some((worst, channel, (wi, wo))) => (
            if check == Check::Sign { -worst } else { tally.total as f64 },
            Place::Pair { wi, wo },
            Some((channel, subject.channel_name(channel))),
        ),
    };
    Finding {
        single,
        verdict: if tally.total > 0 { Verdict::Fail } else { Verdict::Pass },
        value,
        limit: if check == Check::Sign { -NEGATIVE[usize::from(single)] } else { 0.0 },
        place,
        channel,
        note: tally.classes(samples),
        ..Finding::new(check)
    }
}

/// What happens at and below the horizon, where f is 0 by this crate's convention and undefined by others.
fn horizon(subject: &dyn Subject, samples: usize, seed: u32, evaluations: &mut usize) -> Option<Finding> {
    let (mut broken, mut lit) = (Tally::default(), Tally::default());
    for block in (0..samples).step_by(BLOCK) {
        let below = |i: usize| {
            let (mut wi, mut wo) = Class::ALL[i % Class::ALL.len()].pair(i, seed);
            match i % 3 {
                0 => wi.z = -wi.z,
                1 => wo.z = -wo.z,
                _ => (wi.z, wo.z) = (-wi.z, -wo.z),
            }
            if i.is_multiple_of(7) {
                (wi.z, wo.z) = (wi.z.max(0.0), wo.z.max(0.0));
            }
            (wi, wo)
        };
        let pairs: Vec<Pair> = (block..samples.min(block + BLOCK)).map(below).collect();
        *evaluations += pairs.len();
        for (&(wi, wo), f) in pairs.iter().zip(wide(subject, &pairs).chunks_exact(subject.channels().max(1))) {
            for (channel, &f) in f.iter().enumerate() {
                if !f.is_finite() {
                    broken.add("not finite", -wi.z.min(wo.z), channel, (wi, wo));
                } else if f != 0.0 {
                    lit.add("not 0", f.abs(), channel, (wi, wo));
                }
            }
        }
    }
    let (_, channel, (wi, wo)) = broken.worst.or(lit.worst)?;
    let notes: Vec<String> =
        [&broken, &lit].into_iter().filter(|tally| tally.total > 0).map(|tally| tally.classes(samples)).collect();
    Some(Finding {
        verdict: Verdict::Pass,
        binding: false,
        value: (broken.total + lit.total) as f64,
        place: Place::Pair { wi, wo },
        channel: Some((channel, subject.channel_name(channel))),
        note: format!("{} below the horizon: guard the call by both cosines > 0", notes.join(", ")),
        ..Finding::new(Check::Horizon)
    })
}

/// The single-precision instance against the double-precision one, given the same directions.
///
/// Over f > 1e-8 sr⁻¹ and angles up to 89.9°; nothing if the subject has no single-precision instance.
pub fn precision(subject: &dyn Subject, samples: usize, seed: u32) -> Option<Finding> {
    let grazing = 89.9f64.to_radians().cos();
    let mut deviations = Vec::new();
    let mut worst: (f64, usize, Option<Pair>) = (0.0, 0, None);
    for class in Class::ALL {
        for block in (0..samples).step_by(BLOCK) {
            let pairs: Vec<Pair> = (block..samples.min(block + BLOCK))
                .map(|i| class.pair(i, seed))
                .map(|(wi, wo)| (wi.cast::<f32>().cast::<f64>(), wo.cast::<f32>().cast::<f64>()))
                .filter(|(wi, wo)| wi.z >= grazing && wo.z >= grazing)
                .collect();
            let (g, f) = (narrow(subject, &pairs)?, wide(subject, &pairs));
            let n = subject.channels().max(1);
            for ((&pair, f), g) in pairs.iter().zip(f.chunks_exact(n)).zip(g.chunks_exact(n)) {
                for (channel, (&f, &g)) in f.iter().zip(g).enumerate() {
                    if f.is_finite() && g.is_finite() && f.abs() > 1e-8 {
                        let deviation = ((g - f) / f).abs();
                        deviations.push(deviation);
                        if deviation > worst.0 {
                            worst = (deviation, channel, Some(pair));
                        }
                    }
                }
            }
        }
    }
    deviations.sort_by(f64::total_cmp);
    let median = deviations.get(deviations.len() / 2).copied().unwrap_or(0.0);
    let (value, channel, pair) = worst;
    Some(Finding {
        single: true,
        verdict: Verdict::Pass,
        binding: false,
        value,
        limit: f64::INFINITY,
        place: pair.map_or(Place::Everywhere, |(wi, wo)| Place::Pair { wi, wo }),
        channel: Some((channel, subject.channel_name(channel))),
        note: format!("worst relative deviation from f64, median {median:.1e}"),
        ..Finding::new(Check::Precision)
    })
}

#[cfg(test)]
mod tests {
    use super::super::corpus::{beckmann, v_cavity};
    use super::*;
    use crate::frame::half_vector;

    /// Torrance–Sparrow whose single-precision instance forms tan² from 1 − NH².
    struct Cancelling;

    impl Subject for Cancelling {
        fn name(&self) -> String {
            "cancelling".into()
        }
        fn channels(&self) -> usize {
            1
        }
        fn evaluate(&self, wi: Vector<f64>, wo: Vector<f64>, f: &mut [f64]) {
            f[0] = if wi.z > 0.0 && wo.z > 0.0 { beckmann(half_vector(wi, wo), 0.01) * v_cavity(wi, wo) } else { 0.0 };
        }
        fn evaluate_single(&self, wi: Vector<f32>, wo: Vector<f32>, f: &mut [f32]) -> bool {
            let h = half_vector(wi, wo).normalized();
            let t = (1.0 - h.z * h.z) / (h.z * h.z);
            let d = (1.0 + t) * (1.0 + t) * (-t / 1e-4).exp() / (core::f32::consts::PI * 1e-4);
            f[0] = d * v_cavity(wi.cast(), wo.cast()) as f32;
            true
        }
    }

    #[test]
    fn single_precision_is_judged_apart() {
        let (findings, _) = sanity(&Cancelling, 256, 1);
        let verdict =
            |check, single| findings.iter().find(|f| f.check == check && f.single == single).map(|f| f.verdict);
        assert_eq!(verdict(Check::Finite, false), Some(Verdict::Pass), "{findings:?}");
        assert_eq!(verdict(Check::Sign, false), Some(Verdict::Pass), "{findings:?}");
        assert!(verdict(Check::Finite, true).is_some() && verdict(Check::Sign, true).is_some());
        let precision = precision(&Cancelling, 256, 1);
        let fine = |f: &Finding| f.value > 1e-3 && f.verdict == Verdict::Pass && !f.binding;
        assert!(precision.as_ref().is_some_and(fine), "{precision:?}");
    }

    #[test]
    fn a_small_negative_region_is_found_downhill() {
        let away = Vector::from_angles(0.8, 1.0);
        let subject = super::super::from_fn("dented", 1, move |wi: Vector<f64>, wo: Vector<f64>, f: &mut [f64]| {
            let distance = (wi - away).length_squared() + (wo - away).length_squared();
            f[0] = distance - 1e-6;
        });
        let (findings, _) = sanity(&subject, 128, 1);
        let sign = findings.iter().find(|f| f.check == Check::Sign);
        assert_eq!(sign.map(|f| f.verdict), Some(Verdict::Fail), "{findings:?}");
    }
}
