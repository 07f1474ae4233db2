//! What is counted: errors in ULP, their largest, their mean and their distribution; and the bound that a doc comment states.

/// The spacing of f32 at `x`; 2⁻¹⁴⁹ among the subnormal numbers.
fn ulp_single(x: f64) -> f64 {
    power_of_two(exponent(x).max(-126) - 23)
}

/// The spacing of f64 at a normal `x`.
pub(crate) fn ulp_double(x: f64) -> f64 {
    power_of_two(exponent(x).max(-900) - 52)
}

/// ⌊log₂|x|⌋ of a normal number.
fn exponent(x: f64) -> i32 {
    ((x.to_bits() >> 52) & 0x7ff) as i32 - 1023
}

fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((exponent + 1023) as u64) << 52)
}

/// The distance of an f32 from the exact result, in ULP; infinite for a NaN or an infinity that should not be.
pub(crate) fn error(got: f32, want: f64) -> f64 {
    error_of(got, want, want)
}

/// [`error`] in the spacing at `scale`, which may be larger than the exact result.
pub(crate) fn error_of(got: f32, want: f64, scale: f64) -> f64 {
    let distance = (f64::from(got) - want).abs();
    if distance.is_nan() { f64::INFINITY } else { distance / ulp_single(scale) }
}

/// Buckets of the distribution: 32 for each factor of two from 2⁻⁸ to 2⁵⁶, and what is beyond.
const BUCKETS: usize = 64 * 32 + 2;

/// The errors of one result of one form of a term.
pub(crate) struct Meter {
    pub(crate) samples: u64,
    pub(crate) worst: f64,
    /// The arguments of the largest error.
    pub(crate) at: Vec<f32>,
    sum: f64,
    finite: u64,
    buckets: Vec<u64>,
}

impl Default for Meter {
    fn default() -> Self {
        Meter { samples: 0, worst: 0.0, at: Vec::new(), sum: 0.0, finite: 0, buckets: vec![0; BUCKETS] }
    }
}

impl Meter {
    pub(crate) fn add(&mut self, error: f64, arguments: &[f32]) {
        self.samples += 1;
        if error.is_finite() {
            self.sum += error;
            self.finite += 1;
        }
        // The exponent and five digits of the fraction.
        let bucket = (error.to_bits() >> 47) as i64 - ((1023 - 8) << 5);
        self.buckets[bucket.clamp(0, BUCKETS as i64 - 1) as usize] += 1;
        if error > self.worst || self.at.is_empty() {
            self.worst = error;
            self.at = arguments.to_vec();
        }
    }

    /// The mean of the errors that are finite.
    pub(crate) fn mean(&self) -> f64 {
        self.sum / self.finite.max(1) as f64
    }

    /// The error that 99.9 % of the samples do not exceed, to 3 %.
    pub(crate) fn rare(&self) -> f64 {
        let limit = (self.samples as f64 * 0.999).ceil() as u64;
        let mut count = 0;
        for (index, samples) in self.buckets.iter().enumerate() {
            count += samples;
            if count >= limit {
                let end = f64::from_bits(((index as u64 + 1) + ((1023 - 8) << 5)) << 47);
                return end.min(self.worst);
            }
        }
        self.worst
    }
}

// ------------------------------------------------------------------------------------------------------- documentation

fn source(module: &str) -> &'static str {
    match module {
        "absorption" => include_str!("../../src/absorption.rs"),
        "diffuse" => include_str!("../../src/diffuse.rs"),
        "distribution" => include_str!("../../src/distribution.rs"),
        "fresnel" => include_str!("../../src/fresnel.rs"),
        "layered" => include_str!("../../src/layered/model.rs"),
        "masking" => include_str!("../../src/masking.rs"),
        "microfacet" => include_str!("../../src/microfacet.rs"),
        "phong" => include_str!("../../src/phong.rs"),
        "real" => include_str!("../../src/real.rs"),
        "refraction" => include_str!("../../src/refraction.rs"),
        _ => panic!("no module {module}"),
    }
}

/// The bound that the doc comment of `module::function` states as "Error in f32: ≤ … ULP".
pub(crate) fn stated_bound(module: &str, function: &str) -> f64 {
    let text = source(module);
    let at = text.find(&format!("pub fn {function}<")).or_else(|| text.find(&format!("fn {function}(")));
    let at = at.unwrap_or_else(|| panic!("no function {function} in {module}"));
    let mut doc: Vec<&str> = text[..at]
        .lines()
        .rev()
        .map(str::trim)
        .skip_while(|line| !line.starts_with("///"))
        .take_while(|line| line.starts_with("///"))
        .map(|line| line.trim_start_matches('/').trim())
        .collect();
    doc.reverse();
    let doc = doc.join(" ");
    let (_, bound) = doc.split_once("Error in f32: ≤ ").unwrap_or_else(|| panic!("{function} states no error: {doc}"));
    let (number, _) = bound.split_once(" ULP").unwrap_or_else(|| panic!("{function} states no ULP: {doc}"));
    number.parse().unwrap_or_else(|_| panic!("{function} states no number: {doc}"))
}

#[test]
fn errors_are_counted_in_the_spacing_of_the_result() {
    assert_eq!(error(1.0, 1.0), 0.0);
    assert_eq!(error(1.0f32.next_up(), 1.0), 1.0);
    assert_eq!(error(2.0f32.next_down(), 2.0), 0.5);
    assert_eq!(error(f32::from_bits(3), 0.0), 3.0);
    assert_eq!(error(f32::NAN, 1.0), f64::INFINITY);
    assert_eq!(error(f32::INFINITY, 1.0), f64::INFINITY);
}

#[test]
fn the_distribution_keeps_its_ends() {
    let mut meter = Meter::default();
    for i in 1..=10_000 {
        meter.add(f64::from(i) / 10_000.0, &[]);
    }
    meter.add(f64::INFINITY, &[1.0]);
    assert!((meter.rare() / 0.9991 - 1.0).abs() < 0.04, "{}", meter.rare());
    assert!((meter.mean() - 0.500_05).abs() < 1e-9);
    assert_eq!((meter.worst, meter.at.as_slice()), (f64::INFINITY, &[1.0][..]));
}
