//! Reports on a terminal, in colour there and plain in a pipe.

use brdf::check::output::{Acceptance, Entry, Outcome, Run};
use brdf::check::{Fixed, Place, Report, Verdict};
use std::io::{self, IsTerminal, Write};

/// Whether the reader of the standard output sees colours and wants them (no-color.org).
fn coloured() -> bool {
    let set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    io::stdout().is_terminal() && !set("NO_COLOR") && std::env::var_os("TERM").is_none_or(|term| term != "dumb")
}

/// Every report, one line for a plausible subject among several; what a baseline did; the summary.
pub(crate) fn print(out: &mut impl Write, run: &Run, verbose: bool, acceptance: Option<&Acceptance>) -> io::Result<()> {
    let colour = coloured();
    let whole = verbose || run.entries.len() == 1;
    for entry in &run.entries {
        match &entry.outcome {
            Outcome::Judged { report, .. } if whole || report.verdict() != Verdict::Pass => {
                if colour {
                    writeln!(out, "{}", report.coloured())?;
                } else {
                    writeln!(out, "{report}")?;
                }
            }
            Outcome::Judged { report, .. } => line(out, entry, report, colour)?,
            Outcome::Refused { reason, .. } => writeln!(out, "{:12} {reason}", entry.verdict_name())?,
        }
    }
    if let Some(acceptance) = acceptance {
        let lists = [
            ("accepted by the baseline", &acceptance.accepted),
            ("worse than the baseline", &acceptance.worse),
            ("no longer found, though the baseline has it", &acceptance.gone),
        ];
        for (title, lines) in lists.iter().filter(|(_, lines)| !lines.is_empty()) {
            writeln!(out, "{title}:")?;
            for line in *lines {
                writeln!(out, "  {line}")?;
            }
        }
    }
    writeln!(out, "twins: {}", run.twins)?;
    writeln!(out, "{}", run.summary())
}

fn line(out: &mut impl Write, entry: &Entry, report: &Report, colour: bool) -> io::Result<()> {
    let albedo = |fixed| {
        report.energy(fixed).map_or("not judged".to_owned(), |finding| {
            let theta = if let Place::Marginal { theta, .. } = finding.place { theta } else { 0.0 };
            format!("{:.4} at {theta}°", finding.value)
        })
    };
    let [on, off] = if colour { ["\x1b[32m", "\x1b[0m"] } else { ["", ""] };
    writeln!(
        out,
        "{on}{:12}{off} {:28} {:12} albedo ≤ {} [view], {} [light]",
        report.verdict().name(),
        report.subject,
        entry.kind,
        albedo(Fixed::View),
        albedo(Fixed::Light)
    )
}
