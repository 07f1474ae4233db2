//! The reference values of `tests/reference/terms.json` in single precision, Rust and WGSL: each result must lie in the
//! interval that WGSL's rules allow once the inputs themselves are rounded to one of the two f32 next to them.
#![cfg(feature = "gpu")]

mod adapters;

use adapters::adapters_for_tests;
use brdf::Vector;
use brdf::interval::WgslInterval;
use brdf::parity::{Twin, map_twin, twins};
use serde_json::Value;

/// A section of the reference: the function, its arguments from a row, and the row's values for its first results.
struct Section {
    name: &'static str,
    function: (&'static str, &'static str),
    arguments: fn(&Value) -> Vec<f64>,
    values: &'static [&'static str],
}

fn numbers(row: &Value, keys: &[&str]) -> Vec<f64> {
    keys.iter().map(|key| row[key].as_f64().unwrap_or_else(|| panic!("{key} in {row}"))).collect()
}

fn directions(row: &Value) -> [Vector<f64>; 2] {
    let n = numbers(row, &["tl", "tv", "dphi"]);
    [Vector::from_angles(n[0], 0.0), Vector::from_angles(n[1], n[2])]
}

fn half_and_width(row: &Value) -> Vec<f64> {
    let mut arguments: Vec<f64> = row["h"].as_array().expect("a vector").iter().filter_map(Value::as_f64).collect();
    arguments.extend(numbers(row, &["m"]));
    arguments
}

fn pair(row: &Value, keys: &[&str]) -> Vec<f64> {
    let mut arguments: Vec<f64> = directions(row).into_iter().flat_map(<[f64; 3]>::from).collect();
    arguments.extend(numbers(row, keys));
    arguments
}

#[rustfmt::skip]
const SECTIONS: &[Section] = &[
    Section { name: "fresnel_dielectric", function: ("fresnel", "dielectric"), arguments: |r| numbers(r, &["c", "eta"]), values: &["F", "T"] },
    Section { name: "fresnel_conductor", function: ("fresnel", "conductor"), arguments: |r| numbers(r, &["c", "n", "k"]), values: &["F", "T"] },
    Section { name: "fresnel_conductor", function: ("fresnel", "conductor_approx"), arguments: |r| numbers(r, &["c", "n", "k"]), values: &["approx36"] },
    Section { name: "schlick", function: ("fresnel", "schlick"), arguments: |r| numbers(r, &["c", "f0"]), values: &["F", "T"] },
    Section { name: "lazanyi", function: ("fresnel", "lazanyi"), arguments: |r| numbers(r, &["c", "n", "k", "a", "alpha"]), values: &["compensated"] },
    Section { name: "distribution", function: ("distribution", "beckmann"), arguments: half_and_width, values: &["beckmann"] },
    Section { name: "distribution", function: ("distribution", "ggx"), arguments: half_and_width, values: &["ggx"] },
    Section { name: "snell", function: ("refraction", "cos_t"), arguments: |r| numbers(r, &["c", "eta"]), values: &["cos_t"] },
    Section { name: "absorption", function: ("absorption", "transmittance"), arguments: |r| numbers(r, &["sigma", "d", "nlp", "nvp"]), values: &["a"] },
    Section { name: "torrance_sparrow", function: ("microfacet", "torrance_sparrow"), arguments: |r| pair(r, &["n", "k", "m"]), values: &["f", "F"] },
    Section { name: "patina_extent", function: ("patina", "patina_extent"), arguments: |r| numbers(r, &["extent", "transition", "value"]), values: &["factor"] },
];

fn twin((module, function): (&str, &str)) -> Twin {
    let all = twins();
    let at = all.iter().position(|twin| (twin.module, twin.function) == (module, function));
    all[at.unwrap_or_else(|| panic!("{module}::{function} is in the parity table"))]
}

#[test]
fn single_precision_stays_within_what_rounded_inputs_allow() {
    let reference: Value = serde_json::from_str(include_str!("reference/terms.json")).expect("JSON");
    let gpus = adapters_for_tests();
    for section in SECTIONS {
        let twin = twin(section.function);
        let rows = reference[section.name].as_array().expect("a list");
        let arguments: Vec<Vec<f64>> = rows.iter().map(section.arguments).collect();
        let rounded: Vec<Vec<f32>> = arguments.iter().map(|row| row.iter().map(|x| *x as f32).collect()).collect();
        let mut results =
            vec![("Rust".to_owned(), rounded.iter().flat_map(|row| (twin.single)(row)).collect::<Vec<_>>())];
        for gpu in &gpus {
            let outputs =
                map_twin(gpu, &twin, &rounded, &brdf::gpu::StackBuffers::default()).expect("a kernel that runs");
            results.push((gpu.info().to_string(), outputs.values));
        }
        let mut bounded = 0;
        for (index, (row, arguments)) in rows.iter().zip(&arguments).enumerate() {
            let inputs: Vec<WgslInterval> = arguments.iter().map(|x| brdf::Real::from_f64(*x)).collect();
            let allowed = (twin.allowed)(&inputs);
            for (output, key) in section.values.iter().enumerate() {
                let interval = allowed[output];
                bounded += usize::from(interval.is_bounded());
                let want = row[key].as_f64().unwrap_or(0.0);
                let place = format!("{} {key}: {interval:?}\n{row}", section.name);
                // Past exp(−87) ≈ 2e-38, times at most 1/(πα²) = 3e7, f32 returns 0.
                let underflows = interval.high() == 0.0 && want < 1e-30;
                let holds = interval.low() <= want && want <= interval.high();
                assert!(holds || underflows, "the reference {want:e} in {place}");
                for (who, values) in &results {
                    let value = values[index * allowed.len() + output];
                    assert!(interval.contains(value), "{who} gives {value:e} in {place}");
                }
            }
        }
        // The rules are silent only where rounding an input decides whether there is total reflection.
        let share = bounded as f64 / (rows.len() * section.values.len()) as f64;
        assert!(share > 0.9, "{}: only {share} of the results are bounded", section.name);
    }
}
