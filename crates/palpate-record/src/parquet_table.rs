//! Tables as Parquet, written in groups of rows.

use std::io::{self, Write};
use std::sync::{Arc, Mutex, PoisonError};

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

/// Values of a column.
pub(crate) enum ColumnValues {
    Counts(Vec<i64>),
    Numbers(Vec<f64>),
    Names(Vec<ByteArray>),
}

/// Writes a table to `out` in groups of rows. Each item of `groups` contains a column for each of `names`, of the
/// same kinds every time.
pub(crate) fn write(
    out: &mut dyn Write,
    table: &str,
    names: &[&str],
    metadata: Vec<(String, String)>,
    groups: impl IntoIterator<Item = io::Result<Vec<ColumnValues>>>,
) -> io::Result<()> {
    let mut groups = groups.into_iter();
    let first = match groups.next() {
        Some(first) => first?,
        None => return Ok(()),
    };
    let waiting = Waiting::default();
    let mut file = begin(waiting.clone(), table, names, metadata, &first).map_err(plain)?;
    for columns in [Ok(first)].into_iter().chain(groups) {
        group(&mut file, &columns?).map_err(plain)?;
        file.flush()?;
        out.write_all(&waiting.take())?;
    }
    file.close().map_err(plain)?;
    out.write_all(&waiting.take())
}

/// Converts a count to the integer type of Parquet.
pub(crate) fn count(value: u64) -> i64 {
    i64::try_from(value).unwrap_or(i64::MAX)
}

fn begin(
    out: Waiting,
    table: &str,
    names: &[&str],
    metadata: Vec<(String, String)>,
    columns: &[ColumnValues],
) -> Result<SerializedFileWriter<Waiting>, ParquetError> {
    let fields = names
        .iter()
        .zip(columns)
        .map(|(name, column)| column.field(name))
        .collect::<Result<Vec<_>, _>>()?;
    let schema = Type::group_type_builder(table)
        .with_fields(fields)
        .build()?;
    let metadata = metadata
        .into_iter()
        .map(|(key, value)| KeyValue::new(key, value))
        .collect();
    let properties = WriterProperties::builder()
        .set_created_by("palpate".to_owned())
        .set_key_value_metadata(Some(metadata))
        .build();
    SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties))
}

fn group(
    file: &mut SerializedFileWriter<Waiting>,
    columns: &[ColumnValues],
) -> Result<(), ParquetError> {
    let mut group = file.next_row_group()?;
    for column in columns {
        if let Some(mut writer) = group.next_column()? {
            match column {
                ColumnValues::Counts(values) => writer
                    .typed::<Int64Type>()
                    .write_batch(values, None, None)?,
                ColumnValues::Numbers(values) => writer
                    .typed::<DoubleType>()
                    .write_batch(values, None, None)?,
                ColumnValues::Names(values) => writer
                    .typed::<ByteArrayType>()
                    .write_batch(values, None, None)?,
            };
            writer.close()?;
        }
    }
    group.close()?;
    Ok(())
}

impl ColumnValues {
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

/// Buffer for an output: the library requires a `Send` writer, and the caller's need not be one.
#[derive(Clone, Default)]
struct Waiting(Arc<Mutex<Vec<u8>>>);

impl Waiting {
    fn take(&self) -> Vec<u8> {
        std::mem::take(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Write for Waiting {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut waiting = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        waiting.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Returns the error of the system, if there is one.
fn plain(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(inner) => match inner.downcast::<io::Error>() {
            Ok(error) => *error,
            Err(other) => io::Error::other(other),
        },
        other => io::Error::other(other),
    }
}
