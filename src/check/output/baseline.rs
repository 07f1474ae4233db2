//! What is known already: findings of an earlier report that a run may repeat without failing.

use super::{Outcome, Run};
use crate::check::report::{Check, Finding, Place, Report};
use crate::check::verdict::{TOLERANCE, Verdict};

/// What a baseline had to do with a run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Acceptance {
    /// Findings that were accepted, one line each.
    pub accepted: Vec<String>,
    /// Findings that the baseline knows in a milder form, one line each. They count.
    pub worse: Vec<String>,
    /// What the baseline knows and the run did not find, one line each: the baseline can be made again without it.
    pub gone: Vec<String>,
}

/// How much larger than the baseline's a value may be that was searched for, and has no error of its own: two searches
/// from other seeds stop within some percent of each other.
const SEARCHED: f64 = 1.25;

impl Run {
    /// Accepts the findings that `baseline` has as well, and no worse; they no longer count in any verdict.
    ///
    /// Findings are the same if they are of the same source, check, precision and marginal. An albedo is worse if it exceeds
    /// the known one by more than both errors and the judge's tolerance; any other value if it exceeds the known one by a
    /// quarter, where a count is taken as a share of the pairs that were tried; any failure if only doubt was known.
    pub fn accept(&mut self, baseline: &Run) -> Acceptance {
        let mut acceptance = Acceptance::default();
        // A shard is not told that the subjects of the others are gone.
        for known in baseline.entries.iter().filter(|_| self.shard.is_none()) {
            if !self.entries.iter().any(|entry| entry.source == known.source && entry.name() == known.name()) {
                acceptance.gone.push(format!("{}: is no longer judged", known.source));
            }
        }
        for entry in &mut self.entries {
            let same = |known: &&super::Entry| known.source == entry.source && known.name() == entry.name();
            let known = baseline.entries.iter().find(same);
            let source = entry.source.clone();
            match (&mut entry.outcome, known.map(|known| &known.outcome)) {
                (Outcome::Refused { reason, accepted: accepted @ false }, Some(Outcome::Refused { .. })) => {
                    *accepted = true;
                    acceptance.accepted.push(format!("{source}: refused: {reason}"));
                }
                (Outcome::Judged { .. }, Some(Outcome::Refused { reason, .. })) => {
                    acceptance.gone.push(format!("{source}: was refused: {reason}"));
                }
                (Outcome::Judged { report, .. }, Some(Outcome::Judged { report: known, .. })) => {
                    findings(&source, report, known, &mut acceptance);
                }
                _ => {}
            }
        }
        acceptance
    }
}

/// Whether a finding says something that a baseline can know.
fn counts(finding: &Finding) -> bool {
    finding.binding && finding.verdict != Verdict::Pass
}

fn findings(source: &str, report: &mut Report, known: &Report, acceptance: &mut Acceptance) {
    let [pairs, known_pairs] = [&*report, known].map(|report| report.coverage.pairs.max(1) as f64);
    for old in known.findings.iter().filter(|old| counts(old)) {
        if !report.findings.iter().any(|new| same(new, old) && new.verdict != Verdict::Pass) {
            acceptance.gone.push(format!("{source}: {old}"));
        }
    }
    for finding in report.findings.iter_mut().filter(|finding| counts(finding)) {
        let Some(old) = known.findings.iter().find(|old| same(finding, old) && counts(old)) else { continue };
        if finding.verdict > old.verdict || is_worse(finding, old, [1.0 / pairs, 1.0 / known_pairs]) {
            acceptance.worse.push(format!("{source}: {finding}; known: {}", old.verdict_and_value()));
        } else {
            acceptance.accepted.push(format!("{source}: {finding}"));
            finding.accepted = true;
        }
    }
}

fn same(a: &Finding, b: &Finding) -> bool {
    let marginal = |finding: &Finding| match finding.place {
        Place::Marginal { fixed, .. } => Some(fixed),
        _ => None,
    };
    (a.check, a.single, marginal(a)) == (b.check, b.single, marginal(b))
}

fn is_worse(new: &Finding, old: &Finding, per_pair: [f64; 2]) -> bool {
    match new.check {
        Check::Energy => new.value - new.error > old.value + old.error + TOLERANCE,
        Check::Finite | Check::Horizon => new.value * per_pair[0] > SEARCHED * old.value * per_pair[1],
        // An error of 0 was not estimated; one that was says more.
        _ => new.value.abs() - new.error > SEARCHED * (old.value.abs() + old.error),
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::report;
    use super::super::{Entry, Shard};
    use super::*;

    fn run(report: Report) -> Run {
        Run { total: 1, entries: vec![Entry::judged(0, "a.wgsl", "WGSL", report)], ..Run::new() }
    }

    fn changed(verdict: Verdict, change: impl Fn(&mut Finding)) -> Run {
        let mut report = report("a", verdict);
        change(&mut report.findings[0]);
        run(report)
    }

    #[test]
    fn the_same_is_accepted_and_the_worse_is_not() {
        let known = run(report("a", Verdict::Fail));
        let mut again = known.clone();
        let told = again.accept(&known);
        assert_eq!((again.exit_code(), told.accepted.len(), told.worse.len(), told.gone.len()), (0, 1, 0, 0));
        assert!(again.reports().all(|report| report.to_string().contains("accepted")), "{again:?}");

        // 1.2490 ± 0.0004 is known; with the errors and the tolerance up to 1.2508 is no worse.
        let within = |value| changed(Verdict::Fail, move |finding| finding.value = value);
        let mut near = within(1.2507);
        assert!(near.accept(&known).worse.is_empty() && near.exit_code() == 0);
        let mut far = within(1.2509);
        assert!(far.accept(&known).worse.len() == 1 && far.exit_code() == 1);
        let mut other = changed(Verdict::Fail, |finding| finding.check = Check::Reciprocity);
        let told = other.accept(&known);
        assert_eq!((other.exit_code(), told.accepted.len(), told.gone.len()), (1, 0, 1));
    }

    #[test]
    fn doubt_does_not_cover_failure() {
        let doubt = run(report("a", Verdict::Inconclusive));
        let mut fails = run(report("a", Verdict::Fail));
        assert_eq!(fails.accept(&doubt).worse.len(), 1);
        assert_eq!(fails.exit_code(), 1);
        let mut doubts = doubt.clone();
        doubts.accept(&run(report("a", Verdict::Fail)));
        assert_eq!(doubts.exit_code(), 0);
    }

    #[test]
    fn what_is_mended_is_told() {
        let known = run(report("a", Verdict::Fail));
        let mut mended = run(report("a", Verdict::Pass));
        let told = mended.accept(&known);
        assert!(told.accepted.is_empty() && told.gone.len() == 1 && told.gone[0].contains("ENERGY"), "{told:?}");
        let mut elsewhere = Run::new();
        assert!(elsewhere.accept(&known).gone[0].contains("no longer judged"));
        let mut shard = Run { shard: Some(Shard { number: 1, of: 2 }), ..Run::new() };
        assert!(shard.accept(&known).gone.is_empty());
    }

    #[test]
    fn known_refusals_are_accepted() {
        let refused = Run { total: 1, entries: vec![Entry::refused(0, "a.wgsl", "WGSL", "torn")], ..Run::new() };
        let mut again = refused.clone();
        assert_eq!(again.accept(&refused).accepted.len(), 1);
        assert_eq!(again.exit_code(), 0);
        let mut new = refused.clone();
        new.accept(&run(report("a", Verdict::Pass)));
        assert_eq!(new.exit_code(), 2);
    }
}
