//! How fast the device moves, and where it will be at the next sample: one choice for every method that
//! needs it.

use super::observer::{EstimatedMotion, Measurement, Observer, ObserverParams};
use super::steps::{Step, Steps};
use crate::Scalar;
use crate::actuator::Held;
use crate::contact::Mass;
use crate::parameter::{Parameter, ParameterError, ParameterValue, Range, Unit};
use crate::render::{
    Basis, MethodName, Setting, SettingKey, SettingValues, Settings, SettingsError,
};

/// How a method tells how fast the device moves, and where it will be at the next sample, xi~.
///
/// The virtual damper takes from it the velocity of the penetration in its force, HFCR the displacement
/// `d = xi~ - xi_i`. Every choice but the observer needs samples only.
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
    /// At the velocity of end-fit first-order adaptive windowing (Janabi-Sharifi, Hayward and Chen,
    /// IEEE Trans. Control Systems Technology 8(6), 2000): that of the longest straight line from the
    /// last sample to an earlier one that passes every sample in between within the noise bound. A
    /// quantised ramp keeps the whole window if the bound is the quantum; with a bound of 0 this is
    /// the last step wherever the motion is curved.
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
    /// By an observer of the device's motion, at the acceleration it has now. There to be compared:
    /// what the force about to be held will do to the device is still left out.
    Observer {
        /// Effective mass of the device, within a factor of 2 `[kg]`.
        device_mass: Mass<S>,
        /// Quantum of the position sensor `[m]`, 0 if it is not known to have one.
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

/// What a method remembers of the device's motion: nothing, if it needs the last step only.
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
    /// The choice's name, as files, flags and reports spell it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::LastStep => PredictionName::LastStep,
            Self::FirstOrderAdaptiveWindow { .. } => PredictionName::FirstOrderAdaptiveWindow,
            Self::Extrapolation => PredictionName::Extrapolation,
            Self::Observer { .. } => PredictionName::Observer,
        }
        .name()
    }

    /// As of a method's parameters; what an observer is told of the device is told to it elsewhere.
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

/// How the methods that predict the device say it by name.
pub(crate) const PREDICTION: Setting = Setting {
    key: SettingKey::PREDICTION,
    values: SettingValues::Words {
        words: &[
            PredictionName::LastStep.name(),
            PredictionName::FirstOrderAdaptiveWindow.name(),
            PredictionName::Extrapolation.name(),
            PredictionName::Observer.name(),
        ],
        // Its name of before there were others at constant velocity.
        earlier: &[("constant-velocity", PredictionName::LastStep.name())],
    },
    help: "how it tells where the device will be, or how fast the penetration grows; \
           first-order-adaptive-window is last-step where the sensor has no known quantum, its noise \
           bound; extrapolation is at constant acceleration",
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

/// Periods in the longest window of first-order adaptive windowing where nothing is said.
const PERIODS_OF_WINDOW: f64 = 15.0;

impl SettingKey {
    /// How the virtual damper and HFCR predict the device, one of [`PredictionName`].
    pub const PREDICTION: Self = Self::new("prediction");
    /// Longest window of first-order adaptive windowing `[s]`.
    pub const LONGEST_WINDOW: Self = Self::new("longest_window_s");
}

/// A [`Prediction`] without what it is derived from.
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
    /// Every choice.
    pub const ALL: [Self; 4] = [
        Self::LastStep,
        Self::FirstOrderAdaptiveWindow,
        Self::Extrapolation,
        Self::Observer,
    ];

    /// The name, as files, flags and reports spell it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::LastStep => "last-step",
            Self::FirstOrderAdaptiveWindow => "first-order-adaptive-window",
            Self::Extrapolation => "extrapolation",
            Self::Observer => "observer",
        }
    }

    /// The choice of that name.
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
    /// How `method` predicts the device.
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

/// What is not the last step stands in functions of its own: their frames would lie on the stack of every
/// tick otherwise.
impl<S: Scalar> Predictor<S> {
    fn is_last_step(&self) -> bool {
        matches!(self, Self::LastStep)
    }

    /// Takes the sample at an interval's end. What is followed moves against something that has moved
    /// by `against` `[m]`: 0 for the device itself, the object's displacement for the penetration. An
    /// observer follows the device itself.
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

    /// Velocity at the last sample against something that moves at `against` `[m/s]`. None where the
    /// last step says it all.
    #[inline]
    pub fn velocity(&self, memory: &PredictionMemory<S>, against: S) -> Option<S> {
        if self.is_last_step() {
            return None;
        }
        self.followed_velocity(memory, against)
    }

    /// Mean velocity of the device predicted for the coming `period` `[s]`: `(xi~ - xi_i) / T`. None
    /// where the last step says it all.
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
    /// The device as an observer knows it, and the force held over the last interval `[N]`.
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
