//! Parameters of a scene, each with its key.

use palpate_core::{Parameter, ParameterName};

/// A number of a scene, to be matched by value: those of the core, and those of device, hand, loop and
/// window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)] // each stands beside its key
pub enum SceneParameter {
    /// Parameter of the renderer's model.
    Rendered(Parameter),
    ObjectRadius,
    DevicePosition,
    DeviceVelocity,
    ViscousFriction,
    CoulombFriction,
    MotorLimit,
    Resonance,
    ResonanceDamping,
    MotorMassFraction,
    Backlash,
    Cogging,
    CoggingPitch,
    SensorNoise,
    ModelDeviceMass,
    HandForce,
    Tremor,
    TremorFrequency,
    Release,
    HandMass,
    HandStiffness,
    HandDamping,
    HandPosition,
    Swing,
    SwingFrequency,
    DelaySamples,
    DelayFraction,
    DelaySeconds,
    CommandJitter,
    Lag,
    Gain,
    ModelDelay,
    ModelSensorQuantum,
    ModelSensorNoise,
    Jitter,
    JitterDeviation,
    DropProbability,
    DroppedSamples,
    CollapseFrom,
    CollapseUntil,
    CollapsePeriod,
    Seed,
    Collisions,
    Duration,
}

impl From<Parameter> for SceneParameter {
    fn from(parameter: Parameter) -> Self {
        Self::Rendered(parameter)
    }
}

impl SceneParameter {
    /// Returns the key in a scene file, with its table.
    #[must_use]
    pub fn key(self) -> &'static str {
        match self {
            Self::Rendered(parameter) => key_of_rendered(parameter),
            Self::ObjectRadius => "body.centre_m",
            Self::DevicePosition => "device.position_m",
            Self::DeviceVelocity => "device.velocity_m_per_s",
            Self::ViscousFriction => "device.drivetrain.viscous_friction_n_s_per_m",
            Self::CoulombFriction => "device.drivetrain.coulomb_friction_n",
            Self::MotorLimit => "device.drivetrain.motor_limit_n",
            Self::Resonance => "device.drivetrain.resonance_hz",
            Self::ResonanceDamping => "device.drivetrain.resonance_damping_ratio",
            Self::MotorMassFraction => "device.drivetrain.motor_mass_fraction",
            Self::Backlash => "device.drivetrain.backlash_m",
            Self::Cogging => "device.drivetrain.cogging_n",
            Self::CoggingPitch => "device.drivetrain.cogging_pitch_m",
            Self::SensorNoise => "device.noise_m",
            Self::ModelDeviceMass => "model.device_mass_kg",
            Self::HandForce => "device.hand.force_n",
            Self::Tremor => "device.hand.tremor_n",
            Self::TremorFrequency => "device.hand.tremor_hz",
            Self::Release => "device.hand.release_s",
            Self::HandMass => "device.hand.mass_kg",
            Self::HandStiffness => "device.hand.stiffness_n_per_m",
            Self::HandDamping => "device.hand.damping_n_s_per_m",
            Self::HandPosition => "device.hand.rest_m",
            Self::Swing => "device.hand.swing_m",
            Self::SwingFrequency => "device.hand.swing_hz",
            Self::DelaySamples => "loop.delay_samples",
            Self::DelayFraction => "loop.delay_fraction",
            Self::DelaySeconds => "loop.delay_s",
            Self::CommandJitter => "loop.command_jitter_s",
            Self::Lag => "loop.lag_s",
            Self::Gain => "loop.gain",
            Self::ModelDelay => "model.delay_s",
            Self::ModelSensorQuantum => "model.sensor_quantum_m",
            Self::ModelSensorNoise => "model.sensor_noise_m",
            Self::Jitter => "loop.jitter_s",
            Self::JitterDeviation => "loop.jitter_deviation_s",
            Self::DropProbability => "loop.drop_probability",
            Self::DroppedSamples => "loop.dropped_samples",
            Self::CollapseFrom => "loop.collapse.from_s",
            Self::CollapseUntil => "loop.collapse.until_s",
            Self::CollapsePeriod => "loop.collapse.period_s",
            Self::Seed => "loop.seed",
            Self::Collisions => "measure.collisions",
            Self::Duration => "measure.duration_s",
        }
    }
}

fn key_of_rendered(parameter: Parameter) -> &'static str {
    match parameter {
        Parameter::Stiffness => "contact.stiffness_n_per_m",
        Parameter::ObjectMass => "body.mass_kg",
        Parameter::ObjectPosition => "body.position_m",
        Parameter::ObjectVelocity => "body.velocity_m_per_s",
        Parameter::VirtualForce => "body.force_n",
        Parameter::Side => "body.shape.half_space.normal",
        Parameter::Period => "loop.period_s",
        Parameter::Delay => "model.delay_s",
        Parameter::LargestGap => "render.largest_gap_s",
        Parameter::SpeedLimit => "render.speed_limit_m_per_s",
        Parameter::ForceLimit => "render.force_limit_n",
        Parameter::SlewLimit => "render.slew_limit_n_per_s",
        Parameter::GuardSpeed => "render.guard.speed_m_per_s",
        Parameter::GuardAllowance => "render.guard.allowance_j",
        Parameter::GuardAcceleration => "render.guard.acceleration_m_per_s2",
        Parameter::GuardHandForce => "render.guard.hand_force_n",
        Parameter::GuardMass => "render.guard.least_mass_kg",
        Parameter::GuardRecovery => "render.guard.recovery_w",
        Parameter::DeviceMass => "device.mass_kg",
        Parameter::EncoderQuantum | Parameter::GuardQuantum | Parameter::NoiseBound => {
            "device.quantum_m"
        }
        Parameter::Setting(setting) => setting.key.as_str(),
        Parameter::DelayDeviation => "model.delay_deviation_s",
        Parameter::Lag => "model.lag_s",
        Parameter::LagDeviation => "model.lag_deviation_s",
        Parameter::Gain => "model.gain",
        Parameter::GainDeviation => "model.gain_deviation",
        Parameter::Resonance => "model.resonance_hz",
        Parameter::ResonanceDampingRatio => "model.resonance_damping_ratio",
        Parameter::FlexibleMassFraction => "model.flexible_mass_fraction",
        Parameter::HoldOrder => "loop.hold",
        // Parameters without a key in scenes.
        Parameter::DerivedDamping
        | Parameter::AxisOrigin
        | Parameter::AxisNormal
        | Parameter::AxisNormalLength
        | Parameter::Kappa
        | Parameter::ObjectKappa
        | Parameter::Own { .. } => parameter.name(),
    }
}

/// In messages a parameter is called by its key.
impl ParameterName for SceneParameter {
    fn name(&self) -> &'static str {
        self.key()
    }

    fn unit(&self) -> &'static str {
        match self {
            Self::Rendered(parameter) => parameter.unit(),
            Self::ObjectRadius
            | Self::DevicePosition
            | Self::HandPosition
            | Self::Swing
            | Self::Backlash
            | Self::CoggingPitch
            | Self::SensorNoise
            | Self::ModelSensorQuantum
            | Self::ModelSensorNoise => "m",
            Self::DeviceVelocity => "m/s",
            Self::ViscousFriction | Self::HandDamping => "N s/m",
            Self::CoulombFriction
            | Self::MotorLimit
            | Self::Cogging
            | Self::HandForce
            | Self::Tremor => "N",
            Self::ModelDeviceMass | Self::HandMass => "kg",
            Self::TremorFrequency | Self::SwingFrequency | Self::Resonance => "Hz",
            Self::HandStiffness => "N/m",
            Self::Release
            | Self::Jitter
            | Self::JitterDeviation
            | Self::CollapseFrom
            | Self::CollapseUntil
            | Self::CollapsePeriod
            | Self::DelaySeconds
            | Self::CommandJitter
            | Self::Lag
            | Self::ModelDelay
            | Self::Duration => "s",
            Self::DelaySamples => "samples",
            Self::DelayFraction => "periods",
            Self::DropProbability
            | Self::DroppedSamples
            | Self::Seed
            | Self::Collisions
            | Self::Gain
            | Self::ResonanceDamping
            | Self::MotorMassFraction => "",
        }
    }
}
