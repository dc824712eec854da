//! A recorded motion as a device.

use std::path::Path;

use palpate_device::clock::Clock;
use palpate_device::{Device, ReplayDevice};
use palpate_record::trace::Part;
use palpate_study::recording::Ticks;

use super::DeviceArguments;
use crate::arguments::TraceFlags;
use crate::failure::Failure;
use crate::recorded::trace::read_trace;
use crate::recorded::{self, open as open_recording};
use crate::values::duration;

/// Opens the motion of `--motion`, from its first sample.
pub fn open<C: Clock>(arguments: &DeviceArguments, clock: &C) -> Result<Box<dyn Device>, Failure> {
    let path = arguments.motion.as_ref().ok_or_else(|| {
        Failure::Arguments("--device replay needs --motion TRACE.csv or REC.mcap".into())
    })?;
    let part = arguments.part.part(f64::INFINITY)?;
    let (times, positions) = motion(path, &part, &arguments.table)?;
    let first = times.first().copied().unwrap_or(0.0);
    let samples = times
        .iter()
        .zip(&positions)
        .map(|(time, position)| Ok((duration("--motion", time - first)?, [*position, 0.0, 0.0])))
        .collect::<Result<Vec<_>, Failure>>()?;
    let device = ReplayDevice::new(clock.clone(), 1, samples)
        .map_err(|error| Failure::input(format_args!("{}: {error}", path.display())))?;
    Ok(Box::new(device))
}

/// Checks that the replayed recording is complete, if the motion came from one, and reports its gaps.
pub fn whole_or_said(arguments: &DeviceArguments) -> Result<(), Failure> {
    match &arguments.motion {
        Some(path) if is_recording(path) => recorded::whole_or_said(&open_recording(path)?),
        _ => Ok(()),
    }
}

fn is_recording(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension == "mcap")
}

/// Reads times `[s]` and positions `[m]` of a trace, or of the valid samples of a recording.
fn motion(path: &Path, part: &Part, table: &TraceFlags) -> Result<(Vec<f64>, Vec<f64>), Failure> {
    if is_recording(path) {
        if let Some(flag) = table.given() {
            return Err(Failure::Arguments(format!(
                "{flag} is for a trace; a recording has its own columns, in seconds and metres"
            )));
        }
        let ticks = Ticks::new(&open_recording(path)?, part).map_err(Failure::input)?;
        let curves = ticks.curves;
        return Ok((curves.time, curves.device_position));
    }
    let trace = read_trace(path, &path.display().to_string(), part, table)?.trace;
    Ok((trace.t_s, trace.position_m))
}
