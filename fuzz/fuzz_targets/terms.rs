//! Every term over any eight numbers (but for the fit and the normalisation, which take a thousand times as long): none panics; inside a term's domain the result is finite, not negative, and F ≤ 1.

#![no_main]

use arbitrary::Arbitrary;
use brdf::{Real, Vector, absorption, diffuse, distribution, fresnel, masking, material, microfacet, phong, refraction};
use brdf::{Frame, half_vector, layered, sampling, walk};
use libfuzzer_sys::fuzz_target;

/// Numbers as they come, and the same bits scaled into the terms' domains.
#[derive(Arbitrary, Debug)]
struct Input {
    wild: [f64; 8],
    cos: [u32; 2],
    phi: [u16; 2],
    n: u32,
    k: u32,
    alpha: u32,
    u: [u32; 3],
}

/// A share of 1 from all 32 bits: half of them linear, half by decades to 1e-6.
fn share(bits: u32) -> f64 {
    let linear = f64::from(bits >> 1) / f64::from(u32::MAX >> 1);
    if bits & 1 == 0 { linear } else { 10f64.powf(-6.0 * linear) }
}

fn direction(cos: f64, phi: u16) -> Vector<f64> {
    let (sin, angle) = (((1.0 - cos) * (1.0 + cos)).sqrt(), f64::from(phi) / 65536.0 * std::f64::consts::TAU);
    Vector::new(sin * angle.cos(), sin * angle.sin(), cos)
}

fn any_number<R: Real<Mask = bool>>(x: [f64; 8]) {
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
    let _ = (refraction::cos_t(a, b), refraction::refract(u, d), refraction::refract_about(u, v, g));
    let _ = (absorption::transmittance(a, b, c, d), phong::phong(u, v, g), phong::blinn_phong(u, v, g));
    let _ = (microfacet::torrance_sparrow(u, v, g, h, a), microfacet::cos_half(u, v), microfacet::facets(u, v, g));
    let _ = (layered::internal_reflection(a, b), material::patina::patina_extent(a, b, c));
    let _ = (Frame::from_normal(u), Frame::from_normal_and_tangent(u, v), Frame::from_normal(u).to_local(v));
    let _ = (u.normalized(), u.cross(v), half_vector(u, v), Vector::<R>::from_angles(x[0], x[1]));
    let _ = (sampling::reflect_visible(u, d, [e, f, g]), sampling::reflect_visible_pdf(u, v, g));
    let _ = (sampling::cosine_hemisphere([a, b]), sampling::uniform_hemisphere([a, b]));
    let _ = (walk::reflection(u, v, g), walk::visible_normal(u, d, [e, f, g]), walk::visible_part(u, v));
}

fn in_domain<R: Real>(name: &str, value: R, most: f64) {
    let value = value.to_f64();
    assert!(value >= 0.0 && value <= most, "{name}: {value}");
}

fn domain<R: Real>(input: &Input) {
    let one = |x: f64| R::from_f64(x);
    let [ci, co] = input.cos.map(|bits| share(bits).max(1e-6));
    let (wi, wo) = (direction(ci, input.phi[0]).cast::<R>(), direction(co, input.phi[1]).cast::<R>());
    let (n, k, alpha) = (0.02 + 7.98 * share(input.n), 12.0 * share(input.k), share(input.alpha).max(1e-4));
    let (c, h) = (wi.z, half_vector(wi, wo));
    // Rounding may lift a product of shares by some ULP over 1.
    let one_and_a_bit = 1.0 + 8.0 * if size_of::<R>() == 4 { f64::from(f32::EPSILON) } else { f64::EPSILON };
    for (name, f) in [
        ("dielectric", fresnel::dielectric(c, one(n))),
        ("conductor", fresnel::conductor(c, one(n), one(k))),
        ("schlick", fresnel::schlick(c, fresnel::normal_incidence(one(n), one(k)))),
    ] {
        in_domain(name, f.reflectance, one_and_a_bit);
        in_domain(name, f.transmittance, one_and_a_bit);
    }
    in_domain("conductor_approx", fresnel::conductor_approx(c, one(n), one(k)), one_and_a_bit);
    let finite = f64::from(f32::MAX);
    in_domain("beckmann", distribution::beckmann(h, one(alpha)), finite);
    in_domain("ggx", distribution::ggx(h, one(alpha)), finite);
    in_domain("blinn", distribution::blinn(h, one(alpha)), finite);
    let masking = masking::v_cavity(wi.z, wo.z, h);
    in_domain("G", masking.g, one_and_a_bit);
    in_domain("V", masking.visibility, finite);
    let smith = masking::smith_ggx(wi, wo, one(alpha), one(alpha));
    in_domain("smith_ggx", smith.g, one_and_a_bit);
    let base = diffuse::oren_nayar(wi, wo, one(1.5 * share(input.k)));
    in_domain("oren_nayar", base.f(one(share(input.n))), finite);
    in_domain("absorption", absorption::transmittance(one(k), one(n), wi.z, wo.z), 1.0);
    let ts = microfacet::torrance_sparrow(wi, wo, one(n), one(k), one(alpha));
    in_domain("torrance_sparrow", ts.f, finite);
    let u = input.u.map(|bits| one(f64::from(bits) / 4294967296.0));
    let drawn = sampling::reflect_visible(wo, one(alpha), u);
    assert!([drawn.x, drawn.y, drawn.z].iter().all(|x| x.to_f64().is_finite()), "{drawn:?}");
    in_domain("reflect_visible_pdf", sampling::reflect_visible_pdf(wi, wo, one(alpha)), finite);
}

fuzz_target!(|input: Input| {
    any_number::<f64>(input.wild);
    any_number::<f32>(input.wild);
    domain::<f64>(&input);
    domain::<f32>(&input);
});
