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

/// The diffuse light of the patina as the listing adds it to its upper layer: a radiance π·f·NL for a light of irradiance π.
///
/// $$(1-\sigma)(1-F_1)\,NL$$
///
/// In plain text: (1−σ)·(1−F₁)·max(NL, 0); f = (1−σ)(1−F₁)/π.
///
/// * `sigma`: the absorption of the film, in [0, 1] as the listing uses it. `fresnel`: F₁, the reflectance of the patina's
///   surface at V·H, in [0, 1]. `cos_i`: NL, counted as 0 below the horizon.
///
/// As printed (erratum 12): for σ > 1 it is *negative*, and what it scatters is not taken from the light that goes on to
/// the metal, so that patina and metal together reflect up to 3.8 times what arrives. A film that conserves energy is
/// [`film`](super::kubelka_munk::film) as the base under a dielectric.
///
/// Error in f32: ≤ 0.6 ULP. Source: Elek 2010, §4.2, listing 3.
#[inline]
pub fn diffuse_as_printed<R: Real>(sigma: R, fresnel: R, cos_i: R) -> R {
    let (sigma, fresnel, cos_i) = (sigma.widen(), fresnel.widen(), cos_i.widen());
    R::narrow((R::Wide::ONE - sigma) * (R::Wide::ONE - fresnel) * cos_i.max(R::Wide::ZERO))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_printed_term_is_what_the_listing_says() {
        // By hand: (1 − 0.25)(1 − 0.5)·0.5.
        assert_eq!(diffuse_as_printed(0.25f32, 0.5, 0.5), 0.1875);
        assert_eq!(diffuse_as_printed(0.25, 0.5, -0.5), 0.0);
        assert_eq!(diffuse_as_printed(0.25, 1.0, 1.0), 0.0);
        // The erratum: a strong film gives less than no light.
        assert_eq!(diffuse_as_printed(3.0, 0.0, 1.0), -2.0);
        // White, and nothing reflected above it: all the light, which the metal below gets once more.
        assert_eq!(diffuse_as_printed(0.0, 0.0, 1.0), 1.0);
    }
}
