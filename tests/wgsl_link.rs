//! What the linker writes is WGSL: naga reads and validates it.
#![cfg(feature = "shader")]

use brdf::wgsl::{functions, link, link_function, link_with};
use naga::valid::{Capabilities, ValidationFlags, Validator};

fn validate(source: &str) -> naga::Module {
    let module =
        naga::front::wgsl::parse_str(source).unwrap_or_else(|e| panic!("{}\n{source}", e.emit_to_string(source)));
    Validator::new(ValidationFlags::all(), Capabilities::all())
        .validate(&module)
        .unwrap_or_else(|e| panic!("{}\n{source}", e.emit_to_string(source)));
    module
}

const MODULES: &[(&str, &str)] = &[
    (
        "real",
        "const TINY: f32 = 1e-8;
const_assert TINY < 1.0;
alias Rgb = array<vec3<f32>, 2>;
fn squared(x: f32) -> f32 { return x * x; }
fn unused(x: f32) -> f32 { return undefined(x); }
",
    ),
    (
        "fresnel",
        "import package::real::{squared, Rgb};
struct Fresnel { squared: f32, rest: Rgb, }
/// Names a parameter and a local like items.
fn dielectric(c: f32, real: f32) -> Fresnel {
    let squared = squared(c) + super::real::TINY;
    var sum = 0.0;
    for (var dielectric = 0u; dielectric < 3u; dielectric++) { sum += f32(dielectric >> 1u); }
    return Fresnel(squared * real + sum, Rgb(vec3<f32>(c), vec3f(layer(c))));
}
",
    ),
];

#[test]
fn linked_shaders_validate() {
    let root = "// Evaluates in place.
import brdf::fresnel::{self_test as _t};
";
    assert!(link_with(MODULES, root).unwrap_err().to_string().starts_with("root:2:24: no item `self_test`"));

    let root = "// Evaluates in place.
import brdf::{fresnel, real::squared as sq};
diagnostic(off, derivative_uniformity);

@group(0) @binding(0) var<storage, read_write> data: array<f32>;
override gain: f32 = 1.0;
struct Mine { fresnel_Fresnel: fresnel::Fresnel }

fn layer(c: f32) -> f32 { return c; }

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let mine = Mine(fresnel::dielectric(data[id.x], 1.5)); /* fresnel::dielectric /* nested */ */
    data[id.x] = gain * sq(mine.fresnel_Fresnel.squared) + brdf::real::TINY;
}
";
    let linked = link_with(MODULES, root).unwrap();
    assert!(
        linked.starts_with("// Evaluates in place.\ndiagnostic(off, derivative_uniformity);\n\nconst real_TINY"),
        "{linked}"
    );
    let module = validate(&linked);
    let mut names: Vec<_> = module.functions.iter().filter_map(|(_, f)| f.name.as_deref()).collect();
    names.sort_unstable();
    assert_eq!(names, ["fresnel_dielectric", "layer", "real_squared"]);
    assert_eq!(module.entry_points[0].name, "main");
}

#[test]
fn a_shader_without_imports_is_untouched() {
    let root = "@fragment fn main() -> @location(0) vec4<f32> { return vec4f(1.0); }";
    assert_eq!(link(root).unwrap(), root);
    validate(root);
}

/// Every function of the library by itself, with what the embedding shader must supply.
#[test]
fn the_librarys_functions_validate() {
    for function in functions() {
        let mut linked = link_function(function.module, function.name).unwrap();
        if linked.contains("stack_layer(") {
            linked += "fn stack_layer(index: u32) -> layered_Layer { var none: layered_Layer; return none; }";
        }
        if linked.contains("coupled_row(") {
            linked += "fn coupled_row(index: u32) -> vec4f { return vec4f(0.0, 0.0, 0.0, 0.0); }";
        }
        if linked.contains("fresnel_texel(") {
            linked += "fn fresnel_texel(column: u32, row: u32) -> vec3f { return vec3f(0.0, 0.0, 0.0); }";
        }
        if linked.contains("distribution_texel(") {
            linked += "fn distribution_texel(column: u32, row: u32) -> f32 { return 0.0; }";
        }
        if linked.contains("material_texel(") {
            linked += "fn material_texel(index: u32) -> vec4f { return vec4f(0.0, 0.0, 0.0, 0.0); }";
        }
        if linked.contains("ramp_stop(") {
            linked += "fn ramp_stop(index: u32) -> vec4f { return vec4f(0.0, 0.0, 0.0, 0.0); }";
        }
        validate(&linked);
    }
}
