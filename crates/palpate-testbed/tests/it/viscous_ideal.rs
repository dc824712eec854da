//! The ideal with viscous friction, against the closed form without and the integrated one with it.

use palpate_testbed::hand::Hand;
use palpate_testbed::held_mass::HeldMass;
use palpate_testbed::ideal::{Ideal, PointMassScene};
use palpate_testbed::reference::{ReferenceScene, Stop, integrate};
use palpate_testbed::viscous_ideal::ViscousIdeal;

const PERIOD: f64 = 0.02;

fn scene(stiffness: f64, object_mass: f64) -> PointMassScene {
    PointMassScene {
        stiffness,
        device_mass: 0.25,
        object_mass,
        user_force: 1.0,
        virtual_force: if object_mass.is_finite() {
            -9.81 * object_mass
        } else {
            0.0
        },
        device_position: 0.0,
        device_velocity: 0.0,
        object_position: 0.05,
        object_velocity: 0.0,
    }
}

/// Largest difference of two lists, over the largest entry of the second.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let largest = b.iter().fold(0.0_f64, |largest, b| largest.max(b.abs()));
    let error = |(a, b): (&f64, &f64)| (a - b).abs() / largest;
    a.iter().zip(b).map(error).fold(0.0, f64::max)
}

#[test]
fn without_friction_it_is_the_closed_form() {
    for (stiffness, object_mass) in [
        (100.0, 0.1),
        (0.6, 250.0),
        (6000.0, 0.01),
        (3.0, 1e-4),
        (2e4, f64::INFINITY),
    ] {
        let scene = scene(stiffness, object_mass);
        let exact = Ideal::new(scene).unwrap();
        let window = exact.window(5, PERIOD).unwrap();
        let expected = exact.profile(PERIOD, window).unwrap();
        let found = ViscousIdeal::new(&scene, 0.0, PERIOD, window).unwrap();
        let by_impulse = difference(found.profile.impulses(), expected.impulses());
        let by_square = difference(found.profile.squared_forces(), expected.squared_forces());
        assert!(
            by_impulse < 1e-9,
            "{stiffness}, {object_mass}: {by_impulse}"
        );
        assert!(by_square < 1e-9, "{stiffness}, {object_mass}: {by_square}");
        let by_moment = difference(found.profile.moments(), expected.moments());
        assert!(by_moment < 1e-8, "{stiffness}, {object_mass}: {by_moment}");
        let collisions = found.profile.collisions();
        assert_eq!(collisions.len(), expected.collisions().len());
        for (a, b) in collisions.iter().zip(expected.collisions()) {
            assert!((a.start - b.start).abs() < 1e-9, "{a:?} {b:?}");
            assert!(
                (a.peak_force / b.peak_force - 1.0).abs() < 1e-8,
                "{a:?} {b:?}"
            );
            assert!((a.impact_speed / b.impact_speed - 1.0).abs() < 1e-8);
            assert_eq!(a.end.is_some(), b.end.is_some());
            assert_eq!(a.release_speed.is_some(), b.release_speed.is_some());
            if let (Some(a), Some(b)) = (a.release_speed, b.release_speed) {
                assert!((a / b - 1.0).abs() < 1e-8, "{a} {b}");
            }
        }
        let end = exact.at(window as f64 * PERIOD);
        let last = found.record.last().unwrap();
        assert!(
            (last.device_position - end.device_position).abs() < 1e-8,
            "{last:?} {end:?}"
        );
        assert!((last.object_velocity - end.object_velocity).abs() < 1e-8);
    }
}

#[test]
fn with_friction_it_is_where_the_integrated_ideal_converges_to() {
    for (stiffness, object_mass, friction) in [
        (100.0, 0.1, 0.5),
        (400.0, 1.0, 3.0),
        (1000.0, f64::INFINITY, 0.04),
    ] {
        let scene = scene(stiffness, object_mass);
        let window = 60;
        let found = ViscousIdeal::new(&scene, friction, PERIOD, window).unwrap();
        let hand = Hand::ConstantForce {
            force: 1.0,
            tremor: None,
        };
        let device = HeldMass::new(0.25, hand)
            .and_then(|device| device.with_friction(friction, 0.0))
            .unwrap();
        let mut errors = [0.0; 2];
        for (error, steps) in errors.iter_mut().zip([1000, 2000]) {
            let object = ReferenceScene {
                stiffness,
                object_mass,
                virtual_force: scene.virtual_force,
                object_position: 0.05,
                object_velocity: 0.0,
                period: PERIOD,
                steps_per_period: steps,
            };
            let reference = integrate(&device, &object, Stop::AfterPeriods(window)).unwrap();
            *error = difference(found.profile.impulses(), reference.profile.impulses());
        }
        assert!(errors[1] < 1e-4, "{errors:?}");
        // Half the step, about a quarter of the difference: it belongs to the integration.
        assert!(errors[1] < 0.4 * errors[0], "{errors:?}");
    }
}

#[test]
fn friction_lets_an_object_come_to_rest_on_a_wall() {
    let ideal = ViscousIdeal::new(&scene(100.0, f64::INFINITY), 2.0, PERIOD, 2000).unwrap();
    let last = ideal.record.last().unwrap();
    assert!((last.force_on_object - 1.0).abs() < 1e-9, "{last:?}");
    assert!(last.device_velocity.abs() < 1e-9);
    let open = ideal.profile.collisions().last().unwrap();
    assert_eq!(open.end, None);
}

#[test]
fn what_cannot_be_is_named() {
    let name = |friction, period| {
        ViscousIdeal::new(&scene(100.0, 0.1), friction, period, 10)
            .unwrap_err()
            .name
    };
    assert_eq!(name(-1.0, PERIOD), "friction");
    assert_eq!(name(0.1, 0.0), "period");
    assert_eq!(name(0.1, 1e4), "period");
}
