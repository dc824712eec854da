//! The ideal of a point-mass scene.

use crate::common::{
    ALL_SCENES, BEGINS_INSIDE, COASTING, FALLING_BLOCK, HEAVY_DEVICE, REPELLED, STIFF_CONTACT,
    WALL, assert_close, midpoint, simpson, verlet,
};
use palpate_testbed::ideal::{Ideal, PointMassScene};

fn ideal(scene: PointMassScene) -> Ideal {
    Ideal::new(scene).unwrap()
}

#[test]
fn it_agrees_with_a_fine_integration() {
    for (name, scene) in ALL_SCENES {
        let ideal = ideal(scene);
        let mut worst = 0.0f64;
        for stepped in verlet(&scene, 1e-6, 1000, 800) {
            let exact = ideal.at(stepped.time);
            for (given, expected) in [
                (exact.device_position, stepped.device_position),
                (exact.object_position, stepped.object_position),
                (0.1 * exact.device_velocity, 0.1 * stepped.device_velocity),
                (0.1 * exact.object_velocity, 0.1 * stepped.object_velocity),
                (
                    exact.force_on_object / scene.stiffness,
                    stepped.force_on_object / scene.stiffness,
                ),
            ] {
                worst = worst.max((given - expected).abs());
            }
        }
        eprintln!("{name}: within {worst:e}");
        assert!(worst < 2e-9, "{name}: {worst:e}");
    }
}

#[test]
fn its_energy_never_changes() {
    for (name, scene) in ALL_SCENES {
        let ideal = ideal(scene);
        let start = ideal.energy(&ideal.at(0.0));
        for i in 0..3000 {
            let energy = ideal.energy(&ideal.at(f64::from(i) * 1.1e-3));
            assert_close(name, energy, start, 1e-12);
        }
    }
}

#[test]
fn energy_is_stored_in_the_spring_only_during_contact() {
    let ideal = ideal(FALLING_BLOCK);
    let start = ideal.energy(&ideal.at(0.0));
    let in_flight = ideal.energy_without_spring(&ideal.at(0.3));
    let in_contact = ideal.energy_without_spring(&ideal.at(0.141));
    assert_close("flight", in_flight, start, 1e-14);
    assert!(in_contact < start - 0.05, "{in_contact} {start}");
}

#[test]
fn collisions_of_the_paper_begin_and_end_where_a_stepped_model_puts_them() {
    // Instants and peak forces of a model of the same scenes in steps of 1e-5 s. It gained the
    // stated share of its energy in 2 s, so its flights grow longer: by up to share t²/8 at t.
    struct Stepped {
        scene: PointMassScene,
        collisions: &'static [(usize, f64, f64)],
        half_digit: f64,
        energy_gain: f64,
        peak_force: f64,
    }
    for stepped in [
        Stepped {
            scene: FALLING_BLOCK,
            collisions: &[(0, 0.101, 0.181), (1, 0.383, 0.463), (2, 0.665, 0.745)],
            half_digit: 5e-4,
            energy_gain: 0.005,
            peak_force: 5.52,
        },
        Stepped {
            scene: HEAVY_DEVICE,
            collisions: &[
                (0, 0.0851, 0.1853),
                (1, 0.3556, 0.4558),
                (2, 0.6260, 0.7263),
            ],
            half_digit: 5e-5,
            energy_gain: 0.003,
            peak_force: 4.28,
        },
        Stepped {
            scene: STIFF_CONTACT,
            collisions: &[(0, 0.0851, 0.1312), (5, 1.1676, 1.2138)],
            half_digit: 5e-5,
            energy_gain: 0.006,
            peak_force: 7.36,
        },
    ] {
        let ideal = ideal(stepped.scene);
        let profile = ideal.profile(0.01, 130).unwrap();
        for &(index, start, end) in stepped.collisions {
            let collision = profile.collisions()[index];
            let tolerance = |t: f64| stepped.half_digit + 1e-5 + stepped.energy_gain * t * t / 8.0;
            let exact_end = collision.end.unwrap();
            assert_close("start", collision.start, start, tolerance(start));
            assert_close("end", exact_end, end, tolerance(end));
            let peak = stepped.peak_force;
            let tolerance = 0.005 + 0.5 * stepped.energy_gain * peak;
            assert_close("peak", collision.peak_force, peak, tolerance);
            let counted = ideal.end_of_collision(index + 1).unwrap();
            assert_close("end", counted, exact_end, 1e-13);
        }
    }
}

#[test]
fn a_collision_knows_its_impact() {
    let ideal = ideal(FALLING_BLOCK);
    let profile = ideal.profile(0.01, 75).unwrap();
    let [first, ..] = profile.collisions() else {
        panic!("no collision")
    };
    assert_close(
        "speed",
        first.impact_speed,
        (2.0f64 * 19.62 * 0.1).sqrt(),
        1e-15,
    );
    // All of the height's energy M g h, as the device hangs in balance.
    assert_close("energy", ideal.impact_energy(first), 0.0981, 1e-15);
    // The peak from the energy of the relative motion: ω² p²/2 − a p = v²/2
    let (a, w2) = (19.62f64, 2000.0);
    let peak = 100.0 * (a + (a * a + w2 * first.impact_speed.powi(2)).sqrt()) / w2;
    assert_close("peak", first.peak_force, peak, 1e-13);
    // Reversal of the relative velocity plus what gravity adds meanwhile.
    let contact = first.end.unwrap() - first.start;
    let impulse = (2.0 * first.impact_speed + a * contact) / 20.0;
    assert_close("impulse", first.impulse, impulse, 1e-14);
}

#[test]
fn windows_of_the_paper() {
    for (scene, period, collisions, window) in [
        (FALLING_BLOCK, 0.01, 3, 75),
        (HEAVY_DEVICE, 0.02, 3, 37),
        (STIFF_CONTACT, 0.02, 6, 62),
    ] {
        assert_eq!(ideal(scene).window(collisions, period), Some(window));
    }
}

#[test]
fn a_collision_that_does_not_come_has_no_end() {
    for scene in [REPELLED, COASTING] {
        let ideal = ideal(scene);
        assert!(ideal.end_of_collision(1).is_some());
        assert_eq!(ideal.end_of_collision(2), None);
        assert_eq!(ideal.window(2, 0.01), None);
        assert_eq!(ideal.profile(0.01, 500).unwrap().collisions().len(), 1);
    }
    let ideal_apart = ideal(PointMassScene {
        device_velocity: -0.1,
        ..COASTING
    });
    assert_eq!(ideal_apart.end_of_collision(1), None);
    // Counting starts at one, and a bad period has no window.
    assert_eq!(ideal(WALL).end_of_collision(0), None);
    for period in [0.0, -0.01, f64::NAN, f64::INFINITY] {
        assert_eq!(ideal(WALL).window(1, period), None);
    }
    // Pressed on a wall from rest at the surface.
    let pressed = ideal(PointMassScene {
        device_position: 0.02,
        device_velocity: 0.0,
        ..WALL
    });
    assert_eq!(pressed.end_of_collision(1), None);
    assert_eq!(pressed.profile(0.01, 500).unwrap().collisions().len(), 1);
}

#[test]
fn a_contact_present_at_the_start_is_the_first_collision() {
    let ideal = ideal(BEGINS_INSIDE);
    let profile = ideal.profile(0.02, 40).unwrap();
    let first = profile.collisions()[0];
    assert_eq!(first.start, 0.0);
    assert_eq!(ideal.end_of_collision(1), first.end);
    // Kinetic and spring energy together.
    let reduced = 1.0 / (1.0 / 0.25 + 1.0 / 0.1);
    let energy = 0.5 * reduced * 0.4 * 0.4 + 0.5 * 100.0 * 0.015 * 0.015;
    assert_close("energy", ideal.impact_energy(&first), energy, 1e-15);
    // The second, which begins at the surface, is longer by the part that was missing.
    let second = profile.collisions()[1];
    assert!(second.end.unwrap() - second.start > first.end.unwrap());
}

#[test]
fn impulses_moments_and_squares_agree_with_quadrature() {
    for (name, scene) in ALL_SCENES {
        let ideal = ideal(scene);
        let period = 0.02;
        let profile = ideal.profile(period, 40).unwrap();
        let force = |t: f64| ideal.at(t).force_on_object;
        for i in 0..profile.intervals() {
            let (from, to) = (i as f64 * period, (i + 1) as f64 * period);
            let (j, q) = (profile.impulses()[i], profile.squared_forces()[i]);
            assert_close(name, j, midpoint(from, to, 2000, force), 1e-7);
            let square = midpoint(from, to, 2000, |t| force(t).powi(2));
            assert_close(name, q, square, 1e-7);
            let lever = |t: f64| force(t) * (t - 0.5 * (from + to));
            let moment = midpoint(from, to, 2000, lever);
            assert_close(name, profile.moments()[i], moment, 1e-7 * period);
        }
        for collision in profile.collisions() {
            if let Some(end) = collision.end {
                // Smooth between the events, so Simpson's rule reaches round-off.
                let j = simpson(collision.start, end, 2000, force);
                assert_close(name, collision.impulse, j, 1e-12);
            }
        }
    }
}

#[test]
fn evaluation_reaches_far_and_stays_finite() {
    for (name, scene) in ALL_SCENES {
        let ideal = ideal(scene);
        for time in [1e3, 1e6, 1e12] {
            assert!(ideal.at(time).is_finite(), "{name} at {time}");
        }
        for time in [f64::NAN, f64::INFINITY, -1.0] {
            assert_eq!(ideal.at(time), ideal.at(0.0));
        }
    }
    // A million collisions later the event of closed form is still where repetition puts it.
    let ideal = ideal(STIFF_CONTACT);
    let end = ideal.end_of_collision(1_000_000).unwrap();
    assert!(ideal.at(end - 1e-4).force_on_object > 0.0);
    assert_eq!(ideal.at(end + 1e-4).force_on_object, 0.0);
}

#[test]
fn a_wall_ignores_the_virtual_force_and_stays() {
    let without = ideal(PointMassScene {
        virtual_force: 0.0,
        ..WALL
    });
    for i in 0..200 {
        let time = f64::from(i) * 5e-3;
        assert_eq!(ideal(WALL).at(time), without.at(time));
        assert_eq!(without.at(time).object_position, WALL.object_position);
        assert_eq!(without.at(time).object_velocity, 0.0);
    }
}

#[test]
fn a_very_heavy_object_is_a_wall() {
    let heavy = ideal(PointMassScene {
        object_mass: 1e12,
        virtual_force: 0.0,
        ..WALL
    });
    for i in 0..200 {
        let time = f64::from(i) * 5e-3;
        let (given, wall) = (heavy.at(time), ideal(WALL).at(time));
        assert_close("device", given.device_position, wall.device_position, 1e-10);
        assert_close("force", given.force_on_object, wall.force_on_object, 1e-7);
    }
}

#[test]
fn a_rejected_field_is_named() {
    let cases: [(&str, PointMassScene); 6] = [
        (
            "stiffness",
            PointMassScene {
                stiffness: 0.0,
                ..WALL
            },
        ),
        (
            "device_mass",
            PointMassScene {
                device_mass: f64::INFINITY,
                ..WALL
            },
        ),
        (
            "object_mass",
            PointMassScene {
                object_mass: f64::NAN,
                ..WALL
            },
        ),
        (
            "object_velocity",
            PointMassScene {
                object_velocity: 0.1,
                ..WALL
            },
        ),
        (
            "user_force",
            PointMassScene {
                user_force: f64::NAN,
                ..WALL
            },
        ),
        (
            "object_position",
            PointMassScene {
                object_position: f64::INFINITY,
                ..WALL
            },
        ),
    ];
    for (name, scene) in cases {
        assert_eq!(Ideal::new(scene).unwrap_err().name, name);
    }
    assert_eq!(ideal(WALL).profile(0.0, 3).unwrap_err().name, "period");
}
