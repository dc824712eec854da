//! Devices whose mass is another at each place.

use std::sync::Arc;

use palpate_testbed::grid::Grid;
use palpate_testbed::world::{
    ContactLaw, MassTable, Member, Pair, PlantParams, Tool, Vector, WorldHand, WorldIdeal,
    WorldPlant, WorldScene,
};

use super::{device, half_space};

const WORLD: [Vector; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const MASS: f64 = 0.2;
/// Per metre: how much the coordinates of [`straight`] bend.
const BENDS: [f64; 3] = [4.0, -3.0, 3.0];

/// Coordinates in which a device of the mass `J^T J` times [`MASS`], J their derivative by the place, is a point mass.
fn straight([x, y, z]: Vector) -> Vector {
    let [a, b, c] = BENDS;
    [x + a * x * y, y + b * x * y, z + c * x * z]
}

fn derivative([x, y, z]: Vector) -> [Vector; 3] {
    let [a, b, c] = BENDS;
    [
        [1.0 + a * y, a * x, 0.0],
        [b * y, 1.0 + b * x, 0.0],
        [c * z, 0.0, 1.0 + c * x],
    ]
}

fn mass(place: Vector) -> [f64; 6] {
    let j = derivative(place);
    let of =
        |row: usize, column: usize| MASS * (0..3).map(|k| j[k][row] * j[k][column]).sum::<f64>();
    [of(0, 0), of(1, 1), of(2, 2), of(0, 1), of(0, 2), of(1, 2)]
}

fn table(places: [Vec<f64>; 3], mass: impl Fn(Vector) -> [f64; 6]) -> MassTable {
    let mut masses = Vec::new();
    for &x in &places[0] {
        for &y in &places[1] {
            for &z in &places[2] {
                masses.push(mass([x, y, z]));
            }
        }
    }
    MassTable::new(WORLD, places, masses).unwrap()
}

/// Places at unequal distances: a matrix that is of second order along each axis is the table's everywhere.
fn places() -> [Vec<f64>; 3] {
    [
        vec![-0.05, -0.02, 0.01, 0.05],
        vec![-0.05, 0.0, 0.02, 0.06],
        vec![-0.04, 0.01, 0.05],
    ]
}

fn free() -> WorldScene {
    let mut tool = device(MASS, [-0.03, 0.02, -0.02]);
    tool.mass_table = Some(Arc::new(table(places(), mass)));
    tool.velocity = [0.25, -0.2, 0.15];
    WorldScene {
        devices: vec![tool],
        ..WorldScene::default()
    }
}

#[test]
fn a_device_of_one_mass_in_other_coordinates_goes_straight_in_them() {
    let scene = free();
    let ideal = WorldIdeal::new(&scene, Grid::even(0.0, 0.01, 20)).unwrap();
    let device = &scene.devices[0];
    let (start, j) = (straight(device.position), derivative(device.position));
    let speed = j.map(|row| (0..3).map(|k| row[k] * device.velocity[k]).sum::<f64>());
    let mut most = 0.0_f64;
    for state in &ideal.states {
        let now = straight(state.devices[0].position);
        for axis in 0..3 {
            most = most.max((now[axis] - start[axis] - speed[axis] * state.time).abs());
        }
    }
    let first = device.velocity;
    let last = ideal.states[20].devices[0].velocity;
    println!("{most:e} m off; {first:?} m/s became {last:?}");
    assert!(most < 1e-11, "{most:e}");
    assert!((last[0] / first[0] - 1.0).abs() > 0.1, "{last:?}");
}

#[test]
fn a_free_linkage_keeps_its_energy_where_its_table_has_no_formula() {
    let mut scene = free();
    let uneven = |[x, y, z]: Vector| {
        let wave = (60.0 * x).sin() * (50.0 * y).cos() + 0.3 * (70.0 * z).sin();
        [
            0.2 + 0.05 * wave,
            0.16 - 0.03 * wave,
            0.3,
            0.06 * wave,
            0.02,
            0.04 * wave,
        ]
    };
    scene.devices[0].mass_table = Some(Arc::new(table(places(), uneven)));
    let ideal = WorldIdeal::new(&scene, Grid::even(0.0, 0.01, 20)).unwrap();
    let kinetic = ideal.states.iter().map(|state| state.ledger.kinetic);
    let start = ideal.states[0].ledger.kinetic;
    let most = kinetic.fold(0.0_f64, |most, now| most.max((now / start - 1.0).abs()));
    let speed = |state: usize| {
        let parts = ideal.states[state].devices[0].velocity;
        parts.iter().map(|part| part * part).sum::<f64>().sqrt()
    };
    println!(
        "energy off by {most:e}; {} m/s became {}",
        speed(0),
        speed(20)
    );
    assert!(most < 1e-8, "{most:e}");
    assert!((speed(20) / speed(0) - 1.0).abs() > 0.02);
}

fn in_a_hand() -> WorldScene {
    let mut scene = free();
    let tool = &mut scene.devices[0];
    tool.tool = Tool::sphere(0.004);
    tool.hand = WorldHand {
        force: [0.4, 0.1, -1.0],
        stiffness: 40.0,
        damping: 1.0,
        rest: [0.0, 0.01, 0.0],
        ..WorldHand::default()
    };
    scene
}

#[test]
fn in_a_loop_without_force_it_moves_as_the_ideal_does() {
    let [s, c] = [0.6, 0.8];
    let mut flat = in_a_hand();
    // In a plane that leans: two axes of three.
    let axes = [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]];
    let tool = &mut flat.devices[0];
    tool.own_axes = Some(axes);
    tool.mass = [MASS, MASS, f64::INFINITY];
    let in_plane = |[x, y, _]: Vector| mass([x, y, 0.01]);
    let [x, y, _] = places();
    let mut masses = Vec::new();
    for &x in &x {
        for &y in &y {
            masses.push(in_plane([x, y, 0.0]));
        }
    }
    tool.mass_table = Some(Arc::new(
        MassTable::new(axes, [x, y, vec![0.0]], masses).unwrap(),
    ));
    tool.velocity = [0.25 * c, -0.2, 0.25 * s];
    for scene in [in_a_hand(), flat] {
        let ideal = WorldIdeal::new(&scene, Grid::even(0.0, 0.004, 50)).unwrap();
        let mut plant = WorldPlant::new(&scene, PlantParams::perfect(0.004)).unwrap();
        for state in &ideal.states {
            for axis in 0..3 {
                let [x, u] = [plant.positions()[0][axis], plant.velocities()[0][axis]];
                let of = &state.devices[0];
                assert!((x - of.position[axis]).abs() < 1e-9, "{}", state.time);
                assert!((u - of.velocity[axis]).abs() < 1e-7, "{}", state.time);
            }
            plant.hold(&[[0.0; 3]]);
        }
        if scene.devices[0].own_axes.is_some() {
            let start = scene.devices[0].position;
            let end = plant.positions()[0];
            let across: f64 = (0..3).map(|k| axes[2][k] * (end[k] - start[k])).sum();
            assert!(across.abs() < 1e-15, "{across:e}");
        }
    }
}

#[test]
fn a_table_of_one_matrix_is_a_mass() {
    let mut scene = in_a_hand();
    scene.devices[0].hand.tremor[2].push(palpate_testbed::hand::Sinusoid {
        amplitude: 0.1,
        frequency_hz: 9.0,
        phase: 0.3,
    });
    scene.bodies.push(half_space([0.0, 0.0, 1.0], -0.03));
    scene.pairs.push(Pair {
        between: [Member::Device(0), Member::Body(0)],
        law: ContactLaw::spring(2000.0).damped(1.0).rough(0.4, 2000.0),
    });
    scene.devices[0].velocity[2] = -0.2;
    let masses = [0.1, 0.16, 0.3];
    scene.devices[0].mass = masses;
    let one = |_: Vector| [masses[0], masses[1], masses[2], 0.0, 0.0, 0.0];
    let mut constant = scene.clone();
    constant.devices[0].mass_table = None;
    scene.devices[0].mass_table = Some(Arc::new(table(places(), one)));
    let [table, constant] = [scene, constant].map(|scene| {
        let ideal = WorldIdeal::new(&scene, Grid::even(0.0, 0.004, 50)).unwrap();
        let actuated = PlantParams {
            actuator: palpate_testbed::actuator::ActuatorParams {
                gain: 0.9,
                lag: 0.002,
            },
            ..PlantParams::perfect(0.004)
        };
        let mut plant = WorldPlant::new(&scene, actuated).unwrap();
        for sample in 0..50 {
            plant.hold(&[[0.1, -0.5, f64::from(sample) * 0.02]]);
        }
        (ideal, plant)
    });
    let pushed = |ideal: &WorldIdeal| ideal.encounters[0].impulse;
    assert!(pushed(&constant.0)[2] > 0.05, "{:?}", pushed(&constant.0));
    for axis in 0..3 {
        let apart = pushed(&table.0)[axis] - pushed(&constant.0)[axis];
        assert!(apart.abs() < 1e-8, "{apart:e}");
        let [one, other] = [&table.1, &constant.1];
        let apart = one.positions()[0][axis] - other.positions()[0][axis];
        assert!(apart.abs() < 1e-9, "{apart:e}");
        let last = |plant: &WorldPlant| plant.delivered(0)[37][axis];
        assert!((last(one) - last(other)).abs() < 1e-12);
    }
}

#[test]
fn what_is_wrong_with_a_table_is_named() {
    let new = |places: [&[f64]; 3], masses: &[[f64; 6]]| {
        MassTable::new(WORLD, places.map(<[f64]>::to_vec), masses.to_vec())
            .map(|_| ())
            .map_err(|wrong| wrong.to_string())
    };
    let unit = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0];
    assert_eq!(new([&[0.0, 0.1], &[0.0], &[0.0]], &[unit; 2]), Ok(()));
    for (places, masses, says) in [
        (
            [&[0.1, 0.0][..], &[0.0], &[0.0]],
            vec![unit; 2],
            "places = 0.1",
        ),
        ([&[0.0][..], &[], &[0.0]], vec![], "places = NaN"),
        (
            [&[0.0, 0.1][..], &[0.0], &[0.0]],
            vec![unit; 3],
            "masses = 3",
        ),
        (
            [&[0.0][..], &[0.0], &[0.0]],
            vec![[1.0, 1.0, 1.0, 2.0, 0.0, 0.0]],
            "positive definite",
        ),
        // Between the last two places the parabola goes below 0.
        (
            [&[0.0, 0.1, 0.2, 0.3][..], &[0.0], &[0.0]],
            [9.0, 1.0, 0.01, 0.05]
                .map(|m| [m, 1.0, 1.0, 0.0, 0.0, 0.0])
                .to_vec(),
            "in between",
        ),
    ] {
        let refused = new(places, &masses).unwrap_err();
        assert!(refused.contains(says), "{refused}");
    }
}
