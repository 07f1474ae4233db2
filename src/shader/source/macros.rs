//! Macros, expanded as C's preprocessor does: arguments first, and no macro within itself.

use super::Language;
use super::error::SourceError;
use super::lexer::{File, Hidden, HiddenList, Kind, Token, lex};
use std::collections::{BTreeMap, VecDeque};
use std::rc::Rc;

/// The tokens that one source may expand to: macros double as they nest.
const MOST_TOKENS: usize = 1 << 20;
/// How deep macros may be used in the arguments of macros.
const MOST_NESTING: usize = 64;

/// How many macros one token may come from.
const MOST_CHAIN: usize = 256;

/// A macro's parameters, none if it takes no parentheses, and its body.
#[derive(Clone, Debug)]
pub(super) struct Macro {
    pub(super) parameters: Option<Vec<Rc<str>>>,
    pub(super) body: Vec<Token>,
}

/// The macros that are defined, and the tokens that may still be made.
#[derive(Clone, Debug)]
pub(super) struct Macros {
    defined: BTreeMap<Rc<str>, Macro>,
    left: usize,
}

impl Macros {
    /// The macros of `-D NAME[=VALUE]`.
    pub(super) fn new(defines: &[String]) -> Result<Self, SourceError> {
        let mut defined = BTreeMap::new();
        for define in defines {
            let (name, value) = define.split_once('=').unwrap_or((define, "1"));
            let name = name.trim();
            let plain = name.chars().all(|c| c.is_alphanumeric() || c == '_');
            if !super::lexer::is_name(name) || !plain {
                return Err(SourceError::of(
                    "",
                    format!("-D {define}: `{name}` is not a name; write NAME or NAME=VALUE"),
                ));
            }
            let file = File { name: format!("-D {define}"), text: value.to_owned(), directory: None };
            let body = lex(&[file], 0, Language::Glsl)?;
            defined.insert(name.into(), Macro { parameters: None, body });
        }
        Ok(Macros { defined, left: MOST_TOKENS })
    }

    pub(super) fn define(&mut self, name: &Rc<str>, definition: Macro) {
        self.defined.insert(Rc::clone(name), definition);
    }

    pub(super) fn undefine(&mut self, name: &str) {
        self.defined.remove(name);
    }

    pub(super) fn get(&self, name: &str) -> Option<&Macro> {
        self.defined.get(name)
    }

    /// Every use of a macro replaced.
    pub(super) fn expand(&mut self, tokens: Vec<Token>, files: &[File]) -> Result<Vec<Token>, SourceError> {
        self.expand_within(tokens, files, 0)
    }

    fn expand_within(&mut self, tokens: Vec<Token>, files: &[File], depth: usize) -> Result<Vec<Token>, SourceError> {
        let mut input: VecDeque<Token> = tokens.into();
        let mut output = Vec::with_capacity(input.len());
        while let Some(token) = input.pop_front() {
            let found =
                if token.is_word() && !is_hidden(&token) { self.defined.get(&token.text).cloned() } else { None };
            let Some(found) = found else {
                output.push(token);
                continue;
            };
            if depth > MOST_NESTING {
                return Err(SourceError::at(
                    files,
                    token.origin,
                    format!("macros nested more than {MOST_NESTING} deep"),
                ));
            }
            let body = match &found.parameters {
                None => found.body,
                Some(_) if !input.front().is_some_and(|next| next.is("(")) => {
                    output.push(token);
                    continue;
                }
                Some(parameters) => {
                    let arguments = arguments(&mut input)
                        .ok_or_else(|| SourceError::at(files, token.origin, format!("`{}(` has no `)`", token.text)))?;
                    // `F()` is one empty argument, or none.
                    let nothing = arguments.len() == 1 && arguments.iter().all(Vec::is_empty);
                    let count = if nothing && parameters.is_empty() { 0 } else { arguments.len() };
                    if count != parameters.len() {
                        let message =
                            format!("the macro `{}` takes {} arguments, not {count}", token.text, parameters.len());
                        return Err(SourceError::at(files, token.origin, message));
                    }
                    self.substituted(&found, parameters, arguments, files, depth)?
                }
            };
            let Some(left) = self.left.checked_sub(body.len()) else {
                let message = format!("macros expand to more than {MOST_TOKENS} tokens");
                return Err(SourceError::at(files, token.origin, message));
            };
            self.left = left;
            for (index, part) in body.into_iter().enumerate().rev() {
                let rest = joined(&part, &token);
                let length = 1 + rest.as_ref().map_or(0, |list| list.length);
                if length > MOST_CHAIN {
                    let message = format!("macros that lead to each other {MOST_CHAIN} times");
                    return Err(SourceError::at(files, token.origin, message));
                }
                let hidden = Some(Rc::new(HiddenList { name: Rc::clone(&token.text), rest, length }));
                let (spaced, leads) = (if index == 0 { token.spaced } else { part.spaced }, index == 0 && token.leads);
                // The place where the macro is used: what its author can see is wrong.
                input.push_front(Token { origin: token.origin, spaced, leads, hidden, ..part });
            }
        }
        Ok(output)
    }

    /// The body with arguments in place of parameters, and `##` done.
    fn substituted(
        &mut self,
        found: &Macro,
        parameters: &[Rc<str>],
        arguments: Vec<Vec<Token>>,
        files: &[File],
        depth: usize,
    ) -> Result<Vec<Token>, SourceError> {
        let mut expanded: Vec<Option<Vec<Token>>> = vec![None; arguments.len()];
        let mut output: Vec<Token> = Vec::new();
        let mut paste = false;
        for (at, token) in found.body.iter().enumerate() {
            if token.is("##") {
                paste = true;
                continue;
            }
            let next_pastes = found.body.get(at + 1).is_some_and(|next| next.is("##"));
            let parameter = parameters.iter().position(|name| token.is_word() && *name == token.text);
            let mut parts = match parameter {
                // Beside `##` an argument goes in as it was written.
                Some(index) if paste || next_pastes => arguments.get(index).cloned().unwrap_or_default(),
                Some(index) => match expanded.get(index) {
                    Some(Some(done)) => done.clone(),
                    _ => {
                        let argument = arguments.get(index).cloned().unwrap_or_default();
                        let done = self.expand_within(argument, files, depth + 1)?;
                        if let Some(slot) = expanded.get_mut(index) {
                            *slot = Some(done.clone());
                        }
                        done
                    }
                },
                None => vec![token.clone()],
            };
            if parameter.is_some()
                && let Some(first) = parts.first_mut()
            {
                first.spaced = token.spaced;
            }
            if std::mem::take(&mut paste)
                && !parts.is_empty()
                && let Some(left) = output.pop()
            {
                let right = parts.remove(0);
                output.push(Token { text: format!("{}{}", left.text, right.text).into(), ..left });
            }
            output.extend(parts);
            if output.len() > MOST_TOKENS {
                let message = format!("macros expand to more than {MOST_TOKENS} tokens");
                return Err(SourceError::at(files, token.origin, message));
            }
        }
        Ok(output)
    }
}

/// What neither of the two tokens may become again.
fn joined(part: &Token, outer: &Token) -> Hidden {
    let mut hidden = outer.hidden.clone();
    let mut next = &part.hidden;
    while let Some(list) = next {
        let length = 1 + hidden.as_ref().map_or(0, |list| list.length);
        hidden = Some(Rc::new(HiddenList { name: Rc::clone(&list.name), rest: hidden, length }));
        next = &list.rest;
    }
    hidden
}

fn is_hidden(token: &Token) -> bool {
    let mut next = &token.hidden;
    while let Some(list) = next {
        if list.name == token.text {
            return true;
        }
        next = &list.rest;
    }
    false
}

/// The arguments from `(` to its `)`, both taken away; none where the text ends before.
fn arguments(input: &mut VecDeque<Token>) -> Option<Vec<Vec<Token>>> {
    input.pop_front();
    let mut depth = 0usize;
    let mut arguments = vec![Vec::new()];
    loop {
        let token = input.pop_front()?;
        if token.kind == Kind::Sign {
            match &*token.text {
                "(" | "[" | "{" => depth += 1,
                ")" if depth == 0 => return Some(arguments),
                ")" | "]" | "}" => depth = depth.saturating_sub(1),
                "," if depth == 0 => {
                    arguments.push(Vec::new());
                    continue;
                }
                _ => {}
            }
        }
        arguments.last_mut()?.push(token);
    }
}
