//! Fresnel reflectance and transmittance of unpolarised light at a smooth interface, exact and approximate.
//!
//! Twin: `wgsl/fresnel.wgsl`. Cosines are those of the angle of incidence (for a microfacet, V·H). Indices are relative
//! to the medium that the light comes from. [`dielectric`] and [`conductor`] are exact; the others trade error for cost.

pub use crate::fresnel_fit::{Fit, FitError};
use crate::real::Real;
use crate::twofold::Twofold;

/// The split of arriving power at an interface. The two parts sum to 1; each is computed directly, since 1−R loses
/// every digit of a small transmittance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Fresnel<R> {
    /// The reflected fraction F of the power, in [0, 1].
    pub reflectance: R,
    /// The transmitted fraction T = 1−F of the power, in [0, 1].
    pub transmittance: R,
}

impl<W: Real> Fresnel<W> {
    /// The larger part as what the smaller leaves of 1, where the numbers are as short as the result: it errs less.
    #[inline(always)]
    fn complemented(self) -> Self {
        if !W::CARRIES {
            return self;
        }
        let Fresnel { reflectance, transmittance } = self;
        Fresnel {
            reflectance: W::select(transmittance.lt(W::HALF), W::ONE - transmittance, reflectance),
            transmittance: W::select(reflectance.lt(W::HALF), W::ONE - reflectance, transmittance),
        }
    }

    /// The nearest numbers of a type that computes in `W`.
    #[inline(always)]
    pub(crate) fn narrow<R: Real<Wide = W>>(self) -> Fresnel<R> {
        Fresnel { reflectance: R::narrow(self.reflectance), transmittance: R::narrow(self.transmittance) }
    }
}

/// The exact Fresnel equations of a dielectric.
///
/// $$F = \tfrac12 (r_s^2 + r_p^2),\quad r_s = \frac{c-g}{c+g},\quad r_p = \frac{\eta^2 c-g}{\eta^2 c+g},\quad g^2 = \eta^2 - 1 + c^2$$
///
/// In plain text: F = (rs² + rp²)/2 with rs = (c−g)/(c+g), rp = (η²c−g)/(η²c+g), g² = η²−1+c²; T = 1−F.
///
/// * `cos_i` in [0, 1]: cosine of the angle of incidence. At 0: F = 1. At 1: F = ((η−1)/(η+1))².
/// * `eta` > 0: n_t/n_i. At η = 1: F = 0 for every angle. For η < 1, F = 1 and T = 0 from the critical angle on
///   (c² ≤ 1−η²).
///
/// Error in f32: ≤ 0.6 ULP for η in [1/4, 4], cos in [1e-6, 1], the critical angle
/// included: g² is summed without rounding error. Source: Cook & Torrance 1982, eq. 18; Born & Wolf, §1.5.2, eq. 21.
#[inline(always)]
pub fn dielectric<R: Real>(cos_i: R, eta: R) -> Fresnel<R> {
    dielectric_wide::<_, R>(cos_i.widen(), eta.widen()).narrow()
}

/// [`dielectric`] in the numbers that it computes with.
#[inline(always)]
pub(crate) fn dielectric_wide<W: Real, R: Real<Wide = W>>(cos_i: W, eta: W) -> Fresnel<W> {
    let c = cos_i;
    let g_squared = refracted_square_carried::<_, R>(Twofold::new(c), eta);
    let total = g_squared.high.lt(W::ZERO);
    let root = g_squared.sqrt();
    let g = root.high;
    // The differences c−g and η²c−g are written as quotients that do not cancel: (c−g)(c+g) = 1−η².
    let e1 = (Twofold::sum(eta, -W::ONE) * Twofold::sum(eta, W::ONE)).rounded();
    let exact_square = Twofold::square(eta);
    let eta_squared = exact_square.high;
    let (sum, weighted) = (Twofold::new(c) + root, exact_square * c + root);
    let matched = sum.high.le(W::ZERO);
    let sum_s = W::select(matched, W::ONE, sum.squared().rounded());
    let sum_p = W::select(matched, W::ONE, weighted.squared().rounded());
    let rs = e1 / sum_s;
    // (η²c−g)(η²c+g), which vanishes at Brewster's angle: for small η that is close to the critical angle, where sum_p
    // is small, while F is far from 0 and the difference itself exact enough.
    let product = e1 * (eta_squared * c * c - (W::ONE - c) * (W::ONE + c));
    let difference = (eta_squared * c - g) * (eta_squared * c + g);
    let rp = W::select(eta.lt(W::from_f64(0.7)), difference, product) / sum_p;
    let transmittance = W::TWO * c * g * (W::ONE / sum_s + eta_squared / sum_p);
    Fresnel {
        reflectance: W::select(total, W::ONE, W::HALF * (rs * rs + rp * rp)),
        transmittance: W::select(total, W::ZERO, W::select(matched, W::ONE, transmittance)),
    }
    .complemented()
}

/// g² = c² + η² − 1, η² times the squared cosine of the refracted ray; negative on total reflection.
///
/// Summed from exact products, so that it keeps its relative accuracy down to the critical angle. Error in f32: ≤ 0.6 ULP where it is positive.
#[inline(always)]
pub fn refracted_square<R: Real>(cos_i: R, eta: R) -> R {
    R::narrow(refracted_square_wide::<_, R>(cos_i.widen(), eta.widen()))
}

/// [`refracted_square`] in the numbers that it computes with.
#[inline(always)]
pub(crate) fn refracted_square_wide<W: Real, R: Real<Wide = W>>(cos_i: W, eta: W) -> W {
    refracted_square_carried::<_, R>(Twofold::new(cos_i), eta).rounded()
}

/// [`refracted_square`] of an unrounded cosine, unrounded where the type carries.
#[inline(always)]
pub(crate) fn refracted_square_carried<W: Real, R: Real<Wide = W>>(cos_i: Twofold<W>, eta: W) -> Twofold<W> {
    if W::CARRIES {
        let (c, e) = (cos_i.squared(), Twofold::square(eta));
        // The errors of the products first: what is left of a sum that cancels is of their size.
        let (fine, finer) = c.low.sum_exact(e.low);
        let larger = Twofold::sum(c.high.max(e.high), -W::ONE);
        let sum = Twofold::sum(larger.high, c.high.min(e.high));
        let total = Twofold::sum(sum.high, fine);
        return Twofold::sum(total.high, total.low + (finer + (larger.low + sum.low)));
    }
    let cos_i = cos_i.high;
    let (c, c_error) = R::product_wide(cos_i, cos_i);
    let (e, e_error) = R::product_wide(eta, eta);
    // Where the sum cancels, the larger square is in [1/2, 1]: both differences are exact there (Sterbenz).
    let sum = (c.max(e) - W::ONE) + c.min(e);
    let (fine, finer) = c_error.sum_exact(e_error);
    Twofold::new((sum + fine) + finer)
}

/// The exact Fresnel equations of a conductor with the relative index n + iκ; κ = 0 is a dielectric.
///
/// $$F = \tfrac12 F_s (1 + F_q),\quad F_s = \frac{(a-c)^2+b^2}{(a+c)^2+b^2},\quad F_q = \frac{(ac-s^2)^2+b^2c^2}{(ac+s^2)^2+b^2c^2},\quad (a+ib)^2 = (n+i\kappa)^2 - s^2$$
///
/// In plain text: with s² = 1−c² and (a+ib)² = (n+iκ)²−s², F is half of Fs(1+Fq), Fs = ((a−c)²+b²)/((a+c)²+b²),
/// Fq = ((ac−s²)²+b²c²)/((ac+s²)²+b²c²); T = 1−F, the power absorbed or refracted.
///
/// * `cos_i` in [0, 1]. At 0: F = 1. At 1: F = ((n−1)²+κ²)/((n+1)²+κ²).
/// * `n` > 0 and `k` ≥ 0, relative to the (transparent) medium of incidence.
///
/// Error in f32: ≤ 0.6 ULP for n in [0.02, 8], κ in [0, 12], cos in [1e-6, 1], the critical angle of κ ≈ 0, n < 1 included.
/// Source: Born & Wolf, §14.2, eq. 15–18; Elek 2010, §2.1 (which prints an approximation); the roots are chosen so that
/// none cancels.
#[inline(always)]
pub fn conductor<R: Real>(cos_i: R, n: R, k: R) -> Fresnel<R> {
    conductor_wide::<_, R>(cos_i.widen(), n.widen(), k.widen()).narrow()
}

/// [`conductor`] in the numbers that it computes with.
#[inline(always)]
pub(crate) fn conductor_wide<W: Real, R: Real<Wide = W>>(cos_i: W, n: W, k: W) -> Fresnel<W> {
    conductor_carried::<_, R>(Twofold::new(cos_i), n, k)
}

/// [`conductor`] at an unrounded cosine: at a critical angle the root magnifies its rounding.
#[inline(always)]
pub(crate) fn conductor_carried<W: Real, R: Real<Wide = W>>(cos_i: Twofold<W>, n: W, k: W) -> Fresnel<W> {
    let c = cos_i.high;
    let one = Twofold::new(W::ONE);
    let k_squared = Twofold::square(k);
    let e1 = Twofold::sum(n, -W::ONE) * Twofold::sum(n, W::ONE) - k_squared;
    // e1+c², which vanishes at the critical angle of κ ≈ 0.
    let real = refracted_square_carried::<_, R>(cos_i, n) - k_squared;
    let nk = Twofold::product(n, k);
    let modulus = (real.squared() + nk.squared() * W::from_f64(4.0)).rounded().sqrt();
    let real = real.rounded();
    let root = (Twofold::sum(modulus, real.abs()) * W::HALF).sqrt();
    let larger = root.high;
    let smaller = nk.high / W::select(larger.gt(W::ZERO), larger, W::ONE);
    let above = real.ge(W::ZERO);
    let carried = Twofold::select(above, root, Twofold::new(smaller));
    let a = carried.high;
    let b = W::select(above, smaller, larger);
    let b_squared = b * b;

    let a_plus_c = carried + Twofold::new(c);
    let sum = (a_plus_c.squared() + Twofold::new(b_squared)).rounded();
    let matched = sum.le(W::ZERO);
    let sum = W::select(matched, W::ONE, sum);
    // a−c without cancellation: (a−c)(a+c) = e1+b². Where b ≥ a the quotient would magnify the rounding of b² at small
    // a+c, and b² drowns what a−c loses.
    let quotient = (e1 + Twofold::new(b_squared)) / Twofold::select(above & !matched, a_plus_c, one);
    let difference = W::select(above, quotient.rounded(), a - c);
    let s_squared = ((one - cos_i) * (one + cos_i)).rounded();
    let ac = a * c;
    let bc_squared = b_squared * c * c;
    let (minus, plus) = (a.mul_add(c, -s_squared), a.mul_add(c, s_squared));
    let sum_q = plus.mul_add(plus, bc_squared);
    let fs = difference.mul_add(difference, b_squared) / sum;
    let fq = minus.mul_add(minus, bc_squared) / sum_q;
    let ts = W::from_f64(4.0) * ac / sum;
    let tq = W::from_f64(4.0) * ac * s_squared / sum_q;
    Fresnel {
        reflectance: W::HALF * fs * (W::ONE + fq),
        transmittance: W::select(matched, W::ONE, ts + W::HALF * tq * (W::ONE - ts)),
    }
    .complemented()
}

/// The reflectance of a conductor for |n+iκ|² ≫ 1, the approximation that Mihaylov prints.
///
/// $$F \approx \tfrac12\left(\frac{(n-c)^2+\kappa^2}{(n+c)^2+\kappa^2} + \frac{(nc-1)^2+\kappa^2c^2}{(nc+1)^2+\kappa^2c^2}\right)$$
///
/// In plain text: the mean of ((n−c)²+κ²)/((n+c)²+κ²) and ((nc−1)²+κ²c²)/((nc+1)²+κ²c²).
///
/// * `cos_i` in [0, 1]; `n` > 0, `k` ≥ 0. At cos 0: F = 1; at cos 1: exact.
///
/// Differs from [`conductor`] by up to .099 at n = 1.5, κ = 0 and by ≤ .008 for κ ≥ 2. Error in f32: ≤ 0.6 ULP.
/// Source: Mihaylov 2013, eq. 3.6 and 4.6 (its listing drops a factor: erratum 15).
#[inline(always)]
pub fn conductor_approx<R: Real>(cos_i: R, n: R, k: R) -> R {
    R::narrow(conductor_approx_wide(cos_i.widen(), n.widen(), k.widen()))
}

#[inline(always)]
fn conductor_approx_wide<W: Real>(cos_i: W, n: W, k: W) -> W {
    let c = cos_i;
    let k_squared = k * k;
    let kc_squared = k_squared * c * c;
    let s = ((n - c).squared() + k_squared) / ((n + c).squared() + k_squared);
    // nc−1 without the rounding of nc: what is left to cancel is small beside s.
    let difference = (n - W::ONE) * c - (W::ONE - c);
    let p = (difference.squared() + kc_squared) / ((n * c + W::ONE).squared() + kc_squared);
    W::HALF * (s + p)
}

/// The reflectance at normal incidence of a surface with the relative index n + iκ.
///
/// $$F_0 = \frac{(n-1)^2+\kappa^2}{(n+1)^2+\kappa^2}$$
///
/// In plain text: F0 = ((n−1)²+κ²)/((n+1)²+κ²). `n` > 0, `k` ≥ 0; 0 at n = 1, κ = 0.
///
/// Error in f32: ≤ 0.6 ULP. Source: Elek 2010, App. B; Born & Wolf, §14.2.
#[inline(always)]
pub fn normal_incidence<R: Real>(n: R, k: R) -> R {
    R::narrow(normal_incidence_wide(n.widen(), k.widen()))
}

#[inline(always)]
fn normal_incidence_wide<W: Real>(n: W, k: W) -> W {
    let k_squared = k * k;
    ((n - W::ONE).squared() + k_squared) / ((n + W::ONE).squared() + k_squared)
}

/// Schlick's approximation from the reflectance at normal incidence.
///
/// $$F = F_0 + (1-F_0)(1-c)^5$$
///
/// In plain text: F = F0 + (1−F0)(1−c)⁵; T = 1−F, computed as (1−F0)·c·(1+q+q²+q³+q⁴) with q = 1−c.
///
/// * `cos_i` in [0, 1]; `f0` in [0, 1].
///
/// Error in f32: ≤ 0.6 ULP of the formula; against the exact dielectric at n = 1.5 up to .036.
/// Source: Schlick 1994, eq. 15.
#[inline(always)]
pub fn schlick<R: Real>(cos_i: R, f0: R) -> Fresnel<R> {
    schlick_wide(cos_i.widen(), f0.widen()).narrow()
}

#[inline(always)]
fn schlick_wide<W: Real>(cos_i: W, f0: W) -> Fresnel<W> {
    let (rest, difference) = (W::ONE - f0, Twofold::sum(W::ONE, -cos_i));
    let q = difference.high;
    // 1+q+q²+q³+q⁴, and what its slope makes of the rounding of q.
    let series = (q + W::ONE).mul_add(q, W::ONE).mul_add(q, W::ONE).mul_add(q, W::ONE);
    let slope = W::from_f64(4.0).mul_add(q, W::from_f64(3.0)).mul_add(q, W::TWO).mul_add(q, W::ONE);
    let series = if W::CARRIES { difference.low.mul_add(slope, series) } else { series };
    Fresnel {
        reflectance: rest.mul_add(fifth_power(cos_i), f0),
        transmittance: (Twofold::product(rest, cos_i) * series).rounded(),
    }
    .complemented()
}

/// (1−c)⁵.
#[inline(always)]
fn fifth_power<W: Real>(cos_i: W) -> W {
    let q = Twofold::sum(W::ONE, -cos_i);
    let q_squared = q.high * q.high;
    let fourth = q_squared * q_squared;
    // The power magnifies the rounding of the difference five times.
    let value = fourth * q.high;
    if W::CARRIES { (W::from_f64(5.0) * q.low).mul_add(fourth, value) } else { value }
}

/// Schlick's approximation from the two indices of a dielectric interface.
///
/// F0 = ((n_t−n_i)/(n_t+n_i))², then [`schlick`]. `cos_i` in [0, 1]; `n_i`, `n_t` > 0. It knows no total reflection.
///
/// Error in f32: ≤ 0.6 ULP. Source: Mihaylov 2013, eq. 4.9; Schlick 1994, eq. 15.
#[inline(always)]
pub fn schlick_from_indices<R: Real>(cos_i: R, n_i: R, n_t: R) -> Fresnel<R> {
    schlick_from_indices_wide(cos_i.widen(), n_i.widen(), n_t.widen()).narrow()
}

#[inline(always)]
fn schlick_from_indices_wide<W: Real>(cos_i: W, n_i: W, n_t: W) -> Fresnel<W> {
    let ratio = Twofold::sum(n_t, -n_i) / Twofold::sum(n_t, n_i);
    schlick_wide(cos_i, ratio.squared().rounded())
}

/// Lazányi's approximation for metals without its correction: Schlick's with a complex index.
///
/// $$F = \frac{(n-1)^2 + 4n(1-c)^5 + \kappa^2}{(n+1)^2+\kappa^2}$$
///
/// In plain text: F = ((n−1)² + 4n(1−c)⁵ + κ²)/((n+1)²+κ²). `cos_i` in [0, 1], `n` > 0, `k` ≥ 0.
///
/// Error in f32: ≤ 0.6 ULP of the formula; against [`conductor`] up to .041 for copper and .243 for chromium at 84°.
/// Source: Lazányi & Szirmay-Kalos 2005, eq. 5; Elek 2010, App. B, which prints the fourth power.
#[inline(always)]
pub fn lazanyi_uncorrected<R: Real>(cos_i: R, n: R, k: R) -> R {
    R::narrow(lazanyi_uncorrected_wide(cos_i.widen(), n.widen(), k.widen()))
}

#[inline(always)]
fn lazanyi_uncorrected_wide<W: Real>(cos_i: W, n: W, k: W) -> W {
    let k_squared = k * k;
    ((n - W::ONE).squared() + W::from_f64(4.0) * n * fifth_power(cos_i) + k_squared)
        / ((n + W::ONE).squared() + k_squared)
}

/// Lazányi's approximation for metals with its correction.
///
/// $$F = \frac{(n-1)^2 + 4n(1-c)^5 + \kappa^2}{(n+1)^2+\kappa^2} - a\,c\,(1-c)^{e}$$
///
/// In plain text: [`lazanyi_uncorrected`] − a·c·(1−c)^e, at least 0.
///
/// * `cos_i` in [0, 1]; `n` > 0, `k` ≥ 0; `a` and `exponent` > 0 from [`lazanyi_fit`].
///
/// Error in f32: ≤ 0.6 ULP of the formula; against [`conductor`] ≤ .0195 for the fitted seed metals.
/// Source: Lazányi & Szirmay-Kalos 2005, eq. 6.
#[inline(always)]
pub fn lazanyi<R: Real>(cos_i: R, n: R, k: R, a: R, exponent: R) -> R {
    R::narrow(lazanyi_wide(cos_i.widen(), n.widen(), k.widen(), a.widen(), exponent.widen()))
}

#[inline(always)]
fn lazanyi_wide<W: Real>(cos_i: W, n: W, k: W, a: W, exponent: W) -> W {
    let inside = cos_i.lt(W::ONE);
    let log = Twofold::new(W::select(inside, -cos_i, W::ZERO)).ln_one_plus();
    let power = W::select(inside, (-log * exponent).exp_negative(), W::ZERO);
    (lazanyi_uncorrected(cos_i, n, k) - a * cos_i * power).max(W::ZERO)
}

/// The constants of [`lazanyi`] for one index, and the error they leave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LazanyiFit {
    /// The factor a.
    pub a: f64,
    /// The exponent e.
    pub exponent: f64,
    /// The largest |lazanyi − conductor| over cos in [0, 1].
    pub max_error: f64,
}

/// Fits the constants of [`lazanyi`] to the exact conductor so that the largest error over cos in [0, 1] is smallest.
///
/// `n` > 0 and `k` ≥ 0, relative. For each exponent the best factor is that of a one-dimensional Chebyshev
/// approximation (convex); the exponent is searched on [1, 12]. About 0.1 s a metal: a preparation, not a shading cost.
/// Source: Lazányi & Szirmay-Kalos 2005, §3.
pub fn lazanyi_fit(n: f64, k: f64) -> LazanyiFit {
    const SAMPLES: usize = 400;
    // Dense towards grazing, where the error bends: c = x².
    let sample = |i: usize| (i as f64 / SAMPLES as f64).squared();
    let mut rest = [0.0; SAMPLES + 1];
    for (i, r) in rest.iter_mut().enumerate() {
        let c = sample(i);
        *r = lazanyi_uncorrected(c, n, k) - conductor(c, n, k).reflectance;
    }
    let error = |a: f64, exponent: f64| {
        let mut worst = 0.0f64;
        for (i, r) in rest.iter().enumerate() {
            let c = sample(i);
            let q = 1.0 - c;
            let power = if q > 0.0 { Real::exp(exponent * Real::ln(q)) } else { 0.0 };
            worst = worst.max(Real::abs(r - a * c * power));
        }
        worst
    };
    let best_factor = |exponent: f64| golden_section(-20.0, 20.0, 48, |a| error(a, exponent));
    // The outer function has one valley for every index tried, but nothing promises it: search from a coarse grid.
    let (mut coarse, mut least) = (1.0, f64::INFINITY);
    for i in 0..23 {
        let exponent = 1.0 + 0.5 * f64::from(i);
        let value = error(best_factor(exponent), exponent);
        if value < least {
            (coarse, least) = (exponent, value);
        }
    }
    let exponent = golden_section(coarse - 0.5, coarse + 0.5, 30, |e| error(best_factor(e), e));
    let a = best_factor(exponent);
    LazanyiFit { a, exponent, max_error: error(a, exponent) }
}

/// The argument in [low, high] at which a function with one valley is smallest.
pub(crate) fn golden_section(low: f64, high: f64, steps: usize, f: impl Fn(f64) -> f64) -> f64 {
    const RATIO: f64 = 0.618_033_988_749_894_9;
    let (mut low, mut high) = (low, high);
    let (mut x1, mut x2) = (high - RATIO * (high - low), low + RATIO * (high - low));
    let (mut f1, mut f2) = (f(x1), f(x2));
    for _ in 0..steps {
        if f1 < f2 {
            (high, x2, f2) = (x2, x1, f1);
            x1 = high - RATIO * (high - low);
            f1 = f(x1);
        } else {
            (low, x1, f1) = (x1, x2, f2);
            x2 = low + RATIO * (high - low);
            f2 = f(x2);
        }
    }
    0.5 * (low + high)
}

/// Schlick's approximation with a tint at 82°, where the reflectance of many metals dips.
///
/// $$F = F_s(c) - \frac{F_s(\bar c)(1-t)}{\bar c(1-\bar c)^6}\,c\,(1-c)^6,\quad \bar c = 1/7,\quad F_s = \text{Schlick}$$
///
/// In plain text: Schlick's F minus c(1−c)⁶·Fs(1/7)(1−t)/((1/7)(6/7)⁶), so that F(1/7) = t·Fs(1/7). At
/// least 0: for a dark F0 and tint the dip would exceed what it is taken from.
///
/// * `cos_i`, `f0`, `tint` in [0, 1]. At tint 1: [`schlick`].
///
/// Error in f32: ≤ 0.6 ULP. Source: Kutz, Hašan & Edmondson 2021, "Novel aspects of the Adobe Standard
/// Material", §2.3; OpenPBR 1.1, "Metal".
#[inline(always)]
pub fn f82_tint<R: Real>(cos_i: R, f0: R, tint: R) -> R {
    R::narrow(f82_tint_wide(cos_i.widen(), f0.widen(), tint.widen()))
}

#[inline(always)]
fn f82_tint_wide<W: Real>(cos_i: W, f0: W, tint: W) -> W {
    // 1/(c̄(1−c̄)⁶) and (1−c̄)⁵ at c̄ = 1/7.
    let at_peak = W::from_f64(823_543.0 / 46_656.0);
    let fifth = W::from_f64(7_776.0 / 16_807.0);
    let q = W::ONE - cos_i;
    let fifth_of_q = fifth_power(cos_i);
    let schlick_bar = f0 + (W::ONE - f0) * fifth;
    let dip = schlick_bar * (W::ONE - tint) * at_peak;
    let base = f0 + (W::ONE - f0) * fifth_of_q;
    (base - dip * cos_i * (fifth_of_q * q)).max(W::ZERO)
}
