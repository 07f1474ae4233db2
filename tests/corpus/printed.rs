//! The documents' formulas as they are printed, with the numbers that FORMULAS.md and LAYERED.md record for them.

use crate::microfacet::{beckmann, torrance_sparrow, v_cavity};
use crate::{Energy, judge_all, of, one};
use brdf::check::{Cause, Check, Fixed, Options, StackSubject, Verdict, check};
use brdf::half_vector;
use brdf::layered::{Interface, Layer, Model, Stack};
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
        // Erratum 11: (1−F₂)·NL with ρ = 1 on one surface: albedo 1.69.
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

/// A stack's albedo along the normal, and its verdict under each seed.
fn judged(name: &str, stack: &Stack<f64, 1>, verdict: Verdict, value: f64, off: f64) {
    for seed in crate::SEEDS {
        let subject = StackSubject::new(name, stack.clone());
        let report = check(&subject, &Options { seed, budget: 600_000, ..Options::default() });
        let energy = report.energy(Fixed::View).expect("energy is always checked");
        println!("{name}: {energy}");
        assert_eq!(energy.verdict, verdict, "{report}");
        assert!((energy.value - value).abs() <= off, "{value} expected: {report}");
        for check in [Check::Finite, Check::Sign, Check::Sampling, Check::Density, Check::Weight] {
            assert_eq!(report.finding(check).map(|finding| finding.verdict), Some(Verdict::Pass), "{report}");
        }
    }
}

#[test]
fn the_documents_stacks_give_out_more_than_they_get() {
    // LAYERED.md: Cu.r under n = 1.5, m = .1 both: 2.01 at 0°; at most 1.63 for m₁ = .1, m₂ = .3.
    judged("Elek .1/.1", &copper(0.1, 0.1, Model::Elek), Verdict::Fail, 2.01, 0.01);
    judged("Elek .1/.3", &copper(0.1, 0.3, Model::Elek), Verdict::Fail, 1.63, 0.01);
    judged("Weidlich–Wilkie .1/.3", &copper(0.1, 0.3, Model::WeidlichWilkie), Verdict::Pass, 0.85, 0.01);
}

#[test]
fn our_stacks_do_not() {
    judge_all(&[
        of(StackSubject::new("copper under a coat", copper(0.1, 0.3, Model::Conserving))),
        of(StackSubject::new("copper under a coat, coupled", copper(0.1, 0.1, Model::Coupled))),
    ]);
}
