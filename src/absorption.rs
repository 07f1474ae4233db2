//! Absorption along the two legs of a path through a layer.
//!
//! Twin: `wgsl/absorption.wgsl`.

use crate::real::Real;

/// The fraction of light that a layer lets through on the way in and out (Bouguer–Lambert–Beer).
///
/// $$a = e^{-\sigma d\,(1/c_i + 1/c_o)}$$
///
/// In plain text: a = exp(−σ·d·(1/cos_i + 1/cos_o)).
///
/// * `sigma` ≥ 0: absorption coefficient in 1/length. `thickness` ≥ 0: in the same length. Where either is 0: 1.
/// * `cos_i`, `cos_o` in [0, 1]: cosines of both directions *inside* the layer. At 0, with σ·d > 0: 0.
///
/// 0 where the argument exceeds 87 (f32) or 708 (f64). Error in f32: ≤ 3 + 3·x ULP for the argument x: its factors are
/// rounded. Source: Elek 2010, eq. 3 with N·L′ and N·V′ (erratum 8).
#[inline]
pub fn transmittance<R: Real>(sigma: R, thickness: R, cos_i: R, cos_o: R) -> R {
    let clear = sigma.le(R::ZERO) | thickness.le(R::ZERO);
    let blocked = cos_i.le(R::ZERO) | cos_o.le(R::ZERO);
    let guard = |x: R| R::select(blocked, R::ONE, x);
    let path = R::ONE / guard(cos_i) + R::ONE / guard(cos_o);
    let depth = R::select(clear, R::ZERO, sigma * thickness);
    R::select(clear, R::ONE, R::select(blocked, R::ZERO, depth.exp_product(path)))
}
