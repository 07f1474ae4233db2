//! The numbers that the formulas are written over.
//!
//! Every term of this crate is one generic function over [`Real`]. With `f32` it is what a renderer runs, with `f64` it
//! is the oracle that error is measured against. Data-dependent choices are selects on a [`Mask`], never branches, so
//! that the same source serves numbers whose comparisons have more than one answer (lanes, intervals).
//!
//! WGSL has no accurate `log(1+x)`, no usable arc functions and no complementary error function; `wgsl/real.wgsl`
//! supplies [`Real::ln_one_plus`], [`Real::angle`], [`Real::erfcx`], [`Real::exp_product`] and [`Real::unit_circle`] under the
//! same names.

use crate::series::{
    COSINE, COSINE_SINGLE, ERFCX, SINE, SINE_SINGLE, angle_polynomial, circle, erfcx_chebyshev, quarter_turns,
};
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

/// A real number that the reflectance formulas run over. Sealed: `f32`, `f64`, [`Single`](crate::single::Single) and
/// [`WgslInterval`](crate::interval::WgslInterval).
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
    /// The numbers that a term over this type computes in: f64 for `f32`, else the type itself.
    ///
    /// A term takes its arguments to this type, evaluates its formula there and rounds the result once. In `f32` that is
    /// what keeps each result within a ULP; under WGSL's rules, where there is no wider type, and in
    /// [`Single`](crate::single::Single) the formula is evaluated as it stands. `docs/decisions.md` says what it costs.
    type Wide: Real<Wide = Self::Wide>;

    /// Whether terms carry rounding errors along where a result would magnify them: [`Single`](crate::single::Single), in which
    /// they have no wider numbers to compute in.
    #[doc(hidden)]
    const CARRIES: bool = false;

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
    /// This number as the terms compute with it, exactly.
    fn widen(self) -> Self::Wide;
    /// The nearest number to a term's result. Over `f32` the largest of this type where the result is larger; the other
    /// types, which are as wide as their terms, leave it as it is: infinite where it overflowed.
    fn narrow(wide: Self::Wide) -> Self;

    /// √x.
    fn sqrt(self) -> Self;
    /// eˣ.
    fn exp(self) -> Self;
    /// eˣ of numbers in [−87, 0]; of others it may be any number.
    #[doc(hidden)]
    #[inline(always)]
    fn exp_within(self) -> Self {
        self.exp()
    }
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
    /// The scaled complementary error function exp(x²)·erfc(x), x ≥ 0. 1 at 0, falls to 1/(x√π). Error in f32: ≤ 0.6 ULP.
    #[inline(always)]
    fn erfcx(self) -> Self {
        Self::narrow(Self::erfcx_wide(self.widen()))
    }
    /// exp(−a·b), with the rounding error of the product a·b carried into the result; a, b ≥ 0.
    /// 0 where a·b > [`Real::EXP_LIMIT`].
    ///
    /// `exp(-(a * b))` alone loses |a·b|/2 ULP to the rounding of its argument. Error in f32: ≤ 1.5 ULP.
    #[inline(always)]
    fn exp_product(self, other: Self) -> Self {
        let (product, error) = self.product_exact(other);
        let value = (-product).exp_within();
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
    /// What is linear in each of `cells` ≥ 1 cells of width 1, at this position, clamped to them: `ends` of a cell are its values there.
    #[doc(hidden)]
    #[inline(always)]
    fn linear<const C: usize>(self, cells: usize, ends: impl Fn(usize) -> [[f64; 2]; C]) -> [Self; C] {
        let cell = (self.to_f64() as usize).min(cells - 1);
        let share = (self - Self::from_f64(cell as f64)).saturate();
        ends(cell).map(|ends| {
            let [a, b] = ends.map(Self::from_f64);
            a + (b - a) * share
        })
    }
    /// What is linear along both sides of each cell of a grid of `cells` columns and rows, at a column and a row; `node` is its value
    /// at a corner.
    #[doc(hidden)]
    #[inline(always)]
    fn bilinear([x, y]: [Self; 2], cells: [usize; 2], node: impl Fn(usize, usize) -> f64) -> Self {
        let row = (y.to_f64() as usize).min(cells[1] - 1);
        let [low, high] =
            x.linear(cells[0], |i| [[node(i, row), node(i + 1, row)], [node(i, row + 1), node(i + 1, row + 1)]]);
        low + (high - low) * (y - Self::from_f64(row as f64)).saturate()
    }
    /// [`Real::product_exact`] of two wide numbers, so far as this type can tell: in `f32` the double-precision product alone.
    #[doc(hidden)]
    fn product_wide(a: Self::Wide, b: Self::Wide) -> (Self::Wide, Self::Wide);
    /// [`Real::exp_product`] of two wide numbers, 0 past the limit of this type.
    #[doc(hidden)]
    #[inline(always)]
    fn exp_product_wide(a: Self::Wide, b: Self::Wide) -> Self::Wide {
        let (product, error) = Self::product_wide(a, b);
        let value = (-product).exp_within();
        let inside = product.le(Self::EXP_LIMIT.widen());
        Self::Wide::select(inside, value - value * error, Self::Wide::ZERO)
    }
    /// [`Real::angle`] of two wide numbers, with the digits that this type can tell.
    #[doc(hidden)]
    fn angle_wide(opposite: Self::Wide, adjacent: Self::Wide) -> Self::Wide;
    /// [`Real::erfcx`] of a wide number, with the digits that this type can tell.
    #[doc(hidden)]
    fn erfcx_wide(x: Self::Wide) -> Self::Wide;

    /// [`Real::ln_one_plus`] of an unrounded sum, and the rounding error of the result; where the type carries.
    #[doc(hidden)]
    #[inline(always)]
    fn ln_one_plus_carried(high: Self, _low: Self) -> (Self, Self) {
        (high.ln_one_plus(), Self::ZERO)
    }
    /// [`Real::angle`] of an unrounded opposite side, and the rounding error of the result; where the type carries.
    #[doc(hidden)]
    #[inline(always)]
    fn angle_carried(high: Self, _low: Self, adjacent: Self) -> (Self, Self) {
        (high.angle(adjacent), Self::ZERO)
    }

    /// The largest whole number ≤ x, exactly; NaN and infinities are themselves.
    #[inline(always)]
    fn floor(self) -> Self {
        let x = self.to_f64();
        // From 2⁵² on every number is whole; the comparison sends NaN there too.
        let small = x.abs() < 4_503_599_627_370_496.0;
        let whole = x as i64 as f64;
        Self::from_f64(if !small {
            x
        } else if whole > x {
            whole - 1.0
        } else {
            whole
        })
    }
    /// A function of whole numbers, in every lane at its own; numbers beyond 32 bits count as the nearest that is not.
    ///
    /// What lies on a lattice (hashes, texels) is looked up this way: the numbers that a cell holds have no formula.
    #[doc(hidden)]
    #[inline(always)]
    fn at_cell<const D: usize, const N: usize>(cell: [Self; D], value: impl Fn([i32; D]) -> [f64; N]) -> [Self; N] {
        value(cell.map(|x| x.to_f64() as i32)).map(Self::from_f64)
    }

    /// self·factor + addend: rounded once where the type has an instruction for it
    /// ([`Single<true>`](crate::single::Single)), else twice.
    #[inline(always)]
    fn mul_add(self, factor: Self, addend: Self) -> Self {
        self * factor + addend
    }
    /// addend − self·factor, the product without its rounding error: what is left of a division or a root.
    #[doc(hidden)]
    #[inline(always)]
    fn remainder(self, factor: Self, addend: Self) -> Self {
        let (product, lost) = self.product_exact(factor);
        (addend - product) - lost
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
    type Wide = f64;

    #[inline(always)]
    fn widen(self) -> f64 {
        f64::from(self)
    }
    #[inline(always)]
    fn narrow(wide: f64) -> Self {
        // What only a double can hold, a lobe between two directions on the horizon, is the largest f32.
        if wide > f64::from(f32::MAX) { f32::MAX } else { wide as f32 }
    }
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
    fn product_wide(a: f64, b: f64) -> (f64, f64) {
        (a * b, 0.0)
    }
    #[inline(always)]
    fn angle_wide(opposite: f64, adjacent: f64) -> f64 {
        angle_polynomial(opposite, adjacent)
    }
    #[inline(always)]
    fn erfcx_wide(x: f64) -> f64 {
        erfcx_chebyshev(x, &ERFCX[..13])
    }
    #[inline(always)]
    fn unit_circle(self) -> (Self, Self) {
        let (quarter, rest) = quarter_turns(f64::from(self));
        circle(quarter, rest as f32, &SINE_SINGLE, &COSINE_SINGLE)
    }
}

impl Real for f64 {
    comparisons!();
    elementary!(sqrt, exp, log, log1p, atan2);

    const PI: Self = core::f64::consts::PI;
    const FRAC_1_PI: Self = core::f64::consts::FRAC_1_PI;
    const EPSILON: Self = f64::EPSILON;
    const EXP_LIMIT: Self = 708.0;
    type Wide = f64;

    #[inline(always)]
    fn widen(self) -> f64 {
        self
    }
    #[inline(always)]
    fn narrow(wide: f64) -> Self {
        wide
    }
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
    fn product_wide(a: f64, b: f64) -> (f64, f64) {
        a.product_exact(b)
    }
    #[inline(always)]
    fn angle_wide(opposite: f64, adjacent: f64) -> f64 {
        opposite.angle(adjacent)
    }
    #[inline(always)]
    fn erfcx_wide(x: f64) -> f64 {
        erfcx_chebyshev(x, &ERFCX)
    }
    #[inline(always)]
    fn unit_circle(self) -> (Self, Self) {
        let (quarter, rest) = quarter_turns(self);
        circle(quarter, rest, &SINE, &COSINE)
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
