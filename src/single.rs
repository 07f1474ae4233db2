//! f32 in every step: the cheap instance of the terms.
//!
//! Over `f32` a term computes in double precision and rounds once. Over [`Single`] the same formula runs in f32
//! throughout, as its WGSL twin does: in a loop that vectorises it is two to three times faster, and each term loses what
//! `docs/accuracy.md` lists, a few ULP for most and 4 ULP for each unit of an exponent.

use crate::real::{Real, Sealed};
use crate::series::erfcx_single;
use core::ops::{Add, Div, Mul, Neg, Sub};

/// An f32 whose terms compute in f32 throughout.
///
/// A term that overflows is infinite here, where over `f32` it is the largest finite number.
///
/// ```
/// use brdf::{Vector, distribution, single::Single};
///
/// let h = Vector::new(0.1f32, 0.2, 0.9);
/// let (exact, cheap) = (distribution::ggx(h, 0.3), distribution::ggx(h.cast(), Single(0.3)).0);
/// assert!((exact - cheap).abs() <= 12.0 * f32::EPSILON * exact);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
#[repr(transparent)]
pub struct Single(
    /// The number.
    pub f32,
);

macro_rules! operator {
    ($trait:ident, $method:ident, $op:tt) => {
        impl $trait for Single {
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

impl Neg for Single {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Single(-self.0)
    }
}

impl From<f32> for Single {
    #[inline(always)]
    fn from(x: f32) -> Self {
        Single(x)
    }
}

impl From<Single> for f32 {
    #[inline(always)]
    fn from(x: Single) -> Self {
        x.0
    }
}

/// Methods that are f32's own.
macro_rules! delegate {
    ($($method:ident($($other:ident)?)),*) => {$(
        #[inline(always)]
        fn $method(self $(, $other: Self)?) -> Self {
            Single(Real::$method(self.0 $(, $other.0)?))
        }
    )*};
}

impl Sealed for Single {}
impl Real for Single {
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

    delegate!(sqrt(), exp(), ln(), abs(), ln_one_plus(), min(other), max(other), angle(adjacent));

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
    fn product_exact(self, other: Self) -> (Self, Self) {
        let (product, error) = self.0.product_exact(other.0);
        (Single(product), Single(error))
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
        opposite.angle(adjacent)
    }
    #[inline(always)]
    fn erfcx_wide(x: Self) -> Self {
        Single(erfcx_single(x.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Vector, fresnel, masking};

    #[test]
    fn terms_stay_close_to_those_of_f32() {
        for i in 1..2000 {
            let c = i as f32 / 2000.0;
            let (exact, cheap) =
                (fresnel::conductor(c, 1.04, 2.59), fresnel::conductor(Single(c), Single(1.04), Single(2.59)));
            for (exact, Single(cheap)) in
                [(exact.reflectance, cheap.reflectance), (exact.transmittance, cheap.transmittance)]
            {
                assert!((exact - cheap).abs() <= 16.0 * f32::EPSILON * exact, "{c}: {exact} {cheap}");
            }
            let w = Vector::new((1.0 - c * c).sqrt(), 0.0, c);
            let exact = masking::projected_area_beckmann(w, 0.3, 0.3);
            let Single(cheap) = masking::projected_area_beckmann(w.cast(), Single(0.3), Single(0.3));
            assert!((exact - cheap).abs() <= 6.0 * f32::EPSILON * exact, "{c}: {exact} {cheap}");
        }
    }
}
