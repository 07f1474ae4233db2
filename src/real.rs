//! The numbers that the formulas are written over.
//!
//! Every term of this crate is one generic function over [`Real`]. With `f32` it is what a renderer runs, with `f64` it
//! is the oracle that error is measured against. Data-dependent choices are selects on a [`Mask`], never branches, so
//! that the same source serves numbers whose comparisons have more than one answer (lanes, intervals).
//!
//! WGSL has no accurate `log(1+x)`, no usable arc functions and no complementary error function; `wgsl/real.wgsl`
//! supplies [`Real::ln_one_plus`], [`Real::angle`], [`Real::erfcx`], [`Real::exp_product`] and [`Real::unit_circle`] under the
//! same names.

use core::fmt::Debug;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Only this crate adds numbers: each formula is checked for each of them.
#[doc(hidden)]
pub trait Sealed {}
impl Sealed for f32 {}
impl Sealed for f64 {}
impl Sealed for bool {}

/// The answer of a comparison between two [`Real`]s.
pub trait Mask: Copy + Not<Output = Self> + BitAnd<Output = Self> + BitOr<Output = Self> + Sealed {
    /// True in every lane.
    fn all(self) -> bool;
    /// True in some lane.
    fn any(self) -> bool;
}

impl Mask for bool {
    #[inline(always)]
    fn all(self) -> bool {
        self
    }
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
}

/// A real number that the reflectance formulas run over. Sealed: `f32`, `f64` and [`WgslInterval`](crate::interval::WgslInterval).
///
/// Methods follow IEEE 754: `sqrt` is correctly rounded, the transcendental functions are those of the standard library
/// or, with the feature `libm` and without `std`, of libm (each ≤ 1 ULP there).
pub trait Real:
    Copy
    + Debug
    + PartialEq
    + Default
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Sealed
{
    /// What a comparison returns.
    type Mask: Mask;

    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// 1/2.
    const HALF: Self;
    /// 2.
    const TWO: Self;
    /// π, rounded to nearest.
    const PI: Self;
    /// 1/π, rounded to nearest.
    const FRAC_1_PI: Self;
    /// The spacing of the numbers just above 1.
    const EPSILON: Self;
    /// The largest x for which exp(−x) is a normal number, rounded down: 87 and 708.
    const EXP_LIMIT: Self;

    /// The nearest number to `x`.
    fn from_f64(x: f64) -> Self;
    /// This number in double precision.
    fn to_f64(self) -> f64;

    /// √x.
    fn sqrt(self) -> Self;
    /// eˣ.
    fn exp(self) -> Self;
    /// The natural logarithm.
    fn ln(self) -> Self;
    /// |x|.
    fn abs(self) -> Self;
    /// The smaller of two numbers; where one is NaN, the other.
    fn min(self, other: Self) -> Self;
    /// The larger of two numbers; where one is NaN, the other.
    fn max(self, other: Self) -> Self;

    /// `self < other`.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self <= other`.
    fn le(self, other: Self) -> Self::Mask;
    /// `self > other`.
    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        other.lt(self)
    }
    /// `self >= other`.
    #[inline(always)]
    fn ge(self, other: Self) -> Self::Mask {
        other.le(self)
    }
    /// `yes` where the mask is true, else `no`.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// a·b without error, as the rounded product and the rounding error of it.
    ///
    /// Exact unless the error underflows. Dekker 1971, eq. 5.12; in `f32` through one double-precision product.
    fn product_exact(self, other: Self) -> (Self, Self);

    /// a + b without error, as the rounded sum and the rounding error of it (Knuth 1969, TAOCP 2, 4.2.2, theorem B).
    #[inline(always)]
    fn sum_exact(self, other: Self) -> (Self, Self) {
        let sum = self + other;
        let part = sum - self;
        (sum, (self - (sum - part)) + (other - part))
    }

    /// ln(1+x), accurate for small x. Domain x > −1; 0 at 0.
    fn ln_one_plus(self) -> Self;
    /// The angle in [0, π/2] of the right triangle with the given opposite (`self`) and adjacent sides, both ≥ 0.
    ///
    /// `s.angle(c)` is asin(s) and acos(c) at once, accurate at both ends. 0 where both sides are 0.
    fn angle(self, adjacent: Self) -> Self;
    /// The cosine and sine of `self` turns, cos 2πx and sin 2πx; x in [0, 1], clamped there.
    ///
    /// A quarter turn is split off exactly and the rest, at most an eighth, goes through Taylor's polynomials. Error ≤ 3 ULP
    /// of each result; exactly (1, 0), (0, 1), (−1, 0) and (0, −1) at the quarters. NaN counts as 0.
    fn unit_circle(self) -> (Self, Self);
    /// The scaled complementary error function exp(x²)·erfc(x), x ≥ 0. 1 at 0, falls to 1/(x√π). Error in f32: ≤ 7 ULP.
    fn erfcx(self) -> Self;
    /// exp(−a·b), with the rounding error of the product a·b carried into the result; a, b ≥ 0.
    /// 0 where a·b > [`Real::EXP_LIMIT`].
    ///
    /// `exp(-(a * b))` alone loses |a·b|/2 ULP to the rounding of its argument. Error in f32: ≤ 1.5 ULP.
    #[inline(always)]
    fn exp_product(self, other: Self) -> Self {
        let (product, error) = self.product_exact(other);
        let value = (-product).exp();
        // exp(−p−e) = exp(−p)(1−e) to e². Past the limit the result would be subnormal, or the error NaN: 0.
        Self::select(product.le(Self::EXP_LIMIT), value - value * error, Self::ZERO)
    }

    /// The function that is `nodes[i]` at i and linear between, at this position, for each channel.
    ///
    /// In plain text: a·(1−u) + b·u of the two nodes around the position, u its fraction. `nodes` ≥ 0; the position in
    /// [0, length − 1], clamped there; 0 without nodes. The twin is a part of `layered::coupled`. Error in f32: ≤ 3.5 ULP of the value at the position given.
    #[inline(always)]
    fn interpolate<const C: usize>(self, nodes: &[[f64; C]]) -> [Self; C] {
        let left = (self.to_f64() as usize).min(nodes.len().saturating_sub(2));
        let (Some(a), Some(b)) = (nodes.get(left), nodes.get(left + 1).or(nodes.last())) else {
            return [Self::ZERO; C];
        };
        let u = (self - Self::from_f64(left as f64)).saturate();
        core::array::from_fn(|c| Self::from_f64(a[c]) * (Self::ONE - u) + Self::from_f64(b[c]) * u)
    }

    /// x clamped to [0, 1]; NaN becomes 0.
    #[inline(always)]
    fn saturate(self) -> Self {
        self.max(Self::ZERO).min(Self::ONE)
    }
    /// x².
    #[inline(always)]
    fn squared(self) -> Self {
        self * self
    }
}

macro_rules! comparisons {
    () => {
        type Mask = bool;
        const ZERO: Self = 0.0;
        const ONE: Self = 1.0;
        const HALF: Self = 0.5;
        const TWO: Self = 2.0;

        #[inline(always)]
        fn lt(self, other: Self) -> bool {
            self < other
        }
        #[inline(always)]
        fn le(self, other: Self) -> bool {
            self <= other
        }
        #[inline(always)]
        fn select(mask: bool, yes: Self, no: Self) -> Self {
            if mask { yes } else { no }
        }
        #[inline(always)]
        fn min(self, other: Self) -> Self {
            <Self>::min(self, other)
        }
        #[inline(always)]
        fn max(self, other: Self) -> Self {
            <Self>::max(self, other)
        }
        #[inline(always)]
        fn abs(self) -> Self {
            <Self>::abs(self)
        }
    };
}

/// Defines the functions that `core` lacks, from the standard library or from libm.
macro_rules! elementary {
    ($sqrt:ident, $exp:ident, $ln:ident, $ln_1p:ident, $atan2:ident) => {
        #[cfg(feature = "std")]
        #[inline(always)]
        fn sqrt(self) -> Self {
            <Self>::sqrt(self)
        }
        #[cfg(feature = "std")]
        #[inline(always)]
        fn exp(self) -> Self {
            <Self>::exp(self)
        }
        #[cfg(feature = "std")]
        #[inline(always)]
        fn ln(self) -> Self {
            <Self>::ln(self)
        }
        #[cfg(feature = "std")]
        #[inline(always)]
        fn ln_one_plus(self) -> Self {
            <Self>::ln_1p(self)
        }
        #[cfg(feature = "std")]
        #[inline(always)]
        fn angle(self, adjacent: Self) -> Self {
            <Self>::atan2(self, adjacent)
        }
        #[cfg(all(feature = "libm", not(feature = "std")))]
        #[inline(always)]
        fn sqrt(self) -> Self {
            libm::$sqrt(self)
        }
        #[cfg(all(feature = "libm", not(feature = "std")))]
        #[inline(always)]
        fn exp(self) -> Self {
            libm::$exp(self)
        }
        #[cfg(all(feature = "libm", not(feature = "std")))]
        #[inline(always)]
        fn ln(self) -> Self {
            libm::$ln(self)
        }
        #[cfg(all(feature = "libm", not(feature = "std")))]
        #[inline(always)]
        fn ln_one_plus(self) -> Self {
            libm::$ln_1p(self)
        }
        #[cfg(all(feature = "libm", not(feature = "std")))]
        #[inline(always)]
        fn angle(self, adjacent: Self) -> Self {
            libm::$atan2(self, adjacent)
        }
    };
}

impl Real for f32 {
    comparisons!();
    elementary!(sqrtf, expf, logf, log1pf, atan2f);

    const PI: Self = core::f32::consts::PI;
    const FRAC_1_PI: Self = core::f32::consts::FRAC_1_PI;
    const EPSILON: Self = f32::EPSILON;
    const EXP_LIMIT: Self = 87.0;

    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        x as f32
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
    #[inline(always)]
    fn product_exact(self, other: Self) -> (Self, Self) {
        // 24 + 24 bits fit in the 53 of a double.
        let exact = f64::from(self) * f64::from(other);
        let product = exact as f32;
        (product, (exact - f64::from(product)) as f32)
    }
    #[inline(always)]
    fn erfcx(self) -> Self {
        erfcx_chebyshev(self, &ERFCX_SINGLE)
    }
    #[inline(always)]
    fn unit_circle(self) -> (Self, Self) {
        let (quarter, rest) = quarter_turns(f64::from(self));
        circle(quarter, rest as f32, &SINE.map(|c| c as f32)[..5], &COSINE.map(|c| c as f32)[..6])
    }
}

impl Real for f64 {
    comparisons!();
    elementary!(sqrt, exp, log, log1p, atan2);

    const PI: Self = core::f64::consts::PI;
    const FRAC_1_PI: Self = core::f64::consts::FRAC_1_PI;
    const EPSILON: Self = f64::EPSILON;
    const EXP_LIMIT: Self = 708.0;

    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }
    #[inline(always)]
    fn product_exact(self, other: Self) -> (Self, Self) {
        // Veltkamp's split into 26 + 27 bits by masking, which cannot overflow; then Dekker's product.
        let high = |x: f64| f64::from_bits(x.to_bits() & 0xffff_ffff_f800_0000);
        let product = self * other;
        let (ah, bh) = (high(self), high(other));
        let (al, bl) = (self - ah, other - bh);
        (product, ((ah * bh - product) + ah * bl + al * bh) + al * bl)
    }
    #[inline(always)]
    fn erfcx(self) -> Self {
        erfcx_chebyshev(self, &ERFCX)
    }
    #[inline(always)]
    fn unit_circle(self) -> (Self, Self) {
        let (quarter, rest) = quarter_turns(self);
        circle(quarter, rest, &SINE, &COSINE)
    }
}

/// Chebyshev coefficients of (1+2x)·exp(x²)·erfc(x) in u = (x−3.75)/(x+3.75), computed with 50 digits.
///
/// The variable is that of Shepherd & Laframboise 1981, "Chebyshev approximation of (1+2x)exp(x²)erfc x in 0 ≤ x < ∞".
/// 25 coefficients leave an error below 4e-18, the first 13 one below 7e-9.
const ERFCX: [f64; 25] = [
    1.177_578_934_567_401_754_1,
    -0.004_590_054_580_646_477_330_9,
    -0.084_249_133_366_517_915_584,
    0.059_209_939_998_191_890_498,
    -0.026_658_668_435_305_752_277,
    0.009_074_997_670_705_265_093_9,
    -0.002_413_163_540_417_608_191_1,
    0.000_490_775_836_525_808_632_29,
    -0.000_069_169_733_025_012_063_671,
    4.139_027_986_073_010_167_5e-6,
    7.740_383_066_198_490_668_6e-7,
    -2.188_640_104_923_439_546_1e-7,
    1.076_499_946_591_036_107_7e-8,
    4.521_959_811_218_286_897_9e-9,
    -7.754_400_208_831_351_106_5e-10,
    -6.318_088_340_886_684_494_5e-11,
    2.868_795_010_930_669_898_1e-11,
    1.945_586_854_577_734_723e-13,
    -9.654_696_748_433_438_905_9e-13,
    3.252_548_148_148_739_841_5e-14,
    3.347_811_948_286_805_387_8e-14,
    -1.864_562_880_419_313_101_4e-15,
    -1.250_795_053_068_864_708_4e-15,
    7.418_235_256_624_043_466_7e-17,
    5.068_148_904_796_111_313_2e-17,
];

/// The coefficients that single precision needs.
const ERFCX_SINGLE: [f32; 13] = {
    let mut single = [0.0; 13];
    let mut i = 0;
    while i < single.len() {
        single[i] = ERFCX[i] as f32;
        i += 1;
    }
    single
};

/// Clenshaw's sum of the series above, divided by (1+2x).
#[inline(always)]
fn erfcx_chebyshev<R: Real>(x: R, coefficients: &[R]) -> R {
    let k = R::from_f64(3.75);
    // At x = ∞ the quotient would be NaN; u → 1 there.
    let u = R::select(x.lt(R::from_f64(1e30)), (x - k) / (x + k), R::ONE);
    let (mut b1, mut b2) = (R::ZERO, R::ZERO);
    for &c in coefficients[1..].iter().rev() {
        (b1, b2) = (R::TWO * u * b1 - b2 + c, b1);
    }
    (u * b1 - b2 + coefficients[0]) / (R::ONE + R::TWO * x)
}

/// The Taylor coefficients (−1)ʲ(π/2)²ʲ⁺¹/(2j+1)! of sin(πr/2)/r in r². On |r| ≤ 1/2 nine leave an error below 1e-19 of
/// the sine, the first five one of 2.5e-9.
const SINE: [f64; 9] = [
    core::f64::consts::FRAC_PI_2,
    -0.645_964_097_506_246_253_66,
    0.079_692_626_246_167_045_121,
    -0.004_681_754_135_318_688_100_7,
    0.000_160_441_184_787_359_821_87,
    -3.598_843_235_212_085_340_5e-6,
    5.692_172_921_967_926_811_8e-8,
    -6.688_035_109_811_467_232_5e-10,
    6.066_935_731_106_195_667_1e-12,
];

/// The Taylor coefficients (−1)ʲ(π/2)²ʲ/(2j)! of cos(πr/2) in r². Nine leave an error below 3e-18, the first six 1.2e-10.
const COSINE: [f64; 9] = [
    1.0,
    -1.233_700_550_136_169_827_4,
    0.253_669_507_901_048_013_64,
    -0.020_863_480_763_352_960_873,
    0.000_919_260_274_839_426_580_24,
    -0.000_025_202_042_373_060_605_481,
    4.710_874_778_818_171_503_7e-7,
    -6.386_603_083_791_852_241_1e-9,
    6.565_963_114_979_472_362_2e-11,
];

/// The nearest quarter to a turn in [0, 1], and what is left of the turn in quarters, in [−1/2, 1/2]: both exact.
#[inline(always)]
fn quarter_turns(turn: f64) -> (u32, f64) {
    let quarters = 4.0 * turn.saturate();
    let nearest = (quarters + 0.5) as u32;
    (nearest, quarters - f64::from(nearest))
}

/// cos and sin of a quarter turn and a rest, from the series of the rest.
#[inline(always)]
fn circle<R: Real>(quarter: u32, rest: R, sine: &[R], cosine: &[R]) -> (R, R) {
    let square = rest * rest;
    let horner = |series: &[R]| series.iter().rev().fold(R::ZERO, |sum, c| sum * square + *c);
    let (c, s) = (horner(cosine), rest * horner(sine));
    match quarter & 3 {
        0 => (c, s),
        1 => (-s, c),
        2 => (-c, -s),
        _ => (s, -c),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn product_error_is_exact() {
        for (a, b) in [(1.1f64, 1.3), (1e-3, 7.7e5), (1.0 + f64::EPSILON, 1.0 - f64::EPSILON)] {
            let (p, e) = a.product_exact(b);
            assert_eq!(p, a * b);
            assert_eq!(e, a.mul_add(b, -p), "{a} {b}");
            let (p, e) = (a as f32).product_exact(b as f32);
            assert_eq!(e, (a as f32).mul_add(b as f32, -p), "{a} {b}");
        }
    }

    #[test]
    fn erfcx_matches_known_values() {
        // mpmath, 20 digits.
        let table = [
            (0.0, 1.0),
            (1e-3, 0.998_872_620_081_151_408_6),
            (0.5, 0.615_690_344_192_925_874_87),
            (1.0, 0.427_583_576_155_807_004_41),
            (3.75, 0.145_589_721_275_038_539_05),
            (10.0, 0.056_140_992_743_822_585_8),
            (1e4, 5.641_895_807_268_084_115e-5),
        ];
        for (x, want) in table {
            assert!((f64::erfcx(x) / want - 1.0).abs() < 2e-15, "{x}: {} {want}", f64::erfcx(x));
            let single = f32::erfcx(x as f32);
            assert!((f64::from(single) / want - 1.0).abs() < 6e-7, "{x}: {single} {want}");
        }
        assert_eq!(f64::erfcx(f64::INFINITY), 0.0);
    }

    #[test]
    fn unit_circle_is_the_cosine_and_sine() {
        for i in 0..=40_000 {
            let turn = f64::from(i) / 40_000.0;
            let single = turn as f32;
            for (got, ulp, turn) in [
                (turn.unit_circle(), f64::EPSILON, turn),
                (
                    (f64::from(single.unit_circle().0), f64::from(single.unit_circle().1)),
                    f64::from(f32::EPSILON),
                    f64::from(single),
                ),
            ] {
                // The angle within its octant, where the library's functions are accurate.
                let (quarter, rest) = quarter_turns(turn);
                let (s, c) = (core::f64::consts::FRAC_PI_2 * rest).sin_cos();
                let want = [(c, s), (-s, c), (-c, -s), (s, -c)][quarter as usize & 3];
                for (got, want) in [(got.0, want.0), (got.1, want.1)] {
                    assert!((got - want).abs() <= 3.0 * ulp * want.abs(), "{turn}: {got} {want}");
                }
            }
        }
        for (turn, want) in
            [(0.0, (1.0, 0.0)), (0.25, (0.0, 1.0)), (0.5, (-1.0, 0.0)), (0.75, (0.0, -1.0)), (1.0, (1.0, 0.0))]
        {
            assert_eq!(f64::unit_circle(turn), want);
        }
        assert_eq!(f64::NAN.unit_circle(), (1.0, 0.0));
        assert_eq!(f32::MAX.unit_circle(), (1.0, 0.0));
    }

    #[test]
    fn exp_product_keeps_the_argument() {
        // exp(−a·b) against double precision, where f32's own product loses up to 40 ULP.
        for i in 1..2000 {
            let a = 0.043_21_f32 * i as f32;
            let b = 0.987_654_f32;
            let want = (-(f64::from(a) * f64::from(b))).exp();
            let got = f64::from(a.exp_product(b));
            assert!((got - want).abs() <= want * 2.5 * f64::from(f32::EPSILON), "{a}: {got} {want}");
        }
        assert_eq!(f32::INFINITY.exp_product(1.0), 0.0);
        assert_eq!(f64::MAX.exp_product(f64::MAX), 0.0);
    }
}
