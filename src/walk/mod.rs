//! The truth: an unbiased random walk through a layered stack.
//!
//! What the models of [`crate::layered`] leave out (light that bounces between interfaces, and the width that rough
//! interfaces add) a walk finds by chance. A path enters the stack from the viewer, is reflected or refracted by a
//! microfacet at each interface, absorbed between them, and at each visit of an interface connected to a path that comes
//! down from the light. The mean over many walks is the BRDF; the spread of the walks says how far off it may be.
//!
//! ```
//! use brdf::Vector;
//! use brdf::layered::{Interface, Layer, Model, Stack};
//! use brdf::walk::{self, Options};
//!
//! let coat = Layer::new(Interface::dielectric(1.5, 0.1));
//! let base = Layer::new(Interface::diffuse([0.5], 0.0));
//! let stack = Stack::<f64, 1>::new(Model::Conserving, vec![coat, base])?;
//! let options = Options { samples: 4096, ..Options::default() };
//! let albedo = walk::albedo(&stack, Vector::from_angles(0.0, 0.0), &options);
//! assert!((albedo.mean[0] - 0.316).abs() < 4.0 * albedo.standard_error[0]);
//! # Ok::<(), brdf::layered::StackError>(())
//! ```
//!
//! # The measure
//!
//! Radiance over n² and étendue dG = n²·|cosθ|·dω make every kernel symmetric in its two directions, so a path needs no
//! notion of transport mode: f̂ = f_r/n² in reflection, f̂ = f_t/n_o² in transmission, and f = n₀²·Σ ∫ Π f̂·Π e^(−τ/|cos|)·Π dG
//! with n₀ = 1.
//!
//! A path that ends up through several interfaces is found in several ways: connected at any of them, or sampled all the
//! way into the light. The power heuristic (Veach 1997, eq. 9.13) weights each by its density, which for the medium
//! under the top interface is that of the *inner* direction given the light's. (With two interfaces these are the walk and
//! the weights of Guo, Hašan & Zhao. With more, connecting only at the second would leave a standard deviation of 72 times
//! the value for `three_layer_lacquer`, where this one leaves 0.23.)
//!
//! # What the interfaces are
//!
//! [`Microsurface::VCavities`] by default, the microfacets of every model here ([`crate::microfacet::facets`]): the walk over
//! a single interface *is* [`crate::layered::conserving`]'s. An interface with κ > 0 refracts by its n; light that meets
//! it from below sees the Fresnel terms of the refracted ray. Interfaces between equal indices are left out: they do
//! nothing. No width is taken for 0: in f64 the narrowest, 1e-4, is far from the rounding of the half vector, and both
//! ways of finding a path together cope with it.
//!
//! [`Microsurface`] says which masking was measured against the published albedos.
//!
//! Source: Guo, Hašan & Zhao 2018, "Position-Free Monte Carlo Simulation for Arbitrary Layered BSDFs", §5; Walter et al.
//! 2007, "Microfacet Models for Refraction through Rough Surfaces".
//!
//! Twin of [`sample()`]: `wgsl/walk.wgsl`.

mod estimate;
mod facets;
mod interface;
mod path;
pub use crate::random;

pub use facets::{
    Microsurface, Pair, reflected, reflection, refracted, refracting_normal, transmission, visible_normal, visible_part,
};

use crate::frame::Vector;
use crate::layered::{Interface, Layer, Stack};
use crate::real::Real;
use interface::{Interfaces, Source, Way};

/// How many walks, and which.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The number of walks, at least 2; at most 2³² − 1 differ.
    pub samples: u32,
    /// Equal seeds give equal results, to the bit, on any number of threads.
    pub seed: u32,
    /// The number of threads; 0 takes as many as the machine has.
    pub threads: usize,
    /// What the microfacets are.
    pub microsurface: Microsurface,
    /// How paths are found; of no effect on [`albedo`].
    pub technique: Technique,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            samples: 1 << 16,
            seed: 1,
            threads: 0,
            microsurface: Microsurface::default(),
            technique: Technique::default(),
        }
    }
}

/// How [`evaluate`] finds the paths that end up through the top interface. All have the same mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Technique {
    /// From the light and from the interface, weighted by the power heuristic. The default.
    #[default]
    Both,
    /// From the light as far as the last reflection: noisy where what lies below an interface is narrower than it.
    NextEvent,
    /// From the viewer all the way: noisy where the top is narrower.
    Sampling,
    /// A known defect, kept so that tests can show that they would find it: the weight of a sampled path takes the
    /// density of the *outer* direction given the inner one. Biased by up to 8 %.
    #[doc(hidden)]
    OuterDensity,
}

/// A mean over walks and how well it is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate<const C: usize> {
    /// The mean of each channel: f in sr⁻¹, or an albedo.
    pub mean: [f64; C],
    /// The standard error of each mean: two thirds of all estimates lie this close to the truth.
    pub standard_error: [f64; C],
    /// The number of walks.
    pub samples: u32,
}

/// The BRDF in sr⁻¹ of a stack for a pair of local unit directions, with its standard error; the stack's model is ignored.
///
/// `wi` points towards the light, `wo` towards the viewer. 0 where either is at or below the horizon. Unbiased: the error
/// falls as 1/√samples, from a standard deviation per walk of 0 to 0.5 of the value on the built-in stacks. A walk costs
/// 2 to 7 µs with three channels on one core of a 2.x GHz server (`cargo run --release --example walk_tables`).
///
/// The channels share their walks unless an interface that light passes disperses; then each has its own.
///
/// Source: Guo, Hašan & Zhao 2018, §5.1.
pub fn evaluate<const C: usize>(
    stack: &Stack<f64, C>,
    wi: impl Into<Vector<f64>>,
    wo: impl Into<Vector<f64>>,
    options: &Options,
) -> Estimate<C> {
    let (wi, wo) = (wi.into(), wo.into());
    fn walks<const K: usize>(
        (stack, wi, wo): (Interfaces<f64, K>, Vector<f64>, Vector<f64>),
        options: &Options,
    ) -> Estimate<K> {
        let facets = options.microsurface;
        let mut estimate =
            estimate::mean(options, |source| path::transmitted(&stack, facets, options.technique, wi, wo, source));
        let first = path::first_reflection(&stack, facets, wi, wo);
        for (mean, first) in estimate.mean.iter_mut().zip(first) {
            *mean += first;
        }
        estimate
    }
    if disperses(stack.layers()) {
        by_channel(|channel| walks::<1>((Interfaces::new(stack.layers(), channel), wi, wo), options))
    } else {
        walks::<C>((Interfaces::new(stack.layers(), 0), wi, wo), options)
    }
}

/// The directional albedo ∫ f·cos dω of a stack seen from `wo`, with its standard error; the stack's model is ignored.
///
/// The walk is followed until it leaves; its weight is the estimate. By reciprocity this is the albedo for light from
/// `wo` too. 0 where `wo` is at or below the horizon.
///
/// Source: Guo, Hašan & Zhao 2018, §5 without the connections.
pub fn albedo<const C: usize>(stack: &Stack<f64, C>, wo: impl Into<Vector<f64>>, options: &Options) -> Estimate<C> {
    let wo = wo.into();
    fn walks<const K: usize>(stack: &Interfaces<f64, K>, wo: Vector<f64>, options: &Options) -> Estimate<K> {
        estimate::mean(options, |source| path::escaped(stack, options.microsurface, wo, Way::Both, source))
    }
    if disperses(stack.layers()) {
        by_channel(|channel| walks::<1>(&Interfaces::new(stack.layers(), channel), wo, options))
    } else {
        walks::<C>(&Interfaces::new(stack.layers(), 0), wo, options)
    }
}

/// [`albedo`] less what the top interface reflects; of a stack of two interfaces or more.
pub(crate) fn lower_albedo<const C: usize>(stack: &Stack<f64, C>, wo: Vector<f64>, options: &Options) -> Estimate<C> {
    fn walks<const K: usize>(stack: &Interfaces<f64, K>, wo: Vector<f64>, options: &Options) -> Estimate<K> {
        estimate::mean(options, |source| path::escaped(stack, options.microsurface, wo, Way::Transmission, source))
    }
    if disperses(stack.layers()) {
        by_channel(|channel| walks::<1>(&Interfaces::new(stack.layers(), channel), wo, options))
    } else {
        walks::<C>(&Interfaces::new(stack.layers(), 0), wo, options)
    }
}

/// The share of the light from `wo` that reaches the last interface, by any number of bounces between those above it.
pub(crate) fn arrived<const C: usize>(stack: &Stack<f64, C>, wo: Vector<f64>, options: &Options) -> Estimate<C> {
    fn walks<const K: usize>(stack: &Interfaces<f64, K>, wo: Vector<f64>, options: &Options) -> Estimate<K> {
        estimate::mean(options, |source| path::arrived(stack, options.microsurface, wo, source))
    }
    if disperses(stack.layers()) {
        by_channel(|channel| walks::<1>(&Interfaces::new(stack.layers(), channel), wo, options))
    } else {
        walks::<C>(&Interfaces::new(stack.layers(), 0), wo, options)
    }
}

/// The share of Lambertian light from the last interface that those above it send back.
pub(crate) fn returned<const C: usize>(stack: &Stack<f64, C>, options: &Options) -> Estimate<C> {
    fn walks<const K: usize>(stack: &Interfaces<f64, K>, options: &Options) -> Estimate<K> {
        estimate::mean(options, |source| path::returned(stack, options.microsurface, source))
    }
    if disperses(stack.layers()) {
        by_channel(|channel| walks::<1>(&Interfaces::new(stack.layers(), channel), options))
    } else {
        walks::<C>(&Interfaces::new(stack.layers(), 0), options)
    }
}

/// The f of one walk in one channel, in sr⁻¹: what [`evaluate`] takes the mean of.
///
/// `layers` from the top; `channel` < C; `wi`, `wo` local unit vectors; `seed` and `index` name the walk. In f32, and in
/// the twin, widths below 1e-3 are widened to it: the half vector of a refraction carries no more digits.
///
/// Source: as [`evaluate`]. Twin: `walk_sample` in `wgsl/walk.wgsl`.
pub fn sample<R: Real<Mask = bool>, const C: usize>(
    layers: &[Layer<R, C>],
    channel: usize,
    wi: Vector<R>,
    wo: Vector<R>,
    seed: u32,
    index: u32,
) -> R {
    let stack = Interfaces::<R, 1>::new(layers, channel);
    let [first] = path::first_reflection(&stack, Microsurface::default(), wi, wo);
    let source = Source { seed, index };
    let [rest] = path::transmitted(&stack, Microsurface::default(), Technique::default(), wi, wo, source);
    first + rest
}

fn by_channel<const C: usize>(mut one: impl FnMut(usize) -> Estimate<1>) -> Estimate<C> {
    let mut whole = Estimate { mean: [0.0; C], standard_error: [0.0; C], samples: 0 };
    for channel in 0..C {
        let estimate = one(channel);
        whole.mean[channel] = estimate.mean[0];
        whole.standard_error[channel] = estimate.standard_error[0];
        whole.samples = estimate.samples;
    }
    whole
}

/// True where an interface that light passes has an index that differs between channels.
fn disperses<R: Real, const C: usize>(layers: &[Layer<R, C>]) -> bool {
    layers.split_last().is_some_and(|(_, passed)| {
        passed.iter().any(|layer| match layer.interface {
            Interface::Microfacet { n, .. } => n.iter().any(|other| *other != n[0]),
            Interface::Diffuse { .. } => false,
        })
    })
}
