//! The cost of every term, scalar, in f32 and f64: `cargo bench --bench terms`.
//!
//! Each benchmark evaluates one term at the same 1024 low-discrepancy inputs; its throughput is terms per second.

use brdf::table::{DistributionTable, ENTRIES, FresnelTable, Half, Mapping, SIDE};
use brdf::{Real, Vector, half_vector};
use brdf::{absorption, diffuse, distribution, fresnel, masking, microfacet, phong, refraction};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::Duration;

/// n and κ of copper (Elek 2010, App. A).
const COPPER: ([f64; 3], [f64; 3]) = ([0.213, 1.04, 1.17], [4.05, 2.59, 2.36]);

/// One evaluation's arguments, of which a term takes what it needs.
#[derive(Clone, Copy)]
struct Input<R> {
    wi: Vector<R>,
    wo: Vector<R>,
    h: Vector<R>,
    cos: R,
    eta: R,
    n: R,
    k: R,
    alpha: R,
    /// 1/(πα²), the scale of a Gaussian's constant.
    normalisation: R,
    /// In [0, 1].
    u: R,
    exponent: R,
}

fn inputs<R: Real>() -> Vec<Input<R>> {
    // Roberts 2018: the root of x⁸ = x + 1 gives the steps of a sequence in seven dimensions.
    const G: f64 = 1.096_981_557_798_559_8;
    let point = |i: i32| {
        let mut axis = 0;
        [(); 7].map(|()| {
            axis += 1;
            (0.5 + f64::from(i) * G.powi(-axis)).fract()
        })
    };
    let direction = |u: f64, v: f64| {
        let (cos, phi) = (0.02 + 0.98 * u, 2.0 * std::f64::consts::PI * v);
        let sin = (1.0 - cos * cos).sqrt();
        Vector::new(sin * phi.cos(), sin * phi.sin(), cos)
    };
    let one = |i: i32| {
        let [a, b, c, d, e, f, g] = point(i);
        let alpha = 0.05 + 0.9 * e;
        // A half vector within two widths of the normal, and the viewer that mirrors the light about it.
        let (wi, tan, phi) = (direction(a, b), 2.0 * alpha * c, 2.0 * std::f64::consts::PI * d);
        let m = Vector::new(tan * phi.cos(), tan * phi.sin(), 1.0).normalized();
        let mirrored = m * (2.0 * wi.dot(m)) - wi;
        let wo = if mirrored.z > 0.0 { mirrored } else { direction(d, c) };
        Input {
            wi: wi.cast(),
            wo: wo.cast(),
            h: half_vector(wi, wo).cast(),
            cos: R::from_f64(a),
            eta: R::from_f64(0.7 + 1.8 * f),
            n: R::from_f64(0.1 + 3.0 * f),
            k: R::from_f64(5.0 * g),
            alpha: R::from_f64(alpha),
            normalisation: R::from_f64(1.0 / (std::f64::consts::PI * alpha * alpha)),
            u: R::from_f64(g),
            exponent: R::from_f64(1.0 + 200.0 * e),
        }
    };
    (0..1024).map(one).collect()
}

fn terms<R: Real>(c: &mut Criterion, number: &str) {
    let inputs = inputs::<R>();
    let mut group = c.benchmark_group(number);
    group.throughput(Throughput::Elements(inputs.len() as u64));
    macro_rules! term {
        ($name:literal, |$i:ident| $value:expr) => {
            group.bench_function($name, |b| {
                b.iter(|| {
                    for $i in black_box(&inputs) {
                        black_box($value);
                    }
                });
            });
        };
    }
    term!("fresnel/dielectric", |i| fresnel::dielectric(i.cos, i.eta));
    term!("fresnel/conductor", |i| fresnel::conductor(i.cos, i.n, i.k));
    term!("fresnel/conductor_approx", |i| fresnel::conductor_approx(i.cos, i.n, i.k));
    term!("fresnel/normal_incidence", |i| fresnel::normal_incidence(i.n, i.k));
    term!("fresnel/schlick", |i| fresnel::schlick(i.cos, i.u));
    term!("fresnel/schlick_from_indices", |i| fresnel::schlick_from_indices(i.cos, R::ONE, i.eta));
    term!("fresnel/lazanyi_uncorrected", |i| fresnel::lazanyi_uncorrected(i.cos, i.n, i.k));
    term!("fresnel/lazanyi", |i| fresnel::lazanyi(i.cos, i.n, i.k, i.u, i.eta));
    term!("fresnel/f82_tint", |i| fresnel::f82_tint(i.cos, i.u, i.alpha));
    // Three channels of one material: the exact terms and what replaces them.
    let (n, k) = COPPER;
    let (eight, twelve) = (fresnel::Fit::<3, 8>::new(n, k), fresnel::Fit::<3, 12>::new(n, k));
    let (eight, twelve) = (eight.expect("copper is smooth"), twelve.expect("copper is smooth"));
    let (eight, twelve) = (black_box(&eight), black_box(&twelve));
    let [n, k]: [[R; 3]; 2] = black_box([n.map(R::from_f64), k.map(R::from_f64)]);
    let base = black_box([0, 1, 2].map(|c| fresnel::normal_incidence(n[c], k[c])));
    term!("fresnel_rgb/conductor", |i| [0, 1, 2].map(|c| fresnel::conductor(i.cos, n[c], k[c])));
    term!("fresnel_rgb/fit_8", |i| eight.evaluate(i.cos));
    term!("fresnel_rgb/fit_12", |i| twelve.evaluate(i.cos));
    let table = |mapping| FresnelTable::<3>::new(COPPER.0, COPPER.1, ENTRIES, mapping).expect("copper has tables");
    let bytes = |mapping| FresnelTable::<3, u8>::new(COPPER.0, COPPER.1, ENTRIES, mapping).expect("copper has tables");
    let [angle, root] = black_box([Mapping::Angle, Mapping::Root].map(table));
    let [angle_bytes, root_bytes] = black_box([Mapping::Angle, Mapping::Root].map(bytes));
    term!("fresnel_rgb/table_128", |i| angle.reflectance(i.cos));
    term!("fresnel_rgb/table_128_8bit", |i| angle_bytes.reflectance(i.cos));
    term!("fresnel_rgb/table_128_root", |i| root.reflectance(i.cos));
    term!("fresnel_rgb/table_128_root_8bit", |i| root_bytes.reflectance(i.cos));
    term!("fresnel_rgb/lazanyi_uncorrected", |i| [0, 1, 2].map(|c| fresnel::lazanyi_uncorrected(i.cos, n[c], k[c])));
    term!("fresnel_rgb/lazanyi", |i| [0, 1, 2].map(|c| fresnel::lazanyi(i.cos, n[c], k[c], i.u, i.eta)));
    term!("fresnel_rgb/schlick", |i| base.map(|f| fresnel::schlick(i.cos, f)));
    term!("distribution/beckmann", |i| distribution::beckmann(i.h, i.alpha));
    let table = |mapping| DistributionTable::<f32>::new(SIDE, SIDE, 2.3e-3, mapping).expect("in the ranges");
    let half = |mapping| DistributionTable::<Half>::new(SIDE, SIDE, 2.3e-3, mapping).expect("in the ranges");
    let [angle, root] = black_box([Mapping::Angle, Mapping::Root].map(table));
    let [angle_half, root_half] = black_box([Mapping::Angle, Mapping::Root].map(half));
    term!("distribution/table_512", |i| angle.evaluate(i.h, i.alpha));
    term!("distribution/table_512_f16", |i| angle_half.evaluate(i.h, i.alpha));
    term!("distribution/table_512_root", |i| root.evaluate(i.h, i.alpha));
    term!("distribution/table_512_root_f16", |i| root_half.evaluate(i.h, i.alpha));
    term!("distribution/beckmann_anisotropic", |i| distribution::beckmann_anisotropic(i.h, i.alpha, i.u));
    term!("distribution/ggx", |i| distribution::ggx(i.h, i.alpha));
    term!("distribution/ggx_anisotropic", |i| distribution::ggx_anisotropic(i.h, i.alpha, i.u));
    term!("distribution/blinn", |i| distribution::blinn(i.h, i.alpha));
    term!("distribution/blinn_anisotropic", |i| distribution::blinn_anisotropic(i.h, i.alpha, i.u));
    term!("distribution/gaussian", |i| distribution::gaussian(i.h, i.alpha, i.normalisation));
    term!("masking/v_cavity", |i| masking::v_cavity(i.wi.z, i.wo.z, i.h));
    term!("masking/smith_ggx", |i| masking::smith_ggx(i.wi, i.wo, i.alpha, i.alpha));
    term!("masking/smith_ggx_separable", |i| masking::smith_ggx_separable(i.wi, i.wo, i.alpha, i.alpha));
    term!("masking/smith_beckmann", |i| masking::smith_beckmann(i.wi, i.wo, i.alpha, i.alpha));
    term!("masking/smith_beckmann_separable", |i| masking::smith_beckmann_separable(i.wi, i.wo, i.alpha, i.alpha));
    term!("masking/kelemen", |i| masking::kelemen(i.wi.z, i.wo.z, i.h));
    term!("diffuse/lambert", |i| diffuse::lambert(i.u));
    term!("diffuse/oren_nayar", |i| diffuse::oren_nayar(i.wi, i.wo, i.alpha).f(i.u));
    term!("diffuse/oren_nayar_qualitative", |i| diffuse::oren_nayar_qualitative(i.wi, i.wo, i.alpha, i.u));
    term!("refraction/refract", |i| refraction::refract(i.wi, i.eta));
    term!("absorption/transmittance", |i| absorption::transmittance(i.u, i.alpha, i.wi.z, i.wo.z));
    term!("phong/phong", |i| phong::phong(i.wi, i.wo, i.exponent));
    term!("phong/blinn_phong", |i| phong::blinn_phong(i.wi, i.wo, i.exponent));
    term!("microfacet/facets", |i| microfacet::facets(i.wi, i.wo, i.alpha));
    term!("microfacet/torrance_sparrow", |i| microfacet::torrance_sparrow(i.wi, i.wo, i.n, i.k, i.alpha));
    group.finish();
}

fn all(c: &mut Criterion) {
    terms::<f32>(c, "f32");
    terms::<f64>(c, "f64");
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_millis(100))
        .measurement_time(Duration::from_millis(300));
    targets = all
}
criterion_main!(benches);
