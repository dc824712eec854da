use palpate_drivers::emulator::two_diy::{Fault, Wiring};
use palpate_drivers::two_diy::{Unchecked, Verdict};
use palpate_rt::StopFlag;

use super::*;

#[test]
fn motors_that_are_wired_wrong_are_found() {
    let _alone = alone();
    use Verdict::{Dead, Fine, Reversed, Swapped};
    let sold = Wiring::default();
    for (generation, wiring, verdicts) in [
        (Generation::One, sold, [Fine, Fine]),
        (Generation::Two, sold, [Fine, Fine]),
        (Generation::Three, sold, [Fine, Fine]),
        (
            Generation::Three,
            Wiring {
                reversed: [true, false],
                ..sold
            },
            [Reversed, Fine],
        ),
        (
            Generation::Two,
            Wiring {
                dead: [false, true],
                ..sold
            },
            [Fine, Dead],
        ),
        (
            Generation::Three,
            Wiring {
                swapped: true,
                ..sold
            },
            [Swapped, Swapped],
        ),
    ] {
        let emulator = Emulator::start(&on_a_socket(Settings {
            wiring,
            ..Settings::new(generation, generation.usual_board())
        }))
        .unwrap();
        let options = Options::new(generation, Calibration::Retracted, SLOW).unwrap();
        let mut device = TwoDiy::open(&emulator.path(), &options, MonotonicClock::new()).unwrap();
        // On a busy machine the emulated arm may stall during a pulse. A wiring error persists, so it is found in the
        // second or third check.
        let mut checks = Vec::new();
        while checks.last() != Some(&verdicts) && checks.len() < 3 {
            let checked = device.check_motors(&StopFlag::new()).unwrap();
            eprintln!("{generation:?} {wiring:?} {checked:?}");
            checks.push(checked.map(|checked| checked.verdict));
        }
        assert_eq!(
            checks.last(),
            Some(&verdicts),
            "{generation:?} {wiring:?} {checks:?}"
        );
        wait_until("no torque", || is_none(emulator.torques()));
        let most = emulator
            .seen()
            .iter()
            .flat_map(|seen| seen.torques)
            .fold(0.0_f64, |most, torque| most.max(torque.abs()));
        assert!(most < 0.031, "{most}");
    }
}

/// A check takes seconds. Lost answers do not make the board count as silent.
#[test]
fn a_check_gets_over_answers_that_are_lost() {
    let _alone = alone();
    let emulator = Emulator::start(&on_a_socket(Settings::new(
        Generation::Three,
        palpate_drivers::two_diy::Board::M0,
    )))
    .unwrap();
    // Short patience, so that a lost answer counts as many missing samples.
    let period = Duration::from_millis(2);
    let options = Options::new(Generation::Three, Calibration::Retracted, period).unwrap();
    let mut device = TwoDiy::open(&emulator.path(), &options, MonotonicClock::new()).unwrap();
    // A board counts as silent one second after its last good answer.
    std::thread::sleep(Duration::from_millis(1100));
    device.check_motors(&StopFlag::new()).unwrap();
    for _ in 0..3 {
        emulator.inject_faults(Fault::NoAnswer);
    }
    device.check_motors(&StopFlag::new()).unwrap();
    assert!(emulator.has_injected_fault(), "no answer was lost");
}

#[test]
fn a_check_that_is_ended_in_a_pulse_ends_it() {
    let _alone = alone();
    let emulator = Emulator::start(&on_a_socket(in_the_middle(Hand::at(THERE)))).unwrap();
    let mut device = open_in_the_middle(&emulator, SLOW);
    let stop = StopFlag::new();
    std::thread::scope(|scope| {
        let ended = scope.spawn(|| {
            wait_until("a pulse", || !is_none(emulator.torques()));
            stop.raise();
        });
        assert_eq!(device.check_motors(&stop), Err(Unchecked::Stopped));
        ended.join().unwrap();
    });
    wait_until("no torque", || is_none(emulator.torques()));
    device.close().unwrap();
}
