//! Energy ledger for arbitrary device motions.

use palpate_world::{
    BasicParams, Body, ContactLaw, CoupledParams, EnergyLedger, Free, GodObjectParams, HfcrParams,
    Motion, Prior, Sample, Shape, Tool, Vector, VirtualCouplingParams, World, WorldLoop,
    WorldMethod, WorldRenderer, WorldState,
};

use crate::balance::{Balance, of_bodies};
use crate::common::{ball, plane};
use crate::ideal::{Ball, Ideal, Law, hold};

const MASS: Vector = [0.1, 0.16, 0.25];

/// Returns two tools, two balls, a box that falls on its corner, and a floor.
fn crowd(law: ContactLaw) -> World {
    let heavy = |mass: f64| Free::of_mass(mass).pulled_by([0.0, 0.0, -9.81 * mass]);
    let block = Shape::Box {
        half_extents: [0.02, 0.015, 0.01],
    };
    let mut falling = heavy(0.1);
    falling.angular_velocity = [3.0, 1.0, 2.0];
    let half: f64 = 0.4;
    World {
        joints: Vec::new(),
        fields: Vec::new(),
        tools: vec![
            Tool::new("left", Shape::Sphere { radius: 0.006 }),
            Tool::new("right", Shape::Sphere { radius: 0.0 }),
        ],
        bodies: vec![
            plane("floor", [0.0, 0.0, 1.0]),
            ball("one", 0.02, heavy(0.06)).at([0.0, 0.0, 0.02]),
            ball("two", 0.015, heavy(0.04)).at([0.038, 0.005, 0.02]),
            Body::new("block", block, Motion::Free(falling))
                .at([-0.06, 0.0, 0.04])
                .turned([half.cos(), half.sin() * 0.6, half.sin() * 0.8, 0.0]),
        ],
        contacts: vec![
            palpate_world::Contact {
                between: [palpate_world::Party::Any, palpate_world::Party::Any],
                law,
            },
            // No contact between the box and a ball.
        ],
    }
}

/// Returns devices that are pulled down and sideways by hands.
fn devices(hand: (f64, f64)) -> Ideal {
    let device = |position: Vector, force: Vector| Ball {
        position,
        velocity: [0.0; 3],
        mass: MASS,
        radius: 0.0,
        force,
        hand: (hand.0, hand.1, position),
        turning: [0.0; 3],
        is_tool: true,
    };
    let none = Law {
        stiffness: 1.0,
        damping: 0.0,
        friction: 0.0,
    };
    let left = device([-0.005, 0.001, 0.055], [0.2, 0.1, -1.2]);
    let right = device([0.035, -0.004, 0.045], [-0.2, 0.0, -1.5]);
    Ideal::new(vec![left, right], Vec::new(), none)
}

const ALL_AXES: [[bool; 3]; 2] = [[true; 3]; 2];

/// Runs the crowd. Returns the initial energy of all bodies, and the final state.
fn run(
    method: impl Into<WorldMethod>,
    law: ContactLaw,
    hand: (f64, f64),
    quantum: f64,
    limits: Vec<f64>,
) -> (f64, WorldState) {
    run_along(ALL_AXES, method, law, hand, (quantum, limits))
}

/// Runs the crowd with motors only along these axes of each device; along the others the hand moves it.
fn run_along(
    axes: [[bool; 3]; 2],
    method: impl Into<WorldMethod>,
    law: ContactLaw,
    hand: (f64, f64),
    (quantum, limits): (f64, Vec<f64>),
) -> (f64, WorldState) {
    let period = 0.002;
    let loop_params = WorldLoop::new(period).with_force_limits(limits);
    let mut world = crowd(law);
    for (tool, axes) in world.tools.iter_mut().zip(axes) {
        tool.axes = axes;
    }
    let renderer = WorldRenderer::new(&world, loop_params, method).unwrap();
    let mut state = renderer.start();
    let mut devices = devices(hand);
    let at_start = of_bodies(&state);
    for _ in 0..150 {
        let positions: Vec<Vector> = devices
            .balls
            .iter()
            .map(|ball| ball.position.map(|x| quantum * (x / quantum).round()))
            .collect();
        let output = renderer.step(&mut state, &Sample::at(&positions));
        assert_eq!(output.fault, None);
        let forces = output.forces.to_vec();
        for (force, axes) in forces.iter().zip(axes) {
            assert!((0..3).all(|axis| axes[axis] || force[axis] == 0.0));
        }
        hold(&mut devices, &forces, period);
    }
    (at_start, state)
}

/// Returns the turnover: the sum of the magnitudes of all entries.
fn turnover(ledger: &EnergyLedger) -> f64 {
    let contacts = ledger
        .contacts
        .iter()
        .map(|entry| entry.work.abs() + entry.held.abs());
    let bodies = ledger
        .bodies
        .iter()
        .map(|entry| entry.kinetic + entry.potential.abs());
    contacts.sum::<f64>() + bodies.sum::<f64>()
}

fn dissipating(damping: Vec<f64>) -> HfcrParams {
    HfcrParams {
        damping,
        ..HfcrParams::default()
    }
}

fn methods() -> [(&'static str, WorldMethod); 6] {
    let model = CoupledParams::new(vec![MASS.map(|mass| 1.5 * mass); 2]);
    let known = CoupledParams::new(vec![MASS; 2]).with_prior(Prior::of_a_known_mass());
    [
        ("basic", BasicParams::default().into()),
        (
            "virtual coupling",
            VirtualCouplingParams {
                stiffness: vec![2000.0; 2],
                damping: vec![2.0; 2],
                mass: vec![0.1; 2],
                ..VirtualCouplingParams::default()
            }
            .into(),
        ),
        (
            "god-object",
            GodObjectParams {
                stiffness: vec![3000.0; 2],
                damping: vec![2.0; 2],
            }
            .into(),
        ),
        ("hfcr", dissipating(vec![0.5; 2]).into()),
        ("coupled, told 1.5 times the mass", model.into()),
        ("coupled, exact", known.into()),
    ]
}

#[test]
fn ledger_identities_hold_to_rounding() {
    let law = ContactLaw::spring(3000.0)
        .with_damping(2.0)
        .with_friction(0.5);
    let in_a_plane = [[true, true, false], [false, true, true]];
    let cases = [
        (Vec::new(), ALL_AXES),
        (vec![0.3, 0.5], ALL_AXES),
        (Vec::new(), in_a_plane),
        (vec![0.3, 0.5], in_a_plane),
    ];
    let runs = cases
        .iter()
        .flat_map(|case| methods().map(|(name, method)| (name, method, case.clone())));
    for (name, method, (limits, axes)) in runs {
        let is_coupled = method.name() == "coupled";
        let sampled = (2e-6, limits.clone());
        let (at_start, state) = run_along(axes, method, law, (60.0, 1.5), sampled);
        let ledger = state.ledger();
        let turned_over = turnover(ledger);
        let sum = |of: fn(&palpate_world::ContactLedger) -> f64| -> f64 {
            ledger.contacts.iter().map(of).sum()
        };
        // (a) Bodies and contacts have the energy given by the proxies.
        let balance = Balance::since(at_start, &state);
        let (a, step_errors) = (balance.world, balance.steps);
        // (b) The work of a port is that of its contacts' mean forces.
        let b = ledger
            .devices
            .iter()
            .map(|entry| entry.port_work + entry.carried - entry.held - entry.unforeseen);
        let b: f64 = b.sum::<f64>() + ledger.devices.iter().map(|entry| entry.held).sum::<f64>()
            - sum(|entry| entry.held);
        // (c) The leaks equal the offset entries.
        let offsets = ledger
            .devices
            .iter()
            .map(|entry| entry.offset - entry.velocity_offset + entry.unpaid);
        let c = sum(|entry| entry.leak()) - offsets.sum::<f64>();
        println!(
            "{name}, axes {axes:?}, limits {limits:?} N: of {turned_over:.3} J turned over, (a) {:.1e} (b) {:.1e} (c) {:.1e}; step errors {:.1e}, observed {:.1e}, leak {:.1e}, dissipated {:.1e} J",
            a / turned_over,
            b / turned_over,
            c / turned_over,
            step_errors,
            sum(|entry| entry.observed),
            sum(|entry| entry.leak()),
            sum(|entry| entry.dissipated),
        );
        assert!(
            ledger.devices.iter().all(|entry| entry.held.abs() > 1e-4),
            "every tool has met something"
        );
        // A mechanism carries work only for a tool that moves along an axis that its device lacks.
        let carried = ledger.devices.iter().map(|entry| entry.carried.abs());
        let most = carried.fold(0.0, f64::max);
        assert_eq!(most > 1e-4 * turned_over, axes == in_a_plane, "{most}");
        assert!(a.abs() < 1e-10 * turned_over, "{a}");
        assert!(b.abs() < 1e-10 * turned_over, "{b}");
        if is_coupled {
            assert!(c.abs() < 1e-10 * turned_over, "{c}");
        }
        // The identities hold for any sub-step error, so the error must be checked separately.
        assert!(step_errors.abs() < 2e-3 * turned_over, "{step_errors}");
    }
}

#[test]
fn damping_and_friction_only_take() {
    for (name, method) in methods() {
        for law in [
            ContactLaw::spring(3000.0),
            ContactLaw::spring(3000.0).with_damping(2.0),
            ContactLaw::spring(3000.0).with_friction(0.5),
        ] {
            let (_, state) = run(method.clone(), law, (60.0, 1.5), 2e-6, Vec::new());
            let each = state.ledger().contacts.iter().map(|entry| entry.dissipated);
            let (least, sum) = each.fold((f64::INFINITY, 0.0), |(least, sum), d| {
                (d.min(least), sum + d)
            });
            println!("{name}, {law:?}: least {least:e} J, sum {sum:e} J");
            assert!(least >= 0.0);
            let takes = law.damping > 0.0 || law.friction > 0.0;
            assert_eq!(sum > 1e-6, takes, "{sum}");
        }
    }
}

/// With a constant hand force, the leak at the port is this force times the change of the offset.
#[test]
fn with_a_constant_hand_the_leak_is_its_force_times_the_offset() {
    let law = ContactLaw::spring(3000.0)
        .with_damping(2.0)
        .with_friction(0.5);
    let exact = CoupledParams {
        offset_return: 0.0,
        velocity_return: f64::INFINITY,
        ..CoupledParams::new(vec![MASS; 2]).with_prior(Prior::of_a_known_mass())
    };
    let (_, state) = run(exact, law, (0.0, 0.0), 1e-12, Vec::new());
    let forces = [[0.2, 0.1, -1.2], [-0.2, 0.0, -1.5]];
    for (number, (tool, force)) in state.tools().iter().zip(forces).enumerate() {
        let entry = state.ledger().devices[number];
        let leak = entry.offset - entry.velocity_offset + entry.unpaid;
        let model = crate::ideal::dot(force, tool.offset);
        println!(
            "tool {number}: leak {leak:e} J, force times offset {model:e} J, of {:e} J",
            entry.held.abs()
        );
        assert!(
            (leak - model).abs() < 2e-6 * entry.held.abs() && leak.abs() > 1e-5 * entry.held.abs(),
            "{leak} {model}"
        );
    }
}

/// A tool whose device lacks z is moved along z into a springy floor and back by an external motion of the mechanism.
/// The ledger has the work that the mechanism carries, and no energy is generated. Nothing is carried while the tool
/// is at rest.
#[test]
fn what_the_mechanism_of_a_device_carries_is_what_the_contact_stores() {
    let law = ContactLaw::spring(2000.0);
    let floor = vec![plane("floor", [0.0, 0.0, 1.0])];
    let mut world = crate::common::world(0.005, floor, law);
    world.tools[0].axes = [true, true, false];
    let damper = BasicParams {
        damping: vec![3.0],
        ..BasicParams::default()
    };
    let coupling = VirtualCouplingParams {
        stiffness: vec![1000.0],
        damping: vec![1.0],
        mass: vec![0.05],
        ..VirtualCouplingParams::default()
    };
    let methods: [(&str, WorldMethod); 4] = [
        ("virtual damper", damper.into()),
        ("virtual coupling", coupling.into()),
        ("hfcr", HfcrParams::default().into()),
        ("coupled", CoupledParams::new(vec![[0.1; 3]]).into()),
    ];
    for (name, method) in methods {
        let is_sampled = name == "virtual damper" || name == "hfcr";
        let renderer = WorldRenderer::new(&world, WorldLoop::new(0.001), method).unwrap();
        let mut state = renderer.start();
        let mut deepest = 0.0_f64;
        for sample in 0..400 {
            let turn = f64::from(sample) / 200.0 * std::f64::consts::TAU;
            let depth = if sample < 200 {
                0.0005 * (1.0 - turn.cos()) - 0.0001
            } else {
                -0.0001
            };
            let output = renderer.step(&mut state, &Sample::at(&[[0.0, 0.0, 0.005 - depth]]));
            assert_eq!((output.fault, output.forces), (None, &[[0.0; 3]][..]));
            let stored = 0.5 * 2000.0 * depth.max(0.0).powi(2);
            deepest = deepest.max(stored);
            let carried = state.ledger().devices[0].carried;
            // A force that is held between samples is one step late.
            let most = if is_sampled { 4e-5 } else { 1e-9 };
            assert!(
                (carried + stored).abs() < most,
                "{name}: {carried} {stored}"
            );
            let created = state.ledger().created();
            assert!(created.abs() < most, "{name}: {created}");
            assert_eq!(state.ledger().devices[0].port_work, 0.0);
        }
        assert!(deepest > 5e-4, "{deepest}");
    }
}

/// A device without a hand falls on a springy floor and bounces. Its gain in energy once it flies again is the energy
/// generated by the held forces, including that of a damper.
#[test]
#[allow(clippy::print_stdout)] // prints the measured values
fn what_held_forces_created_is_what_the_device_has_gained() {
    let (period, mass, weight) = (0.002, 0.2, 2.0);
    for (name, method) in [
        ("basic", BasicParams::default().into()),
        (
            "virtual damper",
            WorldMethod::from(BasicParams {
                damping: vec![1.0],
                ..BasicParams::default()
            }),
        ),
        (
            "god-object",
            GodObjectParams {
                stiffness: vec![2000.0],
                damping: vec![1.0],
            }
            .into(),
        ),
        ("hfcr", dissipating(vec![0.2]).into()),
        ("coupled", CoupledParams::new(vec![[1.5 * mass; 3]]).into()),
    ] {
        let world = World {
            joints: Vec::new(),
            fields: Vec::new(),
            tools: vec![Tool::new("tool", Shape::Sphere { radius: 0.005 })],
            bodies: vec![plane("floor", [0.0, 0.0, 1.0])],
            contacts: vec![palpate_world::Contact {
                between: [palpate_world::Party::Any, palpate_world::Party::Any],
                law: ContactLaw::spring(2000.0),
            }],
        };
        let renderer = WorldRenderer::new(&world, WorldLoop::new(period), method).unwrap();
        let mut state = renderer.start();
        let (mut z, mut v) = (0.02, 0.0_f64);
        let energy = |z: f64, v: f64| 0.5 * mass * v * v + weight * z;
        let at_start = energy(z, v);
        let mut is_down = false;
        loop {
            let force = renderer
                .step(&mut state, &Sample::at(&[[0.0, 0.0, z]]))
                .forces[0][2];
            is_down |= z < 0.005;
            // It flies again, and the last interval with a force has ended.
            if is_down && z > 0.007 && force == 0.0 {
                break;
            }
            let a = (force - weight) / mass;
            z += v * period + 0.5 * a * period * period;
            v += a * period;
        }
        let gained = energy(z, v) - at_start;
        let created = state.ledger().created();
        println!("{name}: gained {gained:.6} J, created {created:.6} J");
        assert!(
            (created - gained).abs() < 2e-5,
            "{name}: {created} {gained}"
        );
        let is_consistent = name == "coupled" || name == "hfcr";
        assert!(is_consistent || gained > 1e-3, "{name}: {gained}");
    }
}
