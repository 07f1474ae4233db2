//! `brdf bench shaders`: the WGSL of each built-in stack against the general kernel, on every adapter.
//!
//! The loop is inside the kernel, over directions that turn, and the two kernels take turns; a time is the median of several
//! runs. What an empty loop costs is in both.

use crate::failure::Failure;
use crate::material::{self, Change, Material};
use crate::shader::{as_json, counts};
use brdf::Vector;
use brdf::gpu::{Gpu, GpuError, Lap, Stopwatch, layer_bytes, wgpu};
use brdf::layered::Stack;
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
    /// Built-in materials or stack files; without any, every built-in material.
    stacks: Vec<String>,
    /// A short measurement, too short to quote.
    #[arg(long)]
    quick: bool,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

const WORKGROUP: u32 = 64;
const SEEDS: u32 = 4096;

/// What was measured of a stack on an adapter: special, then general.
struct Row {
    name: String,
    ns: [f64; 2],
    counts: [Counts; 2],
}

pub(crate) fn run(options: &Options) -> Result<ExitCode, Failure> {
    let materials: Vec<Material> = if options.stacks.is_empty() {
        material::built_in()
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
    let mut kernels = [Timed::new(gpu, &special, None, quick)?, Timed::new(gpu, &general, Some(&stack), quick)?];
    for _ in 0..if quick { 3 } else { 9 } {
        for kernel in &mut kernels {
            kernel.round()?;
        }
    }
    let stamped = kernels.iter().all(|kernel| kernel.laps.iter().all(|lap| lap.device_ns.is_some()));
    Ok(Row { name: name.clone(), ns: [0, 1].map(|index| kernels[index].median(stamped)), counts: sizes })
}

/// A kernel with a loop that suits the adapter.
struct Timed {
    stopwatch: Stopwatch,
    groups: u32,
    evaluations: f64,
    laps: Vec<Lap>,
}

impl Timed {
    fn new(gpu: &Gpu, source: &str, stack: Option<&Stack<f64, 3>>, quick: bool) -> Result<Self, GpuError> {
        // Enough to fill a card several times; on a software renderer enough for every thread.
        let groups = if gpu.info().device_type == wgpu::DeviceType::Cpu { 64 } else { 1 << 14 };
        let least = if quick { 2e6 } else { 2e7 };
        let source = format!(
            "{source}
@group(0) @binding(0) var<storage, read_write> brdf_sums: array<f32>;
@group(0) @binding(1) var<storage, read> brdf_seeds: array<f32>;
@group(0) @binding(2) var<storage, read> brdf_loop: vec4u;

@compute @workgroup_size({WORKGROUP})
fn brdf_time(@builtin(global_invocation_id) id: vec3u) {{
    let row = (id.x % {SEEDS}u) * 6u;
    var wi = vec3f(brdf_seeds[row], brdf_seeds[row + 1u], brdf_seeds[row + 2u]);
    var wo = vec3f(brdf_seeds[row + 3u], brdf_seeds[row + 4u], brdf_seeds[row + 5u]);
    var sum = vec3f(0.0);
    for (var i = 0u; i < brdf_loop.x; i++) {{
        sum += evaluate(wi, wo);
        // Turned by the angle of a 3-4-5 triangle, and exchanged, so that nothing is constant.
        let t = wi;
        wi = wo;
        wo = vec3f(0.8 * t.x - 0.6 * t.y, 0.6 * t.x + 0.8 * t.y, t.z);
    }}
    brdf_sums[id.x] = sum.x + sum.y + sum.z;
}}
"
        );
        let seeds: Vec<u8> = (0..SEEDS).flat_map(directions).flat_map(f32::to_ne_bytes).collect();
        let layers = stack.map(|stack| {
            let layers: Vec<_> = stack.effective_layers().iter().map(|layer| layer.cast::<f32>()).collect();
            layer_bytes(&layers)
        });
        let mut inputs: Vec<&[u8]> = vec![&seeds, &[0; 16]];
        inputs.extend(layers.as_deref());
        let invocations = groups * WORKGROUP;
        let stopwatch = Stopwatch::new(gpu, &source, "brdf_time", invocations as usize, &inputs)?;
        let mut iterations = 4u32;
        loop {
            let words = [iterations, 0, 0, 0];
            stopwatch.write(2, &words.map(u32::to_ne_bytes).concat())?;
            let lap = stopwatch.lap(groups)?;
            let ns = lap.device_ns.unwrap_or(lap.wall_ns);
            if ns >= least || iterations >= 1 << 24 {
                break;
            }
            iterations = (f64::from(iterations) * (1.2 * least / ns.max(1.0)).clamp(1.5, 16.0)).ceil() as u32;
        }
        let evaluations = f64::from(invocations) * f64::from(iterations);
        Ok(Timed { stopwatch, groups, evaluations, laps: Vec::new() })
    }

    fn round(&mut self) -> Result<(), GpuError> {
        self.laps.push(self.stopwatch.lap(self.groups)?);
        Ok(())
    }

    /// The median time of an evaluation.
    fn median(&self, stamped: bool) -> f64 {
        let time = |lap: &Lap| if stamped { lap.device_ns.unwrap_or(f64::NAN) } else { lap.wall_ns };
        let mut times: Vec<f64> = self.laps.iter().map(|lap| time(lap) / self.evaluations).collect();
        times.sort_by(f64::total_cmp);
        times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
    }
}

/// Two directions over the hemisphere: the Kronecker sequence with the square roots of primes.
fn directions(index: u32) -> [f32; 6] {
    let unit = |root: f64| (0.5 + f64::from(index) * root.sqrt()).fract();
    let one =
        |a: f64, b: f64| Vector::<f64>::from_angles((1.0 - 0.99 * unit(a)).acos(), std::f64::consts::TAU * unit(b));
    let (wi, wo) = (one(2.0, 3.0).cast::<f32>(), one(5.0, 7.0).cast::<f32>());
    [wi.x, wi.y, wi.z, wo.x, wo.y, wo.z]
}
