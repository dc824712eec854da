//! Faults of a world.

pub mod field;

use std::fmt;

use palpate_core::Range;

use field::WorldField;

/// Largest allowed magnitude of a quantity of a world, in any unit. Squares and products of larger values may not be
/// finite.
pub const LARGEST: f64 = 1e12;
/// Smallest allowed value, in any unit, of a quantity that must be above 0.
pub const LEAST: f64 = 1e-20;

/// Returns the message for a `value` outside `range`, or `None` if it is inside. The message calls the quantity
/// `name`.
#[must_use]
pub fn out_of_range(name: impl fmt::Display, value: f64, range: Range) -> Option<String> {
    let least = if range == Range::Positive { LEAST } else { 0.0 };
    let allowed = if value.is_infinite() {
        "finite".into()
    } else if !range.contains(value) {
        match range {
            Range::Positive => "above 0".into(),
            Range::NotNegative => "at least 0".into(),
            Range::Finite => "a finite number".into(),
        }
    } else if value.abs() > LARGEST {
        let sign = if value < 0.0 { "-" } else { "" };
        format!(
            "{} {sign}{LARGEST:e}",
            if value < 0.0 { "at least" } else { "at most" }
        )
    } else if value < least && value > 0.0 {
        format!("at least {LEAST:e}")
    } else {
        return None;
    };
    let size = value.abs();
    let is_plain = value == 0.0 || !value.is_finite() || (1e-5..1e16).contains(&size);
    let shown = if is_plain {
        value.to_string()
    } else {
        format!("{value:e}")
    };
    Some(format!("{name} is {shown}, and has to be {allowed}"))
}

/// The part of a world that has a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum WorldPart {
    /// The world as a whole.
    World,
    /// The tool with this index, from 0.
    Tool(usize),
    /// The body with this index, from 0.
    Body(usize),
    /// The contact with this index, from 0.
    Contact(usize),
    /// The joint with this index, from 0.
    Joint(usize),
    /// The field with this index, from 0.
    Field(usize),
    /// The loop in which a world is rendered.
    Loop,
    /// The rendering method.
    Method,
}

/// A fault of a world: location, cause and allowed values.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{subject}: {message}")]
pub struct WorldError {
    /// Part of the world.
    pub part: WorldPart,
    /// Field of that part.
    pub field: WorldField,
    /// The part in words, for example `body "ball"`.
    pub subject: String,
    /// Cause with the value, and the allowed values.
    pub message: String,
}

impl WorldError {
    /// Creates a fault of a part. The message must include the allowed values.
    pub fn new(
        part: WorldPart,
        field: WorldField,
        subject: impl Into<String>,
        message: impl fmt::Display,
    ) -> Self {
        Self {
            part,
            field,
            subject: subject.into(),
            message: message.to_string(),
        }
    }
}

/// Every fault of a world, of its rendering, or of a change to it: at least one.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldErrors(Vec<WorldError>);

impl WorldErrors {
    /// Takes `faults`, at least one.
    pub(crate) fn all(faults: Vec<WorldError>) -> Self {
        debug_assert!(!faults.is_empty());
        Self(faults)
    }

    /// Fails with `faults` if there are any.
    pub(crate) fn check(faults: Vec<WorldError>) -> Result<(), Self> {
        if faults.is_empty() {
            Ok(())
        } else {
            Err(Self::all(faults))
        }
    }

    /// Returns the first fault.
    #[must_use]
    pub fn first(&self) -> &WorldError {
        &self.0[0]
    }

    /// Returns an iterator over the faults.
    pub fn iter(&self) -> std::slice::Iter<'_, WorldError> {
        self.0.iter()
    }
}

impl From<WorldError> for WorldErrors {
    fn from(fault: WorldError) -> Self {
        Self(vec![fault])
    }
}

impl IntoIterator for WorldErrors {
    type Item = WorldError;
    type IntoIter = std::vec::IntoIter<WorldError>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}

impl<'a> IntoIterator for &'a WorldErrors {
    type Item = &'a WorldError;
    type IntoIter = std::slice::Iter<'a, WorldError>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

/// A line for each.
impl fmt::Display for WorldErrors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (number, fault) in self.iter().enumerate() {
            let separator = if number == 0 { "" } else { "\n" };
            write!(f, "{separator}{fault}")?;
        }
        Ok(())
    }
}

impl std::error::Error for WorldErrors {}
