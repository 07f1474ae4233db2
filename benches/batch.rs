//! Terms over slices, at each level of this processor, and one by one in f32: `cargo bench --bench batch`.
//!
//! Each benchmark evaluates one term at the same 4096 low-discrepancy inputs, which with the results stay in the second-level
//! cache; its throughput is evaluations per second. *scalar* is the function over f32, which is exact to half an ULP.

use brdf::batch::{self, Kernel, Level, terms};
use brdf::{Vector, fresnel, half_vector};
use brdf::{absorption, diffuse, distribution, masking, microfacet, phong, refraction};
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use std::time::Duration;

const COUNT: usize = 4096;

/// Structure of arrays: pairs of directions within a few widths of a mirror, half vectors, cosines.
struct Inputs {
    pair: [Vec<f32>; 6],
    half: [Vec<f32>; 3],
    normal: [Vec<f32>; 6],
    cosines: [Vec<f32>; 2],
}

fn inputs() -> Inputs {
    // Roberts 2018: the root of x⁵ = x + 1 gives the steps of a sequence in four dimensions.
    const G: f64 = 1.167_303_978_261_418_7;
    let direction = |u: f64, v: f64| {
        let (cos, phi) = (0.02 + 0.98 * u, 2.0 * std::f64::consts::PI * v);
        let sin = (1.0 - cos * cos).sqrt();
        Vector::new(sin * phi.cos(), sin * phi.sin(), cos)
    };
    let mut inputs = Inputs {
        pair: Default::default(),
        half: Default::default(),
        normal: Default::default(),
        cosines: Default::default(),
    };
    for i in 0..COUNT as i32 {
        let [a, b, c, d] = [1, 2, 3, 4].map(|axis| (0.5 + f64::from(i) * G.powi(-axis)).fract());
        let (wi, tan, phi) = (direction(a, b), 0.6 * c, 2.0 * std::f64::consts::PI * d);
        let m = Vector::new(tan * phi.cos(), tan * phi.sin(), 1.0).normalized();
        let mirrored = m * (2.0 * wi.dot(m)) - wi;
        let wo = if mirrored.z > 0.0 { mirrored } else { direction(d, c) };
        let h = half_vector(wi, wo);
        let m = h.normalized();
        let push = |columns: &mut [Vec<f32>], numbers: &[f64]| {
            for (column, number) in columns.iter_mut().zip(numbers) {
                column.push(*number as f32);
            }
        };
        push(&mut inputs.pair, &[wi.x, wi.y, wi.z, wo.x, wo.y, wo.z]);
        push(&mut inputs.half, &[h.x, h.y, h.z]);
        push(&mut inputs.normal, &[wi.x, wi.y, wi.z, m.x, m.y, m.z]);
        push(&mut inputs.cosines, &[a, wo.z]);
    }
    inputs
}

/// One term: the kernel at each level, and the function over f32.
fn term<K: Kernel<I, O>, const I: usize, const O: usize>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    name: &str,
    kernel: K,
    columns: &[Vec<f32>],
    scalar: impl Fn([f32; I]) -> [f32; O],
) {
    let inputs: [&[f32]; I] = std::array::from_fn(|i| columns[i].as_slice());
    let mut outputs: [Vec<f32>; O] = std::array::from_fn(|_| vec![0.0; COUNT]);
    group.throughput(Throughput::Elements(COUNT as u64));
    group.bench_function(BenchmarkId::new(name, "scalar"), |b| {
        b.iter(|| {
            for i in 0..COUNT {
                let results = scalar(black_box(inputs).map(|column| column[i]));
                for (output, result) in outputs.iter_mut().zip(results) {
                    output[i] = result;
                }
            }
            black_box(&mut outputs);
        });
    });
    for level in Level::available() {
        group.bench_function(BenchmarkId::new(name, level.name()), |b| {
            b.iter(|| {
                let slices = outputs.each_mut().map(Vec::as_mut_slice);
                batch::map_at(level, black_box(&kernel), black_box(inputs), slices).expect("slices of one length");
                black_box(&mut outputs);
            });
        });
    }
}

fn wi(a: &[f32]) -> Vector<f32> {
    Vector::new(a[0], a[1], a[2])
}

fn wo(a: &[f32]) -> Vector<f32> {
    Vector::new(a[3], a[4], a[5])
}

#[rustfmt::skip]
fn all(c: &mut Criterion) {
    let inputs = inputs();
    let (cos, half, pair, normal) = (&inputs.cosines, &inputs.half, &inputs.pair, &inputs.normal);
    let split = |f: fresnel::Fresnel<f32>| [f.reflectance, f.transmittance];
    let both = |m: masking::Masking<f32>| [m.g, m.visibility];
    let [eta, n, k, f0, tint, a, exponent, width, other, scale, sigma, albedo, shine] =
        black_box([1.5, 1.04, 2.59, 0.04, 0.6, 1.5, 6.0, 0.3, 0.2, 3.5, 0.5, 0.8, 50.0]);
    let g = &mut c.benchmark_group("batch");
    term(g, "fresnel/dielectric", terms::Dielectric { eta }, cos, |[c]| split(fresnel::dielectric(c, eta)));
    term(g, "fresnel/refracted_square", terms::RefractedSquare { eta }, cos, |[c]| [fresnel::refracted_square(c, eta)]);
    term(g, "fresnel/conductor", terms::Conductor { n, k }, cos, |[c]| split(fresnel::conductor(c, n, k)));
    term(g, "fresnel/conductor_approx", terms::ConductorApprox { n, k }, cos, |[c]| [fresnel::conductor_approx(c, n, k)]);
    term(g, "fresnel/normal_incidence", terms::NormalIncidence {}, cos, |[n, k]| [fresnel::normal_incidence(n, k)]);
    term(g, "fresnel/schlick", terms::Schlick { f0 }, cos, |[c]| split(fresnel::schlick(c, f0)));
    term(g, "fresnel/schlick_from_indices", terms::SchlickFromIndices { n_i: 1.0, n_t: eta }, cos,
        |[c]| split(fresnel::schlick_from_indices(c, 1.0, eta)));
    term(g, "fresnel/lazanyi_uncorrected", terms::LazanyiUncorrected { n, k }, cos, |[c]| [fresnel::lazanyi_uncorrected(c, n, k)]);
    term(g, "fresnel/lazanyi", terms::Lazanyi { n, k, a, exponent }, cos, |[c]| [fresnel::lazanyi(c, n, k, a, exponent)]);
    term(g, "fresnel/f82_tint", terms::F82Tint { f0, tint }, cos, |[c]| [fresnel::f82_tint(c, f0, tint)]);
    let fit = fresnel::Fit::<3, 8>::new([0.213, 1.04, 1.17], [4.05, 2.59, 2.36]).expect("copper is smooth");
    term(g, "fresnel/fit_8", fit, cos, |[c]| fit.reflectance(c));

    term(g, "distribution/beckmann", terms::Beckmann { alpha: width }, half, |a| [distribution::beckmann(wi(&a), width)]);
    term(g, "distribution/beckmann_anisotropic", terms::BeckmannAnisotropic { alpha_x: width, alpha_y: other }, half,
        |a| [distribution::beckmann_anisotropic(wi(&a), width, other)]);
    term(g, "distribution/ggx", terms::Ggx { alpha: width }, half, |a| [distribution::ggx(wi(&a), width)]);
    term(g, "distribution/ggx_anisotropic", terms::GgxAnisotropic { alpha_x: width, alpha_y: other }, half,
        |a| [distribution::ggx_anisotropic(wi(&a), width, other)]);
    term(g, "distribution/blinn", terms::Blinn { alpha: width }, half, |a| [distribution::blinn(wi(&a), width)]);
    term(g, "distribution/blinn_anisotropic", terms::BlinnAnisotropic { alpha_x: width, alpha_y: other }, half,
        |a| [distribution::blinn_anisotropic(wi(&a), width, other)]);
    term(g, "distribution/gaussian", terms::Gaussian { alpha: width, normalisation: scale }, half,
        |a| [distribution::gaussian(wi(&a), width, scale)]);

    term(g, "masking/v_cavity", terms::VCavity {}, pair, |a| both(masking::v_cavity(a[2], a[5], wi(&a) + wo(&a))));
    term(g, "masking/smith_ggx", terms::SmithGgx { alpha_x: width, alpha_y: other }, pair,
        |a| both(masking::smith_ggx(wi(&a), wo(&a), width, other)));
    term(g, "masking/smith_ggx_separable", terms::SmithGgxSeparable { alpha_x: width, alpha_y: other }, pair,
        |a| both(masking::smith_ggx_separable(wi(&a), wo(&a), width, other)));
    term(g, "masking/smith_beckmann", terms::SmithBeckmann { alpha_x: width, alpha_y: other }, pair,
        |a| both(masking::smith_beckmann(wi(&a), wo(&a), width, other)));
    term(g, "masking/smith_beckmann_separable", terms::SmithBeckmannSeparable { alpha_x: width, alpha_y: other }, pair,
        |a| both(masking::smith_beckmann_separable(wi(&a), wo(&a), width, other)));
    term(g, "masking/kelemen", terms::Kelemen {}, pair, |a| both(masking::kelemen(a[2], a[5], wi(&a) + wo(&a))));
    term(g, "masking/projected_area_ggx", terms::ProjectedAreaGgx { alpha_x: width, alpha_y: other }, pair,
        |a: [f32; 3]| [masking::projected_area_ggx(wi(&a), width, other)]);
    term(g, "masking/projected_area_beckmann", terms::ProjectedAreaBeckmann { alpha_x: width, alpha_y: other }, pair,
        |a: [f32; 3]| [masking::projected_area_beckmann(wi(&a), width, other)]);

    term(g, "diffuse/oren_nayar", terms::OrenNayar { sigma }, pair,
        |a| { let f = diffuse::oren_nayar(wi(&a), wo(&a), sigma); [f.direct, f.interreflection] });
    term(g, "diffuse/oren_nayar_qualitative", terms::OrenNayarQualitative { sigma, albedo }, pair,
        |a| [diffuse::oren_nayar_qualitative(wi(&a), wo(&a), sigma, albedo)]);
    term(g, "refraction/cos_t", terms::CosT { eta }, cos, |[c]| [refraction::cos_t(c, eta)]);
    term(g, "refraction/refract", terms::Refract { eta }, pair, |a: [f32; 3]| refraction::refract(wi(&a), eta).into());
    term(g, "refraction/refract_about", terms::RefractAbout { eta }, normal,
        |a| refraction::refract_about(wi(&a), wo(&a), eta).into());
    term(g, "absorption/transmittance", terms::Transmittance { sigma, thickness: albedo }, cos,
        |[i, o]| [absorption::transmittance(sigma, albedo, i, o)]);
    term(g, "phong/phong", terms::Phong { exponent: shine }, pair, |a| [phong::phong(wi(&a), wo(&a), shine)]);
    term(g, "phong/blinn_phong", terms::BlinnPhong { exponent: shine }, pair, |a| [phong::blinn_phong(wi(&a), wo(&a), shine)]);
    term(g, "microfacet/cos_half", terms::CosHalf {}, pair, |a| [microfacet::cos_half(wi(&a), wo(&a))]);
    term(g, "microfacet/facets", terms::Facets { alpha: width }, pair,
        |a| { let f = microfacet::facets(wi(&a), wo(&a), width); [f.lobe, f.d, f.g] });
    let metal = terms::TorranceSparrow { n: [0.213, n, 1.17], k: [4.05, k, 2.36], alpha: width };
    // As a renderer calls it: what the channels share once.
    term(g, "microfacet/torrance_sparrow_rgb", metal, pair, |a| {
        let (cos, facets) = (microfacet::cos_half(wi(&a), wo(&a)), microfacet::facets(wi(&a), wo(&a), width));
        [0, 1, 2].map(|c| facets.lobe * fresnel::conductor(cos, metal.n[c], metal.k[c]).reflectance)
    });
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(50))
        .measurement_time(Duration::from_millis(150));
    targets = all
}
criterion_main!(benches);
