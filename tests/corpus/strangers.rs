//! Models that the judge was not made with: other people's BRDFs and the faults that are usual in them.
//!
//! Where a comment gives an albedo it is integrated by hand; the others are held against [`grid`](crate::grid).

use crate::microfacet::{ggx, ggx_anisotropic, ggx_smith, schlick, smith, torrance_sparrow, v_cavity};
use crate::{Energy, judge_all, one};
use brdf::check::{Cause, Check};
use brdf::{Vector, half_vector};
use std::f64::consts::{FRAC_1_PI, PI};

/// The sine between a direction and a fibre along x.
fn across_fibre(v: Vector<f64>) -> f64 {
    ((1.0 - v.x) * (1.0 + v.x)).max(0.0).sqrt()
}

/// Portsmouth, Kutz and Hill 2024: Fujii's form, normalised, with what it loses given back through the exact albedo.
fn energy_preserving_oren_nayar(r: f64) -> impl Fn(Vector<f64>, Vector<f64>) -> f64 + Send + Sync {
    let a = 1.0 / (1.0 + (0.5 - 2.0 / (3.0 * PI)) * r);
    let albedo = move |c: f64| {
        let s = ((1.0 - c) * (1.0 + c)).max(0.0).sqrt();
        let g = s * (c.clamp(0.0, 1.0).acos() - s * c) + 2.0 / 3.0 * (s / c * (1.0 - s.powi(3)) - s);
        a * (1.0 + r * g * FRAC_1_PI)
    };
    let mean = a * (1.0 + (2.0 / 3.0 - 28.0 / (15.0 * PI)) * r);
    move |wi, wo| {
        let s = wi.x * wo.x + wi.y * wo.y;
        let bent = if s > 0.0 { s / wi.z.max(wo.z) } else { s };
        FRAC_1_PI * (a * (1.0 + r * bent) + (1.0 - albedo(wi.z)) * (1.0 - albedo(wo.z)) / (1.0 - mean))
    }
}

/// Strauss 1990, divided by the cosine of the light: smoothness .6, metalness 0, no transparency.
fn strauss(wi: Vector<f64>, wo: Vector<f64>) -> f64 {
    let (smooth, diffuse): (f64, f64) = (0.6, 0.5);
    let angle = |c: f64| c.clamp(0.0, 1.0).acos() / (0.5 * PI);
    let (kf, kg): (f64, f64) = (1.12, 1.01);
    let fresnel = |x: f64| ((x - kf).powi(-2) - kf.powi(-2)) / ((1.0 - kf).powi(-2) - kf.powi(-2));
    let shadow = |x: f64| ((1.0 - kg).powi(-2) - (x - kg).powi(-2)) / ((1.0 - kg).powi(-2) - kg.powi(-2));
    let (light, view) = (angle(wi.z), angle(wo.z));
    let normal = (1.0 - smooth.powi(3)) * (1.0 - diffuse);
    let j = fresnel(light) * shadow(light) * shadow(view);
    let reflected = (normal + (normal + 0.1) * j).min(1.0);
    let mirror = (wi.z * wo.z - wi.x * wo.x - wi.y * wo.y).max(0.0);
    let lobe = mirror.powf(3.0 / (1.0 - smooth)) * reflected;
    FRAC_1_PI * ((1.0 - smooth.powi(3)) * diffuse + lobe / wi.z)
}

#[test]
fn of_powders_and_fibres() {
    judge_all(&[
        // H(μ) = 1 + 2μ for ω = 1 is Hapke's approximation: A(μ) = ½(1+2μ)(2−2μ−μ(1−2μ) ln((1+μ)/μ)), 3/2·ln 2 at the normal.
        one("Hapke ω=1", |wi, wo| 0.25 * FRAC_1_PI / (wi.z + wo.z) * (1.0 + 2.0 * wi.z) * (1.0 + 2.0 * wo.z))
            .reaches(1.5 * 2f64.ln()),
        // Albedo 1 whatever r, by construction.
        one("EON r=.3", energy_preserving_oren_nayar(0.3)).peaks(1.0),
        one("EON r=1", energy_preserving_oren_nayar(1.0)).peaks(1.0),
        // ∫ sin(T, L) dω/π = π/2 for every view; 1/NL of a light.
        one("Kajiya–Kay diffuse", |wi, _| FRAC_1_PI * across_fibre(wi) / wi.z)
            .marginals(Energy::Fail(0.5 * PI, 1e-3), Energy::Over)
            .fails(Check::Reciprocity)
            .cause(Cause::OneSided),
        one("Kajiya–Kay highlight p=20", |wi, wo| {
            let cos = across_fibre(wi) * across_fibre(wo) - wi.x * wo.x;
            0.8 * cos.max(0.0).powi(20)
        })
        .grid(),
        one("Kajiya–Kay highlight, dim", |wi, wo| {
            0.1 * (across_fibre(wi) * across_fibre(wo) - wi.x * wo.x).max(0.0).powi(20)
        })
        .grid(),
        // Beard and Maxwell's volume: 2ρ/(NL+NV), albedo 4πρ(1 − μ ln((1+μ)/μ)): .3956 at 89.9° for 4πρ = .4.
        one("Beard–Maxwell volume", |wi, wo| 0.2 * FRAC_1_PI / (wi.z + wo.z)).peaks(0.3956),
        one("Strauss", strauss).grid().fails(Check::Reciprocity).any_cause(),
        // (NL + ½)/2.25·1/NL: 8/9 of every view, and 1/NL of a light.
        one("wrapped light w=.5", |wi, _| FRAC_1_PI * (wi.z + 0.5) / 2.25 / wi.z)
            .marginals(Energy::At(8.0 / 9.0, 1e-3), Energy::Over)
            .fails(Check::Reciprocity)
            .cause(Cause::OneSided),
    ]);
}

#[test]
fn of_facets() {
    let shirley = |nu: f64, nv: f64, f0: f64| {
        move |wi: Vector<f64>, wo: Vector<f64>| {
            let h = half_vector(wi, wo).normalized();
            let across = (h.x * h.x + h.y * h.y).max(1e-300);
            let power = (nu * h.x * h.x + nv * h.y * h.y) / across;
            let d = ((nu + 1.0) * (nv + 1.0)).sqrt() / (8.0 * PI) * h.z.powf(power);
            d / (wi.dot(h) * wi.z.max(wo.z)) * schlick(wi, wo, f0)
        }
    };
    let side = |c: f64| 1.0 - (1.0 - 0.5 * c).powi(5);
    judge_all(&[
        one("Ashikhmin–Shirley, 10 × 100", move |wi, wo| {
            shirley(10.0, 100.0, 0.5)(wi, wo) + 28.0 / (23.0 * PI) * 0.5 * 0.5 * side(wi.z) * side(wo.z)
        })
        .grid(),
        one("Ashikhmin–Shirley, n=100, F=1", shirley(100.0, 100.0, 1.0)).grid(),
        // D and a V-cavity keep Heitz's furnace whatever D.
        one("GGX with a V-cavity α=.5", |wi, wo| ggx(half_vector(wi, wo), 0.5) * v_cavity(wi, wo)),
        // He 1991: what is left of a rough mirror.
        one("He-like", |wi, wo| {
            torrance_sparrow(0.3)(wi, wo) * (-0.8 * (wi.z + wo.z).powi(2)).exp() + 0.1 * ggx_smith(2e-3)(wi, wo)
        }),
        one("Beard–Maxwell without obscuration", |wi, wo| {
            let h = half_vector(wi, wo);
            ggx(h, 0.1) * (h.z * h.z / h.length_squared()) / (4.0 * wi.z * wo.z)
        })
        .energy(Energy::Over)
        .cause(Cause::Unmasked),
        // α of the roughness in G, squared in D.
        one("D of α², G of α", |wi, wo| ggx(half_vector(wi, wo), 0.25) * smith(wi, wo, 0.5, 0.5)).grid(),
        one("D of α, G of α²", |wi, wo| ggx(half_vector(wi, wo), 0.9) * smith(wi, wo, 0.3, 0.3)).grid(),
        one("Schlick of NV", |wi, wo| ggx_smith(0.3)(wi, wo) * (0.04 + 0.96 * (1.0 - wo.z).max(0.0).powi(5)))
            .fails(Check::Reciprocity)
            .cause(Cause::OneSided),
        one("Schlick of NL", |wi, wo| ggx_smith(0.1)(wi, wo) * (0.5 + 0.5 * (1.0 - wi.z).max(0.0).powi(5)))
            .fails(Check::Reciprocity)
            .cause(Cause::OneSided),
        // A denominator that is clamped loses energy at grazing only.
        one("GGX over max(4 NL NV, .001)", |wi, wo| {
            let product = 4.0 * wi.z * wo.z;
            ggx_smith(0.2)(wi, wo) * product / product.max(1e-3)
        }),
        one("half mirror, half retro α=.003", |wi, wo| {
            let back = Vector::new(-wo.x, -wo.y, wo.z);
            0.5 * ggx_smith(0.003)(wi, wo) + 0.5 * ggx_smith(0.003)(wi, back)
        }),
        one("brushed, 1e-3 × .3", |wi, wo| {
            ggx_anisotropic(half_vector(wi, wo), 1e-3, 0.3) * smith(wi, wo, 1e-3, 0.3) * schlick(wi, wo, 0.9)
        }),
        one("Filament's plastic α=.1", |wi, wo| {
            let f = schlick(wi, wo, 0.04);
            (1.0 - f) * FRAC_1_PI + f * ggx_smith(0.1)(wi, wo)
        })
        .energy(Energy::Over)
        .any_cause(),
    ]);
}

#[test]
fn planted_faults() {
    judge_all(&[
        one("GGX·NL² α=.4", |wi, wo| ggx_smith(0.4)(wi, wo) * wi.z * wi.z)
            .energy(Energy::Any)
            .fails(Check::Reciprocity)
            .cause(Cause::OneSided),
        one("GGX without π α=.5", |wi, wo| PI * ggx_smith(0.5)(wi, wo)).energy(Energy::Over).any_cause(),
        one("NaN along the normal", |wi, wo| {
            let tangent = |v: Vector<f64>| v.x / (v.x * v.x + v.y * v.y).sqrt();
            0.2 * FRAC_1_PI * (1.0 + 0.1 * tangent(wi).powi(2) * tangent(wo).powi(2))
        })
        .energy(Energy::Any)
        .fails(Check::Finite)
        .cause(Cause::AtNormal),
        // Below 0 only where both graze, against each other, within 2.6° of the horizon.
        one("negative against the light", |wi, wo| 0.1 * (1.0 + 1.001 * wi.dot(wo)))
            .energy(Energy::Pass)
            .fails(Check::Sign)
            .cause(Cause::Unclamped),
        // .95 everywhere, and 2√π·w·sinθ·cosθ·b more about 62.4°: 1.003 there.
        one("1.003 in a ring of 1°", |wi, wo| {
            let (theta, width) = (62.4f64.to_radians(), 1f64.to_radians());
            let bump = |v: Vector<f64>| (-((v.z.clamp(-1.0, 1.0).acos() - theta) / width).powi(2)).exp();
            let share = 2.0 * PI.sqrt() * width * theta.sin() * theta.cos();
            FRAC_1_PI * (0.95 + 0.053 / share * bump(wi) * bump(wo))
        })
        .energy(Energy::Fail(1.003, 5e-4)),
        one("0.999 in a ring of 1°", |wi, wo| {
            let (theta, width) = (62.4f64.to_radians(), 1f64.to_radians());
            let bump = |v: Vector<f64>| (-((v.z.clamp(-1.0, 1.0).acos() - theta) / width).powi(2)).exp();
            let share = 2.0 * PI.sqrt() * width * theta.sin() * theta.cos();
            FRAC_1_PI * (0.95 + 0.049 / share * bump(wi) * bump(wo))
        })
        .peaks(0.999),
        one("a tint of the view, 1e-6", |wi, wo| 0.3 * ggx_smith(0.3)(wi, wo) * (1.0 + 1e-6 * wo.z))
            .fails(Check::Reciprocity)
            .any_cause(),
    ]);
}
