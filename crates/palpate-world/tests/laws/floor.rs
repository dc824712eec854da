//! The hold floor: with devices and hands known exactly, each held force is the interval mean of the ideal one.

use palpate::Actuation;
use palpate_world::{
    BasicParams, Body, ContactLaw, CoupledParams, Free, Prior, SubSteps, Vector,
    VirtualCouplingParams, World, WorldLoop, WorldMethod, WorldRenderer,
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
    ideal: Ideal,
    law: ContactLaw,
    milliseconds: u32,
}

fn cases(law: ContactLaw) -> [Case; 4] {
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
    [
        // A point pressed into a groove.
        Case {
            ideal: ideal(
                vec![tool([0.004, 0.0, 0.02], [0.2, 0.1, -1.5])],
                planes(&groove),
            ),
            law,
            milliseconds: 300,
        },
        // A ball above the tool.
        Case {
            ideal: ideal(
                vec![
                    tool([0.0, 0.0, 0.0], [0.0, 0.0, 0.8]),
                    free_ball([0.002, -0.001, 0.035], 0.06, 0.02, true),
                ],
                Vec::new(),
            ),
            law,
            milliseconds: 250,
        },
        // A ball that rests on the floor, and a tool above.
        Case {
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
            milliseconds: 200,
        },
        // A row of two balls.
        Case {
            ideal: ideal(
                vec![
                    tool([0.0, 0.0, 0.0], [0.8, 0.0, 0.0]),
                    free_ball([0.035, 0.001, 0.0], 0.05, 0.02, false),
                    free_ball([0.08, 0.0, 0.001], 0.08, 0.02, false),
                ],
                Vec::new(),
            ),
            law,
            milliseconds: 200,
        },
    ]
}

fn trial(case: &Case, period: f64, delay: usize) -> Trial {
    Trial {
        ideal: case.ideal.clone(),
        period,
        quantum: 0.0,
        delay,
        samples: (f64::from(case.milliseconds) * 0.001 / period) as usize,
    }
}

/// A loop whose integration is as good as exact.
fn fine(in_loop: WorldLoop) -> WorldLoop {
    WorldLoop {
        sub_steps: SubSteps {
            phase: 0.003,
            most: 4096,
            refined: 100,
            ..SubSteps::default()
        },
        ..in_loop
    }
}

/// Coupled rendering that knows the devices and gives no offset back.
fn exact() -> CoupledParams {
    CoupledParams {
        offset_return: 0.0,
        velocity_return: f64::INFINITY,
        ..CoupledParams::new(vec![DEVICE]).with_prior(Prior::of_a_known_mass())
    }
}

/// E in percent of the four worlds.
fn errors(
    law: ContactLaw,
    (period, delay): (f64, usize),
    in_loop: impl Fn(WorldLoop) -> WorldLoop,
    method: impl Into<WorldMethod>,
) -> [f64; 4] {
    let method = method.into();
    let actuation = Actuation::after_samples(delay, period);
    cases(law).map(|case| {
        let in_loop = in_loop(WorldLoop::new(period).with_actuation(actuation));
        let world = as_world(&case.ideal, case.law);
        let renderer = WorldRenderer::new(&world, in_loop, method.clone()).unwrap();
        trial(&case, period, delay).error(&renderer)
    })
}

const LOOPS: [(f64, usize); 3] = [(0.001, 0), (0.004, 0), (0.001, 1)];

#[test]
fn with_devices_known_exactly_each_held_force_is_the_mean_of_the_ideal_one() {
    let smooth = ContactLaw::spring(4000.0).with_damping(1.0);
    for (law, in_loop) in [smooth, smooth.with_friction(0.4)]
        .into_iter()
        .flat_map(|law| LOOPS.map(|in_loop| (law, in_loop)))
    {
        let known = errors(law, in_loop, fine, exact());
        // Without the offset, the avatar begins each interval where the device is.
        let without = CoupledParams {
            offset_limit: 1e-12,
            ..exact()
        };
        let without = errors(law, in_loop, fine, without);
        println!("{law:?}, {in_loop:?}: E {known:.4?} %, without the offset {without:.1?} %");
        for (known, without) in known.into_iter().zip(without) {
            assert!(known < 0.01, "{known}");
            assert!(without > 20.0 * known, "{without}");
        }
    }
}

#[test]
fn as_it_comes_and_told_another_mass_it_is_near_that_mean() {
    let law = ContactLaw::spring(4000.0).with_damping(1.0);
    for in_loop in LOOPS {
        let same = |in_loop| in_loop;
        let told = |factor: f64| CoupledParams::new(vec![DEVICE.map(|mass| factor * mass)]);
        let [right, heavy, light] =
            [1.0, 1.5, 0.67].map(|factor| errors(law, in_loop, same, told(factor)));
        let basic = errors(law, in_loop, same, BasicParams::default());
        let coupling = VirtualCouplingParams {
            stiffness: vec![3000.0],
            damping: vec![1.0],
            mass: vec![0.05],
        };
        let coupling = errors(law, in_loop, same, coupling);
        println!(
            "{in_loop:?}: E {right:.3?} %, told 1.5 times the mass {heavy:.3?}, two thirds {light:.3?}; sampled spring \
             {basic:.0?}, virtual coupling {coupling:.0?}"
        );
        for column in [right, heavy, light] {
            for (error, basic) in column.into_iter().zip(basic) {
                assert!(error < 1.5 && basic > 5.0 * error, "{error} {basic}");
            }
        }
    }
}
