//! Stages in a row, and one evaluation through them.

use super::interface::{
    AnyConductor, AnyDielectric, Conductor, Dielectric, Each, Fitted, Grey, Metal, Reflects, Transmits,
};
use super::stage::{Absorption, Base, Lobe, Passage, Ray};
use crate::frame::Vector;
use crate::layered::Model;
use crate::real::{Mask, Real};
use alloc::vec::Vec;

/// The Fresnel term of an interface in the cheapest form that is exact there, or fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Surface<const K: usize> {
    Dielectric(Dielectric),
    AnyDielectric(AnyDielectric),
    GreyMetal(Grey<Metal>),
    Metals(Each<Metal, K>),
    Conductors(Each<Conductor, K>),
    AnyConductors(Each<AnyConductor, K>),
    Fit8(Fitted<K, 8>),
    Fit10(Fitted<K, 10>),
    Fit12(Fitted<K, 12>),
}

/// How an interface is passed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Way<const K: usize> {
    Dielectric(Dielectric),
    AnyDielectric(AnyDielectric),
    AnyConductors(Each<AnyConductor, K>),
    Fit8(Fitted<K, 8>),
    Fit10(Fitted<K, 10>),
    Fit12(Fitted<K, 12>),
}

/// One step of an evaluation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Stage<const K: usize> {
    Reflect { lobe: Lobe, surface: Surface<K> },
    Pass { passage: Passage, way: Way<K>, model: Model },
    Absorb(Absorption<K>),
    Lambert(Base<K>),
    OrenNayar { base: Base<K>, about_half: bool },
}

/// What an interface reflects, its Fresnel term of one form.
#[derive(Clone, Copy)]
pub(crate) struct Reflect<F> {
    pub(crate) lobe: Lobe,
    pub(crate) fresnel: F,
}

/// The energy-conserving way through an interface, its Fresnel term of one form.
#[derive(Clone, Copy)]
pub(crate) struct Conserve<F> {
    pub(crate) passage: Passage,
    pub(crate) fresnel: F,
}

/// Oren and Nayar's base, refracted to about the macro normal.
#[derive(Clone, Copy)]
pub(crate) struct Rough<const K: usize>(pub(crate) Base<K>);

/// Steps whose types are known when they are compiled, so that they stay in registers from one to the next.
pub(crate) trait Steps<const K: usize>: Copy {
    /// Takes one evaluation through all of them. `wi` and `wo` are its directions above the stack.
    fn take<W: Real<Wide = W>>(&self, ray: &mut Ray<W, K>, wi: Vector<W>, wo: Vector<W>);
}

impl<F: Reflects<K> + Copy, const K: usize> Steps<K> for Reflect<F> {
    #[inline(always)]
    fn take<W: Real<Wide = W>>(&self, ray: &mut Ray<W, K>, _: Vector<W>, _: Vector<W>) {
        self.lobe.reflect(ray, &self.fresnel);
    }
}

impl<F: Transmits<K> + Copy, const K: usize> Steps<K> for Conserve<F> {
    #[inline(always)]
    fn take<W: Real<Wide = W>>(&self, ray: &mut Ray<W, K>, wi: Vector<W>, wo: Vector<W>) {
        self.passage.conserve(ray, (wi.z, wo.z), &self.fresnel);
    }
}

impl<const K: usize> Steps<K> for Absorption<K> {
    #[inline(always)]
    fn take<W: Real<Wide = W>>(&self, ray: &mut Ray<W, K>, _: Vector<W>, _: Vector<W>) {
        self.absorb(ray);
    }
}

/// Lambert's base.
impl<const K: usize> Steps<K> for Base<K> {
    #[inline(always)]
    fn take<W: Real<Wide = W>>(&self, ray: &mut Ray<W, K>, _: Vector<W>, _: Vector<W>) {
        self.lambert(ray);
    }
}

impl<const K: usize> Steps<K> for Rough<K> {
    #[inline(always)]
    fn take<W: Real<Wide = W>>(&self, ray: &mut Ray<W, K>, wi: Vector<W>, wo: Vector<W>) {
        self.0.oren_nayar(ray, wi, wo, false);
    }
}

impl<A: Steps<K>, B: Steps<K>, const K: usize> Steps<K> for (A, B) {
    #[inline(always)]
    fn take<W: Real<Wide = W>>(&self, ray: &mut Ray<W, K>, wi: Vector<W>, wo: Vector<W>) {
        self.0.take(ray, wi, wo);
        self.1.take(ray, wi, wo);
    }
}

/// Calls a closure-like body with the surface's own type.
macro_rules! with_surface {
    ($surface:expr, $fresnel:ident => $body:expr) => {
        match $surface {
            $crate::plan::chain::Surface::Dielectric($fresnel) => $body,
            $crate::plan::chain::Surface::AnyDielectric($fresnel) => $body,
            $crate::plan::chain::Surface::GreyMetal($fresnel) => $body,
            $crate::plan::chain::Surface::Metals($fresnel) => $body,
            $crate::plan::chain::Surface::Conductors($fresnel) => $body,
            $crate::plan::chain::Surface::AnyConductors($fresnel) => $body,
            $crate::plan::chain::Surface::Fit8($fresnel) => $body,
            $crate::plan::chain::Surface::Fit10($fresnel) => $body,
            $crate::plan::chain::Surface::Fit12($fresnel) => $body,
        }
    };
}
/// Calls a closure-like body with the surface's own type if it is a form that metals take, and another one if not.
macro_rules! with_metal {
    ($surface:expr, $fresnel:ident => $body:expr, else $other:expr) => {
        match $surface {
            $crate::plan::chain::Surface::GreyMetal($fresnel) => $body,
            $crate::plan::chain::Surface::Metals($fresnel) => $body,
            $crate::plan::chain::Surface::Fit8($fresnel) => $body,
            $crate::plan::chain::Surface::Fit10($fresnel) => $body,
            $crate::plan::chain::Surface::Fit12($fresnel) => $body,
            _ => $other,
        }
    };
}
/// Calls a closure-like body with the way's own type.
macro_rules! with_way {
    ($way:expr, $fresnel:ident => $body:expr) => {
        match $way {
            $crate::plan::chain::Way::Dielectric($fresnel) => $body,
            $crate::plan::chain::Way::AnyDielectric($fresnel) => $body,
            $crate::plan::chain::Way::AnyConductors($fresnel) => $body,
            $crate::plan::chain::Way::Fit8($fresnel) => $body,
            $crate::plan::chain::Way::Fit10($fresnel) => $body,
            $crate::plan::chain::Way::Fit12($fresnel) => $body,
        }
    };
}
pub(crate) use {with_metal, with_surface, with_way};

impl<const K: usize> Stage<K> {
    /// Takes one evaluation a step further. `wi` and `wo` are its directions above the stack.
    #[inline(always)]
    pub(crate) fn step<W: Real<Wide = W>>(&self, ray: &mut Ray<W, K>, wi: Vector<W>, wo: Vector<W>) {
        let top = (wi.z, wo.z);
        match self {
            Stage::Reflect { lobe, surface } => with_surface!(surface, fresnel => lobe.reflect(ray, fresnel)),
            Stage::Pass { passage, way, model } => with_way!(way, fresnel => match model {
                Model::Elek => passage.elek(ray, top, fresnel),
                Model::WeidlichWilkie => passage.weidlich_wilkie(ray, fresnel),
                _ => passage.conserve(ray, top, fresnel),
            }),
            Stage::Absorb(medium) => medium.absorb(ray),
            Stage::Lambert(base) => base.lambert(ray),
            Stage::OrenNayar { base, about_half } => base.oren_nayar(ray, wi, wo, *about_half),
        }
    }
}

/// The stages of channels that share their directions.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Chain<const K: usize> {
    pub(crate) stages: Vec<Stage<K>>,
    /// The layer that each stage is of, counted from the top, from 0.
    pub(crate) layers: Vec<usize>,
}

impl<const K: usize> Chain<K> {
    /// f of one pair of directions.
    #[inline]
    pub(crate) fn evaluate<W: Real<Wide = W>>(&self, wi: Vector<W>, wo: Vector<W>) -> [W; K] {
        let mut ray = Ray::new(wi, wo);
        for stage in &self.stages {
            if !ray.arrives().any() {
                break;
            }
            stage.step(&mut ray, wi, wo);
        }
        ray.f
    }
}
