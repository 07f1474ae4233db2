//! Agreement of the WGSL twins with the Rust functions.
//!
//! Each twin runs on an adapter over a corner lattice and a low-discrepancy sequence of inputs. Two things must hold.
//!
//! * The twin's text means what the Rust function says: evaluated in f64, both agree to 1e-13, or to what the condition of
//!   the input leaves of f64.
//! * The adapter computes what the text allows: each result lies in the interval that the text itself gives under WGSL's
//!   accuracy rules ([`WgslInterval`]). The tolerance is derived for each input and never tuned.
//!
//! [`allowed`], [`meaning`] and [`compare_meaning`] need no adapter.

mod derived;
mod draw;
#[macro_use]
mod table;
mod textures;

pub use derived::{allowed, meaning, text_double, text_single};
pub use draw::Draw;
pub use table::{Judge, Twin, buffers, twins};

use crate::frame::Vector;
use crate::gpu::{Gpu, GpuError, Kernel, StackBuffers};
use crate::interval::WgslInterval;
use crate::layered::{Model, Stack};
use crate::real::Real;
use crate::shader::{Leaf, Scalar};
use crate::wgsl;

/// The comparison of one function on one adapter.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// The module and name of the function.
    pub module: &'static str,
    /// The name of the function.
    pub function: &'static str,
    /// How many inputs were compared.
    pub samples: usize,
    /// The largest error of a result in f32 ULP of the f64 value; this and the next three over the results whose sign
    /// WGSL's rules settle.
    pub max_ulp: f64,
    /// The error in ULP that 99.9 % of the results stay under.
    pub p999_ulp: f64,
    /// The largest relative error.
    pub max_relative: f64,
    /// The relative error that 99.9 % of the results stay under.
    pub p999_relative: f64,
    /// The largest share of the allowed error that a result used; 1 is the limit.
    pub share: f64,
    /// How many results WGSL's rules say nothing about.
    pub unbounded: usize,
    /// How many results lie outside what WGSL allows.
    pub outside: usize,
    /// The largest difference between the twin's text in f64 and the Rust function, as a share of what rounding in f64 may
    /// leave; 1 is the limit.
    pub meaning: f64,
    /// How many results of the text in f64 differ by more.
    pub misunderstood: usize,
    /// The input of the result furthest outside what is allowed or, where none is, of the largest error.
    pub worst: Option<Worst>,
}

impl Comparison {
    /// Whether every result was allowed, and the text means what the Rust function says.
    pub fn agrees(&self) -> bool {
        self.outside == 0 && self.misunderstood == 0
    }
}

/// One result that stands out.
#[derive(Clone, Debug)]
pub struct Worst {
    /// The arguments, each with its name.
    pub inputs: Vec<(String, f64)>,
    /// Which result it is.
    pub output: String,
    /// What the adapter gave.
    pub got: f32,
    /// The f64 value.
    pub want: f64,
    /// The smallest and largest allowed value.
    pub allowed: (f64, f64),
}

/// Runs a twin over this many samples on an adapter.
///
/// # Errors
///
/// Whatever stops the kernel from being built or run, by name of the function.
pub fn compare(gpu: &Gpu, twin: &Twin, samples: usize) -> Result<Comparison, GpuError> {
    compare_source(gpu, twin, &linked(twin)?, samples)
}

/// Compares any WGSL text in place of the twin's own: plain WGSL that declares the function under its linked name.
///
/// # Errors
///
/// Whatever stops the kernel from being built or run.
pub fn compare_source(gpu: &Gpu, twin: &Twin, source: &str, samples: usize) -> Result<Comparison, GpuError> {
    let rows = sampled(twin, samples);
    let stacks = buffers(source);
    let outputs = map_source(gpu, twin, source, &rows, stacks)?;
    let reference = Reference::new(twin, source, &twin.double, &rows, stacks)?;
    Ok(judge(twin, &reference, &rows, &outputs))
}

/// Compares the twin of a stack's model with the Rust function over this many pairs of directions.
///
/// # Errors
///
/// Whatever stops the kernel from being built or run; a model without a twin.
pub fn compare_stack(gpu: &Gpu, stack: &Stack<f32, 3>, samples: usize) -> Result<Comparison, GpuError> {
    let twin = stack_twin(stack.model()).ok_or_else(|| {
        let function = stack.model().name().to_owned();
        GpuError::Arguments { function, reason: "the model has no twin in WGSL".to_owned() }
    })?;
    let mut stacks = StackBuffers::default();
    let place = stack_arguments(stack, &mut stacks);
    let start = place.len();
    let narrowest = table::narrowest(stack.effective_layers());
    let rows: Vec<Vec<f32>> = (0..samples as u64)
        .map(|index| {
            let [wi, wo] = Draw::new(index).pair(narrowest).map(Vector::cast::<f32>);
            place.iter().copied().chain([wi.x, wi.y, wi.z, wo.x, wo.y, wo.z]).collect()
        })
        .collect();
    let outputs = map_twin(gpu, &twin, &rows, &stacks)?;
    let double = stack.cast::<f64>();
    let double = |a: &[f64]| {
        let [wi, wo] = [start, start + 3].map(|at| Vector::new(a[at], a[at + 1], a[at + 2]));
        double.evaluate(wi, wo).to_vec()
    };
    let reference = Reference::new(&twin, &linked(&twin)?, &double, &rows, &stacks)?;
    Ok(judge(&twin, &reference, &rows, &outputs))
}

/// How well the text of a twin means what the Rust function says, both in double precision.
#[derive(Clone, Debug)]
pub struct Meaning {
    /// The largest relative difference.
    pub relative: f64,
    /// The largest difference as a share of what rounding in f64 may leave; 1 is the limit.
    pub share: f64,
    /// How many results differ by more.
    pub misunderstood: usize,
    /// The arguments of the largest share, which result it is, what the text says and what the function.
    pub worst: Option<(Vec<f32>, usize, f64, f64)>,
}

/// Compares the meaning of a text with the Rust function of a twin; no adapter is needed.
///
/// # Errors
///
/// A text that is invalid or cannot be evaluated.
pub fn compare_meaning(twin: &Twin, source: &str, samples: usize) -> Result<Meaning, GpuError> {
    let rows = sampled(twin, samples);
    let reference = Reference::new(twin, source, &twin.double, &rows, buffers(source))?;
    let mut result = Meaning { relative: 0.0, share: 0.0, misunderstood: 0, worst: None };
    for (row, ((want, allowed), meaning)) in
        rows.iter().zip(reference.want.iter().zip(&reference.allowed).zip(&reference.meaning))
    {
        for (output, ((want, allowed), meaning)) in want.iter().zip(allowed).zip(meaning).enumerate() {
            let (share, relative) = derived::difference(twin, *want, *allowed, *meaning);
            result.relative = result.relative.max(relative);
            result.misunderstood += usize::from(share > 1.0);
            if share > result.share {
                result.share = share;
                result.worst = Some((row.clone(), output, *meaning, *want));
            }
        }
    }
    Ok(result)
}

/// The arguments of this many samples.
fn sampled(twin: &Twin, samples: usize) -> Vec<Vec<f32>> {
    let row = |index| (twin.sample)(&mut Draw::new(index)).into_iter().map(|value| value as f32).collect();
    (0..samples as u64).map(row).collect()
}

/// What a twin is judged by, row by row.
struct Reference {
    /// The Rust function in f64.
    want: Vec<Vec<f64>>,
    /// What WGSL allows the text.
    allowed: Vec<Vec<WgslInterval>>,
    /// The text in f64.
    meaning: Vec<Vec<f64>>,
}

impl Reference {
    fn new(
        twin: &Twin,
        source: &str,
        double: &dyn Fn(&[f64]) -> Vec<f64>,
        rows: &[Vec<f32>],
        stacks: &StackBuffers,
    ) -> Result<Self, GpuError> {
        let exact = |row: &Vec<f32>| double(&row.iter().map(|x| f64::from(*x)).collect::<Vec<_>>());
        let points = |row: &Vec<f32>| row.iter().map(|x| WgslInterval::exactly(*x)).collect::<Vec<_>>();
        Ok(Reference {
            want: rows.iter().map(exact).collect(),
            allowed: match twin.judge {
                Judge::Allowed => derived::allowed(twin, source, rows, stacks)?,
                // To be exact is what these promise, and what intervals take them at their word for.
                Judge::ErrorFree => rows.iter().map(|row| (twin.allowed)(&points(row))).collect(),
            },
            meaning: derived::meaning(twin, source, rows, stacks)?,
        })
    }
}

/// The twin that evaluates stacks under a model, where there is one.
pub fn stack_twin(model: Model) -> Option<Twin> {
    twins().into_iter().find(|twin| twin.module == "layered" && twin.function == model.name())
}

/// Appends a stack to what the twins read. Returns what the twin of its model takes before the two directions: the first
/// layer, the number of layers and, under [`Model::Coupled`], the first row of the table.
pub fn stack_arguments<R: Real>(stack: &Stack<R, 3>, stacks: &mut StackBuffers) -> Vec<f32> {
    let place = stacks.push(stack);
    let table = (stack.model() == Model::Coupled).then_some(place.table);
    [place.first, place.count].into_iter().chain(table).map(|index| index as f32).collect()
}

/// The results of a function on an adapter, and the names of its arguments and results.
#[derive(Clone, Debug)]
pub struct Outputs {
    /// The names of the arguments, flat.
    pub inputs: Vec<String>,
    /// The names of the results of a row, flat.
    pub names: Vec<String>,
    /// The results, row by row.
    pub values: Vec<f32>,
}

/// Maps a twin over rows of flat arguments on an adapter. `stacks` are what the twins of stacks read.
///
/// # Errors
///
/// Whatever stops the kernel from being built or run, by name of the function.
pub fn map_twin(gpu: &Gpu, twin: &Twin, rows: &[Vec<f32>], stacks: &StackBuffers) -> Result<Outputs, GpuError> {
    map_source(gpu, twin, &linked(twin)?, rows, stacks)
}

/// The WGSL of a twin with all that it needs.
fn linked(twin: &Twin) -> Result<String, GpuError> {
    wgsl::link_function(twin.module, twin.function)
        .map_err(|error| GpuError::Arguments { function: twin.function.to_owned(), reason: error.to_string() })
}

fn map_source(
    gpu: &Gpu,
    twin: &Twin,
    source: &str,
    rows: &[Vec<f32>],
    stacks: &StackBuffers,
) -> Result<Outputs, GpuError> {
    let bindings = stacks.bindings(source);
    let kernel = Kernel::new(gpu, source, &wgsl::mangled(twin.module, twin.function), Some(&bindings))?;
    let leaves = kernel.signature().inputs();
    let word = |(value, leaf): (&f32, &Leaf)| match leaf.scalar {
        Scalar::F32 => value.to_bits(),
        Scalar::U32 | Scalar::Bool => *value as u32,
        Scalar::I32 => (*value as i32).cast_unsigned(),
    };
    let words: Vec<u32> = rows.iter().flat_map(|row| row.iter().zip(&leaves).map(word)).collect();
    let storage = stacks.storage(source);
    let storage: Vec<&[u8]> = storage.iter().map(Vec::as_slice).collect();
    let values = kernel.run(&words, &storage)?.into_iter().map(f32::from_bits).collect();
    let name = |leaf: Leaf| leaf.name;
    Ok(Outputs {
        inputs: leaves.into_iter().map(name).collect(),
        names: kernel.signature().outputs().into_iter().map(name).collect(),
        values,
    })
}

/// Compares an adapter's results with the Rust function.
fn judge(twin: &Twin, reference: &Reference, rows: &[Vec<f32>], outputs: &Outputs) -> Comparison {
    let mut errors = Errors::default();
    let mut result = Comparison {
        module: twin.module,
        function: twin.function,
        samples: rows.len(),
        max_ulp: 0.0,
        p999_ulp: 0.0,
        max_relative: 0.0,
        p999_relative: 0.0,
        share: 0.0,
        unbounded: 0,
        outside: 0,
        meaning: 0.0,
        misunderstood: 0,
        worst: None,
    };
    // What stands out most: a forbidden result before an allowed one, then the larger share or error.
    let mut rank = (false, -1.0);
    let width = outputs.names.len();
    for (index, (row, got)) in rows.iter().zip(outputs.values.chunks_exact(width)).enumerate() {
        let exact: Vec<f64> = row.iter().map(|x| f64::from(*x)).collect();
        let (want, allowed, meaning) = (&reference.want[index], &reference.allowed[index], &reference.meaning[index]);
        let got: Vec<f64> = got.iter().map(|g| f64::from(*g)).collect();
        // The sum of an error-free pair is exact but for products of two roundings, in the interval's second part.
        let sum = |pair: &[f64]| vec![pair.iter().sum::<f64>()];
        let (want, allowed, meaning, got) = match twin.judge {
            Judge::Allowed => (want.clone(), allowed.clone(), meaning.clone(), got),
            Judge::ErrorFree => (sum(want), vec![allowed[0].widened(allowed[1])], sum(meaning), sum(&got)),
        };
        for ((want, allowed), meaning) in want.iter().zip(&allowed).zip(meaning) {
            let (share, _) = derived::difference(twin, *want, *allowed, meaning);
            result.meaning = result.meaning.max(share);
            result.misunderstood += usize::from(share > 1.0);
        }
        for (output, got) in got.into_iter().enumerate() {
            let (want, allowed) = (want[output], allowed[output]);
            let error = (got - want).abs();
            let room = (allowed.high() - want).max(want - allowed.low());
            let inside = allowed.low() <= got && got <= allowed.high();
            let share = if error == 0.0 { 0.0 } else { error / room };
            // Where the sign is open (a difference that cancels, the underflow of exp) a relative error says nothing.
            let signed = allowed.low() > 0.0 || allowed.high() < 0.0;
            let (outside, standing) = if allowed.is_bounded() {
                result.share = result.share.max(if inside { share } else { 0.0 });
                (
                    !inside,
                    if !inside {
                        share.max(1.0)
                    } else if signed {
                        errors.add(error, want)
                    } else {
                        0.0
                    },
                )
            } else {
                result.unbounded += 1;
                // Even where the rules are silent, a finite value must not become NaN or infinite.
                (!got.is_finite() && want.abs() < f64::from(f32::MAX), 0.0)
            };
            result.outside += usize::from(outside);
            if (outside, standing) > rank || !standing.is_finite() && outside && !rank.0 {
                rank = (outside, standing);
                result.worst = Some(Worst {
                    inputs: outputs.inputs.iter().cloned().zip(exact.iter().copied()).collect(),
                    output: outputs.names[output].clone(),
                    got: got as f32,
                    want,
                    allowed: (allowed.low(), allowed.high()),
                });
            }
        }
    }
    [result.max_ulp, result.p999_ulp] = Errors::largest_and_rare(&mut errors.ulp);
    [result.max_relative, result.p999_relative] = Errors::largest_and_rare(&mut errors.relative);
    result
}

/// The errors of all results of a function.
#[derive(Default)]
struct Errors {
    ulp: Vec<f64>,
    relative: Vec<f64>,
}

impl Errors {
    /// Records an error and returns it in ULP.
    fn add(&mut self, error: f64, want: f64) -> f64 {
        let magnitude = want.abs().max(f64::from(f32::MIN_POSITIVE));
        let ulp = error / 2f64.powi(magnitude.log2().floor() as i32 - 23);
        self.ulp.push(ulp);
        self.relative.push(error / magnitude);
        ulp
    }

    /// The largest of the errors, and the one that a thousandth exceed.
    fn largest_and_rare(errors: &mut [f64]) -> [f64; 2] {
        errors.sort_by(f64::total_cmp);
        match errors.last() {
            Some(largest) => [*largest, errors[(errors.len() - 1) * 999 / 1000]],
            None => [0.0; 2],
        }
    }
}
