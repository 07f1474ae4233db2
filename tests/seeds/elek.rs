//! E on a single surface: the Torrance–Sparrow model of §2.1 and Appendix B, its Fresnel term, and the patina's edge.

use crate::integrate::{albedo, albedo_of_radiance, direction, range_over_pairs, worst_cosine};
use crate::record::{Erratum, Measurement};
use brdf::check::Fixed;
use brdf::material::{metal, patina};
use brdf::{Real, Vector, fresnel, microfacet};
use std::f64::consts::PI;

/// The index of a material of E, Appendix A, for one channel: 0 red, 1 green, 2 blue.
pub(crate) fn index(name: &str, channel: usize) -> (f64, f64) {
    let metal = metal::by_name(name).expect("a built-in material");
    (metal.n[channel], metal.k[channel])
}

/// The dot products that both documents' listings start from, with H normalised as they do it: NaN where H is 0.
#[derive(Clone, Copy)]
pub(crate) struct Dots<R> {
    pub(crate) nl: R,
    pub(crate) nv: R,
    pub(crate) nh: R,
    pub(crate) vh: R,
}

pub(crate) fn dots<R: Real>(normal: Vector<R>, wi: Vector<R>, wo: Vector<R>) -> Dots<R> {
    let h = normalize(wo + wi);
    Dots { nl: normal.dot(wi), nv: normal.dot(wo), nh: normal.dot(h), vh: wo.dot(h) }
}

/// A shader's `normalize`, which divides by whatever length there is.
pub(crate) fn normalize<R: Real>(v: Vector<R>) -> Vector<R> {
    v * (R::ONE / v.length_squared().sqrt())
}

pub(crate) fn up<R: Real>() -> Vector<R> {
    Vector::new(R::ZERO, R::ZERO, R::ONE)
}

/// Beckmann's distribution as E prints it, §2.1 and Appendix B: without 1/π, from 1 − NH².
pub(crate) fn beckmann_printed<R: Real>(nh: R, m: R) -> R {
    let tg = (R::ONE - nh * nh).sqrt() / nh;
    R::ONE / (m * m * nh * nh * nh * nh) * (-((tg / m) * (tg / m))).exp()
}

/// Cook and Torrance's G as in Appendix B.
pub(crate) fn masking_printed<R: Real>(d: Dots<R>) -> R {
    R::ONE.min((d.nv * (R::TWO * d.nh) / d.vh).min(d.nl * (R::TWO * d.nh) / d.vh))
}

/// Lazányi's approximation as Appendix B prints it, with the fourth power.
pub(crate) fn lazanyi_printed<R: Real>(vh: R, n: R, k: R) -> R {
    let q = R::ONE - vh;
    ((n - R::ONE) * (n - R::ONE) + R::from_f64(4.0) * n * q * q * q * q + k * k) / ((n + R::ONE) * (n + R::ONE) + k * k)
}

/// E, equation 1, with the distribution of the same page.
pub(crate) fn equation_1(reflectance: f64, d: Dots<f64>, m: f64) -> f64 {
    reflectance * beckmann_printed(d.nh, m) * masking_printed(d) / (PI * d.nl * d.nv)
}

/// What the listing of Appendix B returns: its value and the two `out` parameters.
#[derive(Clone, Copy)]
pub(crate) struct Listing<R> {
    pub(crate) value: R,
    pub(crate) f: R,
    pub(crate) g: R,
}

/// The listing of Appendix B with any Fresnel term.
pub(crate) fn appendix_b_with<R: Real>(d: Dots<R>, f: R, m: R) -> Listing<R> {
    let g = masking_printed(d);
    Listing { value: f * beckmann_printed(d.nh, m) * g / (R::from_f64(4.0) * d.nv), f, g }
}

/// The listing of Appendix B as printed.
pub(crate) fn appendix_b<R: Real>(d: Dots<R>, n: R, k: R, m: R) -> Listing<R> {
    appendix_b_with(d, lazanyi_printed(d.vh, n, k), m)
}

/// The listing of E §4.2 with HLSL's `smoothstep`.
pub(crate) fn patina_extent_printed(extent: f64, transition: f64, value: f64) -> f64 {
    let (low, high) = (extent - transition, extent + transition);
    // clamp hands a NaN on.
    let t = ((value - low) / (high - low)).clamp(0.0, 1.0);
    1.0 - t * t * (3.0 - 2.0 * t)
}

pub(crate) fn errata() -> Vec<Erratum> {
    vec![
        Erratum {
            number: 1,
            place: "E eq. 1 with §2.1",
            printed: "f = F·D·G/(π·NL·NV), D = exp(−(tanα/m)²)/(m²cos⁴α)",
            correct: "f = F·D·G/(4·NL·NV), D = exp(−(tanα/m)²)/(π·m²cos⁴α)",
            right: "`microfacet::torrance_sparrow`, `distribution::beckmann`",
            note: "F = 1, m = .1, view along the normal.",
            measure: || {
                let m = 0.1;
                let printed = albedo(0.0, Fixed::View, |wi, wo| equation_1(1.0, dots(up(), wi, wo), m));
                let correct = albedo(0.0, Fixed::View, |wi, wo| microfacet::facets(wi, wo, m).lobe);
                let (low, high) = range_over_pairs(80.0, |wi, wo| {
                    equation_1(1.0, dots(up(), wi, wo), 0.5) / microfacet::facets(wi, wo, 0.5).lobe
                });
                vec![
                    Measurement::notes("printed: albedo, F = 1", printed, "4.00"),
                    Measurement::here("correct: albedo, F = 1", correct, "1.00"),
                    Measurement::notes("printed / correct, the least over pairs", low, "4").within(1e-9),
                    Measurement::notes("printed / correct, the largest over pairs", high, "4").within(1e-9),
                ]
            },
        },
        Erratum {
            number: 3,
            place: "E App. B",
            printed: "the listing's name and eq. 2 call its value f",
            correct: "the value F·D·G/(4·NV) with E's D is π·f·NL: the cosine is in it",
            right: "`microfacet::torrance_sparrow` returns f",
            note: "The Fresnel term is that of erratum 5 corrected, so that only the factor is seen. Right for the upper layer, whose \
                   light comes in at NL; for the lower one see erratum 4.",
            measure: || {
                let (n, k) = index("copper_elek", 0);
                let m = 0.3;
                let listing = |wi, wo| {
                    let d = dots(up(), wi, wo);
                    appendix_b_with(d, fresnel::lazanyi_uncorrected(d.vh, n, k), m).value
                };
                let f = |wi, wo| {
                    let cos_half = microfacet::cos_half(wi, wo);
                    fresnel::lazanyi_uncorrected(cos_half, n, k) * microfacet::facets(wi, wo, m).lobe
                };
                let (low, high) =
                    range_over_pairs(60.0, |wi: Vector<f64>, wo| listing(wi, wo) / (PI * f(wi, wo) * wi.z));
                let correct = albedo(0.0, Fixed::View, f);
                let as_radiance = albedo_of_radiance(0.0, Fixed::View, listing);
                let as_f = albedo(0.0, Fixed::View, listing);
                vec![
                    Measurement::notes("listing / π·f·NL, the least over pairs", low, "1").within(1e-9),
                    Measurement::notes("listing / π·f·NL, the largest over pairs", high, "1").within(1e-9),
                    Measurement::here("listing read as π·f·NL: albedo, Cu.r, m = .3, at 0°", as_radiance, ".948"),
                    Measurement::here("correct: the same", correct, ".948"),
                    Measurement::here("listing read as f: albedo", as_f, "2.526"),
                ]
            },
        },
        Erratum {
            number: 5,
            place: "E App. B",
            printed: "F = ((n−1)² + 4n·q·q·q·q + κ²)/((n+1)²+κ²), q = 1−VH",
            correct: "q⁵",
            right: "`fresnel::lazanyi_uncorrected`, and `fresnel::conductor`, which is exact",
            note: "Largest absolute error against the exact term over all angles. Cu is Cu.r.",
            measure: || {
                let printed =
                    |n, k| worst_cosine(|c| lazanyi_printed(c, n, k) - fresnel::conductor(c, n, k).reflectance).0;
                let correct = |n, k| {
                    worst_cosine(|c| fresnel::lazanyi_uncorrected(c, n, k) - fresnel::conductor(c, n, k).reflectance).0
                };
                let (n, k) = index("copper_elek", 0);
                vec![
                    Measurement::notes("printed: error for Cu", printed(n, k), "0.028"),
                    Measurement::notes("correct: error for Cu", correct(n, k), "0.024"),
                    Measurement::notes("printed: error for glass, n = 1.5", printed(1.5, 0.0), "0.103"),
                    Measurement::notes("correct: error for glass, n = 1.5", correct(1.5, 0.0), "0.036"),
                ]
            },
        },
        Erratum {
            number: 6,
            place: "E §3.1 and App. B",
            printed: "Lazányi's term without its correction \"deviates from the full formula in 5 % at most\"",
            correct: "F = q⁵ form − a·c·(1−c)^α with a, α fitted to the metal",
            right: "`fresnel::lazanyi` with `fresnel::lazanyi_fit`",
            note: "Largest absolute error over all angles.",
            measure: || {
                let error = |name, channel| {
                    let (n, k) = index(name, channel);
                    worst_cosine(|c| fresnel::lazanyi_uncorrected(c, n, k) - fresnel::conductor(c, n, k).reflectance)
                };
                let mut all = Vec::new();
                for (name, symbol, wants) in
                    [("copper_elek", "Cu", [".024", ".041", ".033"]), ("chromium_elek", "Cr", [".243", ".215", ".153"])]
                {
                    for (channel, want) in wants.into_iter().enumerate() {
                        let what = format!("without the correction: {symbol}.{}", ["r", "g", "b"][channel]);
                        all.push(Measurement::notes(what, error(name, channel).0, want));
                    }
                }
                all.push(Measurement::notes("… Cr.r: at which angle in degrees", error("chromium_elek", 0).1, "84"));
                let cuprite = [0, 1, 2].map(|channel| error("cuprite_elek", channel).0);
                let (low, high) = cuprite.iter().fold((1.0f64, 0.0f64), |(a, b), x| (a.min(*x), b.max(*x)));
                all.push(Measurement::notes("without the correction: Cu₂O, the best channel", low, ".11"));
                all.push(Measurement::notes("without the correction: Cu₂O, the worst channel", high, ".13"));
                let mut fitted = 0.0f64;
                for name in ["copper_elek", "chromium_elek", "cuprite_elek"] {
                    for channel in 0..3 {
                        let (n, k) = index(name, channel);
                        let fit = fresnel::lazanyi_fit(n, k);
                        let (error, _) = worst_cosine(|c| {
                            fresnel::lazanyi(c, n, k, fit.a, fit.exponent) - fresnel::conductor(c, n, k).reflectance
                        });
                        fitted = fitted.max(error);
                    }
                }
                all.push(Measurement::notes("with fitted (a, α): the worst of the nine", fitted, "≤ .0195"));
                all
            },
        },
        Erratum {
            number: 13,
            place: "E §4.2, listing 2",
            printed: "1 − smoothstep(extent − transition, extent + transition, value), transition in ⟨0, 1⟩",
            correct: "a step at transition = 0, with value = extent grown",
            right: "`material::patina::patina_extent`",
            note: "",
            measure: || {
                vec![
                    Measurement::notes(
                        "printed: transition = 0, value = extent = .5",
                        patina_extent_printed(0.5, 0.0, 0.5),
                        "NaN",
                    ),
                    Measurement::here("correct: the same", patina::patina_extent(0.5, 0.0, 0.5), "1").within(0.0),
                    Measurement::here(
                        "correct: transition = 0, value .01 above extent",
                        patina::patina_extent(0.5, 0.0, 0.51),
                        "0",
                    )
                    .within(0.0),
                    Measurement::here(
                        "printed − correct: transition = .65, extent = .45, value = .3",
                        patina_extent_printed(0.45, 0.65, 0.3) - patina::patina_extent(0.45, 0.65, 0.3),
                        "0",
                    )
                    .within(1e-15),
                ]
            },
        },
    ]
}

#[test]
fn the_listing_needs_no_direction_but_the_dots() {
    // The two forms of E differ by π·NL and the missing powers alone.
    let (wi, wo) = (direction(50.0, 0.0), direction(30.0, 140.0));
    let d = dots(up(), wi, wo);
    let f = 0.7;
    let ratio = appendix_b_with(d, f, 0.3).value / (equation_1(f, d, 0.3) * d.nl);
    assert!((ratio - PI / 4.0).abs() < 1e-14, "{ratio}");
}
