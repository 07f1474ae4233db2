//! The shader of a `.brdf` file through naga: GLSL, its intermediate form, WGSL, and that evaluated.
//!
//! The parameters are declared as private globals in front of the shader, and a function of directions and numbers, after
//! it, sets them and calls `BRDF`: as uniforms no file could assign them, and bools could not be uniforms at all.

use super::ExplorerError;
use super::grammar::{File, Kind};
use crate::shader::interp::{Program, Shader, bounded};
use core::fmt::Write;
use naga::ShaderStage;
use naga::front::glsl::{Frontend, Options};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The function that the evaluator calls.
const ENTRY: &str = "explorer_subject";
/// Braces within braces that a shader may have: naga takes frames of the stack for each.
const MOST_BLOCKS: usize = 64;

/// A shader that can be evaluated.
pub(super) struct Translated {
    pub(super) double: Program<f64>,
    pub(super) single: Program<f32>,
    pub(super) wgsl: String,
}

pub(super) fn translate(file: &File) -> Result<Translated, ExplorerError> {
    bounded(&file.shader).map_err(|error| ExplorerError::plain(error.to_string()))?;
    if let Some(line) = nested(&file.shader) {
        return Err(ExplorerError::at(line, format!("more than {MOST_BLOCKS} blocks within each other")));
    }
    let glsl = surrounded(file);
    // naga is not written for text that is hostile: some of it ends in a panic.
    let wgsl = catch_unwind(AssertUnwindSafe(|| to_wgsl(&glsl, file)))
        .unwrap_or_else(|_| Err(ExplorerError::plain("the GLSL compiler broke down over the shader")))?;
    let unusable = |error: &dyn core::fmt::Display| ExplorerError::plain(format!("the shader as WGSL: {error}"));
    let double = Shader::in_double(&wgsl).map_err(|error| unusable(&error))?;
    let single = Shader::parse(&wgsl).map_err(|error| unusable(&error))?;
    Ok(Translated {
        double: Program::new(&double, ENTRY).map_err(|error| unusable(&error))?,
        single: Program::new(&single, ENTRY).map_err(|error| unusable(&error))?,
        wgsl,
    })
}

/// The shader with its parameters declared in its first line, which is the file's and empty, and the entry after it.
fn surrounded(file: &File) -> String {
    let (mut globals, mut arguments, mut set) = (String::new(), String::new(), String::new());
    let mut count = 0;
    for declared in &file.parameters {
        let name = &declared.name;
        let mut argument = || {
            count += 1;
            arguments.push_str(&format!(", float explorer_value{count}"));
            format!("explorer_value{count}")
        };
        let (ty, value) = match declared.kind {
            Kind::Float { .. } => ("float", argument()),
            Kind::Bool(_) => ("bool", format!("{} != 0.0", argument())),
            Kind::Color(_) => ("vec3", format!("vec3({}, {}, {})", argument(), argument(), argument())),
        };
        let _ = write!(globals, "{ty} {name}; ");
        let _ = write!(set, "{name} = {value}; ");
    }
    let frame = "vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0)";
    format!(
        "{globals}{shader}vec3 {ENTRY}(vec3 explorer_light, vec3 explorer_view{arguments}) {{ {set}return \
         BRDF(explorer_light, explorer_view, {frame}); }}\nvoid main() {{}}\n",
        shader = file.shader,
    )
}

fn to_wgsl(glsl: &str, file: &File) -> Result<String, ExplorerError> {
    let last = file.shader.lines().count();
    let line_of = |span: naga::Span| {
        let start = span.to_range().map_or(0, |range| range.start);
        1 + glsl.bytes().take(start).filter(|byte| *byte == b'\n').count()
    };
    let place = |span: naga::Span, message: String| match line_of(span) {
        line if line > last => ExplorerError::plain(format!(
            "the shader does not fit `vec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y)`: {message}"
        )),
        line => ExplorerError::at(line, message),
    };
    let module = Frontend::default().parse(&Options::from(ShaderStage::Compute), glsl).map_err(|errors| {
        errors.errors.first().map_or_else(
            || ExplorerError::plain("the shader is no GLSL"),
            |error| place(error.meta, error.kind.to_string()),
        )
    })?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::default()).validate(&module).map_err(|error| {
        let mut message = error.as_inner().to_string();
        let mut cause = std::error::Error::source(error.as_inner());
        while let Some(next) = cause {
            let _ = write!(message, ": {next}");
            cause = next.source();
        }
        if message.contains("does not match the declared return type") {
            message.push_str("; of a float function a whole number is returned as one too: write 1.0 for 1");
        }
        match error.spans().next() {
            Some((span, _)) => place(*span, message),
            None => ExplorerError::plain(message),
        }
    })?;
    naga::back::wgsl::write_string(&module, &info, naga::back::wgsl::WriterFlags::empty())
        .map_err(|error| ExplorerError::plain(format!("the shader has no form in WGSL: {error}")))
}

/// The line where blocks nest too deep.
fn nested(shader: &str) -> Option<usize> {
    let mut depth = 0usize;
    for (index, line) in shader.lines().enumerate() {
        for byte in line.bytes() {
            match byte {
                b'{' => depth += 1,
                b'}' => depth = depth.saturating_sub(1),
                _ => {}
            }
            if depth > MOST_BLOCKS {
                return Some(index + 1);
            }
        }
    }
    None
}
