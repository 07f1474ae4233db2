//! Masks: how much of a covering material lies at a point, by a grey value there.
//!
//! A mask is 0 where the ground shows (the metal) and 1 where the cover does (rust, patina, dirt, the scratched material); between, both
//! are blended by it. Mihaylov 2013 says both that white is the metal (§4.3, the text) and that grey ≤ 0.5 is (the listing below
//! fig. 41): erratum 23. Here it is the listing's way: [`threshold`]`(value, 0.5)` is 0 up to 0.5, and that is the metal.
//!
//! Values may be any finite numbers; no result is ever NaN, whatever the arguments.

use crate::real::Real;

/// A hard mask: 0 (the ground) where value ≤ at, else 1 (the cover).
///
/// `maskDiffuse` of Mihaylov 2013, §4.3, with `at` = 0.5. Discontinuous at `at`.
#[inline]
pub fn threshold<R: Real>(value: R, at: R) -> R {
    R::select(value.gt(at), R::ONE, R::ZERO)
}

/// A mask with a soft edge: 0 below at − softness, 1 above at + softness.
///
/// $$\mathrm{smoothstep}(a - s,\; a + s,\; v) = t^2(3 - 2t),\qquad t = \mathrm{saturate}\frac{v - (a - s)}{2s}$$
///
/// In plain text: smoothstep(at − softness, at + softness, value).
///
/// With `softness` ≤ 0 it is [`threshold`], where smoothstep is 0/0. Slope at most 3/(4·softness). Equal to 1 −
/// [`patina_extent`](crate::material::patina::patina_extent)(at, softness, value).
#[inline]
pub fn soft_threshold<R: Real>(value: R, at: R, softness: R) -> R {
    let sharp = softness.le(R::ZERO);
    let width = R::TWO * R::select(sharp, R::HALF, softness);
    let t = ((value - (at - softness)) / width).saturate();
    R::select(sharp, threshold(value, at), t * t * (R::from_f64(3.0) - R::TWO * t))
}

/// A grey mask by levels: 0 at `black`, 1 at `white`, linear between and constant beyond.
///
/// $$\mathrm{saturate}\frac{v - b}{w - b}$$
///
/// In plain text: saturate((value − black)/(white − black)).
///
/// With `white` < `black` the mask is inverted; where they are equal it is [`threshold`] at `black`.
#[inline]
pub fn grey<R: Real>(value: R, black: R, white: R) -> R {
    let width = white - black;
    let sharp = !(width.lt(R::ZERO) | width.gt(R::ZERO));
    let t = ((value - black) / R::select(sharp, R::ONE, width)).saturate();
    R::select(sharp, threshold(value, black), t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::patina::patina_extent;

    #[test]
    fn the_listing_decides_which_side_is_the_metal() {
        assert_eq!(threshold(0.5, 0.5), 0.0);
        assert_eq!(threshold(0.5f32.next_up(), 0.5), 1.0);
        assert_eq!(soft_threshold(0.5, 0.5, 0.0), 0.0);
        assert_eq!(soft_threshold(0.5f32.next_up(), 0.5, 0.0), 1.0);
        assert_eq!(soft_threshold(0.5f32.next_up(), 0.5, -1.0), 1.0);
        assert_eq!(grey(0.5, 0.5, 0.5), 0.0);
    }

    #[test]
    fn the_soft_edge_is_the_integral_of_a_parabola() {
        // smoothstep's slope is 6t(1 − t)/(2s): at the middle 3/(4s), 0 at both ends.
        for softness in [0.01, 0.25, 2.0] {
            for (offset, want) in [(-1.0, 0.0), (-0.5, 0.15625), (0.0, 0.5), (0.5, 0.84375), (1.0, 1.0), (7.0, 1.0)] {
                let got = soft_threshold(0.3 + offset * softness, 0.3, softness);
                // value − at loses 2⁻⁵⁴ of numbers up to 15, over a width of 2·softness, times the slope 3/2 of t²(3 − 2t).
                assert!((got - want).abs() <= 15.0 * f64::EPSILON / softness, "{offset} {softness}: {got} {want}");
            }
            let h = 1e-6 * softness;
            let slope = (soft_threshold(0.3 + h, 0.3, softness) - soft_threshold(0.3 - h, 0.3, softness)) / (2.0 * h);
            // The third derivative, −12/(2s)³, leaves 2h²/(2s)³; rounding leaves 15 ε/(s·h).
            let room = 2.0 * h * h / (2.0 * softness).powi(3) + 15.0 * f64::EPSILON / (softness * h);
            assert!((slope - 0.75 / softness).abs() <= room, "{slope} {softness}");
        }
    }

    #[test]
    fn a_mask_is_what_the_patina_leaves() {
        for i in 0..200 {
            let value = f64::from(i) / 100.0 - 0.5;
            for (at, softness) in [(0.5, 0.2), (0.0, 1.0), (0.3, 0.0)] {
                let sum = soft_threshold(value, at, softness) + patina_extent(at, softness, value);
                assert!((sum - 1.0).abs() <= f64::EPSILON, "{value} {at} {softness}: {sum}");
            }
        }
    }

    #[test]
    fn levels_are_linear_and_may_be_inverted() {
        for (value, black, white, want) in [
            (0.25, 0.0, 0.5, 0.5),
            (0.25, 0.5, 0.0, 0.5),
            (0.1, 0.5, 0.0, 0.8),
            (-1.0, 0.5, 0.0, 1.0),
            (2.0, 0.0, 1.0, 1.0),
            (0.7, 0.7, 0.7, 0.0),
            (0.8, 0.7, 0.7, 1.0),
        ] {
            assert!((grey(value, black, white) - want).abs() <= f64::EPSILON, "{value} {black} {white}");
        }
    }

    #[test]
    fn nothing_is_nan() {
        let wild = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            1e-45,
            f32::MIN_POSITIVE,
            f32::MAX,
            f32::MIN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::NAN,
        ];
        for a in wild {
            for b in wild {
                for c in wild {
                    for mask in [threshold(a, b), soft_threshold(a, b, c), grey(a, b, c)] {
                        assert!((0.0..=1.0).contains(&mask), "{a} {b} {c}: {mask}");
                    }
                }
            }
        }
    }
}
