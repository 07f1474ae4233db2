//! What of a blurred environment a view sees: the lobes and cosines that a part's layers reflect it to, without sampling.

use crate::absorption::transmittance;
use crate::frame::Vector;
use crate::layered::model::interface_fresnel;
use crate::layered::{Interface, Layer, Medium, Model};
use crate::real::{Mask, Real};
use crate::refraction::refract;

/// Light from one direction of a blurred environment, as [`Spot::mirrored`](super::Spot::mirrored) lists it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror<R> {
    /// Where it comes from: the mirror direction of a lobe, the normal of a diffuse base.
    pub direction: Vector<R>,
    /// How wide the lobe is, as the α of a single interface; of no meaning for a diffuse base.
    pub alpha: R,
    /// Whether the environment is blurred by a cosine (its irradiance over π) and not by a lobe.
    pub diffuse: bool,
    /// What the blurred radiance is multiplied by.
    pub weight: [R; 3],
}

pub(super) fn mirror_of<R: Real>(wo: Vector<R>) -> Vector<R> {
    Vector::new(-wo.x, -wo.y, wo.z)
}

fn cosine<R: Real>(weight: [R; 3]) -> Mirror<R> {
    Mirror { direction: Vector::new(R::ZERO, R::ZERO, R::ONE), alpha: R::ONE, diffuse: true, weight }
}

/// The cosine of the documents' diffuse term over an interface: (1 − σ)·(1 − F), F at the half vector of the view and the normal.
pub(super) fn scattered<R: Real>(sigma: [R; 3], n: [R; 3], k: [R; 3], wo: Vector<R>) -> Mirror<R> {
    let cos_h = ((R::ONE + wo.z) * R::HALF).sqrt();
    cosine(core::array::from_fn(|c| (R::ONE - sigma[c]) * (R::ONE - interface_fresnel(cos_h, n[c], k[c]).reflectance)))
}

/// The lobes and the cosine that layers reflect a view to; `again`: what bounces between a base and its coats add to its albedo.
pub(super) fn mirrors<R: Real>(
    layers: impl Iterator<Item = Layer<R, 3>>,
    model: Model,
    again: [R; 3],
    wo: Vector<R>,
    visit: &mut impl FnMut(Mirror<R>),
) {
    // What passes on the way of the view, and of light from 60° to the normal.
    let (mut seen, mut lit) = ([R::ONE; 3], [R::ONE; 3]);
    let (mut view, mut light) = (wo, Vector::new(R::from_f64(0.75).sqrt(), R::ZERO, R::HALF));
    let (mut n_above, mut least) = (R::ONE, R::ONE);
    for layer in layers {
        let (n, k, alpha) = match layer.interface {
            Interface::Microfacet { n, k, alpha } => (n, k, alpha),
            Interface::Diffuse { albedo, .. } => {
                let through = |c: usize| seen[c] * lit[c] / (n_above * n_above);
                return visit(cosine(core::array::from_fn(|c| (albedo[c] + again[c]) * through(c))));
            }
        };
        let fresnel = |cosine: R| -> [_; 3] {
            core::array::from_fn(|c| interface_fresnel(cosine, n[c] / n_above, k[c] / n_above))
        };
        let (at_view, at_light) = (fresnel(view.z), fresnel(light.z));
        let (leaves, turned) =
            if model == Model::Elek { (R::ONE, R::ZERO) } else { left(view, alpha, (least / n_above).min(R::ONE)) };
        let weight = core::array::from_fn(|c| {
            let out = seen[c] + (lit[c] - seen[c]) * turned;
            at_view[c].reflectance * seen[c] * out * leaves
        });
        let alpha = (alpha * n_above).min(R::ONE);
        visit(Mirror { direction: mirror_of(wo), alpha, diffuse: false, weight });
        if model == Model::Elek {
            return;
        }
        let eta = n[0] / n_above;
        (view, light) = (refract(view, eta), refract(light, eta));
        if !view.z.min(light.z).gt(R::ZERO).any() {
            return;
        }
        let Medium { sigma, thickness } = layer.medium;
        for c in 0..3 {
            // transmittance() is that of both ways; √ of equal ways is one of them.
            let one_way = |cosine: R| transmittance(sigma[c], thickness * R::HALF, cosine, cosine);
            seen[c] = seen[c] * at_view[c].transmittance * one_way(view.z);
            lit[c] = lit[c] * at_light[c].transmittance * one_way(light.z);
        }
        (n_above, least) = (n[0], least.min(n[0]));
    }
}

/// What of a lobe leaves the stack but for what coats reflect back: the part that facets do not mask and that is below the critical angle; and
/// how much of it is far from the mirror direction, so that it passes the coats as light from 60° does.
///
/// $$\tfrac12\left[S\!\left(\frac{s_c-s}{(c_c+c)\alpha}+\frac{\alpha s}{2c}\right)+S\!\left(\frac{s_c+s}{(c_c+c)\alpha}\right)\right]
/// S\!\left(\frac{0.81\,s_c}{(c_c+c)\alpha}\right)(1-0.27\alpha^2c),\quad S(x)=\sqrt{1-e^{-4x^2/\pi}},\quad
/// 1-e^{-\alpha/(14(c-c_c))}$$
///
/// In plain text: with c, s the cosine and sine of the view in the medium of the facets, s_c = `critical` the sine at which light is reflected totally and
/// c_c its cosine: a facet turns the view to the critical direction where its slope is (s_c∓s)/(c_c+c), on either side. Slopes are normal with
/// variance α²/2, and those that the view sees lean towards it by α²/2·tanθ; S is the error function within .7 % (Pólya 1945). Along the plane of
/// incidence both sides bound the lobe, across it one width does. Four numbers are fitted: .81, .27, 14 and 60°.
///
/// Of the albedo for F = 1 under a dielectric: within .06 (rms .017) for n from 1 to 2.4, α up to 1 and every view, where the lobe without it is off by up to
/// .8. The module's tests measure it.
fn left<R: Real>(view: Vector<R>, alpha: R, critical: R) -> (R, R) {
    let number = R::from_f64;
    let cosine = ((R::ONE - critical) * (R::ONE + critical)).sqrt();
    let sine = view.sin_squared().sqrt();
    let upright = R::select(view.z.gt(R::ZERO), view.z, R::ONE);
    let scale = R::ONE / (alpha * (cosine + upright));
    let inside = |x: R| (R::ONE - (-number(4.0) * R::FRAC_1_PI * x * x).exp()).max(R::ZERO).sqrt();
    let near = (critical - sine).max(R::ZERO) * scale + R::HALF * alpha * sine / upright;
    let along = R::HALF * (inside(near) + inside((critical + sine) * scale));
    let across = inside(number(0.81) * critical * scale);
    let unmasked = R::ONE - number(0.27) * alpha * alpha * upright;
    let apart = (upright - cosine).max(number(1e-6));
    (along * across * unmasked, R::ONE - (-alpha / (number(14.0) * apart)).exp())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layered::Stack;
    use crate::material::{Material, Point, Spot};
    use crate::random::random;

    fn direction(cosine: f64) -> Vector<f64> {
        Vector::new(((1.0 - cosine) * (1.0 + cosine)).sqrt(), 0.0, cosine)
    }

    /// What a constant environment of 1 sends to the view.
    fn total(spot: &Spot<'_, f64>, wo: Vector<f64>) -> [f64; 3] {
        let mut sum = [0.0; 3];
        spot.mirrored(wo, &mut |mirror| {
            for (sum, weight) in sum.iter_mut().zip(mirror.weight) {
                *sum += weight;
            }
        });
        sum
    }

    /// By samples of [`Spot::sample`].
    fn albedo(spot: &Spot<'_, f64>, wo: Vector<f64>, samples: u32) -> f64 {
        let weight = |index: u32| {
            let drawn = spot.sample(wo, random(3, index, 0))?;
            Some(spot.reflected(drawn.wi, wo)[1] / drawn.pdf)
        };
        (0..samples).filter_map(weight).sum::<f64>() / f64::from(samples)
    }

    /// A mirror of ever wider facets, bare and under ever denser coats: what is fitted is within what its documentation says.
    #[test]
    fn rough_lobes_keep_what_leaves_the_stack() {
        let mirror = |alpha| Layer::new(Interface::conductor([0.1; 3], [9.0; 3], alpha));
        let (mut squares, mut count) = (0.0f64, 0.0);
        for n in [1.0, 1.2, 1.5, 1.8, 2.4] {
            for alpha in [0.01, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0] {
                let mut layers = std::vec![mirror(alpha)];
                if n > 1.0 {
                    layers.insert(0, Layer::new(Interface::dielectric(n, 0.001)));
                }
                let material = Material::from(Stack::new(Model::Conserving, layers).expect("a stack"));
                for cosine in [1.0, 0.8, 0.6, 0.4, 0.2, 0.1] {
                    let (spot, wo) = (material.at(&Point::<f64>::default()), direction(cosine));
                    let off = total(&spot, wo)[1] - albedo(&spot, wo, 10_000);
                    // Four deviations of samples whose weights vary by .3 are .012.
                    assert!(off.abs() < 0.06 + 0.012, "{n} {alpha} {cosine}: {off}");
                    squares += off * off;
                    count += 1.0;
                }
            }
        }
        let rms = (squares / count).sqrt();
        assert!(rms < 0.017 + 0.003, "{rms}");
    }

    /// The documents' Algorithm 1, lines 28–29: one lobe, of the upper layer's F and width, whatever lies beneath.
    #[test]
    fn the_documents_reflect_the_environment_from_the_upper_layer_alone() {
        let layers = || {
            std::vec![
                Layer::new(Interface::dielectric(1.5, 0.1)),
                Layer::new(Interface::conductor([0.2; 3], [4.0; 3], 0.3))
            ]
        };
        for (model, count) in [(Model::Elek, 1), (Model::Conserving, 2)] {
            let material = Material::from(Stack::new(model, layers()).expect("a stack"));
            let mut lobes = std::vec::Vec::new();
            material.at(&Point::<f64>::default()).mirrored(direction(0.6), &mut |mirror| lobes.push(mirror));
            assert_eq!(lobes.len(), count, "{model:?}");
            let reflectance = crate::fresnel::dielectric(0.6, 1.5).reflectance;
            let upper = lobes.first().expect("a lobe");
            // The documents' keeps all of F; of ours facets mask a part, .27·α²·cosθ, and the narrow lobe loses nothing at its edges.
            let kept = if model == Model::Elek { 1.0 } else { 1.0 - 0.27 * 0.01 * 0.6 };
            assert!((upper.weight[0] - kept * reflectance).abs() < 1e-6 && upper.alpha == 0.1, "{upper:?}");
            assert!(!upper.diffuse && (model != Model::Elek || upper.weight[0] == reflectance), "{upper:?}");
        }
    }

    /// Under `coupled` and `walk` the light that comes back to the base is in both. Without it, a white furnace shows half.
    #[test]
    fn coats_send_light_back_to_a_base() {
        let layers = |n: f64, tint: f64| {
            let coat = Layer::new(Interface::dielectric(n, 0.01)).over([tint; 3], 0.2);
            std::vec![coat, Layer::new(Interface::diffuse([0.9; 3], 0.0))]
        };
        for model in [Model::Conserving, Model::Coupled] {
            for (n, tint) in [(1.5, 0.0), (1.9, 0.0), (1.5, 0.5)] {
                let material = Material::from(Stack::new(model, layers(n, tint)).expect("a stack"));
                for cosine in [1.0, 0.8, 0.5] {
                    let spot = material.at(&Point::<f64>::default());
                    let (ours, theirs) =
                        (total(&spot, direction(cosine))[1], albedo(&spot, direction(cosine), 200_000));
                    // T̄ by one direction: 1 % without absorption, 3 % with it; and .5 % of the samples.
                    let room = if tint == 0.0 { 0.015 } else { 0.035 };
                    assert!((ours / theirs - 1.0).abs() < room, "{model:?} {n} {tint} {cosine}: {ours} {theirs}");
                }
            }
        }
        let total = |model| {
            let material = Material::from(Stack::new(model, layers(1.5, 0.0)).expect("a stack"));
            total(&material.at(&Point::<f64>::default()), direction(0.8))
        };
        assert_eq!(total(Model::Walk), total(Model::Coupled));
    }

    /// The cosine of the documents' diffuse term against its mean over all light.
    #[test]
    fn the_printed_term_is_within_three_percent_of_its_mean() {
        for (n, k) in [(1.5, 0.0), (2.0, 0.0), (2.83, 0.19), (3.0, 0.3)] {
            for cosine in [1.0, 0.9, 0.6, 0.3, 0.1, 0.02] {
                let wo = direction(cosine);
                let ours = scattered([0.25; 3], [n; 3], [k; 3], wo).weight[0];
                const SAMPLES: u32 = 40_000;
                let mean = (0..SAMPLES)
                    .map(|index| {
                        let [u, v, ..] = random::<f64>(5, index, 0);
                        let cos_h = crate::microfacet::cos_half(crate::sampling::cosine_hemisphere([u, v]), wo);
                        crate::material::patina::diffuse_as_printed(
                            0.25,
                            interface_fresnel(cos_h, n, k).reflectance,
                            1.0,
                        )
                    })
                    .sum::<f64>()
                    / f64::from(SAMPLES);
                assert!((ours / mean - 1.0).abs() < 0.03, "{n} {k} {cosine}: {ours} {mean}");
            }
        }
    }
}
