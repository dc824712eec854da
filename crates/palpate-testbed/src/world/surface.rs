//! Nearest point of a shape, and the rate of its normal: one smooth formula for each feature.
//!
//! A face, an edge, a corner or a rim is a *feature*. Within one feature, distance and normal are smooth functions of
//! the position, and can be continued slightly beyond it. The integration keeps the feature of each contact over a step
//! and locates the instant at which another one becomes nearer, so no step crosses a kink.

use super::between::Between;
use super::cylinder::OnCylinder;
use super::hull::OfHull;
use super::mesh::OnMesh;
use super::scene::Shape;
use super::vector::Vec3;

/// The part of a shape's surface that is nearest to a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Feature {
    /// A sphere, half-space or corner of a box on a half-space: the only one there is.
    Whole,
    /// For a box: the sign of each coordinate that is outside the box, 0 inside. Within the box, the face of least
    /// depth.
    Signs([i8; 3]),
    /// For a capsule: 0 beside its segment, otherwise the end on that side.
    Segment(i8),
    /// The round side of a cylinder.
    Side,
    /// A flat end of a cylinder.
    Cap(i8),
    /// The edge between the round side and a flat end.
    Rim(i8),
    /// For two boxes or hulls: the plane between them.
    Between(Between),
    /// For a cylinder and a solid with flat faces: their contact state.
    OnCylinder(OnCylinder),
    /// For a hull: the part nearest to a point.
    OfHull(OfHull),
    /// Parts of a mesh.
    OnMesh(OnMesh),
}

impl Feature {
    /// Returns whether each contact of two solids keeps its point, and thus its bristle, in a change from `other`.
    pub fn has_points_of(self, other: Self) -> bool {
        match (self, other) {
            (Self::Between(at), Self::Between(other)) => at.has_points_of(other),
            (Self::OnCylinder(at), Self::OnCylinder(other)) => at.has_points_of(other),
            _ => false,
        }
    }

    /// Whether it is the other one but for a name.
    pub fn is_same(self, other: Self) -> bool {
        match (self, other) {
            (Self::OnCylinder(at), Self::OnCylinder(other)) => at.is_same(other),
            (at, other) => at == other,
        }
    }
}

/// Position of a surface relative to a point, in the body's axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Nearest {
    /// Distance of the point above the surface, negative inside `[m]`.
    pub distance: f64,
    /// Unit vector from the surface towards the outside.
    pub normal: Vec3,
    curvature: Curvature,
}

/// Rate of the normal with the point.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Curvature {
    Flat,
    /// About a point, at that distance `[m]`.
    Point(f64),
    /// About a line along a unit vector, at that distance `[m]`.
    Line(Vec3, f64),
    /// About a circle around the z axis, at that distance from it, with the outward unit vector and the
    /// distance from the axis `[m]`.
    Circle {
        distance: f64,
        outward: Vec3,
        from_axis: f64,
    },
}

const Z: Vec3 = Vec3([0.0, 0.0, 1.0]);

impl Nearest {
    /// Rate of the normal, in the body's axes, while the point moves with a velocity in them.
    pub fn normal_rate(&self, velocity: Vec3) -> Vec3 {
        let across = velocity.across(self.normal);
        let over = |v: Vec3, distance: f64| {
            if distance > 0.0 {
                v * (1.0 / distance)
            } else {
                Vec3::ZERO
            }
        };
        match self.curvature {
            Curvature::Flat => Vec3::ZERO,
            Curvature::Point(distance) => over(across, distance),
            Curvature::Line(along, distance) => over(across.across(along), distance),
            Curvature::Circle {
                distance,
                outward,
                from_axis,
            } => {
                let around = Z.cross(outward);
                let turning = around * (around.dot(velocity) * self.normal.dot(outward));
                over(across.across(around), distance) + over(turning, from_axis)
            }
        }
    }
}

/// Returns the nearest point on `feature` of `shape` to a `point` in the body's axes; not for a half-space.
pub(super) fn nearest(shape: &Shape, feature: Feature, point: Vec3) -> Nearest {
    match (shape, feature) {
        (&Shape::Box { half_extents }, Feature::Signs(signs)) => {
            let mut beyond = Vec3::ZERO;
            for i in 0..3 {
                if signs[i] != 0 {
                    beyond.0[i] = point.0[i] - f64::from(signs[i]) * half_extents[i];
                }
            }
            let signed = Vec3(signs.map(f64::from));
            match signs.iter().filter(|sign| **sign != 0).count() {
                1 => Nearest {
                    distance: beyond.dot(signed),
                    normal: signed,
                    curvature: Curvature::Flat,
                },
                2 => {
                    let along = Vec3(signs.map(|sign| if sign == 0 { 1.0 } else { 0.0 }));
                    round(beyond, 0.0, signed, |d| Curvature::Line(along, d))
                }
                _ => round(beyond, 0.0, signed, Curvature::Point),
            }
        }
        (
            &Shape::Capsule {
                radius,
                half_length,
            },
            Feature::Segment(end),
        ) => {
            if end == 0 {
                let from_axis = point.across(Z);
                let x = Vec3([1.0, 0.0, 0.0]);
                round(from_axis, radius, x, |d| Curvature::Line(Z, d))
            } else {
                let tip = Z * (f64::from(end) * half_length);
                round(point - tip, radius, Z, Curvature::Point)
            }
        }
        (
            &Shape::Cylinder {
                radius,
                half_length,
            },
            feature,
        ) => on_cylinder(radius, half_length, feature, point),
        (Shape::Hull(hull), Feature::OfHull(part)) => match part {
            OfHull::Face(number) => {
                let (normal, offset) = hull.plane(number);
                Nearest {
                    distance: normal.dot(point) - offset,
                    normal,
                    curvature: Curvature::Flat,
                }
            }
            OfHull::Edge(from, to) => {
                let [from, to] = [from, to].map(|number| hull.corner(number));
                let along = (to - from).direction().unwrap_or(Z);
                let off = (point - from).across(along);
                round(off, 0.0, from + to, |d| Curvature::Line(along, d))
            }
            OfHull::Corner(number) => {
                let corner = hull.corner(number);
                round(point - corner, 0.0, corner, Curvature::Point)
            }
        },
        (&Shape::Sphere { radius }, _) => round(point, radius, Z, Curvature::Point),
        _ => unreachable!("features of a shape are made by `feature`"),
    }
}

/// Returns the nearest point of a shape with a radius about a point, line or circle, at `from_core` from that core;
/// `fallback` is the normal on the core itself.
fn round(
    from_core: Vec3,
    radius: f64,
    fallback: Vec3,
    curvature: impl FnOnce(f64) -> Curvature,
) -> Nearest {
    let distance = from_core.norm();
    Nearest {
        distance: distance - radius,
        normal: from_core.direction().or(fallback.direction()).unwrap_or(Z),
        curvature: curvature(distance),
    }
}

fn on_cylinder(radius: f64, half_length: f64, feature: Feature, point: Vec3) -> Nearest {
    let x = Vec3([1.0, 0.0, 0.0]);
    let radial = point.across(Z);
    let outward = radial.direction().unwrap_or(x);
    match feature {
        Feature::Cap(end) => Nearest {
            distance: f64::from(end) * point.0[2] - half_length,
            normal: Z * f64::from(end),
            curvature: Curvature::Flat,
        },
        Feature::Rim(end) => {
            let on_rim = outward * radius + Z * (f64::from(end) * half_length);
            let fallback = outward + Z * f64::from(end);
            round(point - on_rim, 0.0, fallback, |distance| {
                Curvature::Circle {
                    distance,
                    outward,
                    from_axis: radial.norm(),
                }
            })
        }
        _ => round(radial, radius, x, |d| Curvature::Line(Z, d)),
    }
}

/// The feature of `shape` that is nearest to a `point` in the body's axes.
pub(super) fn feature(shape: &Shape, point: Vec3) -> Feature {
    match *shape {
        Shape::Sphere { .. } | Shape::HalfSpace { .. } => Feature::Whole,
        // The pushing parts of a mesh depend on the previous ones, so `System` queries the mesh itself.
        Shape::Mesh(_) => Feature::OnMesh(OnMesh::Nothing),
        Shape::Hull(ref hull) => Feature::OfHull(hull.nearest_part(point)),
        Shape::Box { half_extents } => {
            let sign = |value: f64| if value < 0.0 { -1 } else { 1 };
            let mut signs = [0_i8; 3];
            let mut shallowest = (f64::INFINITY, 0);
            for i in 0..3 {
                let depth = half_extents[i] - point.0[i].abs();
                if depth < 0.0 {
                    signs[i] = sign(point.0[i]);
                }
                if depth < shallowest.0 {
                    shallowest = (depth, i);
                }
            }
            if signs == [0; 3] {
                signs[shallowest.1] = sign(point.0[shallowest.1]);
            }
            Feature::Signs(signs)
        }
        Shape::Capsule { half_length, .. } => Feature::Segment(if point.0[2] > half_length {
            1
        } else if point.0[2] < -half_length {
            -1
        } else {
            0
        }),
        Shape::Cylinder {
            radius,
            half_length,
        } => {
            let end = if point.0[2] < 0.0 { -1 } else { 1 };
            let above_side = point.across(Z).norm() - radius;
            let above_cap = point.0[2].abs() - half_length;
            match (above_side > 0.0, above_cap > 0.0) {
                (true, true) => Feature::Rim(end),
                (true, false) => Feature::Side,
                (false, true) => Feature::Cap(end),
                (false, false) if above_side > above_cap => Feature::Side,
                (false, false) => Feature::Cap(end),
            }
        }
    }
}

/// Whether `current` is still the nearest feature of `shape` to a `point`, or another one is nearer by no
/// more than about `slack` `[m]`.
pub(super) fn holds(shape: &Shape, current: Feature, point: Vec3, slack: f64) -> bool {
    let found = feature(shape, point);
    if found == current || matches!(current, Feature::OnMesh(_)) {
        return true;
    }
    // Another feature takes over where the point, moved by the slack, is still in its region.
    [-slack, slack].iter().any(|&dx| {
        [-slack, slack].iter().any(|&dy| {
            [-slack, slack]
                .iter()
                .any(|&dz| feature(shape, point + Vec3([dx, dy, dz])) == current)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wedge: two of its faces lean.
    fn wedge() -> Shape {
        let corners = [
            [-0.35, -0.25, -0.2],
            [0.35, -0.25, -0.2],
            [0.35, 0.25, -0.2],
            [-0.35, 0.25, -0.2],
            [-0.2, 0.0, 0.3],
            [0.2, 0.0, 0.3],
        ];
        let hull = super::super::hull::Hull::around(&corners);
        Shape::Hull(std::sync::Arc::new(hull.unwrap()))
    }

    fn shapes() -> [Shape; 5] {
        [
            wedge(),
            Shape::Sphere { radius: 0.3 },
            Shape::Box {
                half_extents: [0.3, 0.2, 0.5],
            },
            Shape::Capsule {
                radius: 0.2,
                half_length: 0.3,
            },
            Shape::Cylinder {
                radius: 0.25,
                half_length: 0.3,
            },
        ]
    }

    /// Points about the shapes, inside and outside.
    fn points() -> impl Iterator<Item = Vec3> {
        let mut numbers = crate::random::SplitMix64::new(5);
        (0..3000).map(move |_| Vec3(std::array::from_fn(|_| 1.6 * numbers.unit() - 0.8)))
    }

    #[test]
    fn the_surface_is_where_the_distance_is_zero_and_the_normal_is_its_gradient() {
        for shape in shapes() {
            for point in points() {
                let feature = feature(&shape, point);
                let here = nearest(&shape, feature, point);
                assert!((here.normal.norm() - 1.0).abs() < 1e-12);
                let below = point - here.normal * here.distance;
                let on_surface = nearest(&shape, super::feature(&shape, below), below).distance;
                assert!(
                    on_surface.abs() < 1e-12,
                    "{shape:?} {point:?} {feature:?}: {on_surface}"
                );
                for axis in 0..3 {
                    let mut step = Vec3::ZERO;
                    step.0[axis] = 1e-6;
                    let slope = (nearest(&shape, feature, point + step).distance
                        - nearest(&shape, feature, point - step).distance)
                        / 2e-6;
                    assert!((slope - here.normal.0[axis]).abs() < 1e-6);
                }
            }
        }
    }

    #[test]
    fn the_normal_turns_as_its_rate_says() {
        let velocity = Vec3([0.3, -0.8, 0.5]);
        for shape in shapes() {
            for point in points() {
                let feature = feature(&shape, point);
                let here = nearest(&shape, feature, point);
                if here.distance.abs() < 0.02 && feature != Feature::Whole {
                    continue; // turns too fast near an edge for a difference
                }
                let step = 1e-7;
                let numeric = (nearest(&shape, feature, point + velocity * step).normal
                    - nearest(&shape, feature, point - velocity * step).normal)
                    * (0.5 / step);
                let rate = here.normal_rate(velocity);
                assert!(
                    (numeric - rate).norm() < 1e-4 * (1.0 + rate.norm().powi(3)),
                    "{shape:?} {point:?} {feature:?}: {numeric:?} {rate:?}"
                );
            }
        }
    }

    #[test]
    fn no_other_point_of_the_surface_is_nearer() {
        // The distance to a solid is the least over its points, so it changes by no more than the point moves,
        // outside and over all features alike.
        for shape in shapes() {
            let all: Vec<(Vec3, f64)> = points()
                .map(|point| {
                    (
                        point,
                        nearest(&shape, feature(&shape, point), point).distance,
                    )
                })
                .collect();
            for pair in all.windows(2) {
                let apart = (pair[0].0 - pair[1].0).norm();
                assert!((pair[0].1 - pair[1].1).abs() <= apart + 1e-12, "{shape:?}");
            }
        }
    }

    #[test]
    fn a_feature_holds_a_little_beyond_its_region() {
        let shape = shapes()[2].clone();
        let face = feature(&shape, Vec3([0.31, 0.0, 0.0]));
        assert_eq!(face, Feature::Signs([1, 0, 0]));
        assert!(holds(&shape, face, Vec3([0.31, 0.2 + 5e-10, 0.0]), 1e-9));
        assert!(!holds(&shape, face, Vec3([0.31, 0.2 + 5e-9, 0.0]), 1e-9));
        // Inside, the face of least depth.
        assert_eq!(
            feature(&shape, Vec3([0.1, 0.1, 0.45])),
            Feature::Signs([0, 0, 1])
        );
    }
}
