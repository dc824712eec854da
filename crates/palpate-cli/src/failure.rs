//! What went wrong, for the person at the terminal: a message, a place, an exit code.

use std::fmt;
use std::io::{self, Write};
use std::ops::Range;
use std::process::ExitCode;

use miette::{
    Diagnostic, GraphicalReportHandler, GraphicalTheme, LabeledSpan, NamedSource, SourceCode,
};
use palpate_io::atomic::{WriteError, WriteFault};
use palpate_io::outputs::OutputError;

/// Why a command ended without its result.
#[derive(Debug)]
pub enum Failure {
    /// A file could not be read or written: exit code 1.
    System(String),
    /// The arguments are wrong: exit code 2.
    Arguments(String),
    /// An input file is wrong: exit code 3.
    Input(Box<InputFault>),
    /// The command is done, but the recording it read is not whole, as has been said: exit code 4.
    NotWhole,
    /// The user ended it before its end: exit code 130, as the shell's for ctrl-C.
    Interrupted(String),
}

/// A fault in a file of the user's.
#[derive(Debug)]
pub struct InputFault {
    /// What is wrong, where (`file:line:column`), and what is allowed.
    pub message: String,
    /// The text at fault and the bytes to point at, if there is text.
    pub excerpt: Option<(NamedSource<String>, Range<usize>)>,
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
            OutputError::IsInput { .. } | OutputError::Twice { .. } => {
                Self::Arguments(error.to_string())
            }
        }
    }
}

impl Failure {
    /// A fault in an input file without a place to show.
    pub fn input(message: impl fmt::Display) -> Self {
        Self::Input(Box::new(InputFault {
            message: message.to_string(),
            excerpt: None,
        }))
    }

    /// A fault in an input file, shown in its text.
    pub fn input_at(
        message: impl fmt::Display,
        file: &str,
        text: &str,
        span: Range<usize>,
    ) -> Self {
        Self::Input(Box::new(InputFault {
            message: message.to_string(),
            excerpt: Some((NamedSource::new(file, text.to_owned()), span)),
        }))
    }

    /// What went wrong, in words.
    pub fn message(&self) -> String {
        match self {
            Self::System(message) | Self::Arguments(message) | Self::Interrupted(message) => {
                message.clone()
            }
            Self::Input(fault) => fault.message.clone(),
            Self::NotWhole => "a recording is not whole".to_owned(),
        }
    }

    /// Tells the user on standard error; the exit code to end with.
    pub fn report(&self) -> ExitCode {
        let (message, code) = match self {
            Self::System(message) => (message.clone(), 1),
            Self::Arguments(message) => (
                format!("{message}\n\nFor more information, try '--help'."),
                2,
            ),
            Self::Input(fault) if fault.excerpt.is_some() => (
                format!("{}\n{}", fault.message, fault.drawing().trim_end()),
                3,
            ),
            Self::Input(fault) => (fault.message.clone(), 3),
            Self::NotWhole => return ExitCode::from(4),
            Self::Interrupted(message) => {
                tell(message);
                return ExitCode::from(130);
            }
        };
        tell(format_args!("error: {message}"));
        ExitCode::from(code)
    }
}

/// Says something on standard error. Nobody may be listening there any more, which is no reason
/// to stop: `eprintln!` would.
pub fn tell(message: impl fmt::Display) {
    let _ = writeln!(io::stderr().lock(), "{message}");
}

impl InputFault {
    /// The lines at fault, with the fault marked.
    fn drawing(&self) -> String {
        let colour = std::io::IsTerminal::is_terminal(&std::io::stderr());
        let theme = if colour {
            GraphicalTheme::unicode()
        } else {
            GraphicalTheme::unicode_nocolor()
        };
        let mut drawing = String::new();
        // A drawing that fails leaves the message, which says it all.
        let _ = GraphicalReportHandler::new_themed(theme)
            .with_context_lines(1)
            .render_report(&mut drawing, self);
        // The first line repeats the message.
        match drawing.find('╭') {
            Some(at) => {
                let start = drawing[..at].rfind('\n').map_or(0, |newline| newline + 1);
                drawing[start..].to_string()
            }
            None => String::new(),
        }
    }
}

impl fmt::Display for InputFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for InputFault {}

impl Diagnostic for InputFault {
    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.excerpt
            .as_ref()
            .map(|(source, _)| source as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let (_, span) = self.excerpt.as_ref()?;
        Some(Box::new(std::iter::once(LabeledSpan::new_with_span(
            Some("here".into()),
            span.clone(),
        ))))
    }
}
