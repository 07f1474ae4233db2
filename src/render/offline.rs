//! A path tracer: the same picture whatever the number of threads, and how sure each pixel is.
//!
//! From each point that a path meets, light is taken from every light of no extent, and from the environment in two ways, which the power heuristic
//! weighs against each other (Veach 1997, §9.2): by a direction drawn from the environment, and by the direction drawn from the
//! material, in which the path goes on. From the fourth point on a path goes on with the probability of its largest channel (Russian
//! roulette). Random numbers are a hash of the seed, the pixel, the sample and the dimension. Twin: `wgsl/offline.wgsl`.

use super::film::{Film, Tally};
use super::scene::Scene;
use super::shading::Shading;
use super::shape::Ray;
use super::{Number, Progress};
use crate::batch::Level;
use crate::real::Real;
use crate::walk::random::{random, random_words};
use convex::Convex;
use core::ops::Range;
use core::sync::atomic::{AtomicU32, Ordering};
use rayon::prelude::*;

mod convex;

/// How the environment's light is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Strategy {
    /// In both ways.
    #[default]
    Both,
    /// By directions drawn from the environment alone.
    Environment,
    /// By directions drawn from the material alone.
    Material,
}

/// How a picture is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Paths to a pixel, at least 1.
    pub samples: u32,
    /// Another picture of the same scene.
    pub seed: u32,
    /// The most points of a path, at least 1; light beyond is lost.
    pub depth: u32,
    /// How the environment's light is found.
    pub strategy: Strategy,
}

impl Default for Options {
    fn default() -> Self {
        Options { samples: 64, seed: 0, depth: 64, strategy: Strategy::Both }
    }
}

/// The point from which on paths may end by chance.
pub(crate) const ROULETTE_FROM: u32 = 3;

/// Groups of four random numbers for each point of a path: the material's, the environment's, the roulette's.
pub(crate) const GROUPS: u32 = 3;

/// Pixels of a tile: small enough to share the work evenly, large enough for the order to keep what is cached.
const TILE: u32 = 256;

/// A scene, prepared.
pub struct Tracer<'a> {
    scene: &'a Scene,
    shading: Shading<'a>,
    options: Options,
}

impl<'a> Tracer<'a> {
    /// Prepares a scene.
    pub fn new(scene: &'a Scene, options: Options) -> Self {
        scene.prepare(&|_| ());
        Tracer { scene, shading: Shading::new(&scene.material), options }
    }

    /// The seed of the numbers of a pixel.
    pub fn pixel_seed(&self, pixel: u32) -> u32 {
        pixel_seed(self.options.seed, pixel)
    }

    /// The radiance that one path finds for a pixel.
    pub fn sample<R: Number>(&self, pixel: u32, seed: u32, sample: u32) -> [R; 3] {
        let scene = self.scene;
        let numbers = |dimension: u32| random::<R>(seed, sample, dimension);
        let [x, y, ..] = numbers(0);
        let mut ray: Ray<R> = scene.camera.ray(pixel, [x, y]);
        let far = R::from_f64(f64::from(f32::MAX));
        let (spread, convex) = (R::from_f64(scene.camera.spread()), scene.shape.is_convex());
        let (mut sum, mut throughput) = ([R::ZERO; 3], [R::ONE; 3]);
        // The density of the direction that the path goes in; none from the viewer.
        let mut density: Option<R> = None;
        let mut travelled = R::ZERO;
        for depth in 0..=self.options.depth {
            let hit = if depth > 0 && convex { None } else { scene.shape.hit(&ray, far) };
            let Some(hit) = hit else {
                if depth == 0 && !scene.backdrop || !scene.environment.shines() {
                    return sum;
                }
                let (radiance, other) = scene.environment.look(ray.direction);
                let weight = match (density, self.options.strategy) {
                    (None, _) | (_, Strategy::Material) => R::ONE,
                    (_, Strategy::Environment) => R::ZERO,
                    (Some(own), Strategy::Both) => heuristic(own, other),
                };
                for c in 0..3 {
                    sum[c] = sum[c] + throughput[c] * radiance[c] * weight;
                }
                return sum;
            };
            if depth == self.options.depth {
                return sum;
            }
            travelled = travelled + hit.distance;
            let local = self.shading.at(|| scene.shape.point(&hit, travelled, spread));
            let facing = local.facing(hit.frame.to_local(-ray.direction));
            let leaves = |wi| R::ZERO.lt(hit.geometric.dot(wi));
            for light in &scene.lights {
                let arriving = light.at(hit.position);
                let wi = hit.frame.to_local(arriving.towards);
                let seen = R::ZERO.lt(wi.z) && leaves(arriving.towards);
                if seen && (convex || !scene.shape.blocks(&Ray::leaving(&hit, arriving.towards), arriving.distance)) {
                    let reflected = facing.reflected(wi);
                    for c in 0..3 {
                        sum[c] = sum[c] + throughput[c] * reflected[c] * arriving.irradiance[c];
                    }
                }
            }
            let group = 1 + GROUPS * depth;
            if self.options.strategy != Strategy::Material
                && let Some((towards, radiance, drawn)) = scene.environment.sample(numbers(group + 1))
            {
                let wi = hit.frame.to_local(towards);
                let seen = R::ZERO.lt(wi.z) && leaves(towards);
                if seen && (convex || !scene.shape.blocks(&Ray::leaving(&hit, towards), far)) {
                    let weight = match self.options.strategy {
                        Strategy::Both => heuristic(drawn, facing.pdf(wi)),
                        _ => R::ONE,
                    };
                    let reflected = facing.reflected(wi);
                    let scale = weight / drawn;
                    for c in 0..3 {
                        sum[c] = sum[c] + throughput[c] * reflected[c] * radiance[c] * scale;
                    }
                }
            }
            let Some(next) = facing.sample(numbers(group)) else { return sum };
            let towards = hit.frame.to_world(next.wi);
            if !leaves(towards) {
                return sum;
            }
            let (reflected, inverse) = (facing.reflected(next.wi), R::ONE / next.pdf);
            for c in 0..3 {
                throughput[c] = throughput[c] * (reflected[c] * inverse);
            }
            let largest = throughput[0].max(throughput[1]).max(throughput[2]);
            if !R::ZERO.lt(largest) {
                return sum;
            }
            if depth >= ROULETTE_FROM {
                let stays = largest.min(R::ONE);
                let [chance, ..] = numbers(group + 2);
                if stays.le(chance) {
                    return sum;
                }
                throughput = throughput.map(|x| x / stays);
            }
            density = Some(next.pdf);
            ray = Ray::leaving(&hit, towards);
        }
        sum
    }

    /// What the samples of a pixel from `first` on add up to.
    pub fn pixel<R: Number>(&self, pixel: u32, first: u32, count: u32) -> Tally {
        let seed = self.pixel_seed(pixel);
        let mut tally = Tally::default();
        for sample in first..first.saturating_add(count) {
            tally.add(self.sample::<R>(pixel, seed, sample).map(R::to_f64));
        }
        tally
    }
}

/// The seed of the numbers of a pixel in a picture.
pub(crate) fn pixel_seed(seed: u32, pixel: u32) -> u32 {
    random_words([pixel, seed, 0x5eed, 0])[0]
}

/// The power heuristic's weight of a direction drawn with the first density, that the second draws as well.
#[inline]
fn heuristic<R: Real>(own: R, other: R) -> R {
    // The ratio's square may overflow, which makes the weight 0: right.
    let ratio = other / own;
    R::ONE / (R::ONE + ratio * ratio)
}

/// The picture, on the threads of the current pool: in vector instructions where the scene lets them (one stack under a closed-form
/// model, on a convex shape), else path by path over f64.
///
/// Both take the same paths: their pictures differ by the rounding of f32, which is not the same for all sets of instructions.
pub fn render(scene: &Scene, options: Options, progress: &Progress<'_>) -> Film {
    match Convex::new(scene, options) {
        Some(convex) => tiled(scene, progress, |pixels| convex.tallies(Level::detect(), pixels)),
        None => render_by_path::<f64>(scene, options, progress),
    }
}

/// The picture path by path over any number type, on the threads of the current pool.
pub fn render_by_path<R: Number>(scene: &Scene, options: Options, progress: &Progress<'_>) -> Film {
    scene.prepare(progress);
    let tracer = Tracer::new(scene, options);
    tiled(scene, progress, |pixels| pixels.map(|pixel| tracer.pixel::<R>(pixel, 0, options.samples.max(1))).collect())
}

/// A picture of tiles, which are ranges of pixels.
fn tiled(scene: &Scene, progress: &Progress<'_>, tallies: impl Fn(Range<u32>) -> Vec<Tally> + Sync) -> Film {
    let count = scene.camera.pixels() as u32;
    let done = AtomicU32::new(0);
    let tiles: Vec<Vec<Tally>> = (0..count.div_ceil(TILE))
        .into_par_iter()
        .map(|tile| {
            let pixels = tile * TILE..count.min((tile + 1) * TILE);
            let length = pixels.end - pixels.start;
            let tallies = tallies(pixels);
            progress(f64::from(done.fetch_add(length, Ordering::Relaxed) + length) / f64::from(count));
            tallies
        })
        .collect();
    Film::new(scene.camera.width(), scene.camera.height(), &tiles.concat())
}
