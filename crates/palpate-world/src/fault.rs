//! What is wrong with a world.

use std::fmt;

/// What is wrong with the `value` of a field that has to be finite and, as in "above 0", `allowed`.
pub(crate) fn out_of_range(field: &str, value: f64, allowed: &str) -> String {
    let allowed = if value == f64::INFINITY {
        "finite"
    } else {
        allowed
    };
    format!("{field} is {value}, and has to be {allowed}")
}

/// Where in a world a fault is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Place {
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
    pub place: Place,
    /// The field of that part, as it is called in this crate, for instance `mass`; empty for the part as a whole.
    pub field: &'static str,
    /// The part in words, for instance `body "ball"`.
    pub subject: String,
    /// What is wrong, with the value, and what is allowed.
    pub message: String,
}

impl WorldError {
    /// A fault of a part, with a message that says what is allowed.
    pub fn new(
        place: Place,
        field: &'static str,
        subject: impl Into<String>,
        message: impl fmt::Display,
    ) -> Self {
        Self {
            place,
            field,
            subject: subject.into(),
            message: message.to_string(),
        }
    }
}
