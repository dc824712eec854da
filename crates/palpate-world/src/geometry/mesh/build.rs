//! Mesh construction from vertices and triangles, with checks.

use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;

use super::distance_grid::{DistanceGrid, InvalidGrid};
use super::parts::Triangles;
use super::point_shell::PointShell;
use super::topology::Topology;
use super::tree::{Bounds, Tree};
use crate::Vector;
use crate::geometry::rigid::Vector3;

/// A triangle surface, in the axes of its body.
///
/// Seen from outside, the corners of each triangle are in counter-clockwise order: its normal (b - a) x (c - a)
/// points out of the solid. A mesh is *closed* if every edge has two triangles. An open mesh is solid behind its
/// triangles, and only their front can be touched.
#[derive(Clone, PartialEq)]
pub struct Mesh {
    pub(super) vertices: Vec<Vector3>,
    pub(super) faces: Vec<[u32; 3]>,
    pub(super) topology: Topology,
    pub(super) tree: Tree,
    is_closed: bool,
    dropped: usize,
    pub(super) turned: usize,
    reach: f64,
    pub(super) grid: Option<Arc<DistanceGrid>>,
    pub(super) shell: Option<PointShell>,
}

/// Fault of a mesh. Triangles and vertices are counted from 0 in the given order.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// No triangle with an area.
    #[error("the mesh has no triangle with an area; it needs at least one")]
    Empty,
    /// Too many triangles.
    #[error("the mesh has {0} triangles, and at most {most} are allowed; reduce it", most = Mesh::MAX_TRIANGLES)]
    TooMany(usize),
    /// A corner index out of range.
    #[error(
        "triangle {triangle} has corner {corner}, and there are {vertices} vertices, counted from 0"
    )]
    NoSuchVertex {
        /// Index of the triangle.
        triangle: usize,
        /// Given index of the corner.
        corner: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A vertex that is not finite or too large.
    #[error("vertex {0} of the mesh is not three finite numbers within 1e100 m of 0")]
    NotFinite(usize),
    /// A surface that branches at an edge.
    #[error(
        "triangles {}, {} and {} share an edge, and an edge needs equal numbers of triangles in both directions: \
         solids may touch at an edge, but a sheet on a surface has no inside; remove the sheet or give it a thickness",
        .0[0], .0[1], .0[2]
    )]
    SharedEdge([usize; 3]),
    /// A sheet with coincident triangles on both sides.
    #[error(
        "triangles {} and {} are the two sides of one sheet, which has no inside; remove the triangles of one side (an open mesh is \
         touched from the front of its triangles), or give the sheet a thickness", .0[0], .0[1]
    )]
    TwoSided([usize; 2]),
    /// Neighbours with opposite orientation.
    #[error(
        "triangles {} and {} share an edge and run along it the same way, so one of them is inside out; reverse the \
         corners of one of them", .0[0], .0[1]
    )]
    Winding([usize; 2]),
    /// A vertex with too many triangles for one tick.
    #[error(
        "{triangles} triangles meet at vertex {vertex} of the mesh, and at most {most} are allowed",
        most = Mesh::MAX_AROUND
    )]
    Fan {
        /// Index of the vertex after merging.
        vertex: usize,
        /// Number of triangles that meet there.
        triangles: usize,
    },
    /// A closed surface without a volume.
    #[error(
        "the closed mesh encloses a volume of {0} m^3, and the volume has to be above 0; if it is a two-sided sheet, \
         remove the triangles of one side (an open mesh is touched from the front of its triangles), or give it a \
         thickness"
    )]
    NoVolume(f64),
}

impl fmt::Debug for Mesh {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Mesh")
            .field("vertices", &self.vertices.len())
            .field("faces", &self.faces.len())
            .field("is_closed", &self.is_closed)
            .field("grid", &self.grid)
            .field("shell", &self.shell)
            .finish_non_exhaustive()
    }
}

/// Ratio of twice a triangle's area to the square of its longest side below which it counts as a line, without a
/// normal.
const FLAT: f64 = 1e-10;
/// Merge tolerance for vertices, as a fraction of half the longest side of their bounding box: two units in the last
/// place of single precision, the precision of common mesh files.
const SAME: f64 = 2.5e-7;

impl Mesh {
    /// Maximum number of triangles of a mesh.
    pub const MAX_TRIANGLES: usize = 1_000_000;
    /// Maximum number of triangles that meet at a vertex.
    pub const MAX_AROUND: usize = 1000;

    /// Creates a mesh from `vertices` `[m]` and triangles, each given by three vertex indices from 0.
    ///
    /// Vertices within 2.5e-7 of half the longest side of their bounding box are merged. Triangles without an area
    /// and duplicates are dropped ([`dropped`](Self::dropped)), and so are triangles between closed parts that touch
    /// face to face. Closed parts that are inside out are reversed, except cavities ([`turned`](Self::turned)).
    ///
    /// # Errors
    /// Returns the first fault.
    pub fn new(vertices: &[Vector], faces: &[[u32; 3]]) -> Result<Self, MeshError> {
        if faces.len() > Self::MAX_TRIANGLES {
            return Err(MeshError::TooMany(faces.len()));
        }
        // Differences and squares of the coordinates must also be finite.
        let is_place = |vertex: &Vector| vertex.iter().all(|x| x.abs() < 1e100);
        if let Some(vertex) = vertices.iter().position(|vertex| !is_place(vertex)) {
            return Err(MeshError::NotFinite(vertex));
        }
        let mut welded = Welded::new(vertices);
        let mut kept: Vec<[u32; 3]> = Vec::with_capacity(faces.len());
        let mut given = Vec::with_capacity(faces.len());
        let mut seen = std::collections::HashSet::with_capacity(faces.len());
        for (triangle, face) in faces.iter().enumerate() {
            let mut corners = [0; 3];
            for (corner, &number) in corners.iter_mut().zip(face) {
                let vertex = vertices.get(number as usize);
                let vertex = vertex.ok_or(MeshError::NoSuchVertex {
                    triangle,
                    corner: number,
                    vertices: vertices.len(),
                })?;
                *corner = welded.number(vertex);
            }
            let first = (0..3).min_by_key(|&k| corners[k]).unwrap_or(0);
            let turned = [0, 1, 2].map(|k| corners[(first + k) % 3]);
            if welded.has_area(corners) && seen.insert(turned) {
                kept.push(corners);
                given.push(triangle);
            }
        }
        if kept.is_empty() {
            return Err(MeshError::Empty);
        }
        let parts = Triangles {
            vertices: welded.places,
            faces: kept,
            given,
            turned: 0,
        };
        let Triangles {
            vertices,
            faces: kept,
            given,
            turned,
        } = parts.into_parts()?;
        let topology = Topology::new(&vertices, &kept, &given)?;
        let dropped = faces.len() - kept.len();
        Ok(Self {
            turned,
            ..Self::of_parts(vertices, kept, topology, dropped)
        })
    }

    /// Creates a mesh from checked parts.
    pub(super) fn of_parts(
        vertices: Vec<Vector3>,
        faces: Vec<[u32; 3]>,
        topology: Topology,
        dropped: usize,
    ) -> Self {
        let boxes: Vec<Bounds> = faces
            .iter()
            .map(|face| {
                let corners = face.iter().map(|&corner| &vertices[corner as usize]);
                corners.fold(Bounds::empty(), Bounds::with)
            })
            .collect();
        Self {
            tree: Tree::over(&boxes),
            reach: vertices.iter().map(Vector3::norm).fold(0.0, f64::max),
            is_closed: topology.is_closed(),
            dropped,
            turned: 0,
            faces,
            vertices,
            topology,
            grid: None,
            shell: None,
        }
    }

    /// Adds a distance grid, so that the points of other shapes can touch the mesh.
    ///
    /// # Errors
    /// The grid was made from another mesh.
    pub fn with_grid(self, grid: DistanceGrid) -> Result<Self, InvalidGrid> {
        if !grid.is_of(&self) {
            return Err(InvalidGrid::OfAnother);
        }
        Ok(Self {
            grid: Some(Arc::new(grid)),
            ..self
        })
    }

    /// Adds the points by which the mesh touches shapes other than spheres.
    #[must_use]
    pub fn with_shell(self, shell: PointShell) -> Self {
        Self {
            shell: Some(shell),
            ..self
        }
    }

    /// Returns the distance grid, if the mesh has one.
    #[must_use]
    pub fn grid(&self) -> Option<&Arc<DistanceGrid>> {
        self.grid.as_ref()
    }

    /// Returns the points by which the mesh touches shapes other than spheres, if it has any.
    #[must_use]
    pub fn shell(&self) -> Option<&PointShell> {
        self.shell.as_ref()
    }

    /// Returns the vertices `[m]`. Positions are unique, except at edges where several solids touch.
    #[must_use]
    pub fn vertices(&self) -> Vec<Vector> {
        self.vertices.iter().map(|&vertex| vertex.into()).collect()
    }

    /// Returns the triangles, each given by its vertex indices.
    #[must_use]
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// Returns whether every edge has two triangles, so that the mesh has an inside.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.is_closed
    }

    /// Returns the number of given triangles that were dropped as duplicates or for having no area.
    #[must_use]
    pub fn dropped(&self) -> usize {
        self.dropped
    }

    /// Returns the number of closed parts that were given inside out.
    #[must_use]
    pub fn turned(&self) -> usize {
        self.turned
    }

    /// Returns the enclosed volume `[m^3]`; 0 for an open mesh.
    #[must_use]
    pub fn volume(&self) -> f64 {
        if self.is_closed {
            volume(&self.vertices, &self.faces)
        } else {
            0.0
        }
    }

    /// Returns the vertices.
    pub(crate) fn places(&self) -> &[Vector3] {
        &self.vertices
    }

    /// Returns the largest distance of a vertex from the origin `[m]`.
    pub(crate) fn reach(&self) -> f64 {
        self.reach
    }

    /// Returns the corners of a triangle.
    pub(super) fn corners(&self, triangle: u32) -> [&Vector3; 3] {
        self.faces[triangle as usize].map(|corner| &self.vertices[corner as usize])
    }
}

/// Returns the signed volume of the cones from the first vertex over all triangles `[m^3]`.
fn volume(vertices: &[Vector3], faces: &[[u32; 3]]) -> f64 {
    let tip = vertices[0];
    let cones = faces.iter().map(|face| {
        let [a, b, c] = face.map(|corner| vertices[corner as usize] - tip);
        a.dot(&b.cross(&c)) / 6.0
    });
    cones.sum()
}

/// Merged vertices.
struct Welded {
    places: Vec<Vector3>,
    /// Distance below which vertices are merged `[m]`.
    tolerance: f64,
    /// Vertices in each cell of a grid.
    cells: HashMap<[i64; 3], Vec<u32>>,
}

/// Cell size divided by the tolerance. With large cells few points need a lookup in a second cell.
const CELL: f64 = 32.0;

impl Welded {
    fn new(vertices: &[Vector]) -> Self {
        let half_side = |axis: usize| {
            let along = || vertices.iter().map(|vertex| vertex[axis]);
            let (least, most) = (
                along().fold(f64::INFINITY, f64::min),
                along().fold(f64::NEG_INFINITY, f64::max),
            );
            0.5 * (most - least)
        };
        let largest = (0..3).map(half_side).fold(0.0, f64::max);
        Self {
            places: Vec::with_capacity(vertices.len()),
            tolerance: SAME * largest,
            cells: HashMap::with_capacity(vertices.len()),
        }
    }

    fn number(&mut self, vertex: &Vector) -> u32 {
        let place = Vector3::from(*vertex);
        let side = (CELL * self.tolerance).max(f64::MIN_POSITIVE);
        #[expect(
            clippy::cast_possible_truncation,
            reason = "at most 1 over the tolerance's share"
        )]
        let cell = |shift: f64| vertex.map(|x| ((x + shift) / side).floor() as i64);
        let (low, high) = (cell(-self.tolerance), cell(self.tolerance));
        for (x, y) in (low[0]..=high[0]).flat_map(|x| (low[1]..=high[1]).map(move |y| (x, y))) {
            for z in low[2]..=high[2] {
                for &number in self.cells.get(&[x, y, z]).into_iter().flatten() {
                    if (self.places[number as usize] - place).norm() <= self.tolerance {
                        return number;
                    }
                }
            }
        }
        let number = super::tree::size(self.places.len());
        self.places.push(place);
        self.cells.entry(cell(0.0)).or_default().push(number);
        number
    }

    fn has_area(&self, corners: [u32; 3]) -> bool {
        let [a, b, c] = corners.map(|corner| self.places[corner as usize]);
        let sides = [b - a, c - b, a - c].map(|side| side.norm_squared());
        let longest = sides.into_iter().fold(0.0, f64::max);
        (b - a).cross(&(c - a)).norm() > FLAT * longest
    }
}
