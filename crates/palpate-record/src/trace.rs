//! Recorded traces: positions of a device over time.
//!
//! A trace is UTF-8 text with columns separated by commas, semicolons or tabs. Its header must name `t_s` and
//! `position_m`, in any order, unless a [`Layout`] selects the columns; other columns are ignored. The line after the
//! header may contain the units. Lines that begin with `#` and empty lines are skipped. Line ends may be `\n` or
//! `\r\n`, and a byte order mark at the start is accepted, because spreadsheets write both. The motion of the devices
//! of a world is a table of the same kind, read by [`read_world`].
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
mod prescribed_motion;
mod table;
#[cfg(test)]
mod tests;

pub use fault::{TraceError, TraceFault};
pub use layout::{Delimiter, Layout, Way, Ways};
pub use prescribed_motion::{LedDevice, WorldTrace, read_world};

use std::io::Read;

use columns::{Kind, Wanted};
use table::{Request, Text};

const FORCE: &str = "force_on_device_n";
const VIRTUAL_FORCE: &str = "virtual_force_n";

/// Maximum number of characters of a field in an error.
const LONGEST_FIELD: usize = 40;

/// A recorded motion along one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// Time of each sample, strictly increasing `[s]`.
    pub t_s: Vec<f64>,
    /// Position at each sample `[m]`.
    pub position_m: Vec<f64>,
}

/// Selection of the samples of a trace.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// Start time `[s]`; earlier samples are skipped.
    pub from: f64,
    /// End time `[s]`; later samples are not read.
    pub to: f64,
    /// Longest time from the first sample to the last `[s]`. A longer trace is rejected as soon as it exceeds this
    /// time.
    pub longest: f64,
}

impl Part {
    /// Selects all samples.
    pub const WHOLE: Self = Self {
        from: f64::NEG_INFINITY,
        to: f64::INFINITY,
        longest: f64::INFINITY,
    };
}

/// A trace with forces from each sample until the next.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldTrace {
    /// The motion.
    pub trace: Trace,
    /// Force on the device from each sample until the next `[N]`, from the column `force_on_device_n`; `None` without
    /// that column.
    pub force_on_device_n: Option<Vec<f64>>,
    /// Virtual force on the object from each sample until the next `[N]`, from the column `virtual_force_n`; `None`
    /// without that column.
    pub virtual_force_n: Option<Vec<f64>>,
    /// Notes on the text.
    pub notes: ReadNotes,
}

/// Notes on a text that was read.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct ReadNotes {
    /// Number of samples that were skipped because they lack a value.
    pub left_out: usize,
    /// Last number, if the last line has no line end. It may be incomplete, so its sample is left out.
    pub unended: Option<String>,
}

/// Reads a trace with the default layout; `file` is its name in errors.
///
/// # Errors
///
/// [`TraceError`] if the bytes cannot be read or the text is not a trace. This includes a last line without a line
/// end, whose last number may be incomplete.
pub fn read(reader: impl Read, file: &str) -> Result<Trace, TraceError> {
    let read = read_part(reader, file, &Part::WHOLE, &Layout::default());
    read.map(|held| held.trace)
}

/// Reads a part of a trace, and no further than its end; `file` is its name in errors.
///
/// # Errors
///
/// [`TraceError`] if the bytes cannot be read, the text is not a trace of this layout, or the part has fewer than two
/// samples or is too long. A column whose name contains another unit does not count as a position.
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
    let force = |key: &str, name: &str| Wanted {
        bare: vec![name.to_owned()],
        is_needed: false,
        ..wanted(Kind::Force, key, "", name)
    };
    let forces = [force("force", FORCE), force("virtual_force", VIRTUAL_FORCE)];
    let request = Request {
        part,
        layout,
        wanted: &[[position].as_slice(), &forces].concat(),
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
        virtual_force_n: samples.is_there[2].then(|| column(width - 1)),
        notes: samples.notes,
    })
}

/// Shortens a field for an error: its first line, up to a maximum length.
fn shortened(text: &str) -> String {
    let line = text.lines().next().unwrap_or_default();
    let mut short: String = line.chars().take(LONGEST_FIELD).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    short
}
