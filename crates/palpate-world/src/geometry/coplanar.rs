//! Flat faces of a convex triangle surface.

use std::collections::HashMap;

use crate::geometry::convex::{Facet, Polygon};
use crate::geometry::rigid::Vector3;

/// A closed surface of facets, and the face of each facet.
struct Faces<'a> {
    facets: &'a [Facet],
    points: &'a [Vector3],
    /// Facet of each directed edge.
    owner: HashMap<(usize, usize), usize>,
    face: Vec<usize>,
    count: usize,
}

/// Computes the faces of a convex surface: facets with all corners within `tolerance` `[m]` of the plane of a larger
/// adjacent facet join its face. `None` if the surface is not closed.
pub(crate) fn polygons(
    facets: &[Facet],
    points: &[Vector3],
    tolerance: f64,
) -> Option<Vec<Polygon>> {
    let mut faces = Faces::new(facets, points)?;
    faces.grow(tolerance);
    // Each round removes a face.
    for _ in 0..facets.len() {
        let at = faces.at_corners();
        let outlines: Vec<Vec<usize>> = (0..faces.count)
            .map(|face| faces.outline(face, &at))
            .collect::<Option<_>>()?;
        let Some(thin) = outlines.iter().position(|corners| corners.len() < 3) else {
            let polygons = outlines.into_iter();
            return polygons.map(|corners| polygon(points, corners)).collect();
        };
        faces.give_away(thin)?;
    }
    None
}

impl<'a> Faces<'a> {
    fn new(facets: &'a [Facet], points: &'a [Vector3]) -> Option<Self> {
        let mut owner = HashMap::new();
        for (number, facet) in facets.iter().enumerate() {
            for edge in facet.edges() {
                if owner.insert(edge, number).is_some() {
                    return None;
                }
            }
        }
        Some(Self {
            facets,
            points,
            owner,
            face: vec![usize::MAX; facets.len()],
            count: 0,
        })
    }

    /// Returns the facet across an edge.
    fn across(&self, (from, to): (usize, usize)) -> Option<usize> {
        self.owner.get(&(to, from)).copied()
    }

    /// Grows faces from the largest facets, whose planes are the most accurate.
    fn grow(&mut self, tolerance: f64) {
        let mut by_size: Vec<usize> = (0..self.facets.len()).collect();
        by_size.sort_by(|&a, &b| self.facets[b].area.total_cmp(&self.facets[a].area));
        for first in by_size {
            if self.face[first] != usize::MAX {
                continue;
            }
            let plane = &self.facets[first];
            let offset = plane.normal.dot(&self.points[plane.corners[0]]);
            let is_near = |corner: &usize| {
                (plane.normal.dot(&self.points[*corner]) - offset).abs() <= tolerance
            };
            let mut waiting = vec![first];
            self.face[first] = self.count;
            while let Some(facet) = waiting.pop() {
                for edge in self.facets[facet].edges() {
                    if let Some(other) = self.across(edge)
                        && self.face[other] == usize::MAX
                        && self.facets[other].corners.iter().all(is_near)
                    {
                        self.face[other] = self.count;
                        waiting.push(other);
                    }
                }
            }
            self.count += 1;
        }
        // Number the faces in the order of their first facets.
        let mut numbers = vec![usize::MAX; self.count];
        let mut count = 0;
        for face in &mut self.face {
            if numbers[*face] == usize::MAX {
                numbers[*face] = count;
                count += 1;
            }
            *face = numbers[*face];
        }
    }

    /// Returns the number of faces that meet at each corner.
    fn at_corners(&self) -> HashMap<usize, usize> {
        let mut at: HashMap<usize, Vec<usize>> = HashMap::new();
        for (facet, face) in self.facets.iter().zip(&self.face) {
            for corner in facet.corners {
                let faces = at.entry(corner).or_default();
                if !faces.contains(face) {
                    faces.push(*face);
                }
            }
        }
        at.into_iter()
            .map(|(corner, faces)| (corner, faces.len()))
            .collect()
    }

    /// Returns the corners of a face in order, without those at which only two faces meet, which lie within an edge.
    /// `None` if there is more than one outline.
    fn outline(&self, face: usize, at: &HashMap<usize, usize>) -> Option<Vec<usize>> {
        let mut next: HashMap<usize, usize> = HashMap::new();
        for facet in (0..self.facets.len()).filter(|&facet| self.face[facet] == face) {
            for edge in self.facets[facet].edges() {
                let is_rim = self.face[self.across(edge)?] != face;
                if is_rim && next.insert(edge.0, edge.1).is_some() {
                    return None;
                }
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
        corners.retain(|corner| at[corner] > 2);
        Some(corners)
    }

    /// Merges a face into the neighbour with the longest common boundary.
    fn give_away(&mut self, thin: usize) -> Option<()> {
        let mut rims: Vec<f64> = vec![0.0; self.count];
        for facet in (0..self.facets.len()).filter(|&facet| self.face[facet] == thin) {
            for edge in self.facets[facet].edges() {
                let other = self.face[self.across(edge)?];
                rims[other] += (self.points[edge.1] - self.points[edge.0]).norm();
            }
        }
        rims[thin] = 0.0;
        let (to, _) = rims
            .iter()
            .enumerate()
            .max_by(|a, b| a.1.total_cmp(b.1))
            .filter(|(_, rim)| **rim > 0.0)?;
        for face in &mut self.face {
            if *face == thin {
                *face = to;
            }
            if *face > thin {
                *face -= 1;
            }
        }
        self.count -= 1;
        Some(())
    }
}

fn polygon(points: &[Vector3], corners: Vec<usize>) -> Option<Polygon> {
    let middle = points[*corners.first()?];
    // Newell's formula: the sum of the triangle areas from one corner.
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
}
