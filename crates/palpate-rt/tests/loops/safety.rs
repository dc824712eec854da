//! Safety by itself: what it lets through.

use palpate_rt::safety::{OscillationParams, Rendered, Safety, SafetyParams, Trip};

/// A fresh sample a millisecond after the last.
fn sample(position: [f64; 3], force: f64) -> Rendered {
    Rendered {
        elapsed: Some(0.001),
        position,
        coordinate: position[0],
        force,
        created_energy: 0.0,
        refused: false,
        stalled: false,
    }
}

fn safety() -> Safety {
    let limits = SafetyParams {
        workspace: Some([[-1.0, -2.0, -3.0], [1.0, 2.0, 3.0]]),
        largest_speed: f64::INFINITY,
        soft_start: 0.0,
        ..SafetyParams::default()
    };
    Safety::new(limits, 0.001).unwrap()
}

const HERE: [f64; 3] = [0.0; 3];

#[test]
fn a_force_that_is_no_number_is_none() {
    for force in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut safety = safety();
        assert_eq!(safety.judge(&sample(HERE, 1.0)).force, 1.0);
        let verdict = safety.judge(&sample(HERE, force));
        assert_eq!(verdict.force, 0.0);
        assert_eq!(verdict.tripped, Some(Trip::NotANumber));
        assert_eq!(safety.judge(&sample(HERE, 1.0)).force, 1.0);
    }
}

#[test]
fn the_box_has_six_sides() {
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let extent = axis as f64 + 1.0;
            let mut position = HERE;
            position[axis] = sign * extent;
            let mut safety = safety();
            assert_eq!(safety.judge(&sample(position, 1.0)).force, 1.0);
            position[axis] = sign * (extent + 1e-9);
            let verdict = safety.judge(&sample(position, 1.0));
            assert_eq!(verdict.force, 0.0);
            assert_eq!(verdict.tripped, Some(Trip::OutsideWorkspace));
        }
    }
}

#[test]
fn the_range_lies_along_the_axis_of_the_contact() {
    let limits = SafetyParams {
        range: Some([-0.01, 0.02]),
        largest_speed: f64::INFINITY,
        soft_start: 0.0,
        ..SafetyParams::default()
    };
    for (coordinate, is_inside) in [
        (-0.0101, false),
        (-0.01, true),
        (0.02, true),
        (0.0201, false),
    ] {
        let mut safety = Safety::new(limits, 0.001).unwrap();
        // Wherever it is in the device's own frame.
        let verdict = safety.judge(&Rendered {
            coordinate,
            ..sample([0.3, -0.2, 0.1], 1.0)
        });
        assert_eq!(verdict.force == 1.0, is_inside, "{coordinate}");
        let trip = (!is_inside).then_some(Trip::OutsideWorkspace);
        assert_eq!(verdict.tripped, trip, "{coordinate}");
    }
}

#[test]
fn of_two_trips_the_one_that_stays_is_kept() {
    let mut safety = safety();
    safety.judge(&sample([f64::NAN; 3], 1.0));
    assert_eq!(safety.trip(), Some(Trip::NotANumber));
    let outside = safety.judge(&sample([9.0; 3], 1.0));
    assert_eq!(outside.tripped, Some(Trip::OutsideWorkspace));
    // One that passes does not take its place, and its passing lifts nothing.
    assert_eq!(safety.trip_on(Trip::Stalled).tripped, None);
    safety.missing();
    safety.missing();
    assert_eq!(safety.judge(&sample(HERE, 1.0)).force, 0.0);
    assert_eq!(safety.trip(), Some(Trip::OutsideWorkspace));
}

#[test]
fn missing_samples_that_do_not_follow_each_other_do_not_add_up() {
    let mut safety = safety();
    for _ in 0..5 {
        assert_eq!(safety.judge(&sample(HERE, 1.0)).force, 1.0);
        assert_eq!(safety.missing().force, 1.0);
    }
    assert_eq!(safety.trip(), None);
    assert_eq!(safety.missing().force, 0.0);
    assert_eq!(safety.trip(), Some(Trip::StaleSample));
}

/// A millijoule each 10 ms fades as fast as it comes; the same at once does not.
#[test]
fn created_energy_counts_for_a_while_only() {
    let limits = SafetyParams {
        oscillation: OscillationParams {
            energy: 0.05,
            window: 0.2,
        },
        // While a force comes in, what it creates does not count.
        soft_start: 0.0,
        ..SafetyParams::default()
    };
    let created = |period: f64| {
        let mut safety = Safety::new(limits, period).unwrap();
        (1..=200).find(|number| {
            safety.judge(&Rendered {
                elapsed: Some(period),
                created_energy: 1e-3 * f64::from(*number),
                ..sample(HERE, 1.0)
            });
            safety.trip() == Some(Trip::Oscillation)
        })
    };
    assert_eq!(created(0.01), None);
    let number = created(1e-6).unwrap();
    assert!((50..=52).contains(&number), "{number}");
}
