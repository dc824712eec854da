//! Calibration between two streams: a position in, a force out.

use std::io::{self, BufRead, Read, Write};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::Builder;
use std::time::Duration;

use palpate_rt::StopFlag;
use palpate_study::calibrate::{ExcitationError, ExcitationParams, Phase, Stop};
use palpate_study::calibration::ExcitedMotion;

use crate::pipe::last_line::{self, LastLineUnread};
use crate::pipe::line::{Format, Line, Refusal};

/// Longest line that is read `[bytes]`.
const LONGEST_LINE: u64 = 4096;
/// Polling interval of the stop flag.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// An excitation between two streams.
struct Stream {
    motion: ExcitedMotion,
    format: Format,
    output: Box<dyn Write + Send>,
    /// Whether the last answer was a nonzero force.
    is_on: bool,
    is_ended: bool,
}

/// Failure to calibrate a device that is excited through two streams.
#[derive(Debug, thiserror::Error)]
pub enum CalibratingError {
    /// A parameter out of its range.
    #[error(transparent)]
    Params(#[from] ExcitationError),
    /// The system cannot create a thread.
    #[error("no thread for the stream: {0}")]
    Thread(io::Error),
    /// The input cannot be read.
    #[error("standard input cannot be read: {0}")]
    Unread(io::Error),
    /// An answer cannot be written.
    #[error("standard output cannot be written: {0}")]
    Unwritten(io::Error),
    /// A line is not a sample.
    #[error("standard input, line {number}: {why}")]
    Line {
        /// The line, counted from 1.
        number: u64,
        /// The reason.
        why: String,
    },
    /// The input ended before the excitation did.
    #[error("standard input ended after {taken} of {whole} samples: no calibration")]
    Ended {
        /// Samples received.
        taken: usize,
        /// Samples of the whole excitation.
        whole: usize,
    },
    /// The device left the box of the excitation, or the hand moved too much.
    #[error("stopped: {0}")]
    Stopped(Stop),
    /// A signal ended the calibration.
    #[error(
        "stopped by a signal before the end: no calibration; the last line sets the force to 0"
    )]
    Signalled,
    /// The thread that answered panicked; the force is off.
    #[error(
        "a line could not be answered because of a program fault; the last line sets the force to 0"
    )]
    Panicked,
    /// The reader did not read the last line.
    #[error(transparent)]
    LastLine(#[from] LastLineUnread),
}

/// Excites a device until the excitation is complete. The positions arrive on `input`, in lines of `format`. `input` is
/// opened in the thread that reads it.
///
/// # Errors
/// The excitation stopped, the input ended or is not a motion, `stop` was raised, or the reader did not read. In each
/// case the last line is a force of 0.
pub fn calibrate<I: BufRead>(
    params: ExcitationParams,
    format: Format,
    input: impl FnOnce() -> I + Send + 'static,
    output: Box<dyn Write + Send>,
    stop: &StopFlag,
) -> Result<ExcitedMotion, CalibratingError> {
    let stream = Arc::new(Mutex::new(Stream {
        motion: ExcitedMotion::new(params)?,
        format,
        output,
        is_on: false,
        is_ended: false,
    }));
    serve_until(&stream, input, stop)?;
    let mut stream = locked(&stream);
    let nothing = ExcitedMotion::new(params)?;
    Ok(std::mem::replace(&mut stream.motion, nothing))
}

fn locked(stream: &Mutex<Stream>) -> MutexGuard<'_, Stream> {
    stream.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Serves in a separate thread, because a thread that waits for a line cannot check signals.
fn serve_until<I: BufRead>(
    stream: &Arc<Mutex<Stream>>,
    input: impl FnOnce() -> I + Send + 'static,
    stop: &StopFlag,
) -> Result<(), CalibratingError> {
    let (sender, served) = channel();
    let server = Arc::clone(stream);
    Builder::new()
        .name("palpate calibrate".to_owned())
        .spawn(move || {
            let ended = serve(&server, &mut input());
            let off = locked(&server).end();
            let _ = sender.send(ended.and_then(|()| off.map_err(CalibratingError::Unwritten)));
        })
        .map_err(CalibratingError::Thread)?;
    loop {
        match served.recv_timeout(LOOK_EVERY) {
            Ok(ended) => return ended,
            Err(RecvTimeoutError::Timeout) if !stop.is_raised() => {}
            Err(RecvTimeoutError::Timeout) => {
                disable_output(stream)?;
                return Err(CalibratingError::Signalled);
            }
            Err(RecvTimeoutError::Disconnected) => {
                disable_output(stream)?;
                return Err(CalibratingError::Panicked);
            }
        }
    }
}

/// Sets the force to 0 from another thread than the answering one, which may wait for a stalled reader.
fn disable_output(stream: &Arc<Mutex<Stream>>) -> Result<(), LastLineUnread> {
    let ending = Arc::clone(stream);
    last_line::write_beside(move || {
        let _ = locked(&ending).end();
    })
}

/// Answers line by line until the excitation ends.
fn serve(stream: &Mutex<Stream>, input: &mut impl BufRead) -> Result<(), CalibratingError> {
    let mut line = Vec::new();
    for number in 1_u64.. {
        line.clear();
        let length = input
            .take(LONGEST_LINE)
            .read_until(b'\n', &mut line)
            .map_err(CalibratingError::Unread)?;
        let mut stream = locked(stream);
        if stream.is_ended {
            return Ok(());
        }
        if length == 0 {
            let (taken, whole) = (stream.motion.positions.len(), stream.motion.length());
            return Err(CalibratingError::Ended { taken, whole });
        }
        if length as u64 == LONGEST_LINE && !line.ends_with(b"\n") {
            let why = format!("the line is longer than {LONGEST_LINE} bytes");
            return Err(CalibratingError::Line { number, why });
        }
        if last_line::is_cut_off(&line) {
            return Err(refused(number, last_line::CUT_OFF));
        }
        stream.answer(number, String::from_utf8_lossy(&line).trim())?;
        match stream.motion.phase() {
            Phase::Running => {}
            Phase::Done => return Ok(()),
            Phase::Stopped(stop) => return Err(CalibratingError::Stopped(stop)),
        }
    }
    Ok(())
}

impl Stream {
    /// Answers the line of this number with a force.
    fn answer(&mut self, number: u64, text: &str) -> Result<(), CalibratingError> {
        if number == 1
            && let Some(format) = self
                .format
                .with_header(text)
                .map_err(|why| refused(number, &why))?
        {
            if format.virtual_force {
                let why = "a calibration has no object: omit virtual_force_n";
                return Err(refused(number, why));
            }
            self.format = format;
            return Ok(());
        }
        let (time, position) = match self.format.parse(text) {
            Ok(Line::Sample { time, position, .. }) => (time, position),
            Ok(Line::Set(_)) => {
                return Err(refused(number, "`set` is not allowed during a calibration"));
            }
            // The fit would take a lost sample for a motion of one period.
            Err(Refusal::Line(why) | Refusal::Stream(why)) => return Err(refused(number, &why)),
        };
        if let (Some(time), Some(last)) = (time, self.motion.times.last())
            && time <= *last
        {
            return Err(refused(number, "the time does not increase"));
        }
        let force = self.motion.take(time, position);
        self.write(force).map_err(CalibratingError::Unwritten)
    }

    fn write(&mut self, force: f64) -> io::Result<()> {
        self.is_on = force != 0.0;
        writeln!(self.output, "{force}")?;
        self.output.flush()
    }

    /// Writes a last line with a force of 0, if the last answer was a force.
    fn end(&mut self) -> io::Result<()> {
        self.is_ended = true;
        if self.is_on { self.write(0.0) } else { Ok(()) }
    }
}

fn refused(number: u64, why: &str) -> CalibratingError {
    let why = format!("{why}; a calibration needs every sample, so it stops");
    CalibratingError::Line { number, why }
}
