//! Events of a loop, without allocation in the loop.

use palpate_core::Fault;
use palpate_record::recording::Event;

use crate::rendering::Rendering;
use crate::safety::SafetyStop;
use palpate_device::DeviceError;

/// An event of the loop.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
#[expect(
    clippy::large_enum_variant,
    reason = "a tick hands it over without allocating, so it cannot be boxed"
)]
pub enum Note {
    /// A safety stop has begun: no force is sent. [`SafetyStop::Oscillation`] has its own event.
    Stopped(SafetyStop),
    /// A safety stop with [`SafetyStop::Oscillation`] has begun.
    Oscillated {
        /// Method whose held forces generated the energy.
        method: &'static str,
        /// Current method.
        renders_now: &'static str,
    },
    /// A safety stop has ended.
    Recovered(SafetyStop),
    /// The safety was rearmed.
    Rearmed,
    /// The renderer rejected a sample.
    Fault(Fault),
    /// The device failed.
    Device(DeviceError),
    /// New parameters are in force.
    Changed {
        /// Number of the parameters.
        generation: u32,
        /// The new rendering.
        rendering: Rendering,
    },
    /// A new world is in force: its number, and the method that renders it.
    OtherWorld(u32, &'static str),
    /// Deadlines were missed and skipped.
    MissedDeadlines(u64),
    /// Estimated actuation delay minus its model value `[s]`; negative: commands act earlier.
    LearnedLateness(f64),
    /// The loop has ended, and zero force was commanded.
    Ended(Ending),
}

/// Reason for the end of a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Ending {
    /// A stop was requested.
    Stopped,
    /// The requested number of periods is over. The motors may have been off in some of them.
    Complete,
    /// The device is disconnected.
    DeviceLost,
    /// The tick panicked.
    Panicked,
}

impl Ending {
    /// Returns a text description.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Stopped => "stopped on request",
            Self::Complete => "the duration is over",
            Self::DeviceLost => "the device is gone",
            Self::Panicked => "a tick panicked",
        }
    }

    /// Returns the code in a tally, above 0.
    pub(crate) fn number(self) -> u8 {
        match self {
            Self::Stopped => 1,
            Self::Complete => 2,
            Self::DeviceLost => 3,
            Self::Panicked => 4,
        }
    }

    /// Returns the ending with this code, if any.
    pub(crate) fn of_number(number: u8) -> Option<Self> {
        let all = [
            Self::Stopped,
            Self::Complete,
            Self::DeviceLost,
            Self::Panicked,
        ];
        all.into_iter().find(|ending| ending.number() == number)
    }
}

/// An event and its tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoopEvent {
    /// Number of the tick.
    pub sequence: u64,
    /// Time since the loop's start `[s]`.
    pub time: f64,
    /// Index of the affected device in a loop of several devices; `None` for the whole loop.
    pub device: Option<u32>,
    /// Kind of the event.
    pub note: Note,
}

impl LoopEvent {
    /// Returns the event as stored in recordings.
    #[must_use]
    pub fn event(&self) -> Event {
        self.event_of(&[])
    }

    /// Returns the event as stored in recordings, for a loop with several devices of these names, from
    /// [`Listener::device_names`](crate::Listener::device_names).
    #[must_use]
    pub fn event_of(&self, names: &[String]) -> Event {
        let (kind, text) = match self.note {
            Note::Stopped(safety_stop) => (
                format!("safety-stop-{}", safety_stop.name()),
                safety_stop.to_string(),
            ),
            Note::Oscillated {
                method,
                renders_now,
            } => (
                format!("safety-stop-{}", SafetyStop::Oscillation.name()),
                oscillated(method, renders_now),
            ),
            Note::Recovered(safety_stop) => (
                "recovered".to_owned(),
                format!("over: {safety_stop}; the force ramps up again"),
            ),
            Note::Rearmed => (
                "rearmed".to_owned(),
                "the safety layer was rearmed".to_owned(),
            ),
            Note::Fault(fault) => (format!("fault-{}", fault.name()), fault.to_string()),
            Note::Device(error) => ("device-error".to_owned(), error.to_string()),
            Note::Changed {
                generation,
                rendering,
            } => (
                "parameters".to_owned(),
                format!("parameters number {generation} from here on: {rendering}"),
            ),
            Note::OtherWorld(generation, method) => (
                "parameters".to_owned(),
                format!(
                    "parameters number {generation} from here on: another world, rendered by {method}"
                ),
            ),
            Note::MissedDeadlines(number) => (
                "missed-deadline".to_owned(),
                format!("deadlines missed and skipped: {number}"),
            ),
            Note::LearnedLateness(lateness) => ("learned-lateness".to_owned(), learned(lateness)),
            Note::Ended(ending) => (
                "ended".to_owned(),
                format!("the loop ended: {}", ending.text()),
            ),
        };
        Event {
            sequence: self.sequence,
            time: self.time,
            kind,
            text: match self.device {
                None => text,
                Some(device) => self.of_device(device, names, &text),
            },
        }
    }
}

impl LoopEvent {
    /// Returns the text of an event of one device of several.
    fn of_device(&self, device: u32, names: &[String], text: &str) -> String {
        let name = usize::try_from(device).ok().and_then(|at| names.get(at));
        let of = name.map_or_else(
            || format!("device {}", u64::from(device) + 1),
            |name| format!("device `{name}`"),
        );
        match self.note {
            Note::Stopped(_) => format!("{of}: {text}; the force of all devices is 0"),
            Note::Recovered(safety_stop) => format!("{of}: over: {safety_stop}"),
            _ => format!("{of}: {text}"),
        }
    }
}

/// Describes the estimated delay.
fn learned(lateness: f64) -> String {
    let than = if lateness < 0.0 { "earlier" } else { "later" };
    format!(
        "commands begin {:.3} ms {than} than the model value, estimated from contact",
        1e3 * lateness.abs()
    )
}

/// Describes the oscillation.
fn oscillated(method: &'static str, renders_now: &'static str) -> String {
    let text =
        format!("held forces created energy while {method} rendered: the contact oscillates");
    if method == renders_now {
        text
    } else {
        format!("{text}; {renders_now} renders now")
    }
}
