use palpate_record::recording::{Flags, Row};
use palpate_rt::realtime::Request;
use palpate_rt::{LoopThread, Message, StopFlag, tap};

use super::*;

const MILLISECOND: Duration = Duration::from_millis(1);

/// Complete system: a hand presses against a wall at 1 kHz.
#[test]
fn a_wall_holds_a_hand() {
    let _alone = alone();
    let hand = Hand::at(THERE).swaying([0.0, 0.01], 0.5);
    let emulator = Emulator::start(&on_a_socket(Settings {
        hand_waits: true,
        ..in_the_middle(hand)
    }))
    .unwrap();
    let device = open_in_the_middle(&emulator, MILLISECOND);
    let (tap, listener) = tap(1 << 13);
    let control = wall(device, 300.0, MILLISECOND, 1.5).tapped(tap);
    let running =
        LoopThread::start(control, Request::nothing(), &StopFlag::new(), Some(3000)).unwrap();
    let end = running.join();
    assert_eq!(end.panic, None);
    drop(end);
    assert!(is_none(emulator.torques()));
    let ticks: Vec<_> = listener
        .filter_map(|messages| match messages {
            Message::Tick(tick, contacts, _, _) => Row::new(tick, &contacts).next(),
            Message::Note(_) => None,
        })
        .collect();
    let fresh: Vec<_> = ticks
        .iter()
        .filter(|row| !row.tick.flags.has(Flags::DEVICE_FAULT))
        .collect();
    // A busy machine sometimes answers late.
    assert!(
        2 * fresh.len() > ticks.len(),
        "{} of {}",
        fresh.len(),
        ticks.len()
    );
    let pressing = fresh
        .iter()
        .filter(|row| row.contact.force_on_device < -0.3);
    assert!(pressing.count() > fresh.len() / 5);
    // 18 mm by the hand alone; with 200 N/m against 300 N/m, 7 mm remain. A busy machine sometimes loses the wall.
    let mut depths: Vec<_> = fresh.iter().map(|row| row.contact.penetration).collect();
    depths.sort_by(f64::total_cmp);
    let deep = depths[depths.len() * 9 / 10];
    assert!((0.004..0.012).contains(&deep), "{deep}");
    for Row { tick, contact, .. } in fresh {
        let asked = -contact.force_on_object;
        if tick.flags.has(Flags::SAFETY_LIMITED) || contact.force_on_device == 0.0 {
            continue;
        }
        // Within one duty step on each motor.
        assert!(
            (contact.force_on_device - asked).abs() < 0.01,
            "{contact:?}"
        );
    }
    came_whole_and_without_torque_at_resets(&emulator.seen());
}
