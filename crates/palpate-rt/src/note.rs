//! What happens beside the ticks, without a word allocated in the loop.

use palpate::Fault;
use palpate_record::recording::Event;

use crate::rendering::Rendering;
use crate::safety::Trip;
use palpate_device::DeviceError;

/// Something that happened in the loop.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
#[expect(
    clippy::large_enum_variant,
    reason = "a tick hands it over without allocating, so it cannot be boxed"
)]
pub enum Note {
    /// Safety has tripped: no force is sent. [`Trip::Oscillation`] has a note of its own.
    Tripped(Trip),
    /// Safety has tripped on [`Trip::Oscillation`].
    Oscillated {
        /// The method whose held forces created the energy.
        method: &'static str,
        /// The method that renders now.
        renders_now: &'static str,
    },
    /// What had tripped has passed.
    Recovered(Trip),
    /// Somebody rearmed.
    Rearmed,
    /// The renderer refused a sample.
    Fault(Fault),
    /// The device did not do what it was asked.
    Device(DeviceError),
    /// Other parameters came into force.
    Changed {
        /// Their number.
        generation: u32,
        /// What they are.
        rendering: Rendering,
    },
    /// Another world came into force: its number, and the method that renders it.
    OtherWorld(u32, &'static str),
    /// Deadlines were missed, and skipped.
    MissedDeadlines(u64),
    /// Commands begin so much later than the renderer was told, by what it has learned `[s]`: negative where they
    /// begin earlier.
    LearnedLateness(f64),
    /// The loop has ended; the device was commanded no force.
    Ended(Ending),
}

/// Why a loop has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Ending {
    /// It was asked to.
    Stopped,
    /// As many periods are over as it was to last. What was done in them is another question: the
    /// motors may have been off.
    Complete,
    /// The device is gone.
    DeviceLost,
    /// The tick panicked.
    Panicked,
}

impl Ending {
    /// What ended it, in words.
    #[must_use]
    pub fn text(self) -> &'static str {
        match self {
            Self::Stopped => "it was asked to stop",
            Self::Complete => "its time was over",
            Self::DeviceLost => "the device is gone",
            Self::Panicked => "a tick panicked",
        }
    }

    /// Its number in a tally, above 0.
    pub(crate) fn number(self) -> u8 {
        match self {
            Self::Stopped => 1,
            Self::Complete => 2,
            Self::DeviceLost => 3,
            Self::Panicked => 4,
        }
    }

    /// The ending with a number; `None` if none has it.
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

/// A note, with its tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noted {
    /// Number of the tick.
    pub sequence: u64,
    /// When, since the loop's start `[s]`.
    pub time: f64,
    /// Number of the device that it is said of, in a loop of several devices; `None` where it is said of the loop.
    pub device: Option<u32>,
    /// What happened.
    pub note: Note,
}

impl Noted {
    /// The note as recordings have it.
    #[must_use]
    pub fn event(&self) -> Event {
        self.event_of(&[])
    }

    /// The same, where the loop has several devices with these names, as
    /// [`Listener::device_names`](crate::Listener::device_names) has them.
    #[must_use]
    pub fn event_of(&self, names: &[String]) -> Event {
        let (kind, text) = match self.note {
            Note::Tripped(trip) => (format!("trip-{}", trip.name()), trip.to_string()),
            Note::Oscillated {
                method,
                renders_now,
            } => (
                format!("trip-{}", Trip::Oscillation.name()),
                oscillated(method, renders_now),
            ),
            Note::Recovered(trip) => (
                "recovered".to_owned(),
                format!("no longer: {trip}; the force comes back"),
            ),
            Note::Rearmed => (
                "rearmed".to_owned(),
                "somebody rearmed the safety".to_owned(),
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

impl Noted {
    /// What is said of one device of several.
    fn of_device(&self, device: u32, names: &[String], text: &str) -> String {
        let name = usize::try_from(device).ok().and_then(|at| names.get(at));
        let of = name.map_or_else(
            || format!("device {}", u64::from(device) + 1),
            |name| format!("device `{name}`"),
        );
        match self.note {
            Note::Tripped(_) => format!("{of}: {text}; no device has a force"),
            Note::Recovered(trip) => format!("{of}: no longer: {trip}"),
            _ => format!("{of}: {text}"),
        }
    }
}

/// How late commands are, in words.
fn learned(lateness: f64) -> String {
    let than = if lateness < 0.0 { "earlier" } else { "later" };
    format!(
        "commands begin {:.3} ms {than} than told, by what the renderer has learned from contact",
        1e3 * lateness.abs()
    )
}

/// What has oscillated, in words.
fn oscillated(method: &'static str, renders_now: &'static str) -> String {
    let text =
        format!("held forces created energy while {method} rendered: the contact oscillates");
    if method == renders_now {
        text
    } else {
        format!("{text}; {renders_now} renders now")
    }
}
