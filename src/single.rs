//! f32 in every step: the cheap instance of the terms, and the one that vectorises.
//!
//! Over `f32` a term computes in double precision and rounds once. Over [`Single`] the same formula runs in f32
//! throughout, as its WGSL twin does, and each term loses what `docs/accuracy.md` lists, a few ULP for most and 4 ULP for
//! each unit of an exponent. Nothing in it branches or calls: in a loop over many evaluations the compiler turns it into
//! vector instructions, which is what [`batch`](crate::batch) is made of.

use crate::batch::lanes;
use crate::real::{Real, Sealed};
use crate::series::{angle_short, erfcx_single};
use core::ops::{Add, Div, Mul, Neg, Sub};

/// An f32 whose terms compute in f32 throughout; `FUSED` where the processor is known to multiply and add in one instruction.
///
/// A term that overflows is infinite here, where over `f32` it is the largest finite number. Of NaN and another number
/// `min` and `max` return the argument, whichever of the two it is.
///
/// `Single<true>` on a processor without that instruction is right, and very slow.
///
/// ```
/// use brdf::{Vector, distribution, single::Single};
///
/// let h = Vector::new(0.1f32, 0.2, 0.9);
/// let exact = distribution::ggx(h, 0.3);
/// let Single(cheap) = distribution::ggx::<Single>(h.cast(), Single(0.3));
/// assert!((exact - cheap).abs() <= 12.0 * f32::EPSILON * exact);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
#[repr(transparent)]
pub struct Single<const FUSED: bool = false>(
    /// The number.
    pub f32,
);

macro_rules! operator {
    ($trait:ident, $method:ident, $op:tt) => {
        impl<const FUSED: bool> $trait for Single<FUSED> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Single(self.0 $op other.0)
            }
        }
    };
}
operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl<const FUSED: bool> Neg for Single<FUSED> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Single(-self.0)
    }
}

impl<const FUSED: bool> From<f32> for Single<FUSED> {
    #[inline(always)]
    fn from(x: f32) -> Self {
        Single(x)
    }
}

impl<const FUSED: bool> From<Single<FUSED>> for f32 {
    #[inline(always)]
    fn from(x: Single<FUSED>) -> Self {
        x.0
    }
}

impl<const FUSED: bool> Sealed for Single<FUSED> {}
impl<const FUSED: bool> Real for Single<FUSED> {
    type Mask = bool;
    type Wide = Self;

    const ZERO: Self = Single(0.0);
    const ONE: Self = Single(1.0);
    const HALF: Self = Single(0.5);
    const TWO: Self = Single(2.0);
    const PI: Self = Single(<f32 as Real>::PI);
    const FRAC_1_PI: Self = Single(<f32 as Real>::FRAC_1_PI);
    const EPSILON: Self = Single(<f32 as Real>::EPSILON);
    const EXP_LIMIT: Self = Single(<f32 as Real>::EXP_LIMIT);

    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        Single(x as f32)
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self.0)
    }
    #[inline(always)]
    fn widen(self) -> Self {
        self
    }
    #[inline(always)]
    fn narrow(wide: Self) -> Self {
        wide
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Single(Real::sqrt(self.0))
    }
    /// 0 below −87.3, where the result would be subnormal, and infinite above 88. Error: ≤ 1 ULP.
    #[inline(always)]
    fn exp(self) -> Self {
        lanes::exp(self)
    }
    #[inline(always)]
    fn exp_within(self) -> Self {
        lanes::exp_within(self)
    }
    /// −∞ at 0 and for subnormal numbers, NaN below. Error: ≤ 2 ULP.
    #[inline(always)]
    fn ln(self) -> Self {
        lanes::ln(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Single(self.0.abs())
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self.0 < other.0 { self } else { other }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self.0 > other.0 { self } else { other }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self.0 < other.0
    }
    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self.0 <= other.0
    }
    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        #[cfg(feature = "std")]
        if FUSED {
            return Single(f32::mul_add(self.0, factor.0, addend.0));
        }
        Single(self.0 * factor.0 + addend.0)
    }
    #[inline(always)]
    fn product_exact(self, other: Self) -> (Self, Self) {
        #[cfg(feature = "std")]
        if FUSED {
            let product = self * other;
            return (product, Single(f32::mul_add(self.0, other.0, -product.0)));
        }
        let (product, error) = self.0.product_exact(other.0);
        (Single(product), Single(error))
    }
    /// Error: ≤ 2 ULP for x ≥ −1/2.
    #[inline(always)]
    fn ln_one_plus(self) -> Self {
        lanes::ln_one_plus(self)
    }
    #[inline(always)]
    fn angle(self, adjacent: Self) -> Self {
        angle_short(self, adjacent)
    }
    #[inline(always)]
    fn unit_circle(self) -> (Self, Self) {
        let (cosine, sine) = self.0.unit_circle();
        (Single(cosine), Single(sine))
    }
    #[inline(always)]
    fn product_wide(a: Self, b: Self) -> (Self, Self) {
        a.product_exact(b)
    }
    #[inline(always)]
    fn angle_wide(opposite: Self, adjacent: Self) -> Self {
        angle_short(opposite, adjacent)
    }
    #[inline(always)]
    fn erfcx_wide(x: Self) -> Self {
        erfcx_single(x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Vector, fresnel, masking};

    /// The largest error of a function in ULP over every `step`th f32 of [from, to], against f64's.
    fn worst(from: f32, to: f32, step: usize, got: impl Fn(f32) -> f32, want: impl Fn(f64) -> f64) -> (f64, f32) {
        let key = |x: f32| {
            let bits = x.to_bits() as i32;
            i64::from(if bits < 0 { i32::MIN - bits } else { bits })
        };
        let number = |key: i64| f32::from_bits(if key < 0 { i32::MIN - key as i32 } else { key as i32 } as u32);
        let (mut worst, mut at) = (0.0, 0.0);
        for key in (key(from)..=key(to)).step_by(step) {
            let x = number(key);
            let exact = want(f64::from(x));
            let ulp = (exact.abs() as f32).next_up() - exact.abs() as f32;
            let error = (f64::from(got(x)) - exact).abs() / f64::from(ulp);
            if error.is_nan() || error > worst {
                (worst, at) = (error, x);
            }
        }
        (worst, at)
    }

    fn elementary_functions_keep_their_bounds<const FUSED: bool>() {
        let s = Single::<FUSED>;
        let (error, at) = worst(-87.0, 88.0, 997, |x| s(x).exp().0, f64::exp);
        assert!(error <= 1.0, "exp {at}: {error}");
        let (error, at) = worst(f32::MIN_POSITIVE, f32::MAX, 997, |x| s(x).ln().0, f64::ln);
        assert!(error <= 2.0, "ln {at}: {error}");
        let (error, at) = worst(-0.5, 1e30, 997, |x| s(x).ln_one_plus().0, f64::ln_1p);
        assert!(error <= 2.0, "ln_one_plus {at}: {error}");
        let (error, at) = worst(0.0, 1e20, 997, |x| s(x).angle(Single(1.0)).0, f64::atan);
        assert!(error <= 3.0, "angle {at}: {error}");
    }

    #[test]
    fn elementary_functions_keep_their_bounds_unfused() {
        elementary_functions_keep_their_bounds::<false>();
    }

    #[test]
    fn elementary_functions_keep_their_bounds_fused() {
        elementary_functions_keep_their_bounds::<true>();
    }

    #[test]
    fn elementary_functions_end_as_they_should() {
        let s = Single::<false>;
        for (got, want) in [
            (s(-1e30).exp(), 0.0),
            (s(f32::NEG_INFINITY).exp(), 0.0),
            (s(0.0).exp(), 1.0),
            (s(1e30).exp(), f32::INFINITY),
            (s(0.0).ln(), f32::NEG_INFINITY),
            (s(1.0).ln(), 0.0),
            (s(f32::INFINITY).ln(), f32::INFINITY),
            (s(0.0).ln_one_plus(), 0.0),
            (s(-1.0).ln_one_plus(), f32::NEG_INFINITY),
            (s(f32::INFINITY).ln_one_plus(), f32::INFINITY),
            (s(0.0).angle(s(0.0)), 0.0),
            (s(f32::NAN).saturate(), 0.0),
        ] {
            assert_eq!(got.0, want);
        }
        for nan in [s(f32::NAN).exp(), s(f32::NAN).ln(), s(-1.0).ln(), s(f32::NAN).ln_one_plus(), s(-2.0).ln_one_plus()]
        {
            assert!(nan.0.is_nan());
        }
    }

    #[test]
    fn terms_stay_close_to_those_of_f32() {
        for i in 1..2000 {
            let c = i as f32 / 2000.0;
            let single = Single::<false>;
            let (exact, cheap) =
                (fresnel::conductor(c, 1.04, 2.59), fresnel::conductor(single(c), Single(1.04), Single(2.59)));
            for (exact, Single(cheap)) in
                [(exact.reflectance, cheap.reflectance), (exact.transmittance, cheap.transmittance)]
            {
                assert!((exact - cheap).abs() <= 16.0 * f32::EPSILON * exact, "{c}: {exact} {cheap}");
            }
            let w = Vector::new((1.0 - c * c).sqrt(), 0.0, c);
            let exact = masking::projected_area_beckmann(w, 0.3, 0.3);
            let Single(cheap) = masking::projected_area_beckmann(w.cast(), single(0.3), Single(0.3));
            assert!((exact - cheap).abs() <= 6.0 * f32::EPSILON * exact, "{c}: {exact} {cheap}");
        }
    }
}
