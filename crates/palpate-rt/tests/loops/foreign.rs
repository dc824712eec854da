//! A loop whose ticks another scheduler makes.

use std::time::Duration;

use palpate_device::ScriptedDevice;
use palpate_device::clock::{Clock, SteppedClock};
use palpate_rt::realtime::Request;
use palpate_rt::{Ending, ForeignTicks, Message, StopFlag, tap};

use crate::{at, scripted, wide};

type Foreign = ForeignTicks<ScriptedDevice<SteppedClock>, SteppedClock>;

fn foreign(stop: &StopFlag, most: Option<u64>) -> (Foreign, SteppedClock, palpate_rt::Listener) {
    let (control, clock) = scripted(vec![at(1.0); 100], wide());
    let (tap, listener) = tap(100);
    let control = control.tapped(tap);
    let ticks = ForeignTicks::start(control, Request::nothing(), stop, most).unwrap();
    (ticks, clock, listener)
}

/// The scheduler of the test drifts, is early, and misses periods; each deadline is a period after the last tick.
#[test]
fn deadlines_follow_the_other_scheduler() {
    let (mut ticks, clock, listener) = foreign(&StopFlag::new(), None);
    let due = [0, 1100, 2200, 3000, 4000, 9000, 10_000].map(Duration::from_micros);
    let late: Vec<f64> = due
        .iter()
        .map(|due| {
            clock.sleep_until(*due);
            (ticks.tick().unwrap().tick.lateness * 1e6).round()
        })
        .collect();
    assert_eq!(late, [0.0, 100.0, 100.0, -200.0, 0.0, 4000.0, 0.0]);
    let end = ticks.finish().unwrap();
    assert_eq!(end.ending, Ending::Stopped);
    assert_eq!(end.statistics.ticks, 7);
    // Between 4 ms and 9 ms.
    assert_eq!(end.statistics.missed_deadlines, 4);
    assert_eq!(end.statistics.lateness.longest().as_micros() / 100, 40);
    let ticks = listener.filter(|message| matches!(message, Message::Tick(..)));
    assert_eq!(ticks.count(), 7);
}

#[test]
fn a_raised_flag_and_the_last_period_end_it_with_zero() {
    let stop = StopFlag::new();
    for most in [Some(3), None] {
        let (mut ticks, clock, _listener) = foreign(&stop.below(), most);
        let mut forces = Vec::new();
        for tick in 0..5 {
            clock.sleep_until(Duration::from_millis(tick));
            if tick == 3 && most.is_none() {
                stop.raise();
            }
            forces.extend(ticks.tick().map(|row| row.tick.delivered_force[0]));
        }
        assert_eq!(forces, [-1.0; 3]);
        let end = ticks.finish().unwrap();
        let expected = if most.is_none() {
            Ending::Stopped
        } else {
            Ending::Complete
        };
        assert_eq!(end.ending, expected);
        assert_eq!(end.control.device().forces().last(), Some(&[0.0; 3]));
    }
}
