//! Judges every BRDF Explorer file of a folder and prints a Markdown table: `explorer_table DIR [BUDGET]`.

use brdf::check::{self, Check, Explorer, Family, Finding, Fixed, Options, Profile, Verdict};
use std::error::Error;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().ok_or("usage: explorer_table DIR [BUDGET]")?;
    let budget = arguments.next().map_or(Ok(Options::default().budget), |budget| budget.parse())?;
    let mut paths: Vec<_> =
        std::fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path())).collect::<Result<_, _>>()?;
    paths.sort();
    println!("| file | default parameters | profile | verdict | worst energy | reciprocity | other findings |");
    println!("|---|---|---|---|---|---|---|");
    for path in paths {
        let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let text = String::from_utf8_lossy(&std::fs::read(&path)?).into_owned();
        let file = match Explorer::parse(&name, &text) {
            Ok(file) => file,
            Err(error) => {
                println!("| {name} | | | refused | {error} | | |");
                continue;
            }
        };
        let start = Instant::now();
        let report = check::check_family(&file, &Options { budget, profile: file.profile(), ..Options::default() });
        let parameters: Vec<String> =
            file.parameters().iter().map(|parameter| format!("{} {}", parameter.name, parameter.default)).collect();
        let worst = Fixed::BOTH
            .iter()
            .filter_map(|&fixed| report.energy(fixed))
            .max_by(|a, b| a.verdict.cmp(&b.verdict).then(a.value.total_cmp(&b.value)));
        let line = |finding: Option<&Finding>| {
            finding.map_or_else(String::new, |finding| {
                let line = finding.to_string();
                line.split_once(' ').map_or(line.clone(), |(_, rest)| rest.to_owned())
            })
        };
        let rest: Vec<String> = report
            .findings
            .iter()
            .filter(|finding| !matches!(finding.check, Check::Energy | Check::Reciprocity))
            .filter(|finding| finding.binding && finding.verdict != Verdict::Pass)
            .map(Finding::to_string)
            .collect();
        let profile = if file.profile() == Profile::Term { "term" } else { "strict" };
        println!(
            "| {name} | {} | {profile} | {} | {} | {} | {} |",
            parameters.join(", "),
            report.verdict(),
            line(worst),
            line(report.finding(Check::Reciprocity)),
            if rest.is_empty() { "none".to_owned() } else { rest.join("; ") },
        );
        eprintln!("{name}: {:.1} s, {} evaluations", start.elapsed().as_secs_f64(), report.coverage.evaluations);
        if let Some(error) = file.error() {
            eprintln!("{name}: {error}");
        }
    }
    Ok(())
}
