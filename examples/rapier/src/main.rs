//! Contact with the bodies of the physics engine Rapier: a hand pushes a cube over a floor.
//!
//! The engine moves the cube and keeps its contact with the floor; the contact of the tool is palpate's. `cargo run
//! --release` prints what the hand feels, `cargo run --release --bin table` how near contacts are to the ideal, `cargo
//! test
//! --release` tests the way into the engine and out of it.

use palpate_example_rapier::contact::{Contact, WithoutTool};
use palpate_world::{ContactLaw, CoupledParams, WorldLoop};
use rapier3d_f64::prelude::*;

const PERIOD: f64 = 0.004;
const STEPS: u32 = 4;
const DEVICE_MASS: f64 = 0.25;

fn main() -> Result<(), String> {
    let mut world = PhysicsWorld::new();
    world.gravity = Vector::new(0.0, 0.0, -9.81);
    world.integration_parameters.dt = PERIOD / f64::from(STEPS);
    let floor = ColliderBuilder::cuboid(1.0, 1.0, 0.1).translation(Vector::new(0.0, 0.0, -0.1));
    world.insert_collider(floor.friction(0.4), None);
    let cube = RigidBodyBuilder::dynamic().translation(Vector::new(0.0, 0.0, 0.03));
    let cube = world.insert_body(cube);
    let side = ColliderBuilder::cuboid(0.03, 0.03, 0.03)
        .mass(0.2)
        .friction(0.4);
    world.insert_collider(side, Some(cube));
    // The tool, as a viewer would show it. The engine asks the hooks about its contacts, which are palpate's.
    let start = [-0.06, 0.0, 0.03];
    let hand = RigidBodyBuilder::kinematic_position_based().translation(Vector::from_array(start));
    let hand = world.insert_body(hand);
    let tool = ColliderBuilder::ball(0.01).active_hooks(ActiveHooks::FILTER_CONTACT_PAIRS);
    let hooks = WithoutTool {
        tool: world.insert_collider(tool, Some(hand)),
    };

    let law = ContactLaw::spring(2000.0).with_friction(0.5);
    let device = CoupledParams::new(vec![[DEVICE_MASS; 3]]);
    let mut contact = Contact::new(&world, 0.01, &[cube], law, WorldLoop::new(PERIOD), device)?;

    println!("time [s]   device [mm]   cube [mm]   force on the hand [N]");
    let (mut position, mut velocity) = (start, [0.0; 3]);
    for tick in 0_u32..250 {
        contact.sample(position);
        for _ in 0..STEPS {
            contact.push(&mut world);
            world.step_with_events(&hooks, &());
            contact.pull(&mut world);
        }
        world.bodies[hand].set_next_kinematic_translation(Vector::from_array(contact.proxy()));
        let force = contact.hold();
        let time = f64::from(tick) * PERIOD;
        if tick % 50 == 49 {
            let cube = world.bodies[cube].translation().x;
            println!(
                "{time:8.3}   {:11.1}   {:9.1}   {:21.2}",
                1e3 * position[0],
                1e3 * cube,
                force[0]
            );
        }
        // Replace this model by your device: 0.25 kg in a hand of 60 N/m and 3 N s/m, whose rest moves by 60 mm/s.
        let rest = [start[0] + 0.06 * time, start[1], start[2]];
        for axis in 0..3 {
            let hand = 60.0 * (rest[axis] - position[axis]) - 3.0 * velocity[axis];
            velocity[axis] += PERIOD * (hand + force[axis]) / DEVICE_MASS;
            position[axis] += PERIOD * velocity[axis];
        }
    }
    Ok(())
}
