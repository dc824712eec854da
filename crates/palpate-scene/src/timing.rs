//! Timing imperfections of a scene's loop.

use std::ops::Range;

use palpate_core::{Allowed, Hold, Parameter, ParameterError};
use palpate_testbed::InvalidParameter;
use palpate_testbed::actuator::ActuatorParams;
use palpate_testbed::hold::DelayedHold;
use palpate_testbed::schedule::{ActuationDelay, Schedule, ScheduleParameter, ScheduleParams};
pub use palpate_testbed::schedule::{Dropped, Jitter, RateCollapse};
use palpate_testbed::timeline::Timeline;
use serde::Deserialize;
use toml::Spanned;

use super::Scene;
use super::check::SceneParameterError;
use super::delay::Delay;
use super::fault::Places;
use super::parameter::SceneParameter;

/// Imperfections of a loop besides its delay; none by default.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Timing {
    /// Largest additional delay of a command, uniform from 0 `[s]`.
    pub command_jitter: f64,
    /// Deviation of a sample from its instant.
    pub jitter: Jitter,
    /// Samples that are not taken.
    pub dropped: Dropped,
    /// A stretch of time with another period.
    pub collapse: Option<RateCollapse>,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// `[loop]` of a scene file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawLoop {
    pub period_s: Spanned<f64>,
    pub delay_samples: Option<Spanned<usize>>,
    pub delay_fraction: Option<Spanned<f64>>,
    pub delay_s: Option<Spanned<f64>>,
    pub command_jitter_s: Option<Spanned<f64>>,
    pub lag_s: Option<Spanned<f64>>,
    pub gain: Option<Spanned<f64>>,
    pub hold: Option<Spanned<Hold>>,
    pub jitter_s: Option<Spanned<f64>>,
    pub jitter_deviation_s: Option<Spanned<f64>>,
    pub drop_probability: Option<Spanned<f64>>,
    pub dropped_samples: Option<Spanned<Vec<u64>>>,
    pub collapse: Option<Spanned<RawCollapse>>,
    pub seed: Option<Spanned<u64>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RawCollapse {
    from_s: Spanned<f64>,
    until_s: Spanned<f64>,
    period_s: Spanned<f64>,
}

impl RawLoop {
    /// Gain and lag of the actuator.
    pub fn actuator(&self, places: &mut Places<SceneParameter>) -> ActuatorParams {
        let perfect = ActuatorParams::default();
        ActuatorParams {
            gain: places.take_or(SceneParameter::Gain, self.gain.clone(), perfect.gain),
            lag: places.take_or(SceneParameter::Lag, self.lag_s.clone(), perfect.lag),
        }
    }

    /// Returns the delay, or the span of a key that conflicts with another one.
    pub fn delay(
        &self,
        places: &mut Places<SceneParameter>,
    ) -> Result<Delay, (Range<usize>, &'static str)> {
        let (samples, fraction) = (self.delay_samples.clone(), self.delay_fraction.clone());
        match (self.delay_s.clone(), samples, fraction) {
            (Some(seconds), None, None) => {
                let seconds = places.take(SceneParameter::DelaySeconds, seconds);
                Ok(Delay::Seconds(seconds))
            }
            (None, samples, fraction) => Ok(Delay::Periods {
                samples: places.take_or(SceneParameter::DelaySamples, samples, 0),
                fraction: places.take_or(SceneParameter::DelayFraction, fraction, 0.0),
            }),
            (Some(seconds), _, _) => Err((
                seconds.span(),
                "either delay_s, or delay_samples with delay_fraction; not both",
            )),
        }
    }

    /// Returns the delay and the other imperfections, or the span of a key that lacks a required key or conflicts with
    /// another one.
    pub fn timing(
        self,
        places: &mut Places<SceneParameter>,
    ) -> Result<(Delay, Timing), (Range<usize>, &'static str)> {
        let delay = self.delay(places)?;
        let jitter = match (self.jitter_s, self.jitter_deviation_s) {
            (None, None) => Jitter::None,
            (Some(bound), None) => Jitter::Uniform {
                bound: places.take(SceneParameter::Jitter, bound),
            },
            (Some(bound), Some(deviation)) => Jitter::Normal {
                bound: places.take(SceneParameter::Jitter, bound),
                deviation: places.take(SceneParameter::JitterDeviation, deviation),
            },
            (None, Some(deviation)) => {
                return Err((
                    deviation.span(),
                    "jitter_deviation_s needs jitter_s, the bound that no sample exceeds",
                ));
            }
        };
        let dropped = match (self.drop_probability, self.dropped_samples) {
            (None, None) => Dropped::None,
            (Some(probability), None) => {
                Dropped::Probability(places.take(SceneParameter::DropProbability, probability))
            }
            (None, Some(samples)) => {
                Dropped::Listed(places.take(SceneParameter::DroppedSamples, samples))
            }
            (Some(_), Some(samples)) => {
                return Err((
                    samples.span(),
                    "either drop_probability or dropped_samples, not both",
                ));
            }
        };
        let timing = Timing {
            command_jitter: places.take_or(
                SceneParameter::CommandJitter,
                self.command_jitter_s,
                0.0,
            ),
            jitter,
            dropped,
            collapse: self
                .collapse
                .map(Spanned::into_inner)
                .map(|collapse| RateCollapse {
                    from: places.take(SceneParameter::CollapseFrom, collapse.from_s),
                    until: places.take(SceneParameter::CollapseUntil, collapse.until_s),
                    period: places.take(SceneParameter::CollapsePeriod, collapse.period_s),
                }),
            seed: places.take_or(SceneParameter::Seed, self.seed, 0),
        };
        Ok((delay, timing))
    }
}

impl Timing {
    /// Returns whether every sample is on time and every command has the constant delay.
    #[must_use]
    pub fn is_perfect(&self) -> bool {
        *self
            == Self {
                seed: self.seed,
                ..Self::default()
            }
    }

    /// Whether some of it is drawn from random numbers.
    #[must_use]
    pub fn is_random(&self) -> bool {
        let drops = matches!(self.dropped, Dropped::Probability(probability) if probability > 0.0);
        drops || self.jitter != Jitter::None || self.command_jitter > 0.0
    }

    /// Shortest period of a loop whose nominal one is `period` `[s]`.
    #[must_use]
    pub fn shortest_period(&self, period: f64) -> f64 {
        self.collapse
            .map_or(period, |collapse| period.min(collapse.period))
    }

    /// The schedule of a loop with a `period` `[s]` and a `delay`.
    #[must_use]
    pub fn schedule(&self, period: f64, delay: Delay) -> ScheduleParams {
        ScheduleParams {
            period,
            jitter: self.jitter,
            dropped: self.dropped.clone(),
            collapse: self.collapse,
            delay: ActuationDelay {
                samples: u32::try_from(delay.whole_samples()).unwrap_or(u32::MAX),
                fraction: delay.fraction(),
                seconds: delay.seconds(),
                jitter: self.command_jitter,
            },
            seed: self.seed,
        }
    }

    /// Checks the timing of a loop with a sound `period` `[s]` and a `delay`.
    pub(super) fn check(&self, period: f64, delay: Delay) -> Result<(), SceneParameterError> {
        let samples = delay.whole_samples();
        if samples > DelayedHold::LONGEST_DELAY {
            return Err(ParameterError {
                parameter: SceneParameter::DelaySamples,
                value: samples as f64,
                allowed: Allowed::Words("at most 1024"),
            });
        }
        let Err(error) = Schedule::new(self.schedule(period, delay)) else {
            return Ok(());
        };
        let parameter = match error.name {
            ScheduleParameter::Period => Parameter::Period.into(),
            ScheduleParameter::CollapsePeriod => SceneParameter::CollapsePeriod,
            ScheduleParameter::CollapseFrom => SceneParameter::CollapseFrom,
            ScheduleParameter::CollapseUntil => SceneParameter::CollapseUntil,
            ScheduleParameter::JitterBound => SceneParameter::Jitter,
            ScheduleParameter::JitterDeviation => SceneParameter::JitterDeviation,
            ScheduleParameter::DelayFraction => SceneParameter::DelayFraction,
            ScheduleParameter::DelaySeconds => SceneParameter::DelaySeconds,
            ScheduleParameter::CommandJitter => SceneParameter::CommandJitter,
            ScheduleParameter::Dropped => match self.dropped {
                Dropped::Listed(_) => SceneParameter::DroppedSamples,
                Dropped::None | Dropped::Probability(_) => SceneParameter::DropProbability,
            },
        };
        Err(ParameterError {
            parameter,
            value: error.value,
            allowed: Allowed::Words(error.allowed),
        })
    }
}

impl Scene {
    /// Seed of the random numbers of timing and sensor noise; none if nothing is random.
    #[must_use]
    pub fn random_seed(&self) -> Option<u64> {
        let is_random = self.timing.is_random() || self.device.noise() > 0.0;
        is_random.then_some(self.timing.seed)
    }

    /// The schedule of the loop.
    #[must_use]
    pub fn schedule(&self) -> ScheduleParams {
        self.timing.schedule(self.loop_params.period, self.delay)
    }

    /// Returns the samples and commands of the loop over `periods` periods.
    pub fn timeline(&self, periods: usize) -> Result<Timeline, InvalidParameter> {
        match self.device.sampled_as_recorded() {
            Some(hand) => {
                let period = self.loop_params.period;
                let delay = (self.delay.whole_samples(), self.delay.seconds());
                Timeline::at_instants(hand.times(), delay, period, periods)
            }
            None => Timeline::new(self.schedule(), periods),
        }
    }

    /// Checks the timing of a loop whose period is sound.
    pub(super) fn check_timing(&self) -> Result<(), SceneParameterError> {
        let only_as_recorded = Timing {
            seed: self.timing.seed,
            ..Timing::default()
        };
        let fraction = self.delay.fraction();
        if self.device.sampled_as_recorded().is_some()
            && (self.timing != only_as_recorded || fraction != 0.0)
        {
            let allowed = "omitted, like jitter and drops, in a loop that samples as recorded";
            return Err(ParameterError {
                parameter: SceneParameter::DelayFraction,
                value: fraction,
                allowed: Allowed::Words(allowed),
            });
        }
        self.timing.check(self.loop_params.period, self.delay)
    }
}
