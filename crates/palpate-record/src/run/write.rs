//! Writer of run files.

use std::io::{self, Write};

use thiserror::Error;

use super::{MARK, VERSION, metadata};

/// One field of a run file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Cell<'a> {
    /// A number in the unit of its column's name; NaN: missing.
    Number(f64),
    /// A word, such as a phase or the code of a fault.
    Text(&'a str),
}

impl From<f64> for Cell<'_> {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl<'a> From<&'a str> for Cell<'a> {
    fn from(text: &'a str) -> Self {
        Self::Text(text)
    }
}

/// Reason why a run file could not be written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RunWriteError {
    /// The output failed.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// A metadata key is empty or duplicate.
    #[error("the metadata key `{key}` is not allowed; keys must be non-empty and unique")]
    MetadataKey {
        /// The key.
        key: String,
    },
    /// The column names are invalid, duplicate, or in conflict with the format column that this crate adds.
    #[error(
        "the columns `{}` are not allowed; at least one is needed; names must be unique, have \
         no space around them, no line end and no byte order mark, and not begin with `{MARK}`",
        columns.join(",")
    )]
    Columns {
        /// Column names given by the caller.
        columns: Vec<String>,
    },
    /// A row has a wrong number of cells.
    #[error("the row has {found} cells, the header {expected} columns")]
    CellCount {
        /// Number of columns.
        expected: usize,
        /// Number of cells.
        found: usize,
    },
    /// There is no row for the metadata.
    #[error("the run has no row; at least one is needed, the first holds the metadata")]
    NoRow,
}

impl From<RunWriteError> for io::Error {
    fn from(error: RunWriteError) -> Self {
        match error {
            RunWriteError::Io(error) => error,
            other => io::Error::new(io::ErrorKind::InvalidInput, other),
        }
    }
}

impl From<csv::Error> for RunWriteError {
    fn from(error: csv::Error) -> Self {
        Self::Io(match error.into_kind() {
            csv::ErrorKind::Io(error) => error,
            csv::ErrorKind::UnequalLengths {
                expected_len, len, ..
            } => io::Error::other(format!(
                "a row has {len} fields where the rows before it have {expected_len}"
            )),
            _ => io::Error::other("a row cannot be written as CSV"),
        })
    }
}

/// Writer of a run file, row by row.
pub struct RunWriter<W: Write> {
    rows: csv::Writer<W>,
    columns: usize,
    /// `None` after it is written with the first row.
    metadata: Option<String>,
    digits: String,
}

impl<W: Write> RunWriter<W> {
    /// Writes the header: `columns`, then the format column. The metadata follow with the first row.
    ///
    /// # Errors
    ///
    /// [`RunWriteError`] if a key or a column is not allowed or `out` fails.
    pub fn new<K: AsRef<str>, V: AsRef<str>>(
        out: W,
        metadata: &[(K, V)],
        columns: &[&str],
    ) -> Result<Self, RunWriteError> {
        let plain = |name: &&str| {
            let free = !name.starts_with(MARK) && !name.contains(['\n', '\r', '\u{feff}']);
            free && !name.is_empty() && name.trim() == *name
        };
        let once = |(at, name): (usize, &&str)| !columns[..at].contains(name);
        if columns.is_empty() || !columns.iter().all(plain) || !columns.iter().enumerate().all(once)
        {
            let columns = columns.iter().map(|&name| name.to_owned()).collect();
            return Err(RunWriteError::Columns { columns });
        }
        let metadata = metadata::to_json(metadata).map_err(|key| {
            let key = key.to_owned();
            RunWriteError::MetadataKey { key }
        })?;
        let mut rows = csv::Writer::from_writer(out);
        let mark = format!("{MARK}{VERSION}");
        rows.write_record(columns.iter().copied().chain([&mark[..]]))?;
        Ok(Self {
            rows,
            columns: columns.len(),
            metadata: Some(metadata),
            digits: String::new(),
        })
    }

    /// Writes one sample, its cells in the order of the columns.
    ///
    /// # Errors
    ///
    /// [`RunWriteError`] if the number of cells differs from the number of columns or the output fails.
    pub fn row(&mut self, cells: &[Cell<'_>]) -> Result<(), RunWriteError> {
        if cells.len() != self.columns {
            return Err(RunWriteError::CellCount {
                expected: self.columns,
                found: cells.len(),
            });
        }
        for cell in cells {
            match cell {
                Cell::Text(text) => self.rows.write_field(text)?,
                Cell::Number(number) => {
                    self.digits.clear();
                    push_number(&mut self.digits, *number);
                    self.rows.write_field(&self.digits)?;
                }
            }
        }
        let metadata = self.metadata.take().unwrap_or_default();
        self.rows.write_field(metadata)?;
        self.rows.write_record(None::<&[u8]>)?;
        Ok(())
    }

    /// Flushes the output and returns it.
    ///
    /// # Errors
    ///
    /// [`RunWriteError::NoRow`] if no row was written, so that the metadata would be lost; [`RunWriteError::Io`] if
    /// the output fails.
    pub fn finish(self) -> Result<W, RunWriteError> {
        if self.metadata.is_some() {
            return Err(RunWriteError::NoRow);
        }
        self.rows
            .into_inner()
            .map_err(|failed| RunWriteError::Io(failed.into_error()))
    }
}

/// Appends the shortest decimal that parses to the same bits; nothing for NaN.
fn push_number(digits: &mut String, number: f64) {
    use std::fmt::Write;
    let size = number.abs();
    let outcome = if number.is_nan() {
        Ok(())
    } else if size == 0.0 || size.is_infinite() || (1e-5..1e16).contains(&size) {
        write!(digits, "{number}")
    } else {
        write!(digits, "{number:e}")
    };
    debug_assert!(outcome.is_ok(), "a string takes every character");
}

#[cfg(test)]
mod tests {
    use super::*;

    const NO_METADATA: &[(&str, &str)] = &[];

    fn column(numbers: &[f64]) -> String {
        let mut writer = RunWriter::new(Vec::new(), NO_METADATA, &["x"]).unwrap();
        for &number in numbers {
            writer.row(&[number.into()]).unwrap();
        }
        String::from_utf8(writer.finish().unwrap()).unwrap()
    }

    #[test]
    fn numbers_take_the_fewest_digits() {
        assert_eq!(
            column(&[0.1, -0.0, 1.0, 1e-5, 1e-6, 1e15, 1e16, 5e-324, f64::MAX]),
            "x,palpate_run_1\n0.1,{}\n-0,\n1,\n0.00001,\n1e-6,\n1000000000000000,\n1e16,\n\
             5e-324,\n1.7976931348623157e308,\n"
        );
    }

    #[test]
    fn what_would_not_read_back_is_not_written() {
        let new = |metadata: &[(&str, &str)], columns: &[&str]| {
            RunWriter::new(Vec::new(), metadata, columns)
                .map(|_| ())
                .unwrap_err()
                .to_string()
        };
        for (metadata, key) in [(&[("", "")][..], ""), (&[("a", "1"), ("a", "2")], "a")] {
            assert_eq!(
                new(metadata, &["x"]),
                format!(
                    "the metadata key `{key}` is not allowed; keys must be non-empty and unique"
                )
            );
        }
        for columns in [
            &[][..],
            &["x", "x"],
            &["x", ""],
            &["x", " y"],
            &["x\ny"],
            &["\u{feff}x"],
            &["palpate_run_1"],
        ] {
            assert_eq!(
                new(&[], columns),
                format!(
                    "the columns `{}` are not allowed; at least one is needed; names must be \
                     unique, have no space around them, no line end and no byte order mark, \
                     and not begin with `palpate_run_`",
                    columns.join(",")
                )
            );
        }
        let mut writer = RunWriter::new(Vec::new(), NO_METADATA, &["x", "y"]).unwrap();
        assert_eq!(
            writer.row(&[1.0.into()]).unwrap_err().to_string(),
            "the row has 1 cells, the header 2 columns"
        );
        assert_eq!(
            writer.finish().unwrap_err().to_string(),
            "the run has no row; at least one is needed, the first holds the metadata"
        );
    }

    #[test]
    fn rejected_row_keeps_metadata_for_next_row() {
        let mut writer = RunWriter::new(Vec::new(), &[("a", "b")], &["x"]).unwrap();
        assert!(writer.row(&[]).is_err());
        writer.row(&[1.0.into()]).unwrap();
        assert_eq!(
            String::from_utf8(writer.finish().unwrap()).unwrap(),
            "x,palpate_run_1\n1,\"{\"\"a\"\":\"\"b\"\"}\"\n"
        );
    }

    #[test]
    fn a_full_disk_is_reported_through_both_layers() {
        let full = std::path::Path::new("/dev/full");
        if !full.exists() {
            return;
        }
        let error = crate::files::atomic::write(full, |out| {
            let mut writer = RunWriter::new(out, NO_METADATA, &["x"])?;
            for _ in 0..100_000 {
                writer.row(&[0.1.into()])?;
            }
            writer.finish()?;
            Ok(())
        })
        .unwrap_err();
        assert_eq!(
            error.to_string(),
            "cannot write `/dev/full`: no space left on the device"
        );
    }
}
