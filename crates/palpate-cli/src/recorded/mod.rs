//! Recordings in commands.

pub mod trace;

use std::path::{Path, PathBuf};

use palpate_record::recording::{Recording, RecordingError};
use palpate_study::recording::shortcomings;

use crate::failure::{Failure, tell};

/// Returns whether a file name has this ending, in small or capital letters.
pub fn ends_in(path: &Path, ending: &str) -> bool {
    path.extension()
        .is_some_and(|it| it.eq_ignore_ascii_case(ending))
}

/// Opens a recording, complete or incomplete.
pub fn open(path: &Path) -> Result<Recording, Failure> {
    Recording::open(path).map_err(|error| match error {
        RecordingError::Unreadable { .. } => {
            let mut part = path.as_os_str().to_owned();
            part.push(".part");
            let part = PathBuf::from(part);
            let unfinished = if !path.exists() && part.exists() {
                format!(
                    "; an unfinished recording exists: read {} instead",
                    part.display()
                )
            } else {
                String::new()
            };
            Failure::System(format!("{error}{unfinished}"))
        }
        RecordingError::Invalid { .. } => {
            let other = if ends_in(path, "toml") {
                "; a .toml file is a scene, for `palpate simulate` or `palpate run`"
            } else if ends_in(path, "csv") {
                "; a .csv file is a table, for `palpate render`"
            } else {
                ""
            };
            Failure::input(format_args!("{error}{other}"))
        }
    })
}

/// Reports defects of a recording on standard error. The command has done all it could, and ends with a separate exit
/// code.
pub fn whole_or_said(recording: &Recording) -> Result<(), Failure> {
    for words in shortcomings(recording) {
        tell(format_args!(
            "warning: {}: {words}",
            recording.path().display()
        ));
    }
    whole_or_code(recording)
}

/// Returns the exit code without a message.
pub fn whole_or_code(recording: &Recording) -> Result<(), Failure> {
    if recording.is_whole() {
        Ok(())
    } else {
        Err(Failure::NotWhole)
    }
}
