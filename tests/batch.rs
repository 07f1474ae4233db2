//! The batch path against the scalar one: every kernel, at every level of this processor, over every length of a remainder.

use brdf::batch::{self, Kernel, LengthError, Level, terms};
use brdf::real::Real;
use brdf::table::{DistributionTable, ENTRIES, FresnelTable, Mapping};
use brdf::{Vector, distribution, fresnel, masking, microfacet, phong, refraction};

/// Numbers that cover what kernels take: cosines and components of directions, with the ends.
fn column(seed: usize, count: usize) -> Vec<f32> {
    (0..count).map(|i| (((i * 7 + seed * 13 + 3) as f32) * 0.618_034).fract().max(1e-6)).collect()
}

/// Runs one check with every kernel of the crate.
trait Check {
    fn check<K: Kernel<I, O>, const I: usize, const O: usize>(&self, name: &str, kernel: K);
}

fn every_kernel(check: &impl Check) {
    let (eta, n, k, alpha, alpha_x, alpha_y, sigma) = (1.5, 0.3, 2.5, 0.3, 0.2, 0.4, 0.5);
    check.check("Dielectric", terms::Dielectric { eta });
    check.check("RefractedSquare", terms::RefractedSquare { eta });
    check.check("Conductor", terms::Conductor { n, k });
    check.check("ConductorApprox", terms::ConductorApprox { n, k });
    check.check("NormalIncidence", terms::NormalIncidence {});
    check.check("Schlick", terms::Schlick { f0: 0.04 });
    check.check("SchlickFromIndices", terms::SchlickFromIndices { n_i: 1.0, n_t: 1.5 });
    check.check("LazanyiUncorrected", terms::LazanyiUncorrected { n, k });
    check.check("Lazanyi", terms::Lazanyi { n, k, a: 1.5, exponent: 6.0 });
    check.check("F82Tint", terms::F82Tint { f0: 0.6, tint: 0.7 });
    check.check("Fit", fresnel::Fit::<3, 8>::new([0.2, 1.0, 1.2], [4.0, 2.6, 2.4]).expect("copper is smooth"));
    let (n3, k3) = ([0.2, 1.0, 1.2], [4.0, 2.6, 2.4]);
    for mapping in [Mapping::Angle, Mapping::Root] {
        let table = FresnelTable::<3, u8>::new(n3, k3, ENTRIES, mapping).expect("within the ranges");
        check.check(&format!("FresnelTable over {mapping:?}"), table);
        let table = DistributionTable::<f32>::new(32, 32, 2e-3, mapping).expect("within the ranges");
        check.check(&format!("DistributionTable over {mapping:?}"), table);
    }
    check.check("Beckmann", terms::Beckmann { alpha });
    check.check("BeckmannAnisotropic", terms::BeckmannAnisotropic { alpha_x, alpha_y });
    check.check("Ggx", terms::Ggx { alpha });
    check.check("GgxAnisotropic", terms::GgxAnisotropic { alpha_x, alpha_y });
    check.check("Blinn", terms::Blinn { alpha });
    check.check("BlinnAnisotropic", terms::BlinnAnisotropic { alpha_x, alpha_y });
    check.check("Gaussian", terms::Gaussian { alpha, normalisation: 3.5 });
    check.check("VCavity", terms::VCavity {});
    check.check("SmithGgx", terms::SmithGgx { alpha_x, alpha_y });
    check.check("SmithGgxSeparable", terms::SmithGgxSeparable { alpha_x, alpha_y });
    check.check("SmithBeckmann", terms::SmithBeckmann { alpha_x, alpha_y });
    check.check("SmithBeckmannSeparable", terms::SmithBeckmannSeparable { alpha_x, alpha_y });
    check.check("Kelemen", terms::Kelemen {});
    check.check("ProjectedAreaGgx", terms::ProjectedAreaGgx { alpha_x, alpha_y });
    check.check("ProjectedAreaBeckmann", terms::ProjectedAreaBeckmann { alpha_x, alpha_y });
    check.check("OrenNayar", terms::OrenNayar { sigma });
    check.check("OrenNayarQualitative", terms::OrenNayarQualitative { sigma, albedo: 0.8 });
    check.check("CosT", terms::CosT { eta });
    check.check("Refract", terms::Refract { eta });
    check.check("RefractAbout", terms::RefractAbout { eta });
    check.check("Transmittance", terms::Transmittance { sigma, thickness: 0.3 });
    check.check("Phong", terms::Phong { exponent: 40.0 });
    check.check("BlinnPhong", terms::BlinnPhong { exponent: 40.0 });
    check.check("CosHalf", terms::CosHalf {});
    check.check("Facets", terms::Facets { alpha });
    check.check("TorranceSparrow", terms::TorranceSparrow { n: [0.2, 1.0, 1.2], k: [4.0, 2.6, 2.4], alpha });
    check.check("TorranceSparrow of 5", terms::TorranceSparrow { n: [0.2; 5], k: [4.0, 3.0, 2.0, 1.0, 0.0], alpha });
}

fn run<K: Kernel<I, O>, const I: usize, const O: usize>(
    level: Level,
    kernel: &K,
    columns: &[Vec<f32>; I],
    range: std::ops::Range<usize>,
) -> [Vec<f32>; O] {
    let mut outputs: [Vec<f32>; O] = std::array::from_fn(|_| vec![f32::NAN; range.len()]);
    let inputs = columns.each_ref().map(|column| &column[range.clone()]);
    batch::map_at(level, kernel, inputs, outputs.each_mut().map(Vec::as_mut_slice)).expect("slices of one length");
    outputs
}

fn same_bits(a: &[f32], b: &[f32]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan())
}

struct Lengths;
impl Check for Lengths {
    fn check<K: Kernel<I, O>, const I: usize, const O: usize>(&self, name: &str, kernel: K) {
        const LONGEST: usize = 67;
        let columns: [Vec<f32>; I] = std::array::from_fn(|seed| column(seed, LONGEST));
        for level in Level::available() {
            let single = (0..LONGEST).map(|i| run::<K, I, O>(level, &kernel, &columns, i..i + 1));
            let mut one_by_one: [Vec<f32>; O] = std::array::from_fn(|_| Vec::new());
            for results in single {
                for (all, one) in one_by_one.iter_mut().zip(results) {
                    all.extend(one);
                }
            }
            for length in 0..=LONGEST {
                let results = run::<K, I, O>(level, &kernel, &columns, 0..length);
                for (together, alone) in results.iter().zip(&one_by_one) {
                    assert!(same_bits(together, &alone[..length]), "{name} at {}, length {length}", level.name());
                }
            }
        }
    }
}

#[test]
fn a_result_does_not_depend_on_where_in_a_slice_it_is() {
    every_kernel(&Lengths);
}

struct Wild;
impl Check for Wild {
    fn check<K: Kernel<I, O>, const I: usize, const O: usize>(&self, _: &str, kernel: K) {
        const WILD: [f32; 14] = [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            1e-45,
            -1e-40,
            f32::MIN_POSITIVE,
            f32::MAX,
            f32::MIN,
            0.0,
            -0.0,
            1.0,
            -1.0,
            1e20,
            1e-20,
        ];
        let columns: [Vec<f32>; I] =
            std::array::from_fn(|seed| (0..196).map(|i| WILD[(i / [1, 14][seed % 2] + seed) % 14]).collect());
        for level in Level::available() {
            run::<K, I, O>(level, &kernel, &columns, 0..196);
        }
    }
}

#[test]
fn no_number_makes_a_kernel_panic() {
    every_kernel(&Wild);
}

struct Mismatched;
impl Check for Mismatched {
    fn check<K: Kernel<I, O>, const I: usize, const O: usize>(&self, name: &str, kernel: K) {
        let numbers = column(0, 21);
        for slice in 1..I + O {
            for found in [0, 19, 21] {
                let length = |i: usize| if i == slice { found } else { 20 };
                let mut outputs: [Vec<f32>; O] = std::array::from_fn(|o| vec![-7.0; length(I + o)]);
                let inputs = std::array::from_fn(|i| &numbers[..length(i)]);
                let result = batch::map(&kernel, inputs, outputs.each_mut().map(Vec::as_mut_slice));
                assert_eq!(result, Err(LengthError { expected: 20, found, slice }), "{name}");
                assert!(outputs.iter().flatten().all(|x| *x == -7.0), "{name} wrote with slice {slice} of {found}");
            }
        }
    }
}

#[test]
fn slices_of_different_lengths_are_refused_and_nothing_is_written() {
    every_kernel(&Mismatched);
    let error = LengthError { expected: 20, found: 3, slice: 2 };
    assert_eq!(error.to_string(), "slice 2 has 3 numbers, but the first input has 20");
}

#[cfg(feature = "rayon")]
struct Parallel;
#[cfg(feature = "rayon")]
impl Check for Parallel {
    fn check<K: Kernel<I, O>, const I: usize, const O: usize>(&self, name: &str, kernel: K) {
        let count = 3 * batch::GRAIN + 41;
        let columns: [Vec<f32>; I] = std::array::from_fn(|seed| column(seed, count));
        let serial = run::<K, I, O>(Level::detect(), &kernel, &columns, 0..count);
        let mut outputs: [Vec<f32>; O] = std::array::from_fn(|_| vec![f32::NAN; count]);
        let inputs = columns.each_ref().map(Vec::as_slice);
        batch::par_map(&kernel, inputs, outputs.each_mut().map(Vec::as_mut_slice)).expect("slices of one length");
        for (parallel, serial) in outputs.iter().zip(&serial) {
            assert!(same_bits(parallel, serial), "{name}");
        }
        outputs[0].pop();
        let result = batch::par_map(&kernel, inputs, outputs.each_mut().map(Vec::as_mut_slice));
        assert_eq!(result, Err(LengthError { expected: count, found: count - 1, slice: I }), "{name}");
    }
}

#[cfg(feature = "rayon")]
#[test]
fn threads_change_no_bit() {
    every_kernel(&Parallel);
}

/// The largest error of a kernel's results at every level, in ULP of f32, against the function over f64.
fn worst<K: Kernel<I, O>, const I: usize, const O: usize>(
    kernel: K,
    columns: &[Vec<f32>; I],
    exact: impl Fn([f64; I]) -> [f64; O],
) -> f64 {
    let mut worst = 0.0f64;
    for level in Level::available() {
        let results = run::<K, I, O>(level, &kernel, columns, 0..columns[0].len());
        for i in 0..columns[0].len() {
            let want = exact(columns.each_ref().map(|column| f64::from(column[i])));
            for (result, want) in results.iter().zip(want) {
                let ulp = f64::from((want.abs() as f32).next_up() - want.abs() as f32);
                let error = (f64::from(result[i]) - want).abs() / ulp;
                // The exponent's limit, 87 in f32.
                if want.abs() > 1e-29 || result[i] != 0.0 {
                    worst = if error.is_nan() { f64::INFINITY } else { worst.max(error) };
                }
            }
        }
    }
    worst
}

/// The limits are those of `docs/accuracy.md`, which measures each term at the level that is detected; here every level.
#[test]
fn every_level_keeps_the_limits() {
    let count = 20_000;
    let cosine = [column(1, count)];
    let unit = |seed: usize| {
        let (turn, cos) = (column(seed, count), column(seed + 5, count));
        let direction =
            |i: usize| Vector::<f32>::from_angles(f64::from(cos[i]).acos(), std::f64::consts::TAU * f64::from(turn[i]));
        (0..count).map(direction).collect::<Vec<_>>()
    };
    let (first, second) = (unit(2), unit(9));
    let parts = |v: &[Vector<f32>]| [0, 1, 2].map(|axis| v.iter().map(|v| [v.x, v.y, v.z][axis]).collect::<Vec<f32>>());
    let [[ix, iy, iz], [ox, oy, oz]] = [parts(&first), parts(&second)];
    let half = [ix.clone(), iy.clone(), iz.clone()];
    let pair = [ix, iy, iz, ox, oy, oz];
    let wi = |a: &[f64]| Vector::new(a[0], a[1], a[2]);
    let wo = |a: &[f64]| Vector::new(a[3], a[4], a[5]);
    let split = |f: fresnel::Fresnel<f64>| [f.reflectance, f.transmittance];
    // Parameters that f32 holds exactly.
    let (eta, n, k, alpha, beta) = (1.5, 0.25, 2.5, 0.375, 0.125);
    for (name, found, limit) in [
        ("dielectric", worst(terms::Dielectric { eta: 1.5 }, &cosine, |[c]| split(fresnel::dielectric(c, eta))), 8.0),
        (
            "conductor",
            worst(terms::Conductor { n: 0.25, k: 2.5 }, &cosine, |[c]| split(fresnel::conductor(c, n, k))),
            8.0,
        ),
        ("schlick", worst(terms::Schlick { f0: 0.25 }, &cosine, |[c]| split(fresnel::schlick(c, n))), 4.0),
        ("beckmann", worst(terms::Beckmann { alpha: 0.375 }, &half, |a| [distribution::beckmann(wi(&a), alpha)]), 8.0),
        ("ggx", worst(terms::Ggx { alpha: 0.375 }, &half, |a| [distribution::ggx(wi(&a), alpha)]), 6.0),
        (
            "smith_ggx",
            worst(terms::SmithGgx { alpha_x: 0.375, alpha_y: 0.125 }, &pair, |a| {
                let m = masking::smith_ggx(wi(&a), wo(&a), alpha, beta);
                [m.g, m.visibility]
            }),
            4.0,
        ),
        (
            "smith_beckmann",
            worst(terms::SmithBeckmann { alpha_x: 0.375, alpha_y: 0.125 }, &pair, |a| {
                let m = masking::smith_beckmann(wi(&a), wo(&a), alpha, beta);
                [m.g, m.visibility]
            }),
            4.0,
        ),
        (
            "refract_about",
            worst(terms::RefractAbout { eta: 1.5 }, &pair, |a| refraction::refract_about(wi(&a), wo(&a), eta).into()),
            4.0,
        ),
        ("phong", worst(terms::Phong { exponent: 40.0 }, &pair, |a| [phong::phong(wi(&a), wo(&a), 40.0)]), 16.0),
        (
            "facets",
            worst(terms::Facets { alpha: 0.375 }, &pair, |a| {
                let f = microfacet::facets(wi(&a), wo(&a), alpha);
                [f.lobe, f.d, f.g]
            }),
            32.0,
        ),
        (
            "torrance_sparrow",
            worst(terms::TorranceSparrow { n: [0.25, 1.5], k: [2.5, 0.0], alpha: 0.375 }, &pair, |a| {
                [(0.25, 2.5), (1.5, 0.0)].map(|(n, k)| microfacet::torrance_sparrow(wi(&a), wo(&a), n, k, alpha).f)
            }),
            32.0,
        ),
    ] {
        println!("{name:20} {found:.2}");
        assert!(found <= limit, "{name}: {found} ULP, the limit is {limit}");
    }
}

/// A kernel of a user's own.
struct UnitCircle;

impl Kernel<1, 2> for UnitCircle {
    #[inline(always)]
    fn evaluate<R: Real<Wide = R>>(&self, [turns]: [R; 1]) -> [R; 2] {
        let (cosine, sine) = turns.unit_circle();
        [cosine, sine]
    }
}

#[test]
fn the_unit_circle_is_the_same_at_every_level() {
    // Eighths, where one quarter's series ends and the next one's begins; the ends and what lies beyond them.
    let steps = 40_000;
    let within = (0..=steps).map(|i| i as f32 / steps as f32);
    let columns = [within.chain((0..=8).map(|i| i as f32 / 8.0)).chain([-1.0, 2.0, f32::NAN]).collect::<Vec<f32>>()];
    for level in Level::available() {
        let [cosines, sines] = run(level, &UnitCircle, &columns, 0..columns[0].len());
        for ((turn, cosine), sine) in columns[0].iter().zip(cosines).zip(sines) {
            // NaN counts as 0, and turns are clamped.
            let (c, s) = f64::from(turn.saturate()).unit_circle();
            for (got, want) in [(cosine, c), (sine, s)] {
                let ulp = f64::from(f32::EPSILON) * want.abs().max(f64::from(f32::MIN_POSITIVE));
                assert!((f64::from(got) - want).abs() <= 3.0 * ulp, "{turn} at {}: {got}, {want}", level.name());
            }
        }
    }
}

#[test]
fn levels_are_listed_from_the_baseline_to_the_fastest() {
    let levels: Vec<Level> = Level::available().collect();
    assert_eq!(levels[0], Level::BASELINE);
    assert_eq!(levels.last(), Some(&Level::detect()));
    assert!(levels.is_sorted());
    println!("{:?}", levels.iter().map(|level| level.name()).collect::<Vec<_>>());
}
