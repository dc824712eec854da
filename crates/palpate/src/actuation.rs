//! How a command becomes a force on the device: after a delay, through a lag, with a gain.

use crate::Scalar;
use crate::parameter::{Allowed, Parameter, ParameterError};

/// Most samples of delay that a loop can state.
pub const LARGEST_DELAY: usize = 8;

/// A delay this close to a whole number of periods is one: quotients of decimal times are never exact.
pub(crate) const WHOLE_WITHIN: f64 = 1e-5;

/// What is known of the way from a sample to the force on the device, with the standard deviation of
/// each value: what a calibration finds. The default is a perfect actuator: no delay, no lag, a gain
/// of 1.
///
/// The force that was computed from a sample at t begins at t + delay, goes through
/// `lag y' = gain u - y`, and stays until the next one begins (Eq. of a first-order actuator).
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
    /// Delivered over commanded force, greater than 0.
    pub gain: S,
    /// Standard deviation of the delay, its changes from command to command included `[s]`.
    pub delay_deviation: S,
    /// Standard deviation of the lag `[s]`.
    pub lag_deviation: S,
    /// Standard deviation of the gain.
    pub gain_deviation: S,
    /// What is flexible between the motor and the rest of the device, where that is known.
    pub transmission: Option<Transmission<S>>,
}

/// A flexible transmission of a device: motor and sensor are on one side of it, the rest of the device's
/// mass, and the hand, on the other. Coupled rendering predicts the motion of both sides where the resonance times the
/// period exceeds 0.05; otherwise one mass follows it better.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Transmission<S> {
    /// Resonance of both sides against each other, with nothing held, greater than 0 `[Hz]`.
    pub resonance: S,
    /// Its damping ratio, from 0 to 1.
    pub damping_ratio: S,
    /// Part of the mass beyond the transmission, seen from the motor, from 0 to below 1.
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
        }
    }
}

impl<S: Scalar> Actuation<S> {
    /// A force that begins `delay` `[s]` after its sample.
    #[must_use]
    pub fn after(delay: S) -> Self {
        Self {
            delay,
            ..Self::default()
        }
    }

    /// A force that begins with the sample `samples` periods of `period` `[s]` after its own.
    #[must_use]
    pub fn after_samples(samples: usize, period: S) -> Self {
        Self::after(S::from_f64(samples as f64) * period)
    }

    /// The same with a first-order lag of time constant `lag` `[s]`.
    #[must_use]
    pub fn with_lag(self, lag: S) -> Self {
        Self { lag, ..self }
    }

    /// Factor of a command that limits of the force apply to: the gain, but at least 1. A limit then bounds both the
    /// command and the force that the modelled actuator delivers.
    #[must_use]
    pub fn limit_gain(&self) -> S {
        if self.gain > S::ONE {
            self.gain
        } else {
            S::ONE
        }
    }

    /// The same with a `gain`: delivered over commanded force.
    #[must_use]
    pub fn with_gain(self, gain: S) -> Self {
        Self { gain, ..self }
    }

    /// The same with a flexible `transmission`.
    #[must_use]
    pub fn with_transmission(self, transmission: Transmission<S>) -> Self {
        Self {
            transmission: Some(transmission),
            ..self
        }
    }

    /// Standard deviation of delay and lag together `[s]`.
    pub(crate) fn timing_deviation(&self) -> S {
        let (delay, lag) = (self.delay_deviation, self.lag_deviation);
        (delay * delay + lag * lag).sqrt()
    }

    /// Whether a force acts as it is sent, whole samples later: no fraction of `period` `[s]`, no lag and a
    /// gain of 1.
    pub fn is_of_whole_samples(&self, period: S) -> bool {
        let periods = self.delay / period;
        let within = S::from_f64(WHOLE_WITHIN);
        let off = periods - (periods + within).floor();
        off.abs() <= within && self.lag <= S::ZERO && self.gain == S::ONE
    }

    /// Every parameter outside its range, in a loop of `period` `[s]`.
    pub(crate) fn faults(&self, period: S) -> impl Iterator<Item = ParameterError> {
        let periods = self.delay / period;
        let most = S::from_f64(LARGEST_DELAY as f64 + WHOLE_WITHIN);
        let known = periods >= S::ZERO && periods <= most;
        // Where the period is wrong, the number of periods says nothing.
        let judged = period.is_finite() && period > S::ZERO;
        let not_negative = |parameter: Parameter, value: S| parameter.not_negative(value).err();
        [
            Parameter::Delay
                .unless(
                    known || !judged,
                    periods,
                    Allowed::UpToSamples(LARGEST_DELAY),
                )
                .err(),
            not_negative(Parameter::Lag, self.lag),
            Parameter::Gain.positive(self.gain).err(),
            not_negative(Parameter::DelayDeviation, self.delay_deviation),
            not_negative(Parameter::LagDeviation, self.lag_deviation),
            not_negative(Parameter::GainDeviation, self.gain_deviation),
        ]
        .into_iter()
        .chain(self.transmission.iter().flat_map(Transmission::faults))
        .flatten()
    }
}

impl<S: Scalar> Transmission<S> {
    /// What is outside its range.
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
