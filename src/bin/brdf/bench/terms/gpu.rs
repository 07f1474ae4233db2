//! A family on an adapter: the results of its WGSL, and the time of an evaluation with the loop inside the kernel.

use super::family::{Family, Inputs, ROUGH};
use super::formula::WGSL;
use crate::bench::clock::Times;
use brdf::gpu::{Gpu, GpuError, Kernel, Lap, Stopwatch, rows, wgpu};
use brdf::wgsl;
use std::fmt;

/// The binding at which both kernels read the constants: the first that `gpu::Kernel` leaves free.
const CONSTANTS: &str = "@group(0) @binding(3) var<storage, read> material: array<vec4f>;\n";

const PARAMETERS: [&str; 6] = ["a", "b", "c", "d", "e", "f"];

/// The invocations of a workgroup.
const WORKGROUP: u32 = 64;

/// What the times of an adapter were read from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::bench) enum Clock {
    /// The device's own, before and after each kernel.
    Timestamps,
    /// The host's, over kernels that run for long.
    Wall,
}

impl fmt::Display for Clock {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Clock::Timestamps => "timestamps",
            Clock::Wall => "wall time",
        })
    }
}

/// A variant's results, and its time where it was measured.
pub(super) struct Run {
    pub(super) results: Vec<f64>,
    pub(super) ns: f64,
}

/// All variants of a family on one adapter, and the time of the loop with nothing in it.
pub(super) struct Runs {
    pub(super) variants: Vec<Run>,
    pub(super) empty_ns: f64,
    /// What all of these times were read from.
    pub(super) clock: Clock,
}

/// The WGSL of a variant: plain, its function `variant`.
fn linked(inputs: Inputs, body: &str) -> Result<String, GpuError> {
    let parameters = PARAMETERS[..inputs.words()].iter().map(|name| format!("{name}: f32")).collect::<Vec<_>>();
    let text = format!("{WGSL}{ROUGH}{CONSTANTS}fn variant({}) -> vec3f {{\n{body}\n}}\n", parameters.join(", "));
    wgsl::link(&text).map_err(|error| GpuError::Arguments { function: "variant".to_owned(), reason: error.to_string() })
}

/// The entry point that calls `variant` over and over, with arguments that change, and adds up what it returns.
fn timed(inputs: Inputs, source: &str) -> String {
    let words = inputs.words();
    let names = PARAMETERS[..words].join(", ");
    let start: String = PARAMETERS[..words]
        .iter()
        .enumerate()
        .map(|(word, name)| format!("    var {name} = brdf_seeds[row + {word}u];\n"))
        .collect();
    // Directions and half vectors turn about the normal by the angle of a 3-4-5 triangle, which keeps them what they are;
    // two directions change places too, so that nothing of either is constant.
    let advance = match inputs {
        Inputs::Cosine => "a = fract(a + 0.618034);",
        Inputs::Half => "let t = a; a = 0.8 * t - 0.6 * b; b = 0.6 * t + 0.8 * b;",
        Inputs::Lobe | Inputs::Pair => {
            "let t = vec3f(a, b, c); a = d; b = e; c = f; d = 0.8 * t.x - 0.6 * t.y; e = 0.6 * t.x + 0.8 * t.y; f = t.z;"
        }
    };
    format!(
        "{source}
@group(0) @binding(0) var<storage, read_write> brdf_sums: array<f32>;
@group(0) @binding(1) var<storage, read> brdf_seeds: array<f32>;
@group(0) @binding(2) var<storage, read> brdf_loop: vec4u;

@compute @workgroup_size({WORKGROUP})
fn brdf_time(@builtin(global_invocation_id) id: vec3u) {{
    let row = (id.x % brdf_loop.y) * {words}u;
{start}    var sum = vec3f(0.0);
    for (var i = 0u; i < brdf_loop.x; i++) {{
        sum += variant({names});
        {advance}
    }}
    // The constants are read whatever the variant does with them: the layout has them.
    brdf_sums[id.x] = sum.x + sum.y + sum.z + min(material[0].x, 0.0);
}}
"
    )
}

/// A kernel whose number of iterations suits the adapter.
struct Calibrated {
    stopwatch: Stopwatch,
    evaluations: f64,
    laps: Vec<Lap>,
}

impl Calibrated {
    fn new(gpu: &Gpu, family: &Family, source: &str, seeds: &[u32], quick: bool) -> Result<Self, GpuError> {
        let least = if quick { 1e6 } else { 1.5e7 };
        let groups = groups(gpu);
        let constants = family.constants.rows();
        let source = timed(family.inputs, source);
        let seed_rows = (seeds.len() / family.inputs.words()) as u32;
        let invocations = groups * WORKGROUP;
        let stopwatch = Stopwatch::new(
            gpu,
            &source,
            "brdf_time",
            invocations as usize,
            &[as_bytes(seeds).as_slice(), &[0; 16], &as_bytes(&bits(&constants))],
        )?;
        let mut iterations = 4u32;
        loop {
            stopwatch.write(2, &as_bytes(&[iterations, seed_rows, 0, 0]))?;
            let lap = stopwatch.lap(groups)?;
            let ns = lap.device_ns.unwrap_or(lap.wall_ns);
            if ns >= least || iterations >= 1 << 24 {
                break;
            }
            iterations = (f64::from(iterations) * (1.2 * least / ns.max(1.0)).clamp(1.5, 16.0)).ceil() as u32;
        }
        let evaluations = f64::from(invocations) * f64::from(iterations);
        Ok(Calibrated { stopwatch, evaluations, laps: Vec::new() })
    }

    fn round(&mut self, groups: u32) -> Result<(), GpuError> {
        self.laps.push(self.stopwatch.lap(groups)?);
        Ok(())
    }

    /// The median time of an evaluation, NaN where the device told none.
    fn median(&self, clock: Clock) -> f64 {
        let time = |lap: &Lap| match clock {
            Clock::Timestamps => lap.device_ns,
            Clock::Wall => Some(lap.wall_ns),
        };
        Times::new(self.laps.iter().filter_map(time).map(|ns| ns / self.evaluations).collect()).median()
    }

    /// Whether most laps have a time of the device.
    fn is_stamped(&self) -> bool {
        2 * self.laps.iter().filter(|lap| lap.device_ns.is_some()).count() > self.laps.len()
    }
}

/// Enough to fill a card several times; on a software renderer enough for every thread.
fn groups(gpu: &Gpu) -> u32 {
    if gpu.info().device_type == wgpu::DeviceType::Cpu { 64 } else { 1 << 14 }
}

fn bits(rows: &[[f32; 4]]) -> Vec<u32> {
    rows.as_flattened().iter().map(|x| x.to_bits()).collect()
}

fn as_bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_ne_bytes()).collect()
}

/// Runs and times every variant of a family on an adapter.
pub(super) fn run(gpu: &Gpu, family: &Family, columns: &[Vec<f32>], quick: bool) -> Result<Runs, GpuError> {
    const SEEDS: usize = 4096;
    let every: Vec<&[f32]> = columns.iter().map(Vec::as_slice).collect();
    let arguments = rows(&every)?;
    let seeds = &arguments[..SEEDS.min(columns[0].len()) * family.inputs.words()];
    let constants = as_bytes(&bits(&family.constants.rows()));
    let sources: Vec<_> = family
        .variants
        .iter()
        .map_while(|variant| Some(linked(family.inputs, variant.wgsl?)))
        .collect::<Result<_, _>>()?;
    let mut results = Vec::new();
    let mut kernels = Vec::new();
    for source in &sources {
        let words = Kernel::new(gpu, source, "variant", None)?.run(&arguments, &[&constants])?;
        let row = |row: &[u32]| {
            row[..family.channels].iter().map(|word| f64::from(f32::from_bits(*word))).collect::<Vec<_>>()
        };
        results.push(words.chunks_exact(3).flat_map(row).collect::<Vec<f64>>());
        kernels.push(Calibrated::new(gpu, family, source, seeds, quick)?);
    }
    let sum = PARAMETERS[..family.inputs.words()].join(" + ");
    let empty = linked(family.inputs, &format!("return vec3f({sum});"))?;
    kernels.push(Calibrated::new(gpu, family, &empty, seeds, quick)?);
    for _ in 0..if quick { 2 } else { 7 } {
        for kernel in &mut kernels {
            kernel.round(groups(gpu))?;
        }
    }
    let clock = if kernels.iter().all(Calibrated::is_stamped) { Clock::Timestamps } else { Clock::Wall };
    let mut times = kernels.iter().map(|kernel| kernel.median(clock));
    let variants = results.into_iter().zip(times.by_ref()).map(|(results, ns)| Run { results, ns }).collect();
    let empty_ns = times.next().unwrap_or(f64::NAN);
    Ok(Runs { variants, empty_ns, clock })
}
