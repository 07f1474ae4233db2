//! Tokens written as text again, with the place that each one came from.

use super::error::SourceError;
use super::lexer::{File, Kind, Origin, Token};

/// A text for a compiler, and where its parts were written.
#[derive(Clone, Debug, Default)]
pub(super) struct Emitted {
    pub(super) text: String,
    /// Offsets in ascending order, and the place of what begins there; none of what nobody wrote.
    map: Vec<(usize, Option<Origin>)>,
    line: (u32, u32),
    last: Option<Kind>,
}

impl Emitted {
    /// Appends text that has no place.
    pub(super) fn raw(&mut self, text: &str) {
        self.map.push((self.text.len(), None));
        self.text.push_str(text);
        self.last = None;
    }

    pub(super) fn token(&mut self, token: &Token) {
        let line = (token.origin.file, token.origin.line);
        let names = |kind: Kind| kind != Kind::Sign;
        if token.leads || line != self.line {
            self.text.push('\n');
        } else if token.spaced || token.hidden.is_some() || (self.last.is_some_and(names) && names(token.kind)) {
            // What macros put side by side must not run together.
            self.text.push(' ');
        }
        self.map.push((self.text.len(), Some(token.origin)));
        self.text.push_str(&token.text);
        (self.line, self.last) = (line, Some(token.kind));
    }

    /// Where what stands at an offset was written.
    pub(super) fn origin(&self, offset: usize) -> Option<Origin> {
        let after = self.map.partition_point(|(start, _)| *start <= offset);
        self.map.get(after.checked_sub(1)?).and_then(|(_, origin)| *origin)
    }

    /// Refuses what would exhaust the stack of a compiler, at its place.
    pub(super) fn bounded(&self, files: &[File]) -> Result<(), SourceError> {
        let Err(error) = crate::shader::interp::bounded(&self.text) else { return Ok(()) };
        // It names a line of this text, which is not the author's.
        let named = error.message().strip_prefix("line ").and_then(|rest| rest.split_once(": "));
        let named = named.and_then(|(line, what)| Some((line.parse::<usize>().ok()?, what)));
        let (line, what) = named.unwrap_or((1, error.message()));
        let before: usize = self.text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
        Err(match self.origin(before) {
            Some(origin) => SourceError::at(files, origin, what),
            None => SourceError::of(files.first().map_or("", |file| &file.name), what),
        })
    }
}
