//! A bound on how deep a module nests, found in its tokens.
//!
//! naga counts parentheses and braces, but takes a frame of the stack for each operator of a chain and each `else if`
//! too, and has no bound on those: a long enough chain ends the process.

use crate::shader::ShaderError;
use crate::wgsl::token::{Kind, Token, tokens};

/// The most operators, parentheses and templates around one operand; 2 MB of stack hold several times as many.
const MOST_OPERATORS: u32 = 500;
/// The most `else if` around one statement.
const MOST_BRANCHES: u32 = 250;

/// An operator that opened a level, and the operators in it so far.
struct Level {
    opener: char,
    operators: u32,
}

/// Refuses text that would exhaust the stack of who parses it.
pub(crate) fn bounded(source: &str) -> Result<(), ShaderError> {
    let refuse = |at: usize, what: String| {
        let line = 1 + source.get(..at).unwrap_or_default().matches('\n').count();
        Err(ShaderError::plain(format!("line {line}: {what}")))
    };
    // A comment without an end is naga's to report.
    let tokens = tokens(source).unwrap_or_default();
    let mut levels: Vec<Level> = Vec::new();
    let (mut outer, mut sum) = (0, 0);
    // How many `else if` each open block lies in, itself included.
    let (mut chains, mut chain): (Vec<u32>, u32) = (Vec::new(), 0);
    let text = |index: usize| tokens.get(index).map_or("", |token: &Token| token.text(source));
    for (index, token) in tokens.iter().enumerate() {
        let sign = match token.kind {
            Kind::Sign => token.text(source).chars().next().unwrap_or(' '),
            _ if token.text(source) == "else" && text(index + 1) == "if" => {
                chain += 1;
                let around: u32 = chain + chains.iter().sum::<u32>();
                if around > MOST_BRANCHES {
                    return refuse(token.start, format!("more than {MOST_BRANCHES} `else if` around one statement"));
                }
                continue;
            }
            _ => continue,
        };
        match sign {
            ';' | '{' | '}' => {
                levels.clear();
                (outer, sum) = (0, 0);
                match sign {
                    '{' => chains.push(std::mem::take(&mut chain)),
                    '}' => {
                        let ended = chains.pop().unwrap_or_default();
                        chain = if text(index + 1) == "else" { ended } else { 0 };
                    }
                    _ => chain = 0,
                }
                continue;
            }
            ',' => {
                let here = levels.last_mut().map_or(&mut outer, |level| &mut level.operators);
                sum -= std::mem::take(here);
                continue;
            }
            ')' | ']' | '>' => {
                let opener = match sign {
                    ')' => '(',
                    ']' => '[',
                    _ => '<',
                };
                // A parenthesis closes the templates that turn out to be comparisons.
                while sign != '>' && levels.last().is_some_and(|level| level.opener == '<') {
                    sum -= levels.pop().map_or(0, |level| level.operators);
                }
                if levels.last().is_some_and(|level| level.opener == opener) {
                    sum -= levels.pop().map_or(0, |level| level.operators);
                    continue;
                }
            }
            _ => {}
        }
        *levels.last_mut().map_or(&mut outer, |level| &mut level.operators) += 1;
        sum += 1;
        if sum > MOST_OPERATORS {
            return refuse(token.start, format!("more than {MOST_OPERATORS} operators around one operand"));
        }
        let is_template = sign == '<' && index > 0 && takes_types(text(index - 1));
        if is_template || matches!(sign, '(' | '[') {
            levels.push(Level { opener: sign, operators: 0 });
        }
    }
    Ok(())
}

/// Whether a template may follow a word: its commas part types, not operands.
fn takes_types(word: &str) -> bool {
    matches!(word, "array" | "ptr" | "atomic" | "bitcast" | "var" | "binding_array")
        || ["vec", "mat", "texture_"].iter().any(|start| word.starts_with(start))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(expression: &str) -> String {
        format!("fn f(x: f32) -> f32 {{\n return {expression}; }}")
    }

    #[test]
    fn long_lists_are_not_deep() {
        assert_eq!(
            bounded(&line(&format!("array<f32, 5000>({})[0]", "x + 1.0, -x, f(a < b, c > d), ".repeat(5000)))),
            Ok(())
        );
        assert_eq!(bounded(&line(&"x + x; ".repeat(5000))), Ok(()));
        assert_eq!(bounded(&line(&"x; if x > 0.0 { } else if x < 1.0 { } ".repeat(5000))), Ok(()));
        let nested = format!("{}x{}", "(x + ".repeat(100), ")".repeat(100));
        assert_eq!(bounded(&line(&nested)), Ok(()));
    }

    #[test]
    fn deep_ones_are_refused() {
        let most = MOST_OPERATORS as usize;
        for deep in [
            format!("x{}", " + x".repeat(most + 1)),
            format!("{}x", "-".repeat(most + 1)),
            format!("x{}", " + array<f32, 2>(x, x)[0]".repeat(most)),
            format!("g(x, x{})", ".x".repeat(most + 1)),
            format!("{}x{}", "(x + ".repeat(most / 2 + 1), ")".repeat(most / 2 + 1)),
        ] {
            let error = bounded(&line(&deep)).unwrap_err().to_string();
            assert_eq!(error, format!("line 2: more than {most} operators around one operand"));
        }
        let chain = format!("x; if x > 0.0 {{ }} {}", "else if x > 1.0 { } ".repeat(MOST_BRANCHES as usize + 1));
        let error = bounded(&line(&chain)).unwrap_err().to_string();
        assert!(error.contains("`else if`"), "{error}");
    }
}
