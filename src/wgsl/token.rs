//! WGSL text as tokens: what renaming and retyping work on, so that they never touch a comment or half a name.
//!
//! Blanks and comments are no tokens; a token is a span, so whatever lies between two of them can be copied verbatim.

use alloc::vec::Vec;

/// What a [`Token`] is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// An identifier or keyword.
    Word,
    /// A literal with its suffix: `1`, `.5f`, `0x1p-3`.
    Number,
    /// `::`, or any other single character. `>>` and `->` are two, so that templates need no special care.
    Sign,
}

/// A span of bytes of the source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Token {
    pub(crate) kind: Kind,
    pub(crate) start: usize,
    pub(crate) end: usize,
}

impl Token {
    /// The token's text in the source that it was read from.
    pub(crate) fn text(self, source: &str) -> &str {
        source.get(self.start..self.end).unwrap_or_default()
    }
}

/// The tokens of `source`; where a block comment never ends, its offset.
pub(crate) fn tokens(source: &str) -> Result<Vec<Token>, usize> {
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(c) = source[at..].chars().next() {
        let rest = &source[at..];
        let start = at;
        if is_blank(c) {
            at += c.len_utf8();
            continue;
        }
        if rest.starts_with("//") {
            at = line_end(source, at);
            continue;
        }
        if rest.starts_with("/*") {
            at += comment_length(rest).ok_or(start)?;
            continue;
        }
        let kind = if is_word_start(c) {
            at += word_length(rest);
            Kind::Word
        } else if c.is_ascii_digit() || (c == '.' && rest[1..].starts_with(|c: char| c.is_ascii_digit())) {
            at += number_length(rest);
            Kind::Number
        } else {
            at += if rest.starts_with("::") { 2 } else { c.len_utf8() };
            Kind::Sign
        };
        tokens.push(Token { kind, start, end: at });
    }
    Ok(tokens)
}

/// The offset of the line break that ends the line with offset `from`, or the end of the text.
pub(crate) fn line_end(source: &str, from: usize) -> usize {
    source[from..].find(is_line_break).map_or(source.len(), |length| from + length)
}

/// WGSL's line breaks, each of which ends a line comment.
pub(crate) fn is_line_break(c: char) -> bool {
    matches!(c, '\n' | '\u{b}' | '\u{c}' | '\r' | '\u{85}' | '\u{2028}' | '\u{2029}')
}

/// WGSL's blankspace.
pub(crate) fn is_blank(c: char) -> bool {
    c.is_whitespace() || matches!(c, '\u{200e}' | '\u{200f}')
}

// Unicode's XID tables are not at hand; a character outside ASCII that is not blank can only be part of a name.
fn is_word_start(c: char) -> bool {
    c == '_' || c.is_ascii_alphabetic() || !(c.is_ascii() || is_blank(c))
}

fn is_word_part(c: char) -> bool {
    is_word_start(c) || c.is_ascii_digit()
}

fn word_length(rest: &str) -> usize {
    rest.find(|c| !is_word_part(c)).unwrap_or(rest.len())
}

fn number_length(rest: &str) -> usize {
    let bytes = rest.as_bytes();
    let byte = |i: usize| bytes.get(i).map_or(0, u8::to_ascii_lowercase);
    let hex = byte(0) == b'0' && byte(1) == b'x';
    let mut at = if hex { 2 } else { 0 };
    let is_digit = |b: u8| if hex { b.is_ascii_hexdigit() } else { b.is_ascii_digit() };
    while is_digit(byte(at)) {
        at += 1;
    }
    if byte(at) == b'.' {
        at += 1;
        while is_digit(byte(at)) {
            at += 1;
        }
    }
    if byte(at) == if hex { b'p' } else { b'e' } {
        let sign = usize::from(matches!(byte(at + 1), b'+' | b'-'));
        if byte(at + 1 + sign).is_ascii_digit() {
            at += 1 + sign;
        }
    }
    at + word_length(&rest[at..])
}

/// The length of the block comment that `rest` begins with; they nest.
fn comment_length(rest: &str) -> Option<usize> {
    let bytes = rest.as_bytes();
    let (mut at, mut depth) = (0, 0_usize);
    while at + 1 < bytes.len() {
        match &bytes[at..at + 2] {
            b"/*" => depth += 1,
            b"*/" => depth -= 1,
            _ => {
                at += 1;
                continue;
            }
        }
        at += 2;
        if depth == 0 {
            return Some(at);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(source: &str) -> Vec<&str> {
        tokens(source).unwrap().into_iter().map(|t| t.text(source)).collect()
    }

    #[test]
    fn words_numbers_signs() {
        assert_eq!(texts("fn f_1(a: f32)->u32{"), ["fn", "f_1", "(", "a", ":", "f32", ")", "-", ">", "u32", "{"]);
        assert_eq!(texts("a::b:c v.x"), ["a", "::", "b", ":", "c", "v", ".", "x"]);
        assert_eq!(
            texts("1e-5f+.5h-0x1E-5 0x1.8p-3f 1.f 2u 1.e+2"),
            ["1e-5f", "+", ".5h", "-", "0x1E", "-", "5", "0x1.8p-3f", "1.f", "2u", "1.e+2"]
        );
        assert_eq!(texts("array<vec3<f32>,4>>1"), ["array", "<", "vec3", "<", "f32", ">", ",", "4", ">", ">", "1"]);
        assert_eq!(texts("größe 𝛼1 é\u{301}"), ["größe", "𝛼1", "é\u{301}"]);
        assert_eq!(
            tokens("1 a ;").unwrap().iter().map(|t| t.kind).collect::<Vec<_>>(),
            [Kind::Number, Kind::Word, Kind::Sign]
        );
    }

    #[test]
    fn comments_are_no_tokens() {
        assert_eq!(texts("a // b /* c\nd"), ["a", "d"]);
        assert_eq!(texts("a /* b /* c */ // d */ e"), ["a", "e"]);
        assert_eq!(texts("a /* \n */ b /**/ c /*/ d */ e"), ["a", "b", "c", "e"]);
        assert_eq!(texts("a // b\u{2028}c // d\re"), ["a", "c", "e"]);
        assert_eq!(tokens("a /* b /* c */"), Err(2));
        assert_eq!(tokens("/*/"), Err(0));
    }
}
