//! The search of a family for its worst member, together with the angles and pairs of directions that show it.
//!
//! Corners of the box first, then a Sobol sequence over it, then a (1+1) evolution strategy (Rechenberg 1973) from the best
//! of those: a violation that fills a thousandth of the box is rarely drawn, but the margin usually slopes towards it. The
//! margin is a cheap albedo less 1, or the worst of a few hundred pairs; what the search finds is only where to look. Its
//! parameters are made round while the margin holds, and then that member goes through every check.

use super::energy::{Albedo, Effort, albedo};
use super::family::{Family, Parameter};
use super::pairs::{Class, moved};
use super::reciprocity::{self, Comparison};
use super::report::{Check, Coverage, Finding, Place, Report};
use super::space::{Space, significant, sobol};
use super::subject::{Fixed, Pair, Subject};
use super::verdict::Verdict;
use super::{Options, diagnosis, examine, is_anisotropic, limits, marginals};
use rayon::prelude::*;

/// Evaluations of a glance, about.
const GLANCE: usize = 2_200;

/// Polar angles that corners are looked at, those that show most first.
const THETAS: [f64; 9] = [88.0, 0.0, 75.0, 89.9, 60.0, 85.0, 45.0, 80.0, 89.0];

/// Climbs, each from another start.
const CLIMBS: usize = 6;

/// Pairs of directions that a member is tried on.
const PAIRS: usize = 144;

/// The share of a margin that rounder parameters may cost.
const SPARED: f64 = 0.02;

/// Where an albedo is looked at: a member, and the fixed direction.
#[derive(Clone, Debug)]
struct Look {
    units: Vec<f64>,
    /// In degrees.
    theta: f64,
    phi: f64,
    fixed: Fixed,
    /// The largest albedo of a channel.
    albedo: f64,
}

/// What a member's pairs showed at worst.
#[derive(Clone, Debug)]
struct Trial {
    units: Vec<f64>,
    /// Reciprocity, sign, finiteness: how bad, and where.
    worst: [(f64, Pair); 3],
}

struct Search<'a> {
    family: &'a dyn Family,
    space: Space<'a>,
    thetas: (f64, f64),
    anisotropic: bool,
    seed: u32,
}

impl Search<'_> {
    fn member(&self, units: &[f64]) -> Box<dyn Subject + '_> {
        self.family.subject(&self.space.values(units))
    }

    /// 0…1 to degrees, grazing angles stretched.
    fn theta(&self, unit: f64) -> f64 {
        let rest = 1.0 - unit.clamp(0.0, 1.0);
        (90.0 - 90.0 * rest * rest).clamp(self.thetas.0, self.thetas.1)
    }

    fn look(&self, mut look: Look) -> Look {
        let seen = marginals::glance(&*self.member(&look.units), look.theta, look.phi, look.fixed).0;
        look.albedo = if seen.value.is_empty() { 0.0 } else { seen.peak().1 };
        look
    }

    /// Corners and the Sobol sequence.
    fn survey(&self, corners: &[Vec<f64>], glances: usize) -> Vec<Look> {
        let thetas = (glances / 2 / (2 * corners.len()).max(1)).clamp(1, THETAS.len());
        let mut looks = Vec::new();
        for units in corners {
            for &theta in &THETAS[..thetas] {
                let theta = theta.clamp(self.thetas.0, self.thetas.1);
                for fixed in Fixed::BOTH {
                    looks.push(Look { units: units.clone(), theta, phi: 0.0, fixed, albedo: 0.0 });
                }
            }
        }
        let d = self.space.parameters.len();
        for i in 0..glances / 4 {
            let at = |axis: usize| sobol(i, axis, self.seed);
            looks.push(Look {
                units: (0..d).map(at).collect(),
                theta: self.theta(at(d)),
                phi: if self.anisotropic { 180.0 * at(d + 1) } else { 0.0 },
                fixed: Fixed::BOTH[i % 2],
                albedo: 0.0,
            });
        }
        looks.into_par_iter().map(|look| self.look(look)).collect()
    }

    /// Climbs from the best looks that are apart.
    fn climb(&self, mut looks: Vec<Look>, glances: usize) -> Vec<Look> {
        looks.sort_by(|a, b| b.albedo.total_cmp(&a.albedo));
        let apart =
            |a: &Look, b: &Look| a.fixed != b.fixed || a.units.iter().zip(&b.units).any(|(a, b)| (a - b).abs() > 0.15);
        let mut starts: Vec<Look> = Vec::new();
        for look in &looks {
            if starts.len() < CLIMBS && starts.iter().all(|other| apart(look, other)) {
                starts.push(look.clone());
            }
        }
        let steps = glances / starts.len().max(1);
        starts.into_par_iter().enumerate().map(|(i, start)| self.ascend(start, i as u32, steps)).collect()
    }

    fn ascend(&self, mut best: Look, run: u32, steps: usize) -> Look {
        let d = self.space.parameters.len();
        let mut sigma = 0.2;
        for step in 0..steps {
            let draw = |axis: usize| 2.0 * sobol(step, axis, self.seed ^ 0xe5 ^ (run << 8)) - 1.0;
            // Now and then a step that is far wider or finer than the strategy's own.
            let width = sigma * [1.0, 0.2, 1.0, 4.0][step % 4];
            let mut next = best.clone();
            for (axis, unit) in next.units.iter_mut().enumerate() {
                // The cube: most steps change few parameters much.
                *unit = (*unit + width * 2.0 * draw(axis).powi(3)).clamp(0.0, 1.0);
            }
            let rest = (1.0 - next.theta / 90.0).max(0.0).sqrt();
            next.theta = self.theta(1.0 - rest + width * draw(d));
            if self.anisotropic {
                next.phi = (next.phi + 90.0 * width * draw(d + 1)).rem_euclid(180.0);
            }
            let next = self.look(next);
            if next.albedo > best.albedo {
                best = next;
                sigma = (sigma * 1.5).min(0.5);
            } else {
                sigma = (sigma * 0.93).max(1e-3);
            }
        }
        best
    }

    /// Tries pairs of every class on a member.
    fn trial(&self, units: &[f64], index: usize) -> Trial {
        let subject = self.member(units);
        let each = PAIRS / Class::ALL.len();
        let pairs: Vec<Pair> = Class::ALL
            .iter()
            .flat_map(|class| (0..each).map(move |i| class.pair(each * index + i, self.seed)))
            .collect();
        Trial { units: units.to_vec(), worst: worst(&*subject, &pairs) }
    }

    /// Climbs from a trial's pair, member and directions together; `which` is the defect.
    fn worsen(&self, trial: Trial, which: usize) -> Trial {
        const GENERATIONS: usize = 40;
        const OFFSPRING: usize = 16;
        let mut best = trial;
        let mut sigma = 0.2;
        for generation in 0..GENERATIONS {
            if best.worst[which].0 == f64::INFINITY {
                break;
            }
            let draw = |i: usize, axis: usize| 2.0 * sobol(generation * 64 + i, axis, self.seed ^ 0x9a1e) - 1.0;
            let units: Vec<f64> = best
                .units
                .iter()
                .enumerate()
                .map(|(axis, unit)| (unit + 2.0 * sigma * draw(0, axis).powi(3)).clamp(0.0, 1.0))
                .collect();
            let (wi, wo) = best.worst[which].1;
            let mut pairs = vec![(wi, wo)];
            pairs.extend((1..OFFSPRING).map(|i| {
                let sigma = sigma * [1.0, 0.1, 0.01, 3.0][i % 4];
                (moved(wi, sigma, draw(i, 0), draw(i, 1)), moved(wo, sigma, draw(i, 2), draw(i, 3)))
            }));
            let found = worst(&*self.member(&units), &pairs);
            if found[which].0 > best.worst[which].0 {
                best = Trial { units, worst: found };
                sigma = (sigma * 1.5).min(0.5);
            } else {
                sigma = (sigma * 0.85).max(1e-3);
            }
        }
        best
    }

    /// The parameters made round, one after the other, as long as `margin` holds.
    fn rounded(&self, values: Vec<f64>, margin: impl Fn(&[f64]) -> f64) -> Vec<f64> {
        let least = (1.0 - SPARED) * margin(&values);
        let mut values = values;
        for (axis, parameter) in self.space.parameters.iter().enumerate() {
            let Parameter { low, high, default, .. } = *parameter;
            let digits = [1, 2, 3].map(|digits| significant(values[axis], digits).clamp(low, high));
            for round in [default, low, high].into_iter().chain(digits) {
                let mut next = values.clone();
                next[axis] = round;
                if round == values[axis] || margin(&next) >= least {
                    values = next;
                    break;
                }
            }
        }
        values
    }
}

/// Reciprocity, sign and finiteness over some pairs: how bad, and where.
fn worst(subject: &dyn Subject, pairs: &[Pair]) -> [(f64, Pair); 3] {
    let mut worst = [(f64::NEG_INFINITY, pairs[0]); 3];
    let mut note = |which: usize, badness: f64, pair: Pair| {
        if badness > worst[which].0 {
            worst[which] = (badness, pair);
        }
    };
    for ((difference, explained), &pair) in Comparison::new(subject).judged(pairs).into_iter().zip(pairs) {
        note(0, if explained > 0.0 { 0.0 } else { difference.relative }, pair);
    }
    let n = subject.channels().max(1);
    let mut f = vec![0.0; pairs.len() * n];
    subject.evaluate_many(pairs, &mut f);
    for (&pair, f) in pairs.iter().zip(f.chunks_exact(n)) {
        for &f in f {
            if f.is_finite() {
                note(1, -f, pair);
                note(2, 0.0, pair);
            } else {
                note(2, f64::INFINITY, pair);
            }
        }
    }
    worst
}

/// See [`super::check_family`].
pub(super) fn check_family(family: &dyn Family, options: &Options<'_>) -> Report {
    let space = Space { parameters: family.parameters() };
    let defaults = space.defaults();
    let standard = family.subject(&defaults);
    if space.parameters.is_empty() || standard.channels() == 0 {
        let mut report = super::check(&*standard, options);
        report.subject = family.name();
        return report;
    }
    let thetas = options.thetas.iter().copied();
    let thetas = (thetas.clone().fold(f64::INFINITY, f64::min), thetas.fold(f64::NEG_INFINITY, f64::max));
    let corners = space.corners(options.seed);
    let anisotropic = corners.iter().any(|units| is_anisotropic(&*family.subject(&space.values(units)), options.seed));
    let search = Search { family, space, thetas, anisotropic, seed: options.seed };
    let mut evaluations = 4 * 256 * corners.len();
    let mut seen = corners.len();
    let mut suspects: Vec<Vec<f64>> = Vec::new();

    if options.profile != super::Profile::Term && thetas.0 <= thetas.1 {
        let glances = (options.budget / GLANCE).clamp(120, 4_000);
        let mut looks = search.survey(&corners, glances);
        let rest = glances.saturating_sub(looks.len()).max(glances / 4);
        looks.extend(search.climb(looks.clone(), rest));
        evaluations += GLANCE * (looks.len() + rest);
        seen += glances / 4 + rest;
        for fixed in Fixed::BOTH {
            let of_this = looks.iter().filter(|look| look.fixed == fixed);
            let Some(worst) = of_this.max_by(|a, b| a.albedo.total_cmp(&b.albedo)) else { continue };
            let values = search.space.values(&worst.units);
            suspects.push(if worst.albedo > 1.0 {
                let effort = Effort { target: 1e-3, evaluations: 8_000, replicates: 0, ..Effort::default() };
                search.rounded(values, |values| {
                    albedo(&*family.subject(values), worst.theta, worst.phi, fixed, &effort).peak().1 - 1.0
                })
            } else {
                values
            });
        }
    }

    let d = search.space.parameters.len();
    let mut members = corners;
    members.extend((0..64).map(|i| (0..d).map(|axis| sobol(i, axis, options.seed ^ 0x77)).collect()));
    let mut trials: Vec<Trial> =
        members.par_iter().enumerate().map(|(index, units)| search.trial(units, index)).collect();
    evaluations += members.len() * 4 * PAIRS;
    for (which, limit) in [(0, reciprocity::TOLERANCE), (1, super::sanity::NEGATIVE[0]), (2, 0.0)] {
        if which == 0 && options.profile == super::Profile::Term {
            continue;
        }
        trials.sort_by(|a, b| b.worst[which].0.total_cmp(&a.worst[which].0));
        // What the default member shows, its own check will find.
        let starts = if which < 2 { &trials[..trials.len().min(3)] } else { &trials[..1] };
        let found = starts.par_iter().map(|trial| search.worsen(trial.clone(), which));
        let Some(worst) = found.max_by(|a, b| a.worst[which].0.total_cmp(&b.worst[which].0)) else { continue };
        evaluations += 3 * 40 * 64;
        let (badness, pair) = worst.worst[which];
        if badness > limit {
            let margin = |values: &[f64]| {
                let found = self::worst(&*family.subject(values), &[pair])[which].0;
                if found > limit { found } else { f64::NEG_INFINITY }
            };
            suspects.push(search.rounded(search.space.values(&worst.units), margin));
        }
    }

    let mut members = vec![defaults];
    for suspect in suspects {
        if !members.contains(&suspect) {
            members.push(suspect);
        }
    }
    let others = options.budget / members.len().saturating_sub(1).max(1);
    let reports: Vec<(Vec<f64>, Report)> = members
        .into_iter()
        .enumerate()
        .map(|(index, values)| {
            let budget = if index == 0 { options.budget } else { others };
            let member = Options { budget, progress: if index == 0 { options.progress } else { None }, ..*options };
            let subject = family.subject(&values);
            let mut report = examine(&*subject, &member);
            diagnosis::explain(&*subject, &mut report, &member);
            (values, report)
        })
        .collect();
    let mut report = merge(family, &search.space, reports, options);
    report.findings.extend(limits::of_family(family, options));
    report.coverage.evaluations += evaluations;
    report.coverage.members[0] = seen + 64;
    report
}

/// How bad a finding is, for findings of one kind.
fn badness(finding: &Finding) -> (bool, Verdict, f64) {
    let value = match finding.check {
        Check::Sign | Check::Sampling => -finding.value,
        _ => finding.value,
    };
    (finding.binding, finding.verdict, value)
}

/// The worst of each kind of finding, with the parameters of the member that it was found in.
fn merge(family: &dyn Family, space: &Space<'_>, reports: Vec<(Vec<f64>, Report)>, options: &Options<'_>) -> Report {
    let mut merged = Report {
        subject: family.name(),
        channel_names: Vec::new(),
        findings: Vec::new(),
        albedos: Vec::new(),
        coverage: Coverage { seed: options.seed, budget: options.budget, ..Coverage::default() },
        notes: Vec::new(),
    };
    merged.coverage.parameters = space.parameters.to_vec();
    merged.coverage.members = [0, reports.len()];
    let fixed = |finding: &Finding| match finding.place {
        Place::Marginal { fixed, .. } if finding.check == Check::Energy => Some(fixed),
        _ => None,
    };
    let mut albedos: [Vec<Albedo>; 2] = [Vec::new(), Vec::new()];
    for (values, report) in reports {
        if merged.channel_names.is_empty() {
            merged.channel_names = report.channel_names;
        }
        for note in report.notes {
            if !merged.notes.contains(&note) {
                merged.notes.push(note);
            }
        }
        let Coverage { evaluations, integrals, pairs, restarts, anisotropic, .. } = report.coverage;
        merged.coverage.evaluations += evaluations;
        merged.coverage.integrals += integrals;
        merged.coverage.pairs += pairs;
        merged.coverage.restarts += restarts;
        merged.coverage.anisotropic |= anisotropic;
        for mut finding in report.findings {
            let names = space.parameters.iter().map(|parameter| parameter.name.clone());
            finding.parameters = names.zip(values.iter().copied()).collect();
            let same = |other: &&mut Finding| {
                (other.check, other.single, fixed(other)) == (finding.check, finding.single, fixed(&finding))
            };
            let marginal = fixed(&finding);
            match merged.findings.iter_mut().find(same) {
                Some(other) => {
                    let (a, b) = (badness(other), badness(&finding));
                    if (b.0, b.1).cmp(&(a.0, a.1)).then(b.2.total_cmp(&a.2)).is_le() {
                        continue;
                    }
                    *other = finding;
                }
                None => merged.findings.push(finding),
            }
            if let Some(marginal) = marginal {
                let of_this = report.albedos.iter().filter(|albedo| albedo.fixed == marginal);
                albedos[usize::from(marginal == Fixed::Light)] = of_this.cloned().collect();
            }
        }
    }
    merged.albedos = albedos.into_iter().flatten().collect();
    merged
}
