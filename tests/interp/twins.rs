//! The twins: what their text means in double precision, and the tolerance that it gives itself.

use brdf::interval::{Wgsl, WgslInterval};
use brdf::parity::{Draw, Twin, allowed, buffers, compare_meaning, twins};
use brdf::wgsl;

const SAMPLES: usize = 4_000;

fn linked(twin: &Twin) -> String {
    wgsl::link_function(twin.module, twin.function).expect("a library function links")
}

#[test]
fn twins_mean_what_the_functions_say() {
    for twin in twins() {
        let name = format!("{}::{}", twin.module, twin.function);
        let meaning = compare_meaning(&twin, &linked(&twin), SAMPLES).unwrap_or_else(|error| panic!("{name}: {error}"));
        println!("{name:40} {:9.2e} {:9.3}", meaning.relative, meaning.share);
        assert_eq!(meaning.misunderstood, 0, "{name}: {meaning:?}");
    }
}

/// The digits that f32 barely shows: only the meaning in double precision can tell.
#[test]
fn a_digit_changes_the_meaning() {
    let faults = [
        ("fresnel", "f82_tint", "7776.0 / 16807.0", "7776.0 / 16807.01"),
        ("distribution", "ggx", "3.14159265358979324", "3.14159275358979324"),
        ("distribution", "beckmann", "3.14159265358979324", "3.14159255358979324"),
        ("diffuse", "lambert", "0.318309886183790672", "0.318309986183790672"),
        ("diffuse", "oren_nayar", "0.09)", "0.09000001)"),
        ("masking", "smith_beckmann", "0.56418958354775628695", "0.56418968354775628695"),
        ("real", "angle", "-0.33333276292", "-0.33333286292"),
        ("real", "ln_one_plus", "1.0 / 3.0", "1.000001 / 3.0"),
        ("real", "unit_circle", "0.645964097506246254", "0.645964197506246254"),
        ("real", "erfcx", "0.059209939998191890498", "0.059210039998191890498"),
        // Clamps that are gone.
        (
            "patina",
            "patina_extent",
            "clamp((value - (extent - transition)) / select(width, 1.0, sharp), 0.0, 1.0)",
            "(value - (extent - transition)) / select(width, 1.0, sharp)",
        ),
        ("refraction", "refract", "max(", "min("),
        ("patina", "diffuse_as_printed", "max(cos_i, 0.0)", "cos_i"),
        ("kubelka_munk", "film", "depth * 0.5 * rest", "depth * 0.5000001 * rest"),
        ("flake", "flake_normal", "max(distance, 1.0)", "distance"),
        ("brushed", "evaluate_ggx", "n.z, k.z", "n.y, k.z"),
        ("brushed", "reflect_visible_ggx", "2.0 - fall", "2.0000002 - fall"),
        ("brushed", "reflect_visible_ggx_pdf", "4.0 * select", "4.000001 * select"),
        ("glint", "leaf", "(column, row, of_row)", "(row, column, of_row)"),
        ("glint", "factor", "h.y * inverse", "h.x * inverse"),
    ];
    for (module, function, right, wrong) in faults {
        let twin = twins().into_iter().find(|twin| (twin.module, twin.function) == (module, function));
        let twin = twin.unwrap_or_else(|| panic!("{module}::{function} is in the table"));
        let source = linked(&twin);
        assert!(source.contains(right), "{module}::{function} contains `{right}`:\n{source}");
        let meaning = compare_meaning(&twin, &source.replacen(right, wrong, 1), SAMPLES).expect("valid WGSL");
        println!("{module}::{function} {wrong}: {} {:e}", meaning.misunderstood, meaning.share);
        assert!(meaning.misunderstood > 0, "{module}::{function} with `{wrong}` means the same: {meaning:?}");
    }
}

/// The tolerance from the text and the one from the Rust function of the same shape.
#[test]
fn the_text_is_no_vaguer_than_the_formula() {
    for twin in twins().iter().filter(|twin| twin.judge == brdf::parity::Judge::Allowed) {
        let name = format!("{}::{}", twin.module, twin.function);
        let rows: Vec<Vec<f32>> = (0..SAMPLES as u64)
            .map(|index| (twin.sample)(&mut Draw::new(index)).into_iter().map(|x| x as f32).collect())
            .collect();
        let text = allowed::<Wgsl>(twin, &linked(twin), &rows, buffers(&linked(twin)))
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        let (mut free, mut ratios) = ([0, 0], Vec::new());
        for (row, text) in rows.iter().zip(&text) {
            let points: Vec<_> = row.iter().map(|x| WgslInterval::exactly(*x)).collect();
            for (text, formula) in text.iter().zip((twin.allowed)(&points)) {
                free[0] += usize::from(!text.is_bounded());
                free[1] += usize::from(!formula.is_bounded());
                let width = |interval: WgslInterval| interval.high() - interval.low();
                if text.is_bounded() && formula.is_bounded() && width(formula) > 0.0 {
                    ratios.push(width(*text) / width(formula));
                }
            }
        }
        ratios.sort_by(f64::total_cmp);
        let median = ratios.get(ratios.len() / 2).copied().unwrap_or(1.0);
        println!("{name:40} median width {median:.3} of the formula's, free {free:?}");
        // The text's series of erfcx magnifies what is open of its argument, the formula's is monotonic.
        let limit = if name == "glint::factor" { 2.0 } else { 1.2 };
        assert!(median < limit, "{name}: {median}");
    }
}
