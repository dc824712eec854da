//! Python names of parameters, and errors that use them.

use palpate_core::{Parameter, ParameterError, Setting, SettingKey, SettingsError};
use palpate_scene::{SceneParameter, SceneParameterError, SetupError};
use palpate_study::sim::replay::ReplayError;
use palpate_testbed::InvalidParameter;
use pyo3::PyErr;
use pyo3::exceptions::PyValueError;

/// Returns a ValueError.
pub fn refused(message: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(message.to_string())
}

/// Returns the argument that sets a parameter, if there is one.
fn argument_of(parameter: Parameter) -> Option<&'static str> {
    Some(match parameter {
        Parameter::Stiffness => "stiffness",
        Parameter::ObjectMass => "mass",
        Parameter::VirtualForce => "force",
        Parameter::ObjectPosition => "object_position",
        Parameter::ObjectVelocity => "object_velocity",
        Parameter::Side => "side",
        Parameter::Period => "period",
        Parameter::Delay => "delay",
        Parameter::ForceLimit => "force_limit",
        Parameter::SlewLimit => "slew_limit",
        Parameter::SpeedLimit => "speed_limit",
        Parameter::LargestGap => "largest_gap",
        Parameter::GuardSpeed => "guard_speed",
        Parameter::GuardAllowance => "guard_allowance",
        Parameter::GuardAcceleration => "guard_acceleration",
        Parameter::GuardHandForce => "guard_hand_force",
        Parameter::GuardMass => "guard_mass",
        Parameter::GuardRecovery => "guard_recovery",
        Parameter::DeviceMass => "device_mass",
        Parameter::EncoderQuantum | Parameter::NoiseBound | Parameter::GuardQuantum => {
            "encoder_quantum"
        }
        Parameter::DelayDeviation => "delay_deviation",
        Parameter::Lag => "lag",
        Parameter::LagDeviation => "lag_deviation",
        Parameter::Gain => "gain",
        Parameter::GainDeviation => "gain_deviation",
        Parameter::HoldOrder => "hold",
        Parameter::Setting(setting) => setting.name(),
        // No argument sets these.
        Parameter::DerivedDamping
        | Parameter::AxisOrigin
        | Parameter::AxisNormal
        | Parameter::AxisNormalLength
        | Parameter::Resonance
        | Parameter::ResonanceDampingRatio
        | Parameter::FlexibleMassFraction
        | Parameter::Kappa
        | Parameter::ObjectKappa
        | Parameter::Own { .. } => return None,
    })
}

/// Returns the error for a parameter outside its range, with the name of its argument.
pub fn wrong_argument(error: &ParameterError) -> PyErr {
    match argument_of(error.parameter) {
        Some(name) => refused(error.called(name)),
        None => refused(error),
    }
}

fn wrong_of_scene(error: &SceneParameterError) -> PyErr {
    match error.parameter {
        SceneParameter::Rendered(parameter) => wrong_argument(&ParameterError {
            parameter,
            value: error.value,
            allowed: error.allowed,
        }),
        _ => refused(error),
    }
}

/// Returns the error for a method that cannot be set up from arguments.
pub fn wrong_setup(error: &SetupError) -> PyErr {
    match error {
        SetupError::Parameter(parameter) => wrong_of_scene(parameter),
        SetupError::Settings(settings) => wrong_settings(settings),
        SetupError::HoldsConstant(_) => refused(error),
    }
}

/// Returns the error for a setting that a method does not use.
pub fn unused(setting: &Setting, method: impl std::fmt::Display) -> PyErr {
    let (name, users) = (setting.name(), setting.key.users());
    refused(format!(
        "{name} cannot be used by method {method}; it is for {users}"
    ))
}

fn wrong_settings(error: &SettingsError) -> PyErr {
    match error {
        SettingsError::Unused { method, setting } => unused(setting, method),
        SettingsError::NoDeviceMass(setting) => refused(format!(
            "{}=\"auto\" needs device_mass [kg]",
            setting.name()
        )),
        SettingsError::NoPushedMass(method) => {
            let without = if method.uses(SettingKey::PREDICTION) {
                "prediction=\"last-step\""
            } else {
                "method=\"hfcr\""
            };
            refused(format!(
                "{method} needs device_mass [kg]: the effective mass of the device, above 0 and accurate \
                 within a factor of 2; or {without}, which needs none"
            ))
        }
        SettingsError::OnlyBeside {
            method,
            setting,
            other,
            needed,
            is,
        } => {
            let (setting, other) = (setting.name(), other.name());
            refused(format!(
                "{setting} is for {other} {needed}, but the {other} of {method} is {is}"
            ))
        }
        error @ SettingsError::NoRule { setting, word, .. } => {
            refused(format!("{}=\"{word}\": {error}", setting.name()))
        }
    }
}

/// Returns the error for a value that the bench rejects.
pub fn wrong_on_bench(error: &InvalidParameter) -> PyErr {
    let (name, value, allowed) = (error.name, error.value, error.allowed);
    refused(format!("{name} is {value}, but must be {allowed}"))
}

/// Returns the error for a motion that cannot be replayed.
pub fn wrong_replay(error: &ReplayError) -> PyErr {
    match error {
        ReplayError::Setup(error) => wrong_setup(error),
        ReplayError::Bench(error) => wrong_on_bench(error),
        other => refused(other),
    }
}
