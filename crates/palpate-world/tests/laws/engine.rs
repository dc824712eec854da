//! Contact with the bodies of another engine: the forces equal those of a world that palpate simulates.

use palpate_core::Fault;
use palpate_world::engine::{
    BodyNow, BodyWrench, EngineBody, EngineRenderer, EngineState, PlacedShape, Stepping,
};
use palpate_world::{
    Body, Contact, ContactLaw, CoupledParams, Free, IDENTITY, Mesh, Motion, Party, Prior, Sample,
    Shape, Tool, Vector, World, WorldLoop, WorldRenderer,
};

const DEVICE: Vector = [0.1, 0.16, 0.25];
const HAND: Vector = [0.05, 0.0, 0.8];
const MASS: f64 = 0.06;
const RADIUS: f64 = 0.02;
const WEIGHT: f64 = -9.81;

/// A device that is integrated exactly under the held force and the hand force.
#[derive(Clone, Copy)]
struct HandledDevice {
    position: Vector,
    velocity: Vector,
}

impl HandledDevice {
    fn under(&mut self, force: Vector, h: f64) {
        for axis in 0..3 {
            let a = (HAND[axis] + force[axis]) / DEVICE[axis];
            self.position[axis] += h * (self.velocity[axis] + 0.5 * h * a);
            self.velocity[axis] += h * a;
        }
    }
}

/// A ball in its own engine, moved only by a wrench.
struct Engine {
    now: BodyNow,
    stepping: Stepping,
}

impl Engine {
    fn new(stepping: Stepping) -> Self {
        let moment = 0.4 * MASS * RADIUS * RADIUS;
        let mut now = BodyNow::fixed([0.002, -0.001, 0.035]);
        now.acceleration = [0.0, 0.0, WEIGHT];
        for axis in 0..3 {
            now.mobility[axis][axis] = 1.0 / MASS;
            now.mobility[axis + 3][axis + 3] = 1.0 / moment;
        }
        Self { now, stepping }
    }

    fn step(&mut self, wrench: &BodyWrench, h: f64) {
        for axis in 0..3 {
            let a =
                self.now.acceleration[axis] + self.now.mobility[axis][axis] * wrench.force[axis];
            let before = self.now.velocity[axis];
            let after = before + h * a;
            self.now.position[axis] += match self.stepping {
                Stepping::MeanVelocity => h * 0.5 * (before + after),
                Stepping::EndVelocity => h * after,
                Stepping::Parts(parts) => {
                    let part = h / f64::from(parts);
                    let velocities = (1..=parts).map(|k| before + f64::from(k) * part * a);
                    velocities.map(|velocity| part * velocity).sum()
                }
            };
            self.now.velocity[axis] = after;
            // The orientation of a ball is irrelevant.
            self.now.angular_velocity[axis] +=
                h * self.now.mobility[axis + 3][axis + 3] * wrench.torque[axis];
        }
    }
}

pub(super) fn params() -> CoupledParams {
    CoupledParams::new(vec![DEVICE]).with_prior(Prior::of_a_known_mass())
}

pub(super) fn tool() -> Tool {
    Tool::new("tool", Shape::Sphere { radius: 0.005 })
}

fn engine_renderer(law: ContactLaw, period: f64, stepping: Stepping) -> EngineRenderer {
    engine_renderer_of(tool(), law, period, stepping)
}

fn engine_renderer_of(
    tool: Tool,
    law: ContactLaw,
    period: f64,
    stepping: Stepping,
) -> EngineRenderer {
    let ball = EngineBody {
        name: "ball".into(),
        shapes: vec![PlacedShape {
            shape: Shape::Sphere { radius: RADIUS },
            position: [0.0; 3],
            orientation: IDENTITY,
        }],
        law,
    };
    EngineRenderer::new(&[tool], &[ball], stepping, WorldLoop::new(period), params()).unwrap()
}

/// Returns the device forces per sample for a ball in its own engine with `steps` steps per period.
fn with_engine(
    law: ContactLaw,
    (period, steps): (f64, u32),
    stepping: Stepping,
    samples: usize,
) -> (Vec<Vector>, EngineState, Vector) {
    with_engine_of(tool(), law, (period, steps), stepping, samples)
}

fn with_engine_of(
    tool: Tool,
    law: ContactLaw,
    (period, steps): (f64, u32),
    stepping: Stepping,
    samples: usize,
) -> (Vec<Vector>, EngineState, Vector) {
    let renderer = engine_renderer_of(tool, law, period, stepping);
    let mut state = renderer.start();
    let mut engine = Engine::new(stepping);
    let mut device = HandledDevice {
        position: [0.0; 3],
        velocity: [0.0; 3],
    };
    let h = period / f64::from(steps);
    let (mut forces, mut given) = (Vec::new(), [0.0; 3]);
    for _ in 0..samples {
        renderer.sample(&mut state, &Sample::at(&[device.position]));
        let mut wrenches = [BodyWrench::default()];
        for _ in 0..steps {
            renderer.advance(&mut state, h, &[engine.now], &mut wrenches);
            engine.step(&wrenches[0], h);
            for (sum, force) in given.iter_mut().zip(wrenches[0].force) {
                *sum += h * force;
            }
        }
        let output = renderer.hold(&mut state);
        assert_eq!(output.fault, None);
        forces.push(output.forces[0]);
        device.under(forces[forces.len() - 1], period);
    }
    (forces, state, given)
}

/// Returns the forces for a ball in a world that palpate simulates.
fn with_world(law: ContactLaw, period: f64, samples: usize) -> Vec<Vector> {
    with_world_of(tool(), law, period, samples)
}

fn with_world_of(tool: Tool, law: ContactLaw, period: f64, samples: usize) -> Vec<Vector> {
    let ball = Free::of_mass(MASS).pulled_by([0.0, 0.0, WEIGHT * MASS]);
    let world = World {
        joints: Vec::new(),
        fields: Vec::new(),
        tools: vec![tool],
        bodies: vec![
            Body::new("ball", Shape::Sphere { radius: RADIUS }, Motion::Free(ball))
                .at([0.002, -0.001, 0.035]),
        ],
        contacts: vec![Contact {
            between: [Party::Any, Party::Any],
            law,
        }],
    };
    let renderer = WorldRenderer::new(&world, WorldLoop::new(period), params()).unwrap();
    let mut state = renderer.start();
    let mut device = HandledDevice {
        position: [0.0; 3],
        velocity: [0.0; 3],
    };
    let mut forces = Vec::new();
    for _ in 0..samples {
        let output = renderer.step(&mut state, &Sample::at(&[device.position]));
        forces.push(output.forces[0]);
        device.under(forces[forces.len() - 1], period);
    }
    forces
}

/// Returns the root mean square of the difference relative to that of `right`, in percent.
fn difference(forces: &[Vector], right: &[Vector]) -> f64 {
    let (mut off, mut sum) = (0.0, 0.0);
    for (one, other) in forces.iter().zip(right) {
        for axis in 0..3 {
            off += (one[axis] - other[axis]).powi(2) / DEVICE[axis];
            sum += other[axis].powi(2) / DEVICE[axis];
        }
    }
    assert!(sum > 0.0);
    100.0 * (off / sum).sqrt()
}

/// A juggled ball: with a ball in its own engine the forces equal those of a world, whose held forces are the means
/// of the ideal ones.
#[test]
#[allow(clippy::print_stdout)] // prints the measured values
fn an_engine_s_ball_gives_the_forces_of_a_world() {
    let soft = ContactLaw::spring(400.0);
    let hard = ContactLaw::spring(4000.0);
    let rough = hard.with_friction(0.4).with_damping(1.0);
    for (name, law, period, steps, stepping, allowed) in [
        (
            "400 N/m, 10 ms, 1 step",
            soft,
            0.01,
            1,
            Stepping::MeanVelocity,
            0.2,
        ),
        (
            "400 N/m, 10 ms, 10 steps",
            soft,
            0.01,
            10,
            Stepping::MeanVelocity,
            0.1,
        ),
        (
            "400 N/m, 10 ms, 10 Euler steps",
            soft,
            0.01,
            10,
            Stepping::EndVelocity,
            1.0,
        ),
        (
            "400 N/m, 10 ms, 4 steps of 4 parts",
            soft,
            0.01,
            4,
            Stepping::Parts(4),
            0.5,
        ),
        (
            "4000 N/m, 1 ms, 1 step",
            hard,
            0.001,
            1,
            Stepping::MeanVelocity,
            0.1,
        ),
        (
            "4000 N/m, 1 ms, 4 steps, rough",
            rough,
            0.001,
            4,
            Stepping::MeanVelocity,
            0.1,
        ),
    ] {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a count"
        )]
        let samples = (0.3 / period) as usize;
        let (forces, ..) = with_engine(law, (period, steps), stepping, samples);
        let error = difference(&forces, &with_world(law, period, samples));
        println!("{name}: {error:.3} %");
        assert!(error < allowed, "{name}: {error} %");
    }
}

/// A device that lacks x, along which its hand moves it: no force is commanded along x, and the ball is pushed
/// nevertheless.
#[test]
fn a_device_that_lacks_an_axis_meets_an_engine_s_ball_as_one_of_a_world() {
    let in_a_plane = || tool().along([false, true, true]);
    let law = ContactLaw::spring(4000.0).with_damping(1.0);
    let (period, samples) = (0.001, 300);
    let stepping = Stepping::MeanVelocity;
    let (forces, state, given) = with_engine_of(in_a_plane(), law, (period, 4), stepping, samples);
    let error = difference(&forces, &with_world_of(in_a_plane(), law, period, samples));
    println!("without x: {error:.3} %");
    assert!(error < 0.1, "{error}");
    assert!(forces.iter().all(|force| force[0] == 0.0));
    assert!(given[0].abs() > 1e-3, "{given:?}");
    assert!(state.ledger().devices[0].carried != 0.0);
}

/// Ball and device receive opposite impulses.
#[test]
fn body_and_device_are_given_the_same_impulse() {
    let (period, law) = (0.01, ContactLaw::spring(400.0));
    // Run until the ball has left the tool and the residual impulse is delivered.
    let (forces, state, given) = with_engine(law, (period, 4), Stepping::MeanVelocity, 24);
    let held: f64 = forces.iter().map(|force| force[2] * period).sum();
    assert!(given[2] > 0.05, "{given:?}");
    assert!(
        (held + given[2]).abs() < 0.02 * given[2],
        "{held} {given:?}"
    );
    let [entry] = &state.ledger().contacts[..] else {
        panic!("one contact");
    };
    let left = entry.observed - entry.work - entry.dissipated + entry.step_error;
    assert!((entry.stored - left).abs() < 1e-12, "{entry:?}");
    let turned_over = entry.work_on_proxy.abs() + entry.held.abs();
    assert!(entry.step_error.abs() < 1e-3 * turned_over, "{entry:?}");
}

/// A table in the engine holds a ball that a tool presses; a free ball gains the work of the hand. Neither energy
/// counts as generated.
#[test]
fn a_body_that_the_engine_holds_creates_no_energy() {
    let period = 0.001;
    let renderer = engine_renderer(ContactLaw::spring(1000.0), period, Stepping::MeanVelocity);
    for is_held in [true, false] {
        let mut engine = Engine::new(Stepping::MeanVelocity);
        (engine.now.position, engine.now.acceleration) = ([0.0; 3], [0.0; 3]);
        let mut state = renderer.start();
        let (mut wrenches, mut most, mut force) = ([BodyWrench::default()], 0.0_f64, 0.0_f64);
        for tick in 0..1000 {
            let pressed = 0.01 * (0.5e-3 * f64::from(tick) * std::f64::consts::TAU).sin();
            let position = [0.0, 0.0, RADIUS + 0.005 - pressed];
            renderer.sample(&mut state, &Sample::at(&[position]));
            renderer.advance(&mut state, period, &[engine.now], &mut wrenches);
            if !is_held {
                engine.step(&wrenches[0], period);
            }
            let held = renderer.hold(&mut state).forces[0];
            force = force.max(held[2]);
            most = most.max(state.ledger().created().abs());
        }
        assert!(force > if is_held { 8.0 } else { 0.1 }, "{force} N");
        assert!(most < 1e-3, "held {is_held}: {most} J");
    }
}

#[test]
fn bad_samples_and_bad_states_give_no_force() {
    let renderer = engine_renderer(ContactLaw::spring(4000.0), 0.001, Stepping::MeanVelocity);
    let good = BodyNow::fixed([0.0, 0.0, 0.02]);
    let mut bad = good;
    bad.mobility[2][2] = f64::NAN;
    let nowhere = BodyNow::fixed([0.0, 0.0, f64::NAN]);
    let mut state = renderer.start();
    for (position, body, fault) in [
        ([0.0; 3], good, None),
        ([f64::NAN; 3], good, Some(Fault::PositionNotFinite)),
        ([0.0; 3], bad, Some(Fault::Overflow)),
        ([0.0; 3], good, None),
        ([0.0; 3], nowhere, Some(Fault::Overflow)),
        ([0.0; 3], good, None),
    ] {
        let mut wrenches = [BodyWrench {
            force: [f64::NAN; 3],
            torque: [f64::NAN; 3],
        }];
        renderer.sample(&mut state, &Sample::at(&[position]));
        renderer.advance(&mut state, 0.001, &[body], &mut wrenches);
        let output = renderer.hold(&mut state);
        assert_eq!(output.fault.map(|it| it.fault), fault);
        let is_held = output.forces[0][2] < -10.0;
        assert_eq!(is_held, fault.is_none(), "{output:?}");
        assert_eq!(wrenches[0].force[2] > 10.0, fault.is_none(), "{wrenches:?}");
    }
}

/// A contact is followed up to the stability bound and rejected beyond it: with one engine step per 1 ms, 26.7 1/kg
/// between device and ball, and 256 sub-steps.
#[test]
fn a_contact_that_is_too_fast_is_refused_and_it_is_said() {
    let of = |stiffness: f64, damping: f64| {
        let law = ContactLaw::spring(stiffness).with_damping(damping);
        let renderer = engine_renderer(law, 0.001, Stepping::MeanVelocity);
        let mut state = renderer.start();
        let mut engine = Engine::new(Stepping::MeanVelocity);
        // The ball is 0.1 mm above the tool and falls.
        engine.now.position = [0.0, 0.0, RADIUS + 0.0051];
        let (mut refused, mut largest, mut touched) = (0, 0.0_f64, 0);
        let mut device = HandledDevice {
            position: [0.0; 3],
            velocity: [0.0; 3],
        };
        for _ in 0..100 {
            renderer.sample(&mut state, &Sample::at(&[device.position]));
            let mut wrenches = [BodyWrench::default()];
            renderer.advance(&mut state, 0.001, &[engine.now], &mut wrenches);
            let output = renderer.hold(&mut state);
            let effort = output.effort;
            let force = output.forces[0];
            if effort.unstable {
                assert!(effort.too_fast, "{effort:?}");
                assert_eq!(output.fault.map(|it| it.fault), Some(Fault::Overflow));
                assert_eq!((force, wrenches[0].force), ([0.0; 3], [0.0; 3]));
                refused += 1;
            } else {
                assert_eq!(output.fault, None);
                assert!(effort.sub_steps <= 256 + 128, "{effort:?}");
                touched += u32::from(wrenches[0].force[2] > 0.0);
            }
            largest = largest.max(force[2].abs());
            engine.step(&wrenches[0], 0.001);
            device.under(force, 0.001);
        }
        println!(
            "{stiffness} N/m, {damping} N s/m: {refused} refused, {touched} touched, {largest} N at most"
        );
        (refused, touched, largest)
    };
    for (stiffness, damping) in [(2e9, 0.0), (4e3, 8e3)] {
        let (refused, touched, largest) = of(stiffness, damping);
        assert!(refused == 0 && touched > 0 && largest < 30.0);
    }
    for (stiffness, damping) in [(3e9, 0.0), (4e3, 9.5e3), (1e12, 0.0)] {
        let (refused, touched, largest) = of(stiffness, damping);
        assert!(refused > 0 && touched == 0 && largest == 0.0);
    }
}

#[test]
fn what_cannot_be_rendered_is_said_with_its_name() {
    let law = ContactLaw::spring(-1.0);
    let shapes = vec![PlacedShape {
        shape: Shape::Box {
            half_extents: [0.1, 0.0, 0.1],
        },
        position: [0.0; 3],
        orientation: IDENTITY,
    }];
    let body = EngineBody {
        name: "door".into(),
        shapes,
        law,
    };
    let of = |bodies: &[EngineBody], params| {
        let loop_params = WorldLoop::new(0.001);
        let made = EngineRenderer::new(
            &[tool()],
            bodies,
            Stepping::MeanVelocity,
            loop_params,
            params,
        );
        let faults = made.unwrap_err();
        let faults: Vec<_> = faults.iter().map(ToString::to_string).collect();
        faults.join("\n")
    };
    let said = of(&[body], CoupledParams::new(vec![[0.0; 3]]));
    for part in [
        "body \"door\": half_extents is 0, and has to be above 0",
        "body \"door\": stiffness is -1, and has to be above 0",
        "device_mass is 0",
    ] {
        assert!(said.contains(part), "{said}");
    }
    assert!(of(&[], params()).contains("there is no body to touch"));
    let open = Mesh::new(&[[0.0; 3], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]], &[[0, 1, 2]]).unwrap();
    let hollow = Mesh::new(&star(), &STAR).unwrap();
    for mesh in [open, hollow] {
        let body = still("cup", Shape::Mesh(mesh.into()));
        let said = of(&[body], params());
        assert!(
            said.contains("body \"cup\": a mesh of an engine's body has to be closed and convex"),
            "{said}"
        );
    }
}

/// Returns a body with one shape and identity orientation.
pub(super) fn still(name: &str, shape: Shape) -> EngineBody {
    EngineBody {
        name: name.into(),
        shapes: vec![PlacedShape {
            shape,
            position: [0.0; 3],
            orientation: IDENTITY,
        }],
        // So soft that it does not move the tool.
        law: ContactLaw::spring(1.0),
    }
}

/// Returns a closed surface with a hollow: an octahedron whose lowest corner is pushed in beyond its centre.
fn star() -> [Vector; 6] {
    [
        [0.1, 0.0, 0.0],
        [-0.1, 0.0, 0.0],
        [0.0, 0.1, 0.0],
        [0.0, -0.1, 0.0],
        [0.0, 0.0, 0.1],
        [0.0, 0.0, 0.05],
    ]
}

const STAR: [[u32; 3]; 8] = [
    [0, 2, 4],
    [2, 1, 4],
    [1, 3, 4],
    [3, 0, 4],
    [2, 0, 5],
    [1, 2, 5],
    [3, 1, 5],
    [0, 3, 5],
];
