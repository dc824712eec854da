//! Recorded traces: where a device was, and when.
//!
//! A trace is UTF-8 text with columns separated by commas, semicolons or tabs. Its header must name
//! `t_s` and `position_m`, in any order, unless a [`Layout`] says which columns they are; other columns
//! are allowed and ignored. The line after the header may have the units. Lines that begin with `#`
//! and empty lines are skipped. Line ends may be `\n` or `\r\n`, and a byte order mark at the
//! start is accepted, since spreadsheets write both. The motion of the devices of a world is a table of
//! the same kind, read by [`read_world`].
//!
//! ```
//! let text = "# a hand at rest\nt_s,position_m\n0,0.01\n0.001,0.01\n";
//! let trace = palpate_record::trace::read(text.as_bytes(), "rest.csv")?;
//! assert_eq!(trace.t_s, [0.0, 0.001]);
//! # Ok::<(), palpate_record::trace::TraceError>(())
//! ```

mod columns;
mod fault;
mod growing;
mod layout;
mod led;
mod table;
#[cfg(test)]
mod tests;

pub use fault::{TraceError, TraceFault};
pub use layout::{Delimiter, Layout, Way, Ways};
pub use led::{LedDevice, WorldTrace, read_world};

use std::io::Read;

use columns::{Kind, Wanted};
use table::{Request, Text};

const FORCE: &str = "force_on_device_n";

/// The most characters of a field that an error repeats.
const LONGEST_FIELD: usize = 40;

/// A recorded motion along one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// Time of each sample, strictly increasing `[s]`.
    pub t_s: Vec<f64>,
    /// Position at each sample `[m]`.
    pub position_m: Vec<f64>,
}

/// Which samples of a trace are read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// From this time on `[s]`; samples before it are passed over.
    pub from: f64,
    /// Up to this time `[s]`; nothing after it is read.
    pub to: f64,
    /// The longest time from the first sample to the last `[s]`; a longer trace is refused as soon
    /// as that shows.
    pub longest: f64,
}

impl Part {
    /// All samples.
    pub const WHOLE: Self = Self {
        from: f64::NEG_INFINITY,
        to: f64::INFINITY,
        longest: f64::INFINITY,
    };
}

/// A trace with the force that was held while it was recorded.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldTrace {
    /// The motion.
    pub trace: Trace,
    /// Force on the device from each sample until the next `[N]`, of the column
    /// `force_on_device_n`; none where there is no such column.
    pub force_on_device_n: Option<Vec<f64>>,
    /// Notes on the text.
    pub notes: ReadNotes,
}

/// Notes on a text that was read.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct ReadNotes {
    /// Samples that were left out, since they had no value.
    pub left_out: usize,
    /// The last number, if the last line has no end: it may be cut off.
    pub unended: Option<String>,
}

/// Reads a trace of the plain layout; `file` is the name errors call it by.
///
/// # Errors
///
/// [`TraceError`] if the bytes cannot be read or the text is not a trace, also if its last line has no end, so that its
/// last number may be cut off.
pub fn read(reader: impl Read, file: &str) -> Result<Trace, TraceError> {
    let read = read_part(reader, file, &Part::WHOLE, &Layout::default());
    read.map(|held| held.trace)
}

/// Reads a part of a trace, and no further than its end; `file` is the name errors call it by.
///
/// # Errors
///
/// [`TraceError`] if the bytes cannot be read, the text is not a trace of this layout, or the part has fewer than
/// two samples or is too long. A column that is called by another unit is no position.
pub fn read_part(
    reader: impl Read,
    file: &str,
    part: &Part,
    layout: &Layout,
) -> Result<HeldTrace, TraceError> {
    let wanted = |kind, key: &str, stem: &str, shown: &str| Wanted {
        kind,
        keys: vec![key.to_owned()],
        bare: Vec::new(),
        stems: vec![stem.to_owned()],
        nth: (0, 1),
        shown: shown.to_owned(),
        is_needed: true,
    };
    let position = wanted(Kind::Length, "x", "position", "position_m");
    let force = Wanted {
        bare: vec![FORCE.to_owned()],
        is_needed: false,
        ..wanted(Kind::Force, "force", "", FORCE)
    };
    let request = Request {
        part,
        layout,
        wanted: &[position, force],
        needed: "`t_s` [s] and `position_m` [m]",
        check: &|_| None,
    };
    let samples = Text::new(reader, file, layout).samples(&request)?;
    let width = samples
        .is_there
        .iter()
        .filter(|is_there| **is_there)
        .count();
    let column = |at: usize| {
        samples
            .numbers
            .iter()
            .skip(at)
            .step_by(width)
            .copied()
            .collect()
    };
    Ok(HeldTrace {
        trace: Trace {
            position_m: column(0),
            t_s: samples.t_s,
        },
        force_on_device_n: samples.is_there[1].then(|| column(1)),
        notes: samples.notes,
    })
}

/// A field as an error repeats it: its first line, and not too much of that.
fn shortened(text: &str) -> String {
    let line = text.lines().next().unwrap_or_default();
    let mut short: String = line.chars().take(LONGEST_FIELD).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    short
}
