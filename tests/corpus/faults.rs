//! One planted fault for each cause, and the cause that must be named.

use crate::microfacet::{beckmann, ggx, ggx_smith, schlick, smith, torrance_sparrow, v_cavity};
use crate::{Energy, judge_all, one};
use brdf::check::{Cause, Check};
use brdf::half_vector;
use std::f64::consts::{FRAC_1_PI, PI};

#[test]
fn conventions() {
    judge_all(&[
        one("Lambert·cos", |wi, _| FRAC_1_PI * wi.z).energy(Energy::Any).fails(Check::Reciprocity).cause(Cause::Cosine),
        one("π·Lambert·cos", |wi, _| wi.z).energy(Energy::Any).fails(Check::Reciprocity).cause(Cause::PiCosine),
        one("GGX·cos α=.2", |wi, wo| ggx_smith(0.2)(wi, wo) * schlick(wi, wo, 0.5) * wi.z)
            .energy(Energy::Any)
            .fails(Check::Reciprocity)
            .cause(Cause::Cosine),
        one("π·GGX·cos α=.2", |wi, wo| PI * ggx_smith(0.2)(wi, wo) * wi.z)
            .energy(Energy::Any)
            .fails(Check::Reciprocity)
            .cause(Cause::PiCosine),
        one("GGX·NV α=.2", |wi, wo| ggx_smith(0.2)(wi, wo) * wo.z)
            .energy(Energy::Any)
            .fails(Check::Reciprocity)
            .cause(Cause::Swapped),
        one("tinted by the light", |wi, wo| 0.5 * ggx_smith(0.2)(wi, wo) * (1.0 + wi.z * wi.z))
            .energy(Energy::Any)
            .fails(Check::Reciprocity)
            .cause(Cause::OneSided),
    ]);
}

#[test]
fn scales_and_denominators() {
    judge_all(&[
        one("Lambert without 1/π", |_, _| 1.0).reaches(PI).cause(Cause::MissingPi),
        one("Lambert ρ=.5 without 1/π", |_, _| 0.5).reaches(0.5 * PI).cause(Cause::MissingPi),
        one("GGX without 1/π α=.3", |wi, wo| PI * ggx_smith(0.3)(wi, wo))
            .energy(Energy::Fail(PI, 0.01))
            .cause(Cause::MissingPi),
        one("GGX without 1/4 α=.05", |wi, wo| 4.0 * ggx_smith(0.05)(wi, wo))
            .energy(Energy::Fail(4.0, 0.01))
            .cause(Cause::MissingQuarter),
        one("D·G without a denominator α=.2", |wi, wo| {
            4.0 * wi.z * wo.z * smith(wi, wo, 0.2, 0.2) * ggx(half_vector(wi, wo), 0.2)
        })
        .energy(Energy::Over)
        .cause(Cause::NoDenominator),
        one("Beckmann without G α=.2", |wi, wo| beckmann(half_vector(wi, wo), 0.2) / (4.0 * wi.z * wo.z))
            .energy(Energy::Over)
            .cause(Cause::Unmasked),
        one("Lambert + GGX α=.05", |wi, wo| 0.9 * FRAC_1_PI + ggx_smith(0.05)(wi, wo) * schlick(wi, wo, 0.3))
            .energy(Energy::Over)
            .cause(Cause::Unweighted),
    ]);
}

#[test]
fn not_finite() {
    let broken = |name: &str, f: fn(brdf::Vector<f64>, brdf::Vector<f64>) -> f64, cause| {
        one(name, f).energy(Energy::Any).fails(Check::Finite).cause(cause)
    };
    judge_all(&[
        broken("pow of a negative base", |wi, wo| 0.3 * (wi.x * wo.x + 0.2).powf(0.3), Cause::NegativeBase),
        broken("acos of 1.2", |wi, wo| 0.1 * (1.2 * wi.dot(wo)).acos(), Cause::NegativeBase),
        broken(
            "azimuth at the normal",
            |wi, wo| {
                let length = |v: brdf::Vector<f64>| v.sin_squared().sqrt();
                let cos = (wi.x * wo.x + wi.y * wo.y) / (length(wi) * length(wo));
                FRAC_1_PI * (0.5 + 0.2 * cos.clamp(-1.0, 1.0) * length(wi) * length(wo))
            },
            Cause::AtNormal,
        ),
        broken(
            "division by a cosine that vanishes",
            |wi, wo| {
                let low = wi.z.min(wo.z);
                torrance_sparrow(0.3)(wi, wo) * (low - 1e-3).max(0.0) / (low - 1e-3).max(0.0)
            },
            Cause::AtGrazing,
        ),
        broken(
            "division by wi − wo",
            |wi, wo| {
                let d = (wi - wo).length_squared();
                0.2 * FRAC_1_PI * (1.0 + d / d)
            },
            Cause::AtRetro,
        ),
        broken(
            "azimuth of the half vector",
            |wi, wo| {
                let h = half_vector(wi, wo);
                let s = h.x * h.x + h.y * h.y;
                beckmann(h, 0.3) * v_cavity(wi, wo) * (0.5 + 0.5 * (h.x * h.x + h.y * h.y) / s)
            },
            Cause::AtMirror,
        ),
    ]);
}
