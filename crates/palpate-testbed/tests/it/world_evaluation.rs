//! Evaluation of worlds: hold bounds, errors, touches and windows.
#![allow(clippy::print_stdout)] // what was measured

use palpate_testbed::grid::Grid;
use palpate_testbed::metrics::{Fidelity, WindowMismatch};
use palpate_testbed::world::{
    ContactLaw, EvaluationError, FreeMotion, Member, Pair, PlantParams, Shape, Tool, Vector,
    WindowRule, WorldBody, WorldDevice, WorldEvaluation, WorldHand, WorldIdeal, WorldPlant,
    WorldScene,
};

const PERIOD: f64 = 0.004;

/// Two devices of unequal axes on a ball between them.
fn scene() -> WorldScene {
    let shape = Shape::Sphere { radius: 0.03 };
    let device = |x: f64, push: f64| WorldDevice {
        name: "tool".into(),
        own_axes: None,
        mass_table: None,
        drivetrain: palpate_testbed::world::Drivetrain::default(),
        mass: [0.1, 0.16, 0.25],
        position: [x, 0.004, 0.002],
        velocity: [0.0; 3],
        tool: Tool::sphere(0.01),
        turning: None,
        hand: WorldHand {
            force: [push, 0.0, 0.1],
            stiffness: 60.0,
            damping: 1.5,
            rest: [x, 0.0, 0.0],
            ..WorldHand::default()
        },
        quantum: [0.0; 3],
    };
    let law = ContactLaw::spring(2000.0).rough(0.3, 1000.0).damped(0.5);
    WorldScene {
        joints: Vec::new(),
        fields: Vec::new(),
        devices: vec![device(-0.045, 1.0), device(0.05, -1.2)],
        bodies: vec![WorldBody {
            name: "ball".into(),
            shape: shape.clone(),
            position: [0.0; 3],
            orientation: [1.0, 0.0, 0.0, 0.0],
            motion: Some(FreeMotion::new(&shape, 0.1)),
        }],
        pairs: (0..2)
            .map(|device| Pair {
                between: [Member::Device(device), Member::Body(0)],
                law,
            })
            .collect(),
    }
}

fn ideal(grid: Grid) -> WorldIdeal {
    WorldIdeal::new(&scene(), grid).unwrap()
}

fn means(ideal: &WorldIdeal) -> Vec<Vec<Vector>> {
    let of_device =
        |device: &palpate_testbed::world::DeviceProfile| device.mean_forces(&ideal.grid);
    ideal.devices.iter().map(of_device).collect()
}

/// The means, each changed in its own way.
fn rendered(ideal: &WorldIdeal) -> Vec<Vec<Vector>> {
    let mut held = means(ideal);
    for (number, forces) in held.iter_mut().enumerate() {
        for (i, force) in forces.iter_mut().enumerate() {
            for (axis, f) in force.iter_mut().enumerate() {
                *f += 0.3 * ((i * (axis + 2) + 5 * number) as f64).sin();
            }
        }
    }
    held
}

fn all(evaluation: &WorldEvaluation) -> Vec<Fidelity> {
    let of_devices = evaluation
        .devices
        .iter()
        .flat_map(|device| device.axes.into_iter().chain([device.sum]));
    of_devices.chain([evaluation.sum]).flatten().collect()
}

#[test]
fn the_interval_means_are_at_the_floor_and_have_no_error() {
    let ideal = ideal(Grid::even(0.0, PERIOD, 60));
    let evaluation = WorldEvaluation::new(&scene(), &ideal, &means(&ideal)).unwrap();
    let all = all(&evaluation);
    assert_eq!(all.len(), 9);
    for fidelity in all {
        assert!(fidelity.mean_force_error < 1e-12);
        assert!(fidelity.hold_bound > 1.0);
        assert!((fidelity.error_over_bound.unwrap() - 1.0).abs() < 1e-12);
    }
    for device in &evaluation.devices {
        assert!(!device.touches.is_empty());
        for touch in &device.touches {
            let rendered = touch.rendered.as_ref().unwrap();
            assert_eq!(rendered.impulse_error, Some(0.0));
            // An interval mean is below the peak within that interval.
            assert!(rendered.peak_error.unwrap() <= 1e-6);
        }
    }
}

/// Under forces of the hand that do not depend on the motion, a device has the ideal's momentum at each sample if the
/// means of the ideal force are held; only its place differs. It is what a renderer without error does.
#[test]
fn held_means_give_a_device_the_momentum_of_the_ideal() {
    let mut scene = scene();
    for device in &mut scene.devices {
        (device.hand.stiffness, device.hand.damping) = (0.0, 0.0);
    }
    let ideal = WorldIdeal::new(&scene, Grid::even(0.0, PERIOD, 60)).unwrap();
    let held = means(&ideal);
    let mut plant = WorldPlant::new(&scene, PlantParams::perfect(PERIOD)).unwrap();
    let mut off = 0.0_f64;
    for (sample, state) in ideal.states.iter().enumerate() {
        for (number, device) in state.devices.iter().enumerate() {
            for axis in 0..3 {
                let velocity = plant.velocities()[number][axis];
                assert!((velocity - device.velocity[axis]).abs() < 1e-11);
                let place = plant.positions()[number][axis];
                off = off.max((place - device.position[axis]).abs());
            }
        }
        if sample < 60 {
            plant.hold(&[held[0][sample], held[1][sample]]);
        }
    }
    println!("places differ by up to {:.1} um", 1e6 * off);
    assert!(off > 1e-6);
}

#[test]
fn the_square_of_the_error_is_that_of_floor_and_mean_force_error_on_any_grid() {
    let cut: Vec<f64> = (0..50)
        .map(|i| 0.004 * f64::from(i) + 0.001 * f64::from(i % 3))
        .collect();
    for grid in [
        Grid::even(0.0, PERIOD, 60),
        Grid::cut_at(cut, PERIOD).unwrap(),
    ] {
        let ideal = ideal(grid);
        let evaluation = WorldEvaluation::new(&scene(), &ideal, &rendered(&ideal)).unwrap();
        for fidelity in all(&evaluation) {
            let sum = fidelity.hold_bound.hypot(fidelity.mean_force_error);
            assert!(fidelity.mean_force_error > 1.0);
            assert!((fidelity.force_rendering_error / sum - 1.0).abs() < 1e-12);
        }
    }
}

#[test]
fn errors_in_sum_count_by_the_mobility_of_each_axis() {
    let ideal = ideal(Grid::even(0.0, PERIOD, 60));
    let held = rendered(&ideal);
    let evaluation = WorldEvaluation::new(&scene(), &ideal, &held).unwrap();
    let (mut apart, mut of_ideal) = (0.0, 0.0);
    for (device, held) in ideal.devices.iter().zip(&held) {
        for (axis, mass) in [0.1, 0.16, 0.25].iter().enumerate() {
            for (interval, force) in held.iter().enumerate() {
                let mean = device.impulses[interval][axis] / PERIOD;
                apart += PERIOD * (force[axis] - mean).powi(2) / mass;
                of_ideal += device.squares[interval][axis] / mass;
            }
        }
    }
    let expected = 100.0 * f64::sqrt(apart / of_ideal);
    let found = evaluation.sum.unwrap().mean_force_error;
    println!("E {found:.3} %");
    assert!((found / expected - 1.0).abs() < 1e-12);
}

#[test]
fn the_squares_are_those_of_the_force_and_not_of_its_samples() {
    // Finer grids have floors that go to 0 and the same squares in sum.
    let squares = |intervals: u32| -> (f64, f64) {
        let ideal = ideal(Grid::even(
            0.0,
            0.24 / f64::from(intervals),
            intervals as usize,
        ));
        let sum = ideal.devices[0]
            .squares
            .iter()
            .map(|q| q.iter().sum::<f64>())
            .sum();
        let evaluation = WorldEvaluation::new(&scene(), &ideal, &means(&ideal)).unwrap();
        (sum, evaluation.sum.unwrap().hold_bound)
    };
    let (coarse, floor) = squares(60);
    let (fine, low) = squares(1920);
    println!("floors {floor:.2} % at 4 ms, {low:.3} % at 125 us");
    assert!((coarse / fine - 1.0).abs() < 1e-9);
    assert!(low < 0.1 * floor && low > 0.001);
}

#[test]
fn touches_are_paired_in_order_and_missing_ones_are_none() {
    let ideal = ideal(Grid::even(0.0, PERIOD, 60));
    let mut held = means(&ideal);
    for force in &mut held[0] {
        *force = force.map(|f| 0.9 * f);
    }
    for force in &mut held[1] {
        *force = [0.0; 3];
    }
    let evaluation = WorldEvaluation::new(&scene(), &ideal, &held).unwrap();
    for touch in &evaluation.devices[0].touches {
        let error = touch.rendered.as_ref().unwrap().impulse_error.unwrap();
        assert!((error - 0.1).abs() < 1e-12);
    }
    assert_eq!(evaluation.devices[1].rendered_touches, 0);
    let mut touches = evaluation.devices[1].touches.iter();
    assert!(touches.all(|touch| touch.rendered.is_none()));
    let silent = evaluation.devices[1].sum.unwrap();
    assert!((silent.force_rendering_error - 100.0).abs() < 1e-12);
}

#[test]
fn a_window_ends_with_a_touch_or_after_a_time() {
    let scene = scene();
    let rule = |touches, longest| WindowRule { touches, longest };
    assert_eq!(rule(None, 0.24).intervals(&scene, PERIOD).unwrap(), 60);
    let ideal = ideal(Grid::even(0.0, PERIOD, 60));
    let mut ends: Vec<f64> = [0, 1]
        .iter()
        .flat_map(|device| ideal.touches_of(*device))
        .filter_map(|(_, end)| end)
        .collect();
    ends.sort_by(f64::total_cmp);
    assert!(ends.len() >= 3, "{ends:?}");
    let second = rule(Some(2), 0.24).intervals(&scene, PERIOD).unwrap() as f64 * PERIOD;
    assert!(second >= ends[1] + 0.5 * PERIOD && second < ends[1] + 1.5 * PERIOD);
    assert_eq!(rule(Some(900), 0.24).intervals(&scene, PERIOD).unwrap(), 60);
    assert_eq!(rule(Some(1), 0.002).intervals(&scene, PERIOD).unwrap(), 1);
}

#[test]
fn forces_that_do_not_fit_are_refused_and_bad_ones_are_infinite() {
    let ideal = ideal(Grid::even(0.0, PERIOD, 20));
    let mut held = means(&ideal);
    held[1].pop();
    assert_eq!(
        WorldEvaluation::new(&scene(), &ideal, &held).unwrap_err(),
        EvaluationError::Intervals {
            device: 1,
            mismatch: WindowMismatch {
                given: 19,
                expected: 20
            }
        }
    );
    let error = WorldEvaluation::new(&scene(), &ideal, &held[..1]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the record has forces of 1 devices, but the ideal has 2"
    );
    let mut held = means(&ideal);
    held[0][3] = [f64::NAN, 0.0, 0.0];
    let evaluation = WorldEvaluation::new(&scene(), &ideal, &held).unwrap();
    assert_eq!(evaluation.devices[0].peak_force, f64::INFINITY);
    assert_eq!(evaluation.sum.unwrap().mean_force_error, f64::INFINITY);
}
