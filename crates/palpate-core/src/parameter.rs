//! Parameter checks with errors that state the parameter, the value and the allowed range.

use core::fmt;

use crate::Scalar;
use crate::render::Setting;

/// A checked parameter. Callers match on it to report their own key, flag or field name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)] // The variants have the names of the fields.
pub enum Parameter {
    Stiffness,
    ObjectMass,
    ObjectPosition,
    ObjectVelocity,
    VirtualForce,
    Side,
    Period,
    Delay,
    DelayDeviation,
    Lag,
    LagDeviation,
    Gain,
    GainDeviation,
    Resonance,
    ResonanceDampingRatio,
    FlexibleMassFraction,
    /// Order of the actuator's hold: 0 for a constant, 1 for a line.
    HoldOrder,
    LargestGap,
    SpeedLimit,
    ForceLimit,
    SlewLimit,
    GuardSpeed,
    GuardAllowance,
    GuardAcceleration,
    GuardHandForce,
    GuardMass,
    GuardQuantum,
    GuardRecovery,
    DeviceMass,
    EncoderQuantum,
    /// Largest error of a measured position in an adaptive window.
    NoiseBound,
    /// Value of automatic damping.
    DerivedDamping,
    AxisOrigin,
    AxisNormal,
    AxisNormalLength,
    Kappa,
    ObjectKappa,
    /// A setting of a method.
    Setting(&'static Setting),
    /// A parameter of a user-defined method.
    Own {
        /// Its name.
        name: &'static str,
        /// Its unit, empty for a pure number.
        unit: &'static str,
    },
}

/// Name and unit of a parameter in messages.
pub trait ParameterName: Copy {
    /// Returns the name of the field.
    fn name(&self) -> &'static str;
    /// Returns the symbol of the unit, empty for a pure number.
    fn unit(&self) -> &'static str;
}

impl ParameterName for Parameter {
    fn name(&self) -> &'static str {
        match self {
            Self::Stiffness => "stiffness",
            Self::ObjectMass => "object_mass",
            Self::ObjectPosition => "object position",
            Self::ObjectVelocity => "object velocity",
            Self::VirtualForce => "virtual force",
            Self::Side => "side",
            Self::Period => "period",
            Self::Delay => "delay",
            Self::DelayDeviation => "delay_deviation",
            Self::Lag => "lag",
            Self::LagDeviation => "lag_deviation",
            Self::Gain => "gain",
            Self::GainDeviation => "gain_deviation",
            Self::Resonance => "resonance",
            Self::ResonanceDampingRatio => "resonance_damping_ratio",
            Self::FlexibleMassFraction => "flexible_mass_fraction",
            Self::HoldOrder => "order of the hold",
            Self::LargestGap => "largest_gap",
            Self::SpeedLimit => "speed_limit",
            Self::ForceLimit => "force_limit",
            Self::SlewLimit => "slew_limit",
            Self::GuardSpeed => "guard speed",
            Self::GuardAllowance => "guard allowance",
            Self::GuardAcceleration => "guard acceleration",
            Self::GuardHandForce => "guard hand force",
            Self::GuardMass => "guard mass",
            Self::GuardQuantum => "guard quantum",
            Self::GuardRecovery => "guard recovery",
            Self::DeviceMass => "device_mass",
            Self::EncoderQuantum => "encoder_quantum",
            Self::NoiseBound => "noise_bound",
            Self::DerivedDamping => "derived damping",
            Self::AxisOrigin => "origin",
            Self::AxisNormal => "normal",
            Self::AxisNormalLength => "length of normal",
            Self::Kappa => "kappa",
            Self::ObjectKappa => "object_kappa",
            Self::Setting(setting) => setting.name(),
            Self::Own { name, .. } => name,
        }
    }

    fn unit(&self) -> &'static str {
        match self {
            Self::Stiffness => Unit::NewtonPerMetre,
            Self::ObjectMass | Self::DeviceMass | Self::GuardMass => Unit::Kilogram,
            Self::ObjectPosition
            | Self::EncoderQuantum
            | Self::NoiseBound
            | Self::AxisOrigin
            | Self::GuardQuantum => Unit::Metre,
            Self::ObjectVelocity | Self::SpeedLimit | Self::GuardSpeed => Unit::MetrePerSecond,
            Self::VirtualForce | Self::ForceLimit | Self::GuardHandForce => Unit::Newton,
            Self::SlewLimit => Unit::NewtonPerSecond,
            Self::Period
            | Self::LargestGap
            | Self::Delay
            | Self::DelayDeviation
            | Self::Lag
            | Self::LagDeviation => Unit::Second,
            Self::Resonance => Unit::Hertz,
            Self::GuardAcceleration => Unit::MetrePerSecondSquared,
            Self::GuardAllowance => Unit::Joule,
            Self::GuardRecovery => Unit::Watt,
            Self::DerivedDamping => Unit::NewtonSecondPerMetre,
            Self::Side
            | Self::AxisNormal
            | Self::AxisNormalLength
            | Self::Gain
            | Self::GainDeviation
            | Self::ResonanceDampingRatio
            | Self::FlexibleMassFraction
            | Self::HoldOrder
            | Self::Kappa
            | Self::ObjectKappa => Unit::One,
            Self::Setting(setting) => setting.unit().unwrap_or(Unit::One),
            Self::Own { unit, .. } => return unit,
        }
        .symbol()
    }
}

impl Parameter {
    pub(crate) fn within<S: Scalar>(self, range: Range, value: S) -> Result<S, ParameterError> {
        self.unless(range.contains(value), value, Allowed::Range(range))
    }

    pub(crate) fn positive<S: Scalar>(self, value: S) -> Result<S, ParameterError> {
        self.within(Range::Positive, value)
    }

    pub(crate) fn not_negative<S: Scalar>(self, value: S) -> Result<S, ParameterError> {
        self.within(Range::NotNegative, value)
    }

    pub(crate) fn finite<S: Scalar>(self, value: S) -> Result<S, ParameterError> {
        self.within(Range::Finite, value)
    }

    /// Returns `value` if `holds`, otherwise the error that it is not `allowed`.
    pub(crate) fn unless<S: Scalar>(
        self,
        holds: bool,
        value: S,
        allowed: Allowed,
    ) -> Result<S, ParameterError> {
        if holds {
            return Ok(value);
        }
        Err(ParameterError {
            parameter: self,
            value: value.to_f64(),
            allowed,
        })
    }
}

/// Allowed values of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Allowed {
    /// A range.
    Range(Range),
    /// Finite and at least one period of the loop.
    AtLeastOnePeriod,
    /// From 0 to this number of periods of the loop.
    UpToPeriods(usize),
    /// Another condition, in words that follow "must be".
    Words(&'static str),
}

impl fmt::Display for Allowed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range(range) => f.write_str(range.allowed()),
            Self::AtLeastOnePeriod => f.write_str("finite and at least one period"),
            Self::UpToPeriods(most) => write!(f, "0 to {most} periods"),
            Self::Words(words) => f.write_str(words),
        }
    }
}

/// A parameter outside its allowed range: of the core ([`Parameter`]), or of a crate that builds on it.
///
/// Its message contains the parameter, the given value, and the range:
///
/// ```
/// use palpate_core::{BasicParams, Contact, LoopParams, Parameter, Renderer};
///
/// let wrong = Renderer::new(Contact::object(-400.0, 0.1), LoopParams::new(0.001), BasicParams);
/// let error = wrong.unwrap_err();
/// assert_eq!(error.parameter, Parameter::Stiffness);
/// assert_eq!(
///     error.to_string(),
///     "stiffness is -400 N/m, but must be finite and greater than 0"
/// );
/// assert_eq!(
///     error.called("--stiffness").to_string(),
///     "--stiffness is -400 N/m, but must be finite and greater than 0"
/// );
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterError<P = Parameter> {
    /// The parameter.
    pub parameter: P,
    /// Given value, in the parameter's unit.
    pub value: f64,
    /// Allowed values.
    pub allowed: Allowed,
}

impl<P: ParameterName> ParameterError<P> {
    /// Returns the error with another parameter type.
    pub fn map<Q>(self, known_as: impl FnOnce(P) -> Q) -> ParameterError<Q> {
        ParameterError {
            parameter: known_as(self.parameter),
            value: self.value,
            allowed: self.allowed,
        }
    }

    /// Returns the message with another name of the parameter: a key of a file, a flag, a field.
    pub fn called<N: fmt::Display>(&self, name: N) -> impl fmt::Display + use<N, P> {
        Message {
            name,
            unit: self.parameter.unit(),
            value: self.value,
            allowed: self.allowed,
        }
    }
}

struct Message<N> {
    name: N,
    unit: &'static str,
    value: f64,
    allowed: Allowed,
}

impl<N: fmt::Display> fmt::Display for Message<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, value, unit) = (&self.name, self.value, self.unit);
        let space = if unit.is_empty() { "" } else { " " };
        write!(
            f,
            "{name} is {value}{space}{unit}, but must be {}",
            self.allowed
        )
    }
}

impl<P: ParameterName> fmt::Display for ParameterError<P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.called(self.parameter.name()).fmt(f)
    }
}

impl<P: ParameterName + fmt::Debug> core::error::Error for ParameterError<P> {}

/// A unit, with its symbol in messages and its suffix of keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[allow(missing_docs)] // The variants are self-explanatory.
#[non_exhaustive]
pub enum Unit {
    One,
    Metre,
    MetrePerSecond,
    MetrePerSecondSquared,
    Second,
    Kilogram,
    Newton,
    NewtonPerMetre,
    NewtonPerSecond,
    NewtonSecondPerMetre,
    Joule,
    Watt,
    Hertz,
}

impl Unit {
    /// Returns the symbol, empty for a pure number.
    #[must_use]
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::One => "",
            Self::Metre => "m",
            Self::MetrePerSecond => "m/s",
            Self::MetrePerSecondSquared => "m/s^2",
            Self::Second => "s",
            Self::Kilogram => "kg",
            Self::Newton => "N",
            Self::NewtonPerMetre => "N/m",
            Self::NewtonPerSecond => "N/s",
            Self::NewtonSecondPerMetre => "N s/m",
            Self::Joule => "J",
            Self::Watt => "W",
            Self::Hertz => "Hz",
        }
    }

    /// Returns the suffix of keys with this unit, empty for a pure number.
    #[must_use]
    pub const fn suffix(self) -> &'static str {
        match self {
            Self::One => "",
            Self::Metre => "_m",
            Self::MetrePerSecond => "_m_per_s",
            Self::MetrePerSecondSquared => "_m_per_s2",
            Self::Second => "_s",
            Self::Kilogram => "_kg",
            Self::Newton => "_n",
            Self::NewtonPerMetre => "_n_per_m",
            Self::NewtonPerSecond => "_n_per_s",
            Self::NewtonSecondPerMetre => "_n_s_per_m",
            Self::Joule => "_j",
            Self::Watt => "_w",
            Self::Hertz => "_hz",
        }
    }
}

/// The range of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Range {
    /// Any finite number.
    Finite,
    /// Finite and greater than 0.
    Positive,
    /// Finite and not below 0.
    NotNegative,
}

impl Range {
    /// Returns whether `value` is in the range.
    pub fn contains<S: Scalar>(self, value: S) -> bool {
        value.is_finite()
            && match self {
                Self::Finite => true,
                Self::Positive => value > S::ZERO,
                Self::NotNegative => value >= S::ZERO,
            }
    }

    /// Returns the range in words that follow "must be".
    #[must_use]
    pub const fn allowed(self) -> &'static str {
        match self {
            Self::Finite => "finite",
            Self::Positive => "finite and greater than 0",
            Self::NotNegative => "finite and not below 0",
        }
    }
}

/// The value of a parameter, for a report.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterValue<S> {
    /// A number, in the unit that the parameter's key ends with.
    Number(S),
    /// One of several words.
    Word(&'static str),
    /// On or off.
    Switch(bool),
    /// A number to be derived from the contact and the loop.
    ToBeDerived,
}

impl<S: fmt::Display> fmt::Display for ParameterValue<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::Word(word) => f.write_str(word),
            Self::Switch(on) => write!(f, "{on}"),
            Self::ToBeDerived => f.write_str("auto"),
        }
    }
}

impl<S> From<S> for ParameterValue<S>
where
    S: Scalar,
{
    fn from(number: S) -> Self {
        Self::Number(number)
    }
}

impl From<bool> for ParameterValue<f64> {
    fn from(on: bool) -> Self {
        Self::Switch(on)
    }
}
