//! Terms of one argument, and of more with all but one fixed, at every f32 of the domain.
//!
//! `ACCURACY_EXHAUSTIVE=1 cargo test --release --test accuracy every_f32 -- --nocapture` takes all of them and, with
//! `BRDF_BLESS=1`, records what it found in `full.csv`; an ordinary run takes every 4099th.

use crate::meter::{Meter, error};
use brdf::Real;
use brdf::{absorption, diffuse, fresnel, refraction};

/// A function of one f32.
pub(crate) struct Section {
    pub(crate) name: &'static str,
    low: f32,
    high: f32,
    single: fn(f32) -> f32,
    double: fn(f64) -> f64,
}

macro_rules! section {
    ($name:literal, $low:literal, $high:literal, |$x:ident| $body:expr) => {{
        fn evaluate<R: Real>($x: R) -> R {
            $body
        }
        Section { name: $name, low: $low, high: $high, single: evaluate::<f32>, double: evaluate::<f64> }
    }};
}

/// A constant that both precisions share.
fn c<R: Real>(x: f32) -> R {
    R::from_f64(f64::from(x))
}

pub(crate) fn sections() -> Vec<Section> {
    vec![
        section!("diffuse::lambert, ρ", 1e-6, 1.0, |x| diffuse::lambert(x)),
        section!("real::erfcx, x", 1e-6, 1e4, |x| x.erfcx()),
        section!("fresnel::normal_incidence, n at κ = 0", 0.02, 8.0, |x| fresnel::normal_incidence(x, R::ZERO)),
        section!("fresnel::dielectric F, cos at η = 1.5", 1e-6, 1.0, |x| fresnel::dielectric(x, c(1.5)).reflectance),
        section!("fresnel::dielectric T, cos at η = 1.5", 1e-6, 1.0, |x| fresnel::dielectric(x, c(1.5)).transmittance),
        section!("fresnel::dielectric F, cos at η = 1/1.5", 1e-6, 1.0, |x| fresnel::dielectric(x, c(1.0 / 1.5))
            .reflectance),
        section!("fresnel::dielectric T, cos at η = 1/1.5", 1e-6, 1.0, |x| fresnel::dielectric(x, c(1.0 / 1.5))
            .transmittance),
        section!("fresnel::conductor F, cos for copper at 550 nm", 1e-6, 1.0, |x| fresnel::conductor(
            x,
            c(1.04),
            c(2.59)
        )
        .reflectance),
        section!("fresnel::conductor T, cos for copper at 550 nm", 1e-6, 1.0, |x| fresnel::conductor(
            x,
            c(1.04),
            c(2.59)
        )
        .transmittance),
        section!("fresnel::schlick F, cos at F₀ = .04", 1e-6, 1.0, |x| fresnel::schlick(x, c(0.04)).reflectance),
        section!("fresnel::schlick T, cos at F₀ = .04", 1e-6, 1.0, |x| fresnel::schlick(x, c(0.04)).transmittance),
        section!("refraction::cos_t, cos at η = 1/1.5", 1e-6, 1.0, |x| refraction::cos_t(x, c(1.0 / 1.5))),
        section!("absorption::transmittance, σ at d = cos = 1", 1e-6, 43.0, |x| absorption::transmittance(
            x,
            R::ONE,
            R::ONE,
            R::ONE
        )),
    ]
}

/// Measures a section at every `step`-th f32.
pub(crate) fn measure(section: &Section, step: u32) -> Meter {
    let mut meter = Meter::default();
    let mut bits = section.low.to_bits();
    let end = section.high.to_bits();
    while bits <= end {
        let x = f32::from_bits(bits);
        meter.add(error((section.single)(x), (section.double)(f64::from(x))), &[x]);
        bits += step.min(if bits == end { step } else { end - bits });
    }
    meter
}

/// The largest error that a section may have: half an ULP and a tenth.
const BOUND: f64 = 0.6;

#[test]
fn every_f32() {
    let all = std::env::var_os("ACCURACY_EXHAUSTIVE").is_some_and(|value| value == "1");
    let bless = std::env::var_os("BRDF_BLESS").is_some_and(|value| value == "1");
    let mut record = String::from("section,f32 numbers,max ULP,at\n");
    for section in sections() {
        let meter = measure(&section, if all { 1 } else { 4099 });
        let line = format!("\"{}\",{},{:.4},{:e}\n", section.name, meter.samples, meter.worst, meter.at[0]);
        print!("{line}");
        record += &line;
        assert!(meter.worst <= BOUND, "{}: {} ULP at {:?}", section.name, meter.worst, meter.at);
    }
    if all && bless {
        std::fs::write(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/accuracy/full.csv"), record)
            .expect("the record can be written");
    }
}
