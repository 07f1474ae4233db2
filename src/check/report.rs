//! What a check found, as data. As a table it is written by its `Display`.

use super::energy::Albedo;
use super::family::Parameter;
use super::subject::Fixed;
use super::verdict::Verdict;
use crate::frame::Vector;

/// What was checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Check {
    /// Albedo ≤ 1.
    Energy,
    /// f(a, b) = f(b, a).
    Reciprocity,
    /// Neither NaN nor infinite above the horizon.
    Finite,
    /// Not negative above the horizon.
    Sign,
    /// What is returned at and below the horizon. Never binds: a renderer need not ask.
    Horizon,
    /// Single against double precision. Never binds.
    Precision,
    /// A GPU against double precision. Never binds. The judge itself runs none: its caller adds it.
    Gpu,
    /// What [`Subject::sample`](super::Subject::sample) draws against its density, by χ². The value is the p-value.
    Sampling,
    /// The density of samples: finite, not negative, its integral at most 1.
    Density,
    /// The weight of samples against f·cos/pdf, relatively.
    Weight,
    /// A limit in which the subject must be another one, relatively: isotropic where both widths are equal.
    Limit,
    /// ∫ D cosθ = 1 of a distribution.
    Normalisation,
    /// The WGSL twin against the Rust function, in shares of what WGSL allows. The judge itself runs no twin: its caller adds it.
    Twin,
}

impl Check {
    /// Every check.
    pub const ALL: [Check; 13] = [
        Check::Energy,
        Check::Reciprocity,
        Check::Finite,
        Check::Sign,
        Check::Horizon,
        Check::Precision,
        Check::Gpu,
        Check::Sampling,
        Check::Density,
        Check::Weight,
        Check::Limit,
        Check::Normalisation,
        Check::Twin,
    ];

    /// The name in the table.
    pub const fn name(self) -> &'static str {
        match self {
            Check::Energy => "ENERGY",
            Check::Reciprocity => "RECIPROCITY",
            Check::Finite => "FINITE",
            Check::Sign => "SIGN",
            Check::Horizon => "HORIZON",
            Check::Precision => "PRECISION",
            Check::Gpu => "GPU",
            Check::Sampling => "SAMPLING",
            Check::Density => "DENSITY",
            Check::Weight => "WEIGHT",
            Check::Limit => "LIMIT",
            Check::Normalisation => "NORMALISATION",
            Check::Twin => "TWIN",
        }
    }
}

/// Where a finding was made: what has to be put in to see it again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// Everywhere that was looked.
    Everywhere,
    /// The direction that an albedo holds fixed, in degrees.
    Marginal {
        /// Polar angle.
        theta: f64,
        /// Azimuth.
        phi: f64,
        /// Which direction.
        fixed: Fixed,
    },
    /// A pair of directions.
    Pair {
        /// Towards the light.
        wi: Vector<f64>,
        /// Towards the viewer.
        wo: Vector<f64>,
    },
}

/// One line of the report: a check, its verdict, and the worst case that led to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// What was checked.
    pub check: Check,
    /// Whether it was the single-precision instance that was judged; else double precision.
    pub single: bool,
    /// The outcome.
    pub verdict: Verdict,
    /// Whether the outcome counts in [`Report::verdict`]. An advisory finding does not.
    pub binding: bool,
    /// Whether a baseline knows of it: an accepted finding does not count either.
    pub accepted: bool,
    /// The worst value: an albedo, a relative difference, a count of non-finite samples, the least f.
    pub value: f64,
    /// What the value may be wrong by; 0 where it is exact.
    pub error: f64,
    /// What the value was held against, its tolerance included.
    pub limit: f64,
    /// Where the value was found.
    pub place: Place,
    /// The channel, and its name.
    pub channel: Option<(usize, String)>,
    /// What else a reader should know: counts.
    pub note: String,
    /// The parameters of the member that it was found in, by name; empty where nothing was searched.
    pub parameters: Vec<(String, f64)>,
    /// f at [`Finding::place`], where that is a pair of directions.
    pub values: Option<Values>,
    /// What is likely wrong, in words that say what to change; empty where nothing is known.
    pub cause: String,
    /// The command that shows the finding again; empty where nobody filled it in.
    pub again: String,
}

/// f of every channel at one pair of directions, by what computed it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Values {
    /// In double precision.
    pub double: Vec<f64>,
    /// In single precision; empty where the subject has none.
    pub single: Vec<f64>,
    /// On an adapter; empty where none ran it.
    pub gpu: Vec<f64>,
}

impl Finding {
    /// A finding to be filled in: inconclusive, binding, in double precision, everywhere.
    pub fn new(check: Check) -> Self {
        Finding {
            check,
            single: false,
            verdict: Verdict::Inconclusive,
            binding: true,
            accepted: false,
            value: 0.0,
            error: 0.0,
            limit: 0.0,
            place: Place::Everywhere,
            channel: None,
            note: String::new(),
            parameters: Vec::new(),
            values: None,
            cause: String::new(),
            again: String::new(),
        }
    }
}

/// What was looked at, so that a pass can be read for what it is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Coverage {
    /// Seed of every random choice.
    pub seed: u32,
    /// Evaluations that were asked for.
    pub budget: usize,
    /// Evaluations that were made.
    pub evaluations: usize,
    /// Directions whose albedo was integrated.
    pub integrals: usize,
    /// Pairs of directions that were tried.
    pub pairs: usize,
    /// Optimiser runs that started from the worst of them.
    pub restarts: usize,
    /// Whether a common rotation about the normal was measured to change f.
    pub anisotropic: bool,
    /// The parameters whose ranges were searched; none for a subject without.
    pub parameters: Vec<Parameter>,
    /// Members of the family that were looked at, and those of them that were put through every check.
    pub members: [usize; 2],
}

/// Everything that was found about one subject.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// The subject's name.
    pub subject: String,
    /// The names of its channels.
    pub channel_names: Vec<String>,
    /// One finding per check.
    pub findings: Vec<Finding>,
    /// The albedos that the energy findings rest on, by marginal, azimuth and polar angle.
    pub albedos: Vec<Albedo>,
    /// What was looked at.
    pub coverage: Coverage,
    /// What the subject says of itself ([`Subject::notes`](super::subject::Subject::notes)).
    pub notes: Vec<String>,
}

impl Report {
    /// The worst verdict of the binding findings, accepted ones taken as passes; inconclusive if there are none.
    pub fn verdict(&self) -> Verdict {
        let binding = self.findings.iter().filter(|finding| finding.binding);
        let verdict = |finding: &Finding| if finding.accepted { Verdict::Pass } else { finding.verdict };
        binding.map(verdict).max().unwrap_or(Verdict::Inconclusive)
    }

    /// The first finding of a check, if it was made.
    pub fn finding(&self, check: Check) -> Option<&Finding> {
        self.findings.iter().find(|finding| finding.check == check)
    }

    /// The energy finding of one marginal, if it was made.
    pub fn energy(&self, which: Fixed) -> Option<&Finding> {
        self.findings.iter().find(|finding| {
            finding.check == Check::Energy && matches!(finding.place, Place::Marginal { fixed, .. } if fixed == which)
        })
    }
}
