//! Merging of the parts of a map.

use std::collections::BTreeMap;

use thiserror::Error;

use super::{CELLS, Format, LINES_PER_CELL, Map, Row, SHARD};

/// Reason why parts cannot be merged.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum MergeError {
    /// There are no parts.
    #[error("there are no parts to merge")]
    NoParts,
    /// Two parts belong to different maps.
    #[error(
        "{first} and {other} are not parts of one map: {key} is {expected} in the first and {found} in the other"
    )]
    Differ {
        /// The first part.
        first: String,
        /// The part that differs from it.
        other: String,
        /// Key with different values.
        key: String,
        /// Its value in the first part.
        expected: String,
        /// Its value in the other.
        found: String,
    },
    /// Two parts have different formats.
    #[error(
        "{first} and {other} are not parts of one map: {first} has {}, {other} has {}; recompute the older \
         one",
        contents(*.expected), contents(*.found)
    )]
    Formats {
        /// The first part.
        first: String,
        /// The part that differs from it.
        other: String,
        /// Format of the first part; `None` if its lines have different formats.
        expected: Option<Format>,
        /// Format of the other part.
        found: Option<Format>,
    },
    /// A part lacks required metadata.
    #[error("{file}: the metadata has no number `{key}`")]
    RecordingMetadata {
        /// The part.
        file: String,
        /// The key.
        key: &'static str,
    },
    /// A cell occurs in two parts.
    #[error("cell {cell} is in {first} and in {other}; name each part once")]
    Doubled {
        /// The cell.
        cell: u64,
        /// First part with the cell.
        first: String,
        /// Second part with the cell.
        other: String,
    },
    /// A cell is outside the map, or has a wrong number of lines.
    #[error("{file}: cell {cell} has {lines} lines, but must have {expected}")]
    Lines {
        /// The part.
        file: String,
        /// The cell.
        cell: u64,
        /// Number of its lines.
        lines: usize,
        /// Required number of lines; 0 for a cell beyond the last one.
        expected: usize,
    },
    /// Some cells are in no part.
    #[error("{missing} of {cells} cells are missing{}", parts_in_words(.parts))]
    Missing {
        /// Number of missing cells.
        missing: u64,
        /// Number of cells of the map.
        cells: u64,
        /// Missing parts, such as `2/3`.
        parts: Vec<String>,
    },
}

fn contents(format: Option<Format>) -> &'static str {
    format.map_or("lines of two formats", Format::contents)
}

fn parts_in_words(parts: &[String]) -> String {
    match parts {
        [] => String::new(),
        [part] => format!(": part {part} is not among the files"),
        parts => format!(": parts {} are not among the files", parts.join(", ")),
    }
}

/// Merges parts in any order. Each part has a name for messages.
///
/// # Errors
/// [`MergeError`], which names the part.
pub fn merge(parts: Vec<(String, Map)>) -> Result<Map, MergeError> {
    let (first, reference) = parts.first().ok_or(MergeError::NoParts)?;
    for (other, part) in &parts {
        same_map(first, reference, other, part)?;
    }
    let count = |key: &'static str| {
        let value = reference.value(key).and_then(|value| value.parse().ok());
        value.ok_or_else(|| MergeError::RecordingMetadata {
            file: first.clone(),
            key,
        })
    };
    let cells: u64 = count(CELLS)?;
    let lines = usize::try_from(count(LINES_PER_CELL)?).unwrap_or(usize::MAX);
    let mut metadata = reference.metadata.clone();
    for (key, value) in &mut metadata {
        if key == SHARD {
            *value = "1/1".to_owned();
        }
    }

    let given: Vec<String> = parts
        .iter()
        .filter_map(|(_, part)| part.value(SHARD).map(str::to_owned))
        .collect();
    let mut by_cell: BTreeMap<u64, (usize, Vec<Row>)> = BTreeMap::new();
    let names: Vec<String> = parts.iter().map(|(name, _)| name.clone()).collect();
    for (number, (name, part)) in parts.into_iter().enumerate() {
        for row in part.rows {
            let (owner, rows) = by_cell.entry(row.cell).or_insert((number, Vec::new()));
            if *owner != number {
                return Err(MergeError::Doubled {
                    cell: row.cell,
                    first: names[*owner].clone(),
                    other: name,
                });
            }
            rows.push(row);
        }
    }
    for (cell, (owner, rows)) in &by_cell {
        let expected = if *cell < cells { lines } else { 0 };
        if rows.len() != expected {
            return Err(MergeError::Lines {
                file: names[*owner].clone(),
                cell: *cell,
                lines: rows.len(),
                expected,
            });
        }
    }
    let missing = cells - by_cell.len() as u64;
    if missing > 0 {
        return Err(MergeError::Missing {
            missing,
            cells,
            parts: absent(&given),
        });
    }
    let rows = by_cell.into_values().flat_map(|(_, rows)| rows).collect();
    Ok(Map { metadata, rows })
}

/// Returns the parts of a series that are missing in `given`.
fn absent(given: &[String]) -> Vec<String> {
    let Some(of) = given
        .first()
        .and_then(|shard| shard.split_once('/'))
        .and_then(|(_, of)| of.parse::<usize>().ok())
    else {
        return Vec::new();
    };
    (1..=of.min(10_000))
        .map(|shard| format!("{shard}/{of}"))
        .filter(|shard| !given.contains(shard))
        .collect()
}

fn same_map(first: &str, reference: &Map, other: &str, part: &Map) -> Result<(), MergeError> {
    let (expected, found) = (reference.format(), part.format());
    if expected != found {
        return Err(MergeError::Formats {
            first: first.to_owned(),
            other: other.to_owned(),
            expected,
            found,
        });
    }
    let keys = reference.metadata.iter().chain(&part.metadata);
    for (key, _) in keys.filter(|(key, _)| key != SHARD) {
        let (expected, found) = (reference.value(key), part.value(key));
        if expected != found {
            let shown = |value: Option<&str>| value.unwrap_or("missing").to_owned();
            return Err(MergeError::Differ {
                first: first.to_owned(),
                other: other.to_owned(),
                key: key.clone(),
                expected: shown(expected),
                found: shown(found),
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::tests::{bytes, of_bounces, part};
    use super::*;

    fn parts(of: usize) -> Vec<(String, Map)> {
        (1..=of)
            .map(|shard| (format!("p{shard}.csv"), part(shard, of)))
            .collect()
    }

    #[test]
    fn any_number_of_parts_in_any_order_gives_the_same_bytes() {
        let whole = bytes(&part(1, 1));
        for of in [1, 2, 3, 5, 12] {
            let mut parts = parts(of);
            parts.reverse();
            assert_eq!(bytes(&merge(parts).unwrap()), whole, "{of}");
        }
    }

    #[test]
    fn a_missing_part_is_named() {
        let mut given = parts(3);
        given.remove(1);
        assert_eq!(
            merge(given).unwrap_err().to_string(),
            "4 of 12 cells are missing: part 2/3 is not among the files"
        );
        assert_eq!(
            merge(parts(5).split_off(4)).unwrap_err().to_string(),
            "10 of 12 cells are missing: parts 1/5, 2/5, 3/5, 4/5 are not among the files"
        );
        assert_eq!(merge(Vec::new()), Err(MergeError::NoParts));
    }

    #[test]
    fn a_doubled_part_is_named() {
        let mut given = parts(3);
        given.push(("again.csv".into(), part(2, 3)));
        assert_eq!(
            merge(given).unwrap_err().to_string(),
            "cell 1 is in p2.csv and in again.csv; name each part once"
        );
    }

    #[test]
    fn parts_of_different_maps_or_versions_are_rejected() {
        let mut given = parts(2);
        given[1].1.metadata[0].1 = "0.2.0".into();
        assert_eq!(
            merge(given).unwrap_err().to_string(),
            "p1.csv and p2.csv are not parts of one map: palpate_version is 0.1.0 in the first \
             and 0.2.0 in the other"
        );
        let mut given = parts(2);
        given[0]
            .1
            .metadata
            .push(("delay_samples".into(), "1".into()));
        let error = merge(given).unwrap_err().to_string();
        assert!(
            error.contains("delay_samples is 1 in the first and missing"),
            "{error}"
        );
    }

    #[test]
    fn an_older_part_and_a_newer_one_are_not_joined() {
        let mut given = parts(2);
        given[1].1 = of_bounces(given[1].1.clone());
        assert_eq!(
            merge(given).unwrap_err().to_string(),
            "p1.csv and p2.csv are not parts of one map: p1.csv has bounces and contacts that stay, \
             p2.csv has bounces alone; recompute the older one"
        );
        let old = parts(2)
            .into_iter()
            .map(|(name, part)| (name, of_bounces(part)));
        let joined = merge(old.collect()).unwrap();
        assert_eq!(bytes(&joined), bytes(&of_bounces(part(1, 1))));
    }

    #[test]
    fn a_cell_with_too_few_lines_or_beyond_the_last_is_named() {
        let mut given = parts(2);
        given[1].1.rows.pop();
        assert_eq!(
            merge(given).unwrap_err().to_string(),
            "p2.csv: cell 11 has 1 lines, but must have 2"
        );
        let mut given = parts(2);
        given[0].1.rows[0].cell = 40;
        given[0].1.rows[1].cell = 40;
        let error = merge(given).unwrap_err().to_string();
        assert!(
            error.contains("cell 40 has 2 lines, but must have 0"),
            "{error}"
        );
    }
}
