//! Along one axis, a world is what the one-dimensional ideals solve in closed form.

use palpate_testbed::ideal::{Ideal, PointMassScene};
use palpate_testbed::profile::{ForceProfile, Snapshot};
use palpate_testbed::viscous_ideal::ViscousIdeal;
use palpate_testbed::world::{ContactLaw, Member, Shape, WorldIdeal, WorldScene};

use super::{body, device, half_space, motion, pair, solve};

const RADIUS: f64 = 0.03;
const PERIOD: f64 = 0.004;
const INTERVALS: usize = 150;

fn scene() -> PointMassScene {
    PointMassScene {
        stiffness: 400.0,
        device_mass: 0.12,
        object_mass: 0.08,
        user_force: 0.981,
        virtual_force: -0.7,
        device_position: -0.001,
        device_velocity: 0.2,
        object_position: 0.004,
        object_velocity: -0.3,
    }
}

/// The same along the z axis; the object is a ball whose lowest point is at its position, or a plane.
fn world(scene: &PointMassScene) -> WorldScene {
    let mut device = device(scene.device_mass, [0.0, 0.0, scene.device_position]);
    device.velocity[2] = scene.device_velocity;
    device.hand.force[2] = scene.user_force;
    let object = if scene.object_mass.is_finite() {
        let position = [0.0, 0.0, scene.object_position + RADIUS];
        let mut ball = body(
            Shape::Sphere { radius: RADIUS },
            scene.object_mass,
            position,
        );
        motion(&mut ball).velocity[2] = scene.object_velocity;
        motion(&mut ball).force[2] = scene.virtual_force;
        ball
    } else {
        half_space([0.0, 0.0, -1.0], -scene.object_position)
    };
    let law = ContactLaw::spring(scene.stiffness);
    WorldScene {
        joints: Vec::new(),
        fields: Vec::new(),
        devices: vec![device],
        bodies: vec![object],
        pairs: vec![pair(Member::Body(0), Member::Device(0), law)],
    }
}

/// Largest difference of impulses and ∫ f² relative to their largest, and of positions [m].
fn differences(
    world: &WorldIdeal,
    profile: &ForceProfile,
    at: impl Fn(f64) -> Snapshot,
) -> (f64, f64) {
    let relative = |a: &[f64], b: &[f64]| {
        let largest = b.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let apart = a.iter().zip(b).map(|(x, y)| (x - y).abs());
        apart.fold(0.0, f64::max) / largest
    };
    let along = |vectors: &[[f64; 3]], sign: f64| -> Vec<f64> {
        vectors.iter().map(|v| sign * v[2]).collect()
    };
    let device = &world.devices[0];
    let forces = relative(&along(&device.impulses, -1.0), profile.impulses()).max(relative(
        &along(&device.squares, 1.0),
        profile.squared_forces(),
    ));
    let places = world.states.iter().map(|state| {
        let snapshot = at(state.time);
        (state.devices[0].position[2] - snapshot.device_position).abs()
    });
    (forces, places.fold(0.0, f64::max))
}

#[test]
fn a_device_and_an_object_move_as_in_the_closed_form() {
    for object_mass in [0.08, 2.0, f64::INFINITY] {
        let scene = PointMassScene {
            object_mass,
            object_velocity: if object_mass.is_finite() { -0.3 } else { 0.0 },
            ..scene()
        };
        let ideal = Ideal::new(scene).unwrap();
        let profile = ideal.profile(PERIOD, INTERVALS).unwrap();
        let world = solve(&world(&scene), PERIOD, INTERVALS);
        let (forces, places) = differences(&world, &profile, |time| ideal.at(time));
        println!(
            "object of {object_mass} kg: impulses and squares to {forces:.1e}, places to {places:.1e} m, {} \
             contacts, {} steps",
            world.encounters.len(),
            world.steps
        );
        assert!(forces < 1e-9 && places < 1e-11);
        assert_eq!(world.encounters.len(), profile.collisions().len());
        for (of_world, collision) in world.encounters.iter().zip(profile.collisions()) {
            assert!((of_world.start - collision.start).abs() < 1e-10);
            assert!((of_world.normal_impulse - collision.impulse).abs() < 1e-9);
            assert!((of_world.peak_force / collision.peak_force - 1.0).abs() < 1e-5);
            match (of_world.end, collision.end) {
                (Some(a), Some(b)) => assert!((a - b).abs() < 1e-10),
                (a, b) => assert_eq!(a, b),
            }
        }
    }
}

#[test]
fn a_hand_that_damps_is_the_friction_of_the_viscous_ideal() {
    let scene = scene();
    let viscous = ViscousIdeal::new(&scene, 0.8, PERIOD, INTERVALS).unwrap();
    let mut world = world(&scene);
    world.devices[0].hand.damping = 0.8;
    let world = solve(&world, PERIOD, INTERVALS);
    let (forces, places) = differences(&world, &viscous.profile, |time| {
        let interval = (time / PERIOD).round();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        viscous.record[interval as usize]
    });
    println!("with friction: impulses and squares to {forces:.1e}, places to {places:.1e} m");
    assert!(forces < 1e-9 && places < 1e-11);
}

/// While contact lasts, a contact's damper towards a wall is a friction of the device.
#[test]
fn a_damped_contact_with_a_wall_moves_its_device_as_friction_would() {
    let scene = PointMassScene {
        object_mass: f64::INFINITY,
        object_velocity: 0.0,
        object_position: -0.003,
        device_position: 0.0,
        ..scene()
    };
    let viscous = ViscousIdeal::new(&scene, 2.5, PERIOD, INTERVALS).unwrap();
    assert_eq!(viscous.profile.collisions().len(), 1); // never parts
    let mut world = world(&scene);
    world.pairs[0].law.damping = 2.5;
    let world = solve(&world, PERIOD, INTERVALS);
    for (state, snapshot) in world.states.iter().zip(&viscous.record) {
        let device = &state.devices[0];
        assert!((device.position[2] - snapshot.device_position).abs() < 1e-11);
        let force = scene.stiffness * snapshot.penetration() + 2.5 * snapshot.device_velocity;
        assert!((device.force[2] + force).abs() < 1e-8);
    }
}
