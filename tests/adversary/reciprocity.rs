//! The reciprocity error |f(i, o) − f(o, i)|/max, maximised.
//!
//! Nothing is allowed: every form is symmetric in the two directions operation by operation, in either precision.

use crate::stacks::{PAIR, STACK, pair, stack};
use crate::strategy::Search;
use crate::{generations, in_parallel};
use brdf::layered::{Coupled, Interface, Layer, Model, Stack};
use brdf::{Real, Vector, diffuse, microfacet};

/// The largest relative difference of two results.
pub(crate) fn asymmetry<R: Real, const N: usize>(f: [R; N], swapped: [R; N]) -> f64 {
    let differ = |(a, b): (R, R)| {
        let (a, b) = (a.to_f64(), b.to_f64());
        if a == b { 0.0 } else { (a - b).abs() / a.abs().max(b.abs()) }
    };
    f.into_iter().zip(swapped).map(differ).fold(0.0, f64::max)
}

/// The asymmetry of a function in the precision of its directions.
fn swapped<R: Real, const N: usize>(f: impl Fn(Vector<R>, Vector<R>) -> [R; N], [wi, wo]: [Vector<f64>; 2]) -> f64 {
    let (wi, wo) = (wi.cast(), wo.cast());
    asymmetry(f(wi, wo), f(wo, wi))
}

/// Torrance–Sparrow and Oren–Nayar with the parameters of a stack's first layer.
fn single_layers<R: Real>(genes: &[f64]) -> f64 {
    let [g, h, s] = [genes[2], genes[3], genes[4]].map(R::from_f64);
    let (n, k, alpha) = (R::from_f64(0.02) + g, h + h, s.max(R::from_f64(1e-4)));
    let f = |wi: Vector<R>, wo: Vector<R>| {
        let base = diffuse::oren_nayar(wi, wo, s);
        [
            microfacet::torrance_sparrow(wi, wo, n, k, alpha).f,
            base.direct,
            base.interreflection,
            base.f(g),
            diffuse::oren_nayar_qualitative(wi, wo, s, g),
        ]
    };
    swapped(f, pair(&genes[STACK..]))
}

fn closed_form(model: Model, genes: &[f64]) -> [f64; 2] {
    let stack = Stack::new(model, stack(genes)).unwrap_or_else(|error| panic!("{error}"));
    let single = stack.cast::<f32>();
    let pair = pair(&genes[STACK..]);
    [swapped(|i, o| stack.evaluate(i, o), pair), swapped(|i: Vector<f32>, o| single.evaluate(i, o), pair)]
}

#[test]
fn no_stack_tells_light_from_view() {
    let jobs: Vec<_> = Model::CLOSED_FORM.into_iter().flat_map(|model| [(model, 1), (model, 2)]).collect();
    let found = in_parallel(jobs, |(model, seed)| {
        let search = Search { genes: STACK + PAIR, generations: generations(400), restarts: 3, seed };
        let find = search.run(|genes| closed_form(model, genes).into_iter().fold(0.0, f64::max));
        (model, find)
    });
    for (model, find) in found {
        println!("{}: {:e} of {} evaluations", model.name(), find.fitness, find.evaluations);
        let (layers, pair) = (stack(&find.genes), pair(&find.genes[STACK..]));
        assert!(find.fitness == 0.0, "{}: {:e} for {layers:?} at {pair:?}", model.name(), find.fitness);
    }
}

#[test]
fn no_single_interface_tells_light_from_view() {
    let search = Search { genes: STACK + PAIR, generations: generations(1000), restarts: 3, seed: 3 };
    let find = search.run(|genes| single_layers::<f64>(genes).max(single_layers::<f32>(genes)));
    assert!(find.fitness == 0.0, "{:e} at {:?} {:?}", find.fitness, &find.genes[2..5], pair(&find.genes[STACK..]));
}

#[test]
fn no_prepared_stack_tells_light_from_view() {
    let coat = |n, alpha| Layer::new(Interface::dielectric(n, alpha)).over([0.5, 0.0], 0.4);
    let stacks = [
        vec![coat(1.5, 0.2), Layer::new(Interface::diffuse([0.5, 1.0], 0.6))],
        vec![coat(1.5, 0.01), Layer::new(Interface::diffuse([0.5, 1.0], 0.0))],
        vec![coat(1.5, 0.1), Layer::new(Interface::conductor([0.2, 1.2], [3.0, 2.4], 0.3))],
        vec![coat(0.7, 0.3), coat(1.4, 0.1), Layer::new(Interface::diffuse([0.9, 0.1], 0.3))],
    ];
    for layers in stacks {
        let stack = Stack::new(Model::Coupled, layers).expect("valid layers");
        let (double, single) = (Coupled::new(&stack), Coupled::new(&stack.cast::<f32>()));
        let search = Search { genes: PAIR, generations: generations(1500), restarts: 3, seed: 4 };
        let find = search.run(|genes| {
            let in_single = swapped(|i: Vector<f32>, o| single.evaluate(i, o), pair(genes));
            swapped(|i, o| double.evaluate(i, o), pair(genes)).max(in_single)
        });
        println!("coupled: {:e} of {} evaluations, {:?}", find.fitness, find.evaluations, stack.layers());
        assert!(find.fitness == 0.0, "{:e} for {:?} at {:?}", find.fitness, stack.layers(), pair(&find.genes));
    }
}
