//! Time per tick on a mesh: `cargo bench -p palpate-world --bench mesh_tick`.
//!
//! A tool is pressed onto a bumpy ball of 100 000 triangles with radius 100 mm and moved around on it. Every tick of
//! a run is timed. Each reported time is the minimum over several identical runs, because any excess is due to other
//! programs.
#![allow(clippy::print_stdout)] // a benchmark prints

mod timed;

use std::sync::Arc;
use std::time::Instant;

use palpate_world::{
    BasicParams, Body, Contact, ContactLaw, CoupledParams, Mesh, Motion, Output, Party, Quaternion,
    Shape, Tool, Vector, World, WorldMethod,
};

use timed::{Held, PERIOD, print_heading, print_ticks};

const MASS: f64 = 0.15;
const RADIUS: f64 = 0.1;

/// Returns a cube with `cells` by `cells` squares per side, projected onto a ball.
fn bumps(cells: u32) -> Mesh {
    let row = cells + 1;
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    let sides = (0..3).flat_map(|axis| [(axis, -1.0), (axis, 1.0)]);
    for (side, (axis, far)) in (0_u32..).zip(sides) {
        let first = side * row * row;
        for (i, j) in (0..row).flat_map(|i| (0..row).map(move |j| (i, j))) {
            // Equal angles give triangles of similar size.
            let tangent = |k: u32| {
                let share = 2.0 * f64::from(k) / f64::from(cells) - 1.0;
                (std::f64::consts::FRAC_PI_4 * share).tan()
            };
            let mut out = [far; 3];
            out[(axis + 1) % 3] = tangent(i);
            out[(axis + 2) % 3] = tangent(j);
            let length = out.iter().map(|x| x * x).sum::<f64>().sqrt();
            let out = out.map(|x| x / length);
            let bump: f64 = out.iter().map(|x| (25.0 * x).sin()).product();
            vertices.push(out.map(|x| x * (RADIUS + 0.001 * bump)));
        }
        for (i, j) in (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))) {
            let [a, d] = [first + i * row + j, first + i * row + j + 1];
            let [b, c] = [a + row, d + row];
            for [x, y, z] in [[a, b, c], [a, c, d]] {
                faces.push(if far > 0.0 { [x, y, z] } else { [x, z, y] });
            }
        }
    }
    // Coincident vertices of adjacent sides are merged.
    Mesh::new(&vertices, &faces).expect("a closed mesh by formula")
}

/// A device that a hand presses towards the ball's centre and moves around it, integrated under held forces.
struct HandledDevice {
    position: Vector,
    velocity: Vector,
}

impl Held for HandledDevice {
    fn place(&self) -> (Vector, Option<Quaternion>) {
        (self.position, None)
    }

    fn hold(&mut self, output: &Output, time: f64) {
        let force = output.forces[0];
        let rest = [
            0.05 * (3.0 * time).sin(),
            0.06 * (2.0 * time).sin(),
            0.088 - 0.02 * (2.5 * time).sin().powi(2),
        ];
        for _ in 0..20 {
            for axis in 0..3 {
                let hand = 150.0 * (rest[axis] - self.position[axis]) - 3.0 * self.velocity[axis];
                self.velocity[axis] += (force[axis] + hand) / MASS * PERIOD / 20.0;
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
    let began = Instant::now();
    let mesh = Arc::new(bumps(91));
    println!(
        "{} triangles, made ready in {:.0} ms",
        mesh.faces().len(),
        1e3 * began.elapsed().as_secs_f64()
    );
    print_heading();
    let methods: [WorldMethod; 2] = [
        BasicParams::default().into(),
        CoupledParams::new(vec![[MASS; 3]])
            .with_encoder_quantum(2e-6)
            .into(),
    ];
    for method in &methods {
        for radius in [0.0, 0.003, 0.008] {
            let name = format!("{}, tool of {} mm", method.name(), 1e3 * radius);
            let world = World {
                joints: Vec::new(),
                fields: Vec::new(),
                tools: vec![Tool::new("tool", Shape::Sphere { radius })],
                bodies: vec![Body::new("bumps", Shape::Mesh(mesh.clone()), Motion::Fixed)],
                contacts: vec![Contact {
                    between: [Party::Any, Party::Any],
                    law: ContactLaw::spring(2000.0)
                        .with_damping(2.0)
                        .with_friction(0.3),
                }],
            };
            print_ticks(&name, &world, method, || HandledDevice {
                position: [0.0, 0.0, RADIUS + radius + 0.004],
                velocity: [0.0; 3],
            });
        }
    }
}
