//! The five-bar's geometry against published numbers and against differences of itself.

use palpate_testbed::pantograph::kinematics::{Assembly, ELBOWS_OUT, NoPose, Origin};
use palpate_testbed::pantograph::{Geometry, Pantograph, PantographParameter};

fn deg(angles: [f64; 2]) -> [f64; 2] {
    angles.map(f64::to_radians)
}

fn gen3() -> Geometry {
    crate::pantographs::haply(3).geometry
}

fn close(a: [f64; 2], b: [f64; 2], tolerance: f64) -> bool {
    (0..2).all(|i| (a[i] - b[i]).abs() <= tolerance)
}

#[test]
fn the_end_point_is_where_the_published_poses_say() {
    let (one, two, three) = (
        crate::pantographs::haply(1),
        crate::pantographs::haply(2),
        crate::pantographs::haply(3),
    );
    for (geometry, angles, expected) in [
        (three.geometry, three.home, [0.01900, 0.03574]),
        (three.geometry, deg([130.0, 50.0]), [0.01900, 0.11691]),
        (three.geometry, deg([97.3, 82.7]), [0.01900, 0.15500]),
        (two.geometry, two.home, [0.0, 0.02213]),
        (one.geometry, one.home, [0.010, 0.03606]),
    ] {
        let found = geometry.forward(angles).unwrap().position;
        assert!(close(found, expected, 5.1e-6), "{found:?} {expected:?}");
    }
}

#[test]
fn the_links_have_their_lengths_in_both_assemblies() {
    for assembly in [Assembly::Far, Assembly::Near] {
        let geometry = Geometry { assembly, ..gen3() };
        let angles = deg([110.0, 35.0]);
        let pose = geometry.forward(angles).unwrap();
        for (i, motor) in [0.0, geometry.base].into_iter().enumerate() {
            let elbow = [
                motor + geometry.proximal * angles[i].cos(),
                geometry.proximal * angles[i].sin(),
            ];
            let link = [pose.position[0] - elbow[0], pose.position[1] - elbow[1]];
            assert!((link[0].hypot(link[1]) - geometry.distal).abs() < 1e-15);
            assert!((link[1].atan2(link[0]) - pose.distal_angles()[i]).abs() < 1e-12);
        }
        let away = pose.position[1] > 0.05;
        assert_eq!(away, assembly == Assembly::Far);
    }
}

#[test]
fn the_centred_origin_moves_x_by_half_the_base() {
    let centred = Geometry {
        origin: Origin::Centre,
        ..gen3()
    };
    let angles = deg([130.0, 50.0]);
    let (a, b) = (
        gen3().forward(angles).unwrap(),
        centred.forward(angles).unwrap(),
    );
    assert!(close(b.position, [0.0, a.position[1]], 1e-16));
    assert!(close(
        centred.inverse(b.position, ELBOWS_OUT).unwrap(),
        angles,
        1e-14
    ));
}

/// Jᵀ by central differences of order 4.
fn differences(geometry: &Geometry, angles: [f64; 2]) -> Option<[[f64; 2]; 2]> {
    let step = 1e-4;
    let mut rows = [[0.0; 2]; 2];
    for (motor, row) in rows.iter_mut().enumerate() {
        let at = |offset: f64| {
            let mut moved = angles;
            moved[motor] += offset;
            geometry.forward(moved).ok().map(|pose| pose.position)
        };
        let (p2, p1, m1, m2) = (at(2.0 * step)?, at(step)?, at(-step)?, at(-2.0 * step)?);
        for (k, value) in row.iter_mut().enumerate() {
            *value = (8.0 * (p1[k] - m1[k]) - (p2[k] - m2[k])) / (12.0 * step);
        }
    }
    Some(rows)
}

#[test]
fn the_jacobian_is_the_derivative_in_every_pose_and_assembly() {
    let mut compared = 0;
    for params in [
        crate::pantographs::haply(1),
        crate::pantographs::haply(2),
        crate::pantographs::haply(3),
        crate::pantographs::desktop(),
    ] {
        for assembly in [Assembly::Far, Assembly::Near] {
            let geometry = Geometry {
                assembly,
                ..params.geometry
            };
            for first in (-180..180).step_by(15) {
                for second in (-173..187).step_by(15) {
                    let angles = deg([f64::from(first), f64::from(second)]);
                    let Ok(pose) = geometry.forward(angles) else {
                        continue;
                    };
                    let Some(rows) = differences(&geometry, angles) else {
                        continue;
                    };
                    // Close to a singular pose differences lose their digits.
                    if pose.sine.abs() < 0.1 {
                        continue;
                    }
                    let j = pose.jacobian();
                    for motor in 0..2 {
                        let column = [j[0][motor], j[1][motor]];
                        assert!(
                            close(column, rows[motor], 1e-9),
                            "{first} {second} {column:?} {:?}",
                            rows[motor]
                        );
                    }
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 3000, "{compared}");
}

#[test]
fn the_jacobian_has_the_published_rows_and_the_true_ones_where_those_are_wrong() {
    let row = |angles: [f64; 2], motor: usize| {
        let j = gen3().forward(deg(angles)).unwrap().jacobian();
        [j[0][motor], j[1][motor]]
    };
    assert!(close(row([130.0, 50.0], 0), [-0.04906, -0.04961], 5.1e-6));
    assert!(close(row([130.0, 50.0], 1), [-0.04906, 0.04961], 5.1e-6));
    // The acos form gives [-0.0034, 0.0615] here.
    assert!(close(row([90.0, -20.0], 1), [0.0035, 0.0626], 5.1e-5));
}

#[test]
fn the_distal_links_turn_as_their_rates_say() {
    let geometry = gen3();
    for angles in [[130.0, 50.0], [90.0, -20.0], [200.0, 110.0]].map(deg) {
        let rates = geometry.forward(angles).unwrap().distal_rates();
        for motor in 0..2 {
            let at = |offset: f64| {
                let mut moved = angles;
                moved[motor] += offset;
                geometry.forward(moved).unwrap().distal_angles()
            };
            let (plus, minus) = (at(1e-5), at(-1e-5));
            for link in 0..2 {
                let slope = (plus[link] - minus[link]) / 2e-5;
                assert!((slope - rates[link][motor]).abs() < 1e-7);
            }
        }
    }
}

#[test]
fn the_inverse_undoes_the_forward_kinematics_with_every_pair_of_elbows() {
    let mut seen = [[0; 2]; 2];
    for assembly in [Assembly::Far, Assembly::Near] {
        let geometry = Geometry { assembly, ..gen3() };
        for first in (-175..180).step_by(10) {
            for second in (-171..180).step_by(10) {
                let angles = deg([f64::from(first), f64::from(second)]);
                let Ok(pose) = geometry.forward(angles) else {
                    continue;
                };
                let elbows = pose.elbows();
                let back = geometry.inverse(pose.position, elbows);
                // On a motor's axis the inverse has no single answer.
                if let Ok(back) = back {
                    assert!(close(back, angles, 1e-7), "{first} {second} {back:?}");
                    let side = |i: usize| usize::from(elbows[i] == ELBOWS_OUT[i]);
                    seen[side(0)][side(1)] += 1;
                } else {
                    panic!("{first} {second} {back:?}");
                }
            }
        }
    }
    assert!(seen.iter().flatten().all(|&n| n > 50), "{seen:?}");
}

#[test]
fn the_four_pairs_of_elbows_split_over_the_two_assemblies() {
    let far = gen3();
    let near = Geometry {
        assembly: Assembly::Near,
        ..far
    };
    let position = [0.03, 0.11];
    let mut reached = 0;
    for (a, b) in far
        .inverse_all(position)
        .into_iter()
        .zip(near.inverse_all(position))
    {
        let (geometry, angles) = match (a, b) {
            (Ok(angles), Err(NoPose::OtherAssembly)) => (far, angles),
            (Err(NoPose::OtherAssembly), Ok(angles)) => (near, angles),
            other => panic!("{other:?}"),
        };
        assert!(close(
            geometry.forward(angles).unwrap().position,
            position,
            1e-15
        ));
        reached += 1;
    }
    assert_eq!(reached, 4);
}

#[test]
fn a_pose_that_does_not_exist_says_why() {
    let short = Geometry::new(0.07, 0.06, 0.038).unwrap();
    assert_eq!(short.forward(deg([180.0, 0.0])), Err(NoPose::Unreachable));
    assert_eq!(short.forward([f64::NAN, 0.0]), Err(NoPose::Unreachable));
    // A = B with both motors on one axis.
    let gen2 = crate::pantographs::haply(2).geometry;
    assert_eq!(gen2.forward([1.0, 1.0]), Err(NoPose::Singular));
    // |h| = 2L: stretched to a straight line.
    let stretched = Geometry::new(0.0625, 0.078_125, 0.031_25).unwrap();
    assert_eq!(stretched.forward(deg([180.0, 0.0])), Err(NoPose::Singular));
    assert_eq!(
        gen3().inverse([0.0, 0.2], ELBOWS_OUT),
        Err(NoPose::Unreachable)
    );
    assert_eq!(
        gen3().inverse([0.0, 0.0], ELBOWS_OUT),
        Err(NoPose::Singular)
    );
    assert_eq!(
        Geometry::new(0.07, -1.0, 0.0).unwrap_err().name,
        PantographParameter::Distal
    );
}

#[test]
fn one_count_of_an_encoder_moves_the_end_point_by_its_quantum() {
    for (params, degrees) in [
        (crate::pantographs::haply(3), 0.147_54),
        (crate::pantographs::haply(2), 0.033_48),
        (crate::pantographs::haply(1), 0.026_04),
    ] {
        let quantum = 360.0 / params.counts_per_rev.unwrap();
        assert!((quantum - degrees).abs() < 5.1e-6);
    }
    // One count of one encoder at the middle of generation 3: 0.126 mm along x, 0.128 mm along y.
    let angles = deg([130.0, 50.0]);
    let j = gen3().forward(angles).unwrap().jacobian();
    let quantum = std::f64::consts::TAU / crate::pantographs::haply(3).counts_per_rev.unwrap();
    let along_x = quantum * (j[0][0].abs() + j[0][1].abs()) / 2.0;
    let along_y = quantum * (j[1][0].abs() + j[1][1].abs()) / 2.0;
    assert!((along_x - 1.263e-4).abs() < 1e-6, "{along_x}");
    assert!((along_y - 1.277e-4).abs() < 1e-6, "{along_y}");
}

#[test]
fn the_encoders_report_the_boards_first_angles() {
    for (params, expected) in [
        (crate::pantographs::haply(3), [167.9016, 11.9508]),
        (crate::pantographs::haply(2), [240.9710, f64::NAN]),
    ] {
        let device = Pantograph::new(params).unwrap();
        let measured = device.measured_pose().unwrap().angles.map(f64::to_degrees);
        for i in 0..2 {
            assert!(expected[i].is_nan() || (measured[i] - expected[i]).abs() < 5.1e-5);
        }
    }
}

#[test]
fn the_torque_limit_gives_the_published_forces() {
    let limit = crate::pantographs::haply(3).max_torque;
    for (angles, expected) in [
        ([168.0, 12.0], [7.9, 1.9]),
        ([130.0, 50.0], [2.5, 2.5]),
        ([97.3, 82.7], [2.5, 7.8]),
    ] {
        let pose = gen3().forward(deg(angles)).unwrap();
        let largest = |force: [f64; 2]| {
            limit
                / pose
                    .torques(force)
                    .map(f64::abs)
                    .into_iter()
                    .fold(0.0, f64::max)
        };
        let found = [largest([1.0, 0.0]), largest([0.0, 1.0])];
        assert!(close(found, expected, 0.051), "{angles:?} {found:?}");
    }
}
