//! Accounting while a safety stop keeps the motors off.

use std::sync::atomic::Ordering;
use std::time::Duration;

use palpate_device::clock::Clock;
use palpate_record::recording::{Flags, LoopTime, Row};
use palpate_rt::safety::{SafetyParams, SafetyStop};
use palpate_rt::tap;

use super::{at, scripted, wide};

/// Outside its range at the sixth tick, then within it and ever deeper in the wall, with zero force.
#[test]
fn what_passes_with_the_motors_off_is_not_created_by_held_forces() {
    let limits = SafetyParams {
        range: Some([-0.05, 0.05]),
        ..wide()
    };
    let mut script = vec![at(1.0); 5];
    script.push(at(60.0));
    script.extend((0..30).map(|step| at(f64::from(step))));
    let (mut control, _) = scripted(script, limits);
    let ticks: Vec<Row> = (0..36).map(|_| control.tick()).collect();
    let is_off = |row: &&Row| row.tick.flags.has(Flags::SAFETY_STOPPED);
    assert_eq!(ticks.iter().filter(is_off).count(), 31);
    assert_eq!(control.statistics().motors_off, 31);
    // A force was held before the stop, and none after it.
    let delivered = ticks[5].contact.held_leak;
    let last = ticks[35];
    assert!(last.contact.stored_energy > 0.4, "{last:?}");
    assert_eq!(
        last.contact.held_leak, delivered,
        "no motor has created anything"
    );
    for tick in &ticks {
        let accounts = tick.contact.port_work
            + tick.contact.virtual_force_work
            + tick.contact.outside_work
            + tick.contact.held_leak;
        let stored = tick.contact.stored_energy - ticks[0].contact.stored_energy;
        assert!((stored - accounts).abs() < 1e-9, "{tick:?}");
    }
    // With the motors on again, only later energy is attributed to them.
    control.rearm().store(true, Ordering::Release);
    let rearmed = control.tick();
    assert_eq!(rearmed.contact.held_leak, delivered);
    let after = control.tick();
    assert_eq!(control.statistics().motors_off, 31);
    assert!(
        (after.contact.held_leak - delivered).abs() < 1e-3,
        "{after:?}"
    );
}

/// Component that removes the force of a stalled loop.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Cut {
    Nobody,
    Supervisor,
    Watchdog,
    /// The supervisor stalled together with the loop.
    WatchdogThenSupervisor,
}

/// The loop stalls for 3 s, and a force of 1 N is held until it is removed.
#[test]
fn a_stall_counts_by_its_time_from_when_the_force_was_taken_off() {
    let us = Duration::from_micros;
    for (cut, held) in [
        (Cut::Nobody, 3_000_000),
        (Cut::Supervisor, 4500),
        // Its limit at 1 kHz equals the supervisor's.
        (Cut::Watchdog, 4000),
        (Cut::WatchdogThenSupervisor, 4000),
    ] {
        let (control, clock) = scripted(vec![at(1.0)], wide());
        let (tap, listener) = tap(1);
        let mut control = control.tapped(tap);
        let watchdog = control.device().watchdog();
        let mut supervisor = control.supervisor().unwrap();
        for _ in 0..=2000 {
            control.tick();
        }
        let begun = clock.now();
        if cut == Cut::Supervisor {
            clock.advance(us(4500));
            assert!(supervisor.look(clock.now()));
        }
        watchdog.store(
            matches!(cut, Cut::Watchdog | Cut::WatchdogThenSupervisor),
            Ordering::SeqCst,
        );
        clock.advance(begun + us(3_000_000) - clock.now());
        if cut == Cut::WatchdogThenSupervisor {
            assert!(supervisor.look(clock.now()));
        }
        control.tick();
        assert_eq!(control.safety_stop(), Some(SafetyStop::Stalled), "{cut:?}");
        let off = us(3_000_000 - held);
        let time = LoopTime {
            lasted: us(5_000_000),
            motors_off: off,
        };
        assert_eq!(control.statistics().time, time, "{cut:?}");
        assert_eq!(listener.counted().time, time, "{cut:?}: a full ring");
        // The force is on again from there; of 2002 ticks one had the motors off.
        for _ in 0..3 {
            control.tick();
        }
        assert_eq!(control.safety_stop(), None, "{cut:?}");
        assert_eq!(control.statistics().time.motors_off, off + us(1000));
        assert_eq!(control.statistics().motors_off, 1, "{cut:?}");
    }
}
