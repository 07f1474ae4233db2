//! Phong and Blinn–Phong lobes, normalised: the comparators that the documents measure their cost against.
//!
//! Twin: `wgsl/phong.wgsl`. Directions are local unit vectors; where a cosine is ≤ 0 the result is 0. Powers are
//! exp(n·ln(1+x)) of the small difference to the lobe's axis, accurate for exponents of 10⁶ and without `pow`.

use crate::frame::Vector;
use crate::real::Real;
use crate::twofold::Twofold;

/// Phong's lobe about the mirror direction, in sr⁻¹, reciprocal and of albedo ≤ 1.
///
/// $$f = \frac{n+2}{2\pi}\,\max(0, R\cdot V)^n$$
///
/// In plain text: f = (n+2)/(2π)·max(0, R·V)ⁿ with R = L mirrored about the normal. `exponent` n ≥ 0.
///
/// Error in f32: ≤ 0.6 ULP. Source: Phong 1975; Lafortune & Willems 1994, eq. 7; Mihaylov 2013, §3.1.
#[inline(always)]
pub fn phong<R: Real>(wi: Vector<R>, wo: Vector<R>, exponent: R) -> R {
    R::narrow(phong_wide::<_, R>(wi.widen(), wo.widen(), exponent.widen()))
}

#[inline(always)]
fn phong_wide<W: Real, R: Real<Wide = W>>(wi: Vector<W>, wo: Vector<W>, exponent: W) -> W {
    // 1 − R·V = |R−V|²/2 with R = (−x, −y, z).
    let difference = Vector::new(wi.x, wi.y, wi.z).sum_carried(Vector::new(wo.x, wo.y, -wo.z));
    let deficit = difference.length_squared_carried() * W::HALF;
    let cosine = Twofold::new(W::ONE) - deficit;
    let lit = wi.z.gt(W::ZERO) & wo.z.gt(W::ZERO) & cosine.high.gt(W::ZERO);
    let log = Twofold::select(lit, -deficit, Twofold::new(W::ZERO)).ln_one_plus();
    let argument = -log * exponent;
    let power = W::select(argument.high.le(R::EXP_LIMIT.widen()), argument.exp_negative(), W::ZERO);
    W::select(lit, W::HALF * (exponent + W::TWO) * W::FRAC_1_PI * power, W::ZERO)
}

/// Blinn's variant of Phong's lobe, about the half vector, in sr⁻¹.
///
/// $$f = \frac{(n+2)(n+4)}{8\pi(n+2^{-n/2})}\,NH^n$$
///
/// In plain text: f = (n+2)(n+4)/(8π(n+2^(−n/2)))·NHⁿ, normalised to albedo 1 at normal incidence, where it is largest.
/// `exponent` n ≥ 0. The widespread factor (n+8)/(8π) is not a normalisation: its albedo is 1.075 at n = 10.
///
/// Error in f32: ≤ 0.6 ULP. Source: Blinn 1977; the factor: Gotanda 2010 ("Practical implementation at tri-Ace"), §2.
#[inline(always)]
pub fn blinn_phong<R: Real>(wi: Vector<R>, wo: Vector<R>, exponent: R) -> R {
    R::narrow(blinn_phong_wide::<_, R>(wi.widen(), wo.widen(), exponent.widen()))
}

#[inline(always)]
fn blinn_phong_wide<W: Real, R: Real<Wide = W>>(wi: Vector<W>, wo: Vector<W>, exponent: W) -> W {
    let lit = wi.z.gt(W::ZERO) & wo.z.gt(W::ZERO);
    let h = wi.sum_carried(wo);
    let z = Twofold::select(lit, h.z, Twofold::new(W::ONE));
    let sin_squared = Twofold::select(lit, h.sin_squared_carried(), Twofold::new(W::ZERO));
    // NHⁿ = exp(−(n/2)·ln(1+tan²)).
    let argument = (sin_squared / z.squared()).ln_one_plus() * (W::HALF * exponent);
    let power = W::select(argument.high.le(R::EXP_LIMIT.widen()), argument.exp_negative(), W::ZERO);
    let half_ln_2 = W::from_f64(0.346_573_590_279_972_654_7);
    let denominator = exponent + (-(half_ln_2 * exponent)).exp();
    let factor = (exponent + W::TWO) * (exponent + W::from_f64(4.0)) / (W::from_f64(8.0) * W::PI * denominator);
    W::select(lit, factor * power, W::ZERO)
}
