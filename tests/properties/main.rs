//! What must hold of every term, BRDF and stack whatever the input, by property-based testing.
//!
//! Inputs are drawn as integers and scaled, so that a failure shrinks to round numbers. Each tolerance says where it
//! comes from; ε is the spacing above 1 of the number type. `PROPTEST_CASES=10000 cargo test --test properties` digs
//! deeper than the default of 256 cases.

mod below_the_surface;
mod every_brdf;
mod facets;
mod reflectance;
mod stacks;
mod wild_input;

use brdf::layered::{Interface, Layer, Model, Stack};
use brdf::{Frame, Real, Vector, half_vector};
use brdf::{absorption, diffuse, distribution, fresnel, layered, masking, material, microfacet, phong, refraction};
use proptest::prelude::*;
use std::f64::consts::PI;

const EPS: f64 = f64::EPSILON;

/// A number of `low..=high` steps of 1/`steps`.
fn scaled(low: u32, high: u32, steps: u32) -> impl Strategy<Value = f64> {
    (low..=high).prop_map(move |i| f64::from(i) / f64::from(steps))
}

/// 10^−e for e in [0, `decades`].
fn decades(decades: u32) -> impl Strategy<Value = f64> {
    scaled(0, decades * 100, 100).prop_map(|e| 10f64.powf(-e))
}

/// A cosine in (0, 1], to grazing 1e-7.
fn cosine() -> impl Strategy<Value = f64> {
    prop_oneof![scaled(1, 1000, 1000), decades(7)]
}

/// A unit direction above the horizon.
fn upper() -> impl Strategy<Value = Vector<f64>> {
    (cosine(), 0u32..360).prop_map(|(cos, degrees)| direction(cos, f64::from(degrees).to_radians()))
}

/// A unit direction at or below the horizon.
fn lower() -> impl Strategy<Value = Vector<f64>> {
    (prop_oneof![Just(0.0), cosine()], 0u32..360)
        .prop_map(|(cos, degrees)| direction(-cos, f64::from(degrees).to_radians()))
}

fn direction(cos: f64, phi: f64) -> Vector<f64> {
    let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
    Vector::new(sin * phi.cos(), sin * phi.sin(), cos)
}

/// A width in [1e-3, 1].
fn alpha() -> impl Strategy<Value = f64> {
    prop_oneof![scaled(1, 100, 100), decades(3)]
}

/// A relative index of a dielectric in [1/4, 4].
fn eta() -> impl Strategy<Value = f64> {
    prop_oneof![scaled(25, 400, 100), decades(9).prop_map(|d| 1.0 + d), decades(9).prop_map(|d| 1.0 - 0.5 * d)]
}

/// n in [.02, 8], κ in [0, 12].
fn index() -> impl Strategy<Value = (f64, f64)> {
    (
        prop_oneof![scaled(2, 800, 100), decades(9).prop_map(|d| 1.0 + d)],
        prop_oneof![Just(0.0), scaled(0, 1200, 100), decades(9)],
    )
}

fn medium() -> impl Strategy<Value = ([f64; 3], f64)> {
    ([scaled(0, 300, 100), scaled(0, 300, 100), scaled(0, 300, 100)], scaled(0, 200, 100))
}

fn microfacet_layer() -> impl Strategy<Value = Layer<f64, 3>> {
    let n = prop_oneof![
        scaled(50, 400, 100).prop_map(|n| [n; 3]),
        [scaled(50, 400, 100), scaled(50, 400, 100), scaled(50, 400, 100)]
    ];
    let k = prop_oneof![Just([0.0; 3]), [scaled(0, 500, 100), scaled(0, 500, 100), scaled(0, 500, 100)]];
    (n, k, alpha(), medium()).prop_map(|(n, k, alpha, (sigma, thickness))| {
        Layer::new(Interface::conductor(n, k, alpha)).over(sigma, thickness)
    })
}

fn base() -> impl Strategy<Value = Layer<f64, 3>> {
    let diffuse = ([scaled(0, 100, 100), scaled(0, 100, 100), scaled(0, 100, 100)], scaled(0, 150, 100))
        .prop_map(|(albedo, sigma)| Layer::new(Interface::diffuse(albedo, sigma)));
    prop_oneof![microfacet_layer(), diffuse]
}

/// Up to three interfaces over a base.
fn layers() -> impl Strategy<Value = Vec<Layer<f64, 3>>> {
    (prop::collection::vec(microfacet_layer(), 0..=3), base()).prop_map(|(mut layers, base)| {
        layers.push(base);
        layers
    })
}

fn model() -> impl Strategy<Value = Model> {
    (0..Model::CLOSED_FORM.len()).prop_map(|i| Model::CLOSED_FORM[i])
}

fn stack(model: Model, layers: Vec<Layer<f64, 3>>) -> Stack<f64, 3> {
    Stack::new(model, layers).expect("the strategies draw valid layers")
}

/// Numbers that no one should pass.
fn wild() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(0.0),
        Just(-0.0),
        Just(1.0),
        Just(-1.0),
        Just(f64::NAN),
        Just(f64::INFINITY),
        Just(f64::NEG_INFINITY),
        Just(f64::MAX),
        Just(f64::MIN_POSITIVE),
        Just(1e-45),
        Just(3.4e38),
        any::<f64>()
    ]
}

/// |a−b| ≤ ulps·ε·max(|a|, |b|).
fn close(a: f64, b: f64, ulps: f64) -> bool {
    (a - b).abs() <= ulps * EPS * a.abs().max(b.abs())
}
