//! The Fresnel reflectance of one interface, prepared as a plan prepares it.

use super::chain::{Surface, with_surface};
use super::interface::Reflects;
use super::{Builder, Options};
use crate::batch::Kernel;
use crate::layered::Model;
use crate::real::Real;
use alloc::vec::Vec;

/// The exact Fresnel reflectance of one material with its constants folded: what a renderer multiplies its own lobes with.
///
/// As [`fresnel::conductor`](crate::fresnel::conductor), two to three times faster for three channels. It is a [`Kernel`]
/// from cos_i to F of each channel.
///
/// Error over f32, which computes in f64: ≤ 0.6 ULP; in batches ≤ 8 ULP, as [`fresnel::conductor`](crate::fresnel::conductor).
///
/// ```
/// use brdf::fresnel;
/// use brdf::plan::Reflectance;
///
/// let copper = Reflectance::new([0.213, 1.04, 1.17], [4.05, 2.59, 2.36]);
/// let [_, green, _] = copper.evaluate(0.3f64);
/// assert!((green - fresnel::conductor(0.3, 1.04, 2.59).reflectance).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reflectance<const C: usize>(Surface<C>);

impl<const C: usize> Reflectance<C> {
    /// For the index n + iκ of each channel relative to the medium of incidence; n > 0, κ ≥ 0.
    pub fn new(n: [f64; C], k: [f64; C]) -> Self {
        let (model, options) = (Model::Conserving, &Options::default());
        let builder = Builder { model, options, applied: &mut Vec::new() };
        Reflectance(builder.surface(n, k, 1.0, 1.0))
    }

    /// F of each channel; `cos_i` in [0, 1].
    #[inline]
    pub fn evaluate<R: Real>(&self, cos_i: R) -> [R; C] {
        let fractions = self.fractions(cos_i.widen());
        let mut all = [R::ZERO; C];
        for channel in 0..C {
            let (numerator, denominator) = fractions[channel];
            all[channel] = R::narrow(numerator / denominator);
        }
        all
    }

    #[inline(always)]
    fn fractions<W: Real<Wide = W>>(&self, cos_i: W) -> [(W, W); C] {
        let squared = cos_i * cos_i;
        let rest = (W::ONE - cos_i) * (W::ONE + cos_i);
        with_surface!(&self.0, fresnel => fresnel.reflectance(squared, cos_i, rest))
    }
}

impl<const C: usize> Kernel<1, C> for Reflectance<C> {
    #[inline(always)]
    fn evaluate<R: Real<Wide = R>>(&self, [cos_i]: [R; 1]) -> [R; C] {
        let fractions = self.fractions(cos_i);
        let mut all = [R::ZERO; C];
        for channel in 0..C {
            all[channel] = fractions[channel].0 / fractions[channel].1;
        }
        all
    }
}
