//! No input makes a function panic.

use super::*;

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
        let valid = (1e-3..=1e3).contains(&n) && (0.0..=1e3).contains(&k) && (1e-4..=1.0).contains(&alpha)
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
