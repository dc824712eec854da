//! Sample-estimate-hold: holds an estimate of the mean force of the coming interval.

use super::method::{Method, MethodParams, Plan, Situation};
use super::named::{FromSettings, MethodInfo, MethodName};
use super::setting::{Basis, Setting, SettingKey, SettingValues, Settings, SettingsError};
use crate::Scalar;
use crate::contact::{Contact, LoopParams};
use crate::motion::ObjectMotion;
use crate::parameter::{ParameterError, ParameterValue};

/// Sample-estimate-hold by name.
pub(super) const SEH: MethodInfo = MethodInfo {
    name: "seh",
    summary: "sample-estimate-hold: extrapolated mean force",
    colour: 9,
    settings: &[Setting {
        key: SettingKey::ESTIMATE,
        values: SettingValues::Words {
            words: &[
                SehEstimate::Ab2.name(),
                SehEstimate::Differences.name(),
                SehEstimate::Ab3.name(),
            ],
            earlier: &[],
        },
        help: "extrapolation",
        default: SehEstimate::Ab2.name(),
    }],
};

impl SettingKey {
    /// The estimate of sample-estimate-hold, one of [`SehEstimate`].
    pub const ESTIMATE: Self = Self::new("estimate");
}

impl<S: Scalar> FromSettings<S> for SehParams {
    fn from_settings(_: MethodName, given: &Settings, _: &Basis) -> Result<Self, SettingsError> {
        let estimate = given
            .word(SettingKey::ESTIMATE)
            .and_then(SehEstimate::named);
        Ok(Self {
            estimate: estimate.unwrap_or_default(),
        })
    }
}

/// Extrapolation of the mean force of the coming interval from past spring forces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum SehEstimate {
    /// Two-step Adams-Bashforth, `(3 f_i - f_{i-1}) / 2`.
    #[default]
    Ab2,
    /// `2 f_i - 1.5 f_{i-1} + 0.5 f_{i-2}`: the force and its first and second backward
    /// differences, halved.
    Differences,
    /// Three-step Adams-Bashforth, `(23 f_i - 16 f_{i-1} + 5 f_{i-2}) / 12`.
    Ab3,
}

impl SehEstimate {
    /// Returns the estimate's name in files, flags and reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ab2 => "ab2",
            Self::Differences => "differences",
            Self::Ab3 => "ab3",
        }
    }

    /// Returns the estimate with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let all = [Self::Ab2, Self::Differences, Self::Ab3];
        all.into_iter().find(|estimate| estimate.name() == name)
    }
}

impl From<SehEstimate> for ParameterValue<f64> {
    fn from(estimate: SehEstimate) -> Self {
        Self::Word(estimate.name())
    }
}

/// Parameters of sample-estimate-hold.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct SehParams {
    /// Member of the family. The paper does not specify it.
    #[cfg_attr(feature = "serde", serde(default))]
    pub estimate: SehEstimate,
}

/// Sample-estimate-hold on the basic model: past forces are those of the basic law, 0 when free or not yet sampled, and
/// the held force is 0 while `p_i <= 0`. Unevenly spaced samples are used with their true instants.
#[derive(Clone, Copy, Debug)]
pub struct Seh {
    estimate: SehEstimate,
}

/// Past spring forces and the spacing of their samples.
#[derive(Clone, Copy, Debug, Default)]
pub struct SehMemory<S> {
    /// f_{i-1} and f_{i-2} `[N]`.
    past: [S; 2],
    /// Time from sample i-2 to sample i-1 `[s]`; 0 before the second sample.
    spacing: S,
}

impl<S: Scalar> MethodParams<S> for SehParams {
    type Method = Seh;

    fn check(self, _: &Contact<S>, _: &LoopParams<S>) -> Result<Seh, ParameterError> {
        Ok(Seh {
            estimate: self.estimate,
        })
    }

    fn name(&self) -> &'static str {
        SEH.name
    }

    fn describe(&self, take: &mut dyn FnMut(&'static str, ParameterValue<S>)) {
        take(
            SettingKey::ESTIMATE.as_str(),
            ParameterValue::Word(self.estimate.name()),
        );
    }
}

impl Seh {
    /// Returns the mean over `period` of the force extrapolated from three past ones, the later pair `late` apart, the
    /// earlier pair `early` `[s]`. For even spacing these are the coefficients of [`SehEstimate`].
    #[inline]
    fn mean_force<S: Scalar>(self, forces: [S; 3], late: S, early: S, period: S) -> S {
        let [now, last, before] = forces;
        let slope = (now - last) / late;
        let curvature = (slope - (last - before) / early) / (late + early);
        let second_moment = match self.estimate {
            SehEstimate::Ab2 => return now + S::HALF * period * slope,
            SehEstimate::Differences => period * period,
            SehEstimate::Ab3 => {
                let three = S::ONE + S::TWO;
                period * (period / three + S::HALF * late)
            }
        };
        now + S::HALF * period * slope + second_moment * curvature
    }
}

impl<S: Scalar> Method<S> for Seh {
    type Memory = SehMemory<S>;

    #[inline]
    fn plan(
        &self,
        motion: &ObjectMotion<S>,
        now: &Situation<'_, S>,
        memory: &mut SehMemory<S>,
    ) -> Plan<S> {
        let force = now.spring_force(motion);
        let [last, before] = memory.past;
        let early = if memory.spacing > S::ZERO {
            memory.spacing
        } else {
            motion.period()
        };
        *memory = SehMemory {
            past: [force, last],
            spacing: now.elapsed,
        };
        now.unswitched(motion, || {
            self.mean_force([force, last, before], now.elapsed, early, motion.period())
        })
    }
}
