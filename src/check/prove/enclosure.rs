//! The values of a formula over a box, in exact arithmetic.

use crate::interval::{AccuracyTable, Interval, Ternary};
use crate::real::{Mask, Real, Sealed};
use core::ops::{Add, Div, Mul, Neg, Sub};

/// Operations without error: what remains is the rounding of the bounds themselves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Exact;

impl AccuracyTable for Exact {
    const SUM: f64 = 0.0;
    const QUOTIENT: f64 = 0.0;
    const INVERSE_SQRT: f64 = 0.0;
    const EXP: (f64, f64) = (0.0, 0.0);
    const LOG: f64 = 0.0;
    // What the standard library's functions of double precision may err by, near values of 1.
    const LOG_NEAR_ONE: f64 = 1e-15;
    const SINE: f64 = 1e-15;
    const ARC_TANGENT: f64 = 0.0;
    const ARC_SINE: f64 = 1e-15;
}

pub(super) type Bounds = Interval<Exact>;

/// An interval that holds the values of an expression over a box in exact arithmetic, rounded outwards, and whether every
/// operation that led to them is defined and finite all over the box.
///
/// A root or a logarithm of what may be negative, a quotient by what may be 0 and a result beyond the largest f32 end that
/// for good, whatever is made of them: `max(x/0, 0)` stays undefined. A comparison of what is undefined is open.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Enclosure {
    bounds: Bounds,
    total: bool,
}

impl Enclosure {
    /// Nothing is known, not even that there is a value.
    pub const ANYTHING: Self = Enclosure { bounds: Bounds::UNKNOWN, total: false };

    /// Everything from the first number to the second.
    pub fn new(low: f64, high: f64) -> Self {
        if low <= high { Self::of(Bounds::new(low, high), true) } else { Self::ANYTHING }
    }

    /// The bounds, of a value that is defined where its operands are.
    pub(super) fn of(bounds: Bounds, total: bool) -> Self {
        let bounds = if bounds.low().is_nan() || bounds.high().is_nan() { Bounds::UNKNOWN } else { bounds };
        Enclosure { bounds, total: total && bounds.is_bounded() }
    }

    #[cfg(feature = "shader")]
    pub(super) fn bounds(self) -> Bounds {
        self.bounds
    }

    /// No value is below this one.
    pub fn low(self) -> f64 {
        self.bounds.low()
    }

    /// No value is above this one.
    pub fn high(self) -> f64 {
        self.bounds.high()
    }

    /// Whether there is a finite value at every point of the box.
    pub fn is_total(self) -> bool {
        self.total
    }

    pub(super) fn map(self, f: impl FnOnce(Bounds) -> Bounds) -> Self {
        Self::of(f(self.bounds), self.total)
    }

    pub(super) fn join(self, other: Self, f: impl FnOnce(Bounds, Bounds) -> Bounds) -> Self {
        Self::of(f(self.bounds, other.bounds), self.total && other.total)
    }

    /// The image under a function that is defined for some numbers alone.
    pub(super) fn within(self, domain: bool, f: impl FnOnce(Bounds) -> Bounds) -> Self {
        if domain { self.map(f) } else { Self::ANYTHING }
    }

    pub(super) fn compare(self, other: Self, f: impl FnOnce(Bounds, Bounds) -> Ternary) -> Ternary {
        // NaN compares as it likes.
        if self.total && other.total { f(self.bounds, other.bounds) } else { Ternary::OPEN }
    }

    /// What holds of either.
    pub(super) fn either(self, other: Self) -> Self {
        self.join(other, Bounds::hull)
    }
}

/// A product or quotient whose bounds f64 may have rounded to 0: its signs are those of its operands.
fn underflown(bounds: Bounds, a: Bounds, b: Bounds) -> Bounds {
    let falls = a.low() < 0.0 && b.high() > 0.0 || a.high() > 0.0 && b.low() < 0.0;
    let rises = a.high() > 0.0 && b.high() > 0.0 || a.low() < 0.0 && b.low() < 0.0;
    let low = if falls && bounds.low() == 0.0 { -f64::MIN_POSITIVE } else { bounds.low() };
    let high = if rises && bounds.high() == 0.0 { f64::MIN_POSITIVE } else { bounds.high() };
    Bounds::new(low, high)
}

/// A power, which f64 may have rounded to 0.
pub(super) fn above_zero(bounds: Bounds) -> Bounds {
    Bounds::new(bounds.low(), bounds.high().max(f64::MIN_POSITIVE))
}

impl Add for Enclosure {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        self.join(other, |a, b| a + b)
    }
}

impl Sub for Enclosure {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self.join(other, |a, b| a - b)
    }
}

impl Mul for Enclosure {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        self.join(other, |a, b| underflown(a * b, a, b))
    }
}

impl Div for Enclosure {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        self.join(other, |a, b| underflown(a / b, a, b))
    }
}

impl Neg for Enclosure {
    type Output = Self;
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

impl Sealed for Enclosure {}
impl Real for Enclosure {
    type Mask = Ternary;
    type Wide = Self;

    const ZERO: Self = Enclosure { bounds: Bounds::new(0.0, 0.0), total: true };
    const ONE: Self = Enclosure { bounds: Bounds::new(1.0, 1.0), total: true };
    const HALF: Self = Enclosure { bounds: Bounds::new(0.5, 0.5), total: true };
    const TWO: Self = Enclosure { bounds: Bounds::new(2.0, 2.0), total: true };
    // The numbers of f64 on both sides of that which is nearest.
    const PI: Self = Enclosure {
        bounds: Bounds::new(core::f64::consts::PI.next_down(), core::f64::consts::PI.next_up()),
        total: true,
    };
    const FRAC_1_PI: Self = Enclosure {
        bounds: Bounds::new(core::f64::consts::FRAC_1_PI.next_down(), core::f64::consts::FRAC_1_PI.next_up()),
        total: true,
    };
    const EPSILON: Self = Enclosure { bounds: Bounds::new(f64::EPSILON, f64::EPSILON), total: true };
    const EXP_LIMIT: Self = Enclosure { bounds: Bounds::new(708.0, 708.0), total: true };

    fn from_f64(x: f64) -> Self {
        Self::new(x, x)
    }
    fn to_f64(self) -> f64 {
        self.bounds.to_f64()
    }
    fn widen(self) -> Self {
        self
    }
    fn narrow(wide: Self) -> Self {
        wide
    }

    fn sqrt(self) -> Self {
        self.within(self.low() >= 0.0, Real::sqrt)
    }
    fn exp(self) -> Self {
        self.map(|a| above_zero(a.exp()))
    }
    fn ln(self) -> Self {
        self.within(self.low() > 0.0, Real::ln)
    }
    fn abs(self) -> Self {
        self.map(Real::abs)
    }
    fn min(self, other: Self) -> Self {
        self.join(other, Real::min)
    }
    fn max(self, other: Self) -> Self {
        self.join(other, Real::max)
    }
    fn lt(self, other: Self) -> Ternary {
        self.compare(other, Real::lt)
    }
    fn le(self, other: Self) -> Ternary {
        self.compare(other, Real::le)
    }
    fn select(mask: Ternary, yes: Self, no: Self) -> Self {
        match (mask.all(), mask.any()) {
            (true, _) => yes,
            (_, false) => no,
            _ => yes.either(no),
        }
    }

    fn product_exact(self, other: Self) -> (Self, Self) {
        let (product, rest) = self.bounds.product_exact(other.bounds);
        let total = self.total && other.total;
        (Self::of(product, total), Self::of(rest, total))
    }
    fn sum_exact(self, other: Self) -> (Self, Self) {
        let (sum, rest) = self.bounds.sum_exact(other.bounds);
        let total = self.total && other.total;
        (Self::of(sum, total), Self::of(rest, total))
    }
    fn ln_one_plus(self) -> Self {
        self.within(self.low() > -1.0, Real::ln_one_plus)
    }
    fn angle(self, adjacent: Self) -> Self {
        // Sides are lengths.
        if self.low() < 0.0 || adjacent.low() < 0.0 { Self::ANYTHING } else { self.join(adjacent, Real::angle) }
    }
    fn unit_circle(self) -> (Self, Self) {
        let (cosine, sine) = self.bounds.unit_circle();
        (Self::of(cosine, self.total), Self::of(sine, self.total))
    }
    fn interpolate<const C: usize>(self, nodes: &[[f64; C]]) -> [Self; C] {
        if self.total { self.bounds.interpolate(nodes).map(|value| Self::of(value, true)) } else { [Self::ANYTHING; C] }
    }
    fn linear<const C: usize>(self, cells: usize, ends: impl Fn(usize) -> [[f64; 2]; C]) -> [Self; C] {
        if self.total {
            self.bounds.linear(cells, ends).map(|value| Self::of(value, true))
        } else {
            [Self::ANYTHING; C]
        }
    }
    fn bilinear([x, y]: [Self; 2], cells: [usize; 2], node: impl Fn(usize, usize) -> f64) -> Self {
        if x.total && y.total {
            Self::of(Real::bilinear([x.bounds, y.bounds], cells, node), true)
        } else {
            Self::ANYTHING
        }
    }
    fn floor(self) -> Self {
        self.map(Real::floor)
    }
    fn at_cell<const D: usize, const N: usize>(cell: [Self; D], value: impl Fn([i32; D]) -> [f64; N]) -> [Self; N] {
        let total = cell.iter().all(|x| x.total);
        Bounds::at_cell(cell.map(|x| x.bounds), value).map(|value| Self::of(value, total))
    }
    fn product_wide(a: Self, b: Self) -> (Self, Self) {
        a.product_exact(b)
    }
    fn angle_wide(opposite: Self, adjacent: Self) -> Self {
        opposite.angle(adjacent)
    }
    fn erfcx_wide(x: Self) -> Self {
        x.within(x.low() >= 0.0, Bounds::erfcx_wide)
    }
    /// Both factors are the same number, which the product of intervals does not know.
    fn squared(self) -> Self {
        let magnitude = self.abs();
        magnitude * magnitude
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_undefined_stays_so() {
        let around = Enclosure::new(-1.0, 1.0);
        for undefined in [
            (around - Enclosure::ONE).sqrt(),
            around.ln(),
            Enclosure::ONE / around,
            Enclosure::ONE / around * Enclosure::ZERO,
            (Enclosure::ONE / around).max(Enclosure::ZERO).min(Enclosure::ONE),
            (Enclosure::new(1e30, 2e30) * Enclosure::new(1e30, 1e30)).min(Enclosure::ONE),
            Enclosure::new(1.0, 0.0),
            Enclosure::from_f64(f64::NAN),
        ] {
            assert!(!undefined.is_total(), "{undefined:?}");
        }
        let open = (Enclosure::ONE / around).lt(Enclosure::TWO);
        assert!(open.any() && !open.all());
        // The other branch is not touched by what this one lacks.
        assert!(Enclosure::select(Enclosure::ZERO.lt(Enclosure::ONE), around, around.ln()).is_total());
        assert!(!Enclosure::select(Enclosure::ZERO.lt(around), around, around.ln()).is_total());
    }

    #[test]
    fn squares_are_not_negative() {
        let square = Enclosure::new(-1.0, 2.0).squared();
        assert_eq!(square.low(), 0.0);
        assert!(square.high() >= 4.0 && square.high() < 4.0 + 1e-14);
        assert_eq!((Enclosure::new(-1.0, 2.0) * Enclosure::new(-1.0, 2.0)).low(), -2.0 - 8.0 * f64::EPSILON);
    }

    #[test]
    fn what_underflows_keeps_its_sign() {
        let [tiny, minus] = [1e-200, -1e-200].map(Enclosure::from_f64);
        assert!((tiny * minus).low() < 0.0 && (minus * minus).high() > 0.0);
        assert!((-Enclosure::from_f64(-800.0).exp()).low() < 0.0);
        assert_eq!((tiny * Enclosure::ZERO).low(), 0.0);
    }

    #[test]
    fn literals_are_points_and_pi_is_within() {
        let tenth = Enclosure::from_f64(0.1);
        assert_eq!((tenth.low(), tenth.high()), (0.1, 0.1));
        let one = Enclosure::PI * Enclosure::FRAC_1_PI;
        assert!(one.low() < 1.0 && one.high() > 1.0 && one.high() - one.low() < 1e-14);
    }
}
