//! The walk's twin on every adapter: its mean against the walk in f64.
#![cfg(feature = "gpu")]

mod adapters;

use adapters::adapters_for_tests;
use brdf::Vector;
use brdf::gpu::{Gpu, Kernel, STACK_BINDINGS, layer_bytes};
use brdf::layered::{Interface, Layer, Model, Stack};
use brdf::walk::{self, Options};
use brdf::wgsl;

/// Walks on each side.
const SAMPLES: u32 = 4096;
/// Standard errors that the two means may be apart. Of the 120 comparisons below an honest pair of independent seeds would
/// exceed it in one run of 130 (P(|z| > 4) = 6.3e-5); the seeds are fixed.
const LIMIT: f64 = 4.0;

/// The built-in stacks, and what they lack: an interface between equal indices and media above the first.
fn stacks() -> Vec<(&'static str, Stack<f32, 3>)> {
    let coat = |n: f32, alpha: f32| Layer::new(Interface::dielectric(n, alpha));
    let copper = Layer::new(Interface::conductor([0.213, 1.04, 1.17], [4.05, 2.59, 2.36], 0.3));
    let mut all: Vec<_> = brdf::material::stack::built_in()
        .into_iter()
        .filter(|material| material.stack.layers().len() > 1)
        .map(|material| (material.name, material.stack.cast::<f32>()))
        .collect();
    let sigma = [0.1, 0.5, 1.0];
    let mut add = |name, layers| all.push((name, Stack::new(Model::Conserving, layers).unwrap()));
    add("matched", vec![coat(1.0, 0.2).over(sigma, 0.3), coat(1.5, 0.2), coat(1.5, 0.1).over(sigma, 0.5), copper]);
    add("very rough", vec![coat(1.5, 0.8), coat(1.2, 1.0), Layer::new(Interface::diffuse([1.0, 0.5, 0.2], 0.7))]);
    add(
        "smooth under rough",
        vec![coat(1.3, 0.5), coat(1.8, 0.05), Layer::new(Interface::diffuse([0.9, 0.5, 0.2], 0.0))],
    );
    add("nearly matched", vec![coat(1.5, 0.2).over(sigma, 0.2), coat(1.55, 0.05), copper]);
    add("very smooth", vec![coat(1.5, 1e-4).over(sigma, 0.5), Layer::new(Interface::diffuse([1.0, 0.5, 0.2], 0.0))]);
    all
}

fn pairs() -> [(Vector<f32>, Vector<f32>); 3] {
    let direction = |theta: f64, phi: f64| Vector::from_angles(theta.to_radians(), phi.to_radians());
    [
        (direction(20.0, 0.0), direction(50.0, 100.0)),
        (direction(42.0, 0.0), direction(36.0, 185.0)),
        (direction(80.0, 0.0), direction(65.0, 160.0)),
    ]
}

/// The mean and standard error of the twin over its walks in one channel.
fn mean_on(
    gpu: &Gpu,
    kernel: &Kernel,
    stack: &Stack<f32, 3>,
    channel: u32,
    pair: (Vector<f32>, Vector<f32>),
) -> [f64; 2] {
    let (wi, wo) = pair;
    let directions = [wi.x, wi.y, wi.z, wo.x, wo.y, wo.z].map(f32::to_bits);
    let row = |index| [&[0, stack.layers().len() as u32, channel], &directions[..], &[77, index]].concat();
    let rows: Vec<u32> = (0..SAMPLES).flat_map(row).collect();
    let values =
        kernel.run(&rows, &[&layer_bytes(stack.layers())]).unwrap_or_else(|error| panic!("{}: {error}", gpu.info()));
    let values: Vec<f64> = values.into_iter().map(|word| f64::from(f32::from_bits(word))).collect();
    assert!(values.iter().all(|f| f.is_finite() && *f >= 0.0), "{}", gpu.info());
    let n = f64::from(SAMPLES);
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|f| (f - mean).powi(2)).sum();
    [mean, (squares / (n * (n - 1.0))).sqrt()]
}

#[test]
fn the_twin_has_the_mean_of_the_walk() {
    let source = wgsl::link_function("walk", "sample").unwrap();
    for gpu in adapters_for_tests() {
        let kernel = Kernel::new(&gpu, &source, &wgsl::mangled("walk", "sample"), Some(STACK_BINDINGS)).unwrap();
        for (name, stack) in stacks() {
            let double = stack.cast::<f64>();
            for (number, (wi, wo)) in pairs().into_iter().enumerate() {
                let options = Options { samples: SAMPLES, seed: 5, ..Options::default() };
                let want = walk::evaluate(&double, wi.cast::<f64>(), wo.cast::<f64>(), &options);
                for channel in 0..3 {
                    let [mean, error] = mean_on(&gpu, &kernel, &stack, channel as u32, (wi, wo));
                    let (want, spread) = (want.mean[channel], want.standard_error[channel].hypot(error));
                    // Where every walk gives the same, the first reflection alone: rounding, and exp(−x) for x up to 87.
                    let off = ((mean - want).abs() - 1e-5 * want - f64::from(f32::MIN_POSITIVE)).max(0.0);
                    assert!(
                        off <= LIMIT * spread,
                        "{}: {name}, pair {number}, channel {channel}: {mean} ± {error}, want {want}: {:.1}",
                        gpu.info(),
                        off / spread
                    );
                }
            }
        }
    }
}
