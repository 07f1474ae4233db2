//! `brdf check`: the judge over the built-in materials or a user's stacks.

use crate::failure::Failure;
use crate::material::{self, AnyStack, Change, Material};
use brdf::check::{self, Check, Finding, Fixed, Place, Report, StackSubject, Subject, Verdict};
use brdf::gpu::Gpu;
use brdf::layered::{Model, Widths};
use brdf::parity::{Comparison, compare_stack, stack_twin};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};
use std::io::{self, Write};
use std::process::ExitCode;

/// What `brdf check` is asked for.
#[derive(Args)]
pub(crate) struct Options {
    /// Built-in materials or stack files; without any, every built-in material.
    stacks: Vec<String>,
    /// The model to judge the stacks under, in place of their own.
    #[arg(long, value_parser = material::model)]
    model: Option<Model>,
    /// How wide covered interfaces are taken, in place of the stacks' own rule.
    #[arg(long, value_parser = material::widths)]
    widths: Option<Widths>,
    /// Seed of every random choice.
    #[arg(long, default_value_t = 1)]
    seed: u32,
    /// Evaluations per material to aim for.
    #[arg(long, default_value_t = check::Options::default().budget, value_parser = parse_budget)]
    budget: usize,
    /// Judge on the CPU alone, without the twins.
    #[arg(long)]
    no_twins: bool,
    /// The adapter that runs the twins, by words of its name or backend; without it the best.
    #[arg(long, conflicts_with = "no_twins")]
    adapter: Option<String>,
    /// Print every finding of every material.
    #[arg(long, short)]
    verbose: bool,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Pairs of directions that a twin is compared on.
const TWIN_SAMPLES: usize = 4_000;

fn parse_budget(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(budget) if (1_000..=1_000_000_000).contains(&budget) => Ok(budget),
        _ => Err("must be a whole number in [1000, 1000000000]".to_owned()),
    }
}

pub(crate) fn run(options: &Options) -> Result<ExitCode, Failure> {
    let change = Change { model: options.model, widths: options.widths };
    let materials = if options.stacks.is_empty() {
        let judged = |m: Material| Material { stack: m.stack.changed(change), ..m };
        material::built_in().into_iter().map(judged).collect()
    } else {
        // Every file is read before the first is judged: bad input stops the command early.
        let load = |name: &String| material::load(name, change);
        options.stacks.iter().map(load).collect::<Result<Vec<_>, _>>()?
    };
    if let Some(noisy) = materials.iter().find(|material| material.stack.model() == Model::Walk) {
        let problem = "the walk's f is a mean of random numbers, whose noise would be judged in place of the stack";
        return Err(format!("{}: {problem}; use --model coupled, or `brdf bench layered`", noisy.name).into());
    }
    let (gpu, twins) = twins(options)?;

    let progress = ProgressBar::new(0);
    let style = ProgressStyle::with_template("{bar:30} {percent}% {msg}").unwrap_or(ProgressStyle::default_bar());
    progress.set_style(style);
    let mut reports = Vec::new();
    for (index, material) in materials.iter().enumerate() {
        progress.set_message(format!("{} ({} of {})", material.name, index + 1, materials.len()));
        let mut report = match &material.stack {
            AnyStack::One(stack) => judge(&StackSubject::new(&material.name, stack.clone()), options, &progress),
            AnyStack::Three(stack) => judge(&StackSubject::new(&material.name, stack.clone()), options, &progress),
        };
        let has_twin = stack_twin(material.stack.model()).is_some();
        if let Some(gpu) = gpu.as_ref().filter(|_| has_twin) {
            let comparison = compare_stack(gpu, &material.stack.three_single(), TWIN_SAMPLES)?;
            report.findings.push(twin_finding(&comparison, gpu));
        }
        reports.push(report);
    }
    progress.finish_and_clear();

    let verdict = reports.iter().map(Report::verdict).max().unwrap_or(Verdict::Inconclusive);
    let mut out = io::stdout().lock();
    if options.json {
        let models: Vec<_> = materials.iter().map(|material| material.stack.model().name()).collect();
        writeln!(out, "{:#}", as_json(&reports, &models, verdict, &twins))?;
    } else {
        for (report, material) in reports.iter().zip(&materials) {
            print(&mut out, report, material.stack.model(), options.verbose)?;
        }
        let count = |wanted| reports.iter().filter(|report| report.verdict() == wanted).count();
        let (failed, open) = (count(Verdict::Fail), count(Verdict::Inconclusive));
        writeln!(out, "twins: {twins}")?;
        writeln!(out, "{}: {} judged, {failed} violate, {open} inconclusive", verdict.name(), reports.len())?;
    }
    Ok(ExitCode::from(verdict.exit_code()))
}

/// The adapter that runs the twins, and a line about it.
fn twins(options: &Options) -> Result<(Option<Gpu>, String), Failure> {
    if options.no_twins {
        return Ok((None, "not run (--no-twins)".to_owned()));
    }
    match Gpu::open(options.adapter.as_deref()) {
        Ok(gpu) => {
            let about = gpu.info().to_string();
            Ok((Some(gpu), about))
        }
        Err(error) if options.adapter.is_some() => Err(error.into()),
        Err(error) => Ok((None, format!("not run: {error}"))),
    }
}

fn judge(subject: &dyn Subject, options: &Options, progress: &ProgressBar) -> Report {
    let follow = |done: usize, total: usize| {
        progress.set_length(total as u64);
        progress.set_position(done as u64);
    };
    let options = check::Options {
        seed: options.seed,
        budget: options.budget,
        progress: Some(&follow),
        ..check::Options::default()
    };
    check::check(subject, &options)
}

/// A comparison of twins as a finding.
fn twin_finding(comparison: &Comparison, gpu: &Gpu) -> Finding {
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

/// One line for a plausible material; every finding for any other.
fn print(out: &mut impl Write, report: &Report, model: Model, verbose: bool) -> io::Result<()> {
    if verbose || report.verdict() != Verdict::Pass {
        return writeln!(out, "{report}");
    }
    let albedo = |fixed| {
        report.energy(fixed).map_or("not judged".to_owned(), |finding| {
            let theta = if let Place::Marginal { theta, .. } = finding.place { theta } else { 0.0 };
            format!("{:.4} at {theta}°", finding.value)
        })
    };
    writeln!(
        out,
        "{:12} {:28} {:12} albedo ≤ {} [view], {} [light]",
        report.verdict().name(),
        report.subject,
        model.name(),
        albedo(Fixed::View),
        albedo(Fixed::Light)
    )
}

fn as_json(reports: &[Report], models: &[&str], verdict: Verdict, twins: &str) -> Value {
    let reports = reports.iter().zip(models).map(|(report, model)| {
        let coverage = &report.coverage;
        json!({
            "subject": report.subject,
            "model": model,
            "verdict": report.verdict().name(),
            "findings": report.findings.iter().map(finding_json).collect::<Vec<_>>(),
            "albedos": report.albedos.iter().map(|albedo| json!({
                "theta": albedo.theta, "phi": albedo.phi, "fixed": albedo.fixed.name(),
                "value": albedo.value, "error": albedo.error,
            })).collect::<Vec<_>>(),
            "coverage": {
                "seed": coverage.seed, "budget": coverage.budget, "evaluations": coverage.evaluations,
                "integrals": coverage.integrals, "pairs": coverage.pairs, "restarts": coverage.restarts,
                "anisotropic": coverage.anisotropic,
            },
        })
    });
    json!({"version": 1, "verdict": verdict.name(), "twins": twins, "reports": reports.collect::<Vec<_>>()})
}

fn finding_json(finding: &Finding) -> Value {
    let place = match finding.place {
        Place::Everywhere => Value::Null,
        Place::Marginal { theta, phi, fixed } => json!({"theta": theta, "phi": phi, "fixed": fixed.name()}),
        Place::Pair { wi, wo } => json!({"wi": [wi.x, wi.y, wi.z], "wo": [wo.x, wo.y, wo.z]}),
    };
    json!({
        "check": finding.check.name(),
        "precision": if finding.single { "f32" } else { "f64" },
        "verdict": finding.verdict.name(),
        "binding": finding.binding,
        "value": finding.value, "error": finding.error, "limit": finding.limit,
        "place": place,
        "channel": finding.channel.as_ref().map(|(_, name)| name),
        "note": finding.note,
        "line": finding.to_string(),
    })
}
