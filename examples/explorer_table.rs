//! Judges every BRDF Explorer file of a folder, at its defaults and over its sliders, and prints a Markdown table:
//! `cargo run --release --features check,shader --example explorer_table DIR [BUDGET]`. Times go to standard error.

use brdf::check::sniff::{Kind, sniff};
use brdf::check::{self, Check, Explorer, Family, Finding, Fixed, Options, Profile, Report, Verdict};
use std::error::Error;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().ok_or("usage: explorer_table DIR [BUDGET]")?;
    let budget = arguments.next().map_or(Ok(Options::default().budget), |budget| budget.parse())?;
    let entries = std::fs::read_dir(folder)?.collect::<Result<Vec<_>, _>>()?;
    let mut paths: Vec<_> = entries.iter().map(|entry| entry.path()).filter(|path| path.is_file()).collect();
    paths.sort();
    println!("| file | defaults | profile | at the defaults | worst energy | reciprocity | else | over the sliders |");
    println!("|---|---|---|---|---|---|---|---|");
    for path in paths {
        let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let bytes = std::fs::read(&path)?;
        let file = match sniff(&bytes) {
            Ok(Kind::Explorer) => Explorer::parse(&name, &String::from_utf8_lossy(&bytes)).map_err(|e| e.to_string()),
            Ok(other) => Err(format!("this is a {}", other.name())),
            Err(refused) => Err(refused.to_string()),
        };
        match file {
            Ok(file) => println!("{}", row(&name, &file, budget)),
            Err(reason) => println!("| {name} | | | refused: {reason} | | | | |"),
        }
    }
    Ok(())
}

fn row(name: &str, file: &Explorer, budget: usize) -> String {
    let options = Options { budget, profile: file.profile(), ..Options::default() };
    let defaults: Vec<f64> = file.parameters().iter().map(|parameter| parameter.default).collect();
    let start = Instant::now();
    let at_defaults = check::check(&*file.subject(&defaults), &options);
    let middle = Instant::now();
    let searched = check::check_family(file, &options);
    eprintln!(
        "{name}: {:.1} s and {} evaluations at the defaults, {:.1} s and {} in all{}",
        (middle - start).as_secs_f64(),
        at_defaults.coverage.evaluations,
        middle.elapsed().as_secs_f64(),
        searched.coverage.evaluations,
        file.error().map_or_else(String::new, |error| format!("; {error}")),
    );
    let values: Vec<(String, f64)> =
        file.parameters().iter().map(|parameter| (parameter.name.clone(), parameter.default)).collect();
    let reciprocity = at_defaults.finding(Check::Reciprocity).map_or_else(String::new, brief);
    let cells = [
        name.to_owned(),
        listed(&values),
        if file.profile() == Profile::Term { "term" } else { "strict" }.to_owned(),
        at_defaults.verdict().to_string(),
        worst_energy(&at_defaults).map_or_else(String::new, brief),
        reciprocity,
        violations(&at_defaults, |check| !matches!(check, Check::Energy | Check::Reciprocity)),
        match searched.verdict() {
            Verdict::Pass => "PASS".to_owned(),
            verdict => format!("{verdict}: {}", violations(&searched, |_| true)),
        },
    ];
    format!("| {} |", cells.join(" | "))
}

fn worst_energy(report: &Report) -> Option<&Finding> {
    let energies = Fixed::BOTH.iter().filter_map(|&fixed| report.energy(fixed));
    energies.reduce(|a, b| if (b.verdict, b.value) > (a.verdict, a.value) { b } else { a })
}

/// The findings that bind and are no pass.
fn violations(report: &Report, of: impl Fn(Check) -> bool) -> String {
    let bad = report.findings.iter().filter(|f| f.binding && f.verdict != Verdict::Pass && of(f.check));
    bad.map(|finding| format!("{} {}", finding.check.name(), brief(finding))).collect::<Vec<_>>().join("; ")
}

/// A finding without its check and note, with what its parameters are.
fn brief(finding: &Finding) -> String {
    let (note, parameters) = (String::new(), Vec::new());
    let line = Finding { note, parameters, ..finding.clone() }.to_string();
    let line = line.strip_prefix(finding.check.name()).unwrap_or(&line).trim_start();
    if finding.parameters.is_empty() { line.to_owned() } else { format!("{line}, {}", listed(&finding.parameters)) }
}

fn listed(values: &[(String, f64)]) -> String {
    values.iter().map(|(name, value)| format!("{name} {value}")).collect::<Vec<_>>().join(", ")
}
