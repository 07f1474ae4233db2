//! A material prepared for a picture: what a path asks of it at each point, at the least cost.
//!
//! A material that is one stack under a closed-form model, the same everywhere, is evaluated by its [`Plan`] and sampled by a prepared
//! [`Views`]; everything else by its [`Spot`]. Both reflect the same but for rounding; they draw with densities of their own.

use super::Number;
use crate::frame::Vector;
use crate::layered::Stack;
use crate::material::finish::Body;
use crate::material::{Colour, Material, Part, Point, Seen, Spot};
use crate::plan::Plan;
use crate::sampling::{Sample, View, Views};

/// A material, prepared.
#[derive(Clone, Debug)]
pub struct Shading<'a> {
    material: &'a Material,
    whole: Option<(Plan<3>, Views)>,
}

impl<'a> Shading<'a> {
    /// Prepares a material.
    pub fn new(material: &'a Material) -> Self {
        let whole = whole(material).and_then(|stack| Some((Plan::new(stack).ok()?, Views::new(stack)?)));
        Shading { material, whole }
    }

    /// The material at a point, which is only looked for where the material asks.
    #[inline]
    pub fn at<R: Number>(&self, point: impl FnOnce() -> Point<R>) -> Local<'_, R> {
        match &self.whole {
            Some((plan, views)) => Local::Whole(plan, views),
            None => Local::Spot(self.material.at(&point())),
        }
    }
}

/// The one stack that a material is, if it is.
pub(super) fn whole(material: &Material) -> Option<&Stack<f64, 3>> {
    let [Part { finish, .. }] = material.parts() else { return None };
    match &finish.body {
        Body::Whole(stack) if finish.relief.is_none() && finish.reflectivity == Colour::Constant([1.0; 3]) => {
            Some(stack)
        }
        _ => None,
    }
}

/// A material at a point.
#[derive(Clone, Debug)]
pub enum Local<'a, R> {
    /// A stack, the same everywhere.
    Whole(&'a Plan<3>, &'a Views),
    /// The material's fields at this point.
    Spot(Spot<'a, R>),
}

impl<R: Number> Local<'_, R> {
    /// The material seen from a local direction.
    #[inline(always)]
    pub fn facing(&self, wo: Vector<R>) -> Facing<'_, R> {
        match self {
            Local::Whole(plan, views) => Facing::Whole(plan, views.facing(wo), wo),
            Local::Spot(spot) => Facing::Spot(spot.facing(wo)),
        }
    }
}

/// A material at a point, seen from a direction.
#[derive(Clone, Debug)]
pub enum Facing<'a, R> {
    /// A stack: its plan and its lobes.
    Whole(&'a Plan<3>, View<R>, Vector<R>),
    /// Anything else.
    Spot(Seen<'a, 'a, R>),
}

impl<R: Number> Facing<'_, R> {
    /// f·cos towards the viewer, in sr⁻¹.
    #[inline]
    pub fn reflected(&self, wi: Vector<R>) -> [R; 3] {
        match self {
            Facing::Whole(plan, _, wo) => plan.evaluate(wi, *wo).map(|f| f * wi.z.max(R::ZERO)),
            Facing::Spot(seen) => seen.reflected(wi),
        }
    }

    /// A direction drawn about in proportion to it, and its density.
    #[inline]
    pub fn sample(&self, u: [R; 4]) -> Option<Sample<R>> {
        match self {
            Facing::Whole(_, view, _) => view.sample([u[1], u[2], u[3]]),
            Facing::Spot(seen) => seen.sample(u),
        }
    }

    /// The density with which a direction is drawn.
    #[inline]
    pub fn pdf(&self, wi: Vector<R>) -> R {
        match self {
            Facing::Whole(_, view, _) => view.pdf(wi),
            Facing::Spot(seen) => seen.pdf(wi),
        }
    }
}
