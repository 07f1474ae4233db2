//! Reports as JUnit XML: a test suite a subject, a test case a check.
//!
//! A violation is a `failure`. What could not be decided or read is an `error`: a reader of JUnit shows both in red, and an
//! open question is no pass. What a baseline accepts, and what is no BRDF,
//! is `skipped`. Findings that do not bind pass, with their line as output.

use super::svg::escape;
use super::{Entry, Outcome, Run};
use crate::check::report::{Finding, Place};
use crate::check::verdict::Verdict;
use core::fmt::Write;

impl Run {
    /// The run as JUnit XML.
    pub fn to_junit(&self) -> String {
        let mut suites = String::new();
        let mut total = Counts::default();
        for entry in &self.entries {
            total.add(suite(&mut suites, entry));
        }
        let Counts { tests, failures, errors, skipped } = total;
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"{}\" tests=\"{tests}\" failures=\"{failures}\" \
             errors=\"{errors}\" skipped=\"{skipped}\">\n{suites}</testsuites>\n",
            escape(&self.tool)
        )
    }
}

#[derive(Clone, Copy, Default)]
struct Counts {
    tests: usize,
    failures: usize,
    errors: usize,
    skipped: usize,
}

impl Counts {
    fn add(&mut self, other: Counts) {
        self.tests += other.tests;
        self.failures += other.failures;
        self.errors += other.errors;
        self.skipped += other.skipped;
    }
}

fn suite(out: &mut String, entry: &Entry) -> Counts {
    let mut counts = Counts::default();
    let mut cases = String::new();
    match &entry.outcome {
        Outcome::Judged { report, .. } => {
            for finding in &report.findings {
                counts.tests += 1;
                let text = body(finding, &mut counts);
                case(&mut cases, &entry.source, &name(finding), &text);
            }
        }
        Outcome::Refused { reason, accepted } => {
            counts.tests = 1;
            let reason = escape(reason);
            let text = if *accepted {
                counts.skipped = 1;
                format!("<skipped message=\"{reason}\"/>")
            } else {
                counts.errors = 1;
                format!("<error type=\"REFUSED\" message=\"{reason}\"/>")
            };
            case(&mut cases, &entry.source, "input", &text);
        }
    }
    let Counts { tests, failures, errors, skipped } = counts;
    let _ = writeln!(
        out,
        "  <testsuite name=\"{}\" tests=\"{tests}\" failures=\"{failures}\" errors=\"{errors}\" skipped=\"{skipped}\">\n{cases}  \
         </testsuite>",
        escape(entry.name())
    );
    counts
}

fn case(out: &mut String, source: &str, name: &str, text: &str) {
    let (source, name) = (escape(source), escape(name));
    let _ = writeln!(out, "    <testcase classname=\"{source}\" name=\"{name}\">{text}</testcase>");
}

fn name(finding: &Finding) -> String {
    let marginal = match finding.place {
        Place::Marginal { fixed, .. } => format!(" [{} fixed]", fixed.name()),
        _ => String::new(),
    };
    format!("{}{marginal}", finding.title())
}

fn body(finding: &Finding, counts: &mut Counts) -> String {
    let line = escape(&finding.to_string());
    let details: String =
        finding.details().iter().map(|(title, text)| format!("{title}: {}\n", escape(text))).collect();
    match finding.verdict {
        _ if finding.accepted => {
            counts.skipped += 1;
            format!("<skipped message=\"{line}\"/>")
        }
        Verdict::Fail if finding.binding => {
            counts.failures += 1;
            format!("<failure type=\"{}\" message=\"{line}\">{details}</failure>", finding.check.name())
        }
        Verdict::Inconclusive if finding.binding => {
            counts.errors += 1;
            format!("<error type=\"INCONCLUSIVE\" message=\"{line}\">{details}</error>")
        }
        _ => format!("<system-out>{line}</system-out>"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::report;
    use super::*;

    #[test]
    fn junit_is_xml_that_counts_what_it_holds() {
        let mut accepted = report("c", Verdict::Fail);
        accepted.findings[0].accepted = true;
        let entries = vec![
            Entry::judged(0, "a&b.wgsl", "WGSL", report("<a>\u{0}", Verdict::Fail)),
            Entry::judged(1, "b", "WGSL", report("b", Verdict::Inconclusive)),
            Entry::judged(2, "c", "WGSL", accepted),
            Entry::refused(3, "d", "MERL", "34 bytes, \"want\" 34992012"),
        ];
        let run = Run { total: 4, entries, ..Run::new() };
        let text = run.to_junit();
        let document = roxmltree::Document::parse(&text).unwrap_or_else(|e| panic!("{e}\n{text}"));
        let root = document.root_element();
        let number = |node: roxmltree::Node<'_, '_>, key| node.attribute(key).and_then(|x| x.parse::<usize>().ok());
        let count = |node: roxmltree::Node<'_, '_>, tag| node.descendants().filter(|n| n.has_tag_name(tag)).count();
        for (key, tag, want) in
            [("tests", "testcase", 7), ("failures", "failure", 1), ("errors", "error", 2), ("skipped", "skipped", 1)]
        {
            assert_eq!((number(root, key), count(root, tag)), (Some(want), want), "{key}\n{text}");
            for suite in root.children().filter(|n| n.has_tag_name("testsuite")) {
                assert_eq!(number(suite, key), Some(count(suite, tag)));
            }
        }
        let failure = root.descendants().find(|n| n.has_tag_name("failure")).expect("a failure");
        assert!(failure.attribute("message").is_some_and(|m| m.contains("1.2490 ± 0.0004") && m.contains("<note>")));
        assert!(failure.text().is_some_and(|t| t.contains("again: brdf check --wgsl 'my file.wgsl'")));
    }
}
