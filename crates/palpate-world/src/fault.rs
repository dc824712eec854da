//! What is wrong with a world.

use std::fmt;

use palpate::Range;

use crate::world_field::WorldField;

/// The largest number, of either sign, that a quantity of a world may have, in whatever unit. The squares and the
/// products of larger ones may not be finite.
pub const LARGEST: f64 = 1e12;
/// The least number, in whatever unit, of a quantity that has to be above 0.
pub const LEAST: f64 = 1e-20;

/// What is wrong with the `value` of a quantity of a world that has to lie in `range`; `None` where nothing is. The quantity
/// is called `name` there.
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

/// A part of a world, in which a fault is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum WorldPart {
    /// The world as a whole.
    World,
    /// The tool of this number, from 0.
    Tool(usize),
    /// The body of this number, from 0.
    Body(usize),
    /// The contact of this number, from 0.
    Contact(usize),
    /// The joint of this number, from 0.
    Joint(usize),
    /// The loop in which a world is rendered.
    Loop,
    /// The method by which it is rendered.
    Method,
}

/// A fault of a world: where it is, of what, and what is allowed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{subject}: {message}")]
pub struct WorldError {
    /// Which part of the world.
    pub part: WorldPart,
    /// The field of that part.
    pub field: WorldField,
    /// The part in words, for instance `body "ball"`.
    pub subject: String,
    /// What is wrong, with the value, and what is allowed.
    pub message: String,
}

impl WorldError {
    /// A fault of a part, with a message that says what is allowed.
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
