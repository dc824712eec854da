//! Errors of reading a trace.

use std::io;

use thiserror::Error;

use super::ReadNotes;
use super::layout::Way;
use crate::place::TextPosition;

/// Reason why a trace could not be read.
#[derive(Debug, Error)]
pub enum TraceError {
    /// The bytes cannot be read.
    #[error("{file}: cannot be read: {source}")]
    Unreadable {
        /// Name given by the caller.
        file: String,
        /// Error of the operating system.
        source: io::Error,
    },
    /// The layout of the caller selects a quantity that tables of this kind do not have.
    #[error("{file}: {fault}")]
    Layout {
        /// Name given by the caller.
        file: String,
        /// The fault, and the allowed values.
        fault: String,
    },
    /// The text is not a trace.
    #[error("{place}: {fault}")]
    Invalid {
        /// Line of the fault.
        place: Box<TextPosition>,
        /// The fault, and the allowed values.
        fault: TraceFault,
    },
}

impl TraceError {
    /// Returns the position of the fault in the text; `None` without text.
    #[must_use]
    pub fn place(&self) -> Option<&TextPosition> {
        match self {
            Self::Unreadable { .. } | Self::Layout { .. } => None,
            Self::Invalid { place, .. } => Some(place),
        }
    }
}

/// A fault in the text of a trace. Each message names the allowed values.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum TraceFault {
    /// There is no header.
    #[error(
        "the file is empty; a trace begins with a header that names its columns: `t_s` and `position_m`, or in a world t, \
         x, y and z"
    )]
    Empty,
    /// The bytes are not UTF-8.
    #[error("the byte 0x{byte:02X} is not UTF-8; save the trace as UTF-8 text")]
    NotUtf8 {
        /// First invalid byte.
        byte: u8,
    },
    /// The header lacks a column.
    #[error(
        "the header has no column `{name}`{}; needed: {needed}, separated by commas, semicolons or tabs, in any \
         order{way}",
        nearest.as_ref().map(|found| format!(", the nearest is `{found}`")).unwrap_or_default()
    )]
    MissingColumn {
        /// The missing column.
        name: String,
        /// Column of the header with the most similar name.
        nearest: Option<String>,
        /// All required columns.
        needed: String,
        /// Remedy, in terms of the caller's interface.
        way: Way,
    },
    /// The header names a column more or less often than needed.
    #[error(
        "the header names the column `{name}` {}; {} needed{way}",
        if *found == 2 { "twice".to_owned() } else { format!("{found} times") },
        if *needed == 1 { "one is".to_owned() } else { format!("{needed} are") }
    )]
    DuplicateColumn {
        /// The column.
        name: String,
        /// Number of its occurrences.
        found: usize,
        /// Required number.
        needed: usize,
        /// Remedy, in terms of the caller's interface.
        way: Way,
    },
    /// The time and a value, or two values, are read from one column.
    #[error(
        "the column `{name}` is selected as {one} and as `{other}`; select another column for one of them"
    )]
    SharedColumn {
        /// The column.
        name: String,
        /// The time or the first value.
        one: String,
        /// The other value.
        other: String,
    },
    /// Two sources name different units.
    #[error(
        "the unit of column `{name}` is {one} according to {says_one}, but {other} according to {says_other}{way}"
    )]
    Units {
        /// The column.
        name: String,
        /// A unit.
        one: &'static str,
        /// Source of the first unit.
        says_one: &'static str,
        /// Another unit.
        other: &'static str,
        /// Source of the other unit.
        says_other: &'static str,
        /// Remedy, in terms of the caller's interface.
        way: Way,
    },
    /// A cell of the unit row is not a unit.
    #[error("`{text}` in the unit row is not a unit of column `{name}`; allowed: {allowed}")]
    NotAUnit {
        /// The column.
        name: String,
        /// The cell.
        text: String,
        /// Known units.
        allowed: &'static str,
    },
    /// A line has more or fewer fields than the header.
    #[error(
        "the line has {found} fields, the header {expected}; each line has one field per column"
    )]
    FieldCount {
        /// Number of fields of the header.
        expected: usize,
        /// Number of fields of the line.
        found: usize,
    },
    /// A field is not a number.
    #[error(
        "`{text}` in column `{name}` is not a number; allowed: decimals such as 0.001 or 1e-3{way}"
    )]
    NotANumber {
        /// The field's column.
        name: String,
        /// The field.
        text: String,
        /// Remedy, in terms of the caller's interface, if any.
        way: Way,
    },
    /// A field is infinite or not a number.
    #[error("`{text}` in column `{name}` is not finite; every sample needs a finite value{way}")]
    NotFinite {
        /// The field's column.
        name: String,
        /// The field.
        text: String,
        /// Remedy, in terms of the caller's interface, if any.
        way: Way,
    },
    /// A number is too large.
    #[error("`{text}` in column `{name}` must be a number between -1e12 and 1e12")]
    TooLarge {
        /// The field's column.
        name: String,
        /// The field.
        text: String,
    },
    /// A quaternion does not have norm 1.
    #[error("qw,qx,qy,qz is a quaternion of length {length}, but must have length 1")]
    Quaternion {
        /// Its norm.
        length: f64,
    },
    /// The last line has no line end, and the caller receives no notes.
    #[error(
        "the last line has no line end, so its last number, `{text}`, may be cut off; if the file is complete, \
         end it with a line end"
    )]
    CutOff {
        /// The field.
        text: String,
    },
    /// Times do not increase.
    #[error(
        "the time {now} s does not come after {before} s; times must increase from line to line"
    )]
    TimeNotIncreasing {
        /// Time of the sample before `[s]`.
        before: f64,
        /// Time of this sample `[s]`.
        now: f64,
    },
    /// A field of the column of forces is not a finite number.
    #[error(
        "`{text}` in column `{name}` is not a finite number; this column has the force [N] held on the \
         device from this sample on, 0 without a force"
    )]
    NotAForce {
        /// The field's column.
        name: String,
        /// The field.
        text: String,
    },
    /// A quoted field has no end.
    #[error(
        "the quote that opens here is not closed before the end of the file; close the field with \
         `\"`, or remove the quote"
    )]
    OpenQuote,
    /// The trace is longer than allowed.
    #[error("the trace continues for more than {longest} s after its first sample at {first} s")]
    TooLong {
        /// Longest allowed time `[s]`.
        longest: f64,
        /// Time of the first selected sample `[s]`.
        first: f64,
    },
    /// Fewer than two samples lie in the selected part.
    #[error(
        "{found} of at least 2 required samples lie {}; the times of the trace begin at \
         {first} s{}{}",
        between(*from, *to),
        last.map_or_else(String::new, |last| format!(" and end at {last} s")),
        left_out(notes)
    )]
    TooFewInPart {
        /// Start of the part `[s]`.
        from: f64,
        /// End of the part `[s]`.
        to: f64,
        /// Number of samples.
        found: usize,
        /// Time of the first sample of the trace `[s]`.
        first: f64,
        /// Time of the last sample `[s]`, if the trace was read to its end.
        last: Option<f64>,
        /// Omitted samples.
        notes: ReadNotes,
    },
    /// The trace has fewer than two samples.
    #[error(
        "a trace needs at least 2 samples, this one has {found}{}",
        left_out(notes)
    )]
    TooFewSamples {
        /// Number of samples.
        found: usize,
        /// Omitted samples.
        notes: ReadNotes,
    },
}

/// Describes the samples that were left out of a trace, with the way to keep one.
fn left_out(notes: &ReadNotes) -> String {
    let mut said = match notes.left_out {
        0 => String::new(),
        1 => "; 1 without a value was left out".to_owned(),
        count => format!("; {count} without a value were left out"),
    };
    if let Some(text) = &notes.unended {
        said += &format!(
            "; the sample of the last line was left out, because the line has no line end and its last number, \
             `{text}`, may be cut off: if the file is complete, end it with a line end"
        );
    }
    said
}

/// Describes a span of time.
fn between(from: f64, to: f64) -> String {
    match (from.is_finite(), to.is_finite()) {
        (true, true) => format!("from {from} s to {to} s"),
        (true, false) => format!("from {from} s on"),
        (false, true) => format!("up to {to} s"),
        (false, false) => "in it".to_owned(),
    }
}
