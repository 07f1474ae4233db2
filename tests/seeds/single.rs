//! What E's listings return in f32 that is not a number (formula notes, end of §3), next to the crate at the same inputs.

use crate::elek::{Dots, appendix_b, dots, normalize, up};
use crate::layered::{Algorithm1, algorithm_1, hlsl_refract};
use brdf::layered::{Interface, Layer, Model, Stack};
use brdf::{Vector, microfacet};

const N: f32 = 0.213;
const K: f32 = 4.05;

fn direction(theta: f64, phi: f64) -> Vector<f32> {
    crate::integrate::direction(theta, phi).cast()
}

fn listing(wi: Vector<f32>, wo: Vector<f32>, m: f32) -> f32 {
    appendix_b(dots(up(), wi, wo), N, K, m).value
}

/// The crate's value at the same inputs, which must be a number.
fn crate_value(wi: Vector<f32>, wo: Vector<f32>, m: f32) -> f32 {
    let f = microfacet::torrance_sparrow(wi, wo, N, K, m).f;
    assert!(f.is_finite() && f >= 0.0, "{wi:?} {wo:?} {m}: {f}");
    f
}

fn coated(upper_n: f32, sigma: f32, d: f32) -> Algorithm1<f32> {
    Algorithm1 { upper: (upper_n, 0.0, 0.1), lower: (N, K, 0.3), sigma, d, diffuse: 0.0, patina: false }
}

fn crate_stack(s: &Algorithm1<f32>, wi: Vector<f32>, wo: Vector<f32>) -> f32 {
    let layer = |(n, k, m)| Layer::new(Interface::conductor([n], [k], m));
    let stack = Stack::new(Model::Elek, vec![layer(s.upper).over([s.sigma], s.d), layer(s.lower)]).expect("valid");
    let [f] = stack.evaluate(wi, wo);
    assert!(f.is_finite() && f >= 0.0, "{f}");
    f
}

#[test]
fn a_view_at_the_horizon() {
    let (wi, wo) = (direction(40.0, 0.0), Vector::new(1.0, 0.0, 0.0));
    assert!(!listing(wi, wo, 0.3).is_finite());
    assert_eq!(crate_value(wi, wo, 0.3), 0.0);
}

#[test]
fn a_half_vector_at_the_horizon() {
    let d = Dots { nl: 0.5, nv: -0.5, nh: 0.0, vh: 0.8 };
    assert!(!appendix_b(d, N, K, 0.3).value.is_finite());
    let (wi, wo) = (Vector::new(0.6, 0.0, 0.8), Vector::new(0.6, 0.0, -0.8));
    assert_eq!(crate_value(wi, wo, 0.3), 0.0);
}

#[test]
fn a_light_behind_the_surface() {
    let wi = direction(40.0, 10.0);
    assert!(listing(wi, -wi, 0.3).is_nan());
    assert_eq!(crate_value(wi, -wi, 0.3), 0.0);
}

#[test]
fn no_roughness() {
    let (wi, wo) = (direction(40.0, 0.0), direction(40.0, 180.0));
    for (m, other) in [(0.0, direction(20.0, 0.0)), (1e-20, direction(20.0, 0.0)), (0.0, wo), (1e-20, wo)] {
        assert!(!listing(wi, other, m).is_finite(), "{m}");
        // Outside the domain of the term, which is closed where a stack is made.
        assert!(Stack::new(Model::Elek, vec![Layer::new(Interface::conductor([N], [K], m))]).is_err());
    }
    // At the end of the domain: the peak of 1/(πm²) at the mirror direction, nothing elsewhere.
    assert!(crate_value(wi, wo, 1e-4) > 1e6);
    assert_eq!(crate_value(wi, direction(20.0, 0.0), 1e-4), 0.0);
}

#[test]
fn total_reflection_on_entry() {
    let (wi, wo) = (direction(80.0, 0.0), direction(75.0, 180.0));
    assert_eq!(hlsl_refract(wi, up(), 1.0 / 0.8), Vector::new(0.0, 0.0, 0.0));
    let s = coated(0.8, 0.1, 1.0);
    assert!(algorithm_1(&s, up(), wi, wo).is_nan());
    assert!(crate_stack(&s, wi, wo) > 0.0);
}

#[test]
fn an_endless_clear_layer() {
    let (wi, wo) = (direction(40.0, 0.0), direction(30.0, 180.0));
    assert!(algorithm_1(&coated(1.5, 0.0, f32::INFINITY), up(), wi, wo).is_nan());
    // A stack takes finite thicknesses, and a clear layer of any costs nothing.
    let layer = Layer::new(Interface::<f32, 1>::dielectric(1.5, 0.1)).over([0.0], f32::INFINITY);
    assert!(Stack::new(Model::Elek, vec![layer, layer]).is_err());
    assert_eq!(crate_stack(&coated(1.5, 0.0, f32::MAX), wi, wo), crate_stack(&coated(1.5, 0.0, 0.0), wi, wo));
}

/// The i-th of a stream of directions all over the sphere.
fn sphere(i: u64) -> Vector<f32> {
    // SplitMix64.
    let uniform = |i: u64| {
        let x = i.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    };
    let (z, phi) = (2.0 * uniform(2 * i + 1) - 1.0, 360.0 * uniform(2 * i + 2));
    direction(z.acos().to_degrees(), phi)
}

#[test]
fn cosines_above_one() {
    let samples = 20_000;
    let (mut seen, mut above, mut nan, mut back) = (0, 0, 0, 0);
    for i in 0..samples {
        let normal = normalize(sphere(2 * i));
        let wi = normalize(sphere(2 * i + 1));
        if normal.dot(wi) <= 0.05 {
            continue;
        }
        // The peak: the view in the mirror direction.
        let wo = normalize(normal * (2.0 * normal.dot(wi)) - wi);
        let d = dots(normal, wi, wo);
        seen += 1;
        above += u32::from(d.nh > 1.0);
        nan += u32::from(appendix_b(d, N, K, 0.1).value.is_nan());
        back += u32::from(dots(normal, wi, wi).vh > 1.0);
    }
    assert_eq!(above, nan, "the listing is NaN exactly where NH > 1");
    let share = |count: u32| f64::from(count) / f64::from(seen);
    println!("NH > 1: {}, VH > 1: {}", share(above), share(back));
    // The notes say 18 % near the peak and 20 % at L = V. The share is that of how N, L and V are rounded: at the peak itself,
    // from 7 % (directions rounded once) to 23 % (all normalised in f32 by a reciprocal root, as here).
    assert!((share(above) - 0.23).abs() < 0.02, "NH > 1 in {}", share(above));
    assert!((share(back) - 0.21).abs() < 0.02, "VH > 1 in {}", share(back));
}
