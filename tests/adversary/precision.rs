//! The error of every term and closed-form stack in f32, maximised over the domain that `tests/accuracy` measures.
//!
//! The genes are the coordinates of the point that a row is drawn from. `Single` states no bound and is left out.

use crate::inputs::{DIMENSIONS, Point};
use crate::meter::{error, stated_bound};
use crate::strategy::Search;
use crate::terms::{Term, terms};
use crate::{generations, in_parallel};

/// The row that genes stand for.
pub(crate) fn row(term: &Term, genes: &[f64]) -> Vec<f32> {
    // The sequence that rows are otherwise drawn from does not reach 1.
    let point: Point = std::array::from_fn(|i| genes[i].min(1.0 - f64::EPSILON));
    (term.draw)(&point)
}

/// The largest error of a term's results in ULP; none where none is measured.
pub(crate) fn worst_result(term: &Term, row: &[f32]) -> Option<f64> {
    let wide: Vec<f64> = row.iter().map(|x| f64::from(*x)).collect();
    if (term.past)(&wide) {
        return None;
    }
    let (got, want) = ((term.single)(row), (term.double)(&wide));
    let measured = (0..term.results.len()).filter(|i| term.measures(want[*i]));
    measured.map(|i| error(got[i], want[i])).reduce(f64::max)
}

#[test]
fn no_input_exceeds_the_documented_error() {
    let finds = in_parallel(terms(), |term| {
        let search = Search { genes: DIMENSIONS, generations: generations(250), restarts: 4, seed: 11 };
        let find = search.run(|genes| worst_result(&term, &row(&term, genes)).unwrap_or(-1.0));
        (term, find)
    });
    let mut broken = Vec::new();
    for (term, find) in finds {
        let (bound, row) = (stated_bound(term.module, term.function), row(&term, &find.genes));
        println!("{:42} {:7} {:8.4} of {bound} {row:?}", term.name(), find.evaluations, find.fitness);
        if !(0.0..=bound).contains(&find.fitness) {
            broken.push(format!("{}: {} ULP, documented {bound}, at {row:?}", term.name(), find.fitness));
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}
