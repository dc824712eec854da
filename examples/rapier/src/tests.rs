//! The way into the engine and out of it.

use palpate_world::{ContactLaw, CoupledParams, WorldLoop};
use rapier3d_f64::prelude::*;

use crate::contact::{Contact, WithoutTool};
use crate::rendered::{Bench, Own};
use crate::scenes::{RATES, scenes};

const H: f64 = 0.001;

fn world() -> PhysicsWorld {
    let mut world = PhysicsWorld::new();
    world.gravity = Vector::ZERO;
    world.integration_parameters.dt = H;
    world
}

fn contact(world: &PhysicsWorld, bodies: &[RigidBodyHandle], stiffness: f64) -> Contact {
    let device = CoupledParams::new(vec![[0.2; 3]]);
    let law = ContactLaw::spring(stiffness);
    Contact::new(world, 0.01, bodies, law, WorldLoop::new(H), device).unwrap()
}

/// A turned box of 1 kg whose centre of mass is not where its frame is.
fn block(world: &mut PhysicsWorld) -> RigidBodyHandle {
    let turned = Vector::new(0.9, 0.2, -0.4);
    let body = RigidBodyBuilder::dynamic()
        .translation(Vector::new(1.0, 2.0, 3.0))
        .rotation(turned)
        .can_sleep(false);
    let body = world.insert_body(body);
    let side = ColliderBuilder::cuboid(0.2, 0.1, 0.05)
        .translation(Vector::new(0.1, 0.0, 0.05))
        .mass(1.0);
    world.insert_collider(side, Some(body));
    // The engine computes masses at its next step.
    world.step();
    body
}

fn close(a: Vector, b: Vector, error: f64) {
    assert!((a - b).length() < error, "{a} is not {b}");
}

#[test]
fn a_newton_on_a_kilogram_for_a_second_is_half_a_metre() {
    let mut world = world();
    let body = block(&mut world);
    let start = world.bodies[body].center_of_mass();
    let mut contact = contact(&world, &[body], 100.0);
    for _ in 0..1000 {
        contact.push_wrench(&mut world, [1.0, 0.0, 0.0], [0.0; 3]);
        world.step();
        contact.pull(&mut world);
        assert_eq!(world.bodies[body].user_force(), Vector::ZERO);
    }
    let moved = world.bodies[body].center_of_mass() - start;
    // The engine divides a step, and moves by the velocity at the end of each part: half a part more.
    let part = H / world.integration_parameters.num_solver_iterations as f64;
    close(moved, Vector::new(0.5 + 0.5 * part, 0.0, 0.0), 1e-9);
    close(world.bodies[body].linvel(), Vector::X, 1e-9);
    close(world.bodies[body].angvel(), Vector::ZERO, 1e-9);
}

#[test]
fn a_force_off_the_centre_turns_a_rotated_body_as_its_mobility_says() {
    let mut world = world();
    world.integration_parameters.dt = 1e-5;
    let body = block(&mut world);
    let mut contact = contact(&world, &[body], 100.0);
    let (force, arm) = (Vector::new(0.3, -0.2, 1.0), Vector::new(0.05, 0.1, -0.02));
    let torque = arm.cross(force);
    let mobility = contact.mobility(&world, 0);
    // The inertia of a block, turned by hand.
    let own = [0.1_f64, 0.05, 0.2].map(|half| half * half);
    let [y, z, x] = own;
    let moments = Vector::new((y + z) / 3.0, (x + z) / 3.0, (x + y) / 3.0);
    let turned = *world.bodies[body].rotation();
    let expected = turned * ((turned.inverse() * torque) / moments);
    contact.push_wrench(&mut world, force.to_array(), torque.to_array());
    world.step();
    contact.pull(&mut world);
    let gained = world.bodies[body].angvel() / 1e-5;
    close(gained, expected, 1e-2);
    let model: Vec<f64> = (3..6)
        .map(|row| {
            (0..3)
                .map(|axis| mobility[row][3 + axis] * torque[axis])
                .sum()
        })
        .collect();
    close(Vector::from_slice(&model), expected, 1e-9);
}

#[test]
fn what_the_program_puts_on_a_body_stays_there() {
    let mut world = world();
    let body = block(&mut world);
    let own = Vector::new(0.0, 0.0, 0.5);
    world.bodies[body].add_force(own, true);
    let mut contact = contact(&world, &[body], 100.0);
    for _ in 0..5 {
        contact.push_wrench(&mut world, [0.1, 0.2, 0.3], [0.01, 0.0, 0.0]);
        world.step();
        contact.pull(&mut world);
        assert_eq!(world.bodies[body].user_force(), own);
        assert_eq!(world.bodies[body].user_torque(), Vector::ZERO);
    }
}

/// Pushes a ball of 100 g with a device of 200 g under 1 N for 0.1 s: the impulses that the device and the ball got.
fn pushed(is_filtered: bool) -> (f64, f64) {
    let mut world = world();
    let ball = RigidBodyBuilder::dynamic().can_sleep(false);
    let ball = world.insert_body(ball);
    world.insert_collider(ColliderBuilder::ball(0.03).mass(0.1), Some(ball));
    let start = [-0.041, 0.0, 0.0];
    let hand = RigidBodyBuilder::kinematic_position_based().translation(Vector::from_array(start));
    let hand = world.insert_body(hand);
    let tool = ColliderBuilder::ball(0.01).active_hooks(ActiveHooks::FILTER_CONTACT_PAIRS);
    let tool = world.insert_collider(tool, Some(hand));
    let nobody = ColliderHandle::invalid();
    let hooks = WithoutTool {
        tool: if is_filtered { tool } else { nobody },
    };
    world.step_with_events(&hooks, &());
    let mut contact = contact(&world, &[ball], 2000.0);
    let (mut position, mut velocity, mut impulse) = (start, 0.0, 0.0);
    for _ in 0..100 {
        contact.sample(position);
        contact.push(&mut world);
        world.step_with_events(&hooks, &());
        contact.pull(&mut world);
        world.bodies[hand].set_next_kinematic_translation(Vector::from_array(contact.proxy()));
        let force = contact.hold()[0];
        impulse -= H * force;
        velocity += H * (1.0 + force) / 0.2;
        position[0] += H * velocity;
    }
    (impulse, 0.1 * world.bodies[ball].linvel().x)
}

#[test]
fn device_and_body_are_given_the_same_impulse_and_the_engine_leaves_the_tool_alone() {
    let (given, got) = pushed(true);
    println!("the device gave {given} N s, the ball got {got} N s");
    assert!(
        given > 0.01 && (got / given - 1.0).abs() < 0.03,
        "{given} {got}"
    );
    // Without the filter the engine's own contact pushes the ball as well.
    let (given, got) = pushed(false);
    println!("without the filter {given} N s, the ball got {got} N s");
    assert!(got > 1.1 * given, "{given} {got}");
}

#[test]
fn other_shapes_are_refused_by_name() {
    let mut world = world();
    let body = world.insert_body(RigidBodyBuilder::dynamic());
    world.insert_collider(ColliderBuilder::cone(0.1, 0.1), Some(body));
    let device = CoupledParams::new(vec![[0.2; 3]]);
    let law = ContactLaw::spring(100.0);
    let refused = Contact::new(&world, 0.01, &[body], law, WorldLoop::new(H), device);
    let said = refused.err().unwrap();
    assert!(
        said.contains("body 0 has a collider of the shape Cone"),
        "{said}"
    );
}

/// Forces on a device that 0.4 N press for 0.2 s onto a body of this collider, beside its centre.
fn pressed(collider: ColliderBuilder) -> Vec<[f64; 3]> {
    let mut world = world();
    let body = world.insert_body(RigidBodyBuilder::dynamic().can_sleep(false));
    world.insert_collider(collider.mass(0.1), Some(body));
    world.step();
    let mut contact = contact(&world, &[body], 500.0);
    let (mut position, mut velocity) = ([0.012, 0.004, 0.025], 0.0);
    let mut forces = Vec::new();
    for _ in 0..200 {
        contact.sample(position);
        contact.push(&mut world);
        world.step();
        contact.pull(&mut world);
        forces.push(contact.hold());
        velocity += H * (forces[forces.len() - 1][2] - 0.4) / 0.2;
        position[2] += H * velocity;
    }
    forces
}

#[test]
fn a_convex_polyhedron_is_touched_as_the_box_that_it_is() {
    let half = [0.03, 0.02, 0.01];
    let corner = |number: usize| {
        let side = |axis: usize| {
            if number >> axis & 1 == 1 {
                half[axis]
            } else {
                -half[axis]
            }
        };
        Vector::new(side(0), side(1), side(2))
    };
    let corners: Vec<_> = (0..8).map(corner).collect();
    let of_box = pressed(ColliderBuilder::cuboid(half[0], half[1], half[2]));
    let of_corners = pressed(ColliderBuilder::convex_hull(&corners).unwrap());
    let most = of_box.iter().map(|force| force[2]).fold(0.0, f64::max);
    assert!(most > 0.1, "{most}");
    for (one, other) in of_box.iter().zip(&of_corners) {
        close(
            Vector::from_array(*one),
            Vector::from_array(*other),
            1e-6 * most,
        );
    }
}

/// Every row of the table with 4 steps of 4 parts. The limit is 5 %, the goal 2 %.
#[test]
fn forces_are_near_the_ideal_s_in_every_scene_of_the_table() {
    for (period, stiffness) in RATES {
        for scene in scenes(period, stiffness) {
            let (name, is_coarse) = (scene.name, scene.is_box && period == 0.01);
            let bench = Bench::new(scene, 4, 4).unwrap();
            let contact = bench.palpate(1.0).unwrap();
            println!("{name}, {period} s: {contact:?}");
            let allowed = if is_coarse { 5.0 } else { 2.0 };
            assert!(contact.error < allowed, "{name}, {period} s: {contact:?}");
            assert!(contact.over_bound < 1.2, "{name}, {period} s: {contact:?}");
        }
    }
}

/// The engine's contact of the tool is the scene's spring, and its floor is the scene's floor. With small steps their
/// error vanishes, and only the effect of holding the device over a period remains.
#[test]
fn the_engine_s_own_contacts_are_those_of_the_scene() {
    let scene = scenes(0.001, 4000.0).remove(1);
    let coarse = Bench::new(scene.clone(), 1, 1).unwrap();
    let fine = Bench::new(scene, 50, 4).unwrap();
    let own = Own {
        moves: true,
        ..Own::default()
    };
    let (coarse, fine) = (coarse.engine(own).unwrap(), fine.engine(own).unwrap());
    println!("{coarse:?} {fine:?}");
    assert!(fine.error < 0.5 * coarse.error, "{coarse:?} {fine:?}");
}
