//! The command that shows a finding again.

use super::Options;
use super::subjects::Source;
use brdf::check::{self, Check, Finding, Place};

/// The command line that evaluates the place of a finding; where it has none, the one that repeats the check.
pub(super) fn command(options: &Options, source: &Source, finding: &Finding) -> String {
    let mut words = vec!["brdf".to_owned(), "check".to_owned()];
    words.extend(options.reading.arguments(source));
    words.extend(["--seed".to_owned(), options.seed.to_string()]);
    let parameters: String = finding.parameters.iter().map(|(name, value)| format!(",{name}={value}")).collect();
    // That f does not change when both directions turn is seen at no one pair.
    let place = if finding.check == Check::Limit { Place::Everywhere } else { finding.place };
    words.extend(settings(options, place == Place::Everywhere));
    match place {
        Place::Everywhere => {}
        Place::Marginal { theta, phi, fixed } => {
            words.extend(["--at".to_owned(), format!("theta={theta},phi={phi},{}{parameters}", fixed.name())]);
        }
        Place::Pair { wi, wo } => {
            let [wi, wo] = [wi, wo].map(|v| format!("{}:{}:{}", plain(v.x), plain(v.y), plain(v.z)));
            words.extend(["--at".to_owned(), format!("wi={wi},wo={wo}{parameters}")]);
        }
    }
    words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
}

/// Every digit of a number, and no rows of zeros.
fn plain(x: f64) -> String {
    if x != 0.0 && x.abs() < 1e-4 { format!("{x:e}") } else { format!("{x}") }
}

/// What has to be told besides the subject, whatever is not the default: how its results are judged and, of a whole check, how it is done.
fn settings(options: &Options, whole: bool) -> Vec<String> {
    let default = check::Options::default();
    let mut words = Vec::new();
    let mut add = |option: &str, value: String| words.extend([option.to_owned(), value]);
    if let Some(profile) = options.profile {
        add("--profile", profile.name().to_owned());
    }
    if let Some(adapter) = &options.adapter {
        add("--adapter", adapter.clone());
    }
    if options.tolerance != check::TOLERANCE {
        add("--tolerance", options.tolerance.to_string());
    }
    if whole && options.budget != default.budget {
        add("--budget", options.budget.to_string());
    }
    if whole && options.distribution {
        words.push("--distribution".to_owned());
    }
    words
}

/// A word as a shell takes it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn words_survive_a_shell() {
        assert_eq!(quoted("a/b.wgsl"), "a/b.wgsl");
        assert_eq!(quoted("f(vec3, float)"), "'f(vec3, float)'");
        assert_eq!(quoted("it's"), "'it'\\''s'");
        assert_eq!(quoted(""), "''");
    }
}
