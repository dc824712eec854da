//! `palpate pipe`: a renderer between standard input and standard output.

mod arguments;
mod change;
mod columns;
pub mod line;
mod messages;
mod stream;
mod summary;

use std::io::{self, BufRead, Read};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::Builder;
use std::time::Duration;

use palpate::LARGEST_DELAY;
use palpate_rt::StopFlag;
use palpate_rt::safety::{OscillationParams, Safety, SafetyParams};
use palpate_scene::method::MethodName;

pub use arguments::PipeArguments;

use super::simulate::read_scene;
use crate::failure::Failure;
use crate::last_line;
use crate::setup::{check_contact, wrong_rendered, wrong_setup};
use change::{Changeable, rendering};
use line::Format;
use messages::Messages;
use stream::{Memory, Stopped, Stream};
pub use summary::Summary;

/// Longest line that is read as a sample `[bytes]`; the rest of a longer one is skipped.
const LONGEST_LINE: u64 = 4096;
/// How often it is looked whether the pipe is to end.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// Answers every line of standard input until it ends, or a signal ends it.
pub fn run(arguments: &PipeArguments) -> Result<(), Failure> {
    let stop =
        StopFlag::on_signals().map_err(|error| Failure::System(format!("no signals: {error}")))?;
    let stream = Arc::new(Mutex::new(set_up(arguments)?));
    let ended = serve_until(&stream, &stop)?;
    let (summary, messages) = locked(&stream).finish();
    if let Some(messages) = messages {
        if arguments.json {
            let summary = serde_json::to_string(&summary);
            messages.finish(summary.expect("a summary has string keys only"));
        } else {
            messages.finish(summary);
        }
    }
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

/// A reader that has left is no error.
fn unless_broken(error: io::Error) -> Result<(), Failure> {
    if error.kind() == io::ErrorKind::BrokenPipe {
        return Ok(());
    }
    Err(Failure::System(format!(
        "standard output cannot be written: {error}"
    )))
}

/// The stream as the arguments say it; nothing has been read or written yet.
fn set_up(arguments: &PipeArguments) -> Result<Stream, Failure> {
    let flags = &arguments.flags;
    let scene = arguments.scene.as_deref().map(read_scene).transpose()?;
    let methods = flags.methods(
        scene
            .as_ref()
            .map_or_else(MethodName::default, |file| file.scene.method),
    );
    let &[method] = methods.as_slice() else {
        return Err(Failure::Arguments(
            "pipe renders by one method; name it with --method".into(),
        ));
    };
    flags.check_settings(&methods)?;
    let motor_limit = scene
        .as_ref()
        .and_then(|file| file.scene.device.largest_force);
    let (mut setup, settings) = match scene {
        Some(file) => flags.live_setup(file.scene, method)?,
        None => (flags.replay_setup("pipe")?, flags.settings()),
    };
    let defaults = SafetyParams::default();
    let is_limit_given = flags.force_limit.is_some() || setup.loop_params.force_limit.is_some();
    if !is_limit_given {
        let least = motor_limit.unwrap_or(f64::INFINITY);
        setup.loop_params.force_limit = Some(defaults.largest_force.min(least));
    }
    let force_limit = setup.loop_params.force_limit;
    let soft_start = soft_start(arguments, &defaults)?;
    let (samples, fraction) = setup.delay();
    let periods = samples as f64 + fraction;
    if periods > LARGEST_DELAY as f64 {
        let unit = if fraction == 0.0 {
            "samples"
        } else {
            "periods"
        };
        return Err(Failure::Arguments(format!(
            "--delay is {periods} {unit}, and a renderer can be told of {LARGEST_DELAY} at most"
        )));
    }
    // Contact and loop first: what is wrong with them is wrong whatever the method.
    check_contact(&setup)?;
    let rendering = rendering(&setup, method, &settings).map_err(|error| wrong_setup(&error))?;
    let (parameters, rendered) =
        palpate_rt::parameters(rendering).map_err(|error| wrong_rendered(&error))?;
    let safety = Safety::new(
        limits(force_limit, soft_start, defaults),
        setup.loop_params.period,
    )
    .map_err(|error| Failure::Arguments(error.to_string()))?;
    let mut stream = Stream {
        rendered,
        safety,
        changeable: Changeable {
            parameters,
            setup,
            method,
            settings,
        },
        format: Format {
            time: arguments.stream.time,
            unit: arguments.stream.unit.unwrap_or_default(),
            is_unit_given: arguments.stream.unit.is_some(),
        },
        columns: arguments.stream.columns.clone(),
        is_header_asked: arguments.stream.header,
        output: Box::new(io::stdout()),
        messages: Some(
            Messages::start()
                .map_err(|error| Failure::System(format!("no thread for messages: {error}")))?,
        ),
        summary: Summary::new(force_limit, soft_start),
        memory: Memory::default(),
    };
    tell_limits(
        &mut stream,
        force_limit.filter(|_| !is_limit_given),
        Some(soft_start).filter(|_| arguments.stream.soft_start.is_none()),
    );
    Ok(stream)
}

/// Time over which a force comes in `[s]`.
fn soft_start(arguments: &PipeArguments, defaults: &SafetyParams) -> Result<f64, Failure> {
    let seconds = arguments.stream.soft_start.unwrap_or(defaults.soft_start);
    if (0.0..=60.0).contains(&seconds) {
        return Ok(seconds);
    }
    Err(Failure::Arguments(format!(
        "--soft-start is {seconds} s, but must be 0 to 60"
    )))
}

/// The limits of `run`, as far as a pipe has them: the largest force and the soft start.
fn limits(force_limit: Option<f64>, soft_start: f64, defaults: SafetyParams) -> SafetyParams {
    SafetyParams {
        largest_force: force_limit.unwrap_or(f64::MAX),
        soft_start,
        largest_speed: f64::INFINITY,
        oscillation: OscillationParams {
            energy: f64::INFINITY,
            ..defaults.oscillation
        },
        ..defaults
    }
}

/// Says what limits a force without having been asked for.
fn tell_limits(stream: &mut Stream, force: Option<f64>, soft_start: Option<f64>) {
    let comes_in = |seconds| {
        format!("where a start or a recovery finds contact, the force comes in over {seconds} s")
    };
    match (force, soft_start) {
        (Some(force), Some(seconds)) => stream.tell(format_args!(
            "forces are limited to {force} N; {}; --force-limit inf and --soft-start 0 switch that off",
            comes_in(seconds)
        )),
        (Some(force), None) => stream.tell(format_args!(
            "forces are limited to {force} N; --force-limit inf switches that off"
        )),
        (None, Some(seconds)) => stream.tell(format_args!(
            "{}; --soft-start 0 switches that off",
            comes_in(seconds)
        )),
        (None, None) => {}
    }
}

/// The stream, for this thread. What a thread that panicked has left can still be ended.
fn locked(stream: &Mutex<Stream>) -> MutexGuard<'_, Stream> {
    stream.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Answers lines in a thread of its own until the input ends or `stop` is raised: a thread that waits
/// for a line cannot look at signals.
fn serve_until(stream: &Arc<Mutex<Stream>>, stop: &StopFlag) -> Result<Ended, Failure> {
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
fn let_go(stream: &Arc<Mutex<Stream>>) -> Result<(), Failure> {
    let ending = Arc::clone(stream);
    last_line::write_beside(move || {
        let _ = locked(&ending).end();
    })
}

/// Answers line by line.
fn serve(stream: &Mutex<Stream>, input: &mut impl BufRead) -> Ended {
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
