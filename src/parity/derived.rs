//! What the text of a twin allows and what it means, from evaluating the text itself.
//!
//! Over intervals ([`WgslInterval`](crate::interval::WgslInterval)) it gives, for each input, everything that WGSL's accuracy
//! table allows an adapter to return: the tolerance. Over f64 it gives what the twin says apart from rounding, which must
//! be what the Rust function says. Neither needs an adapter.

use super::table::Twin;
use crate::gpu::{GpuError, StackBuffers};
use crate::interval::{AccuracyTable, Interval, WgslInterval};
use crate::layered::{Interface, Layer, Medium};
use crate::shader::interp::{Buffers, Cell, InterpError, Known, Number, Program, Shader};
use crate::shader::{STORAGE_BINDING, Scalar};
use crate::wgsl;

/// The relative difference that two ways to round the same formula in f64 may leave.
const ROUNDING: f64 = 1e-13;

/// The ratio of the spacings of f64 and f32, 2⁻²⁹, twice: both sides round. To first order an error in f64 is at most this
/// times the width that the table gives the error in f32, each of whose operations may err by an ULP or more.
const CONDITION: f64 = 2.0 / 536_870_912.0;

/// Functions that approximate a method of `Real` to single precision, and the relative error that `wgsl/real.wgsl` states.
const APPROXIMATIONS: [(&str, Known, f64); 4] = [
    ("ln_one_plus", Known::LnOnePlus, 1.6e-8),
    ("angle", Known::Angle, 3e-9),
    ("erfcx", Known::Erfcx, 7e-9),
    ("unit_circle", Known::UnitCircle, 2.6e-9),
];

/// Constants that belong to the number type, in WGSL and in double precision: `Real::EXP_LIMIT` and √`Real::EPSILON`, the
/// largest number below 1, the limits of `src/walk/path.rs` (1e75 there; its square must be an f32 here) and
/// `src/walk/interface.rs`.
const OF_THE_PRECISION: [(&str, &str); 6] = [
    ("exp_limit: f32 = 87.0", "exp_limit: f32 = 708.0"),
    ("a * b <= 87.0", "a * b <= 708.0"),
    ("least_alpha: f32 = 1e-3", "least_alpha: f32 = 0.0"),
    ("matched_below: f32 = 3.4526698e-4", "matched_below: f32 = 1.4901161193847656e-8"),
    ("largest_root: f32 = 1e9", "largest_root: f32 = 1.8e19"),
    ("_below_one: f32 = 0x1.fffffep-1", "_below_one: f32 = 0x1.fffffffffffffp-1"),
];

/// Everything that an accuracy table allows each row of arguments, from the text of a twin.
///
/// # Errors
/// A text that is invalid or not supported.
pub fn allowed<T: AccuracyTable>(
    twin: &Twin,
    source: &str,
    rows: &[Vec<f32>],
    stacks: &StackBuffers,
) -> Result<Vec<Vec<Interval<T>>>, GpuError> {
    // The error-free transformations alone: that they are exact is tested on every adapter.
    let known = [("sum_exact", Known::SumExact), ("product_exact", Known::ProductExact)];
    let known = known.map(|(name, known)| (wgsl::mangled("real", name), known));
    evaluate(twin, source, &known, rows, stacks, |x| Interval::exactly(x as f32)).map_err(|error| failure(twin, &error))
}

/// The value of each row of arguments in double precision, from the text of a twin.
///
/// # Errors
/// A text that is invalid or not supported.
pub fn meaning(twin: &Twin, source: &str, rows: &[Vec<f32>], stacks: &StackBuffers) -> Result<Vec<Vec<f64>>, GpuError> {
    in_double(twin, source, rows, stacks)
}

/// How far a result in f64 is from the Rust function: as a share of what rounding may leave, and relatively.
pub(super) fn difference(twin: &Twin, want: f64, allowed: WgslInterval, meaning: f64) -> (f64, f64) {
    if meaning == want {
        return (0.0, 0.0);
    }
    if !meaning.is_finite() {
        return (f64::INFINITY, f64::INFINITY);
    }
    let approximation = APPROXIMATIONS.iter().find(|(name, ..)| (twin.module, twin.function) == ("real", *name));
    let relative = approximation.map_or(ROUNDING, |(.., bound)| *bound);
    // Where the table leaves a result open, rounding may decide which way the text goes.
    let width = if allowed.is_bounded() { allowed.high() - allowed.low() } else { f64::INFINITY };
    let difference = (meaning - want).abs();
    (difference / (relative * want.abs() + CONDITION * width), difference / want.abs())
}

fn failure(twin: &Twin, error: &InterpError) -> GpuError {
    GpuError::Arguments { function: twin.function.to_owned(), reason: error.to_string() }
}

/// The results of a twin's own text in f32 for rows of flat arguments: what an adapter computes, within what WGSL allows.
///
/// # Errors
/// A text that cannot be evaluated.
pub fn text_single(twin: &Twin, rows: &[Vec<f64>], stacks: &StackBuffers) -> Result<Vec<Vec<f64>>, GpuError> {
    let source = super::linked(twin)?;
    let rows: Vec<Vec<f64>> = rows.iter().map(|row| row.iter().map(|x| f64::from(*x as f32)).collect()).collect();
    let results = evaluate::<f32, _>(twin, &source, &[], &rows, stacks, |x: f64| x as f32);
    let double = |row: Vec<f32>| row.into_iter().map(f64::from).collect();
    results.map(|rows| rows.into_iter().map(double).collect()).map_err(|error| failure(twin, &error))
}

/// The results of a twin's own text in f64.
///
/// Literals are exact; approximations and limits that belong to single precision are those of f64, as for [`meaning`].
///
/// # Errors
/// A text that cannot be evaluated.
pub fn text_double(twin: &Twin, rows: &[Vec<f64>], stacks: &StackBuffers) -> Result<Vec<Vec<f64>>, GpuError> {
    in_double(twin, &super::linked(twin)?, rows, stacks)
}

fn in_double<T: Copy + Into<f64>>(
    twin: &Twin,
    source: &str,
    rows: &[Vec<T>],
    stacks: &StackBuffers,
) -> Result<Vec<Vec<f64>>, GpuError> {
    let known: Vec<_> = APPROXIMATIONS.iter().map(|(name, known, _)| (wgsl::mangled("real", name), *known)).collect();
    let of_single = |text: String, (single, double): &(&str, &str)| text.replace(single, double);
    let source = OF_THE_PRECISION.iter().fold(source.to_owned(), of_single);
    evaluate(twin, &source, &known, rows, stacks, |x| x).map_err(|error| failure(twin, &error))
}

/// A layer as `layered::Layer` of WGSL lists its numbers.
fn numbers(layer: &Layer<f64, 3>) -> Vec<f64> {
    let one = [1.0; 3];
    let (n, alpha, k, kind, albedo, deviation) = match layer.interface {
        Interface::Microfacet { n, k, alpha } => (n, alpha, k, 0.0, [0.0; 3], 0.0),
        Interface::Diffuse { albedo, sigma } => (one, 1.0, [0.0; 3], 1.0, albedo, sigma),
    };
    let Medium { sigma, thickness } = layer.medium;
    [&n[..], &[alpha], &k, &[kind], &albedo, &[deviation], &sigma, &[thickness]].concat()
}

/// Runs a twin's text over rows of flat arguments.
fn evaluate<N: Number, T: Copy + Into<f64>>(
    twin: &Twin,
    source: &str,
    known: &[(String, Known)],
    rows: &[Vec<T>],
    stacks: &StackBuffers,
    number: impl Fn(f64) -> N,
) -> Result<Vec<Vec<N>>, InterpError> {
    let bindings = stacks.bindings(source);
    let shader = Shader::in_double(&format!("{source}\n{bindings}"))?;
    let program = Program::<N>::with_known(&shader, &wgsl::mangled(twin.module, twin.function), known)?;
    let leaves = program.signature().map(|signature| signature.inputs()).unwrap_or_default();
    let cell = |(value, scalar): (&T, Scalar)| match (scalar, (*value).into()) {
        (Scalar::F32, value) => Cell::Real(number(value)),
        (Scalar::U32 | Scalar::Bool, value) => Cell::Word(value as u32),
        (Scalar::I32, value) => Cell::Word((value as i32).cast_unsigned()),
    };
    let cells: Vec<_> =
        rows.iter().flat_map(|row| row.iter().zip(leaves.iter().map(|leaf| leaf.scalar)).map(cell)).collect();
    let mut buffers = Buffers::new()
        .with_numbers(0, STORAGE_BINDING, stacks.layers.iter().flat_map(numbers).collect())
        .with_numbers(0, STORAGE_BINDING + 1, stacks.rows.as_flattened().to_vec())
        .with_numbers(0, STORAGE_BINDING + 2, stacks.fresnel.as_flattened().to_vec())
        .with_numbers(0, STORAGE_BINDING + 3, stacks.distribution.clone())
        .with_numbers(0, STORAGE_BINDING + 4, stacks.texels.as_flattened().to_vec())
        .with_numbers(0, STORAGE_BINDING + 5, stacks.stops.as_flattened().to_vec());
    let results = program.run(&cells, &mut buffers)?;
    let width = results.len() / rows.len().max(1);
    let real = |cell: &Cell<N>| match cell {
        Cell::Real(value) => *value,
        Cell::Word(word) => number(f64::from(*word)),
        Cell::Open => N::anything(),
    };
    Ok(results.chunks(width.max(1)).map(|row| row.iter().map(real).collect()).collect())
}
