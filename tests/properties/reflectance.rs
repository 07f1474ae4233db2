//! Fresnel terms: sums, limits, fits.

use super::*;

/// c²/|(n+iκ)²−s²|, the conditioning of the conductor: at most 1 but close to the critical angle of κ ≈ 0, n < 1.
fn conditioning(c: f64, n: f64, k: f64) -> f64 {
    c * c / (n * n - k * k - (1.0 - c) * (1.0 + c)).hypot(2.0 * n * k).max(1e-300)
}

proptest! {
    #[test]
    fn reflectance_and_transmittance_sum_to_one(
        c in prop_oneof![Just(0.0), cosine()], eta in eta(), (n, k) in index(), f0 in scaled(0, 1000, 1000)
    ) {
        // The documented ULP of F and T, of numbers ≤ 1, whose spacing is ε/2.
        let split = |what: &str, fresnel: fresnel::Fresnel<f64>, ulps: f64| {
            let fresnel::Fresnel { reflectance, transmittance } = fresnel;
            let slack = 0.5 * ulps * EPS;
            prop_assert!((reflectance + transmittance - 1.0).abs() <= slack, "{} {:?}", what, fresnel);
            prop_assert!(reflectance >= 0.0 && reflectance <= 1.0 + slack, "{} {:?}", what, fresnel);
            prop_assert!(transmittance >= 0.0 && transmittance <= 1.0 + slack, "{} {:?}", what, fresnel);
            Ok(())
        };
        split("dielectric", fresnel::dielectric(c, eta), 25.0)?;
        let x = conditioning(c, n, k);
        // Beyond the documented range of x the two parts share their error.
        split("conductor", fresnel::conductor(c, n, k), 28.0 + 4.0 * x)?;
        split("schlick", fresnel::schlick(c, f0), 15.0)?;
        split("schlick_from_indices", fresnel::schlick_from_indices(c, n, eta), 16.0)?;
    }

    #[test]
    fn a_conductor_without_extinction_is_a_dielectric(c in cosine(), eta in eta()) {
        let (conductor, dielectric) = (fresnel::conductor(c, eta, 0.0), fresnel::dielectric(c, eta));
        let x = conditioning(c, eta, 0.0);
        // The documented ULP of both, each at most 1 ε; the conductor's hold for x ≤ 1e5.
        if x <= 1e5 {
            prop_assert!(close(conductor.reflectance, dielectric.reflectance, 35.0 + x));
            prop_assert!(close(conductor.transmittance, dielectric.transmittance, 18.0 + 3.0 * x));
        }
    }

    #[test]
    fn a_matched_interface_is_invisible(c in prop_oneof![Just(0.0), cosine()]) {
        prop_assert_eq!(fresnel::dielectric(c, 1.0).reflectance, 0.0);
        prop_assert_eq!(fresnel::conductor(c, 1.0, 0.0).reflectance, 0.0);
        prop_assert_eq!(fresnel::schlick_from_indices(c, 1.5, 1.5).reflectance, (1.0 - c).powi(2).powi(2) * (1.0 - c));
        // √(c²) is c to the bit, and 4c²/(2c)² has 6 roundings.
        prop_assert_eq!(refraction::cos_t(c, 1.0), c);
        prop_assert!(close(fresnel::dielectric(c, 1.0).transmittance, 1.0, 4.0));
        prop_assert!(close(fresnel::conductor(c, 1.0, 0.0).transmittance, 1.0, 4.0));
    }

    #[test]
    fn reflectance_vanishes_with_the_step_of_the_index(c in scaled(100, 1000, 1000), step in decades(8)) {
        // |rp| ≤ |rs| = |η²−1|/(c+g)² ≤ 2.5·step/c² for step ≤ 1/2; half of the sum of squares is at most the larger.
        let step = 0.25 * step;
        let bound = (2.5 * step / (c * c)).powi(2);
        prop_assert!(fresnel::dielectric(c, 1.0 + step).reflectance <= bound);
        prop_assert!(fresnel::conductor(c, 1.0 + step, 0.0).reflectance <= bound);
    }

    #[test]
    fn normal_and_grazing_incidence_have_their_closed_forms((n, k) in index(), eta in eta(), f0 in scaled(0, 1000, 1000)) {
        // The documented ULP of the two sides: 17 + x and 7, with x the conditioning of a small index.
        let f = fresnel::conductor(1.0, n, k).reflectance;
        let x = conditioning(1.0, n, k);
        prop_assert!(close(f, fresnel::normal_incidence(n, k), 24.0 + x), "{} {}", f, fresnel::normal_incidence(n, k));
        prop_assert!(close(fresnel::dielectric(1.0, eta).reflectance, fresnel::normal_incidence(eta, 0.0), 25.0));
        // The approximations are exact there: 8, 13, 13 ULP and the conductor's 17 + x.
        prop_assert!(close(fresnel::conductor_approx(1.0, n, k), f, 25.0 + x));
        prop_assert!(close(fresnel::lazanyi_uncorrected(1.0, n, k), f, 30.0 + x));
        prop_assert!(close(fresnel::lazanyi(1.0, n, k, 1.7, 6.0), f, 30.0 + x));
        prop_assert_eq!(fresnel::schlick(1.0, f0).reflectance, f0);
        prop_assert_eq!(fresnel::f82_tint(1.0, f0, 0.5), f0);
        if eta != 1.0 {
            prop_assert!(close(fresnel::dielectric(0.0, eta).reflectance, 1.0, 18.0));
            prop_assert_eq!(fresnel::dielectric(0.0, eta).transmittance, 0.0);
        }
        if n != 1.0 || k > 0.0 {
            prop_assert!(close(fresnel::conductor(0.0, n, k).reflectance, 1.0, 17.0));
            prop_assert_eq!(fresnel::conductor(0.0, n, k).transmittance, 0.0);
        }
        prop_assert!(close(fresnel::conductor_approx(0.0, n, k), 1.0, 8.0));
        prop_assert!(close(fresnel::lazanyi_uncorrected(0.0, n, k), 1.0, 13.0));
        prop_assert!(close(fresnel::schlick(0.0, f0).reflectance, 1.0, 1.0));
    }

    #[test]
    fn total_reflection_begins_at_the_critical_angle(eta in scaled(25, 999, 1000), offset in decades(9)) {
        let critical = ((1.0 - eta) * (1.0 + eta)).sqrt();
        // The critical cosine itself carries 3 roundings: 1e-9 is far outside, by both signs.
        let (below, above) = (critical * (1.0 - 0.5 * offset), critical + (1.0 - critical) * 0.5 * offset);
        prop_assert_eq!(fresnel::dielectric(below, eta), fresnel::Fresnel { reflectance: 1.0, transmittance: 0.0 });
        prop_assert_eq!(refraction::cos_t(below, eta), 0.0);
        // The conductor keeps F = 1: its root b is real and what a loses is not seen.
        prop_assert!(close(fresnel::conductor(below, eta, 0.0).reflectance, 1.0, 17.0));
        prop_assert!(fresnel::dielectric(above, eta).reflectance < 1.0);
        prop_assert!(fresnel::dielectric(above, eta).transmittance > 0.0);
        prop_assert!(refraction::cos_t(above, eta) > 0.0);
    }

    #[test]
    fn a_tint_of_one_is_schlick_and_the_tint_is_met(f0 in scaled(0, 1000, 1000), tint in scaled(0, 1000, 1000), c in cosine()) {
        prop_assert!(close(fresnel::f82_tint(c, f0, 1.0), fresnel::schlick(c, f0).reflectance, 18.0));
        let peak = 1.0 / 7.0;
        let schlick = fresnel::schlick(peak, f0).reflectance;
        // 18 ULP of Schlick's F, which the tinted value is a difference from; as many for the product here.
        prop_assert!((fresnel::f82_tint(peak, f0, tint) - tint * schlick).abs() <= 36.0 * EPS * schlick);
    }
}

#[test]
fn lazanyi_fits_the_documents_metals() {
    for name in ["copper_elek", "chromium_elek", "cuprite_elek"] {
        let metal = material::metal::by_name(name).expect("a built-in metal");
        for (n, k) in metal.n.into_iter().zip(metal.k) {
            let fit = fresnel::lazanyi_fit(n, k);
            let error = |approximate: &dyn Fn(f64) -> f64| {
                let distance = |i| {
                    let c = f64::from(i) / 2000.0;
                    (approximate(c) - fresnel::conductor(c, n, k).reflectance).abs()
                };
                (0..=2000).map(distance).fold(0.0, f64::max)
            };
            let corrected = error(&|c| fresnel::lazanyi(c, n, k, fit.a, fit.exponent));
            let uncorrected = error(&|c| fresnel::lazanyi_uncorrected(c, n, k));
            // FORMULAS.md, erratum 6; the fit's own samples are five times as sparse as these: 1 % between them.
            assert!(corrected <= 0.0195, "{name} {n}+{k}i: {corrected}");
            assert!(corrected < 0.75 * uncorrected, "{name} {n}+{k}i: {corrected} against {uncorrected}");
            assert!((corrected - fit.max_error).abs() <= 0.01 * fit.max_error, "{corrected} {fit:?}");
        }
    }
}
