//! Errors of parameters, in terms of their flags.

use std::borrow::Cow;

use palpate_core::{Allowed, Parameter, ParameterError};
use palpate_scene::method::{SettingKey, SettingsError};
use palpate_scene::{SceneParameter, SceneParameterError, SetupError};
use palpate_testbed::InvalidParameter;

use crate::arguments::{Flags, TimingFlags, flag_of_setting};
use crate::failure::Failure;

/// A flag, and whether it was given.
type FlagOf = (Cow<'static, str>, bool);

/// A flag that takes a value.
fn valued<T>(flag: &'static str, value: Option<T>) -> Option<FlagOf> {
    Some((Cow::Borrowed(flag), value.is_some()))
}

impl TimingFlags {
    /// Returns the flag of a scene's parameter, if one of these sets it.
    fn flag_of(&self, parameter: SceneParameter) -> Option<FlagOf> {
        match parameter {
            SceneParameter::DelayFraction => valued("--delay-fraction", self.delay_fraction),
            SceneParameter::Jitter => valued("--jitter", self.jitter),
            SceneParameter::DropProbability => valued("--drop", self.drop),
            SceneParameter::Seed => valued("--seed", self.seed),
            _ => None,
        }
    }

    /// Whether a flag sets a parameter.
    pub fn gives(&self, parameter: SceneParameter) -> bool {
        self.flag_of(parameter).is_some_and(|(_, given)| given)
    }
}

impl Flags {
    /// Returns the flag of a scene's parameter, if one of these sets it.
    fn flag_of(&self, parameter: SceneParameter) -> Option<FlagOf> {
        let of = &self.actuation;
        match parameter {
            SceneParameter::Rendered(parameter) => self.flag_of_rendered(parameter),
            SceneParameter::ModelDeviceMass => {
                valued("--model-device-mass", self.model_device_mass)
            }
            SceneParameter::DelaySamples | SceneParameter::DelaySeconds => {
                valued(of.delay_flag(), of.delay.or(of.delay_periods))
            }
            SceneParameter::Lag => valued("--lag", of.lag),
            SceneParameter::Gain => valued("--gain", of.gain),
            SceneParameter::ModelDelay => valued("--model-delay", of.model_delay),
            SceneParameter::DelayFraction
            | SceneParameter::Jitter
            | SceneParameter::DropProbability
            | SceneParameter::Seed
            | SceneParameter::ObjectRadius
            | SceneParameter::DevicePosition
            | SceneParameter::DeviceVelocity
            | SceneParameter::ViscousFriction
            | SceneParameter::CoulombFriction
            | SceneParameter::MotorLimit
            | SceneParameter::Resonance
            | SceneParameter::ResonanceDamping
            | SceneParameter::MotorMassFraction
            | SceneParameter::ModelSensorQuantum
            | SceneParameter::Backlash
            | SceneParameter::Cogging
            | SceneParameter::CoggingPitch
            | SceneParameter::SensorNoise
            | SceneParameter::ModelSensorNoise
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
            | SceneParameter::Duration => None,
        }
    }

    fn flag_of_rendered(&self, parameter: Parameter) -> Option<FlagOf> {
        let of = &self.actuation;
        match parameter {
            Parameter::Stiffness => valued("--stiffness", self.stiffness),
            Parameter::ObjectMass => valued("--mass", self.mass),
            Parameter::VirtualForce => valued("--force", self.force),
            Parameter::ObjectPosition => valued("--object-position", self.object_position),
            Parameter::ObjectVelocity => valued("--object-velocity", self.object_velocity),
            Parameter::Side => valued("--side", self.side),
            Parameter::Period => valued("--period", self.period),
            Parameter::Delay => valued(of.delay_flag(), of.delay.or(of.delay_periods)),
            Parameter::ForceLimit => valued("--force-limit", self.force_limit),
            Parameter::SlewLimit => valued("--slew-limit", self.slew_limit),
            Parameter::SpeedLimit => valued("--speed-limit", self.speed_limit),
            Parameter::LargestGap => valued("--largest-gap", self.largest_gap),
            Parameter::GuardSpeed => valued("--guard-speed", self.guard_speed),
            Parameter::GuardAllowance => valued("--guard-allowance", self.guard_allowance),
            Parameter::GuardAcceleration => valued("--guard-acceleration", self.guard_acceleration),
            Parameter::GuardHandForce => valued("--guard-hand-force", self.guard_hand_force),
            Parameter::GuardMass => valued("--guard-mass", self.guard_mass),
            Parameter::GuardRecovery => valued("--guard-recovery", self.guard_recovery),
            Parameter::DeviceMass => valued("--device-mass", self.device_mass),
            Parameter::EncoderQuantum | Parameter::NoiseBound | Parameter::GuardQuantum => {
                valued("--encoder-quantum", self.encoder_quantum)
            }
            Parameter::DelayDeviation => valued("--delay-deviation", of.delay_deviation),
            Parameter::Lag => valued("--lag", of.lag.or(of.model_lag)),
            Parameter::LagDeviation => valued("--lag-deviation", of.lag_deviation),
            Parameter::Gain => valued("--gain", of.gain.or(of.model_gain)),
            Parameter::GainDeviation => valued("--gain-deviation", of.gain_deviation),
            Parameter::Resonance => valued("--resonance", of.resonance),
            Parameter::ResonanceDampingRatio => {
                valued("--resonance-damping-ratio", of.resonance_damping_ratio)
            }
            Parameter::FlexibleMassFraction => {
                valued("--flexible-mass-fraction", of.flexible_mass_fraction)
            }
            // A key of scenes alone.
            Parameter::HoldOrder => None,
            Parameter::Setting(setting) => {
                let is_given = self.settings().has(setting.key);
                Some((flag_of_setting(setting).into(), is_given))
            }
            // No flag sets these.
            Parameter::DerivedDamping
            | Parameter::AxisOrigin
            | Parameter::AxisNormal
            | Parameter::AxisNormalLength
            | Parameter::Kappa
            | Parameter::ObjectKappa
            | Parameter::Own { .. } => None,
        }
    }

    /// Whether a flag sets a parameter.
    pub fn gives(&self, parameter: SceneParameter) -> bool {
        self.flag_of(parameter).is_some_and(|(_, given)| given)
    }
}

/// Explains a parameter out of range by the flag that set it.
pub fn wrong_flag(error: &SceneParameterError) -> Failure {
    let parameter = error.parameter;
    let flag = Flags::default().flag_of(parameter);
    let flag = flag.or_else(|| TimingFlags::default().flag_of(parameter));
    Failure::Arguments(match flag {
        Some((flag, _)) => error.called(flag).to_string(),
        None => error.to_string(),
    })
}

/// Explains an error of the core as [`wrong_flag`] does.
pub fn wrong_rendered(error: &ParameterError) -> Failure {
    wrong_flag(&error.map(SceneParameter::Rendered))
}

/// Explains a value that the flag of a parameter does not allow.
pub(super) fn not_allowed(parameter: Parameter, value: f64, allowed: Allowed) -> Failure {
    wrong_rendered(&ParameterError {
        parameter,
        value,
        allowed,
    })
}

/// Explains an invalid value as [`not_allowed`] does, for another flag that sets the same parameter.
pub(super) fn not_allowed_by(flag: &'static str, error: ParameterError) -> Failure {
    Failure::Arguments(error.called(flag).to_string())
}

/// Explains a value rejected by the simulation; the scene was checked, so the flag is unknown.
pub fn wrong_on_bench(error: &InvalidParameter) -> Failure {
    Failure::Arguments(format!(
        "{} is {}, but must be {}",
        error.name, error.value, error.allowed
    ))
}

/// Explains a method that cannot be set up from flags alone.
pub fn wrong_setup(error: &SetupError) -> Failure {
    match error {
        SetupError::Parameter(parameter) => wrong_flag(parameter),
        SetupError::HoldsConstant(_) => Failure::Arguments(error.to_string()),
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
                "{method} needs --device-mass <kg>: the mass of your device at the grip, above 0 and accurate within a \
                 factor of 2; or --scene <SCENE.toml>, whose device has a mass; or {without}, which needs none"
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
        SetupError::Settings(error @ SettingsError::NoRule { setting, word, .. }) => {
            Failure::Arguments(format!("{} {word}: {error}", flag_of_setting(setting)))
        }
    }
}
