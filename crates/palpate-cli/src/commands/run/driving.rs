//! A loop on its thread, with its progress on standard error.

use std::path::Path;
use std::time::Duration;

use crate::devices::drive as drive_loop;
use palpate_device::Device;
use palpate_device::clock::Clock;
use palpate_record::recording::{Recording, RecordingMetadata};
use palpate_rt::realtime::{Answer, Request};
use palpate_rt::{Account, ControlLoop, LoopEnd, Renders, StopFlag};

use crate::failure::{Failure, tell};
use crate::progress::Progress;
use crate::recorded::open as open_recording;
use crate::reports::Guarding;
use crate::values::duration;

/// A finished loop.
pub struct Ran<C: Clock, R: Renders> {
    /// End of the loop.
    pub end: LoopEnd<Box<dyn Device>, C, R>,
    /// Properties granted by the machine.
    pub answers: Vec<Answer>,
    /// Account of its messages.
    pub account: Account,
    /// Its recording, read back, if one was written.
    pub recording: Option<Recording>,
    /// Error of a requested recording that could not be written.
    pub unwritten: Option<Failure>,
}

/// Runs a loop until a signal, its last period or the loss of its device ends it. Records it on request.
pub fn drive<C: Clock, R: Renders + 'static>(
    control: ControlLoop<Box<dyn Device>, C, R>,
    record: Option<(&Path, RecordingMetadata)>,
    request: Request,
    most: Option<u64>,
    guarding: &Guarding,
) -> Result<Ran<C, R>, Failure> {
    let stop = StopFlag::on_signals()
        .map_err(|error| Failure::System(format!("cannot handle signals: {error}")))?;
    let progress = Progress::new(1);
    progress.begin("running; ctrl-C ends it");
    let to = record.as_ref().map(|(path, metadata)| (*path, metadata));
    let model = |words: std::fmt::Arguments| tell(words);
    let ran = drive_loop(control, to, (request, &stop), most, guarding, &model);
    drop(progress);
    let ran = ran.map_err(|error| Failure::System(error.to_string()))?;
    let unwritten = ran
        .unwritten
        .map(|error| Failure::System(error.to_string()));
    let recording = match (&unwritten, &record) {
        (None, Some((path, _))) => Some(open_recording(path)?),
        _ => None,
    };
    Ok(Ran {
        end: ran.end,
        answers: ran.answers,
        account: ran.account,
        recording,
        unwritten,
    })
}

/// Returns the number of periods in a duration `[s]`, or `None` if only a signal ends the run.
pub fn most_periods(seconds: f64, period: Duration) -> Result<Option<u64>, Failure> {
    if seconds == f64::INFINITY {
        return Ok(None);
    }
    let periods = duration("--duration", seconds)?
        .as_nanos()
        .div_ceil(period.as_nanos());
    Ok(Some(u64::try_from(periods).unwrap_or(u64::MAX)))
}
