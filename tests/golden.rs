//! Every term against 17-digit reference values that were computed elsewhere (`tests/reference/README.md`), in f64; and
//! the same inputs rounded to f32 against f64.

use brdf::layered::{Interface, Layer, Model, Stack};
use brdf::{Real, Vector};
use brdf::{absorption, diffuse, distribution, fresnel, layered, masking, material, microfacet, refraction};
use serde_json::Value;

/// Relative error allowed in f64: about 4500 ULP, a conditioning of 10³ on a few roundings each.
const DOUBLE: f64 = 1e-12;

struct Section {
    name: &'static str,
    rows: Vec<Value>,
}

fn reference() -> Value {
    serde_json::from_str(include_str!("reference/terms.json")).expect("terms.json is JSON")
}

fn section(name: &'static str) -> Section {
    let rows = reference()[name].as_array().expect("a section is a list").clone();
    assert!(!rows.is_empty());
    Section { name, rows }
}

fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("{key} in {row}"))
}

/// A number of the row, rounded to `R`.
fn get<R: Real>(row: &Value, key: &str) -> R {
    R::from_f64(number(row, key))
}

fn vector<R: Real>(value: &Value) -> Vector<R> {
    let component = |i: usize| R::from_f64(value[i].as_f64().expect("a number"));
    Vector::new(component(0), component(1), component(2))
}

/// The two directions that a row gives by angles, `wi` in the plane of the tangent.
fn directions<R: Real>(row: &Value) -> (Vector<R>, Vector<R>) {
    let azimuth = row.get("dphi").map_or(0.0, |phi| phi.as_f64().expect("a number"));
    let theta_o = row.get("tv").map_or(0.0, |theta| theta.as_f64().expect("a number"));
    (Vector::from_angles(number(row, "tl"), 0.0), Vector::from_angles(theta_o, azimuth))
}

/// The same direction in f64 after rounding to f32, so that f32 and f64 see equal inputs.
fn rounded<R: Real>(row: &Value) -> (Vector<R>, Vector<R>) {
    let (wi, wo) = directions::<f32>(row);
    (wi.cast(), wo.cast())
}

fn rounded_get<R: Real>(row: &Value, key: &str) -> R {
    R::from_f64(f64::from(number(row, key) as f32))
}

/// Compares `double` with the reference `want`, and `single` with `oracle`, the f64 value at the f32 inputs.
#[expect(clippy::too_many_arguments, reason = "two precisions, each with its reference")]
fn compare(section: &Section, row: &Value, what: &str, double: f64, want: f64, single: f32, oracle: f64, bound: f64) {
    let scale = want.abs().max(1e-25);
    assert!((double - want).abs() <= DOUBLE * scale, "{} {what}: {double:e}, want {want:e}\n{row}", section.name);
    let single = f64::from(single);
    let error = (single - oracle).abs();
    // Below the normal numbers f32 has no relative precision.
    let allowed = bound * f64::from(f32::EPSILON) * oracle.abs() + f64::from(f32::MIN_POSITIVE);
    assert!(error <= allowed, "{} {what} in f32: {single:e}, want {oracle:e}, bound {bound} ULP\n{row}", section.name);
}

#[test]
fn fresnel_dielectric() {
    let s = section("fresnel_dielectric");
    for row in &s.rows {
        let double = fresnel::dielectric::<f64>(get(row, "c"), get(row, "eta"));
        let single = fresnel::dielectric::<f32>(get(row, "c"), get(row, "eta"));
        let oracle = fresnel::dielectric::<f64>(rounded_get(row, "c"), rounded_get(row, "eta"));
        let f = (double.reflectance, number(row, "F"), single.reflectance, oracle.reflectance);
        let t = (double.transmittance, number(row, "T"), single.transmittance, oracle.transmittance);
        compare(&s, row, "F", f.0, f.1, f.2, f.3, 10.0);
        compare(&s, row, "T", t.0, t.1, t.2, t.3, 10.0);
    }
}

#[test]
fn fresnel_conductor_and_its_approximation() {
    let s = section("fresnel_conductor");
    for row in &s.rows {
        let double = fresnel::conductor::<f64>(get(row, "c"), get(row, "n"), get(row, "k"));
        let single = fresnel::conductor::<f32>(get(row, "c"), get(row, "n"), get(row, "k"));
        let inputs = (rounded_get(row, "c"), rounded_get(row, "n"), rounded_get(row, "k"));
        let oracle = fresnel::conductor::<f64>(inputs.0, inputs.1, inputs.2);
        compare(&s, row, "F", double.reflectance, number(row, "F"), single.reflectance, oracle.reflectance, 14.0);
        compare(&s, row, "T", double.transmittance, number(row, "T"), single.transmittance, oracle.transmittance, 14.0);
        let double = fresnel::conductor_approx::<f64>(get(row, "c"), get(row, "n"), get(row, "k"));
        let single = fresnel::conductor_approx::<f32>(get(row, "c"), get(row, "n"), get(row, "k"));
        let oracle = fresnel::conductor_approx::<f64>(inputs.0, inputs.1, inputs.2);
        compare(&s, row, "approximation", double, number(row, "approx36"), single, oracle, 10.0);
    }
}

#[test]
fn fresnel_schlick_and_normal_incidence() {
    let s = section("schlick");
    for row in &s.rows {
        let double = fresnel::schlick::<f64>(get(row, "c"), get(row, "f0"));
        let single = fresnel::schlick::<f32>(get(row, "c"), get(row, "f0"));
        let oracle = fresnel::schlick::<f64>(rounded_get(row, "c"), rounded_get(row, "f0"));
        // At F0 = 0 what remains is (1−c)⁵: five times the rounding of 1−c and four products.
        compare(&s, row, "F", double.reflectance, number(row, "F"), single.reflectance, oracle.reflectance, 10.0);
        compare(&s, row, "T", double.transmittance, number(row, "T"), single.transmittance, oracle.transmittance, 10.0);
    }
    let s = section("f0");
    for row in &s.rows {
        let double = fresnel::normal_incidence::<f64>(get(row, "n"), get(row, "k"));
        let single = fresnel::normal_incidence::<f32>(get(row, "n"), get(row, "k"));
        let oracle = fresnel::normal_incidence::<f64>(rounded_get(row, "n"), rounded_get(row, "k"));
        compare(&s, row, "F0", double, number(row, "f0"), single, oracle, 6.0);
    }
}

#[test]
fn fresnel_lazanyi() {
    let s = section("lazanyi");
    for row in &s.rows {
        let double =
            fresnel::lazanyi::<f64>(get(row, "c"), get(row, "n"), get(row, "k"), get(row, "a"), get(row, "alpha"));
        let single =
            fresnel::lazanyi::<f32>(get(row, "c"), get(row, "n"), get(row, "k"), get(row, "a"), get(row, "alpha"));
        let oracle = fresnel::lazanyi::<f64>(
            rounded_get(row, "c"),
            rounded_get(row, "n"),
            rounded_get(row, "k"),
            rounded_get(row, "a"),
            rounded_get(row, "alpha"),
        );
        compare(&s, row, "corrected", double, number(row, "compensated"), single, oracle, 16.0);
        let double = fresnel::lazanyi_uncorrected::<f64>(get(row, "c"), get(row, "n"), get(row, "k"));
        let single = fresnel::lazanyi_uncorrected::<f32>(get(row, "c"), get(row, "n"), get(row, "k"));
        let oracle =
            fresnel::lazanyi_uncorrected::<f64>(rounded_get(row, "c"), rounded_get(row, "n"), rounded_get(row, "k"));
        compare(&s, row, "uncorrected", double, number(row, "q5"), single, oracle, 10.0);
    }
}

/// Four distributions of one type.
fn distributions<R: Real>(h: Vector<R>, alpha: R) -> [R; 4] {
    let normalisation = R::from_f64(distribution::gaussian_normalisation(alpha.to_f64()));
    [
        distribution::beckmann(h, alpha),
        distribution::ggx(h, alpha),
        distribution::blinn(h, alpha),
        distribution::gaussian(h, alpha, normalisation),
    ]
}

#[test]
fn distributions_match() {
    let s = section("distribution");
    for row in &s.rows {
        let alpha = number(row, "m");
        let double = distributions::<f64>(vector(&row["h"]), alpha);
        let single = distributions::<f32>(vector(&row["h"]), alpha as f32);
        let oracle = distributions::<f64>(vector::<f32>(&row["h"]).cast(), f64::from(alpha as f32));
        for (i, name) in ["beckmann", "ggx", "blinn", "gaussian"].into_iter().enumerate() {
            if name == "blinn" && alpha >= 1.0 {
                continue; // The reference's exponent 2/α²−2 is 0 there and the term constant.
            }
            // An exponent x has about 6 roundings, each worth x/2 ULP of the result.
            let exponent = (oracle[i] * std::f64::consts::PI * alpha * alpha).ln().abs().min(90.0);
            let bound = if name == "ggx" { 10.0 } else { 12.0 + 6.0 * exponent };
            // Beyond the largest argument of exp in f32 the term is 0.
            let oracle = if exponent > 85.0 && single[i] == 0.0 { 0.0 } else { oracle[i] };
            compare(&s, row, name, double[i], number(row, name), single[i], oracle, bound);
        }
    }
}

#[test]
fn masking_v_cavity() {
    let s = section("geometry");
    fn evaluate<R: Real>((wi, wo): (Vector<R>, Vector<R>)) -> masking::Masking<R> {
        masking::v_cavity(wi.z, wo.z, wi + wo)
    }
    for row in &s.rows {
        let double = evaluate::<f64>(directions(row));
        let (single, oracle) = (evaluate::<f32>(directions(row)), evaluate::<f64>(rounded(row)));
        compare(&s, row, "G", double.g, number(row, "G"), single.g, oracle.g, 8.0);
        let visibility = number(row, "vis");
        compare(&s, row, "V", double.visibility, visibility, single.visibility, oracle.visibility, 8.0);
    }
}

#[test]
fn diffuse_oren_nayar() {
    let s = section("oren_nayar");
    for row in &s.rows {
        let (albedo, sigma) = (number(row, "rho"), number(row, "sigma"));
        let (wi, wo) = directions::<f64>(row);
        let double = diffuse::oren_nayar(wi, wo, sigma);
        let (wi_single, wo_single) = directions::<f32>(row);
        let single = diffuse::oren_nayar(wi_single, wo_single, sigma as f32);
        let (wi_rounded, wo_rounded) = rounded::<f64>(row);
        let oracle = diffuse::oren_nayar(wi_rounded, wo_rounded, f64::from(sigma as f32));
        let over_pi = albedo * std::f64::consts::FRAC_1_PI;
        let parts = [
            ("L1", double.direct * over_pi, single.direct, oracle.direct),
            ("L2", double.interreflection * over_pi * albedo, single.interreflection, oracle.interreflection),
        ];
        for (name, double, single, oracle) in parts {
            let want = number(row, name);
            // L1 is a sum of terms of either sign: its error is measured against the largest of them.
            let scale = want.abs().max(if name == "L1" { 0.2 * over_pi } else { 0.0 }).max(1e-25);
            assert!((double - want).abs() <= DOUBLE * scale, "{name}: {double:e}, want {want:e}\n{row}");
            // 160 ULP of 1 is what the function states for every angle, grazing included; 9 to 89°.
            let grazing = number(row, "tl").max(number(row, "tv")) > 89f64.to_radians();
            let allowed = if grazing { 160.0 } else { 9.0 } * f64::from(f32::EPSILON) * oracle.abs().max(1.0);
            assert!((f64::from(single) - oracle).abs() <= allowed, "{name} in f32: {single:e} {oracle:e}\n{row}");
        }
        let want = number(row, "full").max(0.0);
        assert!((double.f(albedo) - want).abs() <= DOUBLE * want.max(0.02), "{row}");
        let qualitative = diffuse::oren_nayar_qualitative(wi, wo, sigma, albedo);
        assert!((qualitative - number(row, "qual57")).abs() <= DOUBLE, "{qualitative} {row}");
    }
}

#[test]
fn refraction_and_snell() {
    let s = section("snell");
    for row in &s.rows {
        let double = refraction::cos_t::<f64>(get(row, "c"), get(row, "eta"));
        let single = refraction::cos_t::<f32>(get(row, "c"), get(row, "eta"));
        let oracle = refraction::cos_t::<f64>(rounded_get(row, "c"), rounded_get(row, "eta"));
        compare(&s, row, "cos_t", double, row["cos_t"].as_f64().unwrap_or(0.0), single, oracle, 4.0);
    }
    let s = section("refract");
    for row in &s.rows {
        let (w, wo) = directions::<f64>(row);
        let m = (w + wo).normalized();
        for (w, key) in [(w, "L_refr_half"), (wo, "V_refr_half")] {
            let got = <[f64; 3]>::from(refraction::refract_about(w, m, number(row, "eta")));
            let want = if row[key].is_null() { [0.0; 3] } else { vector::<f64>(&row[key]).into() };
            let off = got.iter().zip(want).map(|(got, want)| (got - want).abs()).fold(0.0, f64::max);
            // Components are sums of terms of the order of 1/η.
            assert!(off <= DOUBLE, "{key}: {got:?} {want:?}\n{row}");
        }
        let got = refraction::refract(w, number(row, "eta"));
        if row["L_refr_normal"].is_null() {
            assert_eq!(got.z, 0.0, "{row}");
            continue;
        }
        let want = vector::<f64>(&row["L_refr_normal"]);
        for (got, want) in <[f64; 3]>::from(got).into_iter().zip(<[f64; 3]>::from(want)) {
            assert!((got - want).abs() <= DOUBLE * want.abs().max(1e-25), "{got:e} {want:e}\n{row}");
        }
    }
}

#[test]
fn absorption_and_internal_reflection() {
    let s = section("absorption");
    for row in &s.rows {
        let keys = ["sigma", "d", "nlp", "nvp"];
        let [a, b, c, d] = keys.map(|key| get::<f64>(row, key));
        let double = absorption::transmittance(a, b, c, d);
        let exponent = number(row, "a").ln().abs().min(90.0);
        let [a, b, c, d] = keys.map(|key| get::<f32>(row, key));
        let single = absorption::transmittance(a, b, c, d);
        let [a, b, c, d] = keys.map(|key| rounded_get::<f64>(row, key));
        let oracle = absorption::transmittance(a, b, c, d);
        let oracle = if exponent > 85.0 && single == 0.0 { 0.0 } else { oracle };
        compare(&s, row, "a", double, number(row, "a"), single, oracle, 4.0 + 3.0 * exponent);
    }
    let s = section("internal_t");
    for row in &s.rows {
        let double = layered::internal_reflection::<f64>(1.0 - number(row, "F"), get(row, "G"));
        let single = layered::internal_reflection::<f32>(1.0 - get::<f32>(row, "F"), get(row, "G"));
        let oracle = layered::internal_reflection::<f64>(f64::from(1.0 - get::<f32>(row, "F")), rounded_get(row, "G"));
        compare(&s, row, "t", double, number(row, "t"), single, oracle, 3.0);
    }
}

#[test]
fn microfacet_torrance_sparrow() {
    let s = section("torrance_sparrow");
    for row in &s.rows {
        let [n, k, alpha] = ["n", "k", "m"].map(|key| number(row, key));
        let (wi, wo) = directions::<f64>(row);
        let double = microfacet::torrance_sparrow(wi, wo, n, k, alpha);
        let (wi, wo) = directions::<f32>(row);
        let single = microfacet::torrance_sparrow(wi, wo, n as f32, k as f32, alpha as f32);
        let (wi, wo) = rounded::<f64>(row);
        let round = |x: f64| f64::from(x as f32);
        let oracle = microfacet::torrance_sparrow(wi, wo, round(n), round(k), round(alpha));
        let exponent = (oracle.d * std::f64::consts::PI * alpha * alpha).ln().abs().min(90.0);
        let oracle_f = if exponent > 80.0 && single.f == 0.0 { 0.0 } else { oracle.f };
        compare(&s, row, "f", double.f, number(row, "f"), single.f, oracle_f, 32.0 + 6.0 * exponent);
        // 20-odd roundings in F, of an argument near 1 where the inputs are.
        compare(&s, row, "F", double.reflectance, number(row, "F"), single.reflectance, oracle.reflectance, 20.0);
        compare(&s, row, "G", double.g, number(row, "G"), single.g, oracle.g, 8.0);
    }
}

fn reference_stack(layers: &Value, model: Model) -> Stack<f64, 1> {
    let layers = layers.as_array().expect("a stack is a list of layers").iter().map(|layer| {
        let interface = if layer["kind"] == "on" {
            Interface::diffuse([number(layer, "rho")], number(layer, "sigma"))
        } else {
            Interface::conductor([number(layer, "n")], [number(layer, "k")], number(layer, "m"))
        };
        let medium = |key: &str| layer.get(key).map_or(0.0, |v| v.as_f64().expect("a number"));
        // A diffuse row's sigma is its roughness.
        let sigma = if layer["kind"] == "on" { 0.0 } else { medium("sigma") };
        Layer::new(interface).over([sigma], medium("d"))
    });
    Stack::new(model, layers.collect()).expect("a valid stack")
}

#[test]
fn stacks_match_in_every_model() {
    let all = reference();
    let s = section("stack_values");
    for (key, model) in [("elek", Model::Elek), ("ww_half", Model::WeidlichWilkie), ("physical", Model::Conserving)] {
        for row in &s.rows {
            let stack = reference_stack(&all["stacks"][row["stack"].as_str().expect("a name")], model);
            let (wi, wo) = directions::<f64>(row);
            let [double] = stack.evaluate(wi, wo);
            let single_stack = stack.cast::<f32>();
            let (wi, wo) = directions::<f32>(row);
            let [single] = single_stack.evaluate(wi, wo);
            let [oracle] = single_stack.cast::<f64>().evaluate(wi.cast(), wo.cast::<f64>());
            let (double, want) = (double, number(row, key));
            let scale = want.abs().max(1e-25);
            assert!((double - want).abs() <= DOUBLE * scale, "{model:?}: {double:e}, want {want:e}\n{row}");
            // FORMULAS.md measures 3e-6 for f > 1e-8; below that the exponents of narrow lobes dominate.
            if oracle > 1e-8 {
                let error = (f64::from(single) / oracle - 1.0).abs();
                assert!(error <= 1.2e-5, "{model:?} in f32: {single:e}, want {oracle:e}, error {error:e}\n{row}");
            } else {
                assert!(f64::from(single) <= 2e-8 && single >= 0.0, "{model:?}: {single:e}\n{row}");
            }
        }
    }
}

#[test]
fn material_patina_extent() {
    let s = section("patina_extent");
    for row in &s.rows {
        let keys = ["extent", "transition", "value"];
        let [extent, transition, value] = keys.map(|key| get::<f64>(row, key));
        let got = material::patina::patina_extent(extent, transition, value);
        let want = number(row, "factor");
        // The factor is a difference from 1, where the last bit is 1e-16.
        assert!((got - want).abs() <= 4.0 * f64::EPSILON, "{got} {want}\n{row}");
    }
}
