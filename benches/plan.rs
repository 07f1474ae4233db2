//! What each rule of a plan saves: `cargo bench --bench plan`.
//!
//! For each rule a stack that it applies to (`Rule::example`), three channels: the general evaluation in f32, the plan without the
//! rule and the plan with it, one by one and in batches on one thread. Each benchmark evaluates the same 1024 low-discrepancy
//! pairs of directions; its throughput is evaluations of all channels per second.

use brdf::Vector;
use brdf::layered::Stack;
use brdf::plan::{Options, Plan, Rule};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
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

fn rules(c: &mut Criterion) {
    let directions = directions();
    let column = |one: fn(&(Vector<f32>, Vector<f32>)) -> f32| directions.iter().map(one).collect::<Vec<f32>>();
    let wi = [column(|(w, _)| w.x), column(|(w, _)| w.y), column(|(w, _)| w.z)];
    let wo = [column(|(_, w)| w.x), column(|(_, w)| w.y), column(|(_, w)| w.z)];
    let mut f = [(); 3].map(|()| vec![0.0f32; directions.len()]);
    for rule in Rule::ALL {
        let stack = rule.example();
        let single: Stack<f32, 3> = stack.cast();
        let mut group = c.benchmark_group(rule.name());
        group.throughput(Throughput::Elements(directions.len() as u64));
        group.bench_function("general", |b| {
            b.iter(|| {
                for (wi, wo) in black_box(&directions) {
                    black_box(single.evaluate(*wi, *wo));
                }
            });
        });
        for (name, without) in [("without", &[rule][..]), ("with", &[])] {
            let options = Options { without, ..Options::default() };
            let plan = Plan::with_options(&stack, &options).expect("examples have a closed form");
            group.bench_function(format!("scalar/{name}"), |b| {
                b.iter(|| {
                    for (wi, wo) in black_box(&directions) {
                        black_box(plan.evaluate(*wi, *wo));
                    }
                });
            });
            group.bench_function(format!("batch/{name}"), |b| {
                let ([x, y, z], [u, v, w]) = (wi.each_ref().map(Vec::as_slice), wo.each_ref().map(Vec::as_slice));
                b.iter(|| {
                    let f = f.each_mut().map(Vec::as_mut_slice);
                    black_box(plan.evaluate_batch(black_box([x, y, z]), [u, v, w], f)).expect("slices of one length");
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
    targets = rules
}
criterion_main!(benches);
