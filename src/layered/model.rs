//! The models that evaluate a stack.
//!
//! Twin: `wgsl/layered.wgsl`. Each walks the layers from the top, refracts both directions at every interface, and adds what the interface reflects, weighted by what reaches it and returns. Total reflection, or
//! a refracted direction at or below the horizon, ends the walk: the layers below contribute 0.

use super::{Interface, Layer};
use crate::absorption;
use crate::diffuse;
use crate::frame::{Vector, half_vector};
use crate::fresnel::{self, Fresnel};
use crate::microfacet::{Facets, cos_half, facets_wide};
use crate::real::{Mask, Real};
use crate::refraction::{refract, refract_about};

/// The documents' layered model with normalised microfacets.
///
/// $$f = f_1 + T_{12}\,f_2(L',V')\,a\,t,\quad T_{12} = 1-F_1(V\cdot H),\quad t = (1-G_1) + T_{12}G_1$$
///
/// In plain text: f = f1 + T12·f2(L′, V′)·a·t, applied from the top through all layers. Fresnel terms take the absolute
/// index of their own layer, and no layer is smoother than the one above it (m₂ ← max(m₂, m₁)).
///
/// `layers` from the top; `wi`, `wo` local unit vectors. Reciprocal. It lacks the compression by 1/n², so that
/// what it reflects has no bound: over a mirror 5.3 times the light that arrives under a smooth coat of n = 3, 11.6 times under
/// one of n = 10 (`tests/adversary`), and 2.8 times on the stacks of the documents. Source: Elek 2010, eq. 2–4 and Algorithm 1 (with errata 1 and 8 corrected, 7 kept).
/// Error in f32: ≤ 0.6 ULP for two layers and f > 1e-8.
#[inline]
pub fn elek<R: Real, const C: usize>(layers: &[Layer<R, C>], wi: Vector<R>, wo: Vector<R>) -> [R; C] {
    by_channel::<R, Elek, _, C>(layers, &Plain, wi, wo)
}

/// The energy-conserving layered model.
///
/// $$f = \sum_k \frac{n_0^2}{n_k^2}\,f_k(L_k,V_k)\prod_{j<k}T_j(L_j)T_j(V_j)\,e^{-\tau_{j+1}(1/\mu_L+1/\mu_V)}$$
///
/// In plain text: every interface below adds its own BRDF for the refracted directions, times the Fresnel
/// transmittance of each direction at each interface above, the absorption between, and 1/η² for each refraction.
///
/// `layers` from the top; `wi`, `wo` local unit vectors. Reciprocal. Albedo ≤ 1 where no medium is thinner than the
/// one above the stack: nothing more was found among 30 000 stacks of up to three interfaces, densities rising and falling
/// (`tests/adversary`). Under a rough coat of n < 1 it is up to 1.2, by the critical angle of the coat: its transmittance is that
/// of a smooth one, while the rough one reflects totally over a range of angles (1.195 at 16° for n = .33, α = .42 over total
/// reflection; 1.05 at 43° for n = .7, α = .1 over a mirror).
/// It leaves out the light that bounces between interfaces. Source: Weidlich & Wilkie 2007 with relative indices; the compression of
/// radiance by n² is Snell's (Walter et al. 2007, §3).
/// Error in f32: ≤ 0.6 ULP for two layers and f > 1e-8.
#[inline]
pub fn conserving<R: Real, const C: usize>(layers: &[Layer<R, C>], wi: Vector<R>, wo: Vector<R>) -> [R; C] {
    by_channel::<R, Conserving, _, C>(layers, &Plain, wi, wo)
}

/// The model of Weidlich and Wilkie as Elek reports it.
///
/// In plain text: f = f1 + T12·f2(L′, V′)·a·t as [`elek`], with directions refracted about the half vector H, so that
/// H′ = H, relative indices, and each layer's own width.
///
/// `layers` from the top; `wi`, `wo` local unit vectors. Reciprocal; its albedo reaches 1.94 at grazing over a white
/// diffuse base under a smooth coat of n = 1.005 to 1.12. Over total reflection under coats of n < 1 no bound is known: 3.58 was
/// met. For a rough pair of directions the refracted ones may lie below the horizon: nothing is added then.
/// Source: Weidlich & Wilkie 2007, §5; Elek 2010, §2.2.
/// Error in f32: ≤ 0.6 ULP for two layers and f > 1e-8.
#[inline]
pub fn weidlich_wilkie<R: Real, const C: usize>(layers: &[Layer<R, C>], wi: Vector<R>, wo: Vector<R>) -> [R; C] {
    by_channel::<R, WeidlichWilkie, _, C>(layers, &Plain, wi, wo)
}

/// The factor t by which the documents let internal reflection raise the transmission.
///
/// In plain text: t = (1−G) + T·G = 1 − G·F, with T = 1−F (`transmitted`) the transmittance of the interface at V·H and G its masking.
/// Both in [0, 1]; 1 at G = 0, T at G = 1. It does not model total reflection.
///
/// Error in f32: ≤ 0.6 ULP. Source: Elek 2010, eq. 4; Weidlich & Wilkie 2007, §5.3.
#[inline]
pub fn internal_reflection<R: Real>(transmitted: R, g: R) -> R {
    let (transmitted, g) = (transmitted.widen(), g.widen());
    R::narrow((R::Wide::ONE - g) + transmitted * g)
}

/// A closed-form model over interfaces whose facets are not the plain ones; [`Model::Coupled`](super::Model) and
/// [`Model::Walk`](super::Model) have no closed form: of them it is [`conserving`].
#[cfg(feature = "std")]
#[inline]
pub(crate) fn over<R: Real, S: Surface<R>, const C: usize>(
    model: super::Model,
    layers: &[Layer<R, C>],
    surface: &S,
    wi: Vector<R>,
    wo: Vector<R>,
) -> [R; C] {
    match model {
        super::Model::Elek => by_channel::<R, Elek, S, C>(layers, surface, wi, wo),
        super::Model::WeidlichWilkie => by_channel::<R, WeidlichWilkie, S, C>(layers, surface, wi, wo),
        _ => by_channel::<R, Conserving, S, C>(layers, surface, wi, wo),
    }
}

/// What the facets of the interfaces are.
pub(crate) trait Surface<R: Real> {
    /// The cosine of incidence on the facets that mirror a pair of directions at an interface, and what they reflect.
    fn facets(
        &self,
        position: usize,
        wi: Vector<R::Wide>,
        wo: Vector<R::Wide>,
        alpha: R::Wide,
    ) -> (R::Wide, Facets<R::Wide>);
}

/// Beckmann's facets about the normal.
pub(crate) struct Plain;

impl<R: Real> Surface<R> for Plain {
    #[inline(always)]
    fn facets(&self, _: usize, wi: Vector<R::Wide>, wo: Vector<R::Wide>, alpha: R::Wide) -> (R::Wide, Facets<R::Wide>) {
        (cos_half(wi, wo), facets_wide::<_, R>(wi, wo, alpha))
    }
}

/// What distinguishes one recursive model from another.
trait Rule<R: Real> {
    /// The width of an interface under one of width `above`: its own.
    #[inline(always)]
    fn alpha(alpha: R, _above: R) -> R {
        alpha
    }
    /// The index that a Fresnel term takes, of a layer's own index and the one of the medium above: their ratio.
    #[inline(always)]
    fn index(own: R, n_above: R) -> R {
        own / n_above
    }
    /// The directions below an interface, refracted by the ratio `eta`: about the macro normal.
    #[inline(always)]
    fn refract(wi: Vector<R>, wo: Vector<R>, eta: R) -> (Vector<R>, Vector<R>) {
        (refract(wi, eta), refract(wo, eta))
    }
    /// What an interface lets through in and out, without absorption: `index` is n and κ as its Fresnel terms take them,
    /// `at_half` its Fresnel term at V·H, `g` its masking, `eta` the ratio that directions refract by.
    fn through(wi: Vector<R>, wo: Vector<R>, index: (R, R), at_half: Fresnel<R>, g: R, eta: R) -> R;
}

struct Elek;
impl<R: Real> Rule<R> for Elek {
    #[inline(always)]
    fn alpha(alpha: R, above: R) -> R {
        alpha.max(above)
    }
    #[inline(always)]
    fn index(own: R, _: R) -> R {
        own
    }
    #[inline(always)]
    fn through(_: Vector<R>, _: Vector<R>, _: (R, R), at_half: Fresnel<R>, g: R, _: R) -> R {
        at_half.transmittance * internal_reflection(at_half.transmittance, g)
    }
}

struct WeidlichWilkie;
impl<R: Real> Rule<R> for WeidlichWilkie {
    #[inline(always)]
    fn refract(wi: Vector<R>, wo: Vector<R>, eta: R) -> (Vector<R>, Vector<R>) {
        let m = half_vector(wi, wo).normalized();
        (refract_about(wi, m, eta), refract_about(wo, m, eta))
    }
    #[inline(always)]
    fn through(_: Vector<R>, _: Vector<R>, _: (R, R), at_half: Fresnel<R>, g: R, _: R) -> R {
        at_half.transmittance * internal_reflection(at_half.transmittance, g)
    }
}

struct Conserving;
impl<R: Real> Rule<R> for Conserving {
    #[inline(always)]
    fn through(wi: Vector<R>, wo: Vector<R>, (n, k): (R, R), _: Fresnel<R>, _: R, eta: R) -> R {
        interface_fresnel(wi.z, n, k).transmittance * interface_fresnel(wo.z, n, k).transmittance / (eta * eta)
    }
}

/// The exact Fresnel terms, by the dielectric's form where κ = 0: it is cheaper, and accurate at the critical angle.
#[inline(always)]
pub(crate) fn interface_fresnel<R: Real>(cos_i: R, n: R, k: R) -> Fresnel<R> {
    if k == R::ZERO { fresnel::dielectric(cos_i, n) } else { fresnel::conductor(cos_i, n, k) }
}

/// Evaluates all channels together while they share their directions, else one by one.
#[inline]
fn by_channel<R: Real, M: Rule<R::Wide>, S: Surface<R>, const C: usize>(
    layers: &[Layer<R, C>],
    surface: &S,
    wi: Vector<R>,
    wo: Vector<R>,
) -> [R; C] {
    // Directions too narrow for a lobe below would move it: the walk keeps the numbers that the terms compute with.
    let (wi, wo) = (wi.widen(), wo.widen());
    if disperses(layers) {
        let mut f = [R::ZERO; C];
        for (channel, f) in f.iter_mut().enumerate() {
            let [one] = recurse::<R::Wide, R, M, S, C, 1>(layers, surface, channel, wi, wo);
            *f = R::narrow(one);
        }
        f
    } else {
        recurse::<R::Wide, R, M, S, C, C>(layers, surface, 0, wi, wo).map(R::narrow)
    }
}

/// True where an interface that light passes has an index that differs between channels.
pub(crate) fn disperses<R: Real, const C: usize>(layers: &[Layer<R, C>]) -> bool {
    layers.split_last().is_some_and(|(_, passed)| {
        passed.iter().any(|layer| match layer.interface {
            Interface::Microfacet { n, .. } => n.iter().any(|other| *other != n[0]),
            Interface::Diffuse { .. } => false,
        })
    })
}

/// The recursion over `K` channels from `first` on, which share one pair of directions.
#[inline]
fn recurse<W: Real, R: Real<Wide = W>, M: Rule<W>, S: Surface<R>, const C: usize, const K: usize>(
    layers: &[Layer<R, C>],
    surface: &S,
    first: usize,
    wi: Vector<W>,
    wo: Vector<W>,
) -> [W; K] {
    let mut f = [W::ZERO; K];
    let mut weight = [W::ONE; K];
    let (mut wi, mut wo) = (wi, wo);
    let (mut n_above, mut alpha_above) = (W::ONE, W::ZERO);
    for (position, layer) in layers.iter().enumerate() {
        let (n, k, alpha) = match &layer.interface {
            Interface::Microfacet { n, k, alpha } => {
                (n.map(R::widen), k.map(R::widen), M::alpha(alpha.widen(), alpha_above))
            }
            Interface::Diffuse { albedo, sigma } => {
                let base = diffuse::oren_nayar_wide::<_, R>(wi, wo, sigma.widen());
                for ((f, weight), albedo) in f.iter_mut().zip(weight).zip(&albedo[first..]) {
                    *f = *f + weight * base.f(albedo.widen());
                }
                return f;
            }
        };
        let (cos_h, shared) = surface.facets(position, wi, wo, alpha);
        let last = position + 1 == layers.len();
        let eta = n[first] / n_above;
        let (below_i, below_o) = M::refract(wi, wo, eta);
        for channel in 0..K {
            let (n, k) = (M::index(n[first + channel], n_above), M::index(k[first + channel], n_above));
            let fresnel = interface_fresnel(cos_h, n, k);
            f[channel] = f[channel] + weight[channel] * fresnel.reflectance * shared.lobe;
            if !last {
                let (sigma, thickness) = (layer.medium.sigma[first + channel].widen(), layer.medium.thickness.widen());
                let absorbed = absorption::transmittance_wide::<_, R>(sigma, thickness, below_i.z, below_o.z);
                weight[channel] = weight[channel] * M::through(wi, wo, (n, k), fresnel, shared.g, eta) * absorbed;
            }
        }
        let least = below_i.z.min(below_o.z).min(wi.z).min(wo.z);
        if last || least.le(W::ZERO).all() {
            return f;
        }
        (wi, wo, n_above, alpha_above) = (below_i, below_o, n[first], alpha);
    }
    f
}
