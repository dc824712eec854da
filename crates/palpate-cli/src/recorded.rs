//! Recordings, as commands meet them.

use std::path::{Path, PathBuf};

use palpate_record::recording::{Gap, Recording, RecordingError, WHOLE};

use crate::failure::{Failure, tell};
use crate::report::{counted, digits};

/// Gaps that are told one by one.
const MOST_GAPS: usize = 5;

/// Opens a recording, whole or not.
pub fn open(path: &Path) -> Result<Recording, Failure> {
    Recording::open(path).map_err(|error| match error {
        RecordingError::Unreadable { .. } => {
            let mut part = path.as_os_str().to_owned();
            part.push(".part");
            let part = PathBuf::from(part);
            let unfinished = if !path.exists() && part.exists() {
                format!(
                    "; there is an unfinished one: read {} in its place",
                    part.display()
                )
            } else {
                String::new()
            };
            Failure::System(format!("{error}{unfinished}"))
        }
        RecordingError::Invalid { .. } => Failure::input(error),
    })
}

/// What is not as it should be with a recording, in sentences.
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
            format!("{damage}; what is read stands in parts whose own checksums fit")
        } else {
            format!("not what was written, and left out: {damage}")
        }
    }));
    words
}

/// File, state, ticks, losses and size, in a line.
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

/// Says on standard error what is not as it should be, if anything is; the command has done what it
/// could, and ends with an exit code of its own.
pub fn whole_or_said(recording: &Recording) -> Result<(), Failure> {
    for words in shortcomings(recording) {
        tell(format_args!(
            "warning: {}: {words}",
            recording.path().display()
        ));
    }
    whole_or_code(recording)
}

/// The exit code alone.
pub fn whole_or_code(recording: &Recording) -> Result<(), Failure> {
    if recording.is_whole() {
        Ok(())
    } else {
        Err(Failure::NotWhole)
    }
}

fn gaps(missing: &[Gap]) -> String {
    let mut words: Vec<String> = missing
        .iter()
        .take(MOST_GAPS)
        .map(|gap| match gap.after {
            Some(after) => format!("{} after tick {after}", gap.count),
            None => format!("{} before the first", gap.count),
        })
        .collect();
    if missing.len() > MOST_GAPS {
        words.push(format!("and in {} places more", missing.len() - MOST_GAPS));
    }
    words.join(", ")
}
