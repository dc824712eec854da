//! The hold floor: with devices and hands known exactly, each held force is the interval mean of the ideal one.

use palpate::Actuation;
use palpate_world::{
    BasicParams, Body, ContactLaw, CoupledParams, Free, Prior, Vector, World, WorldLoop,
    WorldRenderer,
};

use crate::common::{ball, plane, world};
use crate::ideal::{Ball, Ideal, Law, Plane, Trial};

const DEVICE: Vector = [0.1, 0.16, 0.25];

fn tool(position: Vector, force: Vector) -> Ball {
    Ball {
        position,
        velocity: [0.0; 3],
        mass: DEVICE,
        radius: 0.005,
        force,
        hand: (0.0, 0.0, [0.0; 3]),
        turning: [0.0; 3],
        is_tool: true,
    }
}

fn free_ball(position: Vector, mass: f64, radius: f64, weight: bool) -> Ball {
    Ball {
        position,
        mass: [mass; 3],
        radius,
        force: [0.0, 0.0, if weight { -9.81 * mass } else { 0.0 }],
        is_tool: false,
        ..tool(position, [0.0; 3])
    }
}

/// The same world for the renderer.
fn as_world(ideal: &Ideal, law: ContactLaw) -> World {
    let mut bodies: Vec<Body> = Vec::new();
    for (number, one) in ideal.balls.iter().filter(|ball| !ball.is_tool).enumerate() {
        let free = Free::of_mass(one.mass[0])
            .pulled_by(one.force)
            .moving(one.velocity);
        bodies.push(ball(&format!("ball {number}"), one.radius, free).at(one.position));
    }
    for (number, one) in ideal.planes.iter().enumerate() {
        bodies.push(plane(&format!("plane {number}"), one.normal));
    }
    world(ideal.balls[0].radius, bodies, law)
}

struct Case {
    name: &'static str,
    ideal: Ideal,
    law: ContactLaw,
    samples: usize,
}

fn cases(law: ContactLaw) -> Vec<Case> {
    let plain = Law {
        stiffness: law.stiffness,
        damping: law.damping,
        friction: law.friction,
    };
    let lean = 1.0_f64;
    let groove = [
        [lean.sin(), 0.0, lean.cos()],
        [-lean.sin(), 0.0, lean.cos()],
    ];
    let planes = |normals: &[Vector]| -> Vec<Plane> {
        normals
            .iter()
            .map(|&normal| Plane {
                normal,
                offset: 0.0,
            })
            .collect()
    };
    let floor = planes(&[[0.0, 0.0, 1.0]]);
    let ideal = |balls, planes| Ideal::new(balls, planes, plain);
    vec![
        Case {
            name: "groove",
            ideal: ideal(
                vec![tool([0.004, 0.0, 0.02], [0.2, 0.1, -1.5])],
                planes(&groove),
            ),
            law,
            samples: 300,
        },
        Case {
            name: "ball juggled",
            ideal: ideal(
                vec![
                    tool([0.0, 0.0, 0.0], [0.0, 0.0, 0.8]),
                    free_ball([0.002, -0.001, 0.035], 0.06, 0.02, true),
                ],
                Vec::new(),
            ),
            law,
            samples: 250,
        },
        Case {
            name: "ball on the floor",
            ideal: ideal(
                vec![
                    tool([0.003, 0.001, 0.055], [0.0, 0.0, -1.0]),
                    free_ball(
                        [0.0, 0.0, 0.02 - 0.06 * 9.81 / law.stiffness],
                        0.06,
                        0.02,
                        true,
                    ),
                ],
                floor,
            ),
            law,
            samples: 200,
        },
        Case {
            name: "two balls in a row",
            ideal: ideal(
                vec![
                    tool([0.0, 0.0, 0.0], [0.8, 0.0, 0.0]),
                    free_ball([0.035, 0.001, 0.0], 0.05, 0.02, false),
                    free_ball([0.08, 0.0, 0.001], 0.08, 0.02, false),
                ],
                Vec::new(),
            ),
            law,
            samples: 200,
        },
    ]
}

fn renderer(case: &Case, period: f64, delay: usize, told: f64, prior: Prior) -> WorldRenderer {
    let in_loop = WorldLoop::new(period).with_actuation(Actuation::after_samples(delay, period));
    let masses = CoupledParams::new(vec![DEVICE.map(|mass| told * mass)]).with_prior(prior);
    WorldRenderer::new(&as_world(&case.ideal, case.law), in_loop, masses).unwrap()
}

fn trial(case: &Case, period: f64, delay: usize) -> Trial {
    Trial {
        ideal: case.ideal.clone(),
        period,
        quantum: 0.0,
        delay,
        samples: (case.samples as f64 * 0.001 / period) as usize,
    }
}

#[test]
fn with_devices_known_exactly_the_force_is_the_mean_of_the_ideal_one() {
    let law = ContactLaw::spring(4000.0).with_damping(1.0);
    for (period, delay) in [(0.001, 0), (0.004, 0), (0.001, 1)] {
        for case in cases(law) {
            let trial = trial(&case, period, delay);
            let known = renderer(&case, period, delay, 1.0, Prior::of_a_known_mass());
            let learned = renderer(&case, period, delay, 1.5, Prior::default());
            let in_loop = WorldLoop::new(period);
            let world = as_world(&case.ideal, case.law);
            let basic = WorldRenderer::new(&world, in_loop, BasicParams::default()).unwrap();
            let (known, learned, basic) = (
                trial.error(&known),
                trial.error(&learned),
                trial.error(&basic),
            );
            println!(
                "{} at {period} s, delay {delay}: E {known:.4} %, told 1.5 times the mass {learned:.3} %, \
                 sampled spring {basic:.1} %",
                case.name
            );
            if delay == 0 {
                assert!(known < 0.1, "{}: {known}", case.name);
            }
            assert!(basic > 5.0);
        }
    }
}
