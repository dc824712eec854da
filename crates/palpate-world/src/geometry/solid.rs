//! Nearest points on the surfaces of shapes.

use std::sync::Arc;

use crate::geometry::hull::Corners;
use crate::geometry::rigid::{Rigid, Vector3};
use crate::{DistanceGrid, Shape};

/// A shape for distance queries from a sphere's centre or a corner.
#[derive(Clone, Debug)]
pub(crate) enum Solid {
    Ball {
        radius: f64,
    },
    /// In the body's axes.
    HalfSpace {
        normal: Vector3,
        offset: f64,
    },
    Block {
        half: Vector3,
    },
    Capsule {
        radius: f64,
        half_length: f64,
    },
    Cylinder {
        radius: f64,
        half_length: f64,
    },
    /// Result at one of the contact points of a sphere with a mesh, by their indices in the world. The mesh itself is
    /// evaluated once for all of them.
    Mesh {
        surface: usize,
        point: usize,
        reach: f64,
    },
    /// A mesh with a distance grid.
    Grid {
        grid: Arc<DistanceGrid>,
        reach: f64,
    },
    /// A convex solid with flat faces.
    Hull {
        corners: Arc<Corners>,
        reach: f64,
    },
    /// Result at one of the contact points of two boxes, by the index of the pair in the world. The second box has
    /// this half-diagonal `[m]`.
    Between {
        blocks: usize,
        point: usize,
        reach: f64,
    },
}

/// Nearest point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Nearest {
    /// Signed distance, negative inside `[m]`.
    pub distance: f64,
    /// Outward unit normal there.
    pub normal: Vector3,
    /// Derivative of the distance along the normal: 1, except where a [`DistanceGrid`] rounds a kink.
    pub slope: f64,
}

impl Nearest {
    /// Returns a result without a surface nearby.
    pub fn far() -> Self {
        Self::exact(f64::INFINITY, Vector3::x())
    }

    /// Creates the result for a surface with exact distances.
    pub fn exact(distance: f64, normal: Vector3) -> Self {
        Self {
            distance,
            normal,
            slope: 1.0,
        }
    }
}

/// Distance below which the direction is undefined `[m]`.
pub(crate) const NO_DIRECTION: f64 = 1e-12;

impl Solid {
    /// Returns the solid of a shape; `None` for several spheres, a hull, and a mesh without a distance grid.
    pub fn new(shape: &Shape) -> Option<Self> {
        Some(match *shape {
            // Contacts of spheres with a mesh are evaluated per pair.
            Shape::Spheres { .. } | Shape::Hull(_) => return None,
            Shape::Mesh(ref mesh) => Self::Grid {
                grid: mesh.grid()?.clone(),
                reach: mesh.reach(),
            },
            Shape::Sphere { radius } => Self::Ball { radius },
            Shape::HalfSpace { normal, offset } => Self::HalfSpace {
                normal: Vector3::from(normal).normalize(),
                offset,
            },
            Shape::Box { half_extents } => Self::Block {
                half: half_extents.into(),
            },
            Shape::Capsule {
                radius,
                half_length,
            } => Self::Capsule {
                radius,
                half_length,
            },
            Shape::Cylinder {
                radius,
                half_length,
            } => Self::Cylinder {
                radius,
                half_length,
            },
        })
    }
}

impl Solid {
    /// Returns the solid of a shape for contacts with shell points.
    pub fn under_points(shape: &Shape) -> Option<Self> {
        match shape {
            Shape::Hull(hull) => Some(Self::Hull {
                corners: hull.by_corners().clone(),
                reach: hull.by_corners().reach(),
            }),
            other => Self::new(other),
        }
    }

    /// Returns the surface point nearest to `point` `[m]`, with the solid as `placed`. For an interior point it is
    /// the point of least depth.
    #[inline]
    pub fn nearest(&self, placed: &Rigid, point: &Vector3) -> Nearest {
        let off = point - placed.position;
        match *self {
            Self::Ball { radius } => from_core(off, radius),
            Self::HalfSpace { normal, offset } if placed.is_upright() => {
                Nearest::exact(normal.dot(&off) - offset, normal)
            }
            _ => self.nearest_turned(placed, off),
        }
    }

    /// Returns the nearest point for an offset `off` from the centre of the solid `[m]`.
    fn nearest_turned(&self, placed: &Rigid, off: Vector3) -> Nearest {
        let own = placed.orientation.inverse_transform_vector(&off);
        let nearest = match *self {
            Self::Ball { radius } => from_core(own, radius),
            Self::HalfSpace { normal, offset } => Nearest::exact(normal.dot(&own) - offset, normal),
            Self::Grid { ref grid, .. } => grid.nearest(&own),
            Self::Hull { ref corners, .. } => corners.nearest(&own),
            Self::Block { half } => from_block(own, half),
            Self::Capsule {
                radius,
                half_length,
            } => {
                let along = own.z.clamp(-half_length, half_length);
                from_core(own - Vector3::new(0.0, 0.0, along), radius)
            }
            Self::Cylinder {
                radius,
                half_length,
            } => from_cylinder(own, radius, half_length),
            Self::Mesh { .. } | Self::Between { .. } => Nearest::far(),
        };
        Nearest {
            normal: placed.orientation * nearest.normal,
            ..nearest
        }
    }

    /// Returns the nearest point, or a lower bound of the distance if the surface is certainly beyond `reach` `[m]`,
    /// which may be cheaper.
    #[inline]
    pub fn nearest_within(&self, placed: &Rigid, point: &Vector3, reach: f64) -> Nearest {
        let Self::Grid { grid, .. } = self else {
            return self.nearest(placed, point);
        };
        let off = point - placed.position;
        let own = placed.orientation.inverse_transform_vector(&off);
        let nearest = grid.nearest_within(&own, reach);
        Nearest {
            normal: placed.orientation * nearest.normal,
            ..nearest
        }
    }

    /// Returns the largest distance of the surface from the centre of mass `[m]`; infinite for a half-space.
    pub fn reach(&self) -> f64 {
        match *self {
            Self::Ball { radius } => radius,
            Self::HalfSpace { .. } => f64::INFINITY,
            Self::Block { half } => half.norm(),
            Self::Capsule {
                radius,
                half_length,
            } => radius + half_length,
            Self::Cylinder {
                radius,
                half_length,
            } => radius.hypot(half_length),
            Self::Mesh { reach, .. }
            | Self::Grid { reach, .. }
            | Self::Hull { reach, .. }
            | Self::Between { reach, .. } => reach,
        }
    }
}

/// Returns the nearest point for an offset `off` from the core of a surface at `radius` around it.
#[inline]
fn from_core(off: Vector3, radius: f64) -> Nearest {
    let length = off.norm();
    let normal = if length > NO_DIRECTION {
        off / length
    } else {
        // The direction is arbitrary.
        Vector3::x()
    };
    Nearest::exact(length - radius, normal)
}

fn from_block(own: Vector3, half: Vector3) -> Nearest {
    let beyond = own.abs() - half;
    let out = own - Vector3::from_fn(|i, _| own[i].clamp(-half[i], half[i]));
    let length = out.norm();
    if length > NO_DIRECTION {
        return Nearest::exact(length, out / length);
    }
    let axis = beyond.imax();
    let mut normal = Vector3::zeros();
    normal[axis] = 1.0_f64.copysign(own[axis]);
    Nearest::exact(beyond[axis], normal)
}

fn from_cylinder(own: Vector3, radius: f64, half_length: f64) -> Nearest {
    let across = own.xy();
    let from_axis = across.norm();
    let outward = if from_axis > NO_DIRECTION {
        across / from_axis
    } else {
        nalgebra::Vector2::x()
    };
    let (beyond_side, beyond_end) = (from_axis - radius, own.z.abs() - half_length);
    let side = Vector3::new(outward.x, outward.y, 0.0);
    let end = Vector3::new(0.0, 0.0, 1.0_f64.copysign(own.z));
    if beyond_side > 0.0 && beyond_end > 0.0 {
        let distance = beyond_side.hypot(beyond_end);
        return Nearest::exact(distance, (side * beyond_side + end * beyond_end) / distance);
    }
    let (distance, normal) = if beyond_side >= beyond_end {
        (beyond_side, side)
    } else {
        (beyond_end, end)
    };
    Nearest::exact(distance, normal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::rigid::Rotation;

    /// Returns an upright wedge.
    fn wedge() -> Solid {
        let corners = [
            [-1.0, -0.4, -WEDGE],
            [1.0, -0.4, -WEDGE],
            [1.0, 0.4, -WEDGE],
            [-1.0, 0.4, -WEDGE],
            [-0.6, 0.0, 0.8 - WEDGE],
            [0.6, 0.0, 0.8 - WEDGE],
        ];
        let hull = crate::Hull::around(&corners).unwrap();
        Solid::under_points(&Shape::Hull(Arc::new(hull))).unwrap()
    }

    fn solids() -> Vec<(Solid, f64)> {
        vec![
            (wedge(), WEDGE),
            (Solid::Ball { radius: 0.7 }, 0.7),
            (
                Solid::Block {
                    half: Vector3::new(0.5, 0.3, 0.8),
                },
                0.3,
            ),
            (
                Solid::Capsule {
                    radius: 0.4,
                    half_length: 0.5,
                },
                0.4,
            ),
            (
                Solid::Cylinder {
                    radius: 0.4,
                    half_length: 0.6,
                },
                0.4,
            ),
        ]
    }

    /// The largest depth in the wedge, equidistant from its bottom and its two long sides: 0.8 c/(1 + c), where c is
    /// the sine of the angle of 0.4 on 0.8.
    const WEDGE: f64 = 0.247_213_595_499_957_9;

    fn placed() -> Rigid {
        Rigid {
            position: Vector3::new(0.2, -0.4, 0.1),
            orientation: Rotation::from_scaled_axis(Vector3::new(0.4, -1.1, 0.7)),
            velocity: Vector3::zeros(),
            spin: Vector3::zeros(),
        }
    }

    /// Returns points all around: near and far, inside and outside.
    fn around() -> impl Iterator<Item = Vector3> {
        (0..2000).map(|number| {
            let part = |prime: f64| 3.0 * ((f64::from(number) * prime).fract() - 0.5);
            Vector3::new(part(0.754_877), part(0.569_840), part(0.430_160))
        })
    }

    /// The distance changes by the length of a displacement along the normal, and by less in any other direction.
    #[test]
    fn the_normal_is_the_gradient_of_the_distance() {
        for (solid, _) in solids() {
            let placed = placed();
            let h = 1e-6;
            for point in around() {
                let nearest = solid.nearest(&placed, &point);
                assert!((nearest.normal.norm() - 1.0).abs() < 1e-12);
                let gradient = Vector3::from_fn(|axis, _| {
                    let step = Vector3::ith(axis, h);
                    let [far, near] =
                        [point + step, point - step].map(|x| solid.nearest(&placed, &x).distance);
                    (far - near) / (2.0 * h)
                });
                let off = (gradient - nearest.normal).norm();
                // The gradient is undefined if two surface positions are equally near.
                let inside = nearest.distance < 0.0;
                assert!(
                    off < 1e-5 || inside && (gradient.norm() - 1.0).abs() > 1e-3,
                    "{solid:?} {point:?} {off}"
                );
            }
        }
    }

    /// From any point, a displacement along the normal by the distance ends on the surface.
    #[test]
    fn the_nearest_point_lies_on_the_surface() {
        for (solid, depth) in solids() {
            let placed = placed();
            let (mut inside, mut deepest) = (0, 0.0_f64);
            for point in around() {
                let nearest = solid.nearest(&placed, &point);
                let surface = point - nearest.normal * nearest.distance;
                let on_it = solid.nearest(&placed, &surface).distance;
                assert!(on_it.abs() < 1e-9, "{solid:?} {point:?} {on_it}");
                inside += usize::from(nearest.distance < 0.0);
                deepest = deepest.max(-nearest.distance);
            }
            assert!(inside > 20, "{solid:?} {inside}");
            assert!(deepest <= depth + 1e-12, "{solid:?} {deepest}");
        }
    }

    #[test]
    fn a_point_without_a_nearest_one_has_a_normal_all_the_same() {
        for (solid, depth) in solids() {
            let placed = placed();
            let nearest = solid.nearest(&placed, &placed.position);
            assert!((nearest.normal.norm() - 1.0).abs() < 1e-12);
            assert!((nearest.distance + depth).abs() < 1e-12);
        }
    }
}
