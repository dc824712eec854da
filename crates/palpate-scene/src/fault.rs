//! Faults of scene and device files, and the places they are found at.

use std::collections::HashMap;
use std::fmt;
use std::hash::Hash;
use std::ops::Range;

use toml::Spanned;

use crate::method::nearest;

/// A place in the text of a file, in bytes.
pub(crate) type Span = Range<usize>;

/// A fault in a scene file or in the device file it names, with its place.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}: {message}", self.place())]
#[non_exhaustive]
pub struct SceneError {
    /// The flag at fault, with the edit that it makes in the file; `None` for a fault in the file itself.
    pub flag: Option<Box<str>>,
    /// Name of the file.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Bytes of the file that are at fault.
    pub span: Range<usize>,
    /// The error and the allowed values.
    pub message: String,
    /// The whole text, to show the place in.
    pub source_text: String,
}

impl SceneError {
    fn place(&self) -> String {
        let Self {
            file, line, column, ..
        } = self;
        match &self.flag {
            Some(flag) => flag.to_string(),
            None => format!("{file}:{line}:{column}"),
        }
    }

    pub(super) fn at(file: &str, source: &str, span: Range<usize>, message: String) -> Self {
        let before = &source[..span.start.min(source.len())];
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        Self {
            flag: None,
            file: file.into(),
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            span,
            message,
            source_text: source.into(),
        }
    }
}

/// Every fault of a scene file and of the device file it names, in the order of the file: at least one.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneErrors(Vec<SceneError>);

impl SceneErrors {
    /// The faults; none if there are none.
    pub(super) fn new(mut faults: Vec<SceneError>) -> Option<Self> {
        faults.sort_by_key(|fault| (fault.span.start, fault.span.end));
        faults.dedup();
        (!faults.is_empty()).then_some(Self(faults))
    }

    /// The first.
    #[must_use]
    pub fn first(&self) -> &SceneError {
        &self.0[0]
    }

    /// Each of them.
    pub fn iter(&self) -> std::slice::Iter<'_, SceneError> {
        self.0.iter()
    }
}

impl From<SceneError> for SceneErrors {
    fn from(fault: SceneError) -> Self {
        Self(vec![fault])
    }
}

impl IntoIterator for SceneErrors {
    type Item = SceneError;
    type IntoIter = std::vec::IntoIter<SceneError>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}

impl<'a> IntoIterator for &'a SceneErrors {
    type Item = &'a SceneError;
    type IntoIter = std::slice::Iter<'a, SceneError>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

/// A line for each.
impl fmt::Display for SceneErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, fault) in self.iter().enumerate() {
            f.write_str(if index > 0 { "\n" } else { "" })?;
            fault.fmt(f)?;
        }
        Ok(())
    }
}

impl std::error::Error for SceneErrors {}

/// Records the spans of values while unwrapping them.
pub(super) struct Places<K>(pub HashMap<K, Range<usize>>);

impl<K> Default for Places<K> {
    fn default() -> Self {
        Self(HashMap::new())
    }
}

impl<K: Eq + Hash> Places<K> {
    pub fn take<T>(&mut self, key: impl Into<K>, value: Spanned<T>) -> T {
        self.0.insert(key.into(), value.span());
        value.into_inner()
    }

    pub fn take_or<T>(&mut self, key: impl Into<K>, value: Option<Spanned<T>>, default: T) -> T {
        value.map_or(default, |value| self.take(key, value))
    }
}

/// A message of the TOML reader without Rust's names of types, and for an unknown key with the one
/// it most likely meant. The reader names both:
/// ``unknown field `x`, expected one of `a`, `b` ``.
#[must_use]
pub fn in_plain_words(message: &str) -> String {
    if let Some(key) = message.strip_prefix("missing field `") {
        return format!("the key {} is missing", key.trim_end_matches('`'));
    }
    let Some(rest) = message.strip_prefix("unknown field `") else {
        // Names of types are ours.
        if let Some((found, _)) = message.split_once("expected struct ") {
            return format!("{found}expected a table");
        }
        return message
            .replace("expected f64", "expected a number")
            .replace("expected i64", "expected a whole number")
            .replace("expected usize", "expected a whole number from 0 up")
            .replace("expected u64", "expected a whole number from 0 up");
    };
    let mut quoted = rest.split('`');
    let unknown = quoted.next().unwrap_or_default();
    // Every second piece from here on is quoted.
    let known: Vec<&str> = quoted.skip(1).step_by(2).collect();
    unknown_key(unknown, &known)
}

/// Returns the error message for a key outside `known`.
pub(crate) fn unknown_key(unknown: &str, known: &[&str]) -> String {
    let all = known.join(", ");
    match nearest(unknown, known) {
        Some(near) => format!("unknown key {unknown}, did you mean {near}? Known here: {all}"),
        None => format!("unknown key {unknown}. Known here: {all}"),
    }
}
