//! Fault injection: time until zero force is commanded, and losses.

use std::sync::atomic::Ordering;
use std::time::Duration;

use palpate_device::clock::{Clock, SteppedClock};
use palpate_device::{DeviceErrorKind, Step};
use palpate_record::recording::Flags;
use palpate_rt::safety::{SafetyParams, SafetyStop};
use palpate_rt::{Listener, Message, Note, StopFlag, tap};
use palpate_scene::method::MethodName;

use crate::{Scripted, at, scene, scripted, simulated, wide};

/// Number of samples before a fault.
const BEFORE: usize = 20;

fn limits() -> SafetyParams {
    SafetyParams {
        workspace: Some([[-0.05, -1.0, -1.0], [0.05, 1.0, 1.0]]),
        largest_speed: 2.0,
        // Nothing is late by itself, because the clock is stepped manually.
        tolerated_lateness: 0.0,
        ..SafetyParams::default()
    }
}

/// Creates a loop that has touched the wall gradually and is 1 mm deep in it, then meets `fault`, then is in the wall
/// again.
fn meets(fault: &[Step]) -> (Scripted, SteppedClock, Listener) {
    let mut script = vec![at(-1.0), at(0.0)];
    script.extend([at(1.0); BEFORE - 2]);
    script.extend_from_slice(fault);
    script.push(at(1.0));
    let (control, clock) = scripted(script, limits());
    let (tap, listener) = tap(10_000);
    let mut control = control.tapped(tap);
    for _ in 0..BEFORE {
        control.tick();
    }
    (control, clock, listener)
}

fn notes(listener: &mut Listener) -> Vec<Note> {
    listener
        .by_ref()
        .filter_map(|messages| match messages {
            Message::Note(noted) => Some(noted.note),
            Message::Tick(..) => None,
        })
        .collect()
}

/// Returns the number of periods until zero force is commanded, counted from the one with the fault; 1: immediately.
fn periods_to_zero(control: &mut Scripted) -> usize {
    for period in 1..=10 {
        if control.tick().contact.force_on_device == 0.0 {
            return period;
        }
    }
    panic!("the force stays on");
}

#[test]
fn every_fault_of_a_device_leaves_no_force_within_two_periods() {
    let nan = Step::At([f64::NAN, 0.0, 0.0]);
    let infinite = Step::At([f64::INFINITY, 0.0, 0.0]);
    use DeviceErrorKind::{Disconnected, Interrupted, NothingNew, Refused};
    let table: [(&str, Step, SafetyStop); 11] = [
        ("position NaN", nan, SafetyStop::NotANumber),
        ("position infinite", infinite, SafetyStop::NotANumber),
        ("repeated sample", Step::Stale, SafetyStop::StaleSample),
        (
            "no sample",
            Step::Fails(NothingNew),
            SafetyStop::StaleSample,
        ),
        ("out of the box", at(60.0), SafetyStop::OutsideWorkspace),
        ("too fast", at(40.0), SafetyStop::TooFast),
        (
            "read refused",
            Step::Fails(Refused),
            SafetyStop::DeviceRefused,
        ),
        (
            "device gone",
            Step::Fails(Disconnected),
            SafetyStop::DeviceLost,
        ),
        (
            "force refused",
            Step::FailsForce(Refused, [1e-3, 0.0, 0.0]),
            SafetyStop::DeviceRefused,
        ),
        (
            "device faulty for now",
            Step::Fails(Interrupted),
            SafetyStop::StaleSample,
        ),
        (
            "force not taken",
            Step::FailsForce(Interrupted, [1e-3, 0.0, 0.0]),
            SafetyStop::StaleSample,
        ),
    ];
    println!("fault              injected  periods to zero  force after it has passed");
    for (name, fault, safety_stop) in table {
        let mut worst = 0;
        let times = 5;
        let mut force_after = 0.0;
        for length in 2..2 + times {
            let (mut control, _, mut listener) = meets(&vec![fault; length]);
            assert_eq!(notes(&mut listener), [], "{name}: stopped before");
            worst = worst.max(periods_to_zero(&mut control));
            assert_eq!(control.safety_stop(), Some(safety_stop), "{name}");
            let mut last = control.tick();
            for _ in 0..1000 {
                last = control.tick();
                if control.safety_stop().is_some() {
                    assert_eq!(last.contact.force_on_device, 0.0, "{name}");
                    assert!(last.tick.flags.has(Flags::SAFETY_STOPPED), "{name}");
                }
            }
            force_after = last.contact.force_on_object
                - (last.contact.force_on_object + last.contact.force_on_device);
            let notes = notes(&mut listener);
            assert!(
                notes.contains(&Note::Stopped(safety_stop)),
                "{name}: {notes:?}"
            );
            let recovered = notes.iter().any(|note| matches!(note, Note::Recovered(_)));
            assert_eq!(recovered, safety_stop.is_passing(), "{name}: {notes:?}");
        }
        println!("{name:<18} {times:>8}  {worst:>15}  {force_after:.3} N");
        assert!(worst <= 2, "{name}: {worst} periods");
        let expected = if safety_stop.is_passing() { 1.0 } else { 0.0 };
        assert!(
            (force_after - expected).abs() < 1e-9,
            "{name}: {force_after} N"
        );
    }
}

#[test]
fn one_missing_sample_is_bridged_and_the_time_of_it_told() {
    let (mut control, _, mut listener) = meets(&[Step::Stale]);
    let missing = control.tick();
    assert_eq!(missing.contact.force_on_device, -1.0);
    assert!(missing.tick.flags.has(Flags::DEVICE_FAULT));
    let next = control.tick();
    assert_eq!(next.contact.force_on_device, -1.0);
    assert!((next.tick.period - 0.002).abs() < 1e-9);
    assert_eq!(notes(&mut listener), []);
    assert_eq!(control.statistics().without_sample, 1);
}

#[test]
fn latched_safety_stop_persists_until_rearmed() {
    let (mut control, _, mut listener) = meets(&[at(60.0)]);
    for _ in 0..500 {
        assert_eq!(control.tick().contact.force_on_device, 0.0);
    }
    control.rearm().store(true, Ordering::Release);
    let forces: Vec<f64> = (0..300)
        .map(|_| -control.tick().contact.force_on_device)
        .collect();
    // The soft start takes a fifth of a second and has no larger steps.
    assert_eq!(forces[0], 0.0);
    assert!(
        forces.windows(2).all(|pair| pair[1] - pair[0] < 0.0051),
        "{forces:?}"
    );
    assert!((forces[299] - 1.0).abs() < 1e-9);
    assert!(notes(&mut listener).contains(&Note::Rearmed));
}

#[test]
fn a_run_that_begins_in_contact_begins_softly_and_one_that_touches_later_does_not() {
    let (mut control, _) = scripted(vec![at(1.0)], SafetyParams::default());
    let forces: Vec<f64> = (0..300)
        .map(|_| -control.tick().contact.force_on_device)
        .collect();
    assert_eq!(forces[0], 0.0);
    assert!((forces[100] - 0.5).abs() < 0.02, "{}", forces[100]);
    assert!((forces[299] - 1.0).abs() < 1e-9);
    let (mut control, _) = scripted(vec![at(-0.5), at(0.0), at(1.0)], SafetyParams::default());
    let forces: Vec<f64> = (0..3)
        .map(|_| -control.tick().contact.force_on_device)
        .collect();
    assert_eq!(forces, [0.0, 0.0, 1.0]);
}

#[test]
fn forces_are_clamped_and_slewed() {
    let clamp = SafetyParams {
        largest_force: 0.7,
        ..wide()
    };
    let (mut control, _) = scripted(vec![at(0.0), at(1.0)], clamp);
    control.tick();
    let tick = control.tick();
    assert_eq!(
        (tick.contact.force_on_device, tick.contact.force_on_object),
        (-0.7, 1.0)
    );
    assert!(tick.tick.flags.has(Flags::SAFETY_LIMITED));
    let slew = SafetyParams {
        slew_limit: 100.0,
        ..wide()
    };
    let (mut control, _) = scripted(vec![at(0.0), at(1.0)], slew);
    let forces: Vec<f64> = (0..12)
        .map(|_| -control.tick().contact.force_on_device)
        .collect();
    for (index, force) in forces.iter().enumerate() {
        let expected = (0.1 * index as f64).min(1.0);
        assert!((force - expected).abs() < 1e-12, "{forces:?}");
    }
}

/// The ledger contains the sent force: on a device clamped to 0.7 N, 0.7 N does the work.
#[test]
fn the_ledger_uses_the_force_really_sent() {
    let clamp = SafetyParams {
        largest_force: 0.7,
        ..wide()
    };
    let (mut control, _) = scripted(vec![at(0.0), at(1.0), at(2.0), at(2.0)], clamp);
    let work: Vec<f64> = (0..4).map(|_| control.tick().contact.port_work).collect();
    assert_eq!(work[1], 0.0);
    assert!((work[2] - 0.7e-3).abs() < 1e-12, "{work:?}");
}

#[test]
fn oscillating_contact_causes_safety_stop_and_stable_contacts_do_not() {
    let mut buzzing = scene("experiment2.toml");
    buzzing.contact.stiffness *= 4.0;
    let (mut control, _) = simulated(&buzzing, MethodName::Basic, SafetyParams::default());
    let mut worst_before: f64 = 0.0;
    let stopped = (0..2000).find(|_| {
        let tick = control.tick();
        worst_before = worst_before.max(tick.contact.held_leak);
        control.safety_stop().is_some()
    });
    println!("basic at kappa 2.6 safety stops at period {stopped:?}, {worst_before:.3} J created");
    assert_eq!(control.safety_stop(), Some(SafetyStop::Oscillation));
    for name in [
        "fig2.toml",
        "experiment1.toml",
        "coupled/wall-100.toml",
        "coupled/wall-1000.toml",
    ] {
        let scene = scene(name);
        for method in [MethodName::Hfcr, MethodName::Coupled] {
            let (mut control, _) = simulated(&scene, method, SafetyParams::default());
            for _ in 0..1000 {
                control.tick();
            }
            assert_eq!(control.safety_stop(), None, "{name}, {method}");
        }
    }
}

/// The loop's thread stalls: the supervisor acts, and the loop detects it afterwards.
#[test]
fn a_stalled_loop_is_cut_within_two_periods_and_comes_back_softly() {
    let (mut control, clock, mut listener) = meets(&[at(1.0)]);
    let zeroed = control.device().times_zeroed();
    let mut supervisor = control.supervisor().unwrap();
    control.tick();
    let half = Duration::from_micros(500);
    // The next tick sleeps until the next deadline, so the period itself is on time.
    let mut halves = 0;
    while zeroed.load(Ordering::SeqCst) == 0 {
        clock.advance(half);
        supervisor.look(clock.now());
        halves += 1;
        assert!(halves <= 4, "not cut after two periods");
    }
    println!("cut after {} periods", f64::from(halves) / 2.0);
    for _ in 0..20 {
        clock.advance(half);
        assert!(!supervisor.look(clock.now()), "it has begun once");
    }
    assert_eq!(control.cuts(), 1);
    let back = control.tick();
    assert_eq!(back.contact.force_on_device, 0.0);
    assert_eq!(control.safety_stop(), Some(SafetyStop::Stalled));
    let forces: Vec<f64> = (0..300)
        .map(|_| -control.tick().contact.force_on_device)
        .collect();
    assert!(forces[0] < 0.01 && (forces[299] - 1.0).abs() < 1e-9);
    let notes = notes(&mut listener);
    assert!(notes.contains(&Note::Stopped(SafetyStop::Stalled)));
    assert!(
        notes.contains(&Note::Recovered(SafetyStop::Stalled)),
        "{notes:?}"
    );
    // A loop on time is not cut.
    for _ in 0..100 {
        control.tick();
        assert!(!supervisor.look(clock.now()));
    }
}

/// A wake-up of an ordinary machine is occasionally late by up to 3 ms. That is not a stall, whatever the period; a
/// longer delay is one.
#[test]
fn a_wake_up_that_is_late_as_they_are_is_not_cut() {
    for (late, is_stall) in [(2900, false), (3600, true)] {
        let (mut control, clock) =
            scripted(vec![at(-1.0), at(0.0), at(1.0)], SafetyParams::default());
        let mut supervisor = control.supervisor().unwrap();
        for _ in 0..BEFORE {
            control.tick();
        }
        // From tick to tick: a period of 1 ms plus the lateness.
        let begun = clock.now();
        let mut was_cut = false;
        while clock.now() < begun + Duration::from_micros(1000 + late) {
            clock.advance(Duration::from_micros(100));
            was_cut |= supervisor.look(clock.now());
        }
        assert_eq!(was_cut, is_stall, "late by {late} us");
        assert_eq!(control.tick().contact.force_on_device == 0.0, is_stall);
    }
}

/// The loop did not run when it was cut. The supervisor reports the time of the cut: 1 N for 1.6 of 5 ms did the work
/// over the millimetre. A watchdog process acts after its limit, 1.5 ms, even if the supervisor stalled together with
/// the loop.
#[test]
fn the_ledger_counts_no_force_from_the_cut_on() {
    for (supervisor_after, is_guarded, held) in [
        (Some(1600), false, 1.6),
        (None, false, 5.0),
        (None, true, 1.5),
        (Some(5000), true, 1.5),
    ] {
        let (mut control, clock, _listener) = meets(&[at(1.0), at(2.0)]);
        let mut supervisor = control.supervisor().unwrap();
        let before = control.tick();
        let watchdog = control.device().watchdog();
        watchdog.store(is_guarded, Ordering::SeqCst);
        let after = supervisor_after.unwrap_or(0);
        clock.advance(Duration::from_micros(after));
        assert_eq!(supervisor.look(clock.now()), supervisor_after.is_some());
        clock.advance(Duration::from_micros(5000 - after));
        let after = control.tick();
        assert!((after.tick.period - 5e-3).abs() < 1e-12);
        let work = after.contact.port_work - before.contact.port_work;
        assert!((work - 0.2e-3 * held).abs() < 1e-12, "{work}, {held}");
    }
}

#[test]
fn the_supervisor_leaves_alone_a_loop_that_has_ended() {
    let (mut control, clock, _listener) = meets(&[]);
    let mut supervisor = control.supervisor().unwrap();
    let stop = StopFlag::new();
    stop.raise();
    control.run(&stop, None);
    clock.advance(Duration::from_secs(1));
    assert!(!supervisor.look(clock.now()));
    assert_eq!(control.device().forces().last(), Some(&[0.0; 3]));
}

#[test]
fn a_late_loop_skips_deadlines_and_says_so() {
    let (mut control, clock, mut listener) = meets(&[at(1.0)]);
    let on_time = control.tick();
    assert_eq!(on_time.tick.lateness, 0.0);
    clock.oversleep_once(Duration::from_micros(3400));
    let late = control.tick();
    assert!((late.tick.lateness - 3.4e-3).abs() < 1e-12);
    assert!((late.tick.period - 4.4e-3).abs() < 1e-9);
    assert!(late.tick.flags.has(Flags::MISSED_DEADLINE));
    let next = control.tick();
    assert_eq!(next.tick.lateness, 0.0);
    assert!(
        (next.tick.period - 0.6e-3).abs() < 1e-9,
        "{}",
        next.tick.period
    );
    assert_eq!(control.statistics().missed_deadlines, 3);
    assert!(notes(&mut listener).contains(&Note::MissedDeadlines(3)));
}

/// Returns the number of ticks until the wall's force is complete; no step may exceed `step`.
fn comes_in_by(control: &mut Scripted, step: f64) -> usize {
    let mut last = 0.0;
    for tick in 0..1000 {
        let force = -control.tick().contact.force_on_device;
        assert!(
            force - last <= step + 1e-9,
            "from {last} to {force} N in tick {tick}"
        );
        if force > 0.999 {
            return tick;
        }
        last = force;
    }
    panic!("the force does not come back");
}

#[test]
fn safety_stop_does_not_shorten_soft_start() {
    let nan = Step::At([f64::NAN, 0.0, 0.0]);
    let missing = Step::Fails(DeviceErrorKind::NothingNew);
    for script in [
        vec![at(1.0)],
        vec![missing, missing, at(1.0)],
        vec![nan, at(1.0)],
        vec![at(1.0), at(1.0), at(1.0), nan, at(1.0)],
    ] {
        let (mut control, _) = scripted(script.clone(), SafetyParams::default());
        let ticks = comes_in_by(&mut control, 0.0051);
        assert!(ticks >= 198, "{script:?}: all there after {ticks} ms");
    }
}

/// Loop and supervisor stall together, and no cut is reported.
#[test]
fn a_freeze_of_loop_and_supervisor_is_noticed_by_the_loop() {
    for milliseconds in [5, 500] {
        let (mut control, clock, mut listener) = meets(&[at(1.0)]);
        control.tick();
        clock.advance(Duration::from_millis(milliseconds));
        assert_eq!(control.tick().contact.force_on_device, 0.0);
        assert!(notes(&mut listener).contains(&Note::Stopped(SafetyStop::Stalled)));
        // Ten times the duration of the outage, up to a whole soft start.
        let expected = (10 * milliseconds).min(200);
        let ticks = comes_in_by(&mut control, 1.0 / expected as f64);
        assert!(
            ticks as u64 + 2 >= expected,
            "{ticks} ms after {milliseconds} ms"
        );
    }
}

#[test]
fn latched_safety_stop_is_reported_in_tick_after_stall() {
    let (mut control, clock, mut listener) = meets(&[at(60.0)]);
    clock.advance(Duration::from_millis(50));
    control.tick();
    assert_eq!(control.safety_stop(), Some(SafetyStop::OutsideWorkspace));
    assert!(notes(&mut listener).contains(&Note::Stopped(SafetyStop::OutsideWorkspace)));
}

#[test]
fn rearming_without_safety_stop_has_no_effect() {
    let (mut control, _, mut listener) = meets(&[at(1.0)]);
    control.rearm().store(true, Ordering::Release);
    assert_eq!(control.tick().contact.force_on_device, -1.0);
    assert!(!notes(&mut listener).contains(&Note::Rearmed));
}

#[test]
fn a_force_that_is_clamped_comes_in_softly_too() {
    let limits = SafetyParams {
        largest_force: 1.0,
        ..SafetyParams::default()
    };
    let (mut control, _) = scripted(vec![at(45.0)], limits);
    assert!(comes_in_by(&mut control, 0.0051) >= 198);
}
