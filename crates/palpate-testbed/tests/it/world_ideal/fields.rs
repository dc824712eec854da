//! Devices in force fields.

use palpate_testbed::world::{Attractor, ForceField, Potential, WorldIdeal, WorldScene};

use super::{device, solve};

const MASS: f64 = 0.2;

fn in_fields(start: [f64; 3], potentials: &[Potential], end: f64) -> WorldIdeal {
    let fields = potentials.iter().map(|&potential| ForceField {
        device: 0,
        potential,
    });
    let scene = WorldScene {
        devices: vec![device(MASS, start)],
        fields: fields.collect(),
        ..WorldScene::default()
    };
    solve(&scene, end / 10.0, 10)
}

/// x = A cos ω t about the point, line or plane.
#[test]
fn a_device_on_a_spring_oscillates_along_the_spring_alone() {
    let (at, stiffness) = ([0.01, -0.02, 0.03], 300.0);
    let start = [0.02, -0.01, 0.045];
    let end = 0.37;
    let cosine = ((stiffness / MASS).sqrt() * end).cos();
    for (to, pulled) in [
        (Attractor::Point, [1.0, 1.0, 1.0]),
        (Attractor::Line([0.0, 1.0, 0.0]), [1.0, 0.0, 1.0]),
        (Attractor::Plane([0.0, 0.0, 1.0]), [0.0, 0.0, 1.0]),
    ] {
        let spring = Potential::Spring {
            to,
            at,
            stiffness,
            range: 1.0,
        };
        let ideal = in_fields(start, &[spring], end);
        let found = ideal.states.last().unwrap().devices[0].position;
        for axis in 0..3 {
            let away = start[axis] - at[axis];
            let expected = at[axis] + away * if pulled[axis] == 1.0 { cosine } else { 1.0 };
            assert!((found[axis] - expected).abs() < 1e-10, "{to:?}: {found:?}");
        }
    }
}

/// Beyond the range the acceleration is K r/m.
#[test]
fn a_spring_beyond_its_range_pulls_with_a_constant_force() {
    let spring = Potential::Spring {
        to: Attractor::Point,
        at: [0.0; 3],
        stiffness: 300.0,
        range: 0.004,
    };
    let ideal = in_fields([0.05, 0.0, 0.0], &[spring], 0.1);
    let found = ideal.states.last().unwrap().devices[0].position[0];
    let expected = 0.05 - 0.5 * 300.0 * 0.004 / MASS * 0.1 * 0.1;
    assert!((found - expected).abs() < 1e-12, "{found}");
}

/// A device that leaves a stop with slightly more than A passes all positions, and turns back at the other stop.
#[test]
fn a_device_passes_detents_and_turns_back_at_the_stops() {
    let (amplitude, stiffness, period) = (0.002, 2000.0, 0.005);
    let detents = Potential::Detents {
        at: [0.0; 3],
        axis: [1.0, 0.0, 0.0],
        positions: 4,
        period,
        amplitude,
        stiffness,
    };
    let start = [-1e-5 - (2.0 * amplitude / stiffness).sqrt(), 0.0, 0.0];
    let spring = Potential::Spring {
        to: Attractor::Line([1.0, 0.0, 0.0]),
        at: [0.0; 3],
        stiffness: 100.0,
        range: 0.001,
    };
    let push = Potential::Constant {
        force: [1e-3, 0.0, -0.2],
    };
    let ideal = in_fields(start, &[detents, spring, push], 2.0);
    let first = ideal.states[0].ledger.balance();
    let (mut furthest, mut apart) = (0.0_f64, 0.0_f64);
    for state in &ideal.states {
        apart = apart.max((state.ledger.balance() - first).abs());
        furthest = furthest.max(state.devices[0].position[0]);
    }
    println!("energy error {apart:e} J of {first:e} J");
    assert!(apart < 1e-8 * first, "{apart} {first}");
    // It has crossed all positions.
    assert!(furthest > 2.5 * period, "{furthest}");
}

#[test]
fn a_field_of_no_device_is_refused() {
    let scene = WorldScene {
        devices: vec![device(MASS, [0.0; 3])],
        fields: vec![ForceField {
            device: 1,
            potential: Potential::Constant { force: [0.0; 3] },
        }],
        ..WorldScene::default()
    };
    let grid = palpate_testbed::grid::Grid::even(0.0, 0.1, 2);
    let error = WorldIdeal::new(&scene, grid).unwrap_err().to_string();
    assert!(error.contains("fields[0].device"), "{error}");
}
