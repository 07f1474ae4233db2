//! Operators, selections and conversions, component by component.

use super::super::code::{Instruction, Slot, Test};
use super::super::error::InterpError;
use super::super::layout::{Kind, kind_of};
use super::super::number::{Number, Whole};
use super::super::words::{self, Word2, map, zip};
use super::{Lowering, Scope};
use naga::{BinaryOperator, Expression, Handle, RelationalFunction, ScalarKind, TypeInner, UnaryOperator};
use std::rc::Rc;

impl<'a, N: Number> Lowering<'a, N> {
    pub(super) fn unary(
        &mut self,
        scope: &mut Scope<'a, N>,
        op: UnaryOperator,
        kind: Kind,
        slots: &[Slot],
    ) -> Result<Rc<[Slot]>, InterpError> {
        slots
            .iter()
            .map(|slot| match (slot, op) {
                (Slot::Real(a), UnaryOperator::Negate) => {
                    self.real1(scope, |o, a| map(o, a, |a: N| -a), *a).map(Slot::Real)
                }
                (Slot::Word(a), UnaryOperator::Negate) => self.word1(scope, words::NEGATE, *a).map(Slot::Word),
                (Slot::Word(a), UnaryOperator::LogicalNot) => self.negated(scope, *a).map(Slot::Word),
                (Slot::Word(a), UnaryOperator::BitwiseNot) if kind != Kind::Bool => {
                    self.word1(scope, words::COMPLEMENT, *a).map(Slot::Word)
                }
                _ => Err(self.unsupported(scope, format!("{op:?} of {kind:?}"))),
            })
            .collect()
    }

    pub(super) fn operator(
        &mut self,
        scope: &mut Scope<'a, N>,
        op: BinaryOperator,
        left: Handle<Expression>,
        right: Handle<Expression>,
    ) -> Result<Rc<[Slot]>, InterpError> {
        let (a, b) = (self.data(scope, left)?, self.data(scope, right)?);
        if op == BinaryOperator::Multiply {
            use TypeInner::{Matrix, Vector};
            match (self.inner(scope, left), self.inner(scope, right)) {
                (Matrix { rows, .. }, Vector { .. }) => return self.matrix_times(scope, &a, &b, rows as usize),
                (Vector { size, .. }, Matrix { rows, .. }) => {
                    return self.vector_times(scope, &a, &b, size as usize, rows as usize);
                }
                (Matrix { columns, rows, .. }, Matrix { .. }) => {
                    let mut product = Vec::with_capacity(b.len());
                    for column in b.chunks(columns as usize) {
                        product.extend_from_slice(&self.matrix_times(scope, &a, column, rows as usize)?);
                    }
                    return Ok(Rc::from(product));
                }
                _ => {}
            }
        }
        let kind = self.kind(scope, left)?;
        self.binary(scope, op, kind, &a, &b)
    }

    fn matrix_times(
        &mut self,
        scope: &mut Scope<'a, N>,
        matrix: &[Slot],
        vector: &[Slot],
        rows: usize,
    ) -> Result<Rc<[Slot]>, InterpError> {
        let row = |row: usize| matrix.iter().skip(row).step_by(rows.max(1)).copied().collect::<Vec<_>>();
        (0..rows).map(|index| self.dot(scope, &row(index), vector).map(Slot::Real)).collect()
    }

    fn vector_times(
        &mut self,
        scope: &mut Scope<'a, N>,
        vector: &[Slot],
        matrix: &[Slot],
        size: usize,
        rows: usize,
    ) -> Result<Rc<[Slot]>, InterpError> {
        debug_assert_eq!(size, rows);
        matrix.chunks(rows.max(1)).map(|column| self.dot(scope, vector, column).map(Slot::Real)).collect()
    }

    /// Σ aᵢ·bᵢ, from the first on.
    pub(super) fn dot(&mut self, scope: &mut Scope<'a, N>, a: &[Slot], b: &[Slot]) -> Result<u32, InterpError> {
        let mut sum = None;
        for (a, b) in a.iter().zip(b) {
            let (Slot::Real(a), Slot::Real(b)) = (a, b) else {
                return Err(self.unsupported(scope, "a product of this type"));
            };
            let product = self.real2(scope, product(*a, *b), *a, *b)?;
            sum = Some(match sum {
                None => product,
                Some(sum) => self.real2(scope, |o, a, b| zip(o, a, b, |a: N, b| a + b), sum, product)?,
            });
        }
        sum.ok_or_else(|| self.unsupported(scope, "a product of nothing"))
    }

    /// A component-wise operator; one operand may be a scalar.
    pub(super) fn binary(
        &mut self,
        scope: &mut Scope<'a, N>,
        op: BinaryOperator,
        kind: Kind,
        a: &[Slot],
        b: &[Slot],
    ) -> Result<Rc<[Slot]>, InterpError> {
        if kind == Kind::Exponent {
            return Err(self.unsupported(scope, "integers of 64 bits"));
        }
        let count = a.len().max(b.len());
        let at = |slots: &[Slot], index: usize| slots.get(if slots.len() == 1 { 0 } else { index }).copied();
        let mut results = Vec::with_capacity(count);
        for index in 0..count {
            let (Some(a), Some(b)) = (at(a, index), at(b, index)) else {
                return Err(self.unsupported(scope, "operands of different sizes"));
            };
            results.push(match (a, b) {
                (Slot::Real(a), Slot::Real(b)) => self.real_operator(scope, op, a, b)?,
                (Slot::Word(a), Slot::Word(b)) => {
                    let (f, a, b) = match word_operator(op, kind, a, b) {
                        Some(found) => found,
                        None => return Err(self.unsupported(scope, format!("{op:?} of {kind:?}"))),
                    };
                    Slot::Word(self.word2(scope, f, a, b)?)
                }
                _ => return Err(self.unsupported(scope, "operands of different types")),
            });
        }
        Ok(Rc::from(results))
    }

    fn real_operator(
        &mut self,
        scope: &mut Scope<'a, N>,
        op: BinaryOperator,
        a: u32,
        b: u32,
    ) -> Result<Slot, InterpError> {
        use BinaryOperator as Op;
        let f: super::Real2<N> = match op {
            Op::Add => |o, a, b| zip(o, a, b, |a, b| a + b),
            Op::Subtract => |o, a, b| zip(o, a, b, |a, b| a - b),
            Op::Multiply => product(a, b),
            Op::Divide => |o, a, b| zip(o, a, b, |a, b| a / b),
            Op::Modulo => |o, a, b| zip(o, a, b, Number::remainder),
            _ => {
                let f: Test<N> = match op {
                    Op::Equal => |o, a, b| zip(o, a, b, |a: N, b| N::truth(a.equals(b))),
                    Op::NotEqual => |o, a, b| zip(o, a, b, |a: N, b| N::truth(!a.equals(b))),
                    Op::Less => |o, a, b| zip(o, a, b, |a: N, b| N::truth(a.lt(b))),
                    Op::LessEqual => |o, a, b| zip(o, a, b, |a: N, b| N::truth(a.le(b))),
                    Op::Greater => |o, a, b| zip(o, a, b, |a: N, b| N::truth(b.lt(a))),
                    Op::GreaterEqual => |o, a, b| zip(o, a, b, |a: N, b| N::truth(b.le(a))),
                    _ => return Err(self.unsupported(scope, format!("{op:?} of real numbers"))),
                };
                let to = self.word(scope)?;
                self.emit(scope, Instruction::Test(f, to, a, b))?;
                return Ok(Slot::Word(to));
            }
        };
        self.real2(scope, f, a, b).map(Slot::Real)
    }

    /// `yes` where the condition holds; the condition may be one bool for all components.
    pub(super) fn select(
        &mut self,
        scope: &mut Scope<'a, N>,
        condition: &[Slot],
        yes: &[Slot],
        no: &[Slot],
    ) -> Result<Rc<[Slot]>, InterpError> {
        let mut results = Vec::with_capacity(yes.len());
        for (index, (yes, no)) in yes.iter().zip(no).enumerate() {
            let Some(Slot::Word(condition)) = condition.get(if condition.len() == 1 { 0 } else { index }) else {
                return Err(self.unsupported(scope, "a selection by something other than bools"));
            };
            let condition = *condition;
            results.push(match (*yes, *no) {
                (Slot::Real(yes), Slot::Real(no)) => {
                    let to = self.real(scope)?;
                    self.emit(scope, Instruction::SelectReal { to, condition, yes, no })?;
                    Slot::Real(to)
                }
                (Slot::Word(yes), Slot::Word(no)) => {
                    let to = self.word(scope)?;
                    self.emit(scope, Instruction::SelectWord { to, condition, yes, no })?;
                    Slot::Word(to)
                }
                _ => return Err(self.unsupported(scope, "a selection from different types")),
            });
        }
        Ok(Rc::from(results))
    }

    pub(super) fn relational(
        &mut self,
        scope: &mut Scope<'a, N>,
        fun: RelationalFunction,
        argument: Handle<Expression>,
    ) -> Result<Rc<[Slot]>, InterpError> {
        let slots = self.data(scope, argument)?;
        let f: Test<N> = match fun {
            RelationalFunction::IsNan => |o, a, _| map(o, a, N::is_nan),
            RelationalFunction::IsInf => |o, a, _| map(o, a, N::is_infinite),
            RelationalFunction::All | RelationalFunction::Any => {
                let f: Word2 = if fun == RelationalFunction::All { words::BOTH } else { words::EITHER };
                let mut all: Option<u32> = None;
                for slot in slots.iter() {
                    let Slot::Word(column) = *slot else {
                        return Err(self.unsupported(scope, "a logical function of real numbers"));
                    };
                    all = Some(match all {
                        None => column,
                        Some(all) => self.word2(scope, f, all, column)?,
                    });
                }
                return Ok(all.into_iter().map(Slot::Word).collect());
            }
        };
        let mut results = Vec::with_capacity(slots.len());
        for slot in slots.iter() {
            let Slot::Real(a) = *slot else {
                return Err(self.unsupported(scope, "a test of whole numbers for NaN"));
            };
            let to = self.word(scope)?;
            self.emit(scope, Instruction::Test(f, to, a, a))?;
            results.push(Slot::Word(to));
        }
        Ok(Rc::from(results))
    }

    pub(super) fn conversion(
        &mut self,
        scope: &mut Scope<'a, N>,
        from: Handle<Expression>,
        to: ScalarKind,
        convert: Option<naga::Bytes>,
    ) -> Result<Rc<[Slot]>, InterpError> {
        let (slots, kind) = (self.data(scope, from)?, self.kind(scope, from)?);
        let width = convert.unwrap_or(4);
        let target = kind_of(naga::Scalar { kind: to, width }).map_err(|what| self.unsupported(scope, what))?;
        if target == Kind::Exponent {
            return Err(self.unsupported(scope, "integers of 64 bits"));
        }
        let mut results = Vec::with_capacity(slots.len());
        for slot in slots.iter() {
            results.push(match (*slot, target) {
                (Slot::Real(a), Kind::Real(width)) => match (kind, width) {
                    (Kind::Real(8), 4) => Slot::Real(self.real1(scope, |o, a| map(o, a, N::narrowed), a)?),
                    _ => *slot,
                },
                (Slot::Real(a), Kind::Bool) => {
                    let to = self.word(scope)?;
                    let f: Test<N> = |o, a, _| map(o, a, |a: N| N::truth(!a.equals(N::ZERO)));
                    self.emit(scope, Instruction::Test(f, to, a, a))?;
                    Slot::Word(to)
                }
                (Slot::Real(a), integer) => {
                    let f: fn(N) -> Whole = match (convert, integer) {
                        (None, _) => |a| a.bits().map_or(Whole::Anything, Whole::exactly),
                        (Some(_), Kind::Signed) => |a| a.whole(i64::from(i32::MIN), N::MOST.0),
                        (Some(_), _) => |a| a.whole(0, N::MOST.1),
                    };
                    let to = self.word(scope)?;
                    self.emit(scope, Instruction::Whole(f, to, a))?;
                    Slot::Word(to)
                }
                (Slot::Word(a), Kind::Real(_)) => {
                    let f: fn(u32) -> N = match (convert, kind) {
                        (None, _) => |a| N::from_single(f32::from_bits(a)).flushed(),
                        (_, Kind::Signed | Kind::Exponent) => |a| N::from_whole(i64::from(a.cast_signed())),
                        (_, Kind::Bool) => {
                            let (one, zero) = (self.real_constant(1.0)?, self.real_constant(0.0)?);
                            let to = self.real(scope)?;
                            self.emit(scope, Instruction::SelectReal { to, condition: a, yes: one, no: zero })?;
                            results.push(Slot::Real(to));
                            continue;
                        }
                        _ => |a| N::from_whole(i64::from(a)),
                    };
                    let to = self.real(scope)?;
                    self.emit(scope, Instruction::FromWord(f, to, a))?;
                    Slot::Real(to)
                }
                (Slot::Word(a), Kind::Bool) if kind != Kind::Bool => {
                    Slot::Word(self.word1(scope, words::NOT_ZERO, a)?)
                }
                (Slot::Word(a), integer) if kind == Kind::Bool && integer != Kind::Bool => {
                    Slot::Word(self.decided(scope, a)?)
                }
                (Slot::Word(_), _) => *slot,
            });
        }
        Ok(Rc::from(results))
    }
}

/// The product of two registers. That of one with itself is a square, which bounds know not to be negative.
fn product<N: Number>(a: u32, b: u32) -> super::Real2<N> {
    if a == b { |o, a, b| zip(o, a, b, |a: N, _| a.squared()) } else { |o, a, b| zip(o, a, b, |a, b| a * b) }
}

/// An operator on words, with its operands in the order that it takes them.
fn word_operator(op: BinaryOperator, kind: Kind, a: u32, b: u32) -> Option<(Word2, u32, u32)> {
    use BinaryOperator as Op;
    let signed = kind == Kind::Signed;
    if kind == Kind::Bool {
        return match op {
            Op::And | Op::LogicalAnd => Some((words::BOTH, a, b)),
            Op::InclusiveOr | Op::LogicalOr => Some((words::EITHER, a, b)),
            Op::Equal => Some((words::SAME, a, b)),
            Op::NotEqual | Op::ExclusiveOr => Some((words::NOT_SAME, a, b)),
            _ => None,
        };
    }
    let of = |if_signed: Word2, if_unsigned: Word2| if signed { if_signed } else { if_unsigned };
    let (f, swapped) = match op {
        Op::Add => (words::ADD, false),
        Op::Subtract => (words::SUBTRACT, false),
        Op::Multiply => (words::MULTIPLY, false),
        Op::Divide => (of(words::DIVIDE_SIGNED, words::DIVIDE), false),
        Op::Modulo => (of(words::REMAINDER_SIGNED, words::REMAINDER), false),
        Op::Equal => (words::EQUAL, false),
        Op::NotEqual => (words::DIFFERENT, false),
        Op::Less => (of(words::LESS_SIGNED, words::LESS), false),
        Op::LessEqual => (of(words::LESS_EQUAL_SIGNED, words::LESS_EQUAL), false),
        Op::Greater => (of(words::LESS_SIGNED, words::LESS), true),
        Op::GreaterEqual => (of(words::LESS_EQUAL_SIGNED, words::LESS_EQUAL), true),
        Op::And => (words::AND, false),
        Op::ExclusiveOr => (words::XOR, false),
        Op::InclusiveOr => (words::OR, false),
        Op::ShiftLeft => (words::SHIFT_LEFT, false),
        Op::ShiftRight => (of(words::SHIFT_RIGHT_SIGNED, words::SHIFT_RIGHT), false),
        Op::LogicalAnd | Op::LogicalOr => return None,
    };
    Some(if swapped { (f, b, a) } else { (f, a, b) })
}
