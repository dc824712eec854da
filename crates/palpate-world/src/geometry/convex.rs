//! Convex hull of points by the Quickhull algorithm (Barber, Dobkin and Huhdanpaa, 1996).
//!
//! The point furthest outside is added next, so a truncated hull is close to the full one. An exact predicate
//! (Shewchuk, 1997) decides on which side of a facet a point is. The facets therefore form a closed convex surface
//! despite rounding errors of the points. Facets that are coplanar up to rounding form one face ([`polygons`]).

use std::collections::HashSet;

use robust::{Coord3D, orient3d};

use crate::geometry::coplanar::polygons;
use crate::geometry::rigid::Vector3;

/// Distance from a plane, relative to the size of the point set, below which points are in the plane: numbers in
/// files have six or seven digits.
const FLAT: f64 = 1e-6;
/// Multiples of that distance for merging facets into a face. The first that gives a closed solid is used.
const ONE_FACE: [f64; 4] = [6.0, 2.0, 20.0, 0.0];
/// Ratio of twice a facet's area to the square of its longest side below which its normal is unreliable.
const SLIVER: f64 = 1e-7;

/// A flat face: its plane, and its corners in counter-clockwise order seen from outside.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Polygon {
    /// Indices of its corners among those of the hull.
    pub corners: Vec<usize>,
    /// Outward unit normal.
    pub normal: Vector3,
    /// normal . x for its points `[m]`.
    pub offset: f64,
}

/// Reason why there is no hull.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoHull {
    /// All points are nearly coplanar.
    Flat,
    /// The hull would have too many corners.
    TooMany,
    /// The construction gave no closed surface.
    Broken,
}

/// A triangle of the hull under construction, and the points outside its plane.
pub(crate) struct Facet {
    pub corners: [usize; 3],
    pub normal: Vector3,
    /// Twice the area `[m^2]`.
    pub area: f64,
    offset: f64,
    is_sliver: bool,
    outside: Vec<usize>,
    /// Distance and index of the furthest outside point.
    furthest: Option<(f64, usize)>,
}

impl Facet {
    fn new(points: &[Vector3], corners: [usize; 3]) -> Self {
        let [a, b, c] = corners.map(|corner| points[corner]);
        let cross = (b - a).cross(&(c - a));
        let sides = [b - a, c - b, a - c].map(|side| side.norm_squared());
        let area = cross.norm();
        // For a facet so thin that the product vanishes the direction is arbitrary: the exact predicate decides.
        let normal = cross.try_normalize(0.0).unwrap_or_else(Vector3::x);
        Self {
            corners,
            offset: normal.dot(&a),
            normal,
            area,
            is_sliver: area <= SLIVER * sides.into_iter().fold(0.0, f64::max),
            outside: Vec::new(),
            furthest: None,
        }
    }

    /// Returns six times the volume of the facet and a point in front of it, negative behind it; the sign is exact.
    fn volume_before(&self, points: &[Vector3], point: &Vector3) -> f64 {
        let coord = |place: &Vector3| Coord3D {
            x: place.x,
            y: place.y,
            z: place.z,
        };
        let [a, b, c] = self.corners.map(|corner| coord(&points[corner]));
        -orient3d(a, b, c, coord(point))
    }

    /// Returns the distance of a point in front of the plane; for a sliver a lower bound `[m]`.
    fn height(&self, points: &[Vector3], point: &Vector3) -> f64 {
        if self.is_sliver {
            let [a, b, c] = self.corners.map(|corner| points[corner]);
            let rounded = 4.0 * f64::EPSILON * (b - a).norm() * (c - a).norm();
            let volume = self.volume_before(points, point);
            return if volume > 0.0 {
                volume / (self.area + rounded)
            } else {
                0.0
            };
        }
        self.normal.dot(point) - self.offset
    }

    fn take(&mut self, number: usize, height: f64) {
        self.outside.push(number);
        if self.furthest.is_none_or(|(other, _)| height > other) {
            self.furthest = Some((height, number));
        }
    }

    pub fn edges(&self) -> [(usize, usize); 3] {
        let [a, b, c] = self.corners;
        [(a, b), (b, c), (c, a)]
    }
}

/// Computes corners and faces of a convex solid whose corners are some of the `points`.
///
/// No point is further outside than `within` `[m]` or the rounding error of the points.
///
/// # Errors
/// The points are coplanar, the hull would have more than `most` corners, or the construction fails.
pub(crate) fn hull(
    points: &[Vector3],
    within: f64,
    most: usize,
) -> Result<(Vec<Vector3>, Vec<Polygon>), NoHull> {
    // A point may turn out not to be a corner; there are few of those.
    let (corners, faces, is_whole) = built(points, within, 2 * most + 8)?;
    if is_whole && corners.len() <= most {
        Ok((corners, faces))
    } else {
        Err(NoHull::TooMany)
    }
}

/// Computes the solid of the `most` furthest protruding corners.
///
/// # Errors
/// The points are coplanar.
pub(crate) fn coarse_hull(
    points: &[Vector3],
    most: usize,
) -> Result<(Vec<Vector3>, Vec<Polygon>), NoHull> {
    let (corners, faces, _) = built(points, 0.0, most)?;
    Ok((corners, faces))
}

/// Computes the hull as triangles, which are exactly convex; some may be thin.
///
/// # Errors
/// The errors of [`hull`].
pub(crate) fn triangles(
    points: &[Vector3],
    within: f64,
    most: usize,
) -> Result<(Vec<Vector3>, Vec<Polygon>), NoHull> {
    let wrapped = Wrapped::around(points, within, 2 * most + 8)?;
    let faces = wrapped.facets.iter().map(|facet| Polygon {
        corners: facet.corners.into(),
        normal: facet.normal,
        offset: facet.offset,
    });
    let (corners, faces) = renumbered(points, faces.collect());
    if wrapped.is_whole && corners.len() <= most {
        Ok((corners, faces))
    } else {
        Err(NoHull::TooMany)
    }
}

/// Returns corners and faces, and whether `most` points were sufficient.
fn built(
    points: &[Vector3],
    within: f64,
    most: usize,
) -> Result<(Vec<Vector3>, Vec<Polygon>, bool), NoHull> {
    let wrapped = Wrapped::around(points, within, most)?;
    let faces = ONE_FACE.iter().find_map(|times| {
        let tolerance = times * wrapped.flat;
        let faces = polygons(&wrapped.facets, points, tolerance)?;
        is_solid(points, &faces, tolerance + wrapped.flat).then_some(faces)
    });
    let (corners, faces) = renumbered(points, faces.ok_or(NoHull::Broken)?);
    Ok((corners, faces, wrapped.is_whole))
}

/// A closed convex surface of facets around points.
struct Wrapped {
    facets: Vec<Facet>,
    /// Whether no point is further outside than allowed.
    is_whole: bool,
    /// Distance below which points lie in a plane `[m]`.
    flat: f64,
}

impl Wrapped {
    /// Wraps the points with at most `most` corners. Points outside by at most `within` `[m]` may be omitted.
    fn around(points: &[Vector3], within: f64, most: usize) -> Result<Self, NoHull> {
        let first = points.first().ok_or(NoHull::Flat)?;
        let size = points.iter().map(|point| (point - first).norm());
        let flat = FLAT * size.fold(0.0, f64::max);
        let within = within.max(flat);
        let mut facets = start(points, flat).ok_or(NoHull::Flat)?;
        for number in 0..points.len() {
            give(points, number, &mut facets, within);
        }
        let mut count = 4;
        let mut is_whole = true;
        loop {
            let furthest = facets.iter().filter_map(|facet| facet.furthest);
            let Some((_, next)) = furthest.max_by(|a, b| a.0.total_cmp(&b.0)) else {
                break;
            };
            if count == most {
                is_whole = false;
                break;
            }
            count += 1;
            let is_visible = |facet: &Facet| facet.volume_before(points, &points[next]) > 0.0;
            let (visible, mut kept): (Vec<_>, Vec<_>) = facets.into_iter().partition(is_visible);
            let edges: HashSet<_> = visible.iter().flat_map(Facet::edges).collect();
            let mut fresh = Vec::new();
            // Iterate in facet order for determinism; a set is unordered.
            for (from, to) in visible.iter().flat_map(Facet::edges) {
                if !edges.contains(&(to, from)) {
                    fresh.push(Facet::new(points, [from, to, next]));
                }
            }
            for number in visible.into_iter().flat_map(|facet| facet.outside) {
                // It may be further outside a kept facet than outside the adjacent new one.
                if number != next && !give(points, number, &mut fresh, within) {
                    give(points, number, &mut kept, within);
                }
            }
            kept.append(&mut fresh);
            facets = kept;
        }
        Ok(Self {
            facets,
            is_whole,
            flat,
        })
    }
}

/// Returns whether faces form a closed surface and no corner is in front of a face by more than a tolerance `[m]`.
fn is_solid(points: &[Vector3], faces: &[Polygon], tolerance: f64) -> bool {
    let mut corners: Vec<usize> = faces.iter().flat_map(|face| face.corners.clone()).collect();
    let sides = corners.len();
    corners.sort_unstable();
    corners.dedup();
    // Euler's formula: a closed surface without holes has edges = corners + faces - 2.
    let closes = corners.len() + faces.len() == sides / 2 + 2 && sides.is_multiple_of(2);
    let is_behind = |face: &Polygon| {
        let mut heights = corners
            .iter()
            .map(|&corner| face.normal.dot(&points[corner]));
        heights.all(|height| height - face.offset <= 4.0 * tolerance)
    };
    closes && faces.iter().all(is_behind)
}

/// Returns a tetrahedron of mutually distant points.
fn start(points: &[Vector3], flat: f64) -> Option<Vec<Facet>> {
    let numbers = || 0..points.len();
    let first = numbers().min_by(|&a, &b| by_axes(&points[a], &points[b]))?;
    let furthest = |by: &dyn Fn(&Vector3) -> f64| {
        let found = numbers().max_by(|&a, &b| by(&points[a]).total_cmp(&by(&points[b])))?;
        (by(&points[found]) > flat).then_some(found)
    };
    let from = points[first];
    let second = furthest(&|point| (point - from).norm())?;
    let along = (points[second] - from).normalize();
    let third = furthest(&|point| (point - from).cross(&along).norm())?;
    let across = along.cross(&(points[third] - from)).normalize();
    let fourth = furthest(&|point| across.dot(&(point - from)).abs())?;
    let [a, b] = if across.dot(&(points[fourth] - from)) > 0.0 {
        [third, second]
    } else {
        [second, third]
    };
    // The fourth point is behind the first three.
    let facets = [
        [first, a, b],
        [a, first, fourth],
        [b, a, fourth],
        [first, b, fourth],
    ]
    .map(|corners| Facet::new(points, corners));
    let is_closed = facets[0].volume_before(points, &points[fourth]) < 0.0;
    is_closed.then(|| facets.into())
}

fn by_axes(a: &Vector3, b: &Vector3) -> std::cmp::Ordering {
    let mut axes = a.iter().zip(b.iter());
    axes.find_map(|(a, b)| Some(a.total_cmp(b)).filter(|order| order.is_ne()))
        .unwrap_or(std::cmp::Ordering::Equal)
}

/// Assigns a point to the facet from which it is furthest outside, if by more than `within`. Returns whether there is
/// one.
fn give(points: &[Vector3], number: usize, facets: &mut [Facet], within: f64) -> bool {
    let point = &points[number];
    let highest = facets
        .iter_mut()
        .map(|facet| (facet.height(points, point), facet))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    if let Some((height, facet)) = highest
        && height > within
        && facet.volume_before(points, point) > 0.0
    {
        facet.take(number, height);
        return true;
    }
    false
}

/// Keeps only the points that are corners, and renumbers the faces.
fn renumbered(points: &[Vector3], mut faces: Vec<Polygon>) -> (Vec<Vector3>, Vec<Polygon>) {
    let mut used: Vec<usize> = faces
        .iter()
        .flat_map(|face| face.corners.iter().copied())
        .collect();
    used.sort_unstable();
    used.dedup();
    for corner in faces.iter_mut().flat_map(|face| &mut face.corners) {
        *corner = used.partition_point(|&other| other < *corner);
    }
    (
        used.into_iter().map(|number| points[number]).collect(),
        faces,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(number: usize, prime: f64) -> f64 {
        2.0 * (number as f64 * prime).fract() - 1.0
    }

    /// Returns points in a unit cube, some of them repeated, on a grid or not.
    fn clouds() -> Vec<Vec<Vector3>> {
        let grid = |n: usize| (0..n * n * n).map(move |k| [k % n, k / n % n, k / n / n]);
        let on_grid = grid(5).map(|[x, y, z]| Vector3::new(x as f64, y as f64, z as f64) * 0.37);
        let turned =
            crate::geometry::rigid::Rotation::from_scaled_axis(Vector3::new(0.3, -0.8, 0.5));
        let cubes: Vec<Vector3> = on_grid.collect();
        let random = |count: usize| {
            (1..=count)
                .map(|k| Vector3::new(part(k, 0.618_034), part(k, 0.414_214), part(k, 0.732_051)))
        };
        vec![
            cubes.iter().map(|point| turned * point).collect(),
            cubes,
            random(8).collect(),
            random(400).collect(),
            random(40).chain(random(40)).collect(),
        ]
    }

    #[test]
    fn a_hull_is_convex_closed_and_around_all_points() {
        for points in clouds() {
            let (corners, faces) = hull(&points, 0.0, 200).unwrap();
            for face in &faces {
                for corner in &corners {
                    assert!(face.normal.dot(corner) - face.offset < 1e-8);
                }
                for point in &points {
                    assert!(face.normal.dot(point) - face.offset < 1e-8);
                }
                for &corner in &face.corners {
                    assert!((face.normal.dot(&corners[corner]) - face.offset).abs() < 1e-8);
                }
            }
            // Every corner is an extreme point in some direction.
            for (number, corner) in corners.iter().enumerate() {
                let at = faces.iter().filter(|face| face.corners.contains(&number));
                let out: Vector3 = at.map(|face| face.normal).sum();
                let others = corners
                    .iter()
                    .enumerate()
                    .filter(|(other, _)| *other != number);
                for (_, other) in others {
                    assert!(out.dot(corner) > out.dot(other) + 1e-9, "{number}");
                }
            }
        }
    }

    #[test]
    fn a_grid_has_the_eight_corners_and_six_faces_of_its_cube() {
        for points in &clouds()[..2] {
            let (corners, faces) = hull(points, 0.0, 64).unwrap();
            assert_eq!((corners.len(), faces.len()), (8, 6));
            assert!(faces.iter().all(|face| face.corners.len() == 4));
        }
    }

    #[test]
    fn a_coarser_hull_has_fewer_corners_and_leaves_out_no_more_than_it_may() {
        let ball: Vec<Vector3> = (0..400)
            .map(|k| Vector3::new(part(k, 0.618_034), part(k, 0.414_214), part(k, 0.732_051)))
            .filter_map(|point| point.try_normalize(0.1))
            .collect();
        let mut last = usize::MAX;
        for within in [0.0, 0.01, 0.05, 0.2] {
            let (corners, faces) = hull(&ball, within, 1000).unwrap();
            assert!(corners.len() < last, "{} {last}", corners.len());
            last = corners.len();
            let outside = |point: &Vector3| {
                let heights = faces
                    .iter()
                    .map(|face| face.normal.dot(point) - face.offset);
                heights.fold(f64::NEG_INFINITY, f64::max)
            };
            let most = ball.iter().map(outside).fold(0.0, f64::max);
            // The ball has a diameter of 2; points within 6 FLAT of a face belong to it.
            assert!(most <= within + 2e-5, "{most} {within}");
        }
        assert!(last < 40, "{last}");
    }

    #[test]
    fn points_of_a_plane_and_too_many_corners_are_refused() {
        let flat: Vec<Vector3> = clouds()[2]
            .iter()
            .map(|point| Vector3::new(point.x, point.y, 0.3 * point.x - point.y))
            .collect();
        assert_eq!(hull(&flat, 0.0, 64).unwrap_err(), NoHull::Flat);
        assert_eq!(hull(&[Vector3::x(); 9], 0.0, 64).unwrap_err(), NoHull::Flat);
        let many = &clouds()[3];
        assert_eq!(hull(many, 0.0, 8).unwrap_err(), NoHull::TooMany);
    }
}
