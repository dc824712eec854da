//! The force that was held while a trace was recorded, where it has a column for it.

use std::ops::Range;

use crate::failure::Failure;

/// Force on the device, held from the sample until the next `[N]`.
pub const COLUMN: &str = "force_on_device_n";

/// The column of a `text` that is known to be a trace; `None` if it has none.
///
/// # Errors
/// A field of the column that is not a finite number; the column twice.
pub fn read(name: &str, text: &str) -> Result<Option<Vec<f64>>, Failure> {
    let body = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut records = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .from_reader(body.as_bytes())
        .into_records()
        .map_while(Result::ok);
    let Some(header) = records.next() else {
        return Ok(None);
    };
    let mut columns = (0..header.len()).filter(|&at| header[at].trim() == COLUMN);
    let Some(column) = columns.next() else {
        return Ok(None);
    };
    if columns.next().is_some() {
        return Err(Failure::input(format!(
            "{name}: the header names the column `{COLUMN}` twice; at most one is needed"
        )));
    }
    records
        .map(|record| match record[column].trim().parse::<f64>() {
            Ok(force) if force.is_finite() => Ok(force),
            _ => {
                let line = record.position().map_or(0, csv::Position::line);
                Err(fault(name, body, line, column, record[column].trim()))
            }
        })
        .collect::<Result<_, _>>()
        .map(Some)
}

fn fault(name: &str, text: &str, line: u64, column: usize, field: &str) -> Failure {
    let (span, place) = place(text, line, column);
    let message = format!(
        "{name}:{line}:{place}: `{field}` in column `{COLUMN}` is not a finite number; the force [N] \
         that was held on the device from this sample on is needed, 0 where there was none"
    );
    Failure::input_at(message, name, text, span)
}

/// The bytes of a field of a line, counted from 1, and the column they begin at.
fn place(text: &str, line: u64, column: usize) -> (Range<usize>, usize) {
    let mut start = 0;
    for (number, content) in (1_u64..).zip(text.split_inclusive('\n')) {
        if number == line {
            let before: usize = content.split(',').take(column).map(|f| f.len() + 1).sum();
            let width = content.split(',').nth(column).map_or(0, |f| f.trim().len());
            let at = start + before;
            return (at..at + width, content[..before].chars().count() + 1);
        }
        start += content.len();
    }
    (text.len()..text.len(), 1)
}
