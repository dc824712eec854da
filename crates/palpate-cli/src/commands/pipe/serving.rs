//! Lines in, lines out: what every kind of pipe does, whatever it renders.

use std::fmt;
use std::io::{self, BufRead, Read};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::Builder;
use std::time::Duration;

use palpate_rt::StopFlag;
use serde::Serialize;

use super::messages::Messages;
use crate::failure::Failure;
use crate::last_line;

/// Longest line that is read as a sample `[bytes]`; the rest of a longer one is skipped.
const LONGEST_LINE: u64 = 4096;
/// How often it is looked whether the pipe is to end.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// What answers lines.
pub trait Answering: Send + 'static {
    /// What it did, for the end.
    type Summary: Serialize + fmt::Display;

    /// Prints the names of the columns, if they are asked for.
    fn write_header(&mut self) -> io::Result<()>;
    /// Answers the line with this number, if it is to be answered; `Err` as its text says why it
    /// could not be read.
    fn take(&mut self, number: u64, text: Result<&str, String>) -> Result<(), Stopped>;
    /// Whether nothing is answered any more.
    fn is_ended(&self) -> bool;
    /// Takes the force off with a last line, if a line was answered: whoever reads holds the force of
    /// the line that came last.
    fn end(&mut self) -> io::Result<()>;
    /// What was done, and the messages, which are not to be used any more.
    fn finish(&mut self) -> (Self::Summary, Option<Messages>);
}

/// Answers every line of standard input until it ends, or a signal ends it. The summary is told at the end, as
/// JSON if that is asked for.
pub fn answer_all<S: Answering>(
    set_up: impl FnOnce() -> Result<S, Failure>,
    as_json: bool,
) -> Result<(), Failure> {
    let stop =
        StopFlag::on_signals().map_err(|error| Failure::System(format!("no signals: {error}")))?;
    let stream = Arc::new(Mutex::new(set_up()?));
    let ended = serve_until(&stream, &stop)?;
    let (summary, messages) = locked(&stream).finish();
    if let Some(messages) = messages {
        if as_json {
            let summary = serde_json::to_string(&summary);
            messages.finish(summary.expect("a summary has string keys only"));
        } else {
            messages.finish(summary);
        }
    }
    ended.into()
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
    pub fn at_line(number: u64, why: &str) -> Self {
        Self::Refused(format!("standard input, line {number}: {why}"))
    }
}

/// How the pipe ended.
enum Ended {
    /// The input did.
    Done,
    /// A line or the output stopped it.
    Stopped(Stopped),
    /// The input cannot be read any more.
    Unread(io::Error),
    /// Somebody ended it by a signal.
    Signalled,
}

impl From<Ended> for Result<(), Failure> {
    fn from(ended: Ended) -> Self {
        match ended {
            Ended::Done => Ok(()),
            Ended::Stopped(Stopped::Refused(why)) => Err(Failure::input(why)),
            Ended::Stopped(Stopped::Unwritten(error)) => unless_broken(error),
            Ended::Unread(error) => Err(Failure::System(format!(
                "standard input cannot be read: {error}"
            ))),
            Ended::Signalled => Err(Failure::Interrupted(
                "stopped by a signal; the last line takes the force off".into(),
            )),
        }
    }
}

/// A reader that has left is no error.
fn unless_broken(error: io::Error) -> Result<(), Failure> {
    if error.kind() == io::ErrorKind::BrokenPipe {
        return Ok(());
    }
    Err(Failure::System(format!(
        "standard output cannot be written: {error}"
    )))
}

/// The stream, for this thread. What a thread that panicked has left can still be ended.
fn locked<S>(stream: &Mutex<S>) -> MutexGuard<'_, S> {
    stream.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Answers lines in a thread of its own until the input ends or `stop` is raised: a thread that waits
/// for a line cannot look at signals.
fn serve_until<S: Answering>(stream: &Arc<Mutex<S>>, stop: &StopFlag) -> Result<Ended, Failure> {
    let (sender, served) = channel();
    let server = Arc::clone(stream);
    Builder::new()
        .name("palpate pipe".to_owned())
        .spawn(move || {
            let ended = serve(&server, &mut io::stdin().lock());
            let written = locked(&server).end();
            let _ = sender.send(match (ended, written) {
                (Ended::Done, Err(error)) => Ended::Stopped(Stopped::Unwritten(error)),
                (ended, _) => ended,
            });
        })
        .map_err(|error| Failure::System(format!("no thread for the pipe: {error}")))?;
    loop {
        match served.recv_timeout(LOOK_EVERY) {
            Ok(ended) => return Ok(ended),
            Err(RecvTimeoutError::Timeout) if !stop.is_raised() => {}
            Err(RecvTimeoutError::Timeout) => {
                return let_go(stream).map(|()| Ended::Signalled);
            }
            Err(RecvTimeoutError::Disconnected) => {
                let_go(stream)?;
                return Err(Failure::System(
                    "a line could not be answered for a fault of the program; the last line takes the \
                     force off"
                        .into(),
                ));
            }
        }
    }
}

/// Takes the force off from beside the thread that answers. That one may wait for ever for a reader
/// that does not read.
fn let_go<S: Answering>(stream: &Arc<Mutex<S>>) -> Result<(), Failure> {
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
