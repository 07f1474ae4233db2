//! Every BRDF and stack: reciprocity, sign, the horizon.

use super::*;

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

proptest! {
    #[test]
    fn brdfs_are_reciprocal(wi in upper(), wo in upper(), alpha in alpha(), (n, k) in index()) {
        fn check<R: Real>(wi: Vector<R>, wo: Vector<R>, alpha: f64, n: f64, k: f64) -> Result<(), TestCaseError> {
            for ((name, f), (_, swapped)) in brdfs(wi, wo, alpha, n, k).into_iter().zip(brdfs(wo, wi, alpha, n, k)) {
                // Every form is symmetric operation by operation.
                prop_assert!(f == swapped, "{}: {:?} {:?}", name, f, swapped);
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
                prop_assert!(f == swapped, "{:?} {:?}", f, swapped);
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
