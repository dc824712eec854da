//! Rows of a comparison as CSV.

use std::io::{self, Write};

/// Writes rows under the names of their columns.
///
/// # Errors
/// The writer fails.
pub fn write<const N: usize>(
    writer: &mut dyn Write,
    columns: &[&str; N],
    rows: impl Iterator<Item = [String; N]>,
) -> io::Result<()> {
    let mut csv = csv::Writer::from_writer(writer);
    csv.write_record(columns)?;
    for row in rows {
        csv.write_record(row)?;
    }
    csv.flush()
}
