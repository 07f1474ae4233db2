//! A view of a stack, prepared: what [`Stack::sample`] and [`Stack::pdf`] find out before they ask for a direction.

use super::{Lobe, Sample, Shape, Weights, below_one, cosine_hemisphere, cosine_share, visit};
use crate::frame::Vector;
use crate::layered::{Layer, Model, Stack};
use crate::real::{Mask, Real};
use crate::refraction::refract;
use alloc::vec::Vec;

/// The lobes that a view keeps without allocating: three interfaces and a base.
const HELD: usize = 4;

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
        let mut view = Self::empty(wo, R::from_f64(cosine_share(model)));
        if !wo.z.gt(R::ZERO).any() {
            return view;
        }
        let mut total = Weights::none();
        visit(layers, model, wo, |lobe| {
            total = total.plus(lobe.weights, R::ONE);
            view.push(Drawn { lobe: *lobe, share: R::ZERO });
        });
        for drawn in view.held.iter_mut().take(view.count).chain(&mut view.more) {
            drawn.share = total.share(drawn.lobe.weights);
        }
        view
    }

    #[inline(always)]
    fn empty(wo: Vector<R>, even: R) -> Self {
        let lobe = Lobe { weights: Weights::none(), shape: Shape::Diffuse { uniform: R::ZERO } };
        View { wo, held: [Drawn { lobe, share: R::ZERO }; HELD], count: 0, more: Vec::new(), even }
    }

    #[inline(always)]
    fn push(&mut self, drawn: Drawn<R>) {
        match self.held.get_mut(self.count) {
            Some(place) => *place = drawn,
            None => self.more.push(drawn),
        }
        self.count += 1;
    }

    fn lobes(&self) -> impl Iterator<Item = &Drawn<R>> {
        self.held.iter().take(self.count).chain(&self.more)
    }

    /// [`Stack::pdf`] for this view, but for rounding.
    #[inline(always)]
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
        let sample = self.draw(u);
        sample.pdf.gt(R::ZERO).all().then_some(sample)
    }

    /// [`View::sample`], with density 0 where there is none.
    #[inline(always)]
    pub(crate) fn draw(&self, u: [R; 3]) -> Sample<R> {
        let wi = self.direction(u);
        Sample { wi, pdf: self.pdf(wi) }
    }

    /// The direction of a sample, before it is known whether it leaves the stack; a vector of length 0 where there is none.
    #[inline(always)]
    pub(crate) fn direction(&self, u: [R; 3]) -> Vector<R> {
        let spreads = u[0].lt(self.even);
        let mut wi = Vector::default();
        let mut pending = !spreads;
        let mut rest = below_one((u[0] - self.even) / (R::ONE - self.even));
        for drawn in self.lobes() {
            let chosen = pending & rest.lt(drawn.share);
            if chosen.any() {
                let within = rest.max(R::ZERO) / R::select(chosen, drawn.share, R::ONE);
                wi = Vector::select(chosen, drawn.lobe.reflect([within, u[1], u[2]]), wi);
                pending = pending & !chosen;
                if !pending.any() {
                    break;
                }
            }
            rest = rest - drawn.share;
        }
        if spreads.any() {
            wi = Vector::select(spreads, cosine_hemisphere([u[1], u[2]]), wi);
        }
        wi
    }
}

impl<R: Real, const C: usize> Stack<R, C> {
    /// A view of the stack, prepared for any number of samples and densities. See [`View`].
    #[inline]
    pub fn facing(&self, wo: impl Into<Vector<R>>) -> View<R> {
        View::new(self.effective_layers(), self.model(), wo.into())
    }
}

/// The cosines at which [`Views`] knows the mixture: 65.
const NODES: usize = 65;

/// The views of a stack that is sampled very often: the mixture at 65 cosines, linear between.
///
/// Which lobe a sample is drawn from is free, as long as the density says the same: a path tracer that interpolates the
/// probabilities is as right as one that computes them, and spares itself the Fresnel terms of every view. [`Views::facing`] is a
/// view like [`Stack::facing`]'s in all but its shares, so that its densities differ a little from [`Stack::pdf`].
#[derive(Clone, Debug)]
pub struct Views {
    lobes: Vec<Tabulated>,
    /// The share of the cosine over all lobes.
    even: f64,
}

/// A lobe at every view.
#[derive(Clone, Debug)]
struct Tabulated {
    /// At normal incidence.
    lobe: Lobe<f64>,
    /// Its share, and what of it is drawn evenly, at each cosine.
    nodes: [[f64; 2]; NODES],
}

impl Views {
    /// The views of a stack; none where some of its lobes end at an angle (indices below 1), or where it reflects nothing.
    pub fn new<const C: usize>(stack: &Stack<f64, C>) -> Option<Self> {
        let at = |node: usize| {
            // Grazing as such has no view.
            let cosine = (node as f64 / (NODES - 1) as f64).max(1e-3);
            stack.facing(Vector::new(((1.0 - cosine) * (1.0 + cosine)).sqrt(), 0.0, cosine))
        };
        let tabulated = |drawn: &Drawn<f64>| Tabulated { lobe: drawn.lobe, nodes: [[0.0; 2]; NODES] };
        let mut lobes: Vec<Tabulated> = at(NODES - 1).lobes().map(tabulated).collect();
        for node in 0..NODES {
            let view = at(node);
            let total: f64 = view.lobes().map(|drawn| drawn.share).sum();
            if view.count != lobes.len() || total <= 0.5 {
                return None;
            }
            for (tabulated, drawn) in lobes.iter_mut().zip(view.lobes()) {
                tabulated.nodes[node] = match drawn.lobe.shape {
                    Shape::Facets { spread, .. } => [drawn.share, spread],
                    Shape::Diffuse { uniform } => [drawn.share, uniform],
                };
            }
        }
        Some(Views { lobes, even: cosine_share(stack.model()) })
    }

    /// The view from a local unit direction; without lobes where it is at or below the horizon.
    #[inline(always)]
    pub fn facing<R: Real>(&self, wo: Vector<R>) -> View<R> {
        let mut view = View::empty(wo, R::from_f64(self.even));
        if !wo.z.gt(R::ZERO).any() {
            return view;
        }
        let place = wo.z.saturate() * R::from_f64((NODES - 1) as f64);
        let none = Weights { estimate: R::ZERO, safe: R::ZERO };
        for Tabulated { lobe, nodes } in &self.lobes {
            let [share, own] = place.interpolate(nodes);
            let shape = match lobe.shape {
                Shape::Facets { alpha, n, least, top, .. } => {
                    let [alpha, n, least] = [alpha, n, least].map(R::from_f64);
                    let view = if top { wo } else { refract(wo, n) };
                    Shape::Facets { view, alpha, n, least, top, spread: own }
                }
                Shape::Diffuse { .. } => Shape::Diffuse { uniform: own },
            };
            view.push(Drawn { lobe: Lobe { weights: none, shape }, share });
        }
        view
    }
}

#[cfg(test)]
mod tests {
    use super::Views;
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
        for stack in stacks
            .flat_map(|stack| [Model::Conserving, Model::Elek, Model::Coupled].map(|m| stack.clone().with_model(m)))
        {
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

    #[test]
    fn interpolated_views_draw_with_the_density_that_they_say() {
        // The mean of 1/p over samples is the solid angle that they cover: at most 2π, all of it under Lambert's base. And the
        // mean of f·cos/p is the albedo, whichever mixture draws.
        for material in built_in() {
            let views = Views::new(&material.stack).expect("indices of 1 and more");
            for theta in [0.2, 0.9, 1.4] {
                let wo = Vector::from_angles(theta, 0.3);
                let (exact, quick) = (material.stack.facing(wo), views.facing(wo));
                let n = 4000;
                let mean = |draw: &dyn Fn([f64; 3]) -> Option<crate::sampling::Sample<f64>>, seed: u32| {
                    let (mut sum, mut squares) = (0.0, 0.0);
                    for i in 0..n {
                        let [u, v, w, _]: [f64; 4] = random(seed, i, 0);
                        let weight = draw([u, v, w])
                            .map_or(0.0, |sample| material.stack.evaluate(sample.wi, wo)[0] * sample.wi.z / sample.pdf);
                        sum += weight;
                        squares += weight * weight;
                    }
                    let mean = sum / f64::from(n);
                    (mean, (squares / f64::from(n) - mean * mean).max(0.0) / f64::from(n))
                };
                let (want, a) = mean(&|u| exact.sample(u), 1);
                let (got, b) = mean(&|u| quick.sample(u), 2);
                // 48 comparisons: 4 standard deviations are exceeded by chance in one run of 300; the seeds are fixed.
                assert!((got - want).abs() <= 4.0 * (a + b).sqrt() + 1e-9, "{} {theta}: {got} {want}", material.name);
            }
        }
    }
}
