//! WGSL modules as values: parsed, validated, and asked what their functions take and return.
//!
//! [`Module::parse`] checks a module with naga; [`Module::function`] gives the [`Signature`] of one of its functions, with
//! every type flattened to 32-bit words; [`map_kernel`] writes the compute entry point that maps such a function over rows
//! of words. Nothing here needs an adapter.

mod count;
pub mod interp;
mod kernel;
mod signature;
pub mod source;

pub use crate::wgsl::{specialise, specialise_scene};
pub use count::Counts;
pub use kernel::{STORAGE_BINDING, map_kernel};
pub use signature::{Leaf, Member, Parameter, Scalar, Signature, Type};

use core::fmt;
use std::error::Error;

/// A WGSL module that naga has parsed and found valid.
///
/// A library without entry points is a module too. What a device must support to run it is not asked here: a module with
/// textures, `f16` or `f64` parses.
#[derive(Clone, Debug)]
pub struct Module {
    ir: naga::Module,
    info: naga::valid::ModuleInfo,
}

impl Module {
    /// Parses and validates WGSL.
    ///
    /// # Errors
    /// naga's message, with the line and column that it blames.
    pub fn parse(source: &str) -> Result<Self, ShaderError> {
        let ir = naga::front::wgsl::parse_str(source).map_err(|error| ShaderError {
            message: error.message().to_owned(),
            place: error.location(source).map(|place| (place.line_number, place.line_position)),
            report: error.emit_to_string(source),
        })?;
        let mut validator =
            naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::all());
        let info = validator.validate(&ir).map_err(|error| ShaderError {
            message: causes(error.as_inner()),
            place: narrowest(&error).map(|span| {
                let place = span.location(source);
                (place.line_number, place.line_position)
            }),
            report: error.emit_to_string(source),
        })?;
        Ok(Module { ir, info })
    }

    /// The names of the module's functions, entry points excluded, in the order of their dependencies.
    pub fn functions(&self) -> impl Iterator<Item = &str> {
        self.ir.functions.iter().filter_map(|(_, function)| function.name.as_deref())
    }

    /// What the function of this name takes and returns.
    ///
    /// # Errors
    /// No function of that name, which lists those that are there; or a parameter or result whose type is not made of
    /// 32-bit scalars (pointers, textures, `f16`, `f64`, atomics, runtime-sized arrays), which names the parameter.
    pub fn function(&self, name: &str) -> Result<Signature, ShaderError> {
        let found = self.ir.functions.iter().find(|(_, function)| function.name.as_deref() == Some(name));
        match found {
            Some((_, function)) => Signature::of(&self.ir, name, function).map_err(ShaderError::plain),
            None if self.ir.entry_points.iter().any(|entry| entry.name == name) => Err(ShaderError::plain(format!(
                "`{name}` is an entry point: name a plain function, one that takes values and returns one"
            ))),
            None => {
                let names: Vec<_> = self.functions().collect();
                Err(ShaderError::plain(match names.as_slice() {
                    [] => format!("no function `{name}`: the module defines none"),
                    names => format!("no function `{name}`: the module defines {}", names.join(", ")),
                }))
            }
        }
    }

    /// The bindings of a group at which the module declares global variables, in ascending order.
    pub fn bindings(&self, group: u32) -> Vec<u32> {
        let bound = self.ir.global_variables.iter().filter_map(|(_, variable)| variable.binding);
        let mut found: Vec<_> = bound.filter(|bound| bound.group == group).map(|bound| bound.binding).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The module in naga's intermediate representation.
    pub fn ir(&self) -> &naga::Module {
        &self.ir
    }

    /// What naga's validation found out about the module: types of expressions, uses of globals.
    pub fn info(&self) -> &naga::valid::ModuleInfo {
        &self.info
    }
}

/// Why a WGSL module or one of its functions cannot be used.
///
/// Displays as one line, `line 3, column 12: no definition in scope for identifier: …`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShaderError {
    message: String,
    place: Option<(u32, u32)>,
    report: String,
}

impl ShaderError {
    pub(crate) fn plain(message: String) -> Self {
        ShaderError { report: message.clone(), message, place: None }
    }

    /// What is wrong, without the place.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// The line blamed, from 1.
    pub fn line(&self) -> Option<u32> {
        self.place.map(|(line, _)| line)
    }

    /// The column blamed, from 1, in bytes.
    pub fn column(&self) -> Option<u32> {
        self.place.map(|(_, column)| column)
    }

    /// The message over several lines, with the source lines blamed and the notes that naga adds.
    pub fn report(&self) -> &str {
        &self.report
    }
}

impl fmt::Display for ShaderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.place {
            Some((line, column)) => write!(f, "line {line}, column {column}: {}", self.message),
            None => f.write_str(&self.message),
        }
    }
}

impl Error for ShaderError {}

/// The shortest part of the source that an error of validation speaks of: the expression, not the function around it.
fn narrowest<E>(error: &naga::WithSpan<E>) -> Option<naga::Span> {
    let spans = error.spans().filter_map(|(span, _)| Some((span.to_range()?.len(), *span)));
    spans.min_by_key(|(length, _)| *length).map(|(_, span)| span)
}

/// An error and its chain of causes on one line.
fn causes(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut next = error.source();
    while let Some(cause) = next {
        text.push_str(": ");
        text.push_str(&cause.to_string());
        next = cause.source();
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_say_where() {
        let error =
            Module::parse("fn one() -> f32 {\n    return 1.0;\n}\nfn two() -> f32 { return thre(); }").unwrap_err();
        assert_eq!(error.line(), Some(4), "{error}");
        assert!(error.to_string().starts_with("line 4, column 26: "), "{error}");
        assert!(error.to_string().contains("thre"), "{error}");
        assert!(error.report().contains("fn two()"), "{}", error.report());

        // Parses, and fails in validation.
        let error = Module::parse("fn one(x: f32) -> f32 {\n    if x > 0.0 { return 1.0; }\n}").unwrap_err();
        assert!(error.line().is_some(), "{error}");
        assert!(error.to_string().contains("one"), "{error}");
        assert_eq!(error.to_string().lines().count(), 1, "{error}");
    }

    #[test]
    fn missing_functions_name_those_there() {
        let module = Module::parse("fn schlick(x: f32) -> f32 { return x; } @compute @workgroup_size(1) fn main() {}");
        let module = module.unwrap();
        assert_eq!(module.functions().collect::<Vec<_>>(), ["schlick"]);
        let error = module.function("shlick").unwrap_err().to_string();
        assert_eq!(error, "no function `shlick`: the module defines schlick");
        assert!(module.function("main").unwrap_err().to_string().contains("entry point"));
        assert!(Module::parse("").unwrap().function("f").unwrap_err().to_string().contains("defines none"));
    }

    #[test]
    fn bindings_are_found() {
        let module = Module::parse("@group(0) @binding(3) var<storage, read> layers: array<f32>;").unwrap();
        assert_eq!(module.bindings(0), [3]);
        assert!(module.bindings(1).is_empty());
    }
}
