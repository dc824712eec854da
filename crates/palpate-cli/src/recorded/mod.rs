//! Recordings, as commands meet them.

pub mod trace;

use std::path::{Path, PathBuf};

use palpate_record::recording::{Recording, RecordingError};
use palpate_study::recording::shortcomings;

use crate::failure::{Failure, tell};

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
