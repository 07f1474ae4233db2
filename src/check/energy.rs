//! Directional albedo of both marginals, with an error that can be believed.
//!
//! A = ∫ f cosθ dω over one direction with the other one fixed, in three steps: find the lobes; integrate adaptively on
//! the half-vector chart, and on one more about each narrow lobe off the mirror direction, cut finely around the wider lobes
//! beforehand; integrate again by randomised quasi-Monte Carlo. Where the two disagree, neither is believed.

use super::atlas::{Atlas, Share, WORTHY};
use super::chart::Chart;
use super::crosscheck::Mixture;
use super::lobes::{self, Lobe};
use super::quadrature::Cubature;
use super::subject::{Fixed, Probe, Section, Subject, Watch};
use crate::frame::{Frame, Vector};
use core::f64::consts::FRAC_PI_4;

/// How hard an integral is worked on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// The sum of error estimates that the cubature stops at, relative to albedos above 1.
    pub target: f64,
    /// The most evaluations that the cubature spends.
    pub evaluations: usize,
    /// Independent scrambles of the cross-check; 0 leaves it out.
    pub replicates: usize,
    /// Samples per replicate, best a power of two, at most 65 536.
    pub samples: usize,
    /// Seed of the cross-check.
    pub seed: u32,
}

impl Default for Effort {
    fn default() -> Self {
        Effort { target: 5e-5, evaluations: 30_000, replicates: 16, samples: 512, seed: 1 }
    }
}

impl Effort {
    /// The same with `factor` times the evaluations, for an answer that was not clear enough.
    #[must_use]
    pub fn scaled(self, factor: usize) -> Self {
        Effort {
            target: self.target / factor.max(1) as f64,
            evaluations: self.evaluations.saturating_mul(factor),
            samples: self.samples.saturating_mul(factor).min(1 << 16),
            seed: self.seed.wrapping_add(0x5bd1_e995),
            ..self
        }
    }
}

/// Evaluations below which an integral without a cross-check starts from wide panels.
const GLANCED: usize = 5_000;

/// The spread of a cross-check, relative to albedos above 1, beyond which it confirms nothing.
const PRECISE: f64 = 0.3;

/// The albedo for one fixed direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Albedo {
    /// Polar angle of the fixed direction in degrees.
    pub theta: f64,
    /// Azimuth of the fixed direction in degrees.
    pub phi: f64,
    /// Which direction is fixed.
    pub fixed: Fixed,
    /// The albedo of each channel.
    pub value: Vec<f64>,
    /// The error of each channel: the cubature's estimate, or the distance to the cross-check and three of its standard
    /// errors where that is less; the larger of the two where they disagree.
    pub error: Vec<f64>,
    /// The cross-check's albedo of each channel; empty where it was left out.
    pub cross_check: Vec<f64>,
    /// The cross-check's standard error of each channel.
    pub standard_error: Vec<f64>,
    /// Whether cubature and cross-check agree.
    pub agrees: bool,
    /// Samples at which some channel was not finite, and counted as 0.
    pub non_finite: usize,
    /// Evaluations of the subject.
    pub evaluations: usize,
}

impl Albedo {
    /// The channel with the largest albedo, and that albedo.
    pub fn peak(&self) -> (usize, f64) {
        self.value.iter().copied().enumerate().fold((0, f64::NEG_INFINITY), |a, b| if b.1 > a.1 { b } else { a })
    }
}

/// The albedo of a subject with one direction fixed at (`theta`, `phi`), in degrees.
///
/// `theta` is clamped to [0, 89.9999].
pub fn albedo(subject: &dyn Subject, theta: f64, phi: f64, fixed: Fixed, effort: &Effort) -> Albedo {
    watched(subject, theta, phi, fixed, effort).0
}

/// [`albedo`], and the defects that it met.
pub(super) fn watched(subject: &dyn Subject, theta: f64, phi: f64, fixed: Fixed, effort: &Effort) -> (Albedo, Watch) {
    let theta = theta.clamp(0.0, 89.9999);
    let direction = Vector::from_angles(theta.to_radians(), phi.to_radians());
    let mut result = Albedo {
        theta,
        phi,
        fixed,
        value: Vec::new(),
        error: Vec::new(),
        cross_check: Vec::new(),
        standard_error: Vec::new(),
        agrees: true,
        non_finite: 0,
        evaluations: 0,
    };
    if subject.channels() == 0 {
        return (result, Watch::default());
    }
    let mut probe = Probe::new(Section { subject, direction, fixed });
    let mut lobes = lobes::find(&mut probe, effort.replicates > 0);
    for last in [false, true] {
        let atlas = Atlas::new(direction, &lobes);
        clear(&mut result, subject.channels());
        let mut witnesses = Vec::new();
        for share in atlas.shares() {
            witnesses.extend(integrate(&mut probe, &lobes, share, effort, &mut result));
        }
        if result.agrees || last {
            break;
        }
        // The cubature has missed something, and the cross-check has hit it.
        lobes.extend(lobes::uphill(&mut probe, &witnesses));
    }
    result.non_finite = probe.watch.broken;
    result.evaluations = probe.evaluations;
    (result, probe.watch)
}

/// An albedo of 0, without an error, to add the shares of charts to.
fn clear(result: &mut Albedo, channels: usize) {
    for each in [&mut result.value, &mut result.error, &mut result.cross_check, &mut result.standard_error] {
        each.clear();
        each.resize(channels, 0.0);
    }
    result.agrees = true;
}

/// One cubature with its cross-check, of what one chart has a share in; adds to `result`. Returns the directions of the samples
/// that contradict the cubature most.
fn integrate(
    probe: &mut Probe<'_>,
    lobes: &[Lobe],
    share: Share<'_>,
    effort: &Effort,
    result: &mut Albedo,
) -> Vec<Vector<f64>> {
    let direction = probe.section.direction;
    let channels = probe.section.subject.channels();
    let chart = share.chart();
    // Without a second opinion it is a glance, that starts from wider panels.
    let glance = effort.replicates < 2 || effort.samples == 0;
    let coarse = glance && effort.evaluations < GLANCED;
    let rings = chart.rings(if coarse { 2.0 } else { 1.0 });
    let sectors: &[f64] = if coarse { &Chart::HALVES } else { &Chart::SECTORS };
    let mut panels = Cubature::new(channels, [&rings, sectors]);
    for lobe in lobes.iter().filter(|lobe| !share.is_of_another(lobe)) {
        focus(&mut panels, &chart, lobe);
    }
    let (mut directions, mut weights) = (Vec::new(), Vec::new());
    panels.run(effort.target, effort.evaluations, |at, f| {
        let points = at.iter().map(|&[c, t]| chart.point(c, t));
        weights.clear();
        directions.clear();
        for point in points {
            // Below the horizon by rounding: the fixed direction stands in, and weighs nothing.
            let above = point.weight > 0.0;
            weights.push(if above { point.weight * share.of(point.v) } else { 0.0 });
            directions.push(if above { point.v } else { direction });
        }
        probe.evaluate(&directions, f);
        for (f, weight) in f.chunks_exact_mut(channels).zip(&weights) {
            f.iter_mut().for_each(|f| *f *= weight);
        }
    });
    let (value, bound) = panels.result();
    let add = |to: &mut [f64], of: &[f64]| to.iter_mut().zip(of).for_each(|(to, of)| *to += of);
    add(&mut result.value, &value);
    if glance {
        add(&mut result.error, &bound);
        result.cross_check.clear();
        result.standard_error.clear();
        return Vec::new();
    }
    panels.weigh();
    let mixture = Mixture { chart: &chart, panels: &panels, lobes, share };
    let estimate = mixture.integrate(probe, effort.replicates, effort.samples, effort.seed);
    for (c, &bound) in bound.iter().enumerate() {
        let (value, spread) = (value[c], estimate.standard_error[c]);
        let apart = (value - estimate.mean[c]).abs();
        // Sixteen replicates: one in a thousand honest means lies more than 4.07 standard errors off (Student, 15 degrees
        // of freedom). The floor admits a standard error that is 0 by luck.
        // Of several charts each has a part of the albedo: a tenth of the verdict's tolerance is near enough, and is told as error.
        let floor = if share.is_alone() { 1e-6 + 1e-4 * value.abs() } else { WORTHY };
        let near = apart <= bound + 4.07 * spread + floor;
        // A second opinion that spans everything confirms nothing.
        let agrees = near && 4.07 * spread <= PRECISE * value.abs().max(1.0);
        let distance = apart + 3.0 * spread;
        result.error[c] += match (agrees, share.is_alone()) {
            (true, true) => bound.min(distance),
            (true, false) => bound.max(apart),
            (false, _) => bound.max(distance),
        };
        result.agrees &= agrees;
        result.cross_check[c] += estimate.mean[c];
        result.standard_error[c] = result.standard_error[c].hypot(spread);
    }
    estimate.witnesses
}

/// Cuts the panels around a lobe that is not the chart's own centre down to the lobe's width.
fn focus(panels: &mut Cubature, chart: &Chart, lobe: &Lobe) {
    let mirror = chart.point(0.0, 0.0).v;
    if (mirror - lobe.direction).length_squared().sqrt() <= 2.0 * lobe.width {
        return;
    }
    // The panels beside the lobe's own as well: it reaches into them, and their points may all miss it.
    let frame = Frame::from_normal(lobe.direction);
    cut(panels, chart, lobe.direction, lobe.width);
    for radius in [1.5, 4.0] {
        for spoke in 0..8 {
            let (sin, cos) = (FRAC_PI_4 * f64::from(spoke)).sin_cos();
            let step = (frame.tangent * cos + frame.bitangent * sin) * (radius * lobe.width);
            let v = (lobe.direction + step).normalized();
            if v.z > 0.0 {
                cut(panels, chart, v, radius * lobe.width);
            }
        }
    }
}

/// Cuts the panel that holds `v` until it spans no more than twice `width`.
fn cut(panels: &mut Cubature, chart: &Chart, v: Vector<f64>, width: f64) {
    let (c, t) = chart.coordinates(v);
    panels.focus([c, t], |low, high| {
        let near = |a: [f64; 2], b: [f64; 2]| {
            let [a, b] = [a, b].map(|[c, t]| chart.point(c, t).v);
            (a - b).length_squared().sqrt() <= 2.0 * width
        };
        // An arc can close on itself: its halves cannot both.
        let middle = [c, 0.5 * (low[1] + high[1])];
        [near([low[0], t], [high[0], t]), near([c, low[1]], middle) && near(middle, [c, high[1]])]
    });
}

#[cfg(test)]
mod tests {
    use super::super::corpus::*;
    use super::*;

    #[test]
    fn known_albedos() {
        let mut cases: Vec<(Box<dyn Subject>, f64, f64)> = Vec::new();
        for theta in [0.0, 45.0, 80.0, 89.9] {
            cases.push((Box::new(lambert()), theta, 1.0));
        }
        cases.push((Box::new(ggx_smith(1.0)), 0.0, 0.306_853));
        // terms.json, kind ts_F1.
        for (alpha, theta, want) in [
            (0.05, 60.0, 1.0),
            (0.1, 80.0, 0.941691),
            (0.1, 89.0, 0.983587),
            (0.3, 0.01, 0.995578),
            (0.3, 30.0, 0.981194),
            (0.3, 60.0, 0.924766),
            (0.3, 89.0, 0.993897),
            (0.5, 30.0, 0.875045),
            (0.5, 60.0, 0.886876),
            (0.5, 80.0, 0.955095),
            (1.0, 0.01, 0.453448),
            (1.0, 80.0, 0.938454),
            (1.0, 89.0, 0.993917),
            (0.001, 60.0, 1.0),
            (0.001, 0.0, 1.0),
            (0.01, 80.0, 1.0),
        ] {
            cases.push((Box::new(torrance_sparrow(alpha)), theta, want));
        }
        for (subject, theta, want) in &cases {
            for fixed in Fixed::BOTH {
                let start = std::time::Instant::now();
                let a = albedo(&**subject, *theta, 20.0, fixed, &Effort::default());
                println!(
                    "{:28} {theta:5}° {:8.6} want {want:8.6} off {:+.1e} error {:.1e} qmc {:+.1e} ± {:.1e} {} evals {} {:?}",
                    subject.name(),
                    a.value[0],
                    a.value[0] - want,
                    a.error[0],
                    a.cross_check[0] - want,
                    a.standard_error[0],
                    if a.agrees { "" } else { "DISAGREES" },
                    a.evaluations,
                    start.elapsed()
                );
                assert!((a.value[0] - want).abs() < 1e-4 && a.error[0] < 3e-4 && a.agrees);
            }
        }
    }
}
