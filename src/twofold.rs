//! Numbers that carry what their rounding left off, where a type has no digits to spare.
//!
//! In [`Single`](crate::single::Single) an exponent of 80 that is off by half an ULP makes its power wrong by 40: there the steps that a
//! result magnifies are computed in two numbers, the second the rounding error of the first. Over f64, which every other
//! term computes in, [`Real::CARRIES`] is false, the second is never computed and these are the plain operations.

use crate::frame::Vector;
use crate::real::Real;
use core::ops::{Add, Div, Mul, Neg, Sub};

/// The unrounded sum of two numbers: `high` is a value and `low` what was rounded off it, 0 where the type does not carry.
#[derive(Clone, Copy)]
pub(crate) struct Twofold<W> {
    pub(crate) high: W,
    pub(crate) low: W,
}

impl<W: Real> Twofold<W> {
    /// An exact number.
    #[inline(always)]
    pub(crate) fn new(high: W) -> Self {
        Twofold { high, low: W::ZERO }
    }

    /// A constant of formulas.
    #[inline(always)]
    pub(crate) fn constant(x: f64) -> Self {
        let high = W::from_f64(x);
        Twofold { high, low: if W::CARRIES { W::from_f64(x - high.to_f64()) } else { W::ZERO } }
    }

    /// The smaller of the number and 1; 1 for NaN.
    #[inline(always)]
    pub(crate) fn at_most_one(self) -> Self {
        let excess = if W::CARRIES { (self.high - W::ONE) + self.low } else { self.high - W::ONE };
        Self::select(excess.lt(W::ZERO), self, Self::new(W::ONE))
    }

    /// a·b, exactly.
    #[inline(always)]
    pub(crate) fn product(a: W, b: W) -> Self {
        if W::CARRIES { Self::from(a.product_exact(b)) } else { Self::new(a * b) }
    }

    /// a + b, exactly.
    #[inline(always)]
    pub(crate) fn sum(a: W, b: W) -> Self {
        if W::CARRIES { Self::from(a.sum_exact(b)) } else { Self::new(a + b) }
    }

    /// a², exactly.
    #[inline(always)]
    pub(crate) fn square(a: W) -> Self {
        if W::CARRIES { Self::from(a.product_exact(a)) } else { Self::new(a.squared()) }
    }

    #[inline(always)]
    pub(crate) fn squared(self) -> Self {
        if W::CARRIES { self * self } else { Self::new(self.high.squared()) }
    }

    /// √x, 0 below 0.
    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        let high = self.high.max(W::ZERO).sqrt();
        if !W::CARRIES {
            return Self::new(high);
        }
        let (square, error) = high.product_exact(high);
        let rest = ((self.high - square) - error) + self.low;
        let positive = high.gt(W::ZERO);
        let low = W::HALF * rest / W::select(positive, high, W::ONE);
        Twofold { high, low: W::select(positive, low, W::ZERO) }
    }

    /// e⁻ˣ.
    #[inline(always)]
    pub(crate) fn exp_negative(self) -> W {
        let value = (-self.high).exp();
        // exp(−h−l) = exp(−h)(1−l) to l².
        if W::CARRIES { value - value * self.low } else { value }
    }

    /// The nearest single number.
    #[inline(always)]
    pub(crate) fn rounded(self) -> W {
        if W::CARRIES { self.high + self.low } else { self.high }
    }

    #[inline(always)]
    pub(crate) fn select(mask: W::Mask, yes: Self, no: Self) -> Self {
        Twofold { high: W::select(mask, yes.high, no.high), low: W::select(mask, yes.low, no.low) }
    }

    /// ln(1+x).
    #[inline(always)]
    pub(crate) fn ln_one_plus(self) -> Self {
        if W::CARRIES { W::ln_one_plus_carried(self.high, self.low).into() } else { Self::new(self.high.ln_one_plus()) }
    }

    /// [`Real::angle_wide`] of a triangle whose opposite side is this number.
    #[inline(always)]
    pub(crate) fn angle<R: Real<Wide = W>>(self, adjacent: W) -> Self {
        if W::CARRIES {
            W::angle_carried(self.high, self.low, adjacent).into()
        } else {
            Self::new(R::angle_wide(self.high, adjacent))
        }
    }
}

impl<W> From<(W, W)> for Twofold<W> {
    #[inline(always)]
    fn from((high, low): (W, W)) -> Self {
        Twofold { high, low }
    }
}

impl<W: Real> Add for Twofold<W> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        if !W::CARRIES {
            return Self::new(self.high + other.high);
        }
        let (sum, error) = self.high.sum_exact(other.high);
        let error = error + (self.low + other.low);
        // What cancelled may leave the error the larger of the two.
        let high = sum + error;
        Twofold { high, low: error - (high - sum) }
    }
}

impl<W: Real> Sub for Twofold<W> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl<W: Real> Neg for Twofold<W> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Twofold { high: -self.high, low: -self.low }
    }
}

impl<W: Real> Mul for Twofold<W> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        if !W::CARRIES {
            return Self::new(self.high * other.high);
        }
        let (high, error) = self.high.product_exact(other.high);
        Twofold { high, low: self.high.mul_add(other.low, self.low.mul_add(other.high, error)) }
    }
}

impl<W: Real> Mul<W> for Twofold<W> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: W) -> Self {
        if !W::CARRIES {
            return Self::new(self.high * factor);
        }
        let (high, error) = self.high.product_exact(factor);
        Twofold { high, low: self.low.mul_add(factor, error) }
    }
}

impl<W: Real> Div for Twofold<W> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        if !W::CARRIES {
            return Self::new(self.high / other.high);
        }
        // One division, which a loop over one divisor does once.
        let inverse = W::ONE / other.high;
        let high = self.high * inverse;
        let (product, error) = high.product_exact(other.high);
        let rest = ((self.high - product) - error) + (self.low - high * other.low);
        Twofold { high, low: rest * inverse }
    }
}

impl<W: Real> Div<W> for Twofold<W> {
    type Output = Self;
    #[inline(always)]
    fn div(self, divisor: W) -> Self {
        self / Self::new(divisor)
    }
}

impl<W: Real> Vector<W> {
    /// The same vector, of exact components.
    #[inline(always)]
    pub(crate) fn carried(self) -> Vector<Twofold<W>> {
        Vector { x: Twofold::new(self.x), y: Twofold::new(self.y), z: Twofold::new(self.z) }
    }

    /// The sum with another vector, unrounded: half vectors are this.
    #[inline(always)]
    pub(crate) fn sum_carried(self, other: Self) -> Vector<Twofold<W>> {
        let sum = Twofold::sum;
        Vector { x: sum(self.x, other.x), y: sum(self.y, other.y), z: sum(self.z, other.z) }
    }
}

impl<W: Real> Vector<Twofold<W>> {
    /// x² + y².
    #[inline(always)]
    pub(crate) fn sin_squared_carried(self) -> Twofold<W> {
        self.x.squared() + self.y.squared()
    }

    /// x² + y² + z².
    #[inline(always)]
    pub(crate) fn length_squared_carried(self) -> Twofold<W> {
        self.x.squared() + self.y.squared() + self.z.squared()
    }

    /// Each component rounded.
    #[inline(always)]
    pub(crate) fn rounded(self) -> Vector<W> {
        Vector { x: self.x.rounded(), y: self.y.rounded(), z: self.z.rounded() }
    }
}
