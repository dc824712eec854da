//! Maps: the stability of each method over plants, as a CSV table, in parts or as a whole.
//!
//! The table has one line per cell, plant and method. In the first line, the last column, [`Format::column`],
//! contains the metadata as a JSON object of strings: parameters, index of the part, number of lines and their
//! checksum. The checksum detects an incomplete part.

mod format;
mod merge;
#[cfg(feature = "parquet")]
mod parquet;
mod row;

pub use format::Format;
pub use merge::{MergeError, merge};
#[cfg(feature = "parquet")]
pub use parquet::write_parquet;
pub use row::{Row, StaySwing};

use std::io::{self, Read, Write};

use crate::files::checksum::Checksum;
use thiserror::Error;

use crate::files::bounded::TABLE;

use crate::run::metadata;

/// Metadata keys that the file format computes itself.
const OWN: [&str; 2] = ["lines", "checksum"];

/// Metadata key of the index of a part, `2/3`.
pub const SHARD: &str = "shard";

/// Metadata key of the number of cells of the whole map.
pub const CELLS: &str = "cells_in_all";

/// Metadata key of the number of lines per cell.
pub const LINES_PER_CELL: &str = "lines_per_cell";

/// A map, or a part of one.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// Metadata in order, without number of lines and checksum.
    pub metadata: Vec<(String, String)>,
    /// Lines in the order of their cells.
    pub rows: Vec<Row>,
}

/// Reason why a file is not a valid map.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MapError {
    /// The file cannot be read.
    #[error("cannot read `{file}`: {source}")]
    Unreadable {
        /// The file.
        file: String,
        /// Error of the system.
        source: io::Error,
    },
    /// The file is not a map.
    #[error(
        "{file}:1: this is not a map of palpate; its first line must name the column {}, or {} of older \
         versions",
        Format::BouncesAndStays.column(),
        Format::Bounces.column()
    )]
    NotAMap {
        /// The file.
        file: String,
    },
    /// A line is invalid.
    #[error("{file}:{line}: {fault}")]
    Line {
        /// The file.
        file: String,
        /// The line, counted from 1.
        line: usize,
        /// Description of the error.
        fault: String,
    },
    /// Lines are missing or damaged.
    #[error("{file} is damaged: {fault}; compute this part again")]
    Torn {
        /// The file.
        file: String,
        /// Description of the damage.
        fault: String,
    },
}

impl Map {
    /// Returns the value of a metadata key.
    #[must_use]
    pub fn value(&self, key: &str) -> Option<&str> {
        self.metadata
            .iter()
            .find(|(name, _)| name == key)
            .map(|(_, value)| value.as_str())
    }

    /// Returns the format in which the map is written; `None` if only some of the lines have sustained contacts.
    #[must_use]
    pub fn format(&self) -> Option<Format> {
        let format = self.rows.first()?.format();
        let are_alike = self.rows.iter().all(|row| row.format() == format);
        are_alike.then_some(format)
    }

    /// Writes the map.
    ///
    /// # Errors
    /// An error of the writer, a duplicate metadata key, or lines of different formats.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let format = self.written_format()?;
        let lines: Vec<String> = self.rows.iter().map(Row::to_line).collect();
        let mut checksum = Checksum::new();
        for line in &lines {
            checksum.add(line.as_bytes());
            checksum.add(b"\n");
        }
        let mut metadata = self.metadata.clone();
        metadata.push(("lines".into(), lines.len().to_string()));
        metadata.push(("checksum".into(), checksum.text()));
        let json = metadata::to_json(&metadata)
            .map_err(|key| io::Error::other(format!("the key `{key}` is empty or duplicate")))?;
        out.write_all(format.head().as_bytes())?;
        for (number, line) in lines.iter().enumerate() {
            if number == 0 {
                writeln!(out, "{line},\"{}\"", json.replace('"', "\"\""))?;
            } else {
                writeln!(out, "{line},")?;
            }
        }
        Ok(())
    }

    fn written_format(&self) -> io::Result<Format> {
        let mixed =
            "a map needs contacts that stay in all of its lines or in none, and at least one line";
        self.format().ok_or_else(|| io::Error::other(mixed))
    }

    /// Reads a map; `file` is its name in errors.
    ///
    /// # Errors
    /// [`MapError`], which names the file and, if there is one, the line.
    pub fn read(mut source: impl Read, file: &str) -> Result<Self, MapError> {
        let file = file.to_owned();
        let mut bytes = Vec::new();
        if let Err(source) = TABLE.reader(&mut source).read_to_end(&mut bytes) {
            return Err(MapError::Unreadable { file, source });
        }
        let torn = |fault: String| MapError::Torn {
            file: file.clone(),
            fault,
        };
        let Ok(text) = String::from_utf8(bytes) else {
            return Err(torn("it is not UTF-8 text".into()));
        };
        let body_of = |format: Format| Some((format, text.strip_prefix(&format.head())?));
        let Some((format, body)) = Format::ALL.into_iter().find_map(body_of) else {
            let is_begun = |format: Format| format.head().starts_with(&text);
            return Err(
                if !text.is_empty() && Format::ALL.into_iter().any(is_begun) {
                    torn("it ends within its first line".into())
                } else {
                    MapError::NotAMap { file }
                },
            );
        };
        let at_line = |line: usize, fault: String| MapError::Line {
            file: file.clone(),
            line,
            fault,
        };
        if !body.ends_with('\n') {
            return Err(torn("its last line has no line end".into()));
        }
        let mut metadata = None;
        let mut rows = Vec::new();
        let mut checksum = Checksum::new();
        for (number, line) in body.lines().enumerate() {
            let (row, rest) = row::split(line, format)
                .ok_or_else(|| torn(format!("line {} has too few fields", number + 2)))?;
            checksum.add(row.as_bytes());
            checksum.add(b"\n");
            if number == 0 {
                let json = rest
                    .strip_prefix('"')
                    .and_then(|rest| rest.strip_suffix('"'))
                    .map(|json| json.replace("\"\"", "\""))
                    .ok_or_else(|| at_line(2, "the metadata is missing".into()))?;
                metadata = Some(
                    metadata::from_json(&json)
                        .map_err(|error| at_line(2, format!("the metadata: {error}")))?,
                );
            } else if !rest.is_empty() {
                return Err(at_line(
                    number + 2,
                    "only the first line has metadata".into(),
                ));
            }
            rows.push(Row::from_line(row, format).map_err(|fault| at_line(number + 2, fault))?);
        }
        let mut metadata = metadata.ok_or_else(|| torn("it has no lines".into()))?;
        let take = |key: &str| {
            metadata
                .iter()
                .find(|(name, _)| name == key)
                .map(|(_, v)| v)
        };
        let lines = take("lines").cloned().unwrap_or_default();
        if lines != rows.len().to_string() {
            return Err(torn(format!("it has {} lines of {lines}", rows.len())));
        }
        if take("checksum") != Some(&checksum.text()) {
            return Err(torn("its checksum does not match its lines".into()));
        }
        metadata.retain(|(key, _)| !OWN.contains(&key.as_str()));
        Ok(Self { metadata, rows })
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Creates a map, or a part, whose cells follow from their index.
    pub(crate) fn part(shard: usize, of: usize) -> Map {
        let metadata = [
            ("palpate_version", "0.1.0".to_owned()),
            ("cells_per_axis", "3".to_owned()),
            (CELLS, "12".to_owned()),
            (LINES_PER_CELL, "2".to_owned()),
            (SHARD, format!("{shard}/{of}")),
        ];
        let rows = (shard - 1..12)
            .step_by(of)
            .flat_map(|cell| {
                ["undamped", "damped"].map(|plant| row::tests::row(cell as u64, plant))
            })
            .collect();
        Map {
            metadata: metadata
                .map(|(key, value)| (key.to_owned(), value))
                .to_vec(),
            rows,
        }
    }

    pub(crate) fn bytes(map: &Map) -> Vec<u8> {
        let mut bytes = Vec::new();
        map.write(&mut bytes).unwrap();
        bytes
    }

    #[test]
    fn what_is_written_is_read() {
        let map = part(2, 3);
        let written = bytes(&map);
        assert_eq!(Map::read(written.as_slice(), "m.csv").unwrap(), map);
        let text = String::from_utf8(written).unwrap();
        assert!(text.starts_with("cell,kappa,object_kappa,"), "{text}");
        let head = text.lines().next().unwrap();
        assert!(
            head.ends_with("resting_swing,pressed_swing,palpate_map_2"),
            "{head}"
        );
    }

    /// Converts a part to an older version.
    pub(crate) fn of_bounces(mut part: Map) -> Map {
        for row in &mut part.rows {
            row.stay = None;
        }
        part
    }

    #[test]
    fn an_older_map_is_read_and_written_as_it_is() {
        let map = of_bounces(part(2, 3));
        let written = bytes(&map);
        let text = String::from_utf8(written.clone()).unwrap();
        assert!(
            text.starts_with("cell,kappa,")
                && text
                    .lines()
                    .next()
                    .unwrap()
                    .ends_with("diverged,palpate_map_1")
        );
        let read = Map::read(written.as_slice(), "m.csv").unwrap();
        assert_eq!(read, map);
        assert_eq!(read.format(), Some(Format::Bounces));
        assert!(read.rows.iter().all(|row| row.stay.is_none()));
        assert_eq!(bytes(&read), written);
        for length in 0..written.len() {
            let error = Map::read(&written[..length], "p1.csv").unwrap_err();
            assert!(error.to_string().starts_with("p1.csv"), "{length}: {error}");
        }
    }

    #[test]
    fn lines_of_different_formats_are_not_written() {
        let mut map = part(1, 1);
        map.rows[3].stay = None;
        assert_eq!(map.format(), None);
        let error = map.write(&mut Vec::new()).unwrap_err().to_string();
        assert!(error.contains("in all of its lines or in none"), "{error}");
    }

    #[test]
    fn a_part_cut_anywhere_is_torn() {
        let whole = bytes(&part(1, 3));
        for length in 0..whole.len() {
            let error = Map::read(&whole[..length], "p1.csv").unwrap_err();
            assert!(error.to_string().starts_with("p1.csv"), "{length}: {error}");
        }
        let error = Map::read(&whole[..whole.len() - 1], "p1.csv").unwrap_err();
        assert_eq!(
            error.to_string(),
            "p1.csv is damaged: its last line has no line end; compute this part again"
        );
    }

    #[test]
    fn a_hole_or_a_changed_digit_in_the_middle_shows() {
        let whole = String::from_utf8(bytes(&part(1, 1))).unwrap();
        let lines: Vec<&str> = whole.lines().collect();
        let mut without = lines.clone();
        without.remove(7);
        let read = |text: &str| Map::read(text.as_bytes(), "p.csv").unwrap_err().to_string();
        let error = read(&(without.join("\n") + "\n"));
        assert_eq!(
            error,
            "p.csv is damaged: it has 23 lines of 24; compute this part again"
        );
        let error = read(&whole.replacen("0.125", "0.126", 1));
        assert!(error.contains("checksum"), "{error}");
        let mut zeros = whole.clone().into_bytes();
        let middle = zeros.len() / 2;
        zeros[middle..middle + 40].fill(0);
        let error = Map::read(zeros.as_slice(), "p.csv")
            .unwrap_err()
            .to_string();
        assert!(error.starts_with("p.csv"), "{error}");
    }

    #[test]
    fn another_file_is_not_a_map() {
        let error = Map::read("t_s,position_m\n0,0\n".as_bytes(), "hand.csv").unwrap_err();
        assert_eq!(
            error.to_string(),
            "hand.csv:1: this is not a map of palpate; its first line must name the column \
             palpate_map_2, or palpate_map_1 of older versions"
        );
    }
}
