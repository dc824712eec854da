//! Failures for the user at the terminal: a message, a position, an exit code.

use std::borrow::Cow;
use std::fmt;
use std::io::{self, Write};
use std::ops::Range;
use std::process::ExitCode;

use palpate_plot::map::NotInTheMap;
use palpate_record::files::atomic::{WriteError, WriteFault};
use palpate_record::files::outputs::OutputError;
use palpate_scene::SceneError;
use palpate_study::map::metadata::NoNumber;
use palpate_study::recording::PutSceneError;

use crate::excerpt::Excerpt;

/// Reason for a command's end without its result.
#[derive(Debug)]
pub enum Failure {
    /// A file could not be read or written: exit code 1.
    System(String),
    /// The arguments are wrong: exit code 2.
    Arguments(String),
    /// An input file is invalid, in one position or in several: exit code 3.
    Input(Vec<InputFault>),
    /// The command is done, but the recording that it read or made is incomplete, which has been reported: exit code 4.
    NotWhole,
    /// The loop ran, but without a force at its end or for most of it, because safety disabled the motors or the
    /// renderer rejected the samples; or a pipe rejected every line or was stopped by safety: exit code 5.
    MotorsOff(String),
    /// The device or its hand prevents a result: exit code 6.
    Declined(String),
    /// A signal of the user ended the command early: exit code 130, as in a shell after ctrl-C.
    Interrupted(String),
}

/// An error in a file of the user.
#[derive(Debug)]
pub struct InputFault {
    /// Description of the error, its position (`file:line:column`) and the allowed values.
    pub message: String,
    /// The erroneous text and the bytes to mark, if there is text.
    pub excerpt: Option<Excerpt>,
}

impl From<WriteError> for Failure {
    fn from(error: WriteError) -> Self {
        let remedy = match error.fault {
            WriteFault::Exists => "; name another, or replace it with --overwrite",
            _ => "",
        };
        Self::System(format!("{error}{remedy}"))
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Self {
        match error {
            OutputError::Write(error) => error.into(),
            OutputError::IsInput { .. }
            | OutputError::IsKept { .. }
            | OutputError::Twice { .. } => Self::Arguments(error.to_string()),
        }
    }
}

impl From<NotInTheMap> for Failure {
    fn from(error: NotInTheMap) -> Self {
        let flag = match error {
            NotInTheMap::Quantity(_) => "--show ",
            NotInTheMap::Method { .. } => "--method ",
            NotInTheMap::Number(_) => "",
        };
        Self::input(format!("{flag}{error}"))
    }
}

impl From<NoNumber> for Failure {
    fn from(error: NoNumber) -> Self {
        Self::input(error)
    }
}

impl From<PutSceneError> for Failure {
    fn from(error: PutSceneError) -> Self {
        match error {
            PutSceneError::Invalid(faults) => Self::inputs(faults),
            PutSceneError::Changed { .. } => Self::Arguments(error.to_string()),
            other => Self::System(other.to_string()),
        }
    }
}

impl Failure {
    /// Adds the name of one of several items before the message.
    pub fn of(self, name: &str) -> Self {
        let of = |message: String| format!("{name}: {message}");
        match self {
            Self::System(message) => Self::System(of(message)),
            Self::Arguments(message) => Self::Arguments(of(message)),
            Self::MotorsOff(message) => Self::MotorsOff(of(message)),
            other => other,
        }
    }

    /// Creates an error in an input file without a position.
    pub fn input(message: impl fmt::Display) -> Self {
        Self::Input(vec![InputFault {
            message: message.to_string(),
            excerpt: None,
        }])
    }

    /// Creates an error in an input file, shown in its text.
    pub fn input_at(
        message: impl fmt::Display,
        file: &str,
        text: &str,
        span: Range<usize>,
    ) -> Self {
        Self::Input(vec![InputFault {
            message: message.to_string(),
            excerpt: Some(Excerpt::new(file, text, span)),
        }])
    }

    /// Creates the errors of scene files, each shown in its text. Errors in flags alone are wrong arguments.
    pub fn inputs(faults: impl IntoIterator<Item = SceneError>) -> Self {
        let faults: Vec<_> = faults.into_iter().collect();
        if faults.iter().all(|fault| fault.flag.is_some()) {
            let faults: Vec<_> = faults.iter().map(ToString::to_string).collect();
            return Self::Arguments(faults.join("\n"));
        }
        let faults = faults.into_iter().map(|fault| InputFault {
            message: fault.to_string(),
            excerpt: (fault.flag.is_none())
                .then(|| Excerpt::new(&fault.file, &fault.source_text, fault.span)),
        });
        Self::Input(faults.collect())
    }

    /// Returns the message.
    pub fn message(&self) -> String {
        match self {
            Self::System(message)
            | Self::Arguments(message)
            | Self::MotorsOff(message)
            | Self::Declined(message)
            | Self::Interrupted(message) => message.clone(),
            Self::Input(faults) => {
                let messages: Vec<_> = faults.iter().map(|fault| fault.message.as_str()).collect();
                messages.join("\n")
            }
            Self::NotWhole => "a recording is incomplete".to_owned(),
        }
    }

    /// Prints the failure to standard error. Returns the exit code.
    pub fn report(&self) -> ExitCode {
        let (message, code) = match self {
            Self::System(message) => (message.clone(), 1),
            Self::Arguments(message) => (
                format!("{message}\n\nFor more information, try '--help'."),
                2,
            ),
            Self::Input(faults) => {
                let drawn = faults.iter().map(|fault| {
                    let message = printable(&fault.message);
                    match &fault.excerpt {
                        Some(excerpt) => format!("{message}\n{}", excerpt.drawing()),
                        None => message.into_owned(),
                    }
                });
                let drawn: Vec<_> = drawn.collect();
                // The drawings may have colours.
                write_line(&format!("error: {}", drawn.join("\n\nerror: ")));
                return ExitCode::from(3);
            }
            Self::NotWhole => return ExitCode::from(4),
            Self::MotorsOff(message) => (message.clone(), 5),
            Self::Declined(message) => (message.clone(), 6),
            Self::Interrupted(message) => {
                tell(message);
                return ExitCode::from(130);
            }
        };
        tell(format_args!("error: {message}"));
        ExitCode::from(code)
    }
}

/// Prints a message to standard error, [`printable`]. A closed standard error is ignored, unlike by `eprintln!`.
pub fn tell(message: impl fmt::Display) {
    write_line(&printable(&message.to_string()));
}

fn write_line(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// Replaces the control characters of a text, except those of lines and columns: names and words of a device, a file or
/// a recording would control the terminal.
pub fn printable(text: &str) -> Cow<'_, str> {
    let controls = |letter: char| letter.is_control() && !"\n\r\t".contains(letter);
    if text.contains(controls) {
        Cow::Owned(text.replace(controls, "\u{fffd}"))
    } else {
        Cow::Borrowed(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_do_not_reach_the_terminal() {
        let name = "\u{1b}[31mred\u{7}\u{9b}2J";
        assert_eq!(printable(name), "\u{fffd}[31mred\u{fffd}\u{fffd}2J");
        let lines = "a\tb\r\n\u{3ba}";
        assert!(matches!(printable(lines), Cow::Borrowed(same) if same == lines));
    }
}
