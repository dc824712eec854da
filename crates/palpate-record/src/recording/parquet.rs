//! A recording as Parquet: the columns of the CSV file, the receipt as the file's metadata.

use std::io::{self, Write};

use parquet::data_type::ByteArray;

use super::export::{names, receipt};
use super::{COLUMNS, Entry, Kind, Recording, Tick, Value};
use crate::parquet_table::{self, Column, count};

/// Ticks that are gathered before they are written: about 12 MB.
const GROUP: usize = 1 << 16;

impl Recording {
    /// Writes every tick that is there as Parquet.
    ///
    /// # Errors
    /// The recording cannot be read any more; what the writer says.
    pub fn write_parquet(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut entries = self.entries().map_err(io::Error::other)?;
        let mut begun = false;
        let groups = std::iter::from_fn(|| {
            let mut ticks = Vec::new();
            while ticks.len() < GROUP {
                match entries.next() {
                    Some(Ok(Entry::Tick(tick))) => ticks.push(tick),
                    Some(Ok(Entry::Event(_))) => {}
                    Some(Err(error)) => return Some(Err(io::Error::other(error))),
                    None => break,
                }
            }
            // A table without rows has its columns too.
            let last = ticks.is_empty() && begun;
            begun = true;
            (!last).then(|| Ok(columns(&ticks)))
        });
        parquet_table::write(out, "ticks", &names(), receipt(self), groups)
    }
}

fn columns(ticks: &[Tick]) -> Vec<Column> {
    COLUMNS
        .iter()
        .map(|column| {
            let values = ticks.iter().map(|tick| column.value(tick));
            match column.kind {
                Kind::Number => Column::Numbers(values.map(Value::number).collect()),
                Kind::Count | Kind::ShortCount => Column::Counts(values.map(whole).collect()),
                Kind::Flags | Kind::Phase => {
                    let bytes =
                        |value: Value| ByteArray::from(value.text().into_owned().into_bytes());
                    Column::Names(values.map(bytes).collect())
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
