//! WGSL's builtin functions over [`Enclosure`]s: those of the intervals, each with its domain.

use super::enclosure::{Bounds, Enclosure, above_zero};
use crate::interval::Ternary;
use crate::real::Real;
use crate::shader::interp::{Number, Whole};

/// Forwards methods of one number that is defined everywhere.
macro_rules! forward {
    ($($name:ident)*) => {
        $(fn $name(self) -> Self {
            self.map(Number::$name)
        })*
    };
}

impl Number for Enclosure {
    const MAY_BE_OPEN: bool = true;
    const MOST: (i64, i64) = <Bounds as Number>::MOST;

    fn anything() -> Self {
        Self::ANYTHING
    }
    fn hull(self, other: Self) -> Self {
        self.either(other)
    }
    fn truth(mask: Ternary) -> u32 {
        Bounds::truth(mask)
    }
    fn equals(self, other: Self) -> Ternary {
        self.compare(other, Number::equals)
    }
    fn from_single(value: f32) -> Self {
        Self::from_f64(f64::from(value))
    }
    fn from_whole(value: i64) -> Self {
        Self::from_f64(value as f64)
    }
    fn bits(self) -> Option<u32> {
        self.bounds().bits().filter(|_| self.is_total())
    }
    fn whole(self, low: i64, high: i64) -> Whole {
        if self.is_total() { self.bounds().whole(low, high) } else { Whole::Anything }
    }
    fn narrowed(self) -> Self {
        // Rounding to f32 is part of what such a shader means.
        self.map(|a| Bounds::rounded(a.low(), a.high(), 1.0))
    }
    fn is_nan(self) -> u32 {
        if self.is_total() { 0 } else { Bounds::UNKNOWN.is_nan() }
    }
    fn is_infinite(self) -> u32 {
        if self.is_total() { 0 } else { Bounds::UNKNOWN.is_infinite() }
    }

    forward! {
        inverse_sqrt log_two sine cosine arc_sine arc_cosine arc_tangent tangent_h arc_cosine_h arc_tangent_h
        round_down round_up round_even round_to_zero fraction sign quantized
    }

    fn exp_two(self) -> Self {
        self.map(|a| above_zero(a.exp_two()))
    }
    /// Rises or falls in each argument on its own, where the base is not negative: the ends are those of the corners.
    fn power(self, exponent: Self) -> Self {
        let (base, by) = (self.bounds(), exponent.bounds());
        let defined = base.low() > 0.0 || base.low() == 0.0 && by.low() > 0.0;
        if !(defined && self.is_total() && exponent.is_total()) {
            return Self::ANYTHING;
        }
        let ends = [(base.low(), by.low()), (base.low(), by.high()), (base.high(), by.low()), (base.high(), by.high())];
        let values = ends.map(|(x, y)| x.powf(y));
        let low = values.into_iter().fold(f64::INFINITY, f64::min);
        let high = values.into_iter().fold(0.0, f64::max);
        let bounds = Bounds::rounded(low, high, 0.0);
        Self::of(if base.high() > 0.0 { above_zero(bounds) } else { bounds }, true)
    }
    fn tangent(self) -> Self {
        self.sine() / self.cosine()
    }
    fn arc_tangent_of(self, x: Self) -> Self {
        // The origin has no angle.
        let origin = self.low() <= 0.0 && self.high() >= 0.0 && x.low() <= 0.0 && x.high() >= 0.0;
        if origin { Self::ANYTHING } else { self.join(x, Number::arc_tangent_of) }
    }
    fn sine_h(self) -> Self {
        (self.exp() - (-self).exp()) * Self::HALF
    }
    fn cosine_h(self) -> Self {
        (self.exp() + (-self).exp()) * Self::HALF
    }
    fn arc_sine_h(self) -> Self {
        // The standard library says nothing of its accuracy: an ULP of f32 is plenty.
        self.map(|a| a.monotonic(1.0, f64::asinh))
    }
    fn multiply_add(self, y: Self, z: Self) -> Self {
        self * y + z
    }
    fn scaled(self, exponent: i32) -> Self {
        self.map(|a| a.scaled(exponent))
    }
    fn exponent(self) -> Whole {
        if self.is_total() { self.bounds().exponent() } else { Whole::Anything }
    }
    fn half_bits(self) -> Whole {
        if self.is_total() { self.bounds().half_bits() } else { Whole::Anything }
    }

    /// Both ways to write it hold.
    fn mixed(self, y: Self, t: Self) -> Self {
        let (a, b) = (self * (Self::ONE - t) + y * t, self + (y - self) * t);
        a.join(b, |a, b| Bounds::new(a.low().max(b.low()), a.high().min(b.high())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn builtins_hold_their_images() {
        // A function, what it encloses, and the domain that it is tried on.
        type Case = (fn(Enclosure) -> Enclosure, fn(f64) -> f64, f64, f64);
        let functions: [Case; 12] = [
            (Number::inverse_sqrt, |x| 1.0 / x.sqrt(), 0.1, 3.0),
            (Number::exp_two, f64::exp2, -3.0, 3.0),
            (Number::log_two, f64::log2, 0.1, 3.0),
            (Number::sine, f64::sin, -3.0, 3.0),
            (Number::cosine, f64::cos, -3.0, 3.0),
            (Number::tangent, f64::tan, -1.0, 1.0),
            (Number::arc_sine, f64::asin, -0.9, 0.9),
            (Number::arc_cosine, f64::acos, -0.9, 0.9),
            (Number::arc_tangent, f64::atan, -3.0, 3.0),
            (Number::tangent_h, f64::tanh, -3.0, 3.0),
            (Number::arc_sine_h, f64::asinh, -3.0, 3.0),
            (|x| x.power(Enclosure::from_f64(2.5)), |x| x.powf(2.5), 0.0, 2.0),
        ];
        for (index, (interval, value, low, high)) in functions.into_iter().enumerate() {
            for part in 0..20 {
                let a = low + (high - low) * f64::from(part) / 20.0;
                let b = low + (high - low) * f64::from(part + 1) / 20.0;
                let image = interval(Enclosure::new(a, b));
                assert!(image.is_total(), "{index} [{a}, {b}]");
                for step in 0..=10 {
                    let x = a + (b - a) * f64::from(step) / 10.0;
                    assert!(image.low() <= value(x) && value(x) <= image.high(), "{index} at {x}: {image:?}");
                }
            }
        }
    }

    #[test]
    fn domains_end_what_is_defined() {
        let around = Enclosure::new(-0.5, 0.5);
        for undefined in [
            around.inverse_sqrt(),
            around.log_two(),
            around.power(Enclosure::TWO),
            Enclosure::new(0.0, 1.0).power(Enclosure::ZERO),
            Enclosure::new(0.5, 1.5).arc_cosine(),
            around.arc_tangent_of(around),
        ] {
            assert!(!undefined.is_total(), "{undefined:?}");
        }
        assert_eq!(around.log_two().bits(), None);
        assert_eq!(around.log_two().whole(0, 9), Whole::Anything);
        let mixed = Enclosure::ZERO.mixed(Enclosure::ONE, Enclosure::new(0.0, 1.0));
        assert!(mixed.low() >= 0.0 && mixed.high() < 1.0 + 1e-14, "{mixed:?}");
    }
}
