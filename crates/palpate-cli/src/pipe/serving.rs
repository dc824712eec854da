//! The line-by-line protocol common to all pipes.

use std::fmt;
use std::io::{self, BufRead, Read};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::Builder;
use std::time::Duration;

use palpate_rt::StopFlag;
use palpate_rt::safety::SafetyStop;
use serde::Serialize;

use crate::pipe::last_line::{self, LastLineUnread};
use crate::pipe::messages::Messages;

/// Longest line that can be a sample `[bytes]`; the rest of a longer line is skipped.
const LONGEST_LINE: u64 = 4096;
/// Polling interval of the stop flag.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// Handler that answers lines.
pub trait Answering: Send + 'static {
    /// Summary at the end.
    type Summary: Serialize + fmt::Display;

    /// Prints the names of the columns, if requested.
    ///
    /// # Errors
    /// They cannot be written.
    fn write_header(&mut self) -> io::Result<()>;
    /// Answers the line of this number, if it needs an answer. If the line could not be read, `text` is an `Err` with
    /// the reason.
    ///
    /// # Errors
    /// No further line is answered.
    fn take(&mut self, number: u64, text: Result<&str, String>) -> Result<(), Stopped>;
    /// Whether the stream has ended.
    fn is_ended(&self) -> bool;
    /// Writes a last line with a force of 0, if a line was answered: the reader holds the force of the last line.
    ///
    /// # Errors
    /// It cannot be written.
    fn end(&mut self) -> io::Result<()>;
    /// Whether lines were answered and all of them were rejected, so that no force was rendered.
    fn has_refused_all(&self) -> bool;
    /// Returns the safety stop that held all forces at 0 until the end, if there is one.
    fn safety_stop(&self) -> Option<SafetyStop>;
    /// Returns the summary and the messages. The stream must not be used afterwards.
    fn finish(&mut self) -> (Self::Summary, Option<Messages>);
}

/// Outcome of a stream.
#[derive(Debug)]
pub struct Served<Summary> {
    /// Summary at the end.
    pub summary: Summary,
    /// Queue for the last message; `None` if the end has been reported.
    pub messages: Option<Messages>,
    /// How it ended.
    pub ended: Ended,
    /// Whether lines were answered and all of them were rejected.
    pub has_refused_all: bool,
    /// The safety stop that held all forces at 0 until the end, if there is one.
    pub safety_stop: Option<SafetyStop>,
}

/// Failure to serve or to end a stream.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ServeError {
    /// The system cannot create a thread.
    #[error("no thread for the pipe: {0}")]
    Thread(io::Error),
    /// The thread that answered panicked; the force is off.
    #[error(
        "a line could not be answered because of a program fault; the last line sets the force to 0"
    )]
    Panicked,
    /// The reader did not read the last line.
    #[error(transparent)]
    LastLine(#[from] LastLineUnread),
}

/// Answers every line of `input`, which is opened in the thread that reads it, until it ends or `stop` is raised.
///
/// # Errors
/// The thread could not be created or panicked, or the reader did not read the last line.
pub fn answer_all<S: Answering, I: BufRead>(
    stream: S,
    input: impl FnOnce() -> I + Send + 'static,
    stop: &StopFlag,
) -> Result<Served<S::Summary>, ServeError> {
    let stream = Arc::new(Mutex::new(stream));
    let ended = serve_until(&stream, input, stop)?;
    let has_refused_all = locked(&stream).has_refused_all();
    let safety_stop = locked(&stream).safety_stop();
    let (summary, messages) = locked(&stream).finish();
    Ok(Served {
        summary,
        messages,
        ended,
        has_refused_all,
        safety_stop,
    })
}

/// Reason for answering no further line.
#[derive(Debug)]
pub enum Stopped {
    /// The lines do not have the requested format, or the motion is implausible.
    Refused(String),
    /// The answer could not be written.
    Unwritten(io::Error),
}

impl Stopped {
    /// Creates a rejection because of the contents of a line.
    #[must_use]
    pub fn at_line(number: u64, why: &str) -> Self {
        Self::Refused(format!("standard input, line {number}: {why}"))
    }
}

/// End of a stream.
#[derive(Debug)]
pub enum Ended {
    /// The input ended.
    Done,
    /// A line or the output stopped it.
    Stopped(Stopped),
    /// The input cannot be read.
    Unread(io::Error),
    /// A signal ended the stream.
    Signalled,
}

/// Locks the stream. A poisoned lock is ignored, so that the stream of a thread that panicked can be ended.
fn locked<S>(stream: &Mutex<S>) -> MutexGuard<'_, S> {
    stream.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Answers lines in a separate thread until the input ends or `stop` is raised. A thread that waits for a line cannot
/// check signals.
fn serve_until<S: Answering, I: BufRead>(
    stream: &Arc<Mutex<S>>,
    input: impl FnOnce() -> I + Send + 'static,
    stop: &StopFlag,
) -> Result<Ended, ServeError> {
    let (sender, served) = channel();
    let server = Arc::clone(stream);
    Builder::new()
        .name("palpate pipe".to_owned())
        .spawn(move || {
            let ended = serve(&server, &mut input());
            let written = locked(&server).end();
            let _ = sender.send(match (ended, written) {
                (Ended::Done, Err(error)) => Ended::Stopped(Stopped::Unwritten(error)),
                (ended, _) => ended,
            });
        })
        .map_err(ServeError::Thread)?;
    loop {
        match served.recv_timeout(LOOK_EVERY) {
            Ok(ended) => return Ok(ended),
            Err(RecvTimeoutError::Timeout) if !stop.is_raised() => {}
            Err(RecvTimeoutError::Timeout) => {
                disable_output(stream)?;
                return Ok(Ended::Signalled);
            }
            Err(RecvTimeoutError::Disconnected) => {
                disable_output(stream)?;
                return Err(ServeError::Panicked);
            }
        }
    }
}

/// Sets the force to 0 from another thread than the answering one, which may wait forever for a stalled reader.
fn disable_output<S: Answering>(stream: &Arc<Mutex<S>>) -> Result<(), LastLineUnread> {
    let ending = Arc::clone(stream);
    last_line::write_beside(move || {
        let _ = locked(&ending).end();
    })
}

/// Answers line by line.
fn serve<S: Answering>(stream: &Mutex<S>, input: &mut impl BufRead) -> Ended {
    if let Err(error) = locked(stream).write_header() {
        return Ended::Stopped(Stopped::Unwritten(error));
    }
    let mut line = Vec::new();
    for number in 1_u64.. {
        line.clear();
        let read = input
            .take(LONGEST_LINE)
            .read_until(b'\n', &mut line)
            .and_then(|length| {
                let too_long = length as u64 == LONGEST_LINE && !line.ends_with(b"\n");
                if too_long {
                    skip_line(input)?;
                }
                Ok((length, too_long))
            });
        let too_long = match read {
            Ok((0, _)) => break,
            Ok((_, too_long)) => too_long,
            Err(error) => return Ended::Unread(error),
        };
        let text = String::from_utf8_lossy(&line);
        let text = if too_long {
            Err(format!("the line is longer than {LONGEST_LINE} bytes"))
        } else if last_line::is_cut_off(&line) {
            Err(last_line::CUT_OFF.to_owned())
        } else {
            Ok(text.trim())
        };
        let mut stream = locked(stream);
        if stream.is_ended() {
            break;
        }
        if let Err(stopped) = stream.take(number, text) {
            return Ended::Stopped(stopped);
        }
    }
    Ended::Done
}

/// Reads up to the end of the line without keeping it.
fn skip_line(input: &mut impl BufRead) -> io::Result<()> {
    loop {
        let buffer = input.fill_buf()?;
        if buffer.is_empty() {
            return Ok(());
        }
        let end = buffer.iter().position(|&byte| byte == b'\n');
        let read = end.map_or(buffer.len(), |at| at + 1);
        input.consume(read);
        if end.is_some() {
            return Ok(());
        }
    }
}
