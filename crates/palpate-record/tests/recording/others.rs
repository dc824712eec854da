//! Recordings rewritten by another tool, the MCAP library for Python: that of `golden.mcap`, with the counters
//! of the loop. `others.py` in the same directory makes the files.

use std::path::Path;

use palpate_record::recording::LoopCount;

use super::common::{Scratch, bits, content, count, event, metadata, row, small};

fn bytes_of(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/recording/others");
    std::fs::read(folder.join(name)).unwrap()
}

#[test]
fn chunks_in_lz4_and_zstd_are_read() {
    for name in [
        "lz4.mcap",
        "zstd.mcap",
        "plain.mcap",
        "unchunked.mcap",
        "metadata-last.mcap",
    ] {
        let scratch = Scratch::new();
        let recording = scratch.open(&bytes_of(name)).unwrap();
        assert_eq!(recording.damage, [] as [String; 0], "{name}");
        assert!(recording.is_complete(), "{name}: {recording:?}");
        assert_eq!(recording.metadata, metadata(), "{name}");
        let counted: Option<LoopCount> = Some(count(9, 1));
        assert_eq!(recording.counted, counted, "{name}");
        let (ticks, events) = content(&recording);
        assert_eq!((ticks.len(), events), (9, vec![event(4)]), "{name}");
        for (sequence, read) in (0..).zip(&ticks) {
            assert_eq!(bits(read), bits(&row(sequence)), "{name}");
        }
    }
}

#[test]
fn a_changed_bit_in_what_is_compressed_is_no_tick() {
    for name in ["lz4.mcap", "zstd.mcap"] {
        let bytes = bytes_of(name);
        let scratch = Scratch::new();
        let mut opened = 0;
        for at in (0..bytes.len()).step_by(3) {
            let mut changed = bytes.clone();
            changed[at] ^= 1 << (at % 8);
            // The changed byte may be in the metadata.
            let Ok(recording) = scratch.open(&changed) else {
                continue;
            };
            opened += 1;
            let (ticks, _) = content(&recording);
            for read in &ticks {
                assert_eq!(
                    bits(read),
                    bits(&row(read.tick.sequence)),
                    "{name}: byte {at}"
                );
            }
        }
        assert!(opened > 1000, "{name}: {opened}");
    }
}

#[test]
fn what_is_left_of_a_cut_one_is_read() {
    for name in ["lz4.mcap", "zstd.mcap", "plain.mcap"] {
        let bytes = bytes_of(name);
        let scratch = Scratch::new();
        let mut most = 0;
        for length in (0..bytes.len()).step_by(3) {
            let Ok(recording) = scratch.open(&bytes[..length]) else {
                continue;
            };
            assert!(!recording.finished, "{name}: {length}");
            let (ticks, _) = content(&recording);
            for (sequence, read) in (0..).zip(&ticks) {
                assert_eq!(bits(read), bits(&row(sequence)), "{name}: {length}");
            }
            most = most.max(ticks.len());
        }
        assert_eq!(most, 9, "{name}");
    }
}

#[test]
fn another_compression_is_named() {
    let (bytes, _) = small(true);
    let mut renamed = bytes_of("lz4.mcap");
    let at = renamed.windows(3).position(|word| word == b"lz4").unwrap();
    renamed[at..at + 3].copy_from_slice(b"lzx");
    let recording = Scratch::new().open(&renamed).unwrap();
    assert!(
        recording.damage[0].contains("its compression is `lzx`"),
        "{:?}",
        recording.damage
    );
    assert!(Scratch::new().open(&bytes).unwrap().is_complete());
}

/// Not a separate test: it writes the input of `others.py`.
#[test]
#[ignore = "writes PALPATE_RECORDING, for others.py"]
fn write_small() {
    let path = std::env::var_os("PALPATE_RECORDING").expect("a path to write to");
    std::fs::write(path, small(true).0).unwrap();
}
