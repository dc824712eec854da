//! The loop on its own thread, on the machine's clock.

#![allow(clippy::print_stdout)] // tests show what they measured
#![allow(
    clippy::disallowed_methods,
    clippy::disallowed_types,
    reason = "the test is the world around the loop: it waits, and looks at the time"
)]

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::sleep;
use std::time::{Duration, Instant};

use palpate_core::{AnyParams, Contact, LoopParams, ObjectState};
use palpate_device::clock::{Clock, MonotonicClock};
use palpate_device::{Capabilities, Device, DeviceError, Pose, Wrench, ZeroWriter};
use palpate_record::recording::{ContactTick, Entry, Recording, RecordingMetadata, Tick};
use palpate_rt::realtime::{Answer, Request};
use palpate_rt::safety::SafetyParams;
use palpate_rt::{ControlLoop, Ending, ForeignTicks, LoopThread, Recorder, Rendering, StopFlag};

/// Observed calls of a device.
#[derive(Default)]
struct Seen {
    reads: AtomicU64,
    last_force: Mutex<f64>,
    zeroed: AtomicUsize,
    zeroed_at: Mutex<Option<Instant>>,
    /// Ends a blocking read.
    is_released: AtomicBool,
}

/// Fault of a read.
#[derive(Clone, Copy)]
enum FaultKind {
    None,
    Panics,
    /// Blocks until the test releases it.
    Hangs,
}

/// A device 1 mm deep in a wall of 1000 N/m, with a fault at its hundredth read.
struct Faulty {
    clock: MonotonicClock,
    capabilities: Capabilities,
    trouble: FaultKind,
    seen: Arc<Seen>,
}

impl Device for Faulty {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        if self.seen.reads.fetch_add(1, Ordering::SeqCst) == 100 {
            match self.trouble {
                FaultKind::None => {}
                FaultKind::Panics => panic!("the cable is on fire"),
                FaultKind::Hangs => {
                    while !self.seen.is_released.load(Ordering::SeqCst) {
                        sleep(Duration::from_millis(1));
                    }
                }
            }
        }
        Ok(Pose {
            orientation: None,
            position: [1e-3, 0.0, 0.0],
            time: self.clock.now(),
        })
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        *self.seen.last_force.lock().unwrap() = wrench.force[0];
        Ok(wrench)
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        struct Zero(Arc<Seen>);
        impl ZeroWriter for Zero {
            fn write_zero(&mut self) {
                self.0.zeroed.fetch_add(1, Ordering::SeqCst);
                self.0
                    .zeroed_at
                    .lock()
                    .unwrap()
                    .get_or_insert(Instant::now());
            }
        }
        Some(Box::new(Zero(Arc::clone(&self.seen))))
    }
}

type FaultyLoop = ControlLoop<Faulty, MonotonicClock>;

fn control(trouble: FaultKind, period: f64) -> (FaultyLoop, Arc<Seen>) {
    let clock = MonotonicClock::new();
    let seen = Arc::new(Seen::default());
    let device = Faulty {
        clock,
        capabilities: Capabilities::unknown("troubled", 1),
        trouble,
        seen: Arc::clone(&seen),
    };
    let rendering = Rendering {
        contact: Contact::object(1000.0, f64::INFINITY),
        loop_params: LoopParams::new(period),
        params: AnyParams::Basic,
        virtual_force: 0.0,
        object: ObjectState {
            position: 0.0,
            velocity: 0.0,
        },
    };
    let limits = SafetyParams {
        soft_start: 0.0,
        ..SafetyParams::default()
    };
    let control = ControlLoop::new(device, clock, rendering, limits).unwrap();
    (control, seen)
}

fn start(control: FaultyLoop, stop: &StopFlag) -> LoopThread<Faulty, MonotonicClock> {
    LoopThread::start(control, Request::default(), stop, None).unwrap()
}

fn wait_for_reads(seen: &Seen, reads: u64) {
    let begun = Instant::now();
    while seen.reads.load(Ordering::SeqCst) < reads {
        assert!(
            begun.elapsed() < Duration::from_secs(20),
            "the loop does not tick"
        );
        sleep(Duration::from_millis(1));
    }
}

fn force(seen: &Seen) -> f64 {
    *seen.last_force.lock().unwrap()
}

#[test]
fn it_runs_until_it_is_stopped_and_leaves_no_force() {
    let (control, seen) = control(FaultKind::None, 0.002);
    let stop = StopFlag::new();
    let running = start(control, &stop);
    let (of_loop, of_supervisor) = running.answers().split_at(2);
    if of_loop.iter().all(Answer::is_granted) || !of_supervisor.is_empty() {
        assert_eq!(
            of_supervisor[0].asked,
            "supervisor: SCHED_FIFO, priority 81"
        );
    }
    wait_for_reads(&seen, 50);
    // A busy machine may have delayed the loop just now.
    let begun = Instant::now();
    while force(&seen) != -1.0 {
        assert!(begun.elapsed() < Duration::from_secs(20), "no force");
    }
    let asked = Instant::now();
    running.stop();
    let end = running.join();
    println!("ended {:?} after it was asked to", asked.elapsed());
    assert_eq!(end.ending, Ending::Stopped);
    assert_eq!(force(&seen), 0.0);
    let statistics = &end.statistics;
    assert_eq!(statistics.ticks, seen.reads.load(Ordering::SeqCst));
    assert_eq!(statistics.lateness.count(), statistics.ticks);
    assert!(statistics.tick.longest() >= statistics.tick.quantile(0.5));
}

#[test]
fn a_loop_that_nobody_waits_for_leaves_no_force() {
    let (control, seen) = control(FaultKind::None, 0.002);
    let running = start(control, &StopFlag::new());
    wait_for_reads(&seen, 20);
    drop(running);
    assert_eq!(force(&seen), 0.0);
    let reads = seen.reads.load(Ordering::SeqCst);
    sleep(Duration::from_millis(20));
    assert_eq!(seen.reads.load(Ordering::SeqCst), reads);
}

#[test]
fn a_loop_without_a_thread_leaves_no_force_when_it_is_dropped() {
    let (mut control, seen) = control(FaultKind::None, 0.001);
    control.tick();
    assert_eq!(force(&seen), -1.0);
    drop(control);
    assert_eq!(force(&seen), 0.0);
}

#[test]
fn driver_panic_zeroes_force_and_is_reported() {
    let (control, seen) = control(FaultKind::Panics, 0.001);
    let end = start(control, &StopFlag::new()).join();
    assert_eq!(end.ending, Ending::Panicked);
    assert_eq!(end.panic.as_deref(), Some("the cable is on fire"));
    assert_eq!(force(&seen), 0.0);
    assert_eq!(end.statistics.ticks, 100);
}

/// The thread itself is blocked: only another thread can disable the motor.
#[test]
fn a_read_that_hangs_is_cut_by_the_supervisor() {
    // At 50 Hz, so that other programs do not delay the loop.
    let (control, seen) = control(FaultKind::Hangs, 0.02);
    let running = start(control, &StopFlag::new());
    wait_for_reads(&seen, 101);
    let hung = Instant::now();
    *seen.zeroed_at.lock().unwrap() = None;
    let before = seen.zeroed.load(Ordering::SeqCst);
    // The cut is repeated while the read is blocked.
    while seen.zeroed.load(Ordering::SeqCst) < before + 3 {
        assert!(hung.elapsed() < Duration::from_secs(20), "it is not cut");
        sleep(Duration::from_millis(1));
    }
    assert_eq!(seen.reads.load(Ordering::SeqCst), 101, "the read hangs");
    let cut_at = seen.zeroed_at.lock().unwrap().unwrap();
    seen.is_released.store(true, Ordering::SeqCst);
    wait_for_reads(&seen, 105);
    running.stop();
    let end = running.join();
    let cut_after = cut_at.saturating_duration_since(hung);
    println!("cut {cut_after:?} after the read began to hang, at a period of 20 ms");
    assert!(end.cuts >= 1);
    assert!(end.cuts < seen.zeroed.load(Ordering::SeqCst) as u64);
}

#[test]
fn what_a_loop_does_is_recorded_tick_by_tick() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let (control, _seen) = control(FaultKind::None, 0.00025);
    let (tap, recorder) = Recorder::begin(&path, &RecordingMetadata::new("test")).unwrap();
    let running = LoopThread::start(
        control.tapped(tap),
        Request::default(),
        &StopFlag::new(),
        Some(2000),
    )
    .unwrap();
    let end = running.join();
    let (account, unwritten) = recorder.finish();
    assert!(unwritten.is_none(), "{unwritten:?}");
    assert_eq!(end.ending, Ending::Complete);
    let made = end.statistics.ticks;
    assert!(end.statistics.periods() >= 2000 && made <= 2000, "{made}");
    assert_eq!(account.recording.unwrap().ticks, made);
    assert_eq!((account.ticks_made, account.ticks), (made, made));
    assert_eq!((account.lost_ticks(), account.lost_events()), (0, 0));
    assert_eq!(account.motors_off, end.statistics.motors_off);
    assert_eq!(account.last.unwrap().tick.sequence, made - 1);
    let recording = Recording::open(&path).unwrap();
    assert!(recording.is_complete(), "{:?}", recording.missing);
    let counted = recording.counted.as_ref().unwrap();
    assert_eq!(counted.ticks, made);
    assert_eq!(counted.ending.as_deref(), Some("the duration is over"));
    let mut ticks = 0;
    let mut before = f64::NEG_INFINITY;
    for entry in recording.entries().unwrap() {
        if let Entry::Tick(tick, ..) = entry.unwrap() {
            assert!(tick.time > before);
            before = tick.time;
            ticks += 1;
        }
    }
    assert_eq!(ticks, made);
}

/// No machine has memory for so many waiting ticks.
#[test]
fn without_memory_no_recording_is_begun() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    for room in [1 << 50, usize::MAX] {
        let error =
            Recorder::begin_with_room(&path, &RecordingMetadata::new("test"), room).unwrap_err();
        assert_eq!(error.source.kind(), std::io::ErrorKind::OutOfMemory);
        let words = error.to_string();
        assert!(
            words.contains(&format!("a buffer for {room} ticks needs ")),
            "{words}"
        );
    }
    assert_eq!(folder.path().read_dir().unwrap().count(), 0);
}

/// The disk is too slow, and the ring is full when the loop ends: the last ticks and the final event are lost, and
/// the file contains their number. Recorded ticks have all their contacts.
#[test]
fn a_tail_that_finds_no_room_is_counted_in_the_file() {
    for contacts in [1, 3] {
        tail_without_room(contacts);
    }
}

fn tail_without_room(contacts: usize) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("late.mcap");
    let (mut tap, recorder) = Recorder::begin(&path, &RecordingMetadata::new("test")).unwrap();
    let mut made = 0;
    // Continue until an item is dropped.
    loop {
        let lost = tap.lost();
        let tick = Tick {
            sequence: made,
            time: made as f64 * 1e-6,
            ..Tick::default()
        };
        tap.tick(&tick, &vec![ContactTick::default(); contacts]);
        made += 1;
        if tap.lost() > lost && made > 200_000 {
            break;
        }
    }
    tap.end(Ending::Stopped);
    let (account, unwritten) = recorder.finish();
    assert!(unwritten.is_none(), "{unwritten:?}");
    let held = account.recording.unwrap().ticks;
    println!("{held} of {made} ticks in the file");
    assert_eq!((account.ticks_made, account.ticks), (made, held));
    assert_eq!(account.lost_ticks(), made - held);
    let recording = Recording::open(&path).unwrap();
    assert!(recording.finished && !recording.is_whole() && !recording.is_complete());
    assert_eq!(
        (recording.ticks, recording.ticks_made()),
        (held, Some(made))
    );
    assert_eq!(recording.lost(), made - held);
    for entry in recording.entries().unwrap() {
        if let Entry::Tick(tick, of_tick, _, _) = entry.unwrap() {
            assert_eq!(of_tick.len(), contacts, "{}", tick.sequence);
        }
    }
    let last = recording.last.unwrap().sequence;
    let tail = recording.missing.last().unwrap();
    assert_eq!((tail.after, tail.count), (Some(last), made - 1 - last));
    let ending = recording.counted.unwrap().ending;
    assert_eq!(ending.as_deref(), Some("stopped on request"));
}

/// A scheduler of its own, such as that of a vendor: a thread that calls the tick until it ends.
fn scheduler(
    mut ticks: ForeignTicks<Faulty, MonotonicClock>,
    period: Duration,
) -> std::thread::JoinHandle<ForeignTicks<Faulty, MonotonicClock>> {
    std::thread::spawn(move || {
        while ticks.tick().is_some() {
            sleep(period);
        }
        ticks
    })
}

#[test]
fn a_foreign_thread_that_hangs_is_cut_by_the_supervisor() {
    let (control, seen) = control(FaultKind::Hangs, 0.02);
    let stop = StopFlag::new();
    let ticks = ForeignTicks::start(control, Request::default(), &stop, None).unwrap();
    let thread = scheduler(ticks, Duration::from_millis(2));
    wait_for_reads(&seen, 101);
    let begun = Instant::now();
    while seen.zeroed.load(Ordering::SeqCst) == 0 {
        assert!(begun.elapsed() < Duration::from_secs(20), "it is not cut");
        sleep(Duration::from_millis(1));
    }
    seen.is_released.store(true, Ordering::SeqCst);
    wait_for_reads(&seen, 105);
    stop.raise();
    let end = thread.join().unwrap().finish().unwrap();
    assert_eq!(end.ending, Ending::Stopped);
    assert!(end.cuts >= 1);
    assert_eq!(force(&seen), 0.0);
}

#[test]
fn a_panic_of_a_driver_does_not_reach_the_foreign_thread() {
    let (control, seen) = control(FaultKind::Panics, 0.001);
    let ticks = ForeignTicks::start(control, Request::nothing(), &StopFlag::new(), None).unwrap();
    let thread = scheduler(ticks, Duration::ZERO);
    let end = thread.join().unwrap().finish().unwrap();
    assert_eq!(end.ending, Ending::Panicked);
    assert_eq!(end.panic.as_deref(), Some("the cable is on fire"));
    assert_eq!(force(&seen), 0.0);
}
