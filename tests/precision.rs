//! The error of every scalar term in f32, in ULP, against f64 at the same f32 inputs.
//!
//! The bound that each test asserts is *read from the function's doc comment* ("Error in f32: …"), so that the two can
//! not disagree. `cargo test --test precision -- --nocapture --test-threads 1` prints the table.
//!
//! A ULP is the spacing of f32 at the f64 result, 2⁻¹⁴⁹ among the subnormal numbers. Terms with an exponential state
//! a + b·x with x its argument; terms that cancel state the scale that the spacing is taken at.

use brdf::{Real, Vector};
use brdf::{absorption, diffuse, distribution, fresnel, layered, masking, microfacet, phong, refraction};
use std::f64::consts::PI;

/// Inputs drawn for a term, unless `PRECISION_SAMPLES` says otherwise. The maximum over a sample is only a lower bound of
/// the error: the documented bounds come from 40 million points of each of two sequences and a margin
/// (`PRECISION_SAMPLES=40000000`, with `--release`, four minutes).
const SAMPLES: u32 = 250_000;
/// How many of them at least must lie in the term's domain and so be measured.
const MEASURED: u32 = 100_000;

// ------------------------------------------------------------------------------------------------------- documentation

/// The bound a + b·x that a doc comment states: `≤ a ULP` or `≤ a + b·x ULP`.
#[derive(Clone, Copy)]
struct Bound {
    constant: f64,
    slope: f64,
}

fn source(module: &str) -> &'static str {
    match module {
        "absorption" => include_str!("../src/absorption.rs"),
        "diffuse" => include_str!("../src/diffuse.rs"),
        "distribution" => include_str!("../src/distribution.rs"),
        "fresnel" => include_str!("../src/fresnel.rs"),
        "layered" => include_str!("../src/layered/model.rs"),
        "masking" => include_str!("../src/masking.rs"),
        "microfacet" => include_str!("../src/microfacet.rs"),
        "phong" => include_str!("../src/phong.rs"),
        "real" => include_str!("../src/real.rs"),
        "refraction" => include_str!("../src/refraction.rs"),
        _ => panic!("no module {module}"),
    }
}

/// What the doc comment of `module::function` says after "Error in f32:", on one line.
fn stated(module: &str, function: &str) -> String {
    let text = source(module);
    let at = text.find(&format!("fn {function}<")).or_else(|| text.find(&format!("fn {function}(")));
    let at = at.unwrap_or_else(|| panic!("no function {function} in {module}"));
    let mut doc: Vec<&str> = text[..at]
        .lines()
        .rev()
        .skip(1)
        .map(str::trim)
        .skip_while(|line| !line.starts_with("///"))
        .take_while(|line| line.starts_with("///"))
        .map(|line| line.trim_start_matches('/').trim())
        .collect();
    doc.reverse();
    let doc = doc.join(" ");
    let (_, error) = doc.split_once("Error in f32:").unwrap_or_else(|| panic!("{function} states no error: {doc}"));
    error.to_string()
}

/// The number that `text` begins with, and what follows it.
fn number(text: &str) -> (Result<f64, std::num::ParseFloatError>, &str) {
    let end = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    (text[..end].parse(), &text[end..])
}

/// The bound that the doc comment states after `label`, which is empty where the function has one result.
fn bound(module: &str, function: &str, label: &str) -> Bound {
    let text = stated(module, function);
    let key = if label.is_empty() { "≤ ".to_string() } else { format!("{label} ≤ ") };
    let (_, rest) = text.split_once(&key).unwrap_or_else(|| panic!("{function} states no `{key}`: {text}"));
    let (constant, rest) = number(rest);
    let slope = rest.strip_prefix(" + ").map_or(Ok(0.0), |rest| number(rest).0);
    match (constant, slope) {
        (Ok(constant), Ok(slope)) => Bound { constant, slope },
        _ => panic!("{function} states no number after `{key}`: {text}"),
    }
}

// --------------------------------------------------------------------------------------------------------- measurement

/// The spacing of f32 at `x`.
fn ulp(x: f64) -> f64 {
    let exponent = x.abs().max(f64::from(f32::MIN_POSITIVE)).log2().floor();
    (exponent - 23.0).exp2()
}

/// The error of one result of one term over all samples.
struct Meter {
    name: String,
    bound: Bound,
    samples: u32,
    worst: f64,
    at: String,
    /// The largest error where the exponent is at most 1, and the largest growth per unit of it beyond 2.
    constant: f64,
    slope: f64,
    /// The largest relative error of a normal number in units of 2⁻²³, which is between half an ULP and one.
    relative: f64,
    /// The largest excess of the error over the bound.
    excess: f64,
}

impl Meter {
    fn new(module: &str, function: &str, label: &str) -> Self {
        Meter {
            name: format!("{module}::{function} {label}").trim().to_string(),
            bound: bound(module, function, label),
            samples: 0,
            worst: 0.0,
            at: String::new(),
            constant: 0.0,
            slope: 0.0,
            relative: 0.0,
            excess: f64::NEG_INFINITY,
        }
    }

    fn add(&mut self, got: f32, want: f64, input: &[f32]) {
        self.add_at(got, want, want, 0.0, input);
    }

    /// Counts one result, in the spacing at `scale`; `exponent` is the x of the bound.
    fn add_at(&mut self, got: f32, want: f64, scale: f64, exponent: f64, input: &[f32]) {
        let error = (f64::from(got) - want).abs() / ulp(scale);
        assert!(error.is_finite(), "{}: {got:e}, want {want:e} at {input:?}", self.name);
        self.samples += 1;
        if scale.abs() >= f64::from(f32::MIN_POSITIVE) {
            self.relative = self.relative.max(error * ulp(scale) / scale.abs() / f64::from(f32::EPSILON));
        }
        if exponent <= 1.0 {
            self.constant = self.constant.max(error);
        } else if exponent >= 2.0 {
            self.slope = self.slope.max((error - self.bound.constant) / exponent);
        }
        self.excess = self.excess.max(error - self.bound.constant - self.bound.slope * exponent);
        if error > self.worst {
            (self.worst, self.at) = (error, format!("{input:?} = {want:.6e}"));
        }
    }
}

/// Prints the rows of the table, then asserts every bound.
fn report<const N: usize>(meters: [Meter; N]) {
    for Meter { name, samples, worst, relative, bound, constant, slope, at, .. } in &meters {
        let bound = if bound.slope > 0.0 {
            format!("{}+{}x (measured {constant:.2}, {slope:.2}x)", bound.constant, bound.slope)
        } else {
            format!("{}", bound.constant)
        };
        println!("{name:44} {samples:8} {worst:10.2} {relative:9.2}ε  ≤ {bound:34} {at}");
    }
    for Meter { name, samples, worst, at, excess, .. } in &meters {
        assert!(*samples >= MEASURED, "{name}: only {samples} samples in the domain");
        assert!(*excess <= 0.0, "{name}: {excess} ULP above its documented bound, worst {worst} at {at}");
    }
}

// -------------------------------------------------------------------------------------------------------------- inputs

/// The point `index` of a low-discrepancy sequence in the unit cube (Roberts 2018, the additive recurrence R6).
fn point(index: u32) -> [f64; 6] {
    // The root of x⁷ = x + 1.
    const G: f64 = 1.112_775_684_278_705_5;
    let mut step = 1.0;
    [(); 6].map(|()| {
        step /= G;
        (0.5 + step * f64::from(index)).fract()
    })
}

/// All points of the sequence.
fn points() -> impl Iterator<Item = [f64; 6]> {
    let samples = std::env::var("PRECISION_SAMPLES").map_or(SAMPLES, |text| text.parse().expect("a number of samples"));
    (0..samples).map(point)
}

/// From `low` to `high`, uniform in the logarithm.
fn log(u: f64, low: f64, high: f64) -> f64 {
    low * (high / low).powf(u)
}

/// A cosine in [0, 1]: half log-spaced from 1e-6, a quarter uniform, a quarter log-spaced below 1, and both ends.
fn cosine(u: f64) -> f32 {
    let (kind, v) = ((u * 4.0) as u32, (u * 4.0).fract());
    (match kind {
        0 | 1 => log(0.5 * (f64::from(kind) + v), 1e-6, 1.0),
        2 if v < 0.002 => 0.0,
        2 if v < 0.004 => 1.0,
        2 => v,
        _ => 1.0 - log(v, 1e-8, 0.5),
    }) as f32
}

/// A positive cosine.
fn lit(u: f64) -> f32 {
    cosine(u).max(1e-6)
}

/// A relative index of a dielectric in [1/4, 4]: half log-spaced, half at a log-spaced distance from 1.
fn eta(u: f64) -> f32 {
    (match (u * 4.0) as u32 {
        0 => 1.0 + log((u * 4.0).fract(), 1e-7, 1.0),
        1 => 1.0 - log((u * 4.0).fract(), 1e-7, 0.5),
        _ => log(u * 2.0 - 1.0, 0.25, 4.0),
    }) as f32
}

/// A cosine and a relative index; for half of the indices < 1 the cosine is close to the critical angle.
fn incidence(p: [f64; 6]) -> (f32, f32) {
    let eta = eta(p[1]);
    let critical = (1.0 - f64::from(eta).powi(2)).max(0.0).sqrt();
    if critical > 1e-6 && p[2] < 0.5 {
        let side = if p[2] < 0.25 { 1.0 } else { -1.0 };
        return (((critical * (1.0 + side * log(p[0], 1e-8, 0.5))) as f32).min(1.0), eta);
    }
    (cosine(p[0]), eta)
}

/// A complex index, n in [.02, 8] and κ in [0, 12], with κ = 0, tiny κ and n near 1.
fn index(u: f64, v: f64) -> (f32, f32) {
    let n = match (u * 8.0) as u32 {
        0 => 1.0,
        1 => 1.0 + log((u * 8.0).fract(), 1e-7, 1.0),
        2 => 1.0 - log((u * 8.0).fract(), 1e-7, 0.5),
        3 => 0.02 + 7.98 * (u * 8.0).fract(),
        _ => log(u * 2.0 - 1.0, 0.02, 8.0),
    };
    let k = match (v * 8.0) as u32 {
        0 => 0.0,
        1 => log((v * 8.0).fract(), 1e-12, 1e-3),
        2 | 3 => 12.0 * (v * 4.0).fract(),
        _ => log(v * 2.0 - 1.0, 1e-3, 12.0),
    };
    (n as f32, k as f32)
}

fn alpha(u: f64) -> f32 {
    // Rounding must not leave the domain.
    (log(u, 1e-4, 1.0) as f32).clamp(1.0e-4, 1.0)
}

/// A unit direction; some azimuths are those of an axis.
fn direction(cos: f64, turn: f64) -> Vector<f32> {
    let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
    let phi = 2.0 * PI * if turn < 0.05 { (turn * 80.0).floor() / 4.0 } else { turn };
    Vector::<f64>::new(sin * phi.cos(), sin * phi.sin(), cos).cast()
}

/// A direction above the horizon, to 1e-6.
fn upper(u: f64, turn: f64) -> Vector<f32> {
    direction(f64::from(lit(u)).max(1e-6), turn)
}

/// A half vector of any length whose tan θ is 1e-3 to 1e4 times `alpha`, at most 1e6.
fn half(alpha: f32, p: [f64; 6]) -> Vector<f32> {
    let tan = (f64::from(alpha)
        * if p[1] < 0.7 { log(p[1] / 0.7, 1e-3, 10.0) } else { log(p[1] / 0.3 - 7.0 / 3.0, 1.0, 1e4) })
    .min(1e6);
    let cos = 1.0 / (1.0 + tan * tan).sqrt();
    let phi = 2.0 * PI * p[2];
    let length = 2.0 * f64::from(lit(p[3])).max(1e-3);
    (Vector::new(tan * phi.cos(), tan * phi.sin(), 1.0) * (cos * length)).cast()
}

/// Pairs of directions whose half vector lies within a few widths of the normal, and pairs of any directions.
fn pair(alpha: f32, p: [f64; 6]) -> (Vector<f32>, Vector<f32>) {
    let wi = upper(p[1], p[2]);
    if p[5] < 0.4 {
        return (wi, upper(p[3], p[4]));
    }
    // wo = wi mirrored about a normal h drawn from the lobe.
    let tan = f64::from(alpha) * log(p[3], 1e-3, 4.0);
    let phi = 2.0 * PI * p[4];
    let h = Vector::new(tan * phi.cos(), tan * phi.sin(), 1.0).normalized();
    let w = wi.cast::<f64>();
    let wo = h * (2.0 * w.dot(h)) - w;
    if wo.z > 1e-6 { (wi, wo.normalized().cast()) } else { (wi, upper(p[3], p[4])) }
}

// -------------------------------------------------------------------------------------------------------------- Fresnel

#[test]
fn fresnel_dielectric() {
    let mut f = Meter::new("fresnel", "dielectric", "F");
    let mut t = Meter::new("fresnel", "dielectric", "T");
    let mut g = Meter::new("fresnel", "refracted_square", "");
    let mut cos = Meter::new("refraction", "cos_t", "");
    for p in points() {
        let (c, eta) = incidence(p);
        let (c64, eta64) = (f64::from(c), f64::from(eta));
        let (got, want) = (fresnel::dielectric(c, eta), fresnel::dielectric(c64, eta64));
        f.add(got.reflectance, want.reflectance, &[c, eta]);
        t.add(got.transmittance, want.transmittance, &[c, eta]);
        let (got, want) = (fresnel::refracted_square(c, eta), fresnel::refracted_square(c64, eta64));
        // Of total reflection only the sign counts.
        assert_eq!(got < 0.0, want < 0.0, "{c} {eta}");
        g.add(if want < 0.0 { 0.0 } else { got }, want.max(0.0), &[c, eta]);
        cos.add(refraction::cos_t(c, eta), refraction::cos_t(c64, eta64), &[c, eta]);
    }
    report([f, t, g, cos]);
}

#[test]
fn fresnel_conductor() {
    let mut f = Meter::new("fresnel", "conductor", "F");
    let mut t = Meter::new("fresnel", "conductor", "T");
    let mut approx = Meter::new("fresnel", "conductor_approx", "");
    let mut normal = Meter::new("fresnel", "normal_incidence", "");
    let mut lazanyi = Meter::new("fresnel", "lazanyi_uncorrected", "");
    for p in points() {
        let (n, k) = index(p[1], p[2]);
        let c = cosine(p[0]);
        let input = [c, n, k];
        let [c64, n64, k64] = input.map(f64::from);
        let (got, want) = (fresnel::conductor(c, n, k), fresnel::conductor(c64, n64, k64));
        let x = critical(c64, n64, k64);
        if x <= CRITICAL_LIMIT {
            f.add_at(got.reflectance, want.reflectance, want.reflectance, x, &input);
            t.add_at(got.transmittance, want.transmittance, want.transmittance, x, &input);
        }
        approx.add(fresnel::conductor_approx(c, n, k), fresnel::conductor_approx(c64, n64, k64), &input);
        normal.add(fresnel::normal_incidence(n, k), fresnel::normal_incidence(n64, k64), &input);
        lazanyi.add(fresnel::lazanyi_uncorrected(c, n, k), fresnel::lazanyi_uncorrected(c64, n64, k64), &input);
    }
    report([f, t, approx, normal, lazanyi]);
}

/// The largest [`critical`] for which the conductor states an error: beyond, the sign of a² is lost to rounding.
const CRITICAL_LIMIT: f64 = 1e5;

/// c²/|(n+iκ)²−s²|: at most 1 but near the critical angle of κ ≈ 0, n < 1.
fn critical(c: f64, n: f64, k: f64) -> f64 {
    c * c / (n * n - k * k - (1.0 - c) * (1.0 + c)).hypot(2.0 * n * k).max(1e-30)
}

#[test]
fn fresnel_schlick() {
    let mut f = Meter::new("fresnel", "schlick", "F");
    let mut t = Meter::new("fresnel", "schlick", "T");
    let mut f_indices = Meter::new("fresnel", "schlick_from_indices", "F");
    let mut t_indices = Meter::new("fresnel", "schlick_from_indices", "T");
    let mut f82 = Meter::new("fresnel", "f82_tint", "");
    let mut lazanyi = Meter::new("fresnel", "lazanyi", "");
    for p in points() {
        let (c, f0, tint) = (cosine(p[0]), cosine(p[1]), cosine(p[2]));
        let [c64, f064, tint64] = [c, f0, tint].map(f64::from);
        let (got, want) = (fresnel::schlick(c, f0), fresnel::schlick(c64, f064));
        f.add(got.reflectance, want.reflectance, &[c, f0]);
        t.add(got.transmittance, want.transmittance, &[c, f0]);
        // F and what is subtracted from it.
        let got = fresnel::f82_tint(c, f0, tint);
        f82.add_at(got, fresnel::f82_tint(c64, f064, tint64), want.reflectance, 0.0, &[c, f0, tint]);

        let (n_i, n_t) = (log(p[3], 1.0, 4.0) as f32, log(p[4], 1.0, 4.0) as f32);
        let got = fresnel::schlick_from_indices(c, n_i, n_t);
        let want = fresnel::schlick_from_indices(c64, f64::from(n_i), f64::from(n_t));
        f_indices.add(got.reflectance, want.reflectance, &[c, n_i, n_t]);
        t_indices.add(got.transmittance, want.transmittance, &[c, n_i, n_t]);

        let (n, k) = index(p[1], p[2]);
        let (a, e) = ((4.0 * p[3] - 1.0) as f32, (1.0 + 11.0 * p[4]) as f32);
        let [n64, k64, a64, e64] = [n, k, a, e].map(f64::from);
        // The sum of the two terms, which may cancel; the power's argument is rounded.
        let power = (1.0 - c64).powf(e64);
        let scale = fresnel::lazanyi_uncorrected(c64, n64, k64) + a64.abs() * c64 * power;
        let x = if power > 0.0 { -power.ln() } else { 0.0 };
        let got = fresnel::lazanyi(c, n, k, a, e);
        lazanyi.add_at(got, fresnel::lazanyi(c64, n64, k64, a64, e64), scale, x, &[c, n, k, a, e]);
    }
    report([f, t, f_indices, t_indices, f82, lazanyi]);
}

// ------------------------------------------------------------------------------------------------------- distributions

/// Counts a term that is 0 where its exponent is out of range: at the limit one precision may be and the other not.
fn add_exponential(meter: &mut Meter, got: f32, want: f64, exponent: f64, input: &[f32]) {
    let limit = f64::from(f32::EXP_LIMIT);
    if exponent > limit * (1.0 - 1e-5) {
        assert!(exponent < limit * (1.0 + 1e-5) || got == 0.0, "{}: {got:e} beyond the limit {input:?}", meter.name);
        return;
    }
    meter.add_at(got, want, want, exponent, input);
}

#[test]
fn distributions() {
    let mut beckmann = Meter::new("distribution", "beckmann", "");
    let mut ggx = Meter::new("distribution", "ggx", "");
    let mut blinn = Meter::new("distribution", "blinn", "");
    let mut gaussian = Meter::new("distribution", "gaussian", "");
    for p in points() {
        let alpha = alpha(p[0]);
        let h = half(alpha, p);
        let (h64, alpha64) = (h.cast::<f64>(), f64::from(alpha));
        let input = [h.x, h.y, h.z, alpha];
        let tan_squared = h64.sin_squared() / (h64.z * h64.z);
        let x = tan_squared / (alpha64 * alpha64);
        add_exponential(
            &mut beckmann,
            distribution::beckmann(h, alpha),
            distribution::beckmann(h64, alpha64),
            x,
            &input,
        );
        ggx.add(distribution::ggx(h, alpha), distribution::ggx(h64, alpha64), &input);
        let x = (1.0 / (alpha64 * alpha64) - 1.0) * tan_squared.ln_1p();
        add_exponential(&mut blinn, distribution::blinn(h, alpha), distribution::blinn(h64, alpha64), x, &input);
        // The constant has no bearing on the error: about that of a small width serves.
        let c = (1.0 / (PI * alpha64 * alpha64)) as f32;
        let x = (tan_squared.sqrt().atan() / alpha64).powi(2);
        let want = distribution::gaussian(h64, alpha64, f64::from(c));
        add_exponential(&mut gaussian, distribution::gaussian(h, alpha, c), want, x, &input);
    }
    report([beckmann, ggx, blinn, gaussian]);
}

#[test]
fn distributions_anisotropic() {
    let mut beckmann = Meter::new("distribution", "beckmann_anisotropic", "");
    let mut ggx = Meter::new("distribution", "ggx_anisotropic", "");
    let mut blinn = Meter::new("distribution", "blinn_anisotropic", "");
    for p in points() {
        let (ax, ay) = (alpha(p[0]), alpha(p[4]));
        let h = half(if p[5] < 0.5 { ax } else { ay }, p);
        let (h64, ax64, ay64) = (h.cast::<f64>(), f64::from(ax), f64::from(ay));
        let input = [h.x, h.y, h.z, ax, ay];
        let weighted = (h64.x / ax64).powi(2) + (h64.y / ay64).powi(2);
        let x = weighted / (h64.z * h64.z);
        let want = distribution::beckmann_anisotropic(h64, ax64, ay64);
        add_exponential(&mut beckmann, distribution::beckmann_anisotropic(h, ax, ay), want, x, &input);
        ggx.add(distribution::ggx_anisotropic(h, ax, ay), distribution::ggx_anisotropic(h64, ax64, ay64), &input);
        let s = h64.sin_squared();
        let log = (s / (h64.z * h64.z)).ln_1p();
        let x = weighted / s.max(1e-300) * log;
        let want = distribution::blinn_anisotropic(h64, ax64, ay64);
        if x - log < 86.9 {
            blinn.add_at(distribution::blinn_anisotropic(h, ax, ay), want, want, x, &input);
        }
    }
    report([beckmann, ggx, blinn]);
}

// -------------------------------------------------------------------------------------------------------------- masking

type Smith<R> = fn(Vector<R>, Vector<R>, R, R) -> masking::Masking<R>;

#[test]
fn masking_smith() {
    let terms: [(&str, Smith<f32>, Smith<f64>); 4] = [
        ("smith_ggx", masking::smith_ggx, masking::smith_ggx),
        ("smith_ggx_separable", masking::smith_ggx_separable, masking::smith_ggx_separable),
        ("smith_beckmann", masking::smith_beckmann, masking::smith_beckmann),
        ("smith_beckmann_separable", masking::smith_beckmann_separable, masking::smith_beckmann_separable),
    ];
    for (name, single, double) in terms {
        let mut g = Meter::new("masking", name, "");
        let mut v = Meter::new("masking", name, "");
        v.name.push_str(" V");
        for p in points() {
            let (ax, ay) = (alpha(p[0]), if p[5] < 0.5 { alpha(p[0]) } else { alpha((p[5] - 0.5) * 2.0) });
            let (wi, wo) = (upper(p[1], p[2]), upper(p[3], p[4]));
            let got = single(wi, wo, ax, ay);
            let want = double(wi.cast(), wo.cast(), f64::from(ax), f64::from(ay));
            let input = [wi.x, wi.y, wi.z, wo.x, wo.y, wo.z, ax, ay];
            g.add(got.g, want.g, &input);
            v.add(got.visibility, want.visibility, &input);
        }
        report([g, v]);
    }
}

#[test]
fn masking_of_one_direction_and_of_half_vectors() {
    let mut ggx = Meter::new("masking", "projected_area_ggx", "");
    let mut beckmann = Meter::new("masking", "projected_area_beckmann", "");
    let mut cavity_g = Meter::new("masking", "v_cavity", "");
    let mut cavity_v = Meter::new("masking", "v_cavity", "");
    let mut kelemen_g = Meter::new("masking", "kelemen", "");
    let mut kelemen_v = Meter::new("masking", "kelemen", "");
    cavity_v.name.push_str(" V");
    kelemen_v.name.push_str(" V");
    let mut cos = Meter::new("microfacet", "cos_half", "");
    for p in points() {
        let (ax, ay) = (alpha(p[0]), alpha(p[3]));
        let (wi, wo) = pair(ax, p);
        let (ax64, ay64, wi64, wo64) = (f64::from(ax), f64::from(ay), wi.cast::<f64>(), wo.cast::<f64>());
        let input = [wi.x, wi.y, wi.z, ax, ay];
        let want = masking::projected_area_ggx(wi64, ax64, ay64);
        ggx.add(masking::projected_area_ggx(wi, ax, ay), want, &input);
        let want = masking::projected_area_beckmann(wi64, ax64, ay64);
        beckmann.add(masking::projected_area_beckmann(wi, ax, ay), want, &input);
        let input = [wi.x, wi.y, wi.z, wo.x, wo.y, wo.z];
        // The half vector is rounded too.
        let (got, want) = (masking::v_cavity(wi.z, wo.z, wi + wo), masking::v_cavity(wi64.z, wo64.z, wi64 + wo64));
        cavity_g.add(got.g, want.g, &input);
        cavity_v.add(got.visibility, want.visibility, &input);
        let (got, want) = (masking::kelemen(wi.z, wo.z, wi + wo), masking::kelemen(wi64.z, wo64.z, wi64 + wo64));
        kelemen_g.add(got.g, want.g, &input);
        kelemen_v.add(got.visibility, want.visibility, &input);
        cos.add(microfacet::cos_half(wi, wo), microfacet::cos_half(wi64, wo64), &input);
    }
    report([ggx, beckmann, cavity_g, cavity_v, kelemen_g, kelemen_v, cos]);
}

// -------------------------------------------------------------------------------------------------------------- diffuse

#[test]
fn diffuse_terms() {
    let mut lambert = Meter::new("diffuse", "lambert", "");
    let mut direct = Meter::new("diffuse", "oren_nayar", "direct");
    let mut near = Meter::new("diffuse", "oren_nayar", "direct to 89°");
    let mut second = Meter::new("diffuse", "oren_nayar", "interreflection");
    let mut qualitative = Meter::new("diffuse", "oren_nayar_qualitative", "");
    for p in points() {
        let (wi, wo) = (upper(p[0], p[1]), if p[4] < 0.2 { nearly_aligned(p) } else { upper(p[2], p[3]) });
        let sigma = if p[4] < 0.01 { 0.0 } else { (p[5] * PI / 2.0) as f32 };
        let albedo = p[4] as f32;
        let (wi64, wo64) = (wi.cast::<f64>(), wo.cast::<f64>());
        let (sigma64, albedo64) = (f64::from(sigma), f64::from(albedo));
        let input = [wi.x, wi.y, wi.z, wo.x, wo.y, wo.z, sigma, albedo];
        lambert.add(diffuse::lambert(albedo), diffuse::lambert(albedo64), &input);
        let (got, want) = (diffuse::oren_nayar(wi, wo, sigma), diffuse::oren_nayar(wi64, wo64, sigma64));
        // The sum is of terms of either sign; C1 in [.5, 1] is the largest but at grazing.
        direct.add_at(got.direct, want.direct, want.direct.abs().max(1.0), 0.0, &input);
        if wi.z.min(wo.z) > 0.01746 {
            near.add_at(got.direct, want.direct, want.direct.abs().max(1.0), 0.0, &input);
        }
        second.add_at(got.interreflection, want.interreflection, want.interreflection.abs().max(0.1), 0.0, &input);
        let want = diffuse::oren_nayar_qualitative(wi64, wo64, sigma64, albedo64);
        let x = 1.0 / wi64.z.max(wo64.z);
        qualitative.add_at(diffuse::oren_nayar_qualitative(wi, wo, sigma, albedo), want, want, x, &input);
    }
    report([lambert, direct, near, second, qualitative]);
}

/// A direction whose azimuth is close to that of `upper(p[0], p[1])` or opposite to it.
fn nearly_aligned(p: [f64; 6]) -> Vector<f32> {
    let opposite = if p[4] < 0.1 { 0.5 } else { 0.0 };
    upper(p[2], (p[1] + opposite + log(p[3], 1e-8, 0.1)).fract())
}

// ------------------------------------------------------------------------------------------ refraction and absorption

#[test]
fn refraction_of_directions() {
    let mut across = Meter::new("refraction", "refract", "x, y");
    let mut along = Meter::new("refraction", "refract", "z");
    for p in points() {
        let (c, eta) = incidence(p);
        let w = direction(f64::from(c), p[3]);
        let (got, want) = (refraction::refract(w, eta), refraction::refract(w.cast::<f64>(), f64::from(eta)));
        let input = [w.x, w.y, w.z, eta];
        across.add(got.x, want.x, &input);
        across.add(got.y, want.y, &input);
        along.add(got.z, want.z, &input);
    }
    report([across, along]);
}

#[test]
fn absorption_and_internal_reflection() {
    let mut transmittance = Meter::new("absorption", "transmittance", "");
    let mut internal = Meter::new("layered", "internal_reflection", "");
    for p in points() {
        let (sigma, thickness) = (log(p[0], 1e-4, 100.0) as f32, log(p[1], 1e-4, 10.0) as f32);
        let (ci, co) = (lit(p[2]), lit(p[3]));
        let input = [sigma, thickness, ci, co];
        let [s, d, i, o] = input.map(f64::from);
        let x = s * d * (1.0 / i + 1.0 / o);
        let want = absorption::transmittance(s, d, i, o);
        add_exponential(&mut transmittance, absorption::transmittance(sigma, thickness, ci, co), want, x, &input);
        let (t, g) = (cosine(p[4]), cosine(p[5]));
        let want = layered::internal_reflection(f64::from(t), f64::from(g));
        internal.add(layered::internal_reflection(t, g), want, &[t, g]);
    }
    report([transmittance, internal]);
}

// ---------------------------------------------------------------------------------------------------- lobes and BRDFs

#[test]
fn phong_lobes() {
    let mut phong = Meter::new("phong", "phong", "");
    let mut blinn = Meter::new("phong", "blinn_phong", "");
    for p in points() {
        let exponent = if p[0] < 0.01 { 0.0 } else { log(p[0], 0.01, 1e6) as f32 };
        // The width of Beckmann's lobe of the same curvature.
        let (wi, wo) = pair(((2.0 / (f64::from(exponent) + 2.0)).sqrt()) as f32, p);
        let (wi64, wo64, e64) = (wi.cast::<f64>(), wo.cast::<f64>(), f64::from(exponent));
        let input = [wi.x, wi.y, wi.z, wo.x, wo.y, wo.z, exponent];
        let mirrored = Vector::new(-wi64.x, -wi64.y, wi64.z);
        let deficit = 0.5 * (mirrored - wo64).length_squared();
        // n·(1/R·V − 1): where R·V vanishes its logarithm has no digits.
        let (got, want) = (phong::phong(wi, wo, exponent), phong::phong(wi64, wo64, e64));
        let argument = -e64 * (-deficit.min(1.0)).ln_1p();
        let x = if deficit < 1.0 - 1e-6 { e64 * deficit / (1.0 - deficit) } else { f64::INFINITY };
        if argument < 86.9 && x.is_finite() {
            phong.add_at(got, want, want, x, &input);
        } else {
            // Left out: the lobe is as good as 0, or flat with R·V at its edge.
            assert!(want < 1e-30 || exponent < 5.0);
        }
        let h = wi64 + wo64;
        let x = 0.5 * e64 * (h.sin_squared() / (h.z * h.z)).ln_1p();
        let want = phong::blinn_phong(wi64, wo64, e64);
        add_exponential(&mut blinn, phong::blinn_phong(wi, wo, exponent), want, x, &input);
    }
    report([phong, blinn]);
}

#[test]
fn torrance_sparrow() {
    let mut f = Meter::new("microfacet", "torrance_sparrow", "f");
    let mut lobe = Meter::new("microfacet", "facets", "lobe");
    for p in points() {
        let (n, k) = index(p[1], p[2]);
        let alpha = alpha(p[0]);
        // A second point of the sequence: 10 dimensions are needed.
        let (wi, wo) = pair(alpha, point(((p[0] * 1e6) as u32).wrapping_add((p[5] * 1e6) as u32)));
        let (wi64, wo64, a64) = (wi.cast::<f64>(), wo.cast::<f64>(), f64::from(alpha));
        let h = wi64 + wo64;
        let x = h.sin_squared() / (h.z * h.z * a64 * a64);
        let cos = microfacet::cos_half(wi64, wo64);
        let x_fresnel = critical(cos, f64::from(n), f64::from(k));
        let input = [wi.x, wi.y, wi.z, wo.x, wo.y, wo.z, n, k, alpha];
        let (got, want) = (microfacet::facets(wi, wo, alpha), microfacet::facets(wi64, wo64, a64));
        add_exponential(&mut lobe, got.lobe, want.lobe, x, &input);
        let want = microfacet::torrance_sparrow(wi64, wo64, f64::from(n), f64::from(k), a64);
        let got = microfacet::torrance_sparrow(wi, wo, n, k, alpha).f;
        if x < 86.9 && x_fresnel <= CRITICAL_LIMIT {
            f.add_at(got, want.f, want.f, x + x_fresnel, &input);
        }
    }
    report([f, lobe]);
}

// ------------------------------------------------------------------------------------------------ elementary functions

#[test]
fn elementary_functions() {
    let mut erfcx = Meter::new("real", "erfcx", "");
    let mut exp_product = Meter::new("real", "exp_product", "");
    for p in points() {
        let x = log(p[0], 1e-6, 1e4) as f32;
        erfcx.add(x.erfcx(), f64::from(x).erfcx(), &[x]);
        let (a, b) = (log(p[1], 1e-6, 1e3) as f32, log(p[2], 1e-6, 1e3) as f32);
        let exponent = f64::from(a) * f64::from(b);
        let want = f64::from(a).exp_product(f64::from(b));
        add_exponential(&mut exp_product, a.exp_product(b), want, exponent, &[a, b]);
    }
    report([erfcx, exp_product]);
}
