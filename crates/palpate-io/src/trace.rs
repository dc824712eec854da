//! Recorded traces: where a device was, and when.
//!
//! A trace is UTF-8 text with comma-separated columns. Its header must name `t_s` and
//! `position_m`, in any order; other columns are allowed and ignored. In place of `position_m` may
//! stand `position_cm`, `position_mm` or `position_um`. Lines that begin with `#`
//! and empty lines are skipped. Line ends may be `\n` or `\r\n`, and a byte order mark at the
//! start is accepted, since spreadsheets write both.
//!
//! ```
//! let text = "# a hand at rest\nt_s,position_m\n0,0.01\n0.001,0.01\n";
//! let trace = palpate_io::trace::read(text.as_bytes(), "rest.csv")?;
//! assert_eq!(trace.t_s, [0.0, 0.001]);
//! # Ok::<(), palpate_io::trace::TraceError>(())
//! ```

use std::io::{self, Read};

use csv::StringRecord;
use thiserror::Error;

use crate::place::{Place, field_span, first_byte, record_span};
use crate::unit::LengthUnit;

const TIME: &str = "t_s";
const POSITION: &str = "position_m";

/// A recorded motion along one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// Time of each sample, strictly increasing \[s\].
    pub t_s: Vec<f64>,
    /// Position at each sample \[m\].
    pub position_m: Vec<f64>,
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
        place: Box<Place>,
        /// What is wrong, and what is allowed.
        fault: TraceFault,
    },
}

impl TraceError {
    /// Where in the text the fault stands; none where there was no text to read.
    #[must_use]
    pub fn place(&self) -> Option<&Place> {
        match self {
            Self::Unreadable { .. } => None,
            Self::Invalid { place, .. } => Some(place),
        }
    }
}

/// What is wrong with the text of a trace. Each message also says what is allowed.
#[derive(Debug, Clone, PartialEq, Error)]
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
        /// Time of the sample before \[s\].
        before: f64,
        /// Time of this sample \[s\].
        now: f64,
    },
    /// There is no motion in fewer than two samples.
    #[error("a trace needs at least 2 samples, this one has {found}")]
    TooFewSamples {
        /// How many there are.
        found: usize,
    },
}

/// Reads a trace; `file` is the name errors call it by.
///
/// # Errors
///
/// [`TraceError`] where the bytes cannot be read or the text is not a trace.
pub fn read(reader: impl Read, file: &str) -> Result<Trace, TraceError> {
    read_in(reader, file, None)
}

/// As [`read`], where the positions are in `unit`, also in a column called `position_m`; none: in the
/// unit that the column's name has.
///
/// # Errors
///
/// As [`read`]; a column that is called by another unit is no position.
pub fn read_in(
    mut reader: impl Read,
    file: &str,
    unit: Option<LengthUnit>,
) -> Result<Trace, TraceError> {
    let mut bytes = Vec::new();
    if let Err(source) = reader.read_to_end(&mut bytes) {
        let file = file.to_owned();
        return Err(TraceError::Unreadable { file, source });
    }
    match std::str::from_utf8(&bytes) {
        Ok(source) => Text { file, source }.trace(unit),
        Err(error) => {
            let at = error.valid_up_to();
            let valid = String::from_utf8_lossy(&bytes[..at]);
            let text = format!("{valid}\u{fffd}");
            let fault = TraceFault::NotUtf8 { byte: bytes[at] };
            Err(Text {
                file,
                source: &text,
            }
            .fault(at..text.len(), fault))
        }
    }
}

/// The whole text of a trace and its name.
struct Text<'a> {
    file: &'a str,
    source: &'a str,
}

/// One record and the offset of its first byte.
struct Line {
    start: usize,
    fields: StringRecord,
}

impl Text<'_> {
    fn fault(&self, span: std::ops::Range<usize>, fault: TraceFault) -> TraceError {
        let place = Box::new(Place::new(self.file, self.source, span));
        TraceError::Invalid { place, fault }
    }

    fn trace(&self, unit: Option<LengthUnit>) -> Result<Trace, TraceError> {
        let body = self.source.strip_prefix('\u{feff}').unwrap_or(self.source);
        let offset = self.source.len() - body.len();
        let mut records = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
            .from_reader(body.as_bytes())
            .into_records()
            .map_while(Result::ok) // text in memory, of any field count: nothing is left to fail
            .map(|fields| Line {
                start: skip_to_record(self.source, offset + first_byte(&fields)),
                fields,
            });

        let Some(header) = records.next() else {
            return Err(self.fault(self.source.len()..self.source.len(), TraceFault::Empty));
        };
        let time = self.column(&header, TIME)?;
        let (name, unit) = position_column(&header, unit);
        let position = self.column(&header, name)?;

        let mut trace = Trace {
            t_s: Vec::new(),
            position_m: Vec::new(),
        };
        for line in records {
            let (expected, found) = (header.fields.len(), line.fields.len());
            if expected != found {
                let span = record_span(self.source, line.start);
                return Err(self.fault(span, TraceFault::FieldCount { expected, found }));
            }
            let now = self.number(&line, time, TIME)?;
            if let Some(&before) = trace.t_s.last()
                && now <= before
            {
                let span = field_span(self.source, line.start, time);
                return Err(self.fault(span, TraceFault::TimeNotIncreasing { before, now }));
            }
            trace.t_s.push(now);
            let place = self.number(&line, position, name)?;
            trace.position_m.push(unit.metres(place));
        }
        let found = trace.t_s.len();
        if found < 2 {
            let end = self.source.trim_end().len();
            return Err(self.fault(end..end, TraceFault::TooFewSamples { found }));
        }
        Ok(trace)
    }

    fn column(&self, header: &Line, name: &'static str) -> Result<usize, TraceError> {
        let mut found = (0..header.fields.len()).filter(|&at| header.fields[at].trim() == name);
        match (found.next(), found.next()) {
            (Some(at), None) => Ok(at),
            (Some(_), Some(again)) => {
                let span = field_span(self.source, header.start, again);
                Err(self.fault(span, TraceFault::DuplicateColumn { name }))
            }
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
                let span = nearest.map_or_else(
                    || record_span(self.source, header.start),
                    |(_, at, _)| field_span(self.source, header.start, at),
                );
                let nearest = nearest.map(|(_, _, field)| field.to_owned());
                Err(self.fault(span, TraceFault::MissingColumn { name, nearest }))
            }
        }
    }

    fn number(&self, line: &Line, at: usize, name: &'static str) -> Result<f64, TraceError> {
        let text = line.fields[at].trim();
        let fault = match text.parse::<f64>() {
            Ok(value) if value.is_finite() => return Ok(value),
            Ok(_) => TraceFault::NotFinite {
                name,
                text: text.to_owned(),
            },
            Err(_) => TraceFault::NotANumber {
                name,
                text: text.to_owned(),
            },
        };
        Err(self.fault(field_span(self.source, line.start, at), fault))
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

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Trace, TraceError> {
        read(text.as_bytes(), "hand.csv")
    }

    fn message(text: &str) -> String {
        parse(text).unwrap_err().to_string()
    }

    #[test]
    fn the_two_columns_are_read_in_any_order_beside_others() {
        let trace = parse("note,position_m,t_s\na,0.5,0\nb,-1e-3,0.001\n").unwrap();
        assert_eq!(trace.t_s, [0.0, 0.001]);
        assert_eq!(trace.position_m, [0.5, -1e-3]);
    }

    #[test]
    fn positions_come_in_the_unit_of_their_column_or_in_the_one_that_is_said() {
        let in_unit = |text: &str, unit| read_in(text.as_bytes(), "hand.csv", unit);
        let millimetres = Some(LengthUnit::Millimetre);
        for (header, unit) in [
            ("position_mm", None),
            ("position_mm", millimetres),
            ("position_m", millimetres),
        ] {
            let trace = in_unit(&format!("t_s,{header}\n0,12\n1,-3\n"), unit).unwrap();
            assert_eq!(trace.position_m, [0.012, -0.003], "{header}");
        }
        let both = "t_s,position_mm,position_m\n0,12,5\n1,-3,6\n";
        assert_eq!(in_unit(both, None).unwrap().position_m, [5.0, 6.0]);
        assert_eq!(in_unit(both, millimetres).unwrap().position_m[0], 0.012);
        let error = in_unit("t_s,position_cm\n0,12\n1,-3\n", millimetres).unwrap_err();
        assert!(
            error.to_string().contains("no column `position_m`"),
            "{error}"
        );
    }

    #[test]
    fn comments_blank_lines_crlf_and_a_byte_order_mark_are_accepted() {
        let text = "\u{feff}# device 3\r\n\r\n t_s , position_m \r\n0,1\r\n# pause\r\n\r\n1, 2\r\n";
        let trace = parse(text).unwrap();
        assert_eq!(trace.t_s, [0.0, 1.0]);
        assert_eq!(trace.position_m, [1.0, 2.0]);
    }

    #[test]
    fn a_missing_last_line_end_is_no_fault() {
        assert_eq!(parse("t_s,position_m\n0,1\n1,2").unwrap().t_s.len(), 2);
    }

    #[test]
    fn quoted_fields_are_read() {
        let trace = parse("t_s,note,position_m\n\"0\",\"a,b\",\"1\"\n1,,2\n").unwrap();
        assert_eq!(trace.position_m, [1.0, 2.0]);
    }

    #[test]
    fn a_missing_column_names_the_nearest() {
        assert_eq!(
            message("# x\nposition_m,time_s\n0,1\n"),
            "hand.csv:2:12: the header has no column `t_s`, the nearest is `time_s`; needed are \
             `t_s` [s] and `position_m` [m], separated by commas, in any order"
        );
        assert_eq!(
            message("t_s,posiiton_m\n0,1\n"),
            "hand.csv:1:5: the header has no column `position_m`, the nearest is `posiiton_m`; \
             needed are `t_s` [s] and `position_m` [m], separated by commas, in any order"
        );
    }

    #[test]
    fn a_header_that_is_nothing_like_it_is_marked_whole() {
        let error = parse("0,1\n2,3\n").unwrap_err();
        let place = error.place().unwrap();
        assert_eq!(&place.text()[place.span()], "0,1");
        assert_eq!(
            error.to_string(),
            "hand.csv:1:1: the header has no column `t_s`; needed are `t_s` [s] and `position_m` \
             [m], separated by commas, in any order"
        );
    }

    #[test]
    fn a_column_that_stands_twice_is_refused() {
        assert_eq!(
            message("t_s,position_m,t_s\n0,1,0\n"),
            "hand.csv:1:16: the header names the column `t_s` twice; one is needed"
        );
    }

    #[test]
    fn a_word_is_not_a_number() {
        let error = parse("# one\n\nt_s,position_m\n0,1\n\n# two\n0.5, fast\n").unwrap_err();
        assert_eq!(
            error.to_string(),
            "hand.csv:7:6: `fast` in column `position_m` is not a number; allowed are decimals \
             such as 0.001 or 1e-3"
        );
        let place = error.place().unwrap();
        assert_eq!(&place.text()[place.span()], "fast");
    }

    #[test]
    fn an_empty_field_is_not_a_number() {
        assert_eq!(
            message("t_s,position_m\n0,\n"),
            "hand.csv:2:3: `` in column `position_m` is not a number; allowed are decimals such \
             as 0.001 or 1e-3"
        );
    }

    #[test]
    fn nan_and_infinity_are_refused() {
        for text in ["NaN", "inf", "-inf", "1e999"] {
            assert_eq!(
                message(&format!("t_s,position_m\n0,{text}\n")),
                format!(
                    "hand.csv:2:3: `{text}` in column `position_m` is not finite; every sample \
                     needs a finite value"
                )
            );
        }
    }

    #[test]
    fn time_must_increase() {
        assert_eq!(
            message("t_s,position_m\n0,1\n0.002,1\n0.002,1\n"),
            "hand.csv:4:1: the time 0.002 s does not come after 0.002 s; times must increase from \
             line to line"
        );
        assert_eq!(
            message("t_s,position_m\r\n0.5,1\r\n0.25,1\r\n"),
            "hand.csv:3:1: the time 0.25 s does not come after 0.5 s; times must increase from \
             line to line"
        );
    }

    #[test]
    fn fewer_than_two_samples_are_no_trace() {
        assert_eq!(
            message("t_s,position_m\n"),
            "hand.csv:1:15: a trace needs at least 2 samples, this one has 0"
        );
        assert_eq!(
            message("t_s,position_m\n0,1\n"),
            "hand.csv:2:4: a trace needs at least 2 samples, this one has 1"
        );
    }

    #[test]
    fn each_line_has_one_field_per_column() {
        let error = parse("t_s,position_m\n0,1\n0,5,1\n").unwrap_err();
        assert_eq!(
            error.to_string(),
            "hand.csv:3:1: the line has 3 fields, the header 2; each line has one field per column"
        );
        let place = error.place().unwrap();
        assert_eq!(&place.text()[place.span()], "0,5,1");
    }

    #[test]
    fn an_empty_file_is_no_trace() {
        for text in ["", "\n\n", "# nothing\n", "\u{feff}"] {
            let error = message(text);
            assert!(
                error.ends_with(
                    "the file is empty; a trace begins with a header that names `t_s` and \
                     `position_m`"
                ),
                "{error}"
            );
        }
        assert!(message("").starts_with("hand.csv:1:1: "));
    }

    #[test]
    fn other_encodings_are_named_by_their_byte() {
        let error = read(&b"t_s,position_m\n0,1 \xb5m\n"[..], "hand.csv").unwrap_err();
        assert_eq!(
            error.to_string(),
            "hand.csv:2:5: the byte 0xB5 is not UTF-8; save the trace as UTF-8 text"
        );
        assert_eq!(error.place().unwrap().span().start, 19);
        let utf16 = read(&b"\xff\xfet\0_\0s\0"[..], "hand.csv").unwrap_err();
        assert_eq!(
            utf16.to_string(),
            "hand.csv:1:1: the byte 0xFF is not UTF-8; save the trace as UTF-8 text"
        );
    }

    #[test]
    fn a_reader_that_fails_is_reported_by_name() {
        struct Broken;
        impl Read for Broken {
            fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
                Err(io::Error::other("the cable came off"))
            }
        }
        let error = read(Broken, "hand.csv").unwrap_err();
        assert_eq!(
            error.to_string(),
            "hand.csv: cannot be read: the cable came off"
        );
        assert!(error.place().is_none());
    }

    proptest::proptest! {
        #[test]
        fn no_bytes_make_the_reader_panic(bytes: Vec<u8>) {
            let _ = read(&bytes[..], "any");
        }

        #[test]
        fn no_text_of_csv_characters_makes_the_reader_panic(
            tail in "[t_s,position_m0-9.\"#\r\n µ;-]{0,80}",
        ) {
            let _ = parse(&format!("t_s,position_m\n{tail}"));
        }
    }
}
