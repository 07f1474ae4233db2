//! The f64 instance, which f32 is measured against, and f32 itself against 80-digit values of the textbook forms.
//!
//! `audit.csv` is written by `audit.py` with mpmath, whose forms share nothing with the crate's. A term in f32 evaluates
//! the formula of f64 and rounds, so that comparing the two says little of the formula: this does.

use crate::meter::{error, ulp_double};
use crate::terms::Term;

/// What a term's results are off by, at most.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Audit {
    pub(crate) points: usize,
    /// The f64 instance, in ULP of f64.
    pub(crate) double: f64,
    /// The f32 instance, in ULP of f32.
    pub(crate) single: f64,
}

/// The audit of each result of a term; empty where it has no rows.
pub(crate) fn audit(term: &Term) -> Vec<Audit> {
    let text = std::env::var("ACCURACY_AUDIT").map_or_else(
        |_| include_str!("audit.csv").to_owned(),
        |path| std::fs::read_to_string(path).expect("ACCURACY_AUDIT names a file"),
    );
    let mut found = Vec::new();
    for line in text.lines().skip(1) {
        let mut cells = line.split(',');
        if cells.next() != Some(term.name().as_str()) {
            continue;
        }
        let mut numbers = || -> Vec<f64> {
            let cell = cells.next().unwrap_or_default();
            cell.split(' ').map(|x| x.parse().unwrap_or_else(|_| panic!("a number in {line}"))).collect()
        };
        let (arguments, want) = (numbers(), numbers());
        let singles: Vec<f32> = arguments.iter().map(|x| *x as f32).collect();
        let doubles: Vec<f64> = singles.iter().map(|x| f64::from(*x)).collect();
        let (single, double) = ((term.single)(&singles), (term.double)(&doubles));
        found.resize(want.len(), Audit::default());
        for (result, audit) in found.iter_mut().enumerate() {
            let want = want[result];
            audit.points += 1;
            audit.single = audit.single.max(error(single[result], want));
            // Past the exponent's limit of f32 the file holds its 0.
            if want != 0.0 && want.abs() >= term.least {
                let off = (double[result] - want).abs() / ulp_double(want);
                assert!(off.is_finite(), "{}: {:e}, want {want:e} at {arguments:?}", term.name(), double[result]);
                if std::env::var_os("ACCURACY_SHOW").is_some() && (off > 1e4 || error(single[result], want) > 3.0) {
                    println!("{} {off:.2e} {:.2} at {arguments:?}", term.name(), error(single[result], want));
                }
                audit.double = audit.double.max(off);
            }
        }
    }
    found
}
