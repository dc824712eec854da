//! What a loop counts of what it tells. It is shared beside the ring that carries ticks and notes, so a
//! ring that is full drops none of it.

use std::time::Duration;

use crate::atomics::{AtomicBool, AtomicU8, AtomicU64, Ordering};

/// Counters that one side, the tap, writes, and that the other, the listener, reads.
///
/// All writes of the tap come before [`close`](Self::close), which is a release. A listener that has
/// seen [`is_closed`](Self::is_closed), an acquire, therefore sees every counter as the loop left it,
/// and everything that was pushed into the ring. Before that, the counters are for show.
#[derive(Debug)]
pub(crate) struct Tally {
    ticks: AtomicU64,
    notes: AtomicU64,
    lost: AtomicU64,
    motors_off: AtomicU64,
    /// In nanoseconds.
    lasted: AtomicU64,
    /// In nanoseconds.
    motors_off_for: AtomicU64,
    /// A number of the ending, which its user gives meaning; 0: none was told.
    ending: AtomicU8,
    closed: AtomicBool,
    deaf: AtomicBool,
}

/// What was counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Counts {
    /// Ticks that were made.
    pub ticks: u64,
    /// Notes that were told.
    pub notes: u64,
    /// Ticks and notes that found no room.
    pub lost: u64,
    /// Ticks that ended with the motors off.
    pub motors_off: u64,
    /// How long the loop ran.
    pub lasted: Duration,
    /// For how much of that no force was delivered.
    pub motors_off_for: Duration,
    /// Number of the ending; 0: none was told.
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

    /// `ticks` were made so far. Only the tap's side calls this and what follows, up to `close`.
    pub fn made(&self, ticks: u64) {
        self.ticks.store(ticks, Ordering::Relaxed);
    }

    /// One more note was told.
    pub fn noted(&self) {
        add_one(&self.notes);
    }

    /// One more tick or note found no room.
    pub fn dropped(&self) {
        add_one(&self.lost);
    }

    /// One more tick ended with the motors off.
    pub fn was_off(&self) {
        add_one(&self.motors_off);
    }

    /// So long did the loop run so far, and no force was delivered for so much of it.
    pub fn ran(&self, lasted: Duration, motors_off_for: Duration) {
        self.lasted.store(nanoseconds(lasted), Ordering::Relaxed);
        self.motors_off_for
            .store(nanoseconds(motors_off_for), Ordering::Relaxed);
    }

    /// Ticks, notes, ticks with the motors off and times are those of `counts`.
    pub fn set(&self, counts: &Counts) {
        self.made(counts.ticks);
        self.notes.store(counts.notes, Ordering::Relaxed);
        self.motors_off.store(counts.motors_off, Ordering::Relaxed);
        self.ran(counts.lasted, counts.motors_off_for);
    }

    /// The loop has ended, by `ending`.
    pub fn ended(&self, ending: u8) {
        self.ending.store(ending, Ordering::Relaxed);
    }

    /// Nothing more is told or counted.
    pub fn close(&self) {
        self.closed.store(true, Ordering::Release);
    }

    /// Nobody listens any more.
    pub fn turn_deaf(&self) {
        self.deaf.store(true, Ordering::Release);
    }

    /// Whether nobody listens any more.
    pub fn is_deaf(&self) -> bool {
        self.deaf.load(Ordering::Acquire)
    }

    /// Whether nothing more is told: what was is in the ring, and the counters stand still.
    pub fn is_closed(&self) -> bool {
        self.closed.load(Ordering::Acquire)
    }

    /// What was counted so far.
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

/// More than 580 years count as that.
fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

/// Only one thread writes a counter, so it need not be one step.
fn add_one(counter: &AtomicU64) {
    let count = counter.load(Ordering::Relaxed);
    counter.store(count.saturating_add(1), Ordering::Relaxed);
}
