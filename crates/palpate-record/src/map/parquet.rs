//! Export of a map as Parquet: the columns of the CSV file, with its metadata as the file's metadata.

use std::io::{self, Write};

use parquet::data_type::ByteArray;

use super::{Format, Map, Row};
use crate::parquet_table::{self, ColumnValues, count};

/// Writes a map as Parquet. The resting swing of a wall, which does not exist, is NaN.
///
/// # Errors
/// An error of the writer, or lines of different formats.
pub fn write_parquet(map: &Map, out: &mut dyn Write) -> io::Result<()> {
    let format = map.written_format()?;
    let metadata = [(format.column().to_owned(), format.version().to_string())]
        .into_iter()
        .chain(map.metadata.iter().cloned())
        .collect();
    let rows = [Ok(columns(&map.rows, format))];
    parquet_table::write(out, "map", format.columns(), metadata, rows)
}

fn columns(rows: &[Row], format: Format) -> Vec<ColumnValues> {
    let numbers = |of: &dyn Fn(&Row) -> f64| ColumnValues::Numbers(rows.iter().map(of).collect());
    let names = |of: &dyn Fn(&Row) -> &str| {
        ColumnValues::Names(rows.iter().map(|row| ByteArray::from(of(row))).collect())
    };
    let counts = |of: &dyn Fn(&Row) -> u64| {
        ColumnValues::Counts(rows.iter().map(|row| count(of(row))).collect())
    };
    let mut columns = vec![
        counts(&|row| row.cell),
        numbers(&|row| row.kappa),
        numbers(&|row| row.object_kappa),
        numbers(&|row| row.stiffness),
        numbers(&|row| row.object_mass),
        names(&|row| &row.plant),
        names(&|row| &row.method),
    ];
    columns.extend((0..8).map(|at| numbers(&|row| row.numbers()[at])));
    columns.extend((0..3).map(|at| counts(&|row| row.classes[at])));
    if format >= Format::BouncesAndStays {
        let resting = |row: &Row| row.stay.and_then(|stay| stay.resting);
        columns.push(numbers(&|row| resting(row).unwrap_or(f64::NAN)));
        columns.push(numbers(&|row| {
            row.stay.map_or(f64::NAN, |stay| stay.pressed)
        }));
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::super::tests::part;
    use super::*;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::RowAccessor;

    #[test]
    fn what_is_written_is_read() {
        let map = part(1, 1);
        let mut bytes = Vec::new();
        write_parquet(&map, &mut bytes).unwrap();
        let file = SerializedFileReader::new(parquet_bytes(bytes)).unwrap();
        let metadata = file.metadata().file_metadata();
        assert!(
            metadata
                .key_value_metadata()
                .unwrap()
                .iter()
                .any(|entry| entry.key == "cells_per_axis" && entry.value.as_deref() == Some("3"))
        );
        let names: Vec<String> = metadata
            .schema_descr()
            .columns()
            .iter()
            .map(|column| column.name().to_owned())
            .collect();
        assert_eq!(names, Format::BouncesAndStays.columns());
        let mut count = 0;
        for (read, row) in file.get_row_iter(None).unwrap().zip(&map.rows) {
            let read = read.unwrap();
            assert_eq!(read.get_long(0).unwrap(), i64::try_from(row.cell).unwrap());
            assert_eq!(read.get_string(5).unwrap(), &row.plant);
            for (at, number) in row.numbers().into_iter().enumerate() {
                assert_eq!(read.get_double(7 + at).unwrap().to_bits(), number.to_bits());
            }
            assert_eq!(read.get_long(17).unwrap(), 1);
            assert!(read.get_double(18).unwrap().is_nan());
            assert_eq!(read.get_double(19).unwrap(), 0.0625);
            count += 1;
        }
        assert_eq!(count, map.rows.len());
    }

    fn parquet_bytes(bytes: Vec<u8>) -> bytes::Bytes {
        bytes::Bytes::from(bytes)
    }
}
