//! What a failed link says: the problem, the place, the remedy, on one line.

use alloc::borrow::ToOwned;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt;

/// Why a shader could not be linked. Its `Display` is one line: place, problem, remedy.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct LinkError {
    /// The text at fault: `root` for the caller's shader, `brdf::fresnel` for a module, else the function called.
    pub place: String,
    /// Line and column there, counted in characters from 1; none where the fault is in an argument.
    pub position: Option<(usize, usize)>,
    /// What is wrong.
    pub problem: String,
    /// How to mend it.
    pub remedy: String,
}

impl LinkError {
    /// An error at a byte offset of a text.
    pub(crate) fn at(place: String, text: &str, offset: usize, problem: String, remedy: String) -> Self {
        let before = text.get(..offset).unwrap_or(text);
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().map_or(0, |line| line.chars().count()) + 1;
        LinkError { place, position: Some((line, column)), problem, remedy }
    }
}

impl fmt::Display for LinkError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.place)?;
        if let Some((line, column)) = self.position {
            write!(f, "{line}:{column}:")?;
        }
        write!(f, " {}; {}", self.problem, self.remedy)
    }
}

impl core::error::Error for LinkError {}

/// The remedy for an unknown name: the nearest of those that exist, and a list of them.
pub(crate) fn suggest<'a>(wanted: &str, names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.collect();
    let near = match names.iter().map(|name| (distance(wanted, name), *name)).min() {
        Some((edits, name)) if edits <= 2.max(wanted.chars().count() / 3) => format!("did you mean `{name}`? "),
        _ => String::new(),
    };
    near + &list(names.into_iter())
}

/// The names that exist, as far as a line can hold them.
pub(crate) fn list<'a>(names: impl Iterator<Item = &'a str>) -> String {
    const LISTED: usize = 16;
    let mut names: Vec<&str> = names.collect();
    names.sort_unstable();
    match names.len() {
        0 => "there are none".to_owned(),
        1..=LISTED => format!("there are: {}", names.join(", ")),
        _ => format!("there are: {}, …", names[..LISTED].join(", ")),
    }
}

/// Levenshtein's distance; anything over 64 characters is far from everything.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    if a.chars().count().max(b.len()) > 64 {
        return usize::MAX;
    }
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = i;
        row[0] = i + 1;
        for (j, cb) in b.iter().enumerate() {
            let substitution = diagonal + usize::from(ca != *cb);
            diagonal = row[j + 1];
            row[j + 1] = substitution.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::string::ToString;

    #[test]
    fn near_names_come_first() {
        let names = ["dielectric", "conductor", "schlick"];
        assert_eq!(
            suggest("dielektric", names.into_iter()),
            "did you mean `dielectric`? there are: conductor, dielectric, schlick"
        );
        assert_eq!(suggest("v_cavity", names.into_iter()), "there are: conductor, dielectric, schlick");
        assert_eq!(suggest("x", [].into_iter()), "there are none");
        assert_eq!(distance("kitten", "sitting"), 3);
    }

    #[test]
    fn places_count_characters_from_one() {
        let error = LinkError::at("root".to_owned(), "α\nβγ δ", 8, "p".to_owned(), "r".to_owned());
        assert_eq!(error.to_string(), "root:2:4: p; r");
    }
}
