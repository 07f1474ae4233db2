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
        violations(&at_defaults, file, |check| !matches!(check, Check::Energy | Check::Reciprocity)),
        match searched.verdict() {
            Verdict::Pass => "PASS".to_owned(),
            verdict => format!("{verdict}: {}", violations(&searched, file, |_| true)),
        },
    ];
    format!("| {} |", cells.join(" | "))
}

fn worst_energy(report: &Report) -> Option<&Finding> {
    let energies = Fixed::BOTH.iter().filter_map(|&fixed| report.energy(fixed));
    energies.reduce(|a, b| if (b.verdict, b.value) > (a.verdict, a.value) { b } else { a })
}

/// The worst of each check that binds and is no pass; in f32 where f64 has nothing to say.
fn violations(report: &Report, file: &Explorer, of: impl Fn(Check) -> bool) -> String {
    let bad = || report.findings.iter().filter(|f| f.binding && f.verdict != Verdict::Pass && of(f.check));
    let key = |f: &Finding| (!f.single, f.verdict, if f.check == Check::Sign { -f.value } else { f.value });
    let worst = bad().filter(|finding| {
        let first = bad().filter(|f| f.check == finding.check).reduce(|a, b| if key(b) > key(a) { b } else { a });
        first.is_some_and(|first| std::ptr::eq(first, *finding))
    });
    let line = |finding: &Finding| {
        let changed: Vec<(String, f64)> = finding
            .parameters
            .iter()
            .zip(file.parameters())
            .filter(|((_, value), parameter)| *value != parameter.default)
            .map(|(changed, _)| changed.clone())
            .collect();
        let with = if changed.is_empty() { String::new() } else { format!(" with {}", listed(&changed)) };
        format!("{} {}{with}", finding.check.name(), brief(finding))
    };
    worst.map(line).collect::<Vec<_>>().join("; ")
}

/// A finding without its check, its note and its parameters.
fn brief(finding: &Finding) -> String {
    let (note, parameters) = (String::new(), Vec::new());
    let line = Finding { note, parameters, ..finding.clone() }.to_string();
    let line = line.strip_prefix(finding.check.name()).unwrap_or(&line).trim_start();
    if finding.value < 1e6 {
        return line.to_owned();
    }
    // Of that many digits nobody reads one.
    let place = line.split_once(" at ").map_or("", |(_, place)| place);
    format!("{} {:.1e} at {place}", finding.verdict, finding.value)
}

fn listed(values: &[(String, f64)]) -> String {
    let one = |(name, value): &(String, f64)| format!("{name} {}", (value * 1e6).round() / 1e6);
    values.iter().map(one).collect::<Vec<_>>().join(", ")
}
