//! A variant on the processor: its passes, and its results in both precisions.

use super::formula::{Batched, Constants, Formula};
use crate::bench::clock::Task;
use brdf::Vector;
use brdf::batch::{self, GRAIN, Level};
use brdf::layered::{Interface, Layer, Model, Stack};
use brdf::plan::Plan;
use std::array::from_fn;
use std::hint::black_box;

/// Evaluations of a pass on one thread: inputs and results fit the second cache.
const CACHED: usize = 8192;

/// A formula whose shape is left to the run time.
pub(super) trait Runner {
    /// The scalar function in a loop, one call after the other.
    fn scalar<'a>(&'a self, columns: &'a [Vec<f32>]) -> Task<'a>;
    /// A batch on this thread, out of the cache.
    fn batch<'a>(&'a self, level: Level, columns: &'a [Vec<f32>]) -> Task<'a>;
    /// A batch on all threads, at the fastest level.
    fn threads<'a>(&'a self, threads: usize, columns: &'a [Vec<f32>]) -> Task<'a>;
    /// The results of the scalar function, one after the other.
    fn singles(&self, columns: &[Vec<f32>]) -> Vec<f64>;
    /// The results of a batch.
    fn batched(&self, level: Level, columns: &[Vec<f32>]) -> Vec<f64>;
    /// The results in double precision.
    fn doubles(&self, columns: &[Vec<f32>]) -> Vec<f64>;
}

/// A formula of known shape.
pub(super) struct Shaped<F, const I: usize, const O: usize>(pub(super) F);

/// Columns as the batch takes them.
fn inputs<const I: usize>(columns: &[Vec<f32>], count: usize) -> [&[f32]; I] {
    from_fn(|i| &columns[i][..count])
}

fn outputs<const O: usize>(columns: &mut [Vec<f32>; O]) -> [&mut [f32]; O] {
    columns.each_mut().map(Vec::as_mut_slice)
}

fn rows<const O: usize>(columns: &[Vec<f32>; O]) -> Vec<f64> {
    (0..columns[0].len()).flat_map(|row| columns.each_ref().map(|column| f64::from(column[row]))).collect()
}

impl<F: Formula<I, O>, const I: usize, const O: usize> Runner for Shaped<F, I, O> {
    fn scalar<'a>(&'a self, columns: &'a [Vec<f32>]) -> Task<'a> {
        Task::new(CACHED, move || {
            let (formula, inputs) = (black_box(&self.0), inputs::<I>(columns, CACHED));
            (0..CACHED).for_each(|row| {
                black_box(formula.at::<f32>(from_fn(|i| inputs[i][row])));
            });
        })
    }

    fn batch<'a>(&'a self, level: Level, columns: &'a [Vec<f32>]) -> Task<'a> {
        let mut results: [Vec<f32>; O] = from_fn(|_| vec![0.0; CACHED]);
        Task::new(CACHED, move || {
            let kernel = Batched(black_box(&self.0));
            // The lengths are equal.
            let _ = batch::map_at(level, &kernel, inputs::<I>(columns, CACHED), outputs(&mut results));
            black_box(&mut results);
        })
    }

    fn threads<'a>(&'a self, threads: usize, columns: &'a [Vec<f32>]) -> Task<'a> {
        let count = 4 * threads * GRAIN;
        let columns: Vec<Vec<f32>> =
            columns.iter().map(|column| column.iter().copied().cycle().take(count).collect()).collect();
        let mut results: [Vec<f32>; O] = from_fn(|_| vec![0.0; count]);
        Task::new(count, move || {
            let kernel = Batched(black_box(&self.0));
            let _ = batch::par_map(&kernel, inputs::<I>(&columns, count), outputs(&mut results));
            black_box(&mut results);
        })
    }

    fn singles(&self, columns: &[Vec<f32>]) -> Vec<f64> {
        let row = |row: usize| self.0.at::<f32>(from_fn(|i| columns[i][row])).map(f64::from);
        (0..columns[0].len()).flat_map(row).collect()
    }

    fn batched(&self, level: Level, columns: &[Vec<f32>]) -> Vec<f64> {
        let count = columns[0].len();
        let mut results: [Vec<f32>; O] = from_fn(|_| vec![0.0; count]);
        let _ = batch::map_at(level, &Batched(&self.0), inputs::<I>(columns, count), outputs(&mut results));
        rows(&results)
    }

    fn doubles(&self, columns: &[Vec<f32>]) -> Vec<f64> {
        let row = |row: usize| self.0.at::<f64>(from_fn(|i| f64::from(columns[i][row])));
        (0..columns[0].len()).flat_map(row).collect()
    }
}

/// A plan of one rough conductor.
pub(super) struct Planned(Plan<3>);

impl Planned {
    pub(super) fn new(constants: &Constants, max_error: f64) -> Option<Self> {
        let Constants { n, k, alpha, .. } = constants;
        let metal = Interface::conductor(n.map(f64::from), k.map(f64::from), f64::from(*alpha));
        let stack = Stack::new(Model::Conserving, vec![Layer::new(metal)]).ok()?;
        Some(Planned(Plan::with_error(&stack, max_error).ok()?))
    }
}

/// The two directions of a row.
fn pair(columns: &[Vec<f32>], row: usize) -> [Vector<f32>; 2] {
    [0, 3].map(|first| Vector::new(columns[first][row], columns[first + 1][row], columns[first + 2][row]))
}

fn halves(columns: &[Vec<f32>], count: usize) -> ([&[f32]; 3], [&[f32]; 3]) {
    let [a, b, c, d, e, f] = inputs::<6>(columns, count);
    ([a, b, c], [d, e, f])
}

impl Runner for Planned {
    fn scalar<'a>(&'a self, columns: &'a [Vec<f32>]) -> Task<'a> {
        Task::new(CACHED, move || {
            let plan = black_box(&self.0);
            (0..CACHED).for_each(|row| {
                let [wi, wo] = pair(columns, row);
                black_box(plan.evaluate::<f32>(wi, wo));
            });
        })
    }

    fn batch<'a>(&'a self, level: Level, columns: &'a [Vec<f32>]) -> Task<'a> {
        let mut results: [Vec<f32>; 3] = from_fn(|_| vec![0.0; CACHED]);
        Task::new(CACHED, move || {
            let (wi, wo) = halves(columns, CACHED);
            // The lengths are equal.
            let _ = black_box(&self.0).evaluate_batch_at(level, wi, wo, outputs(&mut results));
            black_box(&mut results);
        })
    }

    fn threads<'a>(&'a self, threads: usize, columns: &'a [Vec<f32>]) -> Task<'a> {
        let count = 4 * threads * GRAIN;
        let columns: Vec<Vec<f32>> =
            columns.iter().map(|column| column.iter().copied().cycle().take(count).collect()).collect();
        let mut results: [Vec<f32>; 3] = from_fn(|_| vec![0.0; count]);
        Task::new(count, move || {
            let (wi, wo) = halves(&columns, count);
            let _ = black_box(&self.0).par_evaluate_batch(wi, wo, outputs(&mut results));
            black_box(&mut results);
        })
    }

    fn singles(&self, columns: &[Vec<f32>]) -> Vec<f64> {
        let row = |row: usize| {
            let [wi, wo] = pair(columns, row);
            self.0.evaluate::<f32>(wi, wo).map(f64::from)
        };
        (0..columns[0].len()).flat_map(row).collect()
    }

    fn batched(&self, level: Level, columns: &[Vec<f32>]) -> Vec<f64> {
        let count = columns[0].len();
        let mut results: [Vec<f32>; 3] = from_fn(|_| vec![0.0; count]);
        let (wi, wo) = halves(columns, count);
        let _ = self.0.evaluate_batch_at(level, wi, wo, outputs(&mut results));
        rows(&results)
    }

    fn doubles(&self, columns: &[Vec<f32>]) -> Vec<f64> {
        let row = |row: usize| {
            let [wi, wo] = pair(columns, row);
            self.0.evaluate::<f64>(wi.cast(), wo.cast())
        };
        (0..columns[0].len()).flat_map(row).collect()
    }
}
