//! `docs/accuracy.md`: written from the measurements, and compared with them in an ordinary run.

use crate::audit::audit;
use crate::inputs::DIMENSIONS;
use crate::meter::{Meter, error, error_of, stated_bound};
use crate::terms::{Term, terms};
use crate::{SAMPLES, inputs};
use brdf::batch::Level;
use brdf::single::Single;
use std::fmt::Write as _;

/// How to write the document.
pub(crate) const COMMAND: &str = "BRDF_BLESS=1 cargo test --test accuracy";

/// A term and what was found of each of its results.
pub(crate) struct Measured {
    pub(crate) term: Term,
    pub(crate) ours: Vec<Meter>,
    pub(crate) plain: Vec<Meter>,
    pub(crate) batch: Vec<Meter>,
    pub(crate) printed: Vec<Meter>,
}

/// Points that are evaluated as one batch.
const BLOCK: u64 = 1000;

/// Measures a term at the first `samples` points of the sequence.
fn measure(term: Term, samples: u64) -> Measured {
    let results = term.results.len();
    let meters = || (0..results).map(|_| Meter::default()).collect::<Vec<_>>();
    let (mut ours, mut plain, mut batch, mut printed) = (meters(), meters(), meters(), meters());
    let mut batched = Block::new();
    for index in 0..samples {
        if index % BLOCK == 0 {
            batched.evaluate(&term, index..(index + BLOCK).min(samples));
        }
        let (arguments, many) = batched.row(index % BLOCK);
        let wide: Vec<f64> = arguments.iter().map(|x| f64::from(*x)).collect();
        let (got, want) = ((term.single)(&arguments), (term.double)(&wide));
        if (term.past)(&wide) {
            // 0 by decree; at the limit itself rounding decides.
            let zero = got[..results].contains(&0.0) || got[0] < 1e-29;
            assert!(zero, "{}: {got:?} beyond the limit at {arguments:?}", term.name());
            continue;
        }
        let singles: Vec<Single> = arguments.iter().map(|x| Single(*x)).collect();
        let throughout = (term.plain)(&singles);
        let naive = term.naive.map(|form| form(&arguments));
        for result in 0..results {
            let want = want[result];
            if !term.measures(want) {
                assert!(want >= 0.0 || got[result] < 0.0, "{}: the sign at {arguments:?}", term.name());
                continue;
            }
            ours[result].add(error(got[result], want), &arguments);
            // At the exponent's limit the rounding of the argument decides.
            let cut = throughout[result] == Single(0.0) && want.abs() < 1e-29;
            plain[result].add(if cut { 0.0 } else { error(throughout[result].0, want) }, &arguments);
            if let Some(limit) = term.batch_limit().filter(|_| (term.steady)(&wide)) {
                let scale = (limit.scale)(&wide).max(want.abs());
                let cut = many[result] == 0.0 && want.abs() < 1e-29;
                batch[result].add(if cut { 0.0 } else { error_of(many[result], want, scale) }, &arguments);
            }
            if let Some(naive) = naive {
                printed[result].add(error(naive[result], want), &arguments);
            }
        }
    }
    Measured { term, ours, plain, batch, printed }
}

/// A block of points, evaluated together at the level that [`batch::map`](brdf::batch::map) chooses.
struct Block {
    rows: Vec<Vec<f32>>,
    columns: [Vec<f32>; DIMENSIONS],
    results: [Vec<f32>; 3],
    level: Level,
}

impl Block {
    fn new() -> Self {
        Block { rows: Vec::new(), columns: Default::default(), results: Default::default(), level: Level::detect() }
    }

    fn evaluate(&mut self, term: &Term, indices: std::ops::Range<u64>) {
        self.rows = indices.map(|index| (term.draw)(&inputs::point(index))).collect();
        for (i, column) in self.columns.iter_mut().enumerate() {
            *column = self.rows.iter().map(|row| row.get(i).copied().unwrap_or(0.0)).collect();
        }
        for result in &mut self.results {
            *result = vec![0.0; self.rows.len()];
        }
        if term.batch_limit().is_some() {
            let columns = std::array::from_fn(|i| self.columns[i].as_slice());
            (term.batch)(self.level, columns, self.results.each_mut().map(Vec::as_mut_slice));
        }
    }

    fn row(&self, index: u64) -> (Vec<f32>, [f32; 3]) {
        let index = index as usize;
        (self.rows[index].clone(), self.results.each_ref().map(|result| result[index]))
    }
}

/// Every term, measured on as many threads as there are.
pub(crate) fn measure_all(samples: u64) -> Vec<Measured> {
    let queue = std::sync::Mutex::new(terms().into_iter().enumerate());
    let found = std::sync::Mutex::new(Vec::new());
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let next = queue.lock().expect("no thread panics with the lock").next();
                    let Some((place, term)) = next else { return };
                    let measured = measure(term, samples);
                    found.lock().expect("no thread panics with the lock").push((place, measured));
                }
            });
        }
    });
    let mut found = found.into_inner().expect("no thread panics with the lock");
    found.sort_by_key(|(place, _)| *place);
    found.into_iter().map(|(_, measured)| measured).collect()
}

/// A figure to two digits or so.
fn figure(x: f64) -> String {
    if !x.is_finite() {
        "NaN or ∞".into()
    } else if x >= 1e12 {
        "> 1e12".into()
    } else if x >= 1e3 {
        format!("{x:.1e}")
    } else if x >= 10.0 {
        format!("{x:.0}")
    } else {
        format!("{x:.2}")
    }
}

fn arguments(at: &[f32]) -> String {
    let numbers: Vec<String> = at
        .iter()
        .map(|x| if *x == 0.0 || (1e-3..1e4).contains(&x.abs()) { format!("{x}") } else { format!("{x:e}") })
        .collect();
    format!("at ({})", numbers.join(", "))
}

/// A row for each result that `cells` has something to say of.
fn rows(all: &[Measured], cells: impl Fn(&Measured, usize) -> Option<Vec<String>>) -> String {
    let mut text = String::new();
    for m in all {
        for (result, label) in m.term.results.iter().enumerate() {
            if let Some(cells) = cells(m, result) {
                let name = format!("`{}` {label}", m.term.name());
                let _ = writeln!(text, "| {} | {} |", name.trim(), cells.join(" | "));
            }
        }
    }
    text
}

/// The document.
pub(crate) fn document(all: &[Measured]) -> String {
    let evaluations: u64 = all.iter().map(|m| m.ours[0].samples).sum();
    let mut text = format!(
        "<!-- Generated from tests/accuracy by `{COMMAND}`; do not edit. -->\n\n\
         # Accuracy in single precision\n\n\
         Errors are in ULP, the spacing of f32 at the exact result; the inputs are f32 numbers and count as exact. A correctly \
         rounded result is within 0.5. The reference is the f64 instance at the same inputs, which is itself held against 80 \
         digits below. Inputs are points of a low-discrepancy sequence, spaced in the logarithm towards grazing, the \
         normal, matched indices and critical angles: {SAMPLES} for each term, {evaluations} in the terms' domains. \
         A maximum over samples is a lower bound of the true one; the *bound* is what the function's documentation states, \
         and the test fails where a measurement exceeds it. `ACCURACY_SAMPLES=20000000 cargo test --release --test accuracy` \
         digs deeper.\n\n\
         In f32 a term computes in double precision and rounds its result once (`docs/decisions.md`): what is left beyond 0.5 \
         is said by the function's documentation. A GPU has no such numbers; what a WGSL twin may return for an input is an \
         interval that `brdf parity` computes.\n\n\
         ## Every term\n\n\
         | term | max ULP | where | p99.9 | mean | bound | target | batch | p99.9 | limit |\n|---|---|---|---|---|---|---|---|---|---|\n"
    );
    text += &rows(all, |m, result| {
        let meter = &m.ours[result];
        let target = match m.term.target {
            None => "–".into(),
            Some(target) if meter.worst <= target => format!("≤ {target}: met"),
            Some(target) => format!("≤ {target}: **missed**"),
        };
        let bound = stated_bound(m.term.module, m.term.function);
        let mut cells = vec![
            figure(meter.worst),
            arguments(&meter.at),
            figure(meter.rare()),
            figure(meter.mean()),
            format!("≤ {bound}"),
            target,
        ];
        cells.extend(match m.term.batch_limit() {
            None => ["–"; 3].map(str::to_owned),
            Some(limit) => {
                let meter = &m.batch[result];
                [figure(meter.worst), figure(meter.rare()), format!("≤ {}", limit.ulp)]
            }
        });
        Some(cells)
    });
    text.push_str(
        "\n*Batch* is the largest error, and that of 99.9 %, of the term run over slices by `batch::map` at the fastest level of \
         the processor that wrote this (AVX-512), in f32 throughout; the *limit* is asserted at every run, `tests/batch.rs` asserts it at \
         every level. It is the target where there is one. Elsewhere it is the project's own:\n\n\
         * `fresnel::lazanyi` and `f82_tint` subtract from a reflectance: ULP are those of the reflectance before it, or of the \
         result where that is larger. `lazanyi` counts what is below 1e-30 as that.\n\
         * The three terms of `oren_nayar`'s direct part, of size 1, cancel where it changes sign: ULP are at least those of 1/2.\n\
         * Powers: the exponent's error times the exponent. The logarithm of Blinn's and Phong's lobes is good to 2⁻²⁹, which an \
         exponent of 87 makes 5 ULP; the angle of `gaussian` to 2⁻²⁶, squared, which makes 110.\n\n\
         The target of the stacks is a relative error of 1.5e-6, at least 12 ULP, for f > 1e-8; they are measured for two \
         layers. In a batch, of `Plan::evaluate_batch`, they are measured where the base has no critical angle, |(η+iκ)² − sin²θ| ≥ .1, and \
         miss it: the cosines under the coat and the path are numbers of f32, and an absorption of e⁻¹⁸ magnifies their 3 ULP to 54. Elsewhere, by a \
         critical angle of the base, F loses a thousand ULP and more to the rounding of V·H. `tests/plan.rs` holds stacks of any number \
         of layers without critical angles to 8 ULP and 4 times what half an ULP of one number of the input does to f.\n\n## Against 80 digits\n\nThe textbook form of each term in 80-digit arithmetic (`tests/accuracy/audit.py`, \
         mpmath) at f32 inputs: the largest error of f32 in its ULP, and of f64 in the ULP of f64, 2⁻²⁹ of the other. In f64 \
         what grows is the rounding of an exponent, and of a difference close to its zero.\n\n\
         | term | points | f32, max ULP | f64, max ULP of f64 |\n|---|---|---|---|\n",
    );
    text += &rows(all, |m, result| {
        let found = audit(&m.term);
        let audit = found.get(result)?;
        Some(vec![audit.points.to_string(), figure(audit.single), figure(audit.double)])
    });
    text.push_str(
        "\n## In f32 throughout, and the printed forms\n\nWhat the same formula gives over `Single`, in f32 in every step, without \
         fused multiply-adds: the cheap form. Unlike a GPU's twin it carries the rounding errors that a result magnifies. And the same inputs through the forms that the documents and textbooks print, in f32 throughout: \
         1 − F for T, 1 − NH² for tan², `pow`, `acos` and `tan`. *NaN or ∞* stands where a sample is not a number.\n\n\
         | term | f32 | f32 throughout | where | p99.9 | printed form | where | p99.9 | mean of the finite |\n|---|---|---|---|---|---|---|---|---|\n",
    );
    text += &rows(all, |m, result| {
        let (plain, ours) = (&m.plain[result], &m.ours[result]);
        let mut cells = vec![figure(ours.worst), figure(plain.worst), arguments(&plain.at), figure(plain.rare())];
        cells.extend(if m.term.naive.is_some() {
            let meter = &m.printed[result];
            [figure(meter.worst), arguments(&meter.at), figure(meter.rare()), figure(meter.mean())]
        } else {
            ["–"; 4].map(str::to_owned)
        });
        Some(cells)
    });
    text.push_str("\n## Domains\n\n| term | where it is measured |\n|---|---|\n");
    for m in all {
        let _ = writeln!(text, "| `{}` | {} |", m.term.name(), m.term.domain);
    }
    text.push_str(
        "\nPast an exponent of 87 the lobes and the absorption are 0 by definition; what lies beyond is left out.\n\n\
         ## Every f32 of an argument\n\nOne argument at all its f32 numbers, the others fixed, as \
         `ACCURACY_EXHAUSTIVE=1 BRDF_BLESS=1 cargo test --release --test accuracy every_f32` last recorded it; an ordinary run \
         takes every 4099th.\n\n| term and argument | f32 numbers | max ULP | where |\n|---|---|---|---|\n",
    );
    for line in include_str!("full.csv").lines().skip(1) {
        let (name, rest) = line.trim_start_matches('"').split_once("\",").expect("a quoted name");
        let cells: Vec<&str> = rest.split(',').collect();
        let worst: f64 = cells[1].parse().expect("a number");
        let _ = writeln!(text, "| {name} | {} | {} | at {} |", cells[0], figure(worst), cells[2]);
    }
    text.push_str(
        "\n## Endurance\n\nEvery term in f32 and f64, the built-in stacks and 600 drawn ones under every closed-form model, \
         at random inputs and corners: no NaN, no infinity, no negative value, no panic. Signed results (components of a \
         vector, g² of total reflection, the single-scattering part of Oren–Nayar) are held finite alone.\n\n",
    );
    text.push_str(include_str!("endurance.txt").trim_end());
    text.push('\n');
    text
}

/// Whether a cell of the document still says what was measured: another machine's `exp` may move a figure, and the
/// place of a maximum, but not its size.
fn agrees(found: &str, generated: &str) -> bool {
    let (found, generated) = (found.trim(), generated.trim());
    if found == generated || found.starts_with("at ") && generated.starts_with("at ") {
        return true;
    }
    match (found.parse::<f64>(), generated.parse::<f64>()) {
        // The largest error of a printed form, a single sample's, moves most.
        (Ok(a), Ok(b)) => (a - b).abs() <= 0.05 + 0.5 * a.max(b),
        _ => false,
    }
}

/// Panics at the first line that is stale.
pub(crate) fn compare(found: &str, generated: &str) {
    let found = found.replace("\r\n", "\n");
    for (number, (old, new)) in found.lines().zip(generated.lines()).enumerate() {
        let (old_cells, new_cells): (Vec<&str>, Vec<&str>) = (old.split('|').collect(), new.split('|').collect());
        let same = old_cells.len() == new_cells.len() && old_cells.iter().zip(&new_cells).all(|(a, b)| agrees(a, b));
        assert!(same, "docs/accuracy.md, line {}:\n  found     {old}\n  generated {new}\n{COMMAND}", number + 1);
    }
    assert_eq!(found.lines().count(), generated.lines().count(), "docs/accuracy.md ends elsewhere; {COMMAND}");
}

#[test]
fn a_stale_figure_is_found() {
    assert!(agrees(" 0.50 ", " 0.51 ") && agrees("at (1)", "at (2)") && agrees("> 1e12", "> 1e12"));
    assert!(!agrees("0.50", "2.50") && !agrees("≤ 8: met", "≤ 8: **missed**") && !agrees("12", "at (1)"));
    assert!(!agrees("NaN or ∞", "3.00"));
}
