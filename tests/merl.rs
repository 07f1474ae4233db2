//! MERL files: what is written reads back, what is read integrates to what the model does, and what is broken is refused.
#![cfg(feature = "check")]

use brdf::Vector;
use brdf::check::merl::{BINS, DIMENSIONS, LENGTH, Merl, MerlError, SCALES, bin, pair, write};
use brdf::check::{self, Check, Effort, Fixed, Options, Profile, Subject, Verdict, albedo, from_fn};
use std::f64::consts::{FRAC_1_PI, PI, TAU};
use std::io::{BufReader, BufWriter};
use std::path::PathBuf;

/// GGX with Smith's height-correlated masking over a coloured Schlick metal, α = 0.4; f = 0 below the horizon.
fn metal() -> impl Subject {
    from_fn("metal", 3, |wi: Vector<f64>, wo: Vector<f64>, f: &mut [f64]| {
        let (h, a) = (wi + wo, 0.4f64.powi(2));
        let (n, s) = (h.length_squared(), h.sin_squared());
        let q = s / n + h.z * h.z / n * a;
        let g = |v: Vector<f64>| (a + (1.0 - a) * v.z * v.z).sqrt();
        let single = a / (PI * q * q) * 0.5 / (wi.z * g(wo) + wo.z * g(wi));
        for (f, f0) in f.iter_mut().zip([0.95, 0.64, 0.54]) {
            *f = single * (f0 + (1.0 - f0) * (1.0 - 0.5 * n.sqrt()).max(0.0).powi(5));
        }
    })
}

fn lambert() -> impl Subject {
    from_fn("Lambert", 1, |_: Vector<f64>, _: Vector<f64>, f: &mut [f64]| f[0] = FRAC_1_PI)
}

fn path(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("brdf-{}-{name}.binary", std::process::id()))
}

/// Writes a subject to a file, reads the file, and removes it.
fn through_a_file(subject: &dyn Subject, name: &str) -> Merl {
    let path = path(name);
    write(subject, &mut BufWriter::new(std::fs::File::create(&path).unwrap())).unwrap();
    assert_eq!(std::fs::metadata(&path).unwrap().len(), LENGTH as u64);
    let read = Merl::read(name, BufReader::new(std::fs::File::open(&path).unwrap()));
    std::fs::remove_file(&path).unwrap();
    read.unwrap()
}

/// ∫ g cosθ over the hemisphere by the midpoint rule in (sin²θ, φ), half the disk: everything here is symmetric in φ.
fn integrate(n: usize, g: &mut dyn FnMut(Vector<f64>) -> f64) -> f64 {
    let mut sum = 0.0;
    for i in 0..n {
        // Squares of the radius that crowd towards the horizon, where bins are cut by it.
        let t = (i as f64 + 0.5) / n as f64;
        let (s, ds) = (1.0 - (1.0 - t) * (1.0 - t), 2.0 * (1.0 - t));
        for j in 0..n {
            let (sin, cos) = (PI * (j as f64 + 0.5) / n as f64).sin_cos();
            let v = Vector::new(s.sqrt() * cos, s.sqrt() * sin, (1.0 - s).sqrt());
            sum += g(v) * ds;
        }
    }
    sum * PI / (n * n) as f64
}

/// The most that f is apart, in any channel, between two points of a bin's part above the horizon, over its corners, the
/// middles of its edges and sides, and its centre: f varies monotonically between those.
fn step(subject: &dyn Subject, bin: [usize; 3]) -> Vec<f64> {
    let n = subject.channels();
    let (mut low, mut high, mut f) = (vec![f64::INFINITY; n], vec![f64::NEG_INFINITY; n], vec![0.0; n]);
    for i in 0..27 {
        let part = [i / 9, i / 3 % 3, i % 3];
        // θd = 90° has no half vector.
        let at = [0, 1, 2].map(|axis| (bin[axis] as f64 + 0.5 * part[axis] as f64).min(DIMENSIONS[axis] as f64 - 1e-9));
        let (wi, wo) = pair(at);
        if wi.z > 0.0 && wo.z > 0.0 {
            subject.evaluate(wi, wo, &mut f);
            for c in 0..n {
                (low[c], high[c]) = (low[c].min(f[c]), high[c].max(f[c]));
            }
        }
    }
    (0..n).map(|c| (high[c] - low[c]).max(0.0)).collect()
}

#[test]
fn a_file_of_a_model_integrates_to_the_model() {
    let model = metal();
    let read = through_a_file(&model, "metal");
    let exact_effort = Effort { target: 1e-6, evaluations: 400_000, ..Effort::default() };
    let mut f = [0.0; 3];
    for theta in [0.0f64, 30.0, 60.0, 75.0, 85.0] {
        let exact = albedo(&model, theta, 0.0, Fixed::View, &exact_effort);
        let wo = Vector::from_angles(theta.to_radians(), 0.0);
        let mut steps: Vec<Option<Vec<f64>>> = vec![None; BINS];
        for channel in 0..3 {
            let sum = integrate(600, &mut |wi| {
                read.evaluate(wi, wo, &mut f);
                f[channel]
            });
            // Each bin holds one value of f; f is nowhere in it further from that than the bin's step.
            let bound = integrate(600, &mut |wi| {
                let [h, d, p] = bin(wi, wo);
                let step =
                    steps[p + DIMENSIONS[2] * (d + DIMENSIONS[1] * h)].get_or_insert_with(|| step(&model, [h, d, p]));
                step[channel]
            });
            // The midpoint rule over steps: measured with a doubled grid.
            let coarse = integrate(300, &mut |wi| {
                read.evaluate(wi, wo, &mut f);
                f[channel]
            });
            let grid = (sum - coarse).abs();
            let apart = sum - exact.value[channel];
            println!(
                "θ={theta} channel {channel}: {sum:.5}, exact {:.5}: {apart:+.5}, bound {bound:.5}, grid {grid:.1e}",
                exact.value[channel]
            );
            assert!(apart.abs() <= bound + grid + exact.error[channel]);
            // The bound takes each bin at its worst and all of them alike. About a centre errors have both signs: what is
            // left was measured to be 1 % of it.
            assert!(bound < 0.1 && apart.abs() <= 0.05 * bound + grid + exact.error[channel], "{apart} {bound}");
        }
    }
}

#[test]
fn a_constant_keeps_its_energy_up_to_the_horizon() {
    let read = through_a_file(&lambert(), "lambert");
    let mut f = [0.0; 3];
    for (theta, wo) in [0.0f64, 45.0, 80.0, 89.0, 89.9].map(|t| (t, Vector::from_angles(t.to_radians(), 0.0))) {
        let sum = integrate(400, &mut |wi| {
            read.evaluate(wi, wo, &mut f);
            f[1]
        });
        // Nothing varies in a bin: what could be lost is bins without data on this side of the horizon.
        let rule = integrate(400, &mut |_| FRAC_1_PI);
        assert!((rule - 1.0).abs() < 1e-4 && (sum - rule).abs() < 1e-4, "θ={theta}: {sum} {rule}");
    }
    let missing = read.missing();
    assert!(missing.bins > 0 && missing.above_horizon == 0, "{missing:?}");
}

#[test]
fn bins_are_those_of_the_published_reader() {
    // Its formulas: rotate wi by −φh about the normal and by −θh about the bitangent; floor of each angle.
    let published = |wi: Vector<f64>, wo: Vector<f64>| {
        let h = (wi + wo).normalized();
        let (theta_h, phi_h) = (h.z.acos(), h.y.atan2(h.x));
        let (s, c) = (-phi_h).sin_cos();
        let turned = Vector::new(c * wi.x - s * wi.y, s * wi.x + c * wi.y, wi.z);
        let (s, c) = (-theta_h).sin_cos();
        let d = Vector::new(c * turned.x + s * turned.z, turned.y, c * turned.z - s * turned.x);
        let phi_d = d.y.atan2(d.x);
        let phi_d = if phi_d < 0.0 { phi_d + PI } else { phi_d };
        let floor = |x: f64, n: usize| (x as usize).min(n - 1);
        let theta_h = (theta_h / (PI / 2.0) * 90.0 * 90.0).sqrt();
        [floor(theta_h, 90), floor(d.z.acos() / (PI * 0.5) * 90.0, 90), floor(phi_d / PI * 180.0, 180)]
    };
    let (mut same, mut count) = (0, 0);
    for i in 0..20_000u32 {
        // An R2 sequence: pairs all over the hemisphere, none at the edge of a bin by design.
        let u = |a: f64| (0.5 + f64::from(i) * a).fract();
        let wi = Vector::from_angles(1.57 * u(0.754_877_666), TAU * u(0.569_840_290));
        let wo = Vector::from_angles(1.57 * u(0.819_172_513), TAU * u(0.671_043_606));
        count += 1;
        same += usize::from(bin(wi, wo) == published(wi, wo));
        assert_eq!(bin(wi, wo), bin(wo, wi));
    }
    assert_eq!(same, count);
    // The centre of a bin is in it, and so are the coordinates of CHECKING's formula.
    for at in [[0, 0, 0], [1, 44, 90], [30, 10, 179], [89, 0, 5], [60, 20, 91]] {
        let (wi, wo) = pair(at.map(|i| i as f64 + 0.5));
        assert_eq!(bin(wi, wo), at);
    }
    // In the plane of the normal, and at the mirror direction, a common rotation changes nothing.
    for k in 0..100 {
        let phi = 0.1 * f64::from(k);
        let place = |a: f64, b: f64| bin(Vector::from_angles(a, phi), Vector::from_angles(b, phi + PI));
        assert_eq!([place(0.3, 1.2), place(0.7, 0.7)], [place(0.3, 1.2), place(0.7, 0.7)].map(|[h, d, _]| [h, d, 0]));
    }
}

/// A file of constants: 1, 2 and 3 in the stored numbers of the three channels.
fn constants() -> Vec<u8> {
    let mut bytes: Vec<u8> = DIMENSIONS.iter().flat_map(|d| (*d as i32).to_le_bytes()).collect();
    for stored in [1.0f64, 2.0, 3.0] {
        bytes.extend(std::iter::repeat_n(stored.to_le_bytes(), BINS).flatten());
    }
    bytes
}

/// Where the stored number of a channel of a bin starts.
fn offset(channel: usize, [h, d, p]: [usize; 3]) -> usize {
    12 + 8 * (BINS * channel + p + 180 * (d + 90 * h))
}

#[test]
fn broken_files_are_refused_with_the_offset() {
    let good = constants();
    assert_eq!(good.len(), 34_992_012);
    let read = Merl::parse("constants", &good).unwrap();
    assert_eq!(read.bin([89, 89, 179]), Some([SCALES[0], 2.0 * SCALES[1], 3.0 * SCALES[2]]));
    assert_eq!(read.bin([0, 0, 180]), None);
    let refused = |bytes: &[u8]| Merl::parse("x", bytes).unwrap_err();

    for length in [0, 1, 11, 12, 19, 34_992_011] {
        let error = refused(&good[..length]);
        assert!(error.to_string().starts_with(&format!("byte {length}: the file ends")), "{error}");
    }
    let mut long = good.clone();
    long.extend([0; 5]);
    assert_eq!(refused(&long), MerlError::OverLong { length: LENGTH + 5 });
    assert!(refused(&long).to_string().starts_with("byte 34992012: "), "{}", refused(&long));
    assert_eq!(Merl::read("x", &long[..]).unwrap_err().kind(), std::io::ErrorKind::InvalidData);
    for dimensions in [[90, 90, 360], [-90, -90, 180], [0, 0, 0], [i32::MAX; 3]] {
        let mut bytes = good.clone();
        for (at, d) in dimensions.iter().enumerate() {
            bytes[4 * at..4 * at + 4].copy_from_slice(&i32::to_le_bytes(*d));
        }
        assert_eq!(refused(&bytes), MerlError::Dimensions(dimensions));
        assert!(refused(&bytes).to_string().starts_with("byte 0: "));
    }
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let at = offset(1, [7, 30, 100]);
        let mut bytes = good.clone();
        bytes[at..at + 8].copy_from_slice(&value.to_le_bytes());
        let text = refused(&bytes).to_string();
        assert!(text.starts_with(&format!("byte {at}: {value} in green at bin θh 7, θd 30, φd 100")), "{text}");
    }
}

#[test]
fn negative_bins_hold_no_data_and_are_told_apart() {
    let mut bytes = constants();
    // One above the horizon, in one channel; one below it, in two.
    for at in [offset(0, [3, 20, 50]), offset(1, [89, 89, 0]), offset(2, [89, 89, 0])] {
        bytes[at..at + 8].copy_from_slice(&(-0.25f64).to_le_bytes());
    }
    let read = Merl::parse("holes", &bytes).unwrap();
    assert_eq!((read.missing().bins, read.missing().above_horizon), (2, 1));
    assert_eq!(read.bin([3, 20, 50]), Some([0.0, 2.0 * SCALES[1], 3.0 * SCALES[2]]));
    let options = Options { budget: 20_000, thetas: &[0.0], ..Options::default() };
    let report = check::check(&read, &options);
    let notes = report.notes.join("\n");
    assert!(notes.contains("2 of 1458000 bins are negative") && notes.contains("centres of 1 of them"), "{notes}");
    assert!(notes.contains("reciprocity holds by construction"), "{notes}");
    // No data is not a negative BRDF.
    assert_eq!(report.finding(Check::Sign).unwrap().verdict, Verdict::Pass, "{report}");
    assert_eq!(report.finding(Check::Reciprocity).unwrap().value, 0.0, "{report}");
    assert!(report.to_string().contains("note: MERL: "), "{report}");
}

#[test]
fn what_the_format_cannot_hold_is_not_written() {
    let refuse = |channels: usize, value: f64| {
        let subject = from_fn("odd", channels, move |_, _, f: &mut [f64]| f.fill(value));
        write(&subject, &mut std::io::sink()).unwrap_err().to_string()
    };
    assert!(refuse(2, 0.1).contains("has 2"));
    assert!(refuse(1, -0.1).contains("-0.1 in red at bin θh 0, θd 0, φd 0"), "{}", refuse(1, -0.1));
    assert!(refuse(3, f64::NAN).contains("NaN"));
}

#[test]
fn a_file_of_a_model_is_judged() {
    let read = through_a_file(&metal(), "judged");
    for profile in [Profile::Strict, Profile::Measured] {
        let report = check::check(&read, &Options { profile, ..Options::default() });
        println!("{report}");
        // Steps between bins are resolved to a thousandth or so: enough for an albedo that keeps its distance from 1.
        assert_eq!(report.verdict(), Verdict::Pass, "{report}");
        assert!(Fixed::BOTH.iter().all(|&fixed| report.energy(fixed).unwrap().error < 2e-3), "{report}");
        assert!(!report.coverage.anisotropic, "{report}");
    }
}
