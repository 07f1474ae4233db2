//! GLSL through naga's front end to WGSL.

use super::compile::helped;
use super::emit::Emitted;
use super::error::SourceError;
use super::lexer::File;
use crate::shader::{Module, causes, narrowest};

/// What every text begins with: the version, and what naga's front end lacks.
///
/// A comparison, not the bits: in double precision the bits would be those of the number rounded.
pub(super) const PRELUDE: &str = "#version 450
bool checked_isnan(float x) { return !(x == x); }
bvec2 checked_isnan(vec2 x) { return bvec2(!(x.x == x.x), !(x.y == x.y)); }
bvec3 checked_isnan(vec3 x) { return bvec3(!(x.x == x.x), !(x.y == x.y), !(x.z == x.z)); }
bvec4 checked_isnan(vec4 x) { return bvec4(!(x.x == x.x), !(x.y == x.y), !(x.z == x.z), !(x.w == x.w)); }
bool checked_isinf(float x) { return abs(x) > 3.4028235e38; }
bvec2 checked_isinf(vec2 x) { return bvec2(checked_isinf(x.x), checked_isinf(x.y)); }
bvec3 checked_isinf(vec3 x) { return bvec3(checked_isinf(x.x), checked_isinf(x.y), checked_isinf(x.z)); }
bvec4 checked_isinf(vec4 x) { return bvec4(checked_isinf(x.xyz), checked_isinf(x.w)); }
";

/// The stack of the thread that parses: naga's front end takes several frames for each bracket.
const STACK: usize = 256 << 20;

/// A module of naga's, and what validation found.
pub(super) fn parse(emitted: &Emitted, files: &[File]) -> Result<(naga::Module, naga::valid::ModuleInfo), SourceError> {
    emitted.bounded(files)?;
    let text = emitted.text.clone();
    // naga's GLSL front end has panics that it does not mean to have; what panics there must not end the caller.
    let parsed = std::thread::Builder::new().stack_size(STACK).spawn(move || {
        let options = naga::front::glsl::Options::from(naga::ShaderStage::Compute);
        let parsed = naga::front::glsl::Frontend::default().parse(&options, &text);
        let mut module = match parsed {
            Ok(module) => module,
            Err(errors) => {
                let first = errors.errors.first();
                let message = first.map_or_else(|| errors.to_string(), |error| error.kind.to_string());
                return Err((message, first.and_then(|error| error.meta.to_range()).map(|range| range.start)));
            }
        };
        module.entry_points.clear();
        let mut validator =
            naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::all());
        match validator.validate(&module) {
            Ok(info) => Ok((module, info)),
            Err(error) => {
                let start = narrowest(&error).and_then(|span| span.to_range()).map(|range| range.start);
                Err((causes(error.as_inner()), start))
            }
        }
    });
    let file = files.first().map_or("", |file| &file.name);
    let parsed = parsed.map_err(|error| SourceError::of(file, format!("no thread for the compiler: {error}")))?;
    match parsed.join() {
        Ok(Ok(done)) => Ok(done),
        Ok(Err((message, start))) => Err(match start.and_then(|start| emitted.origin(start)) {
            Some(origin) => SourceError::at(files, origin, helped(&message)),
            None => SourceError::of(file, helped(&message)),
        }),
        Err(_) => Err(SourceError::of(file, "the GLSL compiler (naga) failed on this file")),
    }
}

/// The module as WGSL, valid.
pub(super) fn to_wgsl(
    module: &naga::Module,
    info: &naga::valid::ModuleInfo,
    file: &str,
) -> Result<String, SourceError> {
    let written = naga::back::wgsl::write_string(module, info, naga::back::wgsl::WriterFlags::empty());
    let text = written.map_err(|error| SourceError::of(file, format!("no WGSL can say this: {error}")))?;
    // naga writes WGSL that is not valid for some GLSL, `inout` on a component among it.
    Module::parse(&text).map_err(|error| {
        let what = format!(
            "naga translates this to WGSL that is not valid ({}); an `out` argument that is a component, such as `v.x`, \
             is a known cause: pass a variable",
            error.message()
        );
        SourceError::of(file, what)
    })?;
    Ok(text)
}
