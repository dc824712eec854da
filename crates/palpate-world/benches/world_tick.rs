//! Time per tick of a world: `cargo bench -p palpate-world --bench world_tick`.
//!
//! A tool presses a ball onto a floor and against a wall: three bodies and three contacts with friction. Every tick
//! of a run is timed. Each reported time is the minimum over several identical runs, because any excess is due to
//! other programs.
#![allow(clippy::print_stdout)] // a benchmark prints

mod timed;

use palpate_world::{
    BasicParams, Body, Contact, ContactLaw, CoupledParams, Free, Motion, Output, Party, Quaternion,
    Shape, Tool, Vector, World, WorldMethod,
};

use timed::{Held, PERIOD, print_heading, print_ticks};

const MASS: f64 = 0.15;

fn world(friction: f64) -> World {
    let plane = |name, normal: Vector| {
        let shape = Shape::HalfSpace {
            normal,
            offset: 0.0,
        };
        Body::new(name, shape, Motion::Fixed)
    };
    let ball = Free::of_mass(0.06).pulled_by([-0.2, 0.0, -0.6]);
    let law = ContactLaw::spring(4000.0).with_damping(1.0);
    World {
        joints: Vec::new(),
        fields: Vec::new(),
        tools: vec![Tool::new("tool", Shape::Sphere { radius: 0.008 })],
        bodies: vec![
            plane("floor", [0.0, 0.0, 1.0]),
            plane("wall", [1.0, 0.0, 0.0]),
            Body::new("ball", Shape::Sphere { radius: 0.02 }, Motion::Free(ball))
                .at([0.02, 0.0, 0.02]),
        ],
        contacts: vec![Contact {
            between: [Party::Any, Party::Any],
            law: law.with_friction(friction),
        }],
    }
}

/// Three stacked boxes: 49 contact points, 24 of them between boxes.
fn stack(friction: f64) -> World {
    let shape = Shape::Box {
        half_extents: [0.02, 0.02, 0.01],
    };
    let block = |name, [x, y, z]: Vector, turned: f64| {
        let free = Free::of_mass(0.05).pulled_by([0.0, 0.0, -0.4905]);
        let half = 0.5 * turned;
        Body::new(name, shape.clone(), Motion::Free(free))
            .at([x, y, z])
            .turned([half.cos(), 0.0, 0.0, half.sin()])
    };
    let world = world(friction);
    World {
        bodies: vec![
            world.bodies[0].clone(),
            block("lower", [0.0, 0.0, 0.01], 0.0),
            block("middle", [0.002, 0.001, 0.03], 0.07),
            block("upper", [0.001, -0.001, 0.05], -0.1),
        ],
        ..world
    }
}

/// A device that a hand presses down and moves across, integrated under held forces.
struct HandledDevice {
    position: Vector,
    velocity: Vector,
    /// Rest position of the hand, without a sine along y `[m]`.
    rest: Vector,
}

impl Held for HandledDevice {
    fn place(&self) -> (Vector, Option<Quaternion>) {
        (self.position, None)
    }

    fn hold(&mut self, output: &Output, time: f64) {
        let force = output.forces[0];
        let hand = |axis: usize, position: f64, velocity: f64| {
            let sway = if axis == 1 {
                0.004 * (9.0 * time).sin()
            } else {
                0.0
            };
            let rest = self.rest[axis] + sway;
            300.0 * (rest - position) - 3.0 * velocity
        };
        for _ in 0..20 {
            for (axis, force) in force.into_iter().enumerate() {
                let pushed = force + hand(axis, self.position[axis], self.velocity[axis]);
                self.velocity[axis] += pushed / MASS * PERIOD / 20.0;
                self.position[axis] += self.velocity[axis] * PERIOD / 20.0;
            }
        }
    }
}

fn main() {
    // Under `cargo test` a benchmark only has to build and run.
    if !std::env::args().any(|argument| argument == "--bench") {
        return;
    }
    print_heading();
    let methods: [WorldMethod; 2] = [
        BasicParams::default().into(),
        CoupledParams::new(vec![[MASS; 3]])
            .with_encoder_quantum(2e-6)
            .into(),
    ];
    for method in &methods {
        for friction in [0.0, 0.5] {
            let name = format!("{}, friction {friction}", method.name());
            print_ticks(&name, &world(friction), method, || HandledDevice {
                position: [0.022, 0.0, 0.05],
                velocity: [0.0; 3],
                rest: [0.024, 0.0, 0.02],
            });
        }
        let name = format!("{}, three boxes, friction 0.5", method.name());
        print_ticks(&name, &stack(0.5), method, || HandledDevice {
            position: [0.004, 0.0, 0.07],
            velocity: [0.0; 3],
            rest: [0.004, 0.0, 0.055],
        });
    }
}
