//! `brdf bench terms`: every variant of a term by what it costs and how far it is off.
//!
//! The CPU times are medians of passes that take turns, of evaluations over inputs in the cache: the scalar f32 function in
//! a loop, the batch at each level on one thread, and the batch at the best level on all threads, which streams. The GPU
//! times are of a loop inside the kernel; its own cost is part of them, and listed. Errors are of what each of them returns.

mod cpu;
mod family;
mod formula;
mod gpu;
pub(super) mod limit;

use super::clock::{self, Budget};
use super::{chart, host};
use crate::failure::Failure;
use brdf::batch::Level;
use brdf::gpu::{Gpu, Policy, adapters, policy};
use clap::Args;
use family::{Family, Measure};
use gpu::Clock;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

/// What `brdf bench terms` is asked for.
#[derive(Args)]
pub(crate) struct Options {
    /// fresnel, distribution, masking, diffuse or whole; without any, all of them.
    families: Vec<String>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Draw a chart of each family into this folder.
    #[arg(long, value_name = "DIR")]
    svg: Option<PathBuf>,
    /// Only the adapters whose name or backend contains these words; see `brdf list`.
    #[arg(long, conflicts_with = "cpu_only")]
    adapter: Option<String>,
    /// Leave the adapters out.
    #[arg(long)]
    cpu_only: bool,
    /// A short measurement, too short to quote.
    #[arg(long)]
    quick: bool,
}

pub(crate) fn run(options: &Options) -> Result<ExitCode, Failure> {
    let Options { families, json, svg, adapter, cpu_only, quick } = options;
    let measured = measure(families, &Adapters::named(adapter.as_deref(), *cpu_only), *quick)?;
    if let Some(folder) = svg {
        draw(&measured, folder)?;
    }
    let limit = limit::of(&measured, *quick)?;
    let mut out = io::stdout().lock();
    if *json {
        writeln!(out, "{:#}", as_json(&measured, limit.as_ref(), *quick))?;
        return Ok(ExitCode::SUCCESS);
    }
    writeln!(out, "{}, {} threads; {}", host::processor(), host::threads(), host::date())?;
    for family in &measured {
        writeln!(out)?;
        print(&mut out, family)?;
    }
    if let Some(limit) = limit {
        writeln!(out, "\n{limit}")?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The adapters that are asked for.
pub(super) enum Adapters {
    Off,
    /// Those that match, or any.
    Matching(Option<String>),
}

impl Adapters {
    pub(super) fn named(wanted: Option<&str>, cpu_only: bool) -> Self {
        if cpu_only || wanted.is_none() && policy() == Policy::Off {
            return Adapters::Off;
        }
        Adapters::Matching(wanted.map(str::to_owned))
    }

    fn open(&self) -> Result<Vec<Gpu>, Failure> {
        let Adapters::Matching(wanted) = self else { return Ok(Vec::new()) };
        let matches = |info: &brdf::gpu::AdapterInfo| wanted.as_deref().is_none_or(|wanted| info.matches(wanted));
        let found: Vec<_> = adapters().into_iter().filter(|info| info.unusable.is_none() && matches(info)).collect();
        if found.is_empty() && (wanted.is_some() || policy() == Policy::Require) {
            // Says what was looked for, what there is, and how to get one.
            return Ok(vec![Gpu::open(wanted.as_deref())?]);
        }
        if found.is_empty() {
            crate::output::complain(&"SKIPPED the GPU: no usable adapter; see `brdf list`");
        }
        found.iter().map(|info| Ok(Gpu::open(Some(&info.to_string()))?)).collect()
    }
}

/// How a variant was run.
#[derive(Clone, PartialEq)]
pub(super) enum Way {
    /// One call of the f32 function after the other.
    Scalar,
    /// A batch at a level on one thread.
    Batch(Level),
    /// A batch at the fastest level on this many threads.
    Threads(Level, usize),
    /// The twin on an adapter.
    Gpu(String, Clock),
}

impl Way {
    pub(super) fn label(&self) -> String {
        match self {
            Way::Scalar => "scalar".to_owned(),
            Way::Batch(level) => format!("batch, {}", level.name()),
            Way::Threads(level, threads) => format!("batch, {}, {threads} threads", level.name()),
            Way::Gpu(adapter, Clock::Timestamps) => adapter.clone(),
            Way::Gpu(adapter, Clock::Wall) => format!("{adapter}, wall time"),
        }
    }
}

/// How far results are off.
#[derive(Clone, Copy, Default)]
pub(super) struct Errors {
    pub(super) max: f64,
    pub(super) mean: f64,
    /// What 99.9 % stay under.
    pub(super) rare: f64,
}

impl Errors {
    fn of(have: &[f64], want: &[f64], error: impl Fn(f64, f64) -> f64) -> Self {
        let mut all: Vec<f64> = have.iter().zip(want).map(|(have, want)| error(*have, *want)).collect();
        all.sort_by(f64::total_cmp);
        let Some(max) = all.last().copied() else { return Errors::default() };
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        Errors { max, mean, rare: all[(all.len() - 1) * 999 / 1000] }
    }

    fn as_json(&self) -> Value {
        json!({"max": self.max, "mean": self.mean, "p999": self.rare})
    }
}

/// A variant run in one way.
pub(super) struct Point {
    pub(super) way: Way,
    pub(super) ns: f64,
    pub(super) error: Errors,
}

/// A variant with everything measured of it.
pub(super) struct Row {
    pub(super) name: &'static str,
    pub(super) points: Vec<Point>,
    /// As another variant's stand-in.
    stand_in: Option<Errors>,
}

/// A family with everything measured of it.
pub(super) struct Measured {
    pub(super) name: &'static str,
    pub(super) slug: &'static str,
    pub(super) title: &'static str,
    pub(super) measure: Measure,
    pub(super) truth: &'static str,
    domain: &'static str,
    stands_for: Option<&'static str>,
    pub(super) rows: Vec<Row>,
    /// The GPU's loop with nothing in it, for each adapter.
    empty: Vec<(String, f64)>,
}

impl Measured {
    /// What an error of this family is, for the axis and the table.
    pub(super) fn error_name(&self) -> String {
        format!("{} error against {}", self.measure.name(), self.truth)
    }

    /// The adapters that it was run on.
    pub(super) fn adapters(&self) -> impl Iterator<Item = &str> {
        self.empty.iter().map(|(adapter, _)| adapter.as_str())
    }
}

/// Measures families on the processor and on adapters.
pub(super) fn measure(wanted: &[String], adapters: &Adapters, quick: bool) -> Result<Vec<Measured>, Failure> {
    let families = family::families(wanted)?;
    let gpus = adapters.open()?;
    let progress = ProgressBar::new((families.len() * (1 + gpus.len())) as u64);
    progress
        .set_style(ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}").unwrap_or(ProgressStyle::default_bar()));
    let mut measured = Vec::new();
    for family in families {
        measured.push(measure_family(&family, &gpus, quick, &progress)?);
    }
    progress.finish_and_clear();
    Ok(measured)
}

fn measure_family(family: &Family, gpus: &[Gpu], quick: bool, progress: &ProgressBar) -> Result<Measured, Failure> {
    const COUNT: usize = 1 << 16;
    let columns = family.inputs.columns(COUNT, f64::from(family.constants.alpha));
    let threads = host::threads();
    let fastest = Level::detect();
    progress.set_message(format!("{} on the processor", family.title));

    let mut ways = vec![Way::Scalar];
    ways.extend(Level::available().map(Way::Batch));
    ways.push(Way::Threads(fastest, threads));
    let mut tasks = Vec::new();
    for variant in &family.variants {
        tasks.extend(ways.iter().map(|way| match way {
            Way::Batch(level) => variant.runner.batch(*level, &columns),
            Way::Threads(_, threads) => variant.runner.threads(*threads, &columns),
            _ => variant.runner.scalar(&columns),
        }));
    }
    let times = clock::measure(&mut tasks, Budget::new(quick));
    drop(tasks);
    progress.inc(1);

    let exact: Vec<Vec<f64>> = family.variants.iter().map(|variant| variant.runner.doubles(&columns)).collect();
    let truth = |variant: usize| exact[family.exact.unwrap_or(variant)].as_slice();
    let error = |have: f64, want: f64| match family.measure {
        Measure::Absolute => (have - want).abs(),
        Measure::Relative if have == want => 0.0,
        Measure::Relative => ((have - want) / want).abs(),
    };
    let stand_in = |variant: usize| {
        let (other, _) = family.stands_for?;
        let peak = exact[other].iter().copied().fold(0.0, f64::max);
        Some(Errors::of(&exact[variant], &exact[other], |have, want| (have - want).abs() / peak))
    };
    let mut rows: Vec<Row> = Vec::new();
    for ((index, variant), times) in family.variants.iter().enumerate().zip(times.chunks(ways.len())) {
        let points = ways.iter().zip(times).map(|(way, times)| {
            let have = match way {
                Way::Batch(level) | Way::Threads(level, _) => variant.runner.batched(*level, &columns),
                _ => variant.runner.singles(&columns),
            };
            Point { way: way.clone(), ns: times.median(), error: Errors::of(&have, truth(index), error) }
        });
        rows.push(Row { name: variant.name, points: points.collect(), stand_in: stand_in(index) });
    }
    let mut empty = Vec::new();
    for gpu in gpus {
        let adapter = gpu.info().to_string();
        progress.set_message(format!("{} on {adapter}", family.title));
        let runs = gpu::run(gpu, family, &columns, quick)?;
        empty.push((adapter.clone(), runs.empty_ns));
        for (index, (row, run)) in rows.iter_mut().zip(runs.variants).enumerate() {
            let way = Way::Gpu(adapter.clone(), runs.clock);
            row.points.push(Point { way, ns: run.ns, error: Errors::of(&run.results, truth(index), error) });
        }
        progress.inc(1);
    }
    Ok(Measured {
        name: family.name,
        slug: family.slug,
        title: family.title,
        measure: family.measure,
        truth: family.truth,
        domain: family.inputs.domain(),
        stands_for: family.stands_for.map(|(_, text)| text),
        rows,
        empty,
    })
}

/// Draws each family into a folder.
pub(super) fn draw(measured: &[Measured], folder: &std::path::Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    for family in measured {
        let picture = chart::terms(family).map_err(|error| format!("the picture could not be drawn: {error}"))?;
        let path = folder.join(picture_name(family));
        std::fs::write(&path, picture).map_err(|error| format!("{}: {error}", path.display()))?;
    }
    Ok(())
}

/// The file of a family's chart.
pub(super) fn picture_name(family: &Measured) -> String {
    format!("bench-{}.svg", family.slug)
}

/// A time in nanoseconds with three digits.
pub(super) fn nanoseconds(ns: f64) -> String {
    let digits = (2 - ns.max(1e-9).log10().floor() as i32).clamp(0, 6);
    format!("{ns:.*}", digits as usize)
}

fn print(out: &mut impl Write, family: &Measured) -> io::Result<()> {
    writeln!(out, "{} — {}; {}", family.title, family.error_name(), family.domain)?;
    writeln!(out, "  {:27} {:42} {:>9} {:>10} {:>10} {:>10}", "", "", "ns", "max", "mean", "p99.9")?;
    for row in &family.rows {
        for (index, point) in row.points.iter().enumerate() {
            let name = if index == 0 { row.name } else { "" };
            let Errors { max, mean, rare } = point.error;
            let (way, ns) = (point.way.label(), nanoseconds(point.ns));
            writeln!(out, "  {name:27} {way:42} {ns:>9} {max:>10.2e} {mean:>10.2e} {rare:>10.2e}")?;
        }
        if let (Some(Errors { max, mean, rare }), Some(text)) = (row.stand_in, family.stands_for) {
            writeln!(out, "  {:27} {text:42} {:>9} {max:>10.2e} {mean:>10.2e} {rare:>10.2e}", "", "")?;
        }
    }
    for (adapter, ns) in &family.empty {
        writeln!(out, "  {:27} {adapter:42} {:>9}", "the loop alone", nanoseconds(*ns))?;
    }
    Ok(())
}

/// A family as a table of Markdown: the time of each way, and the errors of batch.
pub(super) fn markdown(family: &Measured) -> String {
    let mut text = String::from("| |");
    let Some(first) = family.rows.first() else { return text };
    for point in &first.points {
        text += &format!(" {} |", point.way.label());
    }
    text += " max | mean | p99.9 |";
    if let Some(stands_for) = family.stands_for {
        text += &format!(" {stands_for}: max |");
    }
    text += "\n|---|";
    text += &"---:|".repeat(first.points.len() + 3 + usize::from(family.stands_for.is_some()));
    for row in &family.rows {
        text += &format!("\n| {} |", row.name);
        for point in &row.points {
            text += &format!(" {} |", nanoseconds(point.ns));
        }
        // The batch's at the fastest level: the scalar function's is no larger.
        let batch = row.points.iter().rfind(|point| matches!(point.way, Way::Batch(_)));
        let Errors { max, mean, rare } = batch.map_or(Errors::default(), |point| point.error);
        text += &format!(" {max:.1e} | {mean:.1e} | {rare:.1e} |");
        if let Some(stand_in) = row.stand_in {
            text += &format!(" {:.1e} |", stand_in.max);
        }
    }
    if !family.empty.is_empty() {
        text += "\n| *the loop alone* |";
        for point in &first.points {
            let empty =
                family.empty.iter().find(|(name, _)| matches!(&point.way, Way::Gpu(adapter, _) if adapter == name));
            text += &empty.map_or(" |".to_owned(), |(_, ns)| format!(" {} |", nanoseconds(*ns)));
        }
        text += &" |".repeat(3 + usize::from(family.stands_for.is_some()));
    }
    text += "\n";
    text
}

/// What [`markdown`] does not say by itself.
pub(super) fn caption(family: &Measured) -> String {
    format!("ns an evaluation; {}, of the batch at the fastest level. Inputs: {}.", family.error_name(), family.domain)
}

pub(super) fn as_json(measured: &[Measured], limit: Option<&limit::Limit>, quick: bool) -> Value {
    let point = |point: &Point| {
        let (kind, level, threads, adapter, clock) = match &point.way {
            Way::Scalar => ("scalar", None, 1, None, None),
            Way::Batch(level) => ("batch", Some(level.name()), 1, None, None),
            Way::Threads(level, threads) => ("batch", Some(level.name()), *threads, None, None),
            Way::Gpu(adapter, clock) => ("gpu", None, 0, Some(adapter), Some(clock.to_string())),
        };
        json!({
            "way": kind, "level": level, "threads": (threads > 0).then_some(threads), "adapter": adapter, "clock": clock,
            "ns": point.ns, "error": point.error.as_json(),
        })
    };
    let families = measured.iter().map(|family| {
        let rows = family.rows.iter().map(|row| {
            json!({
                "name": row.name,
                "points": row.points.iter().map(point).collect::<Vec<_>>(),
                "stand_in_error": row.stand_in.as_ref().map(Errors::as_json),
            })
        });
        let empty = family.empty.iter().map(|(adapter, ns)| json!({"adapter": adapter, "ns": ns}));
        json!({
            "family": family.name, "key": family.slug, "title": family.title,
            "error": family.measure.name(), "truth": family.truth, "inputs": family.domain,
            "stand_in": family.stands_for,
            "variants": rows.collect::<Vec<_>>(),
            "gpu_loop_alone": empty.collect::<Vec<_>>(),
        })
    });
    json!({
        "version": 1, "date": host::date(), "quick": quick,
        "processor": host::processor(), "threads": host::threads(),
        "families": families.collect::<Vec<_>>(),
        "limit": limit.map(limit::Limit::as_json),
    })
}
