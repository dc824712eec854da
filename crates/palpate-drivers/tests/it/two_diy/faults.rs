use palpate_drivers::emulator::port::PortSettings;
use palpate_drivers::emulator::two_diy::Fault;
use palpate_record::recording::{Flags, Row};
use palpate_rt::realtime::Request;
use palpate_rt::{
    Ending, LoopEnd, LoopEvent, LoopThread, Message, Note, StopFlag, safety::SafetyStop, tap,
};

use super::*;

struct Ran {
    ticks: Vec<Row>,
    notes: Vec<LoopEvent>,
    ending: Ending,
    safety_stop: Option<SafetyStop>,
    /// Time of the fault since the loop's start `[s]`.
    injected: f64,
    struck: Instant,
    emulator: Emulator,
}

/// Presses a hand into a wall, and injects `fault` once the wall pushes back.
fn with(fault: Fault, comes_back: bool) -> Ran {
    let name = format!("{fault:?}");
    let emulator = Emulator::start(&on_a_socket(in_the_middle(Hand::at(THERE)))).unwrap();
    // Long patience, so that a busy machine is not taken for the fault.
    let device = open_in_the_middle(&emulator, 2 * PERIOD);
    let (tap, listener) = tap(1 << 15);
    let control = wall(device, 150.0, PERIOD, 100.0).tapped(tap);
    let stop = StopFlag::new();
    let started = Instant::now();
    let running = LoopThread::start(control, Request::nothing(), &stop, None).unwrap();
    wait_until("a force", || !is_none(emulator.torques()));
    std::thread::sleep(Duration::from_millis(100));
    let struck = Instant::now();
    let injected = started.elapsed().as_secs_f64();
    emulator.inject_faults(fault);
    std::thread::sleep(Duration::from_millis(500));
    // However busy the machine is: until the force has been back for a while, if it is expected back.
    let since = Instant::now();
    let pressed = |emulator: &Emulator| {
        let seen = emulator.seen();
        let later = seen.iter().filter(|seen| seen.at > since);
        later.filter(|seen| !is_none(seen.torques)).count()
    };
    while comes_back && pressed(&emulator) < 60 && !running.has_ended() {
        assert!(since.elapsed() < Duration::from_secs(20), "{name}");
        std::thread::sleep(Duration::from_millis(50));
    }
    stop.raise();
    let LoopEnd {
        ending,
        safety_stop,
        panic,
        control,
        ..
    } = running.join();
    assert_eq!(panic, None, "{name}");
    drop(control);
    let (mut ticks, mut notes) = (Vec::new(), Vec::new());
    for messages in listener {
        match messages {
            Message::Tick(tick, contacts, _, _) => ticks.extend(Row::new(tick, &contacts)),
            Message::Note(noted) => notes.push(noted),
        }
    }
    Ran {
        ticks,
        notes,
        ending,
        safety_stop,
        injected,
        struck,
        emulator,
    }
}

impl Ran {
    /// Returns whether the device reported an error with these words.
    fn said(&self, words: &str) -> bool {
        self.notes.iter().any(|noted| match noted.note {
            Note::Device(error) => error.what.contains(words),
            _ => false,
        })
    }

    fn stopped(&self, safety_stop: SafetyStop) -> bool {
        self.notes
            .iter()
            .any(|noted| noted.note == Note::Stopped(safety_stop))
    }

    /// Checks that the last force is held for at most one period without a good sample.
    fn no_force_after_two_periods(&self, what: &str) {
        let is_bad = |row: &Row| row.tick.flags.has(Flags::DEVICE_FAULT);
        for pair in self.ticks.windows(2) {
            if is_bad(&pair[0]) && is_bad(&pair[1]) {
                assert_eq!(pair[1].contact.force_on_device, 0.0, "{what}: {pair:?}");
            }
        }
    }

    fn has_recovered(&self, what: &str) {
        let later = self
            .ticks
            .iter()
            .filter(|row| row.tick.time > self.injected + 0.3);
        let pressing = later.filter(|row| row.contact.force_on_device < -0.2);
        assert!(pressing.count() > 8, "{what}: {:?}", self.notes);
    }
}

/// A faulty answer has no lasting effect: zero force while it lasts, then the wall again.
#[test]
fn answers_that_are_not_right_cost_a_moment() {
    let _alone = alone();
    for fault in [
        Fault::NoAnswer,
        Fault::LateAnswer(Duration::from_millis(25)),
        Fault::HalfAnswer,
        Fault::OtherId,
        Fault::Garbage(vec![0x05, 0xff, 0x00]),
        Fault::Garbage(vec![0x77; 40]),
        Fault::TwoAnswers,
        // One bad sample: the last force is held for one period.
        Fault::NotANumber,
    ] {
        let what = format!("{fault:?}");
        // A machine that stalls at that moment already has the next answer, and uses it.
        let ran = (0..6)
            .map(|_| with(fault.clone(), true))
            .find(|ran| {
                ran.ticks
                    .iter()
                    .any(|row| row.tick.flags.has(Flags::DEVICE_FAULT))
            })
            .expect("the loop never saw it");
        assert_eq!(ran.ending, Ending::Stopped, "{what}: {:?}", ran.notes);
        ran.no_force_after_two_periods(&what);
        ran.has_recovered(&what);
        came_whole_and_without_torque_at_resets(&ran.emulator.seen());
        assert!(is_none(ran.emulator.torques()), "{what}");
    }
}

/// A stalled board is unreachable; the packets that it processes afterwards end with zero torque.
#[test]
fn a_board_that_stands_still_finds_no_force_when_it_goes_on() {
    let _alone = alone();
    for milliseconds in [100, 300] {
        let stall = Duration::from_millis(milliseconds);
        let what = format!("{stall:?}");
        let ran = with(Fault::Stall(stall), true);
        ran.no_force_after_two_periods(&what);
        ran.has_recovered(&what);
        assert!(ran.stopped(SafetyStop::StaleSample), "{what}");
        let seen = ran.emulator.seen();
        came_whole_and_without_torque_at_resets(&seen);
        let gap = seen
            .windows(2)
            .position(|pair| {
                pair[1].at > ran.struck && pair[1].at - pair[0].at > stall.mul_f64(0.9)
            })
            .unwrap_or_else(|| panic!("{what}: it never stood still"));
        // The packets in flight at the stall, then zero torque.
        let after: Vec<_> = seen[gap + 1..].iter().take(5).collect();
        assert!(
            after.iter().any(|seen| is_none(seen.torques)),
            "{what}: {after:?}"
        );
        let before_next = after.iter().position(|seen| is_none(seen.torques)).unwrap();
        assert!(
            after[before_next].at - after[0].at < Duration::from_millis(50),
            "{what}"
        );
    }
}

#[test]
fn encoders_that_lose_count_end_the_force_until_somebody_looks() {
    let _alone = alone();
    let ran = with(Fault::Slip(170.0), false);
    assert_eq!(
        ran.safety_stop,
        Some(SafetyStop::DeviceRefused),
        "{:?}",
        ran.notes
    );
    assert!(ran.said("jumped for good"), "{:?}", ran.notes);
    ran.no_force_after_two_periods("slip");
    assert_eq!(ran.ticks.last().unwrap().contact.force_on_device, 0.0);
}

#[test]
fn a_cable_that_is_pulled_ends_the_run_and_can_be_put_back() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("haply");
    let emulator = Emulator::start(&Settings {
        port: PortSettings::Terminal {
            link: Some(link.clone()),
        },
        ..in_the_middle(Hand::at(THERE))
    })
    .unwrap();
    let device = open_in_the_middle(&emulator, PERIOD);
    let (tap, listener) = tap(1 << 15);
    let clock = crate::two_diy::clock();
    let control = wall(device, 150.0, PERIOD, 100.0).tapped(tap);
    let stop = StopFlag::new();
    let running = LoopThread::start(control, Request::nothing(), &stop, None).unwrap();
    wait_until("a force", || !is_none(emulator.torques()));
    emulator.inject_faults(Fault::Unplug(Duration::from_millis(100)));
    wait_until("the end", || running.has_ended());
    let end = running.join();
    assert_eq!(end.ending, Ending::DeviceLost);
    drop(end);
    let said: Vec<_> = listener
        .filter_map(|messages| match messages {
            Message::Note(noted) => Some(noted.note),
            Message::Tick(..) => None,
        })
        .collect();
    assert!(
        said.contains(&Note::Stopped(SafetyStop::DeviceLost)),
        "{said:?}"
    );
    let names_the_port =
        |note: &Note| matches!(note, Note::Device(error) if error.what.contains("port is gone"));
    assert!(said.iter().any(names_the_port), "{said:?}");
    wait_until("the port", || link.exists());
    // The hand decides the arm's position; it is the new start pose.
    let angles = emulator.angles();
    #[expect(
        clippy::cast_possible_truncation,
        reason = "angles on the wire are f32"
    )]
    let calibration = Calibration::At(angles.map(|angle| angle as f32));
    let options = Options::new(Generation::Three, calibration, SLOW).unwrap();
    let mut device = TwoDiy::open(&link, &options, clock).unwrap();
    let position = sample(&mut device).position;
    assert!(
        (position[1] - emulator.position()[1]).abs() < 2e-3,
        "{position:?}"
    );
}
