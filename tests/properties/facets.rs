//! Distributions, masking, and the energy of single interfaces.

use super::*;

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
