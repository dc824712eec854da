//! From the loop's thread to whoever writes down what it does, without ever waiting.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use palpate_io::recording::Tick;

use crate::note::Noted;

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

/// The loop's end: it drops what finds no room, and counts it.
#[derive(Debug)]
pub struct Tap {
    out: rtrb::Producer<Told>,
    lost: Arc<AtomicU64>,
    waits: bool,
}

/// The listener's end: what was told and has not been listened to. It never waits; its end may be
/// followed by more.
#[derive(Debug)]
pub struct Listener {
    incoming: rtrb::Consumer<Told>,
    lost: Arc<AtomicU64>,
}

/// A tap with room for `capacity` things that have not been listened to.
#[must_use]
pub fn tap(capacity: usize) -> (Tap, Listener) {
    let (out, incoming) = rtrb::RingBuffer::new(capacity);
    let lost = Arc::new(AtomicU64::new(0));
    let tap = Tap {
        out,
        lost: Arc::clone(&lost),
        waits: false,
    };
    (tap, Listener { incoming, lost })
}

impl Tap {
    /// Tells a tick.
    pub fn tick(&mut self, tick: &Tick) {
        self.push(Told::Tick(*tick));
    }

    /// Tells something that happened.
    pub fn note(&mut self, noted: &Noted) {
        self.push(Told::Note(*noted));
    }

    /// How many things found no room.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.lost.load(Ordering::Relaxed)
    }

    /// The same tap, waiting for room instead of losing anything: for a loop that runs as fast as it
    /// can, on a clock that stands still meanwhile. Never for one with a motor.
    #[must_use]
    pub fn waiting(self) -> Self {
        Self {
            waits: true,
            ..self
        }
    }

    #[expect(
        clippy::disallowed_methods,
        reason = "yields only where the clock stands still meanwhile"
    )]
    fn push(&mut self, told: Told) {
        while self.waits && self.out.is_full() && !self.out.is_abandoned() {
            std::thread::yield_now();
        }
        if self.out.push(told).is_err() {
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
    }
}

impl Listener {
    /// How many things found no room. A recording shows by its numbers which ticks they were.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.lost.load(Ordering::Relaxed)
    }

    /// Whether the loop is gone; what it told may still be here.
    #[must_use]
    pub fn is_abandoned(&self) -> bool {
        self.incoming.is_abandoned()
    }
}

impl Iterator for Listener {
    type Item = Told;

    fn next(&mut self) -> Option<Told> {
        self.incoming.pop().ok()
    }
}
