//! Which tool may touch which shape of an engine's bodies.

use std::sync::Arc;

use nalgebra::{Quaternion, UnitQuaternion};

use super::body::EngineBody;
use crate::law::PointLaw;
use crate::rigid::{Rigid, Rotation, Vector3};
use crate::solid::{Nearest, Solid};
use crate::{MOST_POINTS, Mesh, Place, Shape, Tool, WorldError};

/// A convex surface that a sphere touches at one point.
#[derive(Clone, Debug)]
pub(super) enum Outline {
    Solid(Solid),
    Convex(Arc<Mesh>),
}

impl Outline {
    /// Of a shape; otherwise why it has none.
    fn of(shape: &Shape) -> Result<Self, String> {
        match shape {
            Shape::Hull(hull) => Ok(Self::Convex(hull.mesh().clone())),
            Shape::Mesh(mesh) if mesh.is_convex() => Ok(Self::Convex(mesh.clone())),
            Shape::Mesh(_) => Err(format!(
                "a mesh here has to be closed and convex, of at most {} triangles: give the hull around it, or several \
                 convex parts",
                Mesh::MOST_OF_CONVEX
            )),
            other => Solid::of(other).map(Self::Solid).ok_or_else(|| {
                "a body of several spheres has a shape for each of them here".to_string()
            }),
        }
    }

    /// Of the surface, with the solid as `placed`, the point nearest to `point` `[m]`; of a point inside, that of least
    /// depth.
    pub fn nearest(&self, placed: &Rigid, point: &Vector3) -> Nearest {
        match self {
            Self::Solid(solid) => solid.nearest(placed, point),
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

/// A tool and a shape that it may touch.
#[derive(Clone, Debug)]
pub(super) struct Pair {
    pub tool: usize,
    pub body: usize,
    /// Of the tool `[m]`.
    pub radius: f64,
    pub outline: Outline,
    /// Where the shape is in the body's axes.
    pub position: Vector3,
    pub orientation: Rotation,
    pub law: PointLaw,
}

/// Each tool with each shape of each body, and what is wrong with them.
pub(super) fn pairs(tools: &[Tool], bodies: &[EngineBody]) -> (Vec<Pair>, Vec<WorldError>) {
    let alone = crate::World {
        joints: Vec::new(),
        tools: tools.to_vec(),
        ..crate::World::default()
    };
    let mut faults = alone.check().err().unwrap_or_default();
    let mut pairs = Vec::new();
    for (number, tool) in tools.iter().enumerate() {
        let Shape::Sphere { radius } = tool.shape else {
            faults.push(WorldError::new(
                Place::Tool(number),
                "shape",
                format!("tool {:?}", tool.name),
                "a tool that touches the bodies of another engine has to be a sphere, of radius 0 or more",
            ));
            continue;
        };
        if tool.turns {
            faults.push(WorldError::new(
                Place::Tool(number),
                "turns",
                format!("tool {:?}", tool.name),
                "a tool that touches the bodies of another engine does not turn so far: give it a device of three axes",
            ));
        }
        for (body, described) in bodies.iter().enumerate() {
            for placed in &described.shapes {
                let outline = match Outline::of(&placed.shape) {
                    Ok(outline) => outline,
                    Err(message) => {
                        let subject = format!("body {:?}", described.name);
                        faults.push(WorldError::new(
                            Place::Body(body),
                            "shape",
                            subject,
                            message,
                        ));
                        continue;
                    }
                };
                let [w, x, y, z] = placed.orientation;
                pairs.push(Pair {
                    tool: number,
                    body,
                    radius,
                    outline,
                    position: placed.position.into(),
                    orientation: UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z)),
                    law: PointLaw::share(&described.law, 1.0),
                });
            }
        }
    }
    for (number, body) in bodies.iter().enumerate() {
        faults.extend(body.faults(number, tools));
    }
    if bodies.is_empty() {
        let message = "there is no body of the engine to touch";
        faults.push(WorldError::new(
            Place::World,
            "bodies",
            "the engine",
            message,
        ));
    }
    if pairs.len() > MOST_POINTS {
        faults.push(WorldError::new(
            Place::World,
            "bodies",
            "the engine",
            format!(
                "its bodies have {} shapes for all tools together, and at most {MOST_POINTS} are allowed",
                pairs.len()
            ),
        ));
    }
    (pairs, faults)
}
