//! A view of a stack, prepared: what [`Stack::sample`] and [`Stack::pdf`] find out before they ask for a direction.

use super::{Lobe, Sample, Shape, Weights, below_one, cosine_hemisphere, cosine_share, visit};
use crate::frame::Vector;
use crate::layered::{Layer, Model, Stack};
use crate::real::{Mask, Real};
use alloc::vec::Vec;

/// The lobes that a view keeps without allocating: three interfaces, or two that disperse over three channels.
const HELD: usize = 6;

/// The lobes of a stack for one view, and the probabilities that they are drawn with.
///
/// A path tracer asks a stack at each point for a sample and for the densities of directions that it has from elsewhere, all for one
/// `wo`. Fresnel terms of the view, its refraction and the mixture are the larger part of that, and the same for all of them.
///
/// ```
/// use brdf::{Vector, material};
///
/// let stack = material::stack::by_name("clear_coat_over_copper").unwrap();
/// let (wi, wo) = (Vector::from_angles(0.3, 1.0), Vector::from_angles(0.5, 0.0));
/// let (view, pdf) = (stack.facing(wo), stack.pdf(wi, wo));
/// assert!((view.pdf(wi) - pdf).abs() < 1e-12 * pdf);
/// ```
#[derive(Clone, Debug)]
pub struct View<R> {
    wo: Vector<R>,
    held: [Drawn<R>; HELD],
    count: usize,
    more: Vec<Drawn<R>>,
    /// The share of the cosine over all lobes.
    even: R,
}

/// A lobe and its probability.
#[derive(Clone, Copy, Debug)]
struct Drawn<R> {
    lobe: Lobe<R>,
    share: R,
}

impl<R: Real> View<R> {
    /// The lobes of a view of layers under a model; none where `wo` is at or below the horizon.
    #[inline]
    pub fn new<const C: usize>(layers: &[Layer<R, C>], model: Model, wo: Vector<R>) -> Self {
        let blank = Drawn { lobe: Lobe { weights: Weights::none(), shape: Shape::Diffuse { uniform: R::ZERO } }, share: R::ZERO };
        let even = R::from_f64(cosine_share(model));
        let mut view = View { wo, held: [blank; HELD], count: 0, more: Vec::new(), even };
        if !wo.z.gt(R::ZERO).any() {
            return view;
        }
        let mut total = Weights::none();
        visit(layers, model, wo, |lobe| {
            total = total.plus(lobe.weights, R::ONE);
            let drawn = Drawn { lobe: *lobe, share: R::ZERO };
            match view.held.get_mut(view.count) {
                Some(place) => *place = drawn,
                None => view.more.push(drawn),
            }
            view.count += 1;
        });
        for drawn in view.held.iter_mut().take(view.count).chain(&mut view.more) {
            drawn.share = total.share(drawn.lobe.weights);
        }
        view
    }

    fn lobes(&self) -> impl Iterator<Item = &Drawn<R>> {
        self.held.iter().take(self.count).chain(&self.more)
    }

    /// [`Stack::pdf`] for this view, but for rounding.
    #[inline]
    pub fn pdf(&self, wi: Vector<R>) -> R {
        let lit = wi.z.gt(R::ZERO) & self.wo.z.gt(R::ZERO);
        if !lit.any() {
            return R::ZERO;
        }
        let mut lobes = R::ZERO;
        for drawn in self.lobes() {
            lobes = lobes + drawn.share * drawn.lobe.density(wi);
        }
        let mixed = wi.z * R::FRAC_1_PI * self.even + lobes * (R::ONE - self.even);
        R::select(lit, mixed, R::ZERO)
    }

    /// [`Stack::sample`] for this view, but for rounding.
    #[inline]
    pub fn sample(&self, u: [R; 3]) -> Option<Sample<R>> {
        let wi = self.direction(u)?;
        let pdf = self.pdf(wi);
        pdf.gt(R::ZERO).all().then_some(Sample { wi, pdf })
    }

    /// The direction of a sample, before it is known whether it leaves the stack.
    #[inline]
    fn direction(&self, u: [R; 3]) -> Option<Vector<R>> {
        if u[0].lt(self.even).all() {
            return Some(cosine_hemisphere([u[1], u[2]]));
        }
        let mut rest = below_one((u[0] - self.even) / (R::ONE - self.even));
        for drawn in self.lobes() {
            if rest.lt(drawn.share).all() {
                return Some(drawn.lobe.reflect([rest.max(R::ZERO) / drawn.share, u[1], u[2]]));
            }
            rest = rest - drawn.share;
        }
        None
    }
}

impl<R: Real, const C: usize> Stack<R, C> {
    /// A view of the stack, prepared for any number of samples and densities. See [`View`].
    #[inline]
    pub fn facing(&self, wo: impl Into<Vector<R>>) -> View<R> {
        View::new(self.effective_layers(), self.model(), wo.into())
    }
}

#[cfg(test)]
mod tests {
    use crate::frame::Vector;
    use crate::layered::{Interface, Layer, Model, Stack};
    use crate::material::stack::built_in;
    use crate::walk::random::random;
    use alloc::vec::Vec;

    /// Sums of a dozen terms in another order: a few roundings each, of which the largest lobe's is the result's own.
    const ROUNDING: f64 = 32.0 * f64::EPSILON;

    #[test]
    fn a_view_draws_what_the_stack_draws() {
        let dispersing = Interface::conductor([1.4, 1.5, 1.6], [0.1, 0.2, 0.3], 0.2);
        let layers: Vec<_> = (0..5).map(|_| Layer::new(dispersing)).collect();
        let deep = Stack::<f64, 3>::new(Model::Conserving, layers).expect("valid");
        let stacks = built_in().into_iter().map(|m| m.stack).chain([deep]);
        for stack in stacks.flat_map(|stack| [Model::Conserving, Model::Elek, Model::Coupled].map(|m| stack.clone().with_model(m))) {
            for sample in 0..200 {
                let [a, b, c, d]: [f64; 4] = random(3, sample, 0);
                let [u, v, w, _]: [f64; 4] = random(3, sample, 1);
                let (wo, wi) = (Vector::from_angles(1.7 * a, 6.0 * b), Vector::from_angles(1.7 * c, 6.0 * d));
                let (view, want) = (stack.facing(wo), stack.pdf(wi, wo));
                assert!((view.pdf(wi) - want).abs() <= ROUNDING * want, "{wo:?} {wi:?}");
                let (got, want) = (view.sample([u, v, w]), stack.sample(wo, [u, v, w]));
                assert_eq!(got.is_some(), want.is_some(), "{wo:?}");
                if let (Some(got), Some(want)) = (got, want) {
                    // `rest` carries the rounding of the shares before it, magnified by 1/share ≤ 1e4 here; so may a narrow lobe's density.
                    assert!((got.wi - want.wi).length_squared() < 1e-20, "{wo:?}");
                    assert!((got.pdf - want.pdf).abs() <= 1e-8 * want.pdf, "{wo:?}: {} {}", got.pdf, want.pdf);
                }
            }
        }
    }
}
