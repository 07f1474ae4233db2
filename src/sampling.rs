//! Directions drawn for the BRDF of a stack, and the density that they are drawn with.
//!
//! Twin: `wgsl/sampling.wgsl`. A path tracer that is at `wo` asks [`Stack::sample`] where to go next, weighs what it finds
//! there by f·cos/pdf, and asks [`Stack::pdf`] for the density of directions that it has from elsewhere (a light).
//!
//! ```
//! use brdf::{Vector, material};
//!
//! let stack = material::stack::by_name("clear_coat_over_copper").unwrap();
//! let wo = Vector::from_angles(0.5, 0.0);
//! if let Some(sample) = stack.sample(wo, [0.3, 0.6, 0.1]) {
//!     let weight = stack.evaluate(sample.wi, wo).map(|f| f * sample.wi.z / sample.pdf);
//!     assert!(weight.iter().all(|w| *w < 1.0));
//!     assert_eq!(sample.pdf, stack.pdf(sample.wi, wo));
//! }
//! ```
//!
//! # The mixture
//!
//! One interface is chosen, then a direction that it reflects to. At interface k the view direction is V_k, refracted down
//! to it. A microfacet interface draws one of its normals that V_k sees, reflects V_k about it, and refracts the
//! result up ([`reflect_visible`]); a diffuse base draws from the cosine, at the top, which *is* the cosine in
//! the base's own medium restricted to what leaves it: both are uniform in the tangential part of n·ω. With
//! s = sinθ₀ = n_k·sinθ_k, the tangential part s is kept up to the factor n_k and dω = s ds dφ/cosθ, so that
//!
//! $$n_0^2\cos\theta_0\,d\omega_0 = n_k^2\cos\theta_k\,d\omega_k,\qquad p(\omega_0) = p_k(\omega_k)\,\frac{\cos\theta_0}{n_k^2\cos\theta_k}$$
//!
//! In plain text: p(ω₀) = p_k(ω_k)·cosθ₀/(n_k²·cosθ_k), n₀ = 1. What is reflected below the horizon of its medium, or totally on its
//! way up, is no sample: there f is 0 and the density integrates to less than 1 by as much.
//!
//! # The weights, and the bound that they give
//!
//! Interface k is chosen with the probability ¾·e_k/Σe + ¼·s_k/Σs. The estimate e_k is what the interface reflects of
//! the view if light came along the mirror direction: F_k(V_k)·Π T_j(V_j)²·a_j(V_j)², or the albedo of a base, a 1/n² of
//! it. The safe weight s_k is what no direction of light can exceed, as the Fresnel terms are largest at one end of the angles
//! that the view allows, and no light loses less than one that comes along the normal. The documents' models keep their own books:
//! their transmittances are those at V·H, at most 1, and nothing is compressed (n_k² more). `weidlich_wilkie` refracts about the
//! facet and keeps its half vector, so its lobes are sampled at the top. Each takes the largest of the channels; where
//! an interface that light passes disperses, each channel has lobes of its own, and all of them share one mixture.
//!
//! Under a coat a rough lobe loses samples to total reflection. As many as that, if the lobe is wide enough for it to help, are drawn
//! from the cosine outside: at 45° the standard deviation of copper of α = 1 under a coat of α = 1 falls from 2.1 to 0.9 of the mean.
//!
//! Hence [`WEIGHT_BOUND`]: every channel of f·cos/pdf is below [`ceiling`] times it. A diffuse base of σ > 0 reflects without
//! bound towards a grazing view, as 1/cos; a part of its samples is drawn uniformly from the hemisphere to meet that.
//! `tests/sampling.rs` measures the weights, and compares samples with their density by χ² tests.
//!
//! Source of the visible normals: Heitz & d'Eon 2014, "Importance sampling microfacet-based BSDFs using the
//! distribution of visible normals", §4 (V-cavities).

use crate::absorption;
use crate::distribution;
use crate::frame::{Vector, half_vector};
use crate::fresnel;
use crate::layered::model::{disperses, interface_fresnel};
use crate::layered::{Interface, Layer, Model, Stack};
use crate::real::{Mask, Real};
use crate::refraction::refract;

mod view;
pub use view::{View, Views};

/// The share of the mixture that follows the safe weights: 1/4. More of it lowers the bound, and costs variance.
const SAFE_SHARE: f64 = 0.25;

/// The largest f·cos/pdf, as a multiple of [`ceiling`]: 4/¼ = 16.
///
/// ¼ of the mixture follows the safe weights. Within its lobe a facet's weight is F·G/G₁ ≤ F, at most twice the larger end of the Fresnel
/// terms: between two ends in which the reflectance of p-polarised light has dipped, F ≤ F_s, which only rises with the angle, and
/// F ≥ F_s/2 at its end (1.94 is met for dielectrics of a large index, 1.32 up to n = 8). At most half of a lobe's samples go to the cosine
/// instead: 4. An Oren–Nayar base exceeds its albedo by up to 2 (both directions at grazing). The module's tests scan both, indices over
/// all that [`N_RANGE`](crate::layered::N_RANGE) and [`K_RANGE`](crate::layered::K_RANGE) make relative to one another.
/// For `weidlich_wilkie`, whose refracted directions may graze where those outside do not, it is measured, not derived.
pub const WEIGHT_BOUND: f64 = 4.0 / SAFE_SHARE;

/// A direction drawn for a view, and its density.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sample<R> {
    /// The direction towards the light, local and unit.
    pub wi: Vector<R>,
    /// The density of `wi` in sr⁻¹, over all ways in which it can be drawn; > 0.
    pub pdf: R,
}

impl<R: Real, const C: usize> Stack<R, C> {
    /// A direction `wi` for a view, drawn about in proportion to f·cos, and its density.
    ///
    /// `wo` is a local unit direction, `u` three independent numbers in [0, 1), clamped there. None where `wo` is at or below the
    /// horizon, and where the numbers lead to no direction: into the surface, or to light that never leaves it. Such a
    /// sample counts as 0. See [`sample`].
    #[inline]
    pub fn sample(&self, wo: impl Into<Vector<R>>, u: [R; 3]) -> Option<Sample<R>> {
        sample(self.effective_layers(), self.model(), wo.into(), u)
    }

    /// The density in sr⁻¹ with which [`Stack::sample`] draws `wi` for the view `wo`.
    ///
    /// 0 where either is at or below the horizon. See [`pdf`].
    #[inline]
    pub fn pdf(&self, wi: impl Into<Vector<R>>, wo: impl Into<Vector<R>>) -> R {
        pdf(self.effective_layers(), self.model(), wi.into(), wo.into())
    }
}

/// The share of samples that a stack draws from the cosine, whatever its layers: a quarter under `coupled` and `walk`, which
/// reflect into every direction; none under the closed forms, whose lobes cover all that they reflect.
fn cosine_share(model: Model) -> f64 {
    match model {
        #[cfg(feature = "std")]
        Model::Coupled | Model::Walk => 0.25,
        _ => 0.0,
    }
}

/// A direction `wi` for a view of a stack, drawn about in proportion to f·cos, and its density.
///
/// * `layers` from the top; `model` that evaluates them.
/// * `wo`: a local unit vector. `u`: three independent numbers, uniform in [0, 1). The first chooses the interface, and is
///   used up to its last digits.
///
/// None where `wo.z` ≤ 0 or the sample is lost (see the [module](self)). The density is [`pdf`] of the direction returned.
/// Error of the density in f32: as the BRDF's own. Source: the [module](self).
#[inline]
pub fn sample<R: Real, const C: usize>(
    layers: &[Layer<R, C>],
    model: Model,
    wo: Vector<R>,
    u: [R; 3],
) -> Option<Sample<R>> {
    let drawn = draw(layers, model, wo, u);
    drawn.pdf.gt(R::ZERO).all().then_some(drawn)
}

/// The density in sr⁻¹ with which [`sample`] draws `wi` for the view `wo`.
///
/// $$p = \sum_k\left(\tfrac34\frac{e_k}{\sum e}+\tfrac14\frac{s_k}{\sum s}\right)p_k(L_k,V_k)\,\frac{\cos\theta_i}{n_k^2\,L_{k,z}}$$
///
/// In plain text: the sum over interfaces of (¾·e_k/Σe + ¼·s_k/Σs)·p_k(L_k, V_k)·cos_i/(n_k²·L_k.z).
///
/// The integral over `wi` is ≤ 1. 0 where a cosine is ≤ 0; finite elsewhere. Not reciprocal.
#[inline]
pub fn pdf<R: Real, const C: usize>(layers: &[Layer<R, C>], model: Model, wi: Vector<R>, wo: Vector<R>) -> R {
    let lit = wi.z.gt(R::ZERO) & wo.z.gt(R::ZERO);
    if !lit.any() {
        return R::ZERO;
    }
    let (mut total, mut density) = (Weights::none(), Weights::none());
    visit(layers, model, wo, |lobe| {
        let p = lobe.density(wi);
        total = total.plus(lobe.weights, R::ONE);
        density = density.plus(lobe.weights, p);
    });
    let (lobes, share) = (total.share(density), cosine_share(model));
    let mixed =
        if share > 0.0 { wi.z * R::FRAC_1_PI * R::from_f64(share) + lobes * R::from_f64(1.0 - share) } else { lobes };
    R::select(lit, mixed, R::ZERO)
}

/// What f·cos/pdf is bounded by, up to the factor [`WEIGHT_BOUND`]: Σs of the view `wo`, at most 1 for each interface (n²
/// for `elek`) and, where channels disperse, for each channel. For [`Model::CLOSED_FORM`]; under `coupled` no bound is
/// derived, and this is what [`Model::Conserving`] has.
pub fn ceiling<R: Real, const C: usize>(layers: &[Layer<R, C>], model: Model, wo: Vector<R>) -> R {
    let mut total = Weights::none();
    if wo.z.gt(R::ZERO).any() {
        visit(layers, model, wo, |lobe| total = total.plus(lobe.weights, R::ONE));
    }
    total.safe
}

/// A direction that Beckmann's facets reflect `wo` to, drawn from the normals that `wo` sees of V-cavities.
///
/// A normal m is drawn from D·cos. Its cavity shows the facets m and m′ = (−x, −y, z); which of them the view sees is
/// decided by their projected areas V·m and V·m′, of which a negative one counts as 0.
///
/// `wo`: a local unit vector, `wo.z` > 0. `alpha` in [1e-4, 1]. `u`: numbers in [0, 1). The first chooses the facet, the others the
/// normal. The result may lie below the horizon, where the BRDF is 0. Its density is [`reflect_visible_pdf`].
///
/// Error in f32: ≤ 1e-6 absolute. Source: Heitz & d'Eon 2014, §4; D·cos by Walter et al. 2007, eq. 28–29.
#[inline(always)]
pub fn reflect_visible<R: Real>(wo: Vector<R>, alpha: R, u: [R; 3]) -> Vector<R> {
    // The slopes of m are Gaussian, with tan²θ = −α²·ln(1−u).
    let slope = alpha * (-(-below_one(u[1])).ln_one_plus()).max(R::ZERO).sqrt();
    let (cosine, sine) = u[2].unit_circle();
    let (x, y) = (slope * cosine, slope * sine);
    let across = x * wo.x + y * wo.y;
    // V·m/(V·m + V·m′) of m = (x, y, 1), whose sum is 2·V.z; below 0 or above 1 where only one faces the view.
    let first = (R::TWO * wo.z * below_one(u[0])).lt(wo.z + across);
    let sign = R::select(first, R::ONE, -R::ONE);
    let (x, y, across) = (sign * x, sign * y, sign * across);
    let square = slope * slope;
    let scale = R::ONE / (R::ONE + square);
    let along = R::TWO * (wo.z + across) * scale;
    // 2(V·m)m/|m|² − V; the height without cancellation at grazing.
    Vector::new(along * x - wo.x, along * y - wo.y, (wo.z * (R::ONE - square) + R::TWO * across) * scale)
}

/// The density in sr⁻¹ with which [`reflect_visible`] draws `wi`: D·G₁/(4·NV).
///
/// $$p = \frac{D\,G_1(V,H)}{4\,NV} = D\,\min\left(\frac1{4\,NV},\frac{h_z}{|h|^2}\right)$$
///
/// In plain text: p = D·min(1/(4·NV), hz/|h|²) with h = wi + wo. 0 where a cosine is ≤ 0. Bounded as NV goes to 0.
///
/// Error in f32: [`distribution::beckmann`]'s plus 6 ULP. Source: Heitz & d'Eon 2014, eq. 2 and 8.
#[inline(always)]
pub fn reflect_visible_pdf<R: Real>(wi: Vector<R>, wo: Vector<R>, alpha: R) -> R {
    let h = half_vector(wi, wo);
    let lit = wi.z.gt(R::ZERO) & wo.z.gt(R::ZERO);
    let guard = |x: R| R::select(lit, x, R::ONE);
    let seen = (h.z / guard(h.length_squared())).min(R::ONE / guard(R::from_f64(4.0) * wo.z));
    R::select(lit, distribution::beckmann(h, alpha) * seen, R::ZERO)
}

/// A direction drawn from the cosine, with density cos/π; from `u` in [0, 1).
#[inline(always)]
pub fn cosine_hemisphere<R: Real>(u: [R; 2]) -> Vector<R> {
    let square = below_one(u[0]);
    let (radius, (cosine, sine)) = (square.sqrt(), u[1].unit_circle());
    Vector::new(radius * cosine, radius * sine, (R::ONE - square).sqrt())
}

/// A direction drawn uniformly from the hemisphere, with density 1/(2π); from `u` in [0, 1).
#[inline(always)]
pub fn uniform_hemisphere<R: Real>(u: [R; 2]) -> Vector<R> {
    let height = R::ONE - below_one(u[0]);
    let (radius, (cosine, sine)) = (((R::ONE - height) * (R::ONE + height)).sqrt(), u[1].unit_circle());
    Vector::new(radius * cosine, radius * sine, height)
}

/// [`sample`], with density 0 where there is none: what the twin returns.
pub(crate) fn draw<R: Real, const C: usize>(
    layers: &[Layer<R, C>],
    model: Model,
    wo: Vector<R>,
    u: [R; 3],
) -> Sample<R> {
    let mut wi = Vector::default();
    if !wo.z.gt(R::ZERO).any() {
        return Sample { wi, pdf: R::ZERO };
    }
    let mut total = Weights::none();
    visit(layers, model, wo, |lobe| total = total.plus(lobe.weights, R::ONE));
    let share = cosine_share(model);
    let (spreads, first) = if share > 0.0 {
        let share = R::from_f64(share);
        (u[0].lt(share), (u[0] - share) / (R::ONE - share))
    } else {
        (R::ONE.lt(R::ZERO), u[0])
    };
    let mut rest = below_one(first);
    let mut pending = R::ZERO.le(R::ZERO);
    visit(layers, model, wo, |lobe| {
        let share = total.share(lobe.weights);
        let chosen = pending & rest.lt(share);
        if chosen.any() {
            let within = rest.max(R::ZERO) / R::select(chosen, share, R::ONE);
            wi = Vector::select(chosen, lobe.reflect([within, u[1], u[2]]), wi);
        }
        pending = pending & !chosen;
        rest = rest - share;
    });
    if spreads.any() {
        wi = Vector::select(spreads, cosine_hemisphere([u[1], u[2]]), wi);
    }
    let lit = wi.z.gt(R::ZERO);
    let pdf = pdf(layers, model, wi, wo);
    let found = lit & pdf.gt(R::ZERO);
    let keep = |x: R| R::select(found, x, R::ZERO);
    Sample { wi: Vector::new(keep(wi.x), keep(wi.y), keep(wi.z)), pdf: keep(pdf) }
}

/// The two weights of a lobe, of which the module's documentation tells; or sums of them.
#[derive(Clone, Copy, Debug)]
struct Weights<R> {
    estimate: R,
    safe: R,
}

impl<R: Real> Weights<R> {
    fn none() -> Self {
        Weights { estimate: R::ZERO, safe: R::ZERO }
    }

    #[inline(always)]
    fn plus(self, other: Self, factor: R) -> Self {
        Weights { estimate: self.estimate + factor * other.estimate, safe: self.safe + factor * other.safe }
    }

    /// ¾·e/Σe + ¼·s/Σs, `self` being the sums.
    #[inline(always)]
    fn share(self, part: Self) -> R {
        let over = |part: R, total: R| {
            R::select(total.gt(R::ZERO), part / R::select(total.gt(R::ZERO), total, R::ONE), R::ZERO)
        };
        let safe = R::from_f64(SAFE_SHARE);
        (R::ONE - safe) * over(part.estimate, self.estimate) + safe * over(part.safe, self.safe)
    }
}

/// What one interface reflects a view to.
#[derive(Clone, Copy, Debug)]
struct Lobe<R> {
    weights: Weights<R>,
    shape: Shape<R>,
}

#[derive(Clone, Copy, Debug)]
enum Shape<R> {
    /// Facets of width `alpha`, in the medium of index `n` under media of which `least` is the smallest index, 1 included.
    /// `view` is refracted down to them. At the `top` directions are those outside. The share `spread` is drawn from the
    /// cosine outside.
    Facets { view: Vector<R>, alpha: R, n: R, least: R, top: bool, spread: R },
    /// A base, of which a share is drawn uniformly and the rest from the cosine.
    Diffuse { uniform: R },
}

impl<R: Real> Lobe<R> {
    /// The density of `wi` outside the stack.
    #[inline(always)]
    fn density(&self, wi: Vector<R>) -> R {
        match self.shape {
            Shape::Facets { view, alpha, top: true, .. } => reflect_visible_pdf(wi, view, alpha),
            Shape::Facets { view, alpha, n, least, spread, .. } => {
                let light = refract(wi, n);
                let reaches = passes(wi, least) & light.z.gt(R::ZERO);
                let compression = wi.z / (n * n * R::select(reaches, light.z, R::ONE));
                let facets = R::select(reaches, reflect_visible_pdf(light, view, alpha) * compression, R::ZERO);
                spread * R::FRAC_1_PI * wi.z + (R::ONE - spread) * facets
            }
            Shape::Diffuse { uniform } => R::FRAC_1_PI * ((R::ONE - uniform) * wi.z + R::HALF * uniform),
        }
    }

    /// A direction outside the stack; at or below the horizon where it is lost.
    #[inline(always)]
    fn reflect(&self, u: [R; 3]) -> Vector<R> {
        match self.shape {
            Shape::Facets { view, alpha, top: true, .. } => reflect_visible(view, alpha, u),
            Shape::Facets { view, alpha, n, least, spread, .. } => {
                let spreads = u[0].lt(spread);
                let rest = (u[0] - spread).max(R::ZERO) / (R::ONE - spread);
                let light = reflect_visible(view, alpha, [rest, u[1], u[2]]);
                let (x, y) = (n * light.x, n * light.y);
                let square = x * x + y * y;
                let leaves = light.z.gt(R::ZERO) & square.lt(least * least);
                let z = (R::ONE - square).max(R::ZERO).sqrt();
                let facets = Vector::new(x, y, R::select(leaves, z, R::ZERO));
                Vector::select(spreads, cosine_hemisphere([u[1], u[2]]), facets)
            }
            Shape::Diffuse { uniform } => {
                let (even, cosine) = (uniform_hemisphere([u[1], u[2]]), cosine_hemisphere([u[1], u[2]]));
                Vector::select(u[0].lt(uniform), even, cosine)
            }
        }
    }
}

/// True where a direction outside gets through media of which `least` is the smallest index.
#[inline(always)]
fn passes<R: Real>(w: Vector<R>, least: R) -> R::Mask {
    fresnel::refracted_square(w.z, least).gt(R::ZERO)
}

/// Calls `each` for every lobe of a view, all channels together while they share their directions, else one by one.
#[inline(always)]
fn visit<R: Real, const C: usize>(layers: &[Layer<R, C>], model: Model, wo: Vector<R>, mut each: impl FnMut(&Lobe<R>)) {
    if disperses(layers) {
        for channel in 0..C {
            descend::<R, C, 1>(layers, channel, model, wo, &mut each);
        }
    } else {
        descend::<R, C, C>(layers, 0, model, wo, &mut each);
    }
}

/// The lobes of `K` channels from `first` on, which share one pair of directions.
#[inline(always)]
fn descend<R: Real, const C: usize, const K: usize>(
    layers: &[Layer<R, C>],
    first: usize,
    model: Model,
    wo: Vector<R>,
    each: &mut impl FnMut(&Lobe<R>),
) {
    let (elek, about_facets) = (model == Model::Elek, model == Model::WeidlichWilkie);
    let printed = elek | about_facets;
    let always = R::ZERO.le(R::ZERO);
    // What is left at the interface: of the view and light along the mirror direction; of the view and any light, at most.
    let (mut mirrored, mut most) = ([R::ONE; K], [R::ONE; K]);
    let (mut view, mut n_above, mut least, mut alpha_above) = (wo, R::ONE, R::ONE, R::ZERO);
    for (position, layer) in layers.iter().enumerate() {
        let mut weights: Weights<R> = Weights::none();
        let (n, k, alpha) = match &layer.interface {
            Interface::Microfacet { n, k, alpha } => (n, k, if elek { alpha.max(alpha_above) } else { *alpha }),
            Interface::Diffuse { albedo, sigma } => {
                let scale = if printed { R::ONE } else { R::ONE / (n_above * n_above) };
                for (most, albedo) in most.iter().zip(&albedo[first..]) {
                    weights.safe = weights.safe.max(scale * *most * *albedo);
                }
                weights.estimate = weights.safe;
                let uniform = slanted(if about_facets { wo } else { view }, *sigma);
                each(&Lobe { weights, shape: Shape::Diffuse { uniform } });
                return;
            }
        };
        let scale = if elek { n_above * n_above } else { R::ONE };
        // The half vector with light at the opposite horizon is the farthest from the view: cos²(θ/2+45°) = (1−sinθ)/2.
        let sine = view.sin_squared().sqrt();
        let widest = view.z * (R::HALF / (R::ONE + sine)).sqrt();
        let (through, last) = (n[first], position + 1 == layers.len());
        for channel in 0..K {
            let (own_n, own_k) = (n[first + channel], k[first + channel]);
            let (n, k) = if elek { (own_n, own_k) } else { (own_n / n_above, own_k / n_above) };
            let split = interface_fresnel(view.z, n, k);
            let end = interface_fresnel(widest, n, k).reflectance;
            weights.estimate = weights.estimate.max(scale * mirrored[channel] * split.reflectance);
            weights.safe = weights.safe.max(scale * most[channel] * split.reflectance.max(end));
            mirrored[channel] = mirrored[channel] * split.transmittance.squared();
            most[channel] = if printed { most[channel] } else { most[channel] * split.transmittance };
        }
        let shape = if position == 0 || about_facets {
            Shape::Facets { view: wo, alpha, n: R::ONE, least: R::ONE, top: true, spread: R::ZERO }
        } else {
            Shape::Facets { view, alpha, n: n_above, least, top: false, spread: spread(view, alpha, n_above, least) }
        };
        each(&Lobe { weights, shape });
        if last {
            return;
        }
        (n_above, alpha_above, least) = (through, alpha, least.min(through));
        view = refract(wo, n_above);
        let reaches = if about_facets { always } else { passes(wo, least) & view.z.gt(R::ZERO) };
        if !reaches.any() {
            return;
        }
        let (sigma, thickness) = (&layer.medium.sigma[first..], layer.medium.thickness);
        // Refracted about a facet, the view may come down steeper.
        let steepest = if about_facets { R::ONE } else { view.z };
        for channel in 0..K {
            let absorbed = |a: R, b: R| absorption::transmittance(sigma[channel], thickness, a, b);
            mirrored[channel] = R::select(reaches, mirrored[channel] * absorbed(view.z, view.z), R::ZERO);
            most[channel] = R::select(reaches, most[channel] * absorbed(steepest, R::ONE), R::ZERO);
        }
    }
}

/// The share of a base's samples that is drawn uniformly: what Oren–Nayar's slanted term amounts to, 0 for Lambert's.
///
/// That term is cosΔφ·C2·tanβ·cos_i ≤ 0.45·σ²/(σ²+0.09)·sinθ_o, which the cosine alone does not bound.
#[inline(always)]
fn slanted<R: Real>(view: Vector<R>, sigma: R) -> R {
    let variance = sigma * sigma;
    R::from_f64(0.45) * variance / (variance + R::from_f64(0.09)) * view.sin_squared()
}

/// The share of a lower interface's samples that is drawn from the cosine: what of its lobe is reflected totally on the way
/// up, times the part of the hemisphere that the lobe fills.
///
/// A facet turns the view to the critical direction, sinθ_c = least/n, where its slope is tan((θ_c∓θ)/2) =
/// (sinθ_c∓sinθ)/(cosθ_c+cosθ) on either side; as many slopes are beyond t as exp(−t²/α²) says.
#[inline(always)]
fn spread<R: Real>(view: Vector<R>, alpha: R, n: R, least: R) -> R {
    let critical = (least / n).min(R::ONE);
    let cosines = view.z + ((R::ONE - critical) * (R::ONE + critical)).max(R::ZERO).sqrt();
    let sine = view.sin_squared().sqrt();
    let scale = R::ONE / (alpha * R::select(cosines.gt(R::ZERO), cosines, R::ONE));
    let beyond = |difference: R| (-(difference.max(R::ZERO) * scale).squared()).exp();
    let lost = R::HALF * (beyond(critical - sine) + beyond(critical + sine));
    let reach = R::TWO * n * view.z * alpha;
    (lost * reach.squared().min(R::ONE)).min(R::HALF)
}

/// A number clamped to [0, 1), to the largest below 1: a logarithm of the rest stays finite.
#[inline(always)]
pub(crate) fn below_one<R: Real>(u: R) -> R {
    u.saturate().min(R::ONE - R::HALF * R::EPSILON)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diffuse;
    use core::f64::consts::FRAC_PI_2;

    /// The safe weight's Fresnel term against every angle of incidence on a facet that the view allows, for every relative index that
    /// two layers in range can have: the larger end is at least half of all between.
    #[test]
    fn fresnel_terms_are_at_most_twice_the_larger_end() {
        let mut worst = 0.0f64;
        for i in 0..=48 {
            for j in 0..=24 {
                let n = 10f64.powf(f64::from(i - 24) / 4.0);
                let k = if j == 0 { 0.0 } else { 10f64.powf(f64::from(j - 12) / 2.0) };
                for step in 0..60 {
                    // Ever closer to grazing, where dense media have their dip.
                    let theta = FRAC_PI_2 * (1.0 - 0.75f64.powi(step));
                    let widest = 0.5 * (theta + FRAC_PI_2);
                    let at = |angle: f64| interface_fresnel(angle.cos(), n, k).reflectance;
                    let ends = at(theta).max(at(widest));
                    let most = (0..=50).map(|part| at(widest * f64::from(part) / 50.0)).fold(0.0, f64::max);
                    // Matched media reflect nothing but rounding.
                    if most > 1e-12 {
                        worst = worst.max(most / ends);
                    }
                }
            }
        }
        assert!(2.0 * worst <= WEIGHT_BOUND * SAFE_SHARE && worst > 1.9, "{worst}");
    }

    #[test]
    fn a_base_exceeds_its_albedo_by_little() {
        let mut worst = 0.0f64;
        for step in 0..=10 {
            let sigma = FRAC_PI_2 * f64::from(step) / 10.0;
            for i in 0..60 {
                // Ever closer to grazing.
                let wo = Vector::from_angles(FRAC_PI_2 * (1.0 - 0.8f64.powi(i)), 0.0);
                let base = Lobe { weights: Weights::none(), shape: Shape::Diffuse { uniform: slanted(wo, sigma) } };
                for j in 0..60 {
                    for turn in 0..13 {
                        let azimuth = core::f64::consts::PI * f64::from(turn) / 12.0;
                        let wi = Vector::from_angles(FRAC_PI_2 * (1.0 - 0.8f64.powi(j)), azimuth);
                        let f = diffuse::oren_nayar(wi, wo, sigma).f(1.0);
                        worst = worst.max(f * wi.z / base.density(wi));
                    }
                }
            }
        }
        assert!(worst < WEIGHT_BOUND * SAFE_SHARE, "{worst}");
    }
}
