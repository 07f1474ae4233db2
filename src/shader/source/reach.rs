//! What a function needs of a source: the declarations that its names lead to, and theirs.

use super::emit::Emitted;
use super::error::SourceError;
use super::imports::{Unit, path_length};
use super::items::{Item, ItemKind};
use super::lexer::{Kind, Token};
use super::{Language, Source};
use std::collections::BTreeSet;
use std::rc::Rc;

/// The unit of a declaration, and its number there.
type Id = (usize, usize);

/// The declarations that a function reaches.
pub(super) struct Reached {
    pub(super) items: BTreeSet<Id>,
    /// Every member that is read or written by name somewhere in them.
    pub(super) members: BTreeSet<Rc<str>>,
}

/// Finds the functions of a name, and all that they reach.
pub(super) fn reach(source: &Source, function: &str) -> Result<Reached, SourceError> {
    let root = source.units.first().map_or(&[][..], |unit| &unit.items);
    let is_it = |item: &Item| item.kind == ItemKind::Function && item.names.iter().any(|name| &**name == function);
    let mut waiting: Vec<Id> =
        (0..root.len()).filter(|at| root.get(*at).is_some_and(is_it)).map(|at| (0, at)).collect();
    if waiting.is_empty() {
        return Err(SourceError::of(source.name(), missing(source, function)));
    }
    let mut reached = Reached { items: BTreeSet::new(), members: BTreeSet::new() };
    while let Some(id) = waiting.pop() {
        let Some(item) = source.item(id) else { continue };
        if !reached.items.insert(id) {
            continue;
        }
        for found in names(source, id.0, item)? {
            match found.meaning {
                Meaning::Item(to) => {
                    if let Some(target) = source.item(to).filter(|target| target.kind == ItemKind::Resource) {
                        let name = &found.name;
                        let what = if target.tokens.iter().any(|t| t.is("shared") || t.is("workgroup")) {
                            "memory that invocations share"
                        } else {
                            "a texture or sampler"
                        };
                        let message = format!(
                            "`{function}` reaches `{name}`, {what}, which has no value here: name a function that takes \
                             what is read from it as a parameter"
                        );
                        return Err(SourceError::at(&source.files, found.token.origin, message));
                    }
                    // Overloads come together.
                    let unit = source.units.get(to.0).map_or(&[][..], |unit| &unit.items);
                    for (at, other) in unit.iter().enumerate() {
                        if at == to.1 || other.names.iter().any(|name| **name == *found.name) {
                            waiting.push((to.0, at));
                        }
                    }
                }
                Meaning::Member => {
                    reached.members.insert(Rc::clone(&found.token.text));
                }
            }
        }
    }
    Ok(reached)
}

fn missing(source: &Source, function: &str) -> String {
    let root = source.units.first().map_or(&[][..], |unit| &unit.items);
    let mut there: Vec<&str> = Vec::new();
    for item in root.iter().filter(|item| item.kind == ItemKind::Function) {
        for name in &item.names {
            if !there.contains(&&**name) {
                there.push(name);
            }
        }
    }
    match (there.as_slice(), function) {
        ([], _) => {
            format!("no function in this file{}", if function.is_empty() { "" } else { ": is it the right one?" })
        }
        (there, "") => format!("name a function of this file: it has {}", there.join(", ")),
        (there, _) => format!("no function `{function}`: the file has {}", there.join(", ")),
    }
}

impl Source {
    pub(super) fn name(&self) -> &str {
        self.files.first().map_or("", |file| &file.name)
    }

    pub(super) fn item(&self, id: Id) -> Option<&Item> {
        self.units.get(id.0).and_then(|unit| unit.items.get(id.1))
    }

    /// Writes the declarations, those of other files under longer names.
    pub(super) fn emit(
        &self,
        reached: &Reached,
        edit: impl Fn(&Item) -> Vec<Token>,
        emitted: &mut Emitted,
    ) -> Result<(), SourceError> {
        for id in &reached.items {
            let Some(item) = self.item(*id) else { continue };
            let item = Item { tokens: edit(item), ..item.clone() };
            let mut renames = names(self, id.0, &item)?.into_iter().peekable();
            let mut at = 0;
            while let Some(token) = item.tokens.get(at) {
                let found = renames.next_if(|found| found.at == at);
                match found {
                    Some(Found { meaning: Meaning::Item(to), name, length, .. }) => {
                        let prefix = self.units.get(to.0).map_or("", |unit| &unit.prefix);
                        emitted.token(&Token { text: format!("{prefix}{name}").into(), ..token.clone() });
                        at += length;
                    }
                    _ => {
                        emitted.token(token);
                        at += 1;
                    }
                }
            }
        }
        emitted.raw("\n");
        Ok(())
    }
}

enum Meaning {
    Item(Id),
    Member,
}

/// A name in a declaration that means something outside of it.
struct Found<'a> {
    /// The token's number, and how many there are of the path.
    at: usize,
    length: usize,
    token: &'a Token,
    /// The name in the unit that declares it.
    name: Rc<str>,
    meaning: Meaning,
}

fn names<'a>(source: &Source, unit: usize, item: &'a Item) -> Result<Vec<Found<'a>>, SourceError> {
    let Some(here) = source.units.get(unit) else { return Ok(Vec::new()) };
    let locals = locals(item, source.language);
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(token) = item.tokens.get(at) {
        let length = path_length(&item.tokens, at);
        let start = at;
        at += length.max(1);
        if length == 0 {
            continue;
        }
        if start > 0 && item.tokens.get(start - 1).is_some_and(|dot| dot.is(".")) {
            let (token, name) = (token, Rc::clone(&token.text));
            found.push(Found { at: start, length: 1, token, name, meaning: Meaning::Member });
            continue;
        }
        let is_call = item.tokens.get(start + length).is_some_and(|open| open.is("("));
        if length == 1 && !is_call && locals.contains(&token.text) {
            continue;
        }
        let text: String = if length == 1 {
            token.text.to_string()
        } else {
            let names = item.tokens.get(start..start + length).unwrap_or_default().iter().filter(|t| t.is_word());
            names.map(|name| &*name.text).collect::<Vec<_>>().join("::")
        };
        let declared = position(here, &text);
        if let Some(declared) = declared {
            let (name, meaning) = (Rc::clone(&token.text), Meaning::Item((unit, declared)));
            found.push(Found { at: start, length, token, name, meaning });
            continue;
        }
        let Some(import) = here.imports.iter().find(|import| import.name == text) else { continue };
        let path = import.path.join("::");
        let refuse = |message: String| Err(SourceError::at(&source.files, token.origin, message));
        match &import.target {
            None => {
                let file = match import.path.as_slice() {
                    [.., file, _] => format!("{file}.wesl or {file}.wgsl"),
                    _ => "it".to_owned(),
                };
                return refuse(format!(
                    "`{text}` is imported from `{path}`, which is not found; give the directory that has {file} with -I"
                ));
            }
            Some((_, None)) => return refuse(format!("`{text}` is a module, not a declaration")),
            Some((to, Some(name))) => {
                let declared = source.units.get(*to).and_then(|unit| position(unit, name));
                let Some(declared) = declared else {
                    return refuse(format!("`{path}` is not declared in the module that it names"));
                };
                let (name, meaning) = (Rc::clone(name), Meaning::Item((*to, declared)));
                found.push(Found { at: start, length, token, name, meaning });
            }
        }
    }
    Ok(found)
}

fn position(unit: &Unit, name: &str) -> Option<usize> {
    unit.items.iter().position(|item| item.names.iter().any(|own| &**own == name))
}

/// The names that a declaration declares within itself: parameters, variables, members.
fn locals(item: &Item, language: Language) -> BTreeSet<Rc<str>> {
    let mut names = BTreeSet::new();
    let tokens = &item.tokens;
    let text = |at: usize| {
        tokens.get(at).map_or("", |token: &Token| if token.kind == Kind::Quoted { "" } else { &token.text })
    };
    for (at, token) in tokens.iter().enumerate().filter(|(_, token)| token.is_word()) {
        if item.names.contains(&token.text) {
            continue;
        }
        let before = if at == 0 { "" } else { text(at - 1) };
        let declares = match language {
            // `var<function> x` too; a member or parameter stands before a colon.
            Language::Wgsl => {
                matches!(before, "let" | "var" | "const")
                    || before == ">" && matches!(text(at + 1), "=" | ":")
                    || text(at + 1) == ":" && matches!(before, "(" | "," | "{" | ")")
            }
            Language::Glsl => {
                let is_type = tokens.get(at.wrapping_sub(1)).is_some_and(Token::is_word)
                    && !matches!(before, "return" | "else" | "case" | "do" | "in" | "out" | "inout" | "const");
                is_type && matches!(text(at + 1), "=" | ";" | "," | ")" | "[")
            }
        };
        if declares {
            names.insert(Rc::clone(&token.text));
        }
    }
    names
}
