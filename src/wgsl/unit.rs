//! One WGSL text split into its imports, directives and items: as much grammar as linking needs.

use super::error::LinkError;
use super::token::{self, Token};
use alloc::borrow::ToOwned;
use alloc::collections::BTreeMap;
use alloc::collections::btree_map::Entry;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::ops::Range;

/// What an [`Item`] declares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Function,
    Struct,
    /// `const`, `override`, `var` or `alias`.
    Value,
    /// `const_assert`, which has no name.
    Assertion,
}

/// A declaration at the top level.
#[derive(Debug)]
pub(crate) struct Item<'a> {
    pub(crate) kind: Kind,
    /// Empty for an assertion.
    pub(crate) name: &'a str,
    pub(crate) name_token: usize,
    /// From the first attribute to the last token.
    pub(crate) tokens: Range<usize>,
    /// The same in bytes, with the comment lines directly above and the comment that follows on the last line.
    pub(crate) text: Range<usize>,
    /// Of a function.
    pub(crate) parameters: usize,
    /// Whether it has one of the attributes `compute`, `vertex` and `fragment`.
    pub(crate) is_entry_point: bool,
}

/// One name that an `import` brings in.
#[derive(Debug)]
pub(crate) struct Import<'a> {
    pub(crate) name: &'a str,
    pub(crate) path: Vec<&'a str>,
    /// Where the path's last segment stands.
    pub(crate) token: usize,
}

/// A parsed text: the caller's shader or one module.
#[derive(Debug)]
pub(crate) struct Unit<'a> {
    /// The module's name; none for the caller's shader.
    pub(crate) module: Option<&'a str>,
    pub(crate) text: &'a str,
    pub(crate) tokens: Vec<Token>,
    pub(crate) imports: Vec<Import<'a>>,
    /// The statements, in bytes and with the comment on their last line, that `imports` came from.
    pub(crate) import_spans: Vec<Range<usize>>,
    /// Where the last `enable`, `requires` or `diagnostic` ends: nothing but those may precede it.
    pub(crate) directives_end: usize,
    pub(crate) items: Vec<Item<'a>>,
    /// Every name that `items` declares.
    pub(crate) names: BTreeMap<&'a str, usize>,
}

impl<'a> Unit<'a> {
    /// Reads a module of the library, or, without a name, the caller's shader.
    pub(crate) fn parse(module: Option<&'a str>, text: &'a str) -> Result<Self, LinkError> {
        let mut unit = Unit {
            module,
            text,
            tokens: Vec::new(),
            imports: Vec::new(),
            import_spans: Vec::new(),
            directives_end: 0,
            items: Vec::new(),
            names: BTreeMap::new(),
        };
        unit.tokens = token::tokens(text).map_err(|offset| {
            LinkError::at(unit.place(), text, offset, "a block comment never ends".into(), "close it with `*/`".into())
        })?;
        let mut at = 0;
        let mut floor = 0; // where the previous statement's text ends
        while at < unit.tokens.len() {
            at = match unit.word(at) {
                Some("import") => unit.import(at)?,
                Some("enable" | "requires" | "diagnostic") => unit.directive(at)?,
                _ if unit.is(at, ";") => at + 1,
                _ => unit.item(at, floor)?,
            };
            floor = unit.items.last().map_or(0, |item| item.text.end).max(unit.offset_after(at));
        }
        Ok(unit)
    }

    /// How errors name this text.
    pub(crate) fn place(&self) -> String {
        self.module.map_or("root".to_owned(), |module| format!("brdf::{module}"))
    }

    /// The text of a token; empty past the end.
    pub(crate) fn token(&self, at: usize) -> &'a str {
        self.tokens.get(at).map_or("", |token| token.text(self.text))
    }

    /// Whether a token is this text.
    pub(crate) fn is(&self, at: usize, text: &str) -> bool {
        self.token(at) == text
    }

    /// The text of a token that is an identifier or keyword.
    pub(crate) fn word(&self, at: usize) -> Option<&'a str> {
        (self.tokens.get(at)?.kind == token::Kind::Word).then(|| self.token(at))
    }

    /// An error at a token.
    pub(crate) fn error(&self, at: usize, problem: impl Into<String>, remedy: impl Into<String>) -> LinkError {
        let offset = self.tokens.get(at).map_or(self.text.len(), |token| token.start);
        LinkError::at(self.place(), self.text, offset, problem.into(), remedy.into())
    }

    /// The token after the bracket that closes the one at `at`.
    pub(crate) fn after_group(&self, at: usize) -> Result<usize, LinkError> {
        let mut open = Vec::new();
        for i in at..self.tokens.len() {
            match self.token(i) {
                "(" => open.push(")"),
                "[" => open.push("]"),
                "{" => open.push("}"),
                close @ (")" | "]" | "}") if open.pop() != Some(close) => {
                    return Err(self.error(i, format!("`{close}` closes nothing"), "balance the brackets"));
                }
                _ => {}
            }
            if open.is_empty() {
                return Ok(i + 1);
            }
        }
        Err(self.error(at, format!("`{}` is never closed", self.token(at)), "balance the brackets"))
    }

    /// The token after `<…>`, where there is one.
    pub(crate) fn after_template(&self, at: usize) -> usize {
        let mut depth = 0_usize;
        for i in at..self.tokens.len() {
            match self.token(i) {
                "<" => depth += 1,
                ">" => depth = depth.saturating_sub(1),
                _ => {}
            }
            if depth == 0 {
                return if i == at { at } else { i + 1 };
            }
        }
        at
    }

    fn offset_after(&self, at: usize) -> usize {
        at.checked_sub(1).and_then(|last| self.tokens.get(last)).map_or(0, |token| token.end)
    }

    fn expect_word(&self, at: usize, what: &str) -> Result<&'a str, LinkError> {
        self.word(at).ok_or_else(|| self.expected(at, what))
    }

    fn expected(&self, at: usize, what: &str) -> LinkError {
        let found = if at < self.tokens.len() { format!("found `{}`", self.token(at)) } else { "the text ends".into() };
        self.error(at, format!("expected {what}, {found}"), "correct the declaration")
    }

    fn before_items(&self, at: usize) -> Result<(), LinkError> {
        match self.items.first() {
            None => Ok(()),
            Some(_) => Err(self.error(at, format!("`{}` after the first item", self.token(at)), "move it to the top")),
        }
    }

    fn import(&mut self, first: usize) -> Result<usize, LinkError> {
        self.before_items(first)?;
        let end = self.import_tree(first + 1, &mut Vec::new())?;
        if !self.is(end, ";") {
            return Err(self.expected(end, "`;` after the import"));
        }
        let span = self.tokens[first].start..self.with_trailing_comment(self.tokens[end].end);
        self.import_spans.push(span);
        Ok(end + 1)
    }

    fn import_tree(&mut self, mut at: usize, path: &mut Vec<&'a str>) -> Result<usize, LinkError> {
        let depth = path.len();
        loop {
            path.push(self.expect_word(at, "a name to import")?);
            if !self.is(at + 1, "::") {
                break;
            }
            // Also what bounds the recursion.
            if path.len() == 3 {
                let problem = format!("`{}` is not a module", path.join("::"));
                return Err(self.error(at, problem, "a path is package, module, item"));
            }
            at += 2;
            if self.is(at, "{") {
                at += 1;
                while !self.is(at, "}") {
                    at = self.import_tree(at, path)?;
                    match self.token(at) {
                        "," => at += 1,
                        "}" => {}
                        _ => return Err(self.expected(at, "`,` or `}` in the import")),
                    }
                }
                path.truncate(depth);
                return Ok(at + 1);
            }
        }
        let (mut name, token) = (path.last().copied().unwrap_or_default(), at);
        at += 1;
        if self.is(at, "as") {
            name = self.expect_word(at + 1, "a name after `as`")?;
            at += 2;
        }
        if matches!(name, "brdf" | "package" | "super") {
            let remedy = "import a module or an item of it, and give it another name with `as`";
            return Err(self.error(at - 1, format!("`{name}` cannot be imported or renamed to"), remedy));
        }
        self.imports.push(Import { name, path: path.clone(), token });
        path.truncate(depth);
        Ok(at)
    }

    fn directive(&mut self, first: usize) -> Result<usize, LinkError> {
        if self.module.is_some() {
            let problem = format!("a library module has the directive `{}`", self.token(first));
            return Err(self.error(first, problem, "leave it to the shader that embeds the module"));
        }
        self.before_items(first)?;
        let end = self.after_semicolon(first)?;
        self.directives_end = self.with_trailing_comment(self.offset_after(end));
        Ok(end)
    }

    fn after_semicolon(&self, mut at: usize) -> Result<usize, LinkError> {
        while at < self.tokens.len() {
            match self.token(at) {
                ";" => return Ok(at + 1),
                "(" | "[" | "{" | ")" | "]" | "}" => at = self.after_group(at)?,
                _ => at += 1,
            }
        }
        Err(self.expected(at, "`;`"))
    }

    fn item(&mut self, first: usize, floor: usize) -> Result<usize, LinkError> {
        let (mut at, mut is_entry_point) = (first, false);
        while self.is(at, "@") {
            is_entry_point |= matches!(self.expect_word(at + 1, "an attribute")?, "compute" | "vertex" | "fragment");
            at += 2;
            if self.is(at, "(") {
                at = self.after_group(at)?;
            }
        }
        let keyword = self.token(at);
        let kind = match keyword {
            "fn" => Kind::Function,
            "struct" => Kind::Struct,
            "const" | "override" | "var" | "alias" => Kind::Value,
            "const_assert" => Kind::Assertion,
            _ => return Err(self.expected(at, "a declaration (fn, struct, const, alias, …)")),
        };
        if self.module.is_some() && (is_entry_point || matches!(keyword, "var" | "override")) {
            let what = if is_entry_point { "an entry point" } else { keyword };
            let remedy = "library modules are plain functions: pass it as a parameter, or declare it in the shader";
            return Err(self.error(at, format!("a library module declares {what}"), remedy));
        }
        at += 1;
        let (mut name, mut name_token, mut parameters) = ("", usize::MAX, 0);
        if kind != Kind::Assertion {
            at = self.after_template(at);
            (name, name_token) = (self.expect_word(at, "the name of the declaration")?, at);
            at += 1;
        }
        let end = match kind {
            Kind::Function => {
                if !self.is(at, "(") {
                    return Err(self.expected(at, "`(` after the function's name"));
                }
                let list = at..self.after_group(at)?;
                at = list.end;
                // Nothing else in a parameter list has a colon.
                parameters = list.filter(|i| self.is(*i, ":")).count();
                while at < self.tokens.len() && !self.is(at, "{") {
                    at = if self.is(at, "(") { self.after_group(at)? } else { at + 1 };
                }
                if at == self.tokens.len() {
                    return Err(self.expected(at, "the function's body"));
                }
                self.after_group(at)?
            }
            Kind::Struct if self.is(at, "{") => self.after_group(at)?,
            Kind::Struct => return Err(self.expected(at, "`{` after the struct's name")),
            Kind::Value | Kind::Assertion => self.after_semicolon(at)?,
        };
        if kind != Kind::Assertion {
            match self.names.entry(name) {
                Entry::Vacant(entry) => entry.insert(self.items.len()),
                Entry::Occupied(_) => {
                    return Err(self.error(name_token, format!("`{name}` is declared twice"), "rename one"));
                }
            };
        }
        let text = self.with_comments(self.tokens[first].start..self.offset_after(end), floor);
        self.items.push(Item { kind, name, name_token, tokens: first..end, text, parameters, is_entry_point });
        Ok(end)
    }

    /// Widens an item's span by the `//` lines directly above it and the one on its last line.
    fn with_comments(&self, span: Range<usize>, floor: usize) -> Range<usize> {
        let mut start = span.start;
        let line_start = |offset: usize| self.text[..offset].rfind('\n').map_or(0, |newline| newline + 1);
        let mut line = line_start(start);
        if self.text[line..start].trim().is_empty() {
            while line > floor {
                let above = line_start(line - 1);
                if above < floor || !self.text[above..line].trim_start().starts_with("//") {
                    break;
                }
                (start, line) = (above, above);
            }
        }
        start..self.with_trailing_comment(span.end)
    }

    fn with_trailing_comment(&self, end: usize) -> usize {
        let line_end = token::line_end(self.text, end);
        if self.text[end..line_end].trim_start().starts_with("//") { line_end } else { end }
    }
}
