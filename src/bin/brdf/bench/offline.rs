//! `brdf bench offline`: how many paths a second the offline mode takes on this machine's threads, for a sphere of each stack and material.
//!
//! As it renders, and path by path over f64. The sphere's outline fills 64 % of the picture; paths that miss it count.

use super::clock::{Budget, Task, measure};
use crate::failure::Failure;
use brdf::material::{Material, built_in, stack};
use brdf::render::camera::{Camera, Orbit};
use brdf::render::environment::Environment;
use brdf::render::shape::Shape;
use brdf::render::{Scene, offline, sources};
use clap::Args;
use serde_json::{Value, json};
use std::hint::black_box;
use std::io::{self, Write};
use std::process::ExitCode;

/// What `brdf bench offline` is asked for.
#[derive(Args)]
pub(crate) struct Options {
    /// Built-in stacks and materials; without any, every one.
    names: Vec<String>,
    /// sky, studio or furnace.
    #[arg(long, default_value = "studio")]
    environment: String,
    /// A short measurement, too short to quote.
    #[arg(long)]
    quick: bool,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Pixels along each side, and paths to a pixel.
const SIDE: u32 = 96;
const SAMPLES: u32 = 16;

/// Millions of paths a second.
struct Rates {
    name: String,
    rendered: f64,
    by_path: f64,
}

pub(crate) fn run(options: &Options) -> Result<ExitCode, Failure> {
    let environment = sources::by_name(&options.environment).ok_or_else(|| {
        format!("--environment {}: a built-in environment is one of {}", options.environment, sources::NAMES.join(", "))
    })?;
    let mut all: Vec<(String, Material)> =
        stack::built_in().into_iter().map(|found| (found.name.to_owned(), found.stack.into())).collect();
    for named in built_in::all() {
        let material = named.material().map_err(|error| format!("{}: {error}", named.name))?;
        all.push((named.name.to_owned(), material));
    }
    if let Some(unknown) = options.names.iter().find(|name| !all.iter().any(|(known, _)| known == *name)) {
        return Err(format!("{unknown} is no built-in stack or material; see `brdf list`").into());
    }
    all.retain(|(name, _)| options.names.is_empty() || options.names.contains(name));
    let rates = all
        .into_iter()
        .map(|(name, material)| timed(name, material, &environment, options.quick))
        .collect::<Result<Vec<_>, _>>()?;
    let mut out = io::stdout().lock();
    if options.json {
        let row = |Rates { name, rendered, by_path }: &Rates| {
            json!({
                "name": name, "samples_per_second": 1e6 * rendered, "path_by_path_samples_per_second": 1e6 * by_path,
            })
        };
        writeln!(out, "{:#}", Value::from_iter(rates.iter().map(row)))?;
        return Ok(ExitCode::SUCCESS);
    }
    let threads = rayon::current_num_threads();
    writeln!(out, "a sphere in the {} on {threads} threads, 10⁶ paths a second", options.environment)?;
    writeln!(out, "{:32} {:>12} {:>18} {:>7}", "", "as rendered", "path by path, f64", "times")?;
    for Rates { name, rendered, by_path } in &rates {
        writeln!(out, "{name:32} {rendered:>12.2} {by_path:>18.2} {:>7.2}", rendered / by_path)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn timed(name: String, material: Material, environment: &Environment, quick: bool) -> Result<Rates, Failure> {
    let scene = Scene {
        shape: Shape::Sphere,
        material,
        camera: Camera::new(&Orbit::default(), SIDE, SIDE)?,
        lights: Vec::new(),
        environment: environment.clone(),
        backdrop: true,
    };
    let how = offline::Options { samples: SAMPLES, ..offline::Options::default() };
    let silent = |_: f64| ();
    let samples = scene.camera.pixels() * SAMPLES as usize;
    let mut tasks = [
        Task::new(samples, || _ = black_box(offline::render(&scene, how, &silent))),
        Task::new(samples, || _ = black_box(offline::render_by_path::<f64>(&scene, how, &silent))),
    ];
    let rates: Vec<f64> = measure(&mut tasks, Budget::new(quick)).iter().map(|times| 1e3 / times.median()).collect();
    match rates[..] {
        [rendered, by_path] => Ok(Rates { name, rendered, by_path }),
        _ => Err(format!("{name}: no time was taken").into()),
    }
}
