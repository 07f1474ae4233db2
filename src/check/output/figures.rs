//! What the pictures of a report are drawn from: samples of one subject, small enough to travel inside JSON.
//!
//! Of several channels the largest value is taken, so that nothing that violates is hidden by one that does not. Numbers
//! are kept to five significant digits.

use crate::check::energy::{Effort, albedo};
use crate::check::family::{Family, Scale};
use crate::check::reciprocity::FLOOR;
use crate::check::subject::{Fixed, Subject};
use crate::frame::Vector;
use rayon::prelude::*;

/// Samples of one BRDF: what its pictures show.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figures {
    /// The parameters of the member that was sampled.
    pub parameters: Vec<(String, f64)>,
    /// Albedo against the polar angle of the fixed direction, in degrees, with its error: the view's marginal and the light's.
    pub albedo: Vec<Series>,
    /// f in the plane of incidence, sr⁻¹, against the signed polar angle of `wo`, one series per polar angle of `wi`; the
    /// mirror direction has a positive angle.
    pub lobes: Vec<Series>,
    /// log₁₀ of the largest relative difference of f(wi, wo) and f(wo, wi) over azimuths, NaN where none is finite; x is the polar angle of `wi`, y
    /// that of `wo`.
    pub reciprocity: Grid,
    /// [`FINE`], [`NEGATIVE`] or [`BROKEN`], the worst over azimuths; axes as of [`Figures::reciprocity`].
    pub validity: Grid,
    /// Relative deviation of single precision, and of a GPU, from double precision against the polar angle of `wo`.
    pub precision: Vec<Series>,
    /// log₁₀ of the largest relative deviation of single precision; x is the polar angle of `wo`, y the parameter named.
    pub sweep: Option<(String, Grid)>,
}

/// f is finite and not negative.
pub const FINE: f64 = 0.0;
/// f is negative somewhere.
pub const NEGATIVE: f64 = 1.0;
/// f is NaN or infinite somewhere.
pub const BROKEN: f64 = 2.0;

/// A curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// What the legend calls it.
    pub name: String,
    /// Abscissae.
    pub x: Vec<f64>,
    /// Ordinates, as many.
    pub y: Vec<f64>,
    /// Half the width of the band around the curve, as many or none.
    pub error: Vec<f64>,
}

/// A map: a value for each x and y.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grid {
    /// Abscissae, increasing.
    pub x: Vec<f64>,
    /// Ordinates, increasing.
    pub y: Vec<f64>,
    /// A row of x after the other.
    pub values: Vec<f64>,
}

/// What runs many pairs on a GPU: `channels` numbers for a pair, nothing if it cannot.
pub type OnGpu<'a> = &'a dyn Fn(&[(Vector<f32>, Vector<f32>)]) -> Option<Vec<f32>>;

/// Polar angles of the albedo curves, in degrees: closer where most models fail.
const ALBEDO_ANGLES: [f64; 14] = [0.0, 15.0, 30.0, 45.0, 55.0, 65.0, 72.0, 78.0, 82.0, 85.0, 87.0, 88.5, 89.5, 89.9];

/// Enough for the third decimal of a smooth albedo, at a tenth of the cost of a verdict.
const SKETCH: Effort = Effort { target: 1e-3, evaluations: 12_000, replicates: 16, samples: 64, seed: 1 };

/// Polar angles of `wi` whose lobes are drawn, in degrees.
const LOBES: [f64; 4] = [0.0, 30.0, 60.0, 80.0];

/// Differences in azimuth that a cell of a map is the worst of, in degrees: retro, mirror, and between.
const AZIMUTHS: [f64; 8] = [0.0, 30.0, 60.0, 90.0, 120.0, 150.0, 180.0, 270.0];

/// Azimuths of `wo`, in degrees: an anisotropic subject differs between them.
const TURNS: [f64; 2] = [0.0, 35.0];

/// f below which no relative deviation is formed, in sr⁻¹: as the check of precision has it.
const FAINT: f64 = 1e-8;

type Pair = (Vector<f64>, Vector<f64>);

impl Figures {
    /// Samples a subject, whose parameters have the values given.
    pub fn new(subject: &dyn Subject, parameters: Vec<(String, f64)>, gpu: Option<OnGpu<'_>>) -> Self {
        let (reciprocity, validity) = maps(subject);
        Figures {
            parameters,
            albedo: Fixed::BOTH.map(|fixed| albedos(subject, fixed)).into(),
            lobes: LOBES.map(|theta| lobe(subject, theta)).into(),
            reciprocity,
            validity,
            precision: precision(subject, gpu),
            sweep: None,
        }
    }

    /// The member of a family with `values`, and how single precision fares as the parameter that is most likely a width
    /// runs over its range.
    pub fn of_family(family: &dyn Family, values: &[f64], gpu: Option<OnGpu<'_>>) -> Self {
        let parameters = family.parameters();
        let named = parameters.iter().map(|parameter| parameter.name.clone()).zip(values.iter().copied()).collect();
        let mut figures = Figures::new(&*family.subject(values), named, gpu);
        let width = |name: &str| ["rough", "alpha", "width", "gloss"].iter().any(|word| name.contains(word));
        let chosen = parameters
            .iter()
            .position(|parameter| width(&parameter.name.to_lowercase()))
            .or_else(|| parameters.iter().position(|parameter| parameter.scale != Scale::Switch));
        figures.sweep = chosen.and_then(|index| sweep(family, values, index));
        figures
    }
}

/// A number kept to five significant digits.
fn short(x: f64) -> f64 {
    if x.is_finite() { format!("{x:.4e}").parse().unwrap_or(x) } else { x }
}

/// Polar angles from the normal to grazing, `step` degrees apart.
fn angles(step: usize) -> Vec<f64> {
    (0..90).step_by(step).map(|theta| theta as f64).chain([89.9]).collect()
}

fn direction(theta: f64, phi: f64) -> Vector<f64> {
    Vector::from_angles(theta.to_radians(), phi.to_radians())
}

/// The largest of some numbers; NaN if one of them is.
fn largest(f: &[f64]) -> f64 {
    f.iter().copied().fold(f64::NEG_INFINITY, |a, b| if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b) })
}

fn albedos(subject: &dyn Subject, fixed: Fixed) -> Series {
    let points: Vec<(f64, f64)> = ALBEDO_ANGLES
        .par_iter()
        .map(|&theta| {
            let albedo = albedo(subject, theta, 0.0, fixed, &SKETCH);
            let (channel, value) = albedo.peak();
            (short(value), short(albedo.error.get(channel).copied().unwrap_or(0.0)))
        })
        .collect();
    let (y, error) = points.into_iter().unzip();
    Series { name: format!("{} fixed", fixed.name()), x: ALBEDO_ANGLES.to_vec(), y, error }
}

fn lobe(subject: &dyn Subject, theta: f64) -> Series {
    let wi = direction(theta, 180.0);
    // The horizon itself is not part of a lobe: f·cosθ is what counts there.
    let x: Vec<f64> = (-179..180).map(|half| 0.5 * f64::from(half)).collect();
    let pairs: Vec<Pair> = x.iter().map(|&signed| (wi, direction(signed, 0.0))).collect();
    let y = evaluate(subject, &pairs).chunks(subject.channels().max(1)).map(|f| short(largest(f))).collect();
    Series { name: format!("θi = {theta}°"), x, y, error: Vec::new() }
}

fn evaluate(subject: &dyn Subject, pairs: &[Pair]) -> Vec<f64> {
    let mut f = vec![0.0; pairs.len() * subject.channels().max(1)];
    if subject.channels() > 0 {
        subject.evaluate_many(pairs, &mut f);
    }
    f
}

/// The maps of reciprocity and validity.
fn maps(subject: &dyn Subject) -> (Grid, Grid) {
    let axis = angles(2);
    let channels = subject.channels().max(1);
    let rows: Vec<Vec<(f64, f64)>> = axis
        .par_iter()
        .map(|&theta_o| {
            let cell = |&theta_i: &f64| {
                TURNS.iter().flat_map(move |&turn| {
                    AZIMUTHS.iter().map(move |&phi| (direction(theta_i, turn + phi), direction(theta_o, turn)))
                })
            };
            let forth: Vec<Pair> = axis.iter().flat_map(cell).collect();
            let back: Vec<Pair> = forth.iter().map(|&(wi, wo)| (wo, wi)).collect();
            let (f, g) = (evaluate(subject, &forth), evaluate(subject, &back));
            let per_cell = TURNS.len() * AZIMUTHS.len() * channels;
            f.chunks(per_cell).zip(g.chunks(per_cell)).map(|(f, g)| (asymmetry(f, g), validity(f))).collect()
        })
        .collect();
    let grid = |pick: fn(&(f64, f64)) -> f64| Grid {
        x: axis.clone(),
        y: axis.clone(),
        values: rows.iter().flatten().map(pick).collect(),
    };
    (grid(|cell| cell.0), grid(|cell| cell.1))
}

fn asymmetry(f: &[f64], g: &[f64]) -> f64 {
    let relative = |(f, g): (&f64, &f64)| (f - g).abs() / f.abs().max(g.abs()).max(FLOOR);
    let worst = f.iter().zip(g).map(relative).filter(|d| d.is_finite()).reduce(f64::max);
    worst.map_or(f64::NAN, |worst| short(worst.log10()))
}

fn validity(f: &[f64]) -> f64 {
    if f.iter().any(|f| !f.is_finite()) {
        BROKEN
    } else if f.iter().any(|&f| f < -1e-12) {
        NEGATIVE
    } else {
        FINE
    }
}

/// Pairs that single precision is tried on at one polar angle: about the mirror direction and over the hemisphere, as f32.
fn trial(theta_o: f64) -> Vec<(Vector<f32>, Vector<f32>)> {
    let wo = direction(theta_o, 0.0);
    let about_mirror = [-10.0, -3.0, -1.0, -0.3, -0.1, 0.0, 0.1, 0.3, 1.0, 3.0, 10.0]
        .into_iter()
        .map(|offset: f64| (theta_o + offset).abs().min(89.9))
        .flat_map(|theta| [180.0, 180.5, 183.0].map(|phi| direction(theta, phi)));
    let hemisphere = [0.0, 20.0, 40.0, 60.0, 75.0, 85.0, 89.0]
        .into_iter()
        .flat_map(|theta| AZIMUTHS.map(|phi| direction(theta, phi)));
    about_mirror.chain(hemisphere).map(|wi| (wi.cast(), wo.cast())).collect()
}

/// Relative deviations from double precision, ascending; nothing if there is nothing to compare.
fn deviations(subject: &dyn Subject, pairs: &[(Vector<f32>, Vector<f32>)], g: &[f32]) -> Vec<f64> {
    let wide: Vec<Pair> = pairs.iter().map(|&(wi, wo)| (wi.cast(), wo.cast())).collect();
    let f = evaluate(subject, &wide);
    let compared = f.iter().zip(g).filter(|(f, g)| f.is_finite() && g.is_finite() && f.abs() > FAINT);
    let mut deviations: Vec<f64> = compared.map(|(&f, &g)| ((f64::from(g) - f) / f).abs()).collect();
    deviations.sort_by(f64::total_cmp);
    deviations
}

fn single(subject: &dyn Subject, pairs: &[(Vector<f32>, Vector<f32>)]) -> Option<Vec<f32>> {
    let channels = subject.channels();
    let mut g = vec![0.0f32; pairs.len() * channels];
    for (&(wi, wo), g) in pairs.iter().zip(g.chunks_mut(channels.max(1))) {
        if !subject.evaluate_single(wi, wo, g) {
            return None;
        }
    }
    Some(g)
}

fn precision(subject: &dyn Subject, gpu: Option<OnGpu<'_>>) -> Vec<Series> {
    let axis = angles(2);
    let named = |name: &str| Series { name: name.into(), ..Series::default() };
    let [mut worst, mut median, mut adapter] = ["f32, worst", "f32, median", "GPU, worst"].map(named);
    let add = |series: &mut Series, theta: f64, deviation: Option<&f64>| {
        if let Some(&deviation) = deviation {
            series.x.push(theta);
            series.y.push(short(deviation));
        }
    };
    for theta in axis {
        let pairs = trial(theta);
        if let Some(g) = single(subject, &pairs) {
            let sorted = deviations(subject, &pairs, &g);
            add(&mut worst, theta, sorted.last());
            add(&mut median, theta, sorted.get(sorted.len() / 2));
        }
        if let Some(g) = gpu.and_then(|run| run(&pairs)) {
            add(&mut adapter, theta, deviations(subject, &pairs, &g).last());
        }
    }
    [worst, median, adapter].into_iter().filter(|series| !series.x.is_empty()).collect()
}

/// Values of the parameter from its least to its largest, in the steps of its scale.
fn sweep(family: &dyn Family, values: &[f64], index: usize) -> Option<(String, Grid)> {
    const STEPS: usize = 16;
    let parameter = family.parameters().get(index)?;
    let (low, high) = (parameter.low, parameter.high);
    let logarithmic = parameter.scale == Scale::Logarithmic && low > 0.0;
    let at = |step: usize| {
        let t = step as f64 / (STEPS - 1) as f64;
        short(if logarithmic { low * (high / low).powf(t) } else { low + (high - low) * t }).clamp(low, high)
    };
    if high.partial_cmp(&low) != Some(core::cmp::Ordering::Greater) {
        return None;
    }
    let (x, y) = (angles(5), (0..STEPS).map(at).collect::<Vec<f64>>());
    let row = |&value: &f64| -> Option<Vec<f64>> {
        let mut values = values.to_vec();
        *values.get_mut(index)? = value;
        let subject = family.subject(&values);
        let cell = |&theta: &f64| {
            let pairs = trial(theta);
            let g = single(&*subject, &pairs)?;
            Some(short(deviations(&*subject, &pairs, &g).last().copied().unwrap_or(0.0).log10()))
        };
        x.iter().map(cell).collect()
    };
    let rows: Option<Vec<Vec<f64>>> = y.par_iter().map(row).collect();
    Some((parameter.name.clone(), Grid { x: x.clone(), y, values: rows?.concat() }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::from_fn;
    use core::f64::consts::FRAC_1_PI;

    #[test]
    fn figures_show_what_is_there() {
        let lambert = from_fn("Lambert", 1, |_: Vector<f64>, _: Vector<f64>, f: &mut [f64]| f[0] = FRAC_1_PI);
        let figures = Figures::new(&lambert, Vec::new(), None);
        assert!(figures.albedo.iter().all(|series| series.y.iter().all(|y| (y - 1.0).abs() < 1e-3)), "{figures:?}");
        assert!(figures.lobes.iter().all(|series| series.y.iter().all(|&y| y == short(FRAC_1_PI))));
        assert!(figures.reciprocity.values.iter().all(|&d| d == f64::NEG_INFINITY));
        assert!(figures.validity.values.iter().all(|&v| v == FINE));
        assert!(figures.precision.is_empty() && figures.sweep.is_none());
    }

    #[test]
    fn defects_lie_where_they_are() {
        let faulty = from_fn("faulty", 2, |wi: Vector<f64>, wo: Vector<f64>, f: &mut [f64]| {
            f[0] = if wi.z < 0.1 { f64::NAN } else { 1.0 };
            f[1] = if wo.z > 0.999 { -1.0 } else { wi.z };
        });
        let figures = Figures::new(&faulty, Vec::new(), None);
        let n = figures.validity.x.len();
        let at = |grid: &Grid, row: usize, column: usize| grid.values[row * n + column];
        assert_eq!(at(&figures.validity, 10, n - 1), BROKEN);
        assert_eq!(at(&figures.validity, 0, 10), NEGATIVE);
        assert_eq!(at(&figures.validity, 10, 10), FINE);
        // The second channel differs by the cosines: 40° against 20°.
        let want = (1.0 - 40f64.to_radians().cos() / 20f64.to_radians().cos()).log10();
        assert!((at(&figures.reciprocity, 10, 20) - want).abs() < 1e-4);
    }

    /// cos(θi)ⁿ, in single precision off by 1e-3·n.
    struct Powers([crate::check::Parameter; 1]);
    struct Power(f64);

    impl Family for Powers {
        fn name(&self) -> String {
            "powers".into()
        }
        fn parameters(&self) -> &[crate::check::Parameter] {
            &self.0
        }
        fn subject(&self, values: &[f64]) -> Box<dyn Subject + '_> {
            Box::new(Power(values[0]))
        }
    }

    impl Subject for Power {
        fn name(&self) -> String {
            "power".into()
        }
        fn channels(&self) -> usize {
            1
        }
        fn evaluate(&self, wi: Vector<f64>, _: Vector<f64>, f: &mut [f64]) {
            f[0] = 1.0 + wi.z;
        }
        fn evaluate_single(&self, wi: Vector<f32>, _: Vector<f32>, f: &mut [f32]) -> bool {
            f[0] = (1.0 + wi.z) * (1.0 + 1e-3 * self.0 as f32);
            true
        }
    }

    #[test]
    fn a_sweep_runs_over_the_parameter() {
        let parameter = crate::check::Parameter {
            name: "n".into(),
            low: 1.0,
            high: 100.0,
            default: 10.0,
            scale: Scale::Logarithmic,
        };
        let family = Powers([parameter]);
        let figures = Figures::of_family(&family, &[10.0], Some(&|pairs| Some(vec![2.0; pairs.len()])));
        assert_eq!(figures.precision.len(), 3);
        assert!(figures.precision[0].y.iter().all(|y| (y / 0.01 - 1.0).abs() < 1e-3), "{:?}", figures.precision[0]);
        let (name, grid) = figures.sweep.expect("a sweep");
        assert_eq!((name.as_str(), grid.y.len(), grid.values.len()), ("n", 16, 16 * grid.x.len()));
        let (first, last) = (grid.values[0], grid.values[grid.values.len() - 1]);
        assert!((first + 3.0).abs() < 1e-3 && (last + 1.0).abs() < 1e-3, "{first} {last}");
    }
}
