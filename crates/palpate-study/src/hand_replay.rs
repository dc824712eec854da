//! Replay of a recorded hand under a new force, independent of the source of the recording.

use std::collections::HashMap;
use std::sync::Arc;

use crate::sim::closed_loop::{Bench, LoopError};
use crate::sim::hand_replay::{
    self, HandError, HandModel, REACH, RecordedHand, Recording, largest_departure,
    largest_ideal_departure,
};
use crate::sim::replay::ReplaySetup;
use crate::sim::run::{Reference, Run};
use palpate_scene::method::{MethodName, Settings};

use crate::report::Replayed;

/// Recorded data of a hand.
#[derive(Clone, Copy, Debug)]
pub struct HandRecording<'a> {
    /// Motion and force.
    pub recording: Recording<'a>,
    /// Whether the loop samples at the recorded instants; otherwise every period.
    pub at_its_instants: bool,
}

/// The runs of a replay.
#[derive(Clone, Debug)]
pub struct ReplayRuns {
    /// The ideal.
    pub reference: Reference,
    /// One for each method.
    pub runs: Vec<Run>,
    /// The replayed motion or hand, and its accuracy.
    pub replayed: Replayed,
}

/// Reason why the loop could not be closed around a recorded hand.
#[derive(Debug)]
pub enum HandReplayError {
    /// The recording contains no data of a hand, or the model of the hand is invalid.
    Hand(HandError),
    /// A method cannot be set up, or the loop cannot be run.
    Loop(MethodName, LoopError),
    /// The ideal device already moves farther than an arm reaches.
    OutOfReach {
        /// The hand.
        model: HandModel,
        /// Distance of the device from the recorded motion `[m]`.
        departure: f64,
    },
}

/// Estimates the hand of a recording by `model` and closes the loop of `setup` by each of `methods`. Calls `begins`
/// at the start of each step. The report states whether stiffness or damping of the model `is_assumed`. Also returns
/// the methods under which the device leaves the recorded motion farther than an arm reaches, with the distances
/// `[m]`.
///
/// # Errors
/// The recording contains no data of a hand, its model is invalid, a method cannot be set up, or the motion exceeds the
/// reach of an arm.
pub fn close_loop(
    recorded: &HandRecording,
    (setup, model, is_assumed): (&ReplaySetup, &HandModel, bool),
    (methods, settings): (&[MethodName], &HashMap<MethodName, Settings>),
    mut begins: impl FnMut(HandReplayStep),
) -> Result<(ReplayRuns, Vec<(MethodName, f64)>), HandReplayError> {
    begins(HandReplayStep::Hand);
    let hand = RecordedHand::estimate(&recorded.recording, model).map_err(HandReplayError::Hand)?;
    let hand = Arc::new(hand);
    let scene_of = if recorded.at_its_instants {
        hand_replay::scene_at_recorded_instants
    } else {
        hand_replay::scene
    };
    let mut scene = scene_of(Arc::clone(&hand), setup).map_err(HandReplayError::Hand)?;
    scene.settings.clone_from(settings);
    begins(HandReplayStep::Ideal);
    let failed = HandReplayError::Loop;
    let bench = Bench::new(&scene).map_err(|error| failed(scene.method, error))?;
    let departure = largest_ideal_departure(&hand, bench.reference());
    if departure > REACH || departure.is_nan() {
        let model = *hand.model();
        return Err(HandReplayError::OutOfReach { model, departure });
    }
    let mut runs = Vec::with_capacity(methods.len());
    for &method in methods {
        begins(HandReplayStep::Method(method));
        runs.push(bench.run(method).map_err(|error| failed(method, error))?);
        begins(HandReplayStep::Done);
    }
    let departures: Vec<(MethodName, f64)> = methods
        .iter()
        .zip(&runs)
        .map(|(method, run)| (*method, largest_departure(&hand, run)))
        .collect();
    let beyond = departures.iter().copied();
    let beyond = beyond
        .filter(|(_, by)| *by > REACH || by.is_nan())
        .collect();
    let force_recorded = recorded.recording.forces_on_device.is_some();
    let replayed = Replayed::hand(&hand, force_recorded, is_assumed, departures);
    let runs = ReplayRuns {
        reference: bench.reference().clone(),
        runs,
        replayed,
    };
    Ok((runs, beyond))
}

/// Current step of a hand replay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HandReplayStep {
    /// The hand's force is estimated.
    Hand,
    /// The ideal is computed.
    Ideal,
    /// The loop is closed by this method.
    Method(MethodName),
    /// End of a method.
    Done,
}
