//! Convex solids with flat faces.

use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;

use crate::geometry::convex::{NoHull, Polygon, coarse_hull, hull, triangles};
use crate::geometry::rigid::{Rotation, Vector3, orientation};
use crate::{MassProperties, Mesh, MeshError, Vector};

/// Maximum number of corners of a hull, and of contact points of a pair.
pub(crate) const MAX_CORNERS: usize = 64;

/// A convex solid: the convex hull of some points, in the axes of its body.
#[derive(Clone, PartialEq)]
pub struct Hull {
    corners: Arc<Corners>,
    /// Triangulation of the surface.
    mesh: Arc<Mesh>,
    /// Largest distance of a given point outside the solid `[m]`.
    left_out: f64,
}

/// Reason for rejecting a hull.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HullError {
    /// A point that is not finite or too large.
    #[error("point {0} of the hull is not three finite numbers within 1e100 m of 0")]
    NotFinite(usize),
    /// Fewer than four points, or coplanar points.
    #[error("the points of the hull lie in a plane, or nearly so; it needs four that do not")]
    Flat,
    /// Too many corners.
    #[error(
        "the hull has more than {0} corners, and at most {0} are allowed; give fewer points, increase the tolerance, \
         or leave out `within_m`, so that a scene keeps the most prominent corners"
    )]
    TooMany(usize),
    /// The tolerance is not a length.
    #[error("the tolerance of the hull is {0} m, and has to be at least 0 m")]
    Within(f64),
    /// The triangulation of the surface is invalid: some corners nearly coincide.
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
    fn new(reason: NoHull, most: usize) -> Self {
        match reason {
            NoHull::TooMany => Self::TooMany(most),
            NoHull::Flat | NoHull::Broken => Self::Flat,
        }
    }
}

/// Distance of points in single precision from their intended plane, relative to their size.
const SINGLE_PRECISION: f64 = 1e-6;

impl Mesh {
    /// Maximum number of corners of a [`convex`](Self::convex) mesh.
    pub const MAX_CONVEX_CORNERS: usize = 4096;

    /// Creates the surface of the convex hull of `points` `[m]`. Points outside by at most 1e-6 of the largest
    /// coordinate are omitted. A [`Hull`] has fewer corners and supports contacts with more shapes.
    ///
    /// # Errors
    /// The points are coplanar, or the solid has more than [`MAX_CONVEX_CORNERS`](Self::MAX_CONVEX_CORNERS)
    /// corners.
    pub fn convex(points: &[Vector]) -> Result<Self, HullError> {
        let places = places_of(points)?;
        let size = places.iter().map(Vector3::amax).fold(0.0, f64::max);
        let most = Self::MAX_CONVEX_CORNERS;
        let within = SINGLE_PRECISION * size;
        let refused = |reason| HullError::new(reason, most);
        let (corners, faces) = triangles(&places, within, most).map_err(refused)?;
        match surface(&corners, &faces) {
            Ok(mesh) if mesh.is_closed() => Ok(mesh),
            // Degenerate triangles are missing; polygonal faces have none.
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

/// Triangulates the surface of a convex solid with fans around the first corner of each face.
fn surface(corners: &[Vector3], faces: &[Polygon]) -> Result<Mesh, HullError> {
    let number = |corner: usize| u32::try_from(corner).unwrap_or(u32::MAX);
    let triangles = faces.iter().flat_map(|face| fan(corners, &face.corners));
    let triangles: Vec<_> = triangles.map(|corners| corners.map(number)).collect();
    let vertices: Vec<Vector> = corners.iter().map(|&corner| corner.into()).collect();
    Mesh::new(&vertices, &triangles).map_err(HullError::Surface)
}

/// Triangulates a convex polygon with a fan around its first corner, or around the best corner if others are nearly
/// collinear with it.
fn fan(places: &[Vector3], corners: &[usize]) -> Vec<[usize; 3]> {
    let about = |first: usize| {
        let ring = (0..corners.len()).map(|k| corners[(first + k) % corners.len()]);
        let ring: Vec<usize> = ring.collect();
        let others = ring[1..].windows(2);
        others
            .map(|two| [ring[0], two[0], two[1]])
            .collect::<Vec<_>>()
    };
    // Smallest ratio of twice the area to the square of the longest side.
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

/// Ratio of twice a triangle's area to the square of its longest side below which it is avoided.
const NEARLY_A_LINE: f64 = 1e-6;

impl Hull {
    /// Maximum number of corners of a hull.
    pub const MAX_CORNERS: usize = MAX_CORNERS;
    /// Number of corners of a simplified hull, which limits the time of its contacts.
    pub const SIMPLIFIED_CORNERS: usize = 48;

    /// Creates the convex hull of `points` `[m]`.
    ///
    /// # Errors
    /// The points are coplanar, or the solid has more than [`MAX_CORNERS`](Self::MAX_CORNERS) corners.
    pub fn around(points: &[Vector]) -> Result<Self, HullError> {
        Self::within(points, 0.0)
    }

    /// Creates a convex solid from the [`SIMPLIFIED_CORNERS`](Self::SIMPLIFIED_CORNERS) furthest protruding `points`
    /// `[m]`, or from fewer if there are fewer corners. [`left_out`](Self::left_out) is the largest distance of a
    /// point outside it.
    ///
    /// # Errors
    /// The points are coplanar.
    pub fn simplified(points: &[Vector]) -> Result<Self, HullError> {
        Self::new(points, |places| {
            Corners::of_most(places, Self::SIMPLIFIED_CORNERS)
                .map_err(|why| HullError::new(why, Self::MAX_CORNERS))
        })
    }

    /// Creates a convex solid whose corners are some of `points` `[m]`. No other point is further outside a face than
    /// `tolerance` `[m]`, at least 0.
    ///
    /// # Errors
    /// The points are coplanar, the solid has more than [`MAX_CORNERS`](Self::MAX_CORNERS) corners, or the
    /// tolerance is not such a length.
    pub fn within(points: &[Vector], tolerance: f64) -> Result<Self, HullError> {
        if !(tolerance >= 0.0 && tolerance.is_finite()) {
            return Err(HullError::Within(tolerance));
        }
        Self::new(points, |places| {
            Corners::around(places, tolerance).map_err(|why| HullError::new(why, Self::MAX_CORNERS))
        })
    }

    fn new(
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

    /// Returns the largest distance of a source point outside the solid `[m]`. It is 0 up to rounding if all corners
    /// are used.
    #[must_use]
    pub fn left_out(&self) -> f64 {
        self.left_out
    }

    /// Returns the corners `[m]`.
    #[must_use]
    pub fn corners(&self) -> Vec<Vector> {
        let corners = self.corners.places.iter();
        corners.map(|&corner| corner.into()).collect()
    }

    /// Returns the flat faces, each given by its corner indices in counter-clockwise order seen from outside.
    #[must_use]
    pub fn faces(&self) -> Vec<Vec<usize>> {
        let faces = self.corners.faces.iter();
        faces.map(|face| face.corners.clone()).collect()
    }

    /// Returns the triangulation of the surface.
    #[must_use]
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// Returns centre of mass, principal axes and moments of inertia of a homogeneous body of `mass` `[kg]`; see
    /// [`Mesh::mass_properties`].
    #[must_use]
    pub fn mass_properties(&self, mass: f64) -> Option<MassProperties> {
        self.mesh.mass_properties(mass)
    }

    /// Returns the solid in axes with a given origin `[m]` and orientation.
    pub(crate) fn seen_from(&self, of: &MassProperties) -> Self {
        let (centre, axes) = (of.centre.into(), orientation(of.orientation));
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

/// Edge between two faces of a convex solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Edge {
    /// Indices of its corners.
    pub ends: [usize; 2],
    /// Indices of its faces.
    pub faces: [usize; 2],
    /// Unit vector along the edge, in the direction of the cross product of the second face's normal and the first's.
    pub along: Vector3,
}

impl Corners {
    /// Computes the hull of points. Points outside by at most `within` `[m]` may be omitted.
    pub fn around(points: &[Vector3], within: f64) -> Result<Self, NoHull> {
        Ok(Self::of_faces(hull(points, within, MAX_CORNERS)?))
    }

    /// Computes the solid of the `most` furthest protruding points.
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

    /// Returns the largest distance of one of the points outside the solid `[m]`.
    fn left_out(&self, points: &[Vector3]) -> f64 {
        let outside = points.iter().filter(|point| {
            let mut faces = self.faces.iter();
            faces.any(|face| face.normal.dot(point) > face.offset)
        });
        let distances = outside.map(|point| self.nearest(point).distance);
        distances.fold(0.0, f64::max)
    }

    /// Creates a box with these half-extents, above 0 `[m]`. A corner's index has one bit per axis.
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

    /// Returns the number of corners of the largest face. A corner has the law of a contact divided by it, so that no
    /// face exceeds the full law.
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

/// Returns the edges of a closed surface, each once.
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
