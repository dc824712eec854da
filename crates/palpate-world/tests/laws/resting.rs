//! What is pressed for long, or lies on a tool, stays.

use palpate_world::{Body, ContactLaw, CoupledParams, Sample, Vector, WorldLoop, WorldRenderer};

use crate::common::{plane, world};
use crate::ideal::{Ball, Ideal, Law, dot, hold};

/// Presses a point into a groove with a hand that trembles, for 10 s: the largest offset in the second and in the last
/// second `[m]`, and the mean force along z over the last second, relative to what the hand presses with.
fn pressed(period: f64, stiffness: f64, friction: f64) -> [f64; 3] {
    let mass = [0.12, 0.2, 0.15];
    let lean = 0.8_f64;
    let groove: Vec<Body> = [lean, -lean]
        .map(|lean| plane(&format!("side {lean}"), [lean.sin(), 0.0, lean.cos()]))
        .into();
    let law = ContactLaw::spring(stiffness)
        .with_damping(1.0)
        .with_friction(friction);
    let told = CoupledParams::new(vec![mass.map(|mass| 1.5 * mass)]).with_encoder_quantum(2e-6);
    let renderer = WorldRenderer::new(&world(0.005, groove, law), WorldLoop::new(period), told);
    let renderer = renderer.unwrap();
    let mut state = renderer.start();
    let rest: Vector = [0.0, 0.0, -0.01];
    let device = Ball {
        position: [0.0, 0.0, 0.012],
        velocity: [0.0; 3],
        mass,
        radius: 0.0,
        force: [0.0; 3],
        hand: (300.0, 3.0, rest),
        turning: [0.0; 3],
        is_tool: true,
    };
    let none = Law {
        stiffness: 1.0,
        damping: 0.0,
        friction: 0.0,
    };
    let mut devices = Ideal::new(vec![device], Vec::new(), none);
    let samples = (10.0 / period) as usize;
    let (mut early, mut late, mut mean, mut pushed) = (0.0_f64, 0.0_f64, 0.0, 0.0);
    for sample in 0..samples {
        let time = sample as f64 * period;
        let position: Vector = devices.balls[0].position.map(|x| 2e-6 * (x / 2e-6).round());
        let output = renderer.step(&mut state, &Sample::at(&[position]));
        assert_eq!(output.fault, None);
        let force = output.forces[0];
        let offset = state.tools()[0].offset;
        let offset = dot(offset, offset).sqrt();
        if (1.0..2.0).contains(&time) {
            early = early.max(offset);
        }
        let tremor = |phase: f64| 0.1 * (std::f64::consts::TAU * 9.0 * time + phase).sin();
        devices.balls[0].force = [tremor(0.0), tremor(1.0), tremor(2.0)];
        if time >= 9.0 {
            late = late.max(offset);
            mean += force[2];
            pushed += 300.0 * (devices.balls[0].position[2] - rest[2]);
        }
        hold(&mut devices, &[force], period);
    }
    [early, late, mean / pushed - 1.0]
}

#[test]
fn pressed_into_a_groove_for_long_the_offset_does_not_drift() {
    for (period, stiffness, friction) in [(0.001, 2e4, 0.0), (0.001, 2e4, 0.4), (0.01, 1000.0, 0.0)]
    {
        let [early, late, mean] = pressed(period, stiffness, friction);
        println!(
            "{period} s, {stiffness} N/m, friction {friction}: offset {:.1} um in the second, {:.1} um in the last \
             second; mean force off by {:.3} %",
            early * 1e6,
            late * 1e6,
            mean * 100.0
        );
        assert!(late < 1.5 * early + 2e-5, "{early} {late}");
        assert!(mean.abs() < 0.02, "{mean}");
    }
}
