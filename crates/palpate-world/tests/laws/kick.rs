//! Unexpected events: a device that stops within a sample, a sensor that jumps, lost samples.

use palpate_world::{
    ContactLaw, CoupledParams, Sample, Shape, Tool, Vector, World, WorldLoop, WorldRenderer,
};

use crate::common::{plane, world};

const PERIOD: f64 = 0.001;
const STIFFNESS: f64 = 3000.0;
const RADIUS: f64 = 0.004;

fn floor() -> World {
    let law = ContactLaw::spring(STIFFNESS).with_damping(1.0);
    world(RADIUS, vec![plane("floor", [0.0, 0.0, 1.0])], law)
}

fn renderer(world: &World, mass: f64, quantum: f64) -> WorldRenderer {
    let model = CoupledParams::new(vec![[mass; 3]]).with_encoder_quantum(quantum);
    WorldRenderer::new(world, WorldLoop::new(PERIOD), model).unwrap()
}

/// Returns the forces along z on a tool with a prescribed path.
fn along(path: impl Fn(u32) -> f64, samples: u32, mass: f64, quantum: f64) -> Vec<f64> {
    let renderer = renderer(&floor(), mass, quantum);
    let mut state = renderer.start();
    (0..samples)
        .map(|sample| {
            let output = renderer.step(&mut state, &Sample::at(&[[0.0, 0.0, path(sample)]]));
            assert_eq!(output.fault, None);
            output.forces[0][2]
        })
        .collect()
}

#[test]
fn a_device_that_stops_within_a_sample_feels_the_depth_at_which_it_stopped() {
    let fall = |sample: u32| 0.009 - 0.3 * PERIOD * f64::from(sample.min(20));
    let deepest = STIFFNESS * (RADIUS - fall(20));
    for mass in [f64::INFINITY, 1.0, 0.2, 0.05] {
        for quantum in [0.0, 1e-6, 1e-5] {
            let forces = along(fall, 400, mass, quantum);
            let most = forces
                .iter()
                .fold(0.0_f64, |most, force| most.max(force.abs()));
            assert!(most < 1.5 * deepest, "{mass} kg, {quantum} m: {most} N");
            let off = forces[25..]
                .iter()
                .map(|force| (force / deepest - 1.0).abs());
            let off = off.fold(0.0, f64::max);
            assert!(off < 0.02, "{mass} kg, {quantum} m: off by {off}");
        }
    }
}

/// Returns the results for a device of 0.2 kg pressed with 3 N. `measured` is its sensor reading per sample; samples
/// with `is_lost` do not arrive.
fn pressed(
    measured: impl Fn(u32, f64) -> f64,
    is_lost: impl Fn(u32) -> bool,
    samples: u32,
) -> Vec<(f64, f64)> {
    let renderer = renderer(&floor(), 0.2, 0.0);
    let mut state = renderer.start();
    let (mut position, mut velocity, mut force, mut since) = (RADIUS + 0.005, 0.0_f64, 0.0, 0.0);
    let mut model = Vec::new();
    for sample in 0..samples {
        since += PERIOD;
        if !is_lost(sample) {
            let at: Vector = [0.0, 0.0, measured(sample, position)];
            let mut one = Sample::at(std::slice::from_ref(&at));
            one.elapsed = (sample > 0).then_some(since);
            let output = renderer.step(&mut state, &one);
            (force, since) = (output.forces[0][2].clamp(-20.0, 20.0), 0.0);
        }
        for _ in 0..50 {
            let step = PERIOD / 50.0;
            velocity += (force - 3.0 - 1.5 * velocity) / 0.2 * step;
            position += velocity * step;
        }
        model.push((RADIUS - position, force));
    }
    model
}

#[test]
fn a_sample_that_is_wrong_once_is_over_with_the_next_ones() {
    for jump in [1e-4, -1e-4, 1e-3, -1e-3, 5e-3] {
        let model = pressed(
            |sample, at| if sample == 2000 { at + jump } else { at },
            |_| false,
            4000,
        );
        let (depth, force) = model[3999];
        assert!((force - 3.0).abs() < 0.05, "{jump} m: {force} N");
        assert!((depth - 1e-3).abs() < 1.5e-4, "{jump} m: {depth} m deep");
        let shaken = model[2050..].iter().map(|(_, force)| (force - 3.0).abs());
        assert!(shaken.fold(0.0, f64::max) < 1.0, "{jump} m");
    }
}

#[test]
fn a_floor_comes_back_to_its_place_after_missing_samples() {
    // The device falls into the floor while no sample arrives.
    let model = pressed(
        |_, at| at,
        |sample| (30..60).contains(&sample) && sample % 8 != 0,
        12_000,
    );
    let deep = model[11_999].0;
    assert!((deep - 1e-3).abs() < 6e-4, "{deep} m deep");
    let mut furthest = 0.0_f64;
    for first in 18..32 {
        let is_lost = |sample: u32| (first..first + 12).contains(&sample);
        let model = pressed(|_, at| at, is_lost, 12_000);
        let [early, late] = [500, 11_999].map(|sample: usize| (model[sample].0 - 1e-3).abs());
        furthest = furthest.max(early);
        assert!(
            late < 6e-4,
            "12 samples from {first} on: {early} m after half a second, {late} m after twelve"
        );
    }
    assert!(furthest > 1.2e-3, "{furthest} m");
}

/// A six-axis box lies on the floor under 4 N; its sensors fail once.
#[test]
fn a_pose_that_is_wrong_once_is_over_with_the_next_ones() {
    let law = ContactLaw::spring(4000.0).with_damping(1.0);
    let half_extents = [0.03, 0.02, 0.01];
    let mut world = world(RADIUS, vec![plane("floor", [0.0, 0.0, 1.0])], law);
    world.tools = vec![Tool::new("tool", Shape::Box { half_extents }).turning()];
    let model = CoupledParams::new(vec![[0.2; 3]]).with_device_inertia(vec![[4e-5, 8e-5, 1e-4]]);
    let renderer = WorldRenderer::new(&world, WorldLoop::new(PERIOD), model).unwrap();
    for (jump, turn) in [(1e-4, 0.0), (0.0, 0.005), (0.0, 0.02), (-2e-4, -0.01)] {
        let mut state = renderer.start();
        let mut largest = [0.0_f64; 2];
        for sample in 0..1200 {
            let is_wrong = sample == 600;
            let (jump, turn) = if is_wrong { (jump, turn) } else { (0.0, 0.0) };
            let (sine, cosine) = (0.5_f64 * turn).sin_cos();
            // Prescribed position: held where it presses with 4 N, after a slow approach.
            let depth = 1e-3 * (f64::from(sample) / 300.0).min(1.0);
            let at = [[0.0, 0.0, 0.01 - depth + jump]];
            let orientations = [[cosine, sine, 0.0, 0.0]];
            let output = renderer.step(&mut state, &Sample::at(&at).turned(&orientations));
            assert_eq!(output.fault, None);
            if sample > 610 {
                largest[0] = largest[0].max((output.forces[0][2] - 4.0).abs());
                let torque = output.torques[0].iter().map(|x| x * x).sum::<f64>();
                largest[1] = largest[1].max(torque.sqrt());
            }
        }
        let [force, torque] = largest;
        assert!(
            force < 0.1 && torque < 2e-3,
            "{jump} m, {turn} rad: {force} N, {torque} N m"
        );
    }
}
