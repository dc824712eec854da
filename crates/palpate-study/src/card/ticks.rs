//! Ticks of a recording for a device report.

use palpate_record::recording::{ContactTick, Entry, Flags, Recording, RecordingError, Tick};

/// A tick and its first contact.
#[derive(Clone, Copy, Debug)]
pub(super) struct OneContact {
    pub tick: Tick,
    pub contact: ContactTick,
}

/// The ticks of a recording, read once, each with its first contact.
#[derive(Debug, Default)]
pub(super) struct Ticks {
    pub all: Vec<OneContact>,
    pub missed_deadlines: u64,
    /// Ticks without a position of the device.
    pub unseen: u64,
    /// Ticks with a force that the safety layer changed.
    pub limited: u64,
    /// Ticks with the motors off.
    pub motors_off: u64,
}

impl Ticks {
    /// Reads all recorded ticks.
    pub fn read(recording: &Recording) -> Result<Self, RecordingError> {
        let mut ticks = Self::default();
        for entry in recording.entries()? {
            if let Entry::Tick(tick, contacts, _, _) = entry? {
                let contact = contacts.first().copied().unwrap_or(ContactTick::UNKNOWN);
                let row = OneContact { tick, contact };
                let count = |flag| u64::from(tick.flags.has(flag));
                ticks.missed_deadlines += count(Flags::MISSED_DEADLINE);
                ticks.limited += count(Flags::SAFETY_LIMITED);
                ticks.motors_off += count(Flags::SAFETY_STOPPED);
                ticks.unseen += u64::from(!is_seen(&row));
                ticks.all.push(row);
            }
        }
        Ok(ticks)
    }
}

/// Whether the tick has a position that the renderer accepted.
pub(super) fn is_seen(row: &OneContact) -> bool {
    row.contact.device_position.is_finite()
        && !row.tick.flags.has(Flags::DEVICE_FAULT)
        && !row.tick.flags.has(Flags::FAULT)
}
