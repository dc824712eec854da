//! What goes wrong with an emulated 2DIY, and when, as a text says it.

use std::str::FromStr;
use std::time::Duration;

use super::Fault;

/// A fault and when it strikes `[s]`.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedFault {
    /// When, after the start `[s]`.
    pub at: f64,
    /// Its kind.
    pub kind: FaultKind,
    /// How long, how far, how many.
    pub value: f64,
}

/// Kinds of faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FaultKind {
    /// The board stands still for the value `[s]`.
    Stall,
    /// The cable is pulled for the value `[s]`.
    Unplug,
    /// So many bytes come before the next answer.
    Garbage,
    /// Half of the next answer is lost.
    Half,
    /// The next answer is lost.
    Lost,
    /// The next answer comes later by the value `[s]`.
    Late,
    /// The next answer comes twice.
    Twice,
    /// The next answer is that of another device.
    OtherId,
    /// The next answer has an angle that is no number.
    NotANumber,
    /// The encoders lose count by the value `[degrees]`.
    Slip,
}

impl FaultKind {
    /// Every kind with its name and the value that it has if none is given.
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

/// A text is no timed fault.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("KIND[=VALUE]@SECONDS is needed, such as stall=0.05@3; the kinds are {}", FaultKind::NAMED.map(|(name, ..)| name).join(", "))]
pub struct NoTimedFault;

/// `KIND[=VALUE]@SECONDS`.
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
    /// The fault, and when it strikes after the start.
    ///
    /// # Errors
    /// A number of seconds that is no time.
    pub fn fault(&self) -> Result<(Duration, Fault), f64> {
        let value = self.value;
        let seconds = |value: f64| Duration::try_from_secs_f64(value).map_err(|_| value);
        let time = || seconds(value);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a cast saturates, and so many bytes nobody sends"
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
