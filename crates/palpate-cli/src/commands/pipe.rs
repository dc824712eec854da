//! `palpate pipe`: a renderer between standard input and standard output.

use std::fmt;
use std::io::{self, BufRead, Read, Write};

use palpate::{AnyMemory, AnyRenderer, Output, Renderer, Sample, State};
use palpate_sim::method::MethodName;
use palpate_testbed::hold::DelayedHold;
use serde::Serialize;

use super::simulate::read_scene;
use crate::arguments::PipeArguments;
use crate::failure::{Failure, tell};
use crate::report::{counted, digits};
use crate::setup::{check_contact, wrong_flag, wrong_setup};

/// Longest line that is read as a sample `[bytes]`; the rest of a longer one is skipped.
const LONGEST_LINE: u64 = 4096;
/// Refused lines that are told one by one; of more, each doubling is: a dead sensor at 1 kHz would
/// bury whatever else standard error has to say.
const TOLD_EACH: u64 = 8;

/// Answers every line of standard input until it ends.
pub fn run(arguments: &PipeArguments) -> Result<(), Failure> {
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
    let (setup, settings) = match scene {
        Some(file) => flags.live_setup(file.scene, method)?,
        None => (flags.replay_setup("pipe")?, flags.settings()),
    };
    // Contact and loop first: what is wrong with them is wrong whatever the method.
    check_contact(&setup)?;
    // The first line says where the device is; until then the object is taken as untouched.
    let params = setup
        .params(method, &settings, setup.object.position, false)
        .map_err(|error| wrong_setup(&error.into()))?;
    let renderer: AnyRenderer<f64> = Renderer::new(setup.contact, setup.known_loop(), params)
        .map_err(|error| wrong_flag(&error))?;
    let mut pipe = Pipe {
        state: renderer
            .start(setup.object)
            .map_err(|error| wrong_flag(&error))?,
        renderer,
        virtual_force: setup.virtual_force,
        hold: DelayedHold::new(setup.delay)
            .map_err(|error| Failure::Arguments(format!("--delay: {error}")))?,
        last_time: None,
        summary: Summary::default(),
    };
    let ended = pipe.serve(&mut io::stdin().lock(), &mut io::stdout().lock());
    let summary = pipe.summary();
    if arguments.json {
        tell(serde_json::to_string(&summary).expect("a summary has string keys only"));
    } else {
        tell(&summary);
    }
    match ended {
        Err(error) if error.kind() == io::ErrorKind::InvalidInput => Err(Failure::input(error)),
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::System(format!("the pipe broke: {error}")))
        }
        _ => Ok(()),
    }
}

/// A renderer and what it needs between two lines.
struct Pipe {
    renderer: AnyRenderer<f64>,
    state: State<f64, AnyMemory<f64>>,
    virtual_force: f64,
    hold: DelayedHold,
    /// Time of the last line that had one `[s]`.
    last_time: Option<f64>,
    summary: Summary,
}

/// What a pipe did, for its end.
#[derive(Debug, Default, Clone, Serialize)]
struct Summary {
    format: &'static str,
    samples: u64,
    refused: u64,
    limited: u64,
    stored_energy_j: f64,
    port_work_j: f64,
    leak_original_j: f64,
    leak_held_j: f64,
}

impl Pipe {
    fn serve(&mut self, input: &mut impl BufRead, output: &mut impl Write) -> io::Result<()> {
        let mut line = Vec::new();
        for number in 1_u64.. {
            line.clear();
            if input.take(LONGEST_LINE).read_until(b'\n', &mut line)? == 0 {
                break;
            }
            let too_long = line.len() as u64 == LONGEST_LINE && !line.ends_with(b"\n");
            if too_long {
                skip_line(input)?;
            }
            let text = String::from_utf8_lossy(&line);
            let mut text = text.trim();
            if number == 1 {
                // What spreadsheets write before the first line.
                text = text.trim_start_matches('\u{feff}');
                if is_header(text)? {
                    continue;
                }
            }
            let sample = if too_long {
                Err(format!("the line is longer than {LONGEST_LINE} bytes"))
            } else {
                parse(text)
            };
            let force = self.answer(number, sample);
            writeln!(output, "{force}")?;
            output.flush()?;
        }
        Ok(())
    }

    /// Force on the device `[N]` for a line.
    fn answer(&mut self, number: u64, line: Result<Line, String>) -> f64 {
        self.summary.samples += 1;
        let sample = match &line {
            Ok(Line { time, position }) => {
                let elapsed = match (time, self.last_time) {
                    (Some(now), Some(last)) => Some(now - last),
                    _ => None,
                };
                Sample {
                    device_position: *position,
                    elapsed,
                    virtual_force: self.virtual_force,
                }
            }
            // The renderer is told that a sample came and is lost.
            Err(_) => Sample::at(f64::NAN),
        };
        let Output {
            force_on_device,
            force_on_object,
            fault,
            limited,
            ..
        } = self.renderer.step(&mut self.state, sample);
        let held = self.hold.exchange(force_on_object);
        self.renderer.report_held(&mut self.state, held);
        // A time that was refused is kept all the same: if it is wrong, the next line is refused
        // too; if it were not kept and the clock was set, all lines to come would be.
        match line {
            Ok(Line { time: None, .. }) => {
                let period = self.renderer.loop_params().period;
                self.last_time = self.last_time.map(|time| time + period);
            }
            Ok(Line { time, .. }) => self.last_time = time,
            Err(_) => {}
        }
        let message = match (&line, fault) {
            (Err(message), _) => Some(message.clone()),
            (Ok(_), Some(fault)) => Some(fault.to_string()),
            (Ok(_), None) => None,
        };
        if let Some(message) = message {
            self.summary.refused += 1;
            let refused = self.summary.refused;
            if refused <= TOLD_EACH {
                tell(format_args!("line {number}: {message}; the force is 0"));
            } else if refused.is_power_of_two() {
                tell(format_args!(
                    "line {number}: {message}; the force is 0 (refused so far: {refused}; the next to be told is number {})",
                    refused.saturating_mul(2)
                ));
            }
        }
        if limited.any() {
            self.summary.limited += 1;
        }
        force_on_device
    }

    fn summary(&self) -> Summary {
        let ledger = self.state.ledger();
        Summary {
            format: "palpate pipe 1",
            stored_energy_j: ledger.stored,
            port_work_j: ledger.port_work,
            leak_original_j: ledger.original_leak.accumulated,
            leak_held_j: ledger.held_leak.accumulated,
            ..self.summary.clone()
        }
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}, {} refused, {} limited; leak {} mJ, the spring force alone would have leaked {} mJ",
            counted(self.samples, "sample"),
            self.refused,
            counted(self.limited, "force"),
            digits(1e3 * self.leak_held_j),
            digits(1e3 * self.leak_original_j),
        )
    }
}

/// A sample as it stands on a line.
struct Line {
    /// Time `[s]`, if the line has one.
    time: Option<f64>,
    /// Device position `[m]`.
    position: f64,
}

/// Whether a first line names the columns as they are read.
///
/// # Errors
/// A first line that names other columns: with a motor attached, nobody is to guess.
fn is_header(text: &str) -> io::Result<bool> {
    let names: Vec<&str> = text.split(',').map(str::trim).collect();
    match names.as_slice() {
        ["position_m"] | ["t_s", "position_m"] => Ok(true),
        names
            if names
                .iter()
                .any(|name| ["t_s", "position_m"].contains(name)) =>
        {
            Err(io::Error::new(
                io::ErrorKind::InvalidInput,
                "the first line names other columns than `position_m` or `t_s,position_m`",
            ))
        }
        _ => Ok(false),
    }
}

fn parse(text: &str) -> Result<Line, String> {
    if text.is_empty() {
        return Err("the line is empty; a line is `position_m` or `t_s,position_m`".into());
    }
    let number = |field: &str| {
        field.trim().parse::<f64>().map_err(|_| {
            format!(
                "\"{}\" is not a number; a line is `position_m` or `t_s,position_m`",
                field.trim().escape_debug()
            )
        })
    };
    let instant = |field: &str| match number(field) {
        Ok(time) if !time.is_finite() => Err("the time is not a finite number".into()),
        read => read,
    };
    match text.split(',').collect::<Vec<_>>().as_slice() {
        [position] => Ok(Line {
            time: None,
            position: number(position)?,
        }),
        [first, position] => Ok(Line {
            time: Some(instant(first)?),
            position: number(position)?,
        }),
        fields => Err(format!(
            "the line has {} fields; a line is `position_m` or `t_s,position_m`",
            fields.len()
        )),
    }
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
