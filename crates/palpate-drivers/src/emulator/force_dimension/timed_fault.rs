//! Timed faults of an emulated device, parsed from text.

use std::str::FromStr;
use std::time::Duration;

use super::Emulator;

/// A fault with its start time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedFault {
    /// Time after the start.
    pub at: Duration,
    kind: FaultKind,
    value: f64,
}

/// Kinds of faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FaultKind {
    Unplug,
    PlugIn,
    Stale,
    Saturate,
    Uncalibrated,
}

/// Each kind with its name and default value.
const NAMED: [(&str, FaultKind, f64); 5] = [
    ("unplug", FaultKind::Unplug, 0.0),
    ("plug-in", FaultKind::PlugIn, 0.0),
    ("stale", FaultKind::Stale, 3.0),
    ("saturate", FaultKind::Saturate, 1.0),
    ("uncalibrated", FaultKind::Uncalibrated, 0.0),
];

/// The text is not a timed fault.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("allowed: KIND[=VALUE]@SECONDS, such as unplug@3; kinds: {}", NAMED.map(|(name, ..)| name).join(", "))]
pub struct NoTimedFault;

/// Parses `KIND[=VALUE]@SECONDS`.
impl FromStr for TimedFault {
    type Err = NoTimedFault;

    fn from_str(text: &str) -> Result<Self, NoTimedFault> {
        let understood = || {
            let (what, at) = text.split_once('@')?;
            let (name, value) = match what.split_once('=') {
                Some((name, value)) => (name, Some(value.parse::<f64>().ok()?)),
                None => (what, None),
            };
            let (_, kind, usual) = NAMED.iter().find(|(known, ..)| *known == name)?;
            Some(TimedFault {
                at: Duration::try_from_secs_f64(at.parse().ok()?).ok()?,
                kind: *kind,
                value: value.unwrap_or(*usual),
            })
        };
        understood().ok_or(NoTimedFault)
    }
}

impl TimedFault {
    /// Injects the fault now.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the cast saturates"
    )]
    pub fn inject(&self, emulator: &Emulator) {
        match self.kind {
            FaultKind::Unplug => emulator.trouble(|trouble| trouble.is_unplugged = true),
            FaultKind::PlugIn => emulator.trouble(|trouble| trouble.is_unplugged = false),
            FaultKind::Stale => emulator.trouble(|trouble| trouble.stale_reads = self.value as u32),
            FaultKind::Saturate => {
                emulator.trouble(|trouble| trouble.saturates_above = Some(self.value));
            }
            FaultKind::Uncalibrated => emulator.set_status(|status| status[3] = 1),
        }
    }
}
