//! Recorded traces: where a device was, and when.
//!
//! A trace is UTF-8 text with comma-separated columns. Its header must name `t_s` and
//! `position_m`, in any order; other columns are allowed and ignored. Lines that begin with `#`
//! and empty lines are skipped. Line ends may be `\n` or `\r\n`, and a byte order mark at the
//! start is accepted, since spreadsheets write both.
//!
//! ```
//! let text = "# a hand at rest\nt_s,position_m\n0,0.01\n0.001,0.01\n";
//! let trace = palpate_record::trace::read(text.as_bytes(), "rest.csv")?;
//! assert_eq!(trace.t_s, [0.0, 0.001]);
//! # Ok::<(), palpate_record::trace::TraceError>(())
//! ```

mod growing;
mod led;

pub use led::{WorldTrace, WorldTraceError, read_world};
#[cfg(test)]
mod tests;

use std::io::{self, Read};

use csv::StringRecord;
use palpate_files::bounded::{Bounded, TABLE};
use thiserror::Error;

use crate::place::{TextPosition, field_span, first_byte, open_quote, record_span};
use crate::unit::LengthUnit;
use growing::{Growing, Unread};

const TIME: &str = "t_s";
const POSITION: &str = "position_m";
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
}

/// Why a trace could not be read.
#[derive(Debug, Error)]
pub enum TraceError {
    /// The bytes could not be had.
    #[error("{file}: cannot be read: {source}")]
    Unreadable {
        /// The name the caller gave.
        file: String,
        /// What the system said.
        source: io::Error,
    },
    /// The text is not a trace.
    #[error("{place}: {fault}")]
    Invalid {
        /// Where the fault stands.
        place: Box<TextPosition>,
        /// What is wrong, and what is allowed.
        fault: TraceFault,
    },
}

impl TraceError {
    /// Where in the text the fault stands; none where there was no text to read.
    #[must_use]
    pub fn place(&self) -> Option<&TextPosition> {
        match self {
            Self::Unreadable { .. } => None,
            Self::Invalid { place, .. } => Some(place),
        }
    }
}

/// What is wrong with the text of a trace. Each message also says what is allowed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum TraceFault {
    /// There is no header.
    #[error("the file is empty; a trace begins with a header that names `t_s` and `position_m`")]
    Empty,
    /// The bytes are not UTF-8.
    #[error("the byte 0x{byte:02X} is not UTF-8; save the trace as UTF-8 text")]
    NotUtf8 {
        /// The first byte that does not fit.
        byte: u8,
    },
    /// The header lacks a column.
    #[error(
        "the header has no column `{name}`{}; needed are `t_s` [s] and `position_m` [m], \
         separated by commas, in any order",
        nearest.as_ref().map(|found| format!(", the nearest is `{found}`")).unwrap_or_default()
    )]
    MissingColumn {
        /// The column that is missing.
        name: &'static str,
        /// The column of the header whose name is most like it.
        nearest: Option<String>,
    },
    /// The header names a column twice.
    #[error("the header names the column `{name}` twice; one is needed")]
    DuplicateColumn {
        /// The column that stands twice.
        name: &'static str,
    },
    /// A line has more or fewer fields than the header.
    #[error(
        "the line has {found} fields, the header {expected}; each line has one field per column"
    )]
    FieldCount {
        /// Fields of the header.
        expected: usize,
        /// Fields of the line.
        found: usize,
    },
    /// A field is not a number.
    #[error(
        "`{text}` in column `{name}` is not a number; allowed are decimals such as 0.001 or 1e-3"
    )]
    NotANumber {
        /// The field's column.
        name: &'static str,
        /// The field.
        text: String,
    },
    /// A field is infinite or not a number.
    #[error("`{text}` in column `{name}` is not finite; every sample needs a finite value")]
    NotFinite {
        /// The field's column.
        name: &'static str,
        /// The field.
        text: String,
    },
    /// Time stands still or runs backwards.
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
        "`{text}` in column `{FORCE}` is not a finite number; the force [N] that was held on the \
         device from this sample on is needed, 0 where there was none"
    )]
    NotAForce {
        /// The field.
        text: String,
    },
    /// A quoted field has no end.
    #[error(
        "the quote that opens here is not closed before the end of the file; close the field with \
         `\"`, or remove the quote"
    )]
    OpenQuote,
    /// The trace is longer than was allowed.
    #[error("the trace goes on for more than {longest} s after its first sample at {first} s")]
    TooLong {
        /// The longest time that was allowed `[s]`.
        longest: f64,
        /// Time of the first sample that counts `[s]`.
        first: f64,
    },
    /// Fewer than two samples lie in the part that was asked for.
    #[error(
        "{found} of the 2 samples that are needed at least lie {}; the times of the trace begin at \
         {first} s{}",
        between(*from, *to),
        last.map_or_else(String::new, |last| format!(" and end at {last} s"))
    )]
    TooFewInPart {
        /// Beginning of the part `[s]`.
        from: f64,
        /// Its end `[s]`.
        to: f64,
        /// How many samples there are.
        found: usize,
        /// Time of the first sample of all `[s]`.
        first: f64,
        /// Time of the last `[s]`, if the trace was read to its end.
        last: Option<f64>,
    },
    /// There is no motion in fewer than two samples.
    #[error("a trace needs at least 2 samples, this one has {found}")]
    TooFewSamples {
        /// How many there are.
        found: usize,
    },
}

/// A span of time, in words.
fn between(from: f64, to: f64) -> String {
    match (from.is_finite(), to.is_finite()) {
        (true, true) => format!("from {from} s to {to} s"),
        (true, false) => format!("from {from} s on"),
        (false, true) => format!("up to {to} s"),
        (false, false) => "in it".to_owned(),
    }
}

/// Reads a trace; `file` is the name errors call it by.
///
/// # Errors
///
/// [`TraceError`] where the bytes cannot be read or the text is not a trace.
pub fn read(reader: impl Read, file: &str) -> Result<Trace, TraceError> {
    let mut text = Text::new(reader, file);
    text.trace(&Part::WHOLE, None, false).map(|held| held.trace)
}

/// Reads a part of a trace, and no further than its end; `file` is the name errors call it by.
/// Positions are in `unit`, also in a column called `position_m`; none: in the unit that the column's
/// name has.
///
/// # Errors
///
/// [`TraceError`] where the bytes cannot be read, the text is not a trace, or the part has fewer than
/// two samples or is too long. A column that is called by another unit is no position.
pub fn read_part(
    reader: impl Read,
    file: &str,
    part: &Part,
    unit: Option<LengthUnit>,
) -> Result<HeldTrace, TraceError> {
    Text::new(reader, file).trace(part, unit, true)
}

/// The text of a trace, as far as it has been read, and its name.
struct Text<'a, R: Read> {
    file: &'a str,
    records: csv::Reader<Growing<R>>,
    /// Offset of the first byte that was read for the last record.
    last: usize,
}

/// One record and the offset of the first byte that was read for it.
struct Line {
    from: usize,
    fields: StringRecord,
}

impl Line {
    fn new() -> Self {
        Self {
            from: 0,
            fields: StringRecord::new(),
        }
    }
}

/// A fault and the bytes at fault.
type Fault = (std::ops::Range<usize>, TraceFault);

impl<'a, R: Read> Text<'a, Bounded<R>> {
    fn new(reader: R, file: &'a str) -> Self {
        let records = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
            .from_reader(Growing::new(TABLE.reader(reader)));
        let last = 0;
        Self {
            file,
            records,
            last,
        }
    }

    fn source(&self) -> &str {
        self.records.get_ref().text()
    }

    fn fault(&mut self, (span, fault): Fault) -> TraceError {
        self.records.get_mut().read_past(span.end);
        let place = Box::new(TextPosition::new(self.file, self.source(), span));
        TraceError::Invalid { place, fault }
    }

    /// A fault of a line, unless the line is what it is because of a quote that has no end.
    fn fault_in(&mut self, line: &Line, fault: impl FnOnce(&str, usize) -> Fault) -> TraceError {
        let start = skip_to_record(self.source(), line.from);
        let found = match open_quote(self.source(), start) {
            Some(at) => (at..at + 1, TraceFault::OpenQuote),
            None => fault(self.source(), start),
        };
        self.fault(found)
    }

    /// The next record in `line`; whether there is one.
    fn next(&mut self, line: &mut Line) -> Result<bool, TraceError> {
        let read = self.records.read_record(&mut line.fields);
        let mark = self.records.get_ref().mark();
        line.from = mark + first_byte(&line.fields);
        match self.records.get_mut().take_fault() {
            Some(Unread::Io(source)) => {
                let file = self.file.to_owned();
                return Err(TraceError::Unreadable { file, source });
            }
            Some(Unread::NotUtf8(byte)) => {
                let text = format!("{}\u{fffd}", self.source());
                let span = self.source().len()..text.len();
                let place = Box::new(TextPosition::new(self.file, &text, span));
                let fault = TraceFault::NotUtf8 { byte };
                return Err(TraceError::Invalid { place, fault });
            }
            None => {}
        }
        // Text of any field count: nothing is left to fail.
        let is_there = read.unwrap_or(false);
        if is_there {
            self.last = line.from;
        }
        Ok(is_there)
    }

    fn trace(
        &mut self,
        part: &Part,
        unit: Option<LengthUnit>,
        with_force: bool,
    ) -> Result<HeldTrace, TraceError> {
        let mut header = Line::new();
        if !self.next(&mut header)? {
            let end = self.source().len();
            return Err(self.fault((end..end, TraceFault::Empty)));
        }
        let time = self.column(&header, TIME)?;
        let (name, unit) = position_column(&header, unit);
        let position = self.column(&header, name)?;
        let is_there = |name| header.fields.iter().any(|field| field.trim() == name);
        let force = (with_force && is_there(FORCE))
            .then(|| self.column(&header, FORCE))
            .transpose()?;

        let mut trace = Trace {
            t_s: Vec::new(),
            position_m: Vec::new(),
        };
        let mut forces = Vec::new();
        let (mut first, mut before) = (None, None);
        let mut is_read_to_its_end = true;
        let mut line = Line::new();
        while self.next(&mut line)? {
            let (expected, found) = (header.fields.len(), line.fields.len());
            if expected != found {
                return Err(self.fault_in(&line, |source, start| {
                    let fault = TraceFault::FieldCount { expected, found };
                    (record_span(source, start), fault)
                }));
            }
            let now = self.number(&line, time, TIME)?;
            if let Some(before) = before
                && now <= before
            {
                return Err(self.fault_in(&line, |source, start| {
                    let fault = TraceFault::TimeNotIncreasing { before, now };
                    (field_span(source, start, time), fault)
                }));
            }
            first = first.or(Some(now));
            if now > part.to {
                is_read_to_its_end = false;
                break;
            }
            before = Some(now);
            if now < part.from {
                continue;
            }
            let begin = trace.t_s.first().copied().unwrap_or(now);
            if now - begin > part.longest {
                return Err(self.fault_in(&line, |source, start| {
                    let fault = TraceFault::TooLong {
                        longest: part.longest,
                        first: begin,
                    };
                    (field_span(source, start, time), fault)
                }));
            }
            trace.t_s.push(now);
            let place = self.number(&line, position, name)?;
            trace.position_m.push(unit.metres(place));
            if let Some(force) = force {
                forces.push(self.number(&line, force, FORCE)?);
            }
        }
        if is_read_to_its_end {
            // Only the last record can have a quote that nothing closes.
            let start = skip_to_record(self.source(), self.last);
            if let Some(at) = open_quote(self.source(), start) {
                return Err(self.fault((at..at + 1, TraceFault::OpenQuote)));
            }
        }
        let found = trace.t_s.len();
        if found < 2 {
            let end = self.source().trim_end().len();
            let fault = match first {
                Some(first) if (part.from, part.to) != (Part::WHOLE.from, Part::WHOLE.to) => {
                    TraceFault::TooFewInPart {
                        from: part.from,
                        to: part.to,
                        found,
                        first,
                        last: before.filter(|_| is_read_to_its_end),
                    }
                }
                _ => TraceFault::TooFewSamples { found },
            };
            return Err(self.fault((end..end, fault)));
        }
        Ok(HeldTrace {
            trace,
            force_on_device_n: force.map(|_| forces),
        })
    }

    fn column(&mut self, header: &Line, name: &'static str) -> Result<usize, TraceError> {
        let mut found = (0..header.fields.len()).filter(|&at| header.fields[at].trim() == name);
        match (found.next(), found.next()) {
            (Some(at), None) => Ok(at),
            (Some(_), Some(again)) => Err(self.fault_in(header, |source, start| {
                let fault = TraceFault::DuplicateColumn { name };
                (field_span(source, start, again), fault)
            })),
            (None, _) => {
                let other = if name == TIME { POSITION } else { TIME };
                let nearest = header
                    .fields
                    .iter()
                    .enumerate()
                    .map(|(at, field)| (at, field.trim()))
                    .filter(|&(_, field)| field != other)
                    .map(|(at, field)| {
                        (
                            strsim::normalized_damerau_levenshtein(name, field),
                            at,
                            field,
                        )
                    })
                    .filter(|&(likeness, ..)| likeness >= 0.25)
                    .max_by(|a, b| a.0.total_cmp(&b.0));
                Err(self.fault_in(header, |source, start| {
                    let span = nearest.map_or_else(
                        || record_span(source, start),
                        |(_, at, _)| field_span(source, start, at),
                    );
                    let nearest = nearest.map(|(_, _, field)| field.to_owned());
                    (span, TraceFault::MissingColumn { name, nearest })
                }))
            }
        }
    }

    fn number(&mut self, line: &Line, at: usize, name: &'static str) -> Result<f64, TraceError> {
        let text = line.fields[at].trim();
        let parsed = text.parse::<f64>();
        if let Ok(value) = parsed
            && value.is_finite()
        {
            return Ok(value);
        }
        let text = shortened(text);
        let fault = match parsed {
            _ if name == FORCE => TraceFault::NotAForce { text },
            Ok(_) => TraceFault::NotFinite { name, text },
            Err(_) => TraceFault::NotANumber { name, text },
        };
        Err(self.fault_in(line, |source, start| (field_span(source, start, at), fault)))
    }
}

/// Name and unit of the column of positions: `position_m`, or the one that another unit calls so.
fn position_column(header: &Line, unit: Option<LengthUnit>) -> (&'static str, LengthUnit) {
    let is_there = |name: &str| header.fields.iter().any(|field| field.trim() == name);
    if let Some(unit) = unit {
        let own = unit.position_column();
        return (if is_there(own) { own } else { POSITION }, unit);
    }
    LengthUnit::ALL
        .into_iter()
        .find(|unit| is_there(unit.position_column()))
        .map_or((POSITION, LengthUnit::Metre), |unit| {
            (unit.position_column(), unit)
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

/// Moves on from `start` over comments and empty lines to the record itself.
fn skip_to_record(source: &str, mut start: usize) -> usize {
    while let Some(&byte) = source.as_bytes().get(start) {
        match byte {
            b'\n' | b'\r' => start += 1,
            b'#' => {
                start += source[start..]
                    .find('\n')
                    .map_or(source.len() - start, |at| at + 1)
            }
            _ => break,
        }
    }
    start
}
