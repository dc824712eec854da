//! The hand of a recording, held against a new force; whatever the recording came from.

use std::collections::HashMap;
use std::sync::Arc;

use palpate_scene::method::{MethodName, Settings};
use palpate_sim::closed_loop::{Bench, LoopError};
use palpate_sim::hand_replay::{
    self, HandError, HandModel, REACH, RecordedHand, Recording, largest_departure,
    largest_ideal_departure,
};
use palpate_sim::replay::ReplaySetup;
use palpate_sim::run::{Reference, Run};
use palpate_testbed::InvalidParameter;

use crate::arguments::ReplayFlags;
use crate::failure::{Failure, tell};
use crate::progress::Progress;
use palpate_study::report::Replayed;
use palpate_study::text::digits;

/// What was recorded of a hand.
pub struct Recorded<'a> {
    /// What the recording is called in messages.
    pub name: &'a str,
    /// Motion and force.
    pub recording: Recording<'a>,
    /// Mass of the device that the hand moved `[kg]`.
    pub device_mass: f64,
    /// Whether the loop samples when the recorded one did; else every period.
    pub at_its_instants: bool,
}

/// The runs of a replay.
pub struct ReplayRuns {
    /// Its ideal.
    pub reference: Reference,
    /// One for each method.
    pub runs: Vec<Run>,
    /// What was replayed, and how well it is known.
    pub replayed: Replayed,
}

/// Estimates the hand of a recording, and closes the loop of `setup` by each of `methods`. What cannot
/// be set up for a method is told by `failure`.
pub fn close_loop(
    recorded: &Recorded,
    (setup, flags): (&ReplaySetup, &ReplayFlags),
    (methods, settings): (&[MethodName], &HashMap<MethodName, Settings>),
    progress: &Progress,
    failure: &dyn Fn(MethodName, LoopError) -> Failure,
) -> Result<ReplayRuns, Failure> {
    let model = HandModel {
        encoder_quantum: setup.encoder_quantum,
        bandwidth: flags.hand_bandwidth,
        stiffness: flags.hand_stiffness.unwrap_or(HandModel::USUAL_STIFFNESS),
        damping: flags.hand_damping.unwrap_or(HandModel::USUAL_DAMPING),
        ..HandModel::force_on(recorded.device_mass)
    };
    progress.begin("the hand's force");
    let in_recording = |error| in_recording(recorded.name, error);
    let hand = RecordedHand::estimate(&recorded.recording, &model).map_err(in_recording)?;
    let hand = Arc::new(hand);
    let scene_of = if recorded.at_its_instants {
        hand_replay::scene_at_recorded_instants
    } else {
        hand_replay::scene
    };
    let mut scene = scene_of(Arc::clone(&hand), setup).map_err(in_recording)?;
    scene.settings.clone_from(settings);
    progress.begin("ideal");
    let bench = Bench::new(&scene).map_err(|error| failure(scene.method, error))?;
    within_reach(recorded.name, &hand, bench.reference())?;
    let mut runs = Vec::with_capacity(methods.len());
    for &method in methods {
        progress.begin(method.name());
        runs.push(bench.run(method).map_err(|error| failure(method, error))?);
        progress.advance();
    }
    let departures: Vec<(MethodName, f64)> = methods
        .iter()
        .zip(&runs)
        .map(|(method, run)| (*method, largest_departure(&hand, run)))
        .collect();
    for (method, departure) in departures
        .iter()
        .filter(|(_, by)| *by > REACH || by.is_nan())
    {
        tell(format_args!(
            "warning: {method}: the device leaves the recorded motion by {} m, farther than an arm reaches \
             ({REACH} m); what stands in its row is no answer of a hand",
            digits(*departure)
        ));
    }
    let force_recorded = recorded.recording.forces_on_device.is_some();
    let is_assumed = flags.hand_stiffness.is_none() || flags.hand_damping.is_none();
    let replayed = Replayed::hand(&hand, force_recorded, is_assumed, departures);
    Ok(ReplayRuns {
        reference: bench.reference().clone(),
        runs,
        replayed,
    })
}

/// Refuses a replay in which even the ideal device goes where no hand can follow.
fn within_reach(name: &str, hand: &RecordedHand, ideal: &Reference) -> Result<(), Failure> {
    let departure = largest_ideal_departure(hand, ideal);
    if departure <= REACH {
        return Ok(());
    }
    let model = hand.model();
    Err(Failure::Arguments(format!(
        "{name}: held by a hand of {} N/m and {} N s/m, the device would leave the recorded motion by {} m \
         under the new force, even were that ideal, and no arm reaches farther than {REACH} m; allowed: a \
         hand that holds on (--hand-stiffness {} --hand-damping {} unless you say otherwise), and contact, \
         weight and --device-mass that it can hold",
        model.stiffness,
        model.damping,
        digits(departure),
        HandModel::USUAL_STIFFNESS,
        HandModel::USUAL_DAMPING,
    )))
}

/// A recording without a hand, or a flag that gave a wrong model of it.
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
