//! `brdf bench layered`: every model of a stack against the walk, and what it costs.
//!
//! The truth is the walk over the layers as written. Albedos are compared at five angles; f over nineteen fixed pairs of
//! directions at, beside and away from the mirror direction. A time is the median over repeated runs of f32 evaluations on
//! one thread, all channels together, at low-discrepancy pairs; only ratios within one run mean something.

use super::chart;
use crate::failure::Failure;
use crate::material::{self, AnyStack, Change, Material};
use brdf::check::{self, Effort, Fixed, StackSubject};
use brdf::layered::{Coupled, Model, Stack, Widths};
use brdf::{Vector, walk};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use std::hint::black_box;
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// What `brdf bench layered` is asked for.
#[derive(Args)]
pub(crate) struct Options {
    /// Built-in stacks or stack files of two layers or more; without any, every such built-in stack.
    stacks: Vec<String>,
    /// Walks for each albedo and each pair of directions.
    #[arg(long, default_value_t = 1 << 16, value_parser = clap::value_parser!(u32).range(2..))]
    walks: u32,
    /// Seed of the walks.
    #[arg(long, default_value_t = 1)]
    seed: u32,
    /// Draw error against cost as SVG.
    #[arg(long)]
    svg: Option<PathBuf>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// The models that are compared, each with the rules of widths that change it.
pub(super) const VARIANTS: [(Model, Widths); 6] = [
    (Model::Elek, Widths::Own),
    (Model::WeidlichWilkie, Widths::Own),
    (Model::Conserving, Widths::Own),
    (Model::Conserving, Widths::Variance),
    (Model::Coupled, Widths::Variance),
    (Model::Coupled, Widths::Own),
];

/// Angles of the albedo in degrees.
const THETAS: [f64; 5] = [0.0, 30.0, 60.0, 80.0, 85.0];

/// An f below this, in sr⁻¹, is dark: relative errors say nothing there.
const DARK: f64 = 0.02;

/// The fixed pairs: angles of the light, the offset of the view from the mirror angle, and its azimuth, in degrees.
const LIGHTS: [f64; 4] = [0.0, 30.0, 60.0, 75.0];
const VIEWS: [(f64, f64); 5] = [(0.0, 180.0), (15.0, 180.0), (-20.0, 150.0), (10.0, 90.0), (0.0, 0.0)];

/// The walk's view of a stack.
struct Truth {
    /// At [`THETAS`], a mean and a standard error for each channel.
    albedos: Vec<Vec<(f64, f64)>>,
    /// The fixed pairs.
    pairs: Vec<Pair>,
    /// The time of one walk for f, on one thread.
    ns: f64,
}

/// A pair of directions, with f and its standard error for each channel.
struct Pair {
    wi: Vector<f64>,
    wo: Vector<f64>,
    f: Vec<(f64, f64)>,
}

/// What a model makes of a stack.
pub(super) struct Row {
    pub(super) model: Model,
    pub(super) widths: Widths,
    /// At [`THETAS`], for each channel.
    albedos: Vec<Vec<f64>>,
    /// The root mean square of f's relative error over the lit pairs; NaN where there is none.
    pub(super) rms: f64,
    /// The relative error of f furthest from 0 over the lit pairs.
    worst: Worst,
    /// The largest error of f over the dark pairs, in sr⁻¹.
    dark: f64,
    /// The time of an evaluation in f32.
    pub(super) ns: f64,
    table_bytes: usize,
    build_time: Duration,
}

#[derive(Clone, Copy, Default)]
struct Worst {
    error: f64,
    light: f64,
    view: f64,
    phi: f64,
    channel: usize,
}

/// A stack with all that was measured of it.
pub(super) struct Measured {
    pub(super) name: String,
    truth: Truth,
    pub(super) rows: Vec<Row>,
}

impl Measured {
    /// The walk as a line of cost and error: the relative standard error of f after one walk, over the lit pairs, and the
    /// time of one walk.
    pub(super) fn walk(&self) -> (f64, f64, f64) {
        let lit = self.truth.pairs.iter().flat_map(|pair| &pair.f).filter(|(f, _)| *f >= DARK);
        let (sum, count) = lit.fold((0.0, 0.0), |(sum, count), (f, error)| (sum + (error / f).powi(2), count + 1.0));
        (if count > 0.0 { f64::sqrt(sum / count) } else { 0.0 }, self.truth.ns, count)
    }
}

pub(crate) fn run(options: &Options) -> Result<ExitCode, Failure> {
    let materials: Vec<Material> = if options.stacks.is_empty() {
        material::stacks().into_iter().filter(|material| material.stack.layers() > 1).collect()
    } else {
        let load = |name: &String| material::load(name, Change::default());
        options.stacks.iter().map(load).collect::<Result<_, _>>()?
    };
    if let Some(bare) = materials.iter().find(|material| material.stack.layers() < 2) {
        return Err(format!("{}: a single layer is the same under every model; give a stack of two", bare.name).into());
    }
    let progress = ProgressBar::new((materials.len() * (VARIANTS.len() + 1)) as u64);
    let style = ProgressStyle::with_template("{bar:30} {percent}% {msg}").unwrap_or(ProgressStyle::default_bar());
    progress.set_style(style);
    let mut measured = Vec::new();
    for Material { name, stack } in &materials {
        progress.set_message(name.clone());
        measured.push(match stack {
            AnyStack::One(stack) => measure(name, stack, options, &progress),
            AnyStack::Three(stack) => measure(name, stack, options, &progress),
        });
    }
    progress.finish_and_clear();
    if let Some(path) = &options.svg {
        let picture = chart::layered(&measured, options.walks)
            .map_err(|error| format!("the picture could not be drawn: {error}"))?;
        std::fs::write(path, picture).map_err(|error| format!("{}: {error}", path.display()))?;
    }
    let mut out = io::stdout().lock();
    if options.json {
        writeln!(out, "{:#}", as_json(&measured, options))?;
    } else {
        for (index, stack) in measured.iter().enumerate() {
            if index > 0 {
                writeln!(out)?;
            }
            print(&mut out, stack)?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn direction(theta: f64, phi: f64) -> Vector<f64> {
    Vector::from_angles(theta.to_radians(), phi.to_radians())
}

/// The angles of the fixed pairs: those of the light and of the view, and the azimuth between them.
fn fixed_pairs() -> impl Iterator<Item = (f64, f64, f64)> {
    let pair = |light: f64| VIEWS.into_iter().map(move |(offset, phi)| (light, (light + offset).abs().min(80.0), phi));
    // At the normal the mirror direction is the light's own.
    LIGHTS.into_iter().flat_map(pair).filter(|pair| *pair != (0.0, 0.0, 0.0))
}

fn measure<const C: usize>(name: &str, stack: &Stack<f64, C>, options: &Options, progress: &ProgressBar) -> Measured {
    let truth = truth(stack, options);
    progress.inc(1);
    let rows = VARIANTS
        .into_iter()
        .map(|(model, widths)| {
            let row = row(&stack.clone().with_model(model).with_widths(widths), &truth);
            progress.inc(1);
            row
        })
        .collect();
    Measured { name: name.to_owned(), truth, rows }
}

fn truth<const C: usize>(stack: &Stack<f64, C>, options: &Options) -> Truth {
    let walks = walk::Options { samples: options.walks, seed: options.seed, ..walk::Options::default() };
    let channels = |estimate: walk::Estimate<C>| estimate.mean.into_iter().zip(estimate.standard_error).collect();
    let albedos = THETAS.map(|theta| channels(walk::albedo(stack, direction(theta, 0.0), &walks))).into();
    let pairs: Vec<_> = fixed_pairs()
        .map(|(light, view, phi)| {
            let (wi, wo) = (direction(light, 0.0), direction(view, phi));
            Pair { wi, wo, f: channels(walk::evaluate(stack, wi, wo, &walks)) }
        })
        .collect();
    let few = walk::Options { samples: 2048, threads: 1, ..walks };
    let start = Instant::now();
    for pair in &pairs {
        black_box(walk::evaluate(stack, pair.wi, pair.wo, &few));
    }
    let ns = start.elapsed().as_nanos() as f64 / (pairs.len() as f64 * f64::from(few.samples));
    Truth { albedos, pairs, ns }
}

fn row<const C: usize>(stack: &Stack<f64, C>, truth: &Truth) -> Row {
    let (mut table_bytes, mut build_time) = (0, Duration::ZERO);
    if stack.model() == Model::Coupled {
        let prepared = Coupled::new(stack);
        (table_bytes, build_time) = (prepared.bytes(), prepared.build_time());
    }
    let subject = StackSubject::new("", stack.clone());
    let albedo = |theta| check::albedo(&subject, theta, 0.0, Fixed::View, &Effort::default()).value;
    let albedos = THETAS.map(albedo).into();
    let (mut squares, mut lit, mut worst, mut dark) = (0.0, 0, Worst::default(), 0.0f64);
    for ((light, view, phi), pair) in fixed_pairs().zip(&truth.pairs) {
        let f = stack.evaluate(pair.wi, pair.wo);
        for (channel, (have, (want, _))) in f.into_iter().zip(&pair.f).enumerate() {
            if *want < DARK {
                dark = dark.max((have - want).abs());
                continue;
            }
            let error = have / want - 1.0;
            squares += error * error;
            lit += 1;
            if error.abs() > worst.error.abs() {
                worst = Worst { error, light, view, phi, channel };
            }
        }
    }
    let rms = (squares / f64::from(lit)).sqrt();
    Row {
        model: stack.model(),
        widths: stack.widths(),
        albedos,
        rms,
        worst,
        dark,
        ns: time(&stack.cast::<f32>()),
        table_bytes,
        build_time,
    }
}

/// The time of an evaluation in nanoseconds: the median of repeated runs over the same pairs of directions.
fn time<const C: usize>(stack: &Stack<f32, C>) -> f64 {
    const PAIRS: i32 = 1024;
    const RUNS: usize = 31;
    // Roberts 2018: the root of x⁵ = x + 1 gives the steps of a sequence in four dimensions.
    const G: f64 = 1.167_303_978_261_418_7;
    let coordinate = |i: i32, axis: i32| (0.5 + f64::from(i) * G.powi(-axis)).fract();
    let direction =
        |u: f64, v: f64| Vector::<f64>::from_angles((0.02 + 0.98 * u).acos(), std::f64::consts::TAU * v).cast();
    let pairs: Vec<(Vector<f32>, Vector<f32>)> = (0..PAIRS)
        .map(|i| (direction(coordinate(i, 1), coordinate(i, 2)), direction(coordinate(i, 3), coordinate(i, 4))))
        .collect();
    let mut runs = [0.0; RUNS].map(|_: f64| {
        let start = Instant::now();
        for (wi, wo) in black_box(&pairs) {
            black_box(stack.evaluate(*wi, *wo));
        }
        start.elapsed().as_nanos() as f64 / f64::from(PAIRS)
    });
    runs.sort_by(f64::total_cmp);
    runs[RUNS / 2]
}

/// The name of a model, and of its rule where that is not its own.
pub(super) fn label(model: Model, widths: Widths) -> String {
    let name = model.name();
    if widths == model.widths() { name.to_owned() } else { format!("{name}, {}", widths.name()) }
}

fn print(out: &mut impl Write, stack: &Measured) -> io::Result<()> {
    let Measured { name, truth, rows } = stack;
    let angles = THETAS.map(|theta| format!("{theta:>7}°")).concat();
    writeln!(out, "{name:27} albedo{angles}")?;
    write!(out, "  {:31}", "walk")?;
    for albedo in &truth.albedos {
        let mean = albedo.iter().map(|(mean, _)| mean).sum::<f64>() / albedo.len() as f64;
        write!(out, "{mean:8.4}")?;
    }
    let (error, ns, lit) = stack.walk();
    writeln!(out, "   f ± {:.2} % over {lit} lit values, {ns:.0} ns a walk", 100.0 * error)?;
    for row in rows {
        write!(out, "  {:31}", label(row.model, row.widths))?;
        for (have, want) in row.albedos.iter().zip(&truth.albedos) {
            let errors = have.iter().zip(want).map(|(have, (want, _))| have / want - 1.0);
            let worst = errors.fold(0.0, |a: f64, b: f64| if b.abs() > a.abs() { b } else { a });
            write!(out, "{:>+7.1}%", 100.0 * worst)?;
        }
        let Worst { error, light, view, phi, .. } = row.worst;
        write!(
            out,
            "   f: rms {:5.1} %, worst {:+6.1} % at {light}°/{view}° {phi}°, dark {:.4}; {:6.0} ns",
            100.0 * row.rms,
            100.0 * error,
            row.dark,
            row.ns
        )?;
        if row.table_bytes > 0 {
            write!(out, ", {} bytes in {:.2} s", row.table_bytes, row.build_time.as_secs_f64())?;
        }
        writeln!(out)?;
    }
    Ok(())
}

fn as_json(measured: &[Measured], options: &Options) -> Value {
    let split = |values: &[(f64, f64)]| {
        let (mean, error): (Vec<f64>, Vec<f64>) = values.iter().copied().unzip();
        json!({"mean": mean, "standard_error": error})
    };
    let stacks = measured.iter().map(|Measured { name, truth, rows }| {
        let pairs = fixed_pairs()
            .zip(&truth.pairs)
            .map(|((light, view, phi), pair)| json!({"light": light, "view": view, "phi": phi, "f": split(&pair.f)}));
        let models = rows.iter().map(|row| {
            json!({
                "model": row.model.name(), "widths": row.widths.name(),
                "albedo": row.albedos,
                "rms": row.rms,
                "worst": {
                    "error": row.worst.error, "light": row.worst.light, "view": row.worst.view,
                    "phi": row.worst.phi, "channel": row.worst.channel,
                },
                "dark": row.dark,
                "ns": row.ns, "table_bytes": row.table_bytes, "build_s": row.build_time.as_secs_f64(),
            })
        });
        json!({
            "stack": name,
            "walk": {
                "albedo": truth.albedos.iter().map(|albedo| split(albedo)).collect::<Vec<_>>(),
                "pairs": pairs.collect::<Vec<_>>(),
                "ns": truth.ns,
            },
            "models": models.collect::<Vec<_>>(),
        })
    });
    json!({
        "version": 1, "thetas": THETAS, "walks": options.walks, "seed": options.seed,
        "stacks": stacks.collect::<Vec<_>>(),
    })
}
