//! Samples against their density: what a path tracer relies on and no image of a furnace shows.
//!
//! For each of a few views the density is integrated over the chart by the adaptive cubature, whose panels, merged until each
//! expects enough samples, are the bins of a χ² test. What the density lacks of 1 is what may be lost: no direction, or one
//! below the horizon.

use super::chart::Chart;
use super::quadrature::Cubature;
use super::report::{Check, Finding, Place};
use super::subject::{Fixed, Subject};
use super::verdict::{TOLERANCE, Verdict};
use crate::frame::Vector;

/// Polar angles of the views, in degrees, and their azimuth.
const THETAS: [f64; 4] = [0.0, 30.0, 60.0, 85.0];
const PHI: f64 = 20.0;

/// The probability, over all views together, with which right samples may be called wrong. A wrong density is off by more than
/// that in any bin that holds a hundred samples.
pub const SIGNIFICANCE: f64 = 1e-6;

/// What f·cos/pdf may differ from a weight by, relatively, and a sample's density from [`Subject::pdf`]: room for subjects that
/// compute in single precision.
pub const AGREEMENT: f64 = 1e-3;

/// Bins hold no fewer samples than this, and no less than a 256th of all.
const LEAST: f64 = 8.0;
const BINS: f64 = 256.0;

/// Puts the samples of a subject to the test, with about `budget` evaluations. Returns the findings and the number of evaluations.
///
/// [`Check::Sampling`]: the p-value of χ², failing below [`SIGNIFICANCE`] shared out over the views (Bonferroni).
/// [`Check::Density`]: ∫ pdf dω ≤ 1, finite, not negative. [`Check::Weight`]: weight = f·cosθ/pdf.
pub fn sampling(subject: &dyn Subject, budget: usize, seed: u32) -> (Vec<Finding>, usize) {
    let samples = (budget / (2 * THETAS.len())).clamp(2_000, 100_000);
    let mut chi = Finding { value: 1.0, limit: SIGNIFICANCE / THETAS.len() as f64, ..Finding::new(Check::Sampling) };
    let mut density = Finding { limit: 1.0 + TOLERANCE, value: f64::NEG_INFINITY, ..Finding::new(Check::Density) };
    let mut weight = Finding { limit: AGREEMENT, ..Finding::new(Check::Weight) };
    for finding in [&mut chi, &mut density, &mut weight] {
        finding.verdict = Verdict::Pass;
    }
    let mut evaluations = 0;
    for (index, theta) in THETAS.into_iter().enumerate() {
        let wo = Vector::from_angles(theta.to_radians(), PHI.to_radians());
        let place = Place::Marginal { theta, phi: PHI, fixed: Fixed::View };
        let view = View::new(subject, wo, samples, seed.wrapping_add(0x1000 * index as u32));
        evaluations += view.evaluations;
        let (p, verdict) = view.chi_square(chi.limit);
        if (verdict, -p) > (chi.verdict, -chi.value) || index == 0 {
            (chi.verdict, chi.value, chi.place) = (verdict, p, place);
            chi.note = format!("{} samples in {} bins, {} lost", samples, view.bins.len(), view.lost);
        }
        let verdict = match view.broken {
            None => Verdict::of(view.total, view.error, 1.0, TOLERANCE),
            Some(_) => Verdict::Fail,
        };
        if (verdict, view.total) > (density.verdict, density.value) {
            (density.verdict, density.value, density.error, density.place) = (verdict, view.total, view.error, place);
            density.note = view.broken.map_or(String::new(), |(wi, pdf)| format!("pdf = {pdf:e} at wi = {wi:?}"));
        }
        if view.apart.0 > weight.value || view.apart.0.is_nan() {
            weight.value = view.apart.0;
            weight.verdict = if view.apart.0 <= AGREEMENT { Verdict::Pass } else { Verdict::Fail };
            weight.place = Place::Pair { wi: view.apart.1, wo };
            weight.note = view.apart.2.into();
        }
    }
    (vec![chi, density, weight], evaluations)
}

/// A bin: samples expected, by how much that may be wrong, and found.
#[derive(Clone, Copy, Debug, Default)]
struct Bin {
    expected: f64,
    doubt: f64,
    found: f64,
}

/// What one view showed.
struct View {
    bins: Vec<Bin>,
    lost: usize,
    total: f64,
    error: f64,
    /// A direction whose density is negative or not finite.
    broken: Option<(Vector<f64>, f64)>,
    /// The largest relative difference of a weight or a density, where, and which.
    apart: (f64, Vector<f64>, &'static str),
    evaluations: usize,
}

impl View {
    fn new(subject: &dyn Subject, wo: Vector<f64>, samples: usize, seed: u32) -> Self {
        let chart = Chart::new(wo);
        let mut view = View {
            bins: Vec::new(),
            lost: 0,
            total: 0.0,
            error: 0.0,
            broken: None,
            apart: (0.0, wo, ""),
            evaluations: 2 * samples,
        };
        // Independent numbers: points that are spread evenly would pass any χ².
        let mut random = Random(u64::from(seed) << 32 | 0x9e37_79b9);
        let mut points = Vec::with_capacity(samples);
        let mut f = vec![0.0; subject.channels()];
        for i in 0..samples {
            let Some(sample) = subject.sample(wo, [random.unit(), random.unit(), random.unit()]) else { continue };
            let at = chart.coordinates(sample.wi);
            if sample.wi.z <= 0.0 || !at.0.is_finite() || !at.1.is_finite() {
                continue;
            }
            points.push([at.0, at.1]);
            if i % 8 == 0 {
                view.evaluations += 1;
                f.fill(0.0);
                subject.evaluate(sample.wi, wo, &mut f);
                view.compare(&f, &sample.weight, sample.pdf, subject.pdf(sample.wi, wo), sample.wi);
            }
        }
        view.lost = samples - points.len();
        let mut panels = Cubature::new(1, [&chart.rings(1.0), &Chart::SECTORS]);
        // Panels where samples are, so that no narrow lobe is missed.
        panels.divide(&points[..points.len().min(2_000)], 40);
        panels.run(1e-4, samples.max(20_000), |at, f| {
            for (&[c, t], f) in at.iter().zip(f) {
                let point = chart.point(c, t);
                if point.weight > 0.0 {
                    let pdf = subject.pdf(point.v, wo);
                    if !(pdf.is_finite() && pdf >= 0.0) {
                        view.broken.get_or_insert((point.v, pdf));
                    }
                    *f = if pdf.is_finite() { pdf * point.weight / point.v.z } else { 0.0 };
                }
            }
        });
        view.evaluations += panels.evaluations;
        let (total, error) = panels.result();
        (view.total, view.error) = (total[0], error[0]);
        view.fill(&panels, &points, samples);
        view
    }

    fn compare(&mut self, f: &[f64], weight: &[f64], drawn: f64, pdf: f64, wi: Vector<f64>) {
        let relative = |a: f64, b: f64, floor: f64| {
            let apart = (a - b).abs() / a.abs().max(b.abs()).max(floor);
            if apart.is_nan() { f64::INFINITY } else { apart }
        };
        let density = relative(drawn, pdf, 1e-12);
        if density > self.apart.0 {
            self.apart = (density, wi, "the density of a sample against pdf()");
        }
        for (f, &weight) in f.iter().zip(weight) {
            let apart = relative(f * wi.z / drawn, weight, 1e-6);
            if apart > self.apart.0 {
                self.apart = (apart, wi, "the weight of a sample against f·cos/pdf");
            }
        }
    }

    /// Merges panels into bins, and counts.
    fn fill(&mut self, panels: &Cubature, points: &[[f64; 2]], samples: usize) {
        let n = samples as f64;
        let least = (n / BINS).max(LEAST);
        let leaves = panels.leaves();
        let mut bin_of = vec![0; leaves.iter().map(|leaf| leaf.0 + 1).max().unwrap_or(0)];
        self.bins.push(Bin {
            expected: n * (1.0 - self.total).max(0.0),
            doubt: n * self.error,
            found: self.lost as f64,
        });
        for (node, mass, error) in leaves {
            if self.bins.last().is_none_or(|bin| bin.expected >= least) {
                self.bins.push(Bin::default());
            }
            let index = self.bins.len() - 1;
            bin_of[node] = index;
            self.bins[index].expected += n * mass;
            self.bins[index].doubt += n * error;
        }
        for &point in points {
            self.bins[bin_of[panels.leaf(point)]].found += 1.0;
        }
        // The last one may have stayed small.
        if self.bins.len() > 1
            && self.bins.last().is_some_and(|bin| bin.expected < least)
            && let (Some(last), Some(before)) = (self.bins.pop(), self.bins.last_mut())
        {
            before.expected += last.expected;
            before.doubt += last.doubt;
            before.found += last.found;
        }
    }

    /// The p-value, where what the bins' integrals may be wrong by is taken off the differences.
    fn chi_square(&self, limit: f64) -> (f64, Verdict) {
        let term = |bin: &Bin| ((bin.found - bin.expected).abs() - bin.doubt).max(0.0).powi(2) / bin.expected.max(1.0);
        let square: f64 = self.bins.iter().map(term).sum();
        let p = upper_gamma(0.5 * self.bins.len().saturating_sub(1).max(1) as f64, 0.5 * square);
        let verdict = match p {
            p if p < limit => Verdict::Fail,
            // A doubt of that size hides what the test is for.
            _ if self.error > 0.02 || self.broken.is_some() => Verdict::Inconclusive,
            _ => Verdict::Pass,
        };
        (p, verdict)
    }
}

/// Q(a, x) = Γ(a, x)/Γ(a): the tail of χ² with 2a degrees of freedom at 2x. Series and continued fraction, Abramowitz & Stegun
/// 6.5.29 and 6.5.31.
fn upper_gamma(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    let front = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut sum, mut term, mut k) = (1.0 / a, 1.0 / a, a);
        while term > 1e-16 * sum {
            k += 1.0;
            term *= x / k;
            sum += term;
        }
        return (1.0 - front * sum).max(0.0);
    }
    // Lentz's method.
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (1e300, 1.0 / b);
    let mut h = d;
    for i in 1..10_000 {
        let i = f64::from(i);
        let numerator = -i * (i - a);
        b += 2.0;
        d = 1.0 / (numerator * d + b);
        c = b + numerator / c;
        h *= c * d;
        if (c * d - 1.0).abs() < 1e-15 {
            break;
        }
    }
    front * h
}

/// ln Γ(a) for a > 0: Stirling's series from a ≥ 10, where its error is below 1e-12.
fn ln_gamma(a: f64) -> f64 {
    let (mut a, mut shift) = (a, 0.0);
    while a < 10.0 {
        shift -= a.ln();
        a += 1.0;
    }
    let inverse = 1.0 / a;
    let square = inverse * inverse;
    let series = inverse * (1.0 / 12.0 - square * (1.0 / 360.0 - square * (1.0 / 1260.0 - square / 1680.0)));
    shift + (a - 0.5) * a.ln() - a + 0.5 * core::f64::consts::TAU.ln() + series
}

/// SplitMix64 (Steele, Lea & Flood 2014).
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 * 2f64.powi(-53)
    }
}

#[cfg(test)]
mod tests {
    use super::super::subject::Sample;
    use super::*;
    use core::f64::consts::{FRAC_1_PI, TAU};

    /// Lambert, drawn from the cosine; the faults that a sampler can have, one at a time.
    #[derive(Clone, Copy, Debug, PartialEq)]
    enum Fault {
        None,
        Uniform,
        Tilted,
        Density,
        Weight,
        Lossy,
        Negative,
    }

    impl Subject for Fault {
        fn name(&self) -> String {
            format!("{self:?}")
        }
        fn channels(&self) -> usize {
            1
        }
        fn evaluate(&self, wi: Vector<f64>, wo: Vector<f64>, f: &mut [f64]) {
            f[0] = if wi.z > 0.0 && wo.z > 0.0 { FRAC_1_PI } else { 0.0 };
        }
        fn samples(&self) -> bool {
            true
        }
        fn sample(&self, wo: Vector<f64>, u: [f64; 3]) -> Option<Sample> {
            let square = if *self == Fault::Uniform { 1.0 - (1.0 - u[0]).powi(2) } else { u[0] };
            let tilt = if *self == Fault::Tilted { 0.2 * (TAU * u[1]).sin() } else { 0.0 };
            let (sin, cos) = (TAU * u[1] + tilt).sin_cos();
            let wi = Vector::new(square.sqrt() * cos, square.sqrt() * sin, (1.0 - square).sqrt());
            if *self == Fault::Lossy && u[2] < 0.02 {
                return None;
            }
            let pdf = self.pdf(wi, wo);
            let weight = vec![FRAC_1_PI * wi.z / pdf * if *self == Fault::Weight { 1.01 } else { 1.0 }];
            Some(Sample { wi, weight, pdf })
        }
        fn pdf(&self, wi: Vector<f64>, _: Vector<f64>) -> f64 {
            let cosine = FRAC_1_PI * wi.z.max(0.0);
            match self {
                Fault::Density => 1.01 * cosine,
                Fault::Negative => {
                    if wi.x > 0.99 {
                        -cosine
                    } else {
                        cosine
                    }
                }
                _ => cosine,
            }
        }
    }

    #[test]
    fn faults_are_found_where_they_are() {
        for (fault, failing) in [
            (Fault::None, [false, false, false]),
            (Fault::Uniform, [true, false, false]),
            (Fault::Tilted, [true, false, false]),
            (Fault::Density, [false, true, false]),
            (Fault::Weight, [false, false, true]),
            (Fault::Lossy, [true, false, false]),
            (Fault::Negative, [false, true, false]),
        ] {
            for seed in 1..4 {
                let (findings, _) = sampling(&fault, 600_000, seed);
                for (finding, failing) in findings.iter().zip(failing) {
                    // Densities that are off by 1 % show in the counts as well, if there are enough.
                    let also = fault == Fault::Density && finding.check == Check::Sampling;
                    let also = also || (fault == Fault::Negative && finding.check != Check::Density);
                    assert!(also || (finding.verdict == Verdict::Fail) == failing, "{fault:?} {finding}");
                    assert!(fault != Fault::None || finding.verdict == Verdict::Pass, "{finding}");
                }
            }
        }
    }

    #[test]
    fn tails_of_chi_square() {
        // One degree of freedom: erfc(1/√2); two: e^{-x}.
        assert!((upper_gamma(0.5, 0.5) - 0.317_310_507_862_914).abs() < 1e-12);
        for x in [0.1, 1.0, 3.0, 30.0] {
            assert!((upper_gamma(1.0, x) / (-x).exp() - 1.0).abs() < 1e-11, "{x}");
        }
    }
}
