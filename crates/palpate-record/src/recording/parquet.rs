//! Export of a recording as Parquet: the columns of the CSV file, with its metadata as the file's metadata.

use std::io::{self, Write};

use parquet::data_type::ByteArray;

use super::export::{columns, metadata, names};
use super::{Column, Kind, Recording, Row, Value};
use crate::parquet_table::{self, count};

/// Rows per group: about 21 MB.
const GROUP: usize = 1 << 16;

impl Recording {
    /// Writes every recorded tick as Parquet, in the rows of [`write_csv`](Self::write_csv).
    ///
    /// # Errors
    /// The recording cannot be read any more; an error of the writer.
    pub fn write_parquet(&self, out: &mut dyn Write) -> io::Result<()> {
        let columns = columns(self);
        let mut rows = self.rows().map_err(io::Error::other)?;
        let mut begun = false;
        let groups = std::iter::from_fn(|| {
            let group: Result<Vec<Row>, _> = rows.by_ref().take(GROUP).collect();
            let group = match group {
                Ok(group) => group,
                Err(error) => return Some(Err(io::Error::other(error))),
            };
            // A table without rows has one empty group, for its columns.
            let last = group.is_empty() && begun;
            begun = true;
            (!last).then(|| Ok(values(&columns, &group)))
        });
        parquet_table::write(out, "ticks", &names(&columns), metadata(self), groups)
    }
}

fn values(columns: &[&'static Column], rows: &[Row]) -> Vec<parquet_table::ColumnValues> {
    columns
        .iter()
        .map(|column| {
            let values = rows.iter().map(|row| column.value(row));
            match column.kind {
                Kind::Number => {
                    parquet_table::ColumnValues::Numbers(values.map(Value::number).collect())
                }
                Kind::Count | Kind::ShortCount => {
                    parquet_table::ColumnValues::Counts(values.map(whole).collect())
                }
                Kind::Flags | Kind::Phase => {
                    let bytes =
                        |value: Value| ByteArray::from(value.text().into_owned().into_bytes());
                    parquet_table::ColumnValues::Names(values.map(bytes).collect())
                }
            }
        })
        .collect()
}

fn whole(value: Value) -> i64 {
    match value {
        Value::Count(value) => count(value),
        Value::ShortCount(value) => i64::from(value),
        _ => 0,
    }
}
