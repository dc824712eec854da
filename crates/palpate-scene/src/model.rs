//! Renderer's model of the loop's actuator.

use palpate_core::{Actuation, LARGEST_DELAY, Parameter, Range, Transmission};
use palpate_world::Vector;
use serde::Deserialize;
use toml::Spanned;

use super::fault::Places;
use super::parameter::SceneParameter as Of;
use super::{Delay, Scene};
use crate::world::per_axis::PerAxis;

/// Overrides of true values, and their standard deviations; all `None` by default. Without an override, the renderer's
/// model has the true lag and gain and the delay of whole samples or of `delay_s`, without deviations. A fraction of a
/// period and the jitter of commands are unmodelled.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Model {
    /// Delay `[s]`.
    pub delay: Option<f64>,
    /// Standard deviation of the delay, its changes from command to command included `[s]`.
    pub delay_deviation: Option<f64>,
    /// Lag `[s]`.
    pub lag: Option<f64>,
    /// Standard deviation of the lag `[s]`.
    pub lag_deviation: Option<f64>,
    /// Delivered over commanded force.
    pub gain: Option<f64>,
    /// Standard deviation of the gain.
    pub gain_deviation: Option<f64>,
    /// Quantum of the position sensor `[m]`.
    pub sensor_quantum: Option<f64>,
    /// Standard deviation of the position sensor's error `[m]`, where it is more than the quantum makes.
    pub sensor_noise: Option<f64>,
    /// Model of the flexible transmission between the motor and the rest of the device; `None`: unmodelled.
    pub transmission: Option<Transmission<f64>>,
}

/// The quantum `[m]` of a sensor whose rounding errors have the standard deviation `noise` `[m]`. Rounding errors are
/// spread evenly over the quantum, so the quantum is √12 times the deviation.
#[must_use]
pub fn quantum_of(noise: f64) -> f64 {
    12.0_f64.sqrt() * noise
}

/// Table `[model]` of a scene file.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawModel {
    pub delay_s: Option<Spanned<f64>>,
    pub delay_deviation_s: Option<Spanned<f64>>,
    pub lag_s: Option<Spanned<f64>>,
    pub lag_deviation_s: Option<Spanned<f64>>,
    pub gain: Option<Spanned<f64>>,
    pub gain_deviation: Option<Spanned<f64>>,
    pub sensor_quantum_m: Option<Spanned<f64>>,
    pub sensor_noise_m: Option<Spanned<f64>>,
    pub resonance_hz: Option<Spanned<f64>>,
    pub resonance_damping_ratio: Option<Spanned<f64>>,
    pub flexible_mass_fraction: Option<Spanned<f64>>,
    pub device_mass_kg: Option<Spanned<PerAxis>>,
    pub device_mass_factor: Option<Spanned<f64>>,
    pub device_inertia_kg_m2: Option<Spanned<Vector>>,
}

impl RawModel {
    /// Returns the span of a transmission key that is given without the others, and the error.
    pub fn alone(&self) -> Option<(std::ops::Range<usize>, String)> {
        let keys = [
            &self.resonance_hz,
            &self.resonance_damping_ratio,
            &self.flexible_mass_fraction,
        ];
        let given = keys.into_iter().flatten();
        let is_whole = given.clone().count() == keys.len();
        given
            .map(Spanned::span)
            .next()
            .filter(|_| !is_whole)
            .map(|span| {
                let message = "a transmission model needs resonance_hz, resonance_damping_ratio and \
                           flexible_mass_fraction";
                (span, message.to_owned())
            })
    }

    /// Returns the model values, without those of the device's mass and inertia.
    pub fn read(&self, places: &mut Places<Of>) -> Model {
        let transmission = self
            .resonance_hz
            .clone()
            .zip(self.resonance_damping_ratio.clone())
            .zip(self.flexible_mass_fraction.clone())
            .map(|((resonance, ratio), fraction)| Transmission {
                resonance: places.take(Parameter::Resonance, resonance),
                damping_ratio: places.take(Parameter::ResonanceDampingRatio, ratio),
                flexible_mass_fraction: places.take(Parameter::FlexibleMassFraction, fraction),
            });
        let mut take = |parameter: Of, value: &Option<Spanned<f64>>| {
            let value = value.clone();
            value.map(|value| places.take(parameter, value))
        };
        Model {
            delay: take(Of::ModelDelay, &self.delay_s),
            delay_deviation: take(Parameter::DelayDeviation.into(), &self.delay_deviation_s),
            lag: take(Parameter::Lag.into(), &self.lag_s),
            lag_deviation: take(Parameter::LagDeviation.into(), &self.lag_deviation_s),
            gain: take(Parameter::Gain.into(), &self.gain),
            gain_deviation: take(Parameter::GainDeviation.into(), &self.gain_deviation),
            sensor_quantum: take(Of::ModelSensorQuantum, &self.sensor_quantum_m),
            sensor_noise: take(Of::ModelSensorNoise, &self.sensor_noise_m),
            transmission,
        }
    }
}

impl Model {
    /// The values that a renderer checks, with the parameter of each.
    pub(super) fn checked(&self) -> [(Range, Of, Option<f64>); 7] {
        [
            (
                Range::NotNegative,
                Parameter::DelayDeviation.into(),
                self.delay_deviation,
            ),
            (Range::NotNegative, Parameter::Lag.into(), self.lag),
            (
                Range::NotNegative,
                Parameter::LagDeviation.into(),
                self.lag_deviation,
            ),
            (Range::Positive, Parameter::Gain.into(), self.gain),
            (
                Range::NotNegative,
                Parameter::GainDeviation.into(),
                self.gain_deviation,
            ),
            (Range::NotNegative, Of::ModelSensorNoise, self.sensor_noise),
            (
                Range::NotNegative,
                Of::ModelSensorQuantum,
                self.sensor_quantum,
            ),
        ]
    }
}

impl Scene {
    /// Returns the model value of the position quantum `[m]`: by default the sensor's own quantum, or the equivalent of
    /// the model noise if that is larger.
    #[must_use]
    pub fn model_quantum(&self) -> f64 {
        let quantum = self.model.sensor_quantum;
        let quantum = quantum.unwrap_or(self.device.encoder_quantum());
        self.model
            .sensor_noise
            .map_or(quantum, |noise| quantum_of(noise).max(quantum))
    }

    /// Returns the renderer's model of delay, lag and gain: the true values, overridden by [`Model`]. The delay is
    /// limited to the largest one that a renderer supports.
    #[must_use]
    pub fn model_actuation(&self) -> Actuation<f64> {
        let (period, model) = (self.loop_params.period, &self.model);

        let longest = LARGEST_DELAY as f64 * period;
        let delay = match model.delay {
            Some(delay) => delay.min(longest),
            None => match self.delay {
                Delay::Seconds(seconds) => seconds.max(0.0).min(longest),
                Delay::Periods { samples, .. } => {
                    Actuation::after_samples(samples.min(LARGEST_DELAY), period).delay
                }
            },
        };
        Actuation {
            delay,
            lag: model.lag.unwrap_or(self.actuator.lag),
            gain: model.gain.unwrap_or(self.actuator.gain),
            delay_deviation: model.delay_deviation.unwrap_or(0.0),
            lag_deviation: model.lag_deviation.unwrap_or(0.0),
            gain_deviation: model.gain_deviation.unwrap_or(0.0),
            transmission: model.transmission,
            hold: self.hold(),
        }
    }
}
