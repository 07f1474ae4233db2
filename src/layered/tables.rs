//! What [`Coupled`](super::Coupled) knows of a stack before it is asked: curves over the cosine, built once.

use super::{Interface, Layer, Model, Stack};
use crate::diffuse;
use crate::frame::Vector;
use crate::fresnel;
use crate::real::Real;
use crate::refraction::{cos_t, refract};
use crate::walk::{self, Options};
use core::f64::consts::{FRAC_1_PI, PI};
use std::time::{Duration, Instant};
use std::vec::Vec;

/// Nodes of a [`Curve`].
pub(super) const NODES: usize = 32;
/// Walks per node and table. The albedo of one walk has a standard deviation of .2 to .5, so a node is known to .001 to
/// .003, and the fit through the nodes to half of that.
const WALKS: u32 = 1 << 14;
/// Coats of at most this width count as smooth: the closed form is then within α² of the rough one.
const SMOOTH: f64 = 0.02;
/// Quadrature points per lobe and node; the points are those of a rank-1 sequence, whose error here is below .003.
const POINTS: usize = 2048;
/// The polynomial that is fitted through the differences to the walk, its number of coefficients.
const TERMS: usize = 12;
/// The largest r_i: a series that loses less than this has no light to lose.
const ENDLESS: f64 = 1.0 - 1e-9;
/// The largest factor of a direction.
const LIFT: f64 = 3.0;
/// The share of the missing albedo that widens nothing: it scales the lobes that are there. The rest goes over the whole
/// hemisphere. Chosen by the f of copper under n = 1.5, α₁/α₂ = .1/.1, .1/.3, .3/.1: there 1 leaves the sides of a lobe
/// dark, and 0 (the form of Kulla & Conty) makes them up to nine times too bright.
const LOBES: f64 = 0.85;
/// How far below 1 the fitted albedo stays: what quadrature and interpolation add between the nodes, up to .003 over a mirror
/// without loss under a smooth coat, the worst of `tests/coupled.rs`.
const MARGIN: f64 = 4e-3;
/// Rounds that balance the scale.
const ROUNDS: usize = 12;

/// A function of the cosine for each channel, linear in √μ between [`NODES`] nodes: dense at grazing, where things change.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Curve<const C: usize>(Vec<[f64; C]>);

impl<const C: usize> Curve<C> {
    /// The cosine of a node. The first one stands for 0, and is taken where a walk can still begin.
    fn cosine(node: usize) -> f64 {
        (node as f64 / (NODES - 1) as f64).powi(2).max(1e-4)
    }

    fn from_nodes(mut node: impl FnMut(usize, f64) -> [f64; C]) -> Self {
        Curve((0..NODES).map(|i| node(i, Self::cosine(i))).collect())
    }

    /// The value of each channel at a cosine in [0, 1].
    #[inline]
    pub(super) fn at<R: Real>(&self, cos: R) -> [R; C] {
        (cos.saturate().sqrt() * R::from_f64((NODES - 1) as f64)).interpolate(&self.0)
    }

    /// The values at the nodes, from grazing to normal incidence.
    #[cfg(feature = "bytemuck")]
    pub(super) fn nodes(&self) -> &[[f64; C]] {
        &self.0
    }

    /// 2∫ value·μ dμ, exactly: with x = √μ it is 4∫ value·x³ dx.
    fn mean(&self) -> [f64; C] {
        let h = 1.0 / (NODES - 1) as f64;
        let mut sum = [0.0; C];
        for (i, pair) in self.0.windows(2).enumerate() {
            let (a, b) = (i as f64 * h, (i + 1) as f64 * h);
            let fourth = (b.powi(4) - a.powi(4)) / 4.0;
            let fifth = (b.powi(5) - a.powi(5)) / 5.0;
            let right = (fifth - a * fourth) / h;
            for c in 0..C {
                sum[c] += 4.0 * (pair[0][c] * (fourth - right) + pair[1][c] * right);
            }
        }
        sum
    }

    fn bytes(&self) -> usize {
        size_of_val(self.0.as_slice())
    }
}

/// The tables of a stack, in double precision.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tables<const C: usize> {
    /// The share of light that gets to a diffuse base; none where the closed form of a smooth coat holds.
    pub(super) transmitted: Option<Curve<C>>,
    /// The share of Lambertian light from the base that returns to it.
    pub(super) internal: [f64; C],
    /// What the base reflects of Lambertian light.
    pub(super) base: [f64; C],
    /// What is left to fit to the walk; none where one interface is all there is.
    pub(super) closure: Option<Closure<C>>,
    pub(super) build_time: Duration,
}

/// The factor of the lower layers for each direction, and the albedo that is missing.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Closure<const C: usize> {
    pub(super) scale: Curve<C>,
    pub(super) missing: Curve<C>,
    /// 1/(π·mean of `missing`), 0 where nothing is missing.
    pub(super) inverse: [f64; C],
}

/// The effective interfaces: those between media that differ, and the base.
fn effective<const C: usize>(layers: &[Layer<f64, C>]) -> Vec<usize> {
    let mut n_above = 1.0;
    let mut found = Vec::new();
    for (position, layer) in layers.iter().enumerate() {
        match &layer.interface {
            Interface::Microfacet { n, k, .. } => {
                if !super::coupled::matched(n[0], n_above) || k.iter().any(|k| *k != 0.0) {
                    found.push(position);
                }
                n_above = n[0];
            }
            Interface::Diffuse { .. } => found.push(position),
        }
    }
    found
}

impl<const C: usize> Tables<C> {
    /// The tables of layers as written, which the walk follows, for the model of the `seen` ones, whose widths differ.
    pub(super) fn build(written: &[Layer<f64, C>], seen: &[Layer<f64, C>]) -> Self {
        let start = Instant::now();
        let mut tables =
            Tables { transmitted: None, internal: [0.0; C], base: [0.0; C], closure: None, build_time: Duration::ZERO };
        let met = effective(written);
        // The walk ignores the model; this one keeps the stack from asking for tables.
        if let (true, Ok(stack)) = (met.len() > 1, Stack::new(Model::Conserving, written.to_vec())) {
            // A Lambert base under one interface is exact as it is.
            let mut exact = false;
            if let Some(Layer { interface: Interface::Diffuse { albedo, sigma }, .. }) = written.last() {
                tables.base = base_albedo(albedo, *sigma);
                tables.couple(&stack, &met);
                exact = *sigma == 0.0 && met.len() == 2;
            }
            if !exact {
                tables.close(&stack, seen);
            }
        }
        tables.build_time = start.elapsed();
        tables
    }

    /// What a coat does to a diffuse base.
    fn couple(&mut self, stack: &Stack<f64, C>, met: &[usize]) {
        let layers = stack.layers();
        if let [coat, _] = *met
            && let Interface::Microfacet { n, k, alpha } = &layers[coat].interface
            && *alpha <= SMOOTH
        {
            self.internal = core::array::from_fn(|c| {
                let below = &layers[coat..layers.len() - 1];
                let depth = below.iter().map(|layer| layer.medium.sigma[c] * layer.medium.thickness).sum();
                internal_reflectance(n[c], k[c], depth).clamp(0.0, ENDLESS)
            });
            return;
        }
        let raw: Vec<_> =
            (0..NODES).map(|i| walk::arrived(stack, view(Curve::<C>::cosine(i)), &options(0x636f_6174, i))).collect();
        // No fit: that a walk may not be reflected at the top has taken most of the noise already.
        self.transmitted = Some(Curve::from_nodes(|i, _| raw[i].mean.map(|share| share.clamp(0.0, 1.0))));
        let options = Options { samples: 32 * WALKS, ..options(0x6261_7365, 0) };
        let returned = walk::returned(stack, &options).mean;
        // What leaves by reciprocity cannot return: the mean of E_T over n² bounds r_i, and is known better.
        let leaves = self.transmitted.as_ref().map_or([0.0; C], Curve::mean);
        let n_base = |c: usize| {
            layers.iter().rev().find_map(|layer| match &layer.interface {
                Interface::Microfacet { n, .. } => Some(n[c]),
                Interface::Diffuse { .. } => None,
            })
        };
        self.internal = core::array::from_fn(|c| {
            let n = n_base(c).unwrap_or(1.0);
            returned[c].min(1.0 - leaves[c] / (n * n)).clamp(0.0, ENDLESS)
        });
    }

    /// Fits the albedo of what lies under the top interface to the walk's.
    fn close(&mut self, stack: &Stack<f64, C>, seen: &[Layer<f64, C>]) {
        let nodes: Vec<Node<C>> = (0..NODES).map(|i| Node::integrate(seen, self, i)).collect();
        let raw: Vec<_> = (0..NODES)
            .map(|i| walk::lower_albedo(stack, view(Curve::<C>::cosine(i)), &options(0x7761_6c6b, i)))
            .collect();
        let ones = Curve::from_nodes(|_, _| [1.0; C]);
        let plain: Vec<[f64; C]> = (0..NODES).map(|i| nodes[i].lower_albedo(&ones, i)).collect();
        let fitted: Vec<[f64; C]> = fit(|i, c| (raw[i].mean[c] - plain[i][c], raw[i].standard_error[c]));
        let target =
            |i: usize, c: usize| (plain[i][c] + fitted[i][c]).clamp(0.0, (1.0 - MARGIN - nodes[i].top[c]).max(0.0));

        let most = if reflects_totally(stack.layers()) { 1.0 } else { LIFT };
        let mut scale = ones;
        for _ in 0..ROUNDS {
            let next = Curve::from_nodes(|i, _| {
                let have = nodes[i].lower_albedo(&scale, i);
                core::array::from_fn(|c| {
                    let (plain, target) = (plain[i][c], target(i, c));
                    let wanted = if target > plain { plain + LOBES * (target - plain) } else { target };
                    let ratio = if have[c] > 0.0 { (wanted / have[c]).sqrt() } else { 1.0 };
                    (scale.0[i][c] * ratio).min(most)
                })
            });
            scale = next;
        }
        let missing = Curve::from_nodes(|i, _| {
            let have = nodes[i].lower_albedo(&scale, i);
            core::array::from_fn(|c| (target(i, c) - have[c]).max(0.0))
        });
        let inverse = missing.mean().map(|mean| if mean > 1e-9 { FRAC_1_PI / mean } else { 0.0 });
        self.closure = Some(Closure { scale, missing, inverse });
    }

    /// What the bounces between the base and its coat add to once its albedo: ρ²r_i/(1 − ρ·r_i), as an albedo.
    #[inline]
    pub(super) fn series(&self, channel: usize) -> f64 {
        let (r, rho) = (self.internal[channel], self.base[channel]);
        rho * rho * r / (1.0 - rho * r)
    }

    /// What the tables hold, on the heap and off it.
    pub(super) fn bytes(&self) -> usize {
        let curves = self.transmitted.iter().chain(self.closure.iter().flat_map(|c| [&c.scale, &c.missing]));
        size_of::<Self>() + curves.map(Curve::bytes).sum::<usize>()
    }
}

/// True where light passes into a medium of a smaller index. There the albedo of what lies below ends at the critical
/// angle, which falls between nodes; no factor above 1 is to be interpolated across it.
fn reflects_totally<const C: usize>(layers: &[Layer<f64, C>]) -> bool {
    let mut n_above = [1.0; C];
    let passed = &layers[..layers.len().saturating_sub(1)];
    passed.iter().any(|layer| match &layer.interface {
        Interface::Microfacet { n, .. } => {
            let thinner = n.iter().zip(n_above).any(|(n, n_above)| *n < n_above);
            n_above = *n;
            thinner
        }
        Interface::Diffuse { .. } => false,
    })
}

/// The walks of a node. The fit smooths the middle by a factor of two and the ends not at all: the normal, which most
/// light sees, gets more of them, and grazing, which next to none does, fewer.
fn options(seed: u32, node: usize) -> Options {
    let samples = match node {
        0..4 => WALKS / 4,
        30.. => WALKS * 4,
        _ => WALKS,
    };
    Options { samples, seed: seed + node as u32, ..Options::default() }
}

fn view(cos: f64) -> Vector<f64> {
    Vector::new(((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt(), 0.0, cos)
}

/// The share of Lambertian light under a smooth interface that it sends back, through a medium of optical depth `tau`.
///
/// $$r_i(\tau) = 2\int_0^1 R(\mu)\,e^{-2\tau/\mu}\,\mu\,d\mu$$
///
/// In plain text: r_i = 2∫ R(μ)·exp(−2τ/μ)·μ dμ, R the Fresnel reflectance seen from below.
///
/// `n` > 0, `k` ≥ 0: the interface's index relative to the medium above it. `tau` = σ·d ≥ 0. 0 at n = 1, κ = 0, or
/// τ → ∞. At n = 1.5: .59635 for τ = 0, .382 for .1, .258 for .2, .090 for .5. Error ≤ 1e-6.
///
/// Source: Saunderson 1942 (k₂); at τ = 0 it is 1 − (1−F̄)/n² (Egan & Hilgeman 1979).
pub fn internal_reflectance(n: f64, k: f64, tau: f64) -> f64 {
    let at = |mu: f64| {
        let f = if k == 0.0 { fresnel::dielectric(mu, 1.0 / n) } else { fresnel::conductor(cos_t(mu, 1.0 / n), n, k) };
        f.reflectance * (-2.0 * tau / mu).exp() * mu
    };
    // Split at the critical angle, where R has a root: u² as the distance to it.
    let critical = (1.0 - 1.0 / (n * n)).max(0.0).sqrt();
    let midpoints = |f: &dyn Fn(f64) -> f64| (0..2000).map(|i| f((f64::from(i) + 0.5) / 2000.0)).sum::<f64>() / 2000.0;
    // There is nothing below it, and 0/0, where the indices match.
    let below = if critical > 0.0 { midpoints(&|u| at(critical * u) * critical) } else { 0.0 };
    let above = midpoints(&|u| at(critical + (1.0 - critical) * u * u) * 2.0 * u * (1.0 - critical));
    2.0 * (below + above)
}

/// What an Oren–Nayar base reflects of Lambertian light, by midpoints in both squared sines and the azimuth.
fn base_albedo<const C: usize>(albedo: &[f64; C], sigma: f64) -> [f64; C] {
    if sigma == 0.0 {
        return *albedo;
    }
    const N: usize = 24;
    let at = |i: usize| ((i as f64 + 0.5) / N as f64).sqrt();
    let mut sum = [0.0; C];
    for i in 0..N * N * N {
        let (wi, cos) = (view(at(i % N)), at(i / N % N));
        let (sin, phi) = ((1.0 - cos * cos).sqrt(), PI * ((i / N / N) as f64 + 0.5) / N as f64);
        let base = diffuse::oren_nayar(wi, Vector::new(sin * phi.cos(), sin * phi.sin(), cos), sigma);
        for c in 0..C {
            sum[c] += PI * base.f(albedo[c]) / (N * N * N) as f64;
        }
    }
    sum.map(|rho| rho.min(1.0))
}

/// The model's f around one direction, ready to be summed.
struct Node<const C: usize> {
    /// The albedo of the top interface.
    top: [f64; C],
    /// The cosine of the other direction, and f·cos/pdf of the lower layers there.
    lower: Vec<(f64, [f64; C])>,
}

impl<const C: usize> Node<C> {
    fn integrate(layers: &[Layer<f64, C>], tables: &Tables<C>, node: usize) -> Self {
        let wo = view(Curve::<C>::cosine(node));
        // Every interface under the index of what is above it; the directions of a middle channel serve all.
        let mut n_above = 1.0;
        let mut lobes = Vec::new();
        for layer in layers {
            if let Interface::Microfacet { n, alpha, .. } = &layer.interface {
                lobes.push((n_above, *alpha));
                n_above = n[C / 2];
            }
        }
        let density = |wi: Vector<f64>| {
            let of = |&(n, alpha): &(f64, f64)| {
                let (a, b) = (refract(wo, n), refract(wi, n));
                if a.z <= 0.0 || b.z <= 0.0 {
                    return 0.0;
                }
                walk::reflection(a, b, alpha).density * wi.z / (n * n * b.z)
            };
            wi.z * FRAC_1_PI + lobes.iter().map(of).sum::<f64>()
        };
        let mut found = Node { top: [0.0; C], lower: Vec::new() };
        for i in 0..POINTS {
            // The root of x⁴ = x + 1, shifted from node to node (Roberts 2018).
            const G: f64 = 1.220_744_084_605_759_6;
            let u =
                [1, 2, 3].map(|axis| (0.5 + (i + 1) as f64 / G.powi(axis) + node as f64 * 0.618_033_988_75).fract());
            for lobe in 0..=lobes.len() {
                let wi = match lobes.get(lobe) {
                    None => {
                        let ((x, y), radius) = (u[1].unit_circle(), u[0].sqrt());
                        Vector::new(radius * x, radius * y, (1.0 - u[0]).sqrt())
                    }
                    Some(&(n, alpha)) => {
                        let a = refract(wo, n);
                        if a.z <= 0.0 {
                            continue;
                        }
                        let b = walk::reflected(a, walk::visible_normal(a, alpha, u));
                        if b.z <= 0.0 { continue } else { refract(b, 1.0 / n) }
                    }
                };
                if wi.z <= 0.0 {
                    continue;
                }
                let weight = wi.z / (density(wi) * POINTS as f64);
                let (top, lower) = super::coupled::parts(layers, tables, wi, wo);
                for (sum, top) in found.top.iter_mut().zip(top) {
                    *sum += top * weight;
                }
                found.lower.push((wi.z, lower.map(|f| f * weight)));
            }
        }
        found
    }

    /// The albedo of the lower layers, scaled by a factor of each direction; this one is that of node `i`.
    fn lower_albedo(&self, scale: &Curve<C>, i: usize) -> [f64; C] {
        let mut sum = [0.0; C];
        for (cos, lower) in &self.lower {
            let there = scale.at(*cos);
            for c in 0..C {
                sum[c] += lower[c] * there[c];
            }
        }
        core::array::from_fn(|c| scale.0[i][c] * sum[c])
    }
}

/// The weighted least-squares polynomial in √μ through noisy nodes, at the nodes: value and standard error of each.
fn fit<const C: usize>(noisy: impl Fn(usize, usize) -> (f64, f64)) -> Vec<[f64; C]> {
    let basis = |i: usize| {
        let x = 2.0 * i as f64 / (NODES - 1) as f64 - 1.0;
        let mut p = [1.0; TERMS];
        p[1] = x;
        for k in 2..TERMS {
            let k_ = k as f64;
            p[k] = ((2.0 * k_ - 1.0) * x * p[k - 1] - (k_ - 1.0) * p[k - 2]) / k_;
        }
        p
    };
    let mut fitted = vec![[0.0; C]; NODES];
    for c in 0..C {
        // Normal equations, the right-hand side as the last column. Grazing nodes know their values best, and matter
        // least: the floor keeps them from ruling the others.
        let mut rows = [[0.0; TERMS + 1]; TERMS];
        for i in 0..NODES {
            let ((value, error), p) = (noisy(i, c), basis(i));
            let weight = 1.0 / (error * error + 4e-6);
            for (row, pr) in rows.iter_mut().zip(p) {
                for (entry, pc) in row.iter_mut().zip(p.into_iter().chain([value])) {
                    *entry += weight * pr * pc;
                }
            }
        }
        // Positive definite: elimination needs no pivots.
        for pivot in 0..TERMS {
            let top = rows[pivot];
            for (r, row) in rows.iter_mut().enumerate() {
                if r != pivot {
                    let factor = row[pivot] / top[pivot];
                    row.iter_mut().zip(top).for_each(|(entry, top)| *entry -= factor * top);
                }
            }
        }
        for (i, fitted) in fitted.iter_mut().enumerate() {
            fitted[c] = basis(i).into_iter().enumerate().map(|(k, p)| p * rows[k][TERMS] / rows[k][k]).sum();
        }
    }
    fitted
}
