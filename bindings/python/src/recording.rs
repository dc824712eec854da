//! Recordings of loops with a device, as arrays.

use std::path::PathBuf;

use numpy::PyArray1;
use palpate_record::recording::{
    BodyTick, DeviceTick, Entry, Event, Flags, Kind, Phase, Recording, Row, Value, columns,
};
use palpate_study::recording::report::RecordingReport;
use pyo3::prelude::*;

use crate::columns::{Words, array};
use crate::interrupt::interruptible;
use crate::replay::unread;

/// Returns the columns of a row of a recording, which is a tick and a contact: the name of each, and whether it is a
/// number or a count; and the meaning of the codes: phases, and flags by bit.
#[pyfunction]
pub fn recorded_columns() -> (Vec<(&'static str, bool)>, [Vec<&'static str>; 2]) {
    let columns = columns()
        .iter()
        .map(|column| (column.name, column.kind == Kind::Number));
    let phases = Phase::ALL.into_iter().map(Phase::name).collect();
    let flags = Flags::NAMED.into_iter().map(|(_, name)| name).collect();
    (columns.collect(), [phases, flags])
}

/// Content of a recording.
type InPython<'py> = (
    (String, String),
    Bound<'py, PyArray1<u64>>,
    Vec<(u64, f64, String, String)>,
    Vec<(String, String)>,
    Bound<'py, PyArray1<u64>>,
    Bound<'py, PyArray1<u64>>,
);

/// Reads a recording: its report as JSON and as text, its rows (one per contact of a tick), its events, its metadata
/// texts, the bodies of a world, and the devices of a loop with several.
#[pyfunction]
pub fn read_recording(py: Python<'_>, path: PathBuf) -> PyResult<InPython<'_>> {
    let read = interruptible(py, move |stop| {
        let recording = Recording::open(&path)?;
        let report = RecordingReport::new(&recording)?;
        let (mut words, mut of_bodies, mut of_devices) = (Words::new(), Words::new(), Words::new());
        let mut events = Vec::new();
        for entry in recording.entries()? {
            match entry? {
                Entry::Tick(tick, contacts, bodies, devices) => {
                    of_bodies.extend(bodies.iter().flat_map(body));
                    of_devices.extend(devices.iter().flat_map(device));
                    for row in Row::new(tick, &contacts) {
                        words.extend(columns().iter().map(|column| word(column.value(&row))));
                    }
                }
                Entry::Event(event) => events.push(event),
            }
            stop.leave_if_raised();
        }
        let said = (palpate_study::json(&report), report.to_string());
        let texts = recording.metadata.texts;
        Ok((said, words, events, texts, of_bodies, of_devices))
    })?;
    let (said, words, events, texts, of_bodies, of_devices) = read.map_err(unread)?;
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
        array(py, of_devices),
    ))
}

/// Number of words of a body at a tick: tick number, body number, pose and velocities.
const BODY: usize = 15;

/// Returns a body at a tick as words.
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

/// Number of words of one of several devices at a tick: tick number, device number, flags, sampling time, round-trip
/// time, position and orientation, and commanded wrench, and held force, slope and torque.
const DEVICE: usize = 27;

/// Returns one of several devices at a tick as words.
pub fn device(device: &DeviceTick) -> [u64; DEVICE] {
    let mut words = [0; DEVICE];
    words[0] = device.sequence;
    words[1] = device.device.into();
    words[2] = device.flags.0.into();
    let times = [device.time, device.round_trip];
    let numbers = times.iter().chain(&device.axes).chain(&device.orientation);
    let numbers = numbers
        .chain(&device.commanded_force)
        .chain(&device.commanded_torque)
        .chain(&device.delivered_force)
        .chain(&device.delivered_slope)
        .chain(&device.delivered_torque);
    for (word, number) in words[3..].iter_mut().zip(numbers) {
        *word = number.to_bits();
    }
    words
}

/// Returns a value as a 64-bit word: a number or a count.
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
