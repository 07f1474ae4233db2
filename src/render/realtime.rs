//! The documents' local model: no rays but the viewer's, one look-up of a blurred environment for each lobe.
//!
//! $$L = \sum_\text{lights} f(l, v)\cos\theta_l\,E_l + \sum_\text{lobes} w\,\bar L(r, \alpha)$$
//!
//! In plain text: the sum over lights of f·cos·E, and over the lobes that the material mirrors the environment with, of weight times the
//! pre-filtered radiance. Nothing casts shadows, nothing is occluded. Twin: `wgsl/realtime.wgsl`.
//!
//! Source: Elek 2010, §3, Algorithm 1; Mihaylov 2013, eq. 4.1–4.7.

use super::film::{Film, Tally};
use super::prefilter::Prefiltered;
use super::scene::Scene;
use super::shape::{Hit, Ray};
use super::{Number, Progress};
use rayon::prelude::*;

/// A point of the picture with what shading needs of it: what a fragment shader is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fragment<R> {
    /// The ray from the viewer.
    pub ray: Ray<R>,
    /// Where it met the shape, if it did.
    pub hit: Option<Hit<R>>,
}

/// The fragments of a pixel: `side`² points on a regular grid, row by row.
pub fn fragments<R: Number>(scene: &Scene, side: u32, pixel: u32) -> impl Iterator<Item = Fragment<R>> {
    let place = move |i: u32| R::from_f64((f64::from(i) + 0.5) / f64::from(side.max(1)));
    (0..side.max(1) * side.max(1)).map(move |i| {
        let ray = scene.camera.ray(pixel, [place(i % side.max(1)), place(i / side.max(1))]);
        Fragment { ray, hit: scene.shape.hit(&ray, R::from_f64(f64::from(f32::MAX))) }
    })
}

/// The radiance of a fragment.
pub fn shade<R: Number>(scene: &Scene, environment: &Prefiltered, fragment: &Fragment<R>) -> [R; 3] {
    let Some(hit) = &fragment.hit else {
        return if scene.backdrop { environment.look(fragment.ray.direction, R::ZERO) } else { [R::ZERO; 3] };
    };
    let point = scene.shape.point(hit, hit.distance, R::from_f64(scene.camera.spread()));
    let spot = scene.material.at(&point);
    let wo = hit.frame.to_local(-fragment.ray.direction);
    let mut sum = [R::ZERO; 3];
    for light in &scene.lights {
        let arriving = light.at(hit.position);
        let reflected = spot.reflected(hit.frame.to_local(arriving.towards), wo);
        for c in 0..3 {
            sum[c] = sum[c] + reflected[c] * arriving.irradiance[c];
        }
    }
    spot.mirrored(wo, &mut |mirror| {
        let alpha = if mirror.diffuse { R::ONE } else { mirror.alpha.min(R::from_f64(WIDEST)) };
        let seen = environment.look(hit.frame.to_world(mirror.direction), alpha);
        for c in 0..3 {
            sum[c] = sum[c] + mirror.weight[c] * seen[c];
        }
    });
    sum
}

/// The widest lobe that is told from the cosine.
pub const WIDEST: f64 = 0.999;

/// The picture, with `side`² points to a pixel, on the threads of the current pool.
pub fn render<R: Number>(scene: &Scene, side: u32, progress: &Progress<'_>) -> Film {
    scene.prepare(progress);
    let environment = Prefiltered::new(&scene.environment);
    let (width, height) = (scene.camera.width(), scene.camera.height());
    let done = core::sync::atomic::AtomicUsize::new(0);
    let rows: Vec<Vec<Tally>> = (0..height)
        .into_par_iter()
        .map(|row| {
            let pixel = |column: u32| {
                let mut tally = Tally::default();
                for fragment in fragments::<R>(scene, side, row * width + column) {
                    tally.add(shade(scene, &environment, &fragment).map(R::to_f64));
                }
                tally
            };
            let tallies = (0..width).map(pixel).collect();
            let rows = done.fetch_add(1, core::sync::atomic::Ordering::Relaxed) + 1;
            progress(rows as f64 / f64::from(height));
            tallies
        })
        .collect();
    let tallies: Vec<Tally> = rows.into_iter().flatten().collect();
    Film::new(width, height, &tallies)
}
