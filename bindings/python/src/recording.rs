//! Recordings of loops with a device, as arrays.

use std::path::PathBuf;

use numpy::PyArray1;
use palpate_record::recording::{
    Entry, Event, Flags, Kind, Phase, Recording, RecordingError, Row, Value, columns,
};
use palpate_study::recording::report::RecordingReport;
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;

use crate::columns::{Words, array};
use crate::interrupt::interruptible;
use crate::names::refused;

/// The columns of a row of a recording, a tick and a contact: the name of each, and whether it is a number or else a count; and
/// what the codes mean: phases, and flags by their bits.
#[pyfunction]
pub fn recorded_columns() -> (Vec<(&'static str, bool)>, [Vec<&'static str>; 2]) {
    let columns = columns()
        .iter()
        .map(|column| (column.name, column.kind == Kind::Number));
    let phases = Phase::ALL.into_iter().map(Phase::name).collect();
    let flags = Flags::NAMED.into_iter().map(|(_, name)| name).collect();
    (columns.collect(), [phases, flags])
}

/// What is in a recording.
type InPython<'py> = (
    (String, String),
    Bound<'py, PyArray1<u64>>,
    Vec<(u64, f64, String, String)>,
    Vec<(String, String)>,
);

/// Reads a recording: the report on it as JSON and as text, its rows, one for each contact of a tick, its events, and the texts of its
/// receipt.
#[pyfunction]
pub fn read_recording(py: Python<'_>, path: PathBuf) -> PyResult<InPython<'_>> {
    let read = interruptible(py, move |stop| {
        let recording = Recording::open(&path)?;
        let report = RecordingReport::new(&recording)?;
        let mut words = Words::new();
        let mut events = Vec::new();
        for entry in recording.entries()? {
            match entry? {
                Entry::Tick(tick, contacts, _) => {
                    for row in Row::of(tick, &contacts) {
                        words.extend(columns().iter().map(|column| word(column.value(&row))));
                    }
                }
                Entry::Event(event) => events.push(event),
            }
            stop.leave_if_raised();
        }
        let said = (palpate_study::json(&report), report.to_string());
        Ok((said, words, events, recording.receipt.texts))
    })?;
    let (said, words, events, texts) = read.map_err(|error| match error {
        RecordingError::Unreadable { .. } => PyOSError::new_err(error.to_string()),
        RecordingError::Invalid { .. } => refused(error),
    })?;
    let events = events.into_iter();
    let events = events.map(
        |Event {
             sequence,
             time,
             kind,
             text,
         }| (sequence, time, kind, text),
    );
    Ok((
        said,
        array(py, words),
        events.collect(),
        texts.into_iter().collect(),
    ))
}

/// A value in a word of 64 bits: a number, or a count.
pub fn word(value: Value) -> u64 {
    match value {
        Value::Number(number) => number.to_bits(),
        Value::Count(count) => count,
        Value::ShortCount(count) => count.into(),
        Value::Flags(flags) => flags.0.into(),
        Value::Phase(phase) => Phase::ALL
            .iter()
            .position(|known| *known == phase)
            .map_or(u64::MAX, |code| code as u64),
    }
}
