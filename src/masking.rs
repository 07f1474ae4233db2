//! Masking and shadowing of microfacets, and the visibility V = G/(4·NL·NV) that a BRDF multiplies with.
//!
//! Twin: `wgsl/masking.wgsl`. V is computed directly: G and the two cosines all vanish at grazing, their quotient does
//! not. Directions are local unit vectors; where a cosine is ≤ 0, G and V are 0.

use crate::frame::Vector;
use crate::real::Real;

/// The masking-shadowing of a pair of directions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Masking<R> {
    /// G, the visible fraction of the microfacets that reflect from wi to wo, in [0, 1].
    pub g: R,
    /// V = G/(4·cos_i·cos_o), in sr⁻¹ times the unit of 1/D.
    pub visibility: R,
}

/// The symmetric V-cavities of Torrance and Sparrow.
///
/// $$G = \min\left(1, \frac{2\,NH\,NV}{VH}, \frac{2\,NH\,NL}{VH}\right)$$
///
/// In plain text: G = min(1, 2·NH·NV/VH, 2·NH·NL/VH). `h` is the half vector wi + wo, whose length is 2·VH.
///
/// Error in f32: ≤ 7 ULP. Source: Torrance & Sparrow 1967; Cook & Torrance 1982, eq. 11; Elek 2010, App. B.
#[inline]
pub fn v_cavity<R: Real>(cos_i: R, cos_o: R, h: Vector<R>) -> Masking<R> {
    let inside = cos_i.gt(R::ZERO) & cos_o.gt(R::ZERO);
    let (least, most) = (cos_i.min(cos_o), cos_i.max(cos_o));
    let guard = |x: R| R::select(inside, x, R::ONE);
    let length_squared = guard(h.length_squared());
    // NH/VH = 2hz/|h|².
    let edge = length_squared / (R::TWO * guard(h.z));
    let visibility = R::HALF / (guard(most) * (R::TWO * guard(least)).max(edge));
    let g = (R::TWO * least / edge).min(R::ONE);
    Masking { g: R::select(inside, g, R::ZERO), visibility: R::select(inside, visibility, R::ZERO) }
}

/// Smith's masking for GGX, height-correlated.
///
/// $$G = \frac{1}{1+\Lambda(\omega_i)+\Lambda(\omega_o)}$$
///
/// In plain text: G = 1/(1+Λ(wi)+Λ(wo)), Λ = (√(1+tan²θ·α²)−1)/2. The widths are those along tangent and bitangent.
///
/// Error in f32: ≤ 11 ULP. Source: Heitz 2014, eq. 99 and 72; Ross, Dion & Potvin 2005.
#[inline]
pub fn smith_ggx<R: Real>(wi: Vector<R>, wo: Vector<R>, alpha_x: R, alpha_y: R) -> Masking<R> {
    correlated(wi.z, wo.z, projected_area_ggx(wi, alpha_x, alpha_y), projected_area_ggx(wo, alpha_x, alpha_y))
}

/// Smith's masking for GGX, the product of the two directions' own.
///
/// In plain text: G = G1(wi)·G1(wo), G1 = 1/(1+Λ).
///
/// Error in f32: ≤ 7 ULP. Source: Walter et al. 2007, eq. 23 and 34.
#[inline]
pub fn smith_ggx_separable<R: Real>(wi: Vector<R>, wo: Vector<R>, alpha_x: R, alpha_y: R) -> Masking<R> {
    separable(wi.z, wo.z, projected_area_ggx(wi, alpha_x, alpha_y), projected_area_ggx(wo, alpha_x, alpha_y))
}

/// Smith's masking for Beckmann's distribution, height-correlated.
///
/// In plain text: G = 1/(1+Λ(wi)+Λ(wo)), Λ = (erf(a)−1 + exp(−a²)/(a√π))/2, a = 1/(α·tanθ).
///
/// Error in f32: ≤ 9 ULP. Source: Heitz 2014, eq. 99 and 66.
#[inline]
pub fn smith_beckmann<R: Real>(wi: Vector<R>, wo: Vector<R>, alpha_x: R, alpha_y: R) -> Masking<R> {
    correlated(wi.z, wo.z, projected_area_beckmann(wi, alpha_x, alpha_y), projected_area_beckmann(wo, alpha_x, alpha_y))
}

/// Smith's masking for Beckmann's distribution, the product of the two directions' own.
///
/// Error in f32: ≤ 11 ULP. Source: Smith 1967; Walter et al. 2007, eq. 23.
#[inline]
pub fn smith_beckmann_separable<R: Real>(wi: Vector<R>, wo: Vector<R>, alpha_x: R, alpha_y: R) -> Masking<R> {
    separable(wi.z, wo.z, projected_area_beckmann(wi, alpha_x, alpha_y), projected_area_beckmann(wo, alpha_x, alpha_y))
}

/// The projected area of a GGX microsurface that faces `w`, for 1 of macrosurface: cosθ·(1+Λ) = cosθ/G1.
///
/// $$\sigma = \tfrac12\left(\cos\theta + \sqrt{\cos^2\theta + \alpha_x^2x^2 + \alpha_y^2y^2}\right)$$
///
/// In plain text: (z + √(z² + (αx·x)² + (αy·y)²))/2. At normal incidence 1; at grazing α/2. `w.z` ≥ 0.
///
/// Error in f32: ≤ 3 ULP. Source: Heitz et al. 2016, "Multiple-scattering microfacet BSDFs", eq. 5; Λ of Heitz 2014, eq. 72.
#[inline]
pub fn projected_area_ggx<R: Real>(w: Vector<R>, alpha_x: R, alpha_y: R) -> R {
    let (x, y) = (alpha_x * w.x, alpha_y * w.y);
    R::HALF * (w.z + (w.z * w.z + x * x + y * y).sqrt())
}

/// The projected area of a Beckmann microsurface that faces `w`, for 1 of macrosurface: cosθ·(1+Λ) = cosθ/G1.
///
/// $$\sigma = \cos\theta + \tfrac12 e^{-a^2}\left(\frac{s}{\sqrt\pi} - \cos\theta\,\mathrm{erfcx}(a)\right),\quad s^2 = \alpha_x^2x^2+\alpha_y^2y^2,\quad a = \cos\theta/s$$
///
/// In plain text: z + exp(−a²)·(s/√π − z·erfcx(a))/2. At normal incidence 1; at grazing α/(2√π). `w.z` ≥ 0.
///
/// Error in f32: ≤ 5 ULP. Source: Λ of Heitz 2014, eq. 66, with erf written so that nothing cancels.
#[inline]
pub fn projected_area_beckmann<R: Real>(w: Vector<R>, alpha_x: R, alpha_y: R) -> R {
    let (x, y) = (alpha_x * w.x, alpha_y * w.y);
    let s = (x * x + y * y).sqrt();
    // From a = 7 on Λ < exp(−49)/(4·7³√π) < 3e-25 is below both precisions.
    let tilted = w.z.lt(R::from_f64(7.0) * s);
    let a = R::select(tilted, w.z, R::ZERO) / R::select(tilted, s, R::ONE);
    let frac_1_sqrt_pi = R::from_f64(0.564_189_583_547_756_286_95);
    let lambda = R::HALF * (-(a * a)).exp() * (s * frac_1_sqrt_pi - w.z * a.erfcx());
    w.z + R::select(tilted, lambda, R::ZERO)
}

/// Kelemen's approximation of the visibility.
///
/// $$V = \frac{1}{4\,VH^2} = \frac{1}{|\omega_i+\omega_o|^2}$$
///
/// In plain text: V = 1/|h|² with h = wi + wo; G = 4·NL·NV·V is not bounded by 1.
///
/// Error in f32: ≤ 7 ULP. Source: Kelemen & Szirmay-Kalos 2001, eq. 9; Elek 2010, §3.1 ("no G").
#[inline]
pub fn kelemen<R: Real>(cos_i: R, cos_o: R, h: Vector<R>) -> Masking<R> {
    let inside = cos_i.gt(R::ZERO) & cos_o.gt(R::ZERO);
    let visibility = R::ONE / R::select(inside, h.length_squared(), R::ONE);
    let g = R::from_f64(4.0) * cos_i * cos_o * visibility;
    Masking { g: R::select(inside, g, R::ZERO), visibility: R::select(inside, visibility, R::ZERO) }
}

/// G and V of correlated heights from the projected areas σ = cos·(1+Λ).
#[inline(always)]
fn correlated<R: Real>(cos_i: R, cos_o: R, area_i: R, area_o: R) -> Masking<R> {
    // cos_i·cos_o·(1+Λi+Λo), symmetric to the last bit; σ ≥ cos, so at most half of the sum cancels.
    from_denominator(cos_i, cos_o, (cos_o * area_i + cos_i * area_o) - cos_i * cos_o)
}

/// G and V of independent heights from the projected areas.
#[inline(always)]
fn separable<R: Real>(cos_i: R, cos_o: R, area_i: R, area_o: R) -> Masking<R> {
    from_denominator(cos_i, cos_o, area_i * area_o)
}

/// G = NL·NV/d and V = 1/(4d).
#[inline(always)]
fn from_denominator<R: Real>(cos_i: R, cos_o: R, denominator: R) -> Masking<R> {
    let inside = cos_i.gt(R::ZERO) & cos_o.gt(R::ZERO);
    let inverse = R::ONE / R::select(inside, denominator, R::ONE);
    Masking {
        g: R::select(inside, (cos_i * cos_o * inverse).min(R::ONE), R::ZERO),
        visibility: R::select(inside, R::from_f64(0.25) * inverse, R::ZERO),
    }
}
