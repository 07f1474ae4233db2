//! The tree that TOML and JSON share, and a walk through it that knows where it is.

use super::DescriptionError;
use alloc::borrow::{Cow, ToOwned};
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec;
use alloc::vec::Vec;
use core::fmt;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A value of the tree that a stack is described by, and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Node {
    /// The value.
    pub value: Value,
    /// The line of its key or, in a list, its own, counted from 1; none where it did not come from a file.
    pub line: Option<usize>,
}

/// What TOML and JSON have in common.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number, finite or not.
    Number(f64),
    /// A string.
    Text(String),
    /// True or false.
    Flag(bool),
    /// A list.
    List(Vec<Node>),
    /// Keys and their values, in the order in which they were written.
    Table(Vec<(String, Node)>),
    /// What no description holds, in words: `a date`, `null`.
    Other(String),
}

impl From<Value> for Node {
    /// A node that did not come from a file.
    fn from(value: Value) -> Self {
        Node { value, line: None }
    }
}

impl Node {
    /// The tree of a TOML document.
    ///
    /// # Errors
    ///
    /// The parser's message where the text is not TOML.
    pub fn from_toml(text: &str) -> Result<Self, DescriptionError> {
        let ends: Vec<usize> = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(at, _)| at).collect();
        let line = |at: usize| ends.partition_point(|end| *end < at) + 1;
        let (document, errors) = DeTable::parse_recoverable(text);
        let document = document.into_inner();
        let value = table_value(&document, &line, 0);
        dismantle(document);
        // The parser finds errors in passes: of keys and brackets first, of values later. The topmost is the cause.
        let start = |error: &toml::de::Error| error.span().map_or(usize::MAX, |span| span.start);
        match errors.into_iter().min_by_key(start) {
            Some(error) => Err(DescriptionError {
                line: error.span().map(|span| line(span.start)),
                key: String::new(),
                problem: format!("not TOML: {}", error.message().trim().replace('\n', ", ")),
            }),
            None => Ok(Node { value, line: None }),
        }
    }
}

/// Drops a table without recursion, which would overflow the stack: see [`DEEPEST`].
fn dismantle(table: DeTable<'_>) {
    let mut rest = vec![DeValue::Table(table)];
    while let Some(value) = rest.pop() {
        match value {
            DeValue::Table(table) => rest.extend(table.into_iter().map(|(_, value)| value.into_inner())),
            DeValue::Array(items) => rest.extend(items.into_iter().map(Spanned::into_inner)),
            _ => {}
        }
    }
}

/// A stack needs seven levels, the fields of a material as many as are nested. The parser bounds tables within tables and keys within keys, each to 80, but not
/// their product, which is deep enough to overflow the stack.
pub(crate) const DEEPEST: usize = 32;

fn table_value(table: &DeTable<'_>, line: &impl Fn(usize) -> usize, depth: usize) -> Value {
    if depth > DEEPEST {
        return Value::Other("a table within too many others".to_owned());
    }
    let mut entries: Vec<_> = table.iter().collect();
    entries.sort_by_key(|(key, _)| key.span().start);
    let entry = |(key, value): (&Spanned<Cow<'_, str>>, &Spanned<DeValue<'_>>)| {
        let value = toml_value(value.get_ref(), line, depth + 1);
        (key.get_ref().to_string(), Node { value, line: Some(line(key.span().start)) })
    };
    Value::Table(entries.into_iter().map(entry).collect())
}

fn toml_value(value: &DeValue<'_>, line: &impl Fn(usize) -> usize, depth: usize) -> Value {
    match value {
        DeValue::String(text) => Value::Text(text.to_string()),
        DeValue::Boolean(flag) => Value::Flag(*flag),
        DeValue::Datetime(_) => Value::Other("a date or time".to_owned()),
        DeValue::Float(number) => read(number.as_str().parse().ok()),
        DeValue::Integer(number) if number.radix() == 10 => read(number.as_str().parse().ok()),
        DeValue::Integer(number) => {
            read(u64::from_str_radix(number.as_str(), number.radix()).ok().map(|number| number as f64))
        }
        DeValue::Array(_) if depth > DEEPEST => Value::Other("a list within too many others".to_owned()),
        DeValue::Array(items) => {
            let item = |item: &Spanned<DeValue<'_>>| Node {
                value: toml_value(item.get_ref(), line, depth + 1),
                line: Some(line(item.span().start)),
            };
            Value::List(items.iter().map(item).collect())
        }
        DeValue::Table(table) => table_value(table, line, depth),
    }
}

fn read(number: Option<f64>) -> Value {
    number.map_or_else(|| Value::Other("an integer of more than 64 bits".to_owned()), Value::Number)
}

/// Where a value stands.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Place {
    pub(crate) path: String,
    pub(crate) line: Option<usize>,
}

impl Place {
    /// The place of a key of the table at this place.
    pub(crate) fn key(&self, key: &str, line: Option<usize>) -> Self {
        let bare = !key.is_empty() && key.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'-');
        let key = if bare { key.to_owned() } else { format!("{key:?}") };
        let path = if self.path.is_empty() { key } else { format!("{}.{key}", self.path) };
        Place { path, line }
    }

    /// The place of an item of the list at this place.
    pub(crate) fn item(&self, index: usize, line: Option<usize>) -> Self {
        Place { path: format!("{}[{index}]", self.path), line }
    }

    pub(crate) fn error(&self, problem: impl Into<String>) -> DescriptionError {
        DescriptionError { line: self.line, key: self.path.clone(), problem: problem.into() }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{} on line {line}", self.path),
            None => write!(f, "{}", self.path),
        }
    }
}

/// A node and its place.
pub(crate) struct Entry<'a> {
    pub(crate) node: &'a Node,
    pub(crate) place: Place,
}

impl<'a> Entry<'a> {
    pub(crate) fn expected(&self, what: &str) -> DescriptionError {
        let found = match &self.node.value {
            Value::Number(_) => "a number",
            Value::Text(_) => "a string",
            Value::Flag(_) => "true or false",
            Value::List(_) => "a list",
            Value::Table(_) => "a table",
            Value::Other(kind) => kind,
        };
        self.place.error(format!("found {found}, expected {what}"))
    }

    pub(crate) fn text(&self) -> Result<&'a str, DescriptionError> {
        match &self.node.value {
            Value::Text(text) => Ok(text),
            _ => Err(self.expected("a string")),
        }
    }

    pub(crate) fn number(&self) -> Result<f64, DescriptionError> {
        match &self.node.value {
            Value::Number(number) => Ok(*number),
            _ => Err(self.expected("a number")),
        }
    }

    pub(crate) fn flag(&self) -> Result<bool, DescriptionError> {
        match &self.node.value {
            Value::Flag(flag) => Ok(*flag),
            _ => Err(self.expected("true or false")),
        }
    }

    pub(crate) fn items(&self, what: &str) -> Result<Vec<Entry<'a>>, DescriptionError> {
        match &self.node.value {
            Value::List(items) => {
                let item = |(i, node): (usize, &'a Node)| Entry { node, place: self.place.item(i, node.line) };
                Ok(items.iter().enumerate().map(item).collect())
            }
            _ => Err(self.expected(what)),
        }
    }

    /// The table at this entry, whose keys are all among the allowed ones.
    pub(crate) fn table(&self, allowed: &'static [&'static str], what: &str) -> Result<Table<'a>, DescriptionError> {
        let Value::Table(entries) = &self.node.value else {
            return Err(self.expected(what));
        };
        for (i, (key, node)) in entries.iter().enumerate() {
            let place = self.place.key(key, node.line);
            if !allowed.contains(&key.as_str()) {
                return Err(place.error(format!("unknown key, {}", suggestion(key, allowed.iter().copied()))));
            }
            if let Some((_, first)) = entries[..i].iter().find(|(other, _)| other == key) {
                return Err(place.error(format!("given twice, first as {}", self.place.key(key, first.line))));
            }
        }
        Ok(Table { entries, place: self.place.clone() })
    }
}

/// The entries of a table whose keys are known.
pub(crate) struct Table<'a> {
    pub(crate) entries: &'a [(String, Node)],
    pub(crate) place: Place,
}

impl<'a> Table<'a> {
    pub(crate) fn get(&self, key: &str) -> Option<Entry<'a>> {
        let (key, node) = self.entries.iter().find(|(other, _)| other == key)?;
        Some(Entry { node, place: self.place.key(key, node.line) })
    }

    pub(crate) fn require(&self, key: &str, what: &str) -> Result<Entry<'a>, DescriptionError> {
        self.get(key).ok_or_else(|| self.place.key(key, self.place.line).error(format!("missing, expected {what}")))
    }
}

/// The nearest allowed name, where one is near, and all of them.
pub(crate) fn suggestion(name: &str, allowed: impl Iterator<Item = &'static str> + Clone) -> String {
    let lower = name.to_lowercase();
    let near = allowed.clone().map(|other| (edits(&lower, other), other)).min();
    let all: Vec<_> = allowed.map(|other| format!("`{other}`")).collect();
    match near {
        Some((edits, other)) if 3 * edits <= other.len().max(3) => {
            format!("did you mean `{other}`? Allowed: {}", all.join(", "))
        }
        _ => format!("allowed: {}", all.join(", ")),
    }
}

/// The least number of characters to insert, remove or replace (Levenshtein 1966).
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, to) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(from != *to);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}
