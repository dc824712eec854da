//! A mesh from its vertices and triangles, checked once.

use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;

use super::distance_grid::{DistanceGrid, InvalidGrid};
use super::parts::Triangles;
use super::point_shell::PointShell;
use super::topology::Topology;
use super::tree::{Bounds, Tree};
use crate::Vector;
use crate::rigid::Vector3;

/// A surface of triangles, in the own axes of the body that has it.
///
/// Seen from outside, the corners of each triangle run counter-clockwise: its normal (b - a) x (c - a) points out of
/// the solid. A mesh is *closed* if every edge has two triangles; an open one is solid on the back of its triangles,
/// and only their front is touched.
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

/// What is wrong with the triangles of a mesh. Triangles and vertices are counted from 0, as they were given.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// There is nothing to touch.
    #[error("the mesh has no triangle with an area; it needs at least one")]
    Empty,
    /// More triangles than are taken.
    #[error("the mesh has {0} triangles, and at most {most} are taken; reduce it", most = Mesh::MOST_TRIANGLES)]
    TooMany(usize),
    /// A corner that does not exist.
    #[error(
        "triangle {triangle} has corner {corner}, and there are {vertices} vertices, counted from 0"
    )]
    NoSuchVertex {
        /// Number of the triangle.
        triangle: usize,
        /// The number that it gives for a corner.
        corner: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A vertex that is no place.
    #[error("vertex {0} of the mesh is not three finite numbers within 1e100 m of 0")]
    NotFinite(usize),
    /// A surface that parts in three.
    #[error(
        "triangles {}, {} and {} share an edge, and as many of its triangles have to run along it one way as the other: solids may \
         touch there, but a sheet that stands on a surface has no inside; remove it, or give it a thickness",
        .0[0], .0[1], .0[2]
    )]
    SharedEdge([usize; 3]),
    /// A sheet whose two sides are given, at the same place.
    #[error(
        "triangles {} and {} are the two sides of one sheet, which has no inside; remove the triangles of one side (an open mesh is \
         touched from the front of its triangles), or give the sheet a thickness", .0[0], .0[1]
    )]
    TwoSided([usize; 2]),
    /// Neighbours that face opposite ways.
    #[error(
        "triangles {} and {} share an edge and run along it the same way, so that one of them is inside out; turn the \
         corners of one of them round", .0[0], .0[1]
    )]
    Winding([usize; 2]),
    /// A fan of more triangles than are looked at in a tick.
    #[error("{triangles} triangles meet at vertex {vertex} of the mesh, and at most {most} may", most = Mesh::MOST_AROUND)]
    Fan {
        /// Number of the vertex, among those of different places.
        vertex: usize,
        /// How many meet there.
        triangles: usize,
    },
    /// A closed surface around nothing.
    #[error(
        "the mesh is closed and encloses a volume of {0} m^3, and it has to enclose one above 0; of a sheet that is given from both \
         sides, remove the triangles of one side (an open mesh is touched from the front of its triangles), or give it a thickness"
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

/// Twice the area of a triangle over the square of its longest side below which it is a line: it has no normal.
const FLAT: f64 = 1e-10;
/// Vertices are one if they are nearer to each other than this share of half the longest side of the box around them: two units in
/// the last place of single precision, in which such files are.
const SAME: f64 = 2.5e-7;

impl Mesh {
    /// Most triangles of a mesh.
    pub const MOST_TRIANGLES: usize = 1_000_000;
    /// Most triangles that may meet at a vertex.
    pub const MOST_AROUND: usize = 1000;

    /// A mesh of `vertices` `[m]` and triangles, each by the numbers of its three corners from 0.
    ///
    /// Vertices nearer to each other than 2.5e-7 of half the longest side of the box around them are one. Triangles without an
    /// area, and those that are there twice, are dropped: [`dropped`](Self::dropped). So are the triangles between closed parts that
    /// touch face to face. Closed parts that are inside out are turned, but for cavities: [`turned`](Self::turned).
    ///
    /// # Errors
    /// The first thing that is wrong with it.
    pub fn new(vertices: &[Vector], faces: &[[u32; 3]]) -> Result<Self, MeshError> {
        if faces.len() > Self::MOST_TRIANGLES {
            return Err(MeshError::TooMany(faces.len()));
        }
        // Their differences and their squares have to be finite too.
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
        let topology = Topology::of(&vertices, &kept, &given)?;
        let dropped = faces.len() - kept.len();
        Ok(Self {
            turned,
            ..Self::of_parts(vertices, kept, topology, dropped)
        })
    }

    /// A mesh of parts that are checked.
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

    /// The same mesh with a grid of distances: the points of other shapes can touch it.
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

    /// The same mesh with points by which it touches other shapes than spheres.
    #[must_use]
    pub fn with_shell(self, shell: PointShell) -> Self {
        Self {
            shell: Some(shell),
            ..self
        }
    }

    /// The grid of its distances, if it has one.
    #[must_use]
    pub fn grid(&self) -> Option<&Arc<DistanceGrid>> {
        self.grid.as_ref()
    }

    /// The points by which it touches other shapes than spheres, if it has any.
    #[must_use]
    pub fn shell(&self) -> Option<&PointShell> {
        self.shell.as_ref()
    }

    /// Its vertices `[m]`: each place once, but for edges at which several solids touch.
    #[must_use]
    pub fn vertices(&self) -> Vec<Vector> {
        self.vertices.iter().map(|&vertex| vertex.into()).collect()
    }

    /// Its triangles, each by the numbers of its corners among the vertices.
    #[must_use]
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// Whether every edge has two triangles, so that there is an inside.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.is_closed
    }

    /// How many of the given triangles have no area or were there twice, and are not part of the mesh.
    #[must_use]
    pub fn dropped(&self) -> usize {
        self.dropped
    }

    /// How many of its closed parts were given inside out.
    #[must_use]
    pub fn turned(&self) -> usize {
        self.turned
    }

    /// Volume that it encloses `[m^3]`; 0 for an open mesh.
    #[must_use]
    pub fn volume(&self) -> f64 {
        if self.is_closed {
            volume(&self.vertices, &self.faces)
        } else {
            0.0
        }
    }

    /// Its vertices.
    pub(crate) fn places(&self) -> &[Vector3] {
        &self.vertices
    }

    /// Largest distance of a vertex from the origin `[m]`.
    pub(crate) fn reach(&self) -> f64 {
        self.reach
    }

    /// The corners of a triangle.
    pub(super) fn corners(&self, triangle: u32) -> [&Vector3; 3] {
        self.faces[triangle as usize].map(|corner| &self.vertices[corner as usize])
    }
}

/// Signed volume of the cones from the first vertex over all triangles `[m^3]`.
fn volume(vertices: &[Vector3], faces: &[[u32; 3]]) -> f64 {
    let tip = vertices[0];
    let cones = faces.iter().map(|face| {
        let [a, b, c] = face.map(|corner| vertices[corner as usize] - tip);
        a.dot(&b.cross(&c)) / 6.0
    });
    cones.sum()
}

/// Vertices, each place once.
struct Welded {
    places: Vec<Vector3>,
    /// Vertices this near are one `[m]`.
    tolerance: f64,
    /// The vertices in each cell of a grid.
    cells: HashMap<[i64; 3], Vec<u32>>,
}

/// Side of a cell of the grid over the tolerance: few places are so near to another cell that both are looked into.
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
