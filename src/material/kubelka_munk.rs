//! A film that scatters and absorbs, over a ground: what makes patina, rust and pigmented paint look diffuse.
//!
//! Twin: `wgsl/kubelka_munk.wgsl`. Kubelka and Munk's two diffuse fluxes, one down and one up, lose K·dx to absorption and
//! exchange S·dx by scattering. Their reflectance is that of the film *without* a boundary; as the albedo of a Lambert base
//! under a dielectric interface in [`Model::Coupled`](crate::layered::Model), whose light bounces between the two, it is
//! what Saunderson's correction gives.

use crate::real::Real;

/// The reflectance of a film of a thickness X over a ground.
///
/// $$\rho = \frac{1 - R_g(A - B\coth BSX)}{A - R_g + B\coth BSX},\quad A = 1 + K/S,\; B = \sqrt{A^2-1}$$
///
/// In plain text: ρ = (1−R_g(A−B·coth BSX))/(A−R_g+B·coth BSX), A = 1+K/S, B = √(A²−1).
///
/// Computed as the mean of R∞ = A−B and R_g with the weights w and e^(−2BSX), w = (γ+K+(1−R_g)S)·(1−e^(−2γX))/(2γ) and
/// γ = BS = √(K(K+2S)), in which nothing cancels and nothing overflows: it lies between the two in every precision.
///
/// * `absorption` K ≥ 0 and `scattering` S ≥ 0 in 1/length, `thickness` X ≥ 0 in length, `ground` R_g in [0, 1].
///
/// X = 0: R_g. S = 0: R_g·exp(−2KX). K = 0: (R_g+(1−R_g)SX)/(1+(1−R_g)SX). X → ∞: R∞ = A−B. The ground counts as hidden
/// where 2γX > 87 (f32) or 708 (f64). It rises with S and R_g, falls with K, and films add up: over a ground that is
/// itself a film, X₁ over X₂, it is that of X₁+X₂.
///
/// Error in f32: ≤ 0.6 ULP; in f64 ≤ (6 + 4γX)·2⁻⁵² relative, against 60 digits. Source: Kubelka 1948, eq. 16.
#[inline]
pub fn film<R: Real>(absorption: R, scattering: R, thickness: R, ground: R) -> R {
    let wide = film_wide::<_, R>(absorption.widen(), scattering.widen(), thickness.widen(), ground.widen());
    R::narrow(wide)
}

#[inline(always)]
fn film_wide<W: Real, R: Real<Wide = W>>(k: W, s: W, x: W, ground: W) -> W {
    let rate = (k * (k + W::TWO * s)).sqrt();
    let twice = W::TWO * rate;
    // A + B times S, of which S is the share R∞: never below S.
    let sum = rate + k + s;
    let deep = s / W::select(sum.gt(W::ZERO), sum, W::ONE);
    let depth = twice * x;
    let faded = R::exp_product_wide(twice, x);
    // (1−exp(−d))/(2γ), X where the film is thin.
    let thin = depth.lt(W::HALF);
    let reached =
        W::select(thin, x * fading(W::select(thin, depth, W::ZERO)), (W::ONE - faded) / W::select(thin, W::ONE, twice));
    // No product of two of the largest numbers is needed to hide the ground.
    let hidden = (reached * (rate + k + (W::ONE - ground) * s)).min(W::from_f64(MOST));
    let total = hidden + faded;
    (deep * hidden + ground * faded) / W::select(total.gt(W::ZERO), total, W::ONE)
}

/// The weight beside which any other is nothing, and whose products are finite.
const MOST: f64 = 1e30;

/// (1−exp(−d))/d for d in [0, 1/2]: Taylor's series, whose first dropped term is 0.5¹⁴/15! = 5e-17.
#[inline(always)]
fn fading<W: Real>(depth: W) -> W {
    (2..=14).rev().fold(W::ONE, |rest, i| W::ONE - depth * W::from_f64(1.0 / f64::from(i)) * rest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector;
    use crate::layered::{Interface, Layer, Model, Stack};
    use crate::single::Single;

    /// K, S, X and R_g, ρ: the coth form in mpmath, 60 digits.
    const REFERENCE: [([f64; 4], f64); 12] = [
        ([1.0, 1.0, 1.0, 0.5], 0.27571667716977044),
        ([0.1, 2.0, 0.25, 0.9], 0.863083526360863037),
        ([1e-6, 1.0, 0.5, 0.2], 0.428571176870855464),
        ([1e-12, 3.0, 0.1, 0.04], 0.254658385093141501),
        ([5.0, 0.01, 0.5, 0.8], 0.00633234850718026054),
        ([2.0, 1e-9, 3.0, 0.7], 4.30119862074053806e-6),
        ([30.0, 1.0, 0.01, 0.3], 0.169210946206309955),
        ([0.5, 10.0, 0.05, 0.0], 0.326045752098586569),
        ([0.5, 10.0, 0.05, 1.0], 0.951621975362001012),
        ([100.0, 7.0, 2.0, 0.5], 0.0327453542409839846),
        ([0.01, 100.0, 0.2, 0.25], 0.951811221529706989),
        ([0.001, 0.001, 0.001, 0.5], 0.499999250001124999),
    ];

    fn white_in_single() -> f64 {
        let [k, s, x, ground] = [0.0, 1e20, 1e20, 0.5].map(Single::<false>::from_f64);
        film(k, s, x, ground).to_f64()
    }

    /// Numbers in a cube, by an additive recurrence (Roberts 2018).
    fn points(count: u32) -> impl Iterator<Item = [f64; 5]> {
        const STEP: [f64; 5] = [0.864_837, 0.747_943, 0.646_849, 0.559_420, 0.483_808];
        (1..=count).map(|i| STEP.map(|step| (0.5 + f64::from(i) * step).fract()))
    }

    fn log(u: f64, low: f64, high: f64) -> f64 {
        low * (high / low).powf(u)
    }

    #[test]
    fn it_is_the_published_form() {
        for ([k, s, x, ground], want) in REFERENCE {
            let got = film(k, s, x, ground);
            let exponent = 2.0 * (k * (k + 2.0 * s)).sqrt() * x;
            assert!(
                (got / want - 1.0).abs() <= (6.0 + 2.0 * exponent) * f64::EPSILON,
                "{k} {s} {x} {ground}: {got} {want}"
            );
            let single = film(k as f32, s as f32, x as f32, ground as f32);
            let rounded = [k, s, x, ground].map(|v| f64::from(v as f32));
            let want = film(rounded[0], rounded[1], rounded[2], rounded[3]);
            assert!((f64::from(single) - want).abs() <= 0.6 * f64::from(f32::EPSILON) * want, "{k} {s} {x} {ground}");
        }
    }

    #[test]
    fn it_has_its_limits() {
        for [a, b, c, ground, _] in points(2000) {
            let (k, s, x) = (log(a, 1e-6, 1e3), log(b, 1e-6, 1e3), log(c, 1e-6, 1e3));
            let close = |got: f64, want: f64, ulp: f64| (got - want).abs() <= ulp * f64::EPSILON * want.abs();
            assert_eq!(film(k, s, 0.0, ground), ground);
            assert_eq!(film(0.0, 0.0, x, ground), ground);
            let gone = ground * (-2.0 * k * x).exp();
            assert!(close(film(k, 0.0, x, ground), gone, 4.0 + 2.0 * k * x) || gone < 1e-300);
            let white = (ground + (1.0 - ground) * s * x) / (1.0 + (1.0 - ground) * s * x);
            assert!(close(film(0.0, s, x, ground), white, 6.0), "{s} {x} {ground}");
            assert!(close(film(1e-30, s, x, ground), white, 6.0), "{s} {x} {ground}");
            let deep = s / (k + s + (k * (k + 2.0 * s)).sqrt());
            assert!(close(film(k, s, 1e9, ground), deep, 6.0), "{k} {s}: {}", film(k, s, 1e9, ground));
            assert_eq!(film(0.0, s, x, 1.0), 1.0);
            // Between what a deep film and the ground reflect.
            let rho = film(k, s, x, ground);
            let (low, high) = (deep.min(ground), deep.max(ground));
            assert!((low * (1.0 - 4e-16)..=high * (1.0 + 4e-16)).contains(&rho), "{k} {s} {x} {ground}: {rho}");
        }
        // Weights that f32 throughout cannot hold.
        assert_eq!(white_in_single(), 1.0);
        for wild in [0.0f32, 1e-38, 1e-10, 1.0, 1e10, 1e30, f32::MAX] {
            for other in [0.0f32, 1e-38, 1.0, 1e30, f32::MAX] {
                for thickness in [0.0f32, 1e-38, 1.0, 1e30, f32::MAX] {
                    let rho = film(wild, other, thickness, 0.5);
                    assert!((0.0..=1.0).contains(&rho), "{wild} {other} {thickness}: {rho}");
                }
            }
        }
    }

    #[test]
    fn films_add_up() {
        for [a, b, c, d, ground] in points(2000) {
            let (k, s, upper, lower) = (log(a, 1e-4, 10.0), log(b, 1e-4, 10.0), log(c, 1e-3, 3.0), log(d, 1e-3, 3.0));
            let (both, one) = (film(k, s, upper, film(k, s, lower, ground)), film(k, s, upper + lower, ground));
            // Each is good to 6 ULP and 2 for the exponent, of which no more than 120 is drawn.
            assert!((both / one - 1.0).abs() <= 4.0 * (6.0 + 2.0 * 120.0) * f64::EPSILON, "{both} {one}");
        }
    }

    /// Saunderson 1942, eq. 4, about the normal: the light that gets in, bounces, and gets out through a smooth n = 1.5.
    #[test]
    fn under_a_smooth_interface_it_is_saundersons() {
        let n = 1.5f64;
        let (normal, slanted) = (Vector::new(0.0, 0.0, 1.0), Vector::new(0.6, 0.0, 0.8));
        // 1 − (1−F̄)/n² of n = 1.5, mpmath.
        const INTERNAL: f64 = 0.596_345_76;
        for (k, s, x, ground) in [(0.1, 5.0, 0.5, 0.2), (0.0, 10.0, 1.0, 0.0), (2.0, 1.0, 0.3, 0.8)] {
            let rho = film(k, s, x, ground);
            let layers = vec![Layer::new(Interface::dielectric(n, 1e-4)), Layer::new(Interface::diffuse([rho], 0.0))];
            let stack = Stack::<f64, 1>::new(Model::Coupled, layers).unwrap();
            let got = stack.evaluate(slanted, normal)[0];
            let enters = |c: f64| 1.0 - crate::fresnel::dielectric(c, n).reflectance;
            let want = enters(0.8) * enters(1.0) * rho / (core::f64::consts::PI * n * n * (1.0 - rho * INTERNAL));
            // The table of the rough interface that stands for the smooth one: half a per cent.
            assert!((got / want - 1.0).abs() < 5e-3, "{got} {want}");
        }
    }
}
