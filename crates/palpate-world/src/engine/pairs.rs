//! Pairs of a tool and a shape of an engine's body that may touch.

use std::sync::Arc;

use nalgebra::{Quaternion, UnitQuaternion};

use super::body::EngineBody;
use crate::contact::law::PointLaw;
use crate::geometry::rigid::{Rigid, Rotation, Vector3};
use crate::geometry::solid::{Nearest, Solid};
use crate::{Mesh, Shape, Tool, WorldError, WorldField, WorldPart};

/// Maximum number of pairs of a tool and a shape of an engine's body.
pub(super) const MAX_PAIRS: usize = 64;

/// A convex surface that a sphere touches at one point.
#[derive(Clone, Debug)]
pub(super) enum Outline {
    Solid(Solid),
    Convex(Arc<Mesh>),
    /// A surface patch through the origin of its own axes, with normal z and this curvature `[1/m]`, positive if
    /// convex.
    Bent(f64),
}

impl Outline {
    /// Returns the outline of a shape, or a message if the shape has none.
    fn new(shape: &Shape) -> Result<Self, String> {
        match shape {
            Shape::Hull(hull) => Ok(Self::Convex(hull.mesh().clone())),
            Shape::Mesh(mesh) if mesh.is_convex() => Ok(Self::Convex(mesh.clone())),
            Shape::Mesh(_) => Err(format!(
                "a mesh of an engine's body has to be closed and convex, of at most {} triangles: give its hull or \
                 several convex parts",
                Mesh::MAX_OF_CONVEX
            )),
            other => Solid::new(other).map(Self::Solid).ok_or_else(|| {
                "an engine's body has no shape of several spheres; give each sphere as a shape"
                    .to_string()
            }),
        }
    }

    /// Returns the surface point nearest to `point` `[m]`, with the solid as `placed`. For an interior point it is
    /// the point of least depth.
    pub fn nearest(&self, placed: &Rigid, point: &Vector3) -> Nearest {
        match self {
            Self::Solid(solid) => solid.nearest(placed, point),
            Self::Bent(curvature) => {
                let turn = &placed.orientation;
                let own = turn.inverse_transform_vector(&(point - placed.position));
                let nearest = bent(*curvature, &own);
                Nearest {
                    normal: turn * nearest.normal,
                    ..nearest
                }
            }
            Self::Convex(mesh) => {
                let own = placed
                    .orientation
                    .inverse_transform_vector(&(point - placed.position));
                let nearest = mesh.nearest_of_convex(&own);
                Nearest {
                    normal: placed.orientation * nearest.normal,
                    ..nearest
                }
            }
        }
    }
}

/// Returns the nearest point of a curved surface patch, in its own axes.
fn bent(curvature: f64, point: &Vector3) -> Nearest {
    let flat = Nearest {
        distance: point.z,
        normal: Vector3::z(),
        slope: 1.0,
    };
    if curvature.abs() < MIN_CURVATURE {
        return flat;
    }
    let radius = 1.0 / curvature;
    let from_centre = point + Vector3::z() * radius;
    let length = from_centre.norm();
    if length <= f64::MIN_POSITIVE {
        return Nearest {
            distance: -radius,
            ..flat
        };
    }
    Nearest {
        distance: length * curvature.signum() - radius,
        normal: from_centre * (curvature.signum() / length),
        ..flat
    }
}

/// Curvature below which a surface is treated as a plane `[1/m]`. The error over 0.1 m is 50 nm; a radius of 100 km
/// would have a rounding error of 0.01 nm.
const MIN_CURVATURE: f64 = 1e-5;

/// The sphere that touches a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Toucher {
    /// The tool of this index.
    Tool(usize),
    /// A sphere of the body of this index, with its centre in the body's axes `[m]`.
    Body { body: usize, centre: Vector3 },
}

impl Toucher {
    /// Returns the index of the tool, if the sphere is a tool.
    pub fn tool(self) -> Option<usize> {
        match self {
            Self::Tool(tool) => Some(tool),
            Self::Body { .. } => None,
        }
    }

    pub fn is_tool(self, tool: usize) -> bool {
        self.tool() == Some(tool)
    }
}

/// Temporary correction of a contact's geometry that keeps its force continuous.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shift {
    /// Added to the penetration `[m]`.
    pub depth: f64,
    /// Added to the normal.
    pub normal: Vector3,
    /// Added to the penetration rate `[m/s]`.
    pub rate: f64,
}

/// A sphere and a shape that it may touch.
#[derive(Clone, Debug)]
pub(super) struct Pair {
    pub toucher: Toucher,
    /// Whether the pair can touch.
    pub is_open: bool,
    pub body: usize,
    /// Radius of the sphere `[m]`.
    pub radius: f64,
    pub outline: Outline,
    /// Position of the shape in the body's axes.
    pub position: Vector3,
    pub orientation: Rotation,
    pub law: PointLaw,
    /// Final value of the fading law. Its stiffness and damping set the stability bounds.
    pub at_full_strength: PointLaw,
    pub shift: Option<Shift>,
}

impl Pair {
    /// Returns the penetration rate for a velocity `relative` of the sphere relative to the body `[m/s]`.
    pub fn rate_of(&self, normal: &Vector3, relative: &Vector3) -> f64 {
        self.shift.map_or(0.0, |shift| shift.rate) - normal.dot(relative)
    }
}

/// Returns the radius of each tool, and the faults of the tools.
pub(super) fn of_spheres(tools: &[Tool]) -> (Vec<f64>, Vec<WorldError>) {
    let alone = crate::World {
        joints: Vec::new(),
        tools: tools.to_vec(),
        ..crate::World::default()
    };
    let mut faults: Vec<_> = alone.check().err().into_iter().flatten().collect();
    let mut radii = Vec::new();
    for (number, tool) in tools.iter().enumerate() {
        let subject = || format!("tool {:?}", tool.name);
        let Shape::Sphere { radius } = tool.shape else {
            faults.push(WorldError::new(
                WorldPart::Tool(number),
                WorldField::Shape,
                subject(),
                "a tool that touches the bodies of another engine has to be a sphere, of radius 0 or more",
            ));
            continue;
        };
        radii.push(radius);
        if tool.turns {
            faults.push(WorldError::new(
                WorldPart::Tool(number),
                WorldField::Turns,
                subject(),
                "a tool that touches the bodies of another engine cannot turn yet: use a device of three axes",
            ));
        }
    }
    (radii, faults)
}

/// Returns the pairs of each tool with each shape of each body, and their faults.
pub(super) fn pairs(tools: &[Tool], bodies: &[EngineBody]) -> (Vec<Pair>, Vec<WorldError>) {
    let (_, mut faults) = of_spheres(tools);
    let mut pairs = Vec::new();
    for (number, tool) in tools.iter().enumerate() {
        let Shape::Sphere { radius } = tool.shape else {
            continue;
        };
        for (body, described) in bodies.iter().enumerate() {
            for placed in &described.shapes {
                let outline = match Outline::new(&placed.shape) {
                    Ok(outline) => outline,
                    Err(message) => {
                        let subject = format!("body {:?}", described.name);
                        faults.push(WorldError::new(
                            WorldPart::Body(body),
                            WorldField::Shape,
                            subject,
                            message,
                        ));
                        continue;
                    }
                };
                let [w, x, y, z] = placed.orientation;
                let law = PointLaw::share(&described.law, 1.0);
                pairs.push(Pair {
                    toucher: Toucher::Tool(number),
                    is_open: true,
                    body,
                    radius,
                    outline,
                    position: placed.position.into(),
                    orientation: UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)),
                    law,
                    at_full_strength: law,
                    shift: None,
                });
            }
        }
    }
    for (number, body) in bodies.iter().enumerate() {
        faults.extend(body.faults(number, tools));
    }
    if bodies.is_empty() {
        let message = "there is no body to touch; give at least one";
        faults.push(WorldError::new(
            WorldPart::World,
            WorldField::Bodies,
            "the engine",
            message,
        ));
    }
    if pairs.len() > MAX_PAIRS {
        faults.push(WorldError::new(
            WorldPart::World,
            WorldField::Bodies,
            "the engine",
            format!(
                "there are {} pairs of a tool and a shape, and at most {MAX_PAIRS} are allowed",
                pairs.len()
            ),
        ));
    }
    (pairs, faults)
}
