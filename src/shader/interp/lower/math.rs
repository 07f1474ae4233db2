//! WGSL's builtin functions. Those of more than one component are written out in the operations that the specification
//! says they inherit their accuracy from.

use super::super::code::{Instruction, Real1, Real2, Real3, Slot, Test};
use super::super::error::InterpError;
use super::super::layout::Kind;
use super::super::number::{Number, Whole, half_value};
use super::super::words::{self, map, zip};
use super::{Lowering, Scope};
use naga::{Expression, Handle, MathFunction as Mf, TypeInner};
use std::rc::Rc;

pub(super) type Slots = Rc<[Slot]>;

#[inline(always)]
fn zip3<N: Copy>(out: &mut [N], a: &[N], b: &[N], c: &[N], f: impl Fn(N, N, N) -> N) {
    for (((out, a), b), c) in out.iter_mut().zip(a).zip(b).zip(c) {
        *out = f(*a, *b, *c);
    }
}

impl<'a, N: Number> Lowering<'a, N> {
    /// A call of a builtin function.
    pub(super) fn math(
        &mut self,
        scope: &mut Scope<'a, N>,
        fun: Mf,
        first: Handle<Expression>,
        rest: [Option<Handle<Expression>>; 3],
    ) -> Result<Slots, InterpError> {
        let kind = self.kind(scope, first)?;
        let mut arguments = vec![self.data(scope, first)?];
        for argument in rest.into_iter().flatten() {
            arguments.push(self.data(scope, argument)?);
        }
        let get = |index: usize| arguments.get(index).cloned().unwrap_or_else(|| Rc::from([]));
        let (a, b, c) = (get(0), get(1), get(2));
        if let Some(f) = unary(fun)
            && matches!(kind, Kind::Real(_))
        {
            return self.each_real(scope, f, &a);
        }
        if let Some(f) = binary(fun)
            && matches!(kind, Kind::Real(_))
        {
            return self.each_two(scope, f, &a, &b);
        }
        if let Some(f) = ternary(fun)
            && matches!(kind, Kind::Real(_))
        {
            return self.each_three(scope, f, &a, &b, &c);
        }
        match fun {
            Mf::Dot if matches!(kind, Kind::Real(_)) => Ok(Rc::from([Slot::Real(self.dot(scope, &a, &b)?)])),
            Mf::Length => Ok(Rc::from([Slot::Real(self.length(scope, &a)?)])),
            Mf::Distance => {
                let difference = self.each_two(scope, |o, a, b| zip(o, a, b, |a, b| a - b), &a, &b)?;
                Ok(Rc::from([Slot::Real(self.length(scope, &difference)?)]))
            }
            Mf::Normalize => {
                let length = [Slot::Real(self.length(scope, &a)?)];
                self.each_two(scope, |o, a, b| zip(o, a, b, |a, b| a / b), &a, &length)
            }
            Mf::Cross => self.cross(scope, &a, &b),
            Mf::FaceForward => {
                let towards = self.dot(scope, &b, &c)?;
                let zero = self.real_constant(0.0)?;
                let condition = self.word(scope)?;
                let less: Test<N> = |o, a, b| zip(o, a, b, |a: N, b| N::truth(a.lt(b)));
                self.emit(scope, Instruction::Test(less, condition, towards, zero))?;
                let flipped = self.each_real(scope, |o, a| map(o, a, |a: N| -a), &a)?;
                self.select(scope, &[Slot::Word(condition)], &a, &flipped)
            }
            Mf::Reflect => {
                let along = self.dot(scope, &b, &a)?;
                let twice = self.real1(scope, |o, a| map(o, a, |a: N| N::TWO * a), along)?;
                let part = self.each_two(scope, multiply::<N>(), &b, &[Slot::Real(twice)])?;
                self.each_two(scope, |o, a, b| zip(o, a, b, |a, b| a - b), &a, &part)
            }
            Mf::Refract => self.refract(scope, &a, &b, &c),
            Mf::Outer => {
                let mut product = Vec::new();
                for column in b.iter() {
                    product.extend_from_slice(&self.each_two(scope, multiply::<N>(), &a, &[*column])?);
                }
                Ok(Rc::from(product))
            }
            Mf::Transpose => {
                let rows = self.rows(scope, first)?;
                Ok((0..rows).flat_map(|row| a.iter().skip(row).step_by(rows).copied()).collect())
            }
            Mf::Determinant => {
                let rows = self.rows(scope, first)?;
                Ok(Rc::from([Slot::Real(self.determinant(scope, &a, rows)?)]))
            }
            Mf::Inverse => Err(self.unsupported(scope, "the inverse of a matrix")),
            Mf::Modf => {
                let fraction = self.each_real(scope, |o, a| map(o, a, |a: N| a - a.round_to_zero()), &a)?;
                let whole = self.each_real(scope, |o, a| map(o, a, N::round_to_zero), &a)?;
                Ok(fraction.iter().chain(whole.iter()).copied().collect())
            }
            Mf::Frexp => self.frexp(scope, &a),
            Mf::Ldexp => {
                let mut results = Vec::with_capacity(a.len());
                for (a, b) in a.iter().zip(b.iter()) {
                    let (Slot::Real(a), Slot::Word(b)) = (*a, *b) else {
                        return Err(self.unsupported(scope, "ldexp of these types"));
                    };
                    let to = self.real(scope)?;
                    self.emit(scope, Instruction::Scale(to, a, b))?;
                    results.push(Slot::Real(to));
                }
                Ok(Rc::from(results))
            }
            Mf::Pack4x8snorm => self.pack(scope, &a, 8, true),
            Mf::Pack4x8unorm => self.pack(scope, &a, 8, false),
            Mf::Pack2x16snorm => self.pack(scope, &a, 16, true),
            Mf::Pack2x16unorm => self.pack(scope, &a, 16, false),
            Mf::Pack2x16float => {
                let mut halves = Vec::with_capacity(a.len());
                for slot in a.iter() {
                    halves.push(self.whole(scope, N::half_bits, *slot)?);
                }
                self.gathered(scope, &halves, 16)
            }
            Mf::Unpack4x8snorm => self.unpack(scope, &a, 8, |word| {
                (N::from_whole(i64::from(word.cast_signed())) / N::from_f64(127.0)).max(-N::ONE)
            }),
            Mf::Unpack4x8unorm => {
                self.unpack(scope, &a, 8, |word| N::from_whole(i64::from(word & 0xff)) / N::from_f64(255.0))
            }
            Mf::Unpack2x16snorm => self.unpack(scope, &a, 16, |word| {
                (N::from_whole(i64::from(word.cast_signed())) / N::from_f64(32767.0)).max(-N::ONE)
            }),
            Mf::Unpack2x16unorm => {
                self.unpack(scope, &a, 16, |word| N::from_whole(i64::from(word & 0xffff)) / N::from_f64(65535.0))
            }
            Mf::Unpack2x16float => self.unpack(scope, &a, 16, |word| N::from_single(half_value(word as u16) as f32)),
            _ => self.integers(scope, fun, kind, [&a, &b, &c, &get(3)]),
        }
    }

    fn each_real(&mut self, scope: &mut Scope<'a, N>, f: Real1<N>, a: &[Slot]) -> Result<Slots, InterpError> {
        let mut results = Vec::with_capacity(a.len());
        for slot in a {
            let a = self.as_real(scope, *slot)?;
            results.push(Slot::Real(self.real1(scope, f, a)?));
        }
        Ok(Rc::from(results))
    }

    fn each_two(
        &mut self,
        scope: &mut Scope<'a, N>,
        f: Real2<N>,
        a: &[Slot],
        b: &[Slot],
    ) -> Result<Slots, InterpError> {
        let mut results = Vec::with_capacity(a.len());
        for (index, slot) in a.iter().enumerate() {
            let (a, b) = (self.as_real(scope, *slot)?, self.component(scope, b, index)?);
            results.push(Slot::Real(self.real2(scope, f, a, b)?));
        }
        Ok(Rc::from(results))
    }

    fn each_three(
        &mut self,
        scope: &mut Scope<'a, N>,
        f: Real3<N>,
        a: &[Slot],
        b: &[Slot],
        c: &[Slot],
    ) -> Result<Slots, InterpError> {
        let mut results = Vec::with_capacity(a.len());
        for index in 0..a.len() {
            let (a, b, c) =
                (self.component(scope, a, index)?, self.component(scope, b, index)?, self.component(scope, c, index)?);
            results.push(Slot::Real(self.real3(scope, f, a, b, c)?));
        }
        Ok(Rc::from(results))
    }

    fn as_real(&self, scope: &Scope<'a, N>, slot: Slot) -> Result<u32, InterpError> {
        match slot {
            Slot::Real(column) => Ok(column),
            Slot::Word(_) => Err(self.unsupported(scope, "a function of real numbers on whole ones")),
        }
    }

    pub(super) fn as_word(&self, scope: &Scope<'a, N>, slot: Slot) -> Result<u32, InterpError> {
        match slot {
            Slot::Word(column) => Ok(column),
            Slot::Real(_) => Err(self.unsupported(scope, "a function of whole numbers on real ones")),
        }
    }

    /// A component; the only one of a scalar for every index.
    fn component(&self, scope: &Scope<'a, N>, slots: &[Slot], index: usize) -> Result<u32, InterpError> {
        match slots.get(if slots.len() == 1 { 0 } else { index }) {
            Some(slot) => self.as_real(scope, *slot),
            None => Err(self.unsupported(scope, "arguments of different sizes")),
        }
    }

    fn rows(&self, scope: &Scope<'a, N>, handle: Handle<Expression>) -> Result<usize, InterpError> {
        match self.inner(scope, handle) {
            TypeInner::Matrix { rows, .. } => Ok(rows as usize),
            _ => Err(self.unsupported(scope, "a function of matrices on something else")),
        }
    }

    fn length(&mut self, scope: &mut Scope<'a, N>, a: &[Slot]) -> Result<u32, InterpError> {
        if let [Slot::Real(a)] = a {
            return self.real1(scope, |o, a| map(o, a, N::abs), *a);
        }
        let squared = self.dot(scope, a, a)?;
        self.real1(scope, |o, a| map(o, a, N::sqrt), squared)
    }

    fn cross(&mut self, scope: &mut Scope<'a, N>, a: &[Slot], b: &[Slot]) -> Result<Slots, InterpError> {
        let mut results = Vec::with_capacity(3);
        for (i, j) in [(1, 2), (2, 0), (0, 1)] {
            let (ai, aj) = (self.component(scope, a, i)?, self.component(scope, a, j)?);
            let (bi, bj) = (self.component(scope, b, i)?, self.component(scope, b, j)?);
            results.push(Slot::Real(self.minor(scope, [ai, aj, bi, bj])?));
        }
        Ok(Rc::from(results))
    }

    /// a₀·b₁ − a₁·b₀.
    fn minor(&mut self, scope: &mut Scope<'a, N>, [ai, aj, bi, bj]: [u32; 4]) -> Result<u32, InterpError> {
        let plus = self.real2(scope, multiply::<N>(), ai, bj)?;
        let minus = self.real2(scope, multiply::<N>(), aj, bi)?;
        self.real2(scope, |o, a, b| zip(o, a, b, |a, b| a - b), plus, minus)
    }

    /// By the first column.
    fn determinant(&mut self, scope: &mut Scope<'a, N>, m: &[Slot], rows: usize) -> Result<u32, InterpError> {
        if rows == 2 {
            let [a, b, c, d] = [0, 1, 2, 3].map(|index| self.component(scope, m, index));
            return self.minor(scope, [a?, b?, c?, d?]);
        }
        let mut sum: Option<u32> = None;
        for row in 0..rows {
            let rest: Vec<Slot> =
                m.iter().enumerate().filter(|(i, _)| *i >= rows && i % rows != row).map(|(_, slot)| *slot).collect();
            let inner = self.determinant(scope, &rest, rows - 1)?;
            let factor = self.component(scope, m, row)?;
            let term = self.real2(scope, multiply::<N>(), factor, inner)?;
            sum = Some(match sum {
                None => term,
                Some(sum) if row % 2 == 1 => self.real2(scope, |o, a, b| zip(o, a, b, |a, b| a - b), sum, term)?,
                Some(sum) => self.real2(scope, |o, a, b| zip(o, a, b, |a, b| a + b), sum, term)?,
            });
        }
        sum.ok_or_else(|| self.unsupported(scope, "the determinant of nothing"))
    }

    /// k = 1 − η²(1 − (n·i)²); 0 where k < 0, else η·i − (η·(n·i) + √k)·n.
    fn refract(
        &mut self,
        scope: &mut Scope<'a, N>,
        i: &[Slot],
        n: &[Slot],
        eta: &[Slot],
    ) -> Result<Slots, InterpError> {
        let eta = self.component(scope, eta, 0)?;
        let along = self.dot(scope, n, i)?;
        let k = self.real2(
            scope,
            |o, eta, along| zip(o, eta, along, |eta: N, d| N::ONE - eta * eta * (N::ONE - d * d)),
            eta,
            along,
        )?;
        let factor = self.real3(
            scope,
            |o, eta, along, k| zip3(o, eta, along, k, |eta: N, d, k: N| eta * d + k.max(N::ZERO).sqrt()),
            eta,
            along,
            k,
        )?;
        let scaled = self.each_two(scope, multiply::<N>(), i, &[Slot::Real(eta)])?;
        let part = self.each_two(scope, multiply::<N>(), n, &[Slot::Real(factor)])?;
        let refracted = self.each_two(scope, |o, a, b| zip(o, a, b, |a, b| a - b), &scaled, &part)?;
        let zero = self.real_constant(0.0)?;
        let total = self.word(scope)?;
        let less: Test<N> = |o, a, b| zip(o, a, b, |a: N, b| N::truth(a.lt(b)));
        self.emit(scope, Instruction::Test(less, total, k, zero))?;
        let zeros = vec![Slot::Real(zero); i.len()];
        self.select(scope, &[Slot::Word(total)], &zeros, &refracted)
    }

    fn whole(&mut self, scope: &mut Scope<'a, N>, f: fn(N) -> Whole, slot: Slot) -> Result<u32, InterpError> {
        let a = self.as_real(scope, slot)?;
        let to = self.word(scope)?;
        self.emit(scope, Instruction::Whole(f, to, a))?;
        Ok(to)
    }

    fn frexp(&mut self, scope: &mut Scope<'a, N>, a: &[Slot]) -> Result<Slots, InterpError> {
        let (mut fractions, mut exponents) = (Vec::new(), Vec::new());
        for slot in a {
            let exponent = self.whole(scope, N::exponent, *slot)?;
            let (value, negated) = (self.as_real(scope, *slot)?, self.word1(scope, words::NEGATE, exponent)?);
            let to = self.real(scope)?;
            self.emit(scope, Instruction::Scale(to, value, negated))?;
            fractions.push(Slot::Real(to));
            exponents.push(Slot::Word(exponent));
        }
        fractions.extend(exponents);
        Ok(Rc::from(fractions))
    }

    /// ⌊1/2 + scale·clamp(x)⌋ of each component, from the lowest bits on.
    fn pack(&mut self, scope: &mut Scope<'a, N>, a: &[Slot], bits: u32, signed: bool) -> Result<Slots, InterpError> {
        let f: fn(N) -> Whole = match (bits, signed) {
            (8, true) => |x| packed(x, 127.0, -1.0),
            (8, false) => |x| packed(x, 255.0, 0.0),
            (_, true) => |x| packed(x, 32767.0, -1.0),
            (_, false) => |x| packed(x, 65535.0, 0.0),
        };
        let mut parts = Vec::with_capacity(a.len());
        for slot in a {
            parts.push(self.whole(scope, f, *slot)?);
        }
        self.gathered(scope, &parts, bits)
    }

    /// The lowest bits of each word, side by side.
    pub(super) fn gathered(
        &mut self,
        scope: &mut Scope<'a, N>,
        parts: &[u32],
        bits: u32,
    ) -> Result<Slots, InterpError> {
        let mask = self.word_constant(if bits >= 32 { u32::MAX } else { (1 << bits) - 1 })?;
        let mut all: Option<u32> = None;
        for (index, part) in (0..).zip(parts) {
            let shift = self.word_constant(index * bits)?;
            let low = self.word2(scope, words::AND, *part, mask)?;
            let moved = self.word2(scope, words::SHIFT_LEFT, low, shift)?;
            all = Some(match all {
                None => moved,
                Some(all) => self.word2(scope, words::OR, all, moved)?,
            });
        }
        Ok(all.into_iter().map(Slot::Word).collect())
    }

    /// The parts of a word, from the lowest bits on, with their signs.
    pub(super) fn scattered(
        &mut self,
        scope: &mut Scope<'a, N>,
        word: Slot,
        bits: u32,
        signed: bool,
    ) -> Result<Vec<u32>, InterpError> {
        let word = self.as_word(scope, word)?;
        let mut parts = Vec::new();
        for index in 0..32 / bits {
            let shift = self.word_constant(index * bits)?;
            let moved = self.word2(scope, words::SHIFT_RIGHT, word, shift)?;
            parts.push(match (signed, bits) {
                (true, 8) => self.word1(scope, words::SIGNED_BYTE, moved)?,
                (true, _) => self.word1(scope, words::SIGNED_HALF, moved)?,
                (false, _) => {
                    let mask = self.word_constant((1 << bits) - 1)?;
                    self.word2(scope, words::AND, moved, mask)?
                }
            });
        }
        Ok(parts)
    }

    fn unpack(
        &mut self,
        scope: &mut Scope<'a, N>,
        a: &[Slot],
        bits: u32,
        f: fn(u32) -> N,
    ) -> Result<Slots, InterpError> {
        let Some(word) = a.first() else { return Ok(Rc::from([])) };
        let mut results = Vec::new();
        for part in self.scattered(scope, *word, bits, true)? {
            let to = self.real(scope)?;
            self.emit(scope, Instruction::FromWord(f, to, part))?;
            results.push(Slot::Real(to));
        }
        Ok(Rc::from(results))
    }
}

fn multiply<N: Number>() -> Real2<N> {
    |o, a, b| zip(o, a, b, |a, b| a * b)
}

fn packed<N: Number>(x: N, scale: f64, low: f64) -> Whole {
    let clamped = x.max(N::from_f64(low)).min(N::ONE);
    (N::HALF + N::from_f64(scale) * clamped).round_down().whole(-65536, 65536)
}

fn unary<N: Number>(fun: Mf) -> Option<Real1<N>> {
    Some(match fun {
        Mf::Abs => |o, a| map(o, a, N::abs),
        Mf::Saturate => |o, a| map(o, a, N::saturate),
        Mf::Cos => |o, a| map(o, a, N::cosine),
        Mf::Cosh => |o, a| map(o, a, N::cosine_h),
        Mf::Sin => |o, a| map(o, a, N::sine),
        Mf::Sinh => |o, a| map(o, a, N::sine_h),
        Mf::Tan => |o, a| map(o, a, N::tangent),
        Mf::Tanh => |o, a| map(o, a, N::tangent_h),
        Mf::Acos => |o, a| map(o, a, N::arc_cosine),
        Mf::Asin => |o, a| map(o, a, N::arc_sine),
        Mf::Atan => |o, a| map(o, a, N::arc_tangent),
        Mf::Asinh => |o, a| map(o, a, N::arc_sine_h),
        Mf::Acosh => |o, a| map(o, a, N::arc_cosine_h),
        Mf::Atanh => |o, a| map(o, a, N::arc_tangent_h),
        Mf::Radians => |o, a| map(o, a, |a: N| a * N::from_f64(core::f64::consts::PI / 180.0)),
        Mf::Degrees => |o, a| map(o, a, |a: N| a * N::from_f64(180.0 / core::f64::consts::PI)),
        Mf::Ceil => |o, a| map(o, a, N::round_up),
        Mf::Floor => |o, a| map(o, a, N::round_down),
        Mf::Round => |o, a| map(o, a, N::round_even),
        Mf::Fract => |o, a| map(o, a, N::fraction),
        Mf::Trunc => |o, a| map(o, a, N::round_to_zero),
        Mf::Exp => |o, a| map(o, a, N::exp),
        Mf::Exp2 => |o, a| map(o, a, N::exp_two),
        Mf::Log => |o, a| map(o, a, N::ln),
        Mf::Log2 => |o, a| map(o, a, N::log_two),
        Mf::Sign => |o, a| map(o, a, N::sign),
        Mf::Sqrt => |o, a| map(o, a, N::sqrt),
        Mf::InverseSqrt => |o, a| map(o, a, N::inverse_sqrt),
        Mf::QuantizeToF16 => |o, a| map(o, a, N::quantized),
        _ => return None,
    })
}

fn binary<N: Number>(fun: Mf) -> Option<Real2<N>> {
    Some(match fun {
        Mf::Min => |o, a, b| zip(o, a, b, N::min),
        Mf::Max => |o, a, b| zip(o, a, b, N::max),
        Mf::Atan2 => |o, a, b| zip(o, a, b, N::arc_tangent_of),
        Mf::Pow => |o, a, b| zip(o, a, b, N::power),
        Mf::Step => |o, a, b| zip(o, a, b, |edge: N, x| N::chosen(N::truth(edge.le(x)), N::ONE, N::ZERO)),
        _ => return None,
    })
}

fn ternary<N: Number>(fun: Mf) -> Option<Real3<N>> {
    Some(match fun {
        Mf::Clamp => |o, a, b, c| zip3(o, a, b, c, |x: N, low, high| x.max(low).min(high)),
        Mf::Fma => |o, a, b, c| zip3(o, a, b, c, N::multiply_add),
        Mf::Mix => |o, a, b, c| zip3(o, a, b, c, N::mixed),
        Mf::SmoothStep => |o, a, b, c| {
            zip3(o, a, b, c, |low: N, high, x| {
                let t = ((x - low) / (high - low)).max(N::ZERO).min(N::ONE);
                t * t * (N::from_f64(3.0) - N::TWO * t)
            })
        },
        _ => return None,
    })
}
