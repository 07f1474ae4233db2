//! `brdf bench materials`: what a material costs at a point, against Phong with the same features.
//!
//! As the documents measured their shaders (Elek 2010, Table 1): a normal map is decoded, one light reflected, and a blurred environment
//! looked up. Phong has one lobe and one lookup; a material evaluates its fields, reflects, and looks up once for each of its interfaces.

use super::timed::Timed;
use crate::failure::Failure;
use brdf::gpu::Gpu;
use brdf::material::{Material, built_in};
use brdf::texture::image::Image;
use brdf::wgsl;
use clap::Args;
use serde_json::{Value, json};
use std::io::{self, Write};
use std::process::ExitCode;

/// What `brdf bench materials` is asked for.
#[derive(Args)]
pub(crate) struct Options {
    /// Built-in materials; without any, every one.
    materials: Vec<String>,
    /// A short measurement, too short to quote.
    #[arg(long)]
    quick: bool,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Texels of the normal map, and of a level of the environment, along each side.
const SIDE: u32 = 64;
/// Levels of the environment: 8 of the width, the last of a cosine.
const LEVELS: u32 = 9;

/// What a material and Phong share: the normal map, and the environment over an octahedron.
const FEATURES: &str = "
@group(0) @binding(3) var<storage, read> texels: array<vec4f>;

fn material_texel(index: u32) -> vec4f {
    return texels[index];
}

fn environment(direction: vec3f, level: f32) -> vec3f {
    let flat = direction.xy / (abs(direction.x) + abs(direction.y) + abs(direction.z));
    let uv = 0.5 + 0.5 * vec2f(flat.x + flat.y, flat.x - flat.y);
    let low = u32(level);
    let high = min(low + 1u, levels - 2u);
    let first = images + side * side;
    let a = brdf::image::bilinear(first + low * side * side, side, side, uv);
    let b = brdf::image::bilinear(first + high * side * side, side, side, uv);
    return mix(a, b, fract(level)).xyz;
}

fn irradiance(direction: vec3f) -> vec3f {
    let flat = direction.xy / (abs(direction.x) + abs(direction.y) + abs(direction.z));
    let uv = 0.5 + 0.5 * vec2f(flat.x + flat.y, flat.x - flat.y);
    return brdf::image::bilinear(images + levels * side * side, side, side, uv).xyz;
}

fn mapped_normal(uv: vec2f) -> vec3f {
    return brdf::bump::decode_rgb(brdf::image::bilinear(images, side, side, uv).xyz);
}
";

const PHONG: &str = "
fn evaluate(wi: vec3f, wo: vec3f) -> vec3f {
    let frame = brdf::bump::frame_about(mapped_normal(wo.xy));
    let to_light = vec3f(dot(wi, frame.tangent), dot(wi, frame.bitangent), dot(wi, frame.normal));
    let to_viewer = vec3f(dot(wo, frame.tangent), dot(wo, frame.bitangent), dot(wo, frame.normal));
    let colour = vec3f(0.8, 0.5, 0.3);
    let lobe = brdf::phong::phong(to_light, to_viewer, 60.0);
    let lit = (colour * brdf::diffuse::frac_pi + vec3f(lobe)) * max(to_light.z, 0.0);
    return lit + colour * environment(vec3f(-to_viewer.x, -to_viewer.y, to_viewer.z), 2.0);
}
";

const MATERIAL: &str = "
fn evaluate(wi: vec3f, wo: vec3f) -> vec3f {
    let frame = brdf::bump::frame_about(mapped_normal(wo.xy));
    let to_light = vec3f(dot(wi, frame.tangent), dot(wi, frame.bitangent), dot(wi, frame.normal));
    let to_viewer = vec3f(dot(wo, frame.tangent), dot(wo, frame.bitangent), dot(wo, frame.normal));
    material_prepare(Point(wo, 0.3, frame.tangent, 2.0, frame.bitangent, 0.004, wo.xy, vec2f(0.2, 0.3)));
    var sum = material_reflected(to_light, to_viewer);
    for (var index = 0u; index < material_mirrors; index++) {
        let mirror = material_mirrored(index, to_viewer);
        if mirror.diffuse {
            sum += mirror.weight * irradiance(mirror.direction);
        } else {
            sum += mirror.weight * environment(mirror.direction, mirror.alpha * f32(levels - 2u));
        }
    }
    return sum;
}
";

/// The time of each material at a point on one adapter, Phong first.
type Times = Vec<(String, f64)>;

pub(crate) fn run(options: &Options) -> Result<ExitCode, Failure> {
    let mut materials = Vec::new();
    for named in built_in::all() {
        if options.materials.is_empty() || options.materials.iter().any(|name| name == named.name) {
            let material = named.material().map_err(|error| format!("{}: {error}", named.name))?;
            materials.push((named.name.to_owned(), material));
        }
    }
    if let Some(unknown) = options.materials.iter().find(|name| built_in::by_name(name).is_none()) {
        return Err(format!("{unknown} is no built-in material; see `brdf list`").into());
    }
    let gpus: Vec<Gpu> = Gpu::open_all().into_iter().collect::<Result<_, _>>()?;
    if gpus.is_empty() {
        // Says what there is, and how to get an adapter.
        Gpu::open(None)?;
    }
    let mut results = Vec::new();
    for gpu in &gpus {
        results.push((gpu.info().to_string(), measure(gpu, &materials, options.quick)?));
    }
    let mut out = io::stdout().lock();
    if options.json {
        let row = |(name, ns): &(String, f64), phong: f64| json!({"material": name, "ns": ns, "to_phong": ns / phong});
        let adapter = |(adapter, times): &(String, Times)| {
            let phong = times.first().map_or(f64::NAN, |(_, ns)| *ns);
            json!({"adapter": adapter, "materials": times.iter().map(|time| row(time, phong)).collect::<Vec<_>>()})
        };
        writeln!(out, "{:#}", Value::from_iter(results.iter().map(adapter)))?;
    } else {
        for (adapter, times) in &results {
            let phong = times.first().map_or(f64::NAN, |(_, ns)| *ns);
            writeln!(out, "{adapter}\n{:32} {:>10} {:>10}", "material", "ns a point", "to Phong")?;
            for (name, ns) in times {
                writeln!(out, "{name:32} {ns:>10.2} {:>10.2}", ns / phong)?;
            }
            writeln!(out)?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn measure(gpu: &Gpu, materials: &[(String, Material)], quick: bool) -> Result<Times, Failure> {
    let mut kernels = vec![("phong".to_owned(), timed(gpu, None, quick)?)];
    for (name, material) in materials {
        kernels.push((name.clone(), timed(gpu, Some(material), quick)?));
    }
    for _ in 0..if quick { 3 } else { 9 } {
        for (_, kernel) in &mut kernels {
            kernel.round()?;
        }
    }
    let stamped = kernels.iter().all(|(_, kernel)| kernel.is_stamped());
    Ok(kernels.into_iter().map(|(name, kernel)| (name, kernel.median(stamped))).collect())
}

fn timed(gpu: &Gpu, material: Option<&Material>, quick: bool) -> Result<Timed, Failure> {
    let images = material.map(Material::images).unwrap_or_default();
    let mut texels: Vec<[f32; 4]> = images.iter().flat_map(Image::texels).collect();
    let sizes =
        format!("const images: u32 = {}u;\nconst side: u32 = {SIDE}u;\nconst levels: u32 = {LEVELS}u;\n", texels.len());
    // A normal map of gentle slopes, and an environment that is brighter above.
    for index in 0..(LEVELS + 2) * SIDE * SIDE {
        let [a, b, c, _] = brdf::random::random::<f32>(5, index, 0);
        texels.push(if index < SIDE * SIDE { [0.45 + 0.1 * a, 0.45 + 0.1 * b, 0.95, 1.0] } else { [a, b, c, 1.0] });
    }
    let text = match material {
        None => PHONG.to_owned(),
        Some(material) => format!("{MATERIAL}{}", wgsl::material(material).map_err(|error| error.to_string())?),
    };
    let linked = wgsl::link(&format!("{sizes}{FEATURES}{text}")).map_err(|error| error.to_string())?;
    let bytes: Vec<u8> = texels.iter().flatten().flat_map(|x| x.to_ne_bytes()).collect();
    Ok(Timed::new(gpu, &linked, &[&bytes], quick)?)
}
