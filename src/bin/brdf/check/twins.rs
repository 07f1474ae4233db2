//! The adapter that runs twins, and what it says of a stack.

use super::subjects::Loaded;
use crate::failure::Failure;
use brdf::Vector;
use brdf::check::pairs::Class;
use brdf::check::{Check, Finding, Place, Report, Verdict};
use brdf::gpu::Gpu;
use brdf::parity::{Comparison, compare_stack, stack_twin};

/// Pairs of directions that a twin is compared on.
const SAMPLES: usize = 4_000;

/// An adapter, if there is one.
pub(super) struct Twins {
    pub(super) gpu: Option<Gpu>,
    /// A line about it, or about why there is none.
    pub(super) about: String,
}

impl Twins {
    /// The adapter that was asked for, else the best, else none.
    pub(super) fn open(off: bool, adapter: Option<&str>) -> Result<Self, Failure> {
        if off {
            return Ok(Twins { gpu: None, about: "not run (--no-twins)".to_owned() });
        }
        match Gpu::open(adapter) {
            Ok(gpu) => {
                let about = gpu.info().to_string();
                Ok(Twins { gpu: Some(gpu), about })
            }
            Err(error) if adapter.is_some() => Err(error.into()),
            Err(error) => Ok(Twins { gpu: None, about: format!("not run: {error}") }),
        }
    }

    /// The comparison of a stack with its twin, where it has one.
    pub(super) fn finding(&self, loaded: &Loaded) -> Result<Option<Finding>, Failure> {
        let (Some(gpu), Some(stack)) = (&self.gpu, &loaded.stack) else { return Ok(None) };
        if stack_twin(stack.model()).is_none() {
            return Ok(None);
        }
        Ok(Some(finding(&compare_stack(gpu, &stack.three_single(), SAMPLES)?, gpu)))
    }
}

/// Pairs of directions of each class that a GPU is tried on.
const PAIRS: usize = 512;

/// f below which no relative deviation is formed, in sr⁻¹, and the cosine below which no pair is taken: as the check of f32
/// has them.
const FAINT: f64 = 1e-8;
const GRAZING: f64 = 1.745e-3;

impl Twins {
    /// f on the GPU at the pairs of findings, and how far it is off f64 for the member with these values.
    pub(super) fn add(&self, loaded: &Loaded, report: &mut Report, values: &[f64], seed: u32) {
        for finding in &mut report.findings {
            if let (Place::Pair { wi, wo }, Some(known)) = (finding.place, &mut finding.values) {
                let values = loaded.judged.values(&finding.parameters);
                known.gpu = loaded
                    .on_gpu(&values, self, &[(wi.cast(), wo.cast())])
                    .and_then(Result::ok)
                    .map(|f| f.into_iter().map(f64::from).collect())
                    .unwrap_or_default();
            }
        }
        match self.deviation(loaded, values, seed).transpose() {
            Ok(finding) => report.findings.extend(finding),
            Err(reason) => report.notes.push(left_out(&reason)),
        }
    }

    fn deviation(&self, loaded: &Loaded, values: &[f64], seed: u32) -> Option<Result<Finding, String>> {
        let narrow: Vec<(Vector<f32>, Vector<f32>)> = Class::ALL
            .iter()
            .flat_map(|class| (0..PAIRS).map(|i| class.pair(i, seed)))
            .filter(|(wi, wo)| wi.z.min(wo.z) > GRAZING)
            .map(|(wi, wo)| (wi.cast(), wo.cast()))
            .collect();
        let got = match loaded.on_gpu(values, self, &narrow)? {
            Ok(got) => got,
            Err(reason) => return Some(Err(reason)),
        };
        let wide: Vec<(Vector<f64>, Vector<f64>)> = narrow.iter().map(|(wi, wo)| (wi.cast(), wo.cast())).collect();
        let (channels, want) = loaded.judged.member(values, |subject| {
            let mut f = vec![0.0; wide.len() * subject.channels()];
            subject.evaluate_many(&wide, &mut f);
            (subject.channels().max(1), f)
        });
        let mut deviations = Vec::new();
        let mut worst: Option<(f64, usize)> = None;
        let mut broken = 0;
        for (index, (&want, &got)) in want.iter().zip(&got).enumerate() {
            broken += usize::from(want.is_finite() && !got.is_finite());
            if want.is_finite() && got.is_finite() && want.abs() > FAINT {
                let deviation = ((f64::from(got) - want) / want).abs();
                deviations.push(deviation);
                if worst.is_none_or(|(most, _)| deviation > most) {
                    worst = Some((deviation, index));
                }
            }
        }
        deviations.sort_by(f64::total_cmp);
        let (value, index) = worst?;
        let &(wi, wo) = wide.get(index / channels)?;
        let median = deviations.get(deviations.len() / 2).copied().unwrap_or(0.0);
        let lost = if broken > 0 { format!(", {broken} not finite where f64 is") } else { String::new() };
        let name = loaded.judged.member(values, |subject| subject.channel_name(index % channels));
        Some(Ok(Finding {
            single: true,
            verdict: Verdict::Pass,
            binding: false,
            value,
            limit: f64::INFINITY,
            place: Place::Pair { wi, wo },
            channel: Some((index % channels, name)),
            parameters: loaded.judged.named(values),
            note: format!("worst relative deviation from f64, median {median:.1e}{lost}"),
            ..Finding::new(Check::Gpu)
        }))
    }
}

/// The line of a report that says why it has none of an adapter.
pub(super) fn left_out(reason: &str) -> String {
    // wgpu speaks in several lines.
    let line = reason.lines().map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join(", ");
    format!("the adapter is left out: {line}")
}

fn finding(comparison: &Comparison, gpu: &Gpu) -> Finding {
    let worst = comparison.worst.as_ref();
    let input = |direction: &str| {
        let inputs = worst.map_or(&[][..], |worst| &worst.inputs);
        let [x, y, z] = ["x", "y", "z"].map(|axis| {
            let found = inputs.iter().find(|(name, _)| *name == format!("{direction}.{axis}"));
            found.map_or(0.0, |(_, value)| *value)
        });
        brdf::Vector::new(x, y, z)
    };
    let note = match worst {
        Some(worst) if !comparison.agrees() => format!(
            "{} results outside what WGSL allows on {}; {} is {:e}, want {:e}",
            comparison.outside,
            gpu.info(),
            worst.output,
            worst.got,
            worst.want
        ),
        _ => format!("99.9 % within {:.1e} relative", comparison.p999_relative),
    };
    Finding {
        single: true,
        verdict: if comparison.agrees() { Verdict::Pass } else { Verdict::Fail },
        value: comparison.share,
        limit: 1.0,
        place: if comparison.agrees() { Place::Everywhere } else { Place::Pair { wi: input("wi"), wo: input("wo") } },
        note,
        ..Finding::new(Check::Twin)
    }
}
