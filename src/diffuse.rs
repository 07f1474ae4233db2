//! Diffuse reflection: Lambert and Oren–Nayar.
//!
//! Twin: `wgsl/diffuse.wgsl`. Directions are local unit vectors; where a cosine is ≤ 0 the result is 0. `albedo` is the
//! reflectance ρ of the facets in [0, 1], `sigma` the standard deviation of the facets' slope angle in radians.

use crate::frame::Vector;
use crate::real::Real;
use crate::twofold::Twofold;

/// Lambert's BRDF, ρ/π in sr⁻¹ for every pair of directions.
///
/// Error in f32: ≤ 0.6 ULP. Source: Lambert 1760; Mihaylov 2013, eq. 4.2 (without the 1/π).
#[inline(always)]
pub fn lambert<R: Real>(albedo: R) -> R {
    R::narrow(albedo.widen() * R::Wide::FRAC_1_PI)
}

/// The two parts of the Oren–Nayar model, each in units of its own power of the albedo.
///
/// f = ρ/π·(`direct` + ρ·`interreflection`): the geometry is shared by all channels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OrenNayar<R> {
    /// L1·π/ρ: light reflected once.
    pub direct: R,
    /// L2·π/ρ²: light reflected twice.
    pub interreflection: R,
}

impl<W: Real> OrenNayar<W> {
    /// The nearest numbers of a type that computes in `W`.
    #[inline(always)]
    pub(crate) fn narrow<R: Real<Wide = W>>(self) -> OrenNayar<R> {
        OrenNayar { direct: R::narrow(self.direct), interreflection: R::narrow(self.interreflection) }
    }
}

impl<R: Real> OrenNayar<R> {
    /// The BRDF L1 + L2 in sr⁻¹ for facets of this albedo, at least 0.
    ///
    /// L1 alone is negative for σ > .67 in places, the sum for a small albedo and σ > .75; there the model is clamped.
    #[inline(always)]
    pub fn f(self, albedo: R) -> R {
        let (albedo, direct, interreflection) = (albedo.widen(), self.direct.widen(), self.interreflection.widen());
        R::narrow((albedo * R::Wide::FRAC_1_PI * (direct + albedo * interreflection)).max(R::Wide::ZERO))
    }
}

/// The Oren–Nayar model in full, with interreflection.
///
/// $$\frac{\pi}{\rho}L_1 = C_1 + \cos\Delta\phi\,C_2\tan\beta + (1-|\cos\Delta\phi|)\,C_3\tan\tfrac{\alpha+\beta}{2}$$
///
/// $$\frac{\pi}{\rho^2}L_2 = 0.17\,\frac{\sigma^2}{\sigma^2+0.13}\left(1-\cos\Delta\phi\left(\tfrac{2\beta}{\pi}\right)^2\right)$$
///
/// In plain text: L1 = ρ/π·(C1 + cosΔφ·C2·tanβ + (1−|cosΔφ|)·C3·tan((α+β)/2)),
/// L2 = 0.17·ρ²/π·σ²/(σ²+0.13)·(1 − cosΔφ·(2β/π)²); α the larger, β the smaller of the two polar angles;
/// C1 = 1 − 0.5σ²/(σ²+0.33); C2 = 0.45σ²/(σ²+0.09)·sinα, less (2β/π)³ inside for cosΔφ < 0;
/// C3 = 0.125σ²/(σ²+0.09)·(4αβ/π²)². cosΔφ is 0 where a direction is the normal.
///
/// At σ = 0 it is Lambert's. Reciprocal to the last bit. Its albedo reaches 1.051 (σ = .3, grazing): the model itself gains energy there.
///
/// Error in f32: ≤ 1 ULP; past 0.6 only where the terms of `direct` cancel. No trigonometry but two angles, by a polynomial.
/// Source: Oren & Nayar 1994, eq. 27–29 of the technical report; Mihaylov 2013, eq. 4.15–4.23 (with errata 19–21).
#[inline(always)]
pub fn oren_nayar<R: Real>(wi: Vector<R>, wo: Vector<R>, sigma: R) -> OrenNayar<R> {
    oren_nayar_wide::<_, R>(wi.widen(), wo.widen(), sigma.widen()).narrow()
}

/// [`oren_nayar`] in the numbers that it computes with.
#[inline(always)]
pub(crate) fn oren_nayar_wide<W: Real, R: Real<Wide = W>>(wi: Vector<W>, wo: Vector<W>, sigma: W) -> OrenNayar<W> {
    let variance = sigma * sigma;
    let lit = wi.z.gt(W::ZERO) & wo.z.gt(W::ZERO);
    let lit_or_one = |x: W| W::select(lit, x, W::ONE);
    let (sin_i, sin_o) = (wi.sin_squared().sqrt(), wo.sin_squared().sqrt());
    let (cos_i, cos_o) = (lit_or_one(wi.z), lit_or_one(wo.z));

    // The polar angle is the larger where the cosine is the smaller; of two rounded to one cosine, where the sine is larger,
    // or the order of the two would show.
    let i_larger = cos_i.lt(cos_o) | (cos_i.le(cos_o) & sin_i.gt(sin_o));
    let sin_alpha = W::select(i_larger, sin_i, sin_o);
    let (least, most) = (cos_i.min(cos_o), cos_i.max(cos_o));
    let sin_beta = W::select(i_larger, sin_o, sin_i);
    let frac_2_pi = W::TWO * W::FRAC_1_PI;
    let alpha_share = R::angle_wide(sin_alpha, least) * frac_2_pi;
    // β is measured from grazing, where the terms that hold it meet tangents: 2β/π = 1−δ.
    let delta = R::angle_wide(most, sin_beta) * frac_2_pi;
    let beta_share = W::ONE - delta;

    // cosΔφ·sinα·sinβ, and cosΔφ where neither direction is the normal.
    let across = (Twofold::product(wi.x, wo.x) + Twofold::product(wi.y, wo.y)).rounded();
    let product = sin_i * sin_o;
    let tilted = product.gt(W::ZERO);
    let product = W::select(tilted, product, W::ONE);
    let azimuth = (across / product).max(-W::ONE).min(W::ONE);
    // 1−|cosΔφ| as sin²Δφ/(1+|cosΔφ|): at grazing it meets a tangent that would magnify its cancellation.
    let sine = (Twofold::product(wi.x, wo.y) - Twofold::product(wi.y, wo.x)).rounded() / product;
    let sideways = W::select(tilted, sine * sine / (W::ONE + azimuth.abs()), W::ONE);

    let ratio = variance / (variance + W::from_f64(0.09));
    let c1 = W::ONE - W::HALF * variance / (variance + W::from_f64(0.33));
    // Forward: cosΔφ·tanβ·sinα. Backward: cosΔφ·tanβ·(sinα − (1−δ)³), where both are near 1.
    let forward = across / most;
    let three = W::from_f64(3.0);
    let dent = delta * (three - delta * (three - delta)) - least * least / (W::ONE + sin_alpha);
    let slanted = W::select(azimuth.lt(W::ZERO), azimuth * (sin_beta / most) * dent, forward);
    let c2 = W::from_f64(0.45) * ratio * slanted;
    let angles = alpha_share * beta_share;
    let half_tangent = (sin_alpha + sin_beta) / (least + most);
    let c3 = W::from_f64(0.125) * ratio * angles * angles * sideways * half_tangent;
    let second = W::from_f64(0.17) * variance / (variance + W::from_f64(0.13));
    // 1 − cosΔφ·(1−δ)², and for cosΔφ > 0, where that cancels at grazing, (1−cosΔφ) + cosΔφ·δ(2−δ).
    let opposed = W::ONE - azimuth * beta_share * beta_share;
    let aligned = sideways + azimuth * delta * (W::TWO - delta);
    let bounced = W::select(azimuth.gt(W::ZERO), aligned, opposed);
    OrenNayar {
        direct: W::select(lit, c1 + c2 + c3, W::ZERO),
        interreflection: W::select(lit, second * bounced, W::ZERO),
    }
}

/// The qualitative Oren–Nayar model, in sr⁻¹.
///
/// $$f = \frac{\rho}{\pi}\left(A + B\,\max(0,\cos\Delta\phi)\sin\alpha\tan\beta\right)$$
///
/// In plain text: f = ρ/π·(A + B·max(0, cosΔφ)·sinα·tanβ), A = 1 − 0.5σ²/(σ²+0.57), B = 0.45σ²/(σ²+0.09). The constant
/// 0.57 makes up for the interreflection that this form leaves out; the full form's C1 has 0.33.
///
/// Gains energy at grazing for small σ (1.015 at σ = .2, 89.99°). Error in f32: ≤ 0.6 ULP.
/// Source: Oren & Nayar 1994, eq. 30 and the footnote to it.
#[inline(always)]
pub fn oren_nayar_qualitative<R: Real>(wi: Vector<R>, wo: Vector<R>, sigma: R, albedo: R) -> R {
    R::narrow(oren_nayar_qualitative_wide(wi.widen(), wo.widen(), sigma.widen(), albedo.widen()))
}

#[inline(always)]
fn oren_nayar_qualitative_wide<W: Real>(wi: Vector<W>, wo: Vector<W>, sigma: W, albedo: W) -> W {
    let variance = sigma * sigma;
    let lit = wi.z.gt(W::ZERO) & wo.z.gt(W::ZERO);
    let most = W::select(lit, wi.z.max(wo.z), W::ONE);
    let across = (Twofold::product(wi.x, wo.x) + Twofold::product(wi.y, wo.y)).rounded().max(W::ZERO);
    let a = W::ONE - W::HALF * variance / (variance + W::from_f64(0.57));
    let b = W::from_f64(0.45) * variance / (variance + W::from_f64(0.09));
    W::select(lit, albedo * W::FRAC_1_PI * (a + b * across / most), W::ZERO)
}
