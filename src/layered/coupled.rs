//! The model that adds the light which bounces between interfaces, from tables that are built once per stack.
//!
//! [`conserving`](super::conserving) follows each path once down and once up. What it leaves out is here, in three parts:
//!
//! * over a diffuse base, the series of bounces between the base and its coat: exact for a Lambert base under any coat,
//! * for each interface under another, the series of mirror reflections between the two,
//! * for the rest a factor s(L)·s(V) of the lower layers and a term of the shape of Kulla & Conty 2017, which together
//!   bring the directional albedo to that of the [walk](crate::walk). Where light is missing the factor makes up 85 % of
//!   it and the term the rest; where the model reflects too much, the factor is below 1.
//!
//! Both corrections are products of a function of each direction: the model is reciprocal to rounding and nowhere negative.
//! Twin: `coupled` in `wgsl/layered.wgsl`, which reads the tables as [`Coupled::buffer_rows`] lays them out.

use super::model::{disperses, interface_fresnel};
use super::tables::Tables;
use super::{Interface, Layer, Model, Stack};
use crate::absorption;
use crate::diffuse;
use crate::frame::Vector;
use crate::fresnel::Fresnel;
use crate::microfacet::{cos_half, facets};
use crate::real::{Mask, Real};
use crate::refraction::{cos_t, refract};
use core::time::Duration;
use std::sync::{Arc, OnceLock};
use std::vec::Vec;

/// Tables that are built when first asked for, and shared by all copies of a stack in whatever precision.
#[derive(Clone, Debug, Default)]
pub(super) struct Lazy<const C: usize>(Arc<OnceLock<Tables<C>>>);

impl<const C: usize> Lazy<C> {
    /// The tables of layers as written, which are `seen` by the model.
    pub(super) fn get<R: Real>(&self, written: &[Layer<R, C>], seen: &[Layer<R, C>]) -> &Tables<C> {
        self.0.get_or_init(|| {
            let [written, seen] = [written, seen].map(|layers| layers.iter().map(Layer::cast).collect::<Vec<_>>());
            Tables::build(&written, &seen)
        })
    }
}

/// A stack prepared for the coupled model: [`Model::Coupled`] with its cost in sight.
///
/// # Cost
///
/// Built once per stack, when first evaluated or here, and shared by its copies, in whatever precision. Single interfaces
/// and Lambert bases under a smooth coat (α ≤ .02) cost less than a millisecond and 160 bytes at three channels. Otherwise
/// up to a million walks: .3 to .5 s on two cores for two interfaces, 1.5 s for three or where the top one disperses; and
/// 64·C numbers, 1.7 kB at three channels, half as much more over an Oren–Nayar base. [`Coupled::build_time`] and
/// [`Coupled::bytes`] say it of a given stack. An evaluation then costs four look-ups more than the conserving model.
///
/// # Error
///
/// Against the walk's directional albedo, 0–80° (`tests/coupled.rs`): within .5 % for a Lambert base of .5 under n = 1.5,
/// α = .1 and .3, and within .6 % for copper, α₁/α₂ = .1/.1, .1/.3, .3/.1 (measured at most .4 % with standard errors of
/// .1 %). The albedo is ≤ 1 on every built-in stack. Over a white Lambert base under a
/// coat that counts as smooth it reaches 1.0011, at 83–86° and n = 1.001 to 1.01 with α = .02, whose true lobe reflects more
/// than the smooth coat does not transmit (`tests/adversary`).
///
/// Single pairs of directions are further off: what widens a lobe under a rough coat is only known at normal incidence
/// ([`Widths::Variance`](super::Widths::Variance)). Root mean square over a fixed set of lit pairs (f ≥ .02 sr⁻¹), and the
/// worst pair, from `brdf bench layered`, by itself and with `examples/stacks/*.toml`: under 1 % for coats over diffuse bases
/// and 1 to 4 % for the built-in metals and oxides, worst −23 %, against 4 to 40 % of `conserving`; but 16 and 20 % for copper
/// under n = 1.5 with α₁/α₂ = .1/.1 and .3/.1, worst −66 and −64 %, beside the lobe and at 60–75°, 31 %, worst −100 %, for
/// .4/.05; and 88 %, worst +181 %, for `coated_gold`, whose lobe of α = .002 is a hundred times as bright as what surrounds it.
///
/// Under a coat of n < 1 the tables do not resolve the critical angle: over a mirror without loss the albedo reaches 1.14
/// just inside it for n = .7, α = .1, and 1.24 for n = .33, α = .42.
///
/// A base that gains energy by itself (Oren–Nayar, ρ near 1) keeps doing so where there is no coat.
///
/// # Example
///
/// ```
/// use brdf::layered::{Coupled, Interface, Layer, Model, Stack};
/// use brdf::Vector;
///
/// let coat = Layer::new(Interface::dielectric(1.5, 0.01));
/// let base = Layer::new(Interface::diffuse([0.5], 0.0));
/// let stack = Stack::<f64, 1>::new(Model::Coupled, vec![coat, base])?;
/// let coupled = Coupled::new(&stack);
/// let (wi, wo) = (Vector::from_angles(0.3, 0.0), Vector::from_angles(0.8, 2.0));
/// assert_eq!(coupled.evaluate(wi, wo), stack.evaluate(wi, wo));
/// assert!((coupled.internal_reflectance()[0] - 0.59635).abs() < 1e-5);
/// # Ok::<(), brdf::layered::StackError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Coupled<R, const C: usize> {
    stack: Stack<R, C>,
}

impl<R: Real, const C: usize> Coupled<R, C> {
    /// The tables of a stack, built now unless the stack or a copy of it has them already. Its model is ignored.
    pub fn new(stack: &Stack<R, C>) -> Self {
        let stack = stack.clone().with_model(Model::Coupled);
        stack.tables().get(stack.layers(), stack.effective_layers());
        Coupled { stack }
    }

    /// The BRDF in sr⁻¹ for a pair of local unit directions, a value for each channel.
    ///
    /// `wi` points towards the light, `wo` towards the viewer. 0 where either is at or below the horizon. Symmetric in
    /// the two but for rounding; ≥ 0.
    #[inline]
    pub fn evaluate(&self, wi: impl Into<Vector<R>>, wo: impl Into<Vector<R>>) -> [R; C] {
        evaluate(self.stack.effective_layers(), self.tables(), wi.into(), wo.into())
    }

    /// The size of the tables in bytes.
    pub fn bytes(&self) -> usize {
        self.tables().bytes()
    }

    /// How long the tables took to build.
    pub fn build_time(&self) -> Duration {
        self.tables().build_time
    }

    /// r_i of each channel: the share of Lambertian light from a diffuse base that its coats send back. 0 without such a
    /// base, or without a coat.
    pub fn internal_reflectance(&self) -> [f64; C] {
        self.tables().internal
    }

    pub(super) fn tables(&self) -> &Tables<C> {
        self.stack.tables().get(self.stack.layers(), self.stack.effective_layers())
    }
}

impl<R: Real, const C: usize> Stack<R, C> {
    /// What the bounces between a diffuse base and its coats add to once its albedo, whatever the model; 0 without a base. Builds the tables.
    pub(crate) fn bounced(&self) -> [f64; C] {
        match self.layers() {
            [_, .., Layer { interface: Interface::Diffuse { .. }, .. }] => {
                let tables = self.tables().get(self.layers(), self.effective_layers());
                core::array::from_fn(|c| tables.series(c))
            }
            _ => [0.0; C],
        }
    }
}

/// The coupled model of layers whose tables are given.
///
/// $$f = f_1 + s(L)\,s(V)\,(f_{2\dots}) + \frac{m(L)\,m(V)}{\pi\,\bar m},\quad \bar m = 2\int_0^1 m\,\mu\,d\mu$$
///
/// In plain text: f = f1 + s(L)·s(V)·(lower layers) + m(L)·m(V)/(π·mean of m), with s in [0, 3]
/// and m ≥ 0; m is 0 where s ≤ 1.
#[inline]
pub(super) fn evaluate<R: Real, const C: usize>(
    layers: &[Layer<R, C>],
    tables: &Tables<C>,
    wi: Vector<R>,
    wo: Vector<R>,
) -> [R; C] {
    let (mut f, lower) = parts(layers, tables, wi, wo);
    if !(wi.z.gt(R::ZERO) & wo.z.gt(R::ZERO)).any() {
        return f;
    }
    if let Some(closure) = &tables.closure {
        let (scale_i, scale_o) = (closure.scale.at(wi.z), closure.scale.at(wo.z));
        let (missing_i, missing_o) = (closure.missing.at(wi.z), closure.missing.at(wo.z));
        for c in 0..C {
            let missing = missing_i[c] * missing_o[c] * R::from_f64(closure.inverse[c]);
            f[c] = f[c] + lower[c] * (scale_i[c] * scale_o[c]) + missing;
        }
    } else {
        for (f, lower) in f.iter_mut().zip(lower) {
            *f = *f + lower;
        }
    }
    f
}

/// What the first interface reflects, and what the layers under it add, before the fit to the walk.
#[inline]
pub(super) fn parts<R: Real, const C: usize>(
    layers: &[Layer<R, C>],
    tables: &Tables<C>,
    wi: Vector<R>,
    wo: Vector<R>,
) -> ([R; C], [R; C]) {
    if disperses(layers) {
        let (mut top, mut lower) = ([R::ZERO; C], [R::ZERO; C]);
        for channel in 0..C {
            ([top[channel]], [lower[channel]]) = recurse::<R, C, 1>(layers, tables, channel, wi, wo);
        }
        (top, lower)
    } else {
        recurse::<R, C, C>(layers, tables, 0, wi, wo)
    }
}

/// Whether two indices differ too little to reflect anything; the walk leaves such interfaces out too.
pub(super) fn matched(n: f64, n_above: f64) -> bool {
    (n / n_above - 1.0).abs() < 1e-7
}

/// The interface above one: its relative indices n and κ, the ratio that directions refract by, and what the medium
/// between the two lets through.
type Mirror<R, const K: usize> = ([(R, R); K], R, [R; K]);

/// [`parts`] of `K` channels from `first` on, which share one pair of directions.
#[inline]
fn recurse<R: Real, const C: usize, const K: usize>(
    layers: &[Layer<R, C>],
    tables: &Tables<C>,
    first: usize,
    wi: Vector<R>,
    wo: Vector<R>,
) -> ([R; K], [R; K]) {
    let (mut top, mut lower) = ([R::ZERO; K], [R::ZERO; K]);
    let (outer_i, outer_o) = (wi.z, wo.z);
    let mut weight = [R::ONE; K];
    let mut above: Option<Mirror<R, K>> = None;
    let (mut wi, mut wo, mut n_above) = (wi, wo, R::ONE);
    let mut entered = false;
    for (position, layer) in layers.iter().enumerate() {
        let (n, k, alpha) = match &layer.interface {
            Interface::Microfacet { n, k, alpha } => (n, k, *alpha),
            Interface::Diffuse { albedo, sigma } => {
                let flat = *sigma == R::ZERO;
                let lit = wi.z.gt(R::ZERO) & wo.z.gt(R::ZERO);
                let base = diffuse::oren_nayar(wi, wo, *sigma);
                let curve = tables.transmitted.as_ref().filter(|_| (outer_i.gt(R::ZERO) & outer_o.gt(R::ZERO)).any());
                let through = curve.map(|curve| (curve.at(outer_i), curve.at(outer_o)));
                let compression = R::ONE / (n_above * n_above);
                for c in 0..K {
                    let once = if flat {
                        R::select(lit, albedo[first + c] * R::FRAC_1_PI, R::ZERO)
                    } else {
                        base.f(albedo[first + c])
                    };
                    let again = R::select(lit, R::from_f64(tables.series(first + c)) * R::FRAC_1_PI, R::ZERO);
                    let weight = match &through {
                        Some((i, o)) => i[first + c] * o[first + c] * compression,
                        None => weight[c],
                    };
                    let sum = if entered { &mut lower[c] } else { &mut top[c] };
                    *sum = *sum + weight * (once + again);
                }
                return (top, lower);
            }
        };
        let shared = facets(wi, wo, alpha);
        let cos_h = cos_half(wi, wo);
        let last = position + 1 == layers.len();
        let eta = n[first] / n_above;
        let (below_i, below_o) = (refract(wi, eta), refract(wo, eta));
        let mut indices = [(R::ONE, R::ZERO); K];
        let mut depths = [R::ONE; K];
        for c in 0..K {
            let (n, k) = (n[first + c] / n_above, k[first + c] / n_above);
            indices[c] = (n, k);
            let fresnel = interface_fresnel(cos_h, n, k);
            let mut reflected = fresnel.reflectance * shared.lobe;
            if let Some((upper, eta, absorbed)) = &above {
                let back = from_below(cos_h, upper[c], *eta).reflectance;
                let rest = R::ONE - back * fresnel.reflectance * absorbed[c];
                // Only total reflection between two perfect mirrors without absorption has no end, and no light in it.
                reflected = R::select(rest.gt(R::ZERO), reflected / R::select(rest.gt(R::ZERO), rest, R::ONE), R::ZERO);
            }
            let sum = if entered { &mut lower[c] } else { &mut top[c] };
            *sum = *sum + weight[c] * reflected;
            if !last {
                let sigma = layer.medium.sigma[first + c];
                depths[c] = absorption::transmittance(sigma, layer.medium.thickness, below_i.z, below_o.z);
                let through = interface_fresnel(wi.z, n, k).transmittance * interface_fresnel(wo.z, n, k).transmittance;
                weight[c] = weight[c] * through / (eta * eta) * depths[c];
            }
        }
        let least = below_i.z.min(below_o.z).min(wi.z).min(wo.z);
        if last || least.le(R::ZERO).all() {
            return (top, lower);
        }
        let passed = matched(n[first].to_f64(), n_above.to_f64()) && k.iter().all(|k| *k == R::ZERO);
        if passed && let Some((.., absorbed)) = &mut above {
            // The mirror is still the interface above this one.
            *absorbed = core::array::from_fn(|c| absorbed[c] * depths[c]);
        } else if !passed {
            entered = true;
            above = Some((indices, eta, depths));
        }
        (wi, wo, n_above) = (below_i, below_o, n[first]);
    }
    (top, lower)
}

/// The Fresnel terms of an interface met from below: those of the refracted ray.
#[inline(always)]
fn from_below<R: Real>(cos: R, (n, k): (R, R), eta: R) -> Fresnel<R> {
    interface_fresnel(cos_t(cos, R::ONE / eta), n, k)
}
