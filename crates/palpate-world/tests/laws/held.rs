//! Scenes held for a long time, for any method: a cube between two fingers, a point in a groove, a light box on a
//! tool. Devices and hands are those of [`ideal`](super::ideal). Each scene returns `None` if a sample was rejected.
#![allow(dead_code, reason = "each test program uses its own part")]

use palpate_world::{
    Body, ContactLaw, Free, Motion, Sample, Shape, SphereAt, Tool, Vector, World, WorldLoop,
    WorldMethod, WorldRenderer,
};

use super::common::{plane, world};
use super::ideal::{Ball, Ideal, Law, dot, hold};

/// Returns devices without a world, which the renderer simulates.
fn devices(balls: Vec<Ball>) -> Ideal {
    let none = Law {
        stiffness: 1.0,
        damping: 0.0,
        friction: 0.0,
    };
    Ideal::new(balls, Vec::new(), none)
}

fn device(position: Vector, mass: Vector, hand: (f64, f64, Vector)) -> Ball {
    Ball {
        position,
        velocity: [0.0; 3],
        mass,
        radius: 0.0,
        force: [0.0; 3],
        hand,
        turning: [0.0; 3],
        is_tool: true,
    }
}

fn measured(position: Vector, quantum: f64) -> Vector {
    if quantum > 0.0 {
        position.map(|x| quantum * (x / quantum).round())
    } else {
        position
    }
}

/// Returns a renderer of a world in a loop with this period, by a method for the world's tools.
fn renderer(world: &World, period: f64, method: impl Into<WorldMethod>) -> WorldRenderer {
    WorldRenderer::new(world, WorldLoop::new(period), method).unwrap()
}

/// Masses of each of the two fingers along the axes `[kg]`.
pub const FINGER: Vector = [0.1, 0.16, 0.13];
/// Stiffness of the contacts of the pinched cube `[N/m]`.
pub const PINCHED: f64 = 5000.0;

/// Returns the height of a cube of 50 g at each sample for a number of seconds `[m]`, while two trembling hands press
/// it with 2 N each. The record ends once the cube has moved 2 m.
pub fn heights(
    method: impl Into<WorldMethod>,
    friction: f64,
    period: f64,
    quantum: f64,
    seconds: f64,
) -> Option<Vec<f64>> {
    let half = 0.015;
    let weight = 9.81 * 0.05;
    let free = Free::of_mass(0.05).pulled_by([0.0, 0.0, -weight]);
    let shape = Shape::Box {
        half_extents: [half; 3],
    };
    let law = ContactLaw::spring(PINCHED)
        .with_damping(1.0)
        .with_friction(friction);
    let cube = Body::new("cube", shape, Motion::Free(free));
    let mut world = world(0.008, vec![cube], law);
    world
        .tools
        .push(Tool::new("other", world.tools[0].shape.clone()));
    let renderer = renderer(&world, period, method);
    let mut state = renderer.start();
    let finger = |side: f64| {
        // The fingers start at their rest positions on the cube.
        let touches = half + 0.008 - 2.0 / PINCHED;
        let rest = [side * (touches - 2.0 / 300.0), 0.0, 0.5 * weight / 300.0];
        device([side * touches, 0.0, 0.0], FINGER, (300.0, 4.0, rest))
    };
    let mut devices = devices(vec![finger(-1.0), finger(1.0)]);
    let mut heights = Vec::new();
    for sample in 0..(seconds / period).round() as usize {
        let time = sample as f64 * period;
        let balls = devices.balls.iter();
        let positions: Vec<Vector> = balls.map(|it| measured(it.position, quantum)).collect();
        let output = renderer.step(&mut state, &Sample::at(&positions));
        if output.fault.is_some() {
            return None;
        }
        let forces = output.forces.to_vec();
        for (number, ball) in devices.balls.iter_mut().enumerate() {
            let tremor = |phase: f64| 0.05 * (std::f64::consts::TAU * 9.0 * time + phase).sin();
            ball.force = [0.0, 1.0, 2.0].map(|phase| tremor(phase + number as f64));
        }
        hold(&mut devices, &forces, period);
        let cube = state.bodies()[0].position;
        heights.push(cube[2]);
        if dot(cube, cube) > 4.0 {
            break;
        }
    }
    Some(heights)
}

/// Returns the difference between the mean heights of the last of ten seconds and the second one `[m]`. The tremor
/// has whole periods in a second. `None` if the cube has been lost.
pub fn drift(method: impl Into<WorldMethod>, period: f64, quantum: f64) -> Option<f64> {
    let heights = heights(method, 0.8, period, quantum, 10.0)?;
    let second = (1.0 / period).round() as usize;
    let mean = |seconds: usize| {
        let all = heights.get(seconds * second..(seconds + 1) * second)?;
        Some(all.iter().sum::<f64>() / second as f64)
    };
    Some(mean(9)? - mean(1)?)
}

/// Masses of the device that is pressed into a groove, along the axes `[kg]`.
pub const PRESSED: Vector = [0.12, 0.2, 0.15];

/// Final results for a point in a groove.
pub struct Pressed {
    /// Largest proxy offset in the second and in the last second `[m]`.
    pub offset: [f64; 2],
    /// Mean force along z over the last second, relative to the hand's pressing force, minus 1.
    pub mean: f64,
    /// Standard deviation of that force, relative to its mean.
    pub ripple: f64,
    /// Mean device position in the last second, above the position at which the wall springs carry the hand's force
    /// there without friction `[m]`.
    pub place: f64,
}

/// Presses a point into a groove with a trembling hand for a number of seconds, with sensors of 2 um.
pub fn pressed(
    method: impl Into<WorldMethod>,
    period: f64,
    stiffness: f64,
    friction: f64,
    seconds: f64,
) -> Option<Pressed> {
    let (lean, radius) = (0.8_f64, 0.005);
    let groove: Vec<Body> = [lean, -lean]
        .map(|lean| plane(&format!("side {lean}"), [lean.sin(), 0.0, lean.cos()]))
        .into();
    let law = ContactLaw::spring(stiffness)
        .with_damping(1.0)
        .with_friction(friction);
    let renderer = renderer(&world(radius, groove, law), period, method);
    let mut state = renderer.start();
    let rest: Vector = [0.0, 0.0, -0.01];
    let mut devices = devices(vec![device([0.0, 0.0, 0.012], PRESSED, (300.0, 3.0, rest))]);
    let samples = (seconds / period).round() as usize;
    let mut offsets = [0.0_f64; 2];
    let (mut forces, mut heights) = (Vec::new(), Vec::new());
    for sample in 0..samples {
        let time = sample as f64 * period;
        let position = measured(devices.balls[0].position, 2e-6);
        let output = renderer.step(&mut state, &Sample::at(&[position]));
        if output.fault.is_some() {
            return None;
        }
        let force = output.forces[0];
        let offset = state.tools()[0].offset;
        let offset = dot(offset, offset).sqrt();
        if (1.0..2.0).contains(&time) {
            offsets[0] = offsets[0].max(offset);
        }
        let tremor = |phase: f64| 0.1 * (std::f64::consts::TAU * 9.0 * time + phase).sin();
        devices.balls[0].force = [tremor(0.0), tremor(1.0), tremor(2.0)];
        if time >= seconds - 1.0 {
            offsets[1] = offsets[1].max(offset);
            forces.push(force[2]);
            heights.push(devices.balls[0].position[2]);
        }
        hold(&mut devices, &[force], period);
    }
    let count = forces.len() as f64;
    let mean = forces.iter().sum::<f64>() / count;
    let apart: f64 = forces.iter().map(|force| (force - mean).powi(2)).sum();
    let height = heights.iter().sum::<f64>() / count;
    // 2 K cos(lean) (radius - z cos(lean)) = 300 (z - rest)
    let walls = 2.0 * stiffness * lean.cos();
    let balance = (walls * radius + 300.0 * rest[2]) / (walls * lean.cos() + 300.0);
    Some(Pressed {
        offset: offsets,
        mean: mean / (300.0 * (height - rest[2])) - 1.0,
        ripple: (apart / count).sqrt() / mean,
        place: height - balance,
    })
}

/// Mass of the light box and of each axis of the device below it `[kg]`, and the loop period `[s]`.
pub const LIGHT: f64 = 0.05;
pub const TRAY: f64 = 0.25;
pub const RESTING_PERIOD: f64 = 0.01;

/// Returns the total stiffness of the four contacts with K T^2/M = `kc` of the light box `[N/m]`.
pub fn resting_stiffness(kc: f64) -> f64 {
    kc * LIGHT / (RESTING_PERIOD * RESTING_PERIOD)
}

/// A light box on a tray, in the last of 4 s.
pub struct Resting {
    /// Largest deviation of the force on the tool from its mean, relative to the weight.
    pub ripple: f64,
    /// Mean force on the tool relative to the weight, positive downwards.
    pub mean: f64,
    /// Mean height of the box above the device, below the height at which its contacts carry its weight `[m]`.
    pub place: f64,
}

/// A light box on a tray of four spheres, held by a hand at 100 Hz. `kc` is K T^2/M of all four together. `None` if
/// the tray does not carry the weight at the end.
pub fn resting(method: impl Into<WorldMethod>, kc: f64, quantum: f64) -> Option<Resting> {
    let weight = 9.81 * LIGHT;
    let stiffness = resting_stiffness(kc);
    let reduced = LIGHT * TRAY / (LIGHT + TRAY);
    let law = ContactLaw::spring(0.25 * stiffness)
        .with_damping(0.25 * 0.02 * (stiffness * reduced).sqrt());
    let shape = Shape::Box {
        half_extents: [0.03, 0.03, 0.01],
    };
    let free = Free::of_mass(LIGHT).pulled_by([0.0, 0.0, -weight]);
    // It is released a tenth of a millimetre above the tray.
    let object = Body::new("box", shape, Motion::Free(free)).at([0.0, 0.0, 0.0151]);
    let mut world = world(0.005, vec![object], law);
    let spheres = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
    world.tools[0].shape = Shape::Spheres {
        spheres: spheres
            .map(|[x, y]| SphereAt {
                centre: [0.02 * x, 0.02 * y, 0.0],
                radius: 0.005,
            })
            .into(),
    };
    let renderer = renderer(&world, RESTING_PERIOD, method);
    let mut state = renderer.start();
    let mut devices = devices(vec![device([0.0; 3], [TRAY; 3], (300.0, 3.0, [0.0; 3]))]);
    let (mut forces, mut heights) = (Vec::new(), Vec::new());
    for _ in 0..400 {
        let position = measured(devices.balls[0].position, quantum);
        let output = renderer.step(&mut state, &Sample::at(&[position]));
        if output.fault.is_some() {
            return None;
        }
        let force = output.forces[0];
        forces.push(force[2]);
        heights.push(state.bodies()[0].position[2] - devices.balls[0].position[2]);
        hold(&mut devices, &[force], RESTING_PERIOD);
    }
    let mean = |all: &[f64]| all[300..].iter().sum::<f64>() / 100.0;
    let force = mean(&forces);
    let off = forces[300..].iter().map(|it| (it - force).abs());
    let resting = Resting {
        ripple: off.fold(0.0, f64::max) / weight,
        mean: -force / weight,
        place: 0.015 - weight / stiffness - mean(&heights),
    };
    ((resting.mean - 1.0).abs() < 0.1).then_some(resting)
}
