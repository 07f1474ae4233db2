//! What E's listings return in f32 that is not a number (formula notes, end of §3), next to the crate at the same inputs.

use crate::elek::{Dots, appendix_b, dots, normalize, up};
use crate::layered::{Algorithm1, algorithm_1, hlsl_refract};
use crate::mihaylov::shader_pow;
use brdf::layered::{Interface, Layer, Model, Stack};
use brdf::{Frame, Vector, microfacet};

const N: f32 = 0.213;
const K: f32 = 4.05;

fn direction(theta: f64, phi: f64) -> Vector<f32> {
    crate::integrate::direction(theta, phi).cast()
}

fn listing(wi: Vector<f32>, wo: Vector<f32>, m: f32) -> f32 {
    appendix_b(dots(up(), wi, wo), N, K, m).value
}

fn coated(upper_n: f32, sigma: f32, d: f32) -> Algorithm1<f32> {
    Algorithm1 { upper: (upper_n, 0.0, 0.1), lower: (N, K, 0.3), sigma, d, diffuse: 0.0, patina: false }
}

fn evaluated(s: &Algorithm1<f32>, wi: Vector<f32>, wo: Vector<f32>) -> Answer {
    let layer = |(n, k, m)| Layer::new(Interface::<f32, 1>::conductor([n], [k], m));
    Stack::new(Model::Elek, vec![layer(s.upper).over([s.sigma], s.d), layer(s.lower)])
        .map_or_else(|_| Answer::Refused, |stack| Answer::Value(stack.evaluate(wi, wo)[0]))
}

/// What the crate makes of an input.
pub(crate) enum Answer {
    /// f in sr⁻¹.
    Value(f32),
    /// A stack is not made of it.
    Refused,
}

/// An input that the listings cannot take.
pub(crate) struct Case {
    pub(crate) what: &'static str,
    /// What the listing returns.
    pub(crate) printed: f32,
    crate_answer: Answer,
}

impl Case {
    /// The crate's answer as the document shows it.
    pub(crate) fn answer(&self) -> &'static str {
        match self.crate_answer {
            Answer::Value(f) => class(f),
            Answer::Refused => "refused, with the key and its range",
        }
    }
}

/// The kind of a number, which is the same on every machine.
pub(crate) fn class(f: f32) -> &'static str {
    match f {
        f if f.is_nan() => "NaN",
        f if f.is_infinite() => "∞",
        f if f > 0.0 => "finite, > 0",
        0.0 => "0",
        _ => "finite, < 0",
    }
}

/// Every input of the formula notes, end of §3.
pub(crate) fn cases() -> Vec<Case> {
    let (wi, wo, mirror) = (direction(40.0, 0.0), direction(30.0, 170.0), direction(40.0, 180.0));
    let horizon = Vector::new(1.0, 0.0, 0.0);
    let below = Vector::new(wi.x, wi.y, -wi.z);
    let bare = |m| {
        Stack::new(Model::Elek, vec![Layer::new(Interface::<f32, 1>::conductor([N], [K], m))])
            .map_or_else(|_| Answer::Refused, |stack| Answer::Value(stack.evaluate(wi, mirror)[0]))
    };
    let value = |wi, wo| Answer::Value(microfacet::torrance_sparrow(wi, wo, N, K, 0.3).f);
    let (low, endless) = (coated(0.8, 0.1, 1.0), coated(1.5, 0.0, f32::INFINITY));
    let thick = coated(1.5, 0.0, f32::MAX);
    let (steep_i, steep_o) = (direction(80.0, 0.0), direction(75.0, 180.0));
    vec![
        Case { what: "NV = 0", printed: listing(wi, horizon, 0.3), crate_answer: value(wi, horizon) },
        Case { what: "NH = 0", printed: listing(wi, below, 0.3), crate_answer: value(wi, below) },
        Case { what: "L = −V", printed: listing(wi, -wi, 0.3), crate_answer: value(wi, -wi) },
        Case { what: "m = 0, at the mirror direction", printed: listing(wi, mirror, 0.0), crate_answer: bare(0.0) },
        Case { what: "m = 0, beside it", printed: listing(wi, wo, 0.0), crate_answer: bare(0.0) },
        Case {
            what: "m = 1e-20, at the mirror direction",
            printed: listing(wi, mirror, 1e-20),
            crate_answer: bare(1e-20),
        },
        Case { what: "m = 1e-20, beside it", printed: listing(wi, wo, 1e-20), crate_answer: bare(1e-20) },
        Case {
            what: "n₁ = .8 with total reflection on entry, 80° and 75°",
            printed: algorithm_1(&low, up(), steep_i, steep_o),
            crate_answer: evaluated(&low, steep_i, steep_o),
        },
        Case {
            what: "d = ∞ with σ = 0",
            printed: algorithm_1(&endless, up(), wi, wo),
            crate_answer: evaluated(&endless, wi, wo),
        },
        Case {
            what: "d = the largest f32 with σ = 0",
            printed: algorithm_1(&thick, up(), wi, wo),
            crate_answer: evaluated(&thick, wi, wo),
        },
    ]
}

#[test]
fn the_listing_fails_and_the_crate_does_not() {
    for case in cases() {
        println!("{}: {} {}", case.what, case.printed, case.answer());
        assert!(!case.printed.is_finite() || case.what.contains("largest"), "{}: {}", case.what, case.printed);
        if let Answer::Value(f) = case.crate_answer {
            assert!(f.is_finite() && f >= 0.0, "{}: {f}", case.what);
        }
    }
}

#[test]
fn what_is_refused_and_what_is_dark() {
    let refused: Vec<_> =
        cases().into_iter().filter(|c| matches!(c.crate_answer, Answer::Refused)).map(|c| c.what).collect();
    assert_eq!(refused.len(), 5, "{refused:?}");
    assert!(refused.iter().all(|what| what.starts_with("m = ") || *what == "d = ∞ with σ = 0"), "{refused:?}");
    let dark: Vec<_> =
        cases().into_iter().filter(|c| matches!(c.crate_answer, Answer::Value(0.0))).map(|c| c.what).collect();
    assert_eq!(dark, ["NV = 0", "NH = 0", "L = −V"]);
    assert_eq!(hlsl_refract(direction(80.0, 0.0), up(), 1.0 / 0.8), Vector::new(0.0, 0.0, 0.0));
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

/// The shares of samples with NH > 1 at the peak, where the view is the mirror direction, and with VH > 1 at L = V.
///
/// `make` rounds a direction, `unit` normalises a vector that is not one.
pub(crate) fn shares_above_one(
    make: fn(Vector<f32>) -> Vector<f32>,
    unit: fn(Vector<f32>) -> Vector<f32>,
) -> (f64, f64) {
    let (mut seen, mut peak, mut retro) = (0, 0, 0);
    for i in 0..20_000 {
        let (normal, wi) = (make(sphere(2 * i)), make(sphere(2 * i + 1)));
        if normal.dot(wi) <= 0.05 {
            continue;
        }
        let wo = unit(normal * (2.0 * normal.dot(wi)) - wi);
        let half = unit(wi + wo);
        let d = Dots { nl: normal.dot(wi), nv: normal.dot(wo), nh: normal.dot(half), vh: wo.dot(half) };
        assert_eq!(appendix_b(d, N, K, 0.1).value.is_nan(), d.nh > 1.0, "{normal:?} {wi:?}");
        let q = f64::from(1.0 - wi.dot(unit(wi + wi)));
        assert_eq!(shader_pow(q, 5.0).is_nan(), q < 0.0);
        seen += 1;
        peak += u32::from(d.nh > 1.0);
        retro += u32::from(q < 0.0);

        let frame = Frame::from_normal(normal);
        for view in [wo, wi] {
            let f = microfacet::torrance_sparrow(frame.to_local(wi), frame.to_local(view), N, K, 0.1).f;
            assert!(f.is_finite() && f >= 0.0, "{normal:?} {wi:?}: {f}");
        }
    }
    (f64::from(peak) / f64::from(seen), f64::from(retro) / f64::from(seen))
}

/// All directions normalised in f32, by a reciprocal root: a shader's way.
pub(crate) fn shares_in_a_shader() -> (f64, f64) {
    shares_above_one(normalize, normalize)
}

/// Directions rounded once from f64, H divided by its length.
pub(crate) fn shares_at_best() -> (f64, f64) {
    shares_above_one(
        |v| v,
        |v| {
            let length = v.length_squared().sqrt();
            Vector::new(v.x / length, v.y / length, v.z / length)
        },
    )
}

#[test]
fn cosines_above_one() {
    let (worst, best) = (shares_in_a_shader(), shares_at_best());
    println!("NH > 1, VH > 1: {worst:?} {best:?}");
    for (share, want) in [(worst.0, 0.23), (worst.1, 0.21), (best.0, 0.07), (best.1, 0.07)] {
        assert!((share - want).abs() < 0.01, "{share}, want {want}");
    }
}
