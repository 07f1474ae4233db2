//! What the WGSL of a material computes, in double precision and on every adapter.

use super::adapters::adapters_for_tests;
use super::{direction, materials, point, variants};
use brdf::gpu::Kernel;
use brdf::material::{Material, Point};
use brdf::random::random;
use brdf::shader::interp::{Buffers, Cell, Known, Program, Shader};
use brdf::{Vector, wgsl};

/// Points and pairs of directions for each material.
const ROWS: u32 = 400;

/// What is compared: f·cos, the density, the lobes and cosines of the environment with their directions, and a direction drawn.
const PROBE: &str = "
struct Found {
    reflected: vec3f,
    pdf: f32,
    weights: vec3f,
    directions: vec3f,
    alphas: f32,
    drawn: vec3f,
    drawn_pdf: f32,
}

fn probe(
    position: vec3f, tangent: vec3f, bitangent: vec3f, uv: vec2f, uv_per_length: vec2f, occlusion: f32, distance: f32, footprint: f32,
    wi: vec3f, wo: vec3f, u: vec4f,
) -> Found {
    material_prepare(Point(position, occlusion, tangent, distance, bitangent, footprint, uv, uv_per_length));
    let drawn = material_sample(wo, u);
    // Where there is none the direction means nothing.
    let towards = select(vec3f(0.0), drawn.wi, drawn.pdf > 0.0);
    var found = Found(material_reflected(wi, wo), material_pdf(wi, wo), vec3f(0.0), vec3f(0.0), 0.0, towards, drawn.pdf);
    for (var index = 0u; index < material_mirrors; index++) {
        let mirror = material_mirrored(index, wo);
        found.weights += mirror.weight;
        found.directions += mirror.direction * mirror.weight.y;
        found.alphas += select(mirror.alpha, 0.0, mirror.diffuse) * mirror.weight.y;
    }
    return found;
}
";

fn source(material: &Material) -> String {
    let text = wgsl::material(material).expect("a closed form");
    wgsl::link(&format!("{PROBE}\n{text}")).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

const TEXELS: &str = "
@group(0) @binding(3) var<storage, read> material_texels: array<vec4f>;
fn material_texel(index: u32) -> vec4f { return material_texels[index]; }
";

/// The texels of all images, as the shader reads them.
fn texels(material: &Material) -> Vec<u8> {
    let all = material.images().iter().flat_map(brdf::texture::image::Image::texels);
    all.flatten().flat_map(f32::to_le_bytes).collect()
}

fn row(index: u32) -> Vec<f32> {
    let Point { position, tangent, bitangent, uv, uv_per_length, occlusion, distance, footprint } = point(index);
    let vector = |v: Vector<f32>| [v.x, v.y, v.z];
    let mut row = [vector(position), vector(tangent), vector(bitangent)].concat();
    row.extend(uv);
    row.extend(uv_per_length);
    row.extend([occlusion, distance, footprint]);
    row.extend([vector(direction(index, 0)), vector(direction(index, 1))].concat());
    row.extend(numbers(index));
    row
}

/// What a direction is drawn with.
fn numbers(index: u32) -> [f32; 4] {
    random(61, index, 0)
}

/// How many numbers a probe gives, and how many of them are not of the direction drawn.
const RESULTS: usize = 15;
const SMOOTH: usize = 11;

/// What the Rust says, in f64 from the same numbers.
fn expected(material: &Material, index: u32) -> [f64; RESULTS] {
    let (point, wi, wo) = (point(index).cast::<f64>(), direction(index, 0).cast(), direction(index, 1).cast());
    let spot = material.at(&point);
    let [r, g, b] = spot.reflected(wi, wo);
    let (mut weights, mut directions, mut alphas) = ([0.0; 3], Vector::new(0.0, 0.0, 0.0), 0.0);
    spot.mirrored(wo, &mut |mirror| {
        weights = [0, 1, 2].map(|c: usize| weights[c] + mirror.weight[c]);
        directions = directions + mirror.direction * mirror.weight[1];
        alphas += if mirror.diffuse { 0.0 } else { mirror.alpha * mirror.weight[1] };
    });
    let [wr, wg, wb] = weights;
    let (drawn, pdf) =
        spot.sample(wo, numbers(index).map(f64::from)).map(|drawn| (drawn.wi, drawn.pdf)).unwrap_or_default();
    let Vector { x, y, z } = drawn;
    [r, g, b, spot.pdf(wi, wo), wr, wg, wb, directions.x, directions.y, directions.z, alphas, x, y, z, pdf]
}

/// Polynomials of `wgsl/real.wgsl` that are good to f32 alone, each tested by itself.
const KNOWN: [(&str, Known); 7] = [
    ("sum_exact", Known::SumExact),
    ("product_exact", Known::ProductExact),
    ("exp_product", Known::ExpProduct),
    ("ln_one_plus", Known::LnOnePlus),
    ("angle", Known::Angle),
    ("erfcx", Known::Erfcx),
    ("unit_circle", Known::UnitCircle),
];

/// In double precision both compute the same formulas: what is left is their rounding, magnified where a narrow lobe (α = .01) has a
/// logarithmic derivative of 1e4 and a relief takes differences over 1/500 of a unit.
#[test]
fn the_text_means_what_the_rust_says() {
    for (name, material) in materials().into_iter().chain(variants()) {
        let source = source(&material) + if material.images().is_empty() { "" } else { TEXELS };
        let shader = Shader::in_double(&source).unwrap_or_else(|error| panic!("{name}: {error}\n{source}"));
        let known = KNOWN.map(|(name, method)| (wgsl::mangled("real", name), method));
        let program =
            Program::<f64>::with_known(&shader, "probe", &known).unwrap_or_else(|error| panic!("{name}: {error}"));
        let rows: Vec<_> = (0..ROWS).flat_map(row).map(|x| Cell::Real(f64::from(x))).collect();
        let mut buffers = Buffers::new().with(0, 3, texels(&material));
        let found = program.run(&rows, &mut buffers).unwrap_or_else(|error| panic!("{name}: {error}"));
        let mut worst = 0.0f64;
        for (index, found) in found.chunks(RESULTS).enumerate() {
            let expected = expected(&material, index as u32);
            for (place, (found, expected)) in found.iter().zip(expected).enumerate() {
                let Cell::Real(found) = *found else { panic!("{name}: a number") };
                let error = (found - expected).abs() / expected.abs().max(1e-3);
                worst = worst.max(error);
                assert!(error < 1e-9, "{name}, row {index}, result {place}: {found:e}, expected {expected:e}");
            }
        }
        println!("{name:24} {worst:.1e}");
    }
}

/// On an adapter the same in f32. Rounding (2⁻²⁴, some tens of operations deep in a field, WGSL's own accuracy) moves the argument of a
/// narrow lobe: by 1e-6/α² of its logarithm, 1e-2 at α = .01; masks and reliefs move by their slope, 50 for the sharpest edge.
/// So most rows must agree to 1e-3, and all to what a mask's edge or a flake's border may change: nothing is off by half. Of the directions
/// drawn most must agree as well; where a number falls between two lobes, rounding decides which of them it chooses, and no bound holds.
#[test]
fn adapters_compute_it() {
    for gpu in adapters_for_tests() {
        for (name, material) in materials().into_iter().chain(variants()) {
            let bindings = (!material.images().is_empty()).then_some(TEXELS);
            let kernel = Kernel::new(&gpu, &source(&material), "probe", bindings)
                .unwrap_or_else(|error| panic!("{}, {name}: {error}", gpu.info()));
            let rows: Vec<f32> = (0..ROWS).flat_map(row).collect();
            let texels = texels(&material);
            let storage: Vec<&[u8]> = if texels.is_empty() { Vec::new() } else { vec![&texels] };
            let found = kernel.run_f32(&rows, &storage).unwrap_or_else(|error| panic!("{name}: {error}"));
            let (mut far, mut astray, mut count) = (0, 0, 0);
            for (index, found) in found.chunks(RESULTS).enumerate() {
                let expected = expected(&material, index as u32);
                let errors: Vec<f64> =
                    found.iter().zip(expected).map(|(f, e)| (f64::from(*f) - e).abs() / e.abs().max(1e-2)).collect();
                let place = format!("{}, {name}, row {index}: {found:?}, expected {expected:?}", gpu.info());
                assert!(errors.iter().all(|error| error.is_finite()), "{place}");
                let (smooth, drawn) = errors.split_at(SMOOTH);
                let worst = |errors: &[f64]| errors.iter().copied().fold(0.0, f64::max);
                assert!(worst(smooth) < 0.5, "{place}");
                far += usize::from(worst(smooth) > 1e-3);
                astray += usize::from(worst(drawn) > 1e-3);
                count += 1;
            }
            println!("{:32} {name:24} {far} and {astray} of {count}", gpu.info().to_string());
            assert!(
                20 * far.max(astray) <= count,
                "{}, {name}: {far} and {astray} of {count} rows are off",
                gpu.info()
            );
        }
    }
}
