//! Timed faults of an emulated service or its device.

use std::fmt;
use std::str::FromStr;
use std::time::{Duration, Instant};

use super::{Emulator, Fault};

/// Kind of fault.
#[derive(Clone, Copy, Debug, PartialEq)]
enum FaultKind {
    /// Fault of the next answer.
    Answer(Fault),
    /// The device is unplugged for this time.
    Unplug(Duration),
    /// The motors have no power for this time.
    NoPower(Duration),
}

impl fmt::Display for FaultKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Answer(fault) => fault.fmt(f),
            Self::Unplug(lasts) => {
                write!(f, "the device is unplugged for {} s", lasts.as_secs_f64())
            }
            Self::NoPower(lasts) => {
                write!(f, "the motors have no power for {} s", lasts.as_secs_f64())
            }
        }
    }
}

/// A fault with its start time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimedFault {
    at: Duration,
    trouble: FaultKind,
}

/// Kinds without a duration.
const KINDS: [(&str, Fault); 8] = [
    ("lost", Fault::Dropped),
    ("twice", Fault::Twice),
    ("late", Fault::Late),
    ("garbage", Fault::Garbage),
    ("half", Fault::HalfFrame),
    ("half-bytes", Fault::HalfBytes),
    ("disconnect", Fault::Disconnect),
    ("close", Fault::Close),
];

/// The text is not a timed fault.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct NoTimedFault(String);

/// Parses `KIND@SECONDS`, or `KIND=SECONDS@SECONDS`.
impl FromStr for TimedFault {
    type Err = NoTimedFault;

    fn from_str(text: &str) -> Result<Self, NoTimedFault> {
        let time = |text: &str| {
            let seconds: f64 = text.trim().parse().ok()?;
            Duration::try_from_secs_f64(seconds).ok()
        };
        let understood = || {
            let (what, at) = text.split_once('@')?;
            let trouble = match what.split_once('=') {
                Some(("stall", value)) => FaultKind::Answer(Fault::Stall(time(value)?)),
                Some(("unplug", value)) => FaultKind::Unplug(time(value)?),
                Some(("no-power", value)) => FaultKind::NoPower(time(value)?),
                Some(_) => return None,
                None => {
                    let (_, fault) = KINDS.iter().find(|(name, _)| *name == what)?;
                    FaultKind::Answer(*fault)
                }
            };
            Some(TimedFault {
                at: time(at)?,
                trouble,
            })
        };
        understood().ok_or_else(|| {
        let kinds: Vec<&str> = KINDS.iter().map(|(name, _)| *name).collect();
        NoTimedFault(format!(
            "allowed: KIND@SECONDS with KIND one of {}; KIND=SECONDS@SECONDS with KIND one of stall, unplug, \
             no-power",
            kinds.join(", ")
        ))
    })
    }
}

impl Emulator {
    /// Injects `faults` into the device with this name, each at its time from now on, until `is_over` returns true for
    /// the elapsed time. Reports each injected fault through `messages`.
    pub fn inject_faults(
        &self,
        id: &str,
        faults: &[TimedFault],
        is_over: impl Fn(Duration) -> bool,
        messages: impl Fn(fmt::Arguments),
    ) {
        // A temporary fault consists of two changes.
        let mut changes: Vec<(Duration, FaultKind, bool)> = Vec::new();
        for &TimedFault { at, trouble } in faults {
            changes.push((at, trouble, true));
            if let FaultKind::Unplug(lasts) | FaultKind::NoPower(lasts) = trouble {
                changes.push((at.saturating_add(lasts), trouble, false));
            }
        }
        changes.sort_by_key(|(at, ..)| *at);
        let mut changes = changes.into_iter().peekable();
        let begun = Instant::now();
        while !is_over(begun.elapsed()) {
            while let Some((at, trouble, begins)) =
                changes.next_if(|(at, ..)| begun.elapsed() >= *at)
            {
                let word = if begins { "" } else { "over: " };
                messages(format_args!(
                    "at {:.1} s: {word}{trouble}",
                    at.as_secs_f64()
                ));
                match trouble {
                    FaultKind::Answer(fault) => self.inject(fault),
                    FaultKind::Unplug(_) => self.set_present(id, !begins),
                    FaultKind::NoPower(_) => {
                        self.set_status(id, |status| status.power_supply = Some(!begins));
                    }
                }
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}
