//! BRDFs with parameters: what is searched for its worst case.

use super::subject::Subject;

/// How a parameter is stepped through when it is searched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    #[default]
    Linear,
    /// Every magnitude alike: a width, an extinction. Takes a range above 0.
    Logarithmic,
    /// 0 or 1.
    Switch,
}

impl Scale {
    /// Every scale.
    pub const ALL: [Scale; 3] = [Scale::Linear, Scale::Logarithmic, Scale::Switch];

    /// `linear`, `logarithmic` or `switch`.
    pub const fn name(self) -> &'static str {
        match self {
            Scale::Linear => "linear",
            Scale::Logarithmic => "logarithmic",
            Scale::Switch => "switch",
        }
    }
}

/// A parameter of a [`Family`], its range, and the value that it has if nobody sets it.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// The name that reports give it.
    pub name: String,
    /// The least value.
    pub low: f64,
    /// The largest value.
    pub high: f64,
    /// The value unless set, in [`low`, `high`](Parameter::low).
    pub default: f64,
    /// How it is searched.
    pub scale: Scale,
}

/// A BRDF whose parameters are open: a shader with a roughness, a material with sliders.
///
/// [`check_family`](super::check_family) searches the box of the parameters' ranges. A [`Subject`] is one member.
pub trait Family: Sync {
    /// What the report calls the family.
    fn name(&self) -> String;

    /// The parameters; none if there is nothing to search.
    fn parameters(&self) -> &[Parameter];

    /// The member with these values, one for each parameter in their order, each within its range.
    fn subject(&self, values: &[f64]) -> Box<dyn Subject + '_>;
}
