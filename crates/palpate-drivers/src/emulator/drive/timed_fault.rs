//! Timed faults of an emulated drive, parsed from text.

use std::str::FromStr;
use std::time::Duration;

use super::Fault;

/// A fault with its start time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedFault {
    /// Time after the start.
    pub at: Duration,
    /// The fault.
    pub fault: Fault,
}

/// The text is not a timed fault.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "allowed: KIND[=VALUE]@SECONDS, such as silence=0.5@3; kinds: silence=s, mode, code=0..255, jump=turns, torn"
)]
pub struct NoTimedFault;

/// Parses `KIND[=VALUE]@SECONDS`.
impl FromStr for TimedFault {
    type Err = NoTimedFault;

    fn from_str(text: &str) -> Result<Self, NoTimedFault> {
        let understood = || {
            let (what, at) = text.split_once('@')?;
            let (name, value) = match what.split_once('=') {
                Some((name, value)) => (name, Some(value)),
                None => (what, None),
            };
            let seconds = |text: &str| Duration::try_from_secs_f64(text.parse().ok()?).ok();
            let fault = match (name, value) {
                ("silence", value) => Fault::Silence(seconds(value.unwrap_or("0.2"))?),
                ("mode", None) => Fault::Mode,
                ("code", value) => Fault::Code(value.unwrap_or("35").parse().ok()?),
                ("jump", value) => Fault::Jump(value.unwrap_or("1").parse().ok()?),
                ("torn", None) => Fault::TornLine,
                _ => return None,
            };
            Some(TimedFault {
                at: seconds(at)?,
                fault,
            })
        };
        understood().ok_or(NoTimedFault)
    }
}
