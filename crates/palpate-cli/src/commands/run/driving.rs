//! A loop on its thread, from its first tick to its end, whatever it renders.

use std::path::Path;
use std::time::Duration;

use palpate_device::Device;
use palpate_device::clock::Clock;
use palpate_record::recording::{Receipt, Recording};
use palpate_rt::realtime::{Answer, Request};
use palpate_rt::{Account, ControlLoop, LoopEnd, LoopThread, Recorder, Renders, StopFlag};
use palpate_session::Guarding;

use crate::failure::{Failure, tell};
use crate::progress::Progress;
use crate::recorded::open as open_recording;
use crate::values::duration;

/// A loop that ran.
pub struct Ran<C: Clock, R: Renders> {
    /// How it ended.
    pub end: LoopEnd<Box<dyn Device>, C, R>,
    /// What the machine granted.
    pub answers: Vec<Answer>,
    /// What was heard of it.
    pub account: Account,
    /// Its recording, read back, if one was written.
    pub recording: Option<Recording>,
    /// Why it could not be written, if it was to be and could not.
    pub unwritten: Option<Failure>,
}

/// Runs a loop until a signal, its last period or the loss of its device ends it, and records it if it is to.
pub fn drive<C: Clock, R: Renders + 'static>(
    control: ControlLoop<Box<dyn Device>, C, R>,
    record: Option<(&Path, Receipt)>,
    request: Request,
    most: Option<u64>,
    guarding: &Guarding,
) -> Result<Ran<C, R>, Failure> {
    let (tap, recorder) = match &record {
        Some((out, receipt)) => {
            Recorder::begin(out, receipt).map_err(|error| Failure::System(error.to_string()))?
        }
        None => Recorder::without_file()
            .map_err(|error| Failure::System(format!("no thread to listen: {error}")))?,
    };
    // Nobody waits for a loop that runs as fast as it can.
    let tap = if C::RUNS { tap } else { tap.waiting() };
    let stop =
        StopFlag::on_signals().map_err(|error| Failure::System(format!("no signals: {error}")))?;
    let progress = Progress::new(1);
    progress.begin("running; ctrl-C ends it");
    let running = LoopThread::start(control.tapped(tap), request, &stop, most)
        .map_err(|error| Failure::System(format!("no thread for the loop: {error}")))?;
    let refused = running
        .answers()
        .iter()
        .filter(|answer| !answer.is_granted());
    for answer in refused {
        tell(format_args!("warning: {answer}"));
    }
    let answers = running.answers().to_vec();
    tell_of_losses(&running, &recorder, guarding);
    let end = running.join();
    // What the run was is told whether or not it could be written.
    let (account, unwritten) = recorder.finish();
    let unwritten = unwritten.map(|error| Failure::System(error.to_string()));
    drop(progress);
    let recording = match (&unwritten, &record) {
        (None, Some((path, _))) => Some(open_recording(path)?),
        _ => None,
    };
    Ok(Ran {
        end,
        answers,
        account,
        recording,
        unwritten,
    })
}

/// How many periods a run of so many seconds has; `None` for one that only a signal ends.
pub fn most_periods(seconds: f64, period: Duration) -> Result<Option<u64>, Failure> {
    if seconds == f64::INFINITY {
        return Ok(None);
    }
    let periods = duration("--duration", seconds)?
        .as_nanos()
        .div_ceil(period.as_nanos());
    Ok(Some(u64::try_from(periods).unwrap_or(u64::MAX)))
}

/// How often it is looked whether the loop has ended, or can no longer be written down.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// Waits for the end of the loop. A recording that cannot be written and a guardian that is lost are told
/// at once: the rest of a session would be for nothing, and nobody would know.
fn tell_of_losses<D: Device, C: Clock, R: Renders>(
    running: &LoopThread<D, C, R>,
    recorder: &Recorder,
    guarding: &Guarding,
) {
    let mut is_told = false;
    let mut is_guardian_told = false;
    while !running.has_ended() {
        if let Some((_, lost)) = guarding.lost().filter(|_| !is_guardian_told) {
            is_guardian_told = true;
            tell(format_args!(
                "warning: {lost}; the loop commands no force until the device is opened anew"
            ));
        }
        if let Some(why) = recorder.failure().filter(|_| !is_told) {
            is_told = true;
            tell(format_args!(
                "warning: {why}; the loop goes on, and is not recorded any more"
            ));
        }
        std::thread::sleep(LOOK_EVERY);
    }
}
