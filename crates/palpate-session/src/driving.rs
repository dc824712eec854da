//! A loop on its thread, from its first tick to its end, whatever it renders.

use std::fmt;
use std::io;
use std::path::Path;
use std::time::Duration;

use palpate_device::Device;
use palpate_device::clock::Clock;
use palpate_files::atomic::WriteError;
use palpate_record::recording::Receipt;
use palpate_rt::realtime::{Answer, Request};
use palpate_rt::{Account, ControlLoop, LoopEnd, LoopThread, Recorder, Renders, StopFlag};

use crate::guardian::Guarding;

/// A loop that ran.
pub struct Ran<D: Device, C: Clock, R: Renders> {
    /// How it ended.
    pub end: LoopEnd<D, C, R>,
    /// What the machine granted.
    pub answers: Vec<Answer>,
    /// What was heard of it.
    pub account: Account,
    /// Why it could not be written, if it was to be and could not.
    pub unwritten: Option<WriteError>,
}

/// Why a loop could not begin.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DriveError {
    /// Its recording cannot be written.
    #[error(transparent)]
    Record(#[from] WriteError),
    /// The system gives no thread that listens to it.
    #[error("no thread to listen: {0}")]
    Listener(io::Error),
    /// The system gives it no thread.
    #[error("no thread for the loop: {0}")]
    Thread(io::Error),
}

/// Runs a loop until `stop` is raised, or its last period or the loss of its device ends it, and records it if it is to.
/// What the machine refuses, and what is lost on the way, is `told` at once.
///
/// # Errors
/// It could not begin.
pub fn drive<D: Device + 'static, C: Clock, R: Renders + 'static>(
    control: ControlLoop<D, C, R>,
    record: Option<(&Path, &Receipt)>,
    (request, stop): (Request, &StopFlag),
    most: Option<u64>,
    guarding: &Guarding,
    told: &dyn Fn(fmt::Arguments),
) -> Result<Ran<D, C, R>, DriveError> {
    let (tap, recorder) = match record {
        Some((out, receipt)) => Recorder::begin(out, receipt)?,
        None => Recorder::without_file().map_err(DriveError::Listener)?,
    };
    // Nobody waits for a loop that runs as fast as it can.
    let tap = if C::RUNS { tap } else { tap.waiting() };
    let running =
        LoopThread::start(control.tapped(tap), request, stop, most).map_err(DriveError::Thread)?;
    let refused = running
        .answers()
        .iter()
        .filter(|answer| !answer.is_granted());
    for answer in refused {
        told(format_args!("warning: {answer}"));
    }
    let answers = running.answers().to_vec();
    tell_of_losses(&running, &recorder, guarding, told);
    let end = running.join();
    // What the run was is told whether or not it could be written.
    let (account, unwritten) = recorder.finish();
    Ok(Ran {
        end,
        answers,
        account,
        unwritten,
    })
}

/// How often it is looked whether the loop has ended, or can no longer be written down.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// Waits for the end of the loop. A recording that cannot be written and a guardian that is lost are told
/// at once: the rest of a session would be for nothing, and nobody would know.
fn tell_of_losses<D: Device, C: Clock, R: Renders>(
    running: &LoopThread<D, C, R>,
    recorder: &Recorder,
    guarding: &Guarding,
    told: &dyn Fn(fmt::Arguments),
) {
    let mut is_told = false;
    let mut is_guardian_told = false;
    while !running.has_ended() {
        if let Some((_, lost)) = guarding.lost().filter(|_| !is_guardian_told) {
            is_guardian_told = true;
            told(format_args!(
                "warning: {lost}; the loop commands no force until the device is opened anew"
            ));
        }
        if let Some(why) = recorder.failure().filter(|_| !is_told) {
            is_told = true;
            told(format_args!(
                "warning: {why}; the loop goes on, and is not recorded any more"
            ));
        }
        std::thread::sleep(LOOK_EVERY);
    }
}
