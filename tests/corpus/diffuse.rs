//! Diffuse models.

use crate::microfacet::schlick;
use crate::{Energy, judge_all, one};
use brdf::check::{Cause, Check};
use brdf::{Vector, half_vector};
use std::f64::consts::{FRAC_1_PI, FRAC_PI_2, PI};

pub(crate) fn burley(roughness: f64) -> impl Fn(Vector<f64>, Vector<f64>) -> f64 + Send + Sync {
    move |wi, wo| {
        // 2·VH²·r, with VH = |h|/2.
        let f90 = 0.5 + 0.5 * roughness * half_vector(wi, wo).length_squared();
        let side = |c: f64| 1.0 + (f90 - 1.0) * (1.0 - c).powi(5);
        FRAC_1_PI * side(wi.z) * side(wo.z)
    }
}

/// cosΔφ·sinθᵢ·sinθₒ.
fn across(wi: Vector<f64>, wo: Vector<f64>) -> f64 {
    wi.x * wo.x + wi.y * wo.y
}

/// Oren & Nayar 1994, the qualitative model.
fn qualitative(sigma: f64) -> impl Fn(Vector<f64>, Vector<f64>) -> f64 + Send + Sync {
    let square = sigma * sigma;
    let (a, b) = (1.0 - 0.5 * square / (square + 0.33), 0.45 * square / (square + 0.09));
    move |wi, wo| FRAC_1_PI * (a + b * across(wi, wo).max(0.0) / wi.z.max(wo.z))
}

/// Fujii's form of it: s/t for both signs of s = L·V − NL·NV, and .17 ρ σ²/(σ²+.13) more in A for light between facets.
fn fujii(sigma: f64) -> impl Fn(Vector<f64>, Vector<f64>) -> f64 + Send + Sync {
    let square = sigma * sigma;
    let between = 0.17 * square / (square + 0.13);
    let (a, b) = (1.0 - 0.5 * square / (square + 0.33) + between, 0.45 * square / (square + 0.09));
    move |wi, wo| {
        let s = across(wi, wo);
        FRAC_1_PI * (a + b * if s > 0.0 { s / wi.z.max(wo.z) } else { s })
    }
}

/// Oren & Nayar 1994 in full, ρ = 1, as the crate has it.
fn full(sigma: f64) -> impl Fn(Vector<f64>, Vector<f64>) -> f64 + Send + Sync {
    move |wi, wo| brdf::diffuse::oren_nayar(wi, wo, sigma).f(1.0)
}

#[test]
fn known_verdicts() {
    judge_all(&[
        one("Lambert", |_, _| FRAC_1_PI).peaks(1.0),
        one("Lambert ρ=.18", |_, _| 0.18 * FRAC_1_PI).peaks(0.18),
        // ½[1 − μ ln((1+μ)/μ)], largest at grazing: .4945 at 89.9°.
        one("Lommel–Seeliger ω=1", |wi, wo| 0.25 * FRAC_1_PI / (wi.z + wo.z)).peaks(0.4945),
        one("Ashikhmin–Shirley diffuse", |wi, wo| {
            let side = |c: f64| 1.0 - (1.0 - 0.5 * c).powi(5);
            28.0 / (23.0 * PI) * side(wi.z) * side(wo.z)
        })
        // 28/23·(1 − (1−μ/2)⁵)·2∫(1 − (1−μ/2)⁵)μ dμ, the integral 23/28 and the rest 31/32 at the normal.
        .peaks(31.0 / 32.0),
        one("Burley r=.35", burley(0.35)),
        // 1.025 at 80°.
        one("Burley r=.5", burley(0.5)).reaches(1.025),
        // 1.249 at 88°, and that is not the maximum.
        one("Burley r=.75", burley(0.75)).reaches(1.2757),
        one("Burley r=1", burley(1.0)).reaches(1.554),
        // 1.0152 at 89.99°.
        one("Oren–Nayar qualitative σ=.2", qualitative(0.2)).reaches(1.0151),
        one("Oren–Nayar qualitative σ=.35", qualitative(0.35)),
        one("Oren–Nayar qualitative σ=0", qualitative(0.0)).peaks(1.0),
        // A + B/π·(π/2 − 2/3) at grazing: 1.027.
        one("Fujii σ=.3", fujii(0.3)).energy(Energy::Fail(1.027, 0.002)),
        // Peaks at 1.051 for σ = .3.
        one("Oren–Nayar 1994 σ=.3", full(0.3)).energy(Energy::Fail(1.051, 0.004)),
        one("Oren–Nayar 1994 σ=0", full(0.0)).peaks(1.0),
    ]);
}

#[test]
fn of_planets_and_cloth() {
    judge_all(&[
        // (k+2)/2π (NL NV)^{k−1}: the largest albedo is where both cosines are 1, (k+2)/(k+1) for k > 1.
        one("Minnaert k=2", |wi, wo| 4.0 / (2.0 * PI) * wi.z * wo.z).reaches(4.0 / 3.0),
        one("Minnaert k=1", |_, _| FRAC_1_PI).peaks(1.0),
        // (NL NV)^{−1/4}/π·…: grows without bound at grazing.
        one("Minnaert k=.5", |wi, wo| 2.5 / (2.0 * PI) * (wi.z * wo.z).powf(-0.5)).grid_or_over(),
        one("Hapke ω=.9", |wi, wo| {
            let w: f64 = 0.9;
            let gamma = (1.0 - w).sqrt();
            let h = |x: f64| (1.0 + 2.0 * x) / (1.0 + 2.0 * x * gamma);
            let g = wi.dot(wo).clamp(-1.0, 1.0).acos();
            let b = 0.5 / (1.0 + (0.5 * g).tan() / 0.05);
            w / (4.0 * PI) / (wi.z + wo.z) * ((1.0 + b) + h(wi.z) * h(wo.z) - 1.0)
        })
        .grid(),
        one("Lunar–Lambert", |wi, wo| 0.5 * 0.5 / (wi.z + wo.z) * FRAC_1_PI + 0.25 * FRAC_1_PI).grid(),
        // Estevez & Kulla 2017: D of an inverted Gaussian in sine, Ashikhmin's denominator.
        one("Charlie sheen r=.3", |wi, wo| {
            let inverse = 1.0 / 0.3;
            let h = half_vector(wi, wo);
            let sin = (h.sin_squared() / h.length_squared()).sqrt();
            (2.0 + inverse) * sin.powf(inverse) / (2.0 * PI) / (4.0 * (wi.z + wo.z - wi.z * wo.z))
        })
        .grid(),
        one("Ashikhmin velvet α=.5", |wi, wo| {
            let cot = 1.0 / crate::microfacet::tan_squared(half_vector(wi, wo)).max(1e-300);
            let a: f64 = 0.25;
            let n = 1.0 / (PI * (1.0 + 4.0 * a));
            n * (1.0 + 4.0 * (-cot / a).exp()) / (4.0 * (wi.z + wo.z - wi.z * wo.z))
        })
        .grid(),
        // Coupled as Ashikhmin and Shirley would: (1−F)(1−F), symmetric.
        one("Lambert under Schlick", |wi, wo| {
            FRAC_1_PI * (1.0 - schlick(wi, wi, 0.04)) * (1.0 - schlick(wo, wo, 0.04))
        }),
        // Gotanda, Lambert–Yarrow: wraps negative.
        one("linear dent", |wi, wo| FRAC_1_PI * (wi.z + wo.z - 0.02))
            .energy(Energy::Any)
            .fails(Check::Sign)
            .cause(Cause::Unclamped),
        // Wrapped light, (NL + w)/(1 + w): not symmetric.
        one("half Lambert", |wi, _| FRAC_1_PI * (0.5 + 0.5 * wi.z).powi(2) / wi.z)
            .energy(Energy::Any)
            .fails(Check::Reciprocity)
            .cause(Cause::OneSided),
        one("Seeliger + opposition surge", |wi, wo| {
            let phase = wi.dot(wo).clamp(-1.0, 1.0).acos();
            0.2 * FRAC_1_PI / (wi.z + wo.z)
                * (1.0 + 0.8 * (-phase / 0.01).exp() + (phase / FRAC_PI_2).sin().abs() * 0.1)
        })
        .energy(Energy::Pass),
    ]);
}

impl crate::Case {
    /// Unbounded at grazing: over the limit in any case.
    fn grid_or_over(self) -> Self {
        self.energy(Energy::Over)
    }
}
