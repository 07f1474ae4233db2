//! The text of a module in double precision.
//!
//! naga rounds literals to f32 when it parses, so that its f32 module evaluated in f64 still carries constants wrong at
//! 1e-8. Retyping works on tokens before that: `f32` → `f64`, `vec3f` → `vec3<f64>`, `mat2x3f` → `mat2x3<f64>`, and a
//! literal of floating point becomes one of f64 with the decimal digits that stand there, whatever its suffix.
//!
//! Words stay 32 bits wide. Where a number meets its bits it goes through f32 as it does on a device:
//! `bitcast<u32>(x)` becomes `bitcast<u32>(f32(x))`, `bitcast<f32>(n)` becomes `f64(bitcast<f32>(n))`; so do `pack…`,
//! `unpack…` and `quantizeToF16`. `f16` is refused. Line breaks stay where they are.

use crate::shader::{Module, ShaderError};
use crate::wgsl::token::{Kind, Token, tokens};
use naga::{Expression, Handle, ScalarKind, TypeInner};
use std::collections::HashMap;

/// What an argument or a result of floating point is, in words of WGSL: `f32`, `vec3<f32>`.
type Shape = Option<u8>;

/// The builtin calls of a module that concern bits, by the offset of their first byte.
struct Calls {
    /// The shapes of the argument and of the result, where they are of floating point.
    by_start: HashMap<usize, (Option<Shape>, Option<Shape>)>,
}

/// The text of `source` in double precision; `written` is the module that it parses to.
pub(super) fn in_double(source: &str, written: &Module) -> Result<String, ShaderError> {
    let refuse = |message: String, at: usize| {
        let line = 1 + source.get(..at).unwrap_or_default().matches('\n').count();
        ShaderError::plain(format!("line {line}: {message}"))
    };
    let tokens = tokens(source).map_err(|at| refuse("a comment that never ends".to_owned(), at))?;
    let calls = Calls::of(written);
    // What replaces or precedes a byte offset, in order.
    let mut edits: Vec<(usize, usize, String)> = Vec::new();
    let mut verbatim_until = 0;
    for (index, token) in tokens.iter().enumerate() {
        if index < verbatim_until {
            continue;
        }
        let text = token.text(source);
        match token.kind {
            Kind::Number => {
                if let Some(literal) = double_literal(text) {
                    let literal = literal.map_err(|message| refuse(message, token.start))?;
                    edits.push((token.start, token.end, literal));
                }
            }
            Kind::Word => {
                if matches!(text, "f16") || text.starts_with("vec") && text.ends_with('h') && text.len() == 5 {
                    return Err(refuse(format!("`{text}` has no meaning in double precision"), token.start));
                }
                if let Some((argument, result)) = calls.by_start.get(&token.start) {
                    let Some((open, close)) = parentheses(&tokens, source, index) else { continue };
                    if text == "bitcast" {
                        verbatim_until = open;
                    }
                    if let Some(shape) = result {
                        edits.push((token.start, token.start, format!("{}(", spelled(*shape, "f64"))));
                        edits.push((tokens[close].end, tokens[close].end, ")".to_owned()));
                    }
                    if let Some(shape) = argument {
                        edits.push((tokens[open].end, tokens[open].end, format!("{}(", spelled(*shape, "f32"))));
                        edits.push((tokens[close].start, tokens[close].start, ")".to_owned()));
                    }
                } else if let Some(retyped) = double_type(text) {
                    // A member may have a type's name.
                    let after_dot = index > 0 && tokens[index - 1].text(source) == ".";
                    if !after_dot {
                        edits.push((token.start, token.end, retyped));
                    }
                }
            }
            Kind::Sign => {}
        }
    }
    // Edits at one offset keep their order, but what closes an inner call closes before the outer.
    edits.sort_by_key(|(start, end, _)| (*start, *end));
    let mut text = String::with_capacity(source.len() + 16 * edits.len());
    let mut at = 0;
    for (start, end, replacement) in edits {
        text.push_str(source.get(at..start).unwrap_or_default());
        text.push_str(&replacement);
        at = end;
    }
    text.push_str(source.get(at..).unwrap_or_default());
    Ok(text)
}

/// The type of double precision for a type of single precision.
pub(super) fn double_type(word: &str) -> Option<String> {
    match word {
        "f32" => return Some("f64".to_owned()),
        "vec2f" | "vec3f" | "vec4f" => return Some(format!("{}<f64>", &word[..4])),
        _ => {}
    }
    let size = word.strip_prefix("mat")?.strip_suffix('f')?;
    let sizes = size.as_bytes();
    let fits = sizes.len() == 3 && sizes[1] == b'x' && [sizes[0], sizes[2]].iter().all(|c| (b'2'..=b'4').contains(c));
    fits.then(|| format!("mat{size}<f64>"))
}

/// The literal of f64 for one of f32; none for whole numbers.
pub(super) fn double_literal(text: &str) -> Option<Result<String, String>> {
    let lower = text.to_ascii_lowercase();
    let hex = lower.starts_with("0x");
    let real = if hex { lower.contains(['.', 'p']) } else { lower.contains(['.', 'e']) || lower.ends_with(['f', 'h']) };
    if !real || lower.ends_with("lf") {
        return None;
    }
    if lower.ends_with('h') {
        return Some(Err(format!("`{text}` is f16, which has no meaning in double precision")));
    }
    // In a hexadecimal number an f before the exponent is a digit.
    let digits = if hex && !lower.contains('p') { lower.as_str() } else { lower.strip_suffix('f').unwrap_or(&lower) };
    let value = if hex { hexadecimal(digits) } else { digits.parse().ok() };
    Some(match value {
        Some(value) if f64::is_finite(value) => Ok(format!("{value:?}lf")),
        _ => Err(format!("`{text}` is no number of double precision")),
    })
}

/// The value of `0x1.8p-3`.
fn hexadecimal(text: &str) -> Option<f64> {
    let (mantissa, exponent) = text.strip_prefix("0x")?.split_once('p').unwrap_or((text.strip_prefix("0x")?, "0"));
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let digits = |sum: f64, c: char| c.to_digit(16).map(|digit| 16.0 * sum + f64::from(digit));
    let value = whole.chars().chain(fraction.chars()).try_fold(0.0, digits)?;
    let exponent: i32 = exponent.parse().ok()?;
    Some(value * 2f64.powi(exponent.saturating_sub(4 * fraction.len() as i32)))
}

/// The tokens that open and close the arguments of the call whose name is the token at `index`.
fn parentheses(tokens: &[Token], source: &str, index: usize) -> Option<(usize, usize)> {
    // Past the template of a bitcast, which has no parentheses.
    let open = (index + 1..tokens.len()).find(|i| tokens[*i].text(source) == "(")?;
    let mut depth = 0;
    for (at, token) in tokens.iter().enumerate().skip(open) {
        match token.text(source) {
            "(" => depth += 1,
            ")" => {
                depth -= 1;
                if depth == 0 {
                    return Some((open, at));
                }
            }
            _ => {}
        }
    }
    None
}

fn spelled(shape: Shape, scalar: &str) -> String {
    match shape {
        None => scalar.to_owned(),
        Some(size) => format!("vec{size}<{scalar}>"),
    }
}

impl Calls {
    fn of(written: &Module) -> Self {
        let mut by_start = HashMap::new();
        let ir = written.ir();
        let plain = ir.functions.iter().map(|(handle, function)| (function, &written.info()[handle]));
        let entries = ir.entry_points.iter().enumerate();
        let entries = entries.map(|(index, entry)| (&entry.function, written.info().get_entry_point(index)));
        for (function, info) in plain.chain(entries) {
            let shape = |handle: Handle<Expression>| match info[handle].ty.inner_with(&ir.types) {
                TypeInner::Scalar(scalar) if scalar.kind == ScalarKind::Float => Some(None),
                TypeInner::Vector { size, scalar } if scalar.kind == ScalarKind::Float => Some(Some(*size as u8)),
                _ => None,
            };
            for (handle, expression) in function.expressions.iter() {
                let argument = match expression {
                    Expression::As { expr, convert: None, .. } => *expr,
                    Expression::Math { fun, arg, .. } if is_of_bits(*fun) => *arg,
                    _ => continue,
                };
                if let Some(range) = function.expressions.get_span(handle).to_range() {
                    by_start.insert(range.start, (shape(argument), shape(handle)));
                }
            }
        }
        Calls { by_start }
    }
}

/// Builtin functions that exist in single precision only.
fn is_of_bits(fun: naga::MathFunction) -> bool {
    use naga::MathFunction as Mf;
    matches!(
        fun,
        Mf::QuantizeToF16
            | Mf::Pack4x8snorm
            | Mf::Pack4x8unorm
            | Mf::Pack2x16snorm
            | Mf::Pack2x16unorm
            | Mf::Pack2x16float
            | Mf::Unpack4x8snorm
            | Mf::Unpack4x8unorm
            | Mf::Unpack2x16snorm
            | Mf::Unpack2x16unorm
            | Mf::Unpack2x16float
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn retyped(source: &str) -> String {
        in_double(source, &Module::parse(source).unwrap()).unwrap()
    }

    #[test]
    fn types_and_literals_change() {
        let source = "fn f(a: vec3f, m: mat2x3f, x: f32) -> f32 { return a.x + 0.1 * x + 1f + 0x1.8p1 + f32(2u); }";
        let want =
            "fn f(a: vec3<f64>, m: mat2x3<f64>, x: f64) -> f64 { return a.x + 0.1lf * x + 1.0lf + 3.0lf + f64(2u); }";
        assert_eq!(retyped(source), want);
    }

    #[test]
    fn bits_go_through_single_precision() {
        let source = "fn f(a: f32, n: u32) -> f32 { return bitcast<f32>(bitcast<u32>(a) & bitcast<u32>(i32(n))); }";
        let want =
            "fn f(a: f64, n: u32) -> f64 { return f64(bitcast<f32>(bitcast<u32>(f32(a)) & bitcast<u32>(i32(n)))); }";
        assert_eq!(retyped(source), want);
        Module::parse(want).unwrap();
        let source = "fn f(a: vec2f) -> vec2f { return unpack2x16float(pack2x16float(a)); }";
        let want =
            "fn f(a: vec2<f64>) -> vec2<f64> { return vec2<f64>(unpack2x16float(pack2x16float(vec2<f32>(a)))); }";
        assert_eq!(retyped(source), want);
        Module::parse(want).unwrap();
    }

    #[test]
    fn half_precision_is_refused() {
        let source = "enable f16;\nfn f(a: f16) -> f16 { return a; }";
        let error = in_double(source, &Module::parse(source).unwrap()).unwrap_err();
        assert!(error.to_string().contains("line 1: `f16`"), "{error}");
    }
}
