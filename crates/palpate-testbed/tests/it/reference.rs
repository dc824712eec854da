//! The integrated ideal against the exact one, which a point mass has.
#![allow(clippy::print_stdout)] // what was measured

use palpate_testbed::device::{DevicePlant, PointMass};
use palpate_testbed::ideal::{Ideal, PointMassScene};
use palpate_testbed::reference::{Reference, ReferenceError, ReferenceScene, Stop, integrate};

const SCENES: [(f64, f64, f64, f64, usize, f64); 4] = [
    // period, device mass, object mass, stiffness, collisions, gap
    (0.01, 0.1, 0.1, 100.0, 3, 0.1),
    (0.02, 0.25, 0.1, 100.0, 3, 0.05),
    (0.02, 0.25, 0.1, 400.0, 6, 0.05),
    (0.001, 0.25, f64::INFINITY, 1000.0, 3, 0.002),
];

fn both(scene: usize, steps_per_period: usize) -> (Ideal, Reference) {
    let (period, device_mass, object_mass, stiffness, collisions, gap) = SCENES[scene];
    let exact = Ideal::new(PointMassScene {
        stiffness,
        device_mass,
        object_mass,
        user_force: 1.0,
        virtual_force: -0.981,
        device_position: 0.0,
        device_velocity: 0.0,
        object_position: gap,
        object_velocity: 0.0,
    })
    .unwrap();
    let integrated = integrate(
        &PointMass::new(device_mass, 1.0).unwrap(),
        &ReferenceScene {
            stiffness,
            object_mass,
            virtual_force: -0.981,
            object_position: gap,
            object_velocity: 0.0,
            period,
            steps_per_period,
        },
        Stop::AfterCollisions(collisions),
    )
    .unwrap();
    (exact, integrated)
}

/// Largest error of an interval's impulse, relative to the largest impulse.
fn worst_impulse(scene: usize, steps_per_period: usize) -> f64 {
    let (exact, integrated) = both(scene, steps_per_period);
    let (period, .., collisions, _) = SCENES[scene];
    let intervals = exact.window(collisions, period).unwrap();
    assert_eq!(integrated.profile.intervals(), intervals);
    let exact = exact.profile(period, intervals).unwrap();
    let largest = exact.impulses().iter().fold(0.0_f64, |a, b| a.max(*b));
    let pairs = exact.impulses().iter().zip(integrated.profile.impulses());
    pairs.fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs())) / largest
}

#[test]
fn its_force_is_the_exact_one_and_the_error_falls_with_the_square_of_the_step() {
    for scene in 0..SCENES.len() {
        let (coarse, fine) = (worst_impulse(scene, 200), worst_impulse(scene, 2000));
        println!("scene {scene}: {coarse:.1e} at 200 steps, {fine:.1e} at 2000");
        assert!(fine < 2e-6, "scene {scene}: {fine}");
        assert!(
            fine < coarse / 30.0,
            "scene {scene}: {fine} of {coarse} is not second order"
        );
    }
}

#[test]
fn squared_force_collisions_and_states_are_the_exact_ones() {
    for (scene, &(period, .., wanted, _)) in SCENES.iter().enumerate() {
        let (exact, integrated) = both(scene, 2000);
        let intervals = integrated.profile.intervals();
        let profile = exact.profile(period, intervals).unwrap();
        let sum = |squares: &[f64]| squares.iter().sum::<f64>();
        let (a, b) = (
            sum(profile.squared_forces()),
            sum(integrated.profile.squared_forces()),
        );
        assert!((a / b - 1.0).abs() < 1e-6, "scene {scene}: {a} {b}");
        let moments = profile.moments().iter().zip(integrated.profile.moments());
        let largest = profile.impulses().iter().fold(0.0_f64, |a, b| a.max(*b)) * period;
        let off = moments.fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs()));
        assert!(off < 2e-6 * largest, "scene {scene}: {off} of {largest}");
        let pairs = profile
            .collisions()
            .iter()
            .zip(integrated.profile.collisions());
        assert!(pairs.len() >= wanted);
        for (a, b) in pairs.take(wanted) {
            let near = |x: f64, y: f64, scale: f64| (x - y).abs() < 3e-6 * scale;
            assert!(near(a.start, b.start, 1.0), "scene {scene}: {a:?} {b:?}");
            assert!(near(a.end.unwrap(), b.end.unwrap(), 1.0));
            assert!(near(a.impulse, b.impulse, a.impulse), "{a:?} {b:?}");
            assert!(near(a.peak_force, b.peak_force, a.peak_force));
            // Known to a step's acceleration.
            assert!((a.impact_speed / b.impact_speed - 1.0).abs() < 1e-3);
            let speeds = (a.release_speed.unwrap(), b.release_speed.unwrap());
            assert!((speeds.0 / speeds.1 - 1.0).abs() < 1e-5, "{speeds:?}");
            // Without losses they part as fast as they met.
            assert!((speeds.0 / a.impact_speed - 1.0).abs() < 1e-9, "{a:?}");
        }
        for at in &integrated.record {
            let exact = exact.at(at.time);
            assert!((exact.device_position - at.device_position).abs() < 1e-6);
            assert!((exact.object_position - at.object_position).abs() < 1e-6);
        }
    }
}

#[test]
fn the_contact_creates_no_energy_however_long_the_step() {
    // 20 steps a period is so coarse that the motion is off; the energy is not.
    let (exact, integrated) = both(2, 20);
    let start = exact.energy(&integrated.record[0]);
    for at in &integrated.record {
        assert!((exact.energy(at) - start).abs() < 1e-12, "{at:?}");
    }
}

#[test]
fn what_cannot_be_integrated_is_refused_by_value() {
    let device = PointMass::new(0.25, -1.0).unwrap();
    let scene = ReferenceScene {
        stiffness: 100.0,
        object_mass: f64::INFINITY,
        virtual_force: 0.0,
        object_position: 0.05,
        object_velocity: 0.0,
        period: 0.02,
        steps_per_period: 20,
    };
    let refused = |scene: ReferenceScene, stop| integrate(&device, &scene, stop).unwrap_err();
    // The hand pulls away from the wall.
    let too_few = refused(scene, Stop::AfterCollisions(1));
    assert_eq!(
        too_few,
        ReferenceError::TooFewCollisions { asked: 1, found: 0 }
    );
    assert_eq!(
        too_few.to_string(),
        "collisions = 1 is not allowed; allowed: at most the number within 2000 periods"
    );
    let none = refused(scene, Stop::AfterCollisions(0));
    assert_eq!(none, ReferenceError::NoCollisions);
    let bad = |change: fn(&mut ReferenceScene)| {
        let mut scene = scene;
        change(&mut scene);
        match refused(scene, Stop::AfterPeriods(1)) {
            ReferenceError::Scene(error) => error.name,
            other => panic!("{other}"),
        }
    };
    assert_eq!(bad(|s| s.stiffness = 0.0), "stiffness");
    assert_eq!(bad(|s| s.object_mass = -1.0), "object_mass");
    assert_eq!(bad(|s| s.period = f64::NAN), "period");
    assert_eq!(bad(|s| s.steps_per_period = 30), "steps_per_period");
    assert_eq!(bad(|s| s.virtual_force = f64::NAN), "virtual_force");
    assert!(device.position() == 0.0);
}
