//! Imports resolved, unreached items dropped, the rest renamed and put in order.

use super::error::{LinkError, list, suggest};
use super::names::{Names, Path, names};
use super::unit::{Kind, Unit};
use alloc::borrow::ToOwned;
use alloc::collections::{BTreeMap, BTreeSet};
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::ops::Range;

/// A module's name and text.
pub(crate) type Module<'a> = (&'a str, &'a str);

/// The name that a library item has in linked WGSL: `fresnel_dielectric` for `dielectric` of `fresnel`.
pub fn mangled(module: &str, item: &str) -> String {
    format!("{module}_{item}")
}

/// Links a root against modules.
pub(crate) fn link(modules: &[Module<'_>], root: &str) -> Result<String, LinkError> {
    let mut linker = Linker::new(modules)?;
    linker.units.push(Unit::parse(None, root)?);
    linker.bind()?;
    let root = linker.units.len() - 1;
    let items = (0..linker.units[root].items.len()).map(|item| (root, item)).collect();
    let mut linked = linker.reach(items)?;
    linked.check(&linker)?;
    let library = linked.library(&linker);

    let unit = &linker.units[root];
    let mut edits: Vec<Edit> = unit.import_spans.iter().map(|span| (line_of(unit.text, span), String::new())).collect();
    edits.extend(linked.edits.range((root, 0)..).flat_map(|(_, edits)| edits.iter().cloned()));
    let head = edited(unit.text, 0..unit.directives_end, &edits);
    let tail = edited(unit.text, unit.directives_end..unit.text.len(), &edits);
    if library.is_empty() {
        return Ok(head + &tail);
    }
    let gap = if head.is_empty() { "" } else { "\n\n" };
    Ok(format!("{}{gap}{library}\n{}", head.trim_end(), tail.trim_start_matches(['\r', '\n'])))
}

/// Links what one item of one module needs.
pub(crate) fn link_item(modules: &[Module<'_>], module: &str, item: &str) -> Result<String, LinkError> {
    let mut linker = Linker::new(modules)?;
    linker.bind()?;
    let unknown = |problem, remedy| LinkError { place: "link_function".to_owned(), position: None, problem, remedy };
    let m = linker.module(module).map_err(|remedy| unknown(format!("no module `{module}`"), remedy))?;
    let i = linker.item(m, item).map_err(|remedy| unknown(format!("no item `{item}` in brdf::{module}"), remedy))?;
    let mut linked = linker.reach([(m, i)].into())?;
    linked.check(&linker)?;
    Ok(linked.library(&linker))
}

/// A unit and an item in it.
type Id = (usize, usize);
/// Bytes of a text and what replaces them.
type Edit = (Range<usize>, String);

/// What a path stands for.
#[derive(Clone, Copy)]
enum Target {
    Module(usize),
    Item(Id),
}

struct Linker<'a> {
    /// The modules in alphabetical order, then the root where there is one.
    units: Vec<Unit<'a>>,
    /// What each unit imports.
    bindings: Vec<BTreeMap<&'a str, Target>>,
}

impl<'a> Linker<'a> {
    fn new(modules: &[Module<'a>]) -> Result<Self, LinkError> {
        let units: Result<Vec<_>, _> = modules.iter().map(|(name, text)| Unit::parse(Some(name), text)).collect();
        let mut units = units?;
        units.sort_by_key(|unit| unit.module);
        Ok(Linker { units, bindings: Vec::new() })
    }

    /// Resolves the imports of every unit: a name that does not exist is an error even where nothing uses it.
    fn bind(&mut self) -> Result<(), LinkError> {
        for unit in &self.units {
            let mut bindings = BTreeMap::new();
            for import in &unit.imports {
                let target = self.absolute(unit, &import.path, import.token)?;
                let problem = if unit.names.contains_key(import.name) {
                    format!("`{}` is imported and declared", import.name)
                } else if bindings.insert(import.name, target).is_some() {
                    format!("`{}` is imported twice", import.name)
                } else {
                    continue;
                };
                return Err(unit.error(import.token, problem, "drop one or rename the import with `as`"));
            }
            self.bindings.push(bindings);
        }
        Ok(())
    }

    /// The unit of a module, or which there are.
    fn module(&self, name: &str) -> Result<usize, String> {
        let mut modules = self.units.iter().map(|unit| unit.module);
        modules
            .position(|module| module == Some(name))
            .ok_or_else(|| suggest(name, self.units.iter().filter_map(|unit| unit.module)))
    }

    /// An item of a unit, or which there are.
    fn item(&self, unit: usize, name: &str) -> Result<usize, String> {
        let names = &self.units[unit].names;
        let public = names.keys().copied().filter(|name| !name.starts_with('_'));
        names.get(name).copied().ok_or_else(|| suggest(name, public))
    }

    /// What a path that begins with the package stands for.
    fn absolute(&self, from: &Unit<'a>, path: &[&str], token: usize) -> Result<Target, LinkError> {
        let package = path.first().copied().unwrap_or_default();
        let packages: &[&str] = if from.module.is_some() { &["package", "super"] } else { &["brdf"] };
        if !packages.contains(&package) {
            let problem = format!("`{}` does not begin in this library", path.join("::"));
            let remedy = match self.module(package) {
                Ok(_) => format!("add `import {}::{package};`", packages[0]),
                Err(_) => format!("paths begin with an imported module or with `{}::`", packages[0]),
            };
            return Err(from.error(token, problem, remedy));
        }
        let Some(name) = path.get(1) else {
            return Err(from.error(token, format!("`{package}` is the whole library"), "name a module of it"));
        };
        let module = self
            .module(name)
            .map_err(|remedy| from.error(token, format!("no module `{name}` in `{package}`"), remedy))?;
        self.within(from, module, &path[2..], token)
    }

    /// What the rest of a path stands for in a module.
    fn within(&self, from: &Unit<'a>, module: usize, path: &[&str], token: usize) -> Result<Target, LinkError> {
        let place = || self.units[module].place();
        match path {
            [] => Ok(Target::Module(module)),
            [name] => {
                let item = self
                    .item(module, name)
                    .map_err(|remedy| from.error(token, format!("no item `{name}` in {}", place()), remedy))?;
                if from.module.is_none() && name.starts_with('_') {
                    let problem = format!("`{name}` is private to {}", place());
                    return Err(from.error(token, problem, "use an item without a leading `_`"));
                }
                Ok(Target::Item((module, item)))
            }
            [name, ..] => {
                let problem = format!("`{name}` in {} is not a module", place());
                Err(from.error(token, problem, "a path is package, module, item"))
            }
        }
    }

    /// The item that a free name stands for; none for builtins and for what only the embedding shader knows.
    fn resolve(&self, at: usize, path: &Path<'a>) -> Result<Option<Id>, LinkError> {
        let unit = &self.units[at];
        let token = path.tokens.start;
        let (first, rest) = path.segments.split_first().map_or(("", &[][..]), |(first, rest)| (*first, rest));
        let target = match (self.bindings[at].get(first), rest.is_empty()) {
            (Some(target @ Target::Item(_)), true) => *target,
            (Some(Target::Item(_)), false) => {
                return Err(unit.error(token, format!("`{first}` is an item, not a module"), "import its module"));
            }
            (Some(Target::Module(module)), _) => self.within(unit, *module, rest, token)?,
            (None, true) => return Ok(unit.names.get(first).map(|item| (at, *item))),
            (None, false) => self.absolute(unit, &path.segments, token)?,
        };
        match target {
            Target::Item(id) => Ok(Some(id)),
            Target::Module(module) => {
                let problem = format!("`{}` is a module, not an item", path.segments.join("::"));
                let items = self.units[module].names.keys().copied().filter(|name| !name.starts_with('_'));
                Err(unit.error(token, problem, format!("name an item of it; {}", list(items))))
            }
        }
    }

    /// Everything that the items given need.
    fn reach(&self, mut queue: Vec<Id>) -> Result<Linked<'a>, LinkError> {
        let mut linked = Linked::default();
        let mut used = BTreeSet::new();
        while let Some(id) = queue.pop() {
            if linked.names.contains_key(&id) {
                continue;
            }
            let unit = &self.units[id.0];
            let item = &unit.items[id.1];
            let mut edits = Vec::new();
            let mut rename = |tokens: Range<usize>, to: Id| {
                if let Some(module) = self.units[to.0].module {
                    let span = unit.tokens[tokens.start].start..unit.tokens[tokens.end - 1].end;
                    edits.push((span, mangled(module, self.units[to.0].items[to.1].name)));
                }
            };
            if item.kind != Kind::Assertion {
                rename(item.name_token..item.name_token + 1, id);
            }
            let mut names = names(unit, item)?;
            let mut unresolved = Vec::new();
            for path in names.free.drain(..) {
                let Some(target) = self.resolve(id.0, &path)? else {
                    unresolved.push(path);
                    continue;
                };
                rename(path.tokens.clone(), target);
                linked.dependencies.entry(id.0).or_default().insert(target.0);
                queue.push(target);
            }
            names.free = unresolved;
            if used.insert(id.0) {
                let assertions = unit.items.iter().enumerate().filter(|(_, item)| item.kind == Kind::Assertion);
                queue.extend(assertions.map(|(item, _)| (id.0, item)));
            }
            linked.edits.insert(id, edits);
            linked.names.insert(id, names);
        }
        Ok(linked)
    }
}

/// The items that are needed, and how their texts change.
#[derive(Default)]
struct Linked<'a> {
    /// With the free names that resolve to nothing.
    names: BTreeMap<Id, Names<'a>>,
    edits: BTreeMap<Id, Vec<Edit>>,
    dependencies: BTreeMap<usize, BTreeSet<usize>>,
}

impl<'a> Linked<'a> {
    /// No new name may be one that the linked items already use, and no builtin that they use may be redefined.
    fn check(&self, linker: &Linker<'a>) -> Result<(), LinkError> {
        let mut taken: BTreeMap<String, String> = BTreeMap::new();
        for &(u, i) in self.names.keys() {
            let (unit, item) = (&linker.units[u], &linker.units[u].items[i]);
            let Some(module) = unit.module.filter(|_| item.kind != Kind::Assertion) else { continue };
            let path = format!("{}::{}", unit.place(), item.name);
            let name = mangled(module, item.name);
            if let Some(other) = taken.get(&name) {
                let problem = format!("{path} and {other} are both `{name}` when linked");
                return Err(unit.error(item.name_token, problem, "rename one"));
            }
            taken.insert(name, path);
        }
        let root = linker.units.last().filter(|unit| unit.module.is_none());
        for (&(u, i), names) in &self.names {
            let (unit, item) = (&linker.units[u], &linker.units[u].items[i]);
            let declared = (unit.module.is_none() && item.kind != Kind::Assertion).then_some(item.name_token);
            let words = names.free.iter().map(|path| path.tokens.start);
            for token in declared.into_iter().chain(names.local.iter().copied()).chain(words) {
                let name = unit.token(token);
                if let Some(path) = taken.get(name) {
                    let problem = format!("`{name}` in {} is what {path} is called when linked", unit.place());
                    return Err(unit.error(token, problem, "rename it, or import the item to use it"));
                }
            }
            let Some(root) = root.filter(|_| unit.module.is_some()) else { continue };
            for path in &names.free {
                let name = unit.token(path.tokens.start);
                if let Some(&redefined) = root.names.get(name)
                    && PREDECLARED.contains(&name)
                {
                    let problem =
                        format!("root's `{name}` redefines WGSL's, which {}::{} uses", unit.place(), item.name);
                    return Err(root.error(root.items[redefined].name_token, problem, "rename it"));
                }
            }
        }
        Ok(())
    }

    /// The library's items: a module after those that it needs, else alphabetically; items in source order.
    fn library(&mut self, linker: &Linker<'a>) -> String {
        let modules: BTreeSet<usize> =
            self.names.keys().map(|id| id.0).filter(|unit| linker.units[*unit].module.is_some()).collect();
        let mut order = Vec::new();
        for &module in &modules {
            self.visit(module, &modules, &mut BTreeSet::new(), &mut order);
        }
        let mut out = String::new();
        for module in order {
            let unit = &linker.units[module];
            let mut previous: Option<&Range<usize>> = None;
            for (&(_, i), edits) in self.edits.range((module, 0)..(module + 1, 0)) {
                let span = &unit.items[i].text;
                // A blank line between two items in the source stays one; none appears where there was none.
                let together = previous.is_some_and(|previous| {
                    let gap = unit.text[previous.end..span.start].split('\n').skip(1);
                    !gap.clone().zip(gap.skip(1)).any(|(line, _)| line.trim().is_empty())
                });
                out.push_str(if out.is_empty() || together { "" } else { "\n" });
                out.push_str(&edited(unit.text, span.clone(), edits));
                out.push('\n');
                previous = Some(span);
            }
        }
        out
    }

    fn visit(&self, module: usize, all: &BTreeSet<usize>, open: &mut BTreeSet<usize>, order: &mut Vec<usize>) {
        if order.contains(&module) || !all.contains(&module) || !open.insert(module) {
            return;
        }
        for &needed in self.dependencies.get(&module).into_iter().flatten() {
            self.visit(needed, all, open, order);
        }
        order.push(module);
    }
}

/// Part of a text with the edits that lie in it.
fn edited(text: &str, part: Range<usize>, edits: &[Edit]) -> String {
    let mut edits: Vec<&Edit> =
        edits.iter().filter(|(span, _)| part.start <= span.start && span.end <= part.end).collect();
    edits.sort_by_key(|(span, _)| span.start);
    let mut out = String::new();
    let mut at = part.start;
    for (span, replacement) in edits {
        out.push_str(&text[at..span.start]);
        out.push_str(replacement);
        at = span.end;
    }
    out.push_str(&text[at..part.end]);
    out
}

/// The span of a statement, widened to its whole lines where nothing else is on them.
fn line_of(text: &str, span: &Range<usize>) -> Range<usize> {
    let start = text[..span.start].rfind('\n').map_or(0, |newline| newline + 1);
    let end = text[span.end..].find('\n').map_or(text.len(), |newline| span.end + newline + 1);
    let alone = text[start..span.start].trim().is_empty() && text[span.end..end].trim().is_empty();
    if alone { start..end } else { span.clone() }
}

/// The types and functions of WGSL that a shader may redefine, to the surprise of the library's functions.
#[rustfmt::skip]
const PREDECLARED: &[&str] = &[
    "bool", "i32", "u32", "f32", "f16", "f64", "vec2", "vec3", "vec4", "array", "atomic", "ptr",
    "vec2f", "vec3f", "vec4f", "vec2h", "vec3h", "vec4h", "vec2i", "vec3i", "vec4i", "vec2u", "vec3u", "vec4u",
    "mat2x2", "mat2x3", "mat2x4", "mat3x2", "mat3x3", "mat3x4", "mat4x2", "mat4x3", "mat4x4",
    "mat2x2f", "mat2x3f", "mat2x4f", "mat3x2f", "mat3x3f", "mat3x4f", "mat4x2f", "mat4x3f", "mat4x4f",
    "bitcast", "all", "any", "select", "arrayLength",
    "abs", "acos", "acosh", "asin", "asinh", "atan", "atanh", "atan2", "ceil", "clamp", "cos", "cosh",
    "countLeadingZeros", "countOneBits", "countTrailingZeros", "cross", "degrees", "determinant", "distance", "dot",
    "exp", "exp2", "extractBits", "faceForward", "firstLeadingBit", "firstTrailingBit", "floor", "fma", "fract",
    "frexp", "insertBits", "inverseSqrt", "ldexp", "length", "log", "log2", "max", "min", "mix", "modf", "normalize",
    "pow", "quantizeToF16", "radians", "reflect", "refract", "reverseBits", "round", "saturate", "sign", "sin", "sinh",
    "smoothstep", "sqrt", "step", "tan", "tanh", "transpose", "trunc",
    "dpdx", "dpdxCoarse", "dpdxFine", "dpdy", "dpdyCoarse", "dpdyFine", "fwidth", "fwidthCoarse", "fwidthFine",
];
