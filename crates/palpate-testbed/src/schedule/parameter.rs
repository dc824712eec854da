//! The parameters of a schedule by name.

use std::fmt;

use crate::InvalidParameter;

/// A parameter of a schedule, to be matched by value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // the parameters are called what the fields are that have them
pub enum ScheduleParameter {
    Period,
    CollapsePeriod,
    CollapseFrom,
    CollapseUntil,
    JitterBound,
    JitterDeviation,
    Dropped,
    DelayFraction,
    DelaySeconds,
    CommandJitter,
}

impl ScheduleParameter {
    /// The field that has it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Period => "period",
            Self::CollapsePeriod => "collapse.period",
            Self::CollapseFrom => "collapse.from",
            Self::CollapseUntil => "collapse.until",
            Self::JitterBound => "jitter.bound",
            Self::JitterDeviation => "jitter.deviation",
            Self::Dropped => "dropped",
            Self::DelayFraction => "delay.fraction",
            Self::DelaySeconds => "delay.seconds",
            Self::CommandJitter => "delay.jitter",
        }
    }
}

impl fmt::Display for ScheduleParameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl From<InvalidParameter<ScheduleParameter>> for InvalidParameter {
    fn from(error: InvalidParameter<ScheduleParameter>) -> Self {
        Self {
            name: error.name.name(),
            value: error.value,
            allowed: error.allowed,
        }
    }
}
