//! Conservation of momentum and angular momentum in contacts, and of energy without damping.

use palpate_world::{
    BasicParams, Body, ContactLaw, Free, Motion, Shape, SubSteps, Vector, WorldLoop, WorldRenderer,
    WorldState,
};

use crate::balance::energy;
use crate::common::{ball, leave_alone, plane, world};

const MASSES: [f64; 2] = [0.1, 0.3];

/// Returns two balls that collide off-centre, one of them spinning.
fn meeting(law: ContactLaw) -> (WorldRenderer, WorldState) {
    let mut spinning = Free::of_mass(MASSES[0]).moving([0.5, 0.0, 0.0]);
    spinning.angular_velocity = [3.0, -20.0, 7.0];
    let bodies = vec![
        ball("spinning", 0.02, spinning).at([-0.05, 0.004, 0.0]),
        ball("still", 0.03, Free::of_mass(MASSES[1])).at([0.01, -0.005, 0.006]),
    ];
    let loop_params = WorldLoop::new(0.001);
    let renderer = WorldRenderer::new(
        &world(0.0, bodies, law),
        loop_params,
        BasicParams::default(),
    );
    let renderer = renderer.unwrap();
    let state = renderer.start();
    (renderer, state)
}

fn sum(vectors: impl Iterator<Item = Vector>) -> Vector {
    vectors.fold([0.0; 3], |a, b| [a[0] + b[0], a[1] + b[1], a[2] + b[2]])
}

fn momentum(state: &WorldState) -> Vector {
    let bodies = state.bodies().iter().zip(MASSES);
    sum(bodies.map(|(body, mass)| body.velocity.map(|v| mass * v)))
}

fn angular_momentum(state: &WorldState) -> Vector {
    let radii = [0.02, 0.03];
    let bodies = state.bodies().iter().zip(MASSES).zip(radii);
    sum(bodies.map(|((body, mass), radius)| {
        let ([x, y, z], [u, v, w]) = (body.position, body.velocity);
        let own = body
            .angular_velocity
            .map(|turn| 0.4 * mass * radius * radius * turn);
        let [a, b, c] = [y * w - z * v, z * u - x * w, x * v - y * u].map(|part| mass * part);
        [a + own[0], b + own[1], c + own[2]]
    }))
}

fn distance(one: Vector, other: Vector) -> f64 {
    let square = |axis: usize| (one[axis] - other[axis]).powi(2);
    (square(0) + square(1) + square(2)).sqrt()
}

#[test]
fn a_collision_keeps_momentum_and_angular_momentum_with_friction_and_damping_too() {
    let law = ContactLaw::spring(5000.0)
        .with_damping(2.0)
        .with_friction(0.4);
    let (renderer, mut state) = meeting(law);
    let before = (momentum(&state), angular_momentum(&state));
    let still = state.bodies()[1];
    leave_alone(&renderer, &mut state, 200);
    let after = (momentum(&state), angular_momentum(&state));
    let off = [distance(before.0, after.0), distance(before.1, after.1)];
    println!(
        "momentum off by {} N s, angular momentum by {} N m s",
        off[0], off[1]
    );
    assert!(off[0] < 1e-15 && off[1] < 1e-16, "{off:?}");
    // They have collided, and friction has rotated the ball that was at rest.
    let moved = state.bodies()[1];
    assert!(distance(moved.velocity, still.velocity) > 0.05);
    assert!(distance(moved.angular_velocity, still.angular_velocity) > 0.1);
}

#[test]
fn a_collision_keeps_energy_without_damping_and_friction_and_loses_it_with_them() {
    let spring = ContactLaw::spring(5000.0);
    let lost = |law| {
        let (renderer, mut state) = meeting(law);
        let before = energy(&state);
        leave_alone(&renderer, &mut state, 200);
        1.0 - energy(&state) / before
    };
    let (none, damped, rubbed) = (
        lost(spring),
        lost(spring.with_damping(2.0)),
        lost(spring.with_friction(0.4)),
    );
    println!("lost: {none:e} of a spring, {damped} with damping, {rubbed} with friction");
    assert!(none.abs() < 1e-6, "{none}");
    assert!(damped > 0.01 && rubbed > 0.01, "{damped} {rubbed}");
}

/// A box that tumbles about its middle axis, which is unstable: its angular momentum is constant, its angular
/// velocity is not.
#[test]
fn a_tumbling_box_keeps_its_angular_momentum() {
    let shape = Shape::Box {
        half_extents: [0.03, 0.02, 0.01],
    };
    let mut free = Free::of_mass(0.2);
    free.angular_velocity = [0.3, 8.0, 0.3];
    let moments = shape.moments(0.2).unwrap();
    let bodies = vec![Body::new("box", shape, Motion::Free(free))];
    let world = world(0.0, bodies, ContactLaw::spring(1000.0));
    let renderer = WorldRenderer::new(&world, WorldLoop::new(0.001), BasicParams::default());
    let renderer = renderer.unwrap();
    let mut state = renderer.start();
    // From the public pose and angular velocity.
    let spin = |state: &WorldState| {
        let body = state.bodies()[0];
        let [w, x, y, z] = body.orientation;
        let own = turned([w, -x, -y, -z], body.angular_velocity);
        let own = [0, 1, 2].map(|axis| moments[axis] * own[axis]);
        turned(body.orientation, own)
    };
    let (mut least, before, spin_before) = (f64::INFINITY, energy(&state), spin(&state));
    for _ in 0..4000 {
        leave_alone(&renderer, &mut state, 1);
        let body = state.bodies()[0];
        let [w, x, y, z] = body.orientation;
        let [_, about_y, _] = turned([w, -x, -y, -z], body.angular_velocity);
        least = least.min(about_y);
    }
    let off = distance(spin(&state), spin_before) / (moments[1] * 8.0);
    let of_energy = energy(&state) / before - 1.0;
    println!(
        "least angular velocity about its own y {least} 1/s; angular momentum off by {off:e}, energy by {of_energy:e}"
    );
    assert!(off < 1e-9, "{off}");
    assert!(of_energy.abs() < 1e-6, "{of_energy}");
    assert!(least < -7.0, "it has not tumbled: {least}");
}

/// Rotates a vector by a unit quaternion.
fn turned([w, x, y, z]: [f64; 4], [a, b, c]: Vector) -> Vector {
    let cross = |[u, v, t]: Vector| [y * t - z * v, z * u - x * t, x * v - y * u];
    let once = cross([a, b, c]);
    let twice = cross(once);
    [
        a + 2.0 * (w * once[0] + twice[0]),
        b + 2.0 * (w * once[1] + twice[1]),
        c + 2.0 * (w * once[2] + twice[2]),
    ]
}

/// Half the sub-steps give four times the error: the method is of second order, also with damping and friction.
#[test]
fn the_integration_is_of_second_order() {
    let velocity = |law, count| {
        let bodies = vec![
            plane("floor", [0.0, 0.0, 1.0]),
            ball("ball", 0.02, {
                let mut free = Free::of_mass(0.1).moving([0.2, 0.0, -0.5]);
                free.angular_velocity = [0.0, 0.0, 3.0];
                free
            })
            // It starts in contact, so that no contact begins within a sub-step.
            .at([0.0, 0.0, 0.0199]),
        ];
        let mut loop_params = WorldLoop::new(0.001);
        loop_params.sub_steps = SubSteps {
            least: count,
            most: count,
            ..SubSteps::default()
        };
        let world = world(0.0, bodies, law);
        let renderer = WorldRenderer::new(&world, loop_params, BasicParams::default()).unwrap();
        let mut state = renderer.start();
        leave_alone(&renderer, &mut state, 5);
        state.bodies()[1].velocity
    };
    let law = ContactLaw::spring(5000.0);
    for law in [
        law,
        law.with_damping(3.0),
        law.with_damping(3.0).with_friction(0.9),
    ] {
        let exact = velocity(law, 4096);
        let [coarse, fine] = [8, 16].map(|count| distance(velocity(law, count), exact));
        println!("{law:?}: off by {coarse:e} m/s with 8 sub-steps, {fine:e} with 16");
        assert!((3.0..5.5).contains(&(coarse / fine)), "{}", coarse / fine);
    }
}
