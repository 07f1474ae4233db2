//! Whole microfacet BRDFs: a Fresnel term, a distribution and a masking term put together.
//!
//! Twin: `wgsl/microfacet.wgsl`.

use crate::distribution;
use crate::frame::{Vector, half_vector};
use crate::fresnel;
use crate::masking;
use crate::real::Real;

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
/// With F = 1 the albedo is ≤ 1 for every α. Error in f32: f ≤ 22 + 7·x ULP with x = tan²θ/α² plus the x of [`fresnel::conductor`].
/// Source: Torrance & Sparrow 1967; Cook & Torrance 1982; Elek 2010, eq. 1 (4 times too bright: erratum 1).
#[inline]
pub fn torrance_sparrow<R: Real>(wi: Vector<R>, wo: Vector<R>, n: R, k: R, alpha: R) -> TorranceSparrow<R> {
    let fresnel = fresnel::conductor(cos_half(wi, wo), n, k);
    let facets = facets(wi, wo, alpha);
    TorranceSparrow {
        f: fresnel.reflectance * facets.lobe,
        reflectance: fresnel.reflectance,
        transmittance: fresnel.transmittance,
        d: facets.d,
        g: facets.g,
    }
}

/// V·H = |wi+wo|/2 of two unit directions, at most 1: the cosine of incidence on the microfacet that mirrors them.
///
/// Error in f32: ≤ 2.5 ULP.
#[inline]
pub fn cos_half<R: Real>(wi: Vector<R>, wo: Vector<R>) -> R {
    (R::HALF * half_vector(wi, wo).length_squared().sqrt()).min(R::ONE)
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

/// Beckmann's distribution under V-cavities, without the Fresnel term. `alpha` in [1e-4, 1].
///
/// Error in f32: lobe ≤ 9 + 7·tan²θ/α² ULP.
#[inline]
pub fn facets<R: Real>(wi: Vector<R>, wo: Vector<R>, alpha: R) -> Facets<R> {
    let h = half_vector(wi, wo);
    let lit = wi.z.gt(R::ZERO) & wo.z.gt(R::ZERO);
    let d = R::select(lit, distribution::beckmann(h, alpha), R::ZERO);
    let masking = masking::v_cavity(wi.z, wo.z, h);
    Facets { lobe: d * masking.visibility, d, g: masking.g }
}
