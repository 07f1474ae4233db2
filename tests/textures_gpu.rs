//! Textures on every adapter: the lattice to the bit, noise where rounding decides the cell, and texels where it decides the column.
#![cfg(feature = "gpu")]

mod adapters;

use adapters::adapters_for_tests;
use brdf::gpu::{Gpu, StackBuffers};
use brdf::parity::{Twin, compare, compare_meaning, map_twin, twins};
use brdf::random::random;
use brdf::texture::noise;
use brdf::{Vector, wgsl};

/// One ULP of f32 at 1, which WGSL's sums and products may err by.
const ULP: f64 = f32::EPSILON as f64;
/// No component of the slope of noise is larger.
const SLOPE: f64 = 3.62;

fn twin(module: &str, function: &str) -> Twin {
    let found = twins().into_iter().find(|twin| (twin.module, twin.function) == (module, function));
    found.unwrap_or_else(|| panic!("{module}::{function} is in the table"))
}

fn textures() -> impl Iterator<Item = Twin> {
    twins().into_iter().filter(|twin| ["bump", "image", "mask", "noise", "ramp", "scratch"].contains(&twin.module))
}

fn map(gpu: &Gpu, twin: &Twin, rows: &[Vec<f32>]) -> Vec<f32> {
    map_twin(gpu, twin, rows, &StackBuffers::default()).unwrap_or_else(|error| panic!("{}: {error}", gpu.info())).values
}

#[test]
fn the_text_means_the_function() {
    for twin in textures() {
        let source = wgsl::link_function(twin.module, twin.function).expect("links");
        let meaning =
            compare_meaning(&twin, &source, 4_000).unwrap_or_else(|error| panic!("{}: {error}", twin.function));
        println!("{}::{} {:9.2e} {:9.3}", twin.module, twin.function, meaning.relative, meaning.share);
        assert_eq!(meaning.misunderstood, 0, "{}: {meaning:?}", twin.function);
    }
}

/// Faults that a picture would hardly show.
#[test]
fn a_fault_changes_the_meaning() {
    let faults = [
        ("noise", "gradient", "t * 6.0 - 15.0", "t * 6.0 - 15.000001"),
        ("noise", "gradient", "0.9649200439453125", "0.96492"),
        ("noise", "gradient", "* 12u) >> 16u", "* 11u) >> 16u"),
        ("noise", "gradient", "vec3u(1u, 0u, 1u)", "vec3u(1u, 0u, 0u)"),
        ("noise", "gradient_slope", "vec4f(h.low.zw, h.high.zw)", "vec4f(h.low.wz, h.high.zw)"),
        ("noise", "gradient_slope", "d.y * ", "d.z * "),
        ("noise", "fractal", "0.3818359375", "0.3818359376"),
        ("noise", "fractal", "seed + k", "seed"),
        ("noise", "fractal_slope", "(a * f)", "a"),
        ("noise", "ridged", "abs(", "("),
        ("scratch", "scratches", "0.6181640625", "0.6181640626"),
        ("scratch", "scratches", "words.w >> 8u", "words.w >> 9u"),
        ("scratch", "scratches", "drawn < density", "drawn > density"),
        ("scratch", "scratches", "1.0 / (", "1.0000001 / ("),
        ("scratch", "scratches", "vec3u(16u)", "vec3u(15u)"),
        ("scratch", "scratches", "off / (width * width)", "off / width"),
        ("ramp", "two", "(1.0 - t) * a", "(1.0 - t) * b"),
        ("ramp", "ramp", "before = stop;", ""),
        ("ramp", "ramp", "count == 0u", "count == 9u"),
        ("ramp", "bands", "i < count", "i + 1u < count"),
        ("ramp", "aged", "(bands - 1.0)", "bands"),
        ("mask", "threshold", "value > at", "value >= at"),
        ("mask", "soft_threshold", "3.0 - 2.0 * t", "3.0 - 2.0000001 * t"),
        ("mask", "soft_threshold", "at - softness", "at + softness"),
        ("mask", "grey", "value - black", "black - value"),
        ("bump", "normal_from_slopes", "-dy", "dy"),
        ("bump", "slopes", "vec2f(along, across)", "vec2f(across, along)"),
        ("bump", "tilted", "normal - along", "normal - slope"),
        ("bump", "decode_rgb", "max(n.z, 0.0)", "n.z"),
        ("bump", "decode_two_channel", "max(squared, 1.0)", "1.0"),
        ("bump", "encode", "normal + 1.0", "normal + 1.0000001"),
        ("bump", "scaled", "normal.y * strength", "normal.y"),
        ("bump", "combined", "a.z * b.z)", "a.z)"),
        ("bump", "frame_about", "-normal.x * c", "normal.x * c"),
        ("image", "bilinear", " - 0.5", " - 0.499"),
        ("image", "bilinear", "(low + 1u) % sizes", "min(low + 1u, sizes - 1u) % sizes"),
        ("image", "bilinear_clamped", "min(low + 1u, last)", "low"),
        ("image", "nearest", "place.x % width", "place.y % width"),
        ("image", "nearest_clamped", "height - 1u", "height"),
    ];
    let mut unnoticed = Vec::new();
    for (module, function, right, wrong) in faults {
        let twin = twin(module, function);
        let source = wgsl::link_function(module, function).expect("links");
        if !source.contains(right) {
            unnoticed.push(format!("{module}::{function} does not contain `{right}`"));
            continue;
        }
        let meaning = compare_meaning(&twin, &source.replace(right, wrong), 4_000);
        let meaning = meaning.unwrap_or_else(|error| panic!("{module}::{function} with `{wrong}`: {error}"));
        if meaning.misunderstood == 0 {
            unnoticed.push(format!("{module}::{function} with `{wrong}` means the same: {meaning:?}"));
        }
    }
    assert!(unnoticed.is_empty(), "{}", unnoticed.join("\n"));
}

#[test]
fn textures_agree_on_every_adapter() {
    for gpu in adapters_for_tests() {
        for twin in textures() {
            let result = compare(&gpu, &twin, 4_000).unwrap_or_else(|error| panic!("{}: {error}", twin.function));
            println!("{}::{} share {:.3} unbounded {}", twin.module, twin.function, result.share, result.unbounded);
            assert!(result.agrees(), "{} on {}: {result:#?}", twin.function, gpu.info());
        }
    }
}

/// At a lattice point the slope is the point's gradient and nothing else, without rounding.
#[test]
fn lattices_are_the_same_to_the_bit() {
    let slope = twin("noise", "gradient_slope");
    let rows: Vec<Vec<f32>> = (0..20_000)
        .map(|i| {
            let [x, y, z, seed] = random::<f32>(3, i, 0);
            // From a few cells about the origin to all that f32 counts.
            let reach = [8.0, 1e3, 8_388_608.0][i as usize % 3];
            let whole = |x: f32| ((x - 0.5) * reach).round();
            vec![whole(x), whole(y), whole(z), (seed * 16_777_216.0).round() * 256.0 * (i % 2) as f32]
        })
        .collect();
    let want: Vec<f32> = rows
        .iter()
        .flat_map(|row| {
            let slope = noise::gradient_slope(Vector::new(row[0], row[1], row[2]), row[3] as u32);
            [slope.x, slope.y, slope.z]
        })
        .collect();
    for gpu in adapters_for_tests() {
        let got = map(&gpu, &slope, &rows);
        for ((got, want), row) in got.chunks(3).zip(want.chunks(3)).zip(&rows) {
            assert_eq!(got, want, "{row:?} on {}", gpu.info());
        }
    }
}

/// Where the rounding of a frequency decides the cell, no interval bounds the hash: the result is held to the slope of the noise
/// times the rounding of the place.
#[test]
fn noise_is_continuous_where_rounding_decides_the_cell() {
    let (amplitude, gain, octaves) = (1.0f32, 0.5f32, 5);
    let rows: Vec<Vec<f32>> = (0..20_000)
        .map(|i| {
            let [f, l, x, y] = random::<f32>(4, i, 0);
            let (frequency, lacunarity) = (0.3 + 3.0 * f, 1.7 + 0.6 * l);
            // A place that some octave takes to within a few ULP of a lattice plane.
            let octave = (i % octaves) as i32;
            let near = (40.0 * (x - 0.5)).round() / (frequency * lacunarity.powi(octave));
            let near = near * (1.0 + ((i / 8 % 5) as f32 - 2.0) * f32::EPSILON);
            vec![near, 6.0 * (y - 0.5), 0.25, (i % 11) as f32, amplitude, frequency, octaves as f32, gain, lacunarity]
        })
        .collect();
    // Each octave's place: its frequency rounds once an octave, the product and the shift once more each. The noise itself: 7 blends,
    // the heights, the fade, each an ULP of numbers up to 2 with slopes up to 15/8·2, as derived in the tests of the noise: 80 ULP.
    let room = |row: &[f32]| -> f64 {
        (0..octaves)
            .map(|k| {
                let k = f64::from(k);
                let frequency = f64::from(row[5]) * f64::from(row[8]).powf(k);
                let place = |x: f32| (f64::from(x).abs() * frequency + k) * (k + 3.0) * ULP;
                let amplitude = f64::from(amplitude) * f64::from(gain).powf(k);
                amplitude * (SLOPE * (place(row[0]) + place(row[1]) + place(row[2])) + (80.0 + k) * ULP)
            })
            .sum()
    };
    let double = |row: &[f32]| {
        let [x, y, z, _, amplitude, frequency, _, gain, lacunarity] = std::array::from_fn(|i| f64::from(row[i]));
        noise::fractal(Vector::new(x, y, z), row[3] as u32, amplitude, frequency, octaves, gain, lacunarity)
    };
    let fractal = twin("noise", "fractal");
    for gpu in adapters_for_tests() {
        let mut most = 0.0f64;
        for (got, row) in map(&gpu, &fractal, &rows).into_iter().zip(&rows) {
            let share = (f64::from(got) - double(row)).abs() / room(row);
            assert!(share <= 1.0, "{row:?} on {}: {got} {}", gpu.info(), double(row));
            most = most.max(share);
        }
        println!("{}: at most {most:.3} of what rounding may leave", gpu.info());
    }
    for row in &rows {
        let p = Vector::new(row[0], row[1], row[2]);
        let got = noise::fractal(p, row[3] as u32, amplitude, row[5], octaves, gain, row[8]);
        assert!((f64::from(got) - double(row)).abs() <= room(row), "{row:?}: {got}");
    }
}
