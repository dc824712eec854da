//! Joints: what they let move moves by its closed form, and momenta and energy stay.

use palpate_testbed::world::{Freedom, Shape, WorldJoint, WorldScene};

use super::{body, motion, solve};

const SHAPE: Shape = Shape::Box {
    half_extents: [0.03, 0.02, 0.01],
};

fn joint(freedom: Freedom, against: Option<usize>) -> WorldJoint {
    WorldJoint {
        body: 0,
        against,
        freedom,
        point: [0.0; 3],
        axis: [0.0, 1.0, 0.0],
        stiffness: 8000.0,
        damping: 0.0,
        span: 0.03,
        spring: 0.0,
        rest: 0.0,
        along_damping: 0.0,
        limits: None,
    }
}

#[test]
fn a_slider_swings_on_its_spring_with_damping_and_goes_as_far_beyond_a_stop_as_that_gives_way() {
    let scene = |joint| WorldScene {
        bodies: vec![body(SHAPE, 0.1, [0.0; 3])],
        fields: Vec::new(),
        joints: vec![joint],
        ..WorldScene::default()
    };
    let (spring, damping) = (40.0, 0.4);
    let swing = WorldJoint {
        spring,
        rest: 0.01,
        along_damping: damping,
        ..joint(Freedom::Slide, None)
    };
    let ideal = solve(&scene(swing), 0.01, 100);
    let (half, square) = (0.5 * damping / 0.1, spring / 0.1);
    let omega = (square - half * half).sqrt();
    let mut off = 0.0_f64;
    for state in &ideal.states {
        let t = state.time;
        let swing = (omega * t).cos() + half / omega * (omega * t).sin();
        let expected = 0.01 - 0.01 * (-half * t).exp() * swing;
        off = off.max((state.bodies[0].position[1] - expected).abs());
    }
    println!("slider: {off:.1e} m from a damped swing");
    assert!(off < 1e-10, "{off}");

    let stops = WorldJoint {
        limits: Some([-0.02, 0.005]),
        ..joint(Freedom::Slide, None)
    };
    let mut thrown = scene(stops);
    motion(&mut thrown.bodies[0]).velocity = [0.0, 0.3, 0.0];
    let ideal = solve(&thrown, 0.0001, 1000);
    let most = ideal
        .states
        .iter()
        .map(|state| state.bodies[0].position[1])
        .fold(0.0, f64::max);
    let expected = 0.005 + 0.3 * (0.1_f64 / 8000.0).sqrt();
    println!("stop: {most:.6} m, {expected:.6} m by its spring");
    assert!((most - expected).abs() < 1e-6, "{most}");
}

#[test]
fn two_bodies_on_a_joint_keep_momentum_angular_momentum_and_energy() {
    for freedom in [Freedom::Turn, Freedom::Slide] {
        for damped in [0.0, 1.0] {
            let turns = freedom == Freedom::Turn;
            let held = WorldJoint {
                point: [0.03, 0.0, 0.0],
                axis: [0.0, 0.8, 0.6],
                damping: 8.0 * damped,
                spring: if turns { 0.02 } else { 60.0 },
                rest: 0.003,
                along_damping: damped * if turns { 1e-4 } else { 0.2 },
                limits: Some(if turns { [-0.4, 0.5] } else { [-0.004, 0.006] }),
                ..joint(freedom, Some(1))
            };
            let mut bodies = vec![
                body(SHAPE, 0.1, [0.0; 3]),
                body(SHAPE, 0.06, [0.06, 0.0, 0.0]),
            ];
            motion(&mut bodies[0]).velocity = [0.1, -0.2, 0.05];
            motion(&mut bodies[0]).angular_velocity = [4.0, 3.0, -5.0];
            motion(&mut bodies[1]).velocity = [0.0, 0.3, 0.0];
            motion(&mut bodies[1]).angular_velocity = [-2.0, 1.0, 3.0];
            let scene = WorldScene {
                bodies,
                fields: Vec::new(),
                joints: vec![held],
                ..WorldScene::default()
            };
            let ideal = solve(&scene, 0.005, 60);
            let sums = |number: usize| {
                let mut sums = [0.0; 6];
                for (body, state) in scene.bodies.iter().zip(&ideal.states[number].bodies) {
                    let mass = body.motion.unwrap().mass;
                    let ([x, y, z], [u, v, w]) = (state.position, state.velocity);
                    let orbital = [y * w - z * v, z * u - x * w, x * v - y * u];
                    for axis in 0..3 {
                        sums[axis] += mass * state.velocity[axis];
                        sums[3 + axis] += mass * orbital[axis] + state.angular_momentum[axis];
                    }
                }
                sums
            };
            let (before, start) = (sums(0), ideal.states[0].ledger);
            let (mut worst, mut drift) = (0.0_f64, 0.0_f64);
            for (number, state) in ideal.states.iter().enumerate() {
                for (a, b) in sums(number).iter().zip(before) {
                    worst = worst.max((a - b).abs());
                }
                drift = drift.max((state.ledger.balance() - start.balance()).abs() / start.kinetic);
            }
            let dissipated = ideal.states.last().unwrap().ledger.dissipated;
            println!(
                "{freedom:?}, damping {damped}: momenta to {worst:.1e}, energy to {drift:.1e}, {dissipated:.1e} J dissipated"
            );
            assert!(worst < 1e-14 && drift < 1e-8, "{worst} {drift}");
            assert_eq!(dissipated > 1e-4, damped > 0.0);
        }
    }
}
