//! Masking and shadowing of microfacets, and the visibility V = G/(4·NL·NV) that a BRDF multiplies with.
//!
//! Twin: `wgsl/masking.wgsl`. V is computed directly: G and the two cosines all vanish at grazing, their quotient does
//! not. Directions are local unit vectors; where a cosine is ≤ 0, G and V are 0.

use crate::frame::Vector;
use crate::real::Real;
use crate::twofold::Twofold;

/// The masking-shadowing of a pair of directions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Masking<R> {
    /// G, the visible fraction of the microfacets that reflect from wi to wo, in [0, 1].
    pub g: R,
    /// V = G/(4·cos_i·cos_o), in sr⁻¹ times the unit of 1/D.
    pub visibility: R,
}

impl<W: Real> Masking<W> {
    /// The nearest numbers of a type that computes in `W`.
    #[inline(always)]
    pub(crate) fn narrow<R: Real<Wide = W>>(self) -> Masking<R> {
        Masking { g: R::narrow(self.g), visibility: R::narrow(self.visibility) }
    }
}

/// The symmetric V-cavities of Torrance and Sparrow.
///
/// $$G = \min\left(1, \frac{2\,NH\,NV}{VH}, \frac{2\,NH\,NL}{VH}\right)$$
///
/// In plain text: G = min(1, 2·NH·NV/VH, 2·NH·NL/VH). `h` is the half vector wi + wo, whose length is 2·VH.
///
/// Error in f32: ≤ 4 ULP, of which 3 are the rounding of `h`. Source: Torrance & Sparrow 1967; Cook & Torrance 1982, eq. 11; Elek 2010, App. B.
#[inline(always)]
pub fn v_cavity<R: Real>(cos_i: R, cos_o: R, h: Vector<R>) -> Masking<R> {
    v_cavity_wide(cos_i.widen(), cos_o.widen(), h.widen()).narrow()
}

#[inline(always)]
pub(crate) fn v_cavity_wide<W: Real>(cos_i: W, cos_o: W, h: Vector<W>) -> Masking<W> {
    let inside = cos_i.gt(W::ZERO) & cos_o.gt(W::ZERO);
    let (least, most) = (cos_i.min(cos_o), cos_i.max(cos_o));
    let guard = |x: W| W::select(inside, x, W::ONE);
    let one = Twofold::new(W::ONE);
    let length_squared = Twofold::select(inside, h.carried().length_squared_carried(), one);
    // NH/VH = 2hz/|h|².
    let edge = length_squared / (W::TWO * guard(h.z));
    let twice = W::TWO * guard(least);
    let wider = Twofold::select(twice.lt(edge.high), edge, Twofold::new(twice));
    let visibility = W::HALF / (wider * guard(most)).rounded();
    let g = (W::TWO * least / edge.rounded()).min(W::ONE);
    Masking { g: W::select(inside, g, W::ZERO), visibility: W::select(inside, visibility, W::ZERO) }
}

/// Smith's masking for GGX, height-correlated.
///
/// $$G = \frac{1}{1+\Lambda(\omega_i)+\Lambda(\omega_o)}$$
///
/// In plain text: G = 1/(1+Λ(wi)+Λ(wo)), Λ = (√(1+tan²θ·α²)−1)/2. The widths are those along tangent and bitangent.
///
/// Error in f32: ≤ 0.6 ULP. Source: Heitz 2014, eq. 99 and 72; Ross, Dion & Potvin 2005.
#[inline(always)]
pub fn smith_ggx<R: Real>(wi: Vector<R>, wo: Vector<R>, alpha_x: R, alpha_y: R) -> Masking<R> {
    smith_ggx_wide(wi.widen(), wo.widen(), alpha_x.widen(), alpha_y.widen()).narrow()
}

#[inline(always)]
pub(crate) fn smith_ggx_wide<W: Real>(wi: Vector<W>, wo: Vector<W>, alpha_x: W, alpha_y: W) -> Masking<W> {
    let (root_i, root_o) = (stretched_length(wi, alpha_x, alpha_y), stretched_length(wo, alpha_x, alpha_y));
    correlated(wi.z, wo.z, Twofold::new(W::HALF * root_i), Twofold::new(W::HALF * root_o))
}

/// Smith's masking for GGX, the product of the two directions' own.
///
/// In plain text: G = G1(wi)·G1(wo), G1 = 1/(1+Λ).
///
/// Error in f32: ≤ 0.6 ULP. Source: Walter et al. 2007, eq. 23 and 34.
#[inline(always)]
pub fn smith_ggx_separable<R: Real>(wi: Vector<R>, wo: Vector<R>, alpha_x: R, alpha_y: R) -> Masking<R> {
    smith_ggx_separable_wide(wi.widen(), wo.widen(), alpha_x.widen(), alpha_y.widen()).narrow()
}

#[inline(always)]
fn smith_ggx_separable_wide<W: Real>(wi: Vector<W>, wo: Vector<W>, alpha_x: W, alpha_y: W) -> Masking<W> {
    let area_i = Twofold::sum(wi.z, stretched_length(wi, alpha_x, alpha_y));
    let area_o = Twofold::sum(wo.z, stretched_length(wo, alpha_x, alpha_y));
    separable(wi.z, wo.z, area_i * W::HALF, area_o * W::HALF)
}

/// Smith's masking for Beckmann's distribution, height-correlated.
///
/// In plain text: G = 1/(1+Λ(wi)+Λ(wo)), Λ = (erf(a)−1 + exp(−a²)/(a√π))/2, a = 1/(α·tanθ).
///
/// Error in f32: ≤ 0.6 ULP. Source: Heitz 2014, eq. 99 and 66.
#[inline(always)]
pub fn smith_beckmann<R: Real>(wi: Vector<R>, wo: Vector<R>, alpha_x: R, alpha_y: R) -> Masking<R> {
    smith_beckmann_wide::<_, R>(wi.widen(), wo.widen(), alpha_x.widen(), alpha_y.widen()).narrow()
}

#[inline(always)]
fn smith_beckmann_wide<W: Real, R: Real<Wide = W>>(wi: Vector<W>, wo: Vector<W>, alpha_x: W, alpha_y: W) -> Masking<W> {
    let (z_i, lambda_i) = beckmann_lambda::<_, R>(wi, alpha_x, alpha_y);
    let (z_o, lambda_o) = beckmann_lambda::<_, R>(wo, alpha_x, alpha_y);
    let half = |z| Twofold::new(W::HALF * z);
    correlated(wi.z, wo.z, half(z_i) + lambda_i, half(z_o) + lambda_o)
}

/// Smith's masking for Beckmann's distribution, the product of the two directions' own.
///
/// Error in f32: ≤ 0.6 ULP. Source: Smith 1967; Walter et al. 2007, eq. 23.
#[inline(always)]
pub fn smith_beckmann_separable<R: Real>(wi: Vector<R>, wo: Vector<R>, alpha_x: R, alpha_y: R) -> Masking<R> {
    smith_beckmann_separable_wide::<_, R>(wi.widen(), wo.widen(), alpha_x.widen(), alpha_y.widen()).narrow()
}

#[inline(always)]
fn smith_beckmann_separable_wide<W: Real, R: Real<Wide = W>>(
    wi: Vector<W>,
    wo: Vector<W>,
    alpha_x: W,
    alpha_y: W,
) -> Masking<W> {
    let (z_i, lambda_i) = beckmann_lambda::<_, R>(wi, alpha_x, alpha_y);
    let (z_o, lambda_o) = beckmann_lambda::<_, R>(wo, alpha_x, alpha_y);
    separable(wi.z, wo.z, Twofold::new(z_i) + lambda_i, Twofold::new(z_o) + lambda_o)
}

/// The projected area of a GGX microsurface that faces `w`, for 1 of macrosurface: cosθ·(1+Λ) = cosθ/G1.
///
/// $$\sigma = \tfrac12\left(\cos\theta + \sqrt{\cos^2\theta + \alpha_x^2x^2 + \alpha_y^2y^2}\right)$$
///
/// In plain text: (z + √(z² + (αx·x)² + (αy·y)²))/2. At normal incidence 1; at grazing α/2. `w.z` ≥ 0.
///
/// Error in f32: ≤ 0.6 ULP. Source: Heitz et al. 2016, "Multiple-scattering microfacet BSDFs", eq. 5; Λ of Heitz 2014, eq. 72.
#[inline(always)]
pub fn projected_area_ggx<R: Real>(w: Vector<R>, alpha_x: R, alpha_y: R) -> R {
    R::narrow(projected_area_ggx_wide(w.widen(), alpha_x.widen(), alpha_y.widen()))
}

#[inline(always)]
pub(crate) fn projected_area_ggx_wide<W: Real>(w: Vector<W>, alpha_x: W, alpha_y: W) -> W {
    W::HALF * (w.z + stretched_length(w, alpha_x, alpha_y))
}

/// √(z² + (αx·x)² + (αy·y)²).
#[inline(always)]
fn stretched_length<W: Real>(w: Vector<W>, alpha_x: W, alpha_y: W) -> W {
    let stretched =
        Vector { x: Twofold::product(alpha_x, w.x), y: Twofold::product(alpha_y, w.y), z: Twofold::new(w.z) };
    (stretched.z.squared() + stretched.x.squared() + stretched.y.squared()).rounded().sqrt()
}

/// The projected area of a Beckmann microsurface that faces `w`, for 1 of macrosurface: cosθ·(1+Λ) = cosθ/G1.
///
/// $$\sigma = \cos\theta + \tfrac12 e^{-a^2}\left(\frac{s}{\sqrt\pi} - \cos\theta\,\mathrm{erfcx}(a)\right),\quad s^2 = \alpha_x^2x^2+\alpha_y^2y^2,\quad a = \cos\theta/s$$
///
/// In plain text: z + exp(−a²)·(s/√π − z·erfcx(a))/2. At normal incidence 1; at grazing α/(2√π). A
/// direction below the horizon counts as one on it.
///
/// Error in f32: ≤ 0.6 ULP. Source: Λ of Heitz 2014, eq. 66, with erf written so that nothing cancels.
#[inline(always)]
pub fn projected_area_beckmann<R: Real>(w: Vector<R>, alpha_x: R, alpha_y: R) -> R {
    R::narrow(projected_area_beckmann_wide::<_, R>(w.widen(), alpha_x.widen(), alpha_y.widen()))
}

#[inline(always)]
fn projected_area_beckmann_wide<W: Real, R: Real<Wide = W>>(w: Vector<W>, alpha_x: W, alpha_y: W) -> W {
    let (z, lambda) = beckmann_lambda::<_, R>(w, alpha_x, alpha_y);
    (Twofold::new(z) + lambda).rounded()
}

/// cosθ and cosθ·Λ of Beckmann's distribution.
#[inline(always)]
fn beckmann_lambda<W: Real, R: Real<Wide = W>>(w: Vector<W>, alpha_x: W, alpha_y: W) -> (W, Twofold<W>) {
    let (x, y) = (Twofold::product(alpha_x, w.x), Twofold::product(alpha_y, w.y));
    let stretched = (x.squared() + y.squared()).sqrt();
    let s = stretched.high;
    // From a = 7 on Λ < exp(−49)/(4·7³√π) < 3e-25 is below both precisions.
    let z = w.z.max(W::ZERO);
    let tilted = z.lt(W::from_f64(7.0) * s);
    let a = W::select(tilted, z, W::ZERO) / W::select(tilted, s, W::ONE);
    let frac_1_sqrt_pi = Twofold::constant(0.564_189_583_547_756_286_95);
    let lambda = (stretched * frac_1_sqrt_pi - Twofold::product(z, R::erfcx_wide(a))) * (W::HALF * (-(a * a)).exp());
    (z, Twofold::select(tilted, lambda, Twofold::new(W::ZERO)))
}

/// Kelemen's approximation of the visibility.
///
/// $$V = \frac{1}{4\,VH^2} = \frac{1}{|\omega_i+\omega_o|^2}$$
///
/// In plain text: V = 1/|h|² with h = wi + wo; G = 4·NL·NV·V is not bounded by 1.
///
/// Error in f32: ≤ 4 ULP, of which 3 are the rounding of `h`. Source: Kelemen & Szirmay-Kalos 2001, eq. 9; Elek 2010, §3.1 ("no G").
#[inline(always)]
pub fn kelemen<R: Real>(cos_i: R, cos_o: R, h: Vector<R>) -> Masking<R> {
    kelemen_wide(cos_i.widen(), cos_o.widen(), h.widen()).narrow()
}

#[inline(always)]
fn kelemen_wide<W: Real>(cos_i: W, cos_o: W, h: Vector<W>) -> Masking<W> {
    let inside = cos_i.gt(W::ZERO) & cos_o.gt(W::ZERO);
    let length_squared = Twofold::select(inside, h.carried().length_squared_carried(), Twofold::new(W::ONE));
    let visibility = W::ONE / length_squared.rounded();
    let g = (Twofold::product(W::from_f64(4.0) * cos_i, cos_o) / length_squared).rounded();
    Masking { g: W::select(inside, g, W::ZERO), visibility: W::select(inside, visibility, W::ZERO) }
}

/// G and V of correlated heights from cos·(½+Λ), what the projected areas exceed half their cosines by.
#[inline(always)]
fn correlated<R: Real>(cos_i: R, cos_o: R, excess_i: Twofold<R>, excess_o: Twofold<R>) -> Masking<R> {
    // cos_i·cos_o·(1+Λi+Λo), symmetric to the last bit.
    from_denominator(cos_i, cos_o, (excess_i * cos_o + excess_o * cos_i).rounded())
}

/// G and V of independent heights from the projected areas.
#[inline(always)]
fn separable<R: Real>(cos_i: R, cos_o: R, area_i: Twofold<R>, area_o: Twofold<R>) -> Masking<R> {
    from_denominator(cos_i, cos_o, (area_i * area_o).rounded())
}

/// G = NL·NV/d and V = 1/(4d).
#[inline(always)]
fn from_denominator<R: Real>(cos_i: R, cos_o: R, denominator: R) -> Masking<R> {
    let inside = cos_i.gt(R::ZERO) & cos_o.gt(R::ZERO);
    let inverse = R::ONE / R::select(inside, denominator, R::ONE);
    Masking {
        g: R::select(inside, (Twofold::product(cos_i, cos_o) * inverse).rounded().min(R::ONE), R::ZERO),
        visibility: R::select(inside, R::from_f64(0.25) * inverse, R::ZERO),
    }
}
