//! A loop on its own thread, from its first tick to its end, for any rendering.

use std::fmt;
use std::io;
use std::path::Path;
use std::time::Duration;

use palpate_device::Device;
use palpate_device::clock::Clock;
use palpate_record::files::atomic::WriteError;
use palpate_record::recording::RecordingMetadata;
use palpate_rt::realtime::{Answer, Request};
use palpate_rt::{Account, ControlLoop, LoopEnd, LoopThread, Recorder, Renders, StopFlag};

use crate::reports::Guarding;

/// A finished loop.
pub struct Ran<D: Device, C: Clock, R: Renders> {
    /// End state of the loop.
    pub end: LoopEnd<D, C, R>,
    /// Answers of the machine to the real-time requests.
    pub answers: Vec<Answer>,
    /// Account of the ticks and events that the recorder received.
    pub account: Account,
    /// Write error of the recording, if any.
    pub unwritten: Option<WriteError>,
}

/// Reason why a loop cannot start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DriveError {
    /// The recording cannot be written.
    #[error(transparent)]
    Record(#[from] WriteError),
    /// The system cannot start the listener thread.
    #[error("no thread for the recorder: {0}")]
    Listener(io::Error),
    /// The system cannot start the loop thread.
    #[error("no thread for the loop: {0}")]
    Thread(io::Error),
}

/// Runs a loop until `stop` is raised, or until its last period or the loss of its device ends it. Records it if
/// `record` is set. Calls `model` immediately for refused real-time requests and for losses.
///
/// # Errors
/// The loop cannot start.
pub fn drive<D: Device + 'static, C: Clock, R: Renders + 'static>(
    control: ControlLoop<D, C, R>,
    record: Option<(&Path, &RecordingMetadata)>,
    (request, stop): (Request, &StopFlag),
    most: Option<u64>,
    guarding: &Guarding,
    model: &dyn Fn(fmt::Arguments),
) -> Result<Ran<D, C, R>, DriveError> {
    let (tap, recorder) = match record {
        Some((out, metadata)) => Recorder::begin(out, metadata)?,
        None => Recorder::without_file().map_err(DriveError::Listener)?,
    };
    // A loop on a simulated clock runs as fast as it can and may wait for its reader.
    let tap = if C::RUNS { tap } else { tap.waiting() };
    let running =
        LoopThread::start(control.tapped(tap), request, stop, most).map_err(DriveError::Thread)?;
    let refused = running
        .answers()
        .iter()
        .filter(|answer| !answer.is_granted());
    for answer in refused {
        model(format_args!("warning: {answer}"));
    }
    let answers = running.answers().to_vec();
    tell_of_losses(&running, &recorder, guarding, model);
    let end = running.join();
    // The result of the run is reported even if the recording cannot be written.
    let (account, unwritten) = recorder.finish();
    Ok(Ran {
        end,
        answers,
        account,
        unwritten,
    })
}

/// Polling interval for the end of the loop and for write errors.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// Waits for the end of the loop. Reports an unwritable recording or a lost watchdog process immediately: the rest of
/// the session would be useless and the operator would not notice.
fn tell_of_losses<D: Device, C: Clock, R: Renders>(
    running: &LoopThread<D, C, R>,
    recorder: &Recorder,
    guarding: &Guarding,
    model: &dyn Fn(fmt::Arguments),
) {
    let mut is_told = false;
    let mut is_watchdog_informed = false;
    while !running.has_ended() {
        if let Some((_, lost)) = guarding.lost().filter(|_| !is_watchdog_informed) {
            is_watchdog_informed = true;
            model(format_args!(
                "warning: {lost}; the loop commands zero force until the device is reopened"
            ));
        }
        if let Some(why) = recorder.failure().filter(|_| !is_told) {
            is_told = true;
            model(format_args!(
                "warning: {why}; the loop continues without a recording"
            ));
        }
        std::thread::sleep(LOOK_EVERY);
    }
}
