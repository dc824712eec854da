//! Causes of safety stops.

use std::fmt;

/// Cause of a safety stop, which holds the force at 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SafetyStop {
    /// A position or a force was NaN or infinite.
    NotANumber,
    /// No fresh sample for too long.
    StaleSample,
    /// The end-point moved faster than the largest speed.
    TooFast,
    /// The loop's thread did not tick, and the supervisor commanded zero force.
    Stalled,
    /// The end-point was outside the workspace, or outside the range along the contact's axis.
    OutsideWorkspace,
    /// Held forces generated more energy than a well-rendered contact can.
    Oscillation,
    /// The force was lost and recovered too often.
    TooManyRecoveries,
    /// The device has a fault that lasts; the event before the stop describes it.
    DeviceRefused,
    /// The device is disconnected.
    DeviceLost,
}

impl SafetyStop {
    /// All causes.
    pub const ALL: [Self; 9] = [
        Self::NotANumber,
        Self::StaleSample,
        Self::TooFast,
        Self::Stalled,
        Self::OutsideWorkspace,
        Self::Oscillation,
        Self::TooManyRecoveries,
        Self::DeviceRefused,
        Self::DeviceLost,
    ];

    /// Returns whether the stop is self-clearing: it ends with its cause. Other stops are latched until the safety is
    /// rearmed.
    #[must_use]
    pub fn is_passing(self) -> bool {
        match self {
            Self::NotANumber | Self::StaleSample | Self::TooFast | Self::Stalled => true,
            Self::OutsideWorkspace
            | Self::Oscillation
            | Self::TooManyRecoveries
            | Self::DeviceRefused
            | Self::DeviceLost => false,
        }
    }

    /// Returns whether the cause concerns the whole loop and not one of its devices.
    pub(crate) fn is_of_the_loop(self) -> bool {
        matches!(self, Self::Stalled | Self::Oscillation)
    }

    /// Returns the short name in kebab case, as in recordings.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::NotANumber => "not-a-number",
            Self::StaleSample => "stale-sample",
            Self::TooFast => "too-fast",
            Self::Stalled => "stalled",
            Self::OutsideWorkspace => "outside-workspace",
            Self::Oscillation => "oscillation",
            Self::TooManyRecoveries => "too-many-recoveries",
            Self::DeviceRefused => "device-refused",
            Self::DeviceLost => "device-lost",
        }
    }
}

impl fmt::Display for SafetyStop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotANumber => "a position or a force was not a finite number",
            Self::StaleSample => "the device delivered no new sample",
            Self::TooFast => "the device moved faster than the largest speed",
            Self::Stalled => "the loop did not tick in time",
            Self::OutsideWorkspace => "the device left its workspace",
            Self::Oscillation => "held forces created energy: the contact oscillates",
            Self::TooManyRecoveries => {
                "too many recoveries: the loop stalled, or lacked valid samples"
            }
            Self::DeviceRefused => "the device or its driver refuses: a fault that lasts",
            Self::DeviceLost => "the device is gone",
        })
    }
}
