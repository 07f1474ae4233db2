//! The values that WGSL lets an f32 expression have.
//!
//! WGSL does not fix the result of an operation; it bounds the error of each (W3C, WGSL §15.7.4, "Floating point
//! accuracy"). [`WgslInterval`] runs a formula under those bounds: its value is the smallest interval, to double
//! precision, that holds every result a conforming implementation may return for exact f32 inputs. What it returns for
//! a term *is* the tolerance that the term's twin is held to.
//!
//! | operation | allowed error |
//! |---|---|
//! | `+ − ×` | correctly rounded in either direction: 1 ULP |
//! | `/` | 2.5 ULP |
//! | `sqrt` | as 1/`inverseSqrt`: 2 + 2.5 ULP |
//! | `exp` | (3 + 2·\|x\|) ULP |
//! | `min max abs`, comparisons, `select` | exact |
//! | subnormal results | may become 0 |
//!
//! WGSL also lets a compiler reassociate. The twins of [`Real::sum_exact`] and [`Real::product_exact`] are written so that
//! none can: their parts are formed by masks and minima. That they return exact pairs is checked on every adapter.

use crate::real::{Mask, Real, Sealed};
use core::fmt::Debug;
use core::marker::PhantomData;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// How accurate WGSL's operations on f32 are; the defaults are its table (WGSL 15.7.4). Errors in ULP unless said otherwise.
///
/// Another table tests the judgement itself: a narrower one must refuse what a wider one allows.
pub trait AccuracyTable: Copy + Debug + Default + PartialEq + Send + Sync + 'static {
    /// `+ − ×`, correctly rounded in either direction.
    const SUM: f64 = 1.0;
    /// `/`.
    const QUOTIENT: f64 = 2.5;
    /// `inverseSqrt`; `sqrt` is 1 over it.
    const INVERSE_SQRT: f64 = 2.0;
    /// `exp` and `exp2`: the first plus |x| times the second.
    const EXP: (f64, f64) = (3.0, 2.0);
    /// `log` and `log2` outside \[1/2, 2\].
    const LOG: f64 = 3.0;
    /// `log` and `log2` on \[1/2, 2\], absolute.
    const LOG_NEAR_ONE: f64 = 1.0 / 2_097_152.0;
    /// `sin` and `cos` on \[−π, π\], absolute.
    const SINE: f64 = 1.0 / 2048.0;
    /// `atan` and `atan2`.
    const ARC_TANGENT: f64 = 4096.0;
    /// `asin` and `acos`, absolute, or what their formula inherits.
    const ARC_SINE: f64 = 6.81e-5;
}

/// WGSL's own accuracy table.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wgsl;
impl AccuracyTable for Wgsl {}

/// An interval of the real numbers that holds every value WGSL allows an f32 expression; NaN bounds mean "anything".
pub type WgslInterval = Interval<Wgsl>;

/// An interval of the real numbers that holds every value that an accuracy table allows an f32 expression.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Interval<T> {
    low: f64,
    high: f64,
    table: PhantomData<T>,
}

/// The spacing of f32 relative to the number, at most: 1 ULP.
const ULP: f64 = f32::EPSILON as f64;
/// The smallest normal f32.
const TINY: f64 = f32::MIN_POSITIVE as f64;
/// The spacing of the subnormal f32.
const SPACING: f64 = TINY * ULP;

/// What is known of a comparison between intervals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ternary {
    /// It may be false.
    may_fail: bool,
    /// It may be true.
    may_hold: bool,
}

impl Ternary {
    /// Nothing is known.
    #[cfg(feature = "check")]
    pub(crate) const OPEN: Self = Ternary { may_fail: true, may_hold: true };
}

impl<T: AccuracyTable> Interval<T> {
    /// Anything at all.
    pub(crate) const UNKNOWN: Self = Self::new(f64::NEG_INFINITY, f64::INFINITY);

    pub(crate) const fn new(low: f64, high: f64) -> Self {
        Interval { low, high, table: PhantomData }
    }

    /// Exactly this f32.
    pub fn exactly(value: f32) -> Self {
        Self::new(f64::from(value), f64::from(value))
    }

    /// The smallest allowed value.
    pub fn low(self) -> f64 {
        self.low
    }

    /// The largest allowed value.
    pub fn high(self) -> f64 {
        self.high
    }

    /// Whether a result is allowed.
    pub fn contains(self, value: f32) -> bool {
        let value = f64::from(value);
        self.low <= value && value <= self.high
    }

    /// This interval with both ends moved outward by the width of another around 0.
    pub fn widened(self, by: Self) -> Self {
        Self::new(self.low + by.low, self.high + by.high)
    }

    /// Whether the rules say anything about the result.
    pub fn is_bounded(self) -> bool {
        self.low.is_finite() && self.high.is_finite()
    }

    /// The interval of exact results between two bounds, widened by what an operation may add: `ulps` of the result, the
    /// flush of a subnormal, and the rounding of this computation in double precision.
    pub(crate) fn rounded(low: f64, high: f64, ulps: f64) -> Self {
        if low.is_nan() || high.is_nan() {
            return Self::UNKNOWN;
        }
        let relative = ulps * ULP + 4.0 * f64::EPSILON;
        // The ULP of a subnormal number is 2⁻¹⁴⁹, whatever its size.
        let room = |x: f64| (relative * x.abs()).max(ulps * SPACING);
        let (positive, negative) = (low >= 0.0, high <= 0.0);
        let mut low = if low == 0.0 { 0.0 } else { low - room(low) };
        let mut high = if high == 0.0 { 0.0 } else { high + room(high) };
        if positive && low < TINY {
            low = 0.0;
        }
        if negative && high > -TINY {
            high = 0.0;
        }
        // A result past the largest f32 is indeterminate.
        if high > f64::from(f32::MAX) {
            high = f64::INFINITY;
        }
        if low < -f64::from(f32::MAX) {
            low = f64::NEG_INFINITY;
        }
        Self::new(low, high)
    }

    /// The image under a monotonic function that is good to `ulps`.
    pub(crate) fn monotonic(self, ulps: f64, f: impl Fn(f64) -> f64) -> Self {
        let (a, b) = (f(self.low), f(self.high));
        Self::rounded(a.min(b), a.max(b), ulps)
    }

    pub(crate) fn hull(self, other: Self) -> Self {
        Self::new(self.low.min(other.low), self.high.max(other.high))
    }

    pub(crate) fn magnitude(self) -> f64 {
        self.low.abs().max(self.high.abs())
    }

    /// The bounds of the products (or quotients) of the ends.
    fn corners(self, other: Self, f: impl Fn(f64, f64) -> f64) -> (f64, f64) {
        let ends = [(self.low, other.low), (self.low, other.high), (self.high, other.low), (self.high, other.high)];
        ends.into_iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (a, b)| {
            // 0·∞ is 0 here: the infinity stands for numbers without bound, not for an infinite factor.
            let value = if a == 0.0 { 0.0 } else { f(a, b) };
            (low.min(value), high.max(value))
        })
    }

    /// A bound on what double-single arithmetic drops: products of two roundings.
    fn second_order(scale: f64) -> Self {
        let width = 8.0 * ULP * ULP * scale;
        Self::new(-width, width)
    }
}

impl<T: AccuracyTable> Add for Interval<T> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::rounded(self.low + other.low, self.high + other.high, T::SUM)
    }
}

impl<T: AccuracyTable> Sub for Interval<T> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self::rounded(self.low - other.high, self.high - other.low, T::SUM)
    }
}

impl<T: AccuracyTable> Mul for Interval<T> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let (low, high) = if other.low == 0.0 && other.high == 0.0 {
            (0.0, 0.0)
        } else {
            self.corners(other, |a, b| if b == 0.0 { 0.0 } else { a * b })
        };
        Self::rounded(low, high, T::SUM)
    }
}

impl<T: AccuracyTable> Div for Interval<T> {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let divisor = [other.low.abs(), other.high.abs()];
        // The range for which the standard bounds the error: 2⁻¹²⁶ to 2¹²⁶.
        let normal = divisor.iter().all(|d| (TINY..=TINY.recip()).contains(d));
        if !normal || other.low < 0.0 && other.high > 0.0 {
            return Self::UNKNOWN;
        }
        let (low, high) = self.corners(other, |a, b| a / b);
        Self::rounded(low, high, T::QUOTIENT)
    }
}

impl<T: AccuracyTable> Neg for Interval<T> {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(-self.high, -self.low)
    }
}

impl Not for Ternary {
    type Output = Self;
    fn not(self) -> Self {
        Ternary { may_fail: self.may_hold, may_hold: self.may_fail }
    }
}

impl BitAnd for Ternary {
    type Output = Self;
    fn bitand(self, other: Self) -> Self {
        Ternary { may_fail: self.may_fail || other.may_fail, may_hold: self.may_hold && other.may_hold }
    }
}

impl BitOr for Ternary {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Ternary { may_fail: self.may_fail && other.may_fail, may_hold: self.may_hold || other.may_hold }
    }
}

impl Sealed for Ternary {}
impl Mask for Ternary {
    fn all(self) -> bool {
        !self.may_fail
    }
    fn any(self) -> bool {
        self.may_hold
    }
}

impl<T: AccuracyTable> Sealed for Interval<T> {}
impl<T: AccuracyTable> Real for Interval<T> {
    type Mask = Ternary;
    type Wide = Self;

    const ZERO: Self = Self::new(0.0, 0.0);
    const ONE: Self = Self::new(1.0, 1.0);
    const HALF: Self = Self::new(0.5, 0.5);
    const TWO: Self = Self::new(2.0, 2.0);
    // The two f32 next to each constant: the nearest is above π and below 1/π.
    const PI: Self = Self::new(core::f32::consts::PI.next_down() as f64, core::f32::consts::PI as f64);
    const FRAC_1_PI: Self =
        Self::new(core::f32::consts::FRAC_1_PI as f64, core::f32::consts::FRAC_1_PI.next_up() as f64);
    const EPSILON: Self = Self::new(ULP, ULP);
    const EXP_LIMIT: Self = Self::new(87.0, 87.0);

    fn from_f64(x: f64) -> Self {
        // A literal is rounded to one of the two f32 next to it.
        let nearest = x as f32;
        if f64::from(nearest) == x {
            Self::exactly(nearest)
        } else if f64::from(nearest) < x {
            Self::new(f64::from(nearest), f64::from(nearest.next_up()))
        } else {
            Self::new(f64::from(nearest.next_down()), f64::from(nearest))
        }
    }
    fn widen(self) -> Self {
        self
    }
    fn narrow(wide: Self) -> Self {
        wide
    }
    fn to_f64(self) -> f64 {
        if self.low == self.high { self.low } else { 0.5 * (self.low + self.high) }
    }

    fn sqrt(self) -> Self {
        self.monotonic(T::INVERSE_SQRT + T::QUOTIENT, |x| Real::sqrt(x.max(0.0)))
    }
    fn exp(self) -> Self {
        self.monotonic(T::EXP.0 + T::EXP.1 * self.magnitude().min(1e30), Real::exp)
    }
    fn ln(self) -> Self {
        // 2⁻²¹ absolute on [0.5, 2], elsewhere 3 ULP.
        let image = self.monotonic(T::LOG, Real::ln);
        let near = T::LOG_NEAR_ONE;
        if self.low <= 2.0 && self.high >= 0.5 { Self::new(image.low - near, image.high + near) } else { image }
    }
    fn abs(self) -> Self {
        if self.low <= 0.0 && self.high >= 0.0 {
            Self::new(0.0, self.magnitude())
        } else {
            Self::new(self.low.abs().min(self.high.abs()), self.magnitude())
        }
    }
    fn min(self, other: Self) -> Self {
        Self::new(self.low.min(other.low), self.high.min(other.high))
    }
    fn max(self, other: Self) -> Self {
        Self::new(self.low.max(other.low), self.high.max(other.high))
    }
    fn lt(self, other: Self) -> Ternary {
        Ternary { may_fail: self.high >= other.low, may_hold: self.low < other.high }
    }
    fn le(self, other: Self) -> Ternary {
        Ternary { may_fail: self.high > other.low, may_hold: self.low <= other.high }
    }
    fn select(mask: Ternary, yes: Self, no: Self) -> Self {
        match (mask.may_hold, mask.may_fail) {
            (true, false) => yes,
            (false, true) => no,
            _ => yes.hull(no),
        }
    }

    /// The exact sum, and what the pair may miss of it.
    fn sum_exact(self, other: Self) -> (Self, Self) {
        let scale = self.magnitude().max(other.magnitude());
        let sum = Self::rounded(self.low + other.low, self.high + other.high, 0.0);
        (sum, Self::second_order(scale))
    }
    /// The exact product, and what the pair may miss of it.
    fn product_exact(self, other: Self) -> (Self, Self) {
        let (low, high) = self.corners(other, |a, b| if b == 0.0 { 0.0 } else { a * b });
        // A product that is an f32 leaves nothing: 1², the matched index.
        let exact = low == high && f64::from(low as f32) == low && (low == 0.0 || low.abs() >= TINY);
        if exact {
            return (Self::new(low, high), Self::ZERO);
        }
        (Self::rounded(low, high, 0.0), Self::second_order(low.abs().max(high.abs())))
    }

    /// 2·artanh(s), s = x/(2+x), by series: s 3.5 ULP, its square 8, of which the series keeps 8/27; two products and
    /// the sum 3; the dropped term 0.2. Outside [−1/2, 1] `log` of 1+x: 3 ULP and 1.5 of the sum.
    fn ln_one_plus(self) -> Self {
        self.monotonic(8.0, |x| Real::ln_one_plus(x.max(-1.0)))
    }
    /// atan(r)/r as a polynomial: r 2.5 ULP, its square 6, of which the logarithmic slope of the polynomial (≤ 0.18)
    /// keeps 1.1; Horner's sums 2.2; the product 1; the difference from π/2 another 1.
    fn angle(self, adjacent: Self) -> Self {
        let (ends, widest) = ((self.low.max(0.0), self.high.max(0.0)), (adjacent.low.max(0.0), adjacent.high.max(0.0)));
        Self::rounded(Real::angle(ends.0, widest.1), Real::angle(ends.1, widest.0), 8.0)
    }
    /// Horner's sums in r² (1 ULP): the sine's last sum 1, 0.16/1.41 of the 3 below it, the product with r 1; the
    /// cosine's last sum 1, 0.3/0.7 of the 3 below it; the dropped terms 0.04. A turn that is not known exactly moves both
    /// by 2π of its width.
    fn unit_circle(self) -> (Self, Self) {
        let middle = Real::saturate(0.5 * (self.low + self.high));
        let (c, s) = middle.unit_circle();
        // The 0 of a sine is exact, and so must its interval be for a turn that is.
        let reach = (self.high - self.low).max(0.0) * core::f64::consts::PI;
        let around = |x: f64| {
            let wide = Self::rounded(x - reach, x + reach, 4.0);
            if reach > 0.0 { Self::new(wide.low.max(-1.0 - ULP), wide.high.min(1.0 + ULP)) } else { wide }
        };
        (around(c), around(s))
    }
    /// The hull of the values at both ends and at every node between them. Nodes are rounded to f32 (½ ULP); 1 − u, each
    /// product and the sum of two that are ≥ 0 add 1 ULP each. The fraction u is exact.
    fn interpolate<const C: usize>(self, nodes: &[[f64; C]]) -> [Self; C] {
        let ends = [self.low, self.high].map(|end| Real::interpolate(end.max(0.0), nodes));
        let first = (self.low.max(0.0) as usize).saturating_add(1);
        let between = (self.high.max(0.0) as usize).saturating_add(1).min(nodes.len());
        let met = nodes.get(first..between).unwrap_or_default();
        core::array::from_fn(|c| {
            let values = ends.iter().chain(met).map(|value| value[c]);
            let (low, high) = values.fold((f64::INFINITY, 0.0f64), |(low, high), x| (low.min(x), high.max(x)));
            Self::rounded(low, high, 3.5)
        })
    }
    fn linear<const C: usize>(self, cells: usize, ends: impl Fn(usize) -> [[f64; 2]; C]) -> [Self; C] {
        piecewise(self, cells, |cell, share| {
            ends(cell).map(|ends| {
                let [a, b] = ends.map(Self::from_f64);
                a + (b - a) * share
            })
        })
    }
    fn bilinear([x, y]: [Self; 2], cells: [usize; 2], node: impl Fn(usize, usize) -> f64) -> Self {
        let [value] = piecewise(y, cells[1], |j, share| {
            let [low, high] =
                x.linear(cells[0], |i| [[node(i, j), node(i + 1, j)], [node(i, j + 1), node(i + 1, j + 1)]]);
            [low + (high - low) * share]
        });
        value
    }
    fn floor(self) -> Self {
        Self::new(Real::floor(self.low), Real::floor(self.high))
    }
    /// The hull over the cells that the position may be in; anything where those are more than 64.
    fn at_cell<const D: usize, const N: usize>(cell: [Self; D], value: impl Fn([i32; D]) -> [f64; N]) -> [Self; N] {
        let first = cell.map(|x| x.low as i32);
        let counts = core::array::from_fn::<_, D, _>(|d| (cell[d].high as i32).abs_diff(first[d]) as usize + 1);
        let all = counts.iter().fold(1_usize, |all, count| all.saturating_mul(*count));
        if all > 64 || cell.iter().any(|x| x.low.is_nan() || x.high.is_nan()) {
            return [Self::UNKNOWN; N];
        }
        let at = |index: usize| {
            let mut rest = index;
            let place = core::array::from_fn(|d| {
                let step = rest % counts[d];
                rest /= counts[d];
                first[d] + step as i32
            });
            value(place).map(Self::from_f64)
        };
        (1..all).fold(at(0), |mut hull, index| {
            for (hull, value) in hull.iter_mut().zip(at(index)) {
                *hull = hull.hull(value);
            }
            hull
        })
    }
    fn product_wide(a: Self, b: Self) -> (Self, Self) {
        a.product_exact(b)
    }
    fn angle_wide(opposite: Self, adjacent: Self) -> Self {
        opposite.angle(adjacent)
    }
    /// Clenshaw's sum for a value in [1, 1.3]: u 4.5 ULP times a slope ≤ 0.5; the sums 6; the divisor 2, the division 2.5;
    /// the dropped terms 7e-9 = 0.1.
    fn erfcx_wide(x: Self) -> Self {
        x.monotonic(14.0, |x| Real::erfcx(x.max(0.0)))
    }
}

/// The hull of a function that is another one in each cell of width 1, over every cell that the position may be in.
fn piecewise<T: AccuracyTable, const C: usize>(
    x: Interval<T>,
    cells: usize,
    value: impl Fn(usize, Interval<T>) -> [Interval<T>; C],
) -> [Interval<T>; C] {
    let cell = |end: f64| (end as usize).min(cells - 1);
    let at = |cell: usize| value(cell, (x - Interval::from_f64(cell as f64)).saturate());
    let (first, last) = (cell(x.low), cell(x.high));
    (first + 1..=last).fold(at(first), |mut hull, cell| {
        for (hull, value) in hull.iter_mut().zip(at(cell)) {
            *hull = hull.hull(value);
        }
        hull
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn width(interval: WgslInterval) -> f64 {
        (interval.high - interval.low) / interval.to_f64().abs() / ULP
    }

    #[test]
    fn operations_widen_by_the_table() {
        let (a, b) = (WgslInterval::exactly(1.3), WgslInterval::exactly(0.7));
        for (interval, exact, ulps) in [
            (a + b, 1.3f32 as f64 + 0.7f32 as f64, 2.0),
            (a * b, 1.3f32 as f64 * 0.7f32 as f64, 2.0),
            (a / b, 1.3f32 as f64 / 0.7f32 as f64, 5.0),
            (Real::sqrt(a), (1.3f32 as f64).sqrt(), 9.0),
            (Real::exp(-a), (-(1.3f32 as f64)).exp(), 2.0 * (3.0 + 2.6)),
        ] {
            assert!(interval.low < exact && exact < interval.high, "{interval:?} {exact}");
            assert!((width(interval) / ulps - 1.0).abs() < 1e-3, "{} {ulps}", width(interval));
        }
    }

    #[test]
    fn formulas_hold_their_f32_and_f64_values() {
        use crate::fresnel;
        for i in 0..2000 {
            let cos = (i as f32 + 0.5) / 2000.0;
            for eta in [0.4f32, 0.75, 1.0001, 1.5, 3.0] {
                let interval = fresnel::dielectric(WgslInterval::exactly(cos), WgslInterval::exactly(eta));
                let single = fresnel::dielectric(cos, eta);
                assert!(interval.reflectance.contains(single.reflectance), "{cos} {eta} {interval:?} {single:?}");
                assert!(interval.transmittance.contains(single.transmittance), "{cos} {eta} {interval:?} {single:?}");
                assert!(interval.reflectance.is_bounded());
            }
        }
    }

    #[test]
    fn a_subnormal_is_rounded_to_its_own_spacing() {
        let (a, b) = (f32::MIN_POSITIVE, 1.3e-3f32);
        let product = WgslInterval::exactly(a) * WgslInterval::exactly(b);
        for allowed in [a * b, (a * b).next_up(), 0.0] {
            assert!(product.contains(allowed), "{allowed:e} {product:?}");
        }
        assert!(!product.contains((a * b) * 1.01) && !product.contains(-f32::from_bits(1)), "{product:?}");
    }

    #[test]
    fn an_interpolation_holds_the_nodes_that_its_position_spans() {
        let nodes = [[1.0, 0.0], [4.0, 0.5], [2.0, 0.0], [2.5, 7.0]];
        let at = |low: f64, high: f64| WgslInterval::new(low, high).interpolate(&nodes);
        for (position, want) in [(0.0, [1.0, 0.0]), (1.0, [4.0, 0.5]), (2.5, [2.25, 3.5]), (3.0, [2.5, 7.0])] {
            let [a, b] = at(position, position);
            for (interval, want) in [(a, want[0]), (b, want[1])] {
                assert!(interval.low <= want && want <= interval.high, "{position} {interval:?}");
                assert!(interval.high - interval.low <= 7.1 * ULP * want, "{position} {interval:?}");
            }
            let single: [f32; 2] = (position as f32).interpolate(&nodes);
            assert!(a.contains(single[0]) && b.contains(single[1]));
        }
        let [a, b] = at(0.5, 2.25);
        assert!(a.contains(4.0) && a.contains(2.0) && a.low > 1.99 && a.high < 4.01, "{a:?}");
        assert!(b.contains(0.0) && b.contains(1.75) && b.high < 1.751, "{b:?}");
        // Past an end, as rounding may take a position: the last node.
        assert!(at(2.9, 3.1)[1].contains(7.0) && at(2.9, 3.1)[1].high < 7.001);
        assert!(at(-0.1, 0.1)[0].contains(1.0) && at(-0.1, 0.1)[0].low > 0.999);
    }

    #[test]
    fn an_undecided_comparison_keeps_both_answers() {
        let x = WgslInterval::exactly(0.1) * WgslInterval::exactly(0.1);
        let y = WgslInterval::from_f64(0.01);
        let chosen = WgslInterval::select(x.lt(y), WgslInterval::ZERO, WgslInterval::ONE);
        assert!(chosen.contains(0.0) && chosen.contains(1.0));
        assert!(!(WgslInterval::ONE / (x - y)).is_bounded());
        let certain = WgslInterval::select(x.lt(WgslInterval::ONE), WgslInterval::ZERO, WgslInterval::ONE);
        assert_eq!(certain, WgslInterval::ZERO);
    }
}
