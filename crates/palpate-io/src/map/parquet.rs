//! A map as Parquet: the columns of the CSV file, the receipt as the file's metadata.

use std::io::{self, Write};
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use super::row::COLUMNS;
use super::{FORMAT_COLUMN, Map, Row};

/// The values of a column.
enum Column {
    Counts(Vec<i64>),
    Numbers(Vec<f64>),
    Names(Vec<ByteArray>),
}

/// Writes a map as Parquet.
///
/// # Errors
/// What the writer says.
pub fn write_parquet(map: &Map, out: &mut dyn Write) -> io::Result<()> {
    write(map, out).map_err(|error| match error {
        ParquetError::External(inner) => match inner.downcast::<io::Error>() {
            Ok(error) => *error,
            Err(other) => io::Error::other(other),
        },
        other => io::Error::other(other),
    })
}

fn write(map: &Map, out: &mut dyn Write) -> Result<(), ParquetError> {
    // The library's writer must be `Send`, and a map fits into memory.
    let mut bytes = Vec::new();
    let columns = columns(&map.rows);
    let fields = COLUMNS
        .iter()
        .zip(&columns)
        .map(|(name, column)| column.field(name))
        .collect::<Result<Vec<_>, _>>()?;
    let schema = Type::group_type_builder("map")
        .with_fields(fields)
        .build()?;
    let receipt = [(FORMAT_COLUMN.to_owned(), "1".to_owned())]
        .into_iter()
        .chain(map.receipt.iter().cloned())
        .map(|(key, value)| KeyValue::new(key, value))
        .collect();
    let properties = WriterProperties::builder()
        .set_created_by("palpate".to_owned())
        .set_key_value_metadata(Some(receipt))
        .build();
    let mut file = SerializedFileWriter::new(&mut bytes, Arc::new(schema), Arc::new(properties))?;
    let mut group = file.next_row_group()?;
    for column in &columns {
        if let Some(mut writer) = group.next_column()? {
            match column {
                Column::Counts(values) => writer
                    .typed::<Int64Type>()
                    .write_batch(values, None, None)?,
                Column::Numbers(values) => writer
                    .typed::<DoubleType>()
                    .write_batch(values, None, None)?,
                Column::Names(values) => writer
                    .typed::<ByteArrayType>()
                    .write_batch(values, None, None)?,
            };
            writer.close()?;
        }
    }
    group.close()?;
    file.close()?;
    out.write_all(&bytes)?;
    Ok(())
}

impl Column {
    fn field(&self, name: &str) -> Result<Arc<Type>, ParquetError> {
        let (physical, logical) = match self {
            Self::Counts(_) => (Physical::INT64, None),
            Self::Numbers(_) => (Physical::DOUBLE, None),
            Self::Names(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        Type::primitive_type_builder(name, physical)
            .with_repetition(Repetition::REQUIRED)
            .with_logical_type(logical)
            .build()
            .map(Arc::new)
    }
}

fn columns(rows: &[Row]) -> Vec<Column> {
    let numbers = |of: &dyn Fn(&Row) -> f64| Column::Numbers(rows.iter().map(of).collect());
    let names = |of: &dyn Fn(&Row) -> &str| {
        Column::Names(rows.iter().map(|row| ByteArray::from(of(row))).collect())
    };
    let counts = |of: &dyn Fn(&Row) -> u64| {
        let value = |row| i64::try_from(of(row)).unwrap_or(i64::MAX);
        Column::Counts(rows.iter().map(value).collect())
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
        let receipt = metadata.key_value_metadata().unwrap();
        assert!(
            receipt
                .iter()
                .any(|entry| entry.key == "cells_per_axis" && entry.value.as_deref() == Some("3"))
        );
        let names: Vec<String> = metadata
            .schema_descr()
            .columns()
            .iter()
            .map(|column| column.name().to_owned())
            .collect();
        assert_eq!(names, COLUMNS);
        let mut count = 0;
        for (read, row) in file.get_row_iter(None).unwrap().zip(&map.rows) {
            let read = read.unwrap();
            assert_eq!(read.get_long(0).unwrap(), i64::try_from(row.cell).unwrap());
            assert_eq!(read.get_string(5).unwrap(), &row.plant);
            for (at, number) in row.numbers().into_iter().enumerate() {
                assert_eq!(read.get_double(7 + at).unwrap().to_bits(), number.to_bits());
            }
            assert_eq!(read.get_long(17).unwrap(), 1);
            count += 1;
        }
        assert_eq!(count, map.rows.len());
    }

    fn parquet_bytes(bytes: Vec<u8>) -> bytes::Bytes {
        bytes::Bytes::from(bytes)
    }
}
