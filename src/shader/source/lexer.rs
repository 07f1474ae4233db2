//! Text as tokens that know where they were written: what the preprocessor and everything after it work on.

use super::Language;
use super::error::SourceError;
use std::rc::Rc;

/// A file that tokens came from.
#[derive(Clone, Debug)]
pub(super) struct File {
    pub(super) name: String,
    pub(super) text: String,
    /// Where it lies, for what it includes itself.
    pub(super) directory: Option<std::path::PathBuf>,
}

/// Where a token was written: for what a macro gave, where the macro was used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Origin {
    pub(super) file: u32,
    /// From 1.
    pub(super) line: u32,
    /// From 1, in characters.
    pub(super) column: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Word,
    Number,
    /// An operator or bracket, as long as it can be.
    Sign,
    /// Between double quotes; the text is without them.
    Quoted,
}

/// The macros that a token came from: none of them is expanded in it again.
pub(super) type Hidden = Option<Rc<HiddenList>>;

#[derive(Debug)]
pub(super) struct HiddenList {
    pub(super) name: Rc<str>,
    pub(super) rest: Hidden,
    /// How many macros the list holds.
    pub(super) length: usize,
}

#[derive(Clone, Debug)]
pub(super) struct Token {
    pub(super) text: Rc<str>,
    pub(super) kind: Kind,
    pub(super) origin: Origin,
    /// Blanks or a comment come before it.
    pub(super) spaced: bool,
    /// It is the first of its line.
    pub(super) leads: bool,
    pub(super) hidden: Hidden,
}

impl Token {
    /// A token that nobody wrote, in place of one that somebody did.
    pub(super) fn instead(text: &str, kind: Kind, of: &Token) -> Self {
        Token { text: text.into(), kind, hidden: None, ..of.clone() }
    }

    pub(super) fn is(&self, text: &str) -> bool {
        &*self.text == text && self.kind != Kind::Quoted
    }

    pub(super) fn is_word(&self) -> bool {
        self.kind == Kind::Word
    }
}

/// Longest first.
const SIGNS: [&str; 24] = [
    "<<=", ">>=", "##", "&&", "||", "^^", "==", "!=", "<=", ">=", "<<", ">>", "++", "--", "+=", "-=", "*=", "/=", "%=",
    "&=", "|=", "^=", "->", "::",
];

/// The tokens of a file.
pub(super) fn lex(files: &[File], index: usize, language: Language) -> Result<Vec<Token>, SourceError> {
    let Some(file) = files.get(index) else { return Ok(Vec::new()) };
    let mut reader = Reader::new(&file.text, index as u32);
    let mut tokens = Vec::new();
    let (mut spaced, mut leads) = (false, true);
    while let Some(c) = reader.rest().chars().next() {
        let rest = reader.rest();
        let continuation = ["\\\r\n", "\\\n"].into_iter().find(|end| rest.starts_with(end));
        if let Some(continuation) = continuation {
            reader.take(continuation.len());
            spaced = true;
        } else if c.is_whitespace() || matches!(c, '\u{200e}' | '\u{200f}' | '\u{feff}') {
            leads |= c == '\n' || c == '\r';
            spaced = true;
            reader.take(c.len_utf8());
        } else if rest.starts_with("//") {
            // A continued line continues its comment.
            let mut length = 0;
            for line in rest.split_inclusive('\n') {
                length += line.trim_end_matches(['\n', '\r']).len();
                if !line.trim_end_matches(['\n', '\r']).ends_with('\\') || !line.ends_with('\n') {
                    break;
                }
                length += line.len() - line.trim_end_matches(['\n', '\r']).len();
            }
            reader.take(length);
            spaced = true;
        } else if rest.starts_with("/*") {
            let Some(length) = comment_length(rest, language == Language::Wgsl) else {
                return Err(SourceError::at(files, reader.origin(), "a comment that does not end"));
            };
            reader.take(length);
            spaced = true;
        } else {
            let origin = reader.origin();
            let (kind, length) = kind_and_length(rest, c);
            let text = reader.take(length);
            let text = if kind == Kind::Quoted { text.trim_matches('"') } else { text };
            tokens.push(Token { text: text.into(), kind, origin, spaced, leads, hidden: None });
            (spaced, leads) = (false, false);
        }
    }
    Ok(tokens)
}

/// The tokens of a text alone, comments left out; empty where it has no end.
pub(super) fn words(text: &str) -> Vec<Rc<str>> {
    let file = File { name: String::new(), text: text.to_owned(), directory: None };
    let tokens = lex(&[file], 0, Language::Glsl).unwrap_or_default();
    tokens.into_iter().map(|token| token.text).collect()
}

pub(super) fn is_name(word: &str) -> bool {
    word.starts_with(is_word_start)
}

fn is_word_start(c: char) -> bool {
    c == '_' || c.is_ascii_alphabetic() || !(c.is_ascii() || c.is_whitespace())
}

fn kind_and_length(rest: &str, c: char) -> (Kind, usize) {
    let word_length = |from: usize| {
        let tail = rest.get(from..).unwrap_or_default();
        from + tail.find(|c: char| !(is_word_start(c) || c.is_ascii_digit())).unwrap_or(tail.len())
    };
    let bytes = rest.as_bytes();
    let byte = |at: usize| bytes.get(at).copied().unwrap_or_default();
    if is_word_start(c) {
        (Kind::Word, word_length(0))
    } else if c.is_ascii_digit() || c == '.' && byte(1).is_ascii_digit() {
        // As C has it: letters, digits, dots, and a sign after an exponent.
        let hex = byte(0) == b'0' && byte(1).eq_ignore_ascii_case(&b'x');
        let mut at = 1;
        loop {
            let exponent = if hex { b'p' } else { b'e' };
            let signed = matches!(byte(at), b'+' | b'-') && byte(at - 1).eq_ignore_ascii_case(&exponent);
            // `1..2` and `1.x` are no numbers of either language; a second dot ends the number.
            let dot = byte(at) == b'.' && !rest.get(..at).unwrap_or_default().contains('.');
            if byte(at).is_ascii_alphanumeric() || byte(at) == b'_' || dot || signed {
                at += 1;
            } else {
                break;
            }
        }
        (Kind::Number, at)
    } else if c == '"' {
        let tail = rest.get(1..).unwrap_or_default();
        let end = tail.find(['"', '\n']).unwrap_or(tail.len());
        (Kind::Quoted, 1 + end + usize::from(tail.get(end..).is_some_and(|tail| tail.starts_with('"'))))
    } else {
        let sign = SIGNS.into_iter().find(|sign| rest.starts_with(sign));
        (Kind::Sign, sign.map_or(c.len_utf8(), str::len))
    }
}

fn comment_length(rest: &str, nests: bool) -> Option<usize> {
    if !nests {
        return rest.get(2..)?.find("*/").map(|length| length + 4);
    }
    let (mut at, mut depth) = (0, 0usize);
    while let Some(pair) = rest.as_bytes().get(at..at + 2) {
        match pair {
            b"/*" => (at, depth) = (at + 2, depth + 1),
            b"*/" => (at, depth) = (at + 2, depth.saturating_sub(1)),
            _ => at += 1,
        }
        if depth == 0 {
            return Some(at);
        }
    }
    None
}

/// A text read from the front, with the place reached.
struct Reader<'a> {
    text: &'a str,
    at: usize,
    origin: Origin,
}

impl<'a> Reader<'a> {
    fn new(text: &'a str, file: u32) -> Self {
        Reader { text, at: 0, origin: Origin { file, line: 1, column: 1 } }
    }
    fn rest(&self) -> &'a str {
        self.text.get(self.at..).unwrap_or_default()
    }
    fn origin(&self) -> Origin {
        self.origin
    }
    fn take(&mut self, length: usize) -> &'a str {
        let taken = self.rest().get(..length).unwrap_or_else(|| self.rest());
        self.at += taken.len();
        for c in taken.chars() {
            if c == '\n' {
                (self.origin.line, self.origin.column) = (self.origin.line + 1, 1);
            } else {
                self.origin.column += 1;
            }
        }
        taken
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(text: &str, language: Language) -> Vec<String> {
        let file = File { name: "a".into(), text: text.into(), directory: None };
        lex(&[file], 0, language).unwrap().into_iter().map(|token| token.text.to_string()).collect()
    }

    #[test]
    fn tokens_are_as_long_as_they_can_be() {
        let both = "a<<=b##c 1.5e-3f .5 0x1p-3 x.y->z::w // c \\\n d\n/* e */f";
        let want = ["a", "<<=", "b", "##", "c", "1.5e-3f", ".5", "0x1p-3", "x", ".", "y", "->", "z", "::", "w", "f"];
        assert_eq!(texts(both, Language::Glsl), want);
        assert_eq!(texts("a\\\nb \"c d\" #include <e>", Language::Glsl).len(), 8);
        assert_eq!(texts("1.xx 2..3", Language::Glsl), ["1.xx", "2.", ".3"]);
    }

    #[test]
    fn comments_nest_in_wgsl_alone() {
        assert_eq!(texts("a /* /* */ b", Language::Glsl), ["a", "b"]);
        assert_eq!(texts("a /* /* */ */ b", Language::Wgsl), ["a", "b"]);
        let file = File { name: "a.wgsl".into(), text: "\n  /* /* */".into(), directory: None };
        let error = lex(&[file], 0, Language::Wgsl).unwrap_err();
        assert_eq!(error.to_string(), "a.wgsl:2:3: a comment that does not end");
    }

    #[test]
    fn places_count_characters() {
        let file = File { name: "a".into(), text: "é b\n\tc".into(), directory: None };
        let tokens = lex(&[file], 0, Language::Glsl).unwrap();
        let places: Vec<_> = tokens.iter().map(|token| (token.origin.line, token.origin.column)).collect();
        assert_eq!(places, [(1, 1), (1, 3), (2, 2)]);
        assert!(tokens[2].leads && tokens[1].spaced && !tokens[1].leads);
    }
}
