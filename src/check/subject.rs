//! What is judged: anything that returns a BRDF for a pair of directions.

use crate::frame::Vector;

/// A BRDF under judgement, its parameters fixed.
///
/// `f` is in sr⁻¹, without the cosine, one number per channel; directions are unit, in the local frame, and point away
/// from the surface. The judge assumes nothing else: neither isotropy nor reciprocity nor a finite result.
///
/// A subject is called from several threads at once and must return the same numbers for the same directions.
pub trait Subject: Sync {
    /// What the report calls the subject.
    fn name(&self) -> String;

    /// How many numbers `f` holds: 3 is RGB.
    fn channels(&self) -> usize;

    /// Writes the BRDF in double precision into `f`, which has [`Subject::channels`] entries.
    fn evaluate(&self, wi: Vector<f64>, wo: Vector<f64>, f: &mut [f64]);

    /// Writes the BRDF as single precision computes it and returns true, or returns false where there is no such thing.
    fn evaluate_single(&self, _wi: Vector<f32>, _wo: Vector<f32>, _f: &mut [f32]) -> bool {
        false
    }

    /// Writes the BRDF of each pair (wi, wo) into `f`, [`Subject::channels`] numbers for a pair: as
    /// [`Subject::evaluate`], for subjects that do many at once faster.
    fn evaluate_many(&self, pairs: &[(Vector<f64>, Vector<f64>)], f: &mut [f64]) {
        let channels = self.channels().max(1);
        for (&(wi, wo), f) in pairs.iter().zip(f.chunks_exact_mut(channels)) {
            self.evaluate(wi, wo, f);
        }
    }

    /// As [`Subject::evaluate_single`] for each pair, into `f` as [`Subject::evaluate_many`] does.
    fn evaluate_single_many(&self, pairs: &[(Vector<f32>, Vector<f32>)], f: &mut [f32]) -> bool {
        let channels = self.channels().max(1);
        pairs.iter().zip(f.chunks_exact_mut(channels)).all(|(&(wi, wo), f)| self.evaluate_single(wi, wo, f))
    }

    /// Whether the subject draws directions: whether [`Subject::sample`] and [`Subject::pdf`] mean anything.
    fn samples(&self) -> bool {
        false
    }

    /// Draws a direction for `wo` from three numbers even in [0, 1); nothing where the path ends.
    fn sample(&self, _wo: Vector<f64>, _u: [f64; 3]) -> Option<Sample> {
        None
    }

    /// The density, in sr⁻¹ about `wi`, with which [`Subject::sample`] draws `wi` for `wo`.
    fn pdf(&self, _wi: Vector<f64>, _wo: Vector<f64>) -> f64 {
        0.0
    }

    /// What a reader of the report must know of the subject besides its numbers: data that is missing, an evaluation that
    /// broke off, a property that holds by construction. One line each; asked for after the checks.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }

    /// What the report calls a channel: r, g, b of three, nothing of one, else its number.
    fn channel_name(&self, channel: usize) -> String {
        match (self.channels(), channel) {
            (1, _) => String::new(),
            (3, 0) => "r".into(),
            (3, 1) => "g".into(),
            (3, 2) => "b".into(),
            _ => format!("channel {channel}"),
        }
    }
}

/// A direction that a subject drew.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// The direction.
    pub wi: Vector<f64>,
    /// f·cosθ/pdf of each channel.
    pub weight: Vec<f64>,
    /// The density that it was drawn with, in sr⁻¹.
    pub pdf: f64,
}

/// A subject made of a closure; see [`from_fn`].
#[derive(Clone, Debug)]
pub struct FromFn<F> {
    name: String,
    channels: usize,
    f: F,
}

/// A subject from a closure that writes `channels` numbers for `(wi, wo)`.
///
/// ```
/// use brdf::check;
/// let lambert = check::from_fn("Lambert", 1, |_wi, _wo, f| f[0] = std::f64::consts::FRAC_1_PI);
/// assert_eq!(check::Subject::name(&lambert), "Lambert");
/// ```
pub fn from_fn<F>(name: impl Into<String>, channels: usize, f: F) -> FromFn<F>
where
    F: Fn(Vector<f64>, Vector<f64>, &mut [f64]) + Sync,
{
    FromFn { name: name.into(), channels, f }
}

impl<F> Subject for FromFn<F>
where
    F: Fn(Vector<f64>, Vector<f64>, &mut [f64]) + Sync,
{
    fn name(&self) -> String {
        self.name.clone()
    }
    fn channels(&self) -> usize {
        self.channels
    }
    fn evaluate(&self, wi: Vector<f64>, wo: Vector<f64>, f: &mut [f64]) {
        (self.f)(wi, wo, f);
    }
}

/// The direction that an integral holds fixed: its *marginal*.
///
/// A furnace image fixes the view, so a model that is normalised per view passes every furnace and may still reflect
/// more than it receives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fixed {
    /// `wo` is fixed, `wi` is integrated over: what a furnace image shows.
    View,
    /// `wi` is fixed, `wo` is integrated over: the share of one light that is reflected.
    Light,
}

impl Fixed {
    /// Both marginals.
    pub const BOTH: [Fixed; 2] = [Fixed::View, Fixed::Light];

    /// `view` or `light`.
    pub const fn name(self) -> &'static str {
        match self {
            Fixed::View => "view",
            Fixed::Light => "light",
        }
    }
}

/// A pair of directions: wi, wo.
pub(super) type Pair = (Vector<f64>, Vector<f64>);

/// A subject with one of its directions fixed, as a function of the other one.
#[derive(Clone, Copy)]
pub(super) struct Section<'a> {
    pub(super) subject: &'a dyn Subject,
    pub(super) direction: Vector<f64>,
    pub(super) fixed: Fixed,
}

/// The defects that an integral met on its way: a cubature refines towards them, so it meets what samples miss.
#[derive(Clone, Debug, Default)]
pub(super) struct Watch {
    /// Evaluations at which some channel was not finite, and the first such pair with its channel.
    pub(super) broken: usize,
    pub(super) broken_at: Option<(usize, Pair)>,
    /// The least f below 0, its channel and its pair.
    pub(super) least: Option<(f64, usize, Pair)>,
}

impl Watch {
    /// What both have met.
    pub(super) fn with(self, other: Watch) -> Watch {
        let lower = |a: &(f64, usize, Pair), b: &(f64, usize, Pair)| b.0 < a.0;
        let least = match (self.least, other.least) {
            (Some(a), Some(b)) => Some(if lower(&a, &b) { b } else { a }),
            (a, b) => a.or(b),
        };
        Watch { broken: self.broken + other.broken, broken_at: self.broken_at.or(other.broken_at), least }
    }
}

/// A section that is evaluated in blocks, counted and watched.
pub(super) struct Probe<'a> {
    pub(super) section: Section<'a>,
    pub(super) watch: Watch,
    pub(super) evaluations: usize,
    channels: usize,
    pairs: Vec<Pair>,
}

impl<'a> Probe<'a> {
    pub(super) fn new(section: Section<'a>) -> Self {
        let channels = section.subject.channels().max(1);
        Probe { section, watch: Watch::default(), evaluations: 0, channels, pairs: Vec::new() }
    }

    /// Writes f for each free direction, the subject's channels one after the other. What is not finite reads 0.
    pub(super) fn evaluate(&mut self, free: &[Vector<f64>], f: &mut [f64]) {
        let Section { subject, direction, fixed } = self.section;
        self.pairs.clear();
        self.pairs.extend(free.iter().map(|&v| match fixed {
            Fixed::View => (v, direction),
            Fixed::Light => (direction, v),
        }));
        f.fill(0.0);
        subject.evaluate_many(&self.pairs, f);
        self.evaluations += free.len();
        for (&pair, f) in self.pairs.iter().zip(f.chunks_exact_mut(self.channels)) {
            let mut broken = false;
            for (channel, x) in f.iter_mut().enumerate() {
                if !x.is_finite() {
                    *x = 0.0;
                    broken = true;
                    self.watch.broken_at.get_or_insert((channel, pair));
                } else if *x < self.watch.least.map_or(0.0, |(least, ..)| least) && pair.0.z > 0.0 && pair.1.z > 0.0 {
                    self.watch.least = Some((*x, channel, pair));
                }
            }
            self.watch.broken += usize::from(broken);
        }
    }
}
