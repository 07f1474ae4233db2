//! Vectors of f32 as numbers: the terms and stages run over a register as they run over one number.
//!
//! [`Single`] is one lane; [`Vectored`] is a [`Register`] of an instruction set.
#![allow(unsafe_code)]

use crate::real::{Mask, Real, Sealed};
use crate::series::{
    ANGLE_SINGLE, COSINE_SINGLE, EXP_SINGLE, LN_SINGLE, SINE_SINGLE, angle_short, erfcx_single, horner,
};
use crate::single::Single;
use crate::twofold::Twofold;
use core::fmt::Debug;
use core::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Some evaluations at once.
pub(crate) trait Lanes: Real<Wide = Self> {
    /// How many.
    const COUNT: usize;
    /// The first [`Self::COUNT`] numbers of a slice that has them.
    fn load(slice: &[f32]) -> Self;
    /// Writes the first numbers of a slice that has room for them.
    fn store(self, slice: &mut [f32]);
    /// Times 2ⁿ, n in [−126, 127], of n + 1.5·2²³ and n.
    fn scale(self, shifted: Self, power: Self) -> Self;
    /// The fraction in [√½, √2) and the power of two of normal numbers > 0.
    fn split(self) -> (Self, Self);
}

/// The numbers of a slice that holds less than a vector, its last again and again behind it.
#[inline(always)]
pub(crate) fn load_part<L: Lanes>(slice: &[f32]) -> L {
    let mut numbers = [slice.last().copied().unwrap_or(0.0); WIDEST];
    for (number, x) in numbers.iter_mut().zip(slice) {
        *number = *x;
    }
    L::load(&numbers)
}

/// As many numbers as a slice that holds less than a vector has room for.
#[inline(always)]
pub(crate) fn store_part<L: Lanes>(vector: L, slice: &mut [f32]) {
    let mut numbers = [0.0; WIDEST];
    vector.store(&mut numbers);
    for (x, number) in slice.iter_mut().zip(numbers) {
        *x = number;
    }
}

/// The lanes of the widest register.
pub(crate) const WIDEST: usize = 16;

/// eˣ; 0 below −87.3, where the result would be subnormal, and infinite above 88. Error: ≤ 1 ULP.
#[inline(always)]
pub(crate) fn exp<L: Lanes>(x: L) -> L {
    let constant = |c: f32| L::from_f64(f64::from(c));
    let value = L::select(x.lt(constant(-87.3)), L::ZERO, exp_within(x));
    L::select(x.gt(constant(88.0)), constant(f32::INFINITY), value)
}

/// eˣ on [−87.3, 88], by a polynomial in what is left of x past the nearest multiple of ln 2.
#[inline(always)]
pub(crate) fn exp_within<L: Lanes>(x: L) -> L {
    let constant = |c: f32| L::from_f64(f64::from(c));
    // x = power·ln 2 + r, |r| ≤ ln2/2: adding 1.5·2²³ rounds to a whole number, which is left in the low bits.
    let magic = constant(12_582_912.0);
    let shifted = x.mul_add(constant(core::f32::consts::LOG2_E), magic);
    let power = shifted - magic;
    // ln 2 in two parts, the first short enough for an exact product.
    let r = power.mul_add(constant(-0.693_359_375), x);
    let r = power.mul_add(constant(2.121_944_4e-4), r);
    let value = L::ONE + (r * r).mul_add(horner(r, &EXP_SINGLE), r);
    value.scale(shifted, power)
}

/// ln x; −∞ at 0 and for subnormal numbers, NaN below. Error: ≤ 2 ULP.
#[inline(always)]
pub(crate) fn ln<L: Lanes>(x: L) -> L {
    let constant = |c: f32| L::from_f64(f64::from(c));
    let (fraction, power) = x.split();
    let value = ln_near_one(fraction - L::ONE, power);
    let value = L::select(x.lt(constant(f32::MIN_POSITIVE)), constant(f32::NEG_INFINITY), value);
    let value = L::select(x.lt(L::ZERO), constant(f32::NAN), value);
    L::select(x.lt(constant(f32::INFINITY)), value, x)
}

/// ln(1+x). Error: ≤ 2 ULP for x ≥ −1/2.
#[inline(always)]
pub(crate) fn ln_one_plus<L: Lanes>(x: L) -> L {
    let constant = |c: f32| L::from_f64(f64::from(c));
    let sum = L::ONE + x;
    let (fraction, power) = sum.split();
    // What the sum rounded off; near 1 the argument itself.
    let lost = L::select(sum.gt(L::TWO), L::ONE - (sum - x), x - (sum - L::ONE));
    let near = x.gt(constant(-0.25)) & x.lt(constant(0.375));
    let value = ln_near_one(L::select(near, x, fraction - L::ONE), L::select(near, L::ZERO, power));
    let value = L::select(near, value, value + lost / sum);
    let end = L::select(sum.lt(L::ZERO), constant(f32::NAN), constant(f32::NEG_INFINITY));
    let value = L::select(sum.gt(L::ZERO), value, end);
    L::select(x.lt(constant(f32::INFINITY)), value, x)
}

/// ln(1+x) of an unrounded sum x, and the rounding error of the result. Relative error: 2⁻²⁹.
#[inline(always)]
pub(crate) fn ln_one_plus_carried<L: Lanes>(high: L, low: L) -> (L, L) {
    let constant = |c: f32| L::from_f64(f64::from(c));
    let (sum, lost) = L::ONE.sum_exact(high);
    // Where the sum is small, what it rounded off is not small beside it.
    let (sum, lost) = sum.sum_exact(lost + low);
    let (fraction, power) = sum.split();
    let near = high.gt(constant(-0.25)) & high.lt(constant(0.375));
    let x = L::select(near, high, fraction - L::ONE);
    let power = L::select(near, L::ZERO, power);
    // What x lacks of the argument: near 1 it is the argument's own.
    let missing = L::select(near, low, lost) / sum;
    // x − x²/2 without rounding, the rest of the series is at most a seventh of it.
    let (square, square_error) = x.product_exact(x);
    let rest = x * square * horner(x, &LN_SINGLE);
    let series = Twofold::sum(x, constant(-0.5) * square);
    let tail = (rest - L::HALF * square_error) + missing;
    // The first part of ln 2 has nine digits: the product is exact.
    let whole = Twofold::new(power * constant(0.693_359_375));
    let tail = power.mul_add(constant(-2.121_944_4e-4), tail);
    let value = whole + Twofold { high: series.high, low: series.low + tail };
    (value.high, value.low)
}

/// The angle of a right triangle, its opposite side an unrounded sum, and the rounding error of the result. Relative error: 2⁻²⁶.
#[inline(always)]
pub(crate) fn angle_carried<L: Lanes>(high: L, low: L, adjacent: L) -> (L, L) {
    let constant = |c: f32| L::from_f64(f64::from(c));
    let opposite = Twofold { high, low };
    let adjacent = Twofold::new(adjacent);
    let steep = high.gt(adjacent.high);
    let larger = Twofold::select(steep, opposite, adjacent);
    let smaller = Twofold::select(steep, adjacent, opposite);
    let divisor = Twofold::select(larger.high.gt(L::ZERO), larger, Twofold::new(L::ONE));
    let r = smaller / divisor;
    let square = r.high * r.high;
    // atan(r) = r + r³·Q(r²), whose slope is 1/(1+r²).
    let odd = Twofold::sum(r.high, r.high * square * horner(square, &ANGLE_SINGLE[1..]));
    let odd = odd + Twofold::new(r.low / (L::ONE + square));
    let right = Twofold { high: constant(core::f32::consts::FRAC_PI_2), low: constant(-4.371_139e-8) };
    let angle = Twofold::select(steep, right - odd, odd);
    (angle.high, angle.low)
}

/// The cosine and sine of x turns, x clamped to [0, 1]. Error: ≤ 3 ULP.
#[inline(always)]
pub(crate) fn unit_circle<L: Lanes>(x: L) -> (L, L) {
    let constant = |c: f32| L::from_f64(f64::from(c));
    let quarters = x.saturate() * constant(4.0);
    // Adding 1.5·2²³ rounds to a whole number, which is left by taking it away.
    let magic = constant(12_582_912.0);
    let nearest = (quarters + magic) - magic;
    let rest = quarters - nearest;
    let square = rest * rest;
    let (c, s) = (horner(square, &COSINE_SINGLE), rest * horner(square, &SINE_SINGLE));
    let (first, second, third) = (constant(0.5).lt(nearest), constant(1.5).lt(nearest), constant(2.5).lt(nearest));
    let last = constant(3.5).lt(nearest);
    let odd = (first & !second) | (third & !last);
    let (cosine, sine) = (L::select(odd, s, c), L::select(odd, c, s));
    (L::select(first & !third, -cosine, cosine), L::select(second & !last, -sine, sine))
}

/// ln(1+x) + power·ln 2 for 1+x in [√½, √2].
#[inline(always)]
fn ln_near_one<L: Lanes>(x: L, power: L) -> L {
    let constant = |c: f32| L::from_f64(f64::from(c));
    let square = x * x;
    let rest = x * square * horner(x, &LN_SINGLE);
    let low = power.mul_add(constant(-2.121_944_4e-4), rest);
    let low = square.mul_add(-L::HALF, low);
    power.mul_add(constant(0.693_359_375), x + low)
}

/// The bits of √½: exponents are counted from there, so that fractions are centred on 1.
const ROOT_HALF: i32 = core::f32::consts::FRAC_1_SQRT_2.to_bits() as i32;

impl<const FUSED: bool> Lanes for Single<FUSED> {
    const COUNT: usize = 1;

    #[inline(always)]
    fn load(slice: &[f32]) -> Self {
        Single(slice[0])
    }
    #[inline(always)]
    fn store(self, slice: &mut [f32]) {
        slice[0] = self.0;
    }
    #[inline(always)]
    fn scale(self, shifted: Self, _: Self) -> Self {
        self * Single(f32::from_bits(shifted.0.to_bits().wrapping_add(127) << 23))
    }
    #[inline(always)]
    fn split(self) -> (Self, Self) {
        let bits = self.0.to_bits() as i32;
        let power = bits.wrapping_sub(ROOT_HALF) >> 23;
        (Single(f32::from_bits(bits.wrapping_sub(power << 23) as u32)), Single(power as f32))
    }
}

/// A register of f32, by the functions of its instruction set.
///
/// # Safety
/// The functions may be called only on a processor with the instruction set: [`Level`](super::Level) sees to it.
pub(crate) trait Register: Copy + Debug + Send + Sync + 'static {
    /// The answer of a comparison.
    type Bits: Copy + Debug + Send + Sync + 'static;
    const COUNT: usize;
    /// Every lane 0, 1, ½, 2, π, 1/π, 2⁻²³ and 87.
    const CONSTANTS: [Self; 8];

    unsafe fn splat(x: f32) -> Self;
    unsafe fn load(from: &[f32]) -> Self;
    unsafe fn store(self, to: &mut [f32]);
    unsafe fn add(self, other: Self) -> Self;
    unsafe fn sub(self, other: Self) -> Self;
    unsafe fn mul(self, other: Self) -> Self;
    unsafe fn div(self, other: Self) -> Self;
    unsafe fn neg(self) -> Self;
    unsafe fn abs(self) -> Self;
    unsafe fn sqrt(self) -> Self;
    /// The other where this one is NaN.
    unsafe fn min(self, other: Self) -> Self;
    unsafe fn max(self, other: Self) -> Self;
    unsafe fn mul_add(self, factor: Self, addend: Self) -> Self;
    /// addend − self·factor, the product without its rounding error.
    unsafe fn remainder(self, factor: Self, addend: Self) -> Self;
    /// What rounding took from the product.
    unsafe fn product_error(self, other: Self, product: Self) -> Self;
    unsafe fn lt(self, other: Self) -> Self::Bits;
    unsafe fn le(self, other: Self) -> Self::Bits;
    unsafe fn select(bits: Self::Bits, yes: Self, no: Self) -> Self;
    unsafe fn not(bits: Self::Bits) -> Self::Bits;
    unsafe fn and(a: Self::Bits, b: Self::Bits) -> Self::Bits;
    unsafe fn or(a: Self::Bits, b: Self::Bits) -> Self::Bits;
    /// A bit for each lane.
    unsafe fn mask(bits: Self::Bits) -> u32;
    unsafe fn scale(self, shifted: Self, power: Self) -> Self;
    unsafe fn split(self) -> (Self, Self);
}

/// A register as a number.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub(crate) struct Vectored<T>(T);

/// The answer of a comparison, lane by lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Answers<T: Register>(T::Bits);

macro_rules! operators {
    ($($trait:ident $method:ident),*) => {$(
        impl<T: Register> $trait for Vectored<T> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: as of Register.
                Vectored(unsafe { self.0.$method(other.0) })
            }
        }
    )*};
}
operators!(Add add, Sub sub, Mul mul, Div div);

/// Methods that are the register's own.
macro_rules! delegate {
    ($($method:ident($($other:ident),*)),*) => {$(
        #[inline(always)]
        fn $method(self $(, $other: Self)*) -> Self {
            // SAFETY: as of Register.
            Vectored(unsafe { self.0.$method($($other.0),*) })
        }
    )*};
}

impl<T: Register> Neg for Vectored<T> {
    type Output = Self;
    delegate!(neg());
}

impl<T: Register> Default for Vectored<T> {
    fn default() -> Self {
        Self::ZERO
    }
}

impl<T: Register> PartialEq for Vectored<T> {
    #[inline(always)]
    fn eq(&self, other: &Self) -> bool {
        (self.le(*other) & other.le(*self)).all()
    }
}

impl<T: Register> Sealed for Vectored<T> {}
impl<T: Register> Lanes for Vectored<T> {
    const COUNT: usize = T::COUNT;

    #[inline(always)]
    fn load(slice: &[f32]) -> Self {
        let slice = &slice[..T::COUNT];
        // SAFETY: as of Register; the slice has as many numbers.
        Vectored(unsafe { T::load(slice) })
    }
    #[inline(always)]
    fn store(self, slice: &mut [f32]) {
        let slice = &mut slice[..T::COUNT];
        // SAFETY: as of Register; the slice has as many numbers.
        unsafe { self.0.store(slice) }
    }
    #[inline(always)]
    fn scale(self, shifted: Self, power: Self) -> Self {
        // SAFETY: as of Register.
        Vectored(unsafe { self.0.scale(shifted.0, power.0) })
    }
    #[inline(always)]
    fn split(self) -> (Self, Self) {
        // SAFETY: as of Register.
        let (fraction, power) = unsafe { self.0.split() };
        (Vectored(fraction), Vectored(power))
    }
}

impl<T: Register> Real for Vectored<T> {
    type Mask = Answers<T>;
    type Wide = Self;
    const CARRIES: bool = true;

    const ZERO: Self = Vectored(T::CONSTANTS[0]);
    const ONE: Self = Vectored(T::CONSTANTS[1]);
    const HALF: Self = Vectored(T::CONSTANTS[2]);
    const TWO: Self = Vectored(T::CONSTANTS[3]);
    const PI: Self = Vectored(T::CONSTANTS[4]);
    const FRAC_1_PI: Self = Vectored(T::CONSTANTS[5]);
    const EPSILON: Self = Vectored(T::CONSTANTS[6]);
    const EXP_LIMIT: Self = Vectored(T::CONSTANTS[7]);

    delegate!(sqrt(), abs(), min(other), max(other), mul_add(factor, addend), remainder(factor, addend));

    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        // SAFETY: as of Register.
        Vectored(unsafe { T::splat(x as f32) })
    }
    /// That of the first lane.
    #[inline(always)]
    fn to_f64(self) -> f64 {
        let mut numbers = [0.0; WIDEST];
        self.store(&mut numbers);
        f64::from(numbers[0])
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
    fn exp(self) -> Self {
        exp(self)
    }
    #[inline(always)]
    fn exp_within(self) -> Self {
        exp_within(self)
    }
    #[inline(always)]
    fn ln(self) -> Self {
        ln(self)
    }
    #[inline(always)]
    fn ln_one_plus(self) -> Self {
        ln_one_plus(self)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Answers<T> {
        // SAFETY: as of Register.
        Answers(unsafe { self.0.lt(other.0) })
    }
    #[inline(always)]
    fn le(self, other: Self) -> Answers<T> {
        // SAFETY: as of Register.
        Answers(unsafe { self.0.le(other.0) })
    }
    #[inline(always)]
    fn select(mask: Answers<T>, yes: Self, no: Self) -> Self {
        // SAFETY: as of Register.
        Vectored(unsafe { T::select(mask.0, yes.0, no.0) })
    }
    #[inline(always)]
    fn product_exact(self, other: Self) -> (Self, Self) {
        let product = self * other;
        // SAFETY: as of Register.
        (product, Vectored(unsafe { self.0.product_error(other.0, product.0) }))
    }
    #[inline(always)]
    fn angle(self, adjacent: Self) -> Self {
        angle_short(self, adjacent)
    }
    #[inline(always)]
    fn unit_circle(self) -> (Self, Self) {
        unit_circle(self)
    }
    #[inline(always)]
    fn floor(self) -> Self {
        let mut numbers = [0.0; WIDEST];
        self.store(&mut numbers);
        for lane in 0..T::COUNT {
            numbers[lane] = Real::floor(numbers[lane]);
        }
        Self::load(&numbers)
    }
    #[inline(always)]
    fn at_cell<const D: usize, const N: usize>(cell: [Self; D], value: impl Fn([i32; D]) -> [f64; N]) -> [Self; N] {
        let (mut places, mut values) = ([[0.0f32; WIDEST]; D], [[0.0f32; WIDEST]; N]);
        for axis in 0..D {
            cell[axis].store(&mut places[axis]);
        }
        for lane in 0..T::COUNT {
            let mut place = [0; D];
            for axis in 0..D {
                place[axis] = places[axis][lane] as i32;
            }
            let found = value(place);
            for number in 0..N {
                values[number][lane] = found[number] as f32;
            }
        }
        let mut loaded = [Self::ZERO; N];
        for number in 0..N {
            loaded[number] = Self::load(&values[number]);
        }
        loaded
    }
    // Each lane has its own cell: the ends are looked up one by one, and the rest is done at once.
    #[inline(always)]
    fn interpolate<const C: usize>(self, nodes: &[[f64; C]]) -> [Self; C] {
        if nodes.is_empty() {
            return [Self::ZERO; C];
        }
        self.linear(nodes.len().max(2) - 1, |left| {
            let (a, b) = (nodes[left], nodes[(left + 1).min(nodes.len() - 1)]);
            let mut ends = [[0.0; 2]; C];
            for channel in 0..C {
                ends[channel] = [a[channel], b[channel]];
            }
            ends
        })
    }
    #[inline(always)]
    fn linear<const C: usize>(self, cells: usize, ends: impl Fn(usize) -> [[f64; 2]; C]) -> [Self; C] {
        let mut numbers = [0.0; WIDEST];
        let (mut low, mut high) = ([[0.0; WIDEST]; C], [[0.0; WIDEST]; C]);
        self.store(&mut numbers);
        for lane in 0..T::COUNT {
            let cell = (numbers[lane] as usize).min(cells - 1);
            let ends = ends(cell);
            numbers[lane] = cell as f32;
            for channel in 0..C {
                (low[channel][lane], high[channel][lane]) = (ends[channel][0] as f32, ends[channel][1] as f32);
            }
        }
        let share = (self - Self::load(&numbers)).saturate();
        let mut values = [Self::ZERO; C];
        for channel in 0..C {
            let a = Self::load(&low[channel]);
            values[channel] = a + (Self::load(&high[channel]) - a) * share;
        }
        values
    }
    #[inline(always)]
    fn bilinear([x, y]: [Self; 2], cells: [usize; 2], node: impl Fn(usize, usize) -> f64) -> Self {
        let (mut columns, mut rows) = ([0.0; WIDEST], [0.0; WIDEST]);
        let mut corners = [[0.0; WIDEST]; 4];
        x.store(&mut columns);
        y.store(&mut rows);
        for lane in 0..T::COUNT {
            let (i, j) = ((columns[lane] as usize).min(cells[0] - 1), (rows[lane] as usize).min(cells[1] - 1));
            (columns[lane], rows[lane]) = (i as f32, j as f32);
            for corner in 0..4 {
                corners[corner][lane] = node(i + corner % 2, j + corner / 2) as f32;
            }
        }
        let across = (x - Self::load(&columns)).saturate();
        let a = Self::load(&corners[0]);
        let low = a + (Self::load(&corners[1]) - a) * across;
        let c = Self::load(&corners[2]);
        let high = c + (Self::load(&corners[3]) - c) * across;
        low + (high - low) * (y - Self::load(&rows)).saturate()
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
    fn ln_one_plus_carried(high: Self, low: Self) -> (Self, Self) {
        ln_one_plus_carried(high, low)
    }
    #[inline(always)]
    fn angle_carried(high: Self, low: Self, adjacent: Self) -> (Self, Self) {
        angle_carried(high, low, adjacent)
    }
    #[inline(always)]
    fn erfcx_wide(x: Self) -> Self {
        erfcx_single(x)
    }
}

impl<T: Register> Not for Answers<T> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        // SAFETY: as of Register.
        Answers(unsafe { T::not(self.0) })
    }
}
impl<T: Register> BitAnd for Answers<T> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        // SAFETY: as of Register.
        Answers(unsafe { T::and(self.0, other.0) })
    }
}
impl<T: Register> BitOr for Answers<T> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        // SAFETY: as of Register.
        Answers(unsafe { T::or(self.0, other.0) })
    }
}
impl<T: Register> Sealed for Answers<T> {}
impl<T: Register> Mask for Answers<T> {
    #[inline(always)]
    fn all(self) -> bool {
        // SAFETY: as of Register.
        unsafe { T::mask(self.0) == (1u32 << T::COUNT) - 1 }
    }
    #[inline(always)]
    fn any(self) -> bool {
        // SAFETY: as of Register.
        unsafe { T::mask(self.0) != 0 }
    }
}
