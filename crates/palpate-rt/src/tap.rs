//! From the loop's thread to whoever writes down what it does, without ever waiting.

use std::sync::Arc;

use palpate_record::recording::{Flags, LoopTime, Tick};

use crate::note::{Ending, Noted};
use crate::tally::{Counts, Tally};

/// What a loop tells.
// A tick is most of what comes: a box for it would be an allocation in the loop.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Copy, Debug)]
pub enum Told {
    /// A tick.
    Tick(Tick),
    /// Something that happened at one.
    Note(Noted),
}

/// What a loop has counted of what it told. It comes by another way than the ticks, so nothing of it is
/// lost where they find no room.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counted {
    /// Ticks that it made.
    pub ticks: u64,
    /// Notes that it told.
    pub notes: u64,
    /// Ticks and notes that found no room.
    pub lost: u64,
    /// Ticks at whose end a trip of the safety kept the motors off.
    pub motors_off: u64,
    /// How long the loop ran, and for how much of that no force was delivered; zero where nobody said.
    pub time: LoopTime,
    /// Why the loop ended; `None` while it runs, or where nobody said.
    pub ending: Option<Ending>,
}

impl From<Counts> for Counted {
    fn from(counts: Counts) -> Self {
        Self {
            ticks: counts.ticks,
            notes: counts.notes,
            lost: counts.lost,
            motors_off: counts.motors_off,
            time: LoopTime {
                lasted: counts.lasted,
                motors_off: counts.motors_off_for,
            },
            ending: Ending::of_number(counts.ending),
        }
    }
}

/// The loop's end: it drops what finds no room, and counts it.
#[derive(Debug)]
pub struct Tap {
    out: rtrb::Producer<Told>,
    tally: Arc<Tally>,
    waits: bool,
}

/// The listener's end: what was told and has not been listened to. It never waits; its end may be
/// followed by more.
#[derive(Debug)]
pub struct Listener {
    incoming: rtrb::Consumer<Told>,
    tally: Arc<Tally>,
}

/// A tap with room for `capacity` things that have not been listened to.
#[must_use]
pub fn tap(capacity: usize) -> (Tap, Listener) {
    let (out, incoming) = rtrb::RingBuffer::new(capacity);
    let tally = Arc::new(Tally::new());
    let tap = Tap {
        out,
        tally: Arc::clone(&tally),
        waits: false,
    };
    (tap, Listener { incoming, tally })
}

impl Tap {
    /// Tells a tick. Its number says how many have been made.
    pub fn tick(&mut self, tick: &Tick) {
        self.tally.made(tick.sequence.saturating_add(1));
        if tick.flags.has(Flags::SAFETY_TRIPPED) {
            self.tally.was_off();
        }
        self.push(Told::Tick(*tick));
    }

    /// Tells how long the loop ran so far, and for how much of that no force was delivered.
    pub fn ran(&mut self, time: LoopTime) {
        self.tally.ran(time.lasted, time.motors_off);
    }

    /// Tells something that happened.
    pub fn note(&mut self, noted: &Noted) {
        self.tally.noted();
        self.push(Told::Note(*noted));
    }

    /// Says how many ticks and notes there were, how many ticks ended with the motors off, and for how
    /// long, where not all of them were told here. What found no room is counted as it was.
    pub fn count(&mut self, counted: &Counted) {
        self.tally.set(&Counts {
            ticks: counted.ticks,
            notes: counted.notes,
            motors_off: counted.motors_off,
            lasted: counted.time.lasted,
            motors_off_for: counted.time.motors_off,
            ..Counts::default()
        });
    }

    /// What was counted so far.
    #[must_use]
    pub fn counted(&self) -> Counted {
        self.tally.counts().into()
    }

    /// Nothing more comes, since the loop has ended. A tap that is dropped says that nothing more
    /// comes, but not why.
    pub fn end(self, ending: Ending) {
        self.tally.ended(ending.number());
    }

    /// How many things found no room.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.tally.counts().lost
    }

    /// The same tap, waiting for room instead of losing anything: for a loop that runs as fast as it
    /// can, on a clock that stands still meanwhile. Never for one with a motor.
    #[must_use]
    pub fn waiting(mut self) -> Self {
        self.waits = true;
        self
    }

    #[expect(
        clippy::disallowed_methods,
        reason = "yields only where the clock stands still meanwhile"
    )]
    fn push(&mut self, told: Told) {
        while self.waits && self.out.is_full() && !self.tally.is_deaf() {
            std::thread::yield_now();
        }
        if self.out.push(told).is_err() {
            self.tally.dropped();
        }
    }
}

impl Drop for Tap {
    fn drop(&mut self) {
        self.tally.close();
    }
}

impl Listener {
    /// How many things found no room. A recording shows by its numbers which ticks they were.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.tally.counts().lost
    }

    /// What the loop has counted so far; all of it once [`is_closed`](Self::is_closed) was true.
    #[must_use]
    pub fn counted(&self) -> Counted {
        self.tally.counts().into()
    }

    /// Whether nothing more will be told; what was may still be here. Asked before the last item is
    /// taken, it says that there is no other.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.tally.is_closed()
    }
}

impl Iterator for Listener {
    type Item = Told;

    fn next(&mut self) -> Option<Told> {
        self.incoming.pop().ok()
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        self.tally.turn_deaf();
    }
}
