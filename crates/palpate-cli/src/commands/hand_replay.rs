//! Replay of a recorded hand against a new force: its parameters and its messages.

use std::collections::HashMap;

use palpate_scene::method::{MethodName, Settings};
use palpate_study::hand_replay::{
    HandRecording, HandReplayError, HandReplayStep, close_loop as close,
};
use palpate_study::sim::closed_loop::LoopError;
use palpate_study::sim::hand_replay::{HandError, HandModel, REACH, Recording};
use palpate_study::sim::replay::ReplaySetup;
use palpate_testbed::InvalidParameter;

use crate::arguments::ReplayFlags;
use crate::failure::{Failure, tell};
use crate::progress::Progress;
pub use palpate_study::hand_replay::ReplayRuns;
use palpate_study::text::digits;

/// Recording of a hand.
pub struct Recorded<'a> {
    /// Name of the recording in messages.
    pub name: &'a str,
    /// Motion and force.
    pub recording: Recording<'a>,
    /// Mass of the device that the hand moved `[kg]`.
    pub device_mass: f64,
    /// Whether the loop samples at the recorded instants; else every period.
    pub at_its_instants: bool,
}

/// Estimates the hand of a recording, and closes the loop of `setup` by each of `methods`. `failure` reports a failed
/// setup of a method.
pub fn close_loop(
    recorded: &Recorded,
    (setup, flags): (&ReplaySetup, &ReplayFlags),
    (methods, settings): (&[MethodName], &HashMap<MethodName, Settings>),
    progress: &Progress,
    failure: &dyn Fn(MethodName, LoopError) -> Failure,
) -> Result<ReplayRuns, Failure> {
    let stated = flags.stated_hand();
    let model = stated.model(recorded.device_mass, setup.encoder_quantum);
    let recording = HandRecording {
        recording: recorded.recording,
        at_its_instants: recorded.at_its_instants,
    };
    let model = (setup, &model, stated.is_assumed());
    let (runs, beyond) = close(&recording, model, (methods, settings), tell_step(progress))
        .map_err(|error| wrong_hand(recorded.name, error, failure))?;
    warn_beyond_reach(&beyond);
    Ok(runs)
}

/// Shows the progress of a replay.
pub fn tell_step(progress: &Progress) -> impl FnMut(HandReplayStep) {
    |step| match step {
        HandReplayStep::Hand => progress.begin("hand force"),
        HandReplayStep::Ideal => progress.begin("ideal"),
        HandReplayStep::Method(method) => progress.begin(method.name()),
        HandReplayStep::Done => progress.advance(),
    }
}

/// Explains why the loop could not be closed around the hand of the recording called `name`.
pub fn wrong_hand(
    name: &str,
    error: HandReplayError,
    failure: &dyn Fn(MethodName, LoopError) -> Failure,
) -> Failure {
    match error {
        HandReplayError::Hand(error) => in_recording(name, error),
        HandReplayError::Loop(method, error) => failure(method, error),
        HandReplayError::OutOfReach { model, departure } => out_of_reach(name, &model, departure),
    }
}

/// Warns of methods with which the device leaves the reach of a hand.
pub fn warn_beyond_reach(beyond: &[(MethodName, f64)]) {
    for (method, departure) in beyond {
        tell(format_args!(
            "warning: {method}: the device leaves the recorded motion by {} m, farther than an arm reaches \
             ({REACH} m); the values in its row are not those of a hand",
            digits(*departure)
        ));
    }
}

/// Rejects a replay in which even the ideal device leaves the reach of a hand.
fn out_of_reach(name: &str, model: &HandModel, departure: f64) -> Failure {
    Failure::Arguments(format!(
        "{name}: held by a hand of {} N/m and {} N s/m, the device leaves the recorded motion by {} m even under the \
         ideal force, farther than an arm reaches ({REACH} m); use a stiffer hand (default: --hand-stiffness {} \
         --hand-damping {}), or a contact, weight and --device-mass that it can hold",
        model.stiffness,
        model.damping,
        digits(departure),
        HandModel::USUAL_STIFFNESS,
        HandModel::USUAL_DAMPING,
    ))
}

/// Converts the error of a recording without a hand, or of a flag with a wrong hand model.
fn in_recording(name: &str, error: HandError) -> Failure {
    match error {
        HandError::Model(InvalidParameter {
            name,
            value,
            allowed,
        }) => Failure::Arguments(format!(
            "--{} is {value}, but must be {allowed}",
            name.replace('_', "-")
        )),
        other => Failure::input(format!("{name}: {other}")),
    }
}
