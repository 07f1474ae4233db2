//! `fresnel::Fit` against the exact equations: the error that it states is the one that it has.

use brdf::Real;
use brdf::fresnel::{self, Fit, FitError, Fresnel};
use brdf::interval::WgslInterval;
use brdf::material::metal::METALS;
use brdf::single::Single;

/// Cosines in equal steps, their squares and fourth powers: dense at grazing incidence.
fn cosines() -> impl Iterator<Item = f64> {
    const STEPS: i32 = 20_000;
    (0..=STEPS).flat_map(|i| {
        let x = f64::from(i) / f64::from(STEPS);
        [x, x * x, x.powi(4)]
    })
}

/// The built-in metals, single dielectrics, and three of them as channels of one fit.
fn materials() -> Vec<(String, [f64; 3], [f64; 3])> {
    let metals = METALS.iter().map(|metal| (metal.name.to_owned(), metal.n, metal.k));
    let dielectrics = [1.01, 1.33, 1.5, 2.42, 4.0].map(|n| (format!("n = {n}"), [n; 3], [0.0; 3]));
    metals.chain(dielectrics).chain([("three coats".to_owned(), [1.33, 1.5, 2.42], [0.0; 3])]).collect()
}

/// The largest |T − exact T| of each channel.
fn measured<R: Real, const C: usize, const N: usize>(fit: &Fit<C, N>, n: [f64; C], k: [f64; C]) -> [f64; C] {
    let mut worst = [0.0f64; C];
    for cos in cosines() {
        let cos = R::from_f64(cos);
        for (channel, fitted) in fit.evaluate(cos).into_iter().enumerate() {
            let exact = fresnel::conductor(cos.to_f64(), n[channel], k[channel]);
            let error = |x: R, exact: f64| (x.to_f64() - exact).abs();
            worst[channel] = worst[channel].max(error(fitted.transmittance, exact.transmittance));
            worst[channel] = worst[channel].max(error(fitted.reflectance, exact.reflectance));
        }
    }
    worst
}

fn states_its_error<const N: usize>() {
    for (name, n, k) in materials() {
        let fit = Fit::<3, N>::new(n, k).unwrap_or_else(|error| panic!("{name}: {error}"));
        let (double, single) = (measured::<f64, 3, N>(&fit, n, k), measured::<f32, 3, N>(&fit, n, k));
        let plain = measured::<Single, 3, N>(&fit, n, k);
        let show = |errors: [f64; 3]| errors.map(|e| format!("{e:.1e}")).join(" ");
        println!("{name:22} b {:.2}, {} | f32 throughout {}", fit.bend, show(double), show(plain));
        let worst = fit.max_error.into_iter().fold(0.0, f64::max);
        let documented = if N == 8 { 2.2e-5 } else { 6e-7 };
        assert!(worst <= documented, "{name} {N}: {worst:e}");
        for channel in 0..3 {
            let (stated, found) = (fit.max_error[channel], double[channel]);
            assert!(
                found <= stated && stated <= 1.01 * found + 1e-14,
                "{name} {N}: stated {stated:e}, found {found:e}"
            );
            // One rounding to an f32 below 1.
            assert!(single[channel] <= stated + 2f64.powi(-25), "{name} {N} in f32: {:e}", single[channel]);
            assert!(plain[channel] <= stated + 5e-7, "{name} {N} in f32 throughout: {:e}", plain[channel]);
        }
    }
}

#[test]
fn degree_8_states_its_error() {
    states_its_error::<8>();
}

#[test]
fn degree_12_states_its_error() {
    states_its_error::<12>();
}

/// The errors that least squares reach at Chebyshev nodes, one channel a fit, to the one digit that they are given with.
#[test]
fn minimax_is_no_worse_than_least_squares() {
    let rows = [
        ("copper r", 0.213, 4.05, 1e-5, 7e-8),
        ("copper g", 1.04, 2.59, 7e-7, 1e-8),
        ("copper b", 1.17, 2.36, 7e-7, 3e-9),
        ("chromium r", 3.84, 4.37, 8e-6, 1e-8),
        ("chromium b", 1.99, 4.22, 4e-6, 2e-8),
        ("aluminium r", 1.84, 8.069, 2e-5, 4e-7),
        ("aluminium g", 1.015, 6.627, 2e-5, 4e-7),
        ("aluminium b", 0.633, 5.454, 2e-5, 4e-7),
        ("silver r", 0.043, 4.724, 1e-6, 2e-8),
        ("silver g", 0.06, 3.597, 1e-6, 2e-8),
        ("silver b", 0.04, 2.648, 1e-6, 2e-8),
        ("n = 1.33", 1.33, 0.0, 4e-7, 8e-10),
        ("n = 1.5", 1.5, 0.0, 2e-7, 5e-10),
        ("n = 2.42", 2.42, 0.0, 5e-7, 3e-11),
    ];
    for (name, n, k, eight, twelve) in rows {
        let fits = (Fit::<1, 8>::new([n], [k]).expect("smooth"), Fit::<1, 12>::new([n], [k]).expect("smooth"));
        let errors = [fits.0.max_error[0], fits.1.max_error[0]];
        println!("{name:12} {:.1e} ({eight:e}) {:.1e} ({twelve:e})", errors[0], errors[1]);
        assert!(errors[0] <= 1.05 * eight && errors[1] <= 1.05 * twelve, "{name}: {errors:?}");
    }
}

#[test]
fn power_is_split_and_grazing_light_reflected() {
    for (name, n, k) in materials() {
        let fit = Fit::<3, 8>::new(n, k).expect("smooth");
        let mut worst = 0.0f64;
        assert_eq!(fit.evaluate(0.0), [Fresnel { reflectance: 1.0, transmittance: 0.0 }; 3], "{name}");
        for cos in cosines() {
            for (channel, Fresnel { reflectance, transmittance }) in fit.evaluate(cos).into_iter().enumerate() {
                assert!((0.0..=1.0).contains(&reflectance) && (0.0..=1.0).contains(&transmittance), "{name} at {cos}");
                assert!((reflectance + transmittance - 1.0).abs() <= f64::EPSILON, "{name} at {cos}");
                // Towards grazing incidence T keeps its digits: t is a factor of the fit.
                let exact = fresnel::conductor(cos, n[channel], k[channel]).transmittance;
                worst = worst.max((transmittance - exact).abs() / exact.max(f64::MIN_POSITIVE));
            }
            assert_eq!(fit.reflectance(cos), fit.evaluate(cos).map(|f| f.reflectance));
            assert_eq!(fit.transmittance(cos), fit.evaluate(cos).map(|f| f.transmittance));
        }
        println!("{name:22} relative error of T {worst:.1e}");
        assert!(worst <= 0.01, "{name}: {worst:e}");
    }
}

#[test]
fn a_wrong_coefficient_breaks_the_stated_error() {
    let (n, k) = ([0.213, 1.04, 1.17], [4.05, 2.59, 2.36]);
    let right = Fit::<3, 8>::new(n, k).expect("copper is smooth");
    for power in 0..8 {
        for channel in 0..3 {
            let mut wrong = right;
            wrong.coefficients[power][channel] += 1e-5;
            let found = measured::<f64, 3, 8>(&wrong, n, k);
            assert!(found[channel] > 1.01 * right.max_error[channel], "{power} {channel}: {found:?}");
        }
    }
}

#[test]
fn intervals_hold_the_fit() {
    let fit = Fit::<3, 8>::new([1.5; 3], [0.0; 3]).expect("glass is smooth");
    for cos in cosines().step_by(97) {
        let allowed = fit.transmittance(WgslInterval::exactly(cos as f32));
        for (allowed, value) in allowed.into_iter().zip(fit.transmittance(Single::<false>(cos as f32))) {
            assert!(allowed.contains(value.0) && allowed.high() - allowed.low() < 1e-5, "{cos}: {allowed:?} {value:?}");
        }
    }
}

#[test]
fn indices_without_a_fit_are_refused() {
    let wild = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, -0.0, 0.0, 1e-320, 1e-4, 2e3, f64::MAX];
    for n in wild {
        let refused = Fit::<1, 8>::new([n], [1.0]);
        assert!(matches!(refused, Err(FitError::OutOfRange { channel: 0, .. })), "n = {n}: {refused:?}");
    }
    for k in [f64::NAN, f64::INFINITY, -1.0, 2e3, f64::MAX] {
        let refused = Fit::<2, 8>::new([1.5; 2], [0.0, k]);
        assert!(matches!(refused, Err(FitError::OutOfRange { channel: 1, .. })), "κ = {k}: {refused:?}");
    }
    // Total reflection, and a matched interface, whose F steps from 1 to 0 at grazing incidence.
    for (n, k) in [(1.0, 0.0), (0.9, 0.0), (0.6667, 0.0), (0.3, 0.0), (0.5, 1e-6)] {
        let refused = Fit::<1, 12>::new([n], [k]);
        let Err(error @ FitError::NotSmooth { max_error, .. }) = refused else { panic!("{n} + {k}i: {refused:?}") };
        println!("{error}");
        assert!(max_error > 0.2 && error.to_string().contains("fresnel::conductor"), "{error}");
    }
}

/// The corners of the range of indices: whatever error is reached is stated, or the fit refused.
#[test]
fn any_index_in_range_is_fitted_or_refused() {
    for n in [1e-3, 0.02, 0.3, 0.7, 1.0, 1.000_1, 1.7, 8.0, 1e3] {
        for k in [0.0, 1e-6, 0.03, 0.3, 1.0, 12.0, 1e3] {
            let Ok(fit) = Fit::<1, 8>::new([n], [k]) else { continue };
            let found = measured::<f64, 1, 8>(&fit, [n], [k])[0];
            println!("{n} + {k}i: b {:.2}, {:.1e}", fit.bend, fit.max_error[0]);
            assert!(found <= fit.max_error[0], "{n} + {k}i: {:e}, found {found:e}", fit.max_error[0]);
        }
    }
}

#[test]
fn any_cosine_gives_a_fraction() {
    let fit = Fit::<3, 8>::new([0.213, 1.04, 1.17], [4.05, 2.59, 2.36]).expect("copper is smooth");
    for cos in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, -fit.bend, 2.0, f64::MAX, -f64::MAX, 1e-320] {
        for Fresnel { reflectance, transmittance } in fit.evaluate(cos) {
            assert!((0.0..=1.0).contains(&reflectance) && (0.0..=1.0).contains(&transmittance), "{cos}");
        }
    }
}
