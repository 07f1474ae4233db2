//! One subject, sampled for pictures.

use super::subjects::Reading;
use super::twins::Twins;
use crate::failure::Failure;
use brdf::check::output::Figures;
use clap::Args;

/// The subject of a picture.
#[derive(Args)]
pub(crate) struct Portrait {
    #[command(flatten)]
    reading: Reading,
    /// Sample on the CPU alone.
    #[arg(long)]
    no_twins: bool,
    /// The adapter that shaders run on as well, by words of its name or backend; without it the best.
    #[arg(long, conflicts_with = "no_twins")]
    adapter: Option<String>,
}

impl Portrait {
    /// The subject's name and what its pictures are drawn from; parameters that are not set have their defaults.
    pub(crate) fn sample(&self) -> Result<(String, Figures), Failure> {
        let sources = self.reading.sources()?;
        let [source] = &sources[..] else {
            return Err(format!("a picture is of one subject, and {} are given", sources.len()).into());
        };
        let loaded = self.reading.load(source).map_err(|refusal| refusal.reason)?;
        let values = loaded.judged.values(&[]);
        let twins = Twins::open(self.no_twins, self.adapter.as_deref())?;
        let figures = loaded.figures(&values, &twins);
        match loaded.fault() {
            Some(fault) => Err(fault.into()),
            None => Ok((loaded.judged.member(&values, |subject| subject.name()), figures)),
        }
    }
}
