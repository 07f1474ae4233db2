//! `brdf bench shaders`: the WGSL of each built-in stack against the general kernel, on every adapter.
//!
//! The loop is inside the kernel, over directions that turn, and the two kernels take turns; a time is the median of several
//! runs. What an empty loop costs is in both.

use super::timed::Timed;
use crate::failure::Failure;
use crate::material::{self, Change, Material};
use crate::shader::{as_json, counts};
use brdf::gpu::{Gpu, layer_bytes};
use brdf::plan::Plan;
use brdf::shader::Counts;
use brdf::wgsl;
use clap::Args;
use serde_json::{Value, json};
use std::io::{self, Write};
use std::process::ExitCode;

/// What `brdf bench shaders` is asked for.
#[derive(Args)]
pub(crate) struct Options {
    /// Built-in stacks or stack files; without any, every built-in stack.
    stacks: Vec<String>,
    /// A short measurement, too short to quote.
    #[arg(long)]
    quick: bool,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// What was measured of a stack on an adapter: special, then general.
struct Row {
    name: String,
    ns: [f64; 2],
    counts: [Counts; 2],
}

pub(crate) fn run(options: &Options) -> Result<ExitCode, Failure> {
    let materials: Vec<Material> = if options.stacks.is_empty() {
        material::stacks()
    } else {
        let load = |name: &String| material::load(name, Change::default());
        options.stacks.iter().map(load).collect::<Result<_, _>>()?
    };
    let gpus: Vec<Gpu> = Gpu::open_all().into_iter().collect::<Result<_, _>>()?;
    if gpus.is_empty() {
        // Says what there is, and how to get an adapter.
        Gpu::open(None)?;
    }
    let mut results = Vec::new();
    for gpu in &gpus {
        let rows = materials.iter().map(|material| measure(gpu, material, options.quick));
        results.push((gpu.info().to_string(), rows.collect::<Result<Vec<Row>, Failure>>()?));
    }
    let mut out = io::stdout().lock();
    if options.json {
        let row = |row: &Row| {
            json!({
                "stack": row.name, "special_ns": row.ns[0], "general_ns": row.ns[1], "ratio": row.ns[1] / row.ns[0],
                "special": as_json(&row.counts[0]), "general": as_json(&row.counts[1]),
            })
        };
        let adapter = |(adapter, rows): &(String, Vec<Row>)| json!({"adapter": adapter, "stacks": rows.iter().map(row).collect::<Vec<_>>()});
        writeln!(out, "{:#}", Value::from_iter(results.iter().map(adapter)))?;
    } else {
        for (adapter, rows) in &results {
            writeln!(out, "{adapter}")?;
            writeln!(
                out,
                "{:32} {:>10} {:>10} {:>7}   {:>18}",
                "stack", "special ns", "general ns", "ratio", "SPIR-V operations"
            )?;
            for Row { name, ns: [special, general], counts } in rows {
                let ratio = general / special;
                let (few, many) = (counts[0].instructions, counts[1].instructions);
                writeln!(out, "{name:32} {special:>10.3} {general:>10.3} {ratio:>7.2}   {few:>7} of {many:>7}")?;
            }
            writeln!(out)?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn measure(gpu: &Gpu, material: &Material, quick: bool) -> Result<Row, Failure> {
    let stack = material.stack.three();
    let name = &material.name;
    let plan = Plan::new(&stack).map_err(|error| format!("{name}: {error}"))?;
    let link = |text: &str| wgsl::link(text).map_err(|error| format!("{name}: {error}"));
    let special = link(&wgsl::specialise(&plan, "evaluate"))?;
    let count = stack.layers().len();
    let general = format!(
        "{}\n@group(0) @binding(3) var<storage, read> stack_layers: array<layered_Layer>;\nfn stack_layer(index: u32) -> \
         layered_Layer {{\n    return stack_layers[index];\n}}\n",
        link(&format!(
            "import brdf::layered;\nfn evaluate(wi: vec3f, wo: vec3f) -> vec3f {{ return layered::{}(0u, {count}u, wi, wo); }}\n",
            stack.model().name()
        ))?
    );
    let sizes = [counts(&special)?, counts(&general)?];
    let layers: Vec<_> = stack.effective_layers().iter().map(|layer| layer.cast::<f32>()).collect();
    let mut kernels =
        [Timed::new(gpu, &special, &[], quick)?, Timed::new(gpu, &general, &[&layer_bytes(&layers)], quick)?];
    for _ in 0..if quick { 3 } else { 9 } {
        for kernel in &mut kernels {
            kernel.round()?;
        }
    }
    let stamped = kernels.iter().all(Timed::is_stamped);
    Ok(Row { name: name.clone(), ns: [0, 1].map(|index| kernels[index].median(stamped)), counts: sizes })
}
