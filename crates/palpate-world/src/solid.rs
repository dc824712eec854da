//! The nearest point of a shape's surface.

use crate::Shape;
use crate::rigid::{Rigid, Vector3};

/// A shape that another one's centre or corner is measured against.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Solid {
    Ball {
        radius: f64,
    },
    /// In the body's own axes.
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
}

/// The nearest point of a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearest {
    /// Distance from it, below 0 inside `[m]`.
    pub distance: f64,
    /// Unit vector out of the solid there.
    pub normal: Vector3,
}

/// Distances below this have no direction `[m]`.
const NO_DIRECTION: f64 = 1e-12;

impl From<&Shape> for Solid {
    fn from(shape: &Shape) -> Self {
        match *shape {
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
        }
    }
}

impl Solid {
    /// Of the solid's surface, with the solid as `placed`, the point nearest to `point` `[m]`; of a point inside,
    /// that of least depth.
    pub fn nearest(&self, placed: &Rigid, point: &Vector3) -> Nearest {
        let off = point - placed.position;
        if let Self::Ball { radius } = *self {
            return from_core(off, radius);
        }
        let own = placed.orientation.inverse_transform_vector(&off);
        let nearest = match *self {
            Self::Ball { radius } => from_core(own, radius),
            Self::HalfSpace { normal, offset } => Nearest {
                distance: normal.dot(&own) - offset,
                normal,
            },
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
        };
        Nearest {
            normal: placed.orientation * nearest.normal,
            ..nearest
        }
    }

    /// Largest distance of the surface from the centre of mass `[m]`, infinite for a half-space.
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
        }
    }
}

/// From a core, by `off`, of a surface at `radius` around it.
fn from_core(off: Vector3, radius: f64) -> Nearest {
    let length = off.norm();
    Nearest {
        distance: length - radius,
        normal: if length > NO_DIRECTION {
            off / length
        } else {
            // Every direction is as good.
            Vector3::x()
        },
    }
}

fn from_block(own: Vector3, half: Vector3) -> Nearest {
    let beyond = own.abs() - half;
    let out = own - Vector3::from_fn(|i, _| own[i].clamp(-half[i], half[i]));
    let length = out.norm();
    if length > NO_DIRECTION {
        return Nearest {
            distance: length,
            normal: out / length,
        };
    }
    let axis = beyond.imax();
    let mut normal = Vector3::zeros();
    normal[axis] = 1.0_f64.copysign(own[axis]);
    Nearest {
        distance: beyond[axis],
        normal,
    }
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
        return Nearest {
            distance,
            normal: (side * beyond_side + end * beyond_end) / distance,
        };
    }
    let (distance, normal) = if beyond_side >= beyond_end {
        (beyond_side, side)
    } else {
        (beyond_end, end)
    };
    Nearest { distance, normal }
}
