//! A program that is killed while it records.

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};
use std::time::Duration;

use palpate_record::recording::{Recording, RecordingWriter};

use super::common::{append, bits, content, metadata, row};
use super::files::say;

const KILLS: u64 = 50;

#[test]
fn whenever_it_is_killed_what_was_flushed_is_readable() {
    let program = std::env::current_exe().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut total = 0;
    for kill in 0..KILLS {
        let path = folder.path().join(format!("{kill}.mcap"));
        let mut child = Command::new(&program)
            .args([
                "--exact",
                "kill::record_for_ever",
                "--ignored",
                "--nocapture",
            ])
            .env("PALPATE_RECORDING", &path)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut said = BufReader::new(child.stdout.take().unwrap())
            .lines()
            .map(Result::unwrap);
        // Kill it at an arbitrary time after it has begun.
        let count = |line: &String| {
            line.strip_prefix("flushed ")
                .map(|n| n.parse::<u64>().unwrap())
        };
        let mut flushed = said.by_ref().find_map(|line| count(&line)).unwrap();
        std::thread::sleep(Duration::from_micros(splitmix(kill) % 20_000));
        child.kill().unwrap();
        child.wait().unwrap();
        // Lines printed before the kill.
        for line in said {
            flushed = count(&line).unwrap_or(flushed);
        }
        let recording = Recording::open(&path.with_extension("mcap.part")).unwrap();
        assert!(
            recording.ticks >= flushed,
            "kill {kill}: {} of {flushed}",
            recording.ticks
        );
        assert!(!recording.finished && recording.tail.is_some());
        assert_eq!((recording.lost(), recording.damage.len()), (0, 0));
        let (ticks, _) = content(&recording);
        for (sequence, read) in (0..).zip(&ticks) {
            assert_eq!(bits(read), bits(&row(sequence)));
        }
        assert!(!path.exists());
        total += flushed;
    }
    assert!(total > 20 * KILLS, "{total} ticks in all");
}

/// Not a separate test: the program that is killed.
#[test]
#[ignore = "run by whenever_it_is_killed_what_was_flushed_is_readable"]
fn record_for_ever() {
    let path = std::env::var_os("PALPATE_RECORDING").expect("run by its test");
    let mut writer = RecordingWriter::create(path.as_ref(), &metadata()).unwrap();
    for sequence in 0.. {
        append(&mut writer, sequence).unwrap();
        if sequence % 10 == 9 {
            writer.flush().unwrap();
            say(&format!("flushed {}", sequence + 1));
        }
    }
}

/// Reproducible pseudo-random numbers.
fn splitmix(seed: u64) -> u64 {
    let mut z = seed.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
