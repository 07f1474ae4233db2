//! Absorption along the two legs of a path through a layer.
//!
//! Twin: `wgsl/absorption.wgsl`.

use crate::real::Real;
use crate::twofold::Twofold;

/// The fraction of light that a layer lets through on the way in and out (Bouguer–Lambert–Beer).
///
/// $$a = e^{-\sigma d\,(1/c_i + 1/c_o)}$$
///
/// In plain text: a = exp(−σ·d·(1/cos_i + 1/cos_o)).
///
/// * `sigma` ≥ 0: absorption coefficient in 1/length. `thickness` ≥ 0: in the same length. Where either is 0: 1.
/// * `cos_i`, `cos_o` in [0, 1]: cosines of both directions *inside* the layer. At 0, with σ·d > 0: 0.
///
/// 0 where the argument exceeds 87 (f32) or 708 (f64). Error in f32: ≤ 0.6 ULP. Source: Elek 2010, eq. 3 with N·L′ and N·V′ (erratum 8).
#[inline(always)]
pub fn transmittance<R: Real>(sigma: R, thickness: R, cos_i: R, cos_o: R) -> R {
    R::narrow(transmittance_wide::<_, R>(sigma.widen(), thickness.widen(), cos_i.widen(), cos_o.widen()))
}

/// [`transmittance`] in the numbers that it computes with.
#[inline(always)]
pub(crate) fn transmittance_wide<W: Real, R: Real<Wide = W>>(sigma: W, thickness: W, cos_i: W, cos_o: W) -> W {
    let clear = sigma.le(W::ZERO) | thickness.le(W::ZERO);
    let blocked = cos_i.le(W::ZERO) | cos_o.le(W::ZERO);
    let guard = |x: W| W::select(blocked, W::ONE, x);
    let one = Twofold::new(W::ONE);
    let path = one / guard(cos_i) + one / guard(cos_o);
    let depth = Twofold::select(clear, Twofold::new(W::ZERO), Twofold::product(sigma, thickness));
    let passed = if W::CARRIES {
        let exponent = depth * path;
        W::select(exponent.high.le(R::EXP_LIMIT.widen()), exponent.exp_negative(), W::ZERO)
    } else {
        R::exp_product_wide(depth.high, path.high)
    };
    W::select(clear, W::ONE, W::select(blocked, W::ZERO, passed))
}
