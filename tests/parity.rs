//! The WGSL twins against the Rust functions, on every adapter.
#![cfg(feature = "gpu")]

mod adapters;

use adapters::adapters_for_tests;
use brdf::parity::{compare, compare_source, compare_stack, twins};
use brdf::wgsl;

/// Inputs per function: a quarter of them corners.
const SAMPLES: usize = 4_000;

#[test]
fn every_public_wgsl_function_has_a_twin_of_its_arity() {
    let twins = twins();
    for function in wgsl::functions() {
        let twin = twins.iter().find(|twin| (twin.module, twin.function) == (function.module, function.name));
        let Some(twin) = twin else { panic!("{}::{} has no row in the parity table", function.module, function.name) };
        assert_eq!(twin.arity, function.parameters, "{}::{}", function.module, function.name);
    }
    for twin in &twins {
        let exists = wgsl::functions().any(|f| (f.module, f.name) == (twin.module, twin.function));
        assert!(exists, "{}::{} is in the parity table but not in WGSL", twin.module, twin.function);
    }
}

#[test]
fn twins_agree_on_every_adapter() {
    for gpu in adapters_for_tests() {
        for twin in twins() {
            let name = format!("{}::{} on {}", twin.module, twin.function, gpu.info());
            let result = compare(&gpu, &twin, SAMPLES).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert!(result.agrees(), "{name}: {result:#?}");
            // The rules may be silent where a comparison they leave open guards a division: at the horizon below
            // refracting layers; and where the half vector of a refraction cancels, between nearly equal indices.
            // Elsewhere they must not be.
            let silent = result.unbounded as f64 / (SAMPLES * 3) as f64;
            let limit = match (twin.module, twin.function) {
                // A walk of more ways than the evaluator follows.
                ("walk", "sample") => 0.06,
                ("walk", _) => 0.05,
                ("layered" | "sampling", _) => 0.01,
                // The last of the normals that a view sees lie where the point of the cap meets the view.
                ("brushed", "reflect_visible_ggx") => 0.01,
                // A place on the border between two cells.
                ("glint", "factor") => 0.001,
                // Octaves whose frequency is rounded: where that decides which cell a point is in, the hash is open.
                // `tests/textures_gpu.rs` holds these to the slope of the noise.
                ("noise", "fractal" | "fractal_slope" | "ridged") => 0.02,
                _ => 0.0,
            };
            assert!(silent <= limit, "{name}: {} unbounded", result.unbounded);
        }
    }
}

#[test]
fn built_in_stacks_agree_under_every_model() {
    use brdf::layered::Model;
    for gpu in adapters_for_tests() {
        for material in brdf::material::stack::built_in() {
            for model in Model::CLOSED_FORM.into_iter().chain([Model::Coupled]) {
                let stack = material.stack.cast::<f32>().with_model(model);
                let result = compare_stack(&gpu, &stack, 1_000).expect("a kernel that runs");
                assert!(result.agrees(), "{} {model:?} on {}: {result:#?}", material.name, gpu.info());
            }
        }
    }
}

/// A table that a broken twin passes would prove nothing: one sign or digit is changed in the text of a twin at a time.
#[test]
fn a_broken_twin_differs() {
    let faults = [
        ("fresnel", "conductor", "- k * k", "+ k * k"),
        ("fresnel", "dielectric", "g * (1.0 / sum_s", "g * (1.0 / sum_p"),
        ("fresnel", "lazanyi", "- a * cos_i * power", "+ a * cos_i * power"),
        ("fresnel_fit", "evaluate", "* u + fit.rows[3].xyz", "* u + fit.rows[2].xyz"),
        ("fresnel_fit", "evaluate_fine", "2.0 * t - 1.0", "2.0 * t - 1.00001"),
        ("distribution", "beckmann", "-select(0.0, exponent", "-0.99999 * select(0.0, exponent"),
        ("masking", "v_cavity", "max(2.0 * select", "min(2.0 * select"),
        ("masking", "smith_beckmann", "0.56418958354775628695", "0.56419458354775628695"),
        ("diffuse", "oren_nayar", "1.0 - 0.5 * variance", "1.0 + 0.5 * variance"),
        ("refraction", "refract", "w.y / eta", "w.y * eta"),
        ("absorption", "transmittance", "1.0 / select(cos_i", "-1.0 / select(cos_i"),
        ("phong", "phong", "wi.x + wo.x", "wi.x - wo.x"),
        ("layered", "conserving", "/ (eta * eta)", "/ eta"),
        ("layered", "elek", "(1.0 - g) + transmitted", "(1.0 - g) - transmitted"),
        ("layered", "coupled", "u32(place), layered__curve_nodes - 2u", "u32(place) + 1u, layered__curve_nodes - 2u"),
        ("layered", "coupled", "1.0 / (n_above * n_above)", "1.0 / n_above"),
        ("layered", "coupled", "/ (eta * eta)", "/ eta"),
        ("layered", "coupled", "1.0 - back * split", "1.0 + back * split"),
        ("layered", "coupled", "* closure.xyz", "* closure.yzx"),
        ("layered", "coupled", "diffuse_lambert(series)", "-diffuse_lambert(series)"),
        ("layered", "coupled", "absorbed *= depth", "absorbed *= 0.5 * depth"),
        ("sampling", "sample", "u.x - sampling__cosine_share", "u.x + sampling__cosine_share"),
        ("sampling", "pdf", "frac_pi * sampling__cosine_share", "frac_pi * sampling__safe_share * 0.5"),
        ("sampling", "sample", "rest -= share", "rest += share"),
        ("sampling", "pdf", "wi.z / (lobe.n", "wi.z * (lobe.n"),
        ("sampling", "reflect_visible", "+ y * wo.y", "- y * wo.y"),
        ("real", "unit_circle", "vec2f(-s, c)", "vec2f(s, c)"),
        ("walk", "visible_normal", "along + across", "along - across"),
        ("walk", "visible_part", "2.0 * m.z", "2.001 * m.z"),
        ("random", "random", "1664525u", "1664521u"),
        ("patina", "patina_extent", "3.0 - 2.0 * t", "3.0 + 2.0 * t"),
        ("patina", "diffuse_as_printed", "1.0 - fresnel", "1.0 + fresnel"),
        ("kubelka_munk", "film", "deep * hidden + ground", "deep * hidden - ground"),
        ("flake", "flake_normal", "2.0 * texel.y - 1.0", "2.0 * texel.y - 1.001"),
        ("brushed", "evaluate_beckmann", "n.y, k.y", "n.x, k.y"),
        ("brushed", "reflect_visible_ggx", "radius * circle.x + v.x", "radius * circle.x - v.x"),
        ("brushed", "reflect_visible_beckmann", "alpha_y * radius", "alpha_x * radius"),
        (
            "brushed",
            "ggx",
            "masking_smith_ggx(wi, wo, alpha_x, alpha_y)",
            "masking_smith_ggx(wi, wo, alpha_y, alpha_x)",
        ),
        ("glint", "leaf", "node.whole - left, left", "left, node.whole - left"),
        ("glint", "leaf", "- 64.0", "- 63.0"),
        ("glint", "factor", "level << 27u", "level << 26u"),
        ("glint", "factor", "column - f32(i)", "column - f32(j)"),
        ("table", "fresnel_over_angle", "0.636619772367581343", "0.636519772367581343"),
        ("table", "fresnel_over_root", "cell + 1u", "cell"),
        ("table", "beckmann_over_angle", "sqrt(sqrt(sqrt(eighth)))", "sqrt(sqrt(eighth))"),
        ("table", "beckmann_over_angle", "j + 1u", "j"),
        ("table", "beckmann_over_root", "shape.columns - 1u", "shape.columns - 2u"),
        ("table", "beckmann_over_root", "sqrt(sqrt(m))", "sqrt(m)"),
        ("real", "ln_one_plus", "1.0 / 3.0", "0.3333"),
        ("real", "angle", "0.199980752811", "0.199981752811"),
    ];
    for gpu in adapters_for_tests() {
        for (module, function, right, wrong) in faults {
            let twin = twins().into_iter().find(|twin| (twin.module, twin.function) == (module, function));
            let twin = twin.unwrap_or_else(|| panic!("{module}::{function} is in the table"));
            let source = wgsl::link_function(module, function).expect("a library function links");
            assert!(source.contains(right), "{module}::{function} contains `{right}`:\n{source}");
            let result = compare_source(&gpu, &twin, &source.replacen(right, wrong, 1), SAMPLES);
            let result = result.unwrap_or_else(|error| panic!("{module}::{function}: {error}"));
            assert!(!result.agrees(), "{module}::{function} with `{wrong}` passes on {}", gpu.info());
        }
    }
}
