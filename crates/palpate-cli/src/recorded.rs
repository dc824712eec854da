//! Recordings, as commands meet them.

use std::path::{Path, PathBuf};

use palpate_io::recording::{Gap, Recording, RecordingError};

use crate::failure::{Failure, tell};
use crate::report::counted;

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
        words.push(format!("not complete: {tail}"));
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
    let damaged = recording.damage.iter();
    words.extend(damaged.map(|damage| format!("not what was written, and left out: {damage}")));
    words
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
