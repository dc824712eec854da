//! A recording as tables of text.

use std::io::{self, Write};

use super::export::{COLUMNS, receipt};
use super::{Entry, Recording};
use crate::run::{Cell, RunWriter};

impl Recording {
    /// Writes every tick that is there as a [run file](crate::run), with the receipt and what is
    /// to be known of the recording in its first row.
    ///
    /// # Errors
    /// There is no tick; the recording cannot be read any more; what `out` says.
    pub fn write_csv(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut rows = RunWriter::new(out, &receipt(self), &COLUMNS)?;
        for entry in self.entries().map_err(io::Error::other)? {
            let Entry::Tick(tick) = entry.map_err(io::Error::other)? else {
                continue;
            };
            let counts = [tick.sequence.to_string(), tick.generation.to_string()];
            let flags = tick.flags.names();
            let mut cells = vec![Cell::Text(&counts[0])];
            cells.extend(tick.numbers().map(Cell::Number));
            cells.push(Cell::Text(&counts[1]));
            cells.push(Cell::Text(&flags));
            cells.push(Cell::Text(tick.phase.name()));
            rows.row(&cells)?;
        }
        rows.finish()?;
        Ok(())
    }

    /// Writes every event as a [run file](crate::run).
    ///
    /// # Errors
    /// There is no event; the recording cannot be read any more; what `out` says.
    pub fn write_events_csv(&self, out: &mut dyn Write) -> io::Result<()> {
        let receipt = [("recording", self.path().display().to_string())];
        let mut rows = RunWriter::new(out, &receipt, &["sequence", "t_s", "kind", "text"])?;
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
