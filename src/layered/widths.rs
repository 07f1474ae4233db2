//! How wide the lobe of an interface under others is taken to be.

use super::{Interface, Layer};
use crate::real::Real;
use alloc::vec::Vec;

/// The width that a model gives to an interface which others cover. [`Model::widths`](super::Model::widths) is what each
/// model takes where a stack asks for none.
///
/// Light that passes a rough interface is spread before it meets the next one, so the lower lobe looks wider than it is.
/// No closed-form model here follows that by itself; these rules stand in for it. They replace α alone: directions, Fresnel
/// terms and absorption keep to the layers as written, and [`crate::walk`] ignores the rule.
///
/// # Error
///
/// By the walk, a metal of α = .05 under n = 1.5, α = .4 falls off from the normal as one of α = .099 under a smooth coat
/// does (`tests/widths.rs`). [`Widths::Own`] says .05, [`Widths::Clamp`] .40 and [`Widths::Variance`] .107.
///
/// Of f over the lit pairs of `brdf bench layered` (its built-in stacks and `examples/stacks/*.toml`), root mean square
/// against the walk, own → variance: `coupled` 44 → 20 % for copper of α = .1 under n = 1.5, α = .3; 192 → 31 % for α = .05
/// under .4; 788 → 88 % for `coated_gold`; 7 → 2 % for `cuprite_over_copper`; unchanged or better elsewhere. `conserving`
/// 47 → 28, 217 → 34, 736 → 81 and 11 → 9 %.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Widths {
    /// Each interface's own α. ([`Model::Elek`](super::Model::Elek) clamps by itself.)
    #[default]
    Own,
    /// No interface smoother than the one above it: α ← max(α, α of the layer above). The documents' rule (Elek 2010,
    /// Algorithm 1), 3 to 5 times too wide.
    Clamp,
    /// The variances of slopes add up: see [`Widths::apply`].
    Variance,
}

impl Widths {
    /// Every rule.
    pub const ALL: [Widths; 3] = [Widths::Own, Widths::Clamp, Widths::Variance];

    /// The name that stack files and the command line use.
    pub const fn name(self) -> &'static str {
        match self {
            Widths::Own => "own",
            Widths::Clamp => "clamp",
            Widths::Variance => "variance",
        }
    }

    /// The rule of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|rule| rule.name() == name)
    }

    /// The layers with the widths that the rule gives them. Diffuse bases have none and stay as they are.
    ///
    /// $$\alpha_\mathrm{eff}^2 = \alpha_k^2 + 2s_k^2,\quad s_{k+1}^2 = \frac{s_k^2}{\eta_k^2}
    ///   + \left(\tfrac12\left(1-\frac1{\eta_k}\right)\alpha_k\right)^2,\quad s_0 = 0$$
    ///
    /// In plain text ([`Widths::Variance`]): α_eff² = α² + 2·s², where s, the spread of one direction in terms of the half
    /// vector's slope, grows by ½(1−1/η)·α at each interface of relative index η and is divided by η as directions refract.
    /// The 2 is for the way in and the way out. With two layers this is α_eff² = α₂² + 2(½(1−1/n)α₁)².
    ///
    /// First order in α at normal incidence: within 1 % of the walk's width at α₁ = .1, 8 % at .4 for n = 1.5, 17 % there
    /// for n = 2. At most 1. Where n differs between channels, their mean counts.
    pub fn apply<R: Real, const C: usize>(self, layers: &[Layer<R, C>]) -> Vec<Layer<R, C>> {
        let mut layers = layers.to_vec();
        self.widen(&mut layers);
        layers
    }

    /// [`Widths::apply`] in place.
    pub(crate) fn widen<R: Real, const C: usize>(self, layers: &mut [Layer<R, C>]) {
        let (mut widest, mut spread, mut n_above) = (R::ZERO, R::ZERO, R::ONE);
        let mut widened = |layer: &Layer<R, C>| {
            let Interface::Microfacet { n, k, alpha } = layer.interface else { return *layer };
            let effective = match self {
                Widths::Own => alpha,
                Widths::Clamp => {
                    widest = widest.max(alpha);
                    widest
                }
                Widths::Variance => {
                    let effective = (alpha * alpha + spread + spread).sqrt().min(R::ONE);
                    let n = n.into_iter().fold(R::ZERO, |sum, n| sum + n) / R::from_f64(C as f64);
                    let inverse = n_above / n;
                    let added = R::HALF * (R::ONE - inverse) * alpha;
                    spread = spread * inverse * inverse + added * added;
                    n_above = n;
                    effective
                }
            };
            Layer { interface: Interface::Microfacet { n, k, alpha: effective }, medium: layer.medium }
        };
        for layer in layers {
            *layer = widened(layer);
        }
    }
}
