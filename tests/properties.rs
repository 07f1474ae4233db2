//! What must hold of every term, BRDF and stack whatever the input, by property-based testing.
//!
//! Inputs are drawn as integers and scaled, so that a failure shrinks to round numbers. Each tolerance says where it
//! comes from; ε is the spacing above 1 of the number type. `PROPTEST_CASES=10000 cargo test --test properties` digs
//! deeper than the default of 256 cases.

use brdf::layered::{Interface, Layer, Model, Stack};
use brdf::{Frame, Real, Vector, half_vector};
use brdf::{absorption, diffuse, distribution, fresnel, layered, masking, material, microfacet, phong, refraction};
use proptest::prelude::*;
use std::f64::consts::PI;

const EPS: f64 = f64::EPSILON;

// ---------------------------------------------------------------------------------------------------------- strategies

/// A number of `low..=high` steps of 1/`steps`.
fn scaled(low: u32, high: u32, steps: u32) -> impl Strategy<Value = f64> {
    (low..=high).prop_map(move |i| f64::from(i) / f64::from(steps))
}

/// 10^−e for e in [0, `decades`].
fn decades(decades: u32) -> impl Strategy<Value = f64> {
    scaled(0, decades * 100, 100).prop_map(|e| 10f64.powf(-e))
}

/// A cosine in (0, 1], to grazing 1e-7.
fn cosine() -> impl Strategy<Value = f64> {
    prop_oneof![scaled(1, 1000, 1000), decades(7)]
}

/// A unit direction above the horizon.
fn upper() -> impl Strategy<Value = Vector<f64>> {
    (cosine(), 0u32..360).prop_map(|(cos, degrees)| direction(cos, f64::from(degrees).to_radians()))
}

/// A unit direction at or below the horizon.
fn lower() -> impl Strategy<Value = Vector<f64>> {
    (prop_oneof![Just(0.0), cosine()], 0u32..360)
        .prop_map(|(cos, degrees)| direction(-cos, f64::from(degrees).to_radians()))
}

fn direction(cos: f64, phi: f64) -> Vector<f64> {
    let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
    Vector::new(sin * phi.cos(), sin * phi.sin(), cos)
}

/// A width in [1e-3, 1].
fn alpha() -> impl Strategy<Value = f64> {
    prop_oneof![scaled(1, 100, 100), decades(3)]
}

/// A relative index of a dielectric in [1/4, 4].
fn eta() -> impl Strategy<Value = f64> {
    prop_oneof![scaled(25, 400, 100), decades(9).prop_map(|d| 1.0 + d), decades(9).prop_map(|d| 1.0 - 0.5 * d)]
}

/// n in [.02, 8], κ in [0, 12].
fn index() -> impl Strategy<Value = (f64, f64)> {
    (
        prop_oneof![scaled(2, 800, 100), decades(9).prop_map(|d| 1.0 + d)],
        prop_oneof![Just(0.0), scaled(0, 1200, 100), decades(9)],
    )
}

fn medium() -> impl Strategy<Value = ([f64; 3], f64)> {
    ([scaled(0, 300, 100), scaled(0, 300, 100), scaled(0, 300, 100)], scaled(0, 200, 100))
}

fn microfacet_layer() -> impl Strategy<Value = Layer<f64, 3>> {
    let n = prop_oneof![
        scaled(50, 400, 100).prop_map(|n| [n; 3]),
        [scaled(50, 400, 100), scaled(50, 400, 100), scaled(50, 400, 100)]
    ];
    let k = prop_oneof![Just([0.0; 3]), [scaled(0, 500, 100), scaled(0, 500, 100), scaled(0, 500, 100)]];
    (n, k, alpha(), medium()).prop_map(|(n, k, alpha, (sigma, thickness))| {
        Layer::new(Interface::conductor(n, k, alpha)).over(sigma, thickness)
    })
}

fn base() -> impl Strategy<Value = Layer<f64, 3>> {
    let diffuse = ([scaled(0, 100, 100), scaled(0, 100, 100), scaled(0, 100, 100)], scaled(0, 150, 100))
        .prop_map(|(albedo, sigma)| Layer::new(Interface::diffuse(albedo, sigma)));
    prop_oneof![microfacet_layer(), diffuse]
}

/// Up to three interfaces over a base.
fn layers() -> impl Strategy<Value = Vec<Layer<f64, 3>>> {
    (prop::collection::vec(microfacet_layer(), 0..=3), base()).prop_map(|(mut layers, base)| {
        layers.push(base);
        layers
    })
}

fn model() -> impl Strategy<Value = Model> {
    (0..Model::CLOSED_FORM.len()).prop_map(|i| Model::CLOSED_FORM[i])
}

fn stack(model: Model, layers: Vec<Layer<f64, 3>>) -> Stack<f64, 3> {
    Stack::new(model, layers).expect("the strategies draw valid layers")
}

/// Numbers that no one should pass.
fn wild() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(0.0),
        Just(-0.0),
        Just(1.0),
        Just(-1.0),
        Just(f64::NAN),
        Just(f64::INFINITY),
        Just(f64::NEG_INFINITY),
        Just(f64::MAX),
        Just(f64::MIN_POSITIVE),
        Just(1e-45),
        Just(3.4e38),
        any::<f64>()
    ]
}

// ----------------------------------------------------------------------------------------------------------- all BRDFs

/// Every BRDF of the crate that has no layers, by name, for F, an albedo or an exponent that follow from `alpha`.
fn brdfs<R: Real>(wi: Vector<R>, wo: Vector<R>, alpha: f64, n: f64, k: f64) -> [(&'static str, R); 8] {
    let of = R::from_f64;
    let (ggx, beckmann) = (
        distribution::ggx(half_vector(wi, wo), of(alpha)) * masking::smith_ggx(wi, wo, of(alpha), of(0.3)).visibility,
        distribution::beckmann(half_vector(wi, wo), of(alpha))
            * masking::smith_beckmann_separable(wi, wo, of(alpha), of(0.3)).visibility,
    );
    let exponent = of(2.0 / (alpha * alpha) - 2.0);
    [
        ("torrance_sparrow", microfacet::torrance_sparrow(wi, wo, of(n), of(k), of(alpha)).f),
        ("facets", microfacet::facets(wi, wo, of(alpha)).lobe),
        ("ggx", ggx),
        ("beckmann", beckmann),
        ("phong", phong::phong(wi, wo, exponent)),
        ("blinn_phong", phong::blinn_phong(wi, wo, exponent)),
        ("oren_nayar", diffuse::oren_nayar(wi, wo, of(1.5 * alpha)).f(of(0.7))),
        ("oren_nayar_qualitative", diffuse::oren_nayar_qualitative(wi, wo, of(1.5 * alpha), of(0.7))),
    ]
}

/// How much two values that differ by which direction is called wi may differ: nothing, as every form is symmetric
/// operation by operation; but Oren–Nayar's, which at equal cosines calls one of two rounded sines the larger and
/// magnifies their difference of 1 ε by its tangents, at most 1/cos.
fn reciprocal<R: Real>(a: R, b: R, tie: bool, cos: R) -> bool {
    let (a, b) = (a.to_f64(), b.to_f64());
    let allowed = if tie { 4.0 * R::EPSILON.to_f64() * (a.abs() + 1.0 / cos.to_f64()) } else { 0.0 };
    (a - b).abs() <= allowed
}

proptest! {
    #[test]
    fn brdfs_are_reciprocal(wi in upper(), wo in upper(), alpha in alpha(), (n, k) in index()) {
        fn check<R: Real>(wi: Vector<R>, wo: Vector<R>, alpha: f64, n: f64, k: f64) -> Result<(), TestCaseError> {
            for ((name, f), (_, swapped)) in brdfs(wi, wo, alpha, n, k).into_iter().zip(brdfs(wo, wi, alpha, n, k)) {
                let tie = name == "oren_nayar" && wi.z == wo.z;
                prop_assert!(reciprocal(f, swapped, tie, wi.z), "{}: {:?} {:?}", name, f, swapped);
            }
            Ok(())
        }
        check::<f64>(wi, wo, alpha, n, k)?;
        check::<f32>(wi.cast(), wo.cast(), alpha, n, k)?;
    }

    #[test]
    fn stacks_are_reciprocal(layers in layers(), model in model(), wi in upper(), wo in upper()) {
        fn check<R: Real>(stack: &Stack<R, 3>, wi: Vector<R>, wo: Vector<R>) -> Result<(), TestCaseError> {
            for (f, swapped) in stack.evaluate(wi, wo).into_iter().zip(stack.evaluate(wo, wi)) {
                // Equal cosines above stay equal below, and may become equal by rounding at grazing.
                let diffuse = matches!(stack.layers().last(), Some(Layer { interface: Interface::Diffuse { .. }, .. }));
                prop_assert!(reciprocal(f, swapped, diffuse, wi.z.min(wo.z)), "{:?} {:?}", f, swapped);
            }
            Ok(())
        }
        let stack = stack(model, layers);
        check(&stack, wi, wo)?;
        check(&stack.cast::<f32>(), wi.cast(), wo.cast())?;
    }

    #[test]
    fn brdfs_are_finite_and_not_negative(wi in upper(), wo in upper(), alpha in alpha(), (n, k) in index()) {
        for (name, f) in brdfs::<f64>(wi, wo, alpha, n, k) {
            prop_assert!(f.is_finite() && f >= 0.0, "{}: {}", name, f);
        }
        for (name, f) in brdfs::<f32>(wi.cast(), wo.cast(), alpha, n, k) {
            prop_assert!(f.is_finite() && f >= 0.0, "{} in f32: {}", name, f);
        }
    }

    #[test]
    fn the_half_cosine_is_a_cosine(wi in upper(), wo in upper()) {
        // Directions normalised in f32 are longer than 1 as often as shorter, by a few ε.
        let long = wi.cast::<f32>() * (1.0 + 4.0 * f32::EPSILON);
        prop_assert!(microfacet::cos_half(long, wo.cast()) <= 1.0);
        prop_assert!(microfacet::cos_half(long, long) <= 1.0);
        let dot = (0.5 + 0.5 * wi.dot(wo)).max(0.0).sqrt();
        // √((1+wi·wo)/2), whose radicand cancels to 2ε where the directions are opposite.
        prop_assert!((microfacet::cos_half(wi, wo).powi(2) - dot * dot).abs() <= 4.0 * EPS);
    }

    #[test]
    fn stacks_are_finite_and_not_negative(layers in layers(), model in model(), wi in upper(), wo in upper()) {
        let stack = stack(model, layers);
        for f in stack.evaluate(wi, wo) {
            prop_assert!(f.is_finite() && f >= 0.0, "{}", f);
        }
        for f in stack.cast::<f32>().evaluate(wi.cast::<f32>(), wo.cast::<f32>()) {
            prop_assert!(f.is_finite() && f >= 0.0, "f32: {}", f);
        }
    }

    #[test]
    fn below_the_horizon_everything_is_zero(
        above in upper(), below in lower(), other in lower(), layers in layers(), model in model(),
        alpha in alpha(), (n, k) in index()
    ) {
        let stack = stack(model, layers);
        let single = stack.cast::<f32>();
        for (wi, wo) in [(above, below), (below, above), (below, other)] {
            for (name, f) in brdfs::<f64>(wi, wo, alpha, n, k) {
                prop_assert_eq!(f, 0.0, "{}", name);
            }
            for (name, f) in brdfs::<f32>(wi.cast(), wo.cast(), alpha, n, k) {
                prop_assert_eq!(f, 0.0, "{} in f32", name);
            }
            prop_assert_eq!(stack.evaluate(wi, wo), [0.0; 3]);
            prop_assert_eq!(single.evaluate(wi.cast::<f32>(), wo.cast::<f32>()), [0.0; 3]);
            prop_assert_eq!(masking::v_cavity(wi.z, wo.z, wi + wo), masking::Masking { g: 0.0, visibility: 0.0 });
            prop_assert_eq!(masking::kelemen(wi.z, wo.z, wi + wo), masking::Masking { g: 0.0, visibility: 0.0 });
            prop_assert_eq!(microfacet::facets(wi, wo, alpha), microfacet::Facets { lobe: 0.0, d: 0.0, g: 0.0 });
            prop_assert_eq!(microfacet::facets::<f32>(wi.cast(), wo.cast(), alpha as f32), Default::default());
        }
        let d = distribution::gaussian_normalisation(alpha);
        let distributions = [
            distribution::beckmann(below, alpha),
            distribution::ggx(below, alpha),
            distribution::blinn(below, alpha),
            distribution::gaussian(below, alpha, d),
        ];
        prop_assert_eq!(distributions, [0.0; 4]);
    }
}

// ------------------------------------------------------------------------------------------------------------- Fresnel

/// c²/|(n+iκ)²−s²|, the conditioning of the conductor: at most 1 but close to the critical angle of κ ≈ 0, n < 1.
fn conditioning(c: f64, n: f64, k: f64) -> f64 {
    c * c / (n * n - k * k - (1.0 - c) * (1.0 + c)).hypot(2.0 * n * k).max(1e-300)
}

/// |a−b| ≤ ulps·ε·max(|a|, |b|).
fn close(a: f64, b: f64, ulps: f64) -> bool {
    (a - b).abs() <= ulps * EPS * a.abs().max(b.abs())
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

// ------------------------------------------------------------------------------------------- distributions and masking

/// ∫ D(h)·weight(x, y)·cos⁴ over the slopes (x, y) of h = (x, y, 1), a grid of `n` by `n` points warped to a lobe of
/// widths (ax, ay). cos⁴·d(slopes) is cosθ·dω.
fn over_slopes(ax: f64, ay: f64, n: u32, f: impl Fn(Vector<f64>) -> f64) -> f64 {
    let step = 1.0 / f64::from(n);
    let mut sum = 0.0;
    for i in 0..n {
        // The slope in units of the width, v = u/(1−u): midpoints, whose error for the smooth integrand is O(n⁻²).
        let u = (f64::from(i) + 0.5) * step;
        let v = u / (1.0 - u);
        let radial = v / ((1.0 - u) * (1.0 - u));
        for j in 0..n {
            let phi = (f64::from(j) + 0.5) * step * 2.0 * PI;
            let h = Vector::new(ax * v * phi.cos(), ay * v * phi.sin(), 1.0);
            let cos_squared = 1.0 / h.length_squared();
            sum += radial * cos_squared * cos_squared * f(h);
        }
    }
    sum * 2.0 * PI * step * step * ax * ay
}

/// ∫ f over the slopes on a grid and on one twice as dense, extrapolated, and how far the dense one is from that.
fn converged(ax: f64, ay: f64, n: u32, f: impl Fn(Vector<f64>) -> f64) -> (f64, f64) {
    let (coarse, fine) = (over_slopes(ax, ay, n, &f), over_slopes(ax, ay, 2 * n, &f));
    (fine + (fine - coarse) / 3.0, (fine - coarse).abs())
}

/// A distribution of one width or pair of widths.
type Distribution<'a> = &'a dyn Fn(Vector<f64>) -> f64;

#[test]
fn distributions_are_normalised() {
    for ax in [1e-4, 1e-3, 0.01, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0] {
        let c = distribution::gaussian_normalisation(ax);
        let isotropic: [(&str, Distribution<'_>); 4] = [
            ("beckmann", &|h| distribution::beckmann(h, ax)),
            ("ggx", &|h| distribution::ggx(h, ax)),
            ("blinn", &|h| distribution::blinn(h, ax)),
            ("gaussian", &|h| distribution::gaussian(h, ax, c)),
        ];
        for (name, d) in isotropic {
            // Isotropic: the azimuth is exact with any number of points, the radial error O(n⁻²) extrapolated.
            let (integral, error) = converged(ax, ax, 128, d);
            assert!((integral - 1.0).abs() <= error.max(1e-9) && error < 1e-3, "{name}, α {ax}: {integral} ± {error}");
        }
        for ratio in [0.2, 0.5, 0.9] {
            let ay = ax * ratio;
            let anisotropic: [(&str, Distribution<'_>); 3] = [
                ("beckmann", &|h| distribution::beckmann_anisotropic(h, ax, ay)),
                ("ggx", &|h| distribution::ggx_anisotropic(h, ax, ay)),
                ("blinn", &|h| distribution::blinn_anisotropic(h, ax, ay)),
            ];
            for (name, d) in anisotropic {
                let (integral, error) = converged(ax, ay, 96, d);
                let place = format!("{name}, α {ax} {ay}: {integral} ± {error}");
                assert!((integral - 1.0).abs() <= error.max(1e-9) && error < 2e-3, "{place}");
            }
        }
    }
}

#[test]
fn smith_masking_passes_the_weak_white_furnace() {
    // ∫ G1(wo)·max(0, wo·h)·D(h)/cos_o dωh = 1: of the light that visible microfacets reflect, none is lost (Heitz 2014,
    // eq. 11 and 116 with G1 in place of G2).
    type Widths = fn(Vector<f64>, f64, f64) -> f64;
    type Smith = fn(Vector<f64>, Vector<f64>, f64, f64) -> masking::Masking<f64>;
    let pairs: [(&str, Widths, Smith, Smith); 2] = [
        ("ggx", distribution::ggx_anisotropic, masking::smith_ggx, masking::smith_ggx_separable),
        ("beckmann", distribution::beckmann_anisotropic, masking::smith_beckmann, masking::smith_beckmann_separable),
    ];
    let normal = Vector::new(0.0, 0.0, 1.0);
    for (name, d, correlated, separable) in pairs {
        for (ax, ay) in [(0.05, 0.05), (0.3, 0.3), (1.0, 1.0), (0.1, 0.4)] {
            for (cos, phi) in [(1.0, 0.0), (0.7, 0.4), (0.3, 1.2), (0.05, 0.9), (0.01, 0.0)] {
                let wo = direction(cos, phi);
                let (area, error) = converged(ax, ay, 160, |h| d(h, ax, ay) * wo.dot(h).max(0.0));
                for smith in [correlated, separable] {
                    let g1 = smith(normal, wo, ax, ay).g;
                    // The kink at wo·h = 0 makes the extrapolation no better than the grid: its own error, doubled.
                    let (furnace, error) = (g1 * area / wo.z, 2.0 * error / area + 1e-9);
                    assert!(
                        (furnace - 1.0).abs() <= error && error < 0.02,
                        "{name} {ax} {ay} {cos}: {furnace} ± {error}"
                    );
                }
            }
        }
    }
}

proptest! {
    #[test]
    fn equal_widths_are_isotropic(alpha in alpha(), tan in prop_oneof![scaled(0, 900, 100), decades(6)], degrees in 0u32..360) {
        let (slope, phi) = (tan * alpha, f64::from(degrees).to_radians());
        let h = Vector::new(slope * phi.cos(), slope * phi.sin(), 1.0);
        // Twice the documented error, with the exponents tan²θ/α² and its upper bound for Blinn's.
        let ulps = 2.0 * (14.0 + 8.0 * (tan * tan).max(1.0 / (alpha * alpha) * (slope * slope).ln_1p()));
        let pairs = [
            (distribution::beckmann(h, alpha), distribution::beckmann_anisotropic(h, alpha, alpha)),
            (distribution::ggx(h, alpha), distribution::ggx_anisotropic(h, alpha, alpha)),
            (distribution::blinn(h, alpha), distribution::blinn_anisotropic(h, alpha, alpha)),
        ];
        for (isotropic, anisotropic) in pairs {
            prop_assert!(close(isotropic, anisotropic, ulps), "{} {}", isotropic, anisotropic);
        }
    }

    #[test]
    fn masking_is_a_fraction_and_visibility_its_quotient(wi in upper(), wo in upper(), ax in alpha(), ay in alpha()) {
        let h = half_vector(wi, wo);
        let terms = [
            ("v_cavity", masking::v_cavity(wi.z, wo.z, h)),
            ("smith_ggx", masking::smith_ggx(wi, wo, ax, ay)),
            ("smith_ggx_separable", masking::smith_ggx_separable(wi, wo, ax, ay)),
            ("smith_beckmann", masking::smith_beckmann(wi, wo, ax, ay)),
            ("smith_beckmann_separable", masking::smith_beckmann_separable(wi, wo, ax, ay)),
        ];
        for (name, masking::Masking { g, visibility }) in terms {
            prop_assert!((0.0..=1.0).contains(&g), "{}: {}", name, g);
            // The documented ULP of both and 3 products.
            prop_assert!(close(4.0 * wi.z * wo.z * visibility, g, 25.0), "{}: {} {}", name, g, visibility);
        }
        // Correlated heights see more than independent ones: G2 ≥ G1·G1; the last bits by rounding.
        prop_assert!(terms[1].1.g >= terms[2].1.g * (1.0 - 22.0 * EPS));
        prop_assert!(terms[3].1.g >= terms[4].1.g * (1.0 - 22.0 * EPS));
        let kelemen = masking::kelemen(wi.z, wo.z, h);
        prop_assert!(close(4.0 * wi.z * wo.z * kelemen.visibility, kelemen.g, 17.0));
        prop_assert!(close(kelemen.visibility * h.length_squared(), 1.0, 2.0));
    }

    #[test]
    fn v_cavity_is_the_printed_minimum(wi in upper(), wo in upper()) {
        let h = half_vector(wi, wo).normalized();
        let (nh, vh) = (h.z, wo.dot(h));
        let printed = (2.0 * nh * wi.z / vh).min(2.0 * nh * wo.z / vh).min(1.0);
        let g = masking::v_cavity(wi.z, wo.z, half_vector(wi, wo)).g;
        // The printed form takes V·H = (1 + wi·wo)/|h|, of directions that are unit to ε: 8ε/(V·H)².
        prop_assert!((g - printed).abs() <= 16.0 * EPS * g * (1.0 + 1.0 / (vh * vh)), "{} {}", g, printed);
    }

    #[test]
    fn masking_falls_with_width(wi in upper(), wo in upper(), alpha in alpha()) {
        // 1 of the same terms at a larger width; monotone but for the documented 11 ULP.
        for smith in [masking::smith_ggx, masking::smith_beckmann] {
            let wider = (1.3 * alpha).min(1.0);
            let (narrow, wide) = (smith(wi, wo, alpha, alpha).g, smith(wi, wo, wider, wider).g);
            prop_assert!(wide <= narrow * (1.0 + 22.0 * EPS), "{} {}", narrow, wide);
        }
    }
}

// -------------------------------------------------------------------------------------------------------------- energy

/// The albedo of a lobe about the half vector for one `wo`, with the error of its quadrature.
fn albedo_about_half(wo: Vector<f64>, width: f64, f: impl Fn(Vector<f64>) -> f64) -> (f64, f64) {
    converged(width, width, 96, |h| {
        let h_unit = h.normalized();
        let wi = h_unit * (2.0 * wo.dot(h_unit)) - wo;
        // dωi = 4·|wo·h|·dωh, and over_slopes holds one cosθh that dωh lacks.
        if wi.z > 0.0 { f(wi) * wi.z * 4.0 * wo.dot(h_unit).abs() / h_unit.z } else { 0.0 }
    })
}

#[test]
fn single_interfaces_gain_no_energy() {
    for cos in [1.0, 0.8, 0.5, 0.2, 0.02] {
        let wo = direction(cos, 0.3);
        for alpha in [1e-3, 0.05, 0.3, 0.5, 1.0] {
            let check = |name: &str, f: &dyn Fn(Vector<f64>) -> f64, limit: f64| {
                let (albedo, error) = albedo_about_half(wo, alpha, f);
                // The integrand has kinks, where the quadrature is of first order: its own difference, doubled.
                assert!(albedo <= limit + 2.0 * error + 1e-9, "{name}, α {alpha}, cos {cos}: {albedo} ± {error}");
                assert!(error < 0.02, "{name}, α {alpha}, cos {cos}: {albedo} ± {error}");
                albedo
            };
            let mirror = check("facets", &|wi| microfacet::facets(wi, wo, alpha).lobe, 1.0);
            if alpha <= 0.01 && cos >= 0.2 {
                // A narrow lobe above the horizon loses nothing: 1 to the quadrature, and it is no vacuous bound.
                assert!(mirror > 0.98, "α {alpha}, cos {cos}: {mirror}");
            }
            if cos == 1.0
                && let Some((_, known)) = [(0.3, 0.996), (0.5, 0.892), (1.0, 0.453)].iter().find(|(a, _)| *a == alpha)
            {
                // FORMULAS.md, §2, to its three digits.
                assert!((mirror - known).abs() < 6e-4, "α {alpha}: {mirror}, known {known}");
            }
            for (n, k) in [(1.5, 0.0), (0.2, 4.0), (3.0, 0.5)] {
                let stack = stack(Model::Conserving, vec![Layer::new(Interface::conductor([n; 3], [k; 3], alpha))]);
                let albedo = check("stack", &|wi| stack.evaluate(wi, wo)[0], 1.0);
                assert!(albedo <= mirror + 1e-12, "Fresnel's reflectance is at most 1");
            }
            let exponent = 2.0 / (alpha * alpha) - 2.0;
            check("blinn_phong", &|wi| phong::blinn_phong(wi, wo, exponent), 1.0);
            // A mirrored normal makes Phong's lobe about wo's mirror a lobe of twice the angle about the half vector.
            check("phong", &|wi| phong::phong(wi, wo, exponent.max(1.0) / 4.0), 1.0);
            check(
                "ggx",
                &|wi| {
                    let h = wi + wo;
                    distribution::ggx(h, alpha) * masking::smith_ggx(wi, wo, alpha, alpha).visibility
                },
                1.0,
            );
            check(
                "smith beckmann",
                &|wi| {
                    let h = wi + wo;
                    distribution::beckmann(h, alpha) * masking::smith_beckmann(wi, wo, alpha, alpha).visibility
                },
                1.0,
            );
        }
        // Lambert's albedo is ρ by its definition; by the wide lobe's quadrature too.
        let (albedo, error) = albedo_about_half(wo, 1.0, |_| diffuse::lambert(1.0));
        assert!((albedo - 1.0).abs() <= 2.0 * error + 1e-9, "{albedo} ± {error}");
    }
}

// --------------------------------------------------------------------------------------------- diffuse and absorption

proptest! {
    #[test]
    fn oren_nayar_without_roughness_is_lambert(wi in upper(), wo in upper(), albedo in scaled(0, 100, 100)) {
        let parts = diffuse::oren_nayar(wi, wo, 0.0);
        prop_assert_eq!(parts, diffuse::OrenNayar { direct: 1.0, interreflection: 0.0 });
        prop_assert_eq!(parts.f(albedo), diffuse::lambert(albedo));
        prop_assert_eq!(diffuse::oren_nayar_qualitative(wi, wo, 0.0, albedo), diffuse::lambert(albedo));
    }

    #[test]
    fn oren_nayar_turns_with_the_surface(wi in upper(), wo in upper(), sigma in scaled(0, 157, 100), degrees in 0u32..360) {
        let phi = f64::from(degrees).to_radians();
        let turn = |w: Vector<f64>| Vector::new(w.x * phi.cos() - w.y * phi.sin(), w.x * phi.sin() + w.y * phi.cos(), w.z);
        let (a, b) = (diffuse::oren_nayar(wi, wo, sigma).f(1.0), diffuse::oren_nayar(turn(wi), turn(wo), sigma).f(1.0));
        // The rotated components carry 3 roundings, magnified by tangents of at most 1/cos of the higher direction.
        prop_assert!((a - b).abs() <= 16.0 * EPS * (1.0 + 1.0 / wi.z.max(wo.z)), "{} {}", a, b);
    }

    #[test]
    fn absorption_is_a_fraction_and_multiplies(
        sigma in scaled(0, 1000, 100), d in scaled(0, 300, 100), share in scaled(0, 100, 100), ci in cosine(), co in cosine()
    ) {
        let whole = absorption::transmittance(sigma, d, ci, co);
        prop_assert!((0.0..=1.0).contains(&whole));
        prop_assert_eq!(whole, absorption::transmittance(sigma, d, co, ci));
        prop_assert_eq!(absorption::transmittance(0.0, d, ci, co), 1.0);
        prop_assert_eq!(absorption::transmittance(sigma, 0.0, ci, co), 1.0);
        let (above, below) = (d * share, d * (1.0 - share));
        let parts = absorption::transmittance(sigma, above, ci, co) * absorption::transmittance(sigma, below, ci, co);
        let x = sigma * d * (1.0 / ci + 1.0 / co);
        // The documented 3 + 3·x ULP three times; beyond 600 a result may be 0 and its factors not.
        if x < 600.0 {
            prop_assert!(close(whole, parts, 9.0 + 9.0 * x), "{} {}", whole, parts);
        }
    }

    #[test]
    fn internal_reflection_lies_between_its_limits(t in scaled(0, 1000, 1000), g in scaled(0, 1000, 1000)) {
        let value = layered::internal_reflection(t, g);
        prop_assert!(value >= t - EPS && value <= 1.0 + EPS);
        prop_assert_eq!(layered::internal_reflection(t, 0.0), 1.0);
        prop_assert_eq!(layered::internal_reflection(t, 1.0), t);
    }
}

// ---------------------------------------------------------------------------------------------- refraction and frames

proptest! {
    #[test]
    fn refraction_obeys_snell_and_is_undone(w in upper(), eta in eta()) {
        let t = refraction::refract(w, eta);
        // sinθi = η·sinθt, by components: one rounding each way.
        prop_assert!(close(t.x * eta, w.x, 2.0) && close(t.y * eta, w.y, 2.0));
        if t.z > 0.0 {
            // |t|² − 1 = ((s²+c²) − 1)/η²: the input is unit to 4 ε.
            prop_assert!((t.length_squared() - 1.0).abs() <= 8.0 * EPS * (1.0 + 1.0 / (eta * eta)), "{:?}", t);
            let back = refraction::refract(t, 1.0 / eta);
            // c² is rebuilt from t.z² with an error of a few ε·max(1, 1/η²), and c from its root.
            let allowed = 16.0 * EPS * (eta * eta).max(1.0);
            prop_assert!((back.z * back.z - w.z * w.z).abs() <= allowed, "{:?} {:?}", back, w);
            prop_assert!(close(back.x, w.x, 4.0) && close(back.y, w.y, 4.0));
        }
        prop_assert_eq!(t.z, refraction::cos_t(w.z, eta));
    }

    #[test]
    fn frames_are_orthonormal_and_undone(n in prop_oneof![upper(), lower()], w in upper(), tangent in [-100i32..=100, -100i32..=100, -100i32..=100]) {
        fn check<R: Real>(n: Vector<R>, w: Vector<R>, tangent: Vector<R>) -> Result<(), TestCaseError> {
            for frame in [Frame::from_normal(n), Frame::from_normal_and_tangent(n, tangent)] {
                let Frame { tangent: t, bitangent: b, normal: n } = frame;
                let products = [
                    (t.dot(t), 1.0), (b.dot(b), 1.0), (n.dot(n), 1.0), (t.dot(b), 0.0), (t.dot(n), 0.0), (b.dot(n), 0.0),
                ];
                // A tangent made perpendicular keeps ε·|tangent|/|what is left|.
                let across = tangent - n * n.dot(tangent);
                let sine = across.length_squared().to_f64().sqrt() / tangent.length_squared().to_f64().sqrt();
                let slack = 16.0 * R::EPSILON.to_f64() * (1.0 + 1.0 / sine.max(1e-3));
                if sine < 1e-3 {
                    continue;
                }
                for (product, want) in products {
                    prop_assert!((product.to_f64() - want).abs() <= slack, "{:?} {:?}", frame, product);
                }
                let back = frame.to_local(frame.to_world(w)) - w;
                prop_assert!(back.length_squared().to_f64().sqrt() <= 4.0 * slack, "{:?}", back);
                let back = frame.to_world(frame.to_local(w)) - w;
                prop_assert!(back.length_squared().to_f64().sqrt() <= 4.0 * slack, "{:?}", back);
            }
            Ok(())
        }
        let tangent = Vector::from(tangent.map(f64::from)) + Vector::new(0.0, 1e-3, 0.0);
        check::<f64>(n, w, tangent)?;
        check::<f32>(n.cast(), w.cast(), tangent.cast())?;
    }
}

// -------------------------------------------------------------------------------------------------------------- stacks

proptest! {
    #[test]
    fn a_matched_coat_changes_nothing(alpha in alpha(), below in layers(), wi in upper(), wo in upper()) {
        let mut coated = vec![Layer::new(Interface::dielectric(1.0, alpha))];
        coated.extend(below.iter().copied());
        let (coated, bare) = (stack(Model::Conserving, coated), stack(Model::Conserving, below));
        for (coated, bare) in coated.evaluate(wi, wo).into_iter().zip(bare.evaluate(wi, wo)) {
            // Directions pass to the bit; two transmittances of 1 to 4 ULP each, and a product for each layer below.
            prop_assert!(close(coated, bare, 16.0), "{} {}", coated, bare);
        }
    }

    #[test]
    fn a_layer_split_by_a_matched_interface_is_the_same(
        top in microfacet_layer(), below in layers(), share in scaled(0, 100, 100), alpha in alpha(),
        wi in upper(), wo in upper()
    ) {
        let Interface::Microfacet { n, .. } = top.interface else { unreachable!() };
        let (sigma, d) = (top.medium.sigma, top.medium.thickness);
        let matched = Layer::new(Interface::conductor(n, [0.0; 3], alpha)).over(sigma, d * (1.0 - share));
        let mut split = vec![top.over(sigma, d * share), matched];
        split.extend(below.iter().copied());
        let mut whole = vec![top];
        whole.extend(below);
        let [split, whole] = [split, whole].map(|layers| stack(Model::Conserving, layers).evaluate(wi, wo));
        for (channel, (split, whole)) in split.into_iter().zip(whole).enumerate() {
            // As a matched coat, and the absorption's 9 + 9·x ULP of the test above.
            let least = [wi, wo].map(|w| refraction::cos_t(w.z, n[channel]));
            let x = sigma[channel] * d * (1.0 / least[0] + 1.0 / least[1]);
            if x < 600.0 {
                prop_assert!(close(split, whole, 32.0 + 9.0 * x), "{} {}", split, whole);
            }
        }
    }

    #[test]
    fn an_opaque_medium_hides_what_is_below(top in microfacet_layer(), below in layers(), wi in upper(), wo in upper()) {
        // exp(−1e4·2) is 0 in both precisions.
        let mut hidden = vec![top.over([1e4; 3], 1.0)];
        hidden.extend(below);
        for model in Model::CLOSED_FORM {
            let alone = stack(model, vec![top]).evaluate(wi, wo);
            prop_assert_eq!(stack(model, hidden.clone()).evaluate(wi, wo), alone);
        }
    }

    #[test]
    fn absorption_only_darkens(layers in layers(), model in model(), wi in upper(), wo in upper()) {
        let clear = layers.iter().map(|layer| layer.over([0.0; 3], layer.medium.thickness)).collect();
        let (tinted, clear) = (stack(model, layers).evaluate(wi, wo), stack(model, clear).evaluate(wi, wo));
        for (tinted, clear) in tinted.into_iter().zip(clear) {
            // Products and sums of the same numbers by factors ≤ 1 are monotone, rounded too.
            prop_assert!(tinted <= clear, "{} {}", tinted, clear);
        }
    }

    #[test]
    fn channels_do_not_know_of_each_other(layers in layers(), model in model(), wi in upper(), wo in upper()) {
        let all = stack(model, layers.clone()).evaluate(wi, wo);
        for channel in 0..3 {
            let alone: Vec<Layer<f64, 1>> = layers.iter().map(|layer| Layer {
                interface: match layer.interface {
                    Interface::Microfacet { n, k, alpha } => Interface::Microfacet { n: [n[channel]], k: [k[channel]], alpha },
                    Interface::Diffuse { albedo, sigma } => Interface::Diffuse { albedo: [albedo[channel]], sigma },
                },
                medium: layered::Medium { sigma: [layer.medium.sigma[channel]], thickness: layer.medium.thickness },
            }).collect();
            let alone = Stack::new(model, alone).expect("valid").evaluate(wi, wo);
            prop_assert_eq!(all[channel], alone[0]);
        }
    }
}

// ---------------------------------------------------------------------------------------------------------- wild input

/// Calls every public function over `R` with eight numbers in place of whatever it takes.
fn call_everything<R: Real>(x: [f64; 8]) {
    let [a, b, c, d, e, f, g, h] = x.map(R::from_f64);
    let (u, v) = (Vector::new(a, b, c), Vector::new(d, e, f));
    let _ = (fresnel::dielectric(a, b), fresnel::refracted_square(a, b), fresnel::conductor(a, b, c));
    let _ = (fresnel::conductor_approx(a, b, c), fresnel::normal_incidence(a, b), fresnel::schlick(a, b));
    let _ = (fresnel::schlick_from_indices(a, b, c), fresnel::lazanyi_uncorrected(a, b, c));
    let _ = (fresnel::lazanyi(a, b, c, d, e), fresnel::f82_tint(a, b, c));
    let _ = (distribution::beckmann(u, d), distribution::ggx(u, d), distribution::blinn(u, d));
    let _ = (distribution::beckmann_anisotropic(u, d, e), distribution::ggx_anisotropic(u, d, e));
    let _ = (distribution::blinn_anisotropic(u, d, e), distribution::gaussian(u, d, e));
    let _ = (masking::v_cavity(a, b, v), masking::kelemen(a, b, v));
    let _ = (masking::smith_ggx(u, v, g, h), masking::smith_ggx_separable(u, v, g, h));
    let _ = (masking::smith_beckmann(u, v, g, h), masking::smith_beckmann_separable(u, v, g, h));
    let _ = (masking::projected_area_ggx(u, g, h), masking::projected_area_beckmann(u, g, h));
    let _ = (diffuse::lambert(a), diffuse::oren_nayar(u, v, g).f(h), diffuse::oren_nayar_qualitative(u, v, g, h));
    let _ = (refraction::cos_t(a, b), refraction::refract(u, d), absorption::transmittance(a, b, c, d));
    let _ = (phong::phong(u, v, g), phong::blinn_phong(u, v, g));
    let _ = (microfacet::torrance_sparrow(u, v, g, h, a), microfacet::cos_half(u, v), microfacet::facets(u, v, g));
    let _ = (layered::internal_reflection(a, b), material::patina::patina_extent(a, b, c));
    let _ = (Frame::from_normal(u), Frame::from_normal_and_tangent(u, v), Frame::from_normal(u).to_local(v));
    let _ = (u.normalized(), u.cross(v), half_vector(u, v));
    #[cfg(feature = "std")]
    let _ = Vector::<R>::from_angles(x[0], x[1]);
    let _ =
        (a.ln_one_plus(), a.angle(b), a.erfcx(), a.exp_product(b), a.saturate(), a.product_exact(b), a.sum_exact(b));
    // Past the constructor too.
    let layers = [
        Layer::<R, 2>::new(Interface::conductor([a, b], [c, d], e)).over([f, g], h),
        Layer::new(Interface::diffuse([c, d], e)),
        Layer::new(Interface::dielectric(f, g)),
    ];
    let _ = (layered::elek(&layers, u, v), layered::conserving(&layers, u, v));
    for model in Model::CLOSED_FORM {
        if let Ok(stack) = Stack::new(model, layers[..2].to_vec()) {
            let _ = stack.evaluate(u, v);
        }
    }
}

proptest! {
    #[test]
    fn no_number_panics(x in prop::array::uniform8(wild())) {
        call_everything::<f64>(x);
        call_everything::<f32>(x);
        let _ = distribution::gaussian_normalisation(x[0]);
    }

    #[test]
    fn a_stack_refuses_numbers_out_of_range(n in wild(), k in wild(), alpha in wild(), sigma in wild(), thickness in wild()) {
        let layer = Layer::new(Interface::conductor([n], [k], alpha)).over([sigma], thickness);
        let valid = n > 0.0 && n.is_finite() && k >= 0.0 && k.is_finite() && (1e-4..=1.0).contains(&alpha)
            && sigma >= 0.0 && sigma.is_finite() && thickness >= 0.0 && thickness.is_finite();
        prop_assert_eq!(Stack::new(Model::Conserving, vec![layer]).is_ok(), valid);
    }
}

#[test]
fn the_fit_survives_any_index() {
    for (n, k) in [(f64::NAN, 1.0), (0.0, 0.0), (1.0, 0.0), (f64::INFINITY, 1.0), (1.5, -1.0), (-1.0, f64::MAX)] {
        let _ = fresnel::lazanyi_fit(n, k);
    }
}
