//! Many evaluations at once: slices in, slices out, in vector instructions.
//!
//! A [`Kernel`] is a formula over [`Real`], one evaluation of it; [`map`] runs it over structure-of-arrays slices in
//! [`Single`](crate::single::Single) precision. The same formula is compiled for each instruction set that is worth it, and the fastest one
//! that the processor has is chosen when it runs ([`Level::detect`]). Nothing is allocated. [`terms`] has a kernel for each term of
//! the crate; [`Plan::evaluate_batch`](crate::plan::Plan::evaluate_batch) runs whole stacks.
//!
//! ```
//! use brdf::batch::{self, terms};
//!
//! let cos = [1.0f32, 0.5, 0.1];
//! let (mut reflected, mut transmitted) = ([0.0; 3], [0.0; 3]);
//! batch::map(&terms::Conductor { n: 1.04, k: 2.59 }, [&cos], [&mut reflected, &mut transmitted])?;
//! assert!((reflected[0] + transmitted[0] - 1.0).abs() < 1e-6);
//! # Ok::<(), batch::LengthError>(())
//! ```
//!
//! # Accuracy
//!
//! That of f32 throughout, term by term in `docs/accuracy.md`, column *batch*. With and without fused multiply-adds results
//! differ in their last bits: for the same bits on every machine fix the [`Level`].
//!
//! # Layout
//!
//! Slices that all start at the same place of a page of memory, as large allocations do, share the ways of the first cache: such
//! arrays cost 10 to 20 % from memory. Start each a cache line (16 numbers) further into its allocation than the one before.

pub(crate) mod dispatch;
pub(crate) mod lanes;
mod stack;
pub mod terms;
#[cfg(target_arch = "x86_64")]
mod x86;

use crate::real::Real;
use core::fmt;
pub use dispatch::Level;

/// A formula from `I` numbers to `O` numbers, over any of the crate's number types.
///
/// [`map`] vectorises it where it is inlined whole and does not branch: mark `evaluate` and what it calls `#[inline(always)]`,
/// and choose by [`Real::select`].
pub trait Kernel<const I: usize, const O: usize>: Sync {
    /// One evaluation.
    fn evaluate<R: Real<Wide = R>>(&self, inputs: [R; I]) -> [R; O];
}

/// Slices of different lengths.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LengthError {
    /// The length of the first input.
    pub expected: usize,
    /// The length of the one that differs.
    pub found: usize,
    /// Which one: inputs counted from 0, then outputs.
    pub slice: usize,
}

impl fmt::Display for LengthError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let LengthError { expected, found, slice } = self;
        write!(f, "slice {slice} has {found} numbers, but the first input has {expected}")
    }
}

impl core::error::Error for LengthError {}

/// Evaluates a kernel for each index of the slices, on the calling thread.
///
/// # Errors
/// Where the slices differ in length; nothing is written then.
pub fn map<K: Kernel<I, O>, const I: usize, const O: usize>(
    kernel: &K,
    inputs: [&[f32]; I],
    outputs: [&mut [f32]; O],
) -> Result<(), LengthError> {
    map_at(Level::detect(), kernel, inputs, outputs)
}

/// [`map`] with the instructions of a level that this processor has.
///
/// # Errors
/// As [`map`].
pub fn map_at<K: Kernel<I, O>, const I: usize, const O: usize>(
    level: Level,
    kernel: &K,
    inputs: [&[f32]; I],
    outputs: [&mut [f32]; O],
) -> Result<(), LengthError> {
    check_lengths(&inputs, &outputs)?;
    level.run(dispatch::Map { kernel, inputs, outputs });
    Ok(())
}

/// [`map`] on the threads of rayon's current pool. The slices are halved down to [`GRAIN`] evaluations.
///
/// # Errors
/// As [`map`].
#[cfg(feature = "rayon")]
pub fn par_map<K: Kernel<I, O>, const I: usize, const O: usize>(
    kernel: &K,
    inputs: [&[f32]; I],
    outputs: [&mut [f32]; O],
) -> Result<(), LengthError> {
    let count = check_lengths(&inputs, &outputs)?;
    let level = Level::detect();
    halve(count, inputs, outputs, &|inputs, outputs| level.run(dispatch::Map { kernel, inputs, outputs }));
    Ok(())
}

/// The evaluations below which a thread does not share its work: some 50 µs of it.
#[cfg(feature = "rayon")]
pub const GRAIN: usize = 16_384;

/// Calls `run` on both halves of the slices in parallel, down to the grain. Allocates nothing.
#[cfg(feature = "rayon")]
pub(crate) fn halve<const I: usize, const O: usize>(
    count: usize,
    inputs: [&[f32]; I],
    outputs: [&mut [f32]; O],
    run: &(impl Fn([&[f32]; I], [&mut [f32]; O]) + Sync),
) {
    if count <= GRAIN {
        return run(inputs, outputs);
    }
    // Whole vectors, so that no half ends in a remainder but the last.
    let middle = (count / 2).next_multiple_of(64);
    let [left, right] =
        [0, 1].map(|half| inputs.map(|slice| if half == 0 { &slice[..middle] } else { &slice[middle..] }));
    let mut rest = outputs.map(|slice| Some(slice.split_at_mut(middle)));
    let mut lower: [&mut [f32]; O] = [(); O].map(|()| &mut [][..]);
    let mut upper: [&mut [f32]; O] = [(); O].map(|()| &mut [][..]);
    for ((pair, low), high) in rest.iter_mut().zip(&mut lower).zip(&mut upper) {
        if let Some((a, b)) = pair.take() {
            (*low, *high) = (a, b);
        }
    }
    rayon::join(|| halve(middle, left, lower, run), || halve(count - middle, right, upper, run));
}

/// The length that all slices share.
pub(crate) fn check_lengths(inputs: &[&[f32]], outputs: &[&mut [f32]]) -> Result<usize, LengthError> {
    let lengths = || inputs.iter().map(|slice| slice.len()).chain(outputs.iter().map(|slice| slice.len()));
    let expected = lengths().next().unwrap_or(0);
    match lengths().enumerate().find(|(_, found)| *found != expected) {
        Some((slice, found)) => Err(LengthError { expected, found, slice }),
        None => Ok(expected),
    }
}
