//! Reports as one HTML page that needs neither network nor scripts.

use super::plots::{Plot, albedo_of_report};
use super::svg::escape;
use super::{Entry, Outcome, Run};
use crate::check::report::{Finding, Report};
use crate::check::verdict::Verdict;
use core::fmt::Write;

const STYLE: &str = include_str!("page.css");

impl Run {
    /// The run as an HTML page: verdicts, counterexamples, pictures.
    ///
    /// A picture needs [`Figures`](super::Figures) in its entry; without them there is the albedo alone.
    pub fn to_html(&self) -> String {
        let mut page = String::new();
        let title = match &self.entries[..] {
            [entry] => format!("brdf check: {}", entry.name()),
            entries => format!("brdf check: {} subjects", entries.len()),
        };
        let title = escape(&title);
        let _ = write!(
            page,
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n\
             <style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n<p class=\"summary\">{}</p>\n<p class=\"tool\">{} · twins: {}</p>\n",
            escape(&self.summary()),
            escape(&self.tool),
            escape(&self.twins)
        );
        if self.entries.len() > 1 {
            overview(&mut page, &self.entries);
        }
        for entry in &self.entries {
            section(&mut page, entry, self.entries.len() == 1);
        }
        page.push_str("</body>\n</html>\n");
        page
    }
}

/// The class that colours a verdict.
fn class(verdict: &str) -> &'static str {
    match verdict {
        "PASS" => "pass",
        "FAIL" => "fail",
        "SKIPPED" => "advisory",
        _ => "open",
    }
}

fn badge(verdict: &str) -> String {
    format!("<span class=\"badge {}\">{verdict}</span>", class(verdict))
}

/// The worst line of a report: what a table of many subjects has room for.
fn headline(report: &Report) -> String {
    let told = report.findings.iter().filter(|finding| finding.is_told()).max_by_key(|finding| finding.verdict);
    told.map_or_else(
        || {
            let counted = report.findings.iter().filter(|finding| finding.accepted).count();
            if counted > 0 { format!("{counted} accepted by the baseline") } else { String::new() }
        },
        Finding::to_string,
    )
}

fn overview(page: &mut String, entries: &[Entry]) {
    page.push_str("<table class=\"overview\">\n<thead><tr><th>subject</th><th>kind</th><th>verdict</th><th>worst finding</th></tr></thead>\n<tbody>\n");
    for entry in entries {
        let (index, name, kind) = (entry.index, escape(entry.name()), escape(&entry.kind));
        let line = match &entry.outcome {
            Outcome::Judged { report, .. } => headline(report),
            Outcome::Refused { reason, .. } => reason.clone(),
        };
        let _ = writeln!(
            page,
            "<tr><td><a href=\"#s{index}\">{name}</a></td><td>{kind}</td><td>{}</td><td>{}</td></tr>",
            badge(entry.verdict_name()),
            escape(&line)
        );
    }
    page.push_str("</tbody>\n</table>\n");
}

fn section(page: &mut String, entry: &Entry, alone: bool) {
    let _ = writeln!(
        page,
        "<section id=\"s{}\">\n<h2>{} {}</h2>\n<p class=\"source\">{} · {}</p>",
        entry.index,
        badge(entry.verdict_name()),
        escape(entry.name()),
        escape(&entry.source),
        escape(&entry.kind)
    );
    match &entry.outcome {
        Outcome::Refused { reason, .. } => {
            let _ = writeln!(page, "<p>{}</p>", escape(reason));
        }
        Outcome::Judged { report, figures } => {
            findings(page, report);
            for note in &report.notes {
                let _ = writeln!(page, "<p class=\"note\">{}</p>", escape(note));
            }
            for finding in report.findings.iter().filter(|finding| finding.is_told()) {
                counterexample(page, finding);
            }
            let pictures: Vec<String> = match figures {
                Some(figures) => {
                    Plot::ALL.iter().filter_map(|plot| plot.draw(figures, &report.subject, true)).collect()
                }
                None => albedo_of_report(report).into_iter().collect(),
            };
            // A page of many subjects opens on what is wrong.
            let open = if alone || report.verdict() != Verdict::Pass { " open" } else { "" };
            let _ = writeln!(page, "<details{open}>\n<summary>Pictures</summary>\n<div class=\"pictures\">");
            for picture in pictures {
                let _ = writeln!(page, "<figure>{picture}</figure>");
            }
            page.push_str("</div>\n</details>\n");
            let _ = writeln!(page, "<pre class=\"coverage\">{}</pre>", escape(report.coverage.to_string().trim_end()));
        }
    }
    page.push_str("</section>\n");
}

fn findings(page: &mut String, report: &Report) {
    page.push_str("<table>\n<thead><tr><th>check</th><th>verdict</th><th>value</th><th>where</th><th>note</th></tr></thead>\n<tbody>\n");
    for finding in &report.findings {
        let verdict = finding.verdict.name();
        let verdict = match (finding.binding, finding.accepted) {
            (_, true) => format!("<span class=\"badge advisory\">{verdict}, accepted</span>"),
            (true, _) => badge(verdict),
            (false, _) if finding.verdict == Verdict::Pass => "note".to_owned(),
            (false, _) => format!("<span class=\"badge advisory\">{verdict}, advisory</span>"),
        };
        let _ = writeln!(
            page,
            "<tr><td>{}</td><td>{verdict}</td><td class=\"value\">{}</td><td>{}</td><td>{}</td></tr>",
            escape(&finding.title()),
            escape(&finding.measured()),
            escape(finding.located().trim_start().trim_start_matches("at ")),
            escape(&finding.note)
        );
    }
    page.push_str("</tbody>\n</table>\n");
}

fn counterexample(page: &mut String, finding: &Finding) {
    let _ = writeln!(page, "<div class=\"counterexample {}\">", class(finding.verdict.name()));
    let _ = writeln!(page, "<h3>{}</h3>\n<dl>", escape(&finding.to_string()));
    for (title, text) in finding.details() {
        let text = escape(&text);
        let text = if title == "likely cause" { text } else { format!("<code>{text}</code>") };
        let _ = writeln!(page, "<dt>{title}</dt><dd>{text}</dd>");
    }
    page.push_str("</dl>\n</div>\n");
}

#[cfg(test)]
mod tests {
    use super::super::figures::{Figures, Grid, Series};
    use super::super::tests::report;
    use super::*;

    fn page() -> String {
        let mut drawn = Entry::judged(0, "a.wgsl", "WGSL", report("<a> & b", Verdict::Fail));
        if let Outcome::Judged { figures, .. } = &mut drawn.outcome {
            let grid = || Grid { x: vec![0.0, 45.0], y: vec![0.0, 45.0], values: vec![0.0, 1.0, 2.0, -3.0] };
            *figures = Some(Box::new(Figures {
                albedo: vec![Series { x: vec![0.0], y: vec![1.2], ..Series::default() }],
                reciprocity: grid(),
                validity: grid(),
                ..Figures::default()
            }));
        }
        let entries = vec![
            drawn,
            Entry::judged(1, "b", "WGSL", report("b", Verdict::Pass)),
            Entry::refused(2, "c", "MERL", "torn <here>"),
        ];
        Run { total: 3, entries, ..Run::new() }.to_html()
    }

    #[test]
    fn the_page_stands_alone() {
        let page = page();
        for foreign in ["http:", "https:", "<script", "<link", "@import", "url(", "src="] {
            let found = page.replace("http://www.w3.org/2000/svg", "").contains(foreign);
            assert!(!found, "{foreign}");
        }
        for wanted in
            ["&lt;a&gt; &amp; b", "torn &lt;here&gt;", "1.2490 ± 0.0004", "view-only scaling", "<svg", "REFUSED"]
        {
            assert!(page.contains(wanted), "{wanted}");
        }
    }

    #[test]
    fn every_element_is_closed() {
        // But for the head's metadata, which HTML leaves open, the page is XML.
        let page = page().replace("<!doctype html>", "");
        let xml: String =
            page.lines().filter(|line| !line.starts_with("<meta")).map(|line| format!("{line}\n")).collect();
        let xml = xml.replace("<details open>", "<details open=\"\">");
        let document = roxmltree::Document::parse(&xml).unwrap_or_else(|e| panic!("{e}\n{xml}"));
        let count = |tag| document.descendants().filter(|n| n.tag_name().name() == tag).count();
        // Four of the drawn subject, the albedo alone of the other.
        assert_eq!((count("section"), count("svg"), count("h3")), (3, 5, 1));
    }
}
