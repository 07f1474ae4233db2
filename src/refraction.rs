//! Refraction of directions at a smooth interface (Snell's law).
//!
//! Twin: `wgsl/refraction.wgsl`. Refracted directions point *away* from the surface and upward, as all directions of
//! this crate do: they are what the light or viewer direction becomes seen from an interface below.

use crate::frame::Vector;
use crate::fresnel::{refracted_square_carried, refracted_square_wide};
use crate::real::Real;
use crate::twofold::Twofold;

/// The cosine of the refracted ray, 0 on total reflection.
///
/// $$\cos\theta_t = \frac{1}{\eta}\sqrt{\eta^2-1+\cos^2\theta_i}$$
///
/// In plain text: cos_t = √(η²−1+cos_i²)/η. `cos_i` in [0, 1], `eta` = n_t/n_i > 0. At η = 1: cos_i.
///
/// Error in f32: ≤ 0.6 ULP for η in [1/4, 4], the critical angle included. Source: Snell; Mihaylov 2013, eq. 3.3.
#[inline(always)]
pub fn cos_t<R: Real>(cos_i: R, eta: R) -> R {
    let (cos_i, eta) = (cos_i.widen(), eta.widen());
    R::narrow(refracted_square_wide::<_, R>(cos_i, eta).max(R::Wide::ZERO).sqrt() / eta)
}

/// A local direction refracted about the normal, pointing away from the surface.
///
/// In plain text: (x/η, y/η, cos_t). `w` is a local unit vector with `w.z` ≥ 0, `eta` = n_t/n_i > 0. On total
/// reflection, and from a direction at or below the horizon that has no refracted ray, `z` is 0: nothing is transmitted.
///
/// Error in f32: ≤ 0.6 ULP of each component. Source: Snell; Elek 2010, Algorithm 1, lines 7–8, which print
/// −refract(L, N, 1/n); that flips the tangential part (erratum 9).
#[inline(always)]
pub fn refract<R: Real>(w: Vector<R>, eta: R) -> Vector<R> {
    Vector::new(w.x / eta, w.y / eta, cos_t(w.z, eta))
}

/// A direction refracted about a microfacet's normal, pointing away from the surface.
///
/// $$w' = \frac{w}{\eta} + m\left(\cos\theta_t - \frac{w\cdot m}{\eta}\right)$$
///
/// In plain text: w/η + m·(cos_t − (w·m)/η). `w` and `m` are unit vectors with w·m ≥ 0, `eta` = n_t/n_i > 0. On total
/// reflection the result is the zero vector. It may point below the horizon: `z` ≤ 0 means that nothing gets there.
///
/// Two directions refracted about their own half vector keep it. Error in f32: ≤ 1 ULP of each component, past 0.6 only where it cancels.
/// Source: Weidlich & Wilkie 2007, §5.2; Walter et al. 2007, eq. 40.
#[inline(always)]
pub fn refract_about<R: Real>(w: Vector<R>, m: Vector<R>, eta: R) -> Vector<R> {
    let (w, m, eta) = (w.widen(), m.widen(), eta.widen());
    let cos_i = Twofold::product(w.x, m.x) + Twofold::product(w.y, m.y) + Twofold::product(w.z, m.z);
    let cos_i = cos_i.at_most_one();
    let square = refracted_square_carried::<_, R>(cos_i, eta);
    let transmitted = square.high.gt(R::Wide::ZERO);
    let cos_t = square.sqrt() / eta;
    let along = cos_t - cos_i / eta;
    let component = |w: R::Wide, m: R::Wide| {
        R::narrow(R::Wide::select(transmitted, (Twofold::new(w) / eta + along * m).rounded(), R::Wide::ZERO))
    };
    Vector::new(component(w.x, m.x), component(w.y, m.y), component(w.z, m.z))
}
