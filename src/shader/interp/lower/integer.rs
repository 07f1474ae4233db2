//! WGSL's builtin functions of whole numbers.

use super::super::code::Slot;
use super::super::error::InterpError;
use super::super::layout::Kind;
use super::super::number::Number;
use super::super::words::{self, Word1, Word2};
use super::math::Slots;
use super::{Lowering, Scope};
use naga::MathFunction as Mf;
use std::rc::Rc;

impl<'a, N: Number> Lowering<'a, N> {
    pub(super) fn integers(
        &mut self,
        scope: &mut Scope<'a, N>,
        fun: Mf,
        kind: Kind,
        arguments: [&[Slot]; 4],
    ) -> Result<Slots, InterpError> {
        let [a, b, c, d] = arguments;
        let signed = kind == Kind::Signed;
        let of = |if_signed: Word2, if_unsigned: Word2| if signed { if_signed } else { if_unsigned };
        let (min, max) = (of(words::MIN_SIGNED, words::MIN), of(words::MAX_SIGNED, words::MAX));
        if let Some(f) = unary_word(fun, signed) {
            return a
                .iter()
                .map(|slot| match f {
                    None => Ok(*slot),
                    Some(f) => {
                        let a = self.as_word(scope, *slot)?;
                        self.word1(scope, f, a).map(Slot::Word)
                    }
                })
                .collect();
        }
        let mut results = Vec::with_capacity(a.len());
        match fun {
            Mf::Min | Mf::Max | Mf::Clamp => {
                for (index, slot) in a.iter().enumerate() {
                    let component = |slots: &[Slot]| slots.get(if slots.len() == 1 { 0 } else { index }).copied();
                    let (Some(b), c) = (component(b), component(c)) else {
                        return Err(self.unsupported(scope, "arguments of different sizes"));
                    };
                    let (a, b) = (self.as_word(scope, *slot)?, self.as_word(scope, b)?);
                    results.push(Slot::Word(match (fun, c) {
                        (Mf::Min, _) => self.word2(scope, min, a, b)?,
                        (Mf::Max, _) => self.word2(scope, max, a, b)?,
                        (_, Some(c)) => {
                            let c = self.as_word(scope, c)?;
                            let raised = self.word2(scope, max, a, b)?;
                            self.word2(scope, min, raised, c)?
                        }
                        _ => return Err(self.unsupported(scope, "clamp without bounds")),
                    }));
                }
            }
            Mf::Dot => {
                let mut pairs = Vec::new();
                for (a, b) in a.iter().zip(b) {
                    pairs.push((self.as_word(scope, *a)?, self.as_word(scope, *b)?));
                }
                results.extend(self.word_dot(scope, &pairs)?);
            }
            Mf::Dot4I8Packed | Mf::Dot4U8Packed => {
                let signed = fun == Mf::Dot4I8Packed;
                let ([a], [b]) = (a, b) else {
                    return Err(self.unsupported(scope, "a packed dot product of vectors"));
                };
                let (a, b) = (self.scattered(scope, *a, 8, signed)?, self.scattered(scope, *b, 8, signed)?);
                let pairs: Vec<_> = a.into_iter().zip(b).collect();
                results.extend(self.word_dot(scope, &pairs)?);
            }
            Mf::ExtractBits | Mf::InsertBits => {
                let (offset, count) = if fun == Mf::ExtractBits { (b, c) } else { (c, d) };
                let ([offset], [count]) = (offset, count) else {
                    return Err(self.unsupported(scope, "a bit field by vectors"));
                };
                let (offset, count) = (self.as_word(scope, *offset)?, self.as_word(scope, *count)?);
                let place = self.word2(scope, words::PLACE, offset, count)?;
                for (index, slot) in a.iter().enumerate() {
                    let e = self.as_word(scope, *slot)?;
                    if fun == Mf::ExtractBits {
                        let f = of(words::EXTRACT_SIGNED, words::EXTRACT);
                        results.push(Slot::Word(self.word2(scope, f, e, place)?));
                        continue;
                    }
                    let Some(new) = b.get(index) else {
                        return Err(self.unsupported(scope, "arguments of different sizes"));
                    };
                    let new = self.as_word(scope, *new)?;
                    let field = self.word1(scope, words::FIELD, place)?;
                    let others = self.word1(scope, words::COMPLEMENT, field)?;
                    let kept = self.word2(scope, words::AND, e, others)?;
                    let moved = self.word2(scope, words::TO_FIELD, new, place)?;
                    let put = self.word2(scope, words::AND, moved, field)?;
                    results.push(Slot::Word(self.word2(scope, words::OR, kept, put)?));
                }
            }
            Mf::Pack4xI8 | Mf::Pack4xU8 | Mf::Pack4xI8Clamp | Mf::Pack4xU8Clamp => {
                let mut parts = Vec::with_capacity(a.len());
                for slot in a {
                    let word = self.as_word(scope, *slot)?;
                    parts.push(match fun {
                        Mf::Pack4xI8Clamp => self.clamped(scope, word, (-128i32).cast_unsigned(), 127, true)?,
                        Mf::Pack4xU8Clamp => self.clamped(scope, word, 0, 255, false)?,
                        _ => word,
                    });
                }
                return self.gathered(scope, &parts, 8);
            }
            Mf::Unpack4xI8 | Mf::Unpack4xU8 => {
                let Some(word) = a.first() else { return Ok(Rc::from([])) };
                let parts = self.scattered(scope, *word, 8, fun == Mf::Unpack4xI8)?;
                results.extend(parts.into_iter().map(Slot::Word));
            }
            _ => return Err(self.unsupported(scope, format!("{fun:?} of {kind:?}"))),
        }
        Ok(Rc::from(results))
    }

    fn clamped(
        &mut self,
        scope: &mut Scope<'a, N>,
        word: u32,
        low: u32,
        high: u32,
        signed: bool,
    ) -> Result<u32, InterpError> {
        let (low, high) = (self.word_constant(low)?, self.word_constant(high)?);
        let (min, max) = if signed { (words::MIN_SIGNED, words::MAX_SIGNED) } else { (words::MIN, words::MAX) };
        let raised = self.word2(scope, max, word, low)?;
        self.word2(scope, min, raised, high)
    }

    fn word_dot(&mut self, scope: &mut Scope<'a, N>, pairs: &[(u32, u32)]) -> Result<Option<Slot>, InterpError> {
        let mut sum: Option<u32> = None;
        for (a, b) in pairs {
            let product = self.word2(scope, words::MULTIPLY, *a, *b)?;
            sum = Some(match sum {
                None => product,
                Some(sum) => self.word2(scope, words::ADD, sum, product)?,
            });
        }
        Ok(sum.map(Slot::Word))
    }
}

/// A function of one word; `Some(None)` changes nothing.
fn unary_word(fun: Mf, signed: bool) -> Option<Option<Word1>> {
    Some(Some(match fun {
        Mf::Abs if signed => words::ABS,
        Mf::Abs => return Some(None),
        Mf::Sign if signed => words::SIGN,
        Mf::Sign => words::SIGN_UNSIGNED,
        Mf::CountTrailingZeros => words::TRAILING_ZEROS,
        Mf::CountLeadingZeros => words::LEADING_ZEROS,
        Mf::CountOneBits => words::ONES,
        Mf::ReverseBits => words::REVERSE,
        Mf::FirstTrailingBit => words::FIRST_TRAILING,
        Mf::FirstLeadingBit if signed => words::FIRST_LEADING_SIGNED,
        Mf::FirstLeadingBit => words::FIRST_LEADING,
        _ => return None,
    }))
}
