//! Recordings for tests.

use std::path::{Path, PathBuf};

use palpate_record::files::atomic::WriteError;
use palpate_record::recording::{
    BodyTick, ContactTick, DeviceTick, Entry, Event, Flags, LoopCount, Phase, Recording,
    RecordingError, RecordingMetadata, RecordingWriter, Row, Tick, Value,
};

/// Returns a row in which every quantity has a distinct value that follows from the tick's number.
pub fn row(sequence: u64) -> Row {
    let t = sequence as f64 / 1000.0;
    let of = |quantity: f64| quantity / 3.0 + t;
    let position = 0.02 * (9.0 * t).sin();
    let flags = Flags::CONTACT.with(Flags::LIMITED_SLEW, sequence.is_multiple_of(2));
    Row {
        tick: Tick {
            device_orientation: [of(12.0), of(13.0), f64::NAN, -0.0],
            commanded_force: [of(14.0), of(15.0), of(16.0)],
            commanded_torque: [of(17.0), of(18.0), of(19.0)],
            delivered_force: [of(20.0), of(21.0), of(22.0)],
            // The recordings by other tools are older than these columns.
            delivered_slope: [f64::NAN; 3],
            delivered_torque: [of(23.0), of(24.0), f64::NEG_INFINITY],
            sequence,
            time: t,
            lateness: 1e-6 * of(1.0),
            period: if sequence == 0 { f64::NAN } else { 0.001 },
            device_axes: [position, of(2.0), f64::NAN],
            tick_duration: 4e-6,
            device_round_trip: of(11.0),
            generation: u32::from(sequence > 4),
            contacts: 1,
            flags,
            ..Tick::UNKNOWN
        },
        contact: ContactTick {
            sequence,
            contact: 0,
            flags,
            device_position: position,
            object_position: 0.01 + 0.001 * (31.0 * t).cos(),
            object_velocity: -of(3.0),
            penetration: of(4.0),
            proxy_shift: -0.0,
            force_on_object: of(5.0),
            force_on_device: -of(5.0),
            stored_energy: of(6.0),
            port_work: of(7.0),
            virtual_force_work: of(8.0),
            outside_work: f64::INFINITY,
            original_leak: of(9.0),
            held_leak: of(10.0),
            phase: Phase::ALL[usize::try_from(sequence % 5).unwrap()],
            ..ContactTick::UNKNOWN
        },
        ..Row::UNKNOWN
    }
}

/// Appends the row of a tick with this number.
pub fn append(writer: &mut RecordingWriter, sequence: u64) -> Result<(), WriteError> {
    let Row { tick, contact, .. } = row(sequence);
    writer.append(&tick, &[contact])
}

/// Returns an event at a tick.
pub fn event(sequence: u64) -> Event {
    Event {
        sequence,
        time: row(sequence).tick.time,
        kind: "parameters".into(),
        text: format!("stiffness now {sequence} N/m, µ as before"),
    }
}

/// Returns the counters of a loop with `ticks` and `events`.
pub fn count(ticks: u64, events: u64) -> LoopCount {
    LoopCount {
        ticks,
        events,
        motors_off: 0,
        time: None,
        ending: Some("its time was over".into()),
    }
}

/// Returns the metadata of these recordings.
pub fn metadata() -> RecordingMetadata {
    RecordingMetadata::new("0.1.0")
        .with("scene", "scene_format = 1\ntitle = \"a test\"\n")
        .with_file("hand.csv", "t_s,position_m\n0,0\n1,0\n")
}

/// Returns every column by its name, with the bits of its number, so that NaN equals NaN.
pub fn bits(row: &Row) -> Vec<(&'static str, u64)> {
    let of_parts = [
        Tick::COLUMNS,
        ContactTick::COLUMNS,
        BodyTick::COLUMNS,
        DeviceTick::COLUMNS,
    ];
    let columns = of_parts.into_iter().flatten();
    columns
        .map(|column| {
            let bits = match column.value(row) {
                Value::Count(count) => count,
                value => value.number().to_bits(),
            };
            (column.name, bits)
        })
        .collect()
}

/// Returns a recording of three flushes of three ticks each, with an event in the second, finished or not, as bytes,
/// and the length of the file after each flush.
pub fn small(finished: bool) -> (Vec<u8>, Vec<usize>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("small.mcap");
    let mut writer = RecordingWriter::create(&path, &metadata()).unwrap();
    let part = writer.part().to_owned();
    let size = || usize::try_from(std::fs::metadata(&part).unwrap().len()).unwrap();
    let mut sizes = vec![size()];
    for flush in 0..3 {
        for sequence in 3 * flush..3 * flush + 3 {
            append(&mut writer, sequence).unwrap();
            if sequence == 4 {
                writer.event(&event(4)).unwrap();
            }
        }
        writer.flush().unwrap();
        sizes.push(size());
    }
    if finished {
        writer.count(&count(9, 1)).unwrap();
        writer.finish().unwrap();
        (std::fs::read(path).unwrap(), sizes)
    } else {
        drop(writer);
        (std::fs::read(part).unwrap(), sizes)
    }
}

/// A temporary file.
pub struct Scratch {
    _folder: tempfile::TempDir,
    pub path: PathBuf,
}

impl Scratch {
    pub fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.mcap");
        Self {
            _folder: folder,
            path,
        }
    }

    pub fn open(&self, bytes: &[u8]) -> Result<Recording, RecordingError> {
        // On some file systems replacing an existing file synchronises it to disk, which takes long.
        let _ = std::fs::remove_file(&self.path);
        std::fs::write(&self.path, bytes).unwrap();
        Recording::open(&self.path)
    }
}

/// Returns all ticks, of one contact each, and all events of a recording, checked against its counts.
pub fn content(recording: &Recording) -> (Vec<Row>, Vec<Event>) {
    let (mut rows, mut events) = (Vec::new(), Vec::new());
    for entry in recording.entries().unwrap() {
        match entry.unwrap() {
            Entry::Tick(tick, contacts, _, _) => {
                assert_eq!(contacts.len(), 1, "tick {}", tick.sequence);
                rows.extend(Row::new(tick, &contacts));
            }
            Entry::Event(event) => events.push(event),
        }
    }
    assert_eq!(rows.len() as u64, recording.ticks);
    assert_eq!(events.len() as u64, recording.events);
    let said = |tick: Option<Tick>| {
        tick.map(|tick| {
            bits(&Row {
                tick,
                ..Row::UNKNOWN
            })
        })
    };
    let ends = [rows.first(), rows.last()].map(|row| said(row.map(|row| row.tick)));
    assert_eq!(ends, [recording.first, recording.last].map(said));
    assert!(recording.has_one_contact_each);
    (rows, events)
}

/// Returns the sorted names in a directory.
pub fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}
