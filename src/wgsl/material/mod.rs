//! The WGSL of a material: what its fields compute at a point, and what it reflects there.

mod fields;
mod layers;

use crate::layered::{Model, Stack};
use crate::material::Material;
use crate::material::finish::{Body, BrushedMetal, Encoding, Layers, Relief, STEEPEST};
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use core::fmt;
use fields::{Statements, literal};
use layers::{coat_expression, flaked_model, layer_literal, scattered, tilts, widen};

/// A material that has no twin: a part of it is a stack under a model that needs tables or chance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoTwin {
    /// The part, counted from 0.
    pub part: usize,
    /// Its model.
    pub model: Model,
}

impl fmt::Display for NoTwin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { part, model } = self;
        write!(f, "part[{part}]: the model {} runs in Rust alone; a shader takes", model.name())?;
        Model::CLOSED_FORM.iter().try_for_each(|model| write!(f, " {}", model.name()))
    }
}

impl core::error::Error for NoTwin {}

/// The WGSL of a material, to be put behind a shader and linked with it ([`link`](super::link)): it names what it needs of the library by
/// full paths. The twin of [`Spot`](crate::material::Spot), over private variables:
///
/// * `struct Point`, as [`Point`](crate::material::Point); `struct Mirror { direction, alpha, weight, diffuse }`;
///   `struct Drawn { wi, pdf }`;
/// * `material_prepare(point: Point)`: evaluates the fields; the functions below then speak of that point;
/// * `material_reflected(wi: vec3f, wo: vec3f) -> vec3f`, `material_sample(wo: vec3f, u: vec4f) -> Drawn`,
///   `material_pdf(wi: vec3f, wo: vec3f) -> f32`;
/// * `material_mirrors: u32`, how many lobes there are, and `material_mirrored(index: u32, wo: vec3f) -> Mirror`.
///
/// Where the material has images the shader supplies `material_texel(index: u32) -> vec4f`: their texels, row by row, one image after the
/// other.
///
/// # Errors
/// Where a part is a stack whose model is not one of [`Model::CLOSED_FORM`].
pub fn material(material: &Material) -> Result<String, NoTwin> {
    let mut stops = Vec::new();
    let mut writer = Writer::default();
    for (index, part) in material.parts().iter().enumerate() {
        let mut cover = Statements::new(material.images(), &mut stops);
        let covered = if index == 0 { "1.0".to_string() } else { cover.scalar(&part.cover) };
        writer.covers += &format!(
            "fn part_{index}_cover(point: Point) -> f32 {{\n{}    return clamp({covered}, 0.0, 1.0);\n}}\n\n",
            cover.text
        );
        if let Some(relief) = &part.finish.relief {
            writer.relief(index, relief, &mut Statements::new(material.images(), &mut stops));
        }
        let mut statements = Statements::new(material.images(), &mut stops);
        let reflectivity = statements.colour(&part.finish.reflectivity);
        statements.text +=
            &format!("    spot_reflectivity[{index}] = clamp({reflectivity}, vec3f(0.0), vec3f(1.0));\n");
        let relief = part.finish.relief.is_some();
        match &part.finish.body {
            Body::Layers(layers) => {
                let returned = material.returned().get(index).copied().unwrap_or(0.0);
                writer.layers(index, layers, returned, relief, statements);
            }
            Body::Brushed(metal) => writer.brushed(index, metal, relief, statements),
            Body::Whole(stack) => writer.whole(index, stack, relief, statements)?,
        }
    }
    Ok(writer.finish(material.parts().len(), &stops))
}

/// The text of a material as it grows.
#[derive(Default)]
struct Writer {
    covers: String,
    parts: String,
    /// How many layers all parts have.
    layers: usize,
    /// The lobes of all parts: the part, and the expression of each.
    mirrors: Vec<(usize, String)>,
    has_brushed: bool,
    has_relief: bool,
}

impl Writer {
    /// The normal of a part of its own.
    fn relief(&mut self, index: usize, relief: &Relief, statements: &mut Statements<'_>) {
        self.has_relief = true;
        let text = match relief {
            Relief::Height { height, step } => {
                let value = statements.scalar(height);
                let [step, steepest] = [*step, STEEPEST].map(literal);
                format!(
                    "fn part_{index}_height(point: Point) -> f32 {{\n{}    return {value};\n}}\n\n\
                     fn part_{index}_normal(point: Point) -> vec3f {{\n    \
                         let here = part_{index}_height(point);\n    \
                         let along = (part_{index}_height(_shifted(point, {step}, 0.0)) - here) / {step};\n    \
                         let across = (part_{index}_height(_shifted(point, 0.0, {step})) - here) / {step};\n    \
                         let slopes = clamp(vec2f(along, across), vec2f(-{steepest}), vec2f({steepest}));\n    \
                         return brdf::bump::normal_from_slopes(slopes.x, slopes.y);\n}}\n\n",
                    statements.text
                )
            }
            Relief::Map { normals, encoding, strength } => {
                let texel = statements.texel(normals);
                let texel = statements.named(&texel);
                let decoded = match encoding {
                    Encoding::Rgb => format!("brdf::bump::decode_rgb({texel}.xyz)"),
                    Encoding::AlphaGreen => format!("brdf::bump::decode_two_channel({texel}.w, {texel}.y)"),
                };
                let strength = literal(*strength);
                format!(
                    "fn part_{index}_normal(point: Point) -> vec3f {{\n{}    let decoded = {decoded};\n    \
                         let upwards = select(decoded.y, -decoded.y, point.uv_per_length.y < 0.0);\n    \
                         return brdf::bump::scaled(vec3f(decoded.x, upwards, decoded.z), {strength});\n}}\n\n",
                    statements.text
                )
            }
        };
        self.parts += &text;
    }

    /// The function that evaluates the fields of a part.
    fn resolve(&mut self, index: usize, text: &str, relief: bool) {
        let frame = if relief {
            format!("    spot_relief[{index}] = _frame_about(part_{index}_normal(point));\n")
        } else {
            String::new()
        };
        self.parts += &format!("fn part_{index}_prepare(point: Point) {{\n{text}{frame}}}\n\n");
    }

    /// The functions of a part from the expressions of f, of a direction drawn and of its density.
    fn reflect(&mut self, index: usize, [f, drawn, density]: [&str; 3], relief: bool) {
        let (own, back) = if relief {
            (
                format!("    let wi = world_i * spot_relief[{index}];\n    let wo = world_o * spot_relief[{index}];\n"),
                format!("spot_relief[{index}] * drawn"),
            )
        } else {
            ("    let wi = world_i;\n    let wo = world_o;\n".to_string(), "drawn".to_string())
        };
        let view = own.lines().filter(|line| line.contains("let wo")).collect::<Vec<_>>().join("\n");
        self.parts += &format!(
            "fn part_{index}_reflected(world_i: vec3f, world_o: vec3f) -> vec3f {{\n{own}    \
                 if min(wi.z, wo.z) <= 0.0 {{\n        return vec3f(0.0, 0.0, 0.0);\n    }}\n    \
                 return ({f}) * spot_reflectivity[{index}] * wi.z;\n}}\n\n\
             fn part_{index}_sample(world_o: vec3f, u: vec3f) -> vec3f {{\n{view}\n    \
                 let drawn = {drawn};\n    \
                 // Into the part's own surface: none, whatever the others have there.\n    \
                 if min(drawn.z, wo.z) <= 0.0 {{\n        return vec3f(0.0, 0.0, 0.0);\n    }}\n    \
                 return {back};\n}}\n\n\
             fn part_{index}_pdf(world_i: vec3f, world_o: vec3f) -> f32 {{\n{own}    \
                 if min(wi.z, wo.z) <= 0.0 {{\n        return 0.0;\n    }}\n    return {density};\n}}\n\n"
        );
    }

    fn layers(&mut self, index: usize, layers: &Layers, returned: f64, relief: bool, mut statements: Statements<'_>) {
        let (first, count) = (self.layers, layers.coats.len());
        for (position, coat) in layers.coats.iter().enumerate() {
            let expression = coat_expression(coat, returned, &mut statements);
            statements.text += &format!("    spot_layers[{}] = {expression};\n", first + position);
        }
        statements.text += &widen(layers, first);
        let flaked = layers.coats.iter().any(|coat| coat.flakes.is_some());
        if flaked {
            statements.text += "    spot_point = point;\n";
            let tilts = tilts(&layers.coats, first, &mut statements);
            statements.text += &tilts;
        }
        let scatter = layers.scatter.as_ref().map(|sigma| statements.colour(sigma));
        if let Some(sigma) = &scatter {
            statements.text += &format!("    spot_scatter[{index}] = clamp({sigma}, vec3f(0.0), vec3f(1.0));\n");
        }
        let text = core::mem::take(&mut statements.text);
        self.resolve(index, &text, relief);
        if scatter.is_some() {
            self.parts += &scattered(index, first);
        }
        let model = layers.model.name();
        let f = if flaked {
            self.parts += &flaked_model(index, layers, first);
            format!(
                "vec3f(part_{index}_channel(0u, wi, wo), part_{index}_channel(1u, wi, wo), part_{index}_channel(2u, wi, wo))"
            )
        } else {
            format!("brdf::layered::{model}({first}u, {count}u, wi, wo)")
        };
        let f = match &scatter {
            Some(_) => format!("{f} + part_{index}_scattered(wi, wo)"),
            None => f,
        };
        self.stack(index, &f, (first, count, layers.model), relief, scatter.is_some());
        if scatter.is_some() {
            self.mirrors.push((index, format!("_scattered({first}u, spot_scatter[{index}], wo)")));
        }
    }

    /// The rest of a part that is a stack of layers.
    fn stack(
        &mut self,
        index: usize,
        f: &str,
        (first, count, model): (usize, usize, Model),
        relief: bool,
        scatters: bool,
    ) {
        let name = model.name();
        let mut drawn = format!("brdf::sampling::sample({first}u, {count}u, brdf::sampling::{name}, wo, u).wi");
        let mut density = format!("brdf::sampling::pdf({first}u, {count}u, brdf::sampling::{name}, wi, wo)");
        if scatters {
            // Half of the samples are drawn from the cosine.
            drawn = format!(
                "select(brdf::sampling::sample({first}u, {count}u, brdf::sampling::{name}, wo, vec3f(2.0 * u.x - 1.0, u.yz)).wi, \
                 brdf::sampling::cosine_hemisphere(u.yz), u.x < 0.5)"
            );
            density = format!("0.5 * {density} + 0.5 * max(wi.z, 0.0) * brdf::sampling::frac_pi");
        }
        self.reflect(index, [f, &drawn, &density], relief);
        let printed = model == Model::Elek;
        for position in 0..if printed { 1 } else { count } {
            self.mirrors.push((index, format!("_layer_mirror({first}u, {position}u, {printed}, wo)")));
        }
        self.layers += count;
    }

    fn whole(
        &mut self,
        index: usize,
        stack: &Stack<f64, 3>,
        relief: bool,
        mut statements: Statements<'_>,
    ) -> Result<(), NoTwin> {
        let model = stack.model();
        if !Model::CLOSED_FORM.contains(&model) {
            return Err(NoTwin { part: index, model });
        }
        let (first, count) = (self.layers, stack.layers().len());
        for (position, layer) in stack.effective_layers().iter().enumerate() {
            statements.text += &format!("    spot_layers[{}] = {};\n", first + position, layer_literal(layer));
        }
        let text = core::mem::take(&mut statements.text);
        self.resolve(index, &text, relief);
        let f = format!("brdf::layered::{}({first}u, {count}u, wi, wo)", model.name());
        self.stack(index, &f, (first, count, model), relief, false);
        Ok(())
    }

    fn brushed(&mut self, index: usize, metal: &BrushedMetal, relief: bool, mut statements: Statements<'_>) {
        self.has_brushed = true;
        let (n, k) = (statements.colour(&metal.n), statements.colour(&metal.k));
        let [along, across, turn] = [&metal.along, &metal.across, &metal.turn].map(|field| statements.scalar(field));
        statements.text += &format!(
            "    brushed_n[{index}] = clamp({n}, vec3f(1e-3), vec3f(1e3));\n    \
                 brushed_k[{index}] = clamp({k}, vec3f(0.0), vec3f(1e3));\n    \
                 brushed_alpha[{index}] = clamp(vec2f({along}, {across}), vec2f(1e-4), vec2f(1.0));\n    \
                 brushed_turn[{index}] = brdf::real::unit_circle({turn} - floor({turn}));\n"
        );
        let text = core::mem::take(&mut statements.text);
        self.resolve(index, &text, relief);
        let (n, k) = (format!("brushed_n[{index}]"), format!("brushed_k[{index}]"));
        let alpha = format!("brushed_alpha[{index}].x, brushed_alpha[{index}].y");
        let turned = |w: &str| format!("_turned({w}, brushed_turn[{index}])");
        let f = format!("brdf::brushed::evaluate_ggx({}, {}, {n}, {k}, {alpha})", turned("wi"), turned("wo"));
        let drawn = format!(
            "_turned(brdf::brushed::reflect_visible_ggx({}, {alpha}, u.xy), vec2f(brushed_turn[{index}].x, -brushed_turn[{index}].y))",
            turned("wo")
        );
        let density = format!("brdf::brushed::reflect_visible_ggx_pdf({}, {}, {alpha})", turned("wi"), turned("wo"));
        self.reflect(index, [&f, &drawn, &density], relief);
        let reflectance = |c: u32| format!("_interface_terms(wo.z, {n}, {k}, 1.0, {c}u).reflectance");
        self.mirrors.push((
            index,
            format!(
                "Mirror(_mirror_of(wo), sqrt(brushed_alpha[{index}].x * brushed_alpha[{index}].y), \
                 vec3f({}, {}, {}), false)",
                reflectance(0),
                reflectance(1),
                reflectance(2)
            ),
        ));
    }

    fn finish(self, parts: usize, stops: &[[f64; 4]]) -> String {
        let mut text = String::from(include_str!("surface.wgsl"));
        let count = self.layers.max(1);
        text += &format!(
            "\nvar<private> spot_layers: array<brdf::layered::Layer, {count}>;\n\
             var<private> spot_share: array<f32, {parts}>;\n\
             var<private> spot_reflectivity: array<vec3f, {parts}>;\n\
             var<private> spot_relief: array<mat3x3f, {parts}>;\n\
             var<private> spot_scatter: array<vec3f, {parts}>;\n\
             var<private> spot_point: Point;\n\
             var<private> spot_tilts: array<mat3x3f, {count}>;\n\
             var<private> brushed_n: array<vec3f, {parts}>;\n\
             var<private> brushed_k: array<vec3f, {parts}>;\n\
             var<private> brushed_alpha: array<vec2f, {parts}>;\n\
             var<private> brushed_turn: array<vec2f, {parts}>;\n\n\
             fn stack_layer(index: u32) -> brdf::layered::Layer {{\n    return spot_layers[index];\n}}\n\n"
        );
        if !stops.is_empty() {
            let rows: Vec<_> = stops.iter().map(|stop| format!("vec4f({})", stop.map(literal).join(", "))).collect();
            text += &format!(
                "var<private> ramp_stops: array<vec4f, {}> = array<vec4f, {}>({});\n\n\
                 fn ramp_stop(index: u32) -> vec4f {{\n    return ramp_stops[index];\n}}\n\n",
                rows.len(),
                rows.len(),
                rows.join(", ")
            );
        }
        text += &self.covers;
        text += &self.parts;
        text += &self.entry_points(parts);
        text
    }

    /// The functions that the shader calls.
    fn entry_points(&self, parts: usize) -> String {
        let each = |line: &dyn Fn(usize) -> String| (0..parts).map(line).collect::<String>();
        let shares: String = (0..parts)
            .rev()
            .map(|part| {
                format!(
                    "    let cover_{part}_ = part_{part}_cover(point);\n    spot_share[{part}] = left * cover_{part}_;\n    \
                     left *= 1.0 - cover_{part}_;\n"
                )
            })
            .collect();
        let prepare =
            each(&|part| format!("    if spot_share[{part}] > 0.0 {{\n        part_{part}_prepare(point);\n    }}\n"));
        let reflected = each(&|part| {
            format!(
                "    if spot_share[{part}] > 0.0 {{\n        sum += spot_share[{part}] * part_{part}_reflected(wi, wo);\n    }}\n"
            )
        });
        let pdf = each(&|part| {
            format!(
                "    if spot_share[{part}] > 0.0 {{\n        sum += spot_share[{part}] * part_{part}_pdf(wi, wo);\n    }}\n"
            )
        });
        // The last part with a share takes what rounding leaves.
        let sample = each(&|part| {
            format!(
                "    if spot_share[{part}] > 0.0 {{\n        if pending {{\n            wi = part_{part}_sample(wo, u.yzw);\n            \
                 pending = rest >= spot_share[{part}];\n        }}\n        rest -= spot_share[{part}];\n    }}\n"
            )
        });
        let mirrors: String = self
            .mirrors
            .iter()
            .enumerate()
            .map(|(index, (part, mirror))| {
                let (own, back) = if self.has_relief {
                    (
                        format!("        let wo = world_o * _frame_of_part_{part}();\n"),
                        format!("        found.direction = _frame_of_part_{part}() * found.direction;\n"),
                    )
                } else {
                    ("        let wo = world_o;\n".to_string(), String::new())
                };
                format!(
                    "    if index == {index}u && spot_share[{part}] > 0.0 {{\n{own}        if wo.z > 0.0 {{\n            found = {mirror};\n        \
                     }}\n{back}        found.weight *= spot_share[{part}] * spot_reflectivity[{part}];\n    }}\n"
                )
            })
            .collect();
        let frames = if self.has_relief {
            each(&|part| {
                let frame = if self.parts.contains(&format!("spot_relief[{part}] =")) {
                    format!("spot_relief[{part}]")
                } else {
                    "mat3x3f(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)".to_string()
                };
                format!("fn _frame_of_part_{part}() -> mat3x3f {{\n    return {frame};\n}}\n\n")
            })
        } else {
            String::new()
        };
        let count = self.mirrors.len();
        format!(
            "{frames}fn material_prepare(point: Point) {{\n    var left = 1.0;\n{shares}{prepare}}}\n\n\
             fn material_reflected(wi: vec3f, wo: vec3f) -> vec3f {{\n    var sum = vec3f(0.0, 0.0, 0.0);\n    \
                 if min(wi.z, wo.z) <= 0.0 {{\n        return sum;\n    }}\n{reflected}    return sum;\n}}\n\n\
             fn material_pdf(wi: vec3f, wo: vec3f) -> f32 {{\n    var sum = 0.0;\n    \
                 if min(wi.z, wo.z) <= 0.0 {{\n        return sum;\n    }}\n{pdf}    return sum;\n}}\n\n\
             fn material_sample(wo: vec3f, u: vec4f) -> Drawn {{\n    var rest = u.x;\n    var pending = true;\n    \
                 var wi = vec3f(0.0, 0.0, 0.0);\n{sample}    \
                 let density = material_pdf(wi, wo);\n    return Drawn(wi, select(0.0, density, density > 0.0));\n}}\n\n\
             const material_mirrors: u32 = {count}u;\n\n\
             fn material_mirrored(index: u32, world_o: vec3f) -> Mirror {{\n    \
                 var found = Mirror(vec3f(0.0, 0.0, 1.0), 1.0, vec3f(0.0, 0.0, 0.0), true);\n{mirrors}    return found;\n}}\n"
        )
    }
}
