//! A committed recording of the format, which all versions of the program with this format must read.

use std::path::{Path, PathBuf};

use palpate_record::recording::{Recording, RecordingWriter};

use super::common::{Scratch, append, bits, content, event, metadata, row};

fn golden() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/recording/golden.mcap")
}

#[test]
fn the_committed_recording_is_read() {
    let recording = Recording::open(&golden()).unwrap();
    assert_eq!(recording.metadata, metadata());
    assert!(recording.finished && recording.damage.is_empty());
    let (ticks, events) = content(&recording);
    assert_eq!(events, [event(4)]);
    // Tick 5 is lost.
    let numbers = [0, 1, 2, 3, 4, 6, 7, 8];
    assert_eq!(recording.lost(), 1);
    // The loop's counters were not recorded.
    assert_eq!(
        (recording.counted.clone(), recording.ticks_made()),
        (None, None)
    );
    assert!(!recording.is_complete());
    assert_eq!(ticks.len(), numbers.len());
    for (read, sequence) in ticks.iter().zip(numbers) {
        assert_eq!(bits(read), bits(&row(sequence)));
    }
}

/// The format defines the content of a message and its channel.
#[test]
fn it_is_read_without_the_chunk_that_has_its_types() {
    let mut bytes = std::fs::read(golden()).unwrap();
    let text = b"# One tick of a haptic loop";
    let at = bytes.windows(text.len()).position(|window| window == text);
    bytes[at.unwrap()] ^= 1;
    let scratch = Scratch::new();
    let recording = scratch.open(&bytes).unwrap();
    assert_eq!(recording.damage.len(), 2, "{:?}", recording.damage);
    let (ticks, events) = content(&recording);
    assert_eq!((ticks.len(), events), (8, vec![event(4)]));
    for read in &ticks {
        assert_eq!(bits(read), bits(&row(read.tick.sequence)));
    }
}

/// Not a separate test: it writes the committed recording.
#[test]
#[ignore = "writes PALPATE_RECORDING, the committed recording"]
fn write_golden() {
    let path = std::env::var_os("PALPATE_RECORDING").expect("a path to write to");
    let mut writer = RecordingWriter::create(Path::new(&path), &metadata()).unwrap();
    for sequence in [0, 1, 2, 3, 4, 6, 7, 8] {
        append(&mut writer, sequence).unwrap();
        if sequence == 4 {
            writer.event(&event(4)).unwrap();
        }
        if sequence % 3 == 2 {
            writer.flush().unwrap();
        }
    }
    writer.finish().unwrap();
}
