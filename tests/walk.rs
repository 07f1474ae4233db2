//! The random walk is right: nine validations, each against something that is known without it.
//!
//! Statistical comparisons are z-tests with fixed seeds, so a run either always passes or always fails. [`LIMIT`] is
//! chosen so that an honest estimator under a fresh set of seeds would fail any of them with a chance below 1e-3.
#![cfg(feature = "std")]

use brdf::layered::{Interface, Layer, Medium, Model, Stack, conserving};
use brdf::walk::{self, Estimate, Microsurface, Options, Technique};
use brdf::{Vector, absorption, diffuse, fresnel, microfacet, refraction};
use std::f64::consts::{FRAC_1_PI, PI};

/// Standard errors that an estimate may be off: P(|z| > 4.7) = 2.6e-6, times fewer than 350 comparisons in this file.
const LIMIT: f64 = 4.7;

type Direction = Vector<f64>;

fn direction(theta: f64, phi: f64) -> Direction {
    Vector::from_angles(theta.to_radians(), phi.to_radians())
}

/// Pairs of light and viewer: oblique, across, close to the mirror, grazing, both at the normal.
fn pairs() -> [(Direction, Direction); 5] {
    [
        (direction(20.0, 0.0), direction(50.0, 100.0)),
        (direction(65.0, 30.0), direction(10.0, 0.0)),
        (direction(40.0, 0.0), direction(36.0, 185.0)),
        (direction(80.0, 0.0), direction(70.0, 170.0)),
        (direction(0.0, 0.0), direction(0.0, 0.0)),
    ]
}

fn stack<const C: usize>(layers: Vec<Layer<f64, C>>) -> Stack<f64, C> {
    Stack::new(Model::Conserving, layers).unwrap()
}

fn coat<const C: usize>(n: f64, alpha: f64) -> Layer<f64, C> {
    Layer::new(Interface::dielectric(n, alpha))
}

fn copper(alpha: f64) -> Layer<f64, 3> {
    Layer::new(Interface::conductor([0.213, 1.04, 1.17], [4.05, 2.59, 2.36], alpha))
}

/// This many walks; a quarter of them without optimisation, where each takes ten times as long.
fn options(samples: u32, seed: u32) -> Options {
    let samples = if cfg!(debug_assertions) { samples.div_ceil(4) } else { samples };
    Options { samples, seed, ..Options::default() }
}

/// The largest distance of an estimate from exact values, in standard errors after `slack` is forgiven.
fn off<const C: usize>(estimate: &Estimate<C>, want: [f64; C], slack: f64) -> f64 {
    let excess = |c: usize| ((estimate.mean[c] - want[c]).abs() - slack * want[c].abs()).max(0.0);
    (0..C).map(|c| excess(c) / estimate.standard_error[c].max(1e-12)).fold(0.0, f64::max)
}

/// The largest distance of two independent estimates in their common standard errors.
fn apart<const C: usize>(a: &Estimate<C>, b: &Estimate<C>) -> f64 {
    (0..C)
        .map(|c| (a.mean[c] - b.mean[c]).abs() / a.standard_error[c].hypot(b.standard_error[c]).max(1e-12))
        .fold(0.0, f64::max)
}

#[track_caller]
fn assert_known<const C: usize>(what: &str, estimate: &Estimate<C>, want: [f64; C], slack: f64) {
    let z = off(estimate, want, slack);
    assert!(z <= LIMIT, "{what}: {estimate:?}, want {want:?}: {z:.1} standard errors off");
}

/// Σ over the midpoints of [0, 1] cut into `n`.
fn midpoints(n: u32, f: impl Fn(f64) -> f64) -> f64 {
    (0..n).map(|i| f((f64::from(i) + 0.5) / f64::from(n))).sum::<f64>() / f64::from(n)
}

/// 1. An interface between equal indices does nothing, and one between nearly equal indices next to nothing.
#[test]
fn a_coat_of_index_one_leaves_the_base() {
    let bases: [Layer<f64, 3>; 3] = [
        Layer::new(Interface::diffuse([0.9, 0.5, 0.0], 0.0)),
        Layer::new(Interface::diffuse([0.9, 0.5, 0.2], 0.5)),
        copper(0.3),
    ];
    for (index, base) in bases.into_iter().enumerate() {
        let matched = stack(vec![coat(1.0, 0.3).over([0.0, 0.1, 1.0], 0.5), base]);
        let close = stack(vec![coat(1.001, 1e-3), base]);
        for (wi, wo) in pairs() {
            let bare = conserving(&[base], wi, wo);
            let absorbed = [0.0, 0.1, 1.0].map(|sigma| absorption::transmittance(sigma, 0.5, wi.z, wo.z));
            let estimate = walk::evaluate(&matched, wi, wo, &options(2, 1));
            for c in 0..3 {
                // Ten products and quotients.
                let want = bare[c] * absorbed[c];
                assert!((estimate.mean[c] - want).abs() <= 10.0 * f64::EPSILON * want, "{estimate:?} {want}");
            }
            // What the conserving model leaves out here, bounces, is of the order F(80°) = 3e-4 at n = 1.001. And what it
            // adds to the mirror image in the coat tends to the base: a bend of .001·tan 70° turns the slope of the half
            // vector by .0014, which moves D at α = .3 by 2·.0014·tanθ/α², 3 % at a slope of 1.
            let estimate = walk::evaluate(&close, wi, wo, &options(4096, 10 + index as u32));
            let almost = close.evaluate(wi, wo);
            assert_known("n = 1.001", &estimate, almost, 1e-3);
            if wi.z.min(wo.z) > 0.3 {
                let image = conserving(&close.layers()[..1], wi, wo);
                for c in 0..3 {
                    assert!((almost[c] - image[c] - bare[c]).abs() <= 0.03 * bare[c] + 1e-12, "{almost:?} {bare:?}");
                }
            }
        }
    }
}

/// 2. Over a black base, or under a layer that lets nothing through, only the top interface reflects.
#[test]
fn a_black_base_leaves_the_top_interface() {
    for alpha in [1e-4, 0.1, 0.5] {
        let top = coat::<1>(1.5, alpha);
        let black = stack(vec![top, Layer::new(Interface::diffuse([0.0], 0.3))]);
        let thick = stack(vec![top.over([100.0], 5.0), Layer::new(Interface::conductor([0.2], [4.0], 0.1))]);
        for (wi, wo) in pairs() {
            let want = conserving(&[top], wi, wo);
            let single = microfacet::torrance_sparrow(wi, wo, 1.5, 0.0, alpha).f;
            assert!((want[0] - single).abs() <= 1e-13 * single);
            for stack in [&black, &thick] {
                let estimate = walk::evaluate(stack, wi, wo, &options(512, 2));
                // e^−1000 is 0; the two sides are the same products in another order.
                assert!((estimate.mean[0] - want[0]).abs() <= 1e-13 * want[0], "{estimate:?} {want:?}");
            }
        }
    }
}

/// The transmittance of a smooth interface of index n and of the layer under it, for one direction.
fn smooth_transmittance(cos: f64, n: f64, tau: f64) -> f64 {
    fresnel::dielectric(cos, n).transmittance * (-tau / refraction::cos_t(cos, n)).exp()
}

/// r_i(τ) = 2∫ R_in(μ)·e^(−2τ/μ)·μ dμ, the internal reflectance of a smooth interface for Lambertian light.
fn internal_reflectance(n: f64, tau: f64) -> f64 {
    // Split at the critical angle, where R_in has a root: u² as the distance to it.
    let critical = (1.0 - 1.0 / (n * n)).sqrt();
    let at = |mu: f64| fresnel::dielectric(mu, 1.0 / n).reflectance * (-2.0 * tau / mu).exp() * mu;
    let below = midpoints(4000, |u| at(critical * u) * critical);
    let above = midpoints(4000, |u| at(critical + (1.0 - critical) * u * u) * 2.0 * u * (1.0 - critical));
    2.0 * (below + above)
}

#[test]
fn internal_reflectances_are_the_published_ones() {
    for (n, want) in [(1.3, 0.444), (1.4, 0.529), (1.5, 0.59635), (1.6, 0.651), (1.8, 0.733), (2.0, 0.790)] {
        assert!((internal_reflectance(n, 0.0) - want).abs() < 5e-4, "{n}: {}", internal_reflectance(n, 0.0));
    }
    for (tau, want) in [(0.1, 0.382), (0.2, 0.258), (0.5, 0.090)] {
        assert!((internal_reflectance(1.5, tau) - want).abs() < 1e-3, "{tau}: {}", internal_reflectance(1.5, tau));
    }
}

/// 3. A smooth coat over a Lambert base: f₁ + T(L)·T(V)·ρ/(πn²(1 − ρ·r_i)), with absorption.
#[test]
fn smooth_coat_over_lambert_is_the_closed_form() {
    let (sigma, rho, thickness) = ([0.0, 0.2, 1.0], [0.5, 1.0, 0.8], 0.5);
    for (index, n) in [1.3, 1.5, 2.0].into_iter().enumerate() {
        let top = coat(n, 1e-4).over(sigma, thickness);
        let whole = stack(vec![top, Layer::new(Interface::diffuse(rho, 0.0))]);
        for (pair, (wi, wo)) in pairs().into_iter().enumerate() {
            let first = conserving(&[top], wi, wo);
            let want = std::array::from_fn(|c| {
                let tau = sigma[c] * thickness;
                let through = smooth_transmittance(wi.z, n, tau) * smooth_transmittance(wo.z, n, tau);
                let r_i = internal_reflectance(n, tau);
                first[c] + through * rho[c] * FRAC_1_PI / (n * n * (1.0 - rho[c] * r_i))
            });
            let estimate = walk::evaluate(&whole, wi, wo, &options(16_384, (10 * index + pair) as u32));
            // α = 1e-4 stands for 0: its effect is of second order, 1e-8·tan²θ; midpoints are good to 1e-6.
            assert_known(&format!("n = {n}"), &estimate, want, 3e-6);
        }
    }
}

/// What a rough interface transmits and reflects of light from one side, by quadrature over its normals under D·cos: the
/// integrals ∫ T·G2·(a·m)·D/a_z dm and ∫ F·G2·(a·m)·D/a_z dm under V-cavities, written without the walk's code.
fn rough_split(a: Direction, n_a: f64, n_b: f64, alpha: f64, grid: u32) -> [f64; 2] {
    let eta = n_b / n_a;
    let part = |w: Direction, m: Direction| (2.0 * m.z * w.z.abs() / w.dot(m).abs()).min(1.0);
    let mut sums = [0.0; 2];
    for i in 0..grid {
        for j in 0..grid {
            let [u, v] = [i, j].map(|k| (f64::from(k) + 0.5) / f64::from(grid));
            let slope = alpha * (-(1.0 - u).ln()).sqrt();
            let (sin, cos) = (PI * v).sin_cos();
            let m = Vector::new(slope * cos, slope * sin, 1.0).normalized();
            let facing = a.dot(m);
            if facing <= 0.0 {
                continue;
            }
            let weight = facing / (a.z * m.z);
            let split = fresnel::dielectric(facing, eta);
            let mirrored = m * (2.0 * facing) - a;
            if mirrored.z > 0.0 {
                sums[1] += weight * split.reflectance * part(a, m).min(part(mirrored, m));
            }
            let inside = 1.0 - (1.0 - facing * facing) / (eta * eta);
            if inside > 0.0 {
                let through = m * (facing / eta - inside.sqrt()) - a * (1.0 / eta);
                if through.z < 0.0 {
                    sums[0] += weight * split.transmittance * (part(a, m) + part(through, m) - 1.0).max(0.0);
                }
            }
        }
    }
    sums.map(|sum| sum / f64::from(grid * grid))
}

/// 4. A rough coat over a Lambert base: the same with the transmitted albedo E_T and the reflectance r_i of the rough one.
#[test]
fn rough_coat_over_lambert_is_the_closed_form() {
    let (n, rho) = (1.5, [0.5, 1.0]);
    for (index, alpha) in [0.1, 0.3, 0.6].into_iter().enumerate() {
        let top = coat(n, alpha);
        let whole = stack(vec![top, Layer::new(Interface::diffuse(rho, 0.0))]);
        let r_i = midpoints(48, |u| {
            let sin = (1.0 - u).sqrt();
            rough_split(Vector::new(sin, 0.0, u.sqrt()), n, 1.0, alpha, 40)[1]
        });
        for (pair, (wi, wo)) in pairs().into_iter().enumerate() {
            let e = |w: Direction| {
                // In the plane of w the integrand is even in the other axis, so half a turn is enough.
                rough_split(Vector::new((1.0 - w.z * w.z).sqrt(), 0.0, w.z), 1.0, n, alpha, 96)[0]
            };
            let first = conserving(&[top], wi, wo);
            let through = e(wi) * e(wo) * FRAC_1_PI / (n * n);
            let want = std::array::from_fn(|c| first[c] + through * rho[c] / (1.0 - rho[c] * r_i));
            let estimate = walk::evaluate(&whole, wi, wo, &options(16_384, (100 + 10 * index + pair) as u32));
            // The quadrature: doubling all three grids moves the closed form by less than 1e-3 (α = .6).
            assert_known(&format!("alpha {alpha}"), &estimate, want, 1e-3);
        }
    }
}

/// 5. A smooth coat over a smooth conductor: F1 + T1²·F2·a/(1 − F1·F2·a) with a = e^(−2τ/μ).
#[test]
fn smooth_conductors_give_the_geometric_series() {
    let (sigma, thickness) = ([0.0, 0.3, 1.5], 0.4);
    let whole = stack(vec![coat(1.5, 1e-4).over(sigma, thickness), copper(1e-4)]);
    for (index, theta) in [0.0, 45.0, 75.0, 85.0].into_iter().enumerate() {
        let wo = direction(theta, 20.0);
        let outer = fresnel::dielectric(wo.z, 1.5);
        let inside = refraction::cos_t(wo.z, 1.5);
        let metal = |c: usize| ([0.213, 1.04, 1.17][c] / 1.5, [4.05, 2.59, 2.36][c] / 1.5);
        let want = std::array::from_fn(|c| {
            let (n, k) = metal(c);
            let back = fresnel::conductor(inside, n, k).reflectance * (-2.0 * sigma[c] * thickness / inside).exp();
            outer.reflectance + outer.transmittance * outer.transmittance * back / (1.0 - outer.reflectance * back)
        });
        let estimate = walk::albedo(&whole, wo, &options(16_384, 200 + index as u32));
        // α = 1e-4 stands for 0: α²·tan²85° = 1.3e-6.
        assert_known(&format!("{theta}°"), &estimate, want, 2e-6);
    }
}

/// Stacks without a closed form: metal, oxide, varnish, and three interfaces.
fn hard_stacks() -> [(&'static str, Stack<f64, 3>); 4] {
    let oxide = Interface::conductor([2.83, 2.83, 2.83], [0.083, 0.19, 0.6], 0.3);
    [
        ("coat over copper", stack(vec![coat(1.5, 0.2).over([0.0, 0.1, 0.8], 0.5), copper(0.3)])),
        ("varnish", stack(vec![coat(1.5, 0.3), Layer::new(Interface::diffuse([0.9, 0.5, 0.2], 0.5))])),
        ("oxide", stack(vec![Layer::new(oxide).over([0.0, 0.2, 0.5], 0.3), copper(0.4)])),
        ("lacquer", stack(vec![coat(1.3, 0.2), coat(1.7, 0.3).over([0.0, 0.2, 0.5], 0.3), copper(0.4)])),
    ]
}

/// The largest distance of one technique from another over the hard stacks.
fn disagreement(a: Technique, b: Technique, samples: u32, mut report: impl FnMut(&str, f64)) {
    for (index, (name, stack)) in hard_stacks().into_iter().enumerate() {
        for (pair, (wi, wo)) in pairs().into_iter().enumerate() {
            let run =
                |technique, seed| walk::evaluate(&stack, wi, wo, &Options { technique, ..options(samples, seed) });
            let seed = (1000 + 10 * index + pair) as u32;
            let (one, other) = (run(a, seed), run(b, seed + 500));
            report(&format!("{name}, pair {pair}: {a:?} {one:?}, {b:?} {other:?}"), apart(&one, &other));
        }
    }
}

/// 6. Connections to the light alone find the same mean as both techniques together.
#[test]
fn next_event_alone_agrees() {
    disagreement(Technique::Both, Technique::NextEvent, 8192, |what, z| assert!(z <= LIMIT, "{what}: {z:.1}"));
}

/// 7. So do sampled paths alone.
#[test]
fn sampling_alone_agrees() {
    disagreement(Technique::Both, Technique::Sampling, 8192, |what, z| assert!(z <= LIMIT, "{what}: {z:.1}"));
}

/// These tests would find the known defect: the outer direction's density in the weight of a sampled path.
#[test]
fn the_outer_density_is_found_out() {
    let mut worst = 0.0f64;
    disagreement(Technique::NextEvent, Technique::OuterDensity, 8192, |_, z| worst = worst.max(z));
    assert!(worst > 2.0 * LIMIT, "the defect shows at {worst:.1} standard errors only");
    // And so would the closed form of a rough coat over Lambert, which the honest walk meets.
    let whole = stack(vec![coat(1.5, 0.3), Layer::new(Interface::diffuse([1.0], 0.0))]);
    let mut worst = 0.0f64;
    for (index, (wi, wo)) in pairs().into_iter().enumerate() {
        let right = walk::evaluate(&whole, wi, wo, &options(16_384, 7));
        let technique = Technique::OuterDensity;
        let wrong = walk::evaluate(&whole, wi, wo, &Options { technique, ..options(16_384, 8 + index as u32) });
        worst = worst.max(apart(&right, &wrong));
    }
    assert!(worst > LIMIT, "the defect shows at {worst:.1} standard errors only");
}

/// 8. Light and viewer may be exchanged.
#[test]
fn the_walk_is_reciprocal() {
    for (index, (name, stack)) in hard_stacks().into_iter().enumerate() {
        for (pair, (wi, wo)) in pairs().into_iter().enumerate() {
            let seed = (2000 + 10 * index + pair) as u32;
            let (there, back) = (
                walk::evaluate(&stack, wi, wo, &options(8192, seed)),
                walk::evaluate(&stack, wo, wi, &options(8192, seed + 500)),
            );
            let z = apart(&there, &back);
            assert!(z <= LIMIT, "{name}, pair {pair}: {there:?} {back:?}: {z:.1}");
        }
    }
}

/// 9. Cutting a layer in two by an interface between equal indices changes nothing; nearly equal ones, next to nothing.
#[test]
fn splitting_a_layer_changes_nothing() {
    let sigma = [0.0, 0.3, 1.0];
    let whole = stack(vec![coat(1.5, 0.2).over(sigma, 0.6), copper(0.3)]);
    let split =
        |n: f64, alpha| stack(vec![coat(1.5, 0.2).over(sigma, 0.2), coat(n, alpha).over(sigma, 0.4), copper(0.3)]);
    for (pair, (wi, wo)) in pairs().into_iter().enumerate() {
        let seed = 3000 + pair as u32;
        let want = walk::evaluate(&whole, wi, wo, &options(8192, seed));
        let same = walk::evaluate(&split(1.5, 0.4), wi, wo, &options(8192, seed));
        for c in 0..3 {
            // The same walks; σ·(.2 + .4) and σ·.6 differ by an ULP.
            assert!((want.mean[c] - same.mean[c]).abs() <= 1e-13 * want.mean[c], "{want:?} {same:?}");
        }
        // An interface of its own, which reflects 1e-11 and bends by 1e-5: the general case of three interfaces.
        let almost = walk::evaluate(&split(1.500_01, 0.01), wi, wo, &options(16_384, seed + 500));
        let z = apart(&want, &almost);
        assert!(z <= LIMIT, "pair {pair}: {want:?} {almost:?}: {z:.1}");
    }
}

/// LAYERED's truth tables, printed to three digits from walks of their own.
#[test]
fn the_truth_tables_are_reproduced() {
    let diffuse = stack(vec![coat::<1>(1.5, 0.1), Layer::new(Interface::diffuse([0.5], 0.0))]);
    let metal = stack(vec![coat::<1>(1.5, 0.1), Layer::new(Interface::conductor([0.213], [4.05], 0.1))]);
    for (stack, wants) in [(diffuse, [0.316, 0.351, 0.503]), (metal, [0.933, 0.839, 0.777])] {
        for (theta, want) in [0.0, 60.0, 80.0].into_iter().zip(wants) {
            for microsurface in [Microsurface::VCavities, Microsurface::SmithBeckmann] {
                let options = Options { microsurface, ..options(16_384, 5) };
                let estimate = walk::albedo(&stack, direction(theta, 0.0), &options);
                // Half of the last digit, and three standard errors of both: the table's own is .1 % (90 000 walks).
                let limit = 5e-4 + 3.0 * estimate.standard_error[0].hypot(1e-3 * want);
                assert!(
                    (estimate.mean[0] - want).abs() <= limit,
                    "{microsurface:?} {theta}°: {estimate:?}, want {want}"
                );
            }
        }
    }
}

/// The albedo is the integral of the BRDF: walks that leave the stack against walks that end at the light.
#[test]
fn the_albedo_is_the_integral() {
    for (index, (name, stack)) in hard_stacks().into_iter().enumerate() {
        let wo = direction(50.0, 0.0);
        let direct = walk::albedo(&stack, wo, &options(16_384, 4000 + index as u32));
        // ∫ f·cos dω over cosine-distributed light: π·mean of f, each from a few walks of its own.
        let count = 2048u32;
        let (mut sum, mut squares) = ([0.0; 3], [0.0; 3]);
        for light in 0..count {
            let [u, v, ..] = walk::random::random::<f64>(91, light, index as u32);
            let wi = Vector::from_angles(u.sqrt().asin(), 2.0 * PI * v);
            let f = walk::evaluate(&stack, wi, wo, &Options { threads: 1, samples: 4, ..options(0, light) }).mean;
            for c in 0..3 {
                sum[c] += PI * f[c];
                squares[c] += (PI * f[c]).powi(2);
            }
        }
        let n = f64::from(count);
        let mean = sum.map(|sum| sum / n);
        let integral = Estimate {
            mean,
            standard_error: std::array::from_fn(|c| ((squares[c] / n - mean[c] * mean[c]) / (n - 1.0)).sqrt()),
            samples: count,
        };
        let z = apart(&direct, &integral);
        assert!(z <= LIMIT, "{name}: {direct:?} {integral:?}: {z:.1}");
    }
}

/// A dispersing stack is three stacks of one channel.
#[test]
fn dispersing_channels_walk_alone() {
    let (n, k, sigma) = ([1.4, 1.5, 1.6], [0.0, 0.01, 0.1], [0.1, 0.2, 0.3]);
    let base = Interface::diffuse([0.9, 0.5, 0.2], 0.3);
    let whole = stack(vec![Layer::new(Interface::conductor(n, k, 0.2)).over(sigma, 0.5), Layer::new(base)]);
    let (wi, wo) = pairs()[0];
    let together = walk::evaluate(&whole, wi, wo, &options(512, 3));
    for c in 0..3 {
        let base = Interface::diffuse([[0.9, 0.5, 0.2][c]], 0.3);
        let one =
            stack(vec![Layer::new(Interface::conductor([n[c]], [k[c]], 0.2)).over([sigma[c]], 0.5), Layer::new(base)]);
        let alone = walk::evaluate(&one, wi, wo, &options(512, 3));
        assert_eq!((together.mean[c], together.standard_error[c]), (alone.mean[0], alone.standard_error[0]));
    }
}

#[test]
fn results_do_not_depend_on_threads() {
    let (_, stack) = &hard_stacks()[3];
    let (wi, wo) = pairs()[1];
    let run = |threads| {
        let options = Options { threads, samples: 5000, ..options(0, 9) };
        (walk::evaluate(stack, wi, wo, &options), walk::albedo(stack, wo, &options))
    };
    let one = run(1);
    assert_eq!(one, run(2));
    assert_eq!(one, run(7));
    assert_eq!(one, run(0));
    // The mean of single walks is the estimate.
    let sum: f64 = (0..5000).map(|index| walk::sample(stack.layers(), 0, wi, wo, 9, index)).sum();
    let same = walk::evaluate(
        &Stack::<f64, 1>::new(Model::Conserving, only_first(stack)).unwrap(),
        wi,
        wo,
        &Options { samples: 5000, ..options(0, 9) },
    );
    assert!((sum / 5000.0 / same.mean[0] - 1.0).abs() < 1e-12);
}

/// The first channel of a stack.
fn only_first(stack: &Stack<f64, 3>) -> Vec<Layer<f64, 1>> {
    let one = |layer: &Layer<f64, 3>| Layer {
        interface: match layer.interface {
            Interface::Microfacet { n, k, alpha } => Interface::Microfacet { n: [n[0]], k: [k[0]], alpha },
            Interface::Diffuse { albedo, sigma } => Interface::Diffuse { albedo: [albedo[0]], sigma },
        },
        medium: Medium { sigma: [layer.medium.sigma[0]], thickness: layer.medium.thickness },
    };
    stack.layers().iter().map(one).collect()
}

/// Whatever the directions and the stack: finite, not negative, albedo at most 1.
#[test]
fn corners_are_finite() {
    let gain = Interface::conductor([0.02, 8.0, 1.0], [12.0, 0.0, 1e-9], 1.0);
    let mut stacks: Vec<Stack<f64, 3>> = hard_stacks().into_iter().map(|(_, stack)| stack).collect();
    stacks.extend(brdf::material::stack::built_in().into_iter().map(|material| material.stack));
    stacks.push(stack(vec![Layer::new(gain).over([0.0, 1e300, 1.0], 1e300), Layer::new(gain), copper(1e-4)]));
    stacks.push(stack(vec![
        coat(1.5, 1e-4),
        coat(1.0, 1.0),
        coat(3.0, 1.0),
        Layer::new(Interface::diffuse([1.0; 3], 1.5)),
    ]));
    stacks.push(stack(vec![Layer::new(Interface::conductor([1.0; 3], [0.0, 0.1, 1.0], 0.3)), copper(0.1)]));
    let zs = [1.0, 0.999_999_9, 0.5, 1e-3, 1e-7, 1e-16, 0.0, -0.5];
    for stack in &stacks {
        for z in zs {
            let wo = Vector::new((1.0f64 - z * z).max(0.0).sqrt(), 0.0, z);
            let options = Options { threads: 1, ..options(32, 3) };
            let albedo = walk::albedo(stack, wo, &options);
            for other in zs {
                let wi = Vector::new(-(1.0f64 - other * other).max(0.0).sqrt(), 0.0, other);
                let f = walk::evaluate(stack, wi, wo, &options);
                let fine = f.mean.iter().chain(&f.standard_error).all(|f| f.is_finite() && *f >= 0.0);
                assert!(fine, "{stack:?} {wi:?} {wo:?} {f:?}");
                assert!(z.min(other) > 0.0 || f.mean == [0.0; 3]);
            }
            // Oren & Nayar's model itself reflects up to 1.051; with 32 walks the spread is wide.
            let limit = |c: usize| 1.06 + 6.0 * albedo.standard_error[c];
            assert!((0..3).all(|c| (0.0..=limit(c)).contains(&albedo.mean[c])), "{stack:?} {wo:?} {albedo:?}");
        }
    }
    // A Lambert base alone, which the walk does not sample at all.
    let bare = stack(vec![Layer::new(Interface::diffuse([0.5; 3], 0.0))]);
    let (wi, wo) = pairs()[0];
    assert_eq!(walk::evaluate(&bare, wi, wo, &options(2, 1)).mean, [diffuse::lambert(0.5); 3]);
}
