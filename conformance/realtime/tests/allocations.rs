//! A tick allocates nothing and does not panic, in every situation.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::time::Duration;

use palpate_conformance_realtime::misdeeds::{Misdeed, commit};
use palpate_conformance_realtime::situations::{MONOTONIC, STEPPED, Situation, scene};
use palpate_device::clock::MonotonicClock;
use palpate_drivers::emulator::inverse3::{Emulator, EmulatorOptions, Fault};
use palpate_drivers::inverse3::{Inverse3, Inverse3Options};
use palpate_rt::ControlLoop;
use palpate_rt::safety::SafetyParams;
use palpate_scene::method::MethodName;

/// The system's allocator, with a count of each thread's allocations and deallocations.
struct Counting;

thread_local! {
    static CALLS: Cell<usize> = const { Cell::new(0) };
}

fn count() {
    CALLS.set(CALLS.get() + 1);
}

// SAFETY: every call is forwarded unchanged; the counter is a constant-initialised thread-local without a destructor,
// so accessing it allocates nothing. `alloc_zeroed` and `realloc` call `alloc` by default.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller guarantees the requirements of `System`.
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

/// Number of ticks, and of ticks with calls of the allocator.
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

/// JSON and WebSocket allocate, but in the driver's threads. The driver wakes one of them in its `write`, by a
/// non-blocking system call. The other checks would report that call and are not used here.
#[test]
fn nor_does_it_on_an_inverse3_whatever_its_service_does() {
    let emulator = Emulator::start(&EmulatorOptions::default()).unwrap();
    let clock = MonotonicClock::new();
    let options = Inverse3Options {
        service: emulator.url(),
        ..Inverse3Options::default()
    };
    let device = Inverse3::open(&options, clock).unwrap();
    let inspector = device.inspector();
    let mut pressed = scene("wall.toml");
    pressed.object.position = -0.001;
    pressed.loop_params.period = 0.001;
    let rendering = pressed.rendering(MethodName::Basic).unwrap();
    let mut control = ControlLoop::new(device, clock, rendering, SafetyParams::default()).unwrap();
    let stall = Fault::Stall(Duration::from_millis(30));
    let faults = [
        stall,
        Fault::Garbage,
        Fault::Twice,
        Fault::Dropped,
        Fault::Disconnect,
    ];
    for fault in faults {
        let ticks = watched(|watch| {
            for tick in 0..300 {
                if tick == 100 {
                    emulator.inject(fault);
                }
                watch(&mut || {
                    control.tick();
                });
            }
        });
        println!("{fault:?}: {ticks:?}");
        assert_eq!(ticks.allocating, 0, "{fault:?}");
    }
    let counts = inspector.counts();
    assert!(counts.fresh > 100, "{counts:?}");
}

#[test]
fn a_tick_that_allocates_is_noticed() {
    let allocating = |misdeed| watched(|watch| commit(misdeed, watch)).allocating;
    assert_eq!(allocating(Misdeed::Nothing), 0);
    assert_eq!(allocating(Misdeed::Allocate), 10);
}
