//! WESL's conditional translation: `@if(FEATURE)`, `@elif`, `@else` before what they keep or leave out.
//!
//! A feature is on where `-D` names it, unless as `NAME=false` or `NAME=0`, and off where nobody does.

use super::condition;
use super::error::SourceError;
use super::items::group_end;
use super::lexer::{File, Kind, Token};
use std::collections::BTreeMap;

/// The tokens that may be looked at to find where decorated parts end: they nest.
const MOST_LOOKED_AT: usize = 1 << 26;

/// What surrounds a part.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Within {
    /// A list, of which a comma ends each part: parameters, members, imports.
    List,
    /// Statements or declarations.
    Body,
}

/// The tokens that the features leave.
pub(super) fn chosen(tokens: Vec<Token>, defines: &[String], files: &[File]) -> Result<Vec<Token>, SourceError> {
    let is_branch = |at: usize| {
        let keyword = tokens.get(at + 1).filter(|_| tokens.get(at).is_some_and(|sign| sign.is("@")))?;
        keyword.is_word().then_some(&*keyword.text).filter(|word| matches!(*word, "if" | "elif" | "else"))
    };
    if !(0..tokens.len()).any(|at| is_branch(at).is_some()) {
        return Ok(tokens);
    }
    let mut left = MOST_LOOKED_AT;
    let mut output: Vec<Token> = Vec::with_capacity(tokens.len());
    let mut around: Vec<Within> = Vec::new();
    // Where a decorated part ends, and whether it or one before it in its chain was kept.
    let mut ends: BTreeMap<usize, bool> = BTreeMap::new();
    let mut at = 0;
    while let Some(token) = tokens.get(at) {
        let Some(branch) = is_branch(at) else {
            if token.kind == Kind::Sign {
                match &*token.text {
                    "(" | "[" => around.push(Within::List),
                    "{" => around.push(if is_list(&tokens, at) { Within::List } else { Within::Body }),
                    ")" | "]" | "}" => {
                        around.pop();
                    }
                    _ => {}
                }
            }
            output.push(token.clone());
            at += 1;
            continue;
        };
        let error = |what: &str| SourceError::at(files, token.origin, what);
        let taken = match (branch, ends.get(&at)) {
            ("if", _) => false,
            (_, Some(taken)) => *taken,
            (_, None) => return Err(error(&format!("@{branch} without @if"))),
        };
        let (holds, start) = if branch == "else" {
            (true, at + 2)
        } else {
            let start = group_end(&tokens, at + 2);
            let asked = tokens.get(at + 2..start).unwrap_or_default();
            let value = condition::value(&settled(asked, defines));
            let value = value.map_err(|what| error(&format!("@{branch}: {what}; write @{branch}(FEATURE)")))?;
            (value != 0, start)
        };
        let within = around.last().copied().unwrap_or(Within::Body);
        let end = part_end(&tokens, start, within);
        left = left.checked_sub(end.saturating_sub(start)).ok_or_else(|| error("too many conditions within others"))?;
        ends.insert(end, taken || holds);
        at = if holds && !taken { start } else { end };
    }
    Ok(output)
}

/// A condition with what `-D` says of its names.
fn settled(asked: &[Token], defines: &[String]) -> Vec<Token> {
    let is_on = |name: &str| {
        let said = defines.iter().rev().find_map(|define| match define.split_once('=') {
            Some((own, value)) => (own.trim() == name).then(|| !matches!(value.trim(), "false" | "0")),
            None => (define.trim() == name).then_some(true),
        });
        said.unwrap_or(name == "true")
    };
    let word = |token: &Token| {
        let value = if is_on(&token.text) { "1" } else { "0" };
        if token.is_word() { Token::instead(value, Kind::Number, token) } else { token.clone() }
    };
    asked.iter().map(word).collect()
}

/// Whether braces that open here hold a list: a struct's members, an import's names.
fn is_list(tokens: &[Token], open: usize) -> bool {
    let before = tokens.get(open.saturating_sub(64)..open).unwrap_or_default().iter().rev();
    let mut declaration = before.take_while(|token| !(token.is(";") || token.is("{") || token.is("}")));
    declaration.any(|token| token.is("struct") || token.is("import"))
}

/// Past the declaration, statement, member or parameter that starts at a token.
fn part_end(tokens: &[Token], start: usize, within: Within) -> usize {
    let is_import = tokens.get(start).is_some_and(|first| first.is("import"));
    let (mut depth, mut angles) = (0usize, 0usize);
    for (at, token) in tokens.iter().enumerate().skip(start).filter(|(_, token)| token.kind == Kind::Sign) {
        match &*token.text {
            "(" | "[" | "{" => depth += 1,
            // What surrounds the part ends with it.
            ")" | "]" | "}" if depth == 0 => return at,
            closing @ (")" | "]" | "}") => {
                depth -= 1;
                let goes_on = tokens.get(at + 1).is_some_and(|next| next.is("else"));
                if depth == 0 && closing == "}" && within == Within::Body && !is_import && !goes_on {
                    return at + 1;
                }
            }
            ";" if depth == 0 => return at + 1,
            "<" if depth == 0 => angles += 1,
            ">" if depth == 0 => angles = angles.saturating_sub(1),
            ">>" if depth == 0 => angles = angles.saturating_sub(2),
            "," if depth == 0 && angles == 0 && within == Within::List => return at + 1,
            _ => {}
        }
    }
    tokens.len()
}

#[cfg(test)]
mod tests {
    use super::super::Language;
    use super::super::lexer::lex;
    use super::*;

    fn run(text: &str, defines: &[&str]) -> Result<String, String> {
        let files = [File { name: "a.wesl".into(), text: text.into(), directory: None }];
        let defines: Vec<String> = defines.iter().map(|define| (*define).to_owned()).collect();
        let tokens = lex(&files, 0, Language::Wgsl).unwrap();
        let left = chosen(tokens, &defines, &files).map_err(|error| error.to_string())?;
        Ok(left.iter().map(|token| &*token.text).collect::<Vec<_>>().join(" "))
    }

    #[test]
    fn parts_are_kept_or_left_out() {
        let members = "struct S { @if(A) a: array<vec2<f32>, 2>, @else // not A\n b: f32, c: f32 }";
        assert_eq!(run(members, &[]).unwrap(), "struct S { b : f32 , c : f32 }");
        assert_eq!(run(members, &["A"]).unwrap(), "struct S { a : array < vec2 < f32 > , 2 > , c : f32 }");
        let statements =
            "fn f() { @if(A && !B) let x = 1; @elif(B) { if x { y(); } else { z(); } } @else return; w(); }";
        assert_eq!(run(statements, &["A"]).unwrap(), "fn f ( ) { let x = 1 ; w ( ) ; }");
        let both = "fn f ( ) { { if x { y ( ) ; } else { z ( ) ; } } w ( ) ; }";
        assert_eq!(run(statements, &["A", "B=true"]).unwrap(), both);
        assert_eq!(run(statements, &["A=false"]).unwrap(), "fn f ( ) { return ; w ( ) ; }");
        let whole = "@if(A) if x { y(); } else if z { } \n@if(A) import p::{q, r};\nfn g(@if(!A) x: f32, y: f32) {}";
        assert_eq!(run(whole, &[]).unwrap(), "fn g ( x : f32 , y : f32 ) { }");
        let nested = "fn f() { @if(A) { @if(B) x(); @else y(); } z(); }";
        assert_eq!(run(nested, &["A"]).unwrap(), "fn f ( ) { { y ( ) ; } z ( ) ; }");
        assert_eq!(run("@group(0) var x: f32;", &[]).unwrap(), "@ group ( 0 ) var x : f32 ;");
    }

    #[test]
    fn errors_name_the_place() {
        assert!(run("fn f() {}\n @else fn g() {}", &[]).unwrap_err().starts_with("a.wesl:2:2: @else without @if"));
        assert!(run("@if fn f() {}", &[]).unwrap_err().starts_with("a.wesl:1:1: @if: "));
        assert!(run("@if(A &&) fn f() {}", &[]).unwrap_err().contains("write @if(FEATURE)"));
    }
}
