//! A tool pressed on a floor in a loop with late ticks: force and proxy are at the equilibrium of floor and hand for
//! each kind of simulation of the bodies.

use palpate_world::engine::local::{LocalContact, LocalParams, LocalRenderer};
use palpate_world::engine::{
    BodyNow, BodyWrench, EngineBody, EngineRenderer, PlacedShape, Stepping,
};
use palpate_world::{
    ContactLaw, CoupledParams, IDENTITY, Sample, Shape, Tool, Vector, WorldLoop, WorldRenderer,
};

use crate::common::{plane, world};

const PERIOD: f64 = 0.002;
const RADIUS: f64 = 0.01;
const STIFFNESS: f64 = 300.0;
const UP: Vector = [0.0, 0.0, 1.0];

/// A hand that holds a device `[kg]`, `[N/m]`, `[N s/m]`, 5 mm below first contact of the tool with the floor.
const DEVICE: f64 = 0.25;
const HAND: f64 = 400.0;
const HAND_DAMPING: f64 = 8.0;
const HELD_AT: f64 = RADIUS - 0.005;

/// Equilibrium of floor and hand: depth of the tool `[m]`, and force `[N]`.
const DEPTH: f64 = 0.005 * HAND / (HAND + STIFFNESS);
const FORCE: f64 = STIFFNESS * DEPTH;

/// Interval durations in periods, repeated.
pub struct Ticks {
    pub name: &'static str,
    pub durations: fn(usize) -> f64,
}

pub const TICKS: [Ticks; 4] = [
    Ticks {
        name: "on time",
        durations: |_| 1.0,
    },
    Ticks {
        name: "every 25th late",
        durations: |tick| match tick % 100 {
            24 => 2.0,
            49 => 5.0,
            74 => 3.3,
            99 => 4.0,
            _ => 1.0,
        },
    },
    Ticks {
        name: "late, and the next one early",
        durations: |tick| match tick % 10 {
            8 => 1.7,
            9 => 0.3,
            _ => 1.0,
        },
    },
    Ticks {
        name: "each a little late",
        durations: |_| 1.2,
    },
];

/// Results over the last second.
struct Settled {
    /// Time-averaged force `[N]`.
    force: f64,
    /// Largest deviation of a force from the equilibrium `[N]`.
    unrest: f64,
    /// Largest distance of the proxy from its device `[m]`.
    offset: f64,
}

/// Simulates the device for 12 s with its own sub-steps. `step` returns the force and the proxy offset along the
/// normal.
fn pressed(ticks: &Ticks, mut step: impl FnMut(&Sample<'_>) -> (f64, f64)) -> Settled {
    let (mut position, mut velocity) = (HELD_AT + DEPTH, 0.0);
    let mut elapsed = PERIOD;
    let mut settled = Settled {
        force: 0.0,
        unrest: 0.0,
        offset: 0.0,
    };
    let (mut time, mut tick, mut weight) = (0.0, 0, 0.0);
    while time < 12.0 {
        let positions = [[0.0, 0.0, position]];
        let sample = Sample::at(&positions).after(elapsed);
        let (force, offset) = step(&sample);
        elapsed = PERIOD * (ticks.durations)(tick);
        for _ in 0..50 {
            let h = elapsed / 50.0;
            let hand = HAND * (HELD_AT - position) - HAND_DAMPING * velocity;
            velocity += h * (hand + force) / DEVICE;
            position += h * velocity;
        }
        if time > 11.0 {
            settled.force += force * elapsed;
            weight += elapsed;
            settled.unrest = settled.unrest.max((force - FORCE).abs());
            settled.offset = settled.offset.max(offset.abs());
        }
        time += elapsed;
        tick += 1;
    }
    settled.force /= weight;
    println!(
        "{}: {:.4} N, to {:.4} N, offset {:.2} um",
        ticks.name,
        settled.force,
        settled.unrest,
        1e6 * settled.offset
    );
    settled
}

fn tool() -> Tool {
    Tool::new("tool", Shape::Sphere { radius: RADIUS })
}

fn law() -> ContactLaw {
    ContactLaw::spring(STIFFNESS)
}

fn params() -> CoupledParams {
    CoupledParams::new(vec![[DEVICE; 3]])
}

fn by_world(ticks: &Ticks) -> Settled {
    let world = world(RADIUS, vec![plane("floor", UP)], law());
    let renderer = WorldRenderer::new(&world, WorldLoop::new(PERIOD), params()).unwrap();
    let mut state = renderer.start();
    pressed(ticks, |sample| {
        let output = renderer.step(&mut state, sample);
        assert_eq!(output.fault, None);
        let force = output.forces[0][2];
        (force, state.tools()[0].offset[2])
    })
}

fn by_local_model(ticks: &Ticks) -> Settled {
    let room = LocalParams::new(0, 1);
    let renderer = LocalRenderer::new(&[tool()], room, WorldLoop::new(PERIOD), params()).unwrap();
    let mut state = renderer.start();
    let floor = Some(LocalContact::of_tool(0, None, [0.0; 3], UP, law()));
    pressed(ticks, |sample| {
        let tick = state.progress().tick;
        let model = renderer.model(tick, &[], &[floor]).unwrap();
        let output = renderer.step(&mut state, sample, Some(&model));
        assert_eq!((output.fault, output.refusal), (None, None));
        let force = output.forces[0][2];
        (force, state.tools()[0].offset[2])
    })
}

/// An engine with two steps per period.
fn by_engine(ticks: &Ticks) -> Settled {
    let floor = EngineBody {
        name: "floor".into(),
        shapes: vec![PlacedShape {
            shape: Shape::HalfSpace {
                normal: UP,
                offset: 0.0,
            },
            position: [0.0; 3],
            orientation: IDENTITY,
        }],
        law: law(),
    };
    let loop_params = WorldLoop::new(PERIOD);
    let stepping = Stepping::EndVelocity;
    let renderer =
        EngineRenderer::new(&[tool()], &[floor], stepping, loop_params, params()).unwrap();
    let mut state = renderer.start();
    let mut wrenches = [BodyWrench::default()];
    pressed(ticks, |sample| {
        renderer.sample(&mut state, sample);
        for _ in 0..2 {
            let bodies = [BodyNow::fixed([0.0; 3])];
            renderer.advance(&mut state, 0.5 * PERIOD, &bodies, &mut wrenches);
        }
        let output = renderer.hold(&mut state);
        assert_eq!(output.fault, None);
        let force = output.forces[0][2];
        (force, state.tools()[0].offset[2])
    })
}

#[test]
fn a_pressed_tool_stays_where_floor_and_hand_put_it() {
    for (name, by) in [
        ("world", by_world as fn(&Ticks) -> Settled),
        ("local model", by_local_model),
        ("engine", by_engine),
    ] {
        println!("{name}");
        for ticks in &TICKS {
            let settled = by(ticks);
            let off = (settled.force - FORCE).abs();
            assert!(off < 5e-4, "{}: {} N", ticks.name, settled.force);
            assert!(
                settled.unrest < 1e-3,
                "{}: {} N",
                ticks.name,
                settled.unrest
            );
            assert!(
                settled.offset < 3e-6,
                "{}: {} m",
                ticks.name,
                settled.offset
            );
        }
    }
}

/// A device of 0.1 kg falls on the floor within a long period, and stays there under 1 N.
#[test]
fn a_large_offset_goes_back_in_contact() {
    let (period, mass) = (0.02, 0.1);
    let room = LocalParams {
        settle: period,
        ..LocalParams::new(0, 1)
    };
    let params = CoupledParams::new(vec![[mass; 3]]);
    let renderer = LocalRenderer::new(&[tool()], room, WorldLoop::new(period), params).unwrap();
    let mut state = renderer.start();
    let floor = LocalContact::of_tool(0, None, [0.0; 3], UP, law().with_damping(1.0));
    let (mut position, mut velocity) = (RADIUS + 0.018, -0.3);
    let mut offsets = Vec::new();
    for _ in 0..250 {
        let positions = [[0.0, 0.0, position]];
        let tick = state.progress().tick;
        let model = renderer.model(tick, &[], &[Some(floor)]).unwrap();
        let output = renderer.step(&mut state, &Sample::at(&positions), Some(&model));
        assert_eq!((output.fault, output.refusal), (None, None));
        let force = output.forces[0][2];
        for _ in 0..50 {
            let h = period / 50.0;
            velocity += h * (force - 1.0 - 1.5 * velocity) / mass;
            position += h * velocity;
        }
        offsets.push(state.tools()[0].offset[2].abs());
    }
    let [early, late] = [10, 249].map(|tick: usize| offsets[tick]);
    println!("{early} m, then {late} m");
    assert!(early > 8e-4 && late < 5.5e-4, "{early} m, then {late} m");
    // The remaining offset is the displacement of the floor.
    let depth = RADIUS - position;
    assert!(
        (depth - 1.0 / STIFFNESS).abs() < 6e-4,
        "{depth} m deep in the floor"
    );
}
