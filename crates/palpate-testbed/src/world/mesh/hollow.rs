//! Bent surfaces: which pushes are of one, and the way out of it.

use std::collections::BTreeSet;

use super::parts::{OnMesh, Part};
use super::search::{ENDS, MAX_CONTACTS, Parts, Push, among, holding, parted};
use super::triangles::TriangleMesh;
use crate::world::vector::Vec3;

/// Factor of the sphere's radius within which a bent surface is continued over the faces that the larger sphere
/// overlaps.
const WIDE: f64 = 1.05;

impl TriangleMesh {
    /// Splits parts into those of the first one's bent surface and the others, both in their original order. The sphere
    /// has this radius and its centre at `centre`.
    pub(super) fn bent(
        &self,
        pushes: Vec<Push>,
        radius: f64,
        centre: Vec3,
    ) -> (Vec<Push>, Vec<Push>) {
        let (surface, others) = parted(pushes.clone(), &BTreeSet::new());
        if !self.has_bends || faces_of(&others).next().is_none() {
            return (surface, others);
        }
        let reached = self.reached(faces_of(&surface), radius, centre);
        parted(pushes, &reached)
    }

    /// The faces on which the shortest way out of a bent surface ends, to where the sphere overlaps nothing of it.
    /// `None` if there is no way, or it is longer than `longest` `[m]`.
    pub(super) fn out_of_all(
        &self,
        surface: &[Push],
        now: &[OnMesh; MAX_CONTACTS],
        radius: f64,
        centre: Vec3,
        longest: f64,
    ) -> Option<Parts> {
        let mut all = surface.to_vec();
        let slack = ENDS * all.first()?.depth;
        loop {
            // A face that holds may be one that the way has not met yet.
            let depth = |part| match part {
                Part::Face(face) if self.has_bends => Some(self.push_of(face, radius, centre)),
                other => among(&all)(other),
            };
            let (way, parts) = holding(&all, now, depth)?;
            if way.norm() > longest {
                return None;
            }
            if !self.has_bends {
                return Some(parts);
            }
            let lifted = centre + way;
            match self.in_the_way(&all, radius, lifted, slack) {
                None => return Some(parts),
                Some(face) => all.push(self.push_of(face, radius, centre)),
            }
        }
    }

    fn push_of(&self, face: usize, radius: f64, centre: Vec3) -> Push {
        let lie = self.lie(Part::Face(face), centre, Vec3::ZERO);
        Push {
            part: Part::Face(face),
            depth: radius - lie.distance,
            normal: lie.normal,
        }
    }

    /// The face that a sphere overlaps most which was lifted out of some: of those below it, and of one bent surface
    /// with these.
    fn in_the_way(&self, of: &[Push], radius: f64, lifted: Vec3, slack: f64) -> Option<usize> {
        let short = |face| self.push_of(face, radius, lifted).depth;
        let is_below = |face: &usize| {
            (slack..radius).contains(&short(*face))
                && faces_of(of).all(|other| other != *face) // out of these it is but for round-off
                && self.on_face(*face, lifted).0 == Part::Face(*face)
        };
        let near = self.near(lifted, radius);
        let below: Vec<usize> = near.into_iter().filter(is_below).collect();
        if below.is_empty() {
            return None;
        }
        let reached = self.reached(faces_of(of), radius, lifted);
        let below = below.into_iter().filter(|face| reached.contains(face));
        below.max_by(|&a, &b| short(a).total_cmp(&short(b)))
    }

    /// Returns the faces that are reached from the given ones over edges that are not convex and bend by less than 30°,
    /// through faces that a slightly larger sphere at `centre` overlaps.
    fn reached(
        &self,
        from: impl Iterator<Item = usize>,
        radius: f64,
        centre: Vec3,
    ) -> BTreeSet<usize> {
        let reach = WIDE * radius;
        let mut reached: BTreeSet<usize> = from.collect();
        let mut border: Vec<usize> = reached.iter().copied().collect();
        while let Some(face) = border.pop() {
            for edge in self.edges_of[face].map(|edge| &self.edges[edge]) {
                for &other in edge.faces.iter().filter(|_| edge.is_bend) {
                    let is_new = !reached.contains(&other);
                    if is_new && self.on_face(other, centre).1 < reach * reach {
                        reached.insert(other);
                        border.push(other);
                    }
                }
            }
        }
        reached
    }
}

/// The faces among them.
fn faces_of(pushes: &[Push]) -> impl Iterator<Item = usize> {
    pushes.iter().filter_map(|push| match push.part {
        Part::Face(face) => Some(face),
        _ => None,
    })
}
