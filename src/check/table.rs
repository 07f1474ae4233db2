//! Findings and reports as text: the table of a terminal, its counterexamples, and the words that other forms share.

use super::energy::Albedo;
use super::report::{Check, Coverage, Finding, Place, Report};
use super::subject::Fixed;
use super::verdict::Verdict;
use crate::frame::Vector;
use core::fmt::{self, Display, Formatter};

impl Report {
    /// The report as [`Display`] writes it, verdicts in the colours of a terminal.
    pub fn coloured(&self) -> impl Display + '_ {
        Table { report: self, colour: true }
    }

    /// Writes the albedos of one marginal, polar angles across and channels down, in the azimuth of the tangent.
    fn write_albedos(&self, f: &mut Formatter<'_>, fixed: Fixed) -> fmt::Result {
        let mut row: Vec<&Albedo> = self.albedos.iter().filter(|a| a.fixed == fixed && a.phi == 0.0).collect();
        row.sort_by(|a, b| a.theta.total_cmp(&b.theta));
        let Some(first) = row.first() else { return Ok(()) };
        let title = format!("albedo [{} fixed]", fixed.name());
        let angles: Vec<String> = row.iter().map(|a| format!("{:>8}", format!("{}°", a.theta))).collect();
        writeln!(f, "  {title:24}{}", angles.concat())?;
        for channel in 0..first.value.len() {
            let name = self.channel_names.get(channel).map_or("", String::as_str);
            let values: Vec<String> =
                row.iter().filter_map(|a| a.value.get(channel)).map(|value| format!("{value:8.4}")).collect();
            writeln!(f, "  {name:>24}{}", values.concat())?;
        }
        Ok(())
    }
}

impl Finding {
    pub(super) fn title(&self) -> String {
        format!("{}{}", self.check.name(), if self.single { " f32" } else { "" })
    }

    fn outcome(&self) -> String {
        match (self.binding, self.check) {
            (false, Check::Horizon | Check::Precision | Check::Gpu) => "note".into(),
            (false, _) if self.verdict != Verdict::Pass => format!("({})", self.verdict),
            _ if self.accepted => format!("{}, accepted", self.verdict),
            _ => self.verdict.to_string(),
        }
    }

    pub(super) fn measured(&self) -> String {
        match self.check {
            // Rounded up: an error of 0 is never claimed.
            Check::Energy | Check::Density | Check::Normalisation => {
                format!("{:.4} ± {:.4}", self.value, (self.error * 1e4).ceil().max(1.0) * 1e-4)
            }
            Check::Finite if self.value == 0.0 => "everywhere".into(),
            Check::Finite | Check::Horizon => format!("{} samples", self.value),
            Check::Sign if self.verdict == Verdict::Pass => format!("f ≥ {:.2e}", self.value),
            Check::Twin => format!("{:.0}% used", 100.0 * self.value),
            Check::Sampling => format!("p = {:.1e}", self.value),
            Check::Reciprocity | Check::Sign | Check::Precision | Check::Gpu | Check::Weight | Check::Limit => {
                format!("{:.2e}", self.value)
            }
        }
    }

    /// The verdict and the value, without where.
    pub(super) fn verdict_and_value(&self) -> String {
        format!("{} {}", self.verdict, self.measured())
    }

    /// Where: angles, parameters, channel.
    pub(super) fn located(&self) -> String {
        let mut words: Vec<String> = Vec::new();
        let mut fixed_direction = String::new();
        match self.place {
            Place::Everywhere => {}
            Place::Marginal { theta, phi, fixed } => {
                let azimuth = if phi == 0.0 { String::new() } else { format!(" φ={phi}°") };
                words.push(format!("θ={theta}°{azimuth}"));
                fixed_direction = format!(" [{} fixed]", fixed.name());
            }
            Place::Pair { wi, wo } => words.push(format!("wi={} wo={}", angles(wi), angles(wo))),
        }
        words.extend(self.parameters.iter().map(|(name, value)| format!("{name}={value}")));
        words.extend(self.channel.iter().map(|(_, name)| name.clone()).filter(|name| !name.is_empty()));
        if words.is_empty() { fixed_direction } else { format!("at {}{fixed_direction}", words.join(", ")) }
    }

    /// Whether it is told at length: what it takes to see it again, and why it is so.
    pub(super) fn is_told(&self) -> bool {
        self.binding && !self.accepted && self.verdict != Verdict::Pass
    }

    /// The counterexample, the likely cause, the command that shows it again: a title and a text each, where they are known.
    pub(super) fn details(&self) -> Vec<(&'static str, String)> {
        let mut lines = Vec::new();
        if let Place::Pair { wi, wo } = self.place {
            lines.push(("wi", components(wi)));
            lines.push(("wo", components(wo)));
        }
        if let Some(values) = &self.values {
            let list = |f: &[f64]| f.iter().map(|f| plain(*f)).collect::<Vec<_>>().join(", ");
            // Single precision by its own digits: the rest of them would be noise.
            let narrow = |f: &[f64]| f.iter().map(|f| format!("{:?}", *f as f32)).collect::<Vec<_>>().join(", ");
            let lists = [
                ("f in f64", list(&values.double)),
                ("f in f32", narrow(&values.single)),
                ("f on the GPU", narrow(&values.gpu)),
            ];
            lines.extend(lists.into_iter().filter(|(_, list)| !list.is_empty()));
        }
        if !self.cause.is_empty() {
            lines.push(("likely cause", self.cause.clone()));
        }
        if !self.again.is_empty() {
            lines.push(("again", self.again.clone()));
        }
        lines
    }
}

/// Every digit of a number, and no rows of zeros.
fn plain(x: f64) -> String {
    if x != 0.0 && x.abs() < 1e-4 { format!("{x:e}") } else { format!("{x}") }
}

fn components(v: Vector<f64>) -> String {
    format!("({}, {}, {})", plain(v.x), plain(v.y), plain(v.z))
}

/// Polar angle and azimuth in degrees. Grazing angles keep what tells them from 90°.
fn angles(v: Vector<f64>) -> String {
    let across = v.sin_squared().sqrt();
    // The sum with 0 turns −0 into 0.
    let phi = if across > 0.0 { (v.y.atan2(v.x).to_degrees() * 100.0).round() / 100.0 + 0.0 } else { 0.0 };
    let elevation = v.z.atan2(across).to_degrees();
    if elevation != 0.0 && elevation.abs() < 0.05 {
        let sign = if elevation > 0.0 { '−' } else { '+' };
        format!("(90°{sign}{:.1e}°, {phi}°)", elevation.abs())
    } else {
        format!("({}°, {phi}°)", ((90.0 - elevation) * 100.0).round() / 100.0)
    }
}

impl Display for Finding {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let columns = [self.title(), self.outcome(), self.measured(), self.located(), self.note.clone()];
        let filled: Vec<&str> = columns.iter().map(String::as_str).filter(|column| !column.is_empty()).collect();
        f.write_str(&filled.join(" "))
    }
}

impl Display for Report {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        Table { report: self, colour: false }.fmt(f)
    }
}

/// A report as a table, in colour or plain.
struct Table<'a> {
    report: &'a Report,
    colour: bool,
}

impl Table<'_> {
    /// The escape sequences around a verdict.
    fn paint(&self, verdict: Verdict, counts: bool) -> [&'static str; 2] {
        match (self.colour, verdict) {
            (false, _) => ["", ""],
            (true, _) if !counts => ["\x1b[2m", "\x1b[0m"],
            (true, Verdict::Pass) => ["\x1b[32m", "\x1b[0m"],
            (true, Verdict::Inconclusive) => ["\x1b[33m", "\x1b[0m"],
            (true, Verdict::Fail) => ["\x1b[1;31m", "\x1b[0m"],
        }
    }
}

impl Display for Table<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let report = self.report;
        let [on, off] = self.paint(report.verdict(), true);
        writeln!(f, "{}: {on}{}{off}", report.subject, report.verdict())?;
        let rows: Vec<[String; 4]> = report
            .findings
            .iter()
            .map(|finding| [finding.title(), finding.outcome(), finding.measured(), finding.located()])
            .collect();
        let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
        let widths = [0, 1, 2, 3].map(width);
        for (row, finding) in rows.iter().zip(&report.findings) {
            let [on, off] = self.paint(finding.verdict, finding.binding && !finding.accepted);
            let mut line = String::from(" ");
            for (column, (cell, width)) in row.iter().zip(widths).enumerate() {
                let [on, off] = if column == 1 { [on, off] } else { ["", ""] };
                line.push_str(&format!(" {on}{cell:width$}{off} "));
            }
            line.push_str(&finding.note);
            writeln!(f, "{}", line.trim_end())?;
            for (title, text) in finding.details().iter().filter(|_| finding.is_told()) {
                writeln!(f, "      {:14}{text}", format!("{title}:"))?;
            }
        }
        for fixed in [Fixed::View, Fixed::Light] {
            report.write_albedos(f, fixed)?;
        }
        for note in &report.notes {
            writeln!(f, "  note: {note}")?;
        }
        write!(f, "{}", report.coverage)
    }
}

impl Display for Coverage {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Coverage { seed, budget, evaluations, integrals, pairs, restarts, anisotropic, .. } = self;
        writeln!(
            f,
            "  seed {seed}, {evaluations} evaluations (budget {budget}), {integrals} integrals, measured {}",
            if *anisotropic { "anisotropic" } else { "isotropic" }
        )?;
        if !self.parameters.is_empty() {
            let ranges = self.parameters.iter().map(|p| format!("{} {}…{}", p.name, p.low, p.high));
            let [seen, checked] = self.members;
            let ranges: Vec<String> = ranges.collect();
            writeln!(f, "  searched {}: {seen} members, {checked} of them in full", ranges.join(", "))?;
        }
        let bound = |looks: usize| 3.0 / looks.max(1) as f64;
        write!(
            f,
            "  {pairs} pairs and {restarts} restarts: where no violation was found, the violating measure under this \
             distribution is < {:.1e} with 95 % confidence",
            bound(*pairs)
        )?;
        if !self.parameters.is_empty() {
            // Directions are looked at in the members that were checked, parameters once a member.
            write!(f, " within those members, and that of the parameters < {:.1e}", bound(self.members[0]))?;
        }
        writeln!(f, "; smaller regions are not excluded")
    }
}

#[cfg(test)]
mod tests {
    use super::super::report::Values;
    use super::*;

    fn finding(check: Check, verdict: Verdict, binding: bool) -> Finding {
        Finding {
            verdict,
            binding,
            value: 1.249,
            error: 0.0004,
            limit: 1.001,
            place: Place::Marginal { theta: 80.0, phi: 0.0, fixed: Fixed::Light },
            channel: Some((0, "r".into())),
            ..Finding::new(check)
        }
    }

    #[test]
    fn a_line_says_what_and_where() {
        let line = finding(Check::Energy, Verdict::Fail, true).to_string();
        assert_eq!(line, "ENERGY FAIL 1.2490 ± 0.0004 at θ=80°, r [light fixed]");
    }

    #[test]
    fn parameters_stand_beside_the_angle_and_the_command_below() {
        let found = Finding {
            parameters: vec![("roughness".into(), 0.3)],
            channel: None,
            cause: "the view alone is normalised".into(),
            again: "brdf check x.wgsl --at theta=80,phi=0,light".into(),
            values: Some(Values { double: vec![0.25], single: vec![0.5], gpu: Vec::new() }),
            ..finding(Check::Energy, Verdict::Fail, true)
        };
        assert_eq!(found.to_string(), "ENERGY FAIL 1.2490 ± 0.0004 at θ=80°, roughness=0.3 [light fixed]");
        let report = |finding: Finding| Report {
            subject: "s".into(),
            channel_names: Vec::new(),
            findings: vec![finding],
            albedos: Vec::new(),
            coverage: Coverage::default(),
            notes: Vec::new(),
        };
        let text = report(found.clone()).to_string();
        for line in ["likely cause: the view alone", "again:        brdf check x.wgsl", "f in f32:     0.5"] {
            assert!(text.contains(line), "{line} in\n{text}");
        }
        assert!(
            !text.contains('\x1b') && report(found.clone()).coloured().to_string().contains("\x1b[1;31mFAIL\x1b[0m")
        );
        let accepted = report(Finding { accepted: true, ..found });
        assert_eq!(accepted.verdict(), Verdict::Pass);
        let text = accepted.to_string();
        assert!(text.contains("FAIL, accepted") && !text.contains("again:"), "{text}");
    }

    #[test]
    fn angles_tell_grazing_from_the_horizon() {
        assert_eq!(angles(Vector::new(1.0, 0.0, 0.0)), "(90°, 0°)");
        assert_eq!(angles(Vector::new(0.0, 1.0, 1e-5)), "(90°−5.7e-4°, 90°)");
        assert_eq!(angles(Vector::new(0.0, 1.0, -1e-5)), "(90°+5.7e-4°, 90°)");
        assert_eq!(angles(Vector::new(0.6, 0.0, 0.8)), "(36.87°, 0°)");
    }

    #[test]
    fn advisory_findings_do_not_bind() {
        let findings =
            vec![finding(Check::Energy, Verdict::Pass, true), finding(Check::Reciprocity, Verdict::Fail, false)];
        let mut report = Report {
            subject: "s".into(),
            channel_names: Vec::new(),
            findings,
            albedos: Vec::new(),
            coverage: Coverage::default(),
            notes: Vec::new(),
        };
        assert_eq!(report.verdict(), Verdict::Pass);
        assert!(report.to_string().contains("(FAIL)"), "{report}");
        report.findings.push(finding(Check::Sign, Verdict::Inconclusive, true));
        assert_eq!(report.verdict(), Verdict::Inconclusive);
        report.findings.clear();
        assert_eq!(report.verdict(), Verdict::Inconclusive);
    }
}
