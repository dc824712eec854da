//! Counters of a loop. They are shared outside the ring buffer of ticks and notes, so a full ring does not affect
//! them.

use std::time::Duration;

use crate::atomics::{AtomicBool, AtomicU8, AtomicU64, Ordering};

/// Counters written by one side, the tap, and read by the other, the listener.
///
/// All writes of the tap precede [`close`](Self::close), which is a release. A listener that has seen
/// [`is_closed`](Self::is_closed), an acquire, therefore sees the final value of every counter and all items of the
/// ring. Before that, the counters are approximate.
#[derive(Debug)]
pub(crate) struct Tally {
    ticks: AtomicU64,
    notes: AtomicU64,
    lost: AtomicU64,
    motors_off: AtomicU64,
    /// Nanoseconds.
    lasted: AtomicU64,
    /// Nanoseconds.
    motors_off_for: AtomicU64,
    /// Code of the ending, defined by the user; 0: unknown.
    ending: AtomicU8,
    closed: AtomicBool,
    deaf: AtomicBool,
}

/// Values of the counters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Counts {
    /// Number of ticks.
    pub ticks: u64,
    /// Number of notes.
    pub notes: u64,
    /// Ticks and notes dropped because the ring was full.
    pub lost: u64,
    /// Ticks that ended with the motors off.
    pub motors_off: u64,
    /// Duration of the loop.
    pub lasted: Duration,
    /// Part of it without a delivered force.
    pub motors_off_for: Duration,
    /// Code of the ending; 0: unknown.
    pub ending: u8,
}

impl Tally {
    pub fn new() -> Self {
        Self {
            ticks: AtomicU64::new(0),
            notes: AtomicU64::new(0),
            lost: AtomicU64::new(0),
            motors_off: AtomicU64::new(0),
            lasted: AtomicU64::new(0),
            motors_off_for: AtomicU64::new(0),
            ending: AtomicU8::new(0),
            closed: AtomicBool::new(false),
            deaf: AtomicBool::new(false),
        }
    }

    /// Sets the number of ticks. Only the tap's side calls this and the following functions, up to `close`.
    pub fn made(&self, ticks: u64) {
        self.ticks.store(ticks, Ordering::Relaxed);
    }

    /// Counts a note.
    pub fn noted(&self) {
        add_one(&self.notes);
    }

    /// Counts a dropped tick or note.
    pub fn dropped(&self) {
        add_one(&self.lost);
    }

    /// Counts a tick that ended with the motors off.
    pub fn was_off(&self) {
        add_one(&self.motors_off);
    }

    /// Sets the duration of the loop and the part of it without a delivered force.
    pub fn ran(&self, lasted: Duration, motors_off_for: Duration) {
        self.lasted.store(nanoseconds(lasted), Ordering::Relaxed);
        self.motors_off_for
            .store(nanoseconds(motors_off_for), Ordering::Relaxed);
    }

    /// Sets ticks, notes, ticks with the motors off and times to those of `counts`.
    pub fn set(&self, counts: &Counts) {
        self.made(counts.ticks);
        self.notes.store(counts.notes, Ordering::Relaxed);
        self.motors_off.store(counts.motors_off, Ordering::Relaxed);
        self.ran(counts.lasted, counts.motors_off_for);
    }

    /// Sets the code of the ending.
    pub fn ended(&self, ending: u8) {
        self.ending.store(ending, Ordering::Relaxed);
    }

    /// Closes the counters: no further items or counts follow.
    pub fn close(&self) {
        self.closed.store(true, Ordering::Release);
    }

    /// Reports that the listener is gone.
    pub fn turn_deaf(&self) {
        self.deaf.store(true, Ordering::Release);
    }

    /// Returns whether the listener is gone.
    pub fn is_deaf(&self) -> bool {
        self.deaf.load(Ordering::Acquire)
    }

    /// Returns whether the counters are final and all items are in the ring.
    pub fn is_closed(&self) -> bool {
        self.closed.load(Ordering::Acquire)
    }

    /// Returns the current values.
    pub fn counts(&self) -> Counts {
        Counts {
            ticks: self.ticks.load(Ordering::Relaxed),
            notes: self.notes.load(Ordering::Relaxed),
            lost: self.lost.load(Ordering::Relaxed),
            motors_off: self.motors_off.load(Ordering::Relaxed),
            lasted: Duration::from_nanos(self.lasted.load(Ordering::Relaxed)),
            motors_off_for: Duration::from_nanos(self.motors_off_for.load(Ordering::Relaxed)),
            ending: self.ending.load(Ordering::Relaxed),
        }
    }
}

/// Converts to nanoseconds; saturates after more than 580 years.
fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

/// Increments without an atomic operation, because only one thread writes a counter.
fn add_one(counter: &AtomicU64) {
    let count = counter.load(Ordering::Relaxed);
    counter.store(count.saturating_add(1), Ordering::Relaxed);
}
