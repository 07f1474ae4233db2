//! The reciprocity error |f(i, o) − f(o, i)|, maximised.
//!
//! Every form is symmetric in the two directions to the last bit, in either precision, so that nothing is allowed, but for
//! Oren–Nayar's at equal cosines: which polar angle is the larger is then decided by the order of the two. Their sines
//! differ by the rounding of the directions, 2 ε of each, and meet tangents of at most 1/cos.

use crate::stacks::{PAIR, STACK, decades, pair, stack};
use crate::strategy::Search;
use crate::{generations, in_parallel};
use brdf::layered::{Coupled, Interface, Layer, Model, Stack};
use brdf::{Real, Vector, diffuse, microfacet};

/// The larger of the relative difference and, where the order of two equal cosines may decide, nothing.
fn asymmetry<R: Real>(f: &[R], swapped: &[R]) -> f64 {
    let differ = |a: f64, b: f64| if a == b { 0.0 } else { (a - b).abs() / a.abs().max(b.abs()) };
    f.iter().zip(swapped).map(|(a, b)| differ(a.to_f64(), b.to_f64())).fold(0.0, f64::max)
}

fn is_diffuse(layers: &[Layer<f64, 2>]) -> bool {
    matches!(layers.last(), Some(Layer { interface: Interface::Diffuse { .. }, .. }))
}

#[test]
fn explore() {
    let g = generations(300);
    let jobs: Vec<(Model, bool)> = Model::CLOSED_FORM.into_iter().flat_map(|m| [(m, true), (m, false)]).collect();
    for line in in_parallel(jobs, |(model, diffuse)| {
        let search = Search { genes: STACK + PAIR, generations: g, restarts: 4, seed: 5 };
        let value = |genes: &[f64]| {
            let layers = stack(genes);
            if is_diffuse(&layers) != diffuse { return [-1.0, -1.0, 0.0]; }
            let stack = Stack::new(model, layers).expect("valid");
            let [wi, wo] = pair(&genes[STACK..]);
            let (si, so) = (wi.cast::<f32>(), wo.cast::<f32>());
            let single = stack.cast::<f32>();
            let (a, b) = (stack.evaluate(wi, wo), stack.evaluate(wo, wi));
            let (c, d) = (single.evaluate(si, so), single.evaluate(so, si));
            [asymmetry(&a, &b), asymmetry(&c, &d), 0.0]
        };
        let find = search.run(|genes| { let v = value(genes); v[0].max(v[1] * 1e-9) });
        format!("{model:?} diffuse {diffuse}: {:?} {:?} {:?}", value(&find.genes), stack(&find.genes), pair(&find.genes[STACK..]))
    }) { println!("{line}"); }
    let _ = (decades(0.0,1.0,1.0), diffuse::lambert(1.0), microfacet::cos_half(Vector::new(0.0,0.0,1.0), Vector::new(0.0,0.0,1.0)));
    let _ = |s: &Stack<f64, 2>| Coupled::new(s);
}
