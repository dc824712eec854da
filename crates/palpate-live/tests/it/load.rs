//! Many clients at 4 kHz, one of which has stopped reading, with a recording: nothing is lost.
//!
//! Three seconds here; `PALPATE_LOAD_SECONDS=60 cargo test --release -p palpate-live --test it load:: --
//! --nocapture` measures the numbers of docs/results/interfaces.md.

#![allow(clippy::print_stdout)] // it says what it measured

use std::time::{Duration, Instant};

use crate::common::{Play, Received, Stage, scene};
use palpate_record::recording::{Entry, Recording};

/// Clients that read, and one that does not.
const READING: usize = 7;

#[test]
fn eight_clients_and_a_recording_at_four_kilohertz_lose_nothing() {
    let seconds = std::env::var("PALPATE_LOAD_SECONDS").map_or(3.0, |text| text.parse().unwrap());
    let mut fast = scene();
    fast.loop_params.period = 0.000_25;
    let stage = Stage::new(Play {
        scene: fast,
        ..Play::default()
    });
    let mut first = stage.client();
    first.say(r#"{"type":"record","on":true}"#);
    first.until("state", |state| state["recording"].is_object());
    let _stopped = stage.client();
    let duration = Duration::from_secs_f64(seconds);
    let rates: Vec<f64> = std::thread::scope(|scope| {
        let readers: Vec<_> = (0..READING)
            .map(|_| {
                let mut client = stage.client();
                scope.spawn(move || {
                    let (mut frames, mut next) = (0_u32, None);
                    let begun = Instant::now();
                    while begun.elapsed() < duration {
                        if let Received::Samples(samples) = client.next() {
                            let expected = next.unwrap_or(samples.number);
                            assert_eq!(samples.number, expected, "a frame was dropped");
                            next = Some(samples.number + 1);
                            frames += 1;
                        }
                    }
                    f64::from(frames) / begun.elapsed().as_secs_f64()
                })
            })
            .collect();
        readers
            .into_iter()
            .map(|reader| reader.join().unwrap())
            .collect()
    });
    let mut last = stage.client();
    let status = last.text("status");
    last.say(r#"{"type":"record","on":false}"#);
    last.until("note", |note| {
        note["text"].as_str().unwrap().contains("is written")
    });
    let lane = &status["lanes"][0];
    assert_eq!(lane["unsent"], 0, "{lane}");
    assert_eq!(status["recording"]["lost"], 0);
    let recording = Recording::open(&stage.folder.path().join("live-001.mcap")).unwrap();
    assert!(recording.is_whole());
    let mut expected = 0;
    for entry in recording.entries().unwrap() {
        if let Entry::Tick(tick, ..) = entry.unwrap() {
            assert_eq!(tick.sequence, expected, "by its number");
            expected += 1;
        }
    }
    let slowest = rates.iter().copied().fold(f64::INFINITY, f64::min);
    println!(
        "{seconds} s: {expected} ticks in the file, none missing; {READING} clients at {slowest:.1} \
         frames a second or more; missed deadlines {}, lateness {}, tick {}",
        lane["missed_deadlines"], lane["lateness_s"], lane["tick_s"]
    );
    // A busy machine may miss deadlines, but what was ticked is here.
    assert!(expected as f64 > 2000.0 * seconds, "{expected} ticks");
    assert!(slowest > 40.0, "{slowest} frames a second");
}
