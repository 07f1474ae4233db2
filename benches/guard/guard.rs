//! The instructions of fixed workloads, counted by valgrind and compared with `counts.json`: `benches/guard/run`.
//!
//! A count does not depend on the machine's clock or on what else runs, so that a change of 2 % is one of the code. It is that of a
//! run of 3 rounds less that of a run of 1, per evaluation: what the program does before and after drops out.
//!
//! `guard` alone compares; `BRDF_BLESS=1 guard` writes the counts; `guard WORKLOAD ROUNDS` is what it runs under valgrind.

use brdf::batch::{self, Level, terms};
use brdf::layered::Stack;
use brdf::material::stack;
use brdf::plan::Plan;
use brdf::{Vector, diffuse, distribution, fresnel, masking, microfacet};
use serde_json::{Map, Value, json};
use std::hint::black_box;
use std::process::{Command, ExitCode};

/// Evaluations of a round: whole vectors at each level.
const COUNT: usize = 1024;

/// How far a count may be off. One toolchain repeats its own to the instruction; what other code that is linked in changes, the
/// alignment of a loop or the order of a spill, stays below a hundredth, and a lost inlining or vectorisation is some tenths.
const TOLERANCE: f64 = 0.02;

/// The levels that valgrind runs: it has no AVX-512.
const LEVELS: [&str; 2] = ["baseline", "avx2"];

/// The built-in stacks that are planned: a metal, two interfaces, an oxide, a diffuse base, three layers.
const STACKS: [&str; 5] =
    ["copper", "clear_coat_over_copper", "cuprite_over_copper", "varnish_over_concrete", "three_layer_lacquer"];

const TERMS: [&str; 6] = ["conductor", "dielectric", "beckmann", "smith_ggx", "oren_nayar", "torrance_sparrow"];

fn workloads() -> Vec<String> {
    let mut all = Vec::new();
    for stack in STACKS {
        all.extend(LEVELS.map(|level| format!("batch/{level}/{stack}")));
        all.push(format!("plan/{stack}"));
    }
    all.push("view/avx2/clear_coat_over_copper".to_owned());
    all.push("general/clear_coat_over_copper".to_owned());
    for term in TERMS {
        all.extend([format!("term/{term}"), format!("map/avx2/{term}")]);
    }
    all
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let result = match arguments.as_slice() {
        [] => compare(),
        [workload, rounds] => {
            rounds.parse().map_err(|error| format!("{rounds}: {error}")).and_then(|n| run(workload, n))
        }
        _ => Err("guard, or guard WORKLOAD ROUNDS".to_owned()),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("guard: {problem}");
            ExitCode::FAILURE
        }
    }
}

/// Pairs of directions over the hemisphere, components apart.
fn directions() -> [Vec<f32>; 6] {
    // Roberts 2018: the root of x⁵ = x + 1 gives the steps of a sequence in four dimensions.
    const G: f64 = 1.167_303_978_261_418_7;
    let mut columns: [Vec<f32>; 6] = Default::default();
    for i in 0..COUNT as i32 {
        let point = [1, 2, 3, 4].map(|axis| (0.5 + f64::from(i) * G.powi(-axis)).fract());
        for (direction, [u, v]) in [[point[0], point[1]], [point[2], point[3]]].into_iter().enumerate() {
            let w = Vector::<f64>::from_angles((0.02 + 0.98 * u).acos(), std::f64::consts::TAU * v);
            for (axis, component) in [w.x, w.y, w.z].into_iter().enumerate() {
                columns[3 * direction + axis].push(component as f32);
            }
        }
    }
    columns
}

/// Runs a workload some rounds.
fn run(workload: &str, rounds: usize) -> Result<(), String> {
    let words: Vec<&str> = workload.split('/').collect();
    let columns = directions();
    let pair = |i: usize| {
        let [a, b, c, d, e, g] = columns.each_ref().map(|column| column[i]);
        (Vector::new(a, b, c), Vector::new(d, e, g))
    };
    let pairs: Vec<(Vector<f32>, Vector<f32>)> = (0..COUNT).map(pair).collect();
    let slices = columns.each_ref().map(Vec::as_slice);
    let [a, b, c, d, e, g] = slices;
    let mut f = [(); 3].map(|()| vec![0.0f32; COUNT]);
    // Made once, so that rounds differ by evaluations alone.
    let general: Option<Stack<f64, 3>> = words.last().and_then(|name| stack::by_name(name));
    let plan = general.as_ref().map(Plan::new).transpose().map_err(|error| error.to_string())?;
    let planned = || plan.as_ref().ok_or_else(|| format!("{workload}: no such stack"));
    let general: Option<Stack<f32, 3>> = general.as_ref().map(Stack::cast);
    let lengths = |error: batch::LengthError| error.to_string();
    for _ in 0..rounds {
        let [x, y, z] = f.each_mut().map(Vec::as_mut_slice);
        match words.as_slice() {
            ["batch", at, _] => {
                planned()?.evaluate_batch_at(level(at)?, [a, b, c], [d, e, g], [x, y, z]).map_err(lengths)?;
            }
            ["view", at, _] => {
                planned()?.evaluate_view_at(level(at)?, [a, b, c], pairs[7].1, [x, y, z]).map_err(lengths)?;
            }
            ["plan", _] => {
                let plan = planned()?;
                for (wi, wo) in &pairs {
                    black_box(plan.evaluate(*wi, *wo));
                }
            }
            ["general", _] => {
                let stack = general.as_ref().ok_or_else(|| format!("{workload}: no such stack"))?;
                for (wi, wo) in &pairs {
                    black_box(stack.evaluate(*wi, *wo));
                }
            }
            ["term", name] => term(name, &pairs)?,
            ["map", at, name] => map(name, level(at)?, slices, [x, y, z])?,
            _ => return Err(format!("no workload {workload}")),
        }
        black_box(&mut f);
    }
    Ok(())
}

fn level(name: &str) -> Result<Level, String> {
    let found = Level::available().find(|level| level.name() == name);
    found.ok_or_else(|| format!("this processor, or valgrind on it, has no {name}"))
}

/// One by one in f32.
fn term(name: &str, pairs: &[(Vector<f32>, Vector<f32>)]) -> Result<(), String> {
    macro_rules! each {
        (|$wi:ident, $wo:ident| $value:expr) => {
            for ($wi, $wo) in pairs {
                black_box($value);
            }
        };
    }
    let (n, k) = (1.04f32, 2.59);
    match name {
        "conductor" => each!(|wi, _wo| fresnel::conductor(wi.z, n, k)),
        "dielectric" => each!(|wi, _wo| fresnel::dielectric(wi.z, 1.5)),
        "beckmann" => each!(|wi, wo| distribution::beckmann(*wi + *wo, 0.3)),
        "smith_ggx" => each!(|wi, wo| masking::smith_ggx(*wi, *wo, 0.2, 0.4)),
        "oren_nayar" => each!(|wi, wo| diffuse::oren_nayar(*wi, *wo, 0.5).f(0.8)),
        "torrance_sparrow" => each!(|wi, wo| microfacet::torrance_sparrow(*wi, *wo, n, k, 0.3)),
        _ => return Err(format!("no term {name}")),
    }
    Ok(())
}

/// Over slices.
fn map(name: &str, level: Level, inputs: [&[f32]; 6], [x, y, z]: [&mut [f32]; 3]) -> Result<(), String> {
    let [a, b, c, ..] = inputs;
    let (n, k, alpha) = (1.04, 2.59, 0.3);
    let result = match name {
        "conductor" => batch::map_at(level, &terms::Conductor { n, k }, [c], [x, y]),
        "dielectric" => batch::map_at(level, &terms::Dielectric { eta: 1.5 }, [c], [x, y]),
        "beckmann" => batch::map_at(level, &terms::Beckmann { alpha }, [a, b, c], [x]),
        "smith_ggx" => batch::map_at(level, &terms::SmithGgx { alpha_x: 0.2, alpha_y: 0.4 }, inputs, [x, y]),
        "oren_nayar" => batch::map_at(level, &terms::OrenNayar { sigma: 0.5 }, inputs, [x, y]),
        "torrance_sparrow" => {
            let kernel = terms::TorranceSparrow { n: [0.2, 1.0, 1.2], k: [4.0, 2.6, 2.4], alpha };
            batch::map_at(level, &kernel, inputs, [x, y, z])
        }
        _ => return Err(format!("no term {name}")),
    };
    result.map_err(|error| error.to_string())
}

/// The instructions of a run under valgrind.
fn count(workload: &str, rounds: usize) -> Result<f64, String> {
    let itself = std::env::current_exe().map_err(|error| error.to_string())?;
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(itself)
        .args([workload, &rounds.to_string()])
        .output()
        .map_err(|error| format!("valgrind does not start: {error}"))?;
    let said = String::from_utf8_lossy(&output.stderr);
    let collected = said.lines().find_map(|line| line.split("Collected :").nth(1));
    let collected = collected.and_then(|number| number.trim().parse().ok()).filter(|_| output.status.success());
    collected.ok_or_else(|| format!("{workload}: valgrind says\n{said}"))
}

/// The compiler that made this program's crate, as far as its driver is the one in use.
fn toolchain() -> String {
    let output = Command::new("rustc").arg("--version").output();
    output.map_or(String::new(), |output| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Counts every workload, and compares with what is kept or keeps it.
fn compare() -> Result<(), String> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/guard/counts.json");
    let mut found = Map::new();
    for workload in workloads() {
        let instructions = (count(&workload, 3)? - count(&workload, 1)?) / (2 * COUNT) as f64;
        found.insert(workload, ((100.0 * instructions).round() / 100.0).into());
    }
    let toolchain = toolchain();
    if std::env::var_os("BRDF_BLESS").is_some_and(|value| value == "1") {
        let kept = json!({"toolchain": toolchain, "instructions_per_evaluation": found});
        return std::fs::write(path, format!("{kept:#}\n")).map_err(|error| format!("{path}: {error}"));
    }
    let text = std::fs::read_to_string(path).map_err(|error| format!("{path}: {error}"))?;
    let kept: Value = serde_json::from_str(&text).map_err(|error| format!("{path}: {error}"))?;
    let mut broken = Vec::new();
    for (workload, instructions) in &found {
        let now = instructions.as_f64().unwrap_or(f64::NAN);
        let Some(was) = kept["instructions_per_evaluation"][workload].as_f64() else {
            broken.push(format!("{workload}: {now} instructions, none kept"));
            continue;
        };
        let change = 100.0 * (now / was - 1.0);
        println!("{workload:42} {now:9.2} was {was:9.2} {change:+6.2} %");
        // Not a number is not within the tolerance.
        if now.is_nan() || now > was * (1.0 + TOLERANCE) {
            broken.push(format!("{workload}: {now} instructions an evaluation, was {was}: {change:+.1} %"));
        } else if now < was * (1.0 - TOLERANCE) {
            println!("{workload}: fewer than kept; BRDF_BLESS=1 benches/guard/run keeps them");
        }
    }
    if broken.is_empty() {
        return Ok(());
    }
    let compiled = kept["toolchain"].as_str().unwrap_or_default();
    let hint = if compiled == toolchain {
        "If the change is worth it: BRDF_BLESS=1 benches/guard/run, and say why in the commit."
    } else {
        "The toolchain changed as well: look at what it did to the slowest, then BRDF_BLESS=1 benches/guard/run."
    };
    Err(format!("more instructions than kept\n{}\nkept by {compiled}, now {toolchain}. {hint}", broken.join("\n")))
}
