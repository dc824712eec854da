//! Calibration of virtual devices recovers their parameters, and declines to report undeterminable ones.

use crate::plant::draws::{Kind, draw};
use crate::plant::{Plant, PlantParams};
use palpate_study::calibrate::{
    Calibration, Declined, Excitation, ExcitationParams, Phase, Quantity, Stop, measure,
};

/// Positions, forces and where the excitation ended.
fn excited(params: &ExcitationParams, plant: &mut Plant) -> (Excitation, Vec<f64>, Vec<f64>) {
    let mut excitation = Excitation::new(*params).unwrap();
    let (mut positions, mut forces) = (Vec::new(), Vec::new());
    while excitation.phase() == Phase::Running {
        let position = plant.measured();
        let force = excitation.next(position);
        plant.advance(force);
        positions.push(position);
        forces.push(force);
    }
    (excitation, positions, forces)
}

fn calibrated(plant: &PlantParams, seconds: f64) -> Result<Calibration, Declined> {
    let params = ExcitationParams {
        duration: seconds,
        ..ExcitationParams::new(plant.period)
    };
    let (excitation, positions, forces) = excited(&params, &mut Plant::new(*plant, 7));
    assert_eq!(excitation.phase(), Phase::Done);
    measure(&params, excitation.excited(), &positions, &forces)
        .map(|measured| measured.fitted.calibration)
}

/// Error of a value in standard deviations.
fn deviations(calibration: &Calibration, quantity: Quantity, put_in: f64) -> f64 {
    let found = calibration.value(quantity).unwrap();
    let deviation = calibration.standard_deviation(quantity).unwrap();
    (found - put_in).abs() / deviation
}

const EVERYTHING: Kind = Kind {
    friction: true,
    hand: true,
    resonance: false,
};

#[test]
fn mass_delay_and_friction_that_were_put_in_are_found() {
    for (period, quantum, seed) in [(1e-3, 1e-5, 3), (1e-3, 1e-6, 4), (4e-3, 1e-5, 5)] {
        let plant = draw(EVERYTHING, period, quantum, seed);
        let found = calibrated(&plant, 6.0).unwrap();
        let delay = plant.delay_plus_lag() * period;
        let error = (found.value(Quantity::DelayPlusLag).unwrap() - delay).abs() / period;
        assert!(error < 0.03, "{plant:?}: {error}");
        assert!(deviations(&found, Quantity::DelayPlusLag, delay) < 3.5);
        let mass = plant.moved_mass() / plant.gain;
        let error = (found.value(Quantity::DeviceMass).unwrap() / mass - 1.0).abs();
        assert!(error < 0.015 * (1.0 + period / 4e-3), "{plant:?}: {error}");
        assert!(deviations(&found, Quantity::DeviceMass, mass) < 3.5);
        let friction = found.value(Quantity::CoulombFriction).unwrap();
        assert!(
            (friction - plant.coulomb / plant.gain).abs() < 0.015,
            "{friction}"
        );
        assert_eq!(found.value(Quantity::Resonance), None);
        let step = found.value(Quantity::SensorQuantum).unwrap();
        assert!((step / quantum - 1.0).abs() < 1e-3, "{step}");
    }
}

#[test]
fn a_resonance_is_found_where_there_is_one() {
    let kind = Kind {
        resonance: true,
        ..EVERYTHING
    };
    for seed in [11, 12] {
        let plant = draw(kind, 1e-3, 1e-5, seed);
        let found = calibrated(&plant, 8.0).unwrap();
        let put_in = plant.resonance().unwrap();
        let resonance = found.value(Quantity::Resonance).expect("a resonance");
        assert!(
            (resonance / put_in - 1.0).abs() < 0.05,
            "{resonance} {put_in}"
        );
        let delay = plant.delay_plus_lag() * plant.period;
        assert!(deviations(&found, Quantity::DelayPlusLag, delay) < 3.5);
    }
}

#[allow(clippy::print_stdout)] // what was measured
fn check_low_resonances(frequencies: &[f64]) {
    for &hertz in frequencies {
        let plant = PlantParams {
            second_mass: 0.1,
            transmission_stiffness: (std::f64::consts::TAU * hertz).powi(2) / 20.0,
            transmission_damping: 0.2,
            hand_damping: 1.0,
            hand_stiffness: 60.0,
            ..PlantParams::bare(1e-3, 0.1)
        };
        let found = calibrated(&plant, 8.0).unwrap();
        let mass = found.value(Quantity::DeviceMass).unwrap();
        let resonance = found.value(Quantity::Resonance).expect("a resonance");
        println!("{hertz} Hz: {mass:.4} kg of 0.2, resonance {resonance:.2} Hz");
        assert!((mass / 0.2 - 1.0).abs() < 0.015, "{hertz} Hz: {mass} kg");
        assert!(
            (resonance / hertz - 1.0).abs() < 0.02,
            "{hertz} Hz: {resonance} Hz"
        );
    }
}

#[test]
fn a_resonance_of_35_hz_is_found_and_leaves_the_mass_right() {
    check_low_resonances(&[35.0]);
}

#[test]
#[ignore = "takes many seconds"]
fn a_resonance_down_to_35_hz_is_found_and_leaves_the_mass_right() {
    check_low_resonances(&[35.0, 40.0, 50.0, 60.0]);
}

#[test]
fn cogging_is_found_and_makes_the_delay_better_known() {
    let plant = PlantParams {
        cogging: 0.1,
        pitch: 0.003,
        hand_stiffness: 100.0,
        hand_damping: 2.0,
        ..PlantParams::bare(1e-3, 0.2)
    };
    let found = calibrated(&plant, 6.0).unwrap();
    assert!(deviations(&found, Quantity::DelayPlusLag, 0.5e-3) < 3.5);
    // Without cogging in the model the deviation is 0.057 periods, with it 0.011.
    let deviation = found.standard_deviation(Quantity::DelayPlusLag).unwrap();
    assert!(deviation < 0.02e-3, "{deviation}");
}

/// Lags beyond those of most motors: up to 4 ms they are found, and a longer one never yields a wrong value.
#[allow(clippy::print_stdout)] // what was measured
fn check_long_lags(lags: &[f64]) {
    for &lag in lags {
        let plant = PlantParams {
            lag,
            ..PlantParams::bare(1e-3, 0.2)
        };
        match calibrated(&plant, 6.0) {
            Ok(found) => {
                let delay = plant.delay_plus_lag() * plant.period;
                let off = deviations(&found, Quantity::DelayPlusLag, delay);
                let mass = deviations(
                    &found,
                    Quantity::DeviceMass,
                    plant.moved_mass() / plant.gain,
                );
                println!("lag {lag} s: {off:.2} and {mass:.2} deviations");
                assert!(off < 3.5 && mass < 3.5, "{lag}: {off} {mass}");
            }
            Err(declined) => {
                println!("lag {lag} s: {declined}");
                assert!(lag > 4e-3, "{lag}: {declined}");
            }
        }
    }
}

#[test]
fn a_long_lag_is_found_or_nothing_is_said() {
    check_long_lags(&[2e-3, 4e-3, 10e-3]);
}

#[test]
#[ignore = "takes half a minute"]
fn every_long_lag_is_found_or_nothing_is_said() {
    check_long_lags(&[1e-3, 2e-3, 3e-3, 4e-3, 6e-3, 10e-3]);
}

#[test]
fn delays_of_several_periods_are_found() {
    let plant = PlantParams {
        delay: 3.3,
        hand_stiffness: 100.0,
        hand_damping: 2.0,
        ..PlantParams::bare(1e-3, 0.2)
    };
    let found = calibrated(&plant, 4.0).unwrap();
    assert!(deviations(&found, Quantity::DelayPlusLag, 3.3e-3) < 3.5);
}

#[test]
fn the_force_is_bounded_begins_and_ends_softly_and_stays_in_the_box() {
    for mass in [0.08, 0.4] {
        let params = ExcitationParams::new(1e-3);
        let mut plant = Plant::new(PlantParams::bare(1e-3, mass), 1);
        let (excitation, _, forces) = excited(&params, &mut plant);
        assert_eq!(excitation.phase(), Phase::Done);
        assert_eq!(forces.len(), excitation.length());
        assert!(plant.excursion < params.excursion, "{}", plant.excursion);
        let largest = |range: std::ops::Range<usize>| {
            forces[range]
                .iter()
                .fold(0.0_f64, |largest, force| largest.max(force.abs()))
        };
        assert!((largest(0..forces.len()) - params.largest_force).abs() < 1e-12);
        assert_eq!(largest(0..500), 0.0);
        let of_first_steps = largest(500..530);
        assert!(of_first_steps > 0.0 && of_first_steps < 0.11 * params.largest_force);
        assert_eq!(largest(forces.len() - 100..forces.len()), 0.0);
    }
}

#[test]
fn it_stops_without_a_force_where_something_is_wrong() {
    type PositionOfSample = fn(usize) -> f64;
    let cases: [(&str, PositionOfSample); 4] = [
        ("a number", |_| f64::NAN),
        ("excursion", |i| 1e-4 * i as f64),
        ("tremor", |i| 0.004 * (i as f64 * 0.06).sin()),
        ("speed", |i| {
            if i < 700 {
                0.0
            } else {
                0.0095 - 0.019 * (i % 2) as f64 * (i / 7 % 2) as f64
            }
        }),
    ];
    for (name, motion) in cases {
        let params = ExcitationParams {
            excursion: 0.011,
            ..ExcitationParams::new(1e-3)
        };
        let mut excitation = Excitation::new(params).unwrap();
        let mut last = f64::NAN;
        for i in 0..2000 {
            last = excitation.next(motion(i));
            if excitation.phase() != Phase::Running {
                break;
            }
        }
        let Phase::Stopped(stop) = excitation.phase() else {
            panic!("{name}: {:?}", excitation.phase());
        };
        let is_right = match name {
            "a number" => matches!(stop, Stop::NotANumber),
            "excursion" => matches!(stop, Stop::Excursion { .. }),
            "tremor" => matches!(stop, Stop::Tremor { .. }),
            _ => matches!(stop, Stop::Speed { .. }),
        };
        assert!(is_right, "{name}: {stop}");
        assert_eq!(last, 0.0, "{name}");
        assert_eq!(excitation.next(0.0), 0.0, "{name}");
    }
}

#[test]
fn friction_near_to_the_force_is_declined_with_its_reason() {
    let stiff = PlantParams {
        coulomb: 0.42,
        hand_stiffness: 100.0,
        ..PlantParams::bare(1e-3, 0.2)
    };
    let declined = calibrated(&stiff, 6.0).unwrap_err();
    assert!(
        matches!(
            declined,
            Declined::Friction { .. } | Declined::Uncertain { .. }
        ),
        "{declined}"
    );
    let stuck = PlantParams {
        coulomb: 0.6,
        ..PlantParams::bare(1e-3, 0.2)
    };
    // It does not move at all.
    let params = ExcitationParams::new(1e-3);
    let (excitation, ..) = excited(&params, &mut Plant::new(stuck, 7));
    let phase = excitation.phase();
    let is_right = matches!(phase, Phase::Stopped(Stop::NoAnswer { .. }));
    assert!(is_right, "{phase:?}");
}

/// Friction and cogging are each below the force, and together above it: the device rocks in a cog of its motor on a
/// soft transmission. A naive fit yields a delay of 7 ms.
#[test]
fn a_device_that_a_cog_holds_is_declined_with_its_reason() {
    let cogged = PlantParams {
        second_mass: 0.2,
        transmission_stiffness: 39_500.0,
        transmission_damping: 2.6,
        delay: 0.53,
        lag: 0.000_22,
        viscous: 0.13,
        coulomb: 0.32,
        cogging: 0.36,
        pitch: 0.0066,
        quantum: 1e-5,
        ..PlantParams::bare(1e-3, 0.087)
    };
    let declined = calibrated(&cogged, 8.0).unwrap_err();
    assert!(matches!(declined, Declined::Held { .. }), "{declined}");
    assert!(declined.to_string().contains("--largest-force of 1.00 N"));
}

#[test]
fn parameters_out_of_range_are_named() {
    let params = ExcitationParams {
        duration: 1.0,
        ..ExcitationParams::new(1e-3)
    };
    let error = Excitation::new(params).unwrap_err().to_string();
    assert_eq!(error, "the duration is 1 s, but must be 2 to 120 s");
}

/// A dead encoder, with and without noise, from the beginning and from the middle on.
#[test]
fn a_position_that_does_not_answer_stops_the_force() {
    for (largest_force, most) in [(0.5, 1.5), (10.0, 0.5)] {
        for noise in [0.0, 2e-6] {
            for dies in [0, 3000] {
                let params = ExcitationParams {
                    largest_force,
                    duration: 8.0,
                    ..ExcitationParams::new(1e-3)
                };
                let mut excitation = Excitation::new(params).unwrap();
                let mut plant = Plant::new(
                    PlantParams {
                        noise,
                        quantum: 0.0,
                        hand_damping: 4.0 * largest_force,
                        ..PlantParams::bare(1e-3, 0.2)
                    },
                    7,
                );
                let (mut last, mut pushed) = (0.0, 0.0);
                for tick in 0.. {
                    let measured = plant.measured();
                    if tick <= dies {
                        last = measured;
                    }
                    let jitter = if noise > 0.0 {
                        noise * (tick % 3) as f64
                    } else {
                        0.0
                    };
                    let force = excitation.next(last + jitter);
                    plant.advance(force);
                    pushed += if tick > dies && force != 0.0 {
                        1e-3
                    } else {
                        0.0
                    };
                    if excitation.phase() != Phase::Running {
                        break;
                    }
                }
                let phase = excitation.phase();
                let is_right = matches!(phase, Phase::Stopped(Stop::NoAnswer { .. }));
                assert!(is_right, "{largest_force} N, {noise} m, {dies}: {phase:?}");
                assert!(
                    pushed < most,
                    "{largest_force} N, {noise} m, {dies}: {pushed} s"
                );
            }
        }
    }
}

#[test]
fn an_amplifier_that_saturates_is_named() {
    for saturation in [0.2, 0.35] {
        let plant = PlantParams {
            saturation,
            viscous: 0.3,
            ..PlantParams::bare(1e-3, 0.15)
        };
        let found = calibrated(&plant, 6.0);
        let Err(Declined::Saturated { level, .. }) = found else {
            panic!("{saturation} N: {found:?}");
        };
        assert!(
            (level / saturation - 1.0).abs() < 0.2,
            "{saturation} N: {level} N"
        );
    }
}

/// Whether the calibration declined, or its deviations cover the error of delay and mass.
#[test]
fn a_delay_that_changes_and_a_slow_transmission_are_not_taken_for_certain() {
    let bare = PlantParams {
        viscous: 0.3,
        ..PlantParams::bare(1e-3, 0.15)
    };
    for (at, later) in [(2.0, 0.5), (4.5, 1.0)] {
        let plant = PlantParams {
            jump: [at, later],
            ..bare
        };
        match calibrated(&plant, 6.0) {
            Err(Declined::Changed { first, second }) => assert!(second - first > 1e-4),
            Err(other) => panic!("{at} s, {later}: {other}"),
            Ok(found) => {
                let off = deviations(&found, Quantity::DelayPlusLag, plant.delay * 1e-3);
                assert!(off < 3.0, "{at} s, {later}: {off}");
            }
        }
    }
    // A transmission of 25 Hz is declined, or its deviations cover the error.
    let plant = PlantParams {
        second_mass: 0.1,
        transmission_stiffness: (std::f64::consts::TAU * 25.0).powi(2) / 20.0,
        transmission_damping: 0.2,
        hand_damping: 1.0,
        hand_stiffness: 60.0,
        ..PlantParams::bare(1e-3, 0.1)
    };
    if let Ok(found) = calibrated(&plant, 8.0) {
        let mass = found.value(Quantity::DeviceMass).unwrap();
        let deviation = found.standard_deviation(Quantity::DeviceMass).unwrap();
        assert!(
            (mass - 0.2).abs() < 3.0 * deviation,
            "{mass} kg +- {deviation}"
        );
        let off = deviations(&found, Quantity::DelayPlusLag, plant.delay * 1e-3);
        assert!(off < 3.5, "{off}");
    }
}
