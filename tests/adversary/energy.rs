//! Directional albedo, maximised.

use crate::stacks::decades;
use crate::strategy::Search;
use crate::{generations, in_parallel};
use brdf::check::{Effort, Fixed, StackSubject, albedo};
use brdf::layered::{Interface, Layer, Model, Stack};

/// How the index goes down through the interfaces that light passes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Order { Denser, Thinner, Vacuum }

fn layers(order: Order, g: &[f64]) -> Vec<Layer<f64, 1>> {
    let covers = 1 + ((g[0] * 3.0) as usize).min(2);
    let covers = if order == Order::Thinner { covers.max(2) } else { covers };
    let mut layers = Vec::new();
    let mut n = 1.0;
    for i in 0..covers {
        let g = &g[6 + 3 * i..];
        n = match order {
            Order::Denser => n * (1.0 + decades(g[0], 5e-3, 2.0)),
            Order::Thinner if i + 1 < covers => decades(g[0], 1.05, 6.0),
            Order::Thinner => 1f64.max(n * (0.2 + 0.75 * g[0])),
            Order::Vacuum => decades(g[0], 0.01, 10.0),
        };
        let k = if g[2] < 0.7 { 0.0 } else { decades((g[2] - 0.7) / 0.3, 1e-3, 10.0) };
        layers.push(Layer::new(Interface::conductor([n], [k], decades(g[1], 1e-2, 1.0))));
    }
    layers.push(match (g[1] * 3.0) as u32 {
        0 => Layer::new(Interface::diffuse([1.0], 0.0)),
        1 => Layer::new(Interface::conductor([1e-3], [decades(g[2], 3.0, 1000.0)], decades(g[3], 5e-3, 1.0))),
        _ => Layer::new(Interface::conductor([decades(g[2], 0.01, 1000.0)], [0.0], decades(g[3], 5e-3, 1.0))),
    });
    layers
}

fn value(model: Model, layers: Vec<Layer<f64, 1>>, theta: f64, effort: &Effort) -> f64 {
    let subject = StackSubject::new("", Stack::new(model, layers).expect("valid"));
    albedo(&subject, theta, 0.0, Fixed::View, effort).value[0]
}

#[test]
fn explore() {
    let g = generations(20);
    let quick = Effort { target: 1e-3, evaluations: 6000, replicates: 0, ..Effort::default() };
    for line in in_parallel(vec![Order::Vacuum, Order::Thinner], |order| {
        let search = Search { genes: 15, generations: g, restarts: 4, seed: 2 };
        let theta = |genes: &[f64]| if genes[4] < 0.5 { 180.0 * genes[4] } else { 90.0 - decades(2.0 - 2.0 * genes[4], 1e-3, 90.0) };
        let start = std::time::Instant::now();
        let find = search.run(|genes| value(Model::Conserving, layers(order, genes), theta(genes), &quick));
        let ls = layers(order, &find.genes);
        let exact = value(Model::Conserving, ls.clone(), theta(&find.genes), &Effort::default());
        format!("{order:?} {} evals {:.1?}: {} exact {exact} theta {} {ls:?}", find.evaluations, start.elapsed(), find.fitness, theta(&find.genes))
    }) { println!("{line}"); }
}

#[test]
fn grid() {
    let quick = Effort { target: 1e-3, evaluations: 6000, replicates: 0, ..Effort::default() };
    let mut jobs = Vec::new();
    for n in [1.02, 1.1, 1.3, 1.5, 2.0, 4.0] { for a in [0.03, 0.1, 0.2, 0.4, 0.8] { for b in [0.01, 0.1, 0.3, 0.6, 2.0] { jobs.push((n, a, b)); } } }
    let mut found = in_parallel(jobs, |(n, a, b)| {
        let base = if b > 1.0 { Layer::new(Interface::diffuse([1.0], 0.0)) } else { Layer::new(Interface::conductor([1e-3], [1000.0], b)) };
        [50.0, 70.0, 80.0, 85.0, 88.0, 89.5].map(|theta: f64| (value(Model::Conserving, vec![Layer::new(Interface::dielectric(n, a)), base], theta, &quick), theta, n, a, b)).into_iter().max_by(|x, y| x.0.total_cmp(&y.0)).unwrap()
    });
    found.sort_by(|x, y| y.0.total_cmp(&x.0));
    for f in &found[..12] { println!("GRID {f:?}"); }
}
