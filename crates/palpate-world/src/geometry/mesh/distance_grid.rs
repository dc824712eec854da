//! Signed distances from a mesh at the nodes of a grid, and their smooth interpolation.
//!
//! The interpolant is the cubic spline through the distances at the nodes (tensor product of B-splines). Value,
//! gradient and curvature are continuous, so a point sliding over the grid feels no force jumps. The spline rounds
//! the kinks of the distance, at edges or midway between two walls, over about one spacing.

mod serialisation;
mod spline;

use std::sync::Arc;

use super::build::Mesh;
use super::nearest::{nearest_of, side};
use super::triangle::nearest;
use crate::Vector;
use crate::geometry::rigid::{Rotation, Vector3};
use crate::geometry::solid::Nearest;
pub use serialisation::GridBytesError;
use serialisation::fingerprint;
use spline::{through, weights};

/// Distance between the mesh and the border of the grid, in spacings.
const MARGIN: f64 = 4.0;
/// Width of the border without an interpolant, in spacings: a spline needs a node on both sides of a cell.
const RIM: f64 = 1.0;
/// Distance of a cell's first node from which points in the cell are apart from the surface, in spacings.
const FAR: f64 = 4.0;
/// Largest excess of the coefficient of a cell's first node over the distance of a point in the cell, in spacings:
/// the cell diagonal, the overshoot of the spline, and the deviation of its coefficients from the distances.
const LESS: f64 = 3.0;
/// Gradient length below which two parts of the surface are equally near and the normal is arbitrary.
const NO_GRADIENT: f64 = 1e-6;

/// A grid of signed distances, in the axes of its mesh.
///
/// Points can touch it: see [`Mesh::with_grid`].
#[derive(Clone, PartialEq)]
pub struct DistanceGrid {
    nodes: Arc<Nodes>,
    /// Origin and orientation of the node axes, in the axes of the mesh.
    origin: Vector3,
    axes: Rotation,
}

#[derive(PartialEq)]
struct Nodes {
    /// Fingerprint of the source data: see [`fingerprint`].
    made_from: u64,
    spacing: f64,
    /// Position of the first node `[m]`.
    least: Vector3,
    counts: [usize; 3],
    /// Coefficients of the B-splines `[m]`, x fastest.
    coefficients: Vec<f32>,
    error: GridError,
}

/// Distance between the surface of a grid and that of its mesh, over all corners and centroids of triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct GridError {
    /// Largest distance `[m]`.
    pub largest: f64,
    /// Root mean square `[m]`.
    pub root_mean_square: f64,
}

/// Reason for rejecting a distance grid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InvalidGrid {
    /// The mesh has no inside.
    #[error("the mesh has open edges, so there is no inside and no signed distance; close it")]
    Open,
    /// The spacing is not a positive length.
    #[error("the spacing is {0} m, and has to be above 0 m")]
    Spacing(f64),
    /// The spacing is too large for the mesh.
    #[error(
        "the spacing is {spacing} m, and the shortest side of the mesh is {side} m: it has to be four spacings or more"
    )]
    Coarse {
        /// Spacing `[m]`.
        spacing: f64,
        /// Shortest side of the mesh's axis-aligned bounding box `[m]`.
        side: f64,
    },
    /// The grid would need too much memory.
    #[error(
        "a spacing of {spacing} m gives {nodes:.3e} nodes, and at most {most} are allowed; the least spacing for this \
         mesh is about {least:.3e} m", most = DistanceGrid::MAX_NODES
    )]
    Fine {
        /// Spacing `[m]`.
        spacing: f64,
        /// Number of nodes required.
        nodes: f64,
        /// Approximate smallest allowed spacing `[m]`.
        least: f64,
    },
    /// The grid belongs to another mesh or spacing.
    #[error("the distance grid was made from another mesh")]
    OfAnother,
}

impl std::fmt::Debug for DistanceGrid {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("DistanceGrid")
            .field("spacing", &self.nodes.spacing)
            .field("counts", &self.nodes.counts)
            .field("error", &self.nodes.error)
            .finish_non_exhaustive()
    }
}

impl DistanceGrid {
    /// Maximum number of nodes of a grid: 32 MiB.
    pub const MAX_NODES: usize = 8 << 20;

    /// Computes the distances from a closed mesh at nodes with a `spacing` `[m]`. Takes about a microsecond per node.
    ///
    /// # Errors
    /// The mesh is open, or the spacing is not a positive length or does not fit the mesh.
    pub fn new(mesh: &Mesh, spacing: f64) -> Result<Self, InvalidGrid> {
        let (least, counts) = laid_out(mesh, spacing)?;
        let mut coefficients = distances(mesh, &least, counts, spacing);
        through(&mut coefficients, counts);
        #[expect(
            clippy::cast_possible_truncation,
            reason = "near the surface, seven digits of a few spacings are far below what a spacing rounds off"
        )]
        let coefficients = coefficients.iter().map(|&of| of as f32).collect();
        let nothing = GridError {
            largest: 0.0,
            root_mean_square: 0.0,
        };
        let mut nodes = Nodes {
            made_from: fingerprint(mesh, spacing),
            spacing,
            least,
            counts,
            coefficients,
            error: nothing,
        };
        nodes.error = nodes.error_against(mesh);
        Ok(Self::in_its_own_axes(nodes))
    }

    fn in_its_own_axes(nodes: Nodes) -> Self {
        Self {
            nodes: Arc::new(nodes),
            origin: Vector3::zeros(),
            axes: Rotation::identity(),
        }
    }

    /// Returns the distance between nodes `[m]`.
    #[must_use]
    pub fn spacing(&self) -> f64 {
        self.nodes.spacing
    }

    /// Returns the number of nodes along each axis.
    #[must_use]
    pub fn counts(&self) -> [usize; 3] {
        self.nodes.counts
    }

    /// Returns the distance between its surface and that of the mesh.
    #[must_use]
    pub fn error(&self) -> GridError {
        self.nodes.error
    }

    /// Returns the position of the first node and the orientation of the node axes, in the axes of the mesh `[m]`.
    #[must_use]
    pub fn placed(&self) -> (Vector, crate::Quaternion) {
        let first = self.origin + self.axes * self.nodes.least;
        let [x, y, z, w]: [f64; 4] = self.axes.coords.into();
        (first.into(), [w, x, y, z])
    }

    /// Returns the coefficients of the cubic B-splines, one per node, x fastest `[m]`. Along each axis, the value at
    /// a node is one sixth of both neighbours' coefficients plus four sixths of its own.
    #[must_use]
    pub fn coefficients(&self) -> &[f32] {
        &self.nodes.coefficients
    }

    /// Returns the signed distance of `place` in the mesh's axes, negative inside, and its gradient; `None` outside
    /// the grid `[m]`.
    #[must_use]
    pub fn distance(&self, place: Vector) -> Option<(f64, Vector)> {
        let own = self.own(&place.into());
        let (distance, gradient) = self.nodes.at(&own)?;
        Some((distance, (self.axes * gradient).into()))
    }

    fn own(&self, place: &Vector3) -> Vector3 {
        self.axes.inverse_transform_vector(&(place - self.origin))
    }

    /// Returns the surface point nearest to `place`, in the mesh's axes. Outside the grid the distance is a lower
    /// bound.
    pub(crate) fn nearest(&self, place: &Vector3) -> Nearest {
        self.nearest_at(&self.own(place))
    }

    /// Returns the surface point nearest to a position in the node axes.
    fn nearest_at(&self, own: &Vector3) -> Nearest {
        let nearest = match self.nodes.at(own) {
            Some((distance, gradient)) => {
                let slope = gradient.norm();
                Nearest {
                    distance,
                    normal: if slope > NO_GRADIENT {
                        gradient / slope
                    } else {
                        Vector3::x()
                    },
                    slope,
                }
            }
            None => self.nodes.beyond_the_grid(own),
        };
        Nearest {
            normal: self.axes * nearest.normal,
            ..nearest
        }
    }

    /// Returns the nearest surface point, or a lower bound of the distance if the surface is certainly beyond `reach`
    /// `[m]`.
    pub(crate) fn nearest_within(&self, place: &Vector3, reach: f64) -> Nearest {
        let own = self.own(place);
        let least = self.nodes.at_least(&own);
        if least > reach {
            Nearest::exact(least, Vector3::x())
        } else {
            self.nearest_at(&own)
        }
    }

    /// Returns the grid in axes with origin `centre` `[m]` and orientation `orientation`.
    pub(super) fn seen_from(&self, centre: &Vector3, orientation: &Rotation) -> Self {
        Self {
            nodes: self.nodes.clone(),
            origin: orientation.inverse_transform_vector(&(self.origin - centre)),
            axes: orientation.inverse() * self.axes,
        }
    }

    /// Returns whether the grid was made from this mesh, as it was given.
    pub(super) fn is_of(&self, mesh: &Mesh) -> bool {
        self.nodes.made_from == fingerprint(mesh, self.nodes.spacing)
    }
}

/// Returns the position of the first node, and the number of nodes along each axis.
fn laid_out(mesh: &Mesh, spacing: f64) -> Result<(Vector3, [usize; 3]), InvalidGrid> {
    if !mesh.is_closed() {
        return Err(InvalidGrid::Open);
    }
    if !(spacing > 0.0 && spacing.is_finite()) {
        return Err(InvalidGrid::Spacing(spacing));
    }
    let (low, high) = mesh.bounds();
    let size = high - low;
    let side = size.min();
    if side < 4.0 * spacing {
        return Err(InvalidGrid::Coarse { spacing, side });
    }
    let along = size.map(|length| (length / spacing).ceil() + 2.0 * MARGIN + 1.0);
    let nodes = along.product();
    if nodes > DistanceGrid::MAX_NODES as f64 {
        let least = spacing * (nodes / DistanceGrid::MAX_NODES as f64).cbrt();
        return Err(InvalidGrid::Fine {
            spacing,
            nodes,
            least: 1.05 * least,
        });
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "their product is below the largest number of nodes"
    )]
    let counts = [along.x, along.y, along.z].map(|count| count as usize);
    let covered = along.map(|count| (count - 1.0) * spacing);
    Ok(((low + high - covered) * 0.5, counts))
}

/// Computes the distance at each node.
fn distances(mesh: &Mesh, least: &Vector3, counts: [usize; 3], spacing: f64) -> Vec<f64> {
    let [nx, ny, nz] = counts;
    let mut distances = Vec::with_capacity(nx * ny * nz);
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                let place = least + Vector3::new(x as f64, y as f64, z as f64) * spacing;
                distances.push(mesh.signed_distance(&place));
            }
        }
    }
    distances
}

impl Mesh {
    /// Returns the distance of a position from the surface of a closed mesh, negative inside `[m]`.
    fn signed_distance(&self, place: &Vector3) -> f64 {
        let Some((distance, triangle)) = nearest_of(self, place) else {
            return f64::INFINITY;
        };
        let (on_surface, region) = nearest(self.corners(triangle), place);
        let is_outside =
            side(self, triangle, region, &(place - on_surface)).is_some_and(|side| side > 0.0);
        if is_outside { distance } else { -distance }
    }

    /// Returns the axis-aligned bounding box `[m]`.
    fn bounds(&self) -> (Vector3, Vector3) {
        let places = self.places();
        let all = |pick: fn(&Vector3, &Vector3) -> Vector3| {
            let first = places.first().copied().unwrap_or_else(Vector3::zeros);
            places.iter().fold(first, |one, other| pick(&one, other))
        };
        (all(Vector3::inf), all(Vector3::sup))
    }
}

impl Nodes {
    /// Returns the position relative to the first node, in spacings.
    fn steps_to(&self, own: &Vector3) -> Vector3 {
        (own - self.least) / self.spacing
    }

    /// Returns the cell that contains a position, if it has an interpolant.
    fn cell(&self, steps: &Vector3) -> Option<[usize; 3]> {
        let mut cell = [0; 3];
        for (axis, cell) in cell.iter_mut().enumerate() {
            let most = self.counts[axis] as f64 - 1.0 - RIM;
            if !(steps[axis] >= RIM && steps[axis] <= most) {
                return None;
            }
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "it lies between two numbers of nodes"
            )]
            let before = steps[axis] as usize;
            // The end of the range belongs to the last cell.
            *cell = before.min(self.counts[axis] - 3);
        }
        Some(cell)
    }

    fn number(&self, [x, y, z]: [usize; 3]) -> usize {
        x + self.counts[0] * (y + self.counts[1] * z)
    }

    /// Returns value and gradient of the spline.
    fn at(&self, own: &Vector3) -> Option<(f64, Vector3)> {
        let steps = self.steps_to(own);
        let cell = self.cell(&steps)?;
        let [(wx, sx), (wy, sy), (wz, sz)] =
            [0, 1, 2].map(|axis| weights(steps[axis] - cell[axis] as f64));
        let first = cell.map(|node| node - 1);
        let (mut value, mut slopes) = (0.0, Vector3::zeros());
        for z in 0..4 {
            let (mut plane, mut plane_x, mut plane_y) = (0.0, 0.0, 0.0);
            for y in 0..4 {
                let from = self.number([first[0], first[1] + y, first[2] + z]);
                let row = &self.coefficients[from..from + 4];
                let (mut along, mut along_x) = (0.0, 0.0);
                for x in 0..4 {
                    let of = f64::from(row[x]);
                    along += wx[x] * of;
                    along_x += sx[x] * of;
                }
                plane += wy[y] * along;
                plane_x += wy[y] * along_x;
                plane_y += sy[y] * along;
            }
            value += wz[z] * plane;
            slopes += Vector3::new(wz[z] * plane_x, wz[z] * plane_y, sz[z] * plane);
        }
        Some((value, slopes / self.spacing))
    }

    /// Returns a lower bound of the distance, negative if unknown `[m]`.
    fn at_least(&self, own: &Vector3) -> f64 {
        let steps = self.steps_to(own);
        match self.cell(&steps) {
            None => self.beyond_the_grid(own).distance,
            Some(cell) => {
                let at_node = f64::from(self.coefficients[self.number(cell)]);
                if at_node > FAR * self.spacing {
                    at_node - LESS * self.spacing
                } else {
                    f64::NEG_INFINITY
                }
            }
        }
    }

    /// Returns a lower bound of the distance outside the grid: the distance to the box with an interpolant, plus the
    /// margin between that box and the mesh.
    fn beyond_the_grid(&self, own: &Vector3) -> Nearest {
        let rim = RIM * self.spacing;
        let (mut off, mut far) = (Vector3::zeros(), f64::NEG_INFINITY);
        for axis in 0..3 {
            let low = self.least[axis] + rim;
            let high = self.least[axis] + (self.counts[axis] as f64 - 1.0) * self.spacing - rim;
            off[axis] = own[axis] - own[axis].clamp(low, high.max(low));
            far = far.max(off[axis].abs());
        }
        let length = off.norm();
        if length.is_nan() || length == 0.0 {
            return Nearest::far();
        }
        Nearest {
            distance: length + (MARGIN - RIM) * self.spacing,
            normal: off / length,
            slope: 1.0,
        }
    }

    fn error_against(&self, mesh: &Mesh) -> GridError {
        let middles = (0..super::tree::size(mesh.faces.len())).map(|triangle| {
            let [a, b, c] = mesh.corners(triangle);
            (a + b + c) / 3.0
        });
        let places = mesh.places().iter().copied().chain(middles);
        let (mut largest, mut sum, mut count) = (0.0_f64, 0.0, 0.0);
        for place in places {
            let off = self.at(&place).map_or(f64::INFINITY, |(off, _)| off.abs());
            largest = largest.max(off);
            sum += off * off;
            count += 1.0;
        }
        GridError {
            largest,
            root_mean_square: (sum / count).sqrt(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a block of 20 x 14 x 12 mm with a groove of 6 mm along x in its top: a solid with concave edges.
    fn grooved() -> Mesh {
        let outline = [
            [0.0, 0.0],
            [14.0, 0.0],
            [14.0, 12.0],
            [10.0, 12.0],
            [10.0, 6.0],
            [4.0, 6.0],
            [4.0, 12.0],
            [0.0, 12.0],
        ];
        let count = u32::try_from(outline.len()).unwrap();
        let at = |x: f64| outline.map(|[y, z]| [1e-3 * x, 1e-3 * y, 1e-3 * z]);
        let vertices: Vec<Vector> = at(0.0).into_iter().chain(at(20.0)).collect();
        // The outline as three rectangles, by its corners.
        let parts = [[0, 1, 4, 5], [1, 2, 3, 4], [0, 5, 6, 7]];
        let mut faces = Vec::new();
        for [a, b, c, d] in parts {
            faces.extend([[a, c, b], [a, d, c]]);
            let [a, b, c, d] = [a, b, c, d].map(|corner| corner + count);
            faces.extend([[a, b, c], [a, c, d]]);
        }
        for corner in 0..count {
            let next = (corner + 1) % count;
            faces.push([corner, next, next + count]);
            faces.push([corner, next + count, corner + count]);
        }
        Mesh::new(&vertices, &faces).unwrap()
    }

    fn spread(number: u32) -> Vector3 {
        let part = |prime: f64| (f64::from(number) * prime).fract();
        Vector3::new(part(0.754_877), part(0.569_840), part(0.430_160))
    }

    /// Positions in and around the block.
    fn places() -> impl Iterator<Item = Vector3> {
        (1..3000).map(|number| {
            let low = Vector3::repeat(-1.2e-3);
            low + spread(number).component_mul(&Vector3::new(22.4e-3, 16.4e-3, 14.4e-3))
        })
    }

    #[test]
    fn the_spline_passes_through_the_distances_at_the_nodes() {
        let mesh = grooved();
        let spacing = 0.8e-3;
        let grid = DistanceGrid::new(&mesh, spacing).unwrap();
        let nodes = &*grid.nodes;
        let mut checked = 0;
        for z in 2..nodes.counts[2] - 2 {
            for y in 2..nodes.counts[1] - 2 {
                for x in 2..nodes.counts[0] - 2 {
                    let place = nodes.least + Vector3::new(x as f64, y as f64, z as f64) * spacing;
                    let (value, _) = grid.distance(place.into()).unwrap();
                    assert!((value - mesh.signed_distance(&place)).abs() < 1e-9);
                    checked += 1;
                }
            }
        }
        assert!(checked > 5000, "{checked}");
    }

    #[test]
    fn in_turned_axes_the_distances_are_the_same() {
        let grid = DistanceGrid::new(&grooved(), 0.8e-3).unwrap();
        let centre = Vector3::new(3e-3, -2e-3, 5e-3);
        let turned = Rotation::from_scaled_axis(Vector3::new(0.4, -1.1, 0.7));
        let seen = grid.seen_from(&centre, &turned);
        for place in places() {
            let there = turned.inverse() * (place - centre);
            let (one, of_one) = grid.distance(place.into()).unwrap();
            let (other, of_other) = seen.distance(there.into()).unwrap();
            assert!((one - other).abs() < 1e-15);
            let back = turned * Vector3::from(of_other);
            assert!((back - Vector3::from(of_one)).norm() < 1e-12);
        }
    }

    /// Points classified as far are far: inside the block, near it and outside the grid.
    #[test]
    fn nothing_within_reach_is_called_far() {
        let mesh = grooved();
        let grid = DistanceGrid::new(&mesh, 0.6e-3).unwrap();
        let mut far = 0;
        for number in 1..4000 {
            let place = (spread(number) - Vector3::repeat(0.5)) * 60e-3 + Vector3::repeat(7e-3);
            let exact = mesh.signed_distance(&place);
            for reach in [0.0, 0.4e-3, 3e-3, 10e-3] {
                let found = grid.nearest_within(&place, reach);
                if found.distance > reach {
                    assert!(exact > reach - 1e-4, "{place:?} {exact} {reach}");
                }
                if found != grid.nearest(&place) {
                    let least = found.distance;
                    assert!(exact > least && least > reach, "{place:?} {exact} {least}");
                    far += 1;
                }
                assert!((found.normal.norm() - 1.0).abs() < 1e-9);
            }
            let outside = grid.distance(place.into()).is_none();
            assert!(!outside || grid.nearest(&place).distance <= exact + 1e-12);
        }
        assert!(far > 3000, "{far}");
        let nowhere = grid.nearest(&Vector3::repeat(f64::NAN));
        assert_eq!(nowhere.distance, f64::INFINITY);
    }

    #[test]
    fn the_finest_spacing_that_a_refusal_names_fits() {
        let mesh = grooved();
        let Err(InvalidGrid::Fine { least, .. }) = DistanceGrid::new(&mesh, 1e-5) else {
            panic!("too fine");
        };
        assert!(laid_out(&mesh, least).is_ok(), "{least}");
    }
}
