//! Velocity of the device, and its position at the next sample: one choice for every method that needs it.

use super::observer::{EstimatedMotion, Measurement, Observer, ObserverParams};
use super::steps::{Step, Steps};
use crate::Scalar;
use crate::actuator::Held;
use crate::contact::Mass;
use crate::parameter::{Parameter, ParameterError, ParameterValue, Range, Unit};
use crate::render::{
    Basis, MethodName, Setting, SettingKey, SettingValues, Settings, SettingsError,
};

/// Estimator of the device's velocity, and of its position at the next sample, xi~.
///
/// The virtual damper uses the velocity of the penetration in its force, HFCR the displacement `d = xi~ - xi_i`. Every
/// choice except the observer uses samples only.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "S: Scalar + serde::Serialize",
        deserialize = "S: Scalar + serde::Deserialize<'de>"
    ))
)]
pub enum Prediction<S> {
    /// At the mean velocity of the last step, as in the paper: `xi~ = 2 xi_i - xi_{i-1}`.
    #[default]
    #[cfg_attr(feature = "serde", serde(alias = "constant-velocity"))]
    LastStep,
    /// At the velocity of end-fit first-order adaptive windowing (Janabi-Sharifi, Hayward and Chen, IEEE Trans. Control
    /// Systems Technology 8(6), 2000): that of the longest straight line from the last sample to an earlier one that
    /// passes every sample in between within the noise bound. A quantised ramp keeps the whole window if the bound is
    /// the quantum; with a bound of 0 this is the last step whenever the motion is curved.
    FirstOrderAdaptiveWindow {
        /// Largest error of a measured position `[m]`, not below 0: the quantum of the sensor.
        noise_bound: S,
        /// Longest window `[s]`, greater than 0. One step always counts, and never more than
        /// [`LONGEST_WINDOW`](crate::LONGEST_WINDOW).
        longest_window: S,
    },
    /// On the parabola through the last three samples, at constant acceleration:
    /// `xi~ = 3 xi_i - 3 xi_{i-1} + xi_{i-2}`.
    Extrapolation,
    /// By an observer of the device's motion, at its current acceleration. For comparison: the effect of the next held
    /// force on the device is omitted.
    Observer {
        /// Effective mass of the device, within a factor of 2 `[kg]`.
        device_mass: Mass<S>,
        /// Quantum of the position sensor `[m]`, 0 if it has no known quantum.
        encoder_quantum: S,
    },
}

/// A checked [`Prediction`].
#[derive(Clone, Copy, Debug)]
pub(crate) enum Predictor<S> {
    LastStep,
    AdaptiveWindow { noise_bound: S, longest: S },
    Extrapolation,
    Observer(ObserverParams<S>),
}

/// Memory of the device's motion: empty if the method needs the last step only.
#[derive(Clone, Copy, Debug, Default)]
pub struct PredictionMemory<S>(Past<S>);

#[derive(Clone, Copy, Debug, Default)]
enum Past<S> {
    #[default]
    Unknown,
    Sampled(Steps<S>),
    Observed {
        observer: Observer<S>,
        /// Force held over the last interval `[N]`.
        held_force: S,
    },
}

impl<S: Scalar> Prediction<S> {
    /// Returns the choice's name in files, flags and reports.
    pub fn name(&self) -> &'static str {
        match self {
            Self::LastStep => PredictionName::LastStep,
            Self::FirstOrderAdaptiveWindow { .. } => PredictionName::FirstOrderAdaptiveWindow,
            Self::Extrapolation => PredictionName::Extrapolation,
            Self::Observer { .. } => PredictionName::Observer,
        }
        .name()
    }

    /// Describes the choice as parameters of a method; the observer's parameters are described elsewhere.
    pub(crate) fn describe(&self, take: &mut dyn FnMut(&'static str, ParameterValue<S>)) {
        take(PREDICTION.key.as_str(), ParameterValue::Word(self.name()));
        if let Self::FirstOrderAdaptiveWindow {
            noise_bound,
            longest_window,
        } = *self
        {
            take("noise_bound_m", ParameterValue::Number(noise_bound));
            let key = LONGEST_WINDOW_SETTING.key.as_str();
            take(key, ParameterValue::Number(longest_window));
        }
    }

    pub(crate) fn check(self) -> Result<Predictor<S>, ParameterError> {
        Ok(match self {
            Self::LastStep => Predictor::LastStep,
            Self::FirstOrderAdaptiveWindow {
                noise_bound,
                longest_window,
            } => Predictor::AdaptiveWindow {
                noise_bound: Parameter::NoiseBound.not_negative(noise_bound)?,
                longest: LONGEST_WINDOW_SETTING.check(longest_window)?,
            },
            Self::Extrapolation => Predictor::Extrapolation,
            Self::Observer {
                device_mass,
                encoder_quantum,
            } => Predictor::Observer(ObserverParams::new(device_mass, encoder_quantum)?),
        })
    }
}

/// Setting that selects the prediction by name.
pub(crate) const PREDICTION: Setting = Setting {
    key: SettingKey::PREDICTION,
    values: SettingValues::Words {
        words: &[
            PredictionName::LastStep.name(),
            PredictionName::FirstOrderAdaptiveWindow.name(),
            PredictionName::Extrapolation.name(),
            PredictionName::Observer.name(),
        ],
        // Earlier name, from before there were other choices at constant velocity.
        earlier: &[("constant-velocity", PredictionName::LastStep.name())],
    },
    help: "prediction of the device position, or of the penetration rate; first-order-adaptive-window uses the sensor \
           quantum as its noise bound and equals last-step if the quantum is unknown; extrapolation is at constant \
           acceleration",
    default: PredictionName::LastStep.name(),
};

pub(crate) const LONGEST_WINDOW_SETTING: Setting = Setting {
    key: SettingKey::LONGEST_WINDOW,
    values: SettingValues::Number {
        unit: Unit::Second,
        range: Range::Positive,
    },
    help: "longest window of first-order-adaptive-window; it never holds more than 16 steps",
    default: "15 periods",
};

/// Default longest window of first-order adaptive windowing, in periods.
const PERIODS_OF_WINDOW: f64 = 15.0;

impl SettingKey {
    /// Prediction of the device by the virtual damper and HFCR, one of [`PredictionName`].
    pub const PREDICTION: Self = Self::new("prediction");
    /// Longest window of first-order adaptive windowing `[s]`.
    pub const LONGEST_WINDOW: Self = Self::new("longest_window_s");
}

/// A [`Prediction`] without its parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PredictionName {
    /// At the velocity of its last step, as in the paper.
    #[default]
    LastStep,
    /// At the velocity of first-order adaptive windowing, whose noise bound is the sensor's quantum.
    FirstOrderAdaptiveWindow,
    /// At constant acceleration, through the last three samples.
    Extrapolation,
    /// By the observer of coupled rendering.
    Observer,
}

impl PredictionName {
    /// All choices.
    pub const ALL: [Self; 4] = [
        Self::LastStep,
        Self::FirstOrderAdaptiveWindow,
        Self::Extrapolation,
        Self::Observer,
    ];

    /// Returns the name in files, flags and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::LastStep => "last-step",
            Self::FirstOrderAdaptiveWindow => "first-order-adaptive-window",
            Self::Extrapolation => "extrapolation",
            Self::Observer => "observer",
        }
    }

    /// Returns the choice with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|choice| choice.name() == name)
    }
}

impl From<PredictionName> for ParameterValue<f64> {
    fn from(choice: PredictionName) -> Self {
        Self::Word(choice.name())
    }
}

impl<S: Scalar> Prediction<S> {
    /// Returns the prediction of the device by `method`.
    pub(crate) fn from_settings(
        method: MethodName,
        given: &Settings,
        basis: &Basis,
    ) -> Result<Self, SettingsError> {
        let choice = given.word(SettingKey::PREDICTION);
        let choice = choice.and_then(PredictionName::named).unwrap_or_default();
        let longest = given.number(SettingKey::LONGEST_WINDOW);
        if longest.is_some() && choice != PredictionName::FirstOrderAdaptiveWindow {
            return Err(SettingsError::OnlyBeside {
                method,
                setting: &LONGEST_WINDOW_SETTING,
                other: &PREDICTION,
                needed: PredictionName::FirstOrderAdaptiveWindow.name(),
                is: choice.name(),
            });
        }
        Ok(match choice {
            PredictionName::LastStep => Self::LastStep,
            PredictionName::FirstOrderAdaptiveWindow => Self::FirstOrderAdaptiveWindow {
                noise_bound: S::from_f64(basis.encoder_quantum),
                longest_window: S::from_f64(longest.unwrap_or(PERIODS_OF_WINDOW * basis.period)),
            },
            PredictionName::Extrapolation => Self::Extrapolation,
            PredictionName::Observer => Self::Observer {
                device_mass: basis.pushed_mass(method)?,
                encoder_quantum: S::from_f64(basis.encoder_quantum),
            },
        })
    }
}

/// Choices other than the last step have functions of their own; otherwise their frames would use the stack of every
/// tick.
impl<S: Scalar> Predictor<S> {
    fn is_last_step(&self) -> bool {
        matches!(self, Self::LastStep)
    }

    /// Processes the sample at an interval's end. `against` `[m]` is the displacement of the reference of the tracked
    /// motion: 0 for the device itself, the object's displacement for the penetration. An observer tracks the device
    /// itself.
    #[inline]
    pub fn update(
        &self,
        memory: &mut PredictionMemory<S>,
        measurement: &Measurement<S>,
        against: S,
    ) {
        if !self.is_last_step() {
            self.follow(memory, measurement, against);
        }
    }

    /// Returns the velocity at the last sample relative to a reference that moves at `against` `[m/s]`; `None` if the
    /// last step is used.
    #[inline]
    pub fn velocity(&self, memory: &PredictionMemory<S>, against: S) -> Option<S> {
        if self.is_last_step() {
            return None;
        }
        self.followed_velocity(memory, against)
    }

    /// Returns the predicted mean velocity of the device for the coming `period` `[s]`: `(xi~ - xi_i) / T`; `None` if
    /// the last step is used.
    #[inline]
    pub fn mean_velocity(&self, memory: &PredictionMemory<S>, period: S) -> Option<S> {
        if self.is_last_step() {
            return None;
        }
        self.followed_mean_velocity(memory, period)
    }

    #[inline(never)]
    fn follow(&self, memory: &mut PredictionMemory<S>, measurement: &Measurement<S>, against: S) {
        if let Self::Observer(params) = self {
            if !matches!(memory.0, Past::Observed { .. }) {
                memory.0 = Past::Observed {
                    observer: Observer::new(params),
                    held_force: S::ZERO,
                };
            }
            if let Past::Observed {
                observer,
                held_force,
            } = &mut memory.0
            {
                observer.update(params, measurement, params.measurement_variance);
                *held_force = measurement.held.mean;
            }
            return;
        }
        if !matches!(memory.0, Past::Sampled(_)) {
            memory.0 = Past::Sampled(Steps::none());
        }
        if let Past::Sampled(steps) = &mut memory.0 {
            steps.push(Step {
                moved: measurement.moved - against,
                elapsed: measurement.elapsed,
            });
        }
    }

    #[inline(never)]
    fn followed_velocity(&self, memory: &PredictionMemory<S>, against: S) -> Option<S> {
        match (self, &memory.0) {
            (Self::Observer(params), _) => {
                let (device, _) = memory.observed(params);
                Some(device.velocity - against)
            }
            (Self::Extrapolation, Past::Sampled(steps)) => Some(steps.parabola()?.velocity),
            (
                Self::AdaptiveWindow {
                    noise_bound,
                    longest,
                },
                Past::Sampled(steps),
            ) => steps.adaptive_window(*noise_bound, *longest),
            _ => None,
        }
    }

    #[inline(never)]
    fn followed_mean_velocity(&self, memory: &PredictionMemory<S>, period: S) -> Option<S> {
        match (self, &memory.0) {
            (Self::Observer(params), _) => {
                let (device, held_force) = memory.observed(params);
                let (travel, _) = device.under(&Held::constant(held_force), period);
                Some((device.offset + travel) / period)
            }
            (Self::Extrapolation, Past::Sampled(steps)) => {
                let parabola = steps.parabola()?;
                Some(parabola.velocity + parabola.half_acceleration * period)
            }
            // At constant velocity.
            _ => self.followed_velocity(memory, S::ZERO),
        }
    }
}

impl<S: Scalar> PredictionMemory<S> {
    /// Returns the device motion by the observer, and the force held over the last interval `[N]`.
    #[inline]
    fn observed(&self, params: &ObserverParams<S>) -> (EstimatedMotion<S>, S) {
        match &self.0 {
            Past::Observed {
                observer,
                held_force,
            } => (observer.motion, *held_force),
            _ => (Observer::new(params).motion, S::ZERO),
        }
    }
}
