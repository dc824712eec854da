//! The hand of a recording, held against a new force.

use std::sync::Arc;

use palpate_io::trace::Trace;
use palpate_sim::closed_loop::{Bench, LoopError};
use palpate_sim::hand_replay::{
    self, HandError, HandModel, RecordedHand, Recording, largest_departure,
};
use palpate_sim::method::{MethodName, Settings};
use palpate_sim::replay::ReplaySetup;
use palpate_sim::run::{Reference, Run};
use palpate_testbed::InvalidParameter;

use crate::arguments::ReplayFlags;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::report::Replayed;
use crate::setup::{check_contact, wrong_on_bench, wrong_setup};

/// The closed loops of a recorded hand.
pub struct HandRuns {
    /// Its ideal.
    pub reference: Reference,
    /// One for each method.
    pub runs: Vec<Run>,
    /// What is said of the hand.
    pub replayed: Replayed,
}

/// Estimates the hand of a trace that was recorded under `forces`, and closes the loop by each of
/// `methods`.
pub fn render(
    name: &str,
    (trace, forces): (&Trace, Option<&[f64]>),
    (setup, flags): (&ReplaySetup, &ReplayFlags),
    (methods, settings): (&[MethodName], &Settings),
    progress: &Progress,
) -> Result<HandRuns, Failure> {
    let device_mass = setup.device_mass.ok_or_else(|| {
        Failure::Arguments(
            "--replay hand needs --device-mass <kg>, finite and above 0: what the recorded hand moved; \
             --replay motion needs none"
                .into(),
        )
    })?;
    check_contact(setup)?;
    let model = HandModel {
        encoder_quantum: setup.encoder_quantum,
        bandwidth: flags.hand_bandwidth,
        stiffness: flags.hand_stiffness.unwrap_or(0.0),
        damping: flags.hand_damping.unwrap_or(0.0),
        ..HandModel::force_on(device_mass)
    };
    let recording = Recording {
        times: &trace.t_s,
        positions: &trace.position_m,
        forces_on_device: forces,
    };
    progress.begin("the hand's force");
    let in_trace = |error| in_trace(name, error);
    let hand = RecordedHand::estimate(&recording, &model).map_err(in_trace)?;
    let hand = Arc::new(hand);
    let mut scene = hand_replay::scene(Arc::clone(&hand), setup).map_err(in_trace)?;
    for &method in methods {
        scene.settings.insert(method, *settings);
    }
    progress.begin("ideal");
    let bench = Bench::new(&scene).map_err(|error| in_loop(name, error))?;
    let mut runs = Vec::with_capacity(methods.len());
    for &method in methods {
        progress.begin(method.name());
        runs.push(bench.run(method).map_err(|error| in_loop(name, error))?);
        progress.advance();
    }
    let departures = runs.iter().map(|run| largest_departure(&hand, run));
    let replayed = Replayed::hand(&hand, forces.is_some(), departures.collect());
    Ok(HandRuns {
        reference: bench.reference().clone(),
        runs,
        replayed,
    })
}

/// A recording without a hand, or a flag that gave a wrong model of it.
fn in_trace(name: &str, error: HandError) -> Failure {
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

fn in_loop(name: &str, error: LoopError) -> Failure {
    match error {
        LoopError::Setup(error) => wrong_setup(&error),
        LoopError::Bench(error) => wrong_on_bench(&error),
        other => Failure::input(format!("{name}: {other}")),
    }
}
