//! The documents' formulas as they are printed, with the numbers that FORMULAS.md and LAYERED.md record for them.

use crate::microfacet::{beckmann, torrance_sparrow, v_cavity};
use crate::{Energy, judge_all, of, one};
use brdf::check::{Albedo, Cause, Check, Fixed, Options, Report, StackSubject, Subject, Verdict, check};
use brdf::layered::{Interface, Layer, Model, Stack};
use brdf::{Vector, half_vector};
use std::f64::consts::{FRAC_1_PI, PI};

#[test]
fn single_surfaces() {
    judge_all(&[
        // Erratum 1: 4 times too bright.
        one("E eq. 1, m=.1", |wi, wo| 4.0 * torrance_sparrow(0.1)(wi, wo))
            .energy(Energy::Fail(4.0, 0.002))
            .cause(Cause::MissingQuarter),
        // Erratum 2: 4/π.
        one("M 4.8 with 4.12, m=.1", |wi, wo| torrance_sparrow(0.1)(wi, wo) * 4.0 / PI)
            .energy(Energy::Fail(1.273, 0.002))
            .cause(Cause::PiForQuarter),
        // Erratum 3: π·f·NL.
        one("E App. B, m=.3", |wi, wo| PI * torrance_sparrow(0.3)(wi, wo) * wi.z)
            .energy(Energy::Any)
            .fails(Check::Reciprocity)
            .cause(Cause::PiCosine),
        // Erratum 18: multiplied by NL·NV: 1.27 at the normal, 0 at grazing.
        one("M specular printed, m=.02", |wi, wo| {
            let g = v_cavity(wi, wo) * 4.0 * wi.z * wo.z;
            beckmann(half_vector(wi, wo), 0.02) * g * FRAC_1_PI * (wi.z * wo.z + 1e-7)
        })
        .energy(Energy::Fail(1.27, 0.004))
        .cause(Cause::NoDenominator),
    ]);
}

fn copper(top: f64, base: f64, model: Model) -> Stack<f64, 1> {
    let layers =
        vec![Layer::new(Interface::dielectric(1.5, top)), Layer::new(Interface::conductor([0.213], [4.05], base))];
    Stack::new(model, layers).expect("a valid stack")
}

/// What a report must say: the albedo at some angles, and the verdict of the energy of a marginal.
struct Expected<'a> {
    name: &'a str,
    fixed: Fixed,
    verdict: Verdict,
    /// Degrees and albedos.
    albedos: &'a [(f64, f64)],
    /// What the albedos may differ by, relatively.
    off: f64,
}

/// Checks a subject under each seed at the angles that are known, and at grazing.
fn judged(subject: &dyn Subject, expected: &Expected<'_>) -> Vec<Report> {
    let Expected { name, fixed, verdict, albedos, off } = *expected;
    let thetas: Vec<f64> = albedos.iter().map(|(theta, _)| *theta).chain([89.9]).collect();
    let each = |seed| {
        let report = check(subject, &Options { seed, budget: 300_000, thetas: &thetas, ..Options::default() });
        let energy = report.energy(fixed).expect("energy is always checked");
        println!("{name}: {energy}");
        assert_eq!(energy.verdict, verdict, "{name}: {report}");
        for &(theta, want) in albedos {
            let at = |albedo: &&Albedo| albedo.fixed == fixed && albedo.theta == theta;
            let found = report.albedos.iter().find(at).expect("an albedo at every angle");
            assert!((found.value[0] / want - 1.0).abs() <= off, "{name} at {theta}°: {want} expected: {found:?}");
        }
        report
    };
    crate::SEEDS.map(each).into()
}

fn stack(model: Model, top: Layer<f64, 1>, base: Layer<f64, 1>) -> StackSubject<1> {
    StackSubject::new(model.name(), Stack::new(model, vec![top, base]).expect("a valid stack"))
}

#[test]
fn stacks_reflect_what_the_table_says() {
    // LAYERED.md: n = 1.5, the angles 0°, 60° and 80°.
    let copper = |alpha| Layer::new(Interface::conductor([0.213], [4.05], alpha));
    let coat = Layer::new(Interface::dielectric(1.5, 0.1));
    let grey = Layer::new(Interface::diffuse([0.5], 0.0));
    let (pass, fail) = (Verdict::Pass, Verdict::Fail);
    let at = |albedos: [f64; 3]| [(0.0, albedos[0]), (60.0, albedos[1]), (80.0, albedos[2])];
    // The table has three digits, of albedos from .234 on: half a digit is .2 %, and its own integration is allowed as much. Elek's
    // are met within 3 %: .547 and 1.486 at 60°, where it prints .533 and 1.52 and does not say how they were integrated.
    // `coupled` is held to the column of the truth, which this crate's meets where the document's own does not (.726 at 60°).
    let rows = [
        (Model::Elek, coat, grey, fail, at([0.502, 0.533, 0.795]), 0.03),
        (Model::Conserving, coat, grey, pass, at([0.234, 0.275, 0.445]), 6e-3),
        (Model::Coupled, coat, grey, pass, at([0.316, 0.351, 0.503]), 6e-3),
        (Model::Elek, coat, copper(0.1), fail, at([2.01, 1.52, 1.10]), 0.03),
        (Model::Conserving, coat, copper(0.1), pass, at([0.900, 0.678, 0.578]), 6e-3),
        (Model::Coupled, coat, copper(0.1), pass, at([0.933, 0.839, 0.777]), 6e-3),
    ];
    for (model, top, base, verdict, albedos, off) in rows {
        let expected = Expected { name: model.name(), fixed: Fixed::View, verdict, albedos: &albedos, off };
        for report in judged(&stack(model, top, base), &expected) {
            for check in [Check::Finite, Check::Sign, Check::Sampling, Check::Density, Check::Weight] {
                assert_eq!(report.finding(check).map(|finding| finding.verdict), Some(pass), "{report}");
            }
        }
    }
    // The largest albedo: m₁ = .1 over m₂ = .3. The table's third number, .73 for `conserving`, and its row of Cu₂O are not reproduced.
    for (model, verdict, most) in [(Model::Elek, fail, 1.63), (Model::WeidlichWilkie, pass, 0.85)] {
        let thetas = [0.0, 30.0, 45.0, 60.0, 75.0, 80.0, 85.0];
        let options = Options { budget: 300_000, thetas: &thetas, ..Options::default() };
        let report = check(&stack(model, coat, copper(0.3)), &options);
        let energy = report.energy(Fixed::View).expect("energy is always checked");
        assert_eq!(energy.verdict, verdict, "{report}");
        assert!((energy.value - most).abs() <= 0.01, "{most} expected: {report}");
    }
}

/// E's listing of Appendix B: π·f·NL, with q⁴ in the Fresnel term, which is the second number, and G.
fn appendix_b(n: Vector<f64>, wi: Vector<f64>, wo: Vector<f64>, (ior, k, m): (f64, f64, f64)) -> [f64; 3] {
    let h = half_vector(wi, wo).normalized();
    let (nl, nv, nh, vh) = (n.dot(wi), n.dot(wo), n.dot(h), wo.dot(h));
    // max: 1 − NH² is below 0 by rounding at the mirror direction, and the listing NaN.
    let tan = (1.0 - nh * nh).max(0.0).sqrt() / nh;
    let d = (-(tan / m).powi(2)).exp() / (m * m * nh.powi(4));
    let g = 1f64.min((nv * 2.0 * nh / vh).min(nl * 2.0 * nh / vh));
    let f = ((ior - 1.0).powi(2) + 4.0 * ior * (1.0 - vh).powi(4) + k * k) / ((ior + 1.0).powi(2) + k * k);
    [f * d * g / (4.0 * nv), f, g]
}

/// E's Algorithm 1 with the layers' (n, κ, m), over π·NL; `patina` is (1 − σ) of §4.2, listing 3, and σ = 0 absorbs nothing.
fn algorithm_1(
    upper: (f64, f64, f64),
    lower: (f64, f64, f64),
    patina: f64,
) -> impl Fn(Vector<f64>, Vector<f64>) -> f64 + Send + Sync {
    let up = Vector::new(0.0, 0.0, 1.0);
    move |wi, wo| {
        let below = |v: Vector<f64>| {
            let (x, y) = (v.x / upper.0, v.y / upper.0);
            Vector::new(x, y, (1.0 - x * x - y * y).sqrt())
        };
        let [f1, fresnel, g] = appendix_b(up, wi, wo, upper);
        let [f2, ..] = appendix_b(up, below(wi), below(wo), lower);
        let transmitted = 1.0 - fresnel;
        let inside = (1.0 - g) + transmitted * g;
        (f1 + patina * transmitted * wi.z + transmitted * f2 * inside) / (PI * wi.z)
    }
}

#[test]
fn the_listings_give_out_more_than_they_get() {
    let up = Vector::new(0.0, 0.0, 1.0);
    let over = |name, fixed, albedos| Expected { name, fixed, verdict: Verdict::Fail, albedos, off: 6e-3 };
    // Erratum 4: 2.35 along the normal, 72.6 with the light at 89.5°, f(89°, 10°)/f(10°, 89°) = 42.
    let algorithm = one("Alg. 1", algorithm_1((1.5, 0.0, 0.1), (0.213, 4.05, 0.3), 0.0)).subject;
    for report in judged(&*algorithm, &over("Alg. 1", Fixed::View, &[(0.0, 2.35)])) {
        assert_eq!(report.finding(Check::Reciprocity).map(|finding| finding.verdict), Some(Verdict::Fail), "{report}");
    }
    judged(&*algorithm, &over("Alg. 1", Fixed::Light, &[(89.5, 72.6)]));
    // LAYERED.md: 2.07 along the normal and up to 2.8 times, with m = .1 in both.
    let algorithm = one("Alg. 1", algorithm_1((1.5, 0.0, 0.1), (0.213, 4.05, 0.1), 0.0)).subject;
    for report in judged(&*algorithm, &over("Alg. 1 .1/.1", Fixed::View, &[(0.0, 2.07)])) {
        assert!(report.energy(Fixed::View).is_some_and(|energy| (energy.value - 2.766).abs() < 2e-3), "{report}");
    }
    // Erratum 11: 1.69 at 89.5°.
    let diffuse = one("layer 2", move |wi, wo| {
        let [f, fresnel, _] = appendix_b(up, wi, wo, (1.5, 0.0, 0.1));
        (f + (1.0 - fresnel) * wi.z) / (PI * wi.z)
    });
    judged(&*diffuse.subject, &over("Alg. 1, line 22", Fixed::View, &[(0.0, 1.0), (89.5, 1.69)]));
    // Erratum 12: 3.3 to 3.8, Cu₂O over Cu, m = .3.
    let patina = one("patina", algorithm_1((2.83, 0.083, 0.3), (0.213, 4.05, 0.3), 1.0)).subject;
    let wide = Expected { off: 0.08, ..over("patina", Fixed::View, &[(0.0, 3.55), (45.0, 3.55), (75.0, 3.55)]) };
    judged(&*patina, &wide);
    // Without F, V-cavities and Beckmann: what the facets' shadows leave along the normal.
    for (m, albedo) in [(0.3, 0.996), (0.5, 0.892), (1.0, 0.453)] {
        let name = format!("Torrance–Sparrow m={m}");
        let subject = one(name.clone(), torrance_sparrow(m)).subject;
        let albedos = [(0.0, albedo)];
        let expected =
            Expected { name: &name, fixed: Fixed::View, verdict: Verdict::Pass, albedos: &albedos, off: 2e-3 };
        judged(&*subject, &expected);
    }
}

#[test]
fn oren_nayar_as_listed_is_negative() {
    // Erratum 19: `C2 =` for γ < 0. At σ = 0 f falls to (1 − 6/π)/π = −.91/π at grazing.
    let listed = one("M, Oren–Nayar σ=0", |wi, wo| {
        let (alpha, beta) = {
            let (a, b) = (wi.z.min(1.0).acos(), wo.z.min(1.0).acos());
            (a.max(b), a.min(b))
        };
        let gamma = wi.x * wo.x + wi.y * wo.y;
        let c2 = if gamma >= 0.0 { 0.0 } else { alpha.sin() - (2.0 * beta / PI).powi(3) };
        FRAC_1_PI * (1.0 + gamma * c2 * beta.tan())
    });
    for seed in crate::SEEDS {
        let report = check(&*listed.subject, &Options { seed, budget: 300_000, ..Options::default() });
        let sign = report.finding(Check::Sign).expect("sign is always checked");
        println!("{sign}");
        assert_eq!(sign.verdict, Verdict::Fail, "{report}");
        assert!((PI * sign.value + 0.91).abs() < 0.02, "{report}");
        assert_eq!(sign.cause, Cause::Unclamped.text());
    }
}

#[test]
fn our_stacks_do_not() {
    judge_all(&[
        of(StackSubject::new("copper under a coat", copper(0.1, 0.3, Model::Conserving))),
        of(StackSubject::new("copper under a coat, coupled", copper(0.1, 0.1, Model::Coupled))),
    ]);
}

#[test]
fn built_in_stacks_pass() {
    for material in brdf::material::stack::built_in() {
        let report = check(&StackSubject::new(material.name, material.stack), &Options::default());
        println!("{} {}", material.name, report.verdict());
        assert_eq!(report.verdict(), Verdict::Pass, "{report}");
    }
}
