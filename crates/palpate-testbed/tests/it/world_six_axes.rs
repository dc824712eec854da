//! Devices of six axes: the ideal against closed forms and its own books, and the plant against the ideal.
#![allow(missing_docs)]

use palpate_testbed::actuator::ActuatorParams;
use palpate_testbed::grid::Grid;
use palpate_testbed::hand::Sinusoid;
use palpate_testbed::world::{
    ContactLaw, Member, Pair, PlantParams, Shape, SphereAt, Tool, Turning, TurningHand, WorldBody,
    WorldDevice, WorldEvaluation, WorldHand, WorldIdeal, WorldPlant, WorldScene,
};

const IDENTITY: [f64; 4] = [1.0, 0.0, 0.0, 0.0];

fn tool(tool: Tool, inertia: [f64; 3], angular_velocity: [f64; 3]) -> WorldDevice {
    WorldDevice {
        name: "tool".into(),
        own_axes: None,
        mass_table: None,
        drivetrain: palpate_testbed::world::Drivetrain::default(),
        mass: [0.2; 3],
        position: [0.0, 0.0, 0.022],
        velocity: [0.05, 0.0, -0.3],
        tool,
        turning: Some(Turning {
            inertia,
            orientation: IDENTITY,
            angular_velocity,
            hand: TurningHand::none(),
            gives_torque: true,
            quantum: 0.0,
        }),
        hand: WorldHand::default(),
        quantum: [0.0; 3],
    }
}

fn dumbbell() -> Tool {
    let end = |x: f64| SphereAt {
        centre: [x, 0.0, 0.0],
        radius: 0.008,
    };
    Tool::Spheres(vec![end(-0.03), end(0.03)])
}

fn alone(device: WorldDevice) -> WorldScene {
    WorldScene {
        joints: Vec::new(),
        fields: Vec::new(),
        devices: vec![device],
        ..WorldScene::default()
    }
}

/// A dumbbell in a hand that turns it, with tremor, on a rough table.
fn on_a_table() -> WorldScene {
    let mut device = tool(dumbbell(), [3e-5, 2e-4, 2.2e-4], [0.0, 2.0, 1.0]);
    device.hand.force = [0.1, 0.0, -4.0];
    let sine = |amplitude| {
        vec![Sinusoid {
            amplitude,
            frequency_hz: 9.0,
            phase: 0.4,
        }]
    };
    let turning = device.turning.as_mut().unwrap();
    turning.hand = TurningHand {
        torque: [0.0, 0.005, 0.002],
        stiffness: 0.3,
        damping: 0.003,
        rest: [0.995, 0.0, 0.0998, 0.0].map(|x: f64| x / (0.995_f64.hypot(0.0998))),
        tremor: [sine(0.001), sine(0.002), vec![]],
    };
    let table = WorldBody {
        name: "table".into(),
        shape: Shape::HalfSpace {
            normal: [0.0, 0.0, 1.0],
            offset: 0.0,
        },
        position: [0.0; 3],
        orientation: IDENTITY,
        motion: None,
    };
    WorldScene {
        joints: Vec::new(),
        fields: Vec::new(),
        devices: vec![device],
        bodies: vec![table],
        pairs: vec![Pair {
            between: [Member::Device(0), Member::Body(0)],
            law: ContactLaw::spring(5000.0).damped(2.0).rough(0.3, 4000.0),
        }],
    }
}

/// A top with two equal moments turns its axis about the angular momentum at a rate L/I.
#[test]
fn a_symmetric_tool_precesses_at_the_rate_of_the_closed_form() {
    let (across, along) = (2e-4, 5e-5);
    let omega = [1.5, 0.0, 20.0];
    let scene = alone(tool(Tool::sphere(0.0), [across, across, along], omega));
    let grid = Grid::even(0.0, 0.01, 30);
    let ideal = WorldIdeal::new(&scene, grid).unwrap();
    let momentum = [across * omega[0], 0.0, along * omega[2]];
    let size = momentum[0].hypot(momentum[2]);
    let axis = momentum.map(|l| l / size);
    for state in &ideal.states {
        let turn = size / across * state.time;
        // The tool's z axis, turned about the momentum: Rodrigues' formula.
        let z = [0.0, 0.0, 1.0];
        let dot = axis[2];
        let cross = [axis[1], -axis[0], 0.0];
        let expected: [f64; 3] = std::array::from_fn(|i| {
            z[i] * turn.cos() + cross[i] * turn.sin() + axis[i] * dot * (1.0 - turn.cos())
        });
        let [w, x, y, z] = state.devices[0].orientation;
        let found = [
            2.0 * (x * z + w * y),
            2.0 * (y * z - w * x),
            1.0 - 2.0 * (x * x + y * y),
        ];
        for i in 0..3 {
            assert!(
                (found[i] - expected[i]).abs() < 1e-8,
                "{found:?} {expected:?}"
            );
        }
    }
}

#[test]
fn energy_in_is_energy_kept_and_energy_out() {
    let scene = on_a_table();
    let ideal = WorldIdeal::new(&scene, Grid::even(0.0, 0.001, 300)).unwrap();
    let start = ideal.states[0].ledger.balance();
    let last = ideal.states.last().unwrap();
    let off = (last.ledger.balance() - start).abs();
    assert!(last.ledger.dissipated > 1e-4 && last.ledger.hand_work.abs() > 1e-4);
    assert!(off < 1e-9 * last.ledger.dissipated, "{off}");
    assert!(
        ideal
            .states
            .iter()
            .any(|it| it.devices[0].torque[1].abs() > 0.01)
    );
}

#[test]
fn without_contact_the_plant_turns_as_the_ideal_does() {
    let mut scene = on_a_table();
    scene.pairs.clear();
    let ideal = WorldIdeal::new(&scene, Grid::even(0.0, 0.01, 40)).unwrap();
    let mut plant = WorldPlant::new(&scene, PlantParams::perfect(0.01)).unwrap();
    for state in &ideal.states {
        let device = &state.devices[0];
        for i in 0..4 {
            let off = plant.orientations()[0][i] - device.orientation[i];
            assert!(off.abs() < 1e-9, "{off}");
        }
        for i in 0..3 {
            let off = plant.angular_velocities()[0][i] - device.angular_velocity[i];
            assert!(off.abs() < 1e-6, "{off}");
        }
        plant.hold_wrenches(&[[0.0; 3]], &[[0.0; 3]]);
    }
}

#[test]
fn a_held_torque_is_that_of_the_hand_and_comes_later_through_a_lag() {
    let mut pushed = on_a_table();
    pushed.pairs.clear();
    let turning = pushed.devices[0].turning.as_mut().unwrap();
    turning.hand.torque = [0.004, 0.002, 0.002];
    let ideal = WorldIdeal::new(&pushed, Grid::even(0.0, 0.01, 20)).unwrap();
    let mut scene = on_a_table();
    scene.pairs.clear();
    let mut plant = WorldPlant::new(&scene, PlantParams::perfect(0.01)).unwrap();
    let mut late = PlantParams::perfect(0.01);
    late.actuator = ActuatorParams {
        gain: 0.8,
        lag: 0.003,
    };
    let mut late = WorldPlant::new(&scene, late).unwrap();
    let torque = [0.004, -0.003, 0.0];
    for _ in 0..20 {
        plant.hold_wrenches(&[[0.0; 3]], &[torque]);
        late.hold_wrenches(&[[0.0; 3]], &[torque]);
    }
    for i in 0..4 {
        let off = plant.orientations()[0][i] - ideal.states[20].devices[0].orientation[i];
        assert!(off.abs() < 1e-9, "{off}");
    }
    let settling: f64 = 0.003 * (1.0 - (-10.0_f64 / 3.0).exp());
    let expected = 0.8 * (1.0 - settling / 0.01);
    let first = late.delivered_torque(0)[0];
    for (given, asked) in first.iter().zip(torque) {
        assert!((given - expected * asked).abs() < 1e-15, "{given}");
    }
}

#[test]
fn a_quantum_rounds_the_turns_since_the_start() {
    let mut scene = alone(tool(Tool::sphere(0.0), [1e-4; 3], [0.3, -0.7, 0.2]));
    let quantum = 1e-3;
    scene.devices[0].turning.as_mut().unwrap().quantum = quantum;
    let mut plant = WorldPlant::new(&scene, PlantParams::perfect(0.001)).unwrap();
    let mut apart = 0.0_f64;
    for _ in 0..50 {
        plant.hold_wrenches(&[], &[]);
        let ([w, x, y, z], exact) = (plant.measure_orientations()[0], plant.orientations()[0]);
        let length = [w, x, y, z].iter().map(|part| part * part).sum::<f64>();
        assert!((length - 1.0).abs() < 1e-12);
        let off = [x - exact[1], y - exact[2], z - exact[3]].map(|part| 2.0 * part.abs());
        apart = off.into_iter().fold(apart, f64::max);
    }
    assert!(apart > 0.3 * quantum && apart < 0.6 * quantum, "{apart}");
}

#[test]
fn floor_and_error_add_up_in_squares_for_torques_too() {
    let scene = on_a_table();
    let ideal = WorldIdeal::new(&scene, Grid::even(0.0, 0.001, 200)).unwrap();
    let means = |impulses: &[[f64; 3]]| -> Vec<[f64; 3]> {
        impulses.iter().map(|it| it.map(|j| j / 0.001)).collect()
    };
    let best = [means(&ideal.devices[0].impulses)];
    let best_torque = [means(&ideal.devices[0].torque_impulses)];
    let at_best = WorldEvaluation::of_wrenches(&scene, &ideal, &best, &best_torque).unwrap();
    let none = WorldEvaluation::new(&scene, &ideal, &best).unwrap();
    let sum = at_best.sum.unwrap();
    assert!(
        sum.mean_force_error < 1e-9 && sum.hold_bound > 0.5,
        "{sum:?}"
    );
    // Without rendered torques the torque error is 100 %, and the force error is 0.
    let device = &none.devices[0];
    let torque = device.torque.as_ref().unwrap().sum.unwrap();
    assert!(
        (torque.force_rendering_error - 100.0).abs() < 1e-9,
        "{torque:?}"
    );
    assert!(device.force.unwrap().mean_force_error < 1e-9);
    for fidelity in [device.sum.unwrap(), torque, none.sum.unwrap()] {
        let squares = fidelity.hold_bound.hypot(fidelity.mean_force_error);
        assert!((squares - fidelity.force_rendering_error).abs() < 1e-9);
    }
    assert!(device.sum.unwrap().mean_force_error > 20.0);
}

#[test]
fn what_is_wrong_with_a_device_of_six_axes_is_named() {
    let refused = |change: fn(&mut Turning)| {
        let mut scene = on_a_table();
        change(scene.devices[0].turning.as_mut().unwrap());
        let error = WorldIdeal::new(&scene, Grid::even(0.0, 0.001, 1)).unwrap_err();
        error.to_string()
    };
    assert!(refused(|it| it.inertia[1] = 0.0).starts_with("devices[0].turning.inertia = 0"));
    assert!(refused(|it| it.orientation[0] = 2.0).starts_with("devices[0].turning.orientation"));
    assert!(refused(|it| it.hand.damping = -1.0).starts_with("devices[0].turning.hand.damping"));
    let mut scene = on_a_table();
    scene.devices[0].tool = Tool::Spheres(Vec::new());
    let error = WorldIdeal::new(&scene, Grid::even(0.0, 0.001, 1)).unwrap_err();
    assert!(
        error.to_string().starts_with("devices[0].tool = 0"),
        "{error}"
    );
}

/// The pen of a device that gives no torque: what it touches does not turn it, and the hand's work has what it takes
/// up.
#[test]
fn a_hand_alone_turns_a_tool_whose_device_gives_no_torque() {
    let mut scene = on_a_table();
    let turning = scene.devices[0].turning.as_mut().unwrap();
    turning.gives_torque = false;
    let grid = Grid::even(0.0, 0.001, 300);
    let ideal = WorldIdeal::new(&scene, grid.clone()).unwrap();
    let in_the_air = WorldScene {
        pairs: Vec::new(),
        ..scene.clone()
    };
    let in_the_air = WorldIdeal::new(&in_the_air, grid.clone()).unwrap();
    let turned_away = |one: &WorldIdeal, other: &WorldIdeal| {
        let states = one.states.iter().zip(&other.states);
        let each = states.map(|(one, other)| {
            let [one, other] = [one, other].map(|state| state.devices[0].orientation);
            let dot: f64 = one.iter().zip(other).map(|(a, b)| a * b).sum();
            1.0 - dot.abs()
        });
        each.fold(0.0, f64::max)
    };
    let most = |ideal: &WorldIdeal| {
        let torques = ideal.states.iter().map(|it| it.devices[0].torque[1].abs());
        torques.fold(0.0, f64::max)
    };
    let apart = turned_away(&ideal, &in_the_air);
    assert!(most(&ideal) > 0.01 && apart < 1e-12, "{apart}");
    // A device of six axes is turned by them.
    let turned = WorldIdeal::new(&on_a_table(), grid.clone()).unwrap();
    assert!(turned_away(&turned, &in_the_air) > 1e-3);

    let [start, last] = [0, 300].map(|state: usize| &ideal.states[state].ledger);
    let off = (last.balance() - start.balance()).abs();
    assert!(
        last.dissipated > 1e-4 && off < 1e-9 * last.dissipated,
        "{off}"
    );

    // No motor turns the device either, and no torque is evaluated.
    let mut plant = WorldPlant::new(&scene, PlantParams::perfect(0.001)).unwrap();
    for state in &in_the_air.states[..300] {
        let found = plant.orientations()[0];
        let off = found.iter().zip(state.devices[0].orientation);
        let off = off.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-7, "{off}");
        plant.hold_wrenches(&[[0.0; 3]], &[[0.3, -0.2, 0.1]]);
    }
    assert!(
        plant
            .delivered_torque(0)
            .iter()
            .flatten()
            .all(|x| *x == 0.0)
    );
    let forces = ideal.devices[0].mean_forces(&grid);
    let evaluated = WorldEvaluation::new(&scene, &ideal, &[forces]).unwrap();
    assert_eq!(evaluated.devices[0].torque, None);
    assert!(evaluated.sum.unwrap().mean_force_error < 1e-9);
}
