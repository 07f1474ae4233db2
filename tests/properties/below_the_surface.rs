//! Diffuse terms, absorption, refraction and frames.

use super::*;

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
