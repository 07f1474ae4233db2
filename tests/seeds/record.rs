//! What a record of an erratum holds, how its measurements are judged, and the document that is written from it.

use crate::{elek, layered, mihaylov, single, tables};
use std::fmt::Write as _;
use std::sync::OnceLock;

/// How to write the document.
pub(crate) const COMMAND: &str = "BRDF_BLESS=1 cargo test --features check --test seeds";

/// A formula that a document prints and that is wrong, or where the documents contradict themselves or nature.
pub(crate) struct Erratum {
    /// Its number in the formula notes, §2.
    pub(crate) number: usize,
    /// Where it is printed.
    pub(crate) place: &'static str,
    /// What is printed.
    pub(crate) printed: &'static str,
    /// What is right.
    pub(crate) correct: &'static str,
    /// The function of the crate that is right, or why there is none.
    pub(crate) right: &'static str,
    /// How the measured quantities are defined, and where the notes are off; may be empty.
    pub(crate) note: &'static str,
    /// Measures the consequence, next to the same quantity of the correct form.
    pub(crate) measure: fn() -> Vec<Measurement>,
}

/// Who gave the number that a measurement is held against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// The formula notes.
    Notes,
    /// Nobody before: the number was measured here first, and is kept from moving.
    Here,
}

/// A measured number and what it must be.
#[derive(Clone, Debug)]
pub(crate) struct Measurement {
    /// What was measured.
    pub(crate) what: String,
    /// The measured value; a fraction where `want` is a percentage.
    pub(crate) value: f64,
    /// What it must be, as text: a number, with `≤`, `≥` or `>` before it a bound, with `%` after it a hundredth, or `NaN`.
    pub(crate) want: &'static str,
    /// How far from `want` the value may be.
    pub(crate) tolerance: f64,
    /// Where `want` is from.
    pub(crate) source: Source,
}

impl Measurement {
    fn new(what: impl Into<String>, value: f64, want: &'static str, source: Source) -> Self {
        // Half of the last digit that is printed, and nothing for a bound.
        let tolerance = match bound(want) {
            Some(_) => 0.0,
            None => 0.5 * 0.1f64.powi(decimals(want) as i32) * scale(want) * (1.0 + 1e-9),
        };
        Measurement { what: what.into(), value, want, tolerance, source }
    }

    /// A value that the notes give as `want`, to the precision with which they print it.
    pub(crate) fn notes(what: impl Into<String>, value: f64, want: &'static str) -> Self {
        Self::new(what, value, want, Source::Notes)
    }

    /// A value that was measured here, to the precision of `want`.
    pub(crate) fn here(what: impl Into<String>, value: f64, want: &'static str) -> Self {
        Self::new(what, value, want, Source::Here)
    }

    /// The same with another tolerance.
    pub(crate) fn within(self, tolerance: f64) -> Self {
        Measurement { tolerance, ..self }
    }

    /// Whether the value is what it must be.
    fn holds(&self) -> bool {
        if self.want == "NaN" {
            return self.value.is_nan();
        }
        let want = number(self.want);
        match bound(self.want) {
            Some('≤') => self.value <= want + self.tolerance,
            Some('≥') => self.value >= want - self.tolerance,
            Some(_) => self.value > want - self.tolerance,
            None => (self.value - want).abs() <= self.tolerance,
        }
    }

    /// The value with one decimal more than `want` has.
    fn shown(&self) -> String {
        if self.value.is_nan() {
            return "NaN".into();
        }
        let places = decimals(self.want) + usize::from(decimals(self.want) > 0 || self.want.contains('%'));
        let value = self.value / scale(self.want);
        let text = format!("{value:.places$}");
        let zero = text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.');
        let text = if zero { text.trim_start_matches('-').to_owned() } else { text.replace('-', "−") };
        if self.want.contains('%') { text + " %" } else { text }
    }

    /// How far the value is from where its shown digits change, in units of the last of them.
    fn margin(&self) -> f64 {
        let places = decimals(self.want) + usize::from(decimals(self.want) > 0 || self.want.contains('%'));
        let units = self.value / scale(self.want) * 10f64.powi(places as i32);
        0.5 - (units - units.round()).abs()
    }
}

/// The sign of a bound.
fn bound(want: &str) -> Option<char> {
    want.chars().next().filter(|c| "≤≥>".contains(*c))
}

/// What one printed unit is worth.
fn scale(want: &str) -> f64 {
    if want.contains('%') { 0.01 } else { 1.0 }
}

/// The digits of a text that are its number.
fn digits(want: &str) -> String {
    want.trim_matches(|c: char| "≤≥> %+".contains(c)).replace('−', "-")
}

fn decimals(want: &str) -> usize {
    digits(want).split_once('.').map_or(0, |(_, after)| after.len())
}

fn number(want: &str) -> f64 {
    digits(want).parse::<f64>().unwrap_or_else(|_| panic!("{want:?} is not a number")) * scale(want)
}

/// Every record, by number.
pub(crate) fn all() -> &'static [Erratum] {
    static ALL: OnceLock<Vec<Erratum>> = OnceLock::new();
    ALL.get_or_init(|| {
        let mut all = [elek::errata(), layered::errata(), tables::errata(), mihaylov::errata()]
            .into_iter()
            .flatten()
            .collect::<Vec<_>>();
        all.sort_by_key(|erratum| erratum.number);
        all
    })
}

/// The measurements of an erratum, made once.
fn measurements(number: usize) -> &'static [Measurement] {
    static MADE: [OnceLock<Vec<Measurement>>; 25] = [const { OnceLock::new() }; 25];
    MADE[number - 1].get_or_init(|| (all()[number - 1].measure)())
}

/// Asserts every measurement of an erratum.
pub(crate) fn assert_holds(number: usize) {
    let measurements = measurements(number);
    assert!(!measurements.is_empty(), "erratum {number} measures nothing");
    let mut broken = String::new();
    for m in measurements {
        println!("{number:2} {}: {:.6} [{} ± {:.1e}]", m.what, m.value, m.want, m.tolerance);
        if !m.holds() {
            let _ = writeln!(broken, "{}: {}, want {} ± {:.1e}", m.what, m.value, m.want, m.tolerance);
        }
        // So that the document is the same on a machine whose exp differs in the last digit.
        if m.value.is_finite() && m.margin() < 1e-3 {
            let _ = writeln!(broken, "{}: {} is too close to where its shown digits change", m.what, m.value);
        }
    }
    assert!(broken.is_empty(), "erratum {number}\n{broken}");
}

/// The document.
pub(crate) fn document() -> String {
    let mut text = format!(
        "<!-- Generated from tests/seeds by `{COMMAND}`; do not edit. -->\n\n\
         # Errata of the two documents\n\n\
         What Elek, *Layered Materials in Real-Time Rendering* (2010, **E**), and Mihaylov, *Rendering Metals and Worn or Weathered Metallic Objects* (2013, **M**) \
         print that is wrong, what is right, and what the printed form costs. Each printed form is implemented in \
         `tests/seeds`, and each number below is measured by that test.\n\n\
         Conventions are those of the crate: f in sr⁻¹ without the cosine, albedo = ∫ f·cos dω. NL, NV, NH, VH are dot products, \
         m is Beckmann's slope parameter. *Notes* is the number in the project's formula notes, with which the \
         measurement agrees to the last digit printed; *here* marks a number that is held by this test alone.\n\n\
         | # | printed in | printed | correct |\n|---|---|---|---|\n"
    );
    for e in all() {
        let cell = |text: &str| text.replace('|', "\\|");
        let _ = writeln!(
            text,
            "| [{0}](#erratum-{0}) | {1} | {2} | {3} |",
            e.number,
            cell(e.place),
            cell(e.printed),
            cell(e.correct)
        );
    }
    for e in all() {
        let _ = write!(
            text,
            "\n## Erratum {}\n\n{}\n\n* Printed: {}\n* Correct: {}\n* Right in the crate: {}\n\n\
             | measured | value | expected |\n|---|---|---|\n",
            e.number, e.place, e.printed, e.correct, e.right
        );
        for m in measurements(e.number) {
            let source = if m.source == Source::Notes { "notes" } else { "here" };
            let what = m.what.replace('|', "\\|");
            let _ = writeln!(text, "| {what} | {} | {} ({source}) |", m.shown(), m.want);
        }
        if !e.note.is_empty() {
            let _ = writeln!(text, "\n{}", e.note);
        }
    }
    text.push_str(
        "\n## What E's listings return in single precision\n\nApp. B and Algorithm 1 evaluated in f32 as printed, and the \
         crate at the same inputs.\n\n| input | listing | crate |\n|---|---|---|\n",
    );
    for case in single::cases() {
        let _ = writeln!(text, "| {} | {} | {} |", case.what, single::class(case.printed), case.answer());
    }
    let percent = |x: f64| format!("{:.0} %", 100.0 * x);
    let (worst, best) = (single::shares_in_a_shader(), single::shares_at_best());
    let _ = writeln!(
        text,
        "\nApp. B is NaN wherever NH > 1 by rounding, and a `pow(1 − VH, 5)` wherever VH > 1. At the peak itself NH > 1 in {} of \
         samples, at L = V VH > 1 in {}, with every direction normalised in f32 by a reciprocal root; {} and {} where directions \
         are rounded once from f64 and H is divided by its length. The notes give 18 % near the peak and 20 %. The crate is \
         finite at each.",
        percent(worst.0),
        percent(worst.1),
        percent(best.0),
        percent(best.1)
    );
    text
}

#[test]
fn a_wrong_value_does_not_hold() {
    let holds = |value, want| Measurement::notes("", value, want).holds();
    assert!(holds(2.346, "2.35") && !holds(2.344, "2.35") && !holds(2.356, "2.35"));
    assert!(holds(0.474, "47 %") && !holds(0.48, "47 %") && !holds(47.0, "47 %"));
    assert!(holds(-0.19, "−.19") && !holds(0.19, "−.19"));
    assert!(holds(0.002, "≤ .0026") && !holds(0.00261, "≤ .0026"));
    assert!(holds(3.0, "> 2") && !holds(2.0, "≥ 2.1"));
    assert!(holds(f64::NAN, "NaN") && !holds(1.0, "NaN") && !holds(f64::NAN, "1") && !holds(f64::NAN, "≤ 1"));
    assert_eq!(Measurement::notes("", -1e-17, "0.0").shown(), "0.00");
    assert_eq!(Measurement::notes("", 0.4738, "47 %").shown(), "47.4 %");
}
