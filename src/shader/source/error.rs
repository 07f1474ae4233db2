//! What is wrong with a shader file, and where.

use super::lexer::{File, Origin};
use core::fmt;

/// A place in a text as its author wrote it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The file's name.
    pub file: String,
    /// The line, from 1.
    pub line: u32,
    /// The column, from 1, in characters.
    pub column: u32,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.file, self.line, self.column)
    }
}

/// Why a shader file cannot be used. Displays as one line, `file:line:column: message`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceError {
    place: Option<Place>,
    file: String,
    message: String,
    excerpt: Option<String>,
}

impl SourceError {
    /// An error of a whole file.
    pub(crate) fn of(file: &str, message: impl Into<String>) -> Self {
        SourceError { place: None, file: file.to_owned(), message: one_line(message.into()), excerpt: None }
    }

    /// An error at a place.
    pub(super) fn at(files: &[File], origin: Origin, message: impl Into<String>) -> Self {
        let Some(file) = files.get(origin.file as usize) else {
            return SourceError::of("", message);
        };
        let place = Place { file: file.name.clone(), line: origin.line, column: origin.column };
        let excerpt = file.text.lines().nth(origin.line.saturating_sub(1) as usize).map(|line| {
            let before = line.chars().take(origin.column.saturating_sub(1) as usize);
            // A tab stays a tab, so that the mark stands below what it marks.
            let indent: String = before.map(|c| if c == '\t' { '\t' } else { ' ' }).collect();
            format!("{line}\n{indent}^")
        });
        SourceError { file: file.name.clone(), place: Some(place), message: one_line(message.into()), excerpt }
    }

    /// Where it is, if it is in one place.
    pub fn place(&self) -> Option<&Place> {
        self.place.as_ref()
    }

    /// What is wrong, without the place.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// The message, then the line blamed with a mark below.
    pub fn report(&self) -> String {
        match &self.excerpt {
            Some(excerpt) => format!("{self}\n{excerpt}"),
            None => self.to_string(),
        }
    }
}

fn one_line(message: String) -> String {
    message.split_whitespace().collect::<Vec<_>>().join(" ")
}

impl fmt::Display for SourceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.place {
            Some(place) => write!(f, "{place}: {}", self.message),
            None if self.file.is_empty() => f.write_str(&self.message),
            None => write!(f, "{}: {}", self.file, self.message),
        }
    }
}

impl std::error::Error for SourceError {}
