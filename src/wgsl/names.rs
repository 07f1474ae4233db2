//! Which words of an item are free: not members, attributes or anything declared within the item.
//!
//! Scopes are WGSL's own: a parameter lives in the body, a local from the end of its statement to the end of its block,
//! a loop variable in its `for`. So an item may be called `f` and a local of the same module too.

use super::error::LinkError;
use super::unit::{Item, Kind, Unit};
use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;

/// The words of one item.
#[derive(Debug, Default)]
pub(crate) struct Names<'a> {
    /// Names and paths that nothing within the item declares: references to items, builtins, and keywords.
    pub(crate) free: Vec<Path<'a>>,
    /// The tokens that declare parameters and locals.
    pub(crate) local: Vec<usize>,
}

/// `a` or `a::b::c`.
#[derive(Debug)]
pub(crate) struct Path<'a> {
    pub(crate) segments: Vec<&'a str>,
    pub(crate) tokens: Range<usize>,
}

#[derive(Default)]
struct Scope<'a> {
    names: Vec<&'a str>,
    /// The scope of a `for`, which ends with the block in it.
    is_loop: bool,
}

/// Reads the names of an item.
pub(crate) fn names<'a>(unit: &Unit<'a>, item: &Item<'a>) -> Result<Names<'a>, LinkError> {
    let mut names = Names::default();
    let mut scopes: Vec<Scope> = Vec::new();
    let mut pending = Vec::new(); // declared, and in scope from the next `;` or `{`
    let mut parentheses = 0_usize;
    let mut at = item.tokens.start;
    while at < item.tokens.end {
        let Some(word) = unit.word(at) else {
            match unit.token(at) {
                "@" => {
                    // These attributes' arguments are names of their own.
                    let skip = matches!(unit.token(at + 1), "builtin" | "interpolate" | "diagnostic");
                    at += 1;
                    if skip && unit.is(at + 1, "(") {
                        at = unit.after_group(at + 1)? - 1;
                    }
                }
                "." if unit.word(at + 1).is_some() => at += 1,
                "::" => return Err(unit.error(at, "`::` without a name on either side", "write `module::item`")),
                "(" => parentheses += 1,
                ")" => parentheses = parentheses.saturating_sub(1),
                "{" => scopes.push(Scope { names: core::mem::take(&mut pending), is_loop: false }),
                "}" => {
                    scopes.pop();
                    scopes.pop_if(|scope| scope.is_loop);
                }
                ";" => {
                    if let Some(scope) = scopes.last_mut() {
                        scope.names.append(&mut pending);
                    }
                }
                _ => {}
            }
            at += 1;
            continue;
        };
        let is_function = item.kind == Kind::Function;
        if at == item.name_token {
            at += 1;
        } else if is_function && !scopes.is_empty() && matches!(word, "let" | "var" | "const") {
            at = unit.after_template(at + 1);
            if let Some(name) = unit.word(at) {
                pending.push(name);
                names.local.push(at);
                at += 1;
            }
        } else if is_function && scopes.is_empty() && parentheses == 1 && unit.is(at + 1, ":") {
            pending.push(word);
            names.local.push(at);
            at += 1;
        } else if item.kind == Kind::Struct && parentheses == 0 && unit.is(at + 1, ":") {
            at += 1;
        } else if is_function && word == "for" {
            scopes.push(Scope { is_loop: true, ..Scope::default() });
            at += 1;
        } else {
            let start = at;
            let mut segments = vec![word];
            at += 1;
            while unit.is(at, "::")
                && let Some(segment) = unit.word(at + 1)
            {
                segments.push(segment);
                at += 2;
            }
            if segments.len() > 1 || !scopes.iter().any(|scope| scope.names.contains(&word)) {
                names.free.push(Path { segments, tokens: start..at });
            }
        }
    }
    Ok(names)
}
