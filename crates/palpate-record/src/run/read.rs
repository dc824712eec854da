//! Reader of run files.

use std::io::{self, Read};
use std::ops::Range;

use csv::StringRecord;
use thiserror::Error;

use super::{MARK, VERSION, metadata};
use crate::files::bounded::TABLE;

use crate::place::{TextPosition, field_span, first_byte, open_quote, record_span};

/// Reason why a run file could not be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RunError {
    /// The bytes cannot be read.
    #[error("{file}: cannot be read: {source}")]
    Unreadable {
        /// Name given by the caller.
        file: String,
        /// Error of the system.
        source: io::Error,
    },
    /// The text is not a run file, or lacks the requested data.
    #[error("{place}: {fault}")]
    Invalid {
        /// Position of the fault.
        place: Box<TextPosition>,
        /// The fault, and the allowed values.
        fault: RunFault,
    },
}

impl RunError {
    /// Returns the position of the fault in the text; `None` without text.
    #[must_use]
    pub fn place(&self) -> Option<&TextPosition> {
        match self {
            Self::Unreadable { .. } => None,
            Self::Invalid { place, .. } => Some(place),
        }
    }
}

/// A fault in the text of a run file. Each message names the allowed values.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum RunFault {
    /// The bytes are not UTF-8.
    #[error("the byte 0x{byte:02X} is not UTF-8; a run file is UTF-8 text")]
    NotUtf8 {
        /// First invalid byte.
        byte: u8,
    },
    /// The header is not that of a run file.
    #[error(
        "not a run file; one begins with a header whose last column is named `{MARK}{VERSION}`"
    )]
    NotARun,
    /// The file has an unknown version.
    #[error("a run file of version {found}; this program reads version {VERSION}")]
    UnknownVersion {
        /// Text in place of the version.
        found: String,
    },
    /// The header names a column twice.
    #[error("the header names the column `{name}` twice; column names must be unique")]
    DuplicateColumn {
        /// The duplicate column.
        name: String,
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
    /// A quoted field has no end.
    #[error("the quote that opens here is not closed before the end of the file")]
    OpenQuote,
    /// The first row lacks the metadata.
    #[error("the first row has no metadata; removing or sorting rows loses it")]
    NoMetadata,
    /// The metadata in the first row are invalid.
    #[error("the metadata is not a JSON object of strings: {why} of the metadata")]
    NotMetadata {
        /// Description and position of the error.
        why: String,
    },
    /// A row after the first contains metadata.
    #[error("only the first row has metadata; in the others this field is empty")]
    StrayMetadata,
    /// The column does not exist.
    #[error("no column `{name}`; there are {}", listed(columns))]
    NoColumn {
        /// The requested column.
        name: String,
        /// The existing columns.
        columns: Vec<String>,
    },
    /// A field of a numeric column is not a number.
    #[error("`{text}` in column `{name}` is not a number")]
    NotANumber {
        /// The field's column.
        name: String,
        /// The field.
        text: String,
    },
}

fn listed(names: &[String]) -> String {
    if names.is_empty() {
        return "none".to_owned();
    }
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    quoted.join(", ")
}

/// A run file that was read.
#[derive(Debug, Clone)]
pub struct Run {
    file: String,
    source: String,
    metadata: Vec<(String, String)>,
    header_start: usize,
    columns: Vec<String>,
    rows: Vec<Row>,
}

#[derive(Debug, Clone)]
struct Row {
    start: usize,
    fields: StringRecord,
}

/// Reads a run file; `file` is its name in errors.
///
/// # Errors
///
/// [`RunError`] if the bytes cannot be read or the text is not a run file of this version.
pub fn read(mut reader: impl Read, file: &str) -> Result<Run, RunError> {
    let file = file.to_owned();
    let mut bytes = Vec::new();
    if let Err(source) = TABLE.reader(&mut reader).read_to_end(&mut bytes) {
        return Err(RunError::Unreadable { file, source });
    }
    match String::from_utf8(bytes) {
        Ok(source) => Run::parse(file, source),
        Err(error) => {
            let at = error.utf8_error().valid_up_to();
            let bytes = error.into_bytes();
            let text = format!("{}\u{fffd}", String::from_utf8_lossy(&bytes[..at]));
            let fault = RunFault::NotUtf8 { byte: bytes[at] };
            Err(invalid(&file, &text, at..text.len(), fault))
        }
    }
}

fn invalid(file: &str, source: &str, span: Range<usize>, fault: RunFault) -> RunError {
    let place = Box::new(TextPosition::new(file, source, span));
    RunError::Invalid { place, fault }
}

impl Run {
    fn parse(file: String, source: String) -> Result<Self, RunError> {
        let fail = |span, fault| Err(invalid(&file, &source, span, fault));
        let at = if source.starts_with('\u{feff}') { 3 } else { 0 };
        let mut records = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .from_reader(&source.as_bytes()[at..])
            .into_records()
            .map_while(Result::ok); // Text in memory with any number of fields cannot fail.
        let Some(header) = records.next() else {
            return fail(at..at, RunFault::NotARun);
        };
        let header_start = skip_line_ends(&source, at + first_byte(&header));
        if let Some(at) = open_quote(&source, header_start, b',') {
            return fail(at..at + 1, RunFault::OpenQuote);
        }
        let mut columns: Vec<String> = header.iter().map(|name| name.trim().to_owned()).collect();
        let last = columns.len() - 1;
        let version = columns[last].strip_prefix(MARK).unwrap_or_default();
        if version != VERSION {
            let fault = if version.is_empty() {
                RunFault::NotARun
            } else {
                let found = version.to_owned();
                RunFault::UnknownVersion { found }
            };
            return fail(field_span(&source, header_start, last, b','), fault);
        }
        for (index, name) in columns.iter().enumerate() {
            if columns[..index].contains(name) {
                let span = field_span(&source, header_start, index, b',');
                return fail(span, RunFault::DuplicateColumn { name: name.clone() });
            }
        }
        columns.truncate(last);

        let mut metadata = Vec::new();
        let mut rows = Vec::new();
        for fields in records {
            let start = skip_line_ends(&source, at + first_byte(&fields));
            if let Some(at) = open_quote(&source, start, b',') {
                return fail(at..at + 1, RunFault::OpenQuote);
            }
            let (expected, found) = (header.len(), fields.len());
            if expected != found {
                let span = record_span(&source, start, b',');
                return fail(span, RunFault::FieldCount { expected, found });
            }
            let json = fields[last].trim();
            let outcome = match (rows.is_empty(), json.is_empty()) {
                (true, true) => Err(RunFault::NoMetadata),
                (true, false) => metadata::from_json(json).map_err(|error| {
                    let why = error.to_string();
                    RunFault::NotMetadata { why }
                }),
                (false, true) => Ok(metadata),
                (false, false) => Err(RunFault::StrayMetadata),
            };
            metadata = match outcome {
                Ok(metadata) => metadata,
                Err(fault) => return fail(field_span(&source, start, last, b','), fault),
            };
            rows.push(Row { start, fields });
        }
        Ok(Self {
            file,
            source,
            metadata,
            header_start,
            columns,
            rows,
        })
    }

    /// Returns the configuration of the run, in the order of the file.
    #[must_use]
    pub fn metadata(&self) -> &[(String, String)] {
        &self.metadata
    }

    /// Returns the names of the columns, in the order of the file.
    #[must_use]
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// Returns the number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Returns whether there are no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Returns the column `name` as numbers, NaN for an empty field.
    ///
    /// # Errors
    ///
    /// [`RunFault::NoColumn`] if the column does not exist, [`RunFault::NotANumber`] at the first field that is not a
    /// number.
    pub fn numbers(&self, name: &str) -> Result<Vec<f64>, RunError> {
        let at = self.column(name)?;
        let number = |row: &Row| {
            let text = row.fields[at].trim();
            if text.is_empty() {
                return Ok(f64::NAN);
            }
            text.parse().map_err(|_| {
                let fault = RunFault::NotANumber {
                    name: name.to_owned(),
                    text: text.to_owned(),
                };
                self.invalid(field_span(&self.source, row.start, at, b','), fault)
            })
        };
        self.rows.iter().map(number).collect()
    }

    /// Returns the column `name` as in the file.
    ///
    /// # Errors
    ///
    /// [`RunFault::NoColumn`] if the column does not exist.
    pub fn texts(&self, name: &str) -> Result<Vec<&str>, RunError> {
        let at = self.column(name)?;
        Ok(self.rows.iter().map(|row| &row.fields[at]).collect())
    }

    fn column(&self, name: &str) -> Result<usize, RunError> {
        let found = self.columns.iter().position(|column| column == name);
        found.ok_or_else(|| {
            let fault = RunFault::NoColumn {
                name: name.to_owned(),
                columns: self.columns.clone(),
            };
            self.invalid(record_span(&self.source, self.header_start, b','), fault)
        })
    }

    fn invalid(&self, span: Range<usize>, fault: RunFault) -> RunError {
        invalid(&self.file, &self.source, span, fault)
    }
}

/// Skips empty lines from `start`, which the CSV reader attributes to the next record.
fn skip_line_ends(source: &str, start: usize) -> usize {
    let rest = &source[start..];
    start + rest.len() - rest.trim_start_matches(['\n', '\r']).len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Run, RunError> {
        read(text.as_bytes(), "run.csv")
    }

    fn message(text: &str) -> String {
        parse(text).unwrap_err().to_string()
    }

    #[test]
    fn a_quote_that_nothing_closes_is_shown_where_it_opens() {
        assert_eq!(
            message("x,palpate_run_1\n1,\"{}\"\n\"2,\n3,\n"),
            "run.csv:3:1: the quote that opens here is not closed before the end of the file"
        );
    }

    #[test]
    fn crlf_empty_lines_and_a_byte_order_mark_are_accepted() {
        let text = "\u{feff}x, palpate_run_1\r\n1,\"{\"\"a\"\": \"\"\"\"}\"\r\n\r\n2, \r\n";
        let run = parse(text).unwrap();
        assert_eq!(run.metadata(), [("a".to_owned(), String::new())]);
        assert_eq!(run.columns(), ["x"]);
        assert_eq!(run.numbers("x").unwrap(), [1.0, 2.0]);
    }

    #[test]
    fn a_header_without_rows_is_an_empty_run() {
        let run = parse("x,palpate_run_1\n").unwrap();
        assert!(run.is_empty() && run.metadata().is_empty());
        assert!(run.numbers("x").unwrap().is_empty());
    }

    #[test]
    fn other_files_are_refused() {
        for (text, place) in [
            ("", "1:1"),
            ("\n\n", "1:1"),
            ("t_s,position_m\n0,1\n", "1:5"),
            ("t_s,palpate_run_\n0,{}\n", "1:5"),
            ("palpate_run_1,t_s\n{},0\n", "1:15"),
        ] {
            assert_eq!(
                message(text),
                format!(
                    "run.csv:{place}: not a run file; one begins with a header whose last column \
                     is named `palpate_run_1`"
                )
            );
        }
    }

    #[test]
    fn other_versions_are_refused() {
        assert_eq!(
            message("x,palpate_run_2\n1,{}\n"),
            "run.csv:1:3: a run file of version 2; this program reads version 1"
        );
        let error = parse("\n\u{b5},\"palpate_run_1.5\"\n1,{}\n").unwrap_err();
        assert_eq!(
            error.to_string(),
            "run.csv:2:3: a run file of version 1.5; this program reads version 1"
        );
        let place = error.place().unwrap();
        assert_eq!(&place.text()[place.span()], "\"palpate_run_1.5\"");
    }

    #[test]
    fn a_column_that_stands_twice_is_refused() {
        assert_eq!(
            message("x,y,x,palpate_run_1\n"),
            "run.csv:1:5: the header names the column `x` twice; column names must be unique"
        );
        assert_eq!(
            message("palpate_run_1,palpate_run_1\n"),
            "run.csv:1:15: the header names the column `palpate_run_1` twice; column names \
             must be unique"
        );
    }

    #[test]
    fn each_line_has_one_field_per_column() {
        assert_eq!(
            message("x,y,palpate_run_1\n1,2,{}\n\n3,4\n"),
            "run.csv:4:1: the line has 2 fields, the header 3; each line has one field per column"
        );
    }

    #[test]
    fn metadata_other_than_object_of_strings_is_rejected() {
        for (json, why) in [
            ("hfcr", "expected value at line 1 column 1"),
            (
                "[]",
                "invalid type: sequence, expected an object at line 1 column 0",
            ),
            (
                "{\"a\":1}",
                "invalid type: integer `1`, expected a string at line 1 column 6",
            ),
            ("{\"a\":\"b\"} c", "trailing characters at line 1 column 11"),
            (
                "{\"a\":\"b\"",
                "EOF while parsing an object at line 1 column 8",
            ),
            (
                "{\"a\":\"\",\"a\":\"\"}",
                "the key `a` is empty or duplicate at line 1 column 11",
            ),
        ] {
            let field = format!("\"{}\"", json.replace('"', "\"\""));
            let error = parse(&format!("x,palpate_run_1\n1,{field}\n2,\n")).unwrap_err();
            assert_eq!(
                error.to_string(),
                format!(
                    "run.csv:2:3: the metadata is not a JSON object of strings: {why} of the metadata"
                )
            );
            let place = error.place().unwrap();
            assert_eq!(place.text()[place.span()], field);
        }
    }

    #[test]
    fn metadata_is_only_in_first_row() {
        assert_eq!(
            message("x,palpate_run_1\n1,\n2,{}\n"),
            "run.csv:2:3: the first row has no metadata; removing or sorting rows loses it"
        );
        assert_eq!(
            message("x,palpate_run_1\n1,{}\n2,{}\n"),
            "run.csv:3:3: only the first row has metadata; in the others this field is empty"
        );
    }

    #[test]
    fn a_column_that_is_not_there_is_reported_with_those_that_are() {
        let run = parse("\nt_s,force_n,palpate_run_1\n").unwrap();
        for name in ["force", "palpate_run_1"] {
            let message = format!("run.csv:2:1: no column `{name}`; there are `t_s`, `force_n`");
            assert_eq!(run.numbers(name).unwrap_err().to_string(), message);
            assert_eq!(run.texts(name).unwrap_err().to_string(), message);
        }
        assert_eq!(
            parse("palpate_run_1\n")
                .unwrap()
                .texts("x")
                .unwrap_err()
                .to_string(),
            "run.csv:1:1: no column `x`; there are none"
        );
    }

    #[test]
    fn a_word_in_a_column_of_numbers_is_reported() {
        let run = parse("t_s,x,palpate_run_1\n0,1,{}\n\n1,\"fast\",\n").unwrap();
        let error = run.numbers("x").unwrap_err();
        assert_eq!(
            error.to_string(),
            "run.csv:4:3: `fast` in column `x` is not a number"
        );
        let place = error.place().unwrap();
        assert_eq!(&place.text()[place.span()], "\"fast\"");
    }

    #[test]
    fn other_encodings_are_named_by_their_byte() {
        let error = read(&b"x,palpate_run_1\n1,\xb5\n"[..], "run.csv").unwrap_err();
        assert_eq!(
            error.to_string(),
            "run.csv:2:3: the byte 0xB5 is not UTF-8; a run file is UTF-8 text"
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
        let error = read(Broken, "run.csv").unwrap_err();
        assert_eq!(
            error.to_string(),
            "run.csv: cannot be read: the cable came off"
        );
        assert!(error.place().is_none());
    }

    proptest::proptest! {
        #[test]
        fn no_bytes_make_the_reader_panic(bytes: Vec<u8>) {
            let _ = read(&bytes[..], "any");
            let _ = read(&[b"x,palpate_run_1\n", &bytes[..]].concat()[..], "any");
        }

        #[test]
        fn no_text_of_csv_characters_makes_the_reader_panic(
            head in "[x, \"\r\n\u{feff}]{0,8}",
            tail in "[0-9{}:,\"\\\\\r\n µ-]{0,80}",
        ) {
            if let Ok(run) = parse(&format!("{head},palpate_run_1\n{tail}")) {
                for name in run.columns() {
                    let _ = (run.numbers(name), run.texts(name));
                }
            }
        }
    }
}
