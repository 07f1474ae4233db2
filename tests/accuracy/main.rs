//! The error of every term in f32, and `docs/accuracy.md`, which is written from the same measurements:
//!
//! ```sh
//! BRDF_BLESS=1 cargo test --test accuracy
//! ```
//!
//! The bound that a measurement is held to is *read from the function's doc comment* ("Error in f32: ≤ … ULP"), so that
//! the two cannot disagree.

mod audit;
mod document;
mod endurance;
mod inputs;
mod meter;
mod naive;
mod sections;
mod terms;

use document::Measured;

/// Inputs drawn for each term in an ordinary run.
const SAMPLES: u64 = 300_000;
/// How many of them at least must lie in the term's domain.
const MEASURED: u64 = SAMPLES / 2;

/// Asserts what is documented of every result.
fn assert_bounds(all: &[Measured]) {
    let mut broken = Vec::new();
    for m in all {
        let bound = meter::stated_bound(m.term.module, m.term.function);
        for (result, (meter, label)) in m.ours.iter().zip(m.term.results).enumerate() {
            let (name, samples, worst) = (m.term.name(), meter.samples, meter.worst);
            println!(
                "{name:42} {label:16} {samples:9} {worst:8.3} {:8.3} {:8.3} {:?}",
                meter.rare(),
                meter.mean(),
                meter.at
            );
            if worst > bound {
                broken.push(format!("{name} {label}: {worst} ULP, documented {bound}, at {:?}", meter.at));
            }
            if let (Some(limit), Some(many)) = (m.term.batch_limit(), m.batch.get(result)) {
                println!("{name:42} {label:16} batch     {:8.3} {:8.3} {:?}", many.worst, many.rare(), many.at);
                if many.worst > limit.ulp {
                    broken.push(format!("{name} {label}: {} ULP in a batch, the limit is {}", many.worst, limit.ulp));
                }
            }
            if samples < MEASURED {
                broken.push(format!("{name} {label}: only {samples} samples in the domain"));
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

#[test]
fn every_term_keeps_its_bound_and_the_document_says_so() {
    // A deeper run asserts the bounds; the document is of the ordinary one.
    if let Some(samples) = std::env::var_os("ACCURACY_SAMPLES") {
        let samples = samples.to_str().and_then(|text| text.parse().ok()).expect("ACCURACY_SAMPLES is a number");
        assert_bounds(&document::measure_all(samples));
        return;
    }
    let all = document::measure_all(SAMPLES);
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/accuracy.md");
    let generated = document::document(&all);
    if std::env::var_os("BRDF_BLESS").is_some_and(|value| value == "1") {
        std::fs::write(path, generated).expect("docs/accuracy.md can be written");
    } else {
        document::compare(&std::fs::read_to_string(path).unwrap_or_default(), &generated);
    }
    assert_bounds(&all);
}

#[test]
fn both_precisions_hold_against_80_digits() {
    let mut audited = 0;
    for term in terms::terms() {
        // A term of f32 is the rounding of one in f64: beyond its bound, what f64 is off by.
        let bound = meter::stated_bound(term.module, term.function);
        for (found, label) in audit::audit(&term).iter().zip(term.results) {
            let name = term.name();
            println!("{name:42} {label:16} {:6} f32 {:8.3}, f64 {:8.1}", found.points, found.single, found.double);
            assert!(found.single <= bound, "{name} {label}: {} ULP, documented {bound}", found.single);
            // 1e-3 ULP of f32: what the reference may hide.
            let hidden = found.double * f64::EPSILON / f64::from(f32::EPSILON);
            assert!(hidden <= 1e-3, "{name} {label}: f64 is {} ULP off", found.double);
            audited += found.points;
        }
    }
    assert!(audited > 3_000, "{audited} audited results");
}
