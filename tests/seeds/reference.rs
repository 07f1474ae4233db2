//! The printed forms against `tests/reference/terms.json`, where they were computed independently in 50 digits.

use crate::elek::{Dots, appendix_b, beckmann_printed, dots, equation_1, lazanyi_printed, patina_extent_printed, up};
use crate::layered::flake_normal;
use crate::mihaylov::{Printed, SPECULAR_PI, equation_4_8, fresnel_term_printed, oren_nayar_printed, specular_printed};
use brdf::{Vector, fresnel};
use serde_json::Value;
use std::f64::consts::FRAC_1_PI;

/// The rows of a section.
fn rows(section: &str) -> Vec<Value> {
    let all: Value = serde_json::from_str(include_str!("../reference/terms.json")).expect("terms.json is JSON");
    let rows = all[section].as_array().expect("a section is a list").clone();
    assert!(!rows.is_empty());
    rows
}

fn get(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("{key} in {row}"))
}

fn directions(row: &Value) -> (Vector<f64>, Vector<f64>) {
    (Vector::from_angles(get(row, "tl"), 0.0), Vector::from_angles(get(row, "tv"), get(row, "dphi")))
}

fn assert_close(got: f64, want: f64, tolerance: f64, row: &Value) {
    assert!((got - want).abs() <= tolerance * want.abs().max(1e-25), "{got:e}, want {want:e}\n{row}");
}

#[test]
fn fresnel_terms() {
    for row in rows("fresnel_conductor") {
        let got = fresnel_term_printed(get(&row, "n"), get(&row, "k"), get(&row, "c"));
        assert_close(got, get(&row, "thesis_listing"), 1e-12, &row);
    }
    for row in rows("lazanyi") {
        let got = lazanyi_printed(get(&row, "c"), get(&row, "n"), get(&row, "k"));
        assert_close(got, get(&row, "q4_as_printed"), 1e-14, &row);
    }
}

#[test]
fn distributions() {
    for row in rows("distribution") {
        // From NH, of which 1 − NH² has few digits near the peak: only where it has some.
        let nh = get(&row, "nh");
        let m = get(&row, "m");
        if 1.0 - nh > 1e-4 {
            assert_close(beckmann_printed(nh, m), get(&row, "beckmann_elek_unnormalised"), 1e-9, &row);
        }
    }
}

#[test]
fn whole_models() {
    for row in rows("torrance_sparrow") {
        let (wi, wo) = directions(&row);
        let (n, k, m) = (get(&row, "n"), get(&row, "k"), get(&row, "m"));
        // NH and VH of the reference: from the directions they are NaN's neighbours where NH rounds above 1.
        let d = Dots { nh: get(&row, "nh"), vh: get(&row, "vh"), ..dots(up(), wi, wo) };
        let exact = fresnel::conductor(d.vh, n, k).reflectance;
        // tan²α/m² of the exponent carries the rounding of NH.
        let tolerance = 1e-13 * (1.0 + 1.0 / (m * m * d.nh * d.nh)).powi(2).min(1e8);
        assert_close(equation_1(exact, d, m), get(&row, "elek_eq1"), tolerance, &row);
        assert_close(equation_4_8(exact, d, m), get(&row, "thesis_4_8"), tolerance, &row);
        assert_close(appendix_b(d, n, k, m).value, get(&row, "elek_appendixB_as_printed"), tolerance, &row);
        // The reference cuts the divisor off to 3.1415 as the listing does, but not the π in D.
        let spec = specular_printed(fresnel_term_printed(n, k, d.vh), d, m) * (SPECULAR_PI * FRAC_1_PI);
        assert_close(spec, get(&row, "thesis_listing_spec_as_printed"), tolerance, &row);
    }
}

#[test]
fn oren_nayar() {
    for row in rows("oren_nayar") {
        let (wi, wo) = directions(&row);
        let scale = get(&row, "rho") * FRAC_1_PI;
        for (form, key) in [(Printed::Equations, "thesis_eqs_raw_gamma"), (Printed::Listing, "thesis_listing")] {
            let got = scale * oren_nayar_printed(form, wi, wo, get(&row, "sigma"));
            let want = get(&row, key);
            // The listing cuts π off to 3.14159, where the reference does not; a tangent near grazing magnifies it.
            let tolerance = if form == Printed::Listing { 1e-4 } else { 1e-11 };
            assert!((got - want).abs() < tolerance * (1.0 + want.abs()), "{key} {got:e}, want {want:e}\n{row}");
        }
    }
}

#[test]
fn normals_and_edges() {
    for row in rows("flake_normal") {
        let vector = |key: &str| [0, 1, 2].map(|i| row[key][i].as_f64().expect("a number"));
        let got: [f64; 3] = flake_normal(vector("N").into(), get(&row, "distance"), vector("texel")).into();
        for (got, want) in got.into_iter().zip(vector("result")) {
            assert!((got - want).abs() < 1e-15, "{got} {want}\n{row}");
        }
    }
    for row in rows("patina_extent") {
        let got = patina_extent_printed(get(&row, "extent"), get(&row, "transition"), get(&row, "value"));
        assert!((got - get(&row, "factor")).abs() < 1e-14, "{got}\n{row}");
    }
}
