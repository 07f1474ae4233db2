//! A kernel that evaluates a function of two directions in a loop, timed.

use brdf::Vector;
use brdf::gpu::{Gpu, GpuError, Lap, Stopwatch, wgpu};

const WORKGROUP: u32 = 64;
const SEEDS: u32 = 4096;

/// A kernel with a loop that suits the adapter.
pub(super) struct Timed {
    stopwatch: Stopwatch,
    groups: u32,
    evaluations: f64,
    laps: Vec<Lap>,
}

impl Timed {
    /// Of a module with the function `evaluate(wi: vec3f, wo: vec3f) -> vec3f`; `buffers` are what it reads at bindings 3 and after.
    pub(super) fn new(gpu: &Gpu, source: &str, buffers: &[&[u8]], quick: bool) -> Result<Self, GpuError> {
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
        let mut inputs: Vec<&[u8]> = vec![&seeds, &[0; 16]];
        inputs.extend(buffers);
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

    /// One more measurement.
    pub(super) fn round(&mut self) -> Result<(), GpuError> {
        self.laps.push(self.stopwatch.lap(self.groups)?);
        Ok(())
    }

    /// Whether the device stamped every measurement with its own clock.
    pub(super) fn is_stamped(&self) -> bool {
        self.laps.iter().all(|lap| lap.device_ns.is_some())
    }

    /// The median time of an evaluation.
    pub(super) fn median(&self, stamped: bool) -> f64 {
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
