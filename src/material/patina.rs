//! The documents' patina (Elek 2010, §4.2).

use crate::real::Real;

/// How far patina has grown at a point, in [0, 1].
///
/// $$1 - \mathrm{smoothstep}(e - t,\; e + t,\; v)$$
///
/// In plain text: 1 − smoothstep(extent − transition, extent + transition, value).
///
/// * `value`: the growth map at the point, in [0, 1]. `extent` in about [−1, 2]: how far patina has come.
/// * `transition` ≥ 0: the softness of its edge. At 0 the edge is sharp and `value` = `extent` counts as grown (1);
///   as printed it is 0/0 there (erratum 13).
///
/// Source: Elek 2010, §4.2, listing 2.
#[inline]
pub fn patina_extent<R: Real>(extent: R, transition: R, value: R) -> R {
    let (low, width) = (extent - transition, R::TWO * transition);
    let sharp = width.le(R::ZERO);
    let t = ((value - low) / R::select(sharp, R::ONE, width)).saturate();
    let soft = R::ONE - t * t * (R::from_f64(3.0) - R::TWO * t);
    R::select(sharp, R::select(value.le(extent), R::ONE, R::ZERO), soft)
}
