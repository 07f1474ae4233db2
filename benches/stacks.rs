//! The cost of every built-in stack under every model in f32, three channels: `cargo bench --bench stacks`.
//!
//! Each benchmark evaluates one stack at the same 1024 low-discrepancy pairs of directions; its throughput is evaluations
//! of all channels per second.

use brdf::Vector;
use brdf::layered::Model;
use brdf::material::stack::built_in;
use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::Duration;

/// Pairs of directions over the hemisphere, uniform in the cosine above .02 and in the azimuth.
fn directions() -> Vec<(Vector<f32>, Vector<f32>)> {
    // Roberts 2018: the root of x⁵ = x + 1 gives the steps of a sequence in four dimensions.
    const G: f64 = 1.167_303_978_261_418_7;
    let direction = |u: f64, v: f64| {
        let (cos, phi) = (0.02 + 0.98 * u, 2.0 * std::f64::consts::PI * v);
        let sin = (1.0 - cos * cos).sqrt();
        Vector::<f64>::new(sin * phi.cos(), sin * phi.sin(), cos).cast()
    };
    let coordinate = |i: i32, axis: i32| (0.5 + f64::from(i) * G.powi(-axis)).fract();
    let pair = |i: i32| (direction(coordinate(i, 1), coordinate(i, 2)), direction(coordinate(i, 3), coordinate(i, 4)));
    (0..1024).map(pair).collect()
}

fn stacks(c: &mut Criterion) {
    let directions = directions();
    for model in Model::CLOSED_FORM.into_iter().chain([Model::Coupled]) {
        let mut group = c.benchmark_group(model.name());
        group.throughput(Throughput::Elements(directions.len() as u64));
        for material in built_in() {
            let stack = material.stack.with_model(model).cast::<f32>();
            // Tables are built here, before the clock runs.
            black_box(stack.evaluate(directions[0].0, directions[0].1));
            group.bench_with_input(BenchmarkId::from_parameter(material.name), &stack, |b, stack| {
                b.iter(|| {
                    for (wi, wo) in black_box(&directions) {
                        black_box(stack.evaluate(*wi, *wo));
                    }
                });
            });
        }
        group.finish();
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(100))
        .measurement_time(Duration::from_millis(300));
    targets = stacks
}
criterion_main!(benches);
