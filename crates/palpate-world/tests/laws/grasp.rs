//! Two devices and friction: a cube is held in the air between two fingers.

use palpate_world::{
    BasicParams, Body, ContactLaw, CoupledParams, Free, Motion, Sample, Shape, Tool, Vector,
    WorldLoop, WorldMethod, WorldRenderer,
};

use crate::common::world;
use crate::ideal::{Ball, Ideal, Law, hold};

/// Height of a cube of 50 g at each sample of so many seconds `[m]`, while two hands press it with 2 N each and tremble.
fn heights(
    method: impl Into<WorldMethod>,
    friction: f64,
    period: f64,
    quantum: f64,
    seconds: f64,
) -> Vec<f64> {
    let half = 0.015;
    let weight = 9.81 * 0.05;
    let free = Free::of_mass(0.05).pulled_by([0.0, 0.0, -weight]);
    let shape = Shape::Box {
        half_extents: [half; 3],
    };
    let law = ContactLaw::spring(5000.0)
        .with_damping(1.0)
        .with_friction(friction);
    let cube = Body::new("cube", shape, Motion::Free(free));
    let mut world = world(0.008, vec![cube], law);
    world
        .tools
        .push(Tool::new("other", world.tools[0].shape.clone()));
    let renderer = WorldRenderer::new(&world, WorldLoop::new(period), method).unwrap();
    let mut state = renderer.start();
    let finger = |side: f64| Ball {
        // They begin as the cube rests between them.
        position: [side * (half + 0.008 - 2.0 / 5000.0), 0.0, 0.0],
        velocity: [0.0; 3],
        mass: [0.1, 0.16, 0.13],
        radius: 0.0,
        force: [0.0; 3],
        hand: (
            300.0,
            4.0,
            [
                side * (half + 0.008 - 2.0 / 5000.0 - 2.0 / 300.0),
                0.0,
                0.5 * weight / 300.0,
            ],
        ),
        turning: [0.0; 3],
        is_tool: true,
    };
    let none = Law {
        stiffness: 1.0,
        damping: 0.0,
        friction: 0.0,
    };
    let mut devices = Ideal::new(vec![finger(-1.0), finger(1.0)], Vec::new(), none);
    let mut heights = Vec::new();
    for sample in 0..(seconds / period).round() as usize {
        let time = sample as f64 * period;
        let positions: Vec<Vector> = devices
            .balls
            .iter()
            .map(|ball| ball.position.map(|x| quantum * (x / quantum).round()))
            .collect();
        let output = renderer.step(&mut state, &Sample::at(&positions));
        assert_eq!(output.fault, None);
        let forces = output.forces.to_vec();
        for (number, ball) in devices.balls.iter_mut().enumerate() {
            let tremor = |phase: f64| 0.05 * (std::f64::consts::TAU * 9.0 * time + phase).sin();
            ball.force = [0.0, 1.0, 2.0].map(|phase| tremor(phase + number as f64));
        }
        hold(&mut devices, &forces, period);
        heights.push(state.bodies()[0].position[2]);
    }
    heights
}

/// How far the cube sinks in 2 s `[m]`, with sensors of 2 um.
fn sinks(method: impl Into<WorldMethod>, friction: f64, period: f64) -> f64 {
    let heights = heights(method, friction, period, 2e-6, 2.0);
    -heights.last().unwrap()
}

/// The drift is how far the cube's mean height of the last second is from that of the second one: the tremor has whole
/// periods in a second.
#[test]
fn a_cube_that_is_pinched_for_ten_seconds_does_not_drift() {
    for (period, quantum, told) in [
        (0.001, 2e-6, 1.5),
        (0.001, 2e-6, 0.67),
        (0.001, 1e-5, 0.67),
        (0.004, 2e-6, 1.5),
    ] {
        let mass = [0.1, 0.16, 0.13].map(|mass| told * mass);
        let params = CoupledParams::new(vec![mass; 2]).with_encoder_quantum(quantum);
        let heights = heights(params, 0.8, period, quantum, 10.0);
        let second = heights.len() / 10;
        let mean = |seconds: usize| {
            let all = &heights[seconds * second..(seconds + 1) * second];
            all.iter().sum::<f64>() / second as f64
        };
        let drift = mean(9) - mean(1);
        println!(
            "{period} s, quantum {:.0} um, told {told} times the masses: drift {:.2} um from the second to the tenth \
             second",
            1e6 * quantum,
            1e6 * drift
        );
        assert!(drift.abs() < 5e-6, "{drift}");
    }
}

#[test]
fn two_fingers_hold_a_cube_by_friction_and_drop_it_without() {
    for period in [0.001, 0.004] {
        let told = CoupledParams::new(vec![[0.15, 0.24, 0.195]; 2]).with_encoder_quantum(2e-6);
        let coupled = sinks(told.clone(), 0.8, period);
        let slippery = sinks(told, 0.05, period);
        let basic = sinks(BasicParams::default(), 0.8, period);
        println!(
            "{period} s: the cube sinks by {:.3} mm, with a friction of 0.05 by {slippery:.1} m; by the sampled spring {:.3} mm",
            coupled * 1e3,
            basic * 1e3
        );
        // The hands give way by its weight: 0.49 N of 600 N/m is 0.8 mm.
        assert!(coupled.abs() < 0.0002, "{coupled}");
        assert!(slippery > 1.0, "{slippery}");
    }
}
