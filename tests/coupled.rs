//! The coupled model against the walk, its closed forms, and the judge.
#![cfg(feature = "check")]

use brdf::Vector;
use brdf::check::{self, Effort, Fixed, StackSubject, Verdict};
use brdf::layered::{Coupled, Interface, Layer, Model, Stack, internal_reflectance};
use brdf::material::stack::built_in;
use brdf::walk::{self, Options};

fn coat<const C: usize>(n: f64, alpha: f64) -> Layer<f64, C> {
    Layer::new(Interface::dielectric(n, alpha))
}

fn diffuse(albedo: f64) -> Layer<f64, 1> {
    Layer::new(Interface::diffuse([albedo], 0.0))
}

fn copper(alpha: f64) -> Layer<f64, 3> {
    Layer::new(Interface::conductor([0.213, 1.04, 1.17], [4.05, 2.59, 2.36], alpha))
}

fn coupled<const C: usize>(layers: Vec<Layer<f64, C>>) -> Stack<f64, C> {
    Stack::new(Model::Coupled, layers).unwrap()
}

fn direction(theta: f64, phi: f64) -> Vector<f64> {
    Vector::from_angles(theta.to_radians(), phi.to_radians())
}

/// The largest relative distance of the albedo to the walk's, forgiving three standard errors, over 0–80°.
fn worst_albedo<const C: usize>(name: &str, stack: &Stack<f64, C>) -> f64 {
    let subject = StackSubject::new(name, stack.clone());
    let prepared = Coupled::new(stack);
    println!("{name}: built in {:.2?}, {} bytes", prepared.build_time(), prepared.bytes());
    let mut worst = 0.0f64;
    for theta in [0.0, 15.0, 30.0, 45.0, 60.0, 70.0, 80.0] {
        let have = check::albedo(&subject, theta, 0.0, Fixed::View, &Effort::default());
        let options = Options { samples: 1 << 19, seed: 77 + theta as u32, ..Options::default() };
        let truth = walk::albedo(stack, direction(theta, 0.0), &options);
        for c in 0..C {
            let (have, want, error) = (have.value[c], truth.mean[c], truth.standard_error[c]);
            let off = have / want - 1.0;
            println!("  {theta:4}° {c}: {have:.4} walk {want:.4} ± {error:.4}: {:+.2} %", 100.0 * off);
            worst = worst.max(((have - want).abs() - 3.0 * error).max(0.0) / want);
        }
    }
    worst
}

#[test]
fn internal_reflectances_are_the_published_ones() {
    for (n, want) in [(1.3, 0.444), (1.4, 0.529), (1.6, 0.651), (1.8, 0.733), (2.0, 0.790)] {
        assert!((internal_reflectance(n, 0.0, 0.0) - want).abs() < 5e-4, "{n}");
    }
    assert!((internal_reflectance(1.5, 0.0, 0.0) - 0.59635).abs() < 5e-6);
    // The last one is printed as .090 in the project's notes: it is .08947.
    for (tau, want) in [(0.1, 0.382), (0.2, 0.258), (0.5, 0.0895)] {
        assert!((internal_reflectance(1.5, 0.0, tau) - want).abs() < 5e-4, "{tau}");
        let stack = coupled(vec![coat(1.5, 0.01).over([tau], 1.0), diffuse(0.5)]);
        assert!((Coupled::new(&stack).internal_reflectance()[0] - want).abs() < 5e-4);
    }
}

#[test]
fn a_coated_diffuse_base_has_the_albedo_of_the_walk() {
    for alpha in [0.1, 0.3] {
        let stack = coupled(vec![coat(1.5, alpha), diffuse(0.5)]);
        let worst = worst_albedo(&format!("diffuse .5 under n = 1.5, m = {alpha}"), &stack);
        assert!(worst < 0.01, "{alpha}: {worst}");
    }
}

#[test]
fn a_coated_metal_has_the_albedo_of_the_walk() {
    for (top, base) in [(0.1, 0.1), (0.1, 0.3), (0.3, 0.1)] {
        let stack = coupled(vec![coat(1.5, top), copper(base)]);
        let worst = worst_albedo(&format!("Cu, m = {top}, {base}"), &stack);
        assert!(worst < 0.02, "{top} {base}: {worst}");
    }
}

#[test]
fn the_built_in_stacks_are_plausible() {
    for material in built_in() {
        let stack = material.stack.with_model(Model::Coupled);
        let prepared = Coupled::new(&stack);
        let options = check::Options { budget: 400_000, ..check::Options::default() };
        let report = check::check(&StackSubject::new(material.name, stack), &options);
        let peak = report.energy(Fixed::View).map_or(0.0, |finding| finding.value);
        println!("{}: ≤ {peak:.4}, {:.2?}, {} bytes", material.name, prepared.build_time(), prepared.bytes());
        assert_eq!(report.verdict(), Verdict::Pass, "{report}");
    }
}

#[test]
fn it_is_reciprocal_and_not_negative() {
    for material in built_in() {
        let stack = material.stack.with_model(Model::Coupled);
        for i in 0..4000 {
            let at = |axis: i32| (0.5 + f64::from(i) / 1.167_303_978_261_418_7_f64.powi(axis)).fract();
            let wi = direction(90.0 * at(1), 360.0 * at(2));
            let wo = if i % 2 == 0 { direction(90.0 * at(3), 360.0 * at(4)) } else { Vector::new(-wi.x, -wi.y, wi.z) };
            let (f, g) = (stack.evaluate(wi, wo), stack.evaluate(wo, wi));
            for c in 0..3 {
                assert!(f[c] >= 0.0 && f[c].is_finite(), "{} {f:?}", material.name);
                // The narrowest lobe, α = .002, turns the rounding of H into 1e-16·tan²θ/α² of f.
                assert!((f[c] - g[c]).abs() <= 1e-10 * f[c].max(1e-6), "{} {f:?} {g:?}", material.name);
            }
        }
    }
}
