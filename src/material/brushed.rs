//! Brushed metal: a conductor whose microfacets are wider across the brush marks than along them (Mihaylov 2013, §3.1.4).
//!
//! Twin: `wgsl/brushed.wgsl`. The marks run along the local axis of the *smaller* width; a frame whose tangent follows them
//! ([`Frame::from_normal_and_tangent`](crate::Frame::from_normal_and_tangent)) brushes a plane along, a lid around. Highlights stretch
//! across the marks.
//!
//! ```
//! use brdf::Vector;
//! use brdf::material::brushed::{Brushed, Shape};
//! use brdf::material::metal;
//!
//! let steel = metal::by_name("iron").unwrap();
//! let lid = Brushed { n: steel.n, k: steel.k, alpha_x: 0.05, alpha_y: 0.4, shape: Shape::Ggx };
//! let wo = Vector::from_angles(0.7, 0.3);
//! let sample = lid.sample(wo, [0.1, 0.6, 0.3]).unwrap();
//! let weight = lid.evaluate(sample.wi, wo).map(|f| f * sample.wi.z / sample.pdf);
//! assert!(weight.iter().all(|w| *w <= 1.0));
//! ```
//!
//! # Two shapes
//!
//! [`Shape::Ggx`] masks by Smith's rule for correlated heights, [`Shape::Beckmann`] by V-cavities, as every other Beckmann interface of
//! this crate does: equal widths give [`torrance_sparrow`](crate::microfacet::torrance_sparrow) itself. Under either the normals that a view
//! sees have a density that integrates to 1, so directions drawn from it weigh F·G/G₁ ≤ F, and with F = 1 no view reflects
//! more than arrives.

use crate::distribution;
use crate::frame::Vector;
use crate::fresnel;
use crate::masking;
use crate::microfacet::cos_half_carried;
use crate::real::{Mask, Real};
use crate::sampling::{Sample, below_one};

/// The distribution of a brushed metal's facets, and the masking that goes with it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Shape {
    /// GGX under Smith's masking, heights correlated: long tails, as of abraded metal.
    #[default]
    Ggx,
    /// Beckmann's under V-cavities: the documents' lobe.
    Beckmann,
}

/// A conductor with a width along the tangent and one along the bitangent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brushed<R, const C: usize> {
    /// The real part of the index relative to the medium above, > 0, for each channel.
    pub n: [R; C],
    /// The imaginary part, ≥ 0.
    pub k: [R; C],
    /// The width along the tangent, in [1e-4, 1].
    pub alpha_x: R,
    /// The width along the bitangent, in [1e-4, 1].
    pub alpha_y: R,
    /// The distribution of its facets.
    pub shape: Shape,
}

impl<R: Real, const C: usize> Brushed<R, C> {
    /// f = F·D·V in sr⁻¹; 0 where a cosine is ≤ 0. See [`evaluate_ggx`], [`evaluate_beckmann`].
    #[inline]
    pub fn evaluate(&self, wi: impl Into<Vector<R>>, wo: impl Into<Vector<R>>) -> [R; C] {
        let evaluate = match self.shape {
            Shape::Ggx => evaluate_ggx,
            Shape::Beckmann => evaluate_beckmann,
        };
        evaluate(wi.into(), wo.into(), self.n, self.k, self.alpha_x, self.alpha_y)
    }

    /// A direction drawn from the normals that `wo` sees, and its density; `u` three numbers in [0, 1).
    ///
    /// None where `wo` is at or below the horizon, and where a facet reflects into the surface: such a sample counts as 0.
    /// f·cos/pdf is F·G/G₁, at most 1. See [`reflect_visible_ggx`], [`reflect_visible_beckmann`].
    #[inline]
    pub fn sample(&self, wo: impl Into<Vector<R>>, u: [R; 3]) -> Option<Sample<R>> {
        let wo = wo.into();
        let wi = match self.shape {
            Shape::Ggx => reflect_visible_ggx(wo, self.alpha_x, self.alpha_y, [u[0], u[1]]),
            Shape::Beckmann => reflect_visible_beckmann(wo, self.alpha_x, self.alpha_y, u),
        };
        let pdf = self.pdf(wi, wo);
        pdf.gt(R::ZERO).all().then_some(Sample { wi, pdf })
    }

    /// The density in sr⁻¹ with which [`Brushed::sample`] draws `wi` for the view `wo`. 0 where a cosine is ≤ 0.
    #[inline]
    pub fn pdf(&self, wi: impl Into<Vector<R>>, wo: impl Into<Vector<R>>) -> R {
        let pdf = match self.shape {
            Shape::Ggx => reflect_visible_ggx_pdf,
            Shape::Beckmann => reflect_visible_beckmann_pdf,
        };
        pdf(wi.into(), wo.into(), self.alpha_x, self.alpha_y)
    }
}

/// D·V of GGX with two widths under Smith's masking of correlated heights: the BRDF for F = 1.
///
/// In plain text: D·G/(4·NL·NV), D of [`distribution::ggx_anisotropic`], G of [`masking::smith_ggx`]. At equal widths: that
/// of [`distribution::ggx`]. 0 where a cosine is ≤ 0.
///
/// Error in f32: ≤ 0.6 ULP. Source: Heitz 2014, eq. 85, 86 and 99.
#[inline]
pub fn ggx<R: Real>(wi: Vector<R>, wo: Vector<R>, alpha_x: R, alpha_y: R) -> R {
    R::narrow(ggx_wide(wi.widen(), wo.widen(), alpha_x.widen(), alpha_y.widen()))
}

#[inline(always)]
fn ggx_wide<W: Real>(wi: Vector<W>, wo: Vector<W>, alpha_x: W, alpha_y: W) -> W {
    let visibility = masking::smith_ggx_wide(wi, wo, alpha_x, alpha_y).visibility;
    distribution::ggx_anisotropic_wide(upper(wi, wo), alpha_x, alpha_y) * visibility
}

/// D·V of Beckmann's distribution with two widths under V-cavities: the BRDF for F = 1.
///
/// In plain text: D·G/(4·NL·NV), D of [`distribution::beckmann_anisotropic`], G of [`masking::v_cavity`]. At equal widths: the
/// lobe of [`facets`](crate::microfacet::facets). 0 where a cosine is ≤ 0.
///
/// Error in f32: ≤ 0.6 ULP. Source: Heitz 2014, eq. 75; Torrance & Sparrow 1967.
#[inline]
pub fn beckmann<R: Real>(wi: Vector<R>, wo: Vector<R>, alpha_x: R, alpha_y: R) -> R {
    R::narrow(beckmann_wide::<_, R>(wi.widen(), wo.widen(), alpha_x.widen(), alpha_y.widen()))
}

#[inline(always)]
fn beckmann_wide<W: Real, R: Real<Wide = W>>(wi: Vector<W>, wo: Vector<W>, alpha_x: W, alpha_y: W) -> W {
    let h = upper(wi, wo);
    distribution::beckmann_anisotropic_wide::<_, R>(h, alpha_x, alpha_y)
        * masking::v_cavity_wide(wi.z, wo.z, h).visibility
}

/// The half vector; one at the horizon, where D is 0, for directions of which one is not above it.
#[inline(always)]
fn upper<W: Real>(wi: Vector<W>, wo: Vector<W>) -> Vector<W> {
    let lit = wi.z.gt(W::ZERO) & wo.z.gt(W::ZERO);
    let h = wi + wo;
    Vector::new(h.x, h.y, W::select(lit, h.z, W::ZERO))
}

/// F·D·V of a conductor: [`ggx`] times the exact Fresnel reflectance at V·H of each channel.
///
/// `n` > 0 and `k` ≥ 0 relative to the medium above. Error in f32: ≤ 0.6 ULP.
#[inline]
pub fn evaluate_ggx<R: Real, const C: usize>(
    wi: Vector<R>,
    wo: Vector<R>,
    n: [R; C],
    k: [R; C],
    alpha_x: R,
    alpha_y: R,
) -> [R; C] {
    reflected(wi, wo, n, k, ggx_wide(wi.widen(), wo.widen(), alpha_x.widen(), alpha_y.widen()))
}

/// F·D·V of a conductor: [`beckmann`] times the exact Fresnel reflectance at V·H of each channel.
///
/// `n` > 0 and `k` ≥ 0 relative to the medium above. Error in f32: ≤ 0.6 ULP.
#[inline]
pub fn evaluate_beckmann<R: Real, const C: usize>(
    wi: Vector<R>,
    wo: Vector<R>,
    n: [R; C],
    k: [R; C],
    alpha_x: R,
    alpha_y: R,
) -> [R; C] {
    reflected(wi, wo, n, k, beckmann_wide::<_, R>(wi.widen(), wo.widen(), alpha_x.widen(), alpha_y.widen()))
}

#[inline(always)]
fn reflected<R: Real, const C: usize>(wi: Vector<R>, wo: Vector<R>, n: [R; C], k: [R; C], lobe: R::Wide) -> [R; C] {
    let cos_half = cos_half_carried(wi.widen(), wo.widen());
    core::array::from_fn(|c| {
        let fresnel = fresnel::conductor_carried::<_, R>(cos_half, n[c].widen(), k[c].widen());
        R::narrow(fresnel.reflectance * lobe)
    })
}

/// A direction that GGX facets reflect `wo` to, drawn from the normals that `wo` sees.
///
/// The view is stretched by the widths, a point of the spherical cap below it is drawn evenly, and their sum, stretched
/// back, is the normal.
///
/// `wo`: a local unit vector, `wo.z` > 0. Widths in [1e-4, 1]. `u`: numbers in [0, 1). The result may lie below the
/// horizon, where the BRDF is 0. Its density is [`reflect_visible_ggx_pdf`].
///
/// Source: Dupuy & Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps", listing 3; the distribution by Heitz 2018.
#[inline]
pub fn reflect_visible_ggx<R: Real>(wo: Vector<R>, alpha_x: R, alpha_y: R, u: [R; 2]) -> Vector<R> {
    let stretched = Vector::new(alpha_x * wo.x, alpha_y * wo.y, wo.z);
    let square = stretched.length_squared();
    let v = stretched * (R::ONE / R::select(square.gt(R::ZERO), square, R::ONE).sqrt());
    // The cap reaches from the pole, 1, down to −v.z; `fall` is the way down to the point.
    let share = below_one(u[1]);
    let reach = R::ONE + v.z;
    let fall = share * reach;
    let radius = (fall * (R::TWO - fall)).max(R::ZERO).sqrt();
    let (cosine, sine) = u[0].unit_circle();
    let m = Vector::new(alpha_x * (radius * cosine + v.x), alpha_y * (radius * sine + v.y), (R::ONE - share) * reach);
    let square = m.length_squared();
    let along = R::TWO * wo.dot(m) / R::select(square.gt(R::ZERO), square, R::ONE);
    m * along - wo
}

/// The density in sr⁻¹ with which [`reflect_visible_ggx`] draws `wi`: D·G₁/(4·NV).
///
/// $$p = \frac{D}{4\,\sigma(V)}$$
///
/// In plain text: p = D/(4σ), σ = NV/G₁ the projected area ([`masking::projected_area_ggx`]). 0 where a cosine is ≤ 0. Bounded as NV
/// goes to 0.
///
/// Error in f32: ≤ 0.6 ULP. Source: Heitz 2018, eq. 3 and 19.
#[inline]
pub fn reflect_visible_ggx_pdf<R: Real>(wi: Vector<R>, wo: Vector<R>, alpha_x: R, alpha_y: R) -> R {
    let (wi, wo, alpha_x, alpha_y) = (wi.widen(), wo.widen(), alpha_x.widen(), alpha_y.widen());
    let d = distribution::ggx_anisotropic_wide(upper(wi, wo), alpha_x, alpha_y);
    let area = masking::projected_area_ggx_wide(wo, alpha_x, alpha_y);
    let lit = wo.z.gt(R::Wide::ZERO);
    R::narrow(d / (R::Wide::from_f64(4.0) * R::Wide::select(lit, area, R::Wide::ONE)))
}

/// A direction that Beckmann's facets of two widths reflect `wo` to, drawn from the normals that `wo` sees of V-cavities.
///
/// As [`reflect_visible`](crate::sampling::reflect_visible), with a width for each slope. Its density is [`reflect_visible_beckmann_pdf`].
///
/// Source: Heitz & d'Eon 2014, §4.
#[inline]
pub fn reflect_visible_beckmann<R: Real>(wo: Vector<R>, alpha_x: R, alpha_y: R, u: [R; 3]) -> Vector<R> {
    // The slopes of m are Gaussian.
    let radius = (-(-below_one(u[1])).ln_one_plus()).max(R::ZERO).sqrt();
    let (cosine, sine) = u[2].unit_circle();
    let (x, y) = (alpha_x * radius * cosine, alpha_y * radius * sine);
    let across = x * wo.x + y * wo.y;
    // V·m/(V·m + V·m′) of m = (x, y, 1), whose sum is 2·V.z.
    let first = (R::TWO * wo.z * below_one(u[0])).lt(wo.z + across);
    let sign = R::select(first, R::ONE, -R::ONE);
    let (x, y, across) = (sign * x, sign * y, sign * across);
    let square = x * x + y * y;
    let scale = R::ONE / (R::ONE + square);
    let along = R::TWO * (wo.z + across) * scale;
    Vector::new(along * x - wo.x, along * y - wo.y, (wo.z * (R::ONE - square) + R::TWO * across) * scale)
}

/// The density in sr⁻¹ with which [`reflect_visible_beckmann`] draws `wi`: D·G₁/(4·NV).
///
/// In plain text: p = D·min(1/(4·NV), hz/|h|²) with h = wi + wo. 0 where a cosine is ≤ 0. Bounded as NV goes to 0.
///
/// Error in f32: ≤ 0.6 ULP. Source: Heitz & d'Eon 2014, eq. 2 and 8.
#[inline]
pub fn reflect_visible_beckmann_pdf<R: Real>(wi: Vector<R>, wo: Vector<R>, alpha_x: R, alpha_y: R) -> R {
    let (wi, wo) = (wi.widen(), wo.widen());
    let h = upper(wi, wo);
    let lit = h.z.gt(R::Wide::ZERO);
    let guard = |x: R::Wide| R::Wide::select(lit, x, R::Wide::ONE);
    let seen = (h.z / guard(h.length_squared())).min(R::Wide::ONE / guard(R::Wide::from_f64(4.0) * wo.z));
    let d = distribution::beckmann_anisotropic_wide::<_, R>(h, alpha_x.widen(), alpha_y.widen());
    R::narrow(d * seen)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::microfacet;

    const SHAPES: [Shape; 2] = [Shape::Ggx, Shape::Beckmann];
    const WIDTHS: [(f64, f64); 4] = [(0.05, 0.4), (0.3, 0.3), (0.7, 0.2), (0.15, 1.0)];

    /// Numbers in a cube, by an additive recurrence (Roberts 2018).
    fn points(count: u32) -> impl Iterator<Item = [f64; 6]> {
        const STEP: [f64; 6] = [0.884_271, 0.781_934, 0.691_442, 0.611_421, 0.540_661, 0.478_090];
        (1..=count).map(|i| STEP.map(|step| (0.5 + f64::from(i) * step).fract()))
    }

    fn direction(cosine: f64, turn: f64) -> Vector<f64> {
        let ((c, s), sine) = (turn.unit_circle(), ((1.0 - cosine) * (1.0 + cosine)).sqrt());
        Vector::new(sine * c, sine * s, cosine)
    }

    fn metal(shape: Shape, (alpha_x, alpha_y): (f64, f64)) -> Brushed<f64, 1> {
        Brushed { n: [0.2], k: [4.0], alpha_x, alpha_y, shape }
    }

    /// A conductor that reflects everything, to 4e-9.
    fn mirror(shape: Shape, (alpha_x, alpha_y): (f64, f64)) -> Brushed<f64, 1> {
        Brushed { n: [1.0], k: [1e9], alpha_x, alpha_y, shape }
    }

    #[test]
    fn equal_widths_are_the_isotropic_terms() {
        for [a, b, c, d, e, _] in points(2000) {
            let (wi, wo, alpha) = (direction(a, b), direction(c, d), 0.02 + 0.98 * e);
            // Exponents of up to 708 magnify what two roundings of theirs differ by.
            let close = |got: f64, want: f64| (got - want).abs() <= 4.0 * 708.0 * f64::EPSILON * want;
            let h = wi + wo;
            let isotropic = distribution::ggx(h, alpha) * masking::smith_ggx(wi, wo, alpha, alpha).visibility;
            assert!(close(ggx(wi, wo, alpha, alpha), isotropic), "{wi:?} {wo:?} {alpha}");
            assert!(close(beckmann(wi, wo, alpha, alpha), microfacet::facets(wi, wo, alpha).lobe));
            let printed = microfacet::torrance_sparrow(wi, wo, 0.2, 4.0, alpha).f;
            assert!(close(metal(Shape::Beckmann, (alpha, alpha)).evaluate(wi, wo)[0], printed));
            let (ours, theirs) = (
                reflect_visible_beckmann(wo, alpha, alpha, [a, b, e]),
                crate::sampling::reflect_visible(wo, alpha, [a, b, e]),
            );
            assert!((ours - theirs).length_squared() < 1e-28, "{ours:?} {theirs:?}");
            assert!(close(
                reflect_visible_beckmann_pdf(wi, wo, alpha, alpha),
                crate::sampling::reflect_visible_pdf(wi, wo, alpha)
            ));
        }
    }

    #[test]
    fn it_is_reciprocal_and_turns_with_its_axes() {
        for ([a, b, c, d, ..], widths) in points(2000).zip(WIDTHS.into_iter().cycle()) {
            let (wi, wo) = (direction(a, b), direction(c, d));
            let turned = |w: Vector<f64>| Vector::new(w.y, w.x, w.z);
            for shape in SHAPES {
                let f = metal(shape, widths).evaluate(wi, wo)[0];
                assert_eq!(f, metal(shape, widths).evaluate(wo, wi)[0]);
                let other = metal(shape, (widths.1, widths.0)).evaluate(turned(wi), turned(wo))[0];
                assert!((f - other).abs() <= 1e-13 * f, "{f} {other}");
                let below = Vector::new(wi.x, wi.y, -wi.z);
                assert_eq!([metal(shape, widths).evaluate(below, wo)[0], metal(shape, widths).pdf(wi, -wo)], [0.0; 2]);
            }
        }
    }

    #[test]
    fn weights_are_at_most_one() {
        for ([a, b, c, d, e, f], widths) in points(20_000).zip(WIDTHS.into_iter().cycle()) {
            // A third of the views within a thousandth of grazing.
            let wo = direction(if f < 0.3 { 1e-3 * c } else { c }, d);
            for shape in SHAPES {
                let subject = mirror(shape, widths);
                if let Some(sample) = subject.sample(wo, [a, b, e]) {
                    assert!((sample.wi.length_squared() - 1.0).abs() < 1e-12, "{sample:?}");
                    let weight = subject.evaluate(sample.wi, wo)[0] * sample.wi.z / sample.pdf;
                    assert!(weight <= 1.0 + 1e-9 && weight > 0.0, "{shape:?} {widths:?} {wo:?}: {weight}");
                }
            }
        }
    }

    /// ∫ p over the upper hemisphere in `u` = cosθ and azimuth, by the midpoint rule in each cell.
    fn masses(subject: &Brushed<f64, 1>, wo: Vector<f64>, cells: [usize; 2], steps: usize) -> Vec<f64> {
        let mut masses = Vec::new();
        for i in 0..cells[0] {
            for j in 0..cells[1] {
                let (mut sum, side) = (0.0, steps as f64);
                for p in 0..steps * steps {
                    let u = (i as f64 + ((p / steps) as f64 + 0.5) / side) / cells[0] as f64;
                    let turn = (j as f64 + ((p % steps) as f64 + 0.5) / side) / cells[1] as f64;
                    sum += subject.pdf(direction(u, turn), wo);
                }
                masses.push(sum * core::f64::consts::TAU / (side * side * (cells[0] * cells[1]) as f64));
            }
        }
        masses
    }

    #[test]
    fn samples_follow_their_density() {
        const CELLS: [usize; 2] = [12, 24];
        const SAMPLES: u32 = 200_000;
        for (widths, cosine) in [((0.15, 0.6), 0.8), ((0.5, 0.2), 0.3), ((0.3, 0.9), 0.05)] {
            for shape in SHAPES {
                let (subject, wo) = (metal(shape, widths), direction(cosine, 0.1));
                let masses = masses(&subject, wo, CELLS, 24);
                let mut counts = vec![0.0; masses.len()];
                for i in 0..SAMPLES {
                    let words = crate::random::random_words([i, 5, 7, 9]);
                    let u = [0, 1, 2].map(|d| f64::from(words[d] >> 8) / 16_777_216.0);
                    if let Some(Sample { wi, .. }) = subject.sample(wo, u) {
                        let turn = (wi.y.atan2(wi.x) / core::f64::consts::TAU).rem_euclid(1.0);
                        let cell = |u: f64, cells: usize| ((u * cells as f64) as usize).min(cells - 1);
                        counts[cell(wi.z, CELLS[0]) * CELLS[1] + cell(turn, CELLS[1])] += 1.0;
                    }
                }
                let (mut chi, mut freedom) = (0.0, 0.0);
                for (count, mass) in counts.iter().zip(&masses) {
                    let expected = mass * f64::from(SAMPLES);
                    if expected > 20.0 {
                        chi += (count - expected).powi(2) / expected;
                        freedom += 1.0;
                    }
                }
                // Six tests at a total of 1e-3: 3.8 standard deviations √(2·freedom).
                let limit = freedom + 3.8 * f64::sqrt(2.0 * freedom);
                assert!(freedom > 30.0 && chi < limit, "{shape:?} {widths:?} {cosine}: {chi} of {limit}");
                // What is drawn below the horizon is missing.
                let (whole, kept) = (masses.iter().sum::<f64>(), counts.iter().sum::<f64>() / f64::from(SAMPLES));
                let deviation = (kept * (1.0 - kept) / f64::from(SAMPLES)).sqrt();
                assert!(whole <= 1.0 + 1e-3 && (whole - kept).abs() < 4.0 * deviation + 1e-3, "{whole} {kept}");
            }
        }
    }

    #[test]
    fn single_precision_is_the_rounding_of_double() {
        for ([a, b, c, d, ..], widths) in points(5000).zip(WIDTHS.into_iter().cycle()) {
            let [wi, wo] = [direction(a, b), direction(c, d)].map(|w| w.cast::<f32>());
            let (x, y) = (widths.0 as f32, widths.1 as f32);
            let (i, o, p, q) = (wi.cast::<f64>(), wo.cast::<f64>(), f64::from(x), f64::from(y));
            let pairs = [
                (ggx(wi, wo, x, y), ggx(i, o, p, q)),
                (beckmann(wi, wo, x, y), beckmann(i, o, p, q)),
                (reflect_visible_ggx_pdf(wi, wo, x, y), reflect_visible_ggx_pdf(i, o, p, q)),
                (reflect_visible_beckmann_pdf(wi, wo, x, y), reflect_visible_beckmann_pdf(i, o, p, q)),
            ];
            for (got, want) in pairs.into_iter().filter(|pair| pair.1 > 1e-29) {
                // An ULP is at least ε/2 of the result.
                assert!((f64::from(got) - want).abs() <= 0.6 * f64::from(f32::EPSILON) * want, "{got} {want}");
            }
        }
    }

    #[test]
    fn nothing_panics() {
        let numbers = [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e-300, 0.5, 1e20];
        for a in numbers {
            for b in numbers {
                for shape in SHAPES {
                    let subject = Brushed { n: [a, b], k: [b, a], alpha_x: a, alpha_y: b, shape };
                    let w = Vector::new(a, b, 0.5);
                    let _ = (subject.evaluate(w, w), subject.pdf(w, w), subject.sample(w, [a, b, 0.5]));
                }
            }
        }
    }

    #[cfg(feature = "check")]
    #[test]
    fn it_is_plausible() {
        for shape in SHAPES {
            let subject = metal(shape, (0.15, 0.5));
            crate::check::assert_plausible(&crate::check::from_fn("brushed", 1, move |wi, wo, f| {
                f.copy_from_slice(&subject.evaluate(wi, wo));
            }));
        }
    }
}
