//! The judge's own regression corpus: models whose verdicts are known, put to it at the default budget under three seeds.
//!
//! A model's verdict is known from its analysis (the comments say which), from the table of known verdicts, or from [`grid`],
//! an integration by another method that shares nothing with the judge's and is good where lobes are wide. No false alarm and
//! no miss is allowed, and a cause is named where it is planted and nowhere else.

#![cfg(feature = "check")]

mod diffuse;
mod disney;
mod empirical;
mod families;
mod faults;
mod grid;
mod microfacet;
mod printed;
mod stacks;
mod strangers;
mod trials;

use brdf::Vector;
use brdf::check::{self, Cause, Check, Finding, Fixed, Options, Report, Subject, Verdict};

/// The seeds that every model is judged under.
const SEEDS: [u32; 3] = [1, 2, 77];

type Function = Box<dyn Fn(Vector<f64>, Vector<f64>, &mut [f64]) + Send + Sync>;

/// What the energy of a marginal must come out as.
#[derive(Clone, Copy, Debug)]
enum Energy {
    /// It passes.
    Pass,
    /// It passes, and the maximum is this within the second.
    At(f64, f64),
    /// It fails, with this value within the second relatively.
    Fail(f64, f64),
    /// It fails.
    Over,
    /// It must not fail.
    NotFail,
    /// Whatever the grid says.
    Grid,
    /// It is not looked at: a defect makes it meaningless.
    Any,
}

/// A model and what must be found.
struct Case {
    subject: Box<dyn Subject + Send>,
    energy: [Energy; 2],
    fails: Vec<Check>,
    cause: Option<Cause>,
    any_cause: bool,
}

/// A one-channel model that must pass every check.
fn one(name: impl Into<String>, f: impl Fn(Vector<f64>, Vector<f64>) -> f64 + Send + Sync + 'static) -> Case {
    let lit: Function = Box::new(move |wi, wo, out| out[0] = if wi.z > 0.0 && wo.z > 0.0 { f(wi, wo) } else { 0.0 });
    of(check::from_fn(name, 1, lit))
}

fn of(subject: impl Subject + Send + 'static) -> Case {
    Case { subject: Box::new(subject), energy: [Energy::Pass; 2], fails: Vec::new(), cause: None, any_cause: false }
}

impl Case {
    fn energy(self, energy: Energy) -> Self {
        Case { energy: [energy; 2], ..self }
    }
    /// Fails in both marginals with a known maximum, within .6 %.
    fn reaches(self, value: f64) -> Self {
        self.energy(Energy::Fail(value, 0.006))
    }
    /// Passes in both marginals with a known maximum.
    fn peaks(self, value: f64) -> Self {
        self.energy(Energy::At(value, 1e-3))
    }
    fn grid(self) -> Self {
        self.energy(Energy::Grid)
    }
    fn marginals(self, view: Energy, light: Energy) -> Self {
        Case { energy: [view, light], ..self }
    }
    fn fails(mut self, check: Check) -> Self {
        self.fails.push(check);
        self
    }
    fn cause(self, cause: Cause) -> Self {
        Case { cause: Some(cause), ..self }
    }
    /// A cause may be named, and it is not said which.
    fn any_cause(self) -> Self {
        Case { any_cause: true, ..self }
    }

    /// What is wrong with a report; nothing if it is right.
    fn complaints(&self, report: &Report) -> Vec<String> {
        let mut complaints = Vec::new();
        for (fixed, expected) in Fixed::BOTH.into_iter().zip(self.energy) {
            let Some(finding) = report.energy(fixed) else {
                complaints.push(format!("no energy with the {} fixed", fixed.name()));
                continue;
            };
            let right = match expected {
                Energy::Pass => finding.verdict == Verdict::Pass,
                Energy::At(value, off) => finding.verdict == Verdict::Pass && (finding.value - value).abs() <= off,
                Energy::Fail(value, off) => {
                    finding.verdict == Verdict::Fail && (finding.value / value - 1.0).abs() <= off
                }
                Energy::Over => finding.verdict == Verdict::Fail,
                Energy::NotFail => finding.verdict != Verdict::Fail,
                Energy::Grid => grid::agrees(&*self.subject, fixed, finding),
                Energy::Any => true,
            };
            if !right {
                complaints.push(format!("{expected:?} expected: {finding}"));
            }
        }
        for check in [Check::Reciprocity, Check::Finite, Check::Sign, Check::Sampling, Check::Density, Check::Weight] {
            let failing = self.fails.contains(&check);
            for finding in report.findings.iter().filter(|finding| finding.check == check) {
                let right = if failing { Verdict::Fail } else { Verdict::Pass };
                if finding.verdict != right {
                    complaints.push(format!("{right} expected: {finding}"));
                }
            }
        }
        if !self.any_cause {
            complaints.extend(wrong_causes(&report.findings, self.cause));
        }
        complaints
    }
}

/// Causes that are named and should not be, or should be and are not.
fn wrong_causes(findings: &[Finding], planted: Option<Cause>) -> Vec<String> {
    let named: Vec<&str> = findings.iter().map(|f| f.cause.as_str()).filter(|cause| !cause.is_empty()).collect();
    match planted {
        Some(cause) if !named.contains(&cause.text()) => vec![format!("{cause:?} is not named, but {named:?}")],
        _ => named
            .into_iter()
            .filter(|named| planted.is_none_or(|cause| cause.text() != *named))
            .map(|named| format!("named and not planted: {named}"))
            .collect(),
    }
}

/// Judges every case under every seed; panics with all that is wrong.
fn judge_all(cases: &[Case]) {
    let mut wrong = Vec::new();
    for case in cases {
        for seed in SEEDS {
            let start = std::time::Instant::now();
            let report = check::check(&*case.subject, &Options { seed, ..Options::default() });
            let energies: Vec<String> = report.findings.iter().take(2).map(ToString::to_string).collect();
            println!(
                "{:32} {:12} {:9} {:>6.0?} {}",
                report.subject,
                report.verdict(),
                report.coverage.evaluations,
                start.elapsed(),
                energies.join("  ")
            );
            let complaints = case.complaints(&report);
            if !complaints.is_empty() {
                wrong.push(format!("seed {seed}: {}\n{report}", complaints.join("\n")));
            }
        }
    }
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}
