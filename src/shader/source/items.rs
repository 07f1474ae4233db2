//! A preprocessed text split into its declarations: as much grammar as it takes to tell which of them a function needs.

use super::Language;
use super::error::SourceError;
use super::lexer::{File, Kind, Token, is_name};
use std::rc::Rc;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ItemKind {
    Function,
    /// A struct, constant, alias, prototype or variable with no outside to it.
    Plain,
    /// A variable that the pipeline would fill, rewritten to a private one; its value, where it states one, is kept.
    Input,
    /// An `override`.
    Override,
    /// A texture, a sampler, memory that invocations share: what has no value here.
    Resource,
    /// `enable`.
    Directive,
}

/// A declaration at the top level.
#[derive(Clone, Debug)]
pub(super) struct Item {
    pub(super) kind: ItemKind,
    pub(super) names: Vec<Rc<str>>,
    pub(super) tokens: Vec<Token>,
}

/// Statements that only name what other files declare: the tokens between `import` and `;`.
pub(super) type ImportStatement = Vec<Token>;

/// Splits a text.
pub(super) fn items(
    tokens: Vec<Token>,
    language: Language,
    files: &[File],
) -> Result<(Vec<Item>, Vec<ImportStatement>), SourceError> {
    let tokens = match language {
        Language::Glsl => without_precision(tokens),
        Language::Wgsl => tokens,
    };
    let (mut items, mut imports) = (Vec::new(), Vec::new());
    let mut at = 0;
    while let Some(first) = tokens.get(at) {
        let end = declaration_end(&tokens, at, language, files)?;
        let declaration = tokens.get(at..end).unwrap_or_default();
        at = end;
        if first.is(";") {
            continue;
        }
        match language {
            Language::Wgsl if first.is("import") => imports.push(declaration.get(1..).unwrap_or_default().to_vec()),
            Language::Wgsl => items.extend(wgsl_item(declaration)),
            Language::Glsl => items.extend(glsl_item(declaration)),
        }
    }
    Ok((items, imports))
}

/// Where the declaration that starts at a token ends: after `;`, or after the braces of a body.
fn declaration_end(tokens: &[Token], start: usize, language: Language, files: &[File]) -> Result<usize, SourceError> {
    let mut open: Vec<&Token> = Vec::new();
    let mut is_body = false;
    let wgsl_struct = tokens.get(start).is_some_and(|first| first.is("struct")) && language == Language::Wgsl;
    let is_import = tokens.get(start).is_some_and(|first| first.is("import"));
    let mut has_list = false;
    for (at, token) in tokens.iter().enumerate().skip(start) {
        if token.kind != Kind::Sign {
            continue;
        }
        match &*token.text {
            "(" | "[" | "{" => {
                if open.is_empty() && token.is("{") {
                    // What follows a parameter list, with WGSL's result between them.
                    let after_list = tokens.get(at.wrapping_sub(1)).is_some_and(|before| before.is(")"));
                    let is_function = if language == Language::Glsl { after_list } else { has_list && !is_import };
                    is_body = wgsl_struct || is_function;
                }
                has_list |= token.is("(") && open.is_empty();
                open.push(token);
                if open.len() > 200 {
                    return Err(SourceError::at(files, token.origin, "brackets nested more than 200 deep"));
                }
            }
            closing @ (")" | "]" | "}") => {
                let opening = match closing {
                    ")" => "(",
                    "]" => "[",
                    _ => "{",
                };
                if !open.pop().is_some_and(|token| token.is(opening)) {
                    return Err(SourceError::at(files, token.origin, format!("`{closing}` closes nothing")));
                }
                if open.is_empty() && closing == "}" && is_body {
                    return Ok(at + 1);
                }
            }
            ";" if open.is_empty() => return Ok(at + 1),
            _ => {}
        }
    }
    if let Some(token) = open.last() {
        return Err(SourceError::at(files, token.origin, format!("`{}` is not closed", token.text)));
    }
    match tokens.get(start) {
        Some(first) => Err(SourceError::at(files, first.origin, "this declaration does not end: no `;` or body")),
        None => Ok(tokens.len()),
    }
}

/// GLSL without `highp` and its kin, `precision` statements, and `const` beside `in`: what naga does not read.
fn without_precision(tokens: Vec<Token>) -> Vec<Token> {
    let mut output: Vec<Token> = Vec::with_capacity(tokens.len());
    let mut tokens = tokens.into_iter().peekable();
    while let Some(token) = tokens.next() {
        if token.is("precision") && token.is_word() {
            for token in tokens.by_ref() {
                if token.is(";") {
                    break;
                }
            }
        } else if token.is_word() && matches!(&*token.text, "highp" | "mediump" | "lowp" | "precise") {
            // What follows still starts the line that this one started.
            if let Some(next) = tokens.peek_mut() {
                next.leads |= token.leads;
            }
        } else {
            output.push(token);
        }
    }
    output
}

const QUALIFIERS: [&str; 19] = [
    "uniform",
    "varying",
    "attribute",
    "in",
    "out",
    "buffer",
    "shared",
    "const",
    "flat",
    "smooth",
    "noperspective",
    "centroid",
    "sample",
    "invariant",
    "readonly",
    "writeonly",
    "coherent",
    "restrict",
    "patch",
];

fn glsl_item(declaration: &[Token]) -> Vec<Item> {
    let mut qualifiers: Vec<&str> = Vec::new();
    let mut at = 0;
    while let Some(token) = declaration.get(at) {
        if token.is("layout") {
            at += 1;
            at = group_end(declaration, at);
        } else if let Some(qualifier) = QUALIFIERS.into_iter().find(|qualifier| token.is(qualifier)) {
            qualifiers.push(qualifier);
            at += 1;
        } else {
            break;
        }
    }
    let has = |qualifier: &str| qualifiers.contains(&qualifier);
    let rest = declaration.get(at..).unwrap_or_default();
    let part = |at: usize| rest.get(at);
    if rest.iter().all(|token| token.is(";")) || has("invariant") {
        return Vec::new();
    }
    let is_input = ["uniform", "varying", "attribute", "in", "out", "buffer"].into_iter().any(has);
    let kind = if is_input { ItemKind::Input } else { ItemKind::Plain };
    // A function or its prototype: a name and a list, with nothing assigned before.
    let list = rest.iter().position(|token| token.is("("));
    let assigned = rest.iter().position(|token| token.is("=") || token.is("{"));
    if let Some(list) = list.filter(|list| assigned.is_none_or(|assigned| *list < assigned))
        && let Some(name) = rest.get(list.wrapping_sub(1)).filter(|name| name.is_word())
    {
        let body = rest.last().is_some_and(|last| last.is("}"));
        let end = group_end(rest, list);
        let is_const = |at: usize, token: &Token| at > list && at < end && token.is("const");
        let kept = rest.iter().enumerate().filter(|(at, token)| !is_const(*at, token));
        let tokens = kept.map(|(_, token)| token.clone()).collect();
        let kind = if body { ItemKind::Function } else { ItemKind::Plain };
        return vec![Item { kind, names: vec![Rc::clone(&name.text)], tokens }];
    }
    // A block of inputs is a struct and a variable of it, or as many variables as it has members.
    if is_input && part(1).is_some_and(|open| open.is("{")) {
        return block(rest);
    }
    let mut tokens = rest.to_vec();
    if has("const")
        && let Some(first) = tokens.first().cloned()
    {
        tokens.insert(0, Token::instead("const", Kind::Word, &first));
        if let Some(second) = tokens.get_mut(1) {
            (second.spaced, second.leads) = (true, false);
        }
    }
    let is_struct = part(0).is_some_and(|first| first.is("struct"));
    let mut names: Vec<Rc<str>> = Vec::new();
    // Past the type: its name, or the struct's braces.
    let mut at = 1;
    if is_struct {
        names.extend(part(1).filter(|name| name.is_word()).map(|name| Rc::clone(&name.text)));
        at = rest.iter().position(|token| token.is("{")).map_or(rest.len(), |open| group_end(rest, open));
    }
    names.extend(declarators(rest.get(at..).unwrap_or_default()));
    let ty = part(0).map_or("", |ty| &ty.text);
    let opaque = ["sampler", "isampler", "usampler", "image", "texture", "subpass", "acceleration", "atomic_"];
    let is_resource = has("shared") || (!is_struct && opaque.into_iter().any(|start| ty.starts_with(start)));
    vec![Item { kind: if is_resource { ItemKind::Resource } else { kind }, names, tokens }]
}

/// The names that a list of declarators declares: the first word, and the first after each comma.
fn declarators(tokens: &[Token]) -> Vec<Rc<str>> {
    let (mut names, mut depth, mut expected) = (Vec::new(), 0i32, true);
    for token in tokens {
        match &*token.text {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth -= 1,
            "," if depth == 0 => expected = true,
            "=" => expected = false,
            _ if depth == 0 && expected && token.is_word() => {
                names.push(Rc::clone(&token.text));
                expected = false;
            }
            _ => {}
        }
    }
    names
}

fn block(rest: &[Token]) -> Vec<Item> {
    let end = group_end(rest, 1);
    let (Some(name), Some(open)) = (rest.first(), rest.get(1)) else { return Vec::new() };
    let mut members: Vec<Vec<Token>> = Vec::new();
    for member in rest.get(2..end.saturating_sub(1)).unwrap_or_default().split_inclusive(|token| token.is(";")) {
        let start = match member.first() {
            Some(first) if first.is("layout") => group_end(member, 1),
            _ => 0,
        };
        members.push(member.get(start..).unwrap_or_default().to_vec());
    }
    let instance = declarators(rest.get(end..).unwrap_or_default());
    if instance.is_empty() {
        let of_member = |tokens: Vec<Token>| {
            let names = declarators(tokens.get(1..).unwrap_or_default());
            Item { kind: ItemKind::Input, names, tokens }
        };
        return members.into_iter().map(of_member).collect();
    }
    let sign = |text: &str| Token { spaced: true, leads: false, ..Token::instead(text, Kind::Sign, open) };
    let mut tokens = vec![Token::instead("struct", Kind::Word, name)];
    tokens.push(Token { spaced: true, leads: false, ..name.clone() });
    tokens.push(sign("{"));
    tokens.extend(members.into_iter().flatten());
    tokens.extend([sign("}"), sign(";")]);
    let ty = Item { kind: ItemKind::Plain, names: vec![Rc::clone(&name.text)], tokens };
    let mut tokens = vec![name.clone()];
    tokens.extend(rest.get(end..).unwrap_or_default().iter().cloned());
    vec![ty, Item { kind: ItemKind::Input, names: instance, tokens }]
}

/// Past the group that opens at a token; that token itself, if none does.
pub(super) fn group_end(tokens: &[Token], start: usize) -> usize {
    let mut depth = 0usize;
    for (at, token) in tokens.iter().enumerate().skip(start) {
        match &*token.text {
            "(" | "[" | "{" if token.kind == Kind::Sign => depth += 1,
            ")" | "]" | "}" if token.kind == Kind::Sign => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth == 0 {
            return if at == start { start } else { at + 1 };
        }
    }
    tokens.len()
}

fn wgsl_item(declaration: &[Token]) -> Vec<Item> {
    // Attributes belong to entry points and bindings, neither of which is left.
    let mut at = 0;
    let mut is_entry_point = false;
    while declaration.get(at).is_some_and(|token| token.is("@")) {
        let name = declaration.get(at + 1).map_or("", |name| &name.text);
        is_entry_point |= matches!(name, "vertex" | "fragment" | "compute");
        at += 2;
        if declaration.get(at).is_some_and(|token| token.is("(")) {
            at = group_end(declaration, at);
        }
    }
    let rest = declaration.get(at..).unwrap_or_default();
    let Some(keyword) = rest.first() else { return Vec::new() };
    let name_at = |at: usize| rest.get(at).filter(|name| name.is_word()).map(|name| Rc::clone(&name.text));
    let item = |kind: ItemKind, name: Option<Rc<str>>, tokens: Vec<Token>| {
        name.map(|name| Item { kind, names: vec![name], tokens }).into_iter().collect()
    };
    match &*keyword.text {
        "fn" if is_entry_point => Vec::new(),
        "fn" => item(ItemKind::Function, name_at(1), rest.to_vec()),
        "struct" | "const" | "alias" => item(ItemKind::Plain, name_at(1), rest.to_vec()),
        "override" => item(ItemKind::Override, name_at(1), rest.to_vec()),
        "enable" => vec![Item { kind: ItemKind::Directive, names: Vec::new(), tokens: rest.to_vec() }],
        "var" => {
            let mut space = "";
            let mut at = 1;
            if rest.get(1).is_some_and(|open| open.is("<")) {
                space = rest.get(2).map_or("", |space| &space.text);
                at = rest.iter().position(|token| token.is(">")).map_or(rest.len(), |end| end + 1);
            }
            let mut tokens: Vec<Token> = Vec::new();
            for (at, text) in ["var", "<", "private", ">"].into_iter().enumerate() {
                let kind = if is_name(text) { Kind::Word } else { Kind::Sign };
                let leads = at == 0 && keyword.leads;
                tokens.push(Token { leads, spaced: false, ..Token::instead(text, kind, keyword) });
            }
            tokens.extend(rest.get(at..).unwrap_or_default().iter().cloned());
            let opaque = rest.iter().any(|token| token.is("sampler") || token.text.starts_with("texture_"))
                || rest.iter().any(|token| token.is("sampler_comparison") || token.is("acceleration_structure"));
            let kind = match space {
                "private" => ItemKind::Plain,
                "uniform" | "storage" if !opaque => ItemKind::Input,
                _ => ItemKind::Resource,
            };
            item(kind, name_at(at), tokens)
        }
        _ => Vec::new(),
    }
}
