//! `brdf merge`: the reports of shards, put together.

use crate::check::{Files, read_run, terminal};
use crate::failure::Failure;
use crate::output::Verdicts;
use brdf::check::output::Run;
use clap::Args;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// What `brdf merge` is asked for.
#[derive(Args)]
pub(crate) struct Options {
    /// The JSON of every shard, in any order.
    #[arg(required = true)]
    reports: Vec<PathBuf>,
    /// A JSON report whose findings are known: they are accepted, new and worse ones are not.
    #[arg(long, value_name = "FILE")]
    baseline: Option<PathBuf>,
    /// Print every finding of every subject.
    #[arg(long, short)]
    verbose: bool,
    /// Print JSON: the same bytes as an undivided run's.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    files: Files,
}

pub(crate) fn run(options: &Options) -> Result<ExitCode, Failure> {
    let files = options.files.open()?;
    let parts = options.reports.iter().map(|path| read_run(path)).collect::<Result<Vec<_>, _>>()?;
    let mut run = Run::merge(parts).map_err(|error| error.to_string())?;
    let baseline = options.baseline.as_deref().map(read_run).transpose()?;
    let acceptance = baseline.map(|baseline| run.accept(&baseline));
    files.write(&run)?;
    let mut out = Verdicts::new();
    if options.json {
        out.write_all(run.to_json().as_bytes())?;
    } else {
        terminal::print(&mut out, &run, options.verbose, acceptance.as_ref())?;
    }
    Ok(ExitCode::from(run.exit_code()))
}
