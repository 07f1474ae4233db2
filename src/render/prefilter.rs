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
const SIDES: [usize; 10] = [0, 256, 256, 128, 128, 64, 64, 64, 64, 64];

/// Rings of equal weight, and samples to a ring.
const RINGS: usize = 12;
const TURNS: usize = 24;

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

/// A direction of a lobe around +z, its weight, and the solid angle that it stands for.
struct Ray {
    w: Vector<f64>,
    weight: f64,
    solid: f64,
}

/// The rays of the lobe of a level. Rings hold equal parts of the lobe, so each ray's solid angle follows from its neighbours'.
fn rays(alpha: f64) -> Vec<Ray> {
    let cosine = |part: f64| {
        if alpha >= 1.0 {
            return (1.0 - part).sqrt();
        }
        // Slopes are Gaussian: tan²θ_h = −α²·ln(1−u); the light lies at twice the angle.
        let tan_squared = -alpha * alpha * (-part).ln_1p();
        (1.0 - tan_squared) / (1.0 + tan_squared)
    };
    let mut all = Vec::with_capacity(RINGS * TURNS);
    for ring in 0..RINGS {
        let part = (ring as f64 + 0.5) / RINGS as f64;
        let cos = cosine(part);
        if cos <= 0.0 {
            continue;
        }
        let (inner, outer) = (cosine(ring as f64 / RINGS as f64), cosine((ring + 1) as f64 / RINGS as f64));
        // The last ring of a Gaussian reaches to infinity: as far beyond its middle as its inner edge is before it.
        let outer = if ring + 1 == RINGS { 2.0 * cos - inner } else { outer };
        let solid = core::f64::consts::TAU * (inner - outer.max(-1.0)) / TURNS as f64;
        let sine = ((1.0 - cos) * (1.0 + cos)).sqrt();
        for turn in 0..TURNS {
            // Each ring is turned against the one inside by the golden angle.
            let phi = core::f64::consts::TAU * ((turn as f64 + 0.5) / TURNS as f64 + 0.381_966 * ring as f64);
            let w = Vector::new(sine * phi.cos(), sine * phi.sin(), cos);
            all.push(Ray { w, weight: 1.0, solid });
        }
    }
    let total: f64 = all.iter().map(|ray| ray.weight).sum();
    for ray in &mut all {
        ray.weight /= total;
    }
    all
}

fn blurred(pyramid: &[Map], alpha: f64, side: usize) -> Map {
    let rays = rays(alpha);
    // The level whose texels cover about a ray's solid angle, so that no light falls between rays; one finer, as lookups blur too.
    let levels: Vec<usize> = rays
        .iter()
        .map(|ray| {
            let fits = |map: &&Map| 4.0 * core::f64::consts::PI / ((map.side() * map.side()) as f64) >= 0.5 * ray.solid;
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
                            *sum += ray.weight * x;
                        }
                    }
                }
                sum.map(|x| x as f32)
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
        // Twelve rings of the cosine: the midpoint rule is off by up to 1/(24·12²)·f″, and the map's texels by 1/64.
        for (got, want) in [(at(0.0, 0.0, 1.0), 2.0 / 3.0), (at(1.0, 0.0, 0.0), 2.0 / (3.0 * core::f64::consts::PI))] {
            assert!((got - want).abs() < 0.01, "{got} {want}");
        }
        assert!(at(0.0, 0.0, -1.0) < 0.01);
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
