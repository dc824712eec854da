//! Zero-order-hold bound: with devices and hands known exactly, each held force is the interval mean of the ideal
//! one.

use palpate_core::Actuation;
use palpate_world::{
    BasicParams, Body, ContactLaw, CoupledParams, Free, Prior, Sample, Shape, SubSteps, Tool,
    Vector, VirtualCouplingParams, World, WorldLoop, WorldMethod, WorldRenderer,
};

use crate::common::{ball, plane, world};
use crate::ideal::{Actuators, Ball, Ideal, Law, Plane, Trial, dot};

pub const DEVICE: Vector = [0.1, 0.16, 0.25];

pub fn tool(position: Vector, force: Vector) -> Ball {
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

pub fn free_ball(position: Vector, mass: f64, radius: f64, weight: bool) -> Ball {
    Ball {
        position,
        mass: [mass; 3],
        radius,
        force: [0.0, 0.0, if weight { -9.81 * mass } else { 0.0 }],
        is_tool: false,
        ..tool(position, [0.0; 3])
    }
}

/// Returns the same world for the renderer.
pub fn as_world(ideal: &Ideal, law: ContactLaw) -> World {
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
    let tools = ideal.balls.iter().filter(|ball| ball.is_tool).skip(1);
    let tools = tools.enumerate().map(|(number, one)| {
        let radius = one.radius;
        Tool::new(format!("tool {number}"), Shape::Sphere { radius })
    });
    let mut world = world(ideal.balls[0].radius, bodies, law);
    world.tools.extend(tools);
    world
}

pub struct Case {
    pub ideal: Ideal,
    pub law: ContactLaw,
    pub milliseconds: u32,
}

pub fn cases(law: ContactLaw) -> [Case; 4] {
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
        // A ball at rest on the floor, and a tool above.
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

/// Returns a loop with nearly exact integration.
pub fn fine(loop_params: WorldLoop) -> WorldLoop {
    WorldLoop {
        sub_steps: SubSteps {
            phase: 0.003,
            most: 4096,
            refined: 100,
            ..SubSteps::default()
        },
        ..loop_params
    }
}

/// Returns coupled rendering with exact device knowledge and without decay of the offset.
pub fn exact() -> CoupledParams {
    CoupledParams {
        offset_return: 0.0,
        velocity_return: f64::INFINITY,
        ..CoupledParams::new(vec![DEVICE]).with_prior(Prior::of_a_known_mass())
    }
}

/// Returns E in percent for the four worlds.
fn errors(
    law: ContactLaw,
    (period, delay): (f64, usize),
    loop_params: impl Fn(WorldLoop) -> WorldLoop,
    method: impl Into<WorldMethod>,
) -> [f64; 4] {
    let method = method.into();
    let actuation = Actuation::after_samples(delay, period);
    cases(law).map(|case| {
        let loop_params = loop_params(WorldLoop::new(period).with_actuation(actuation));
        let world = as_world(&case.ideal, case.law);
        let renderer = WorldRenderer::new(&world, loop_params, method.clone()).unwrap();
        trial(&case, period, delay).error(&renderer)
    })
}

const LOOPS: [(f64, usize); 3] = [(0.001, 0), (0.004, 0), (0.001, 1)];

#[test]
fn with_devices_known_exactly_each_held_force_is_the_mean_of_the_ideal_one() {
    let smooth = ContactLaw::spring(4000.0).with_damping(1.0);
    for (law, loop_params) in [smooth, smooth.with_friction(0.4)]
        .into_iter()
        .flat_map(|law| LOOPS.map(|loop_params| (law, loop_params)))
    {
        let known = errors(law, loop_params, fine, exact());
        // Without an offset, the proxy starts each interval at the device.
        let without = CoupledParams {
            offset_limit: 1e-12,
            ..exact()
        };
        let without = errors(law, loop_params, fine, without);
        println!("{law:?}, {loop_params:?}: E {known:.4?} %, without the offset {without:.1?} %");
        for (known, without) in known.into_iter().zip(without) {
            assert!(known < 0.01, "{known}");
            assert!(without > 20.0 * known, "{without}");
        }
    }
}

#[test]
fn model_mass_error_keeps_forces_near_hold_bound() {
    let law = ContactLaw::spring(4000.0).with_damping(1.0);
    for loop_params in LOOPS {
        let same = |loop_params| loop_params;
        let model = |factor: f64| CoupledParams::new(vec![DEVICE.map(|mass| factor * mass)]);
        let [right, heavy, light] =
            [1.0, 1.5, 0.67].map(|factor| errors(law, loop_params, same, model(factor)));
        let basic = errors(law, loop_params, same, BasicParams::default());
        let coupling = VirtualCouplingParams {
            stiffness: vec![3000.0],
            damping: vec![1.0],
            mass: vec![0.05],
            ..VirtualCouplingParams::default()
        };
        let coupling = errors(law, loop_params, same, coupling);
        println!(
            "{loop_params:?}: E {right:.3?} %, told 1.5 times the mass {heavy:.3?}, two thirds {light:.3?}; sampled spring \
             {basic:.0?}, virtual coupling {coupling:.0?}"
        );
        for column in [right, heavy, light] {
            for (error, basic) in column.into_iter().zip(basic) {
                assert!(error < 1.5 && basic > 5.0 * error, "{error} {basic}");
            }
        }
    }
}

/// Returns E in percent over the windows in which the commands act, from `lead` after each sample. `real` is the
/// actual actuator, `model` the renderer's model.
fn over_windows(case: &Case, period: f64, real: Actuation<f64>, model: Actuation<f64>) -> f64 {
    let loop_params = fine(WorldLoop::new(period)).with_actuation(model);
    let world = as_world(&case.ideal, case.law);
    let renderer = WorldRenderer::new(&world, loop_params, exact()).unwrap();
    let mut state = renderer.start();
    let mut ideal = case.ideal.clone();
    let tool = ideal.balls[0];
    let mut device = Ideal::new(vec![tool], Vec::new(), ideal.law);
    let mut actuators = Actuators {
        delay: real.delay,
        lag: real.lag,
        gain: real.gain,
        sent: Vec::new(),
        felt: vec![[0.0; 3]],
        own: vec![tool.force],
    };
    // The ideal starts at the beginning of the first command.
    let early = real.delay % period;
    if early > 0.0 {
        ideal.interval(early);
    }
    let (mut delivered, mut errors, mut all) = ([0.0; 3], 0.0, 0.0);
    let mut compare = |impulse: Vector| {
        let (means, squares) = ideal.interval(period);
        let off = [0, 1, 2].map(|axis| impulse[axis] / period - means[0][axis]);
        errors += dot(off, off) * period;
        all += squares;
    };
    for sample in 0..case.milliseconds.min(150) as usize {
        let now = sample as f64 * period;
        let position = device.balls[0].position;
        let output = renderer.step(&mut state, &Sample::at(&[position]));
        assert_eq!(output.fault, None);
        actuators.sent.push((now, output.forces.to_vec()));
        if actuators.sent.len() > 4 {
            actuators.sent.remove(0);
        }
        // To the end of the window that began in the last interval, then on to the next sample.
        if early > 0.0 {
            let late = actuators.hold(&mut device, now, now + early)[0];
            delivered = [0, 1, 2].map(|axis| delivered[axis] + late[axis]);
            if sample > 0 {
                compare(delivered);
            }
        }
        delivered = actuators.hold(&mut device, now + early, now + period)[0];
        if early == 0.0 {
            compare(delivered);
        }
    }
    100.0 * (errors / all).sqrt()
}

#[test]
fn with_an_actuator_known_exactly_each_delivered_mean_is_that_of_the_ideal_force() {
    let period = 0.001;
    let law = ContactLaw::spring(4000.0)
        .with_damping(1.0)
        .with_friction(0.3);
    let actuators = [
        Actuation::after(0.0).with_gain(0.9),
        Actuation::after(0.0004),
        Actuation::after(0.0013),
        Actuation::after(0.0005).with_lag(0.0003).with_gain(1.1),
        Actuation::after(0.0).with_lag(0.0003),
    ];
    for real in actuators {
        let nothing = Actuation::default();
        let [known, unknown] = [real, nothing]
            .map(|model| cases(law).map(|case| over_windows(&case, period, real, model)));
        println!(
            "delay {} s, lag {} s, gain {}: E {known:.4?} %, told nothing {unknown:.1?} %",
            real.delay, real.lag, real.gain
        );
        for (known, unknown) in known.into_iter().zip(unknown) {
            assert!(known < 0.05, "{known}");
            assert!(unknown > 10.0 * known, "{unknown}");
        }
    }
}
