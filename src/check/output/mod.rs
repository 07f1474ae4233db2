//! What a run of the checker hands on: JSON, JUnit XML, an HTML page with plots; and what is done with such reports
//! afterwards, merging the shards of one run and accepting what is already known.
//!
//! ```
//! use brdf::check::{self, output::{Entry, Outcome, Run}};
//!
//! let lambert = check::from_fn("Lambert", 1, |_, _, f| f[0] = std::f64::consts::FRAC_1_PI);
//! let report = check::check(&lambert, &check::Options { thetas: &[0.0, 60.0], ..Default::default() });
//! let run = Run { entries: vec![Entry::judged(0, "Lambert", "closure", report)], ..Run::new() };
//! let json = run.to_json();
//! assert_eq!(Run::from_json(&json)?, run);
//! assert!(run.to_junit().contains("<testcase"));
//! # Ok::<(), check::output::OutputError>(())
//! ```

mod baseline;
pub mod figures;
mod html;
mod json;
mod junit;
mod merge;
pub mod plots;
mod read;
mod svg;

pub use baseline::Acceptance;
pub use figures::Figures;
pub use json::VERSION;

use super::report::Report;
use super::verdict::Verdict;
use core::fmt::{self, Display, Formatter};

/// The subjects of one run of the checker, and what was found about each.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The program that made it, with its version.
    pub tool: String,
    /// What ran the twins on a GPU, or why nothing did.
    pub twins: String,
    /// How many subjects the whole run has, those of other shards included.
    pub total: usize,
    /// Which part of the whole this is; nothing if it is the whole.
    pub shard: Option<Shard>,
    /// The subjects of this part, by [`Entry::index`].
    pub entries: Vec<Entry>,
}

/// Part `number` of `of`, counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which part, from 1.
    pub number: usize,
    /// Of how many.
    pub of: usize,
}

/// One subject of a [`Run`].
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Its place among all subjects of the whole run, from 0.
    pub index: usize,
    /// What the user called it: a path, the name of a built-in material.
    pub source: String,
    /// What it was read as: `WGSL`, `MERL`, the model of a stack.
    pub kind: String,
    /// What came of it.
    pub outcome: Outcome,
}

/// Whether a subject was judged.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// It was.
    Judged {
        /// What was found.
        report: Box<Report>,
        /// Samples to draw pictures from; only where they were asked for.
        figures: Option<Box<Figures>>,
    },
    /// It could not be read, and this is why.
    Refused {
        /// One line: what, where, how to mend it.
        reason: String,
        /// Whether that does not count: a baseline knows of it, or it is no BRDF and was met in a folder.
        accepted: bool,
    },
}

impl Run {
    /// A run of this version, without subjects.
    pub fn new() -> Self {
        Run {
            tool: concat!("brdf ", env!("CARGO_PKG_VERSION")).to_owned(),
            twins: "not run".to_owned(),
            total: 0,
            shard: None,
            entries: Vec::new(),
        }
    }

    /// The reports of the subjects that were judged.
    pub fn reports(&self) -> impl Iterator<Item = &Report> {
        self.entries.iter().filter_map(Entry::report)
    }

    /// The subjects that could not be read where that counts, with the reason.
    pub fn refused(&self) -> impl Iterator<Item = (&Entry, &str)> {
        self.entries.iter().filter_map(|entry| match &entry.outcome {
            Outcome::Refused { reason, accepted: false } => Some((entry, reason.as_str())),
            _ => None,
        })
    }

    /// The worst verdict of the subjects that were judged; inconclusive if none was and something was to be.
    ///
    /// A shard may be empty, where there are fewer subjects than shards: that is a pass.
    pub fn verdict(&self) -> Verdict {
        let nothing =
            if self.entries.is_empty() && self.shard.is_none() { Verdict::Inconclusive } else { Verdict::Pass };
        self.reports().map(Report::verdict).max().unwrap_or(nothing)
    }

    /// What a process that reports this run exits with: 1 if something violates, else 2 if something could not be read,
    /// else 3 if something is inconclusive, else 0.
    pub fn exit_code(&self) -> u8 {
        match self.verdict() {
            Verdict::Fail => 1,
            _ if self.refused().next().is_some() => 2,
            verdict => verdict.exit_code(),
        }
    }

    /// The last line of a report: how many subjects there were, and what came of them.
    pub fn summary(&self) -> String {
        let count = |wanted| self.reports().filter(|report| report.verdict() == wanted).count();
        let (failed, open) = (count(Verdict::Fail), count(Verdict::Inconclusive));
        let refused = self.refused().count();
        let head = if refused > 0 && self.verdict() != Verdict::Fail { "REFUSED" } else { self.verdict().name() };
        let mut line = format!("{head}: {} judged, {failed} violate, {open} inconclusive", self.reports().count());
        if refused > 0 {
            line.push_str(&format!(", {refused} refused"));
        }
        let skipped = self.entries.len() - self.reports().count() - refused;
        if skipped > 0 {
            line.push_str(&format!(", {skipped} skipped"));
        }
        if let Some(shard) = self.shard {
            line.push_str(&format!(" (shard {shard} of {} subjects)", self.total));
        }
        line
    }
}

impl Default for Run {
    fn default() -> Self {
        Run::new()
    }
}

impl Entry {
    /// A subject that was judged, without figures.
    pub fn judged(index: usize, source: impl Into<String>, kind: impl Into<String>, report: Report) -> Self {
        let outcome = Outcome::Judged { report: Box::new(report), figures: None };
        Entry { index, source: source.into(), kind: kind.into(), outcome }
    }

    /// A subject that could not be read.
    pub fn refused(
        index: usize,
        source: impl Into<String>,
        kind: impl Into<String>,
        reason: impl Into<String>,
    ) -> Self {
        let outcome = Outcome::Refused { reason: reason.into(), accepted: false };
        Entry { index, source: source.into(), kind: kind.into(), outcome }
    }

    /// The report, if the subject was judged.
    pub fn report(&self) -> Option<&Report> {
        match &self.outcome {
            Outcome::Judged { report, .. } => Some(report),
            Outcome::Refused { .. } => None,
        }
    }

    /// The subject's own name if it was judged, else what the user called it.
    pub fn name(&self) -> &str {
        self.report().map_or(&self.source, |report| &report.subject)
    }

    /// The verdict; else `REFUSED`, or `SKIPPED` where that does not count.
    pub fn verdict_name(&self) -> &'static str {
        match &self.outcome {
            Outcome::Judged { report, .. } => report.verdict().name(),
            Outcome::Refused { accepted: false, .. } => "REFUSED",
            Outcome::Refused { accepted: true, .. } => "SKIPPED",
        }
    }
}

impl Shard {
    /// Reads `K/N`, with 1 ≤ K ≤ N.
    ///
    /// ```
    /// use brdf::check::output::Shard;
    /// assert_eq!(Shard::parse("2/5")?, Shard { number: 2, of: 5 });
    /// assert!(Shard::parse("0/5").is_err() && Shard::parse("6/5").is_err());
    /// # Ok::<(), brdf::check::output::OutputError>(())
    /// ```
    pub fn parse(text: &str) -> Result<Self, OutputError> {
        let parts = text.split_once('/').and_then(|(number, of)| Some((number.parse().ok()?, of.parse().ok()?)));
        match parts {
            Some((number, of)) if 1 <= number && number <= of => Ok(Shard { number, of }),
            _ => Err(OutputError(format!("`{text}` is no shard: K/N with 1 ≤ K ≤ N, as 2/5"))),
        }
    }

    /// Whether the subject at `index` of the whole belongs to this part: every N-th does, so that neighbours, which cost
    /// alike, are spread.
    pub fn holds(self, index: usize) -> bool {
        index % self.of.max(1) + 1 == self.number
    }
}

impl Display for Shard {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

/// Why a report could not be read or put together: one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputError(pub(super) String);

impl Display for OutputError {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for OutputError {}

#[cfg(test)]
pub(super) mod tests {
    use super::super::report::{Check, Coverage, Finding, Place, Values};
    use super::super::subject::Fixed;
    use super::super::{Albedo, Parameter, Scale};
    use super::*;
    use crate::frame::Vector;

    /// A report with a finding of every shape that JSON must carry.
    pub(in super::super) fn report(name: &str, verdict: Verdict) -> Report {
        let energy = Finding {
            verdict,
            value: 1.249,
            error: 0.0004,
            limit: 1.001,
            place: Place::Marginal { theta: 80.0, phi: 35.0, fixed: Fixed::Light },
            channel: Some((1, "g".into())),
            note: "a <note> & \"more\"".into(),
            parameters: vec![("roughness".into(), 0.3), ("metal\u{1}lic".into(), 1.0 / 3.0)],
            cause: "view-only scaling".into(),
            again: "brdf check --wgsl 'my file.wgsl' --at light,theta=80".into(),
            ..Finding::new(Check::Energy)
        };
        let sign = Finding {
            single: true,
            verdict: Verdict::Pass,
            value: f64::NEG_INFINITY,
            limit: f64::INFINITY,
            error: f64::NAN,
            place: Place::Pair { wi: Vector::new(0.6, 0.0, 0.8), wo: Vector::new(-0.1, 1e-7, 1.0 / 3.0) },
            values: Some(Values { double: vec![f64::NAN, 0.1 + 0.2], single: vec![1.0], gpu: Vec::new() }),
            ..Finding::new(Check::Sign)
        };
        let parameters =
            vec![Parameter { name: "roughness".into(), low: 0.01, high: 1.0, default: 0.5, scale: Scale::Logarithmic }];
        let albedo = Albedo {
            theta: 80.0,
            phi: 0.0,
            fixed: Fixed::View,
            value: vec![0.1, 1.0 / 3.0],
            error: vec![1e-5, 2e-5],
            cross_check: vec![0.1, 0.33],
            standard_error: vec![1e-6, 0.0],
            agrees: true,
            non_finite: 2,
            evaluations: 1234,
        };
        Report {
            subject: name.into(),
            channel_names: vec!["r".into(), "g".into()],
            findings: vec![energy, sign],
            albedos: vec![albedo],
            coverage: Coverage { seed: 3, budget: 4, pairs: 7, parameters, members: [9, 2], ..Coverage::default() },
            notes: vec!["16 bins hold no data".into()],
        }
    }

    /// The same with NaN made comparable.
    pub(super) fn text_of(run: &Run) -> String {
        format!("{run:?}")
    }

    #[test]
    fn exit_codes_rank_violations_over_bad_input_over_doubt() {
        let run = |entries: Vec<Entry>| Run { total: entries.len(), entries, ..Run::new() };
        let judged = |verdict| Entry::judged(0, "a", "k", report("a", verdict));
        let refused = Entry::refused(1, "b", "k", "torn");
        assert_eq!(run(vec![judged(Verdict::Pass)]).exit_code(), 0);
        assert_eq!(run(vec![judged(Verdict::Inconclusive)]).exit_code(), 3);
        assert_eq!(run(vec![judged(Verdict::Inconclusive), refused.clone()]).exit_code(), 2);
        assert_eq!(run(vec![judged(Verdict::Fail), refused.clone()]).exit_code(), 1);
        assert_eq!(run(vec![refused]).exit_code(), 2);
        assert_eq!(run(vec![]).exit_code(), 3);
        let shard = Some(Shard { number: 3, of: 3 });
        assert_eq!(Run { shard, total: 2, ..Run::new() }.exit_code(), 0);
    }

    #[test]
    fn shards_part_the_whole() {
        for of in 1..5 {
            for index in 0..20 {
                let holders = (1..=of).filter(|&number| Shard { number, of }.holds(index)).count();
                assert_eq!(holders, 1, "{index} of {of}");
            }
        }
        for bad in ["", "1", "0/0", "0/1", "2/1", "-1/2", "1/2/3", "a/b"] {
            assert!(Shard::parse(bad).is_err(), "{bad}");
        }
    }
}
