//! Phong and Blinn–Phong lobes, normalised: the comparators that the documents measure their cost against.
//!
//! Twin: `wgsl/phong.wgsl`. Directions are local unit vectors; where a cosine is ≤ 0 the result is 0. Powers are
//! exp(n·ln(1+x)) of the small difference to the lobe's axis, accurate for exponents of 10⁶ and without `pow`.

use crate::frame::Vector;
use crate::real::Real;

/// Phong's lobe about the mirror direction, in sr⁻¹, reciprocal and of albedo ≤ 1.
///
/// $$f = \frac{n+2}{2\pi}\,\max(0, R\cdot V)^n$$
///
/// In plain text: f = (n+2)/(2π)·max(0, R·V)ⁿ with R = L mirrored about the normal. `exponent` n ≥ 0.
///
/// Error in f32: ≤ 7 + 5.5·n·(1/R·V − 1) ULP. Source: Phong 1975; Lafortune & Willems 1994, eq. 7; Mihaylov 2013, §3.1.
#[inline]
pub fn phong<R: Real>(wi: Vector<R>, wo: Vector<R>, exponent: R) -> R {
    // 1 − R·V = |R−V|²/2 with R = (−x, −y, z).
    let difference = Vector::new(wi.x + wo.x, wi.y + wo.y, wi.z - wo.z);
    let deficit = R::HALF * difference.length_squared();
    let lit = wi.z.gt(R::ZERO) & wo.z.gt(R::ZERO) & deficit.lt(R::ONE);
    let log = (-R::select(lit, deficit, R::ZERO)).ln_one_plus();
    let argument = exponent * -log;
    let power = R::select(argument.le(R::EXP_LIMIT), (-argument).exp(), R::ZERO);
    R::select(lit, R::HALF * (exponent + R::TWO) * R::FRAC_1_PI * power, R::ZERO)
}

/// Blinn's variant of Phong's lobe, about the half vector, in sr⁻¹.
///
/// $$f = \frac{(n+2)(n+4)}{8\pi(n+2^{-n/2})}\,NH^n$$
///
/// In plain text: f = (n+2)(n+4)/(8π(n+2^(−n/2)))·NHⁿ, normalised to albedo 1 at normal incidence, where it is largest.
/// `exponent` n ≥ 0. The widespread factor (n+8)/(8π) is not a normalisation: its albedo is 1.075 at n = 10.
///
/// Error in f32: ≤ 8 + 5.5·|ln NHⁿ| ULP. Source: Blinn 1977; the factor: Gotanda 2010 ("Practical implementation at tri-Ace"), §2.
#[inline]
pub fn blinn_phong<R: Real>(wi: Vector<R>, wo: Vector<R>, exponent: R) -> R {
    let lit = wi.z.gt(R::ZERO) & wo.z.gt(R::ZERO);
    let h = wi + wo;
    let z = R::select(lit, h.z, R::ONE);
    // NHⁿ = exp(−(n/2)·ln(1+tan²)).
    let argument = R::HALF * exponent * (R::select(lit, h.sin_squared(), R::ZERO) / (z * z)).ln_one_plus();
    let power = R::select(argument.le(R::EXP_LIMIT), (-argument).exp(), R::ZERO);
    let half_ln_2 = R::from_f64(0.346_573_590_279_972_654_7);
    let denominator = exponent + (-(half_ln_2 * exponent)).exp();
    let factor = (exponent + R::TWO) * (exponent + R::from_f64(4.0)) / (R::from_f64(8.0) * R::PI * denominator);
    R::select(lit, factor * power, R::ZERO)
}
