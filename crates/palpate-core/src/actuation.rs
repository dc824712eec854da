//! Model of the actuation: delay, lag and gain from a command to the force on the device.

use crate::Scalar;
use crate::parameter::{Allowed, Parameter, ParameterError};

/// Largest delay of a loop in samples.
pub const LARGEST_DELAY: usize = 8;

/// Tolerance of a whole number of periods: quotients of decimal times are never exact.
pub(crate) const WHOLE_WITHIN: f64 = 1e-5;

/// Force that an actuator holds from the begin of one command to that of the next.
///
/// A held constant cannot follow the contact's force: its error is the hold bound. A drive with a loop of its own can
/// hold a straight line. Of all lines the nearest to a force has the impulse and the first moment of that force, so the
/// device ends the interval with the velocity and at the position of the ideal device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Hold {
    /// A constant: zero-order hold.
    #[default]
    Constant,
    /// A line of force f and slope s, `f + s (t - T/2)` with t the time since the command began and T the nominal
    /// period. After T it keeps its last value.
    Line,
}

impl Hold {
    /// All holds.
    pub const ALL: [Self; 2] = [Self::Constant, Self::Line];

    /// Returns the name in files, flags and arguments.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Line => "line",
        }
    }

    /// Returns the hold with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|hold| hold.name() == name)
    }

    /// Returns whether it is a constant.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        *self == Self::Constant
    }
}

/// Model of the actuation from a sample to the force on the device, with the standard deviation of each value, as
/// measured by a calibration. The default is a perfect actuator: no delay, no lag, a gain of 1.
///
/// The force computed from a sample at t begins at t + delay, passes through `lag y' = gain u - y`, and lasts until the
/// next one begins (Eq. of a first-order actuator).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: Scalar + serde::Serialize",
        deserialize = "S: Scalar + serde::Deserialize<'de>"
    ))
)]
pub struct Actuation<S> {
    /// Time from a sample to the beginning of its force `[s]`, at most [`LARGEST_DELAY`] periods.
    pub delay: S,
    /// Time constant of the actuator `[s]`, not below 0.
    pub lag: S,
    /// Ratio of delivered to commanded force, greater than 0.
    pub gain: S,
    /// Standard deviation of the delay, including its variation between commands, at most [`LARGEST_DELAY`] periods
    /// `[s]`.
    pub delay_deviation: S,
    /// Standard deviation of the lag, at most [`LARGEST_DELAY`] periods `[s]`.
    pub lag_deviation: S,
    /// Standard deviation of the gain, at most the gain.
    pub gain_deviation: S,
    /// Flexible transmission between the motor and the rest of the device, if known.
    pub transmission: Option<Transmission<S>>,
    /// Force that the actuator holds for each command. A line requires an actuator without lag, no
    /// [slew limit](crate::LoopParams::slew_limit), no [`Guard`](crate::Guard), and [`Coupled`](crate::Coupled)
    /// rendering.
    #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Hold::is_constant"))]
    pub hold: Hold,
}

/// Flexible transmission of a device: motor and sensor are on one side, the rest of the device's mass and the hand on
/// the other. Coupled rendering predicts the motion of both sides if the resonance times the period exceeds 0.05;
/// otherwise a model with one mass is better.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Transmission<S> {
    /// Resonance of both sides against each other, without a hand, greater than 0 `[Hz]`.
    pub resonance: S,
    /// Damping ratio of the resonance, from 0 to 1.
    pub damping_ratio: S,
    /// Fraction of the mass beyond the transmission, seen from the motor, from 0 to below 1.
    pub flexible_mass_fraction: S,
}

impl<S: Scalar> Default for Actuation<S> {
    fn default() -> Self {
        Self {
            delay: S::ZERO,
            lag: S::ZERO,
            gain: S::ONE,
            delay_deviation: S::ZERO,
            lag_deviation: S::ZERO,
            gain_deviation: S::ZERO,
            transmission: None,
            hold: Hold::Constant,
        }
    }
}

impl<S: Scalar> Actuation<S> {
    /// Creates an actuation whose force begins `delay` `[s]` after its sample.
    #[must_use]
    pub fn after(delay: S) -> Self {
        Self {
            delay,
            ..Self::default()
        }
    }

    /// Creates an actuation whose force begins with the sample `samples` periods of `period` `[s]` after its own.
    #[must_use]
    pub fn after_samples(samples: usize, period: S) -> Self {
        Self::after(S::from_f64(samples as f64) * period)
    }

    /// Returns the actuation with a first-order lag of time constant `lag` `[s]`.
    #[must_use]
    pub fn with_lag(self, lag: S) -> Self {
        Self { lag, ..self }
    }

    /// Returns the factor from the command to the force that force limits apply to: the gain, but at least 1. A limit
    /// then bounds both the command and the force that the modelled actuator delivers.
    #[must_use]
    pub fn limit_gain(&self) -> S {
        if self.gain > S::ONE {
            self.gain
        } else {
            S::ONE
        }
    }

    /// Returns the actuation with a `gain`: ratio of delivered to commanded force.
    #[must_use]
    pub fn with_gain(self, gain: S) -> Self {
        Self { gain, ..self }
    }

    /// Returns the actuation with a flexible `transmission`.
    #[must_use]
    pub fn with_transmission(self, transmission: Transmission<S>) -> Self {
        Self {
            transmission: Some(transmission),
            ..self
        }
    }

    /// Returns the actuation of an actuator that holds a line.
    #[must_use]
    pub fn with_line(self) -> Self {
        Self {
            hold: Hold::Line,
            ..self
        }
    }

    /// Returns the standard deviation of delay and lag together `[s]`.
    pub(crate) fn timing_deviation(&self) -> S {
        let (delay, lag) = (self.delay_deviation, self.lag_deviation);
        (delay * delay + lag * lag).sqrt()
    }

    /// Returns whether a force acts as sent, whole samples later: no fraction of `period` `[s]`, no lag and a gain of
    /// 1.
    pub fn is_of_whole_samples(&self, period: S) -> bool {
        let periods = self.delay / period;
        let within = S::from_f64(WHOLE_WITHIN);
        let off = periods - (periods + within).floor();
        off.abs() <= within && self.lag <= S::ZERO && self.gain == S::ONE
    }

    /// Returns every parameter outside its range, in a loop of `period` `[s]`.
    pub(crate) fn faults(&self, period: S) -> impl Iterator<Item = ParameterError> {
        let most = S::from_f64(LARGEST_DELAY as f64 + WHOLE_WITHIN);
        // With an invalid period, the number of periods is meaningless.
        let evaluated = period.is_finite() && period > S::ZERO;
        let in_periods = |parameter: Parameter, value: S| {
            let periods = value / period;
            let known = periods >= S::ZERO && periods <= most;
            let allowed = Allowed::UpToPeriods(LARGEST_DELAY);
            parameter.unless(known || !evaluated, value, allowed).err()
        };
        let deviation = self.gain_deviation;
        // An invalid gain is reported itself.
        let gain = self.gain;
        let is_part = deviation <= gain || !(gain.is_finite() && gain > S::ZERO);
        [
            in_periods(Parameter::Delay, self.delay),
            Parameter::Lag.not_negative(self.lag).err(),
            Parameter::Gain.positive(self.gain).err(),
            in_periods(Parameter::DelayDeviation, self.delay_deviation),
            in_periods(Parameter::LagDeviation, self.lag_deviation),
            Parameter::GainDeviation
                .unless(
                    deviation >= S::ZERO && deviation.is_finite() && is_part,
                    deviation,
                    Allowed::Words("from 0 to the gain"),
                )
                .err(),
            Parameter::Lag
                .unless(
                    self.hold == Hold::Constant || self.lag <= S::ZERO || !self.lag.is_finite(),
                    self.lag,
                    Allowed::Words("0 with a line hold"),
                )
                .err(),
        ]
        .into_iter()
        .chain(self.transmission.iter().flat_map(Transmission::faults))
        .flatten()
    }
}

impl<S: Scalar> Transmission<S> {
    /// Returns the parameters outside their range.
    fn faults(&self) -> [Option<ParameterError>; 3] {
        let (ratio, fraction) = (self.damping_ratio, self.flexible_mass_fraction);
        let from_zero = |value: S| value >= S::ZERO && value <= S::ONE;
        [
            Parameter::Resonance.positive(self.resonance).err(),
            Parameter::ResonanceDampingRatio
                .unless(from_zero(ratio), ratio, Allowed::Words("from 0 to 1"))
                .err(),
            Parameter::FlexibleMassFraction
                .unless(
                    from_zero(fraction) && fraction < S::ONE,
                    fraction,
                    Allowed::Words("from 0 to below 1"),
                )
                .err(),
        ]
    }
}
