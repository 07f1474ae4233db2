//! The second opinion on an integral: randomised quasi-Monte Carlo.
//!
//! Owen-scrambled Sobol points (Burley 2020), independent scrambles as replicates, so that the spread of their means is an
//! honest standard error. The points go to a mixture of densities, weighted by the balance heuristic (Veach & Guibas 1995,
//! eq. 10): the panels of the cubature, the cosine, every radius about the mirror direction alike, and the lobes that were
//! found. What is averaged is f less the panels' own quadratics, whose integral is the cubature's result (a control
//! variate, Owen & Zhou 2000), so the points measure what the cubature is wrong by. The estimate is unbiased whatever the
//! cubature saw; what the panels miss, the other densities still meet.

use super::atlas::Share;
use super::chart::Chart;
use super::lobes::Lobe;
use super::quadrature::Cubature;
use super::subject::Probe;
use crate::frame::{Frame, Vector};
use core::f64::consts::{FRAC_1_PI, PI, TAU};
use sobol_burley::sample_4d;

/// Shares of the mixture: panels, cosine, radii, lobes.
const SHARES: [f64; 4] = [0.6, 0.15, 0.15, 0.1];

/// Samples that are kept as witnesses against the cubature.
///
/// Each costs the panels around a lobe: with many, the cubature has nothing left to refine with.
const WITNESSES: usize = 1;

/// Samples that the subject is given at once.
const BLOCK: usize = 256;

/// Everything that the mixture draws from.
pub(super) struct Mixture<'a> {
    pub(super) chart: &'a Chart,
    pub(super) panels: &'a Cubature,
    pub(super) lobes: &'a [Lobe],
    /// What of f the chart integrates.
    pub(super) share: Share<'a>,
}

/// The mean of each channel and its standard error.
pub(super) struct Estimate {
    pub(super) mean: Vec<f64>,
    pub(super) standard_error: Vec<f64>,
    /// Where the samples were that say most against the cubature.
    pub(super) witnesses: Vec<Vector<f64>>,
}

struct Draw {
    v: Vector<f64>,
    /// Where `v` is on the chart, and the chart's weight there.
    at: [f64; 2],
    weight: f64,
    /// The density of the mixture per projected solid angle.
    density: f64,
}

impl Mixture<'_> {
    /// Integrates f·cosθ over the hemisphere with `replicates` × `samples` points.
    pub(super) fn integrate(&self, probe: &mut Probe<'_>, replicates: usize, samples: usize, seed: u32) -> Estimate {
        let channels = probe.section.subject.channels();
        // The sequence is no longer than that.
        let samples = samples.min(1 << 16);
        let mut model = vec![0.0; channels];
        let (mut sum, mut squares) = (vec![0.0; channels], vec![0.0; channels]);
        let mut witnesses: Vec<(f64, Vector<f64>)> = Vec::new();
        let mut least = 0.0;
        let (mut draws, mut directions, mut values) = (Vec::new(), Vec::new(), Vec::new());
        for replicate in 0..replicates {
            let scramble = seed.wrapping_mul(0x9e37_79b9).wrapping_add(replicate as u32);
            let mut mean = vec![0.0; channels];
            for block in (0..samples).step_by(BLOCK) {
                draws.clear();
                draws.extend((block..samples.min(block + BLOCK)).filter_map(|i| {
                    // Sobol coordinates have 24 bits; the half step keeps them inside (0, 1).
                    self.draw(sample_4d(i as u32, 0, scramble).map(|u| f64::from(u) + 2.98e-8))
                }));
                directions.clear();
                directions.extend(draws.iter().map(|draw| draw.v));
                values.resize(draws.len() * channels, 0.0);
                probe.evaluate(&directions, &mut values);
                for (&Draw { v, at, weight, density }, f) in draws.iter().zip(values.chunks_exact(channels)) {
                    self.panels.model(at, &mut model);
                    let share = self.share.of(v);
                    for ((mean, f), model) in mean.iter_mut().zip(f).zip(&model) {
                        let excess = (share * f - model / weight) / density;
                        if excess.abs() > least {
                            witnesses.push((excess.abs(), v));
                        }
                        *mean += excess / samples as f64;
                    }
                }
            }
            witnesses.sort_by(|a, b| b.0.total_cmp(&a.0));
            witnesses.truncate(WITNESSES);
            if witnesses.len() == WITNESSES {
                least = witnesses[WITNESSES - 1].0;
            }
            for c in 0..channels {
                sum[c] += mean[c];
                squares[c] += mean[c] * mean[c];
            }
        }
        let n = replicates.max(2) as f64;
        let mut mean: Vec<f64> = sum.iter().map(|s| s / n).collect();
        let spread = |c: usize| ((squares[c] / n - mean[c] * mean[c]).max(0.0) / (n - 1.0)).sqrt();
        let standard_error = (0..channels).map(spread).collect();
        for (mean, known) in mean.iter_mut().zip(self.panels.result().0) {
            *mean += known;
        }
        Estimate { mean, standard_error, witnesses: witnesses.into_iter().map(|(_, v)| v).collect() }
    }

    /// A sample of the mixture; none where the density drawn from reaches below the horizon.
    fn draw(&self, u: [f64; 4]) -> Option<Draw> {
        let mut which = u[2];
        let mut share = 0;
        while share < 3 && which >= SHARES[share] {
            which -= SHARES[share];
            share += 1;
        }
        if share == 3 && self.lobes.is_empty() {
            share = 1;
        }
        let on_chart = |at: [f64; 2]| (self.chart.point(at[0], at[1]).v, at);
        let (v, at) = match share {
            0 => on_chart(self.panels.sample([u[0], u[1]])),
            1 => {
                let (sin, cos) = (TAU * u[1]).sin_cos();
                let v = Vector::new(u[0].sqrt() * cos, u[0].sqrt() * sin, (1.0 - u[0]).max(0.0).sqrt());
                (v, self.chart.coordinates(v).into())
            }
            2 => on_chart([u[0] * self.chart.extent(), 2.0 * u[1] - 1.0]),
            _ => {
                let lobe = self.lobes[((u[3] * self.lobes.len() as f64) as usize).min(self.lobes.len() - 1)];
                let v = draw_lobe(lobe, u[0], u[1]);
                if v.z <= 0.0 {
                    return None;
                }
                (v, self.chart.coordinates(v).into())
            }
        };
        let weight = self.chart.point(at[0], at[1]).weight;
        if v.z <= 0.0 || weight <= 0.0 {
            return None;
        }
        let lobes: f64 = self.lobes.iter().map(|&lobe| lobe_density(lobe, v)).sum::<f64>() / v.z;
        let (cosine, lobes) = match self.lobes.len() {
            0 => (SHARES[1] + SHARES[3], 0.0),
            n => (SHARES[1], SHARES[3] * lobes / n as f64),
        };
        let rings = SHARES[2] / (2.0 * self.chart.extent());
        let density = (SHARES[0] * self.panels.density(at) + rings) / weight + cosine * FRAC_1_PI + lobes;
        Some(Draw { v, at, weight, density })
    }
}

/// A draw from the GGX normal distribution around the lobe's axis: heavy tails, so that a narrow guess does no harm.
fn draw_lobe(lobe: Lobe, u0: f64, u1: f64) -> Vector<f64> {
    let square = lobe.width * lobe.width;
    let sin_squared = square * u0 / (1.0 + (square - 1.0) * u0);
    let (sin, cos) = (TAU * u1).sin_cos();
    let frame = Frame::from_normal(lobe.direction);
    let across = sin_squared.sqrt();
    frame.to_world(Vector::new(across * cos, across * sin, (1.0 - sin_squared).max(0.0).sqrt()))
}

fn lobe_density(lobe: Lobe, v: Vector<f64>) -> f64 {
    let cos = lobe.direction.dot(v);
    if cos <= 0.0 {
        return 0.0;
    }
    let square = lobe.width * lobe.width;
    let q = square * cos * cos + lobe.direction.cross(v).length_squared();
    square * cos / (PI * q * q)
}
