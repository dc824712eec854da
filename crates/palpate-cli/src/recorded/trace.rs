//! Traces in commands.

use std::fs::File;
use std::io;
use std::path::Path;

use palpate_record::trace::{
    self, HeldTrace, LedDevice, Part, ReadNotes, TraceError, TraceFault, WorldTrace,
};
use palpate_scene::world::WorldDevice;
use palpate_study::report::RecordedMotion;
use palpate_study::sim::run::MAX_PERIODS;
use palpate_study::text::digits;

use crate::arguments::TraceFlags;
use crate::failure::{Failure, tell};
use crate::inside;

/// Name of standard input.
pub const STANDARD_INPUT: &str = "-";

/// If the largest number of periods lasts less than this `[s]`, the period is wrong, not the trace.
const SHORTEST_FIT: f64 = 1.0;

/// Returns the remedy for a recording with too many periods.
pub fn how_to_cut() -> String {
    format!(
        "at most {MAX_PERIODS} are allowed: select a part with --from and --to [s], or use a longer period"
    )
}

/// Rejects a recording at the place of a table.
pub fn reject_recording(path: &Path, name: &str) -> Result<(), Failure> {
    if super::ends_in(path, "mcap") {
        return Err(Failure::Arguments(format!(
            "{name} is a recording: pass it to `palpate replay`, or to `--motion` of `run --device replay`"
        )));
    }
    Ok(())
}

/// Reads a part of the trace at `path`, with the held force if the table has it.
pub fn read_trace(
    path: &Path,
    name: &str,
    part: &Part,
    flags: &TraceFlags,
) -> Result<HeldTrace, Failure> {
    reject_recording(path, name)?;
    let layout = flags.layout();
    let read = if path == Path::new(STANDARD_INPUT) {
        trace::read_part(io::stdin().lock(), name, part, &layout)
    } else {
        trace::read_part(opened(path, name)?, name, part, &layout)
    };
    let held = read.map_err(wrong_trace)?;
    tell_notes(name, &held.notes);
    let HeldTrace { trace, .. } = &held;
    inside::check_motion(name, &trace.t_s, &[&trace.position_m], flags)?;
    Ok(held)
}

/// Reads a part of the table at `path` with the motion of a world's devices.
pub fn read_world_trace(
    path: &Path,
    part: &Part,
    flags: &TraceFlags,
    devices: &[WorldDevice],
    names: &[&str],
) -> Result<WorldTrace, Failure> {
    let name = path.display().to_string();
    let led = names.iter().zip(devices).map(|(name, device)| LedDevice {
        name: (*name).to_owned(),
        turns: device.turning.is_some(),
    });
    let led: Vec<_> = led.collect();
    let file = opened(path, &name)?;
    let trace = trace::read_world(file, &name, part, &flags.layout(), &led).map_err(wrong_trace)?;
    tell_notes(&name, &trace.notes);
    let mut coordinates = vec![Vec::with_capacity(trace.t_s.len()); 3 * devices.len()];
    for places in &trace.positions_m {
        let numbers = places.iter().flatten();
        for (coordinate, number) in coordinates.iter_mut().zip(numbers) {
            coordinate.push(*number);
        }
    }
    let coordinates: Vec<&[f64]> = coordinates.iter().map(Vec::as_slice).collect();
    inside::check_motion(&name, &trace.t_s, &coordinates, flags)?;
    let starts = names.iter().zip(devices).zip(&trace.positions_m[0]);
    for ((device, of), start) in starts {
        inside::check_start(&name, device, (of.position, *start), flags)?;
    }
    Ok(trace)
}

fn opened(path: &Path, name: &str) -> Result<File, Failure> {
    let file = File::open(path).map_err(|error| Failure::System(format!("{name}: {error}")))?;
    palpate_record::files::inputs::note(path);
    Ok(file)
}

/// Reports notes about the text of the table called `name`.
fn tell_notes(name: &str, notes: &ReadNotes) {
    if let Some(number) = &notes.unended {
        tell(format_args!(
            "warning: {name}: the last line has no line end, so its last number, `{number}`, may be cut off, and its \
             sample is left out; if it is complete, add a line end"
        ));
    }
}

/// Warns of a gap in the motion called `name` that a straight line bridges.
pub fn tell_gap(name: &str, motion: &RecordedMotion) {
    if let Some(warning) = motion.warning() {
        tell(format_args!("warning: {name}: {warning}"));
    }
}

fn wrong_trace(error: TraceError) -> Failure {
    match &error {
        TraceError::Unreadable { .. } => Failure::System(error.to_string()),
        TraceError::Layout { .. } => Failure::Arguments(format!("--columns: {error}")),
        // The last line that was read is not the cause.
        TraceError::Invalid {
            place,
            fault: TraceFault::TooLong { longest, first },
        } => {
            let fits = longest * MAX_PERIODS as f64 / (MAX_PERIODS + 1) as f64;
            let message = format!(
                "{}: the trace continues for more than {MAX_PERIODS} periods ({} s) after its first sample at {first} \
                 s; {}",
                place.file(),
                digits(fits),
                how_to_cut()
            );
            if fits < SHORTEST_FIT {
                Failure::Arguments(format!("--period is too short: {message}"))
            } else {
                Failure::input(message)
            }
        }
        TraceError::Invalid { place, .. } => {
            Failure::input_at(&error, place.file(), place.text(), place.span())
        }
    }
}
