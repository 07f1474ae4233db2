//! WGSL in several files: WESL's imports, naga_oil's `#import`, and the library's own modules.
//!
//! Every import is looked for when a file is loaded; one that is not found matters only if the function reaches it.

use super::error::SourceError;
use super::features;
use super::items::{Item, items};
use super::lexer::{File, Kind, Origin, Token};
use super::macros::Macros;
use super::preprocess::{Preprocessed, add, preprocess, read};
use super::{Environment, Language};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// The files that are asked for their `#define_import_path`.
const MOST_SEARCHED: usize = 20_000;

/// One file's declarations, and what it imports.
#[derive(Debug, Default)]
pub(super) struct Unit {
    pub(super) items: Vec<Item>,
    pub(super) imports: Vec<Import>,
    /// What the names of its items begin with in the result; empty for the file itself.
    pub(super) prefix: String,
}

/// A name, or a path as it stands in the text, that means something of another file.
#[derive(Debug)]
pub(super) struct Import {
    pub(super) name: String,
    pub(super) path: Vec<Rc<str>>,
    pub(super) origin: Origin,
    /// None where it is not found.
    pub(super) target: Option<Target>,
}

/// A unit, and the name of the item there; no name where a path is a whole module.
pub(super) type Target = (usize, Option<Rc<str>>);

/// A module's place, before it is read.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Module {
    File(PathBuf),
    /// One of this crate's.
    Own(&'static str),
}

/// Reads a source and all that it imports.
pub(super) fn load(
    name: &str,
    text: &str,
    language: Language,
    environment: &Environment,
    files: &mut Vec<File>,
) -> Result<Vec<Unit>, SourceError> {
    let directory = Path::new(name).parent().filter(|_| Path::new(name).is_file()).map(Path::to_path_buf);
    // A file name alone has an empty parent.
    let directory = directory.map(|path| if path.as_os_str().is_empty() { PathBuf::from(".") } else { path });
    let mut loader = Loader { language, environment, files, units: Vec::new(), known: BTreeMap::new(), declared: None };
    loader.unit(name, text, directory, String::new())?;
    Ok(loader.units)
}

struct Loader<'a> {
    language: Language,
    environment: &'a Environment,
    files: &'a mut Vec<File>,
    units: Vec<Unit>,
    known: BTreeMap<Module, usize>,
    /// What files declare with `#define_import_path`, once asked for.
    declared: Option<BTreeMap<String, PathBuf>>,
}

impl Loader<'_> {
    fn unit(
        &mut self,
        name: &str,
        text: &str,
        directory: Option<PathBuf>,
        prefix: String,
    ) -> Result<usize, SourceError> {
        let file = add(self.files, name, text, directory.clone())?;
        let mut macros = Macros::new(&self.environment.defines)?;
        let done = preprocess(self.files, file, self.language, self.environment, &mut macros)?;
        let Preprocessed { tokens, imports: directives, .. } = done;
        let tokens = match self.language {
            Language::Wgsl => features::chosen(tokens, &self.environment.defines, self.files)?,
            Language::Glsl => tokens,
        };
        let (items, statements) = items(tokens, self.language, self.files)?;
        let mut imports = Vec::new();
        for statement in statements.iter().chain(&directives) {
            tree(statement, self.files, &mut imports)?;
        }
        // Paths written out where they are used, their first name being one imported or not.
        let mut paths: Vec<Import> = Vec::new();
        if self.language == Language::Wgsl {
            for item in &items {
                for (segments, origin) in paths_of(&item.tokens) {
                    let name = segments.join("::");
                    if paths.iter().any(|known| known.name == name) {
                        continue;
                    }
                    let mut path = segments.clone();
                    let first = segments.first().map_or("", |first| first);
                    if let Some(alias) = imports.iter().find(|import| import.name == first) {
                        path = alias.path.iter().chain(segments.iter().skip(1)).cloned().collect();
                    }
                    paths.push(Import { name, path, origin, target: None });
                }
            }
        }
        imports.extend(paths);
        let index = self.units.len();
        self.units.push(Unit { items, imports: Vec::new(), prefix });
        for import in &mut imports {
            import.target = self.target(&import.path, directory.as_deref(), index, import.origin)?;
        }
        if let Some(unit) = self.units.get_mut(index) {
            unit.imports = imports;
        }
        Ok(index)
    }

    /// The unit that a path leads to, loaded if it is new.
    fn target(
        &mut self,
        path: &[Rc<str>],
        directory: Option<&Path>,
        from: usize,
        origin: Origin,
    ) -> Result<Option<Target>, SourceError> {
        // The whole path as a module first, then all but its last name.
        for keep in [path.len(), path.len().saturating_sub(1)] {
            let (module, item) = (path.get(..keep).unwrap_or_default(), path.get(keep).cloned());
            if matches!(module, [only] if &**only == "package" || &**only == "super") && keep < path.len() {
                return Ok(Some((from, item)));
            }
            let Some(found) = self.find(module, directory) else { continue };
            if let Some(known) = self.known.get(&found) {
                return Ok(Some((*known, item)));
            }
            let prefix =
                format!("{}_", module.last().map_or("", |last| last).replace(|c: char| !c.is_alphanumeric(), "_"));
            let prefix = self.unlike_others(prefix);
            let index = self.units.len();
            self.known.insert(found.clone(), index);
            match &found {
                Module::Own(name) => {
                    let text = crate::wgsl::source(name).unwrap_or_default();
                    self.unit(&format!("brdf::{name}"), text, None, prefix)?;
                }
                Module::File(path) => {
                    let shown = path.display().to_string();
                    let text = read(path)
                        .map_err(|reason| SourceError::at(self.files, origin, format!("{shown}: {reason}")))?;
                    self.unit(&shown, &text, path.parent().map(Path::to_path_buf), prefix)?;
                }
            }
            return Ok(Some((index, item)));
        }
        Ok(None)
    }

    fn unlike_others(&self, mut prefix: String) -> String {
        while self.units.iter().any(|unit| unit.prefix == prefix) {
            prefix.insert(0, 'x');
        }
        prefix
    }

    fn find(&mut self, path: &[Rc<str>], directory: Option<&Path>) -> Option<Module> {
        let first = path.first()?;
        let beside = directory.map(Path::to_path_buf);
        let roots: Vec<PathBuf> = beside.iter().chain(&self.environment.include).cloned().collect();
        let file = |path: PathBuf| path.is_file().then_some(Module::File(path));
        if path.len() == 1 && first.contains(['/', '.']) {
            return roots.iter().find_map(|root| file(root.join(&**first)));
        }
        if let Some(declared) = self.declared(directory).get(&path.join("::")) {
            return Some(Module::File(declared.clone()));
        }
        let own =
            |name: &str| crate::wgsl::MODULES.iter().find(|(own, _)| *own == name).map(|(own, _)| Module::Own(own));
        match path {
            [package, module] if &**package == "brdf" => return own(module),
            // Within the library its modules import each other.
            [package, module] if directory.is_none() && matches!(&**package, "package" | "super") => {
                return own(module);
            }
            _ => {}
        }
        // `super` is the directory above that of the module's own children: where the module itself lies.
        let ups = path.iter().take_while(|segment| &***segment == "super").count();
        let mut tail = path.get(ups..)?;
        let mut bases = roots;
        if ups > 0 {
            let mut base = directory?.to_path_buf();
            for _ in 1..ups {
                base.pop();
            }
            bases = vec![base];
        } else if &**first == "package" {
            tail = path.get(1..)?;
        }
        let names: Vec<&str> = tail.iter().map(|segment| &**segment).collect();
        // The first name may be a package's, whose directory an -I is.
        let choices = [names.as_slice(), names.get(1..).unwrap_or_default()];
        let choices = choices.into_iter().take(if ups == 0 && &**first != "package" { 2 } else { 1 });
        for names in choices.filter(|names| !names.is_empty()) {
            for base in &bases {
                for ending in ["wesl", "wgsl"] {
                    let path = base.join(format!("{}.{ending}", names.join("/")));
                    if let Some(found) = file(path) {
                        return Some(found);
                    }
                }
            }
        }
        None
    }

    fn declared(&mut self, directory: Option<&Path>) -> &BTreeMap<String, PathBuf> {
        let include = &self.environment.include;
        self.declared.get_or_insert_with(|| {
            let mut found = BTreeMap::new();
            let mut left = MOST_SEARCHED;
            // The files beside the first one, and all below the directories given.
            for (root, deep) in
                directory.map(|path| (path, false)).into_iter().chain(include.iter().map(|path| (path.as_path(), true)))
            {
                search(root, if deep { 16 } else { 0 }, &mut left, &mut found);
            }
            found
        })
    }
}

/// Collects what files of a directory call themselves.
fn search(directory: &Path, depth: usize, left: &mut usize, found: &mut BTreeMap<String, PathBuf>) {
    let Ok(entries) = std::fs::read_dir(directory) else { return };
    let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    paths.sort();
    for path in paths {
        let Some(rest) = left.checked_sub(1) else { return };
        *left = rest;
        if path.is_dir() && !path.is_symlink() {
            if depth > 0 {
                search(&path, depth - 1, left, found);
            }
        } else if path.extension().is_some_and(|ending| ending == "wgsl" || ending == "wesl")
            && let Ok(text) = read(&path)
        {
            let declared = text.lines().find_map(|line| line.trim().strip_prefix("#define_import_path"));
            if let Some(name) = declared {
                found.entry(name.trim().to_owned()).or_insert(path);
            }
        }
    }
}

/// Reads `a::{b, c::d as e}`, or naga_oil's older `a::b c, d`.
fn tree(tokens: &[Token], files: &[File], imports: &mut Vec<Import>) -> Result<(), SourceError> {
    let mut at = 0;
    let mut path = Vec::new();
    branch(tokens, &mut at, &mut path, files, imports, 0)?;
    // The older form: items after the module.
    let module = imports.last().map(|import| import.path.clone());
    while let (Some(token), Some(module)) = (tokens.get(at), &module) {
        if token.is_word() {
            let path = module.iter().chain([&token.text]).cloned().collect();
            imports.push(Import { name: token.text.to_string(), path, origin: token.origin, target: None });
        } else if !token.is(",") && !token.is(";") {
            return Err(SourceError::at(files, token.origin, format!("`{}` is not expected in an import", token.text)));
        }
        at += 1;
    }
    Ok(())
}

fn branch(
    tokens: &[Token],
    at: &mut usize,
    path: &mut Vec<Rc<str>>,
    files: &[File],
    imports: &mut Vec<Import>,
    depth: usize,
) -> Result<(), SourceError> {
    let outer = path.len();
    while let Some(token) = tokens.get(*at) {
        *at += 1;
        if token.is("{") {
            if depth > 32 {
                return Err(SourceError::at(files, token.origin, "braces nested more than 32 deep in an import"));
            }
            loop {
                match tokens.get(*at) {
                    Some(next) if next.is("}") => {
                        *at += 1;
                        break;
                    }
                    Some(next) if next.is(",") => *at += 1,
                    Some(_) => branch(tokens, at, path, files, imports, depth + 1)?,
                    None => return Err(SourceError::at(files, token.origin, "`{` is not closed")),
                }
            }
            path.truncate(outer);
            return Ok(());
        }
        if !token.is_word() && token.kind != Kind::Quoted {
            return Err(SourceError::at(files, token.origin, format!("`{}` is not expected in an import", token.text)));
        }
        path.push(Rc::clone(&token.text));
        if tokens.get(*at).is_some_and(|next| next.is("::")) {
            *at += 1;
            continue;
        }
        let mut name = Rc::clone(&token.text);
        if tokens.get(*at).is_some_and(|next| next.is("as"))
            && let Some(given) = tokens.get(*at + 1)
        {
            name = Rc::clone(&given.text);
            *at += 2;
        }
        imports.push(Import { name: name.to_string(), path: path.clone(), origin: token.origin, target: None });
        break;
    }
    path.truncate(outer);
    Ok(())
}

/// The paths of more than one name in a declaration.
pub(super) fn paths_of(tokens: &[Token]) -> Vec<(Vec<Rc<str>>, Origin)> {
    let mut paths = Vec::new();
    let mut at = 0;
    while let Some(token) = tokens.get(at) {
        let length = path_length(tokens, at);
        if length > 1 {
            let names = tokens.get(at..at + length).unwrap_or_default().iter().filter(|token| token.is_word());
            paths.push((names.map(|token| Rc::clone(&token.text)).collect(), token.origin));
        }
        at += length.max(1);
    }
    paths
}

/// The tokens of the path `a::b::c` that starts here; 1 for a name alone, 0 for no name.
pub(super) fn path_length(tokens: &[Token], start: usize) -> usize {
    if !tokens.get(start).is_some_and(Token::is_word) {
        return 0;
    }
    let mut length = 1;
    while tokens.get(start + length).is_some_and(|sign| sign.is("::"))
        && tokens.get(start + length + 1).is_some_and(Token::is_word)
    {
        length += 2;
    }
    length
}
