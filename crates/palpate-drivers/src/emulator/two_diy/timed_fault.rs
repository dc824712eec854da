//! Timed faults of an emulated 2DIY, parsed from text.

use std::str::FromStr;
use std::time::Duration;

use super::Fault;

/// A fault with its start time `[s]`.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedFault {
    /// Time after the start `[s]`.
    pub at: f64,
    /// Kind.
    pub kind: FaultKind,
    /// Duration, angle or count, depending on the kind.
    pub value: f64,
}

/// Kinds of faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FaultKind {
    /// The board stalls for the value `[s]`.
    Stall,
    /// The cable is pulled for the value `[s]`.
    Unplug,
    /// This number of bytes precedes the next answer.
    Garbage,
    /// Half of the next answer is lost.
    Half,
    /// The next answer is lost.
    Lost,
    /// The next answer is delayed by the value `[s]`.
    Late,
    /// The next answer is sent twice.
    Twice,
    /// The next answer has another device id.
    OtherId,
    /// The next answer contains a NaN angle.
    NotANumber,
    /// The encoders lose counts of the value `[degrees]`.
    Slip,
}

impl FaultKind {
    /// Every kind with its name and default value.
    pub const NAMED: [(&'static str, Self, f64); 10] = [
        ("stall", Self::Stall, 0.05),
        ("unplug", Self::Unplug, 2.0),
        ("garbage", Self::Garbage, 5.0),
        ("half", Self::Half, 0.0),
        ("lost", Self::Lost, 0.0),
        ("late", Self::Late, 0.005),
        ("twice", Self::Twice, 0.0),
        ("other-id", Self::OtherId, 0.0),
        ("nan", Self::NotANumber, 0.0),
        ("slip", Self::Slip, 25.0),
    ];
}

/// The text is not a timed fault.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("allowed: KIND[=VALUE]@SECONDS, such as stall=0.05@3; kinds: {}", FaultKind::NAMED.map(|(name, ..)| name).join(", "))]
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
            let (_, kind, usual) = FaultKind::NAMED.iter().find(|(known, ..)| *known == name)?;
            Some(TimedFault {
                at: at.parse().ok()?,
                kind: *kind,
                value: value.unwrap_or(*usual),
            })
        };
        understood().ok_or(NoTimedFault)
    }
}

impl TimedFault {
    /// Returns the fault and its time after the start.
    ///
    /// # Errors
    /// A number of seconds that is not a valid duration.
    pub fn fault(&self) -> Result<(Duration, Fault), f64> {
        let value = self.value;
        let seconds = |value: f64| Duration::try_from_secs_f64(value).map_err(|_| value);
        let time = || seconds(value);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "the cast saturates, and the count is limited to 10 000"
        )]
        let fault = match self.kind {
            FaultKind::Stall => Fault::Stall(time()?),
            FaultKind::Unplug => Fault::Unplug(time()?),
            FaultKind::Garbage => Fault::Garbage(vec![0x77; (value as usize).min(10_000)]),
            FaultKind::Half => Fault::HalfAnswer,
            FaultKind::Lost => Fault::NoAnswer,
            FaultKind::Late => Fault::LateAnswer(time()?),
            FaultKind::Twice => Fault::TwoAnswers,
            FaultKind::OtherId => Fault::OtherId,
            FaultKind::NotANumber => Fault::NotANumber,
            FaultKind::Slip => Fault::Slip(value),
        };
        Ok((seconds(self.at)?, fault))
    }
}
