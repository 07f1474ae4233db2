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
    let mut n_above = R::ONE;
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
        let weight = core::array::from_fn(|c| at_view[c].reflectance * seen[c] * seen[c]);
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
        n_above = n[0];
    }
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

    /// By samples of [`Spot::sample`], 200 000 of them.
    fn albedo(spot: &Spot<'_, f64>, wo: Vector<f64>) -> f64 {
        const SAMPLES: u32 = 200_000;
        let weight = |index: u32| {
            let drawn = spot.sample(wo, random(3, index, 0))?;
            Some(spot.reflected(drawn.wi, wo)[1] / drawn.pdf)
        };
        (0..SAMPLES).filter_map(weight).sum::<f64>() / f64::from(SAMPLES)
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
            assert!((upper.weight[0] - reflectance).abs() < 1e-15 && upper.alpha == 0.1 && !upper.diffuse, "{upper:?}");
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
                    let (ours, theirs) = (total(&spot, direction(cosine))[1], albedo(&spot, direction(cosine)));
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
