//! The convex hull of points, by the Quickhull algorithm (Barber, Dobkin and Huhdanpaa, 1996).
//!
//! The point that is furthest outside of all is taken next, so that a hull that stops early is near to the whole one.
//! What comes out is checked: it is closed, and no point lies outside of it by more than was allowed.

use std::collections::{HashMap, HashSet};

use crate::rigid::Vector3;

/// Points nearer to a plane than this share of the size of all lie in it.
const FLAT: f64 = 1e-9;

/// A flat face: its corners, which run counter-clockwise when they are seen from outside, and its plane.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Polygon {
    /// Numbers of its corners among those of the hull.
    pub corners: Vec<usize>,
    /// Unit vector out of the solid.
    pub normal: Vector3,
    /// normal . x of its points `[m]`.
    pub offset: f64,
}

/// Why there is no hull.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoHull {
    /// All points lie in a plane.
    Flat,
    /// It would have more corners than asked for.
    TooMany,
    /// Round-off has broken it: the points nearly lie in a plane.
    Broken,
}

/// A triangle of the hull that is being built, and the points that lie outside of its plane.
struct Facet {
    corners: [usize; 3],
    normal: Vector3,
    offset: f64,
    outside: Vec<usize>,
    /// The furthest of them, and how far it is.
    furthest: Option<(f64, usize)>,
}

impl Facet {
    fn of(points: &[Vector3], corners: [usize; 3]) -> Option<Self> {
        let [a, b, c] = corners.map(|corner| points[corner]);
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0)?;
        Some(Self {
            corners,
            offset: normal.dot(&a),
            normal,
            outside: Vec::new(),
            furthest: None,
        })
    }

    fn height(&self, point: &Vector3) -> f64 {
        self.normal.dot(point) - self.offset
    }

    fn take(&mut self, number: usize, height: f64) {
        self.outside.push(number);
        if self.furthest.is_none_or(|(other, _)| height > other) {
            self.furthest = Some((height, number));
        }
    }

    fn edges(&self) -> [(usize, usize); 3] {
        let [a, b, c] = self.corners;
        [(a, b), (b, c), (c, a)]
    }
}

/// Corners and faces of the least convex solid from which no point is further outside than `within` `[m]`, with at most
/// `most` corners.
pub(crate) fn hull(
    points: &[Vector3],
    within: f64,
    most: usize,
) -> Result<(Vec<Vector3>, Vec<Polygon>), NoHull> {
    let first = points.first().ok_or(NoHull::Flat)?;
    let size = points.iter().map(|point| (point - first).norm());
    let flat = FLAT * size.fold(0.0, f64::max);
    let within = within.max(flat);
    let mut facets = start(points, flat).ok_or(NoHull::Flat)?;
    for number in 0..points.len() {
        give(points, number, &mut facets, within);
    }
    let mut count = 4;
    loop {
        let furthest = facets.iter().filter_map(|facet| facet.furthest);
        let Some((_, next)) = furthest.max_by(|a, b| a.0.total_cmp(&b.0)) else {
            break;
        };
        count += 1;
        // A point may turn out not to be a corner; there are few of those.
        if count > 2 * most + 8 {
            return Err(NoHull::TooMany);
        }
        let is_visible = |facet: &Facet| facet.height(&points[next]) > flat;
        let (visible, mut kept): (Vec<_>, Vec<_>) = facets.into_iter().partition(is_visible);
        let edges: HashSet<_> = visible.iter().flat_map(Facet::edges).collect();
        let mut fresh = Vec::new();
        // In the order of the facets: a set has none.
        for (from, to) in visible.iter().flat_map(Facet::edges) {
            if !edges.contains(&(to, from)) {
                fresh.push(Facet::of(points, [from, to, next]).ok_or(NoHull::Broken)?);
            }
        }
        for number in visible.into_iter().flat_map(|facet| facet.outside) {
            if number != next {
                give(points, number, &mut fresh, within);
            }
        }
        kept.append(&mut fresh);
        facets = kept;
    }
    let faces = polygons(&facets, points, flat).ok_or(NoHull::Broken)?;
    let (corners, faces) = renumbered(points, faces);
    if corners.len() > most {
        return Err(NoHull::TooMany);
    }
    let is_inside = |point: &Vector3| {
        let mut faces = faces.iter();
        faces.all(|face| face.normal.dot(point) - face.offset <= within + 8.0 * flat)
    };
    // Euler's formula: a closed surface without holes has as many edges as corners and faces less two.
    let edges: usize = faces.iter().map(|face| face.corners.len()).sum();
    let is_closed = corners.len() + faces.len() == edges / 2 + 2 && edges.is_multiple_of(2);
    if is_closed && points.iter().all(is_inside) {
        Ok((corners, faces))
    } else {
        Err(NoHull::Broken)
    }
}

/// A tetrahedron of points that are far from each other.
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
    // The fourth is on the back of the first three.
    [
        [first, a, b],
        [a, first, fourth],
        [b, a, fourth],
        [first, b, fourth],
    ]
    .into_iter()
    .map(|corners| Facet::of(points, corners))
    .collect()
}

fn by_axes(a: &Vector3, b: &Vector3) -> std::cmp::Ordering {
    let mut axes = a.iter().zip(b.iter());
    axes.find_map(|(a, b)| Some(a.total_cmp(b)).filter(|order| order.is_ne()))
        .unwrap_or(std::cmp::Ordering::Equal)
}

/// Gives a point to the facet from which it is furthest outside, if it is so by more than `within`.
fn give(points: &[Vector3], number: usize, facets: &mut [Facet], within: f64) {
    let height = |facet: &Facet| facet.height(&points[number]);
    let highest = facets
        .iter_mut()
        .map(|facet| (height(facet), facet))
        .max_by(|a, b| a.0.total_cmp(&b.0));
    if let Some((height, facet)) = highest
        && height > within
    {
        facet.take(number, height);
    }
}

/// Facets of one plane put together, their corners in order; `None` where that is no closed surface.
fn polygons(facets: &[Facet], points: &[Vector3], flat: f64) -> Option<Vec<Polygon>> {
    let mut owner = HashMap::new();
    for (number, facet) in facets.iter().enumerate() {
        for edge in facet.edges() {
            if owner.insert(edge, number).is_some() {
                return None;
            }
        }
    }
    let mut group = vec![usize::MAX; facets.len()];
    let mut groups = 0;
    for first in 0..facets.len() {
        if group[first] != usize::MAX {
            continue;
        }
        let plane = &facets[first];
        let mut waiting = vec![first];
        group[first] = groups;
        while let Some(facet) = waiting.pop() {
            for (from, to) in facets[facet].edges() {
                let other = *owner.get(&(to, from))?;
                let in_plane = |&corner: &usize| plane.height(&points[corner]).abs() <= 4.0 * flat;
                if group[other] == usize::MAX && facets[other].corners.iter().all(in_plane) {
                    group[other] = groups;
                    waiting.push(other);
                }
            }
        }
        groups += 1;
    }
    // How many groups there are at each corner: one with two of them lies within an edge.
    let mut at: HashMap<usize, Vec<usize>> = HashMap::new();
    for (facet, group) in facets.iter().zip(&group) {
        for corner in facet.corners {
            let groups = at.entry(corner).or_default();
            if !groups.contains(group) {
                groups.push(*group);
            }
        }
    }
    (0..groups)
        .map(|number| {
            let of_group = || (0..facets.len()).filter(|&facet| group[facet] == number);
            let mut next: HashMap<usize, usize> = HashMap::new();
            for (from, to) in of_group().flat_map(|facet| facets[facet].edges()) {
                if group[*owner.get(&(to, from))?] != number && next.insert(from, to).is_some() {
                    return None;
                }
            }
            let first = *next.keys().min()?;
            let mut corners = vec![first];
            let mut here = *next.get(&first)?;
            while here != first {
                corners.push(here);
                here = *next.get(&here)?;
                if corners.len() > next.len() {
                    return None;
                }
            }
            if corners.len() != next.len() {
                return None;
            }
            corners.retain(|corner| at[corner].len() > 2);
            let middle = points[*corners.first()?];
            // Newell's formula: the areas of the triangles from one corner.
            let area: Vector3 = corners
                .windows(2)
                .map(|pair| (points[pair[0]] - middle).cross(&(points[pair[1]] - middle)))
                .sum();
            let normal = area.try_normalize(0.0)?;
            let heights = corners.iter().map(|&corner| normal.dot(&points[corner]));
            Some(Polygon {
                offset: heights.sum::<f64>() / corners.len() as f64,
                normal,
                corners,
            })
        })
        .collect()
}

/// Only the points that are corners, and the faces by their numbers.
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

    /// Points within a unit cube, some of them many times over, on a grid or not.
    fn clouds() -> Vec<Vec<Vector3>> {
        let grid = |n: usize| (0..n * n * n).map(move |k| [k % n, k / n % n, k / n / n]);
        let on_grid = grid(5).map(|[x, y, z]| Vector3::new(x as f64, y as f64, z as f64) * 0.37);
        let turned = crate::rigid::Rotation::from_scaled_axis(Vector3::new(0.3, -0.8, 0.5));
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
            // Each corner is one: some direction has it alone.
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
            assert!(most <= within + 1e-7, "{most} {within}");
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
