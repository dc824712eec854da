//! Repeated loss of the force: conditions for a latched safety stop.

use std::sync::atomic::Ordering;
use std::time::Duration;

use palpate_device::Wrench;
use palpate_device::clock::SteppedClock;
use palpate_device::{DeviceErrorKind, Step};
use palpate_rt::safety::{Rendered, Safety, SafetyParams, SafetyStop};
use palpate_rt::{Listener, Message, Note, tap};

use crate::{Scripted, at, scripted};

/// Creates a loop at 1 kHz that presses a wall with 1 N, on a device that continues with `script`.
fn pressing(script: &[Step]) -> (Scripted, SteppedClock, Listener) {
    let mut steps = vec![at(-1.0), at(0.0), at(1.0), at(1.0)];
    steps.extend_from_slice(script);
    steps.push(at(1.0));
    let (control, clock) = scripted(steps, SafetyParams::default());
    let (tap, listener) = tap(10_000);
    let mut control = control.tapped(tap);
    for _ in 0..4 {
        control.tick();
    }
    (control, clock, listener)
}

fn stopped(listener: &mut Listener) -> Vec<SafetyStop> {
    let notes = listener.by_ref().filter_map(|messages| match messages {
        Message::Note(noted) => Some(noted.note),
        Message::Tick(..) => None,
    });
    let safety_stops = notes.filter_map(|note| match note {
        Note::Stopped(safety_stop) => Some(safety_stop),
        _ => None,
    });
    safety_stops.collect()
}

/// Stalls for `stall` ms in each `each` ms, 40 times or until the motors stay off. Returns the number of recoveries.
fn frozen(control: &mut Scripted, clock: &SteppedClock, stall: u64, each: u64) -> usize {
    for recovered in 0..40 {
        clock.advance(Duration::from_millis(stall));
        for _ in 0..each - stall {
            control.tick();
        }
        if control.safety_stop() == Some(SafetyStop::TooManyRecoveries) {
            return recovered;
        }
        assert_eq!(control.safety_stop(), None);
    }
    40
}

#[test]
fn a_loop_that_is_frozen_again_and_again_leaves_its_motors_off_for_good() {
    let (mut control, clock, mut listener) = pressing(&[]);
    assert_eq!(frozen(&mut control, &clock, 25, 85), 7);
    for _ in 0..5000 {
        assert_eq!(control.tick().contact.force_on_device, 0.0);
    }
    assert_eq!(control.device().forces().last(), Some(&[0.0; 3]));
    assert!(control.statistics().off_at_end >= Duration::from_secs(5));
    let safety_stops = stopped(&mut listener);
    let (last, before) = safety_stops.split_last().unwrap();
    assert_eq!(*last, SafetyStop::TooManyRecoveries);
    assert_eq!(before, [SafetyStop::Stalled; 8]);
    assert!(!last.is_passing());
    // Rearming allows another eight recoveries.
    control.rearm().store(true, Ordering::Release);
    let back = (0..300).map(|_| control.tick()).last().unwrap();
    assert!((back.contact.force_on_device + 1.0).abs() < 1e-9);
    assert_eq!(frozen(&mut control, &clock, 25, 85), 7);
}

/// Limits with a long tolerated stall are meant for a busy machine: the renderer rejects samples after such a gap,
/// and the force returns.
#[test]
fn outages_shorter_than_a_stall_that_is_allowed_never_count() {
    let patient = SafetyParams {
        stall_after_periods: 1000.0,
        ..SafetyParams::default()
    };
    let steps = vec![at(-1.0), at(0.0), at(1.0), at(1.0)];
    let (mut control, clock) = scripted(steps, patient);
    for _ in 0..4 {
        control.tick();
    }
    assert_eq!(frozen(&mut control, &clock, 25, 85), 40);
    assert!(control.statistics().refused > 0);
}

/// Any number of brief stalls is allowed: other programs on a busy machine cause them.
#[test]
fn brief_stalls_never_count() {
    for stall in [6, 10, 19] {
        let (mut control, clock, mut listener) = pressing(&[]);
        assert_eq!(frozen(&mut control, &clock, stall, stall + 5), 40);
        assert_eq!(
            stopped(&mut listener),
            [SafetyStop::Stalled; 40],
            "{stall} ms"
        );
    }
    let (mut control, clock, _listener) = pressing(&[]);
    assert_eq!(frozen(&mut control, &clock, 21, 26), 7);
}

#[test]
fn stalls_that_come_seldom_do_not_add_up() {
    // The first and the last of eight recoveries are seven intervals apart, 2 s or more.
    let (mut control, clock, _listener) = pressing(&[]);
    assert_eq!(frozen(&mut control, &clock, 25, 287), 40);
    let (mut control, clock, _listener) = pressing(&[]);
    assert_eq!(frozen(&mut control, &clock, 25, 285), 7);
}

/// Samples that are missing, not a number or too fast count like a stall of the same duration.
#[test]
fn outages_of_the_device_count_by_how_long_they_are() {
    let missing = Step::Fails(DeviceErrorKind::NothingNew);
    let nan = Step::At([f64::NAN, 0.0, 0.0]);
    for (fault, count, expected) in [
        (missing, 18, None),
        (missing, 25, Some(SafetyStop::TooManyRecoveries)),
        (nan, 18, None),
        (nan, 25, Some(SafetyStop::TooManyRecoveries)),
    ] {
        let mut script = Vec::new();
        for _ in 0..20 {
            script.extend(vec![fault; count]);
            script.extend([at(1.0); 30]);
        }
        let (mut control, _, _listener) = pressing(&script);
        for _ in 0..script.len() {
            control.tick();
        }
        assert_eq!(control.safety_stop(), expected, "{fault:?}, {count}");
    }
}

/// A force with a ramp of one second never reaches its full value if it is lost every second.
#[test]
fn with_a_longer_soft_start_recoveries_count_for_longer() {
    let safety_stops = |soft_start: f64| {
        let limits = SafetyParams {
            soft_start,
            ..SafetyParams::default()
        };
        let mut safety = Safety::new(limits, 0.001).unwrap();
        (0..20).any(|_| {
            let sample = |elapsed, stalled| Rendered {
                elapsed: Some(elapsed),
                position: [0.0; 3],
                coordinate: 0.0,
                wrench: Wrench::of_force([1.0, 0.0, 0.0]),
                slope: [0.0; 3],
                created_energy: 0.0,
                refused: false,
                stalled,
            };
            safety.evaluate(&sample(0.1, true));
            for _ in 0..1000 {
                safety.evaluate(&sample(0.001, false));
            }
            safety.safety_stop() == Some(SafetyStop::TooManyRecoveries)
        })
    };
    assert!(!safety_stops(0.2));
    assert!(safety_stops(1.0));
}
