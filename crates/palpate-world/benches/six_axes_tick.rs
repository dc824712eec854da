//! Time per tick of a six-axis tool: `cargo bench -p palpate-world --bench six_axes_tick`.
//!
//! A hand presses a box onto a table, tilts it and moves it across: eight contact points, up to four of them active.
//! Then the box is a mesh with a shell of 60 or 200 points, and the table a mesh with a distance grid. Every tick of
//! a run is timed. Each reported time is the minimum over several identical runs, because any excess is due to other
//! programs.
#![allow(clippy::print_stdout)] // a benchmark prints

mod timed;

use std::sync::Arc;

use palpate_world::{
    BasicParams, Body, Contact, ContactLaw, CoupledParams, DistanceGrid, Free, Hull, Mesh, Motion,
    Output, Party, PointShell, Quaternion, Shape, Tool, Vector, World, WorldMethod,
};

use timed::{Held, PERIOD, print_heading, print_ticks};

const MASS: f64 = 0.15;
const INERTIA: f64 = 1.5e-4;

const HALF: Vector = [0.03, 0.02, 0.015];

fn box_on_table(friction: f64) -> World {
    let table = Shape::HalfSpace {
        normal: [0.0, 0.0, 1.0],
        offset: 0.0,
    };
    let half_extents = HALF;
    world(Shape::Box { half_extents }, table, friction)
}

/// A cylinder on a half-space, a box and hulls, and one below two stacked ones.
fn cylinders(friction: f64) -> Vec<(&'static str, World)> {
    let can = |radius, half_length| Shape::Cylinder {
        radius,
        half_length,
    };
    // The table is a prism with this number of sides, wide enough that the cylinder stays on it.
    let prism = |sides: u32| {
        let corners: Vec<Vector> = (0..2 * sides)
            .map(|number| {
                let angle = std::f64::consts::TAU * f64::from(number % sides) / f64::from(sides);
                let z = if number < sides { -0.04 } else { 0.0 };
                [0.1 * angle.cos(), 0.1 * angle.sin(), z]
            })
            .collect();
        Shape::Hull(Arc::new(
            Hull::around(&corners).expect("a prism has a hull"),
        ))
    };
    let half_space = Shape::HalfSpace {
        normal: [0.0, 0.0, 1.0],
        offset: 0.0,
    };
    let half_extents = [0.1, 0.1, 0.015];
    let mut on_box = world(can(0.025, 0.015), Shape::Box { half_extents }, friction);
    on_box.bodies[0].position[2] = -0.015;
    let on = |table| world(can(0.025, 0.015), table, friction);
    let mut worlds = vec![
        ("half-space, ", on(half_space.clone())),
        ("box, ", on_box),
        ("16 corners, ", on(prism(8))),
        ("32 corners, ", on(prism(16))),
    ];
    let free = || Motion::Free(Free::of_mass(0.1).pulled_by([0.0, 0.0, -0.981]));
    let mut stack = on(half_space);
    stack.tools[0].shape = Shape::Sphere { radius: 0.015 };
    stack.bodies.extend([
        Body::new("lower", can(0.03, 0.02), free()).at([0.0, 0.0, -0.06]),
        Body::new("upper", can(0.025, 0.02), free()).at([0.003, 0.0, -0.02]),
    ]);
    if let Shape::HalfSpace { offset, .. } = &mut stack.bodies[0].shape {
        *offset = -0.08;
    }
    worlds.push(("two stacked, ", stack));
    worlds
}

/// Box and table as meshes: a point shell on a grid of 2 mm.
fn points_on_grid(points: usize, friction: f64) -> World {
    let block = |half: Vector, top: f64| {
        let corner = |number: u32| {
            let sign = |axis: u32| if number >> axis & 1 == 0 { -1.0 } else { 1.0 };
            let [x, y, z] = [0, 1, 2].map(|axis| sign(axis) * half[axis as usize]);
            [x, y, z + top]
        };
        let corners: Vec<Vector> = (0..8).map(corner).collect();
        Mesh::convex(&corners).expect("a block has a hull")
    };
    let (block, table) = (block(HALF, 0.0), block([0.1, 0.1, 0.02], -0.02));
    let shell = PointShell::over(&block, points).expect("the points are not too many");
    let grid = DistanceGrid::new(&table, 0.002).expect("the grid fits the table");
    let table = table.with_grid(grid).expect("the grid is of the table");
    let shapes = [block.with_shell(shell), table].map(|mesh| Shape::Mesh(Arc::new(mesh)));
    let [block, table] = shapes;
    world(block, table, friction)
}

fn world(block: Shape, table: Shape, friction: f64) -> World {
    World {
        joints: Vec::new(),
        fields: Vec::new(),
        tools: vec![Tool::new("tool", block).turning()],
        bodies: vec![Body::new("table", table, Motion::Fixed)],
        contacts: vec![Contact {
            between: [Party::Any, Party::Any],
            law: ContactLaw::spring(5000.0)
                .with_damping(4.0)
                .with_friction(friction),
        }],
    }
}

/// An isotropic device that a hand presses down, moves across and tilts, integrated under a held wrench.
struct HandledDevice {
    position: Vector,
    velocity: Vector,
    orientation: Quaternion,
    turning: Vector,
}

impl HandledDevice {
    fn start() -> Self {
        Self {
            position: [0.0, 0.0, 0.03],
            velocity: [0.0; 3],
            orientation: [1.0, 0.0, 0.0, 0.0],
            turning: [0.0; 3],
        }
    }
}

impl Held for HandledDevice {
    fn place(&self) -> (Vector, Option<Quaternion>) {
        (self.position, Some(self.orientation))
    }

    fn hold(&mut self, output: &Output, time: f64) {
        let (force, torque) = (output.forces[0], output.torques[0]);
        let step = PERIOD / 20.0;
        for _ in 0..20 {
            let rest = [0.004 * (9.0 * time).sin(), 0.0, 0.008];
            // Rotation vector to the target for small angles.
            let aim = [0.05 * (7.0 * time).sin(), 0.08 * (5.0 * time).cos(), 0.0];
            let [w, x, y, z] = self.orientation;
            for (axis, angle) in [x, y, z].into_iter().enumerate() {
                let hand = 300.0 * (rest[axis] - self.position[axis]) - 3.0 * self.velocity[axis];
                self.velocity[axis] += (force[axis] + hand) / MASS * step;
                self.position[axis] += self.velocity[axis] * step;
                let hand = 0.5 * (aim[axis] - 2.0 * angle) - 0.005 * self.turning[axis];
                self.turning[axis] += (torque[axis] + hand) / INERTIA * step;
            }
            let [a, b, c] = self.turning.map(|rate| 0.5 * rate * step);
            let turned = [
                w - a * x - b * y - c * z,
                x + a * w + b * z - c * y,
                y + b * w + c * x - a * z,
                z + c * w + a * y - b * x,
            ];
            let length = turned.iter().map(|part| part * part).sum::<f64>().sqrt();
            self.orientation = turned.map(|part| part / length);
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
            .with_device_inertia(vec![[INERTIA, 1.3 * INERTIA, 1.4 * INERTIA]])
            .with_encoder_quantum(2e-6)
            .with_angle_quantum(3.5e-5)
            .into(),
    ];
    for method in &methods {
        for friction in [0.0, 0.5] {
            let name = |what: &str| format!("{}, {what}friction {friction}", method.name());
            print_ticks(
                &name(""),
                &box_on_table(friction),
                method,
                HandledDevice::start,
            );
            for (what, world) in cylinders(friction) {
                let what = format!("cylinder, {what}");
                print_ticks(&name(&what), &world, method, HandledDevice::start);
            }
            for points in [60, 200] {
                let world = points_on_grid(points, friction);
                let what = format!("{points} points, ");
                print_ticks(&name(&what), &world, method, HandledDevice::start);
            }
        }
    }
}
