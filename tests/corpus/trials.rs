//! What a judge is tried with: lobes as narrow as there are, lobes off every beaten track, steps, dents and holes.

use crate::microfacet::{ggx, ggx_smith, smith};
use crate::{Case, Energy, judge_all, one};
use brdf::check::{Cause, Check, Options, Verdict, check};
use brdf::{Vector, half_vector};
use std::f64::consts::{FRAC_1_PI, PI};

fn at(theta: f64, phi: f64) -> Vector<f64> {
    Vector::from_angles(theta.to_radians(), phi.to_radians())
}

/// A symmetric product of a bump about one direction with itself, whose albedo with the other one at its top is `top`.
fn spike(theta: f64, width: f64, top: f64) -> impl Fn(Vector<f64>, Vector<f64>) -> f64 + Send + Sync {
    let centre = at(theta, 0.0);
    // ∫ exp(−d²/w²) dω = π w².
    let scale = top / (PI * width * width * centre.z);
    move |wi, wo| {
        let bump = |v: Vector<f64>| (-(v - centre).length_squared() / (width * width)).exp();
        scale * bump(wi) * bump(wo)
    }
}

#[test]
fn narrow_lobes() {
    let mut cases: Vec<Case> = Vec::new();
    for alpha in [1e-4, 3e-4, 1e-3] {
        // Twice what is allowed: it must not be read as 0.
        cases.push(
            one(format!("2·GGX α={alpha}"), move |wi, wo| 2.0 * ggx_smith(alpha)(wi, wo))
                .energy(Energy::Fail(2.0, 0.01)),
        );
        // A retro-reflector: GGX with the view mirrored.
        let retro = move |wi: Vector<f64>, wo: Vector<f64>| {
            let mirrored = Vector::new(-wo.x, -wo.y, wo.z);
            ggx(half_vector(wi, mirrored), alpha) * smith(wi, mirrored, alpha, alpha)
        };
        cases.push(one(format!("retro α={alpha}"), retro).energy(Energy::Pass));
        cases.push(
            one(format!("1.2·retro α={alpha}"), move |wi, wo| 1.2 * retro(wi, wo)).energy(Energy::Fail(1.2, 0.01)),
        );
    }
    // Mirrors that are turned about the normal: off-specular at every angle but the normal.
    let turned = |angle: f64, alpha: f64| {
        let (sin, cos) = angle.to_radians().sin_cos();
        move |wi: Vector<f64>, wo: Vector<f64>| {
            let wo = Vector::new(wo.x * cos - wo.y * sin, wo.x * sin + wo.y * cos, wo.z);
            ggx(half_vector(wi, wo), alpha) * smith(wi, wo, alpha, alpha)
        }
    };
    cases.push(one("turned mirror 40° α=.01", turned(40.0, 0.01)).energy(Energy::Pass).fails(Check::Reciprocity));
    judge_all(&cases);
}

#[test]
fn bumps_in_theta() {
    // A ring about the normal, that reflects `top` where it is and nothing elsewhere.
    let ring = |theta: f64, width: f64, top: f64| {
        let (theta, width) = (theta.to_radians(), width.to_radians());
        let scale = top / (2.0 * PI * PI.sqrt() * width * theta.sin() * theta.cos());
        move |wi: Vector<f64>, wo: Vector<f64>| {
            let bump = |v: Vector<f64>| (-((v.z.clamp(-1.0, 1.0).acos() - theta) / width).powi(2)).exp();
            scale * bump(wi) * bump(wo)
        }
    };
    judge_all(&[
        one("ring at 52.3°, 4°", ring(52.3, 4.0, 1.3)).energy(Energy::Fail(1.3, 0.01)),
        one("ring at 52.3°, .5°", ring(52.3, 0.5, 1.3)).energy(Energy::Over),
        one("ring over Lambert .5", move |wi, wo| 0.5 * FRAC_1_PI + ring(66.6, 0.3, 0.8)(wi, wo)).energy(Energy::Over),
        // As fine as is resolved: an open verdict is honest, a failure would be a false alarm.
        one("ring, .9", ring(52.3, 0.5, 0.9)).energy(Energy::NotFail),
        // One direction alone, in an anisotropic subject.
        one("spike at 30°, 10° wide", spike(30.0, 0.17, 1.4)).energy(Energy::Over),
    ]);
}

/// NaN where either direction is within `radius` of one.
fn hole(theta: f64, phi: f64, radius: f64) -> impl Fn(Vector<f64>, Vector<f64>) -> f64 + Send + Sync {
    let centre = at(theta, phi);
    move |wi, wo| {
        let inside = |v: Vector<f64>| (v - centre).length_squared() < radius * radius;
        if inside(wi) || inside(wo) { f64::NAN } else { 0.5 * FRAC_1_PI }
    }
}

#[test]
fn what_is_too_small_to_be_met_is_not_excluded() {
    let radius = 1e-3;
    let subject = one("NaN within 1e-3 of a direction", hole(41.0, 77.0, radius)).subject;
    for seed in crate::SEEDS {
        let report = check(&*subject, &Options { seed, ..Options::default() });
        println!("{report}");
        let found = report.finding(Check::Finite).is_some_and(|finding| finding.verdict == Verdict::Fail);
        // Either direction, of projected solid angle π r² cosθ.
        let measure = 2.0 * radius * radius * 41f64.to_radians().cos();
        let excluded = 3.0 / report.coverage.pairs as f64;
        let said = report.to_string().contains("smaller regions are not excluded");
        assert!(found || (measure < excluded && said), "{report}");
    }
}

#[test]
fn dents_steps_and_holes() {
    judge_all(&[
        one("NaN within 1e-3 of the normal", hole(0.0, 0.0, 1e-3)).energy(Energy::Any).fails(Check::Finite).any_cause(),
        one("NaN within .02 of a direction", hole(41.0, 77.0, 0.02))
            .energy(Energy::Any)
            .fails(Check::Finite)
            .any_cause(),
        one("infinite at grazing below 1e-6", |wi, wo| if wi.z.min(wo.z) < 1e-6 { f64::INFINITY } else { 0.1 })
            .energy(Energy::Any)
            .fails(Check::Finite)
            .cause(Cause::AtGrazing),
        // A checkerboard in azimuth and angle, of the two arguments together and symmetric.
        one("checkerboard", |wi, wo| {
            let square = |v: Vector<f64>| ((v.x * 5.0).floor() + (v.y * 5.0).floor()) as i64;
            if (square(wi) + square(wo)).rem_euclid(2) == 0 { FRAC_1_PI } else { 0.2 * FRAC_1_PI }
        }),
        one("step at 45°", |wi, wo| if (wi.z > 0.707) == (wo.z > 0.707) { FRAC_1_PI } else { 0.0 }),
        one("step over 1", |wi, wo| if (wi.z > 0.5) == (wo.z > 0.5) { 1.5 * FRAC_1_PI } else { 0.0 })
            .energy(Energy::Over),
        one("non-reciprocal by 1e-6", |wi, wo| 0.3 * (1.0 + 1e-6 * wi.z * wo.z * wo.z))
            .fails(Check::Reciprocity)
            .any_cause(),
        one("non-reciprocal by 1e-7, off the axis", |wi, wo| 0.3 * (1.0 + 1e-7 * wi.x * wo.y * wo.y))
            .fails(Check::Reciprocity)
            .any_cause(),
        one("slightly negative", |wi, wo| 0.1 * (wi.z + wo.z) - 1e-4)
            .energy(Energy::Pass)
            .fails(Check::Sign)
            .cause(Cause::Unclamped),
        one("a dent of 3°", |wi, wo| {
            let centre = at(57.0, 20.0);
            let bump = |v: Vector<f64>| (-(v - centre).length_squared() / 2.7e-3).exp();
            0.2 - 0.25 * bump(wi) * bump(wo)
        })
        .energy(Energy::Pass)
        .fails(Check::Sign)
        .cause(Cause::Unclamped),
        one("black", |_, _| 0.0),
        // Glints: many small lobes over a broad one, each under the limit together.
        one("ripples", |wi, wo| {
            let ripple = |v: Vector<f64>| 1.0 + 0.9 * (40.0 * v.x).sin() * (40.0 * v.y).sin();
            0.25 * FRAC_1_PI * ripple(wi) * ripple(wo)
        }),
        one("tiny", |wi, wo| 1e-12 * (wi.z + wo.z)),
    ]);
}
