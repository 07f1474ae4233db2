//! Whole microfacet BRDFs: a Fresnel term, a distribution and a masking term put together.
//!
//! Twin: `wgsl/microfacet.wgsl`.

use crate::distribution;
use crate::frame::{Vector, half_vector};
use crate::fresnel;
use crate::masking;
use crate::real::Real;
use crate::twofold::Twofold;

/// The Torrance–Sparrow BRDF with the factors that it is the product of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TorranceSparrow<R> {
    /// The BRDF F·D·G/(4·NL·NV) in sr⁻¹.
    pub f: R,
    /// F, the Fresnel reflectance at V·H.
    pub reflectance: R,
    /// T = 1−F at V·H.
    pub transmittance: R,
    /// D at the half vector, in sr⁻¹.
    pub d: R,
    /// G of the pair of directions.
    pub g: R,
}

/// The Torrance–Sparrow BRDF of a rough conductor or (κ = 0) dielectric: Beckmann's distribution, V-cavities, exact Fresnel.
///
/// $$f = \frac{F(V\cdot H)\,D(H)\,G(L,V)}{4\,NL\,NV}$$
///
/// In plain text: f = F·D·G/(4·NL·NV).
///
/// * `wi`, `wo`: local unit vectors; where a cosine is ≤ 0, f, D and G are 0.
/// * `n` > 0, `k` ≥ 0: the index relative to the medium above. `alpha` in [1e-4, 1].
///
/// With F = 1 the albedo is ≤ 1 for every α. Error in f32: ≤ 0.6 ULP, every factor included.
/// Source: Torrance & Sparrow 1967; Cook & Torrance 1982; Elek 2010, eq. 1 (4 times too bright: erratum 1).
#[inline(always)]
pub fn torrance_sparrow<R: Real>(wi: Vector<R>, wo: Vector<R>, n: R, k: R, alpha: R) -> TorranceSparrow<R> {
    let (wi, wo) = (wi.widen(), wo.widen());
    let fresnel = fresnel::conductor_carried::<_, R>(cos_half_carried(wi, wo), n.widen(), k.widen());
    let facets = facets_wide::<_, R>(wi, wo, alpha.widen());
    TorranceSparrow {
        f: R::narrow(fresnel.reflectance * facets.lobe),
        reflectance: R::narrow(fresnel.reflectance),
        transmittance: R::narrow(fresnel.transmittance),
        d: R::narrow(facets.d),
        g: R::narrow(facets.g),
    }
}

/// [`cos_half`], unrounded where the type carries: at a critical angle F magnifies its rounding.
#[inline(always)]
pub(crate) fn cos_half_carried<W: Real>(wi: Vector<W>, wo: Vector<W>) -> Twofold<W> {
    (wi.sum_carried(wo).length_squared_carried().sqrt() * W::HALF).at_most_one()
}

/// V·H = |wi+wo|/2 of two unit directions, at most 1: the cosine of incidence on the microfacet that mirrors them.
///
/// Error in f32: ≤ 0.6 ULP.
#[inline(always)]
pub fn cos_half<R: Real>(wi: Vector<R>, wo: Vector<R>) -> R {
    let (wi, wo) = (wi.widen(), wo.widen());
    R::narrow(R::Wide::HALF * half_vector(wi, wo).length_squared().sqrt()).min(R::ONE)
}

/// The part of a microfacet BRDF that all channels share.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Facets<R> {
    /// D·G/(4·NL·NV) in sr⁻¹: the BRDF for F = 1.
    pub lobe: R,
    /// D at the half vector, in sr⁻¹.
    pub d: R,
    /// G of the pair of directions.
    pub g: R,
}

impl<W: Real> Facets<W> {
    /// The nearest numbers of a type that computes in `W`.
    #[inline(always)]
    pub(crate) fn narrow<R: Real<Wide = W>>(self) -> Facets<R> {
        Facets { lobe: R::narrow(self.lobe), d: R::narrow(self.d), g: R::narrow(self.g) }
    }
}

/// Beckmann's distribution under V-cavities, without the Fresnel term. `alpha` in [1e-4, 1].
///
/// Error in f32: ≤ 0.6 ULP.
#[inline(always)]
pub fn facets<R: Real>(wi: Vector<R>, wo: Vector<R>, alpha: R) -> Facets<R> {
    facets_wide::<_, R>(wi.widen(), wo.widen(), alpha.widen()).narrow()
}

/// [`facets`] in the numbers that it computes with.
#[inline(always)]
pub(crate) fn facets_wide<W: Real, R: Real<Wide = W>>(wi: Vector<W>, wo: Vector<W>, alpha: W) -> Facets<W> {
    let h = wi.sum_carried(wo);
    let lit = wi.z.gt(W::ZERO) & wo.z.gt(W::ZERO);
    let d = W::select(lit, distribution::beckmann_carried::<_, R>(h, alpha), W::ZERO);
    let masking = masking::v_cavity(wi.z, wo.z, h.rounded());
    Facets { lobe: d * masking.visibility, d, g: masking.g }
}
