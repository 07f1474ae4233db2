//! The numbers that a shader is evaluated in: what WGSL's builtins need beside [`Real`].

use crate::real::{Mask, Real};

/// What is known of a `bool` that an interval leaves open; 0 and 1 are false and true.
pub(super) const OPEN: u32 = 2;

/// The whole numbers that a real one may become: a range, or anything.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(hidden)]
pub enum Whole {
    /// From the first to the second, as the bits of the type aimed at when truncated to 32.
    Range(i64, i64),
    /// Nothing is known.
    Anything,
}

impl Whole {
    pub(super) fn exactly(word: u32) -> Self {
        Whole::Range(i64::from(word), i64::from(word))
    }
}

/// A number type of the evaluator: `f32`, `f64`, or the intervals of [`crate::interval`].
///
/// The methods are WGSL's builtin functions of one component. For `f32` and `f64` they are those of the standard library;
/// intervals follow the accuracy table of the WGSL specification, section 15.7.4.
#[doc(hidden)]
pub trait Number: Real {
    /// Comparisons may stay undecided.
    const MAY_BE_OPEN: bool;
    /// The largest whole numbers below 2³¹ and 2³² that a conversion saturates to.
    const MOST: (i64, i64);

    /// Any value at all.
    fn anything() -> Self;
    /// The smallest set of values that holds both.
    fn hull(self, other: Self) -> Self;
    /// 0, 1 or [`OPEN`].
    fn truth(mask: Self::Mask) -> u32;
    /// `self == other`.
    fn equals(self, other: Self) -> Self::Mask;
    /// The value of an f32, exactly.
    fn from_single(value: f32) -> Self;
    /// This number as an operand: a subnormal one may count as 0.
    fn flushed(self) -> Self {
        self
    }
    /// The value of a whole number, rounded.
    fn from_whole(value: i64) -> Self;
    /// The bits of this number as an f32, where there is one answer.
    fn bits(self) -> Option<u32>;
    /// Truncated towards zero and clamped to a range.
    fn whole(self, low: i64, high: i64) -> Whole;
    /// Rounded to f32.
    fn narrowed(self) -> Self;
    /// Whether it may be NaN or infinite: 0, 1 or [`OPEN`].
    fn is_nan(self) -> u32;
    /// Whether it is infinite: 0, 1 or [`OPEN`].
    fn is_infinite(self) -> u32;

    /// 1/√x.
    fn inverse_sqrt(self) -> Self;
    /// 2ˣ.
    fn exp_two(self) -> Self;
    /// The logarithm to base 2.
    fn log_two(self) -> Self;
    /// xʸ.
    fn power(self, exponent: Self) -> Self;
    /// The sine.
    fn sine(self) -> Self;
    /// The cosine.
    fn cosine(self) -> Self;
    /// The tangent.
    fn tangent(self) -> Self;
    /// The arc sine.
    fn arc_sine(self) -> Self;
    /// The arc cosine.
    fn arc_cosine(self) -> Self;
    /// The arc tangent.
    fn arc_tangent(self) -> Self;
    /// The arc tangent of y/x in the quadrant of (x, y); `self` is y.
    fn arc_tangent_of(self, x: Self) -> Self;
    /// The hyperbolic sine.
    fn sine_h(self) -> Self;
    /// The hyperbolic cosine.
    fn cosine_h(self) -> Self;
    /// The hyperbolic tangent.
    fn tangent_h(self) -> Self;
    /// The inverse hyperbolic sine.
    fn arc_sine_h(self) -> Self;
    /// The inverse hyperbolic cosine.
    fn arc_cosine_h(self) -> Self;
    /// The inverse hyperbolic tangent.
    fn arc_tangent_h(self) -> Self;
    /// The largest whole number ≤ x.
    fn round_down(self) -> Self;
    /// The smallest whole number ≥ x.
    fn round_up(self) -> Self;
    /// The nearest whole number, the even one of two.
    fn round_even(self) -> Self;
    /// Without the fraction.
    fn round_to_zero(self) -> Self;
    /// −1, 0 or 1.
    fn sign(self) -> Self;
    /// x·y + z, with one rounding or two.
    fn multiply_add(self, y: Self, z: Self) -> Self;
    /// x·2ᵉ.
    fn scaled(self, exponent: i32) -> Self;
    /// The exponent e of x = m·2ᵉ with |m| in [1/2, 1), 0 for 0.
    fn exponent(self) -> Whole;
    /// Rounded to a number of binary16.
    fn quantized(self) -> Self;
    /// The bits of the number of binary16 that it is rounded to.
    fn half_bits(self) -> Whole;

    /// x(1−t) + y·t.
    #[inline(always)]
    fn mixed(self, y: Self, t: Self) -> Self {
        self * (Self::ONE - t) + y * t
    }
    /// x − ⌊x⌋.
    fn fraction(self) -> Self {
        self - self.round_down()
    }
    /// x − y·trunc(x/y).
    fn remainder(self, y: Self) -> Self {
        self - y * (self / y).round_to_zero()
    }
    /// One of two values by 0, 1 or [`OPEN`].
    #[inline(always)]
    fn chosen(truth: u32, yes: Self, no: Self) -> Self {
        if Self::MAY_BE_OPEN && truth == OPEN {
            yes.hull(no)
        } else if truth != 0 {
            yes
        } else {
            no
        }
    }
}

macro_rules! floats {
    ($float:ident, $most:expr) => {
        impl Number for $float {
            const MAY_BE_OPEN: bool = false;
            const MOST: (i64, i64) = $most;

            fn anything() -> Self {
                $float::NAN
            }
            fn hull(self, _: Self) -> Self {
                self
            }
            #[inline(always)]
            fn truth(mask: bool) -> u32 {
                u32::from(mask.all())
            }
            #[inline(always)]
            fn equals(self, other: Self) -> bool {
                self == other
            }
            #[inline(always)]
            fn from_single(value: f32) -> Self {
                value as $float
            }
            #[inline(always)]
            fn from_whole(value: i64) -> Self {
                value as $float
            }
            #[inline(always)]
            fn bits(self) -> Option<u32> {
                Some((self as f32).to_bits())
            }
            #[inline(always)]
            fn whole(self, low: i64, high: i64) -> Whole {
                let value = (self as i64).clamp(low, high);
                Whole::Range(value, value)
            }
            #[inline(always)]
            fn narrowed(self) -> Self {
                self as f32 as $float
            }
            fn is_nan(self) -> u32 {
                u32::from($float::is_nan(self))
            }
            fn is_infinite(self) -> u32 {
                u32::from($float::is_infinite(self))
            }
            #[inline(always)]
            fn inverse_sqrt(self) -> Self {
                1.0 / $float::sqrt(self)
            }
            fn exp_two(self) -> Self {
                self.exp2()
            }
            fn log_two(self) -> Self {
                self.log2()
            }
            fn power(self, exponent: Self) -> Self {
                self.powf(exponent)
            }
            fn sine(self) -> Self {
                self.sin()
            }
            fn cosine(self) -> Self {
                self.cos()
            }
            fn tangent(self) -> Self {
                self.tan()
            }
            fn arc_sine(self) -> Self {
                self.asin()
            }
            fn arc_cosine(self) -> Self {
                self.acos()
            }
            fn arc_tangent(self) -> Self {
                self.atan()
            }
            fn arc_tangent_of(self, x: Self) -> Self {
                self.atan2(x)
            }
            fn sine_h(self) -> Self {
                self.sinh()
            }
            fn cosine_h(self) -> Self {
                self.cosh()
            }
            fn tangent_h(self) -> Self {
                self.tanh()
            }
            fn arc_sine_h(self) -> Self {
                self.asinh()
            }
            fn arc_cosine_h(self) -> Self {
                self.acosh()
            }
            fn arc_tangent_h(self) -> Self {
                self.atanh()
            }
            fn round_down(self) -> Self {
                self.floor()
            }
            fn round_up(self) -> Self {
                self.ceil()
            }
            fn round_even(self) -> Self {
                self.round_ties_even()
            }
            fn round_to_zero(self) -> Self {
                self.trunc()
            }
            fn sign(self) -> Self {
                if self > 0.0 {
                    1.0
                } else if self < 0.0 {
                    -1.0
                } else {
                    0.0
                }
            }
            fn multiply_add(self, y: Self, z: Self) -> Self {
                self.mul_add(y, z)
            }
            fn scaled(self, exponent: i32) -> Self {
                // In three steps none of which overflows or rounds before the last.
                let step = exponent.clamp(-2100, 2100) / 3;
                let rest = exponent.clamp(-2100, 2100) - 2 * step;
                (f64::from(self) * 2f64.powi(step) * 2f64.powi(step) * 2f64.powi(rest)) as $float
            }
            fn exponent(self) -> Whole {
                Whole::exactly(exponent_of(f64::from(self)).cast_unsigned())
            }
            fn quantized(self) -> Self {
                half_value(half_of(f64::from(self))) as $float
            }
            fn half_bits(self) -> Whole {
                Whole::exactly(u32::from(half_of(f64::from(self))))
            }
        }
    };
}

floats!(f32, (2_147_483_520, 4_294_967_040));
floats!(f64, (2_147_483_647, 4_294_967_295));

/// e of x = m·2ᵉ with |m| in [1/2, 1); 0 for 0 and for what is not finite.
pub(super) fn exponent_of(x: f64) -> i32 {
    if x == 0.0 || !x.is_finite() {
        return 0;
    }
    let field = |x: f64| (x.to_bits() >> 52 & 0x7ff) as i32;
    // A subnormal is scaled into the normal numbers first.
    if field(x) == 0 { field(x * 2f64.powi(64)) - 64 - 1022 } else { field(x) - 1022 }
}

/// The bits of the binary16 number nearest to x, the even one of two; infinity where it is too large.
pub(super) fn half_of(x: f64) -> u16 {
    let sign = if x.is_sign_negative() { 0x8000 } else { 0 };
    let magnitude = x.abs();
    if x.is_nan() {
        return 0x7e00;
    }
    if magnitude >= 65520.0 {
        return sign | 0x7c00;
    }
    // The spacing of binary16 there; 2⁻²⁴ among its subnormals.
    // 0 has no exponent of its own: it is one of the subnormals.
    let exponent = if magnitude == 0.0 { -14 } else { (exponent_of(magnitude) - 1).max(-14) };
    let steps = (magnitude / 2f64.powi(exponent - 10)).round_ties_even() as u16;
    // Steps beyond the spacing carry into the exponent by themselves.
    sign | if exponent == -14 { steps } else { (((exponent + 15) as u16) << 10) + (steps - 1024) }
}

/// The value of a binary16 number.
pub(super) fn half_value(bits: u16) -> f64 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 0x3ff));
    let magnitude = match exponent {
        0 => fraction * 2f64.powi(-24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1024.0 + fraction) * 2f64.powi(exponent - 25),
    };
    if bits & 0x8000 == 0 { magnitude } else { -magnitude }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn binary16_round_trips() {
        for bits in 0..=u16::MAX {
            let value = half_value(bits);
            if !value.is_nan() {
                assert_eq!(half_of(value), bits, "{value}");
            }
        }
        // Halfway between 1 and the next: to even; past it: up.
        assert_eq!(half_of(1.0 + 2f64.powi(-11)), 0x3c00);
        assert_eq!(half_of(1.0 + 2f64.powi(-11) * 1.001), 0x3c01);
        assert_eq!(half_of(1.0 + 3.0 * 2f64.powi(-11)), 0x3c02);
        assert_eq!(half_of(65519.0), 0x7bff);
        assert_eq!(half_of(2f64.powi(-14) - 2f64.powi(-26)), 0x0400);
    }

    #[test]
    fn exponents_are_those_of_frexp() {
        for (x, want) in [(1.0, 1), (0.5, 0), (0.75, 0), (-8.0, 4), (0.0, 0), (f64::from(f32::MIN_POSITIVE), -125)] {
            assert_eq!(exponent_of(x), want, "{x}");
        }
        assert_eq!(exponent_of(5e-324), -1073);
        assert_eq!(1.5f32.scaled(-149), f32::from_bits(2));
        assert_eq!(1f64.scaled(1023), 2f64.powi(1023));
    }
}
