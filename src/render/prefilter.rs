//! Environments blurred beforehand, for shading without rays: what a lobe of width α sees around each direction.
//!
//! The documents' local model looks the environment up once for each lobe ("an adequately blurred environment map", Elek 2010, §3). A level
//! holds, for each direction r, the mean of the radiance over the light that Beckmann's facets of one α reflect to V = N = r:
//! ∫ L(l)·D(h)·cosθ_h dω_h, l being V mirrored at h, of what stays above the horizon, over the same of 1. So a constant environment stays constant.
//! The first level is the environment itself, the last the mean under the cosine: the irradiance over π of a diffuse base, which α = 1 means.
//! Between levels lookups are linear in α, within them bilinear. Twin: `wgsl/environment.wgsl`; the same texels.

use super::environment::Environment;
use super::octahedral::Map;
use crate::frame::{Frame, Vector};
use crate::real::Real;
use rayon::prelude::*;

/// The widths of the levels: of the environment itself, of Beckmann's lobes, and 1 for the cosine.
pub const ALPHAS: [f64; 10] = [0.0, 0.02, 0.05, 0.1, 0.18, 0.3, 0.45, 0.65, 0.85, 1.0];

/// Texels to a side: about three to the width of a lobe.
const SIDES: [usize; 10] = [0, 256, 128, 128, 64, 64, 32, 32, 32, 32];

/// Directions of a lobe. They stand for its equal parts, so that each needs no weight.
const RAYS: usize = 320;

/// An environment at every width.
#[derive(Clone, Debug, PartialEq)]
pub struct Prefiltered {
    levels: Vec<Map>,
}

impl Prefiltered {
    /// All levels of an environment, on the threads of the current pool: half a second.
    pub fn new(environment: &Environment) -> Self {
        let pyramid = pyramid(environment.map());
        let level = |(alpha, side): (&f64, &usize)| {
            if *side == 0 { environment.map().clone() } else { blurred(&pyramid, *alpha, *side) }
        };
        Prefiltered { levels: ALPHAS.iter().zip(&SIDES).map(level).collect() }
    }

    /// The levels, in the order of [`ALPHAS`].
    pub fn levels(&self) -> &[Map] {
        &self.levels
    }

    /// The mean radiance that a lobe of width `alpha` around a direction sees.
    #[inline]
    pub fn look<R: Real>(&self, w: Vector<R>, alpha: R) -> [R; 3] {
        let alpha = alpha.saturate();
        let width = alpha.to_f64();
        let above = ALPHAS.iter().position(|level| width <= *level).unwrap_or(ALPHAS.len() - 1).max(1);
        let at = |level: usize| self.levels.get(level).map_or([R::ZERO; 3], |map| map.look(w).0);
        let (low, high) = (ALPHAS[above - 1], ALPHAS[above]);
        let share = (alpha - R::from_f64(low)) / R::from_f64(high - low);
        let (a, b) = (at(above - 1), at(above));
        core::array::from_fn(|c| a[c] + (b[c] - a[c]) * share)
    }
}

/// The map, and ever coarser ones: each texel the mean of four, weighted by their solid angles.
fn pyramid(map: &Map) -> Vec<Map> {
    let mut all = vec![map.clone()];
    while let Some(fine) = all.last().filter(|map| map.side() > 8) {
        let side = fine.side() / 2;
        let coarse = Map::new(side, |column, row| {
            let (mut sum, mut total) = ([0.0; 3], 0.0);
            for (x, y) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                let (x, y) = (2 * column + x, 2 * row + y);
                let (_, solid) = Map::centre(fine.side(), x, y);
                let texel = fine.texel(x, y);
                total += solid;
                for (sum, texel) in sum.iter_mut().zip(texel) {
                    *sum += solid * f64::from(texel);
                }
            }
            sum.map(|x| (x / total) as f32)
        });
        all.push(coarse);
    }
    all
}

/// A direction of a lobe around +z, and the solid angle that it stands for.
struct Ray {
    w: Vector<f64>,
    solid: f64,
}

/// The rays of the lobe of a level: a sunflower in the plane of slopes (Vogel 1979), which is as fine along as around.
fn rays(alpha: f64) -> Vec<Ray> {
    // The cosine of the light that the inner part of a lobe reaches to.
    let cosine = |part: f64| {
        if alpha >= 1.0 {
            return (1.0 - part).sqrt();
        }
        // Slopes are Gaussian: tan²θ_h = −α²·ln(1−u); the light lies at twice the angle.
        let tan_squared = -alpha * alpha * (-part).ln_1p();
        if tan_squared.is_finite() { (1.0 - tan_squared) / (1.0 + tan_squared) } else { -1.0 }
    };
    let golden = 0.5 * (3.0 - 5.0f64.sqrt());
    let ray = |i: usize| {
        let part = |offset: f64| (i as f64 + offset) / RAYS as f64;
        let cos = cosine(part(0.5));
        let solid = core::f64::consts::TAU * (cosine(part(0.0)) - cosine(part(1.0)));
        let sine = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
        let (y, x) = (core::f64::consts::TAU * (golden * i as f64).fract()).sin_cos();
        Ray { w: Vector::new(sine * x, sine * y, cos), solid }
    };
    (0..RAYS).map(ray).filter(|ray| ray.w.z > 0.0).collect()
}

fn blurred(pyramid: &[Map], alpha: f64, side: usize) -> Map {
    let rays = rays(alpha);
    // The finest level whose texels cover a ray's solid angle, so that no light falls between rays.
    let levels: Vec<usize> = rays
        .iter()
        .map(|ray| {
            let fits = |map: &&Map| 4.0 * core::f64::consts::PI / ((map.side() * map.side()) as f64) >= ray.solid;
            let fitting = pyramid.iter().position(|map| fits(&map)).unwrap_or(pyramid.len());
            fitting.min(pyramid.len() - 1)
        })
        .collect();
    let rows: Vec<Vec<[f32; 3]>> = (0..side)
        .into_par_iter()
        .map(|row| {
            let texel = |column: usize| {
                let (normal, _) = Map::centre(side, column, row);
                let frame = Frame::from_normal(normal);
                let mut sum = [0.0; 3];
                for (ray, level) in rays.iter().zip(&levels) {
                    if let Some(map) = pyramid.get(*level) {
                        let (radiance, _) = map.look(frame.to_world(ray.w));
                        for (sum, x) in sum.iter_mut().zip(radiance) {
                            *sum += x;
                        }
                    }
                }
                sum.map(|x| (x / rays.len().max(1) as f64) as f32)
            };
            (0..side).map(texel).collect()
        })
        .collect();
    Map::new(side, |column, row| rows.get(row).and_then(|row| row.get(column)).copied().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_environment_stays_constant() {
        let all = Prefiltered::new(&Environment::furnace());
        for alpha in [0.0, 0.01, 0.1, 0.5, 0.9, 1.0] {
            for x in all.look(Vector::from_angles(0.7, 2.0), alpha) {
                assert!((x - 1.0f64).abs() < 1e-6, "{alpha}: {x}");
            }
        }
    }

    #[test]
    fn the_last_level_is_the_irradiance() {
        // L = max(z, 0): E(n)/π = (sin θ + (π−θ)·cos θ)/(2π)·… is known at the poles: ∫z·z dω/π = 2/3 up, 0 down; sideways
        // ∫ max(z,0)·max(x,0) dω/π = 2/(3π).
        let all = Prefiltered::new(&Environment::from_radiance(256, |w| [w.z.max(0.0); 3]));
        let at = |x, y, z| all.look(Vector::<f64>::new(x, y, z), 1.0)[0];
        // 320 rays resolve 1/√320 of the lobe's width, and the bend at the horizon less; texels of the coarse levels blur by 1/32.
        for (got, want) in [(at(0.0, 0.0, 1.0), 2.0 / 3.0), (at(1.0, 0.0, 0.0), 2.0 / (3.0 * core::f64::consts::PI))] {
            assert!((got - want).abs() < 0.03, "{got} {want}");
        }
        assert!(at(0.0, 0.0, -1.0) < 0.03);
    }

    #[test]
    fn a_lobe_has_the_width_of_its_alpha() {
        // A small lamp at +z: the blurred radiance falls as Beckmann's D of half the angle, D(θ/2)/D(0).
        let lamp = |w: Vector<f64>| if w.z > 0.9995 { [1.0; 3] } else { [0.0; 3] };
        let all = Prefiltered::new(&Environment::from_radiance(512, lamp));
        let alpha = 0.3;
        let peak = all.look(Vector::<f64>::new(0.0, 0.0, 1.0), alpha)[0];
        let side = all.look(Vector::<f64>::from_angles(0.5, 1.0), alpha)[0] / peak;
        let tan = 0.25f64.tan();
        let want = (-(tan / alpha).powi(2)).exp();
        // The texels of the coarse level that the rays look up blur by a few hundredths of a radian.
        assert!((side - want).abs() < 0.1, "{side} {want}");
    }
}
