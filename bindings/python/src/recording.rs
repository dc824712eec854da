//! Recordings of loops with a device, as arrays.

use std::path::PathBuf;

use numpy::PyArray1;
use palpate_record::recording::{
    BodyTick, Entry, Event, Flags, Kind, Phase, Recording, Row, Value, columns,
};
use palpate_study::recording::report::RecordingReport;
use pyo3::prelude::*;

use crate::columns::{Words, array};
use crate::interrupt::interruptible;
use crate::replay::unread;

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
    Bound<'py, PyArray1<u64>>,
);

/// Reads a recording: the report on it as JSON and as text, its rows, one for each contact of a tick, its events, the texts of its
/// receipt, and the bodies of a world.
#[pyfunction]
pub fn read_recording(py: Python<'_>, path: PathBuf) -> PyResult<InPython<'_>> {
    let read = interruptible(py, move |stop| {
        let recording = Recording::open(&path)?;
        let report = RecordingReport::new(&recording)?;
        let (mut words, mut of_bodies) = (Words::new(), Words::new());
        let mut events = Vec::new();
        for entry in recording.entries()? {
            match entry? {
                Entry::Tick(tick, contacts, bodies, _) => {
                    of_bodies.extend(bodies.iter().flat_map(body));
                    for row in Row::of(tick, &contacts) {
                        words.extend(columns().iter().map(|column| word(column.value(&row))));
                    }
                }
                Entry::Event(event) => events.push(event),
            }
            stop.leave_if_raised();
        }
        let said = (palpate_study::json(&report), report.to_string());
        Ok((said, words, events, recording.receipt.texts, of_bodies))
    })?;
    let (said, words, events, texts, of_bodies) = read.map_err(unread)?;
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
        array(py, of_bodies),
    ))
}

/// Words of a body at a tick: number of the tick, number of the body, its place and its motion.
const BODY: usize = 15;

/// A body at a tick, in words.
pub fn body(body: &BodyTick) -> [u64; BODY] {
    let mut words = [0; BODY];
    words[0] = body.sequence;
    words[1] = body.body.into();
    let numbers = body.position.iter().chain(&body.orientation);
    let numbers = numbers.chain(&body.velocity).chain(&body.angular_velocity);
    for (word, number) in words[2..].iter_mut().zip(numbers) {
        *word = number.to_bits();
    }
    words
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
