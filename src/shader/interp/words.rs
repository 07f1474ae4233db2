//! WGSL's operations on 32-bit integers and bools, one column at a time.

use super::number::OPEN;

pub(super) type Word1 = fn(&mut [u32], &[u32]);
pub(super) type Word2 = fn(&mut [u32], &[u32], &[u32]);

#[inline(always)]
pub(super) fn map<T: Copy, U>(out: &mut [U], a: &[T], f: impl Fn(T) -> U) {
    for (out, a) in out.iter_mut().zip(a) {
        *out = f(*a);
    }
}

#[inline(always)]
pub(super) fn zip<T: Copy, U>(out: &mut [U], a: &[T], b: &[T], f: impl Fn(T, T) -> U) {
    for ((out, a), b) in out.iter_mut().zip(a).zip(b) {
        *out = f(*a, *b);
    }
}

/// A function of two signed numbers.
macro_rules! signed {
    ($f:expr) => {
        |out, a, b| zip(out, a, b, |a, b| $f(a.cast_signed(), b.cast_signed()).cast_unsigned())
    };
}

macro_rules! unsigned {
    ($f:expr) => {
        |out, a, b| zip(out, a, b, $f)
    };
}

pub(super) const ADD: Word2 = unsigned!(u32::wrapping_add);
pub(super) const SUBTRACT: Word2 = unsigned!(u32::wrapping_sub);
pub(super) const MULTIPLY: Word2 = unsigned!(u32::wrapping_mul);
// x/0 = x and x % 0 = 0; MIN/−1 = MIN and MIN % −1 = 0 (WGSL 8.7).
pub(super) const DIVIDE_SIGNED: Word2 = signed!(|a: i32, b: i32| if b == 0 { a } else { a.wrapping_div(b) });
pub(super) const DIVIDE: Word2 = unsigned!(|a: u32, b| a.checked_div(b).unwrap_or(a));
pub(super) const REMAINDER_SIGNED: Word2 = signed!(|a: i32, b: i32| if b == 0 { 0 } else { a.wrapping_rem(b) });
pub(super) const REMAINDER: Word2 = unsigned!(|a: u32, b| a.checked_rem(b).unwrap_or(0));
pub(super) const AND: Word2 = unsigned!(|a, b| a & b);
pub(super) const OR: Word2 = unsigned!(|a, b| a | b);
pub(super) const XOR: Word2 = unsigned!(|a, b| a ^ b);
pub(super) const SHIFT_LEFT: Word2 = unsigned!(u32::wrapping_shl);
pub(super) const SHIFT_RIGHT: Word2 = unsigned!(u32::wrapping_shr);
pub(super) const SHIFT_RIGHT_SIGNED: Word2 =
    |out, a, b| zip(out, a, b, |a, b| a.cast_signed().wrapping_shr(b).cast_unsigned());
pub(super) const EQUAL: Word2 = unsigned!(|a, b| u32::from(a == b));
pub(super) const DIFFERENT: Word2 = unsigned!(|a, b| u32::from(a != b));
pub(super) const LESS: Word2 = unsigned!(|a, b| u32::from(a < b));
pub(super) const LESS_EQUAL: Word2 = unsigned!(|a, b| u32::from(a <= b));
pub(super) const LESS_SIGNED: Word2 = signed!(|a, b| i32::from(a < b));
pub(super) const LESS_EQUAL_SIGNED: Word2 = signed!(|a, b| i32::from(a <= b));
pub(super) const MIN: Word2 = unsigned!(|a: u32, b| a.min(b));
pub(super) const MAX: Word2 = unsigned!(|a: u32, b| a.max(b));
pub(super) const MIN_SIGNED: Word2 = signed!(|a: i32, b| a.min(b));
pub(super) const MAX_SIGNED: Word2 = signed!(|a: i32, b| a.max(b));

pub(super) const NEGATE: Word1 = |out, a| map(out, a, u32::wrapping_neg);
pub(super) const COMPLEMENT: Word1 = |out, a| map(out, a, |a| !a);
pub(super) const ABS: Word1 = |out, a| map(out, a, |a| a.cast_signed().wrapping_abs().cast_unsigned());
pub(super) const SIGN: Word1 = |out, a| map(out, a, |a| a.cast_signed().signum().cast_unsigned());
pub(super) const SIGN_UNSIGNED: Word1 = |out, a| map(out, a, |a| u32::from(a != 0));
pub(super) const NOT_ZERO: Word1 = |out, a| map(out, a, |a| u32::from(a != 0));
pub(super) const TRAILING_ZEROS: Word1 = |out, a| map(out, a, u32::trailing_zeros);
pub(super) const LEADING_ZEROS: Word1 = |out, a| map(out, a, u32::leading_zeros);
pub(super) const ONES: Word1 = |out, a| map(out, a, u32::count_ones);
pub(super) const REVERSE: Word1 = |out, a| map(out, a, u32::reverse_bits);
pub(super) const FIRST_TRAILING: Word1 = |out, a| map(out, a, |a| if a == 0 { u32::MAX } else { a.trailing_zeros() });
pub(super) const FIRST_LEADING: Word1 = |out, a| map(out, a, first_leading);
pub(super) const FIRST_LEADING_SIGNED: Word1 =
    |out, a| map(out, a, |a| first_leading(if a.cast_signed() < 0 { !a } else { a }));

fn first_leading(a: u32) -> u32 {
    if a == 0 { u32::MAX } else { 31 - a.leading_zeros() }
}

// The bools 0, 1 and OPEN, which is 2: Kleene's logic.
pub(super) const NOT: Word1 = |out, a| map(out, a, |a| if a == OPEN { OPEN } else { a ^ 1 });
pub(super) const BOTH: Word2 = unsigned!(|a, b| if a == 0 || b == 0 { 0 } else { a | b & OPEN | a & b & 1 }.min(OPEN));
pub(super) const EITHER: Word2 = unsigned!(|a, b| if a == 1 || b == 1 { 1 } else { a | b });
pub(super) const SAME: Word2 = unsigned!(|a, b| if a == OPEN || b == OPEN { OPEN } else { u32::from(a == b) });
pub(super) const NOT_SAME: Word2 = unsigned!(|a, b| if a == OPEN || b == OPEN { OPEN } else { a ^ b });

/// `extractBits` of an unsigned number; `place` holds offset and count in its two halves, see [`PLACE`].
pub(super) const EXTRACT: Word2 = unsigned!(|e: u32, place: u32| {
    let (offset, count) = (place & 0xffff, place >> 16);
    if count == 0 { 0 } else { (e << (32 - count - offset)) >> (32 - count) }
});
/// `extractBits` of a signed number.
pub(super) const EXTRACT_SIGNED: Word2 = unsigned!(|e: u32, place: u32| {
    let (offset, count) = (place & 0xffff, place >> 16);
    if count == 0 { 0 } else { ((e << (32 - count - offset)).cast_signed() >> (32 - count)).cast_unsigned() }
});
/// Offset and count of a bit field, clamped to the 32 bits that there are.
pub(super) const PLACE: Word2 = unsigned!(|offset: u32, count: u32| {
    let offset = offset.min(32);
    offset | count.min(32 - offset) << 16
});
/// The bits that a field covers.
pub(super) const FIELD: Word1 = |out, a| {
    map(out, a, |place| {
        let (offset, count) = (place & 0xffff, place >> 16);
        let ones = if count == 32 { u32::MAX } else { (1 << count) - 1 };
        ones.checked_shl(offset).unwrap_or(0)
    })
};
/// The first number moved to the offset of a field.
pub(super) const TO_FIELD: Word2 = unsigned!(|e: u32, place: u32| e.checked_shl(place & 0xffff).unwrap_or(0));

/// The lowest byte, with its sign.
pub(super) const SIGNED_BYTE: Word1 = |out, a| map(out, a, |a| i32::from(a as i8).cast_unsigned());
/// The lowest 16 bits, with their sign.
pub(super) const SIGNED_HALF: Word1 = |out, a| map(out, a, |a| i32::from(a as i16).cast_unsigned());

#[cfg(test)]
mod tests {
    use super::*;

    fn two(f: Word2, a: u32, b: u32) -> u32 {
        let mut out = [0];
        f(&mut out, &[a], &[b]);
        out[0]
    }

    #[test]
    fn open_bools_follow_kleene() {
        for (a, b, both, either) in [
            (0, 0, 0, 0),
            (0, 1, 0, 1),
            (1, 1, 1, 1),
            (0, 2, 0, 2),
            (1, 2, 2, 1),
            (2, 2, 2, 2),
            (2, 0, 0, 2),
            (2, 1, 2, 1),
        ] {
            assert_eq!((two(BOTH, a, b), two(EITHER, a, b)), (both, either), "{a} {b}");
        }
    }

    #[test]
    fn bit_fields_stay_within_the_word() {
        let extract = |e, offset, count| two(EXTRACT, e, two(PLACE, offset, count));
        assert_eq!(extract(0xabcd_1234, 4, 8), 0x23);
        assert_eq!(extract(0xabcd_1234, 0, 32), 0xabcd_1234);
        assert_eq!(extract(0xabcd_1234, 32, 1), 0);
        assert_eq!(extract(0xabcd_1234, 28, u32::MAX), 0xa);
        assert_eq!(extract(0xabcd_1234, 5, 0), 0);
        assert_eq!(two(EXTRACT_SIGNED, 0xf0, two(PLACE, 4, 4)), u32::MAX);
    }
}
