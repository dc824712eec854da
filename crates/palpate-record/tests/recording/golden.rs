//! A recording that was written once, by the first version of the format, and is read for ever.

use std::path::Path;

use palpate_record::recording::Recording;

use super::common::{bits, content, event, receipt, tick};

#[test]
fn the_first_recording_is_still_read() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/recording/golden-v1.mcap");
    let recording = Recording::open(&path).unwrap();
    assert_eq!(recording.receipt, receipt());
    assert!(recording.finished && recording.damage.is_empty());
    let (ticks, events) = content(&recording);
    assert_eq!(events, [event(4)]);
    // Tick 5 was lost.
    let numbers = [0, 1, 2, 3, 4, 6, 7, 8];
    assert_eq!(recording.lost(), 1);
    // Nobody wrote down how many the loop made.
    assert_eq!(
        (recording.counted.clone(), recording.ticks_made()),
        (None, None)
    );
    assert!(!recording.is_complete());
    assert_eq!(ticks.len(), numbers.len());
    for (read, sequence) in ticks.iter().zip(numbers) {
        assert_eq!(bits(read), bits(&tick(sequence)));
    }
}
