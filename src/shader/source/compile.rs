//! A function and what it reaches, compiled: its signature, the values that it waits for, and the module.

use super::emit::Emitted;
use super::error::SourceError;
use super::items::{Item, ItemKind};
use super::lexer::{Kind, Token};
use super::reach::{Reached, reach};
use super::{Language, Source, glsl};
use crate::shader::signature::{Parameter, Type};
use crate::shader::{Module, ShaderError};
use std::collections::BTreeSet;

/// A function of a shader file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Its name.
    pub name: String,
    /// Its parameters.
    pub parameters: Vec<Parameter>,
    /// Whether each parameter is written to: `out` and `inout`, or a pointer.
    pub written: Vec<bool>,
    /// What it returns.
    pub result: Option<Type>,
}

/// A variable of the module that a pipeline would fill.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Input {
    /// Its name.
    pub name: String,
    /// Its type.
    pub ty: Type,
    /// It begins with a value, or may: a private variable, an `override` or uniform that states one.
    pub has_value: bool,
}

/// A function compiled alone.
#[derive(Debug)]
pub struct Compiled<'a> {
    source: &'a Source,
    emitted: Emitted,
    /// The function.
    pub entry: Entry,
    /// Its inputs beside the parameters.
    pub inputs: Vec<Input>,
    members: BTreeSet<String>,
}

impl Source {
    /// Compiles a function with all that it reaches.
    ///
    /// `function` is a name, or a name with the types of its parameters where there are several of that name:
    /// `F_Schlick(float, vec3)`. An `override` stays one, to be set, where `is_set` says so of its name; else it has its
    /// own value.
    ///
    /// # Errors
    /// No such function, or several; what the compiler refuses; a texture within reach; an import that is missing.
    pub fn compile(&self, function: &str, is_set: &dyn Fn(&str) -> bool) -> Result<Compiled<'_>, SourceError> {
        let (name, types) = match function.split_once('(') {
            Some((name, types)) => (name.trim(), Some(types.trim_end().trim_end_matches(')').to_owned())),
            None => (function.trim(), None),
        };
        let reached = reach(self, name)?;
        let mut emitted = Emitted::default();
        if self.language == Language::Glsl {
            emitted.raw(glsl::PRELUDE);
        } else {
            self.directives(&reached, &mut emitted);
        }
        self.emit(&reached, |item| edited(item, self.language, is_set), &mut emitted)?;
        let mut inputs: Vec<(String, bool)> = Vec::new();
        for id in &reached.items {
            let Some(item) = self.item(*id) else { continue };
            let prefix = self.units.get(id.0).map_or("", |unit| &unit.prefix);
            let states = item.tokens.iter().any(|token| token.is("="));
            let waits = match item.kind {
                ItemKind::Input => true,
                ItemKind::Override => is_open(item, is_set),
                // A private variable has a value, which may be set all the same.
                ItemKind::Plain => is_variable(item, self.language),
                _ => false,
            };
            let has_value = states || item.kind == ItemKind::Plain;
            if waits {
                inputs.extend(item.names.iter().map(|name| (format!("{prefix}{name}"), has_value)));
            }
        }
        let compiled = Compiled {
            source: self,
            emitted,
            entry: Entry { name: name.to_owned(), parameters: Vec::new(), written: Vec::new(), result: None },
            inputs: Vec::new(),
            members: reached.members.iter().map(|member| member.to_string()).collect(),
        };
        compiled.described(types.as_deref(), &inputs)
    }

    /// `enable f16` where the function needs it; other extensions change nothing that is evaluated.
    fn directives(&self, reached: &Reached, emitted: &mut Emitted) {
        let of_items = |id: &(usize, usize)| self.item(*id).map_or(&[][..], |item| &item.tokens);
        let half = |token: &Token| token.is("f16") || matches!(&*token.text, "vec2h" | "vec3h" | "vec4h");
        if reached.items.iter().flat_map(of_items).any(half) {
            emitted.raw("enable f16;\n");
        }
    }
}

fn is_open(item: &Item, is_set: &dyn Fn(&str) -> bool) -> bool {
    let typed = item.tokens.get(2).is_some_and(|colon| colon.is(":"));
    let states = item.tokens.iter().any(|token| token.is("="));
    typed && (!states || item.names.iter().any(|name| is_set(name)))
}

fn is_variable(item: &Item, language: Language) -> bool {
    let first = |text: &str| item.tokens.first().is_some_and(|first| first.is(text));
    match language {
        Language::Wgsl => first("var"),
        Language::Glsl => !first("const") && !first("struct") && !item.tokens.iter().any(|token| token.is("(")),
    }
}

/// What a declaration becomes for the compiler.
fn edited(item: &Item, language: Language, is_set: &dyn Fn(&str) -> bool) -> Vec<Token> {
    let mut tokens = item.tokens.clone();
    if language == Language::Glsl {
        for at in 0..tokens.len() {
            let is_call = tokens.get(at + 1).is_some_and(|open| open.is("("));
            if let Some(token) = tokens.get_mut(at)
                && is_call
                && (token.is("isnan") || token.is("isinf"))
            {
                token.text = format!("checked_{}", token.text).into();
            }
        }
        if item.kind == ItemKind::Function && tokens.first().is_some_and(|ty| ty.is("float")) {
            tokens = with_float_results(tokens);
        }
    }
    if item.kind == ItemKind::Override
        && let Some(keyword) = tokens.first().cloned()
    {
        if is_open(item, is_set) {
            let part = |text: &str, kind| Token { spaced: false, leads: false, ..Token::instead(text, kind, &keyword) };
            let space = [part("<", Kind::Sign), part("private", Kind::Word), part(">", Kind::Sign)];
            tokens.splice(0..1, [Token::instead("var", Kind::Word, &keyword)].into_iter().chain(space));
        } else {
            tokens.splice(0..1, [Token::instead("const", Kind::Word, &keyword)]);
        }
    }
    tokens
}

/// `return 1;` of a function that returns a float, as `return float(1);`: the conversion that naga leaves out.
fn with_float_results(tokens: Vec<Token>) -> Vec<Token> {
    let mut output: Vec<Token> = Vec::with_capacity(tokens.len());
    let mut at = 0;
    while let Some(token) = tokens.get(at) {
        at += 1;
        output.push(token.clone());
        let rest = tokens.get(at..).unwrap_or_default();
        let length = rest.iter().position(|token| token.is(";")).unwrap_or(0);
        let value = rest.get(..length).unwrap_or_default();
        let is_float = |token: &Token| token.kind == Kind::Number && token.text.contains(['.', 'e', 'E', 'f', 'F']);
        if token.is("return") && !value.is_empty() && !value.iter().any(is_float) {
            let part = |text: &str, kind| Token { spaced: true, leads: false, ..Token::instead(text, kind, token) };
            output.extend([part("float", Kind::Word), part("(", Kind::Sign)]);
            output.extend_from_slice(value);
            output.push(part(")", Kind::Sign));
            at += length;
        }
    }
    output
}

impl Compiled<'_> {
    /// Whether a member of this name is used anywhere that the function reaches.
    pub fn uses_member(&self, name: &str) -> bool {
        self.members.contains(name)
    }

    /// Whether the function does anything with a parameter of this name but declare it.
    pub fn reads(&self, parameter: &str) -> bool {
        let root = self.source.units.first().map_or(&[][..], |unit| &unit.items);
        let own = root.iter().filter(|item| item.kind == ItemKind::Function);
        let mut own = own.filter(|item| item.names.iter().any(|name| **name == *self.entry.name));
        own.any(|item| item.tokens.iter().filter(|token| token.is(parameter)).count() > 1)
    }

    /// Whether the opposite of a parameter of this name is taken somewhere, but for `reflect` and `refract`, which expect it.
    pub fn negates(&self, parameter: &str) -> bool {
        let root = self.source.units.first().map_or(&[][..], |unit| &unit.items);
        root.iter().any(|item| {
            let word = |at: usize, text: &str| item.tokens.get(at).is_some_and(|token| token.is(text));
            (3..item.tokens.len()).any(|at| {
                let opens = word(at - 2, "(") || word(at - 2, ",");
                let incident = word(at - 3, "reflect") || word(at - 3, "refract");
                word(at, parameter) && word(at - 1, "-") && opens && !incident
            })
        })
    }

    /// The language of the source, in which [`Compiled::with`] takes its text.
    pub fn language(&self) -> Language {
        self.source.language
    }

    /// The name of the source.
    pub fn name(&self) -> &str {
        self.source.name()
    }

    /// An error of the whole source.
    pub fn error(&self, message: impl Into<String>) -> SourceError {
        SourceError::of(self.source.name(), message)
    }

    /// The module as WGSL, with declarations added in the source's own language.
    ///
    /// # Errors
    /// What the compiler refuses, at its place; text that is not valid in addition to the source.
    pub fn with(&self, addition: &str) -> Result<String, SourceError> {
        let mut emitted = self.emitted.clone();
        emitted.raw(addition);
        match self.source.language {
            Language::Wgsl => {
                self.wgsl(&emitted)?;
                Ok(emitted.text)
            }
            Language::Glsl => {
                emitted.raw("\nvoid main() {}\n");
                let (module, info) = glsl::parse(&emitted, &self.source.files)?;
                glsl::to_wgsl(&module, &info, self.name())
            }
        }
    }

    fn wgsl(&self, emitted: &Emitted) -> Result<Module, SourceError> {
        let at = |error: ShaderError| {
            let offset = error.line().zip(error.column()).map(|(line, column)| {
                let before = emitted.text.split_inclusive('\n').take(line.saturating_sub(1) as usize);
                before.map(str::len).sum::<usize>() + column.saturating_sub(1) as usize
            });
            match offset.and_then(|offset| emitted.origin(offset)) {
                Some(origin) => SourceError::at(&self.source.files, origin, helped(error.message())),
                None => SourceError::of(self.name(), helped(error.message())),
            }
        };
        emitted.bounded(&self.source.files)?;
        Module::parse(&emitted.text).map_err(at)
    }

    /// Fills in what the compiler knows of the function and the inputs.
    fn described(mut self, types: Option<&str>, inputs: &[(String, bool)]) -> Result<Self, SourceError> {
        let module = match self.source.language {
            Language::Wgsl => self.wgsl(&self.emitted)?.ir,
            Language::Glsl => {
                let mut emitted = self.emitted.clone();
                emitted.raw("\nvoid main() {}\n");
                glsl::parse(&emitted, &self.source.files)?.0
            }
        };
        let language = self.source.language;
        let mut found: Vec<Entry> = Vec::new();
        let mut refused = None;
        for (_, function) in module.functions.iter().filter(|(_, f)| f.name.as_deref() == Some(&self.entry.name)) {
            match described(&module, function, &self.entry.name) {
                Ok(entry) => found.push(entry),
                Err(what) => refused = Some(what),
            }
        }
        let list = |entries: &[Entry]| entries.iter().map(|e| e.signature(language)).collect::<Vec<_>>().join("; ");
        if let Some(types) = types {
            let wanted: String = types.split_whitespace().collect();
            let all = found.clone();
            found.retain(|entry| {
                let types = entry.parameters.iter().map(|p| type_name(&p.ty, language));
                types.collect::<Vec<_>>().join(",") == wanted
            });
            if found.is_empty() {
                return Err(self.error(format!("no `{}({types})`: there is {}", self.entry.name, list(&all))));
            }
        }
        self.entry = match (found.len(), refused) {
            (1, _) => found.remove(0),
            (0, Some(what)) => return Err(self.error(what)),
            (0, None) => return Err(self.error(format!("no function `{}` is left by the compiler", self.entry.name))),
            (_, _) => {
                let message = format!(
                    "there are several `{0}`: {1}; choose one by its types, as `--fn \"{0}({2})\"`",
                    self.entry.name,
                    list(&found),
                    found.first().map_or(String::new(), |first| {
                        first.parameters.iter().map(|p| type_name(&p.ty, language)).collect::<Vec<_>>().join(", ")
                    })
                );
                return Err(self.error(message));
            }
        };
        for (name, has_value) in inputs {
            let variable = module.global_variables.iter().find(|(_, v)| v.name.as_deref() == Some(name));
            let Some((_, variable)) = variable else { continue };
            match Type::of(&module, variable.ty) {
                Ok(ty) => self.inputs.push(Input { name: name.clone(), ty, has_value: *has_value }),
                Err(_) if *has_value => {}
                Err(what) => {
                    let message =
                        format!("`{}` reaches the variable `{name}`, {what}, which has no value here", self.entry.name);
                    return Err(self.error(message));
                }
            }
        }
        Ok(self)
    }
}

/// A compiler's message, and what to do where a name is missing: engines put files together that do not name each other.
pub(super) fn helped(message: &str) -> String {
    let missing = ["Unknown function", "Unknown variable", "Unknown type", "no definition in scope"];
    if missing.into_iter().any(|start| message.starts_with(start)) {
        return format!(
            "{message}; if another file of the renderer has it, give a file of your own that says #include \"…\" for that \
             one and then for this one; a constant may be said by -D NAME=VALUE"
        );
    }
    message.to_owned()
}

fn described(module: &naga::Module, function: &naga::Function, name: &str) -> Result<Entry, String> {
    let (mut parameters, mut written) = (Vec::new(), Vec::new());
    for (index, argument) in function.arguments.iter().enumerate() {
        let own = argument.name.clone().unwrap_or_else(|| format!("argument{index}"));
        let (ty, is_pointer) = match module.types[argument.ty].inner {
            naga::TypeInner::Pointer { base, space: naga::AddressSpace::Function } => (Type::of(module, base), true),
            naga::TypeInner::ValuePointer { size, scalar, space: naga::AddressSpace::Function } => {
                (Type::of_value(size, scalar), true)
            }
            _ => (Type::of(module, argument.ty), false),
        };
        let ty = ty.map_err(|what| {
            format!(
                "the parameter `{own}` of `{name}` is {what}: values of 32 bits and what is made of them can be given"
            )
        })?;
        parameters.push(Parameter { name: own, ty });
        written.push(is_pointer);
    }
    let result = match &function.result {
        Some(result) => Some(Type::of(module, result.ty).map_err(|what| format!("`{name}` returns {what}"))?),
        None => None,
    };
    Ok(Entry { name: name.to_owned(), parameters, written, result })
}

impl Entry {
    /// The declaration as the language writes it.
    pub fn signature(&self, language: Language) -> String {
        let name = |ty: &Type| type_name(ty, language);
        let parameters: Vec<String> = self
            .parameters
            .iter()
            .zip(&self.written)
            .map(|(parameter, written)| match (language, written) {
                (Language::Wgsl, false) => format!("{}: {}", parameter.name, name(&parameter.ty)),
                (Language::Wgsl, true) => format!("{}: ptr<function, {}>", parameter.name, name(&parameter.ty)),
                (Language::Glsl, false) => format!("{} {}", name(&parameter.ty), parameter.name),
                (Language::Glsl, true) => format!("inout {} {}", name(&parameter.ty), parameter.name),
            })
            .collect();
        let (own, parameters) = (&self.name, parameters.join(", "));
        match (language, &self.result) {
            (Language::Wgsl, None) => format!("fn {own}({parameters})"),
            (Language::Wgsl, Some(result)) => format!("fn {own}({parameters}) -> {}", name(result)),
            (Language::Glsl, None) => format!("void {own}({parameters})"),
            (Language::Glsl, Some(result)) => format!("{} {own}({parameters})", name(result)),
        }
    }
}

/// A type's name in a language.
pub(crate) fn type_name(ty: &Type, language: Language) -> String {
    use crate::shader::Scalar;
    if language == Language::Wgsl {
        return ty.to_string();
    }
    match ty {
        Type::Scalar(Scalar::F32) => "float".to_owned(),
        Type::Scalar(Scalar::I32) => "int".to_owned(),
        Type::Scalar(Scalar::U32) => "uint".to_owned(),
        Type::Scalar(Scalar::Bool) => "bool".to_owned(),
        Type::Vector { size, scalar } => {
            let kind = match scalar {
                Scalar::F32 => "",
                Scalar::I32 => "i",
                Scalar::U32 => "u",
                Scalar::Bool => "b",
            };
            format!("{kind}vec{size}")
        }
        Type::Matrix { columns, rows } if columns == rows => format!("mat{columns}"),
        Type::Matrix { columns, rows } => format!("mat{columns}x{rows}"),
        Type::Array { element, length } => format!("{}[{length}]", type_name(element, language)),
        Type::Struct { name, .. } => name.clone(),
    }
}
