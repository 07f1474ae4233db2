//! Shader files of others, in WGSL or GLSL, made into one valid WGSL module with what a single function needs.
//!
//! [`Source::load`] reads a file as its renderer would: conditionals, macros, includes and imports are resolved. Of what
//! is left, [`Source::compile`] keeps the function and all that it reaches, so that textures, stage inputs and entry
//! points elsewhere in the file do not matter, and puts it through the compiler. Every [`SourceError`] names file, line and column
//! of the text as written, also within includes and behind macros.
//!
//! What only a pipeline could supply becomes a private global ([`Compiled::inputs`]): uniforms, varyings, overrides
//! without a value. A texture that the function reaches is refused by name.

mod compile;
mod condition;
mod emit;
mod error;
mod features;
mod glsl;
mod imports;
mod items;
mod lexer;
mod macros;
mod preprocess;
mod reach;

#[cfg(feature = "check")]
pub(crate) use compile::type_name;
pub use compile::{Compiled, Entry, Input};
pub use error::{Place, SourceError};

use core::fmt;
use std::path::PathBuf;

/// A language that shaders are read in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Language {
    /// WGSL, with WESL's or naga_oil's imports and `#` directives.
    Wgsl,
    /// GLSL 4.50 and what WebGL's versions share with it.
    Glsl,
}

impl fmt::Display for Language {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Language::Wgsl => "WGSL",
            Language::Glsl => "GLSL",
        })
    }
}

/// The language that a text is written in, by its content; none if it has no function of either.
pub fn sniff(text: &str) -> Option<Language> {
    let words = lexer::words(text);
    let word = |at: usize| words.get(at).map_or("", |word| &**word);
    for at in 0..words.len() {
        // `fn name(`: no GLSL declaration puts two names before a parenthesis of which the first is `fn`.
        if word(at) == "fn" && word(at + 2) == "(" && lexer::is_name(word(at + 1)) {
            return Some(Language::Wgsl);
        }
        let is_type = |word: &str| {
            matches!(word, "void" | "float" | "int" | "bool" | "uint" | "double")
                || word.strip_prefix("vec").is_some_and(|size| matches!(size, "2" | "3" | "4"))
        };
        if (is_type(word(at)) || lexer::is_name(word(at))) && word(at + 2) == "(" && lexer::is_name(word(at + 1)) {
            let is_statement = matches!(word(at), "return" | "else" | "let" | "var" | "const" | "define" | "in");
            if is_type(word(at)) || (!is_statement && is_type(word(at + 3))) {
                return Some(Language::Glsl);
            }
        }
    }
    None
}

/// Where a source's includes and imports are looked for, and the macros that it starts with.
#[derive(Clone, Debug, Default)]
pub struct Environment {
    /// Directories, in order. The directory of the including file comes first.
    pub include: Vec<PathBuf>,
    /// `NAME` or `NAME=VALUE`.
    pub defines: Vec<String>,
}

/// A shader file with everything that it includes, preprocessed.
#[derive(Debug)]
pub struct Source {
    language: Language,
    files: Vec<lexer::File>,
    /// The file itself, then the modules that it imports.
    units: Vec<imports::Unit>,
}

impl Source {
    /// Preprocesses a text. `name` is what errors call it: its path, if it has one.
    ///
    /// # Errors
    /// A directive, include, macro or import that cannot be followed, with its place.
    pub fn load(name: &str, text: &str, language: Language, environment: &Environment) -> Result<Self, SourceError> {
        let mut files = Vec::new();
        let units = imports::load(name, text, language, environment, &mut files)?;
        Ok(Source { language, files, units })
    }

    /// The language that it is read in.
    pub fn language(&self) -> Language {
        self.language
    }
}
