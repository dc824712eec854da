//! Content and shortcomings of recordings.

mod curves;
mod put_scene;
mod replay;
pub mod report;
mod scene;
mod ticks;
mod world_path;

pub use curves::RecordedCurves;
pub use put_scene::{PutSceneError, put_scene};
pub use replay::{RecordingReplay, RecordingReplayError, ReplayOf, ReplayedRecording, StatedHand};
pub use scene::{NoScene, scene_edited, scene_of};
pub use ticks::{HeldDevice, Ticks, TicksError};
pub use world_path::{WorldPathError, world_path};

pub use palpate_record::recording::DEVICES;
use palpate_record::recording::{Gap, LoopTime, Recording, WHOLE};

use crate::text::{counted, digits};

/// Maximum number of gaps listed individually.
const MAX_GAPS: usize = 5;

/// Returns the shortcomings of a recording as sentences.
#[must_use]
pub fn shortcomings(recording: &Recording) -> Vec<String> {
    let mut words = Vec::new();
    if let Some(tail) = &recording.tail {
        let there = match recording.last {
            Some(last) => format!(
                "{} can be read, up to tick {} at {:.3} s",
                counted(recording.ticks, "tick"),
                last.sequence,
                last.time
            ),
            None => "no tick can be read".to_owned(),
        };
        words.push(format!("not complete: {tail}; {there}"));
    }
    if recording.lost() > 0 {
        let known = recording.ticks.saturating_add(recording.lost());
        words.push(format!(
            "{} of {} lost: {}",
            recording.lost(),
            counted(known, "tick"),
            gaps(&recording.missing)
        ));
    }
    if recording.lost_events() > 0 {
        let made = recording.events.saturating_add(recording.lost_events());
        words.push(format!(
            "{} of {} lost",
            recording.lost_events(),
            counted(made, "event")
        ));
    }
    words.extend(recording.damage.iter().map(|damage| {
        if damage.starts_with(WHOLE) {
            format!("{damage}; the data that were read have matching checksums of their own")
        } else {
            format!("corrupt and skipped: {damage}")
        }
    }));
    words
}

/// Returns file, state, ticks, losses and size as one line.
#[must_use]
pub fn in_a_line(recording: &Recording) -> String {
    let state = if recording.is_complete() {
        "complete"
    } else if recording.is_whole() {
        "finished"
    } else {
        "not complete"
    };
    let ticks = match recording.ticks_made() {
        Some(made) if made != recording.ticks => {
            format!("{} of {}", recording.ticks, counted(made, "tick"))
        }
        _ => counted(recording.ticks, "tick"),
    };
    let events = match recording.lost_events() {
        0 => String::new(),
        lost => format!(", {} lost", counted(lost, "event")),
    };
    format!(
        "{}: {state}, {ticks}, {} lost{events}, {} MB",
        recording.path().display(),
        recording.lost(),
        digits(1e-6 * recording.bytes as f64),
    )
}

/// Describes for how long, and at the end of how many ticks, the safety layer had the motors off. Without a known
/// time the text gives only the ticks.
#[must_use]
pub fn motors_off(time: Option<LoopTime>, ticks: u64, of: u64) -> String {
    let of_ticks = format!("{ticks} of {}", counted(of, "tick"));
    let percent = |part: f64, of: f64| digits(if of > 0.0 { 100.0 * part / of } else { 0.0 });
    match time {
        Some(LoopTime { lasted, motors_off }) => {
            let (off, all) = (motors_off.as_secs_f64(), lasted.as_secs_f64());
            format!(
                "the safety layer kept the motors off for {} s of {} s ({} %), and at the end of {of_ticks}",
                digits(off),
                digits(all),
                percent(off, all)
            )
        }
        None => format!(
            "the safety layer kept the motors off for {of_ticks} ({} %)",
            percent(ticks as f64, of as f64)
        ),
    }
}

/// Describes how many samples the renderer rejected.
#[must_use]
pub fn refused(ticks: u64, of: u64) -> String {
    format!(
        "the renderer refused the samples of {ticks} of {}; its force was 0 there",
        counted(of, "tick")
    )
}

fn gaps(missing: &[Gap]) -> String {
    let mut words: Vec<String> = missing
        .iter()
        .take(MAX_GAPS)
        .map(|gap| match gap.after {
            Some(after) => format!("{} after tick {after}", gap.count),
            None => format!("{} before the first", gap.count),
        })
        .collect();
    if missing.len() > MAX_GAPS {
        words.push(format!("further gaps: {}", missing.len() - MAX_GAPS));
    }
    words.join(", ")
}
