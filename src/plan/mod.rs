//! What must be computed of a stack, and nothing else.
//!
//! A [`Plan`] is made from a [`Stack`] once and evaluated often: constants are folded, what the stack does not need is left out
//! by named [`Rule`]s, and what remains is a row of stages. It drives the scalar evaluation ([`Plan::evaluate`]), the batches
//! ([`Plan::evaluate_batch`], [`Plan::evaluate_view`]) and the shader that is specialised to it.
//!
//! ```
//! use brdf::layered::{Interface, Layer, Model, Stack};
//! use brdf::plan::{Plan, Rule};
//! use brdf::Vector;
//!
//! let copper = Interface::conductor([0.213, 1.04, 1.17], [4.05, 2.59, 2.36], 0.3);
//! let coated = vec![Layer::new(Interface::dielectric(1.5, 0.1)), Layer::new(copper)];
//! let stack = Stack::<f64, 3>::new(Model::Conserving, coated)?;
//! let plan = Plan::new(&stack)?;
//! assert!(plan.applied().iter().any(|applied| applied.rule == Rule::ClearMedium));
//!
//! let (wi, wo) = (Vector::from_angles(0.4, 0.0), Vector::from_angles(0.5, 2.0));
//! let (planned, general) = (plan.evaluate(wi, wo), stack.evaluate(wi, wo));
//! assert!(planned.iter().zip(general).all(|(a, b): (&f64, f64)| (a - b).abs() <= 1e-12 * b));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub(crate) mod chain;
#[cfg(feature = "std")]
mod cost;
pub(crate) mod interface;
mod reflectance;
mod rule;
pub(crate) mod stage;
mod term;

use crate::frame::Vector;
use crate::fresnel::Fit;
use crate::layered::{Interface, Layer, Model, Stack};
use crate::real::Real;
use alloc::vec::Vec;
use chain::{Chain, Stage, Surface, Way};
use core::fmt;
#[cfg(feature = "std")]
pub use cost::{Operations, Path};
use interface::{AnyConductor, AnyDielectric, Conductor, Dielectric, Each, Fitted, Grey, Metal};
pub use reflectance::Reflectance;
pub use rule::{Applied, Rule};
use stage::{Absorption, Base, Lobe, Passage};
pub use term::Term;

/// The depth 2τ from which a medium counts as opaque.
const OPAQUE: f64 = 87.0;

/// How a plan is made. The default is exact, by every rule.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options<'a> {
    /// The largest error of F with which a conductor's Fresnel terms may be fitted; 0 for none.
    pub max_error: f64,
    /// Rules that are not applied: what they save is measured, and that they change nothing is tested, against a plan
    /// without them. [`Rule::SingleInterface`] rewrites nothing; without [`Rule::GreyInterface`] a dielectric still has one term.
    pub without: &'a [Rule],
}

/// A stack prepared for evaluation under a closed-form model.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan<const C: usize> {
    model: Model,
    chains: Chains<C>,
    applied: Vec<Applied>,
}

/// The channels, by whether they share their directions.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Chains<const C: usize> {
    Together(Chain<C>),
    Apart(Vec<Chain<1>>),
}

/// A model that has no plan: [`Model::Coupled`] needs its tables and [`Model::Walk`] chance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotClosedForm(
    /// The model that was asked for.
    pub Model,
);

impl fmt::Display for NotClosedForm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the model {} has no closed form; plans are made for", self.0.name())?;
        Model::CLOSED_FORM.iter().try_for_each(|model| write!(f, " {}", model.name()))
    }
}

impl core::error::Error for NotClosedForm {}

impl<const C: usize> Plan<C> {
    /// The plan of a stack, exact.
    ///
    /// # Errors
    /// Where the stack's model has no closed form.
    pub fn new<R: Real>(stack: &Stack<R, C>) -> Result<Self, NotClosedForm> {
        Self::with_error(stack, 0.0)
    }

    /// The plan of a stack with the Fresnel terms of its conductors fitted ([`Fit`]) where the largest error of F is at most
    /// `max_error`: the smallest of the fits of 8, 10 and 12 coefficients that does, exact where none does.
    ///
    /// # Errors
    /// As [`Plan::new`].
    pub fn with_error<R: Real>(stack: &Stack<R, C>, max_error: f64) -> Result<Self, NotClosedForm> {
        Self::with_options(stack, &Options { max_error, ..Options::default() })
    }

    /// The plan of a stack, made as these options say.
    ///
    /// # Errors
    /// As [`Plan::new`].
    pub fn with_options<R: Real>(stack: &Stack<R, C>, options: &Options<'_>) -> Result<Self, NotClosedForm> {
        let model = stack.model();
        if !Model::CLOSED_FORM.contains(&model) {
            return Err(NotClosedForm(model));
        }
        let layers: Vec<Layer<f64, C>> = stack.effective_layers().iter().map(Layer::cast).collect();
        let mut applied = Vec::new();
        let shared = !options.without.contains(&Rule::SharedDirections);
        let chains = if crate::layered::model::disperses(&layers) || !shared {
            let channel = |c: usize| {
                let layers: Vec<Layer<f64, 1>> = layers.iter().map(|layer| one_channel(layer, c)).collect();
                let mut own = Vec::new();
                let chain = Builder { model, options, applied: &mut own }.chain(&layers);
                (chain, own)
            };
            let (chains, found): (Vec<_>, Vec<_>) = (0..C).map(channel).unzip();
            // A rule that applied to every channel.
            if let Some((first, others)) = found.split_first() {
                applied.extend(first.iter().filter(|one| others.iter().all(|found| found.contains(one))));
            }
            Chains::Apart(chains)
        } else {
            if C > 1 && layers.len() > 1 {
                applied.push(Applied { rule: Rule::SharedDirections, layer: 0 });
            }
            Chains::Together(Builder { model, options, applied: &mut applied }.chain(&layers))
        };
        applied.sort_by_key(|applied| (applied.layer, applied.rule));
        Ok(Plan { model, chains, applied })
    }

    /// The model that it evaluates.
    pub fn model(&self) -> Model {
        self.model
    }

    /// What was left out, from the top.
    pub fn applied(&self) -> &[Applied] {
        &self.applied
    }

    pub(crate) fn chains(&self) -> &Chains<C> {
        &self.chains
    }

    /// The BRDF in sr⁻¹ for a pair of local unit directions, as [`Stack::evaluate`]. 0 where either is at or below the horizon;
    /// cosines below 1e-18 count as the horizon.
    ///
    /// Error in f32: ≤ 0.6 ULP for two layers and f > 1e-8, as [`Stack::evaluate`].
    #[inline]
    pub fn evaluate<R: Real>(&self, wi: impl Into<Vector<R>>, wo: impl Into<Vector<R>>) -> [R; C] {
        let (wi, wo) = (wi.into().widen(), wo.into().widen());
        match &self.chains {
            Chains::Together(chain) => chain.evaluate(wi, wo).map(R::narrow),
            Chains::Apart(chains) => {
                let mut f = [R::ZERO; C];
                for (f, chain) in f.iter_mut().zip(chains) {
                    let [one] = chain.evaluate(wi, wo);
                    *f = R::narrow(one);
                }
                f
            }
        }
    }
}

/// A layer with one of its channels.
fn one_channel<const C: usize>(layer: &Layer<f64, C>, c: usize) -> Layer<f64, 1> {
    let interface = match layer.interface {
        Interface::Microfacet { n, k, alpha } => Interface::conductor([n[c]], [k[c]], alpha),
        Interface::Diffuse { albedo, sigma } => Interface::diffuse([albedo[c]], sigma),
    };
    Layer::new(interface).over([layer.medium.sigma[c]], layer.medium.thickness)
}

/// Makes the stages of a chain, and notes the rules that apply.
struct Builder<'a> {
    model: Model,
    options: &'a Options<'a>,
    applied: &'a mut Vec<Applied>,
}

impl Builder<'_> {
    fn chain<const K: usize>(mut self, layers: &[Layer<f64, K>]) -> Chain<K> {
        let compressed = self.model == Model::Conserving;
        // Each with the layer that it is of.
        let mut stages: Vec<(usize, Stage<K>)> = Vec::new();
        let (mut n_above, mut widest) = (1.0, 0.0f64);
        // Stages at the top that stay, whatever is below them.
        let mut kept = 0;
        if let [_] = layers {
            self.applies(Rule::SingleInterface, 0);
        }
        for (position, layer) in layers.iter().enumerate() {
            let last = position + 1 == layers.len();
            match layer.interface {
                Interface::Diffuse { albedo, sigma } => {
                    let base = Base { albedo, sigma, n_above, compressed };
                    if albedo == [0.0; K] && self.applies(Rule::BlackBase, position) {
                        // Reflects nothing.
                    } else if sigma == 0.0 && self.applies(Rule::FlatBase, position) {
                        stages.push((position, Stage::Lambert(base)));
                    } else {
                        let about_half = self.model == Model::WeidlichWilkie;
                        stages.push((position, Stage::OrenNayar { base, about_half }));
                    }
                    break;
                }
                Interface::Microfacet { n, k, alpha } => {
                    let dielectric = k == [0.0; K];
                    widest = widest.max(alpha);
                    let alpha = if self.model == Model::Elek { widest } else { alpha };
                    // Elek's Fresnel terms take the absolute index.
                    let reference = if self.model == Model::Elek { 1.0 } else { n_above };
                    let matched = dielectric && n == [n_above; K] && n_above == reference;
                    if !(matched && self.applies(Rule::MatchedIndices, position)) {
                        let grey = n == [n[0]; K] && k == [k[0]; K];
                        if dielectric {
                            self.applies(Rule::NoConductor, position);
                        }
                        if grey && K > 1 {
                            self.applies(Rule::GreyInterface, position);
                        }
                        let surface = self.surface(n, k, n_above, reference);
                        let lobe = Lobe::new(alpha, n_above, compressed);
                        stages.push((position, Stage::Reflect { lobe, surface }));
                        if !last {
                            let way = self.way(n, k, n_above, reference);
                            let passage = Passage::new(n_above, n[0]);
                            stages.push((position, Stage::Pass { passage, way, model: self.model }));
                        }
                    }
                    n_above = n[0];
                    let depth = layer.medium.sigma.map(|sigma| sigma * layer.medium.thickness);
                    let clear = depth == [0.0; K];
                    if last && !clear && !self.applies(Rule::LastMedium, position) {
                        stages
                            .push((position, Stage::Absorb(Absorption { depth: depth.map(|depth| n_above * depth) })));
                        kept = stages.len();
                    }
                    if last || (clear && self.applies(Rule::ClearMedium, position)) {
                        continue;
                    }
                    match stages.last_mut() {
                        // Nothing between this medium and the one above: they are one.
                        Some((_, Stage::Absorb(medium))) => {
                            for (sum, depth) in medium.depth.iter_mut().zip(depth) {
                                *sum += n_above * depth;
                            }
                        }
                        _ => {
                            let depth = depth.map(|depth| n_above * depth);
                            stages.push((position, Stage::Absorb(Absorption { depth })));
                        }
                    }
                    let opaque = depth.iter().all(|depth| 2.0 * depth >= OPAQUE);
                    if opaque && self.applies(Rule::OpaqueMedium, position) {
                        break;
                    }
                }
            }
        }
        // What carries light to where nothing reflects any more.
        while stages.len() > kept
            && let Some((_, Stage::Pass { .. } | Stage::Absorb(_))) = stages.last()
        {
            stages.pop();
        }
        let (layers, stages) = stages.into_iter().unzip();
        Chain { stages, layers }
    }

    /// Notes a rule, unless it is not to be applied.
    fn applies(&mut self, rule: Rule, layer: usize) -> bool {
        let wanted = self.wants(rule);
        if wanted {
            self.applied.push(Applied { rule, layer });
        }
        wanted
    }

    fn wants(&self, rule: Rule) -> bool {
        !self.options.without.contains(&rule)
    }

    /// A fit of the indices relative to `reference`, by the smallest polynomial that is good enough.
    fn fit<const K: usize, const N: usize>(&self, n: [f64; K], k: [f64; K], reference: f64) -> Option<Fit<K, N>> {
        let fit = Fit::new(n.map(|n| n / reference), k.map(|k| k / reference)).ok()?;
        fit.max_error.iter().all(|error| *error <= self.options.max_error).then_some(fit)
    }

    /// The cheapest form of what an interface reflects.
    fn surface<const K: usize>(&self, n: [f64; K], k: [f64; K], n_above: f64, reference: f64) -> Surface<K> {
        let grey = n == [n[0]; K] && k == [k[0]; K];
        if grey && k[0] == 0.0 && self.wants(Rule::NoConductor) {
            let eta = n[0] / reference;
            return match Dielectric::new(eta * n_above, n_above) {
                Some(dielectric) => Surface::Dielectric(dielectric),
                None => Surface::AnyDielectric(AnyDielectric { eta, n_above }),
            };
        }
        if self.options.max_error > 0.0 {
            if let Some(fit) = self.fit(n, k, reference) {
                return Surface::Fit8(Fitted { fit, n_above });
            }
            if let Some(fit) = self.fit(n, k, reference) {
                return Surface::Fit10(Fitted { fit, n_above });
            }
            if let Some(fit) = self.fit(n, k, reference) {
                return Surface::Fit12(Fitted { fit, n_above });
            }
        }
        // Relative to the medium above in the optical cosines' terms: for Elek's absolute indices n·A and k·A.
        let scale = n_above / reference;
        let of = |c: usize| (scale * n[c], scale * k[c]);
        if let Some(metals) = every(|c| Metal::new(of(c).0, of(c).1, n_above)) {
            return if grey && self.wants(Rule::GreyInterface) {
                Surface::GreyMetal(Grey(metals[0]))
            } else {
                Surface::Metals(Each(metals))
            };
        }
        if let Some(conductors) = every(|c| Conductor::new(of(c).0, of(c).1, n_above)) {
            return Surface::Conductors(Each(conductors));
        }
        Surface::AnyConductors(self.any(n, k, n_above, reference))
    }

    fn any<const K: usize>(&self, n: [f64; K], k: [f64; K], n_above: f64, reference: f64) -> Each<AnyConductor, K> {
        let one = |c: usize| AnyConductor { eta: n[c] / reference, kappa: k[c] / reference, n_above };
        Each(core::array::from_fn(one))
    }

    /// The cheapest form of what an interface lets through.
    fn way<const K: usize>(&self, n: [f64; K], k: [f64; K], n_above: f64, reference: f64) -> Way<K> {
        match self.surface(n, k, n_above, reference) {
            Surface::Dielectric(dielectric) => Way::Dielectric(dielectric),
            Surface::AnyDielectric(dielectric) => Way::AnyDielectric(dielectric),
            Surface::Fit8(fit) => Way::Fit8(fit),
            Surface::Fit10(fit) => Way::Fit10(fit),
            Surface::Fit12(fit) => Way::Fit12(fit),
            _ => Way::AnyConductors(self.any(n, k, n_above, reference)),
        }
    }
}

/// All channels' values, if there are.
fn every<T: Copy, const K: usize>(one: impl Fn(usize) -> Option<T>) -> Option<[T; K]> {
    let first = one(0)?;
    let mut all = [first; K];
    for (c, place) in all.iter_mut().enumerate() {
        *place = one(c)?;
    }
    Some(all)
}
