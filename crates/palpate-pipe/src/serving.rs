//! Lines in, lines out: what every kind of pipe does, whatever it renders.

use std::fmt;
use std::io::{self, BufRead, Read};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::Builder;
use std::time::Duration;

use palpate_rt::StopFlag;
use palpate_rt::safety::Trip;
use serde::Serialize;

use crate::last_line::{self, LastLineUnread};
use crate::messages::Messages;

/// Longest line that is read as a sample `[bytes]`; the rest of a longer one is skipped.
const LONGEST_LINE: u64 = 4096;
/// How often it is looked whether the pipe is to end.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// What answers lines.
pub trait Answering: Send + 'static {
    /// What it did, for the end.
    type Summary: Serialize + fmt::Display;

    /// Prints the names of the columns, if they are asked for.
    ///
    /// # Errors
    /// They cannot be written.
    fn write_header(&mut self) -> io::Result<()>;
    /// Answers the line with this number, if it is to be answered; `Err` as its text says why it
    /// could not be read.
    ///
    /// # Errors
    /// No further line is answered.
    fn take(&mut self, number: u64, text: Result<&str, String>) -> Result<(), Stopped>;
    /// Whether nothing is answered any more.
    fn is_ended(&self) -> bool;
    /// Takes the force off with a last line, if a line was answered: whoever reads holds the force of
    /// the line that came last.
    ///
    /// # Errors
    /// It cannot be written.
    fn end(&mut self) -> io::Result<()>;
    /// Whether lines were answered, and each of them was refused: no force was ever answered.
    fn has_refused_all(&self) -> bool;
    /// The safety stop that has held all forces at 0 until the end, if one has.
    fn safety_stop(&self) -> Option<Trip>;
    /// What was done, and the messages, which are not to be used any more.
    fn finish(&mut self) -> (Self::Summary, Option<Messages>);
}

/// What a stream did.
#[derive(Debug)]
pub struct Served<Summary> {
    /// For the end.
    pub summary: Summary,
    /// Where the end is to be told; none if it has been.
    pub messages: Option<Messages>,
    /// How it ended.
    pub ended: Ended,
    /// Whether lines were answered, and each of them was refused.
    pub has_refused_all: bool,
    /// The safety stop that has held all forces at 0 until the end, if one has.
    pub safety_stop: Option<Trip>,
}

/// A stream could not be served, or not ended as it should.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ServeError {
    /// The system gives no thread.
    #[error("no thread for the pipe: {0}")]
    Thread(io::Error),
    /// The thread that answered panicked; the force is off.
    #[error(
        "a line could not be answered for a fault of the program; the last line takes the force off"
    )]
    Panicked,
    /// Nobody reads.
    #[error(transparent)]
    LastLine(#[from] LastLineUnread),
}

/// Answers every line of `input`, which is opened in the thread that reads it, until it ends or `stop` is raised.
///
/// # Errors
/// There is no thread, it panicked, or nobody read the last line.
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

/// Why no further line is answered.
#[derive(Debug)]
pub enum Stopped {
    /// The lines are not what was asked for, or no hand makes the motion.
    Refused(String),
    /// The answer could not be written.
    Unwritten(io::Error),
}

impl Stopped {
    /// Refused for what stands in a line.
    #[must_use]
    pub fn at_line(number: u64, why: &str) -> Self {
        Self::Refused(format!("standard input, line {number}: {why}"))
    }
}

/// How a stream ended.
#[derive(Debug)]
pub enum Ended {
    /// The input did.
    Done,
    /// A line or the output stopped it.
    Stopped(Stopped),
    /// The input cannot be read any more.
    Unread(io::Error),
    /// Somebody ended it by a signal.
    Signalled,
}

/// The stream, for this thread. What a thread that panicked has left can still be ended.
fn locked<S>(stream: &Mutex<S>) -> MutexGuard<'_, S> {
    stream.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Answers lines in a thread of its own until the input ends or `stop` is raised: a thread that waits
/// for a line cannot look at signals.
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
                let_go(stream)?;
                return Ok(Ended::Signalled);
            }
            Err(RecvTimeoutError::Disconnected) => {
                let_go(stream)?;
                return Err(ServeError::Panicked);
            }
        }
    }
}

/// Takes the force off from beside the thread that answers. That one may wait for ever for a reader
/// that does not read.
fn let_go<S: Answering>(stream: &Arc<Mutex<S>>) -> Result<(), LastLineUnread> {
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
