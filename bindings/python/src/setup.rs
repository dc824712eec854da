//! Converts arguments of Python to contact, loop, object and device model.

use palpate_core::{
    Actuation, Allowed, BasicParams, Contact, Hold, LARGEST_DELAY, LoopParams, Mass, ObjectState,
    Parameter, ParameterError, Range, Renderer, Side,
};
use palpate_scene::{GuardBounds, GuardConflict, GuardMode};
use palpate_study::sim::replay::ReplaySetup;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::fields::named;
use crate::names::{refused, wrong_argument};

/// Arguments of contact, loop, object and device, as passed by the Python files, which fill in all defaults.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Arguments {
    stiffness: f64,
    mass: f64,
    period: f64,
    force: f64,
    object_position: f64,
    object_velocity: f64,
    side: String,
    unilateral: bool,
    force_limit: f64,
    slew_limit: Option<f64>,
    speed_limit: Option<f64>,
    largest_gap: Option<f64>,
    guard: String,
    guard_speed: f64,
    guard_allowance: Option<f64>,
    guard_acceleration: Option<f64>,
    guard_hand_force: Option<f64>,
    guard_mass: Option<f64>,
    guard_learn_mass: bool,
    guard_recovery: Option<f64>,
    delay: f64,
    delay_deviation: f64,
    lag: f64,
    lag_deviation: f64,
    gain: f64,
    gain_deviation: f64,
    hold: String,
    device_mass: Option<f64>,
    encoder_quantum: f64,
}

/// Reads and checks the arguments that do not depend on the method.
///
/// # Errors
/// The first invalid value, by the name of its argument.
pub fn setup(arguments: &Bound<'_, PyDict>) -> PyResult<ReplaySetup> {
    let given: Arguments = arguments
        .extract()
        .map_err(|error| named(arguments, error))?;
    given.check_facts()?;
    let mut contact = Contact::object(given.stiffness, given.mass);
    contact.side = side_named(&given.side)?;
    contact.unilateral = given.unilateral;
    if contact.object_mass == Mass::Infinite && given.object_velocity != 0.0 {
        let allowed = Allowed::Words("0 for a wall");
        return Err(not_allowed(
            Parameter::ObjectVelocity,
            given.object_velocity,
            allowed,
        ));
    }
    let guard = guard_named(&given.guard)?;
    let bounds = GuardBounds {
        speed: Some(given.guard_speed),
        allowance: given.guard_allowance,
        acceleration: given.guard_acceleration,
        hand_force: given.guard_hand_force,
        least_mass: given.guard_mass,
        learns_mass: given.guard_learn_mass,
        recovery: given.guard_recovery,
    };
    check_hand(&bounds)?;
    let setup = ReplaySetup {
        contact,
        loop_params: LoopParams {
            largest_gap: given.largest_gap,
            speed_limit: given.speed_limit,
            // An infinite limit means no limit.
            force_limit: (given.force_limit != f64::INFINITY).then_some(given.force_limit),
            slew_limit: given.slew_limit,
            guard: guard.guard(bounds),
            ..LoopParams::new(given.period)
        },
        object: ObjectState {
            position: given.object_position,
            velocity: given.object_velocity,
        },
        virtual_force: given.force,
        actuation: Actuation {
            delay: given.delay,
            lag: given.lag,
            gain: given.gain,
            delay_deviation: given.delay_deviation,
            lag_deviation: given.lag_deviation,
            gain_deviation: given.gain_deviation,
            transmission: None,
            hold: hold_named(&given.hold)?,
        },
        device_mass: given.device_mass,
        encoder_quantum: given.encoder_quantum,
    };
    // Check contact and loop first: their faults do not depend on the method. Basic plans constants for any hold.
    let mut loop_params = setup.known_loop();
    loop_params.actuation.hold = Hold::Constant;
    Renderer::new(setup.contact, loop_params, BasicParams)
        .and_then(|renderer| renderer.start(setup.object))
        .map_err(|error| wrong_argument(&error))?;
    Ok(setup)
}

/// Rejects a delay above the largest model delay, because a running loop has no other compensation for it.
pub fn check_delay(setup: &ReplaySetup) -> PyResult<()> {
    let (samples, fraction) = (setup.delay().whole_samples(), setup.delay().fraction());
    let periods = samples as f64 + fraction;
    if periods > LARGEST_DELAY as f64 {
        return Err(refused(format!(
            "delay is {} s, {periods} periods, but must be at most {LARGEST_DELAY} periods",
            setup.actuation.delay
        )));
    }
    Ok(())
}

impl Arguments {
    /// Rejects impossible values, whether or not a method uses them.
    fn check_facts(&self) -> PyResult<()> {
        for (parameter, value) in [
            (Parameter::VirtualForce, Some(self.force)),
            (Parameter::DeviceMass, self.device_mass),
            (Parameter::EncoderQuantum, Some(self.encoder_quantum)),
            (Parameter::Delay, Some(self.delay)),
            (Parameter::DelayDeviation, Some(self.delay_deviation)),
            (Parameter::Lag, Some(self.lag)),
            (Parameter::LagDeviation, Some(self.lag_deviation)),
            (Parameter::Gain, Some(self.gain)),
            (Parameter::GainDeviation, Some(self.gain_deviation)),
        ] {
            check_fact(parameter, value)?;
        }
        Ok(())
    }
}

/// Rejects bounds of the hand that exclude or miss each other.
pub fn check_hand(bounds: &GuardBounds) -> PyResult<()> {
    match bounds.conflict() {
        None => Ok(()),
        Some(GuardConflict::MassAlone) => Err(refused(
            "guard_mass and guard_learn_mass need guard_acceleration or guard_hand_force",
        )),
        Some(GuardConflict::TwoLimits) => Err(refused(
            "guard_hand_force excludes guard_acceleration; give one",
        )),
    }
}

/// Rejects an impossible value, if one is given.
pub fn check_fact(parameter: Parameter, value: Option<f64>) -> PyResult<()> {
    let range = match parameter {
        Parameter::VirtualForce => Range::Finite,
        Parameter::DeviceMass | Parameter::Gain => Range::Positive,
        _ => Range::NotNegative,
    };
    match value {
        Some(value) if !range.contains(value) => {
            Err(not_allowed(parameter, value, Allowed::Range(range)))
        }
        _ => Ok(()),
    }
}

/// Returns the side of a contact by its name.
pub fn side_named(name: &str) -> PyResult<Side> {
    Side::named(name).ok_or_else(|| not_a_word("side", name, &Side::ALL.map(Side::name)))
}

/// Returns what an actuator holds by its name.
fn hold_named(name: &str) -> PyResult<Hold> {
    Hold::named(name).ok_or_else(|| not_a_word("hold", name, &Hold::ALL.map(Hold::name)))
}

/// Returns the mode of a guard by its name.
pub fn guard_named(name: &str) -> PyResult<GuardMode> {
    let words = GuardMode::ALL.map(GuardMode::name);
    GuardMode::named(name).ok_or_else(|| not_a_word("guard", name, &words))
}

fn not_allowed(parameter: Parameter, value: f64, allowed: Allowed) -> PyErr {
    wrong_argument(&ParameterError {
        parameter,
        value,
        allowed,
    })
}

fn not_a_word(name: &str, given: &str, words: &[&str]) -> PyErr {
    refused(format!(
        "{name} is \"{given}\", but must be \"{}\"",
        words.join("\" or \"")
    ))
}
