//! A tick allocates nothing, and does not panic, whatever the loop gets into.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use palpate_conformance_realtime::misdeeds::{Misdeed, commit};
use palpate_conformance_realtime::situations::{MONOTONIC, STEPPED, Situation};

/// The system's allocator, counting what each thread asks of it: memory taken, and given back.
struct Counting;

thread_local! {
    static CALLS: Cell<usize> = const { Cell::new(0) };
}

fn count() {
    CALLS.set(CALLS.get() + 1);
}

// SAFETY: every call is passed on unchanged; the counter is a constant-initialised thread-local
// without a destructor, so touching it allocates nothing. `alloc_zeroed` and `realloc` come
// through `alloc` by default.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller's promises are those `System` asks for.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count();
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Ticks, and how many of them called the allocator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Ticks {
    all: usize,
    allocating: usize,
}

fn watched(run: impl FnOnce(&mut dyn FnMut(&mut dyn FnMut()))) -> Ticks {
    let mut ticks = Ticks::default();
    run(&mut |tick| {
        let before = CALLS.get();
        tick();
        ticks.all += 1;
        ticks.allocating += usize::from(CALLS.get() != before);
    });
    ticks
}

fn none_in(situations: &[Situation]) {
    for (name, situation) in situations {
        let ticks = watched(situation);
        println!("{name}: {ticks:?}");
        assert_eq!(ticks.allocating, 0, "{name}");
        assert!(ticks.all > 0, "{name}");
    }
}

#[test]
fn a_tick_allocates_nothing() {
    none_in(&STEPPED);
}

#[test]
fn nor_does_it_in_real_time() {
    none_in(&MONOTONIC);
}

#[test]
fn a_tick_that_allocates_is_noticed() {
    let allocating = |misdeed| watched(|watch| commit(misdeed, watch)).allocating;
    assert_eq!(allocating(Misdeed::Nothing), 0);
    assert_eq!(allocating(Misdeed::Allocate), 10);
}
