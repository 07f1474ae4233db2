//! `brdf bench machine`: what this processor can do at best, by measurement.
//!
//! Rates are of single-precision numbers, not of instructions: a register of eight counts as eight. Each is the best of
//! several passes over arrays in the first cache, twelve chains that do not wait for each other.

use super::clock::{self, Budget, Task};
use super::host;
use crate::failure::Failure;
use brdf::Real;
use brdf::batch::{self, Kernel, Level};
use clap::Args;
use rayon::prelude::*;
use serde_json::{Value, json};
use std::hint::black_box;
use std::io::{self, Write};
use std::process::ExitCode;

/// What `brdf bench machine` is asked for.
#[derive(Args)]
pub(crate) struct Options {
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// A short measurement, too short to quote.
    #[arg(long)]
    quick: bool,
}

pub(crate) fn run(options: &Options) -> Result<ExitCode, Failure> {
    let machine = Machine::measure(options.quick)?;
    let mut out = io::stdout().lock();
    if options.json {
        writeln!(out, "{:#}", machine.as_json())?;
    } else {
        machine.print(&mut out)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The peaks of this machine.
pub(super) struct Machine {
    pub(super) processor: String,
    pub(super) threads: usize,
    pub(super) peaks: Vec<Peak>,
    /// Bytes read and written in a second, by one thread and by all.
    pub(super) copy: [f64; 2],
    /// The bytes of each of the two arrays of the copy.
    pub(super) copy_bytes: usize,
    quick: bool,
}

/// What a level does in a second.
pub(super) struct Peak {
    pub(super) level: Level,
    pub(super) threads: usize,
    /// Products with a sum: one instruction where the level has it, else two.
    pub(super) multiply_adds: f64,
    /// Products and sums in turns, each an instruction: what simple operations can reach.
    pub(super) operations: f64,
    pub(super) divides: f64,
    pub(super) roots: f64,
    /// Times that it does everything in [`WORK`].
    pub(super) work: f64,
}

/// The arithmetic of an evaluation.
pub(super) struct Work {
    /// Products, fused with a sum or not.
    pub(super) products: usize,
    pub(super) sums: usize,
    /// Comparisons, selects, minima, maxima, changes of an exponent.
    pub(super) choices: usize,
    pub(super) divides: usize,
    pub(super) roots: usize,
}

/// The exact RGB Torrance–Sparrow BRDF of a metal as `Plan::evaluate_batch` has it: counted in the machine code of its loop with
/// AVX-512. What the loop itself takes is left out.
pub(super) const WORK: Work = Work { products: 77, sums: 40, choices: 11, divides: 4, roots: 6 };

/// The length of the arrays: both fit the first cache.
const LENGTH: usize = 2048;
/// Independent chains, enough to hide the latency and few enough for sixteen registers.
const CHAINS: usize = 12;
/// The steps of each chain.
const STEPS: usize = 16;

/// Does something to each chain sixteen times, written out: a loop would keep the compiler from vectorising around it.
macro_rules! sixteen_times {
    ($body:block) => {
        $body $body $body $body $body $body $body $body
        $body $body $body $body $body $body $body $body
    };
}

/// The constants of the chains, read when the kernel runs.
#[derive(Clone, Copy)]
struct Chains {
    start: [f32; CHAINS],
    factor: f32,
    addend: f32,
}

impl Chains {
    fn new() -> Self {
        black_box(Chains { start: std::array::from_fn(|i| 0.125 * (i + 1) as f32), factor: 0.75, addend: 0.375 })
    }

    #[inline(always)]
    fn numbers<R: Real>(&self, x: R) -> ([R; CHAINS], R, R) {
        let mut chains = [x; CHAINS];
        for (chain, start) in chains.iter_mut().zip(&self.start) {
            *chain = x + R::from_f64(f64::from(*start));
        }
        (chains, R::from_f64(f64::from(self.factor)), R::from_f64(f64::from(self.addend)))
    }
}

#[inline(always)]
fn sum<R: Real>(chains: [R; CHAINS]) -> [R; 1] {
    let [a, b, c, d, e, f, g, h, i, j, k, l] = chains;
    [((a + b) + (c + d)) + ((e + f) + (g + h)) + ((i + j) + (k + l))]
}

struct MultiplyAdds(Chains);
impl Kernel<1, 1> for MultiplyAdds {
    #[inline(always)]
    fn evaluate<R: Real<Wide = R>>(&self, [x]: [R; 1]) -> [R; 1] {
        let (mut chains, factor, addend) = self.0.numbers(x);
        sixteen_times!({
            for chain in &mut chains {
                *chain = chain.mul_add(factor, addend);
            }
        });
        sum(chains)
    }
}

struct Operations(Chains);
impl Kernel<1, 1> for Operations {
    #[inline(always)]
    fn evaluate<R: Real<Wide = R>>(&self, [x]: [R; 1]) -> [R; 1] {
        let (mut chains, factor, addend) = self.0.numbers(x);
        sixteen_times!({
            for chain in &mut chains {
                *chain = *chain * factor + addend;
            }
        });
        sum(chains)
    }
}

struct Divides(Chains);
impl Kernel<1, 1> for Divides {
    #[inline(always)]
    fn evaluate<R: Real<Wide = R>>(&self, [x]: [R; 1]) -> [R; 1] {
        let (mut chains, factor, _) = self.0.numbers(x);
        for chain in &mut chains {
            *chain = factor / *chain;
        }
        sum(chains)
    }
}

struct Roots(Chains);
impl Kernel<1, 1> for Roots {
    #[inline(always)]
    fn evaluate<R: Real<Wide = R>>(&self, [x]: [R; 1]) -> [R; 1] {
        let (mut chains, _, _) = self.0.numbers(x);
        for chain in &mut chains {
            *chain = chain.sqrt();
        }
        sum(chains)
    }
}

/// [`WORK`] with nothing that waits for long: units that different operations share are shared here too.
struct Everything(Chains);
impl Kernel<1, 1> for Everything {
    #[inline(always)]
    fn evaluate<R: Real<Wide = R>>(&self, [x]: [R; 1]) -> [R; 1] {
        let (mut chains, factor, addend) = self.0.numbers(x);
        // That took a sum for each chain, and the end takes as many but one. Rounds are written out: see `sixteen_times`.
        const { assert!(WORK.products == 6 * CHAINS + 5 && WORK.sums == (2 * CHAINS - 1) + CHAINS + 5) };
        for chain in chains.iter_mut().take(WORK.roots) {
            *chain = chain.sqrt();
        }
        for chain in chains.iter_mut().rev().take(WORK.divides) {
            *chain = factor / *chain;
        }
        let multiply = |chain: &mut R| *chain = chain.mul_add(factor, addend);
        chains.iter_mut().for_each(multiply);
        chains.iter_mut().for_each(multiply);
        chains.iter_mut().for_each(multiply);
        chains.iter_mut().take(WORK.choices).for_each(|chain| *chain = chain.min(addend));
        chains.iter_mut().for_each(multiply);
        chains.iter_mut().for_each(multiply);
        chains.iter_mut().for_each(multiply);
        chains.iter_mut().take(5).for_each(multiply);
        let add = |chain: &mut R| *chain = *chain + factor;
        chains.iter_mut().for_each(add);
        chains.iter_mut().take(5).for_each(add);
        sum(chains)
    }
}

/// One run of a kernel over its arrays, on each of some threads.
fn passes<'a, K: Kernel<1, 1> + 'a>(kernel: K, level: Level, threads: usize, counted: usize) -> Task<'a> {
    /// Runs that a thread does before it waits for the others.
    const RUNS: usize = 64;
    let input: Vec<f32> = (0..LENGTH).map(|i| 1.0 + i as f32 / LENGTH as f32).collect();
    let mut outputs = vec![vec![0.0f32; LENGTH]; threads];
    Task::new(threads * RUNS * LENGTH * counted, move || {
        let run = |output: &mut Vec<f32>| {
            for _ in 0..RUNS {
                // The lengths are equal.
                let _ = batch::map_at(level, black_box(&kernel), [&input], [&mut *output]);
            }
            black_box(output);
        };
        match outputs.as_mut_slice() {
            [output] => run(output),
            outputs => outputs.par_iter_mut().with_max_len(1).for_each(run),
        }
    })
}

impl Machine {
    pub(super) fn measure(quick: bool) -> Result<Self, Failure> {
        let threads = host::threads();
        let budget = Budget::new(quick);
        let chains = Chains::new();
        let counts: &[usize] = if threads > 1 { &[1, threads] } else { &[1] };
        let places: Vec<_> =
            counts.iter().flat_map(|threads| Level::available().map(|level| (level, *threads))).collect();
        let mut peaks = Vec::new();
        for (level, threads) in places {
            let mut tasks = [
                passes(MultiplyAdds(chains), level, threads, CHAINS * STEPS),
                // The sums at the start and at the end are operations too.
                passes(Operations(chains), level, threads, 2 * CHAINS * STEPS + 2 * CHAINS - 1),
                passes(Divides(chains), level, threads, CHAINS),
                passes(Roots(chains), level, threads, CHAINS),
                passes(Everything(chains), level, threads, 1),
            ];
            let rates: Vec<_> = clock::measure(&mut tasks, budget).iter().map(|times| 1e9 / times.least()).collect();
            let [multiply_adds, operations, divides, roots, work] = rates[..] else { continue };
            peaks.push(Peak { level, threads, multiply_adds, operations, divides, roots, work });
        }
        // Where the system does not tell, no processor in use has more than half of this.
        let cache = host::largest_cache().unwrap_or(64 << 20);
        let copy_bytes = if quick { 8 << 20 } else { (4 * cache).clamp(128 << 20, 1 << 30) };
        Ok(Machine {
            processor: host::processor(),
            threads,
            peaks,
            copy: copy(copy_bytes, budget, threads)?,
            copy_bytes,
            quick,
        })
    }

    /// The peak of a level on this many threads.
    pub(super) fn peak(&self, level: Level, threads: usize) -> Option<&Peak> {
        self.peaks.iter().find(|peak| (peak.level, peak.threads) == (level, threads))
    }

    pub(super) fn as_json(&self) -> Value {
        let peak = |peak: &Peak| {
            json!({
                "level": peak.level.name(), "threads": peak.threads,
                "multiply_adds_per_s": peak.multiply_adds, "operations_per_s": peak.operations,
                "divides_per_s": peak.divides, "roots_per_s": peak.roots, "metals_per_s": peak.work,
            })
        };
        let copy = |threads: usize, rate: f64| json!({"threads": threads, "bytes_per_s": rate});
        json!({
            "version": 1, "date": host::date(), "quick": self.quick,
            "processor": self.processor, "threads": self.threads,
            "peaks": self.peaks.iter().map(peak).collect::<Vec<_>>(),
            "copy": {
                "array_bytes": self.copy_bytes,
                "rates": [copy(1, self.copy[0]), copy(self.threads, self.copy[1])],
            },
        })
    }

    pub(super) fn print(&self, out: &mut impl Write) -> io::Result<()> {
        writeln!(out, "{}, {} threads; {}", self.processor, self.threads, host::date())?;
        writeln!(out, "10⁹ numbers a second     multiply-adds  operations     divides       roots      metals")?;
        for peak in &self.peaks {
            let threads = if peak.threads == 1 { "1 thread ".to_owned() } else { format!("{} threads", peak.threads) };
            let rates = [peak.multiply_adds, peak.operations, peak.divides, peak.roots, peak.work];
            let rates = rates.map(|rate| format!("{:12.2}", 1e-9 * rate)).concat();
            writeln!(out, "{:10} {threads:14}{rates}", peak.level.name())?;
        }
        let Work { products, sums, choices, divides, roots } = WORK;
        writeln!(
            out,
            "metals: {products} products, {sums} sums, {choices} choices, {divides} divides and {roots} roots, what the exact RGB \
             Torrance–Sparrow batch takes"
        )?;
        let [one, all] = self.copy.map(|rate| 1e-9 * rate);
        let (bytes, threads) = (self.copy_bytes >> 20, self.threads);
        writeln!(out, "copy of {bytes} MiB, read and written: {one:.1} GB/s on 1 thread, {all:.1} GB/s on {threads}")
    }
}

/// Bytes read and written in a second, by one thread and by all.
fn copy(bytes: usize, budget: Budget, threads: usize) -> Result<[f64; 2], Failure> {
    let count = bytes / size_of::<f32>();
    let array = |value: f32| -> Result<Vec<f32>, Failure> {
        let mut array = Vec::new();
        let refused = |error| format!("two arrays of {} MiB for the copy: {error}", bytes >> 20);
        array.try_reserve_exact(count).map_err(refused)?;
        array.resize(count, value);
        Ok(array)
    };
    let (from, mut to) = (array(1.0)?, array(0.0)?);
    let mut rates = [0.0; 2];
    for (rate, parts) in rates.iter_mut().zip([1, threads]) {
        let share = count.div_ceil(parts);
        let task = Task::new(2 * bytes, || {
            let part = |(to, from): (&mut [f32], &[f32])| to.copy_from_slice(black_box(from));
            if parts == 1 {
                part((&mut to, &from));
            } else {
                to.par_chunks_mut(share).zip(from.par_chunks(share)).for_each(part);
            }
            black_box(&to);
        });
        *rate = 1e9 / clock::measure(&mut [task], budget)[0].least();
    }
    Ok(rates)
}
