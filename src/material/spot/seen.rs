//! What a spot draws for one view.

use super::{MOST_PARTS, Share, Spot, turned};
use crate::frame::Vector;
use crate::material::brushed::Brushed;
use crate::real::{Mask, Real};
use crate::sampling::{Sample, View, cosine_hemisphere};

/// A [`Spot`] seen from a direction: the lobes of its parts, found once for any number of samples and densities.
#[derive(Clone, Debug)]
pub struct Seen<'s, 'a, R> {
    pub(super) spot: &'s Spot<'a, R>,
    pub(super) wo: Vector<R>,
    pub(super) lobes: [Option<Lobes<R>>; MOST_PARTS],
}

impl<R: Real> Seen<'_, '_, R> {
    /// [`Spot::reflected`] towards this view.
    pub fn reflected(&self, wi: Vector<R>) -> [R; 3] {
        self.spot.reflected(wi, self.wo)
    }

    /// A direction `wi`, drawn about in proportion to [`Spot::reflected`], and its density.
    ///
    /// `u`: four independent numbers in [0, 1). The first chooses the part. None where the numbers lead to no direction; such a
    /// sample counts as 0.
    pub fn sample(&self, u: [R; 4]) -> Option<Sample<R>> {
        let [choice, u @ ..] = u;
        let mut rest = choice;
        let chosen = self.parts().find(|(part, _)| {
            let here = rest.lt(part.share).any();
            rest = rest - part.share;
            here
        });
        // Shares add up to 1 but for rounding.
        let (part, lobes) = chosen.or_else(|| self.parts().last())?;
        let wi = part.to_surface(lobes.as_ref()?.direction(u)?);
        let pdf = self.pdf(wi);
        pdf.gt(R::ZERO).all().then_some(Sample { wi, pdf })
    }

    /// The density in sr⁻¹ with which [`Seen::sample`] draws `wi`. 0 where it or the view is at or below the horizon.
    pub fn pdf(&self, wi: Vector<R>) -> R {
        if !wi.z.min(self.wo.z).gt(R::ZERO).any() {
            return R::ZERO;
        }
        self.parts().fold(R::ZERO, |sum, (part, lobes)| {
            let wi = part.to_own(wi);
            match lobes {
                Some(lobes) if wi.z.gt(R::ZERO).any() => sum + part.share * lobes.pdf(wi),
                _ => sum,
            }
        })
    }

    fn parts(&self) -> impl Iterator<Item = (&Share<'_, R>, &Option<Lobes<R>>)> {
        self.spot.parts.iter().zip(&self.lobes).filter_map(|(part, lobes)| Some((part.as_ref()?, lobes)))
    }
}

/// What a part draws for a view, in the part's own frame.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant)] // in a box, each point of a picture would allocate
pub(super) enum Lobes<R> {
    /// Lobes of layers; the share `even` of the samples is drawn from the cosine instead.
    Layers {
        view: View<R>,
        even: R,
    },
    /// The view is turned as the metal is.
    Brushed {
        metal: Brushed<R, 3>,
        turn: (R, R),
        wo: Vector<R>,
    },
    Whole(View<f64>),
}

impl<R: Real> Lobes<R> {
    /// A direction above the horizon.
    fn direction(&self, [choice, u, v]: [R; 3]) -> Option<Vector<R>> {
        let wi = match self {
            Lobes::Layers { even, .. } if choice.lt(*even).any() => cosine_hemisphere([u, v]),
            Lobes::Layers { view, even } => view.direction([(choice - *even) / (R::ONE - *even), u, v]),
            Lobes::Brushed { metal, turn: (cosine, sine), wo } => {
                turned(metal.sample(*wo, [choice, u, v])?.wi, (*cosine, -*sine))
            }
            Lobes::Whole(view) => view.direction([choice, u, v].map(R::to_f64)).cast(),
        };
        wi.z.gt(R::ZERO).all().then_some(wi)
    }

    /// The density of a direction.
    fn pdf(&self, wi: Vector<R>) -> R {
        match self {
            Lobes::Layers { view, even } => view.pdf(wi) * (R::ONE - *even) + wi.z.max(R::ZERO) * R::FRAC_1_PI * *even,
            Lobes::Brushed { metal, turn, wo } => metal.pdf(turned(wi, *turn), *wo),
            Lobes::Whole(view) => R::from_f64(view.pdf(wi.cast())),
        }
    }
}
