//! Layered stacks: what an artist writes down, and the models that evaluate it.
//!
//! A [`Stack`] lists its layers from the top. Each [`Layer`] is an interface and the medium under it; indices are those
//! of the materials themselves, against vacuum, and the library forms the ratios. An interface with κ > 0 may have
//! layers under it (an oxide): directions refract by its n, its Fresnel terms use n + iκ.
//!
//! [`model`] holds the evaluations, whose twin is `wgsl/layered.wgsl`; [`Widths`] says how wide they take a covered interface
//! to be.

#[cfg(feature = "bytemuck")]
mod buffer;
#[cfg(feature = "std")]
pub mod coupled;
#[cfg(feature = "toml")]
pub mod description;
mod error;
pub mod model;
#[cfg(feature = "std")]
mod tables;
mod widths;

use crate::frame::Vector;
use crate::real::Real;
use alloc::vec::Vec;
#[cfg(feature = "bytemuck")]
pub use buffer::BufferLayer;
#[cfg(feature = "std")]
pub use coupled::Coupled;
pub use error::StackError;
pub use model::{conserving, elek, internal_reflection, weidlich_wilkie};
#[cfg(feature = "std")]
pub use tables::internal_reflectance;
pub use widths::Widths;

/// The real parts of an index that an interface may have. Nothing measured lies outside; squares of squares stay finite in f32.
pub const N_RANGE: core::ops::RangeInclusive<f64> = 1e-3..=1e3;

/// The imaginary parts of an index that an interface may have.
pub const K_RANGE: core::ops::RangeInclusive<f64> = 0.0..=1e3;

/// The widths that an interface may have.
pub const ALPHA_RANGE: core::ops::RangeInclusive<f64> = 1e-4..=1.0;

/// The boundary at the top of a layer, over `C` colour channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Interface<R, const C: usize> {
    /// A rough dielectric or conductor of index n + iκ: Beckmann's distribution under V-cavities.
    Microfacet {
        /// The real part of the index, in [1e-3, 1e3].
        n: [R; C],
        /// The imaginary part of the index, in [0, 1e3]; 0 for a dielectric.
        k: [R; C],
        /// The width of the distribution, in [1e-4, 1].
        alpha: R,
    },
    /// An opaque Oren–Nayar base. Nothing lies below it.
    Diffuse {
        /// The reflectance of its facets, in [0, 1].
        albedo: [R; C],
        /// The standard deviation of the slope angle in radians, in [0, π/2].
        sigma: R,
    },
}

impl<R: Real, const C: usize> Interface<R, C> {
    /// A dielectric of one index for all channels.
    pub fn dielectric(n: R, alpha: R) -> Self {
        Interface::Microfacet { n: [n; C], k: [R::ZERO; C], alpha }
    }

    /// A conductor with an index for each channel.
    pub fn conductor(n: [R; C], k: [R; C], alpha: R) -> Self {
        Interface::Microfacet { n, k, alpha }
    }

    /// An Oren–Nayar base.
    pub fn diffuse(albedo: [R; C], sigma: R) -> Self {
        Interface::Diffuse { albedo, sigma }
    }
}

/// The absorbing medium between an interface and the next one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium<R, const C: usize> {
    /// The absorption coefficient in 1/length, ≥ 0.
    pub sigma: [R; C],
    /// The thickness in the same length, ≥ 0.
    pub thickness: R,
}

impl<R: Real, const C: usize> Medium<R, C> {
    /// A medium that absorbs nothing.
    pub const CLEAR: Self = Medium { sigma: [R::ZERO; C], thickness: R::ZERO };
}

/// An interface and the medium below it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer<R, const C: usize> {
    /// The boundary that light meets.
    pub interface: Interface<R, C>,
    /// What lies between it and the next layer; of no effect in the last layer.
    pub medium: Medium<R, C>,
}

impl<R: Real, const C: usize> Layer<R, C> {
    /// An interface over a clear medium.
    pub fn new(interface: Interface<R, C>) -> Self {
        Layer { interface, medium: Medium::CLEAR }
    }

    /// The same interface over an absorbing medium.
    pub fn over(self, sigma: [R; C], thickness: R) -> Self {
        Layer { medium: Medium { sigma, thickness }, ..self }
    }

    /// The same layer over another number type.
    pub fn cast<S: Real>(&self) -> Layer<S, C> {
        let one = |x: R| S::from_f64(x.to_f64());
        let interface = match self.interface {
            Interface::Microfacet { n, k, alpha } => {
                Interface::Microfacet { n: n.map(one), k: k.map(one), alpha: one(alpha) }
            }
            Interface::Diffuse { albedo, sigma } => Interface::Diffuse { albedo: albedo.map(one), sigma: one(sigma) },
        };
        let Medium { sigma, thickness } = self.medium;
        Layer { interface, medium: Medium { sigma: sigma.map(one), thickness: one(thickness) } }
    }
}

/// How a stack is evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Model {
    /// The documents' model as printed, with normalised microfacets: [`elek`]. It gains energy without bound as n
    /// grows, 2.8 times on the documents' stacks.
    Elek,
    /// Refraction about the reflecting microfacet, relative indices: [`weidlich_wilkie`]. It gains energy, up to twice.
    WeidlichWilkie,
    /// Full Fresnel transmittance of both directions and 1/n² compression: [`conserving`]. The default.
    #[default]
    Conserving,
    /// [`Model::Conserving`] with the light that bounces between interfaces: [`coupled`]. Builds tables on first use;
    /// [`Coupled`] says what they cost.
    #[cfg(feature = "std")]
    Coupled,
    /// The truth, by chance: [`walk::evaluate`](crate::walk::evaluate) with its default options, which is thousands of
    /// times slower than the others and off by a standard error that only that function reports.
    #[cfg(feature = "std")]
    Walk,
}

impl Model {
    /// Every model.
    #[cfg(feature = "std")]
    pub const ALL: [Model; 5] = [Model::Elek, Model::WeidlichWilkie, Model::Conserving, Model::Coupled, Model::Walk];
    /// Every model.
    #[cfg(not(feature = "std"))]
    pub const ALL: [Model; 3] = Model::CLOSED_FORM;

    /// The models that need neither tables nor chance.
    pub const CLOSED_FORM: [Model; 3] = [Model::Elek, Model::WeidlichWilkie, Model::Conserving];

    /// The name that stack files and the command line use.
    pub const fn name(self) -> &'static str {
        match self {
            Model::Elek => "elek",
            Model::WeidlichWilkie => "weidlich_wilkie",
            Model::Conserving => "conserving",
            #[cfg(feature = "std")]
            Model::Coupled => "coupled",
            #[cfg(feature = "std")]
            Model::Walk => "walk",
        }
    }

    /// The rule of widths of a stack that asks for none: [`Widths::Variance`] for `coupled`, which it brings closer to the
    /// walk on every stack measured, [`Widths::Own`] for the others.
    pub const fn widths(self) -> Widths {
        match self {
            #[cfg(feature = "std")]
            Model::Coupled => Widths::Variance,
            _ => Widths::Own,
        }
    }

    /// The model of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|model| model.name() == name)
    }
}

/// A valid stack of layers over `C` colour channels, and the model that evaluates it.
#[derive(Clone, Debug)]
pub struct Stack<R, const C: usize> {
    layers: Vec<Layer<R, C>>,
    model: Model,
    /// The rule that was asked for; the model's own where none was.
    widths: Option<Widths>,
    /// The layers with the widths that the rule gives them; none under [`Widths::Own`].
    widened: Option<Vec<Layer<R, C>>>,
    #[cfg(feature = "std")]
    tables: coupled::Lazy<C>,
}

/// Equal layers under equal models and rules; whether tables are built makes no difference.
impl<R: PartialEq, const C: usize> PartialEq for Stack<R, C> {
    fn eq(&self, other: &Self) -> bool {
        self.layers == other.layers && self.model == other.model && self.rule() == other.rule()
    }
}

impl<R, const C: usize> Stack<R, C> {
    fn rule(&self) -> Widths {
        self.widths.unwrap_or(self.model.widths())
    }
}

impl<R: Real, const C: usize> Stack<R, C> {
    /// A stack of these layers, listed from the top.
    ///
    /// # Errors
    ///
    /// Names the layer and the key that is out of range: no layer at all, α outside [1e-4, 1], n outside [1e-3, 1e3], κ
    /// outside [0, 1e3], negative σ or
    /// thickness, an albedo outside [0, 1], a diffuse base that is not the last layer, any number that is not finite.
    pub fn new(model: Model, layers: Vec<Layer<R, C>>) -> Result<Self, StackError> {
        error::validate(&layers)?;
        Ok(Self::unchecked(model, None, layers))
    }

    pub(crate) fn unchecked(model: Model, widths: Option<Widths>, layers: Vec<Layer<R, C>>) -> Self {
        let rule = widths.unwrap_or(model.widths());
        Stack {
            widened: (rule != Widths::Own).then(|| rule.apply(&layers)),
            layers,
            model,
            widths,
            #[cfg(feature = "std")]
            tables: coupled::Lazy::default(),
        }
    }

    /// The tables of the coupled model, built or not.
    #[cfg(feature = "std")]
    fn tables(&self) -> &coupled::Lazy<C> {
        &self.tables
    }

    /// The layers as written, from the top.
    pub fn layers(&self) -> &[Layer<R, C>] {
        &self.layers
    }

    /// The layers with the widths that the models take: what a GPU buffer is to hold.
    pub fn effective_layers(&self) -> &[Layer<R, C>] {
        self.widened.as_ref().unwrap_or(&self.layers)
    }

    /// The model that [`Stack::evaluate`] uses.
    pub fn model(&self) -> Model {
        self.model
    }

    /// The same layers under another model, and under its rule of widths unless one was asked for.
    pub fn with_model(self, model: Model) -> Self {
        let widths = self.widths;
        self.under(model, widths)
    }

    /// The rule by which covered interfaces are widened.
    pub fn widths(&self) -> Widths {
        self.rule()
    }

    /// The same layers under another rule of widths, whatever the model.
    pub fn with_widths(self, widths: Widths) -> Self {
        let model = self.model;
        self.under(model, Some(widths))
    }

    /// Another rule needs tables of its own; another model alone does not.
    fn under(self, model: Model, widths: Option<Widths>) -> Self {
        let rule = self.rule();
        let other = Self { model, widths, ..self };
        if other.rule() == rule { other } else { Self::unchecked(model, widths, other.layers) }
    }

    /// The BRDF in sr⁻¹ for a pair of local unit directions, a value for each channel.
    ///
    /// `wi` points towards the light, `wo` towards the viewer. 0 where either is at or below the horizon.
    #[inline]
    pub fn evaluate(&self, wi: impl Into<Vector<R>>, wo: impl Into<Vector<R>>) -> [R; C] {
        let (wi, wo) = (wi.into(), wo.into());
        let layers = self.effective_layers();
        match self.model {
            Model::Elek => elek(layers, wi, wo),
            Model::WeidlichWilkie => weidlich_wilkie(layers, wi, wo),
            Model::Conserving => conserving(layers, wi, wo),
            #[cfg(feature = "std")]
            Model::Coupled => coupled::evaluate(layers, self.tables.get(&self.layers, layers), wi, wo),
            #[cfg(feature = "std")]
            Model::Walk => {
                let options = crate::walk::Options::default();
                crate::walk::evaluate(&self.cast(), wi.cast(), wo.cast(), &options).mean.map(R::from_f64)
            }
        }
    }

    /// The same stack over another number type.
    pub fn cast<S: Real>(&self) -> Stack<S, C> {
        Stack {
            layers: self.layers.iter().map(Layer::cast).collect(),
            model: self.model,
            widths: self.widths,
            widened: self.widened.as_ref().map(|layers| layers.iter().map(Layer::cast).collect()),
            #[cfg(feature = "std")]
            tables: self.tables.clone(),
        }
    }
}

impl<R: Real> Stack<R, 1> {
    /// The stack with this one channel in each of `C`.
    pub fn broadcast<const C: usize>(&self) -> Stack<R, C> {
        let layer = |layer: &Layer<R, 1>| Layer {
            interface: match layer.interface {
                Interface::Microfacet { n: [n], k: [k], alpha } => {
                    Interface::Microfacet { n: [n; C], k: [k; C], alpha }
                }
                Interface::Diffuse { albedo: [albedo], sigma } => Interface::Diffuse { albedo: [albedo; C], sigma },
            },
            medium: Medium { sigma: [layer.medium.sigma[0]; C], thickness: layer.medium.thickness },
        };
        Stack::unchecked(self.model, self.widths, self.layers.iter().map(layer).collect())
    }
}
