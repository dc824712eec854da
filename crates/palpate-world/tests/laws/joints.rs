//! Hinges and sliders: free motion along the joint, small motion otherwise, energy ledger and momenta.

use std::f64::consts::TAU;

use palpate_world::{
    Body, CoupledParams, Free, Joint, JointKind, JointLaw, Motion, Sample, Shape, Tool, Vector,
    World, WorldLoop, WorldRenderer, WorldState,
};

use crate::balance::energy;
use crate::common::leave_alone;
use crate::tumbling::{mass_and_moments, momenta};

const SIZE: Vector = [0.06, 0.04, 0.02];

fn block(name: &str, mass: f64, free: impl FnOnce(Free) -> Free) -> Body {
    let half_extents = SIZE.map(|x| 0.5 * x);
    let motion = Motion::Free(free(Free::of_mass(mass)));
    Body::new(name, Shape::Box { half_extents }, motion)
}

fn joint(
    kind: JointKind,
    against: Option<&str>,
    point: Vector,
    axis: Vector,
    law: JointLaw,
) -> Joint {
    Joint {
        body: "one".into(),
        against: against.map(Into::into),
        kind,
        point,
        axis,
        law,
    }
}

fn started(bodies: Vec<Body>, joints: Vec<Joint>) -> (WorldRenderer, WorldState) {
    let world = World {
        fields: Vec::new(),
        tools: vec![Tool::new("tool", Shape::Sphere { radius: 0.005 })],
        bodies,
        joints,
        contacts: Vec::new(),
    };
    let method = CoupledParams::new(vec![[0.1; 3]]);
    let renderer = WorldRenderer::new(&world, WorldLoop::new(0.001), method).unwrap();
    let state = renderer.start();
    (renderer, state)
}

/// Returns the moments of inertia of a block `[kg m^2]`.
fn moments(mass: f64) -> Vector {
    let [a, b, c] = SIZE.map(|x| x * x * mass / 12.0);
    [b + c, a + c, a + b]
}

#[test]
fn a_block_on_a_hinge_is_a_pendulum() {
    let (mass, arm, stiffness) = (0.1, 0.05, 2e4);
    let block = block("one", mass, |free| free.pulled_by([0.0, 0.0, -9.81 * mass]));
    let law = JointLaw::new(stiffness, 0.03);
    let lean: f64 = 0.02;
    // The block starts at a small angle from the hinge's vertical.
    let place = [arm * lean.sin(), 0.0, -arm * lean.cos()];
    let turned = [(0.5 * lean).cos(), 0.0, -(0.5 * lean).sin(), 0.0];
    let hinge = joint(JointKind::Hinge, None, [0.0; 3], [0.0, 1.0, 0.0], law);
    let (renderer, mut state) = started(vec![block.at(place).turned(turned)], vec![hinge]);
    let moment = moments(mass)[1] + mass * arm * arm;
    let period = TAU * (moment / (mass * 9.81 * arm)).sqrt();
    let (start, mut crossings, mut drift) = (energy(&state), Vec::new(), 0.0_f64);
    let mut aside = 0.0_f64;
    let mut before = place[0];
    for sample in 1..=3000 {
        leave_alone(&renderer, &mut state, 1);
        let [x, y, z] = state.bodies()[0].position;
        if before > 0.0 && x <= 0.0 {
            crossings.push(0.001 * (f64::from(sample) - x / (x - before)));
        }
        before = x;
        drift = drift.max((energy(&state) - start).abs());
        aside = aside.max(y.abs()).max((x.hypot(z) - arm).abs());
    }
    let swings = crossings.len() - 1;
    let measured = (crossings[swings] - crossings[0]) / swings as f64;
    // The bearing yields to the weight, so the block hangs lower by this distance.
    println!(
        "pendulum: {measured:.5} s instead of {period:.5} s, energy to {drift:.1e} J, beside its way by {aside:.1e} m"
    );
    assert!(swings > 4 && (measured / period - 1.0).abs() < 1e-3);
    assert!(
        drift < 1e-7 && aside < 2.2 * mass * 9.81 / stiffness,
        "{drift} {aside}"
    );
}

#[test]
fn a_block_on_a_slider_swings_on_its_spring_and_comes_back_from_its_stops() {
    let (mass, spring) = (0.1, 40.0);
    let law = JointLaw {
        spring,
        rest: 0.01,
        ..JointLaw::new(2e4, 0.03)
    };
    let axis = [0.6, 0.0, 0.8];
    let slider = |law| vec![joint(JointKind::Slider, None, [0.0; 3], axis, law)];
    let along = |state: &WorldState| {
        let place = state.bodies()[0].position;
        let q: f64 = place.iter().zip(axis).map(|(x, a)| x * a).sum();
        let square: f64 = place.iter().map(|x| x * x).sum();
        (q, (square - q * q).max(0.0).sqrt())
    };
    let (renderer, mut state) = started(vec![block("one", mass, |free| free)], slider(law));
    let (mut off, mut aside) = (0.0_f64, 0.0_f64);
    let omega = (spring / mass).sqrt();
    for sample in 1..=1000 {
        leave_alone(&renderer, &mut state, 1);
        let expected = 0.01 - 0.01 * (omega * 0.001 * f64::from(sample - 1)).cos();
        let (q, across) = along(&state);
        off = off.max((q - expected).abs());
        aside = aside.max(across);
    }
    println!("slider: {off:.1e} m from the swing of a spring, {aside:.1e} m across");
    assert!(off < 1e-6 && aside < 1e-9, "{off} {aside}");

    let stops = JointLaw {
        limits: Some([-0.01, 0.015]),
        ..JointLaw::new(2e4, 0.03)
    };
    let speed = axis.map(|a| 0.3 * a);
    let thrown = block("one", mass, |free| free.moving(speed));
    let (renderer, mut state) = started(vec![thrown], slider(stops));
    let (start, mut drift) = (energy(&state), 0.0_f64);
    let (mut least, mut most) = (0.0_f64, 0.0_f64);
    for _ in 0..500 {
        leave_alone(&renderer, &mut state, 1);
        let (q, _) = along(&state);
        (least, most) = (least.min(q), most.max(q));
        drift = drift.max((energy(&state) / start - 1.0).abs());
    }
    // Deflection of a stop of 20 kN/m.
    let beyond = 0.3 * (mass / 2e4).sqrt();
    println!("stops: from {least:.5} to {most:.5} m, energy to {drift:.1e}");
    assert!((most - 0.015 - beyond).abs() < 0.03 * beyond, "{most}");
    assert!((-least - 0.01 - beyond).abs() < 0.03 * beyond, "{least}");
    assert!(drift < 1e-4, "{drift}");
}

/// Two flying, tumbling blocks connected by a hinge and by a slider, with or without springs, stops and damping.
#[test]
fn two_blocks_on_a_joint_keep_momentum_and_angular_momentum_and_without_damping_energy() {
    for kind in [JointKind::Hinge, JointKind::Slider] {
        for damped in [0.0, 1.0] {
            let law = JointLaw {
                damping: 8.0 * damped,
                spring: if kind == JointKind::Hinge { 0.02 } else { 60.0 },
                rest: 0.003,
                along_damping: damped * if kind == JointKind::Hinge { 1e-4 } else { 0.2 },
                limits: Some(if kind == JointKind::Hinge {
                    [-0.4, 0.5]
                } else {
                    [-0.004, 0.006]
                }),
                ..JointLaw::new(8000.0, 0.03)
            };
            let one = block("one", 0.1, |free| Free {
                velocity: [0.1, -0.2, 0.05],
                angular_velocity: [4.0, 3.0, -5.0],
                ..free
            });
            let other = block("other", 0.06, |free| Free {
                velocity: [0.0, 0.3, 0.0],
                angular_velocity: [-2.0, 1.0, 3.0],
                ..free
            });
            let bodies = vec![one, other.at([0.06, 0.0, 0.0])];
            let axis = [0.0, 0.8, 0.6];
            let of_bodies = bodies.iter().map(mass_and_moments).collect::<Vec<_>>();
            let (renderer, mut state) = started(
                bodies,
                vec![joint(kind, Some("other"), [0.03, 0.0, 0.0], axis, law)],
            );
            let (before, start) = (momenta(&state, &of_bodies), energy(&state));
            let stored = state.ledger().joints[0].stored;
            let (mut worst, mut drift, mut last) = (0.0_f64, 0.0_f64, 0.0);
            for _ in 0..400 {
                leave_alone(&renderer, &mut state, 1);
                for (a, b) in momenta(&state, &of_bodies).iter().zip(before) {
                    worst = worst.max((a - b).abs());
                }
                drift = drift.max((energy(&state) / start - 1.0).abs());
                let entry = state.ledger().joints[0];
                assert!(entry.dissipated >= last);
                last = entry.dissipated;
            }
            let entry = state.ledger().joints[0];
            let off = entry.stored - stored + entry.work + entry.dissipated - entry.step_error;
            println!(
                "{kind:?}, damping {damped}: momenta to {worst:.1e}, energy to {drift:.1e}, {:.1e} J dissipated, book off by \
                 {off:.1e}",
                entry.dissipated
            );
            assert!(worst < 1e-13 && off.abs() < 1e-15, "{worst} {off}");
            if damped > 0.0 {
                assert!(
                    entry.dissipated > 1e-4 && entry.step_error.abs() < 1e-2 * entry.dissipated
                );
            } else {
                assert!(drift < 1e-3 && entry.dissipated == 0.0, "{drift}");
            }
        }
    }
}

/// A button on a spring at its stop, for a minute: its position after a second, and the deviation from it in the last
/// second.
#[test]
fn a_button_pressed_for_a_minute_does_not_creep() {
    use crate::ideal::{Ball, Ideal, Law, hold};
    use palpate_world::{Contact, ContactLaw, Party};

    let weight = [0.0, 0.0, -0.2];
    let law = JointLaw {
        damping: 4.0,
        spring: 300.0,
        along_damping: 1.0,
        limits: Some([-0.004, 0.0005]),
        ..JointLaw::new(1e4, 0.02)
    };
    let world = World {
        tools: vec![Tool::new("tool", Shape::Sphere { radius: 0.005 })],
        bodies: vec![block("one", 0.02, |free| free.pulled_by(weight))],
        fields: Vec::new(),
        joints: vec![joint(
            JointKind::Slider,
            None,
            [0.0; 3],
            [0.0, 0.0, 1.0],
            law,
        )],
        contacts: vec![Contact {
            between: [Party::Any, Party::Any],
            law: ContactLaw::spring(4000.0)
                .with_damping(2.0)
                .with_friction(0.4),
        }],
    };
    let mass = [0.1, 0.16, 0.25];
    let model = CoupledParams::new(vec![mass.map(|mass| 1.5 * mass)]).with_encoder_quantum(2e-6);
    let period = 0.004;
    let renderer = WorldRenderer::new(&world, WorldLoop::new(period), model).unwrap();
    let mut state = renderer.start();
    let none = Law {
        stiffness: 1.0,
        damping: 0.0,
        friction: 0.0,
    };
    let device = Ball {
        position: [0.004, -0.003, 0.016],
        velocity: [0.0; 3],
        mass,
        radius: 0.0,
        force: [0.1, 0.0, -2.5],
        hand: (60.0, 1.5, [0.004, -0.003, 0.012]),
        turning: [0.0; 3],
        is_tool: true,
    };
    let mut devices = Ideal::new(vec![device], Vec::new(), none);
    let mut at = [0.0; 3];
    let (mut crept, mut deepest) = (0.0_f64, 0.0_f64);
    for sample in 0..15_000 {
        let position: Vector = devices.balls[0].position.map(|x| 2e-6 * (x / 2e-6).round());
        let output = renderer.step(&mut state, &Sample::at(&[position]));
        assert_eq!(output.fault, None);
        hold(&mut devices, &[output.forces[0]], period);
        let place = state.bodies()[0].position;
        if sample == 500 {
            at = place;
        }
        if sample >= 14_750 {
            for axis in 0..3 {
                crept = crept.max((place[axis] - at[axis]).abs());
            }
            deepest = deepest.min(place[2]);
        }
    }
    println!("button for a minute: at {deepest:.6} m, {crept:.1e} m from where it was after 2 s");
    assert!(deepest < -0.004 && deepest > -0.0045, "{deepest}");
    assert!(crept < 1e-5, "{crept}");
}
