//! M: the Fresnel terms, the Cook–Torrance highlight, Oren–Nayar, and where text and listing disagree.

use crate::elek::{Dots, dots, index, masking_printed, up};
use crate::integrate::{albedo, direction, range_over_cosines, range_over_pairs, worst_cosine};
use crate::record::{Erratum, Measurement};
use brdf::check::Fixed;
use brdf::diffuse::{lambert, oren_nayar, oren_nayar_qualitative};
use brdf::material::metal;
use brdf::{Vector, fresnel, microfacet};
use std::f64::consts::PI;

/// π as the listing of the highlight writes it.
#[expect(clippy::approx_constant, reason = "as printed")]
pub(crate) const SPECULAR_PI: f64 = 3.1415;
/// π as the Oren–Nayar listing writes it.
#[expect(clippy::approx_constant, reason = "as printed")]
const OREN_NAYAR_PI: f64 = 3.14159;

/// `pow` of HLSL, Cg and WGSL, exp2(y·log2(x)): NaN where x < 0.
pub(crate) fn shader_pow(x: f64, y: f64) -> f64 {
    (y * x.log2()).exp2()
}

/// `fresnelTerm` as printed in M §4.1.4, with the paren that it lacks.
pub(crate) fn fresnel_term_printed(ior: f64, k: f64, cos: f64) -> f64 {
    let (e, c2) = (ior * ior + k * k, cos * cos);
    let r1 = (e * c2 - 2.0 * cos + 1.0) / (e * c2 + 2.0 * cos + 1.0);
    let r2 = (e - 2.0 * ior * cos + c2) / (e + 2.0 * ior * cos + c2);
    0.5 * (r1 + r2)
}

/// `fresnelSchlick` as printed in M §4.1.4.
fn fresnel_schlick_printed(ior: f64, cos: f64) -> f64 {
    let r1 = shader_pow((1.0 - ior) / (1.0 + ior), 2.0);
    r1 + (1.0 - r1) * shader_pow(1.0 - cos, 5.0)
}

/// M, equation 4.12: normalised.
fn beckmann_4_12(nh: f64, m: f64) -> f64 {
    let (c2, m2) = (nh * nh, m * m);
    ((c2 - 1.0) / (m2 * c2)).exp() / (PI * m2 * c2 * c2)
}

/// M, equation 4.8 with 4.11 and 4.12.
pub(crate) fn equation_4_8(reflectance: f64, d: Dots<f64>, m: f64) -> f64 {
    reflectance * beckmann_4_12(d.nh, m) * masking_printed(d) / (PI * d.nl * d.nv)
}

/// The specular component of M §4.1.4 as printed, with any Fresnel term and white colour: a radiance.
pub(crate) fn specular_printed(reflectance: f64, d: Dots<f64>, m: f64) -> f64 {
    let d1 = 1.0 / (SPECULAR_PI * m * m * d.nh.powi(4));
    let d2 = ((d.nh * d.nh - 1.0) / (m * m * d.nh * d.nh)).exp();
    (reflectance * masking_printed(d) * (d1 * d2)) / SPECULAR_PI * (d.nv * d.nl + 1.0e-7)
}

/// What a printed form of M's Oren–Nayar uses.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Printed {
    /// Equations 4.15–4.23, γ the dot product of the projected directions.
    Equations,
    /// The listing: `C2 =` instead of `C2 *=` where γ < 0, and π cut off.
    Listing,
}

/// C₁ + χ + ε of M: what Kd·NL·Ld is multiplied by, π·f/ρ if it were right.
pub(crate) fn oren_nayar_printed(form: Printed, wi: Vector<f64>, wo: Vector<f64>, q: f64) -> f64 {
    let (ti, to) = (wi.z.min(1.0).acos(), wo.z.min(1.0).acos());
    let (alpha, beta) = (ti.max(to), ti.min(to));
    let gamma = wi.x * wo.x + wi.y * wo.y;
    let pi = if form == Printed::Listing { OREN_NAYAR_PI } else { PI };
    let q2 = q * q;
    let c1 = 1.0 - 0.5 * (q2 / (q2 + 0.33));
    let scale = 0.45 * (q2 / (q2 + 0.09));
    let dent = alpha.sin() - (2.0 * beta / pi).powi(3);
    let c2 = match (gamma >= 0.0, form) {
        (true, _) => scale * alpha.sin(),
        (false, Printed::Equations) => scale * dent,
        (false, Printed::Listing) => dent,
    };
    let c3 = 0.125 * q2 / (q2 + 0.09) * (4.0 * alpha * beta / (pi * pi)).powi(2);
    c1 + gamma * c2 * beta.tan() + (1.0 - gamma.abs()) * c3 * ((alpha + beta) / 2.0).tan()
}

/// M, equation 4.7: Kd·NL·Ld/d + CM·Fr.
fn diffuse_4_7(kd: f64, nl: f64, ld: f64, d: f64, cm: f64, fr: f64) -> f64 {
    1.0 / d * kd * nl * ld + cm * fr
}

/// diffuseComponent of M §4.1.4, with cubeRefl = texCUBE·Refl.
fn diffuse_printed(color: f64, nl: f64, light: f64, attenuation: f64, cube: f64, refl: f64, fr: f64) -> f64 {
    cube * refl + attenuation * light * color * nl.max(0.0) * fr
}

/// The attenuation of M eq. 4.2 and §4.1.4.
fn attenuation_printed(d: f64) -> f64 {
    1.0 / d
}

/// The attenuation of a point light.
fn attenuation_correct(d: f64) -> f64 {
    1.0 / (d * d)
}

/// What the text of M §4.3 says a mask leaves of the metal.
fn metal_share_of_the_text(mask: f64) -> f64 {
    if mask > 0.5 { 1.0 } else { 0.0 }
}

/// `maskDiffuse` of M §4.3: what share of the metal a mask leaves.
fn metal_share_printed(mask: f64) -> f64 {
    if mask <= 0.5 { 1.0 } else { 0.0 }
}

pub(crate) fn errata() -> Vec<Erratum> {
    let mut all = specular();
    all.extend(diffuse());
    all.extend(contradictions());
    all
}

fn specular() -> Vec<Erratum> {
    vec![
        Erratum {
            number: 2,
            place: "M eq. 4.8 with 4.12",
            printed: "f = F·D·G/(π·NL·NV) with a D that has its 1/π",
            correct: "f = F·D·G/(4·NL·NV)",
            right: "`microfacet::torrance_sparrow`",
            note: "F = 1, m = .1, view along the normal.",
            measure: || {
                let m = 0.1;
                let (low, high) = range_over_pairs(80.0, |wi, wo| {
                    equation_4_8(1.0, dots(up(), wi, wo), 0.5) / microfacet::facets(wi, wo, 0.5).lobe
                });
                vec![
                    Measurement::notes(
                        "printed: albedo, F = 1",
                        albedo(0.0, Fixed::View, |wi, wo| equation_4_8(1.0, dots(up(), wi, wo), m)),
                        "1.273",
                    ),
                    Measurement::here(
                        "correct: albedo, F = 1",
                        albedo(0.0, Fixed::View, |wi, wo| microfacet::facets(wi, wo, m).lobe),
                        "1.000",
                    ),
                    Measurement::notes("printed / correct × π/4, the least over pairs", low * PI / 4.0, "1")
                        .within(1e-9),
                    Measurement::notes("printed / correct × π/4, the largest over pairs", high * PI / 4.0, "1")
                        .within(1e-9),
                ]
            },
        },
        Erratum {
            number: 15,
            place: "M §4.1.4, fresnelTerm",
            printed: "r1 = (… − 2·cosθ + 1)/(… + 2·cosθ + 1), and one paren too few",
            correct: "2·ior·cosθ in both, as eq. 4.6 has it",
            right: "`fresnel::conductor_approx`, and `fresnel::conductor`, which is exact",
            note: "Against the exact term. The notes' range is that of their own set: −.19 is silver as .06 + 3.75i, +.26 is Cu₂O.g of E, \
                   App. A (an oxide; of the metals there, Cr.r is worst with +.25). Among the crate's metals the lower end is −.26, \
                   silver at 450 nm.",
            measure: || {
                let off = |n, k| {
                    range_over_cosines(|c| fresnel_term_printed(n, k, c) - fresnel::conductor(c, n, k).reflectance)
                };
                let (n, k) = index("cuprite_elek", 1);
                let chromium = index("chromium_elek", 0);
                let silver = metal::by_name("silver").map(|m| (m.n[2], m.k[2])).expect("built in");
                vec![
                    Measurement::notes("printed: F₀ at ior = 1.5, k = 0", fresnel_term_printed(1.5, 0.0, 1.0), ".139"),
                    Measurement::notes("correct: F₀", fresnel::conductor_approx(1.0, 1.5, 0.0), ".04"),
                    Measurement::notes("printed − exact: silver, .06 + 3.75i, least", off(0.06, 3.75).0, "−.19"),
                    Measurement::notes("printed − exact: Cu₂O.g, largest", off(n, k).1, "+.26"),
                    Measurement::here("printed − exact: Cr.r, largest", off(chromium.0, chromium.1).1, "+.25"),
                    Measurement::here("printed − exact: silver at 450 nm, least", off(silver.0, silver.1).0, "−.26"),
                    Measurement::here(
                        "correct − exact: Cr.r, largest error",
                        worst_cosine(|c| {
                            let (n, k) = chromium;
                            fresnel::conductor_approx(c, n, k) - fresnel::conductor(c, n, k).reflectance
                        })
                        .0,
                        ".003",
                    ),
                ]
            },
        },
        Erratum {
            number: 16,
            place: "M eq. 3.6 and 4.6 with the defaults of §4.1.4",
            printed: "the approximation for conductors with κ = 0",
            correct: "the exact terms of a dielectric; the approximation is for κ ≥ 2",
            right: "`fresnel::dielectric`; `fresnel::conductor_approx` states its error",
            note: "Largest absolute error over all angles; for κ ≥ 2 over n in [.05, 5] and κ in [2, 9], worst at n = 2.2, κ = 2.",
            measure: || {
                let error = |n, k| {
                    worst_cosine(|c| fresnel::conductor_approx(c, n, k) - fresnel::conductor(c, n, k).reflectance).0
                };
                let mut metals = 0.0f64;
                for n in 1..=100 {
                    for k in 0..=28 {
                        let (n, k) = (0.05 * f64::from(n), 2.0 + 0.25 * f64::from(k));
                        for c in 0..=100 {
                            let c = f64::from(c) / 100.0;
                            let off = fresnel::conductor_approx(c, n, k) - fresnel::conductor(c, n, k).reflectance;
                            metals = metals.max(off.abs());
                        }
                    }
                }
                vec![
                    Measurement::notes("n = 1.5, κ = 0", error(1.5, 0.0), ".099"),
                    Measurement::notes("n = 1.33, κ = 0", error(1.33, 0.0), ".144"),
                    Measurement::notes("κ ≥ 2", metals, ".008"),
                ]
            },
        },
        Erratum {
            number: 17,
            place: "M eq. 4.9 and fresnelSchlick",
            printed: "F₀ = ((n₁−n₂)/(n₁+n₂))², as pow((1−ior)/(1+ior), 2)",
            correct: "F₀ = ((n−1)²+κ²)/((n+1)²+κ²), a product",
            right: "`fresnel::schlick` of `fresnel::normal_incidence`; `fresnel::schlick_from_indices` multiplies",
            note: "`pow` of a negative base is NaN or undefined in HLSL, Cg and WGSL.",
            measure: || {
                let (n, k) = index("copper_elek", 1);
                vec![
                    Measurement::notes(
                        "eq. 4.9: F₀ of Cu.g",
                        fresnel::schlick_from_indices(1.0, 1.0, n).reflectance,
                        ".0004",
                    ),
                    Measurement::notes(
                        "correct: F₀ of Cu.g",
                        fresnel::schlick(1.0, fresnel::normal_incidence(n, k)).reflectance,
                        ".617",
                    ),
                    Measurement::notes(
                        "listing: F at ior = 1.5, 30°",
                        fresnel_schlick_printed(1.5, 0.75f64.sqrt()),
                        "NaN",
                    ),
                    Measurement::here(
                        "correct: the same",
                        fresnel::schlick_from_indices(0.75f64.sqrt(), 1.0, 1.5).reflectance,
                        ".040",
                    ),
                ]
            },
        },
        Erratum {
            number: 18,
            place: "M §4.1.4, specularComponent",
            printed: "((F·G·D)/3.1415·(NV·NL + 1e-7))",
            correct: "F·G·D/(4·NL·NV)·NL; as eq. 4.8 has it, divided by NL·NV",
            right: "`microfacet::torrance_sparrow` times NL",
            note: "F = 1, m = .05; the listing's value taken as f·NL, a radiance.",
            measure: || {
                let m = 0.05;
                let printed = |theta| {
                    albedo(theta, Fixed::View, |wi: Vector<f64>, wo| {
                        specular_printed(1.0, dots(up(), wi, wo), m) / wi.z
                    })
                };
                let correct = |theta| albedo(theta, Fixed::View, |wi, wo| microfacet::facets(wi, wo, m).lobe);
                vec![
                    Measurement::notes("printed: albedo at 0°", printed(0.0), "1.27"),
                    Measurement::notes("printed: albedo at 75°", printed(75.0), ".023"),
                    Measurement::notes("printed: albedo at 89°", printed(89.0), ".000"),
                    Measurement::here("correct: albedo at 0°", correct(0.0), "1.00"),
                    Measurement::here("correct: albedo at 75°", correct(75.0), ".999"),
                    Measurement::here("correct: albedo at 89°", correct(89.0), ".969"),
                ]
            },
        },
    ]
}

fn diffuse() -> Vec<Erratum> {
    vec![
        Erratum {
            number: 19,
            place: "M §4.3, Oren–Nayar listing, line 16",
            printed: "γ < 0: C2 = (sin(alpha) − …)",
            correct: "C2 *= …, as eq. 4.22 has it",
            right: "`diffuse::oren_nayar`",
            note: "The listing as printed, with errata 20 and 21, over pairs up to 89.9°. The notes' −.91 is that of σ = 0, whose limit at \
                   grazing is 1 − 6/π = −.910 (the listing's π of 3.14159 turns it back within the last tenth of a degree); with \
                   roughness it goes lower.",
            measure: || {
                let printed = |q| range_over_pairs(89.9, |wi, wo| oren_nayar_printed(Printed::Listing, wi, wo, q));
                let (low, high) = range_over_pairs(89.9, |wi, wo| oren_nayar(wi, wo, 0.0).direct);
                vec![
                    Measurement::notes("printed, σ = 0: the least πf/ρ", printed(0.0).0, "−.91"),
                    Measurement::here("printed, σ = 0: the largest πf/ρ", printed(0.0).1, "1.00"),
                    Measurement::here("correct, σ = 0: the least πf/ρ", low, "1").within(0.0),
                    Measurement::here("correct, σ = 0: the largest πf/ρ", high, "1").within(0.0),
                    Measurement::here("printed, σ = .5: the least πf/ρ", printed(0.5).0, "−1.12"),
                    Measurement::here(
                        "correct, σ = .5, ρ = 1: the least πf",
                        range_over_pairs(89.9, |wi, wo| PI * oren_nayar(wi, wo, 0.5).f(1.0)).0,
                        ".377",
                    ),
                ]
            },
        },
        Erratum {
            number: 20,
            place: "M eq. 4.21 and the listing, line 5",
            printed: "γ = (V − N(V·N)) · (L − N(L·N)), which is sinα·sinβ·cosΔφ",
            correct: "γ = cosΔφ, both normalised",
            right: "`diffuse::oren_nayar`",
            note: "Equations 4.15–4.23 against L₁, σ = .5. The notes' 20 % is right to 85°; towards grazing it rises to 21 %. \
                   Eq. 4.21 prints bars around the factors, which may have meant normalisation; the listing has none.",
            measure: || {
                let sigma = 0.5;
                let off = |limit| {
                    range_over_pairs(limit, |wi, wo| {
                        let correct = oren_nayar(wi, wo, sigma).direct;
                        oren_nayar_printed(Printed::Equations, wi, wo, sigma) / correct - 1.0
                    })
                };
                let normal = direction(0.0, 0.0);
                vec![
                    Measurement::notes("printed / correct − 1, to 85°: the largest", off(85.0).1, "20 %"),
                    Measurement::here("printed / correct − 1, to 85°: the least", off(85.0).0, "−11 %"),
                    Measurement::here("printed / correct − 1, to 89.99°: the largest", off(89.99).1, "21 %"),
                    Measurement::here(
                        "printed / correct − 1, along the normal",
                        oren_nayar_printed(Printed::Equations, normal, normal, sigma)
                            / oren_nayar(normal, normal, sigma).direct
                            - 1.0,
                        "0",
                    )
                    .within(1e-15),
                ]
            },
        },
        Erratum {
            number: 21,
            place: "M eq. 4.15 and the listing",
            printed: "Kd·NL·Ld·(C₁ + χ + ε)",
            correct: "ρ/π·(L₁ + ρ·L₂): the interreflection L₂ and 1/π are missing; C₁'s .33 is right",
            right: "`diffuse::oren_nayar`; `diffuse::oren_nayar_qualitative` has .57 and no L₂",
            note: "σ = .5, ρ = 1. The notes' \"127 % at most\" is right to 88°; towards grazing, opposite and at 90°, it rises to a limit \
                   of 147 %. .57 in place of .33 belongs to the A, B form: it makes up for part of the L₂ that this form leaves out.",
            measure: || {
                let sigma = 0.5;
                let ratio = |wi, wo| {
                    let f = oren_nayar::<f64>(wi, wo, sigma);
                    f.interreflection / f.direct
                };
                let normal = direction(0.0, 0.0);
                let largest = |limit| range_over_pairs(limit, ratio).1;
                let full = PI * oren_nayar(normal, normal, sigma).f(1.0);
                vec![
                    Measurement::notes("L₂/L₁ along the normal", ratio(normal, normal), "14 %"),
                    Measurement::notes("L₂/L₁ to 88°: the largest", largest(88.0), "127 %"),
                    Measurement::here("L₂/L₁ to 89.99°: the largest", largest(89.99), "147 %"),
                    Measurement::here("πf along the normal: full form", full, ".896"),
                    Measurement::here(
                        "πf along the normal: printed, no L₂, .33",
                        oren_nayar_printed(Printed::Equations, normal, normal, sigma),
                        ".784",
                    ),
                    Measurement::here(
                        "πf along the normal: A, B form, no L₂, .57",
                        PI * oren_nayar_qualitative(normal, normal, sigma, 1.0),
                        ".848",
                    ),
                    Measurement::here(
                        "printed / correct at σ = 0 (π is missing)",
                        oren_nayar_printed(Printed::Equations, normal, normal, 0.0) / lambert(1.0),
                        "3.1416",
                    ),
                ]
            },
        },
    ]
}

fn contradictions() -> Vec<Erratum> {
    vec![
        Erratum {
            number: 22,
            place: "M eq. 4.7 against the listing of §4.1.4",
            printed: "4.7: Kd·NL·Ld/d + CM·Fr; listing: CM·Refl + Color·NL·Ld·att·Fr",
            correct: "4.7: Fresnel weighs the mirror image",
            right: "`fresnel::conductor` times the environment; `diffuse::lambert` without it",
            note: "Contradiction. Defaults: ior = 1.5, k = 0, Refl = .5, with the exact Fresnel term on both sides.",
            measure: || {
                let f = |theta: f64| fresnel::dielectric(theta.to_radians().cos(), 1.5).reflectance;
                // A white environment without a light, and a light on a white surface without an environment.
                let equation_4_7 = |theta| {
                    (diffuse_4_7(1.0, 1.0, 0.0, 1.0, 1.0, f(theta)), diffuse_4_7(1.0, 1.0, 1.0, 1.0, 0.0, f(theta)))
                };
                let listing = |theta| {
                    let of = |light, cube| diffuse_printed(1.0, 1.0, light, 1.0, cube, 0.5, f(theta));
                    (of(0.0, 1.0), of(1.0, 0.0))
                };
                vec![
                    Measurement::here("4.7: mirror image at 0°", equation_4_7(0.0).0, ".04"),
                    Measurement::here("listing: mirror image at 0°", listing(0.0).0, ".50"),
                    Measurement::here(
                        "4.7: mirror image, 85° / 0°",
                        equation_4_7(85.0).0 / equation_4_7(0.0).0,
                        "15.3",
                    ),
                    Measurement::here("listing: mirror image, 85° / 0°", listing(85.0).0 / listing(0.0).0, "1")
                        .within(0.0),
                    Measurement::here("4.7: Lambert's weight at 0°", equation_4_7(0.0).1, "1").within(0.0),
                    Measurement::here("listing: Lambert's weight at 0°", listing(0.0).1, ".04"),
                ]
            },
        },
        Erratum {
            number: 23,
            place: "M §4.3, the text against maskDiffuse",
            printed: "text: \"white in color renders the metal material and the black color renders the rust\"; listing: mask.x ≤ .5 is metal",
            correct: "the listing: black is metal; §3.3 of M says the same",
            right: "none: the crate has no mask yet",
            note: "Contradiction.",
            measure: || {
                vec![
                    Measurement::here("listing: share of metal where the mask is black", metal_share_printed(0.0), "1")
                        .within(0.0),
                    Measurement::here("listing: share of metal where the mask is .5", metal_share_printed(0.5), "1")
                        .within(0.0),
                    Measurement::here("listing: share of metal where the mask is white", metal_share_printed(1.0), "0")
                        .within(0.0),
                    Measurement::here(
                        "text: share of metal where the mask is white",
                        metal_share_of_the_text(1.0),
                        "1",
                    )
                    .within(0.0),
                    Measurement::here(
                        "text: share of metal where the mask is black",
                        metal_share_of_the_text(0.0),
                        "0",
                    )
                    .within(0.0),
                ]
            },
        },
        Erratum {
            number: 24,
            place: "M §3.1.3 and §4.1.2",
            printed: "\"metals have reflectance of over 60 % for the whole angular range\"",
            correct: "some metals, in some channels, reflect less",
            right: "`fresnel::conductor` with `material::metal::METALS`",
            note: "The least reflectance over all angles. Fe is 2.87 + 3.35i, the index of the reference values; the crate's iron (Johnson & \
                   Christy) goes lower.",
            measure: || {
                let least = |n, k| range_over_cosines(|c| fresnel::conductor(c, n, k).reflectance).0;
                let (copper, chromium) = (index("copper_elek", 2), index("chromium_elek", 0));
                let of = |name: &str, channel: usize| {
                    let metal = metal::by_name(name).expect("built in");
                    least(metal.n[channel], metal.k[channel])
                };
                let lowest = metal::METALS
                    .iter()
                    .filter(|metal| !metal.name.starts_with("cuprite"))
                    .flat_map(|metal| [0, 1, 2].map(|c| least(metal.n[c], metal.k[c])))
                    .fold(1.0, f64::min);
                vec![
                    Measurement::notes("Cu.b", least(copper.0, copper.1), ".545"),
                    Measurement::notes("Cr.r", least(chromium.0, chromium.1), ".559"),
                    Measurement::notes("Fe", least(2.87, 3.35), ".530"),
                    Measurement::here("crate's iron, blue", of("iron", 2), ".485"),
                    Measurement::here("crate's gold, blue", of("gold", 2), ".408"),
                    Measurement::here("the least of the crate's metals: gold at 465 nm", lowest, ".403"),
                ]
            },
        },
        Erratum {
            number: 25,
            place: "M eq. 4.2 and §4.1.4",
            printed: "attenuation = 1/d, \"linear\"",
            correct: "1/d² of a point light",
            right: "none: lights are the caller's; the notes ask to offer both",
            note: "The power that passes a sphere around the light, in units of what passes at d = 1.",
            measure: || {
                let power = |attenuation: fn(f64) -> f64, d: f64| d * d * attenuation(d) / attenuation(1.0);
                vec![
                    Measurement::here("printed: power through d = 10", power(attenuation_printed, 10.0), "10")
                        .within(1e-12),
                    Measurement::here("correct: power through d = 10", power(attenuation_correct, 10.0), "1")
                        .within(1e-12),
                ]
            },
        },
    ]
}

#[test]
fn the_listing_and_the_equations_agree_forward() {
    // Erratum 19 is of γ < 0 alone.
    let (wi, wo) = (direction(70.0, 0.0), direction(40.0, 50.0));
    let [a, b] = [Printed::Equations, Printed::Listing].map(|form| oren_nayar_printed(form, wi, wo, 0.5));
    assert!((a - b).abs() < 1e-5, "{a} {b}");
    let wo = direction(40.0, 130.0);
    let [a, b] = [Printed::Equations, Printed::Listing].map(|form| oren_nayar_printed(form, wi, wo, 0.5));
    assert!((a - b).abs() > 0.1, "{a} {b}");
}
