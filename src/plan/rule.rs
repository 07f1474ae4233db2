//! What a plan leaves out, by name.

use crate::layered::{Interface, Layer, Model, Stack};
use alloc::vec;
use alloc::vec::Vec;
use core::fmt;

/// A rewriting of a stack that leaves its BRDF as it is.
///
/// In f64 a plan agrees with [`Stack::evaluate`](crate::layered::Stack::evaluate) to 1e-12 (`tests/plan.rs`), whatever the rules
/// that applied; [`Rule::OpaqueMedium`] besides leaves out less than 1e-30 sr⁻¹.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Rule {
    /// A medium without absorption or thickness, τ = 0, has no transmittance to compute.
    ClearMedium,
    /// Nothing lies under the last interface: its medium has no effect.
    LastMedium,
    /// An interface with κ = 0 needs no complex index.
    NoConductor,
    /// A dielectric interface between equal indices reflects nothing; the media on both sides are one.
    MatchedIndices,
    /// The layers below a medium that lets less than e⁻⁸⁷ through in every channel.
    OpaqueMedium,
    /// A diffuse base of albedo 0.
    BlackBase,
    /// An Oren–Nayar base with σ = 0 is Lambert's.
    FlatBase,
    /// Channels of one index share their Fresnel term.
    GreyInterface,
    /// Channels that refract alike share their directions and lobes; those of dispersing interfaces do not.
    SharedDirections,
    /// A single interface is the same under every closed-form model.
    SingleInterface,
}

impl Rule {
    /// Every rule.
    pub const ALL: [Rule; 10] = [
        Rule::ClearMedium,
        Rule::LastMedium,
        Rule::NoConductor,
        Rule::MatchedIndices,
        Rule::OpaqueMedium,
        Rule::BlackBase,
        Rule::FlatBase,
        Rule::GreyInterface,
        Rule::SharedDirections,
        Rule::SingleInterface,
    ];

    /// The name that `brdf plan` prints.
    pub const fn name(self) -> &'static str {
        match self {
            Rule::ClearMedium => "clear_medium",
            Rule::LastMedium => "last_medium",
            Rule::NoConductor => "no_conductor",
            Rule::MatchedIndices => "matched_indices",
            Rule::OpaqueMedium => "opaque_medium",
            Rule::BlackBase => "black_base",
            Rule::FlatBase => "flat_base",
            Rule::GreyInterface => "grey_interface",
            Rule::SharedDirections => "shared_directions",
            Rule::SingleInterface => "single_interface",
        }
    }

    /// What it leaves out, and why that changes nothing.
    pub const fn reason(self) -> &'static str {
        match self {
            Rule::ClearMedium => "its medium absorbs nothing: no exponential",
            Rule::LastMedium => "nothing lies under it: its medium has no effect",
            Rule::NoConductor => "κ = 0: the dielectric's Fresnel term",
            Rule::MatchedIndices => "the index of the medium above: reflects nothing, refracts nothing",
            Rule::OpaqueMedium => "its medium lets nothing through: the layers below are dropped",
            Rule::BlackBase => "its albedo is 0: reflects nothing",
            Rule::FlatBase => "σ = 0: Lambert's constant",
            Rule::GreyInterface => "one index in every channel: one Fresnel term for all",
            Rule::SharedDirections => "one refraction and one lobe for all channels",
            Rule::SingleInterface => "alone: every model is the same",
        }
    }

    /// A stack that the rule applies to, by which what it saves is measured (`brdf plan --rules`, `benches/plan.rs`).
    pub fn example(self) -> Stack<f64, 3> {
        let copper = Interface::conductor([0.213, 1.04, 1.17], [4.05, 2.59, 2.36], 0.3);
        let (coat, copper) = (Layer::new(Interface::dielectric(1.5, 0.1)), Layer::new(copper));
        let tint = [0.15, 1.2, 1.6];
        let over = |albedo, sigma| vec![coat.over(tint, 0.4), Layer::new(Interface::diffuse(albedo, sigma))];
        let layers: Vec<Layer<f64, 3>> = match self {
            Rule::ClearMedium | Rule::NoConductor | Rule::SharedDirections => vec![coat, copper],
            Rule::LastMedium => vec![coat, copper.over(tint, 0.4)],
            Rule::MatchedIndices => vec![coat, Layer::new(Interface::dielectric(1.5, 0.3)), copper],
            Rule::OpaqueMedium => vec![coat.over([1.0; 3], 100.0), copper],
            Rule::BlackBase => over([0.0; 3], 0.5),
            Rule::FlatBase => over([0.55, 0.53, 0.5], 0.0),
            Rule::GreyInterface => vec![Layer::new(Interface::conductor([2.9; 3], [3.1; 3], 0.3))],
            Rule::SingleInterface => vec![copper],
        };
        // Each is valid, which a test asserts: they are not empty.
        Stack::unchecked(Model::Conserving, None, layers)
    }
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A rule at work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Applied {
    /// The rule.
    pub rule: Rule,
    /// The layer it was applied to, counted from the top, from 0.
    pub layer: usize,
}
