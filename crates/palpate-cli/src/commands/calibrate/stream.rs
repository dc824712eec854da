//! Calibration between standard input and standard output: a position in, a force out.

use std::io::{self, BufRead, Read, Write};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::Builder;
use std::time::Duration;

use palpate_calibrate::{ExcitationParams, Phase};
use palpate_record::unit::LengthUnit;
use palpate_rt::StopFlag;
use palpate_study::calibration::Motion;

use crate::commands::pipe::line::{Format, Line, Refusal};
use crate::failure::Failure;
use crate::last_line;

/// Longest line that is read `[bytes]`.
const LONGEST_LINE: u64 = 4096;
/// How often it is looked whether the command is to end.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// An excitation between two streams.
struct Stream {
    motion: Motion,
    format: Format,
    output: Box<dyn Write + Send>,
    /// Whether a line was answered with a force that is not 0, and none with 0 after it.
    is_on: bool,
    is_ended: bool,
}

/// Excites a device whose positions come in on standard input, until the excitation is complete.
///
/// # Errors
/// The excitation stopped, the input ended or is no motion, a signal came, or nobody reads. The last line
/// is a force of 0 in each case.
pub fn excite(
    params: ExcitationParams,
    time: bool,
    unit: Option<LengthUnit>,
) -> Result<Motion, Failure> {
    let stop =
        StopFlag::on_signals().map_err(|error| Failure::System(format!("no signals: {error}")))?;
    let motion = Motion::new(params).map_err(|error| Failure::Arguments(error.to_string()))?;
    let stream = Arc::new(Mutex::new(Stream {
        motion,
        format: Format {
            time,
            unit: unit.unwrap_or_default(),
            is_unit_given: unit.is_some(),
        },
        output: Box::new(io::stdout()),
        is_on: false,
        is_ended: false,
    }));
    serve_until(&stream, &stop)?;
    let mut stream = locked(&stream);
    let nothing = Motion::new(params).map_err(|error| Failure::Arguments(error.to_string()))?;
    Ok(std::mem::replace(&mut stream.motion, nothing))
}

fn locked(stream: &Mutex<Stream>) -> MutexGuard<'_, Stream> {
    stream.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Serves in a thread of its own: a thread that waits for a line cannot look at signals.
fn serve_until(stream: &Arc<Mutex<Stream>>, stop: &StopFlag) -> Result<(), Failure> {
    let (sender, served) = channel();
    let server = Arc::clone(stream);
    Builder::new()
        .name("palpate calibrate".to_owned())
        .spawn(move || {
            let ended = serve(&server, &mut io::stdin().lock());
            let off = locked(&server).end();
            let _ = sender.send(ended.and_then(|()| off.map_err(|error| unwritten(&error))));
        })
        .map_err(|error| Failure::System(format!("no thread for the stream: {error}")))?;
    loop {
        match served.recv_timeout(LOOK_EVERY) {
            Ok(ended) => return ended,
            Err(RecvTimeoutError::Timeout) if !stop.is_raised() => {}
            Err(RecvTimeoutError::Timeout) => {
                let_go(stream)?;
                return Err(Failure::Interrupted(
                    "stopped by a signal before the end: no calibration; the last line takes the force off"
                        .into(),
                ));
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

/// Takes the force off from beside the thread that answers, which may wait for a reader that does not
/// read.
fn let_go(stream: &Arc<Mutex<Stream>>) -> Result<(), Failure> {
    let ending = Arc::clone(stream);
    last_line::write_beside(move || {
        let _ = locked(&ending).end();
    })
}

fn unwritten(error: &io::Error) -> Failure {
    Failure::System(format!("standard output cannot be written: {error}"))
}

/// Answers line by line until the excitation ends.
fn serve(stream: &Mutex<Stream>, input: &mut impl BufRead) -> Result<(), Failure> {
    let mut line = Vec::new();
    for number in 1_u64.. {
        line.clear();
        let length = input
            .take(LONGEST_LINE)
            .read_until(b'\n', &mut line)
            .map_err(|error| Failure::System(format!("standard input cannot be read: {error}")))?;
        let mut stream = locked(stream);
        if stream.is_ended {
            return Ok(());
        }
        if length == 0 {
            let (taken, whole) = (stream.motion.positions.len(), stream.motion.length());
            return Err(Failure::Declined(format!(
                "standard input ended after {taken} of {whole} samples: no calibration"
            )));
        }
        if length as u64 == LONGEST_LINE && !line.ends_with(b"\n") {
            return Err(Failure::input(format_args!(
                "standard input, line {number}: the line is longer than {LONGEST_LINE} bytes"
            )));
        }
        if last_line::is_cut_off(&line) {
            return Err(refused(number, last_line::CUT_OFF));
        }
        stream.answer(number, String::from_utf8_lossy(&line).trim())?;
        match stream.motion.phase() {
            Phase::Running => {}
            Phase::Done => return Ok(()),
            Phase::Stopped(stop) => return Err(Failure::Declined(format!("stopped: {stop}"))),
        }
    }
    Ok(())
}

impl Stream {
    /// Answers the line with this number with a force.
    fn answer(&mut self, number: u64, text: &str) -> Result<(), Failure> {
        if number == 1
            && let Some(format) = self
                .format
                .with_header(text)
                .map_err(|why| refused(number, &why))?
        {
            self.format = format;
            return Ok(());
        }
        let (time, position) = match self.format.parse(text) {
            Ok(Line::Sample { time, position }) => (time, position),
            Ok(Line::Set(_)) => {
                return Err(refused(
                    number,
                    "nothing can be changed during a calibration",
                ));
            }
            // A sample that is lost is a period that the fit would take for a motion.
            Err(Refusal::Line(why) | Refusal::Stream(why)) => return Err(refused(number, &why)),
        };
        if let (Some(time), Some(last)) = (time, self.motion.times.last())
            && time <= *last
        {
            return Err(refused(number, "the time does not increase"));
        }
        let force = self.motion.take(time, position);
        self.write(force).map_err(|error| unwritten(&error))
    }

    fn write(&mut self, force: f64) -> io::Result<()> {
        self.is_on = force != 0.0;
        writeln!(self.output, "{force}")?;
        self.output.flush()
    }

    /// Takes the force off with a last line, if the last answer was a force.
    fn end(&mut self) -> io::Result<()> {
        self.is_ended = true;
        if self.is_on { self.write(0.0) } else { Ok(()) }
    }
}

fn refused(number: u64, why: &str) -> Failure {
    Failure::input(format_args!(
        "standard input, line {number}: {why}; a calibration needs every sample, so it stops"
    ))
}
