//! `brdf check --prove`: finite and not negative, by interval arithmetic.

use super::subjects::{Reading, Source};
use crate::failure::Failure;
use crate::output::Verdicts;
use brdf::check::Verdict;
use brdf::check::prove::{Directions, Options};
use clap::Args;
use std::io::Write;
use std::process::ExitCode;

/// What is to be proved, and where.
#[derive(Args)]
pub(super) struct Prove {
    /// Prove shader functions not negative and finite over the ranges of their parameters, or disprove it by a point
    /// (docs/report.md).
    #[arg(long, conflicts_with_all = ["at", "json", "junit", "html", "baseline", "shard"])]
    pub(super) prove: bool,
    /// The least cosine of either direction with the normal that --prove is about.
    #[arg(long, requires = "prove", value_name = "COSINE", default_value_t = Directions::default().least_cosine, value_parser = cosine)]
    least_cosine: f64,
    /// Prove it for views of azimuth 0 alone: for every view, if the BRDF is isotropic.
    #[arg(long, requires = "prove")]
    isotropic: bool,
    /// The boxes that --prove may bound.
    #[arg(long, requires = "prove", value_name = "N", default_value_t = Options::default().boxes)]
    boxes: usize,
}

fn cosine(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(cosine) if cosine > 0.0 && cosine <= 1.0 => Ok(cosine),
        _ => Err("must be a number in (0, 1]".to_owned()),
    }
}

/// Proves every subject, and prints the answers.
pub(super) fn run(asked: &Prove, reading: &Reading, sources: &[Source]) -> Result<ExitCode, Failure> {
    let directions = Directions { least_cosine: asked.least_cosine, isotropic: asked.isotropic };
    let options = Options { directions, boxes: asked.boxes };
    let mut out = Verdicts::new();
    let mut verdict = Verdict::Pass;
    for source in sources {
        let loaded = reading.load(source).map_err(|refusal| refusal.reason)?;
        let Some(prove) = &loaded.prove else {
            let (name, kind) = (source.name(), &loaded.kind);
            return Err(
                format!("{name}: --prove is about functions of WGSL and GLSL files (--fn), this is {kind}").into()
            );
        };
        let proof = prove(&options)?;
        for note in &loaded.notes {
            writeln!(out, "note: {note}")?;
        }
        writeln!(out, "{proof}")?;
        verdict = verdict.max(proof.verdict());
    }
    Ok(ExitCode::from(verdict.exit_code()))
}
