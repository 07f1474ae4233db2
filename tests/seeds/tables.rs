//! E §3.1's tables: F over the angle in 128 × 8 bit, D over angle and roughness in 512 × 512 × 16 bit.
//!
//! These stand apart from those of `brdf::table`, which `tests/tables.rs` measures. Texels lie at the ends of the range, texel i
//! of n at i/(n−1), and are interpolated linearly.

use crate::elek::index;
use crate::record::{Erratum, Measurement};
use brdf::{Vector, distribution, fresnel};
use std::f64::consts::FRAC_PI_2;

/// Texels of the F table.
const ANGLES: usize = 128;
/// Texels of the D table along each axis.
const SIDE: usize = 512;

/// The nearest half-precision number, ∞ past the largest.
pub(crate) fn half(x: f64) -> f64 {
    // 11 significant bits down to 2⁻¹⁴, below that steps of 2⁻²⁴.
    let step = 2f64.powi((x.abs().log2().floor() as i32).max(-14) - 10);
    let rounded = if x == 0.0 { 0.0 } else { (x / step).round_ties_even() * step };
    if rounded.abs() > 65_504.0 { f64::INFINITY.copysign(x) } else { rounded }
}

/// A table over [0, 1], interpolated linearly.
struct Table(Vec<f64>);

impl Table {
    fn new(texels: usize, texel: impl Fn(f64) -> f64) -> Self {
        Table((0..texels).map(|i| texel(i as f64 / (texels - 1) as f64)).collect())
    }

    fn at(&self, u: f64) -> f64 {
        let x = u.clamp(0.0, 1.0) * (self.0.len() - 1) as f64;
        let i = (x as usize).min(self.0.len() - 2);
        let share = x - i as f64;
        self.0[i] * (1.0 - share) + self.0[i + 1] * share
    }
}

/// Beckmann's D of the crate at an angle.
fn beckmann(angle: f64, m: f64) -> f64 {
    distribution::beckmann(Vector::from_angles(angle, 0.0), m)
}

/// The largest error of a row of the D table, relative to the peak D(0, m): `texel` is the angle that the texel at u
/// holds, `look_up` the u that an angle is looked up at.
fn row_error(m: f64, texel: impl Fn(f64) -> f64, look_up: impl Fn(f64) -> f64) -> f64 {
    let table = Table::new(SIDE, |u| half(beckmann(texel(u), m)));
    let error = |angle: f64| (table.at(look_up(angle)) - beckmann(angle, m)).abs();
    let steps = 20_000;
    let (near, far) = ((8.0 * m).min(FRAC_PI_2), FRAC_PI_2);
    let worst = (0..=steps)
        .map(|i| f64::from(i) / f64::from(steps))
        .fold(0.0f64, |worst, x| worst.max(error(near * x)).max(error(far * x)));
    worst / beckmann(0.0, m)
}

/// The map of E §3.1 read as it must be: texel u holds α = u⁸·π/2, so that α is looked up at three square roots.
fn right(m: f64) -> f64 {
    row_error(m, |u| u.powi(8) * FRAC_PI_2, |angle| (angle / FRAC_PI_2).sqrt().sqrt().sqrt())
}

/// The map read as u = NH⁸: texel u holds NH = u^(1/8), three multiplications to look it up.
fn wrong(m: f64) -> f64 {
    row_error(m, |u| u.powf(0.125).acos(), |angle| angle.cos().powi(8))
}

/// α in equal steps.
fn linear(m: f64) -> f64 {
    row_error(m, |u| u * FRAC_PI_2, |angle| angle / FRAC_PI_2)
}

/// The largest error between the two rows of m that enclose `m`, in equal steps of m, relative to the peak.
fn between_rows(m: f64) -> f64 {
    let step = 1.0 / (SIDE - 1) as f64;
    let low = (m / step).floor() * step;
    let mut worst = 0.0f64;
    for i in 1..40 {
        let share = f64::from(i) / 40.0;
        let m = low + share * step;
        for j in 0..=4000 {
            let angle = 8.0 * m * f64::from(j) / 4000.0;
            let read = beckmann(angle, low) * (1.0 - share) + beckmann(angle, low + step) * share;
            worst = worst.max((read - beckmann(angle, m)).abs() / beckmann(0.0, m));
        }
    }
    worst
}

/// The largest absolute error of the F table of an index.
fn fresnel_error((n, k): (f64, f64)) -> f64 {
    let exact = |angle: f64| fresnel::conductor(angle.cos().max(0.0), n, k).reflectance;
    let table = Table::new(ANGLES, |u| (exact(u * FRAC_PI_2) * 255.0).round() / 255.0);
    (0..=20_000)
        .map(|i| f64::from(i) / 20_000.0)
        .fold(0.0, |worst, u| worst.max((table.at(u) - exact(u * FRAC_PI_2)).abs()))
}

pub(crate) fn errata() -> Vec<Erratum> {
    vec![Erratum {
        number: 14,
        place: "E §3.1, the tables",
        printed: "\"on the coordinate u the texture holds a value of D which would be stored in the linearly-mapped texture on the \
                  coordinate uˣ\", x = 8, \"since u⁸ can be computed in 3 multiplications\"",
        correct: "texel u holds D at α = u⁸·π/2; it is *looked up* at u = (2α/π)^(1/8), three square roots — not at u = NH⁸",
        right: "`distribution::beckmann` and `fresnel::conductor`, evaluated; `table::DistributionTable` looks up at the eighth root",
        note: "Errors of D are relative to its peak D(0, m), of F absolute, over all angles; rows of m .0023, .005, .01, .02, .05, .1, .3, \
               .5 and 1; F for the nine indices of App. A, n = 1.5 and n = 1.33. D carries its 1/π; without it, as E prints it, f16 \
               overflows for m < .0039. \
               The notes print .57 % at m = .02 for what is .577 %.",
        measure: || {
            let rows = [0.0023, 0.005, 0.01, 0.02, 0.05, 0.1, 0.3, 0.5, 1.0];
            let worst = rows.into_iter().map(right).fold(0.0, f64::max);
            // The least m whose peak f16 can hold, by bisection.
            let overflow = |peak: &dyn Fn(f64) -> f64| {
                let (mut low, mut high) = (1e-4, 1.0);
                for _ in 0..60 {
                    let m = 0.5 * (low + high);
                    if half(peak(m)).is_infinite() { low = m } else { high = m }
                }
                high
            };
            let mut fresnel_worst = fresnel_error((1.5, 0.0)).max(fresnel_error((1.33, 0.0)));
            for name in ["copper_elek", "chromium_elek", "cuprite_elek"] {
                for channel in 0..3 {
                    fresnel_worst = fresnel_worst.max(fresnel_error(index(name, channel)));
                }
            }
            vec![
                Measurement::notes("right: the worst row", worst, "≤ 0.2 %"),
                Measurement::here("right: the worst row, m = 1", right(1.0), "0.19 %"),
                Measurement::notes("u = NH⁸: m = .01", wrong(0.01), "47 %"),
                Measurement::here("linear in α: m = .02", linear(0.02), ".58 %"),
                Measurement::notes("linear in α: m = .01", linear(0.01), "2.2 %"),
                Measurement::notes("between linear rows of m: at .01", between_rows(0.01), "2.5 %"),
                Measurement::notes("f16 overflows below m =", overflow(&|m| beckmann(0.0, m)), ".0022"),
                Measurement::here("without 1/π, f16 overflows below m =", overflow(&|m| 1.0 / (m * m)), ".0039"),
                Measurement::notes("F table: the worst index", fresnel_worst, "≤ .0026"),
                Measurement::here("F table: the worst index", fresnel_worst, ".0026"),
                Measurement::here("F table, bytes", (ANGLES * 3) as f64, "384"),
                Measurement::here("D table, bytes", (SIDE * SIDE * 2) as f64, "524288"),
            ]
        },
    }]
}

#[test]
fn half_precision_rounds_and_overflows() {
    for (x, want) in [
        (1.0, 1.0),
        (1.0 + 2f64.powi(-11), 1.0),
        (1.0 + 3.0 * 2f64.powi(-11), 1.0 + 2f64.powi(-9)),
        (0.1, 0.099_975_585_937_5),
        (65_504.0, 65_504.0),
        (65_519.0, 65_504.0),
        (65_520.0, f64::INFINITY),
        (2f64.powi(-24), 2f64.powi(-24)),
        (2f64.powi(-26), 0.0),
        (0.0, 0.0),
    ] {
        assert_eq!(half(x), want, "{x}");
    }
}
