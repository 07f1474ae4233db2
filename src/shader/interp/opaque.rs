//! The text of a module without constant expressions of floating point.
//!
//! naga computes constant expressions when it parses, and fails on those of f64. Here each literal of floating point
//! becomes an override of that default, which naga leaves alone; a constant made of such becomes an override too, or a
//! private variable where it is no scalar, or a `let` within a function. A whole number or a bool made of them is written
//! as the value that it has in single precision. Line breaks stay where they are.
//!
//! | written | becomes |
//! |---|---|
//! | `const THIRD = 1.0 / 3.0;` | `override THIRD = real_0 / real_1;` |
//! | `const AXIS = vec2f(0.5) * 2;` | `var<private> AXIS = vec2f(real_0) * 2;` |
//! | `const COUNT = u32(2.5);` | `const COUNT = 2u;` |
//! | `fn f() { const half = 0.5; … }` | `fn f() { let half = real_0; … }` |

use super::retype::{double_literal, double_type};
use crate::shader::{Module, ShaderError};
use crate::wgsl::token::{Kind, Token, tokens};
use naga::{Expression, Literal, ScalarKind, TypeInner};
use std::collections::{HashMap, HashSet};

/// What becomes of a constant.
#[derive(Clone)]
enum Fate {
    Override,
    /// A private variable: it is no scalar.
    Variable,
    /// A constant of this value.
    Known(String),
}

/// The tokens of a declaration `const name … = value;`.
struct Constant {
    keyword: usize,
    name: usize,
    equals: usize,
    semicolon: usize,
    is_global: bool,
}

/// A module's text and tokens.
struct Text<'s> {
    source: &'s str,
    tokens: Vec<Token>,
}

/// The text of `source`, a valid module, without constant expressions of floating point.
pub(super) fn unfolded(source: &str) -> Result<String, ShaderError> {
    let tokens = tokens(source).map_err(|_| ShaderError::plain("a comment that never ends".to_owned()))?;
    let text = Text { source, tokens };
    let constants = text.constants();
    let prefix = text.free_name("real");
    let fates = text.fates(&constants)?;
    let is_real = text.made_of_reals(&constants, &fates);

    let mut replaced: Vec<Option<String>> = vec![None; text.tokens.len()];
    let mut literals: Vec<String> = Vec::new();
    let components = text.components();
    for (constant, _) in constants.iter().zip(is_real).filter(|(_, is_real)| *is_real) {
        let fate = fates.get(text.word(constant.name)).filter(|_| constant.is_global);
        let keyword = match fate {
            None => "let",
            Some(Fate::Override) => "override",
            Some(Fate::Variable) => "var<private>",
            Some(Fate::Known(value)) => {
                replaced[constant.equals + 1..constant.semicolon].fill(Some(String::new()));
                replaced[constant.equals + 1] = Some(value.clone());
                continue;
            }
        };
        replaced[constant.keyword] = Some(keyword.to_owned());
    }

    for index in 0..text.tokens.len() {
        if replaced[index].is_some() {
            continue;
        }
        let word = text.word(index);
        let literal = if components.contains(&index) { format!("{word}.0") } else { word.to_owned() };
        if components.contains(&index) || text.is_real(index) {
            let known = literals.iter().position(|other| *other == literal);
            let at = known.unwrap_or(literals.len());
            if known.is_none() {
                literals.push(literal);
            }
            replaced[index] = Some(format!("{prefix}_{at}"));
        } else if word == "const_assert" {
            // It has been found to hold.
            let end = (index..text.tokens.len()).find(|i| text.word(*i) == ";").unwrap_or(index);
            replaced[index..=end].fill(Some(String::new()));
        }
    }

    let mut result = String::with_capacity(2 * source.len());
    let mut at = 0;
    for (token, replacement) in text.tokens.iter().zip(&replaced) {
        result.push_str(source.get(at..token.start).unwrap_or_default());
        result.push_str(replacement.as_deref().unwrap_or_else(|| token.text(source)));
        at = token.end;
    }
    result.push_str(source.get(at..).unwrap_or_default());
    for (at, literal) in literals.iter().enumerate() {
        result.push_str(&format!("\noverride {prefix}_{at}: f32 = {literal};"));
    }
    Ok(result)
}

impl Text<'_> {
    fn word(&self, index: usize) -> &str {
        self.tokens.get(index).map_or("", |token| token.text(self.source))
    }

    /// Whether a token is a literal of floating point.
    fn is_real(&self, index: usize) -> bool {
        self.tokens[index].kind == Kind::Number && double_literal(self.word(index)).is_some()
    }

    /// A name that nothing in the module begins with.
    fn free_name(&self, name: &str) -> String {
        let mut name = name.to_owned();
        while self.source.contains(&name) {
            name.push('x');
        }
        name
    }

    fn constants(&self) -> Vec<Constant> {
        let mut constants = Vec::new();
        let mut depth = 0;
        for keyword in 0..self.tokens.len() {
            match self.word(keyword) {
                "{" => depth += 1,
                "}" => depth -= 1,
                "const" => {
                    let find = |sign: &str| (keyword..self.tokens.len()).find(|index| self.word(*index) == sign);
                    // `@const` has no value.
                    if let (Some(equals), Some(semicolon)) = (find("="), find(";"))
                        && equals + 1 < semicolon
                    {
                        let name = keyword + 1;
                        constants.push(Constant { keyword, name, equals, semicolon, is_global: depth == 0 });
                    }
                }
                _ => {}
            }
        }
        constants
    }

    /// What would become of each constant of the module.
    fn fates(&self, constants: &[Constant]) -> Result<HashMap<String, Fate>, ShaderError> {
        // naga drops constants of abstract type, but not variables that have their values.
        let prefix = self.free_name("probe");
        let names: HashSet<&str> = constants.iter().filter(|c| c.is_global).map(|c| self.word(c.name)).collect();
        let mut probes = self.source.to_owned();
        for name in &names {
            probes.push_str(&format!("\nvar<private> {prefix}_{name} = {name};"));
        }
        let module = Module::parse(&probes)?;
        let ir = module.ir();
        let mut fates = HashMap::new();
        for (_, variable) in ir.global_variables.iter() {
            let Some(name) = variable.name.as_deref().and_then(|name| name.strip_prefix(&format!("{prefix}_"))) else {
                continue;
            };
            let fate = match ir.types[variable.ty].inner {
                TypeInner::Scalar(scalar) if scalar.kind == ScalarKind::Float => Fate::Override,
                TypeInner::Scalar(_) => {
                    let mut value = variable.init;
                    while let Some(Expression::Constant(other)) = value.map(|value| &ir.global_expressions[value]) {
                        value = Some(ir.constants[*other].init);
                    }
                    match value.map(|value| &ir.global_expressions[value]) {
                        Some(Expression::Literal(Literal::I32(value))) => Fate::Known(format!("i32({value})")),
                        Some(Expression::Literal(Literal::U32(value))) => Fate::Known(format!("{value}u")),
                        Some(Expression::Literal(Literal::Bool(value))) => Fate::Known(format!("{value}")),
                        _ => Fate::Override,
                    }
                }
                _ => Fate::Variable,
            };
            fates.insert(name.to_owned(), fate);
        }
        Ok(fates)
    }

    /// Which constants have a number of floating point in their values, or a constant that has.
    fn made_of_reals(&self, constants: &[Constant], fates: &HashMap<String, Fate>) -> Vec<bool> {
        let mut is_real = vec![false; constants.len()];
        let mut names: HashSet<&str> = HashSet::new();
        loop {
            let before = names.len();
            for (constant, is_real) in constants.iter().zip(&mut is_real) {
                let mut value = constant.name + 1..constant.semicolon;
                if *is_real || !value.any(|index| self.is_real(index) || self.is_real_word(index, &names)) {
                    continue;
                }
                *is_real = true;
                let name = self.word(constant.name);
                if !(constant.is_global && matches!(fates.get(name), Some(Fate::Known(_)))) {
                    names.insert(name);
                }
            }
            if names.len() == before {
                return is_real;
            }
        }
    }

    /// Whether a token is a type of floating point or one of these names.
    fn is_real_word(&self, index: usize, names: &HashSet<&str>) -> bool {
        let word = self.word(index);
        self.word(index - 1) != "." && (double_type(word).is_some() || names.contains(word))
    }

    /// The whole numbers that stand alone as arguments of a type of floating point: `vec2f(1, 2)`, `vec2<f32>(1)`.
    fn components(&self) -> HashSet<usize> {
        let mut found = HashSet::new();
        for index in 0..self.tokens.len() {
            let in_template = self.word(index) == "f32" && self.word(index + 1) == ">";
            let open = if in_template { index + 2 } else { index + 1 };
            let of_bits = in_template && index > 1 && self.word(index - 2) == "bitcast";
            if double_type(self.word(index)).is_none() || self.word(open) != "(" || of_bits {
                continue;
            }
            let mut depth = 0;
            for at in open..self.tokens.len() {
                match self.word(at) {
                    "(" => depth += 1,
                    ")" => depth -= 1,
                    _ => {}
                }
                if depth == 0 {
                    break;
                }
                let alone = matches!(self.word(at - 1), "(" | ",") && matches!(self.word(at + 1), ")" | ",");
                let digits = self.word(at).bytes().all(|byte| byte.is_ascii_digit());
                if depth == 1 && alone && digits && self.tokens[at].kind == Kind::Number {
                    found.insert(at);
                }
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_become_what_naga_leaves_alone() {
        let source = "const A = 1.0 / 3.0;\nconst B = vec2f(A, 2) * 0.5; const N = u32(2.5); const M = N + 1u;
            const_assert A < 1.0;
            fn f(x: f32) -> f32 { const k = 1.0 * A; const n = 3; return x * k + B.x + f32(N); }";
        let want =
            "override A = real_0 / real_1;\nvar<private> B = vec2f(A, real_2) * real_3; const N = 2u; const M = N + 1u;
                  
            fn f(x: f32) -> f32 { let k = real_0 * A; const n = 3; return x * k + B.x + f32(N); }
override real_0: f32 = 1.0;
override real_1: f32 = 3.0;
override real_2: f32 = 2.0;
override real_3: f32 = 0.5;";
        let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        let unfolded = unfolded(source).unwrap();
        assert_eq!(words(&unfolded), words(want));
        assert!(unfolded.lines().count() == 4 + source.lines().count());
        Module::parse(&unfolded).unwrap();
    }
}
