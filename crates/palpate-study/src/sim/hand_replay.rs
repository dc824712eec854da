//! Replay of a recorded hand: predicts the device's motion under another force.
//!
//! A recorded motion results from the force of a hand and, if the motor was on, of the motor. In a plain
//! [`replay`](crate::sim::replay) the rendered force cannot move the device. Here the hand's force is estimated from
//! the motion, and the loop is closed again:
//!
//! ```
//! use std::sync::Arc;
//! use palpate_core::{Actuation, Contact, LoopParams, ObjectState};
//! use palpate_study::sim::closed_loop::Bench;
//! use palpate_study::sim::hand_replay::{self, HandModel, RecordedHand, Recording};
//! use palpate_scene::method::MethodName;
//! use palpate_study::sim::replay::ReplaySetup;
//!
//! // Half a second of a hand that swings by 5 mm, seen at 1 kHz; the motor was off.
//! let times: Vec<f64> = (0..=500).map(|i| f64::from(i) * 1e-3).collect();
//! let positions: Vec<f64> = times.iter().map(|t| -5e-3 * (12.0 * t).cos()).collect();
//! let recording = Recording { times: &times, positions: &positions, forces_on_device: None };
//! let hand = RecordedHand::estimate(&recording, &HandModel::force_on(0.25))?;
//! assert!(hand.uncertainty().force_deviation < 0.05); // [N]
//!
//! let setup = ReplaySetup {
//!     contact: Contact::object(400.0, 0.1),
//!     loop_params: LoopParams::new(0.01),
//!     object: ObjectState::at_rest(0.0),
//!     virtual_force: 0.0,
//!     actuation: Actuation::default(),
//!     device_mass: None,
//!     encoder_quantum: 0.0,
//! };
//! let scene = hand_replay::scene(Arc::new(hand), &setup)?;
//! let run = Bench::new(&scene)?.run(MethodName::Coupled)?;
//! assert!(run.force.fidelity.is_some());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Estimated quantities and their uncertainty
//!
//! All samples together determine the hand's force and its standard deviation ([`RecordedHand::forces`]), up to a
//! bandwidth that is chosen by likelihood unless it is given. [`HandUncertainty`] has the figures for a report,
//! including a check: the estimated and the recorded force, applied to a device of the same mass, reproduce the
//! recorded motion within `given_back_within`.
//!
//! The hand's reaction to a different motion of the device is unknown. By default the force is that of the recording.
//! Nothing then returns the device, and the two motions separate permanently once the forces have differed by an
//! impulse. With [`HandModel::stiffness`] and `damping` the hand holds on to its recorded motion. The caller chooses
//! both; [`HandModel::holding_on`] has usual values.

pub use palpate_testbed::recorded_hand::{
    HandError, HandForce, HandModel, HandUncertainty, RecordedHand, Recording,
};

use std::collections::HashMap;
use std::sync::Arc;

use crate::sim::replay::ReplaySetup;
use crate::sim::run::{Reference, Run};
use palpate_scene::method::MethodName;
use palpate_scene::{ActuatorParams, Delay, Measure, Model, Scene, SceneDevice, Timing};

/// Tolerance on the end of the last period beyond that of the recording, in recording steps: time stamps are decimal.
const SAME_INSTANT: f64 = 1e-6;

/// Returns the closed loop of `setup` with `hand` in place of the recorded one, over the whole periods of the
/// recording; times count from its first sample. The device has the mass of the hand's model. The renderer's model mass
/// is that of the setup, if given.
///
/// # Errors
/// A recording that is shorter than a period.
pub fn scene(hand: Arc<RecordedHand>, setup: &ReplaySetup) -> Result<Scene, HandError> {
    let period = setup.loop_params.period;
    let duration = hand.duration();
    let periods = ((duration + SAME_INSTANT * hand.last_step().min(period)) / period).floor();
    if periods < 1.0 {
        return Err(HandError::TooShort {
            recorded: duration,
            period,
        });
    }
    let actuation = setup.actuation;
    Ok(Scene {
        title: "Recorded hand".into(),
        contact: setup.contact,
        loop_params: setup.loop_params,
        object: setup.object,
        virtual_force: setup.virtual_force,
        device: SceneDevice::Recorded {
            hand,
            encoder_quantum: setup.encoder_quantum,
            at_its_instants: false,
        },
        model_device_mass: setup.device_mass,
        object_radius: 0.0,
        delay: if setup.delay().is_whole() {
            setup.delay()
        } else {
            Delay::Seconds(actuation.delay)
        },
        timing: Timing::default(),
        actuator: ActuatorParams {
            gain: actuation.gain,
            lag: actuation.lag,
        },
        model: Model {
            delay_deviation: Some(actuation.delay_deviation),
            lag_deviation: Some(actuation.lag_deviation),
            gain_deviation: Some(actuation.gain_deviation),
            transmission: actuation.transmission,
            ..Model::default()
        },
        measure: Measure::Duration(periods * period),
        method: MethodName::default(),
        settings: HashMap::new(),
    })
}

/// Returns the same loop with samples at the recorded instants instead of every period: at each of the hand's samples,
/// with or without a position.
///
/// # Errors
/// The recording is shorter than a period.
pub fn scene_at_recorded_instants(
    hand: Arc<RecordedHand>,
    setup: &ReplaySetup,
) -> Result<Scene, HandError> {
    let mut scene = scene(hand, setup)?;
    if let SceneDevice::Recorded {
        at_its_instants, ..
    } = &mut scene.device
    {
        *at_its_instants = true;
    }
    Ok(scene)
}

/// Reach of an arm `[m]`; a replayed device farther away is no longer in a hand.
pub const REACH: f64 = 1.0;

/// Returns the largest distance between the ideal's device and its recorded motion `[m]`. Beyond [`REACH`] the contact,
/// the mass or the hand does not fit the recording.
pub fn largest_ideal_departure(hand: &RecordedHand, ideal: &Reference) -> f64 {
    let points = ideal.curve.iter();
    points
        .map(|point| (point.device_position - hand.motion(point.time).0).abs())
        .fold(0.0, f64::max)
}

/// Returns the largest distance between the device of `run` and its recorded motion `[m]`.
pub fn largest_departure(hand: &RecordedHand, run: &Run) -> f64 {
    run.ticks
        .iter()
        .map(|tick| (tick.true_device_position - hand.motion(tick.time).0).abs())
        .fold(0.0, f64::max)
}
