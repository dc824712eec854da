//! What is counted while a trip keeps the motors off.

use std::sync::atomic::Ordering;

use palpate_io::recording::{Flags, Tick};
use palpate_rt::safety::SafetyParams;

use super::{at, scripted, wide};

/// Out of its range at the sixth tick, then ever deeper in the wall within it, with a force of none.
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
    let ticks: Vec<Tick> = (0..36).map(|_| control.tick()).collect();
    let is_off = |tick: &&Tick| tick.flags.has(Flags::SAFETY_TRIPPED);
    assert_eq!(ticks.iter().filter(is_off).count(), 31);
    assert_eq!(control.statistics().motors_off, 31);
    // The interval before the trip was held by a force; the one after it by none.
    let delivered = ticks[5].held_leak;
    let last = ticks[35];
    assert!(last.stored_energy > 0.4, "{last:?}");
    assert_eq!(last.held_leak, delivered, "no motor has created anything");
    for tick in &ticks {
        let accounts =
            tick.port_work + tick.virtual_force_work + tick.outside_work + tick.held_leak;
        let stored = tick.stored_energy - ticks[0].stored_energy;
        assert!((stored - accounts).abs() < 1e-9, "{tick:?}");
    }
    // Back on, the motors answer for what follows, and for no more.
    control.rearm().store(true, Ordering::Release);
    let rearmed = control.tick();
    assert_eq!(rearmed.held_leak, delivered);
    let after = control.tick();
    assert_eq!(control.statistics().motors_off, 31);
    assert!((after.held_leak - delivered).abs() < 1e-3, "{after:?}");
}
