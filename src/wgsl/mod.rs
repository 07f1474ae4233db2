//! The WGSL twins, and the linker that puts them into a shader.
//!
//! Every function of the crate's terms has a twin in `wgsl/`: the same name, the same order of parameters, in the file
//! of the same name. The twins are plain functions, without bindings or entry points. [`link`] takes a shader that
//! imports them and returns plain WGSL with the functions that it needs, and only those.
//!
//! # Imports
//!
//! WESL's syntax, before the first declaration; in the modules themselves `package::` (or `super::`) takes the place of
//! `brdf::`.
//!
//! ```wgsl
//! import brdf::fresnel;                                   // fresnel::dielectric(c, eta), fresnel::Fresnel
//! import brdf::fresnel::dielectric;                       // dielectric(c, eta)
//! import brdf::fresnel::{dielectric, conductor as metal};
//! import brdf::{fresnel, masking::v_cavity};
//! ```
//!
//! A full path, `brdf::fresnel::dielectric(c, eta)`, needs no import.
//!
//! # What linking does
//!
//! * The shader's own items stay as they are, in their order; `enable`, `requires` and `diagnostic` stay on top.
//! * An item of the library appears as `module_item` ([`mangled`]), with the comment lines directly above it. Where
//!   that is a name that the shader uses too, linking fails. So it does where the shader redefines a builtin function
//!   or type that the linked functions call.
//! * Scopes are respected, not renamed: a parameter or local that has an item's name hides the item from there to the
//!   end of its block, as WGSL has it. Members, whether declared or accessed, are never renamed.
//! * A name that a module neither declares nor imports is left alone: a builtin, or a function that the embedding
//!   shader supplies.
//! * An item whose name begins with `_` is private to the library.
//! * A module's `const_assert`s come along with any of its items.
//! * Equal inputs give equal text: modules follow those that they need and are else in alphabetical order, items are in
//!   source order.
//!
//! # Rules for the modules
//!
//! No `var`, `override`, directive or entry point (refused); no `pow` and no trigonometry, whose accuracy WGSL leaves
//! open. No name of an item or a member ends in a digit: naga appends `_` to those (`f0` becomes `f0_`) in what it
//! writes.

mod error;
mod link;
#[cfg(feature = "std")]
mod material;
mod names;
mod specialise;
pub(crate) mod token;
mod unit;

#[cfg(test)]
mod tests;

pub use error::LinkError;
pub use link::mangled;
#[cfg(feature = "std")]
pub use material::{NoTwin, material};
pub use specialise::{identifier, specialise, specialise_scene};

use alloc::string::String;
use unit::{Kind, Unit};

macro_rules! modules {
    ($($name:literal),* $(,)?) => {
        &[$(($name, include_str!(concat!("../../wgsl/", $name, ".wgsl")))),*]
    };
}

/// The library's modules: each one's name and its text.
#[rustfmt::skip]
pub const MODULES: &[(&str, &str)] = modules![
    "absorption", "brushed", "bump", "diffuse", "distribution", "flake", "fresnel", "fresnel_fit", "glint", "image", "kubelka_munk", "layered",
    "mask", "masking", "microfacet", "noise", "patina", "phong", "ramp", "random", "real", "refraction", "sampling", "scratch", "table",
    "walk",
];

/// The text of one module, as written: with its imports.
pub fn source(module: &str) -> Option<&'static str> {
    MODULES.iter().find(|(name, _)| *name == module).map(|(_, text)| *text)
}

/// A function of the library, as [`functions`] lists them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Function {
    /// The module that declares it.
    pub module: &'static str,
    /// Its name there.
    pub name: &'static str,
    /// How many parameters it has.
    pub parameters: usize,
}

/// Every public function of the library: module by module, in source order.
pub fn functions() -> impl Iterator<Item = Function> {
    MODULES.iter().flat_map(|&(module, text)| functions_of(module, text))
}

fn functions_of(module: &'static str, text: &'static str) -> impl Iterator<Item = Function> {
    let items = Unit::parse(Some(module), text).map(|unit| unit.items).unwrap_or_default();
    items
        .into_iter()
        .filter(|item| item.kind == Kind::Function && !item.is_entry_point && !item.name.starts_with('_'))
        .map(move |item| Function { module, name: item.name, parameters: item.parameters })
}

/// Links a shader with the items of the library that it imports: plain WGSL, the library's part first.
///
/// The [module's documentation](self) says which imports there are and what becomes of names.
///
/// # Errors
///
/// Where an import or a path names nothing, comes too late, or brings in a name that is already taken; where a name of
/// the linked library collides with one of the shader; and where the text is not WGSL enough to tell its declarations
/// apart.
pub fn link(root: &str) -> Result<String, LinkError> {
    link::link(MODULES, root)
}

/// Links a shader as [`link`] does, with other modules in place of [`MODULES`]: a name and a text each.
///
/// For modules of one's own beside the library's, or instead of them. Their package is `brdf` all the same.
///
/// ```
/// let modules = [("numbers", "// x·x.\nfn squared(x: f32) -> f32 { return x * x; }\nfn unused() {}\n")];
/// let root = "import brdf::numbers;\nfn fourth(x: f32) -> f32 { return numbers::squared(numbers::squared(x)); }\n";
/// assert_eq!(
///     brdf::wgsl::link_with(&modules, root)?,
///     "// x·x.\nfn numbers_squared(x: f32) -> f32 { return x * x; }\n\n\
///      fn fourth(x: f32) -> f32 { return numbers_squared(numbers_squared(x)); }\n",
/// );
/// # Ok::<(), brdf::wgsl::LinkError>(())
/// ```
///
/// # Errors
///
/// As [`link`], and where a module breaks the [rules for modules](self#rules-for-the-modules).
pub fn link_with(modules: &[(&str, &str)], root: &str) -> Result<String, LinkError> {
    link::link(modules, root)
}

/// One item of the library with everything that it needs, under their [`mangled`] names.
///
/// # Errors
///
/// Where there is no such module or item.
pub fn link_function(module: &str, item: &str) -> Result<String, LinkError> {
    link::link_item(MODULES, module, item)
}
