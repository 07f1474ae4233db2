//! `brdf render`: a picture of a material.

use crate::failure::Failure;
use crate::gallery;
use crate::material::{Change, Varying, load, model, varying, walking_part};
use brdf::gpu::Gpu;
use brdf::layered::Model;
use brdf::material::{Material, built_in};
use brdf::render::camera::{Camera, Orbit};
use brdf::render::environment::Environment;
use brdf::render::light::Light;
use brdf::render::mesh::Mesh;
use brdf::render::shape::Shape;
use brdf::render::torus::Torus;
use brdf::render::{Film, Scene, film, gpu, offline, realtime, sources};
use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::json;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// What `brdf render` is asked for.
#[derive(Args)]
pub(crate) struct Options {
    /// A built-in material, a material file or a stack file. Images of a material stand upright where v rises; green of a normal map is +Y up.
    #[arg(required_unless_present = "gallery", default_value = "", hide_default_value = true)]
    material: String,
    /// Write the documents' figures into this folder instead.
    #[arg(long, value_name = "DIR", conflicts_with_all = OF_A_PICTURE)]
    gallery: Option<PathBuf>,
    /// Of the gallery only figures whose name contains this.
    #[arg(long, requires = "gallery", conflicts_with = "material")]
    only: Option<String>,
    /// sphere, torus, torus:MINOR (the radius of the tube, 0.4 by default), plane, or an OBJ file.
    #[arg(long, default_value = "sphere")]
    shape: String,
    /// The documents' local model, or a path tracer.
    #[arg(long, value_enum, default_value = "realtime")]
    mode: Mode,
    /// Render on a GPU.
    #[arg(long)]
    gpu: bool,
    /// The adapter whose name or backend contains these words; see `brdf list`.
    #[arg(long, requires = "gpu")]
    adapter: Option<String>,
    /// Pixels to a row, and rows.
    #[arg(long, default_value = "512x512", value_parser = size)]
    size: (u32, u32),
    /// Paths to a pixel offline (64 by default); rounded up to a square of points in realtime (4 by default).
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1 << 20))]
    samples: Option<u32>,
    /// Another seed, another noise.
    #[arg(long, default_value_t = 0)]
    seed: u32,
    /// sky, studio, furnace, none, or a .hdr or .exr file.
    #[arg(long, default_value = "studio")]
    environment: String,
    /// directional:X,Y,Z[,E] (towards the light; irradiance E, or R,G,B), point:X,Y,Z[,I], point/d:… (thins out as 1/d). +z is up.
    #[arg(long)]
    light: Vec<Light>,
    /// The model of a stack, but for `walk`; its own by default.
    #[arg(long, value_parser = model)]
    model: Option<Model>,
    /// A number of a built-in material.
    #[arg(long, value_parser = assignment, value_name = "KEY=VALUE")]
    set: Vec<(String, f64)>,
    /// The camera's azimuth in degrees; 0 looks along +y.
    #[arg(long, default_value_t = Orbit::default().azimuth, allow_negative_numbers = true)]
    azimuth: f64,
    /// The camera's elevation in degrees.
    #[arg(long, default_value_t = Orbit::default().elevation, allow_negative_numbers = true)]
    elevation: f64,
    /// The camera's distance from the origin; five times the shape's radius by default, which fills nine tenths of the height.
    #[arg(long)]
    distance: Option<f64>,
    /// The vertical field of view in degrees.
    #[arg(long, default_value_t = Orbit::default().field)]
    field: f64,
    /// Stops by which a PNG is exposed.
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true, value_parser = exposure)]
    exposure: f64,
    /// Black behind the shape instead of the environment.
    #[arg(long)]
    no_backdrop: bool,
    /// The picture: a .png (sRGB, clipped) or .exr (linear) file.
    #[arg(long, short, default_value = "render.png")]
    out: PathBuf,
    /// Print what was done as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Mode {
    /// Lights and pre-filtered environment, without shadows, at four points of each pixel (Elek 2010, Algorithm 1).
    Realtime,
    /// A path tracer.
    Offline,
}

/// What a gallery, whose figures say themselves how they are taken, has no use for.
const OF_A_PICTURE: [&str; 19] = [
    "material",
    "shape",
    "mode",
    "gpu",
    "adapter",
    "size",
    "samples",
    "seed",
    "environment",
    "light",
    "model",
    "set",
    "azimuth",
    "elevation",
    "distance",
    "field",
    "exposure",
    "no_backdrop",
    "out",
];

fn size(text: &str) -> Result<(u32, u32), String> {
    text.split_once(['x', '×'])
        .and_then(|(width, height)| Some((width.parse().ok()?, height.parse().ok()?)))
        .filter(|(width, height)| *width > 0 && *height > 0)
        .ok_or_else(|| "a size is WIDTHxHEIGHT, two whole numbers of at least 1".to_owned())
}

fn assignment(text: &str) -> Result<(String, f64), String> {
    text.split_once('=')
        .and_then(|(key, value)| Some((key.trim().to_owned(), value.trim().parse::<f64>().ok()?)))
        .filter(|(key, value)| !key.is_empty() && value.is_finite())
        .ok_or_else(|| "it is KEY=VALUE, the value a finite number".to_owned())
}

fn exposure(text: &str) -> Result<f64, String> {
    text.parse::<f64>()
        .ok()
        .filter(|stops| stops.abs() <= 64.0)
        .ok_or_else(|| "an exposure is a number of stops in [-64, 64]".to_owned())
}

pub(crate) fn run(options: &Options) -> Result<ExitCode, Failure> {
    if let Some(folder) = &options.gallery {
        return gallery::run(folder, options.only.as_deref(), options.json);
    }
    // What cannot be written is refused before anything is computed.
    film::writable(&options.out).map_err(|error| format!("--out {error}"))?;
    let scene = scene(options)?;
    let device = if options.gpu { Some(Gpu::open(options.adapter.as_deref())?) } else { None };
    let bar = ProgressBar::new(1000);
    let style = ProgressStyle::with_template("{msg}{bar:30} {percent:>3} %, {eta} left");
    bar.set_style(style.unwrap_or(ProgressStyle::default_bar()));
    let progress = |done: f64| bar.set_position((1000.0 * done) as u64);
    let start = Instant::now();
    bar.set_message("occlusion ");
    scene.prepare(&progress);
    bar.set_message("");
    bar.reset();
    let (film, samples) = picture(options, &scene, device.as_ref(), &progress)?;
    let seconds = start.elapsed().as_secs_f64();
    bar.finish_and_clear();
    let clipped = film.write(&options.out, options.exposure)?;
    let not_finite = film.not_finite();
    let paths = f64::from(samples) * scene.camera.pixels() as f64;
    let device = device.map_or("cpu".to_owned(), |gpu| gpu.info().to_string());
    let mut out = io::stdout().lock();
    if options.json {
        let [mean, largest] = summary(&film);
        let report = json!({
            "file": options.out.display().to_string(), "width": film.width(), "height": film.height(),
            "samples": samples, "seed": options.seed, "device": device, "seconds": seconds,
            "samples_per_second": paths / seconds, "clipped": clipped, "not_finite": not_finite,
            "mean": mean, "largest": largest,
        });
        writeln!(out, "{report:#}")?;
    } else {
        let (width, height, rate) = (film.width(), film.height(), 1e-6 * paths / seconds);
        write!(out, "{}: {width}×{height}, {samples} samples a pixel on {device}, ", options.out.display())?;
        write!(out, "{seconds:.1} s ({rate:.2} Msamples/s)")?;
        if clipped > 0 {
            write!(out, "; {clipped} pixels are brighter than 1 and clipped: --exposure lowers them")?;
        }
        if not_finite > 0 {
            write!(
                out,
                "; {not_finite} pixels are infinite or not a number: a light or the environment is too bright, or a light too near"
            )?;
        }
        writeln!(out)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The mean and the largest value of each channel.
fn summary(film: &Film) -> [[f64; 3]; 2] {
    let count = film.mean().len().max(1) as f64;
    let channel = |c: usize| film.mean().iter().map(move |pixel| f64::from(pixel[c]));
    [std::array::from_fn(|c| channel(c).sum::<f64>() / count), std::array::from_fn(|c| channel(c).fold(0.0, f64::max))]
}

fn picture(
    options: &Options,
    scene: &Scene,
    device: Option<&Gpu>,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<(Film, u32), Failure> {
    let refused = |error: gpu::PictureError| format!("{}: {error}", options.material);
    match options.mode {
        Mode::Realtime => {
            let side = f64::from(options.samples.unwrap_or(4)).sqrt().ceil() as u32;
            let film = match device {
                Some(device) => gpu::realtime(device, scene, side, progress).map_err(refused)?,
                None => realtime::render::<f64>(scene, side, progress),
            };
            Ok((film, side * side))
        }
        Mode::Offline => {
            let samples = options.samples.unwrap_or(64);
            let how = offline::Options { samples, seed: options.seed, ..offline::Options::default() };
            let film = match device {
                Some(device) => gpu::offline(device, scene, how, progress).map_err(refused)?,
                None => offline::render(scene, how, progress),
            };
            Ok((film, samples))
        }
    }
}

fn scene(options: &Options) -> Result<Scene, Failure> {
    let (width, height) = options.size;
    let Options { azimuth, elevation, field, .. } = *options;
    let shape = shape(&options.shape)?;
    let distance = options.distance.unwrap_or(Orbit::default().distance * shape.radius());
    let camera = Camera::new(&Orbit { azimuth, elevation, distance, field }, width, height)?;
    let [eye, ..] = camera.vectors();
    if shape.encloses(eye) {
        return Err(format!("--distance {distance}: the camera is inside the {}; step back", options.shape).into());
    }
    Ok(Scene {
        shape,
        material: material(options)?,
        camera,
        lights: options.light.clone(),
        environment: environment(&options.environment)?,
        backdrop: !options.no_backdrop,
    })
}

fn shape(name: &str) -> Result<Shape, String> {
    match name {
        "sphere" => Ok(Shape::Sphere),
        "plane" => Ok(Shape::Plane),
        "torus" => Ok(Shape::Torus(Torus::new(0.4)?)),
        _ => match name.strip_prefix("torus:") {
            Some(minor) => {
                let radius = minor.parse().map_err(|_| format!("--shape {name}: `{minor}` is no number"))?;
                Torus::new(radius).map(Shape::Torus).map_err(|error| format!("--shape {name}: {error}"))
            }
            None if Path::new(name).extension().is_some() => Mesh::read(Path::new(name)).map(Shape::Mesh),
            None => Err(format!("--shape {name}: a shape is sphere, torus, torus:MINOR, plane or an .obj file")),
        },
    }
}

fn environment(name: &str) -> Result<Environment, String> {
    if name == "none" {
        return Ok(Environment::dark());
    }
    match sources::by_name(name) {
        Some(found) => Ok(found),
        None if Path::new(name).extension().is_some() => Environment::read(Path::new(name)),
        None => {
            let names = sources::NAMES.join(", ");
            Err(format!("--environment {name}: an environment is {names}, none, or a .hdr or .exr file"))
        }
    }
}

/// Refuses what takes a random walk for every value: minutes for a picture of 16×16.
fn without_walk(name: &str, material: Material) -> Result<Material, Failure> {
    match walking_part(&material) {
        Some(part) => Err(format!(
            "{name}: part[{part}] is under the model `walk`, a random walk for every value, which takes a picture hours: \
             choose `coupled`, and compare single values by `brdf eval`"
        )
        .into()),
        None => Ok(material),
    }
}

fn material(options: &Options) -> Result<Material, Failure> {
    let name = options.material.as_str();
    if options.model == Some(Model::Walk) {
        return Err("--model walk: a random walk for every value takes a picture hours: choose `coupled`, and compare single values by \
                    `brdf eval`"
            .to_owned()
            .into());
    }
    let varying = varying(name)?;
    if let (Some((key, _)), None | Some(Varying::File(_))) = (options.set.first(), &varying) {
        return Err(format!("--set {key}: only the built-in materials of `brdf list` have numbers to set").into());
    }
    if let (Some(model), Some(_)) = (options.model, &varying) {
        return Err(format!("--model {}: {name} is no stack, and has the models that it says", model.name()).into());
    }
    match varying {
        Some(Varying::BuiltIn) => Ok(built_in::with(name, &options.set).map_err(|error| error.to_string())?),
        Some(Varying::File(file)) => without_walk(name, file.material),
        None => {
            let change = Change { model: options.model, ..Change::default() };
            without_walk(name, load(name, change)?.stack.three().into())
        }
    }
}
