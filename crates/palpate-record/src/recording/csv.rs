//! Export of a recording as text tables.

use std::borrow::Cow;
use std::io::{self, Write};

use super::export::{columns, metadata, names};
use super::{BodyTick, Column, DeviceTick, Entry, Recording, Row, Value, event};
use crate::run::{Cell, RunWriter};

impl Recording {
    /// Writes every recorded tick as a [run file](crate::run), with the metadata and the facts about the recording in
    /// its first row. A tick has a line for each of its contacts, and one line if it has none.
    ///
    /// # Errors
    /// There are no ticks; the recording cannot be read any more; an error of `out`.
    pub fn write_csv(&self, out: &mut dyn Write) -> io::Result<()> {
        let columns = columns(self);
        let mut rows = RunWriter::new(out, &metadata(self), &names(&columns))?;
        for row in self.rows().map_err(io::Error::other)? {
            write_row(&mut rows, &columns, &row.map_err(io::Error::other)?)?;
        }
        rows.finish()?;
        Ok(())
    }

    /// Writes every body of every tick of a world as a [run file](crate::run).
    ///
    /// # Errors
    /// There are no bodies; the recording cannot be read any more; an error of `out`.
    pub fn write_bodies_csv(&self, out: &mut dyn Write) -> io::Result<()> {
        let metadata = [("recording", self.path().display().to_string())];
        let time = Column::named("t_s").into_iter();
        let columns: Vec<_> = BodyTick::COLUMNS.iter().chain(time).collect();
        let mut rows = RunWriter::new(out, &metadata, &names(&columns))?;
        for entry in self.entries().map_err(io::Error::other)? {
            if let Entry::Tick(tick, _, bodies, _) = entry.map_err(io::Error::other)? {
                for body in bodies {
                    let row = Row {
                        tick,
                        body,
                        ..Row::UNKNOWN
                    };
                    write_row(&mut rows, &columns, &row)?;
                }
            }
        }
        rows.finish()?;
        Ok(())
    }

    /// Writes every device of every tick of a loop with several devices as a [run file](crate::run).
    ///
    /// # Errors
    /// There are no such devices; the recording cannot be read any more; an error of `out`.
    pub fn write_devices_csv(&self, out: &mut dyn Write) -> io::Result<()> {
        let metadata = [("recording", self.path().display().to_string())];
        let columns: Vec<_> = DeviceTick::COLUMNS.iter().collect();
        let mut rows = RunWriter::new(out, &metadata, &names(&columns))?;
        for entry in self.entries().map_err(io::Error::other)? {
            if let Entry::Tick(.., devices) = entry.map_err(io::Error::other)? {
                for device in devices {
                    let row = Row {
                        device,
                        ..Row::UNKNOWN
                    };
                    write_row(&mut rows, &columns, &row)?;
                }
            }
        }
        rows.finish()?;
        Ok(())
    }

    /// Writes every event as a [run file](crate::run).
    ///
    /// # Errors
    /// There are no events; the recording cannot be read any more; an error of `out`.
    pub fn write_events_csv(&self, out: &mut dyn Write) -> io::Result<()> {
        let metadata = [("recording", self.path().display().to_string())];
        let mut rows = RunWriter::new(out, &metadata, &event::COLUMNS.map(|column| column.name))?;
        for entry in self.entries().map_err(io::Error::other)? {
            if let Entry::Event(event) = entry.map_err(io::Error::other)? {
                rows.row(&[
                    Cell::Text(&event.sequence.to_string()),
                    Cell::Number(event.time),
                    Cell::Text(&event.kind),
                    Cell::Text(&event.text),
                ])?;
            }
        }
        rows.finish()?;
        Ok(())
    }
}

/// Writes a line of a table.
fn write_row<W: Write>(
    rows: &mut RunWriter<W>,
    columns: &[&'static Column],
    row: &Row,
) -> io::Result<()> {
    let values: Vec<_> = columns.iter().map(|column| column.value(row)).collect();
    let texts: Vec<_> = values
        .iter()
        .map(|value| match value {
            Value::Number(_) => Cow::default(),
            other => other.text(),
        })
        .collect();
    let cells: Vec<_> = values
        .iter()
        .zip(&texts)
        .map(|(value, text)| match value {
            Value::Number(number) => Cell::Number(*number),
            _ => Cell::Text(text),
        })
        .collect();
    rows.row(&cells)?;
    Ok(())
}
