//! The layers of a part as WGSL: each at a point, their widths, and a model over flakes.

use super::fields::{Statements, literal, vector};
use crate::layered::{Interface, Layer, Model, Widths};
use crate::material::finish::{Boundary, Coat, Flakes, Layers};
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

const KINDS: [&str; 2] = ["brdf::layered::microfacet_interface", "brdf::layered::diffuse_base"];

/// A layer at `point`.
pub(super) fn coat_expression(coat: &Coat, returned: f64, statements: &mut Statements<'_>) -> String {
    let zero = "vec3f(0.0, 0.0, 0.0)".to_string();
    let (n, alpha, k, kind, albedo, deviation) = match &coat.boundary {
        Boundary::Microfacet { n, k, alpha } => {
            let (n, k, alpha) = (statements.colour(n), statements.colour(k), statements.scalar(alpha));
            let n = format!("clamp({n}, vec3f(1e-3), vec3f(1e3))");
            let k = format!("clamp({k}, vec3f(0.0), vec3f(1e3))");
            (n, format!("clamp({alpha}, 1e-4, 1.0)"), k, KINDS[0], zero, "0.0".to_string())
        }
        Boundary::Diffuse { albedo, sigma } => {
            let (albedo, sigma) = (statements.colour(albedo), statements.scalar(sigma));
            let albedo = statements.named(&format!("clamp({albedo}, vec3f(0.0), vec3f(1.0))"));
            let albedo = match returned {
                0.0 => albedo,
                returned => format!("{albedo} / (vec3f(1.0) - {albedo} * {})", literal(returned)),
            };
            (
                zero.clone(),
                "1.0".to_string(),
                zero,
                KINDS[1],
                albedo,
                format!("clamp({sigma}, 0.0, 1.57079632679489662)"),
            )
        }
    };
    let (sigma, thickness) = (statements.colour(&coat.sigma), statements.scalar(&coat.thickness));
    format!(
        "brdf::layered::Layer({n}, {alpha}, {k}, {kind}, {albedo}, {deviation}, max({sigma}, vec3f(0.0)), max({thickness}, 0.0))"
    )
}

pub(super) fn layer_literal(layer: &Layer<f64, 3>) -> String {
    let zero = [0.0; 3];
    let (n, alpha, k, kind, albedo, deviation) = match layer.interface {
        Interface::Microfacet { n, k, alpha } => (n, alpha, k, KINDS[0], zero, 0.0),
        Interface::Diffuse { albedo, sigma } => (zero, 1.0, zero, KINDS[1], albedo, sigma),
    };
    let medium = layer.medium;
    let (n, k, albedo, sigma) = (vector(n), vector(k), vector(albedo), vector(medium.sigma));
    let (alpha, deviation, thickness) = (literal(alpha), literal(deviation), literal(medium.thickness));
    format!("brdf::layered::Layer({n}, {alpha}, {k}, {kind}, {albedo}, {deviation}, {sigma}, {thickness})")
}

/// The documents' diffuse term of the upper layer.
pub(super) fn scattered(index: usize, first: usize) -> String {
    format!(
        "fn part_{index}_scattered(wi: vec3f, wo: vec3f) -> vec3f {{\n    \
             let cosine = brdf::microfacet::cos_half(wi, wo);\n    \
             let terms = _terms_of(cosine, spot_layers[{first}], 1.0);\n    let sigma = spot_scatter[{index}];\n    \
             return vec3f(\n        brdf::patina::diffuse_as_printed(sigma.x, terms[0].x, 1.0),\n        \
                 brdf::patina::diffuse_as_printed(sigma.y, terms[0].y, 1.0),\n        \
                 brdf::patina::diffuse_as_printed(sigma.z, terms[0].z, 1.0)) * brdf::sampling::frac_pi;\n}}\n\n"
    )
}

/// The widths of covered interfaces, as [`Widths`](crate::layered::Widths) has them.
pub(super) fn widen(layers: &Layers, first: usize) -> String {
    let mut text = String::new();
    let microfacets: Vec<usize> = layers
        .coats
        .iter()
        .enumerate()
        .filter(|(_, coat)| matches!(coat.boundary, Boundary::Microfacet { .. }))
        .map(|(position, _)| first + position)
        .collect();
    match layers.widths {
        Widths::Own => {}
        Widths::Clamp => {
            for pair in microfacets.windows(2) {
                if let [above, below] = pair {
                    text += &format!(
                        "    spot_layers[{below}].alpha = max(spot_layers[{below}].alpha, spot_layers[{above}].alpha);\n"
                    );
                }
            }
        }
        Widths::Variance => {
            text += "    var spread = 0.0;\n    var index_above = 1.0;\n";
            for layer in microfacets {
                text += &format!(
                    "    {{\n        let own = spot_layers[{layer}].alpha;\n        \
                     let index = dot(spot_layers[{layer}].n, vec3f(1.0 / 3.0));\n        \
                     spot_layers[{layer}].alpha = min(sqrt(own * own + 2.0 * spread), 1.0);\n        \
                     let inverse = index_above / index;\n        let added = 0.5 * (1.0 - inverse) * own;\n        \
                     spread = spread * inverse * inverse + added * added;\n        index_above = index;\n    }}\n"
                );
            }
        }
    }
    text
}

/// The frames about the documents' flake normals.
pub(super) fn tilts(coats: &[Coat], first: usize, statements: &mut Statements<'_>) -> String {
    let mut text = String::new();
    for (position, coat) in coats.iter().enumerate() {
        if let Some(Flakes::AsPrinted { normals }) = &coat.flakes {
            let texel = statements.texel(normals);
            text += &format!(
                "    spot_tilts[{}] = _frame_about(brdf::flake::flake_normal(vec3f(0.0, 0.0, 1.0), point.distance, {texel}.xyz));\n",
                first + position
            );
        }
    }
    text
}

/// One channel of a model over flakes: the text of `wgsl/layered.wgsl` with the facets of each layer its own.
pub(super) fn flaked_model(index: usize, layers: &Layers, first: usize) -> String {
    let count = layers.coats.len();
    let cases: String = layers
        .coats
        .iter()
        .enumerate()
        .filter_map(|(position, coat)| {
            let flakes = coat.flakes.as_ref()?;
            let body = match flakes {
                Flakes::Glints { spacing, resolution, seed } => format!(
                    "        var found = brdf::microfacet::facets(wi, wo, alpha);\n        \
                     found.lobe *= brdf::glint::factor(wi + wo, alpha, brdf::glint::Flakes({}, 1.0, {resolution}u, {seed}u), \
                     spot_point.position, spot_point.footprint);\n        return found;\n",
                    literal(*spacing)
                ),
                Flakes::AsPrinted { .. } => format!(
                    "        let own_i = wi * spot_tilts[{0}];\n        let own_o = wo * spot_tilts[{0}];\n        \
                     var found = brdf::microfacet::facets(own_i, own_o, alpha);\n        \
                     found.lobe *= max(own_i.z, 0.0) / select(1.0, wi.z, wi.z > 0.0);\n        return found;\n",
                    first + position
                ),
            };
            Some(format!("    if position == {position}u {{\n{body}    }}\n"))
        })
        .collect();
    let (alpha, relative, refract, through) = match layers.model {
        Model::Elek => (
            "max(layer.alpha, alpha_above)",
            "1.0",
            ["brdf::refraction::refract(below_i, eta)", "brdf::refraction::refract(below_o, eta)"],
            "terms.transmittance * brdf::layered::internal_reflection(terms.transmittance, rough.g)",
        ),
        Model::WeidlichWilkie => (
            "layer.alpha",
            "n_above",
            [
                "brdf::refraction::refract_about(below_i, normalize(below_i + below_o), eta)",
                "brdf::refraction::refract_about(below_o, normalize(below_i + below_o), eta)",
            ],
            "terms.transmittance * brdf::layered::internal_reflection(terms.transmittance, rough.g)",
        ),
        _ => (
            "layer.alpha",
            "n_above",
            ["brdf::refraction::refract(below_i, eta)", "brdf::refraction::refract(below_o, eta)"],
            "_interface_terms(below_i.z, layer.n, layer.k, n_above, channel).transmittance \
             * _interface_terms(below_o.z, layer.n, layer.k, n_above, channel).transmittance / (eta * eta)",
        ),
    };
    let [refract_i, refract_o] = refract;
    format!(
        "fn part_{index}_facets(position: u32, wi: vec3f, wo: vec3f, alpha: f32) -> brdf::microfacet::Facets {{\n{cases}    \
             return brdf::microfacet::facets(wi, wo, alpha);\n}}\n\n\
         fn part_{index}_channel(channel: u32, wi: vec3f, wo: vec3f) -> f32 {{\n    \
             var f = 0.0;\n    var weight = 1.0;\n    var below_i = wi;\n    var below_o = wo;\n    var n_above = 1.0;\n    \
             var alpha_above = 0.0;\n    \
             for (var position = 0u; position < {count}u; position++) {{\n        \
                 let layer = spot_layers[{first}u + position];\n        \
                 if layer.kind == brdf::layered::diffuse_base {{\n            \
                     let base = brdf::diffuse::oren_nayar(below_i, below_o, layer.deviation);\n            \
                     let albedo = layer.albedo[channel];\n            \
                     return f + weight * max(brdf::diffuse::lambert(albedo) * (base.direct + albedo * base.interreflection), 0.0);\n        \
                 }}\n        \
                 let eta = layer.n[channel] / n_above;\n        let alpha = {alpha};\n        \
                 let rough = part_{index}_facets(position, below_i, below_o, alpha);\n        \
                 let terms = _interface_terms(brdf::microfacet::cos_half(below_i, below_o), layer.n, layer.k, {relative}, channel);\n        \
                 f += weight * terms.reflectance * rough.lobe;\n        \
                 let next_i = {refract_i};\n        let next_o = {refract_o};\n        \
                 if min(next_i.z, next_o.z) <= 0.0 || min(below_i.z, below_o.z) <= 0.0 {{\n            return f;\n        }}\n        \
                 weight *= {through}\n            \
                     * brdf::absorption::transmittance(layer.sigma[channel], layer.thickness, next_i.z, next_o.z);\n        \
                 below_i = next_i;\n        below_o = next_o;\n        n_above = layer.n[channel];\n        alpha_above = alpha;\n    \
             }}\n    return f;\n}}\n\n"
    )
}
