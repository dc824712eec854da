//! Which tools and bodies of a world can touch, and at which points.

use crate::law::PointLaw;
use crate::rigid::{Mobility, Rigid, Vector3};
use crate::solid::Solid;
use crate::{Motion, Place, Shape, World, WorldError};

/// Most points of contact that a world may have: a tick looks at all of them in every sub-step.
pub const MOST_POINTS: usize = 64;

/// One side of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// The tool of this number, from 0.
    Tool(usize),
    /// The body of this number, from 0.
    Body(usize),
}

/// A point at which two tools or bodies can touch: a sphere, or a corner as one of radius 0, and the nearest point of
/// a solid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Point {
    /// Numbers of the two among tools and bodies, tools first.
    pub first: usize,
    pub second: usize,
    /// Whether the centre is a corner, and not the first's own.
    pub is_corner: bool,
    /// Centre of the sphere, in the axes of the first `[m]`.
    pub centre: Vector3,
    pub radius: f64,
    pub solid: Solid,
    pub law: PointLaw,
    /// Of both sides, the largest squared lever of a force across the surface times the inverse moment of inertia
    /// `[1/kg]`.
    pub across: [f64; 2],
    /// The same for a force along the normal: 0 for a sphere.
    pub along: [f64; 2],
}

impl Point {
    /// Where the sphere's centre is `[m]`.
    pub fn centre_of(&self, first: &Rigid) -> Vector3 {
        if self.is_corner {
            first.position + first.orientation * self.centre
        } else {
            first.position
        }
    }
}

/// One of a world's tools and bodies.
struct Candidate<'a> {
    name: &'a str,
    shape: &'a Shape,
    place: Place,
    is_tool: bool,
    is_free: bool,
}

impl Candidate<'_> {
    fn words(&self) -> &'static str {
        match self.shape {
            Shape::Sphere { .. } => "a sphere",
            Shape::HalfSpace { .. } => "a half-space",
            Shape::Box { .. } => "a box",
            Shape::Capsule { .. } => "a capsule",
            Shape::Cylinder { .. } => "a cylinder",
        }
    }

    fn moves(&self) -> bool {
        self.is_tool || self.is_free
    }
}

/// All points of contact of a checked world, or every pair that cannot be rendered.
pub(crate) fn points(
    world: &World,
    mobilities: &[Mobility],
) -> Result<Vec<Point>, Vec<WorldError>> {
    let tools = world.tools.iter().enumerate().map(|(i, tool)| Candidate {
        name: &tool.name,
        shape: &tool.shape,
        place: Place::Tool(i),
        is_tool: true,
        is_free: false,
    });
    let bodies = world.bodies.iter().enumerate().map(|(i, body)| Candidate {
        name: &body.name,
        shape: &body.shape,
        place: Place::Body(i),
        is_tool: false,
        is_free: matches!(body.motion, Motion::Free(_)),
    });
    let parts: Vec<_> = tools.chain(bodies).collect();
    let (mut points, mut faults) = (Vec::new(), Vec::new());
    for (i, one) in parts.iter().enumerate() {
        for (j, other) in parts.iter().enumerate().skip(i + 1) {
            if (one.is_tool && other.is_tool) || !(one.moves() || other.moves()) {
                continue;
            }
            let Some(law) = world.law(one.name, other.name) else {
                continue;
            };
            match (one.shape, other.shape) {
                (Shape::Sphere { radius }, solid) => {
                    points.push(sphere(i, j, *radius, solid, PointLaw::share(law, 1.0)));
                }
                (solid, Shape::Sphere { radius }) => {
                    points.push(sphere(j, i, *radius, solid, PointLaw::share(law, 1.0)));
                }
                (Shape::Box { half_extents }, plane @ Shape::HalfSpace { .. }) => {
                    points.extend(corners(i, j, *half_extents, plane, law));
                }
                (plane @ Shape::HalfSpace { .. }, Shape::Box { half_extents }) => {
                    points.extend(corners(j, i, *half_extents, plane, law));
                }
                _ => faults.push(WorldError::new(
                    one.place,
                    "shape",
                    format!("{:?} and {:?}", one.name, other.name),
                    format!(
                        "there is no contact of {} with {} yet; a sphere may touch any shape, and a box a \
                         half-space. Give one of them another shape, or leave the pair without a law",
                        one.words(),
                        other.words()
                    ),
                )),
            }
        }
    }
    if points.len() > MOST_POINTS {
        faults.push(WorldError::new(
            Place::World,
            "contacts",
            "the world",
            format!(
                "there are {} points at which its tools and bodies may touch, and at most {MOST_POINTS} are \
                 allowed; give laws to fewer pairs",
                points.len()
            ),
        ));
    }
    for point in &mut points {
        let far = point.centre.norm() + point.radius;
        let of_solid = point.solid.reach();
        let lever = |reach: f64, number: usize| {
            let most = mobilities.get(number).map_or(0.0, |m| m.angular.max());
            if most > 0.0 {
                reach * reach * most
            } else {
                0.0
            }
        };
        let [first, second] = [lever(far, point.first), lever(of_solid, point.second)];
        point.across = [first, second];
        let is_ball = matches!(point.solid, Solid::Ball { .. });
        point.along = [
            if point.is_corner { first } else { 0.0 },
            if is_ball { 0.0 } else { second },
        ];
    }
    if faults.is_empty() {
        Ok(points)
    } else {
        Err(faults)
    }
}

fn sphere(first: usize, second: usize, radius: f64, solid: &Shape, law: PointLaw) -> Point {
    Point {
        first,
        second,
        is_corner: false,
        centre: Vector3::zeros(),
        radius,
        solid: solid.into(),
        law,
        across: [0.0; 2],
        along: [0.0; 2],
    }
}

/// The corners of a box above a half-space. A face that lies flat has four, so each has a quarter of the law.
fn corners(
    first: usize,
    second: usize,
    half: [f64; 3],
    plane: &Shape,
    law: &crate::ContactLaw,
) -> impl Iterator<Item = Point> {
    let law = PointLaw::share(law, 4.0);
    let solid: Solid = plane.into();
    (0..8).map(move |corner: u8| {
        let side = |axis: u8| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
        Point {
            first,
            second,
            is_corner: true,
            centre: Vector3::new(side(0) * half[0], side(1) * half[1], side(2) * half[2]),
            radius: 0.0,
            solid,
            law,
            across: [0.0; 2],
            along: [0.0; 2],
        }
    })
}
