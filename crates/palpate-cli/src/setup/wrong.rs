//! Errors of parameters in terms of the flags that give them.

use std::borrow::Cow;

use palpate::{Allowed, Parameter, ParameterError};
use palpate_scene::method::{SettingKey, SettingsError};
use palpate_scene::{SceneParameter, SceneParameterError, SetupError};
use palpate_testbed::InvalidParameter;

use crate::arguments::flag_of_setting;
use crate::failure::Failure;

/// The flag that gives a parameter of a scene, if one does.
fn flag_of(parameter: SceneParameter) -> Option<Cow<'static, str>> {
    Some(Cow::Borrowed(match parameter {
        SceneParameter::Rendered(parameter) => return flag_of_rendered(parameter),
        SceneParameter::ToldDeviceMass => "--told-device-mass",
        SceneParameter::DelayFraction => "--delay-fraction",
        SceneParameter::DelaySeconds => "--delay",
        SceneParameter::Lag => "--lag",
        SceneParameter::Gain => "--gain",
        SceneParameter::ToldDelay => "--told-delay",
        SceneParameter::Jitter => "--jitter",
        SceneParameter::DropProbability => "--drop",
        SceneParameter::Seed => "--seed",
        SceneParameter::ObjectRadius
        | SceneParameter::DevicePosition
        | SceneParameter::DeviceVelocity
        | SceneParameter::ViscousFriction
        | SceneParameter::CoulombFriction
        | SceneParameter::MotorLimit
        | SceneParameter::Resonance
        | SceneParameter::ResonanceDamping
        | SceneParameter::MotorMassShare
        | SceneParameter::Backlash
        | SceneParameter::Cogging
        | SceneParameter::CoggingPitch
        | SceneParameter::SensorNoise
        | SceneParameter::ToldSensorNoise
        | SceneParameter::CommandJitter
        | SceneParameter::HandForce
        | SceneParameter::Tremor
        | SceneParameter::TremorFrequency
        | SceneParameter::Release
        | SceneParameter::HandMass
        | SceneParameter::HandStiffness
        | SceneParameter::HandDamping
        | SceneParameter::HandPosition
        | SceneParameter::Swing
        | SceneParameter::SwingFrequency
        | SceneParameter::JitterDeviation
        | SceneParameter::DroppedSamples
        | SceneParameter::CollapseFrom
        | SceneParameter::CollapseUntil
        | SceneParameter::CollapsePeriod
        | SceneParameter::Collisions
        | SceneParameter::Duration => return None,
    }))
}

fn flag_of_rendered(parameter: Parameter) -> Option<Cow<'static, str>> {
    Some(Cow::Borrowed(match parameter {
        Parameter::Stiffness => "--stiffness",
        Parameter::ObjectMass => "--mass",
        Parameter::VirtualForce => "--force",
        Parameter::ObjectPosition => "--object-position",
        Parameter::ObjectVelocity => "--object-velocity",
        Parameter::Side => "--side",
        Parameter::Period => "--period",
        Parameter::Delay => "--delay",
        Parameter::ForceLimit => "--force-limit",
        Parameter::SlewLimit => "--slew-limit",
        Parameter::SpeedLimit => "--speed-limit",
        Parameter::LargestGap => "--largest-gap",
        Parameter::GuardSpeed => "--guard-speed",
        Parameter::GuardAllowance => "--guard-allowance",
        Parameter::DeviceMass => "--device-mass",
        Parameter::EncoderQuantum | Parameter::NoiseBound => "--encoder-quantum",
        Parameter::DelayDeviation => "--delay-deviation",
        Parameter::Lag => "--lag",
        Parameter::LagDeviation => "--lag-deviation",
        Parameter::Gain => "--gain",
        Parameter::GainDeviation => "--gain-deviation",
        Parameter::Resonance => "--resonance",
        Parameter::ResonanceDampingRatio => "--resonance-damping-ratio",
        Parameter::FlexibleMassFraction => "--flexible-mass-fraction",
        Parameter::Setting(setting) => return Some(flag_of_setting(setting).into()),
        // Nobody gives these by a flag.
        Parameter::DerivedDamping
        | Parameter::AxisOrigin
        | Parameter::AxisNormal
        | Parameter::AxisNormalLength
        | Parameter::Kappa
        | Parameter::ObjectKappa
        | Parameter::Own { .. } => return None,
    }))
}

/// A parameter out of range, in terms of the flag that gave it.
pub fn wrong_flag(error: &SceneParameterError) -> Failure {
    let flag = flag_of(error.parameter);
    Failure::Arguments(match flag {
        Some(flag) => error.called(flag).to_string(),
        None => error.to_string(),
    })
}

/// As [`wrong_flag`], of what the core refuses.
pub fn wrong_rendered(error: &ParameterError) -> Failure {
    wrong_flag(&error.map(SceneParameter::Rendered))
}

/// A value that the flag of a parameter cannot have.
pub(super) fn not_allowed(parameter: Parameter, value: f64, allowed: Allowed) -> Failure {
    wrong_rendered(&ParameterError {
        parameter,
        value,
        allowed,
    })
}

/// As [`not_allowed`], of another flag that gives the same parameter.
pub(super) fn not_allowed_by(flag: &'static str, error: ParameterError) -> Failure {
    Failure::Arguments(error.called(flag).to_string())
}

/// A value that the bench refuses; the scene was checked, so no flag is known that gave it.
pub fn wrong_on_bench(error: &InvalidParameter) -> Failure {
    Failure::Arguments(format!(
        "{} is {}, but must be {}",
        error.name, error.value, error.allowed
    ))
}

/// A method that cannot be set up from flags alone.
pub fn wrong_setup(error: &SetupError) -> Failure {
    match error {
        SetupError::Parameter(parameter) => wrong_flag(parameter),
        SetupError::Settings(SettingsError::Unused { method, setting }) => {
            Failure::Arguments(format!(
                "{} cannot be used by method {method}; it is for {}",
                flag_of_setting(setting),
                setting.key.users()
            ))
        }
        SetupError::Settings(SettingsError::NoDeviceMass(setting)) => Failure::Arguments(format!(
            "{} auto needs --device-mass <kg>",
            flag_of_setting(setting)
        )),
        SetupError::Settings(SettingsError::NoPushedMass(method)) => {
            let without = if method.uses(SettingKey::PREDICTION) {
                "--prediction last-step"
            } else {
                "--method hfcr"
            };
            Failure::Arguments(format!(
                "{method} needs --device-mass <kg>: what your device weighs where it is held, above 0 \
                 and right within a factor of 2; or --scene <SCENE.toml>, whose device has a mass; \
                 or {without}, which needs none"
            ))
        }
        SetupError::Settings(SettingsError::OnlyBeside {
            method,
            setting,
            other,
            needed,
            is,
        }) => Failure::Arguments(format!(
            "{}, or {} of a scene, is for {} {needed}, but the {} of {method} is {is}",
            flag_of_setting(setting),
            setting.key,
            flag_of_setting(other),
            other.name(),
        )),
        SetupError::Settings(error @ SettingsError::NoRule { setting, .. }) => {
            Failure::Arguments(format!("{} auto: {error}", flag_of_setting(setting)))
        }
    }
}
