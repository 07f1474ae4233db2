//! The judge of physical plausibility: whether a BRDF conserves energy, is reciprocal, finite and not negative.
//!
//! A subject is anything that returns f for two directions ([`Subject`], or a closure by [`from_fn`]). [`check`] returns a
//! [`Report`] with a finding per check, each with the place to see it again; [`assert_plausible`] is the same for tests.
//!
//! ```
//! use brdf::check::{self, Check, Fixed, Verdict};
//!
//! // Blinn–Phong with the factor (n+8)/8π that game engines use, n = 10.
//! let subject = check::from_fn("Blinn–Phong", 1, |wi, wo, f| {
//!     let h = brdf::half_vector(wi, wo).normalized();
//!     f[0] = 18.0 / (8.0 * std::f64::consts::PI) * h.z.max(0.0).powi(10);
//! });
//! let report = check::check(&subject, &check::Options { thetas: &[0.0, 45.0], ..Default::default() });
//! assert_eq!(report.verdict(), Verdict::Fail);
//! let energy = report.energy(Fixed::Light).unwrap();
//! assert!((energy.value - 1.075).abs() < 1e-3, "{report}");
//! assert_eq!(report.finding(Check::Reciprocity).unwrap().verdict, Verdict::Pass);
//! ```
//!
//! # How far to trust it
//!
//! Albedos come from an adaptive cubature on a chart in which lobes at the mirror direction cannot hide, and from a
//! randomised quasi-Monte Carlo estimate that must agree ([`energy`]). A narrow lobe anywhere else is found if it can be
//! climbed to from the mirror, the retro direction, the normal or some fifty others, and then has a chart of its own; it
//! can otherwise be missed. A ring about the normal is found from half a degree of width on; one of .15° was passed once
//! in three seeds. Every other check samples, in double precision. A pass says what was looked at; it is not a proof.

mod atlas;
mod chart;
#[cfg(test)]
mod corpus;
mod crosscheck;
pub mod diagnosis;
pub mod energy;
#[cfg(feature = "shader")]
pub mod explorer;
pub mod family;
pub mod limits;
mod lobes;
mod marginals;
mod material;
pub mod merl;
pub mod output;
pub mod pairs;
pub mod prove;
mod quadrature;
pub mod reciprocity;
pub mod report;
pub mod sampling;
pub mod sanity;
mod search;
#[cfg(feature = "shader")]
pub mod shader;
pub mod sniff;
mod space;
mod stack;
pub mod subject;
mod table;
pub mod verdict;

pub use diagnosis::Cause;
pub use energy::{Albedo, Effort, albedo};
#[cfg(feature = "shader")]
pub use explorer::{Explorer, ExplorerError};
pub use family::{Family, Parameter, Scale};
pub use marginals::THETAS;
pub use material::MaterialFamily;
pub use merl::Merl;
pub use report::{Check, Coverage, Finding, Place, Report};
pub use stack::StackSubject;
pub use subject::{Fixed, FromFn, Sample, Subject, from_fn};
pub use verdict::{TOLERANCE, Verdict};

use pairs::Class;
use subject::Watch;

/// What a violation is held to be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Profile {
    /// Every check binds.
    #[default]
    Strict,
    /// What a real-time renderer can live without is advisory: reciprocity, and energy with the light fixed.
    Realtime,
    /// A measurement: energy and sign bind within [`Options::tolerance`], the data's own; reciprocity is advisory, as storage
    /// often folds it in.
    Measured,
    /// A single term, not a BRDF: finite and not negative, and normalised if [`Options::distribution`] says so.
    Term,
}

impl Profile {
    /// Every profile.
    pub const ALL: [Profile; 4] = [Profile::Strict, Profile::Realtime, Profile::Measured, Profile::Term];

    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Profile::Strict => "strict",
            Profile::Realtime => "realtime",
            Profile::Measured => "measured",
            Profile::Term => "term",
        }
    }

    /// Whether what a check finds at a place counts, or only advises.
    pub fn binds(self, check: Check, place: Place) -> bool {
        let light = matches!(place, Place::Marginal { fixed: Fixed::Light, .. });
        match self {
            Profile::Strict => true,
            Profile::Realtime => !(light || check == Check::Reciprocity),
            Profile::Measured => check != Check::Reciprocity,
            Profile::Term => !matches!(check, Check::Energy | Check::Reciprocity),
        }
    }
}

/// How to check.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// Seed of every random choice.
    pub seed: u32,
    /// Evaluations per subject to aim for. Unclear integrals may take more, clear ones less.
    pub budget: usize,
    /// Polar angles in degrees, in [0, 90), that albedos are integrated at.
    pub thetas: &'a [f64],
    /// Which findings bind.
    pub profile: Profile,
    /// What an albedo may exceed 1 by, [`TOLERANCE`] unless the subject is known no better; in [`Profile::Measured`] also what f may
    /// be below 0 by, in sr⁻¹.
    pub tolerance: f64,
    /// Whether the subject is a distribution of normals, a function of `wi` that stands for the normal: ∫ D cosθ = 1 is
    /// checked too.
    pub distribution: bool,
    /// Called with the steps done and their total, from any thread.
    pub progress: Option<&'a (dyn Fn(usize, usize) + Sync)>,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Options {
            seed: 1,
            budget: 1_500_000,
            thetas: &THETAS,
            profile: Profile::Strict,
            tolerance: TOLERANCE,
            distribution: false,
            progress: None,
        }
    }
}

impl core::fmt::Debug for Options<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Options")
            .field("seed", &self.seed)
            .field("budget", &self.budget)
            .field("thetas", &self.thetas)
            .field("profile", &self.profile)
            .field("tolerance", &self.tolerance)
            .field("distribution", &self.distribution)
            .finish_non_exhaustive()
    }
}

/// Puts a subject through every check.
///
/// Energy with the view fixed and with the light fixed, at every angle of [`Options::thetas`], at bumps between them, and then
/// uphill from the worst; at several azimuths if the subject is measured to be anisotropic. Reciprocity, finiteness and sign
/// over [`Class`]es of pairs. Its samples, if it draws any. The findings come in that order, failures with their likely
/// [`Cause`]; the same options give the same report.
pub fn check(subject: &dyn Subject, options: &Options<'_>) -> Report {
    let mut report = examine(subject, options);
    diagnosis::explain(subject, &mut report, options);
    report
}

/// Puts the members of a family through every check, and reports the worst that was found for each.
///
/// The box of the parameters is searched together with the angles and the pairs of directions: its corners, then evenly, then
/// uphill. The default member and the worst ones, their parameters made round, go through [`check`]. A family without
/// parameters is checked as its one member; with them it takes about three times [`Options::budget`], and
/// more where integrals stay unclear.
pub fn check_family(family: &dyn Family, options: &Options<'_>) -> Report {
    search::check_family(family, options)
}

/// [`check`] without the causes.
fn examine(subject: &dyn Subject, options: &Options<'_>) -> Report {
    let mut report = Report {
        subject: subject.name(),
        channel_names: (0..subject.channels()).map(|channel| subject.channel_name(channel)).collect(),
        findings: Vec::new(),
        albedos: Vec::new(),
        coverage: Coverage { seed: options.seed, budget: options.budget, ..Coverage::default() },
        notes: Vec::new(),
    };
    // 9 classes, some 5 evaluations a pair: a tenth of the budget.
    let samples = (options.budget / 10 / (5 * Class::ALL.len())).clamp(64, 1 << 16);
    let mut watch = Watch::default();
    if options.profile != Profile::Term {
        let anisotropic = is_anisotropic(subject, options.seed);
        let azimuths = if anisotropic { &marginals::AZIMUTHS[..] } else { &marginals::AZIMUTHS[..1] };
        let plan = marginals::Plan {
            thetas: options.thetas,
            azimuths,
            effort: effort(options, azimuths.len()),
            tolerance: options.tolerance,
            progress: options.progress,
        };
        let energy = marginals::energy(subject, &plan);
        report.findings.extend(energy.findings);
        report.coverage.integrals = energy.albedos.len();
        report.coverage.anisotropic = anisotropic;
        report.coverage.evaluations += energy.evaluations + 4 * ROTATIONS;
        report.albedos = energy.albedos;
        watch = energy.watch;
        let (finding, [evaluations, pairs, restarts]) = reciprocity::reciprocity(subject, samples, options.seed);
        report.findings.push(finding);
        report.coverage.evaluations += evaluations;
        report.coverage.pairs += pairs;
        report.coverage.restarts += restarts;
    } else if options.distribution {
        let (finding, evaluations) = limits::normalisation(subject, options.seed);
        report.findings.push(finding);
        report.coverage.evaluations += evaluations;
    }
    let (mut findings, evaluations) = sanity::sanity(subject, samples, options.seed);
    sanity::heed(subject, &watch, &mut findings);
    report.findings.extend(findings);
    report.coverage.evaluations += evaluations;
    report.coverage.pairs = report.coverage.pairs.max(samples * Class::ALL.len());
    report.findings.extend(sanity::precision(subject, samples, options.seed));
    if options.profile != Profile::Term && subject.samples() {
        let (findings, evaluations) = sampling::sampling(subject, options.budget / 5, options.seed);
        report.findings.extend(findings);
        report.coverage.evaluations += evaluations;
    }
    for finding in &mut report.findings {
        soften(finding, options);
        finding.values = values(subject, finding.place);
    }
    report.notes = subject.notes();
    report
}

/// What a profile lets pass, or does not bind.
fn soften(finding: &mut Finding, options: &Options<'_>) {
    finding.binding &= options.profile.binds(finding.check, finding.place);
    if options.profile == Profile::Measured && finding.check == Check::Sign {
        finding.limit = finding.limit.min(-options.tolerance);
        if finding.value >= finding.limit {
            finding.verdict = Verdict::Pass;
        }
    }
}

/// f at a pair of directions, by all that computes it here.
fn values(subject: &dyn Subject, place: Place) -> Option<report::Values> {
    let Place::Pair { wi, wo } = place else { return None };
    let mut double = vec![0.0; subject.channels()];
    subject.evaluate(wi, wo, &mut double);
    let mut single = vec![0.0; subject.channels()];
    if !subject.evaluate_single(wi.cast(), wo.cast(), &mut single) {
        single.clear();
    }
    Some(report::Values { double, single: single.into_iter().map(f64::from).collect(), gpu: Vec::new() })
}

/// Shares the budget out over the integrals.
fn effort(options: &Options<'_>, azimuths: usize) -> Effort {
    let integrals = (2 * options.thetas.len() * azimuths).max(1);
    let each = options.budget / integrals;
    // Two thirds to the cubature, as much of the rest as a power of two takes to 16 replicates. The floors are what sees a
    // Lambert surface at all.
    let samples = (each / 6 / 16).max(64).next_power_of_two().min(1 << 16);
    Effort { evaluations: (each / 3 * 2).max(10_000), samples, seed: options.seed, ..Effort::default() }
}

const ROTATIONS: usize = 256;

/// Whether a common rotation about the normal changes f by more than rounding can.
fn is_anisotropic(subject: &dyn Subject, seed: u32) -> bool {
    let mut pairs = Vec::with_capacity(4 * ROTATIONS);
    for i in 0..2 * ROTATIONS {
        let class = if i % 2 == 0 { Class::Hemisphere } else { Class::Mirror };
        let (wi, wo) = class.pair(i, seed);
        // Multiples of the golden angle: no symmetry of a figure hides from them.
        let angle = 2.399_963_229_728_653 * (i + 1) as f64;
        pairs.extend([(wi, wo), (pairs::turned(wi, angle), pairs::turned(wo, angle))]);
    }
    let n = subject.channels().max(1);
    let mut f = vec![0.0; pairs.len() * n];
    subject.evaluate_many(&pairs, &mut f);
    f.chunks_exact(2 * n).any(|both| {
        let (f, g) = both.split_at(n);
        f.iter().zip(g).any(|(f, g)| (f - g).abs() > 1e-5 * f.abs().max(g.abs()).max(1e-3))
    })
}

/// Checks a subject with the default options, for a test of one's own.
///
/// # Panics
///
/// If the verdict is not [`Verdict::Pass`], with the report.
pub fn assert_plausible(subject: &dyn Subject) {
    let report = check(subject, &Options::default());
    assert!(report.verdict() == Verdict::Pass, "not plausible\n{report}");
}

/// [`assert_plausible`] for every member of a family.
///
/// # Panics
///
/// If the verdict is not [`Verdict::Pass`], with the report.
pub fn assert_family_plausible(family: &dyn Family) {
    let report = check_family(family, &Options::default());
    assert!(report.verdict() == Verdict::Pass, "not plausible\n{report}");
}

#[cfg(test)]
mod tests {
    use super::corpus::{ggx_smith, lambert, view_scaled};
    use super::*;
    use core::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn plausible_subjects_are_asserted() {
        assert_plausible(&lambert());
    }

    #[test]
    #[should_panic(expected = "[light fixed]")]
    fn implausible_subjects_panic_with_the_counterexample() {
        assert_plausible(&view_scaled(0.5));
    }

    #[test]
    fn reports_repeat_and_progress_ends() {
        let (steps, last) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let progress = |done: usize, total: usize| {
            steps.fetch_add(1, Ordering::Relaxed);
            if done == total {
                last.store(total, Ordering::Relaxed);
            }
        };
        let options = Options { budget: 200_000, thetas: &[0.0, 60.0, 89.0], seed: 9, ..Options::default() };
        let watched = check(&ggx_smith(0.2), &Options { progress: Some(&progress), ..options });
        assert_eq!(watched, check(&ggx_smith(0.2), &options));
        assert_eq!(steps.into_inner(), last.into_inner());
        let other = check(&ggx_smith(0.2), &Options { seed: 10, ..options });
        assert_eq!(other.verdict(), watched.verdict());
    }

    #[test]
    fn profiles_choose_what_binds() {
        let subject = view_scaled(0.5);
        let verdict = |profile| check(&subject, &Options { profile, ..Options::default() }).verdict();
        assert_eq!(verdict(Profile::Strict), Verdict::Fail);
        assert_eq!(verdict(Profile::Realtime), Verdict::Pass);
        assert_eq!(verdict(Profile::Term), Verdict::Pass);
    }

    #[test]
    fn measurements_are_judged_within_their_own_error() {
        // 1.003 reflected, 5e-4 below 0 near grazing, and no data for it to be reciprocal.
        let subject = super::corpus::one("measured", |wi, wo| {
            let albedo = if wi.z.min(wo.z) < 0.05 { -5e-4 } else { 1.003 / core::f64::consts::PI };
            albedo * (1.0 + 1e-6 * wi.z)
        });
        let with = |profile, tolerance| check(&subject, &Options { profile, tolerance, ..Options::default() });
        let report = with(Profile::Measured, 5e-3);
        assert_eq!(report.verdict(), Verdict::Pass, "{report}");
        let reciprocity = report.finding(Check::Reciprocity);
        assert!(reciprocity.is_some_and(|f| f.verdict == Verdict::Fail && !f.binding), "{report}");
        let sign = report.finding(Check::Sign);
        assert!(sign.is_some_and(|f| f.value < 0.0 && f.limit == -5e-3), "{report}");
        // An error of the data that is less than what they are off by.
        for tolerance in [1e-4, 4e-4] {
            let report = with(Profile::Measured, tolerance);
            assert_eq!(report.finding(Check::Sign).map(|f| f.verdict), Some(Verdict::Fail), "{report}");
        }
        assert_eq!(with(Profile::Strict, 5e-3).verdict(), Verdict::Fail);
    }

    #[test]
    fn distributions_are_normalised() {
        let term = Options { profile: Profile::Term, distribution: true, ..Options::default() };
        for (scale, verdict) in [(1.0, Verdict::Pass), (core::f64::consts::PI, Verdict::Fail), (0.9, Verdict::Fail)] {
            for alpha in [1e-3, 0.3, 1.0] {
                let subject = super::corpus::one("D", move |wi, _| scale * super::corpus::ggx(wi, alpha));
                let report = check(&subject, &term);
                let found = report.finding(Check::Normalisation);
                assert!(
                    found.is_some_and(|f| f.verdict == verdict && (f.value / scale - 1.0).abs() < 1e-3),
                    "{report}"
                );
                assert_eq!(report.verdict(), verdict, "{report}");
                let plain = check(&subject, &Options { distribution: false, ..term });
                assert!(plain.finding(Check::Normalisation).is_none() && plain.verdict() == Verdict::Pass, "{plain}");
            }
        }
    }
}
