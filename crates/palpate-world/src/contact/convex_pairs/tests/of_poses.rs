//! Degenerate cylinder poses with an undefined direction or position: the result is arbitrary but valid.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

use super::of_cylinders::OnForm;
use super::*;
use crate::Shape;

/// Returns solids of about the size of a cylinder with this radius and half-length.
fn others(radius: f64, half_length: f64) -> Vec<Shape> {
    let hull = |sides: usize| {
        let corners: Vec<[f64; 3]> = (0..2 * sides)
            .map(|number| {
                let angle = std::f64::consts::TAU * (number % sides) as f64 / sides as f64;
                let side = if number < sides {
                    -half_length
                } else {
                    half_length
                };
                [radius * angle.cos(), radius * angle.sin(), side]
            })
            .collect();
        crate::Hull::around(&corners).map(|hull| Shape::Hull(Arc::new(hull)))
    };
    let cylinder = |radius, half_length| Shape::Cylinder {
        radius,
        half_length,
    };
    let mut others = vec![
        cylinder(radius, half_length),
        cylinder(0.5 * radius, half_length),
        cylinder(2.0 * half_length, 0.5 * radius),
        Shape::Box {
            half_extents: [radius, radius, half_length],
        },
        Shape::Box {
            half_extents: [half_length, 2.0 * radius, radius],
        },
    ];
    others.extend([hull(5), hull(32)].into_iter().flatten());
    others
}

/// Returns rotations, some of them so small that their square is lost to rounding.
fn turns() -> Vec<Rotation> {
    let about = |axis: Vector3| Rotation::from_scaled_axis(axis);
    let little = |x: f64| Rotation::new_unchecked(nalgebra::Quaternion::new(1.0, x, 0.0, 0.0));
    vec![
        Rotation::identity(),
        little(1e-300),
        little(1e-162),
        little(1e-161),
        little(1e-160),
        little(1e-20),
        little(1e-17),
        about(Vector3::new(1e-12, -1e-13, 0.0)),
        about(Vector3::new(1e-8, 2e-8, 0.0)),
        about(Vector3::x() * FRAC_PI_2),
        about(Vector3::y() * FRAC_PI_2),
        about(Vector3::new(1.0, 1.0, 0.0) * (FRAC_PI_2 * FRAC_1_SQRT_2)),
        about(Vector3::x() * (2.0 * FRAC_PI_2)),
        about(Vector3::z() * 0.3),
        about(Vector3::x() * (0.5 * FRAC_PI_2)),
    ]
}

#[test]
fn cylinders_take_a_sound_plane_where_none_is_determined() {
    let sizes = [
        (0.02, 0.03),
        (0.02, 0.02),
        (0.03, 1e-4),
        (1e-4, 0.03),
        (1e-6, 1e-6),
        (10.0, 10.0),
        (10.0, 1e-6),
        (1e-6, 10.0),
    ];
    let mut seen = 0;
    for (radius, half_length) in sizes {
        let own = Shape::Cylinder {
            radius,
            half_length,
        };
        let each = others(radius, half_length).into_iter();
        let each = each.flat_map(|other| [[own.clone(), other.clone()], [other, own.clone()]]);
        for shapes in each {
            let Some(pair) = OnForm::between([&shapes[0], &shapes[1]]) else {
                panic!("{shapes:?}");
            };
            let size = pair
                .0
                .reaches()
                .iter()
                .fold(0.0_f64, |most, &x| most.max(x));
            let ways = [
                Vector3::zeros(),
                Vector3::z() * half_length,
                Vector3::z() * (2.0 * half_length),
                Vector3::x() * radius,
                Vector3::x() * (2.0 * radius),
                Vector3::x() * (radius + half_length),
                Vector3::z() * (radius + half_length),
                Vector3::new(radius, 0.0, half_length),
                Vector3::x() * (1e-300 * radius),
            ];
            for turn in turns() {
                for way in ways {
                    let at = |rotation: Rotation, position: Vector3| Rigid {
                        orientation: rotation,
                        ..rigid(position, Vector3::zeros())
                    };
                    let first = at(Rotation::identity(), Vector3::zeros());
                    let check = |second: &Rigid| {
                        let here = pair.placed(&first, second);
                        let (plane, depth) = here.least(None);
                        let what = format!("{shapes:?} {turn:?} {way:?} {plane:?} {depth}");
                        assert!(depth.is_finite() && depth.abs() < 4.0 * size, "{what}");
                        let normal = here.normal(plane);
                        assert!((normal.norm() - 1.0).abs() < 1e-12, "{what} {normal:?}");
                        let mut points = vec![Found::none(); pair.points()];
                        here.points(plane, &mut points);
                        let mut squares = 0.0;
                        for found in &points {
                            let p = found.penetration.max(0.0);
                            squares += p * p / pair.share() as f64;
                            if p > 0.0 {
                                let lever = found.place.norm() - way.norm();
                                assert!(lever < 1.001 * size + p, "{what} {found:?}");
                            }
                        }
                        let off = (squares.sqrt() - depth.max(0.0)).abs();
                        assert!(off < 1e-12 * size, "{what} {}", squares.sqrt());
                        depth
                    };
                    let depth = check(&at(turn, way));
                    seen += u32::from(depth > 0.0);
                    // No jump near the degenerate pose.
                    for by in [1e-9, -1e-9] {
                        let near =
                            Vector3::new(0.3, -0.2, 0.5) * (by * size.min(radius.min(half_length)));
                        let moved = check(&at(turn, way + near));
                        let off = (moved.max(0.0) - depth.max(0.0)).abs();
                        assert!(
                            off < 4.0 * near.norm() + 1e-14 * size,
                            "{shapes:?} {turn:?} {way:?} {depth} {moved}"
                        );
                    }
                }
            }
        }
    }
    assert!(seen > 1000, "{seen}");
}
