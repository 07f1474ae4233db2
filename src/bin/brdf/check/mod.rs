//! `brdf check`: the judge over stacks, materials, and what else can be read.

mod again;
mod pinned;
mod place;
pub(crate) mod portrait;
mod prove;
mod shaders;
pub(crate) mod subjects;
pub(crate) mod terminal;
mod twins;

use crate::failure::Failure;
use crate::output::{Destination, Verdicts, complain};
use brdf::check::output::{Entry, Outcome, Run, Shard};
use brdf::check::{self, Finding, Report, Verdict};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use subjects::{Loaded, Reading, Refusal, Source};
use twins::Twins;

/// What `brdf check` is asked for.
#[derive(Args)]
pub(crate) struct Options {
    #[command(flatten)]
    reading: Reading,
    /// Which findings count: strict (all), realtime (reciprocity and the light's energy advise), measured, term (finite and
    /// not negative alone).
    #[arg(long, value_parser = profile)]
    profile: Option<check::Profile>,
    /// What an albedo may exceed 1 by.
    #[arg(long, default_value_t = check::TOLERANCE, value_parser = tolerance)]
    tolerance: f64,
    /// Check too that the subject is a distribution of normals, a function of the light that stands for the normal.
    #[arg(long)]
    distribution: bool,
    /// Seed of every random choice.
    #[arg(long, default_value_t = 1)]
    seed: u32,
    /// Evaluations per subject to aim for.
    #[arg(long, default_value_t = check::Options::default().budget, value_parser = parse_budget)]
    budget: usize,
    /// Judge part K of N of the subjects, whose JSON `brdf merge` puts together.
    #[arg(long, value_name = "K/N", value_parser = shard)]
    shard: Option<Shard>,
    /// A JSON report whose findings are known: they are accepted, new and worse ones are not.
    #[arg(long, value_name = "FILE")]
    baseline: Option<PathBuf>,
    /// See one place again: `theta=80,phi=0,light` integrates the albedo, `wi=X:Y:Z,wo=X:Y:Z` evaluates f; parameters follow as
    /// `,NAME=VALUE`.
    #[arg(long, value_parser = place::At::parse, conflicts_with_all = ["shard", "baseline", "json", "junit", "html"])]
    at: Option<place::At>,
    #[command(flatten)]
    prove: prove::Prove,
    /// Judge on the CPU alone.
    #[arg(long)]
    no_twins: bool,
    /// The adapter that runs twins and shaders, by words of its name or backend; without it the best.
    #[arg(long, conflicts_with = "no_twins")]
    adapter: Option<String>,
    /// Print every finding of every subject.
    #[arg(long, short)]
    verbose: bool,
    /// Print JSON (docs/report.md).
    #[arg(long)]
    json: bool,
    /// Put the samples that pictures are drawn from into the JSON, for the page that `brdf merge --html` writes.
    #[arg(long, requires = "json")]
    figures: bool,
    #[command(flatten)]
    files: Files,
}

impl Options {
    /// How a subject is judged.
    fn settings(&self, loaded: &Loaded) -> check::Options<'static> {
        check::Options {
            seed: self.seed,
            budget: self.budget,
            profile: self.profile.or(loaded.profile).unwrap_or_default(),
            tolerance: self.tolerance,
            distribution: self.distribution,
            ..check::Options::default()
        }
    }
}

/// The files that a report is written to.
#[derive(Args)]
pub(crate) struct Files {
    /// Write JUnit XML here.
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Write an HTML page with pictures here.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
}

impl Files {
    /// Tries whether they can be written, before anything is judged.
    pub(crate) fn open(&self) -> Result<Reports, Failure> {
        if self.junit.is_some() && self.junit == self.html {
            return Err("--junit and --html name one file: give two".to_owned().into());
        }
        let tried = |path: &Option<PathBuf>| path.as_deref().map(Destination::new).transpose();
        Ok(Reports { junit: tried(&self.junit)?, html: tried(&self.html)? })
    }
}

/// [`Files`] that can be written.
pub(crate) struct Reports {
    junit: Option<Destination>,
    html: Option<Destination>,
}

impl Reports {
    /// Writes what was asked for: all of it or nothing.
    pub(crate) fn write(&self, run: &Run) -> Result<(), Failure> {
        let junit = self.junit.iter().map(|file| (file, run.to_junit()));
        let html = self.html.iter().map(|file| (file, run.to_html()));
        Destination::write_all(&junit.chain(html).collect::<Vec<_>>())
    }
}

/// Reads a JSON report.
pub(crate) fn read_run(path: &Path) -> Result<Run, Failure> {
    let at = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let text = std::fs::read_to_string(path).map_err(|error| at(&error))?;
    Ok(Run::from_json(&text).map_err(|error| at(&error))?)
}

fn parse_budget(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(budget) if (1_000..=1_000_000_000).contains(&budget) => Ok(budget),
        _ => Err("must be a whole number in [1000, 1000000000]".to_owned()),
    }
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(tolerance) if (0.0..=1.0).contains(&tolerance) => Ok(tolerance),
        _ => Err("must be a number in [0, 1]".to_owned()),
    }
}

fn profile(name: &str) -> Result<check::Profile, String> {
    let found = check::Profile::ALL.into_iter().find(|profile| profile.name() == name);
    found.ok_or_else(|| {
        format!("`{name}` is no profile; there are {}", check::Profile::ALL.map(check::Profile::name).join(", "))
    })
}

fn shard(text: &str) -> Result<Shard, String> {
    Shard::parse(text).map_err(|error| error.to_string())
}

pub(crate) fn run(options: &Options) -> Result<ExitCode, Failure> {
    let sources = options.reading.sources()?;
    if options.prove.prove {
        return prove::run(&options.prove, &options.reading, &sources);
    }
    let baseline = options.baseline.as_deref().map(read_run).transpose()?;
    let reports = options.files.open()?;
    let twins = Twins::open(options.no_twins, options.adapter.as_deref())?;
    if let Some(at) = &options.at {
        return see(options, &sources, at, &twins);
    }
    let total = sources.len();
    let mut run = Run { total, shard: options.shard, twins: twins.about.clone(), ..Run::new() };
    let held = |index: &usize| options.shard.is_none_or(|shard| shard.holds(*index));
    let progress = ProgressBar::new(0);
    let style = ProgressStyle::with_template("{bar:30} {percent}% {msg}").unwrap_or(ProgressStyle::default_bar());
    progress.set_style(style);
    for (index, source) in sources.iter().enumerate().filter(|(index, _)| held(index)) {
        progress.set_message(format!("{} ({} of {total})", source.name(), index + 1));
        let entry = match options.reading.load(source) {
            Ok(loaded) => match judge(options, source, &loaded, &twins, &progress)? {
                Ok(outcome) => Entry { index, source: source.name().to_owned(), kind: loaded.kind, outcome },
                Err(reason) => Entry::refused(index, source.name(), loaded.kind, reason),
            },
            Err(Refusal { reason, passed_over }) => {
                let outcome = Outcome::Refused { reason, accepted: passed_over };
                Entry { index, source: source.name().to_owned(), kind: String::new(), outcome }
            }
        };
        run.entries.push(entry);
    }
    progress.finish_and_clear();

    let acceptance = baseline.map(|baseline| run.accept(&baseline));
    reports.write(&run)?;
    let mut out = Verdicts::new();
    if options.json {
        out.write_all(run.to_json().as_bytes())?;
    } else {
        terminal::print(&mut out, &run, options.verbose, acceptance.as_ref())?;
    }
    out.flush()?;
    // A terminal shows both outputs, and the table has said it there.
    if options.json || !io::stdout().is_terminal() {
        for (_, reason) in run.refused() {
            complain(&reason);
        }
    }
    Ok(ExitCode::from(run.exit_code()))
}

/// The report of one subject, or why it could not be evaluated.
fn judge(
    options: &Options,
    source: &Source,
    loaded: &Loaded,
    twins: &Twins,
    progress: &ProgressBar,
) -> Result<Result<Outcome, String>, Failure> {
    let follow = |done: usize, total: usize| {
        progress.set_length(total as u64);
        progress.set_position(done as u64);
    };
    let settings = check::Options { progress: Some(&follow), ..options.settings(loaded) };
    let mut report = loaded.judged.check(&settings);
    if let Some(fault) = loaded.fault() {
        return Ok(Err(fault));
    }
    report.findings.extend(twins.finding(loaded)?);
    let values = worst_member(loaded, &report);
    twins.add(loaded, &mut report, &values, options.seed);
    report.notes.extend(loaded.notes.iter().cloned());
    for finding in &mut report.findings {
        finding.again = again::command(options, source, finding);
    }
    let drawn = options.figures || options.files.html.is_some();
    let figures = drawn.then(|| Box::new(loaded.figures(&values, twins)));
    Ok(Ok(Outcome::Judged { report: Box::new(report), figures }))
}

/// The parameters of the member that the worst finding is about.
fn worst_member(loaded: &Loaded, report: &Report) -> Vec<f64> {
    let rank = |finding: &&Finding| (finding.binding, finding.verdict, !finding.parameters.is_empty());
    // Of equals the first: energy is what the first picture shows.
    let worst = report.findings.iter().rev().filter(|finding| finding.verdict != Verdict::Pass).max_by_key(rank);
    loaded.judged.values(worst.map_or(&[][..], |finding| &finding.parameters))
}

/// Evaluates the one place of `--at`.
fn see(options: &Options, sources: &[Source], at: &place::At, twins: &Twins) -> Result<ExitCode, Failure> {
    let [source] = sources else {
        return Err(format!("--at is about one subject, and {} are given", sources.len()).into());
    };
    let loaded = options.reading.load(source).map_err(|refusal| refusal.reason)?;
    let values = loaded.judged.values(&at.parameters);
    loaded.judged.knows(&at.parameters)?;
    let verdict = place::print(&mut Verdicts::new(), &loaded, &values, at, &options.settings(&loaded), twins)?;
    if let Some(fault) = loaded.fault() {
        return Err(fault.into());
    }
    Ok(ExitCode::from(verdict.exit_code()))
}
