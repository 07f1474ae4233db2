//! `brdf parity`: the WGSL twins against the Rust functions.

use crate::failure::Failure;
use crate::output::Verdicts;
use brdf::gpu::{Gpu, adapters};
use brdf::parity::{Comparison, compare, twins};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use std::io::{self, Write};
use std::process::ExitCode;

/// What `brdf parity` is asked for.
#[derive(Args)]
pub(crate) struct Options {
    /// Only the adapters whose name or backend contains these words; see `brdf list`.
    #[arg(long)]
    adapter: Option<String>,
    /// Only the functions whose path contains this.
    #[arg(long)]
    function: Option<String>,
    /// Inputs per function.
    #[arg(long, default_value_t = 20_000, value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    samples: u32,
    /// Take the tolerance from the text of each function; that is what happens without it too.
    #[arg(long)]
    derived: bool,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// The comparisons of one adapter.
struct Run {
    adapter: String,
    comparisons: Vec<Comparison>,
}

pub(crate) fn run(options: &Options) -> Result<ExitCode, Failure> {
    // There is one way, so that the flag has nothing to choose.
    let Options { derived: _, .. } = options;
    let matches = |path: &str| options.function.as_deref().is_none_or(|wanted| path.contains(wanted));
    let twins: Vec<_> =
        twins().into_iter().filter(|twin| matches(&format!("{}::{}", twin.module, twin.function))).collect();
    if twins.is_empty() {
        let wanted = options.function.as_deref().unwrap_or_default();
        return Err(format!("--function {wanted}: no such function; `brdf parity` alone lists them all").into());
    }
    let gpus = open(options.adapter.as_deref())?;
    let progress = ProgressBar::new((gpus.len() * twins.len()) as u64);
    progress
        .set_style(ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}").unwrap_or(ProgressStyle::default_bar()));
    let mut runs = Vec::new();
    for gpu in gpus {
        let mut comparisons = Vec::new();
        for twin in &twins {
            progress.set_message(format!("{}::{} on {}", twin.module, twin.function, gpu.info()));
            comparisons.push(compare(&gpu, twin, options.samples as usize)?);
            progress.inc(1);
        }
        runs.push(Run { adapter: gpu.info().to_string(), comparisons });
    }
    progress.finish_and_clear();

    let mut out = Verdicts::new();
    if options.json {
        writeln!(out, "{:#}", Value::from_iter(runs.iter().map(run_json)))?;
    } else {
        for run in &runs {
            print(&mut out, run)?;
        }
    }
    let failed = runs.iter().flat_map(|run| &run.comparisons).any(|comparison| !comparison.agrees());
    Ok(ExitCode::from(u8::from(failed)))
}

/// The adapters to run on: those that match, else every usable one.
fn open(wanted: Option<&str>) -> Result<Vec<Gpu>, Failure> {
    let matching: Vec<_> = adapters()
        .into_iter()
        .filter(|info| info.unusable.is_none() && wanted.is_none_or(|wanted| info.matches(wanted)))
        .collect();
    if matching.is_empty() {
        // Says what was looked for, what there is, and how to get one.
        return Ok(vec![Gpu::open(wanted)?]);
    }
    matching.iter().map(|info| Ok(Gpu::open(Some(&info.to_string()))?)).collect()
}

fn run_json(run: &Run) -> Value {
    let rows = run.comparisons.iter().map(|row| {
        json!({
            "function": format!("{}::{}", row.module, row.function),
            "agrees": row.agrees(),
            "samples": row.samples,
            "max_ulp": row.max_ulp, "p999_ulp": row.p999_ulp,
            "max_relative": row.max_relative, "p999_relative": row.p999_relative,
            "share_of_allowed": row.share, "meaning_share": row.meaning, "misunderstood": row.misunderstood,
            "unbounded": row.unbounded, "outside": row.outside,
            "worst": row.worst.as_ref().map(|worst| json!({
                "inputs": worst.inputs.iter().map(|(name, value)| (name.clone(), Value::from(*value)))
                    .collect::<serde_json::Map<_, _>>(),
                "output": worst.output, "got": worst.got, "want": worst.want,
                "allowed": [worst.allowed.0, worst.allowed.1],
            })),
        })
    });
    json!({"adapter": run.adapter, "functions": rows.collect::<Vec<_>>()})
}

fn print(out: &mut impl Write, run: &Run) -> io::Result<()> {
    writeln!(out, "{}", run.adapter)?;
    writeln!(
        out,
        "{:8} {:37} {:>7} {:>9} {:>9} {:>9} {:>9} {:>6} {:>5} {:>6}",
        "", "function", "samples", "max ULP", "99.9 %", "max rel", "99.9 %", "used", "free", "in f64"
    )?;
    for row in &run.comparisons {
        writeln!(
            out,
            "{:8} {:37} {:>7} {:>9.3} {:>9.3} {:>9.2e} {:>9.2e} {:>5.0}% {:>5} {:>5.0}%",
            if row.agrees() { "AGREES" } else { "DIFFERS" },
            format!("{}::{}", row.module, row.function),
            row.samples,
            row.max_ulp,
            row.p999_ulp,
            row.max_relative,
            row.p999_relative,
            100.0 * row.share,
            row.unbounded,
            100.0 * row.meaning,
        )?;
        if row.misunderstood > 0 {
            writeln!(out, "{:8}   {} results differ in f64: the text means something else", "", row.misunderstood)?;
        }
        if let Some(worst) = &row.worst {
            let inputs: Vec<_> = worst.inputs.iter().map(|(name, value)| format!("{name}={value}")).collect();
            writeln!(out, "{:8}   worst: {} = {:e}, want {:e}", "", worst.output, worst.got, worst.want)?;
            writeln!(out, "{:8}     at {}", "", inputs.join(" "))?;
            if !row.agrees() {
                let (low, high) = worst.allowed;
                writeln!(out, "{:8}     WGSL allows [{low:e}, {high:e}]; {} results lie outside", "", row.outside)?;
            }
        }
    }
    writeln!(out)
}
