//! WGSL's builtin functions over intervals: the image of the function, widened by its row of the accuracy table.
//!
//! A function that the table defines by a formula is that formula here. Where the specification leaves a result open (a
//! sine outside [−π, π], a logarithm of a negative number) the interval is everything.

use super::number::{Number, OPEN, Whole, exponent_of, half_of};
use crate::interval::{AccuracyTable, Interval};
use crate::real::{Mask, Real};
use core::f64::consts::{FRAC_PI_2, PI};

/// The largest number of binary16.
const LARGEST_HALF: f64 = 65504.0;

impl<T: AccuracyTable> Interval<T> {
    /// The image under a monotonic function that is exact.
    fn exact(self, f: impl Fn(f64) -> f64) -> Self {
        if self.is_bounded() { Self::new(f(self.low()), f(self.high())) } else { Self::UNKNOWN }
    }

    /// Moved outwards by an absolute error.
    fn loosened(self, by: f64) -> Self {
        Self::new(self.low() - by, self.high() + by)
    }

    fn is_point(self) -> bool {
        self.low() == self.high()
    }

    /// The image of the cosine, to an absolute error.
    fn wave(self, phase: f64) -> Self {
        // The table speaks of [−π, π] alone.
        if !(self.low() >= -PI.next_up() && self.high() <= PI.next_up()) {
            return Self::UNKNOWN;
        }
        let (low, high) = (self.low() - phase, self.high() - phase);
        let (a, b) = (low.cos(), high.cos());
        // A multiple of 2π within gives 1, an odd one of π −1.
        let holds = |offset: f64| ((low - offset) / (2.0 * PI)).ceil() * 2.0 * PI + offset <= high;
        let top = if holds(0.0) { 1.0 } else { a.max(b) };
        let bottom = if holds(PI) { -1.0 } else { a.min(b) };
        Self::new(bottom, top).loosened(T::SINE)
    }

    fn numbers(self) -> Self {
        if self.low().is_nan() || self.high().is_nan() { Self::UNKNOWN } else { self }
    }
}

impl<T: AccuracyTable> Number for Interval<T> {
    const MAY_BE_OPEN: bool = true;
    const MOST: (i64, i64) = (2_147_483_520, 4_294_967_040);

    fn anything() -> Self {
        Self::UNKNOWN
    }
    fn hull(self, other: Self) -> Self {
        Interval::hull(self, other)
    }
    fn truth(mask: Self::Mask) -> u32 {
        match (mask.all(), mask.any()) {
            (true, _) => 1,
            (_, false) => 0,
            _ => OPEN,
        }
    }
    fn equals(self, other: Self) -> Self::Mask {
        self.le(other) & other.le(self)
    }
    fn from_single(value: f32) -> Self {
        if value.is_finite() { Self::exactly(value) } else { Self::UNKNOWN }
    }
    fn flushed(self) -> Self {
        let tiny = f64::from(f32::MIN_POSITIVE);
        let low = if self.low() > 0.0 && self.low() < tiny { 0.0 } else { self.low() };
        let high = if self.high() < 0.0 && self.high() > -tiny { 0.0 } else { self.high() };
        Self::new(low, high)
    }
    fn from_whole(value: i64) -> Self {
        Self::from_f64(value as f64)
    }
    fn bits(self) -> Option<u32> {
        let value = self.low() as f32;
        // The bits of a subnormal number may be those of 0, and those of 0 may carry a sign.
        (self.is_point() && f64::from(value) == self.low() && value.is_normal()).then(|| value.to_bits())
    }
    fn whole(self, low: i64, high: i64) -> Whole {
        if self.low().is_nan() || self.high().is_nan() {
            return Whole::Anything;
        }
        // A cast from floating point saturates.
        Whole::Range((self.low() as i64).clamp(low, high), (self.high() as i64).clamp(low, high))
    }
    fn narrowed(self) -> Self {
        if self.is_point() { Self::from_f64(self.low()) } else { self }
    }
    fn is_nan(self) -> u32 {
        if self.is_bounded() { 0 } else { OPEN }
    }
    fn is_infinite(self) -> u32 {
        if self.is_bounded() { 0 } else { OPEN }
    }

    fn inverse_sqrt(self) -> Self {
        if self.low() > 0.0 { self.monotonic(T::INVERSE_SQRT, |x| 1.0 / x.sqrt()) } else { Self::UNKNOWN }
    }
    fn exp_two(self) -> Self {
        self.monotonic(T::EXP.0 + T::EXP.1 * self.magnitude().min(1e30), f64::exp2)
    }
    fn log_two(self) -> Self {
        if self.low() <= 0.0 {
            return Self::UNKNOWN;
        }
        let image = self.monotonic(T::LOG, f64::log2);
        if self.low() <= 2.0 && self.high() >= 0.5 { image.loosened(T::LOG_NEAR_ONE) } else { image }
    }
    fn power(self, exponent: Self) -> Self {
        (exponent * self.log_two()).exp_two()
    }
    fn sine(self) -> Self {
        self.wave(FRAC_PI_2)
    }
    fn cosine(self) -> Self {
        self.wave(0.0)
    }
    fn tangent(self) -> Self {
        self.sine() / self.cosine()
    }
    fn arc_sine(self) -> Self {
        if self.low() < -1.0 || self.high() > 1.0 {
            return Self::UNKNOWN;
        }
        let direct = self.exact(f64::asin).loosened(T::ARC_SINE);
        direct.hull(self.arc_tangent_of((Self::ONE - self * self).sqrt())).numbers()
    }
    fn arc_cosine(self) -> Self {
        if self.low() < -1.0 || self.high() > 1.0 {
            return Self::UNKNOWN;
        }
        let direct = Self::new(self.high().acos(), self.low().acos()).loosened(T::ARC_SINE);
        direct.hull((Self::ONE - self * self).sqrt().arc_tangent_of(self)).numbers()
    }
    fn arc_tangent(self) -> Self {
        self.monotonic(T::ARC_TANGENT, f64::atan)
    }
    fn arc_tangent_of(self, x: Self) -> Self {
        let circle = Self::rounded(-PI, PI, T::ARC_TANGENT);
        if !(self.is_bounded() && x.is_bounded()) {
            return circle;
        }
        let around_zero = |v: Self| v.low() <= 0.0 && v.high() >= 0.0;
        // The origin has no angle, and the negative axis has two.
        if around_zero(self) && x.low() <= 0.0 {
            return circle;
        }
        let mut ends = [0.0; 4];
        for (index, end) in ends.iter_mut().enumerate() {
            let y = if index & 1 == 0 { self.low() } else { self.high() };
            *end = y.atan2(if index & 2 == 0 { x.low() } else { x.high() });
        }
        let (low, high) =
            ends.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)));
        Self::rounded(low, high, T::ARC_TANGENT)
    }
    fn sine_h(self) -> Self {
        (self.exp() - (-self).exp()) * Self::HALF
    }
    fn cosine_h(self) -> Self {
        (self.exp() + (-self).exp()) * Self::HALF
    }
    fn tangent_h(self) -> Self {
        // max(1e-5 absolute, what sinh/cosh inherits).
        let direct = self.exact(f64::tanh).loosened(1e-5);
        direct.hull(self.sine_h() / self.cosine_h())
    }
    fn arc_sine_h(self) -> Self {
        (self + (self * self + Self::ONE).sqrt()).ln().numbers()
    }
    fn arc_cosine_h(self) -> Self {
        if self.low() < 1.0 {
            return Self::UNKNOWN;
        }
        (self + (self * self - Self::ONE).sqrt()).ln().numbers()
    }
    fn arc_tangent_h(self) -> Self {
        if self.low() <= -1.0 || self.high() >= 1.0 {
            return Self::UNKNOWN;
        }
        (((Self::ONE + self) / (Self::ONE - self)).ln() * Self::HALF).numbers()
    }
    fn round_down(self) -> Self {
        self.exact(f64::floor)
    }
    fn round_up(self) -> Self {
        self.exact(f64::ceil)
    }
    fn round_even(self) -> Self {
        self.exact(f64::round_ties_even)
    }
    fn round_to_zero(self) -> Self {
        self.exact(f64::trunc)
    }
    fn mixed(self, y: Self, t: Self) -> Self {
        // Drivers compute x + (y−x)t as well, and the conformance tests of WebGPU take either.
        (self * (Self::ONE - t) + y * t).hull(self + (y - self) * t)
    }
    fn fraction(self) -> Self {
        if self.low().floor() == self.high().floor() {
            self - self.round_down()
        } else {
            // Just below a whole number the rounded fraction may be 1.
            Self::new(0.0, 1.0)
        }
    }
    fn sign(self) -> Self {
        let sign = |x: f64| {
            if x > 0.0 {
                1.0
            } else if x < 0.0 {
                -1.0
            } else {
                0.0
            }
        };
        Self::new(sign(self.low()), sign(self.high())).numbers()
    }
    fn multiply_add(self, y: Self, z: Self) -> Self {
        // The product's interval holds the exact product too.
        self * y + z
    }
    fn scaled(self, exponent: i32) -> Self {
        let scale = |x: f64| x.scaled(exponent);
        Self::rounded(scale(self.low()), scale(self.high()), if self.is_point() { 0.0 } else { T::SUM })
    }
    fn exponent(self) -> Whole {
        let whole = |x: f64| exponent_of(x).cast_unsigned();
        // A subnormal number may count as 0, whose exponent is 0.
        let normal = self.low() >= f64::from(f32::MIN_POSITIVE) || self.high() <= -f64::from(f32::MIN_POSITIVE);
        let (low, high) = (exponent_of(self.low()), exponent_of(self.high()));
        match (self.is_bounded(), self.is_point()) {
            (true, true) if normal || self.low() == 0.0 => Whole::exactly(whole(self.low())),
            (true, false) if normal => Whole::Range(i64::from(low.min(high)), i64::from(low.max(high))),
            _ => Whole::Anything,
        }
    }
    fn quantized(self) -> Self {
        if !(self.low() >= -LARGEST_HALF && self.high() <= LARGEST_HALF) {
            return Self::UNKNOWN;
        }
        let spacing = |x: f64| 2f64.powi((exponent_of(x) - 11).max(-24));
        let (below, above) = (spacing(self.low()), spacing(self.high()));
        let rounded = Self::new((self.low() / below).floor() * below, (self.high() / above).ceil() * above);
        // Subnormal numbers of binary16 may become 0.
        let smallest = 2f64.powi(-14);
        if self.low() < smallest && self.high() > -smallest { rounded.hull(Self::ZERO) } else { rounded }
    }
    fn half_bits(self) -> Whole {
        let rounded = self.quantized();
        let (low, high) = (half_of(rounded.low()), half_of(rounded.high()));
        if low == high && rounded.is_bounded() { Whole::exactly(u32::from(low)) } else { Whole::Anything }
    }
}
