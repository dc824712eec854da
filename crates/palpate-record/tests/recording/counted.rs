//! Counters of the loop compared with the content of the file.

use std::path::PathBuf;
use std::time::Duration;

use palpate_record::recording::{Gap, LoopCount, LoopTime, Recording, RecordingWriter};

use super::common::{append, content, count, event, metadata};

/// Returns a recording of `ticks` and of one event, with the counters of its loop.
fn recorded(
    ticks: impl IntoIterator<Item = u64>,
    counted: Option<&LoopCount>,
) -> (tempfile::TempDir, Recording) {
    let folder = tempfile::tempdir().unwrap();
    let path: PathBuf = folder.path().join("r.mcap");
    let mut writer = RecordingWriter::create(&path, &metadata()).unwrap();
    for sequence in ticks {
        append(&mut writer, sequence).unwrap();
    }
    writer.event(&event(1)).unwrap();
    if let Some(counted) = counted {
        writer.count(counted).unwrap();
    }
    writer.finish().unwrap();
    let recording = Recording::open(&path).unwrap();
    (folder, recording)
}

#[test]
fn it_is_complete_where_the_loop_counted_as_much_as_there_is() {
    let counted = LoopCount {
        motors_off: 2,
        time: Some(LoopTime {
            lasted: Duration::from_micros(5_000_001),
            motors_off: Duration::from_millis(3_200),
        }),
        ..count(5, 1)
    };
    let (_folder, recording) = recorded(0..5, Some(&counted));
    assert!(recording.is_complete() && recording.is_whole());
    assert_eq!(recording.counted, Some(counted));
    assert_eq!(recording.ticks_made(), Some(5));
    let size = std::fs::metadata(recording.path()).unwrap().len();
    assert_eq!(recording.bytes, size);
    content(&recording);
}

#[test]
fn a_tail_that_was_lost_is_missing() {
    let (_folder, recording) = recorded(0..5, Some(&count(8, 1)));
    assert!(recording.finished && !recording.is_whole() && !recording.is_complete());
    let tail = Gap {
        after: Some(4),
        count: 3,
    };
    assert_eq!(
        (recording.missing.as_slice(), recording.lost()),
        (&[tail][..], 3)
    );
    // All ticks are missing.
    let (_folder, recording) = recorded([], Some(&count(8, 1)));
    assert_eq!((recording.lost(), recording.ticks_made()), (8, Some(8)));
}

#[test]
fn an_event_that_was_lost_is_missing() {
    let (_folder, recording) = recorded(0..5, Some(&count(5, 3)));
    assert_eq!((recording.lost(), recording.lost_events()), (0, 2));
    assert!(!recording.is_whole());
}

#[test]
fn more_than_the_loop_counted_is_not_what_was_written() {
    for counted in [count(4, 1), count(5, 0)] {
        let (_folder, recording) = recorded(0..5, Some(&counted));
        assert!(!recording.is_whole());
        assert_eq!(recording.damage.len(), 1, "{:?}", recording.damage);
        assert!(recording.damage[0].contains("the counters of the loop"));
    }
}

/// No data are known to be missing, but missing ticks at the end cannot be excluded.
#[test]
fn without_the_count_it_is_whole_and_not_complete() {
    let (_folder, recording) = recorded(0..5, None);
    assert!(recording.is_whole() && !recording.is_complete());
    assert_eq!(recording.ticks_made(), None);
}

/// Recordings of older versions have no counters, and the event of the loop's end names its last tick.
#[test]
fn an_event_of_the_end_says_how_many_ticks_there_were() {
    let folder = tempfile::tempdir().unwrap();
    for (last, is_complete) in [(4, true), (6, false)] {
        let path = folder.path().join(format!("{last}.mcap"));
        let mut writer = RecordingWriter::create(&path, &metadata()).unwrap();
        for sequence in 0..5 {
            append(&mut writer, sequence).unwrap();
        }
        let ended = palpate_record::recording::Event {
            kind: "ended".into(),
            ..event(last)
        };
        writer.event(&ended).unwrap();
        writer.finish().unwrap();
        let recording = Recording::open(&path).unwrap();
        assert_eq!(recording.ticks_made(), Some(last + 1));
        assert_eq!(recording.is_complete(), is_complete);
        assert_eq!(recording.lost(), last - 4);
    }
}
