//! The ideal of an object before a device on a recorded path.

use crate::common::{HEAVY_DEVICE, STIFF_CONTACT, WALL, assert_close, midpoint};
use palpate_testbed::driven::{DrivenIdeal, DrivenScene};
use palpate_testbed::grid::Grid;
use palpate_testbed::ideal::{Ideal, PointMassScene};
use palpate_testbed::recorded_path::{PathError, RecordedPath};

const OBJECT: DrivenScene = DrivenScene {
    stiffness: 400.0,
    object_mass: 0.1,
    virtual_force: -0.981,
    object_position: 0.03,
    object_velocity: 0.0,
};

const WALL_BEFORE_HAND: DrivenScene = DrivenScene {
    object_mass: f64::INFINITY,
    object_position: 0.012,
    ..OBJECT
};

/// A hand that moves up and down and trembles, recorded every 0.5 ms for 1.5 s.
fn hand() -> RecordedPath {
    let times: Vec<f64> = (0..=3000).map(|i| f64::from(i) * 0.0005).collect();
    let positions: Vec<f64> = times
        .iter()
        .map(|t| {
            0.02 * (2.3 * t).sin() + 0.004 * (19.0 * t + 0.4).sin() + 0.0002 * (63.0 * t).sin()
        })
        .collect();
    RecordedPath::new(&times, &positions).unwrap()
}

#[test]
fn it_agrees_with_a_fine_integration() {
    let path = hand();
    let stiff = DrivenScene {
        stiffness: 3000.0,
        virtual_force: 0.2,
        object_position: -0.002,
        object_velocity: -0.1,
        ..OBJECT
    };
    let varying = |sample: u32| 0.5 * (0.02 * f64::from(sample)).sin();
    for (scene, varying) in [
        (OBJECT, None),
        (stiff, None),
        (OBJECT, Some(varying)),
        (stiff, Some(varying)),
    ] {
        let added: Vec<f64> = varying.map_or(Vec::new(), |at| (0..=3000).map(at).collect());
        let driven = DrivenIdeal::pushed(scene, path.clone(), &added).unwrap();
        let step = 1e-6;
        let acceleration = |i: u32, t: f64, eta: f64| {
            let added = varying.map_or(0.0, |at| at(i / 500));
            (scene.virtual_force + added + scene.stiffness * (path.position(t) - eta).max(0.0))
                / scene.object_mass
        };
        let (mut eta, mut w) = (scene.object_position, scene.object_velocity);
        let mut worst = 0.0f64;
        let mut touched = false;
        for i in 0..1_500_000u32 {
            let t = f64::from(i) * step;
            if i % 777 == 0 {
                let exact = driven.at(t);
                touched |= exact.force_on_object > 0.0;
                worst = worst
                    .max((exact.object_position - eta).abs())
                    .max(0.05 * (exact.object_velocity - w).abs())
                    .max((exact.device_position - path.position(t)).abs());
            }
            w += 0.5 * step * acceleration(i, t, eta);
            eta += step * w;
            w += 0.5 * step * acceleration(i, t + step, eta);
        }
        assert!(touched);
        eprintln!("within {worst:e}");
        assert!(worst < 1e-8, "{worst:e}");
    }
}

#[test]
fn impulses_and_squares_agree_with_quadrature() {
    for scene in [OBJECT, WALL_BEFORE_HAND] {
        let driven = DrivenIdeal::new(scene, hand()).unwrap();
        let period = 0.01;
        let profile = driven.profile(period, 150).unwrap();
        assert!(!profile.collisions().is_empty());
        let force = |t: f64| driven.at(t).force_on_object;
        for i in 0..150 {
            let (from, to) = (f64::from(i) * period, f64::from(i + 1) * period);
            let index = usize::try_from(i).unwrap();
            let (j, q) = (profile.impulses()[index], profile.squared_forces()[index]);
            assert_close("J", j, midpoint(from, to, 4000, force), 1e-7);
            let square = midpoint(from, to, 4000, |t| force(t).powi(2));
            assert_close("Q", q, square, 1e-6);
        }
        let whole: f64 = profile.impulses().iter().sum();
        let of_collisions: f64 = profile.collisions().iter().map(|c| c.impulse).sum();
        assert_close("impulse", whole, of_collisions, 1e-12);
        for collision in profile.collisions() {
            let end = collision.end.unwrap_or(1.5);
            let highest = (0..=1000)
                .map(|i| force(collision.start + f64::from(i) * (end - collision.start) / 1000.0))
                .fold(0.0, f64::max);
            assert!(collision.peak_force >= highest - 1e-12);
            assert_close("peak", collision.peak_force, highest, 1e-2 * highest);
        }
    }
}

#[test]
fn impulse_is_momentum_and_the_wall_is_a_spring() {
    let driven = DrivenIdeal::new(OBJECT, hand()).unwrap();
    let profile = driven.profile(0.01, 150).unwrap();
    let whole: f64 = profile.impulses().iter().sum();
    let gained = 0.1 * driven.at(1.5).object_velocity + 0.981 * 1.5;
    assert_close("momentum", whole, gained, 1e-12);

    let wall = DrivenIdeal::new(WALL_BEFORE_HAND, hand()).unwrap();
    for i in 0..1000 {
        let at = wall.at(f64::from(i) * 1.49e-3);
        assert_eq!(at.object_position, 0.012);
        let spring = 400.0 * at.penetration().max(0.0);
        assert_close("spring", at.force_on_object, spring, 1e-11);
    }
}

#[test]
fn a_straight_path_is_a_device_of_unbounded_mass() {
    // However the line is cut into pieces, the object cannot tell.
    for (scene, velocity) in [(HEAVY_DEVICE, 0.12), (STIFF_CONTACT, -0.08), (WALL, 0.2)] {
        let scene = PointMassScene {
            device_mass: 1e15,
            user_force: 0.0,
            device_velocity: velocity,
            ..scene
        };
        let times: Vec<f64> = (0..=1000)
            .map(|i| f64::from(i) * 1e-3 + if i % 7 == 3 { 3.3e-4 } else { 0.0 })
            .collect();
        let positions: Vec<f64> = times
            .iter()
            .map(|t| scene.device_position + velocity * t)
            .collect();
        let driven = DrivenIdeal::new(
            DrivenScene {
                stiffness: scene.stiffness,
                object_mass: scene.object_mass,
                virtual_force: scene.virtual_force,
                object_position: scene.object_position,
                object_velocity: scene.object_velocity,
            },
            RecordedPath::new(&times, &positions).unwrap(),
        )
        .unwrap();
        let ideal = Ideal::new(scene).unwrap();
        let (given, expected) = (
            driven.profile(0.02, 50).unwrap(),
            ideal.profile(0.02, 50).unwrap(),
        );
        assert_eq!(given.collisions().len(), expected.collisions().len());
        assert!(!given.collisions().is_empty());
        for (given, expected) in given.collisions().iter().zip(expected.collisions()) {
            assert_close("start", given.start, expected.start, 1e-11);
            assert_eq!(given.end.is_some(), expected.end.is_some());
            let ends = (given.end.unwrap_or(0.0), expected.end.unwrap_or(0.0));
            assert_close("end", ends.0, ends.1, 1e-11);
            assert_close("impulse", given.impulse, expected.impulse, 1e-10);
            assert_close("peak", given.peak_force, expected.peak_force, 1e-8);
            assert_close("speed", given.impact_speed, expected.impact_speed, 1e-10);
        }
        for i in 0..50 {
            assert_close("J", given.impulses()[i], expected.impulses()[i], 1e-10);
            let squares = (given.squared_forces()[i], expected.squared_forces()[i]);
            assert_close("Q", squares.0, squares.1, 1e-9);
        }
    }
}

#[test]
fn a_path_need_not_start_at_zero() {
    let path = hand();
    let later: Vec<f64> = path.times().iter().map(|t| t + 64.0).collect();
    let later = RecordedPath::new(&later, path.positions()).unwrap();
    let (now, then) = (
        DrivenIdeal::new(OBJECT, path).unwrap(),
        DrivenIdeal::new(OBJECT, later).unwrap(),
    );
    let (now, then) = (
        now.profile(0.01, 150).unwrap(),
        then.profile(0.01, 150).unwrap(),
    );
    assert_eq!(then.start(), 64.0);
    for (a, b) in now.impulses().iter().zip(then.impulses()) {
        assert_close("J", *b, *a, 1e-9);
    }
}

#[test]
fn steps_of_the_last_digit_of_a_late_clock_come_to_an_end() {
    let late = 1.7e9f64;
    let times: Vec<f64> = (0..100u64)
        .map(|i| f64::from_bits(late.to_bits() + i))
        .collect();
    let positions: Vec<f64> = (0..100).map(|i| 0.031 + 1e-9 * f64::from(i)).collect();
    let stiff = DrivenScene {
        stiffness: 1e18,
        ..OBJECT
    };
    let path = RecordedPath::new(&times, &positions).unwrap();
    let driven = DrivenIdeal::new(stiff, path).unwrap();
    assert!(driven.at(late).is_finite());
}

#[test]
fn outside_the_path_nothing_is_invented() {
    let driven = DrivenIdeal::new(OBJECT, hand()).unwrap();
    assert_eq!(driven.profile(0.01, 151).unwrap_err().name, "intervals");
    assert_eq!(driven.profile(-0.01, 1).unwrap_err().name, "period");
    assert_eq!(driven.at(9.0), driven.at(1.5));
    assert_eq!(driven.at(-9.0), driven.at(0.0));
    assert_eq!(driven.at(f64::NAN), driven.at(0.0));
    let before = driven.at(1.5 - 1e-9).object_velocity;
    assert_close("velocity", driven.at(1.5).object_velocity, before, 1e-6);
}

#[test]
fn a_whole_multiple_of_the_recording_step_decimates_bit_for_bit() {
    let path = hand();
    for multiple in [1usize, 2, 3, 20, 40] {
        let period = 0.0005 * multiple as f64;
        let resampled = path.resample(period).unwrap();
        let decimated: Vec<f64> = path.positions().iter().copied().step_by(multiple).collect();
        assert_eq!(resampled.len(), 3000 / multiple + 1);
        for (given, recorded) in resampled.iter().zip(&decimated) {
            assert_eq!(given.to_bits(), recorded.to_bits());
        }
    }
    // Stamps as a file has them, with a start that binary fractions cannot hold.
    let times: Vec<f64> = (0..2000u32)
        .map(|i| format!("{}.{:04}", 17 + i / 2000, 5 * i).parse().unwrap())
        .collect();
    let positions: Vec<f64> = (0..2000).map(|i| f64::from(i).sin()).collect();
    let path = RecordedPath::new(&times, &positions).unwrap();
    for (i, given) in path.resample(0.01).unwrap().iter().enumerate() {
        assert_eq!(given.to_bits(), positions[20 * i].to_bits());
    }
}

#[test]
fn other_periods_interpolate() {
    let path = RecordedPath::new(&[1.0, 1.5, 2.5], &[0.0, 1.0, -1.0]).unwrap();
    assert_eq!(path.resample(0.3).unwrap().len(), 6);
    for (given, expected) in path
        .resample(0.3)
        .unwrap()
        .iter()
        .zip([0.0, 0.6, 0.8, 0.2, -0.4, -1.0])
    {
        assert_close("position", *given, expected, 1e-12);
    }
    assert_eq!(path.position(0.0), 0.0);
    assert_eq!(path.position(9.0), -1.0);
    assert_eq!(path.velocity(1.2), 2.0);
    assert_eq!(path.velocity(1.5), -2.0);
    assert_eq!(path.velocity(9.0), 0.0);
    assert_eq!(path.resample(0.0).unwrap_err().name, "period");
    assert_eq!(path.resample(1e-9).unwrap_err().name, "period");
    assert_eq!(path.resample(5.0).unwrap(), [0.0]);
}

#[test]
fn a_broken_recording_says_where() {
    for (times, positions, expected) in [
        (
            &[0.0][..],
            &[1.0][..],
            "a path needs at least two samples, not 1",
        ),
        (&[0.0, 1.0], &[1.0], "2 times but 1 positions"),
        (
            &[0.0, 1.0, 1.0],
            &[1.0, 1.0, 1.0],
            "time 1 s at index 2 is not after 1 s",
        ),
        (
            &[0.0, f64::NAN],
            &[1.0, 1.0],
            "time NaN s at index 1 is not finite",
        ),
        (
            &[0.0, 1.0],
            &[1.0, f64::INFINITY],
            "position inf m at index 1 is not finite",
        ),
    ] {
        let error: PathError = RecordedPath::new(times, positions).unwrap_err();
        assert_eq!(error.to_string(), expected);
    }
    let error = DrivenIdeal::new(
        DrivenScene {
            stiffness: -1.0,
            ..OBJECT
        },
        hand(),
    );
    assert_eq!(error.unwrap_err().name, "stiffness");
}

#[test]
fn on_a_grid_of_its_own_it_is_the_same_force() {
    let ideal = DrivenIdeal::new(OBJECT, hand()).unwrap();
    let even = ideal.profile(0.01, 150).unwrap();
    // Every third instant is missing: two intervals in one.
    let kept: Vec<usize> = (0..=150).filter(|i| i % 3 != 1).collect();
    let edges: Vec<f64> = kept.iter().map(|&i| even.grid().edge(i)).collect();
    let grid = Grid::cut_at(edges, 0.01).unwrap();
    let cut = ideal.profile_on(grid).unwrap();
    for (interval, ends) in kept.windows(2).enumerate() {
        let sum = |values: &[f64]| values[ends[0]..ends[1]].iter().sum::<f64>();
        assert_close("J", cut.impulses()[interval], sum(even.impulses()), 1e-15);
        let squared = sum(even.squared_forces());
        assert_close("Q", cut.squared_forces()[interval], squared, 1e-14);
    }
    for (edges, name) in [([-0.1, 1.0], "grid start"), ([0.0, 1.6], "grid end")] {
        let outside = Grid::cut_at(edges.to_vec(), 0.01).unwrap();
        assert_eq!(ideal.profile_on(outside).unwrap_err().name, name);
    }
}
