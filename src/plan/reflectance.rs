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
/// As [`fresnel::conductor`](crate::fresnel::conductor): a metal takes one division a channel where that term takes four. It is a
/// [`Kernel`] from cos_i to F of each channel.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch;
    use crate::fresnel;

    #[test]
    fn every_form_is_the_exact_term() {
        // Metals, one close to κ = n, dim and bright conductors, dielectrics of either side; and grey ones.
        let materials = [
            ([0.2, 1.0, 1.2], [4.0, 2.6, 2.4]),
            ([3.1, 3.2, 2.9], [3.3, 3.21, 2.95]),
            ([1.5, 2.0, 3.0], [0.01, 0.5, 1.0]),
            ([1.5; 3], [0.0; 3]),
            ([0.7; 3], [0.0; 3]),
            ([0.2; 3], [4.0; 3]),
        ];
        for (n, k) in materials {
            let prepared = Reflectance::new(n, k);
            for i in 1..=1000 {
                let cos = f64::from(i as f32 / 1000.0);
                let exact: [f64; 3] = core::array::from_fn(|c| fresnel::conductor(cos, n[c], k[c]).reflectance);
                let got: [f64; 3] = prepared.evaluate(cos);
                let single = [cos as f32];
                let mut f = [[0.0f32]; 3];
                let slots = f.each_mut().map(|f| f.as_mut_slice());
                batch::map(&prepared, [&single], slots).expect("of one length");
                for c in 0..3 {
                    // F of the forms with a difference loses ½(1 + 1/F) ε, F ≥ .02: 26 ε, a few of them for as many roundings.
                    assert!(
                        (got[c] - exact[c]).abs() <= 100.0 * f64::EPSILON * exact[c],
                        "{n:?} {k:?} {cos}: {got:?} {exact:?}"
                    );
                    let error = (f64::from(f[c][0]) - exact[c]).abs();
                    assert!(error <= 100.0 * f64::from(f32::EPSILON) * exact[c], "{n:?} {k:?} {cos}: {f:?} {exact:?}");
                }
            }
        }
    }
}
