//! Replay of a recorded hand: what the device would have done under another force.
//!
//! A recorded motion was made by a hand and, where one was held, by a force of the motor. Played back
//! as it is ([`replay`](crate::replay)) the device cannot be moved by what is rendered. Here the hand's
//! force is estimated from the motion and the loop is closed again:
//!
//! ```
//! use std::sync::Arc;
//! use palpate::{Actuation, Contact, LoopParams, ObjectState};
//! use palpate_sim::closed_loop::Bench;
//! use palpate_sim::hand_replay::{self, HandModel, RecordedHand, Recording};
//! use palpate_scene::method::MethodName;
//! use palpate_sim::replay::ReplaySetup;
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
//! # What is known, and how well
//!
//! All samples together give the hand's force and its standard deviation ([`RecordedHand::forces`]), up
//! to a bandwidth that is chosen by likelihood unless it is stated. [`HandUncertainty`] has the figures
//! for a report, with a check: the estimated force, put on a device of the same mass together with the
//! recorded one, gives the recorded motion back within `given_back_within`.
//!
//! What is not known is what the hand would have done had the device moved otherwise. By itself the
//! force stays what it was; then nothing brings the device back, and the two motions part for good once
//! the forces have differed by an impulse. With [`HandModel::stiffness`] and `damping` the hand holds on
//! to its recorded motion; both are the caller's to state, and [`HandModel::holding_on`] has usual ones.

pub use palpate_testbed::recorded_hand::{
    HandError, HandForce, HandModel, HandUncertainty, RecordedHand, Recording,
};

use std::collections::HashMap;
use std::sync::Arc;

use crate::replay::ReplaySetup;
use crate::run::{Reference, Run};
use palpate_scene::method::MethodName;
use palpate_scene::{ActuatorParams, Delay, Measure, Scene, SceneDevice, Timing, Told};

/// How far, in recording steps, the end of the last period may lie behind that of the recording: time
/// stamps are written in decimals.
const SAME_INSTANT: f64 = 1e-6;

/// The closed loop of `setup` with `hand` in place of the one that was recorded, over the whole periods of
/// the recording; times count from its first sample. The device has the mass of the hand's model; what
/// a renderer is told is the setup's, if it says one.
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
        told_device_mass: setup.device_mass,
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
        told: Told {
            delay_deviation: Some(actuation.delay_deviation),
            lag_deviation: Some(actuation.lag_deviation),
            gain_deviation: Some(actuation.gain_deviation),
            transmission: actuation.transmission,
            ..Told::default()
        },
        measure: Measure::Duration(periods * period),
        method: MethodName::default(),
        settings: HashMap::new(),
    })
}

/// The same loop, sampling when the recorded one did, in place of every period: at each of the hand's
/// samples, whether it has a position or not.
///
/// # Errors
/// A recording that is shorter than a period.
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

/// No arm follows a device farther than this `[m]`; what is replayed beyond it is no hand.
pub const REACH: f64 = 1.0;

/// How far from its recorded motion the device of the ideal gets, at most `[m]`: beyond [`REACH`] the
/// contact, the mass or the hand that was stated makes no sense for the recording.
pub fn largest_ideal_departure(hand: &RecordedHand, ideal: &Reference) -> f64 {
    let points = ideal.curve.iter();
    points
        .map(|point| (point.device_position - hand.motion(point.time).0).abs())
        .fold(0.0, f64::max)
}

/// How far from its recorded motion the device of `run` got, at most `[m]`.
pub fn largest_departure(hand: &RecordedHand, run: &Run) -> f64 {
    run.ticks
        .iter()
        .map(|tick| (tick.true_device_position - hand.motion(tick.time).0).abs())
        .fold(0.0, f64::max)
}
