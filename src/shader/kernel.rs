//! The compute entry point that maps a function over rows of words.
//!
//! | binding (group 0) | what |
//! |---|---|
//! | 0 | `storage, read`: the arguments, [`Signature::input_words`] words a row |
//! | 1 | `storage, read_write`: the results, [`Signature::output_words`] words a row |
//! | 2 | `uniform vec4<u32>`: the number of rows; the number of invocations along x, the workgroup size included |
//! | 3… | whatever the caller's `bindings` declare there: read-only storage buffers |
//!
//! Rows run along x first and continue along y, so that more than 65535 workgroups fit in one dispatch.

use super::signature::{Scalar, Signature, Type};
use core::fmt::Write;

/// The first binding in group 0 that is left to the module: the read-only storage buffers of [`map_kernel`]'s `bindings`.
pub const STORAGE_BINDING: u32 = 3;

/// A WGSL module: the source, then `bindings`, then the entry point `brdf_map`, which maps a function over rows of words.
///
/// `bindings` is WGSL that completes the source, such as the function `stack_layer` that the layered twins call and the
/// storage buffer that it reads; empty where nothing is missing. The source comes first, so that line numbers in messages
/// are those of the source. The function must return a value; the module's own names must not start with `brdf_`.
pub fn map_kernel(module_source: &str, signature: &Signature, bindings: &str, workgroup_size: u32) -> String {
    let mut word = 0;
    let arguments: Vec<_> = signature.parameters.iter().map(|parameter| construct(&parameter.ty, &mut word)).collect();
    let mut results = String::new();
    let outputs = signature.result.as_ref().map(|result| result.leaves("brdf_value")).unwrap_or_default();
    for (index, leaf) in outputs.iter().enumerate() {
        let value = match leaf.scalar {
            Scalar::U32 => leaf.name.clone(),
            Scalar::Bool => format!("select(0u, 1u, {})", leaf.name),
            Scalar::F32 | Scalar::I32 => format!("bitcast<u32>({})", leaf.name),
        };
        // Writing to a String cannot fail.
        let _ = writeln!(results, "    brdf_outputs[brdf_out + {index}u] = {value};");
    }
    format!(
        "{module_source}
{bindings}
@group(0) @binding(0) var<storage, read> brdf_inputs: array<u32>;
@group(0) @binding(1) var<storage, read_write> brdf_outputs: array<u32>;
@group(0) @binding(2) var<uniform> brdf_rows: vec4<u32>;

@compute @workgroup_size({workgroup_size})
fn brdf_map(@builtin(global_invocation_id) brdf_id: vec3<u32>) {{
    let brdf_row = brdf_id.y * brdf_rows.y + brdf_id.x;
    if brdf_row >= brdf_rows.x {{
        return;
    }}
    let brdf_in = brdf_row * {inputs}u;
    let brdf_out = brdf_row * {outputs}u;
    let brdf_value = {name}({arguments});
{results}}}
",
        inputs = signature.input_words(),
        outputs = signature.output_words(),
        name = signature.name,
        arguments = arguments.join(", "),
    )
}

/// The expression that builds a value from the words of a row, starting at `word`.
fn construct(ty: &Type, word: &mut usize) -> String {
    let mut scalar = |scalar: Scalar| {
        let read = format!("brdf_inputs[brdf_in + {word}u]");
        *word += 1;
        match scalar {
            Scalar::U32 => read,
            Scalar::Bool => format!("({read} != 0u)"),
            Scalar::F32 | Scalar::I32 => format!("bitcast<{scalar}>({read})"),
        }
    };
    let parts: Vec<String> = match ty {
        Type::Scalar(kind) => return scalar(*kind),
        Type::Vector { size, scalar: kind } => (0..*size).map(|_| scalar(*kind)).collect(),
        Type::Matrix { columns, rows } => (0..columns * rows).map(|_| scalar(Scalar::F32)).collect(),
        Type::Array { element, length } => (0..*length).map(|_| construct(element, word)).collect(),
        Type::Struct { members, .. } => members.iter().map(|member| construct(&member.ty, word)).collect(),
    };
    format!("{ty}({})", parts.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::Module;

    #[test]
    fn kernels_are_valid_modules() {
        let source = "
            struct Layer { alpha: f32, k: vec3<f32>, on: bool, m: array<mat2x3<f32>, 2> }
            fn f(c: f32, l: Layer, i: vec2<i32>) -> Layer { return l; }
            fn g(index: u32) -> f32 { return stack_layer(index); }";
        let bindings = "@group(0) @binding(3) var<storage, read> stack_layers: array<f32>;
            fn stack_layer(i: u32) -> f32 { return stack_layers[i]; }";
        let module = Module::parse(&format!("{source}\n{bindings}")).unwrap();
        for name in ["f", "g"] {
            let kernel = map_kernel(source, &module.function(name).unwrap(), bindings, 64);
            let parsed = Module::parse(&kernel).map_err(|error| error.report().to_owned()).unwrap();
            assert_eq!(parsed.ir().entry_points.len(), 1);
        }
    }

    #[test]
    fn rows_are_read_in_order() {
        let module = Module::parse("fn f(a: vec2<f32>, b: bool, c: i32) -> bool { return b; }").unwrap();
        let kernel = map_kernel("", &module.function("f").unwrap(), "", 64);
        let call = "f(vec2<f32>(bitcast<f32>(brdf_inputs[brdf_in + 0u]), bitcast<f32>(brdf_inputs[brdf_in + 1u])), \
                    (brdf_inputs[brdf_in + 2u] != 0u), bitcast<i32>(brdf_inputs[brdf_in + 3u]))";
        assert!(kernel.contains(call), "{kernel}");
        assert!(kernel.contains("brdf_outputs[brdf_out + 0u] = select(0u, 1u, brdf_value);"), "{kernel}");
    }
}
