//! A recording as Parquet: the columns of the CSV file, the receipt as the file's metadata.

use std::io::{self, Write};

use parquet::data_type::ByteArray;

use super::export::{COLUMNS, receipt};
use super::tick::NUMBERS;
use super::{Entry, Recording, Tick};
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
        parquet_table::write(out, "ticks", &COLUMNS, receipt(self), groups)
    }
}

fn columns(ticks: &[Tick]) -> Vec<Column> {
    let counts = |of: &dyn Fn(&Tick) -> u64| {
        Column::Counts(ticks.iter().map(|tick| count(of(tick))).collect())
    };
    let names = |of: &dyn Fn(&Tick) -> String| {
        let bytes = |tick| ByteArray::from(of(tick).into_bytes());
        Column::Names(ticks.iter().map(bytes).collect())
    };
    let mut columns = vec![counts(&|tick| tick.sequence)];
    columns.extend((0..NUMBERS.len()).map(|at| {
        let numbers = ticks.iter().map(|tick| tick.numbers()[at]);
        Column::Numbers(numbers.collect())
    }));
    columns.push(counts(&|tick| u64::from(tick.generation)));
    columns.push(names(&|tick| tick.flags.names()));
    columns.push(names(&|tick| tick.phase.name().to_owned()));
    columns
}
