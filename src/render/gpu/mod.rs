//! Pictures by compute kernels: the same scene, the same texels and the same random numbers as on the CPU, in f32.
//!
//! A kernel is the WGSL of the material ([`wgsl::material`]) and that of `src/render/wgsl`, linked with the library. A picture is
//! dispatched in pieces of about [`DISPATCH`], so that a driver's watchdog leaves it alone and progress can be told.

mod words;

use super::Progress;
use super::film::{Film, Tally};
use super::offline::{self, Options};
use super::prefilter::Prefiltered;
use super::realtime::{self, Fragment};
use super::scene::Scene;
use super::shape::Shape;
use crate::gpu::{Gpu, GpuError, Kernel, texel_bytes};
use crate::wgsl::{self, LinkError, NoTwin};
use core::fmt;
use std::time::{Duration, Instant};

/// How long a dispatch is meant to take.
pub const DISPATCH: Duration = Duration::from_millis(300);

/// The paths of a row: few enough that their f32 sum rounds less than it varies, the same whatever the device's speed.
const PATHS: u32 = 4;

/// Fragments that are found before they are shaded: 23 MB.
const BAND: u32 = 1 << 18;

/// Rows of the first dispatch, whose time decides about the next.
const FIRST: usize = 1024;

const SCENE: &str = include_str!("../wgsl/scene.wgsl");
const SHAPE: &str = include_str!("../wgsl/shape.wgsl");
const OFFLINE: &str = include_str!("../wgsl/offline.wgsl");
const REALTIME: &str = include_str!("../wgsl/realtime.wgsl");

const SCENE_BINDINGS: &str = "\
@group(0) @binding(3) var<storage, read> scene_words: array<u32>;
fn scene_word(index: u32) -> u32 {
    return scene_words[index];
}
";

const TEXEL_BINDINGS: &str = "\
@group(0) @binding(4) var<storage, read> material_texels: array<vec4f>;
fn material_texel(index: u32) -> vec4f {
    return material_texels[index];
}
";

/// Why there is no picture.
#[derive(Clone, Debug, PartialEq)]
pub enum PictureError {
    /// The material has no twin.
    NoTwin(NoTwin),
    /// The material's WGSL does not link.
    Link(LinkError),
    /// The device refuses.
    Gpu(GpuError),
}

impl fmt::Display for PictureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PictureError::NoTwin(error) => write!(f, "{error}; render it without --gpu"),
            PictureError::Link(error) => error.fmt(f),
            PictureError::Gpu(error @ GpuError::TooLarge { .. }) => write!(f, "{error}, or render without --gpu"),
            PictureError::Gpu(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for PictureError {}

impl From<NoTwin> for PictureError {
    fn from(error: NoTwin) -> Self {
        PictureError::NoTwin(error)
    }
}

impl From<LinkError> for PictureError {
    fn from(error: LinkError) -> Self {
        PictureError::Link(error)
    }
}

impl From<GpuError> for PictureError {
    fn from(error: GpuError) -> Self {
        PictureError::Gpu(error)
    }
}

/// A kernel and the content of its buffers.
struct Program {
    kernel: Kernel,
    storage: Vec<Vec<u8>>,
    outputs: usize,
}

impl Program {
    fn new(gpu: &Gpu, scene: &Scene, parts: &[&str], function: &str, words: &[u32]) -> Result<Self, PictureError> {
        let material = wgsl::material(&scene.material)?;
        let source = wgsl::link(&format!("{material}\n{}", parts.join("\n")))?;
        let textured = source.contains("material_texel(");
        gpu.bindable(size_of_val(words) as u64, || large(scene))?;
        let texels = if textured { Some(texel_bytes(gpu, scene.material.images())?) } else { None };
        let bindings = format!("{SCENE_BINDINGS}{}", if textured { TEXEL_BINDINGS } else { "" });
        let kernel = Kernel::new(gpu, &source, function, Some(&bindings))?;
        let mut storage = vec![bytemuck::cast_slice(words).to_vec()];
        storage.extend(texels);
        let outputs = kernel.signature().output_words();
        Ok(Program { kernel, storage, outputs })
    }

    /// The results of all rows, in pieces that take about [`DISPATCH`].
    fn run(&self, rows: &[u32], words: usize, progress: &Progress<'_>) -> Result<Vec<f32>, PictureError> {
        let storage: Vec<&[u8]> = self.storage.iter().map(Vec::as_slice).collect();
        let mut results = Vec::with_capacity(rows.len() / words.max(1) * self.outputs);
        let (mut rest, mut size) = (rows, FIRST);
        while !rest.is_empty() {
            let (piece, after) = rest.split_at((size * words).min(rest.len()));
            let start = Instant::now();
            results.extend(self.kernel.run(piece, &storage)?.into_iter().map(f32::from_bits));
            let share = DISPATCH.as_secs_f64() / start.elapsed().as_secs_f64().max(1e-6);
            // At most four times as many at once: the first pixels may have been empty.
            size = ((size as f64 * share.clamp(0.25, 4.0)) as usize).clamp(64, 1 << 20);
            rest = after;
            progress(1.0 - rest.len() as f64 / rows.len() as f64);
        }
        Ok(results)
    }
}

/// What of a scene can be large.
fn large(scene: &Scene) -> String {
    let side = scene.environment.map().side();
    let mesh = match &scene.shape {
        Shape::Mesh(mesh) => format!("the mesh (of {} triangles)", mesh.triangles().len()),
        _ => "the shape".to_owned(),
    };
    format!("{mesh} and the environment (kept as {side}×{side} texels)")
}

/// The picture of [`offline::render`], but for rounding.
///
/// # Errors
/// Where the material has no twin, and what the device refuses.
pub fn offline(gpu: &Gpu, scene: &Scene, options: Options, progress: &Progress<'_>) -> Result<Film, PictureError> {
    scene.prepare(progress);
    let words = words::words(scene, &options, None);
    let program = Program::new(gpu, scene, &[SCENE, SHAPE, OFFLINE], "trace_pixel", &words)?;
    let pixels = scene.camera.pixels() as u32;
    let mut tallies = vec![Tally::default(); pixels as usize];
    let passes = options.samples.max(1).div_ceil(PATHS);
    for pass in 0..passes {
        let first = pass * PATHS;
        let count = PATHS.min(options.samples.max(1) - first);
        let rows: Vec<u32> =
            (0..pixels).flat_map(|pixel| [pixel, offline::pixel_seed(options.seed, pixel), first, count]).collect();
        let part = |done: f64| progress((f64::from(pass) + done) / f64::from(passes));
        let results = program.run(&rows, 4, &part)?;
        for (tally, sums) in tallies.iter_mut().zip(results.chunks_exact(6)) {
            tally.count += count;
            for c in 0..3 {
                tally.sum[c] += f64::from(sums[c]);
                tally.squares[c] += f64::from(sums[c + 3]);
            }
        }
    }
    Ok(Film::new(scene.camera.width(), scene.camera.height(), &tallies))
}

/// The picture of [`realtime::render`] over f32, but for rounding: the CPU finds the fragments, the device shades them.
///
/// # Errors
/// As [`offline()`].
pub fn realtime(gpu: &Gpu, scene: &Scene, side: u32, progress: &Progress<'_>) -> Result<Film, PictureError> {
    scene.prepare(progress);
    let environment = Prefiltered::new(&scene.environment);
    let words = words::words(scene, &Options::default(), Some(&environment));
    let program = Program::new(gpu, scene, &[SCENE, REALTIME], "shade_fragment", &words)?;
    let pixels = scene.camera.pixels() as u32;
    let mut tallies = vec![Tally::default(); pixels as usize];
    let band = (BAND / side.max(1).saturating_mul(side.max(1))).max(1);
    for first in (0..pixels).step_by(band as usize) {
        let (mut rows, mut owners) = (Vec::new(), Vec::new());
        for pixel in first..first.saturating_add(band).min(pixels) {
            for fragment in realtime::fragments::<f32>(scene, side, pixel) {
                match row(scene, &fragment) {
                    Some(row) => {
                        rows.extend(row);
                        owners.push(pixel);
                    }
                    None => {
                        if let Some(tally) = tallies.get_mut(pixel as usize) {
                            tally.add(realtime::shade(scene, &environment, &fragment).map(f64::from));
                        }
                    }
                }
            }
        }
        let share = f64::from(band.min(pixels - first)) / f64::from(pixels);
        let part = |done: f64| progress(f64::from(first) / f64::from(pixels) + done * share);
        let results = program.run(&rows, ROW, &part)?;
        for (pixel, radiance) in owners.into_iter().zip(results.chunks_exact(3)) {
            if let (Some(tally), [r, g, b]) = (tallies.get_mut(pixel as usize), radiance) {
                tally.add([*r, *g, *b].map(f64::from));
            }
        }
    }
    Ok(Film::new(scene.camera.width(), scene.camera.height(), &tallies))
}

/// The words of a fragment that met the shape.
const ROW: usize = 22;

fn row(scene: &Scene, fragment: &Fragment<f32>) -> Option<[u32; ROW]> {
    let hit = fragment.hit.as_ref()?;
    let point = scene.shape.point(hit, hit.distance, scene.camera.spread() as f32);
    let mut row = [0u32; ROW];
    let vectors = [fragment.ray.direction, point.position, point.tangent, point.bitangent, hit.frame.normal];
    let vectors = vectors.map(|v| [v.x, v.y, v.z]);
    let rest =
        point.uv.into_iter().chain(point.uv_per_length).chain([point.occlusion, point.distance, point.footprint]);
    for (word, x) in row.iter_mut().zip(vectors.as_flattened().iter().copied().chain(rest)) {
        *word = x.to_bits();
    }
    Some(row)
}
