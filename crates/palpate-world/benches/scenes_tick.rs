//! Time per tick of worlds with one to a hundred bodies: `cargo bench -p palpate-world --bench scenes_tick`.
//!
//! A hand presses a tool down onto the bodies and moves it to and fro, with friction. Bodies start at rest on a floor.
//! A scene is selected by its name: `-- "20 balls"`.
#![allow(clippy::print_stdout)] // a benchmark prints

mod timed;

use palpate_world::{
    Body, Contact, ContactLaw, CoupledParams, Free, Motion, Output, Party, Quaternion, Shape, Tool,
    Vector, World, WorldMethod,
};

use timed::{Held, PERIOD, print_heading, print_ticks};

/// Mass of the device `[kg]`.
const DEVICE: f64 = 0.15;
/// Mass of a body `[kg]`.
const MASS: f64 = 0.06;
const STIFFNESS: f64 = 4000.0;
const TOOL_RADIUS: f64 = 0.008;

fn world(bodies: Vec<Body>) -> World {
    let floor = Shape::HalfSpace {
        normal: [0.0, 0.0, 1.0],
        offset: 0.0,
    };
    let law = ContactLaw::spring(STIFFNESS).with_damping(1.0);
    World {
        joints: Vec::new(),
        fields: Vec::new(),
        tools: vec![Tool::new(
            "tool",
            Shape::Sphere {
                radius: TOOL_RADIUS,
            },
        )],
        bodies: [Body::new("floor", floor, Motion::Fixed)]
            .into_iter()
            .chain(bodies)
            .collect(),
        contacts: vec![Contact {
            between: [Party::Any, Party::Any],
            law: law.with_friction(0.5),
        }],
    }
}

fn body(name: &str, shape: Shape, at: Vector) -> Body {
    let free = Free::of_mass(MASS).pulled_by([0.0, 0.0, -9.81 * MASS]);
    Body::new(name, shape, Motion::Free(free)).at(at)
}

/// Returns balls of 20 mm in rows of ten, 60 mm apart.
fn balls(count: u32) -> World {
    let each = (0..count).map(|number| {
        let at = [
            0.06 * f64::from(number % 10),
            0.06 * f64::from(number / 10),
            0.02 - 9.81 * MASS / STIFFNESS,
        ];
        body(
            &format!("ball {number}"),
            Shape::Sphere { radius: 0.02 },
            at,
        )
    });
    world(each.collect())
}

/// Returns flat boxes in one stack, each turned against the one below.
fn tower(count: u32) -> World {
    let each = (0..count).map(|number| {
        let level = f64::from(number);
        let half = 0.04 * (1.7 * level).sin();
        let shape = Shape::Box {
            half_extents: [0.02, 0.02, 0.01],
        };
        let at = [
            0.001 * level.sin(),
            -0.001 * level.sin(),
            0.01 + 0.02 * level,
        ];
        body(&format!("box {number}"), shape, at).turned([half.cos(), 0.0, 0.0, half.sin()])
    });
    world(each.collect())
}

/// Returns two cylinders, one on the other.
fn cylinders() -> World {
    let each = (0..2_u32).map(|number| {
        let shape = Shape::Cylinder {
            radius: 0.02,
            half_length: 0.01,
        };
        body(
            &format!("can {number}"),
            shape,
            [0.0, 0.0, 0.01 + 0.02 * f64::from(number)],
        )
    });
    world(each.collect())
}

/// A device that a hand presses down and moves across, integrated under held forces.
struct HandledDevice {
    position: Vector,
    velocity: Vector,
    /// Rest position of the hand, without a sine along y `[m]`.
    rest: Vector,
}

impl HandledDevice {
    /// Returns a device over a surface at this height `[m]`, pressed 15 mm into it.
    fn over(top: f64) -> Self {
        Self {
            position: [0.002, 0.0, top + TOOL_RADIUS + 0.002],
            velocity: [0.0; 3],
            rest: [0.002, 0.0, top + TOOL_RADIUS - 0.015],
        }
    }
}

impl Held for HandledDevice {
    fn place(&self) -> (Vector, Option<Quaternion>) {
        (self.position, None)
    }

    fn hold(&mut self, output: &Output, time: f64) {
        let sway = [0.0, 0.004 * (9.0 * time).sin(), 0.0];
        for _ in 0..20 {
            for (axis, sway) in sway.into_iter().enumerate() {
                let hand = 300.0 * (self.rest[axis] + sway - self.position[axis])
                    - 3.0 * self.velocity[axis];
                self.velocity[axis] += (output.forces[0][axis] + hand) / DEVICE * PERIOD / 20.0;
                self.position[axis] += self.velocity[axis] * PERIOD / 20.0;
            }
        }
    }
}

fn main() {
    // Under `cargo test` a benchmark only has to build and run.
    let mut arguments = std::env::args().skip(1);
    if !std::env::args().any(|argument| argument == "--bench") {
        return;
    }
    let only = arguments.find(|argument| !argument.starts_with('-'));
    print_heading();
    let coupled: WorldMethod = CoupledParams::new(vec![[DEVICE; 3]])
        .with_encoder_quantum(2e-6)
        .into();
    let scenes = [
        ("1 ball on a floor", balls(1), 0.04),
        ("20 balls, tool on one", balls(20), 0.04),
        ("100 balls, tool on one", balls(100), 0.04),
        ("100 balls, tool above", balls(100), 0.3),
        ("tower of 3 boxes", tower(3), 0.06),
        ("tower of 5 boxes", tower(5), 0.1),
        ("two cylinders", cylinders(), 0.04),
    ];
    for (name, world, top) in scenes {
        if only
            .as_ref()
            .is_none_or(|only| name.contains(only.as_str()))
        {
            print_ticks(name, &world, &coupled, || HandledDevice::over(top));
        }
    }
}
