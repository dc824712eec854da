//! The path from the loop to its recorder under loom: every interleaving of the two threads, and every value that a
//! weakly ordered machine allows a load to see.
//!
//! The tally is the program's own file. The ring is a model of `rtrb` 0.3.6, which does not support loom: it has the
//! same loads and stores with the same orderings, and `push` and `pop` as in its source.

#![allow(
    dead_code,
    reason = "the tally is the program's, and not all of it is used here"
)]

use loom::cell::UnsafeCell;
use loom::sync::Arc;
use loom::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use loom::thread;

/// Source of the atomics in `tally.rs`.
mod atomics {
    pub(crate) use loom::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, Ordering};
}

#[path = "../../../crates/palpate-rt/src/tally.rs"]
mod tally;

use tally::Tally;

const CAPACITY: usize = 1;
const TICKS: u64 = 3;

/// A ring with one producer and one consumer.
struct Ring {
    slots: [UnsafeCell<u64>; CAPACITY],
    head: AtomicUsize,
    tail: AtomicUsize,
}

// SAFETY: one side writes a slot while it is empty and the other reads it while it is full; loom fails the test
// otherwise.
unsafe impl Sync for Ring {}

impl Ring {
    fn new() -> Self {
        Self {
            slots: std::array::from_fn(|_| UnsafeCell::new(0)),
            head: AtomicUsize::new(0),
            tail: AtomicUsize::new(0),
        }
    }

    fn slot(&self, position: usize) -> &UnsafeCell<u64> {
        &self.slots[position % CAPACITY]
    }
}

struct Producer {
    ring: Arc<Ring>,
    cached_head: usize,
    cached_tail: usize,
}

impl Producer {
    fn is_full(&mut self) -> bool {
        if self.cached_tail - self.cached_head == CAPACITY {
            self.cached_head = self.ring.head.load(Ordering::Acquire);
        }
        self.cached_tail - self.cached_head == CAPACITY
    }

    fn push(&mut self, value: u64) -> bool {
        if self.is_full() {
            return false;
        }
        let slot = self.ring.slot(self.cached_tail);
        // SAFETY: the slot is empty, and this is the only producer.
        slot.with_mut(|slot| unsafe { *slot = value });
        self.cached_tail += 1;
        self.ring.tail.store(self.cached_tail, Ordering::Release);
        true
    }
}

struct Consumer {
    ring: Arc<Ring>,
    cached_head: usize,
    cached_tail: usize,
}

impl Consumer {
    fn pop(&mut self) -> Option<u64> {
        if self.cached_head == self.cached_tail {
            self.cached_tail = self.ring.tail.load(Ordering::Acquire);
            if self.cached_head == self.cached_tail {
                return None;
            }
        }
        let slot = self.ring.slot(self.cached_head);
        // SAFETY: the slot is full, and this is the only consumer.
        let value = slot.with(|slot| unsafe { *slot });
        self.cached_head += 1;
        self.ring.head.store(self.cached_head, Ordering::Release);
        Some(value)
    }
}

fn ring() -> (Producer, Consumer) {
    let ring = Arc::new(Ring::new());
    let (cached_head, cached_tail) = (0, 0);
    let producer = Producer {
        ring: Arc::clone(&ring),
        cached_head,
        cached_tail,
    };
    let consumer = Consumer {
        ring,
        cached_head,
        cached_tail,
    };
    (producer, consumer)
}

/// Listens like the recorder: it first loads the closed flag, then takes all entries.
fn listen(consumer: &mut Consumer, is_closed: impl Fn() -> bool) -> Vec<u64> {
    let mut heard = Vec::new();
    loop {
        let is_last = is_closed();
        let before = heard.len();
        heard.extend(std::iter::from_fn(|| consumer.pop()));
        if is_last && heard.len() == before {
            return heard;
        }
        thread::yield_now();
    }
}

/// The ring is repeatedly full, and every tick is either received or counted as lost.
#[test]
fn what_the_loop_made_is_what_was_heard_and_what_was_lost() {
    loom::model(|| {
        let (mut producer, mut consumer) = ring();
        let tally = Arc::new(Tally::new());
        let messages = Arc::clone(&tally);
        let maker = thread::spawn(move || {
            for tick in 0..TICKS {
                messages.made(tick + 1);
                if !producer.push(tick) {
                    messages.dropped();
                }
            }
            messages.ended(2);
            messages.close();
        });
        let heard = listen(&mut consumer, || tally.is_closed());
        let counts = tally.counts();
        assert_eq!((counts.ticks, counts.ending), (TICKS, 2));
        assert_eq!(heard.len() as u64 + counts.lost, TICKS);
        assert!(heard.windows(2).all(|pair| pair[0] < pair[1]), "{heard:?}");
        maker.join().unwrap();
    });
}

/// A waiting tap loses nothing while a listener exists, and stops waiting when it is gone.
#[test]
fn a_tap_that_waits_ends_when_nobody_listens() {
    loom::model(|| {
        let (mut producer, mut consumer) = ring();
        let tally = Arc::new(Tally::new());
        let messages = Arc::clone(&tally);
        let maker = thread::spawn(move || {
            for tick in 0..TICKS {
                messages.made(tick + 1);
                while producer.is_full() && !messages.is_deaf() {
                    thread::yield_now();
                }
                if !producer.push(tick) {
                    assert!(messages.is_deaf());
                    messages.dropped();
                }
            }
            messages.close();
        });
        let first = consumer.pop();
        assert!(first.is_none_or(|first| first == 0));
        tally.turn_deaf();
        maker.join().unwrap();
        let rest = std::iter::from_fn(|| consumer.pop()).count() as u64;
        let heard = u64::from(first.is_some()) + rest;
        assert_eq!(heard + tally.counts().lost, TICKS);
    });
}

/// Negative control: the test fails if the close is not a release or is not acquired, like `is_abandoned` of `rtrb`
/// without a subsequent fence.
fn closed_by(store: Ordering, load: Ordering) {
    loom::model(move || {
        let (mut producer, mut consumer) = ring();
        let ticks = Arc::new(AtomicU64::new(0));
        let closed = Arc::new(AtomicBool::new(false));
        let (messages, end) = (Arc::clone(&ticks), Arc::clone(&closed));
        let maker = thread::spawn(move || {
            messages.store(1, Ordering::Relaxed);
            assert!(producer.push(0));
            end.store(true, store);
        });
        let heard = listen(&mut consumer, || closed.load(load));
        assert_eq!((heard.len(), ticks.load(Ordering::Relaxed)), (1, 1));
        maker.join().unwrap();
    });
}

#[test]
fn a_close_that_is_released_and_acquired_is_enough() {
    closed_by(Ordering::Release, Ordering::Acquire);
}

#[test]
#[should_panic = "assertion `left == right` failed"]
fn a_close_that_is_not_released_is_found() {
    closed_by(Ordering::Relaxed, Ordering::Acquire);
}

#[test]
#[should_panic = "assertion `left == right` failed"]
fn a_close_that_is_not_acquired_is_found() {
    closed_by(Ordering::Release, Ordering::Relaxed);
}
