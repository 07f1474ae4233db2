//! Microfacet normal distributions D, normalised so that ∫ D·cos dω = 1 over the hemisphere.
//!
//! Twin: `wgsl/distribution.wgsl`. Each takes a local half vector of *any* length with `h.z` > 0 and returns sr⁻¹; where
//! `h.z` ≤ 0 it returns 0. Everything is written in tan²θ = (hx²+hy²)/hz², never in 1−cos²θ, which at small widths has
//! no correct digit left in f32 (errors of 5.6e7 ULP). `alpha` is the width along both axes, Beckmann's slope
//! parameter, in [1e-4, 1].

use crate::frame::Vector;
use crate::real::Real;
use crate::twofold::Twofold;

/// Beckmann's distribution.
///
/// $$D = \frac{e^{-\tan^2\theta/\alpha^2}}{\pi\alpha^2\cos^4\theta}$$
///
/// In plain text: D = exp(−tan²θ/α²)/(πα²cos⁴θ). At θ = 0: 1/(πα²). 0 where tan²θ/α² > 87 (f32) or 708 (f64), where
/// the result would be subnormal.
///
/// Error in f32: ≤ 0.6 ULP, the exponent included.
/// Source: Beckmann & Spizzichino 1963; Mihaylov 2013, eq. 4.12; Elek 2010, App. B (which lacks 1/π).
#[inline(always)]
pub fn beckmann<R: Real>(h: Vector<R>, alpha: R) -> R {
    R::narrow(beckmann_wide::<_, R>(h.widen(), alpha.widen()))
}

#[inline(always)]
pub(crate) fn beckmann_wide<W: Real, R: Real<Wide = W>>(h: Vector<W>, alpha: W) -> W {
    beckmann_carried::<_, R>(h.carried(), alpha)
}

/// [`beckmann`] at an unrounded half vector.
#[inline(always)]
pub(crate) fn beckmann_carried<W: Real, R: Real<Wide = W>>(h: Vector<Twofold<W>>, alpha: W) -> W {
    let (inside, z) = upper_carried(h);
    let tan_squared = h.sin_squared_carried() / z.squared();
    let alpha_squared = Twofold::square(alpha);
    let exponent = tan_squared / alpha_squared;
    let inside = inside & exponent.high.le(R::EXP_LIMIT.widen());
    let value = (W::ONE + tan_squared.high).squared() * exponent.exp_negative() / (W::PI * alpha_squared.high);
    W::select(inside, value, W::ZERO)
}

/// Beckmann's distribution with a width for each axis.
///
/// $$D = \frac{e^{-(x^2/\alpha_x^2+y^2/\alpha_y^2)/z^2}}{\pi\alpha_x\alpha_y\cos^4\theta}$$
///
/// In plain text: D = exp(−((hx/αx)² + (hy/αy)²)/hz²)/(π αx αy cos⁴θ). At αx = αy: [`beckmann`].
///
/// Error in f32: ≤ 0.6 ULP. Source: Heitz 2014, eq. 75.
#[inline(always)]
pub fn beckmann_anisotropic<R: Real>(h: Vector<R>, alpha_x: R, alpha_y: R) -> R {
    R::narrow(beckmann_anisotropic_wide::<_, R>(h.widen(), alpha_x.widen(), alpha_y.widen()))
}

#[inline(always)]
pub(crate) fn beckmann_anisotropic_wide<W: Real, R: Real<Wide = W>>(h: Vector<W>, alpha_x: W, alpha_y: W) -> W {
    let (inside, z) = upper(h);
    let x = Twofold::new(h.x) / Twofold::product(z, alpha_x);
    let y = Twofold::new(h.y) / Twofold::product(z, alpha_y);
    let exponent = x.squared() + y.squared();
    let inside = inside & exponent.high.le(R::EXP_LIMIT.widen());
    let inverse_cos_squared = W::ONE + h.sin_squared() / (z * z);
    let value = inverse_cos_squared.squared() * exponent.exp_negative() / (W::PI * alpha_x * alpha_y);
    W::select(inside, value, W::ZERO)
}

/// The distribution of Trowbridge and Reitz, known as GGX.
///
/// $$D = \frac{\alpha^2}{\pi(\sin^2\theta + \alpha^2\cos^2\theta)^2}$$
///
/// In plain text: D = α²/(π(sin²θ+α²cos²θ)²). At θ = 0: 1/(πα²).
///
/// Error in f32: ≤ 0.6 ULP. Source: Trowbridge & Reitz 1975; Walter et al. 2007, eq. 33.
#[inline(always)]
pub fn ggx<R: Real>(h: Vector<R>, alpha: R) -> R {
    R::narrow(ggx_wide(h.widen(), alpha.widen()))
}

#[inline(always)]
fn ggx_wide<W: Real>(h: Vector<W>, alpha: W) -> W {
    let (inside, z) = upper(h);
    let (s, z_squared) = (h.carried().sin_squared_carried(), Twofold::square(z));
    let ratio = (s + z_squared) * alpha / (s + Twofold::square(alpha) * z_squared);
    W::select(inside, (ratio.squared() * W::FRAC_1_PI).rounded(), W::ZERO)
}

/// GGX with a width for each axis.
///
/// $$D = \frac{|h|^4}{\pi\alpha_x\alpha_y(h_x^2/\alpha_x^2+h_y^2/\alpha_y^2+h_z^2)^2}$$
///
/// In plain text: D = |h|⁴/(π αx αy ((hx/αx)²+(hy/αy)²+hz²)²). At αx = αy: [`ggx`].
///
/// Error in f32: ≤ 0.6 ULP. Source: Burley 2012, App. B.2, eq. 13; Heitz 2014, eq. 85.
#[inline(always)]
pub fn ggx_anisotropic<R: Real>(h: Vector<R>, alpha_x: R, alpha_y: R) -> R {
    R::narrow(ggx_anisotropic_wide(h.widen(), alpha_x.widen(), alpha_y.widen()))
}

#[inline(always)]
pub(crate) fn ggx_anisotropic_wide<W: Real>(h: Vector<W>, alpha_x: W, alpha_y: W) -> W {
    let (inside, z) = upper(h);
    let (x, y) = (Twofold::new(h.x) / alpha_x, Twofold::new(h.y) / alpha_y);
    let (s, z_squared) = (h.carried().sin_squared_carried(), Twofold::square(z));
    let ratio = (s + z_squared) / (x.squared() + y.squared() + z_squared);
    W::select(inside, ratio.squared().rounded() / (W::PI * alpha_x * alpha_y), W::ZERO)
}

/// Blinn's distribution, with the exponent that matches Beckmann's width.
///
/// $$D = \frac{\cos^e\theta}{\pi\alpha^2},\quad e = 2/\alpha^2-2$$
///
/// In plain text: D = cos(θ)^(2/α²−2)/(πα²). At θ = 0: 1/(πα²); at α = 1: constant.
///
/// The power is exp(−(1/α²−1)·ln(1+tan²θ)), so that it stays accurate for exponents of 10⁸.
/// Error in f32: ≤ 0.6 ULP. Source: Blinn 1977; Walter et al. 2007, eq. 30 with α_p = 2/α²−2; Elek 2010, §2.1.
#[inline(always)]
pub fn blinn<R: Real>(h: Vector<R>, alpha: R) -> R {
    R::narrow(blinn_wide::<_, R>(h.widen(), alpha.widen()))
}

#[inline(always)]
fn blinn_wide<W: Real, R: Real<Wide = W>>(h: Vector<W>, alpha: W) -> W {
    let (inside, z) = upper(h);
    let alpha_squared = Twofold::square(alpha);
    let half_exponent = Twofold::sum(W::ONE, -alpha) * Twofold::sum(W::ONE, alpha) / alpha_squared;
    let tan_squared = h.carried().sin_squared_carried() / Twofold::square(z);
    let exponent = half_exponent * tan_squared.ln_one_plus();
    let inside = inside & exponent.high.le(R::EXP_LIMIT.widen());
    W::select(inside, exponent.exp_negative() / (W::PI * alpha_squared.high), W::ZERO)
}

/// Blinn's distribution with a width for each axis.
///
/// $$D = \frac{\cos^e\theta}{\pi\alpha_x\alpha_y},\quad e = 2(\cos^2\!\phi/\alpha_x^2+\sin^2\!\phi/\alpha_y^2)-2$$
///
/// In plain text: cos(θ)^e/(π αx αy), the exponent interpolated over the azimuth. At αx = αy: [`blinn`].
///
/// Error in f32: ≤ 0.6 ULP. Source: Ashikhmin & Shirley 2000, eq. 6, without their 1/4 terms.
#[inline(always)]
pub fn blinn_anisotropic<R: Real>(h: Vector<R>, alpha_x: R, alpha_y: R) -> R {
    R::narrow(blinn_anisotropic_wide::<_, R>(h.widen(), alpha_x.widen(), alpha_y.widen()))
}

#[inline(always)]
fn blinn_anisotropic_wide<W: Real, R: Real<Wide = W>>(h: Vector<W>, alpha_x: W, alpha_y: W) -> W {
    let (inside, z) = upper(h);
    let s = h.carried().sin_squared_carried();
    let tilted = s.high.gt(W::ZERO);
    let one = Twofold::new(W::ONE);
    let across = Twofold::select(tilted, s, one);
    let (x, y) = (Twofold::new(h.x) / alpha_x, Twofold::new(h.y) / alpha_y);
    // ln(1+t²)·(half the exponent); the azimuthal mean of 1/α² is (x²+y²)/s.
    let half_exponent = Twofold::select(tilted, (x.squared() + y.squared()) / across, one) - one;
    let half_exponent = Twofold::select(half_exponent.high.gt(W::ZERO), half_exponent, Twofold::new(W::ZERO));
    let exponent = half_exponent * (s / Twofold::square(z)).ln_one_plus();
    let inside = inside & exponent.high.le(R::EXP_LIMIT.widen());
    W::select(inside, exponent.exp_negative() / (W::PI * alpha_x * alpha_y), W::ZERO)
}

/// The Gaussian distribution in the angle.
///
/// $$D = c(\alpha)\,e^{-(\theta/\alpha)^2}$$
///
/// In plain text: D = c·exp(−(θ/α)²), with θ the angle to the normal in radians and c = `normalisation` from
/// [`gaussian_normalisation`], a constant of the material.
///
/// Error in f32: ≤ 0.6 ULP. Source: Torrance & Sparrow 1967, eq. 5; Elek 2010, §2.1 (with c unstated).
#[inline(always)]
pub fn gaussian<R: Real>(h: Vector<R>, alpha: R, normalisation: R) -> R {
    R::narrow(gaussian_wide::<_, R>(h.widen(), alpha.widen(), normalisation.widen()))
}

#[inline(always)]
fn gaussian_wide<W: Real, R: Real<Wide = W>>(h: Vector<W>, alpha: W, normalisation: W) -> W {
    let (inside, z) = upper(h);
    let angle = h.carried().sin_squared_carried().sqrt().angle::<R>(z) / alpha;
    let exponent = angle.squared();
    let inside = inside & exponent.high.le(R::EXP_LIMIT.widen());
    W::select(inside, normalisation * exponent.exp_negative(), W::ZERO)
}

/// The constant c(α) of [`gaussian`], 1/∫ exp(−(θ/α)²)·cosθ dω.
///
/// `alpha` in [1e-4, 1]. About 1/(πα²) for a small width. Error: 1e-14 relative. By Gauss–Legendre quadrature of
/// π∫₀^{π/2} exp(−(θ/α)²)·sin2θ dθ, whose closed form π·α·Dawson(α) holds only while the tail beyond π/2 is nothing.
pub fn gaussian_normalisation(alpha: f64) -> f64 {
    // θ = α·x: past x = 6.5 the integrand is below 5e-19 of its peak.
    let end = Real::min(core::f64::consts::FRAC_PI_2 / alpha, 6.5);
    let panels = 8;
    let width = end / f64::from(panels);
    let mut sum = 0.0;
    for panel in 0..panels {
        for (node, weight) in GAUSS_LEGENDRE {
            for side in [-node, node] {
                let x = width * (f64::from(panel) + 0.5 + 0.5 * side);
                sum += 0.5 * width * weight * Real::exp(-x * x) * sine(2.0 * alpha * x);
            }
        }
    }
    1.0 / (core::f64::consts::PI * alpha * sum)
}

/// sin(x) for x in [0, π], of the standard library or libm.
fn sine(x: f64) -> f64 {
    #[cfg(feature = "std")]
    return x.sin();
    #[cfg(not(feature = "std"))]
    return libm::sin(x);
}

/// The nodes and weights of the ten-point Gauss–Legendre rule on [−1, 1], one side (Abramowitz & Stegun, table 25.4).
const GAUSS_LEGENDRE: [(f64, f64); 5] = [
    (0.148_874_338_981_631_21, 0.295_524_224_714_752_87),
    (0.433_395_394_129_247_19, 0.269_266_719_309_996_36),
    (0.679_409_568_299_024_41, 0.219_086_362_515_982_04),
    (0.865_063_366_688_984_51, 0.149_451_349_150_580_59),
    (0.973_906_528_517_171_72, 0.066_671_344_308_688_14),
];

/// Whether `h` points up, and its height, 1 where it does not: a divisor that is never 0.
#[inline(always)]
fn upper<R: Real>(h: Vector<R>) -> (R::Mask, R) {
    let inside = h.z.gt(R::ZERO);
    (inside, R::select(inside, h.z, R::ONE))
}

/// [`upper`] of an unrounded vector.
#[inline(always)]
fn upper_carried<R: Real>(h: Vector<Twofold<R>>) -> (R::Mask, Twofold<R>) {
    let inside = h.z.high.gt(R::ZERO);
    (inside, Twofold::select(inside, h.z, Twofold::new(R::ONE)))
}
