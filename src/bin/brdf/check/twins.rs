//! The adapter that runs twins, and what it says of a stack.

use super::subjects::Loaded;
use crate::failure::Failure;
use brdf::check::{Check, Finding, Place, Verdict};
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
