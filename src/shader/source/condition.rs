//! The expressions of `#if`: whole numbers, with a name that nobody defined counting as 0.

use super::lexer::{Kind, Token};

/// How deep an expression may nest.
const MOST_NESTING: usize = 100;

/// The value of an expression whose macros have been expanded, or what is wrong with it.
pub(super) fn value(tokens: &[Token]) -> Result<i64, String> {
    let mut reader = Reader { tokens, at: 0, depth: 0 };
    let value = reader.binary(0)?;
    match reader.peek() {
        "" => Ok(value),
        other => Err(format!("`{other}` is not expected here")),
    }
}

struct Reader<'a> {
    tokens: &'a [Token],
    at: usize,
    depth: usize,
}

impl Reader<'_> {
    fn peek(&self) -> &str {
        self.tokens.get(self.at).map_or("", |token| &token.text)
    }

    /// Operators that bind at least as strongly as `least`.
    fn binary(&mut self, least: u32) -> Result<i64, String> {
        self.depth += 1;
        if self.depth > MOST_NESTING {
            return Err(format!("nested more than {MOST_NESTING} deep"));
        }
        let mut left = self.unary()?;
        loop {
            let operator = self.peek().to_owned();
            let strength = match operator.as_str() {
                "||" => 1,
                "&&" => 2,
                "|" => 3,
                "^" => 4,
                "&" => 5,
                "==" | "!=" => 6,
                "<" | "<=" | ">" | ">=" => 7,
                "<<" | ">>" => 8,
                "+" | "-" => 9,
                "*" | "/" | "%" => 10,
                _ => break,
            };
            if strength < least.max(1) {
                break;
            }
            self.at += 1;
            let right = self.binary(strength + 1)?;
            left = match operator.as_str() {
                "||" => i64::from(left != 0 || right != 0),
                "&&" => i64::from(left != 0 && right != 0),
                "|" => left | right,
                "^" => left ^ right,
                "&" => left & right,
                "==" => i64::from(left == right),
                "!=" => i64::from(left != right),
                "<" => i64::from(left < right),
                "<=" => i64::from(left <= right),
                ">" => i64::from(left > right),
                ">=" => i64::from(left >= right),
                "<<" => left.wrapping_shl(right as u32),
                ">>" => left.wrapping_shr(right as u32),
                "+" => left.wrapping_add(right),
                "-" => left.wrapping_sub(right),
                "*" => left.wrapping_mul(right),
                "/" => left.checked_div(right).ok_or("a division by 0")?,
                _ => left.checked_rem(right).ok_or("a division by 0")?,
            };
        }
        self.depth -= 1;
        Ok(left)
    }

    fn unary(&mut self) -> Result<i64, String> {
        let mut operators = Vec::new();
        while matches!(self.peek(), "!" | "-" | "+" | "~") {
            operators.push(self.peek().to_owned());
            self.at += 1;
        }
        let Some(token) = self.tokens.get(self.at) else { return Err("the condition ends too early".to_owned()) };
        self.at += 1;
        let mut value = match token.kind {
            Kind::Number => number(&token.text).ok_or(format!("`{}` is not a whole number", token.text))?,
            Kind::Word if token.is("true") => 1,
            // A macro that takes arguments is not defined: neither is what it would give.
            Kind::Word if self.peek() == "(" => {
                return Err(format!("`{}` is not a macro that takes arguments", token.text));
            }
            Kind::Word => 0,
            _ if token.is("(") => {
                let value = self.binary(0)?;
                if self.peek() != ")" {
                    return Err("a `(` has no `)`".to_owned());
                }
                self.at += 1;
                value
            }
            _ => return Err(format!("`{}` is not expected here", token.text)),
        };
        for operator in operators.iter().rev() {
            value = match operator.as_str() {
                "!" => i64::from(value == 0),
                "-" => value.wrapping_neg(),
                "~" => !value,
                _ => value,
            };
        }
        Ok(value)
    }
}

fn number(text: &str) -> Option<i64> {
    let text = text.trim_end_matches(['u', 'U', 'l', 'L', 'i']);
    match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        Some(digits) => i64::from_str_radix(digits, 16).ok(),
        None => text.parse().ok(),
    }
}
