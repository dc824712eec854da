//! Convex solids with flat faces.

use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;

use crate::body::rotation;
use crate::convex::{NoHull, Polygon, coarse_hull, hull, triangles};
use crate::pairs::MOST_POINTS;
use crate::rigid::{Rotation, Vector3};
use crate::{MassProperties, Mesh, MeshError, Vector};

/// A convex solid: the least one around some points, in the own axes of the body that has it.
#[derive(Clone, PartialEq)]
pub struct Hull {
    corners: Arc<Corners>,
    /// The same surface by triangles.
    mesh: Arc<Mesh>,
    /// Largest distance of a given point outside of it `[m]`.
    left_out: f64,
}

/// Why some points have no hull.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HullError {
    /// A point that is no place.
    #[error("point {0} of the hull is not three finite numbers within 1e100 m of 0")]
    NotFinite(usize),
    /// Fewer than four points, or all of them in a plane.
    #[error("the points of the hull lie in a plane, or nearly so; it needs four that do not")]
    Flat,
    /// More corners than are taken.
    #[error(
        "the hull has more than {0} corners, and at most {0} are taken; give fewer points, let it leave out points that are further \
         outside, or take the corners that stand out most, as a scene does without `within_m`"
    )]
    TooMany(usize),
    /// A tolerance that is no length.
    #[error(
        "the hull may leave points out that are {0} m outside of it; this has to be at least 0 m"
    )]
    Within(f64),
    /// Its surface is not one of triangles: corners that are nearly the same place.
    #[error("the triangles of the hull's surface: {0}")]
    Surface(MeshError),
}

impl fmt::Debug for Hull {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Hull")
            .field("corners", &self.corners.places.len())
            .field("faces", &self.corners.faces.len())
            .finish_non_exhaustive()
    }
}

impl HullError {
    fn of(reason: NoHull, most: usize) -> Self {
        match reason {
            NoHull::TooMany => Self::TooMany(most),
            NoHull::Flat | NoHull::Broken => Self::Flat,
        }
    }
}

/// Points of single precision are so near to the plane that they were meant to be in, as a share of their size.
const SINGLE_PRECISION: f64 = 1e-6;

impl Mesh {
    /// Most corners of a [`convex`](Self::convex) mesh.
    pub const MOST_CONVEX_CORNERS: usize = 4096;

    /// The surface of the least convex solid around `points` `[m]`. It leaves points out that are outside of it by no more
    /// than 1e-6 of their largest coordinate. A [`Hull`] has fewer corners, and more shapes touch it.
    ///
    /// # Errors
    /// The points lie in a plane, or the solid has more than [`MOST_CONVEX_CORNERS`](Self::MOST_CONVEX_CORNERS) corners.
    pub fn convex(points: &[Vector]) -> Result<Self, HullError> {
        let places = places_of(points)?;
        let size = places.iter().map(Vector3::amax).fold(0.0, f64::max);
        let most = Self::MOST_CONVEX_CORNERS;
        let within = SINGLE_PRECISION * size;
        let refused = |reason| HullError::of(reason, most);
        let (corners, faces) = triangles(&places, within, most).map_err(refused)?;
        match surface(&corners, &faces) {
            Ok(mesh) if mesh.is_closed() => Ok(mesh),
            // Triangles without an area are missing: faces of several corners have none.
            _ => {
                let (corners, faces) = hull(&places, within, most).map_err(refused)?;
                surface(&corners, &faces)
            }
        }
    }
}

fn places_of(points: &[Vector]) -> Result<Vec<Vector3>, HullError> {
    let is_place = |point: &Vector| point.iter().all(|x| x.abs() < 1e100);
    if let Some(number) = points.iter().position(|point| !is_place(point)) {
        return Err(HullError::NotFinite(number));
    }
    Ok(points.iter().map(|&point| point.into()).collect())
}

/// The surface of a convex solid, each face as triangles about its first corner.
fn surface(corners: &[Vector3], faces: &[Polygon]) -> Result<Mesh, HullError> {
    let number = |corner: usize| u32::try_from(corner).unwrap_or(u32::MAX);
    let triangles = faces.iter().flat_map(|face| fan(corners, &face.corners));
    let triangles: Vec<_> = triangles.map(|corners| corners.map(number)).collect();
    let vertices: Vec<Vector> = corners.iter().map(|&corner| corner.into()).collect();
    Mesh::new(&vertices, &triangles).map_err(HullError::Surface)
}

/// Triangles of a convex polygon about its first corner, or, if corners lie nearly in a line with that one, about the best one.
fn fan(places: &[Vector3], corners: &[usize]) -> Vec<[usize; 3]> {
    let about = |first: usize| {
        let ring = (0..corners.len()).map(|k| corners[(first + k) % corners.len()]);
        let ring: Vec<usize> = ring.collect();
        let others = ring[1..].windows(2);
        others
            .map(|two| [ring[0], two[0], two[1]])
            .collect::<Vec<_>>()
    };
    // Twice the least area over the square of the longest side.
    let worst = |triangles: &[[usize; 3]]| {
        let each = triangles.iter().map(|triangle| {
            let [a, b, c] = triangle.map(|corner| places[corner]);
            let sides = [b - a, c - b, a - c].map(|side| side.norm_squared());
            (b - a).cross(&(c - a)).norm() / sides.into_iter().fold(0.0, f64::max)
        });
        each.fold(f64::INFINITY, f64::min)
    };
    let first = about(0);
    if worst(&first) > NEARLY_A_LINE {
        return first;
    }
    (1..corners.len()).map(about).fold(first, |best, other| {
        if worst(&other) > worst(&best) {
            other
        } else {
            best
        }
    })
}

/// Triangles with less than this twice their area over the square of their longest side are avoided.
const NEARLY_A_LINE: f64 = 1e-6;

impl Hull {
    /// Most corners of a hull.
    pub const MOST_CORNERS: usize = MOST_POINTS;
    /// Corners of a simplified hull: they leave room for other contacts among the points of a world.
    pub const SIMPLIFIED_CORNERS: usize = 48;

    /// The least convex solid around `points` `[m]`.
    ///
    /// # Errors
    /// The points lie in a plane, or the solid has more than [`MOST_CORNERS`](Self::MOST_CORNERS) corners.
    pub fn around(points: &[Vector]) -> Result<Self, HullError> {
        Self::within(points, 0.0)
    }

    /// A convex solid whose corners are the [`SIMPLIFIED_CORNERS`](Self::SIMPLIFIED_CORNERS) of `points` `[m]` that stand out most, or
    /// fewer if there are fewer corners: [`left_out`](Self::left_out) is the largest distance of a point outside of it.
    ///
    /// # Errors
    /// The points lie in a plane.
    pub fn simplified(points: &[Vector]) -> Result<Self, HullError> {
        Self::of(points, |places| {
            Corners::of_most(places, Self::SIMPLIFIED_CORNERS)
                .map_err(|why| HullError::of(why, Self::MOST_CORNERS))
        })
    }

    /// A convex solid whose corners are some of `points` `[m]`, chosen so that no other of them is further outside of a face than
    /// `tolerance` `[m]`, at least 0.
    ///
    /// # Errors
    /// The points lie in a plane, the solid has more than [`MOST_CORNERS`](Self::MOST_CORNERS) corners, or a tolerance that is no
    /// such length.
    pub fn within(points: &[Vector], tolerance: f64) -> Result<Self, HullError> {
        if !(tolerance >= 0.0 && tolerance.is_finite()) {
            return Err(HullError::Within(tolerance));
        }
        Self::of(points, |places| {
            Corners::around(places, tolerance).map_err(|why| HullError::of(why, Self::MOST_CORNERS))
        })
    }

    fn of(
        points: &[Vector],
        corners: impl Fn(&[Vector3]) -> Result<Corners, HullError>,
    ) -> Result<Self, HullError> {
        let places = places_of(points)?;
        let corners = corners(&places)?;
        let mesh = surface(&corners.places, &corners.faces)?;
        Ok(Self {
            left_out: corners.left_out(&places),
            corners: Arc::new(corners),
            mesh: Arc::new(mesh),
        })
    }

    /// Largest distance outside of it of a point that it was made from `[m]`: 0 but for round-off, if all corners are taken.
    #[must_use]
    pub fn left_out(&self) -> f64 {
        self.left_out
    }

    /// Its corners `[m]`.
    #[must_use]
    pub fn corners(&self) -> Vec<Vector> {
        let corners = self.corners.places.iter();
        corners.map(|&corner| corner.into()).collect()
    }

    /// Its flat faces, each by the numbers of its corners, counter-clockwise when it is seen from outside.
    #[must_use]
    pub fn faces(&self) -> Vec<Vec<usize>> {
        let faces = self.corners.faces.iter();
        faces.map(|face| face.corners.clone()).collect()
    }

    /// Its surface by triangles.
    #[must_use]
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// Centre, principal axes and moments of inertia of a body of `mass` `[kg]` that fills it evenly; see
    /// [`Mesh::mass_properties`].
    #[must_use]
    pub fn mass_properties(&self, mass: f64) -> Option<MassProperties> {
        self.mesh.mass_properties(mass)
    }

    /// The same solid in axes that begin at a centre `[m]` and are turned.
    pub(crate) fn seen_from(&self, of: &MassProperties) -> Self {
        let (centre, axes) = (of.centre.into(), rotation(of.orientation));
        Self {
            corners: Arc::new(self.corners.seen_from(&centre, &axes)),
            mesh: self.mesh.seen_from(&centre, &axes),
            left_out: self.left_out,
        }
    }

    pub(crate) fn by_corners(&self) -> &Arc<Corners> {
        &self.corners
    }
}

/// Corners and flat faces of a convex solid.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Corners {
    pub places: Vec<Vector3>,
    pub faces: Vec<Polygon>,
    pub edges: Vec<Edge>,
}

/// Where two faces of a convex solid meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Edge {
    /// Numbers of its corners.
    pub ends: [usize; 2],
    /// Numbers of its faces.
    pub faces: [usize; 2],
    /// Unit vector along it, to the side of the cross product of the second face's normal and the first's.
    pub along: Vector3,
}

impl Corners {
    /// Of points, from which the solid may leave those out that are outside of it by no more than `within` `[m]`.
    pub fn around(points: &[Vector3], within: f64) -> Result<Self, NoHull> {
        Ok(Self::of_faces(hull(points, within, MOST_POINTS)?))
    }

    /// Of points; of their solid, so many corners that stand out most.
    pub fn of_most(points: &[Vector3], most: usize) -> Result<Self, NoHull> {
        Ok(Self::of_faces(coarse_hull(points, most)?))
    }

    fn of_faces((places, faces): (Vec<Vector3>, Vec<Polygon>)) -> Self {
        Self {
            edges: edges(&places, &faces),
            places,
            faces,
        }
    }

    /// Largest distance of one of the points outside of the solid `[m]`.
    fn left_out(&self, points: &[Vector3]) -> f64 {
        let outside = points.iter().filter(|point| {
            let mut faces = self.faces.iter();
            faces.any(|face| face.normal.dot(point) > face.offset)
        });
        let distances = outside.map(|point| self.nearest(point).distance);
        distances.fold(0.0, f64::max)
    }

    /// Of a box of half these lengths, above 0 `[m]`: a corner's number has a bit for each axis.
    pub fn of_box(half: Vector3) -> Self {
        let side = |number: usize, axis: usize| if number >> axis & 1 == 1 { 1.0 } else { -1.0 };
        let corner = |number: usize| Vector3::from_fn(|axis, _| side(number, axis) * half[axis]);
        let places: Vec<Vector3> = (0..8).map(corner).collect();
        let faces: Vec<Polygon> = (0..6)
            .map(|number| {
                let (axis, positive) = (number / 2, number % 2);
                let [one, other] = [1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3)];
                let first = positive << axis;
                let mut corners = vec![first, first + one, first + one + other, first + other];
                if positive == 0 {
                    corners.reverse();
                }
                Polygon {
                    corners,
                    normal: Vector3::ith(axis, 2.0 * positive as f64 - 1.0),
                    offset: half[axis],
                }
            })
            .collect();
        Self {
            edges: edges(&places, &faces),
            places,
            faces,
        }
    }

    /// Corners of the face that has the most: a corner has the law of a contact over this, so that no face has more than
    /// the whole law.
    pub fn most_on_a_face(&self) -> usize {
        let each = self.faces.iter().map(|face| face.corners.len());
        each.max().unwrap_or(1)
    }

    fn seen_from(&self, centre: &Vector3, axes: &Rotation) -> Self {
        let back = |place: &Vector3| axes.inverse_transform_vector(&(place - centre));
        let faces = self.faces.iter().map(|face| Polygon {
            normal: axes.inverse_transform_vector(&face.normal),
            offset: face.offset - face.normal.dot(centre),
            corners: face.corners.clone(),
        });
        let places: Vec<Vector3> = self.places.iter().map(back).collect();
        let faces: Vec<Polygon> = faces.collect();
        Self {
            edges: edges(&places, &faces),
            places,
            faces,
        }
    }
}

/// The edges of a closed surface, each once.
fn edges(places: &[Vector3], faces: &[Polygon]) -> Vec<Edge> {
    let sides = |face: &Polygon| {
        let next = face.corners.iter().cycle().skip(1).copied();
        face.corners.iter().copied().zip(next).collect::<Vec<_>>()
    };
    let mut owner = HashMap::new();
    for (number, face) in faces.iter().enumerate() {
        owner.extend(sides(face).into_iter().map(|side| (side, number)));
    }
    let mut edges = Vec::new();
    for (number, face) in faces.iter().enumerate() {
        for (from, to) in sides(face) {
            let Some(&other) = owner.get(&(to, from)) else {
                continue;
            };
            if from < to {
                let along = (places[to] - places[from]).normalize();
                let turns = faces[other].normal.cross(&face.normal);
                edges.push(Edge {
                    ends: [from, to],
                    faces: [number, other],
                    along: if along.dot(&turns) < 0.0 {
                        -along
                    } else {
                        along
                    },
                });
            }
        }
    }
    edges
}
