//! E's layered model: Algorithm 1, equations 2–4, the metallic paint and the patina.

use crate::elek::{Dots, Listing, appendix_b, dots, index, lazanyi_printed, normalize, up};
use crate::integrate::{albedo, albedo_of_radiance, direction, range_over_pairs};
use crate::record::{Erratum, Measurement};
use brdf::check::Fixed;
use brdf::layered::{Interface, Layer, Model, Stack, internal_reflection};
use brdf::{Real, Vector, absorption, fresnel, microfacet, refraction};
use std::f64::consts::PI;

/// The uniform variables of Algorithm 1, one channel of them.
#[derive(Clone, Copy)]
pub(crate) struct Algorithm1<R> {
    /// n₁, κ₁ and m₁.
    pub(crate) upper: (R, R, R),
    /// n₂, κ₂ and m₂.
    pub(crate) lower: (R, R, R),
    pub(crate) sigma: R,
    pub(crate) d: R,
    /// The texel of the diffuse map.
    pub(crate) diffuse: R,
    /// Whether the patina's diffuse term of §4.2 is added to the upper layer.
    pub(crate) patina: bool,
}

/// `refract` of HLSL and Cg: `i` towards the surface, 0 on total reflection.
pub(crate) fn hlsl_refract<R: Real>(i: Vector<R>, n: Vector<R>, eta: R) -> Vector<R> {
    let cos = n.dot(i);
    let k = R::ONE - eta * eta * (R::ONE - cos * cos);
    let total = k.lt(R::ZERO);
    let bent = i * eta - n * (eta * cos + k.max(R::ZERO).sqrt());
    let pick = |x: R| R::select(total, R::ZERO, x);
    Vector::new(pick(bent.x), pick(bent.y), pick(bent.z))
}

/// L′ and V′ of Algorithm 1, lines 7–8, as printed.
pub(crate) fn refracted_printed<R: Real>(w: Vector<R>, normal: Vector<R>, n1: R) -> Vector<R> {
    -hlsl_refract(w, normal, R::ONE / n1)
}

/// Algorithm 1 as printed, without the environment and with lightCol = 1: the radiance that line 30 adds.
pub(crate) fn algorithm_1<R: Real>(s: &Algorithm1<R>, normal: Vector<R>, wi: Vector<R>, wo: Vector<R>) -> R {
    let (n1, k1, m1) = s.upper;
    let (n2, k2, m2) = s.lower;
    let (wi_below, wo_below) = (refracted_printed(wi, normal, n1), refracted_printed(wo, normal, n1));
    let above = dots(normal, wi, wo);
    let below = dots(normal, wi_below, wo_below);
    let Listing { value: mut f1, f: fresnel1, g: g1 } = appendix_b(above, n1, k1, m1);
    if s.patina {
        // §4.2, listing 3, with the σ of the layer.
        f1 = f1 + (R::ONE - s.sigma) * (R::ONE - fresnel1) * above.nl.max(R::ZERO);
    }
    let Listing { value: mut f2, f: fresnel2, .. } = appendix_b(below, n2, k2, m2.max(m1));
    f2 = f2 + (R::ONE - fresnel2) * above.nl.max(R::ZERO) * s.diffuse;
    let t12 = R::ONE - fresnel1;
    let t21 = t12;
    let t = (R::ONE - g1) + t21 * g1;
    let l = s.d * (R::ONE / below.nl + R::ONE / below.nv);
    let a = (-s.sigma * l).exp();
    f1 + t12 * f2 * a * t
}

/// A clear coat of n = 1.5, m = .1 over Cu.r of m = .3: the stack that most of the numbers are of.
const COATED_COPPER: Algorithm1<f64> =
    Algorithm1 { upper: (1.5, 0.0, 0.1), lower: (0.213, 4.05, 0.3), sigma: 0.0, d: 0.0, diffuse: 0.0, patina: false };

/// The same stack in the crate.
pub(crate) fn stack(s: &Algorithm1<f64>, model: Model) -> Stack<f64, 1> {
    let interface = |(n, k, m)| Layer::new(Interface::conductor([n], [k], m));
    Stack::new(model, vec![interface(s.upper).over([s.sigma], s.d), interface(s.lower)]).expect("a valid stack")
}

/// The fraction that a layer lets through as equation 3 prints it: N·L where N·L′ belongs.
fn absorption_printed(tau: f64, cos_i: f64, cos_o_below: f64) -> f64 {
    (-tau * (1.0 / cos_i + 1.0 / cos_o_below)).exp()
}

/// E §4.1: N += max(distance, 1)·z + 2·texel − 1, normalised.
pub(crate) fn flake_normal(normal: Vector<f64>, distance: f64, texel: [f64; 3]) -> Vector<f64> {
    let [x, y, z] = texel.map(|t| 2.0 * t - 1.0);
    normalize(normal + up() * distance.max(1.0) + Vector::new(x, y, z))
}

pub(crate) fn errata() -> Vec<Erratum> {
    vec![
        Erratum {
            number: 4,
            place: "E Alg. 1, lines 21 and 30",
            printed: "f₂ = TorranceSparrow(NL′, NV′, …), which is π·f₂·NL′, is added to π·f₁·NL",
            correct: "π·f₂·NL: the light that comes in is weighed by NL at every layer",
            right: "`layered::elek` (eq. 2 with one NL), and `layered::conserving`, which also conserves energy",
            note: "The whole listing as printed, n = 1.5, m₁ = .1 over Cu.r, m₂ = .3, with the printed q⁴. The reciprocity ratio is \
                   f(89°, 10°)/f(10°, 89°) across the normal; it is (NL′/NL)·(NV/NV′), and has no bound. Equation 2 itself gains energy too \
                   (erratum 7 and the missing 1/n²), but is reciprocal.",
            measure: || {
                let s = COATED_COPPER;
                let listing = |wi, wo| algorithm_1(&s, up(), wi, wo);
                let elek = stack(&s, Model::Elek);
                let conserving = stack(&s, Model::Conserving);
                let ratio = |f: &dyn Fn(Vector<f64>, Vector<f64>) -> f64, low: f64| {
                    let (wi, wo) = (direction(89.0, 0.0), direction(low, 180.0));
                    f(wi, wo) / f(wo, wi)
                };
                let listing_f = |wi: Vector<f64>, wo| listing(wi, wo) / (PI * wi.z);
                vec![
                    Measurement::notes("printed: albedo at 0°", albedo_of_radiance(0.0, Fixed::View, listing), "2.35"),
                    Measurement::notes(
                        "printed: albedo with the light at 89.5°",
                        albedo_of_radiance(89.5, Fixed::Light, listing),
                        "72.6",
                    ),
                    Measurement::notes("printed: reciprocity ratio, 89° and 10°", ratio(&listing_f, 10.0), "42"),
                    Measurement::here("printed: reciprocity ratio, 89° and 0°", ratio(&listing_f, 0.0), "42.7"),
                    Measurement::here(
                        "`elek`: albedo at 0°",
                        albedo(0.0, Fixed::View, |wi, wo| elek.evaluate(wi, wo)[0]),
                        "1.625",
                    ),
                    Measurement::here(
                        "`elek`: albedo with the light at 89.5°",
                        albedo(89.5, Fixed::Light, |wi, wo| elek.evaluate(wi, wo)[0]),
                        "1.57",
                    ),
                    Measurement::here(
                        "`elek`: reciprocity ratio, 89° and 10°",
                        ratio(&|wi, wo| elek.evaluate(wi, wo)[0], 10.0),
                        "1",
                    )
                    .within(1e-12),
                    Measurement::here(
                        "`conserving`: albedo at 0°",
                        albedo(0.0, Fixed::View, |wi, wo| conserving.evaluate(wi, wo)[0]),
                        ".707",
                    ),
                ]
            },
        },
        Erratum {
            number: 7,
            place: "E eq. 2 and Alg. 1, line 21",
            printed: "the Fresnel term of a lower layer takes n₂ + iκ₂, its index against vacuum",
            correct: "(n₂ + iκ₂)/n₁, its index against the layer above",
            right: "`fresnel::conductor(c, n₂/n₁, κ₂/n₁)`, as `layered::conserving` does; `layered::elek` keeps the printed form",
            note: "Reflectance at normal incidence under n₁ = 1.5.",
            measure: || {
                let f0 = |(n, k): (f64, f64), above: f64| fresnel::conductor(1.0, n / above, k / above).reflectance;
                let matched = |above: f64| fresnel::dielectric(1.0, 1.5 / above).reflectance;
                let (copper, chromium) = (index("copper_elek", 2), index("chromium_elek", 0));
                vec![
                    Measurement::notes("printed: F₀ of Cu.b", f0(copper, 1.0), ".545"),
                    Measurement::notes("correct: F₀ of Cu.b", f0(copper, 1.5), ".447"),
                    Measurement::notes("printed: F₀ of Cr.r", f0(chromium, 1.0), ".639"),
                    Measurement::notes("correct: F₀ of Cr.r", f0(chromium, 1.5), ".516"),
                    Measurement::notes("printed: F₀ of a dielectric n = 1.5 under its own index", matched(1.0), ".04"),
                    Measurement::notes("correct: F₀ of a dielectric n = 1.5 under its own index", matched(1.5), "0")
                        .within(0.0),
                ]
            },
        },
        Erratum {
            number: 8,
            place: "E eq. 3",
            printed: "l = d·(1/(N·L) + 1/(N·V′))",
            correct: "l = d·(1/(N·L′) + 1/(N·V′)), as Alg. 1, line 26 has it",
            right: "`absorption::transmittance` with the cosines of `refraction::refract`",
            note: "σ·d = .2 under n = 1.5, the other direction the normal. The ratio grows without bound: exp(σ·d/NL) at grazing.",
            measure: || {
                let tau = 0.2;
                let below = |theta: f64| refraction::cos_t(theta.to_radians().cos(), 1.5);
                let cos = |theta: f64| theta.to_radians().cos();
                let printed = |i: f64, o: f64| {
                    absorption_printed(tau, cos(o), below(i)) / absorption_printed(tau, cos(i), below(o))
                };
                let correct = |i: f64, o: f64| {
                    absorption::transmittance(tau, 1.0, below(i), below(o))
                        / absorption::transmittance(tau, 1.0, below(o), below(i))
                };
                vec![
                    Measurement::here("printed: reciprocity ratio at 60°", printed(60.0, 0.0), "1.17"),
                    Measurement::here("printed: reciprocity ratio at 80°", printed(80.0, 0.0), "2.43"),
                    Measurement::here("printed: its decimal logarithm at 89°", printed(89.0, 0.0).log10(), "4.86"),
                    Measurement::here("printed: its decimal logarithm at 89.9°", printed(89.9, 0.0).log10(), "49.65"),
                    Measurement::here("correct: reciprocity ratio at 89.9°", correct(89.9, 0.0), "1").within(0.0),
                ]
            },
        },
        Erratum {
            number: 9,
            place: "E Alg. 1, lines 7–8",
            printed: "L′ = −refract(L, N, 1/n₁)",
            correct: "L′ = −refract(−L, N, 1/n₁)",
            right: "`refraction::refract`",
            note: "`refract` takes a ray towards the surface; given one that leaves it, it bends the right way and turns the tangential part \
                   round. While one N serves all dot products they do not notice. §4.1 inserts the flakes' normal between lines 13 and 14, \
                   where L′, V′ and H′ exist and their dot products do not. The flake is the texel (.7, .4, .9) at distance 1, the view \
                   is the normal, the lights are at 30° all around.",
            measure: || {
                let n1 = 1.5;
                let printed = |w| refracted_printed(w, up(), n1);
                let correct = |w: Vector<f64>| refraction::refract(w, n1);
                let apart = |a: Dots<f64>, b: Dots<f64>| {
                    [a.nl - b.nl, a.nv - b.nv, a.nh - b.nh, a.vh - b.vh].iter().fold(0.0f64, |w, x| w.max(x.abs()))
                };
                let (_, shared) = range_over_pairs(89.0, |wi, wo| {
                    apart(dots(up(), printed(wi), printed(wo)), dots(up(), correct(wi), correct(wo)))
                });
                let wi = direction(60.0, 25.0);
                let turned = (printed(wi).x + correct(wi).x).abs().max((printed(wi).y + correct(wi).y).abs());
                let flake = flake_normal(up(), 1.0, [0.7, 0.4, 0.9]);
                let (_, perturbed) = range_over_pairs(60.0, |wi, wo| {
                    apart(dots(flake, printed(wi), printed(wo)), dots(flake, correct(wi), correct(wo)))
                });
                // The azimuth of the light for which the flake shines.
                let brightest = |bend: &dyn Fn(Vector<f64>) -> Vector<f64>| {
                    (0..360)
                        .map(|degree| {
                            let azimuth = f64::from(degree);
                            (dots(flake, bend(direction(30.0, azimuth)), bend(up())).nh, azimuth)
                        })
                        .fold((0.0, 0.0), |best, next| if next.0 > best.0 { next } else { best })
                };
                let (wrong, right) = (brightest(&printed), brightest(&correct));
                vec![
                    Measurement::here("printed + correct: tangential part of L′, L at 60°", turned, "0").within(1e-15),
                    Measurement::here("one N: the largest difference of a dot product", shared, "0").within(1e-14),
                    Measurement::here("a flake's N: the largest difference of a dot product", perturbed, ".182"),
                    Measurement::here(
                        "correct: azimuth of the light that the flake answers, in degrees",
                        right.1,
                        "333",
                    ),
                    Measurement::here("printed: the same", wrong.1, "153"),
                    Measurement::here("printed: how far round that is, in degrees", (wrong.1 - right.1).abs(), "180"),
                ]
            },
        },
        Erratum {
            number: 10,
            place: "E Alg. 1, lines 7–8 with its data",
            printed: "n₁ is float3, 1/n₁ is passed as the scalar eta of `refract`",
            correct: "a scalar index for directions, or a pair of directions for each channel",
            right: "`layered::conserving` and `layered::elek`: one pair while the channels agree, else one for each",
            note: "A Cg compiler drops all but the first component: green and blue are bent by red's index. Cu₂O of App. A, light at 80°. \
                   The last row asks the crate's `elek` for green in a stack of three channels and alone.",
            measure: || {
                let n1 = [0, 1, 2].map(|c| index("cuprite_elek", c).0);
                let light = direction(80.0, 0.0);
                let angle = |w: Vector<f64>| w.z.acos().to_degrees();
                // The float3 as a scalar: its x.
                let [scalar, green, _] = n1;
                let printed = angle(refracted_printed(light, up(), scalar));
                let correct = angle(refraction::refract(light, green));
                let layers = |n: [f64; 3]| {
                    vec![
                        Layer::new(Interface::conductor(n, [0.0; 3], 0.1)),
                        Layer::new(Interface::diffuse([1.0; 3], 0.5)),
                    ]
                };
                let of = |n| Stack::new(Model::Elek, layers(n)).expect("a valid stack");
                let (wi, wo) = (direction(80.0, 0.0), direction(60.0, 180.0));
                let three = of(n1).evaluate(wi, wo)[1];
                let alone = of([green; 3]).evaluate(wi, wo)[1];
                vec![
                    Measurement::here("printed: refracted angle of green, in degrees", printed, "20.36"),
                    Measurement::here("correct: refracted angle of green, in degrees", correct, "18.52"),
                    Measurement::here("crate: green of three channels / green alone", three / alone, "1").within(0.0),
                ]
            },
        },
        Erratum {
            number: 11,
            place: "E Alg. 1, line 22",
            printed: "f₂ += (1 − F₂(VH))·NL·diffuse",
            correct: "what enters and leaves again: (1−F(L))·(1−F(V))/n², and the same light cannot be reflected by F₂ as well",
            right: "`layered::conserving` with a diffuse base",
            note: "Layer 2 alone, so that NL′ is NL: n = 1.5, m = .1, diffuse = 1, printed q⁴, at 89.5°.",
            measure: || {
                let m = 0.1;
                let printed = |wi: Vector<f64>, wo| {
                    let d = dots(up(), wi, wo);
                    let Listing { value, f, .. } = appendix_b(d, 1.5, 0.0, m);
                    value + (1.0 - f) * d.nl
                };
                let layers =
                    vec![Layer::new(Interface::dielectric(1.5, m)), Layer::new(Interface::diffuse([1.0], 0.0))];
                let correct = Stack::<f64, 1>::new(Model::Conserving, layers).expect("a valid stack");
                vec![
                    Measurement::notes(
                        "printed: albedo at 89.5°",
                        albedo_of_radiance(89.5, Fixed::View, printed),
                        "1.69",
                    ),
                    Measurement::here("printed: albedo at 0°", albedo_of_radiance(0.0, Fixed::View, printed), "1.00"),
                    Measurement::here(
                        "correct: albedo at 89.5°",
                        albedo(89.5, Fixed::View, |wi, wo| correct.evaluate(wi, wo)[0]),
                        ".725",
                    ),
                ]
            },
        },
        Erratum {
            number: 12,
            place: "E §4.2, listing 3",
            printed: "f₁ += (1−σ)·(1−F₁)·NL, and T₁₂ stays 1 − F₁",
            correct: "light that the patina scatters back does not reach the copper",
            right: "none yet: a Kubelka–Munk base under the interface; `layered::conserving` over a diffuse base is measured in its place",
            note: "The whole listing as printed, red channel, Cu₂O over Cu of App. A, m₁ = m₂ = .3, σ = 0, view at 0, 30, 45, 60, 75, \
                   80, 85 and 89°. σ is an absorption coefficient in 1/length and may exceed 1; the term is then negative. With m₁ = .1 \
                   the range is 3.4–4.0.",
            measure: || {
                let with = |m, sigma| {
                    let ((n1, k1), (n2, k2)) = (index("cuprite_elek", 0), index("copper_elek", 0));
                    Algorithm1 { upper: (n1, k1, m), lower: (n2, k2, m), sigma, d: 0.0, diffuse: 0.0, patina: true }
                };
                let s = with(0.3, 0.0);
                let albedos = [0.0, 30.0, 45.0, 60.0, 75.0, 80.0, 85.0, 89.0]
                    .map(|theta| albedo_of_radiance(theta, Fixed::View, |wi, wo| algorithm_1(&s, up(), wi, wo)));
                let (low, high) = albedos.iter().fold((f64::MAX, 0.0f64), |(a, b), x| (a.min(*x), b.max(*x)));
                let bare = Algorithm1 { patina: false, ..s };
                let without = albedo_of_radiance(0.0, Fixed::View, |wi, wo| algorithm_1(&bare, up(), wi, wo));
                // σ = 2 with a layer so thick that the copper is not seen, off the mirror direction.
                let thick = Algorithm1 { d: 100.0, ..with(0.1, 2.0) };
                let negative = algorithm_1(&thick, up(), direction(60.0, 0.0), direction(60.0, 0.0)) / (PI * 0.5);
                let (n1, k1) = index("cuprite_elek", 0);
                let layers =
                    vec![Layer::new(Interface::conductor([n1], [k1], 0.3)), Layer::new(Interface::diffuse([1.0], 0.0))];
                let correct = Stack::<f64, 1>::new(Model::Conserving, layers).expect("a valid stack");
                vec![
                    Measurement::notes("printed: the least albedo", low, "3.3"),
                    Measurement::notes("printed: the largest albedo", high, "3.8"),
                    Measurement::here("printed, without this term: albedo at 0°", without, "2.98"),
                    Measurement::here("printed: f at σ = 2, both directions at 60°", negative, "−.246"),
                    Measurement::here(
                        "correct, a white patina that hides the copper: albedo at 89°",
                        albedo(89.0, Fixed::View, |wi, wo| correct.evaluate(wi, wo)[0]),
                        ".503",
                    ),
                ]
            },
        },
    ]
}

#[test]
fn the_listing_is_equation_2_with_another_cosine() {
    // With the exact Fresnel terms of the crate and NL for NL′, Algorithm 1 is the crate's `elek`.
    let s = Algorithm1 { sigma: 0.4, d: 0.5, ..COATED_COPPER };
    let elek = stack(&s, Model::Elek);
    let (wi, wo) = (direction(40.0, 0.0), direction(25.0, 170.0));
    let (below_i, below_o) = (refraction::refract(wi, 1.5), refraction::refract(wo, 1.5));
    let (above, below) = (dots(up(), wi, wo), dots(up(), below_i, below_o));
    let exact = |d: Dots<f64>, (n, k, _): (f64, f64, f64)| fresnel::conductor(d.vh, n, k).reflectance;
    let upper = appendix_b(above, 1.5, 0.0, 0.1).value / lazanyi_printed(above.vh, 1.5, 0.0) * exact(above, s.upper);
    let lower =
        appendix_b(below, 0.213, 4.05, 0.3).value / lazanyi_printed(below.vh, 0.213, 4.05) * exact(below, s.lower);
    let (t12, g) = (1.0 - exact(above, s.upper), appendix_b(above, 1.5, 0.0, 0.1).g);
    let a = (-0.2 * (1.0 / below.nl + 1.0 / below.nv)).exp();
    let want = upper / (PI * wi.z) + t12 * (lower / (PI * below_i.z)) * a * ((1.0 - g) + t12 * g);
    let got = elek.evaluate(wi, wo)[0];
    assert!((got / want - 1.0).abs() < 1e-12, "{got} {want}");
}

#[test]
fn the_listing_is_made_of_the_terms_of_the_crate() {
    // Algorithm 1 as printed, from the crate's D·V, refraction, absorption and t, with the printed Fresnel terms. Errata 3
    // and 4 are the cosines; the lower interface is the smoother one, so that the clamp is seen.
    let s = Algorithm1 { upper: (1.5, 0.0, 0.4), lower: (0.213, 4.05, 0.05), sigma: 0.4, d: 0.5, ..COATED_COPPER };
    for (light, view) in [(40.0, 25.0), (75.0, 60.0), (10.0, 80.0)] {
        let (wi, wo) = (direction(light, 0.0), direction(view, 150.0));
        let below = (refraction::refract(wi, 1.5), refraction::refract(wo, 1.5));
        let lobe = |wi: Vector<f64>, wo, (n, k, _), m| {
            let facets = microfacet::facets(wi, wo, m);
            let f = lazanyi_printed(microfacet::cos_half(wi, wo), n, k);
            (PI * f * facets.lobe * wi.z, f, facets.g)
        };
        let (f1, fresnel1, g1) = lobe(wi, wo, s.upper, 0.4);
        let (f2, ..) = lobe(below.0, below.1, s.lower, 0.4);
        let t12 = 1.0 - fresnel1;
        let a = absorption::transmittance(0.4, 0.5, below.0.z, below.1.z);
        let want = f1 + t12 * f2 * a * internal_reflection(t12, g1);
        let got = algorithm_1(&s, up(), wi, wo);
        assert!((got / want - 1.0).abs() < 1e-12, "{light} {view}: {got} {want}");
    }
}
