//! Which parts of a mesh push a sphere, found by looking at all parts about it.

use std::collections::BTreeSet;

use super::parts::{OnMesh, Part, nearest, shares};
use super::triangles::TriangleMesh;
use crate::world::vector::Vec3;

/// Contacts of a sphere with a mesh at once.
pub(in crate::world) const MOST_CONTACTS: usize = 4;
/// Cosine of the angle between normals from which on their faces are surfaces of their own: 30°.
const SHARP: f64 = 0.866_025_403_784_438_6;
/// Parts of one bent surface that are looked at, the deepest.
const MOST_TOGETHER: usize = 12;
/// What is beyond its end by less than this share is not.
const SLACK: f64 = 1e-12;

/// A part with the sphere's depth in it.
#[derive(Debug, Clone, Copy)]
struct Push {
    part: Part,
    depth: f64,
    normal: Vec3,
}

/// What each of the contacts should be at, if they are at `now`, and the sphere's centre is at `centre` in the mesh's
/// axes.
pub(in crate::world) fn wanted(
    mesh: &TriangleMesh,
    now: &[OnMesh; MOST_CONTACTS],
    radius: f64,
    centre: Vec3,
) -> [OnMesh; MOST_CONTACTS] {
    let found = match mesh.standing(now, radius, centre) {
        OnMesh::Inside => vec![OnMesh::Inside],
        behind @ OnMesh::Behind(_) => vec![behind],
        _ => mesh.in_front(radius, centre),
    };
    // Each goes where the one was that is most like it.
    let normal = |at| match at {
        OnMesh::Nothing | OnMesh::Inside => Vec3::ZERO,
        at => nearest(mesh, at, radius, centre, Vec3::ZERO).1,
    };
    let before = now.map(normal);
    let mut wanted = [OnMesh::Nothing; MOST_CONTACTS];
    for at in found.into_iter().take(MOST_CONTACTS) {
        let likeness = |place: usize| before[place].dot(normal(at));
        let free = (0..MOST_CONTACTS).filter(|&place| wanted[place] == OnMesh::Nothing);
        // Of equals, the first.
        let best = free.reduce(|best, place| {
            if likeness(place) > likeness(best) {
                place
            } else {
                best
            }
        });
        if let Some(place) = best {
            wanted[place] = at;
        }
    }
    wanted
}

impl TriangleMesh {
    /// On which side the centre is: [`OnMesh::Inside`], behind a part, or else in front.
    fn standing(&self, now: &[OnMesh; MOST_CONTACTS], radius: f64, centre: Vec3) -> OnMesh {
        for &at in now {
            if let OnMesh::Behind(part) = at {
                return match self.downhill(part, centre) {
                    (part, side) if side <= 0.0 => OnMesh::Behind(part),
                    _ => OnMesh::Nothing,
                };
            }
        }
        let is_first = now.iter().all(|at| *at == OnMesh::Nothing);
        let (part, distance) = self.nearest_of_all(centre);
        let is_behind = self.side(part, centre) <= 0.0;
        if now.contains(&OnMesh::Inside) || is_first {
            let is_out = !is_behind && (is_first || distance >= radius);
            return if is_out {
                OnMesh::Nothing
            } else {
                OnMesh::Inside
            };
        }
        if !is_behind {
            OnMesh::Nothing
        } else if self.is_beyond_border(now) {
            OnMesh::Inside // round the border of an open mesh, and not through its front
        } else {
            OnMesh::Behind(part)
        }
    }

    /// Whether the parts that were nearest until now are all on the border of an open mesh, where no surface was crossed.
    fn is_beyond_border(&self, now: &[OnMesh; MOST_CONTACTS]) -> bool {
        let mut parts = now.iter().flat_map(|at| match at {
            OnMesh::Before(parts) => parts.iter().flatten().copied().collect(),
            _ => Vec::new(),
        });
        parts.all(|part| self.is_on_border(part))
    }

    /// Whether a part is on the border of an open mesh.
    fn is_on_border(&self, part: Part) -> bool {
        let is_border = |edge: &usize| self.edges[*edge].faces.len() == 1;
        match part {
            Part::Face(_) => false,
            Part::Edge(edge) => is_border(&edge),
            Part::Vertex(vertex) => self.edges_at[vertex].iter().any(is_border),
        }
    }

    /// The nearest point of a face: the part that it lies on, and the squared distance.
    fn on_face(&self, face: usize, point: Vec3) -> (Part, f64) {
        let corners = self.faces[face];
        let mut best = (Part::Face(face), f64::INFINITY);
        let mut is_over = true;
        for k in 0..3 {
            let edge = self.edges_of[face][k];
            let [from, to] = [corners[k], corners[(k + 1) % 3]];
            let [start, end] = [from, to].map(|vertex| self.vertices[vertex]);
            let (along, off) = (end - start, point - start);
            is_over &= self.inward(face, edge).dot(off) >= 0.0;
            let share = along.dot(off) / along.dot(along);
            let (part, place) = if share <= 0.0 {
                (Part::Vertex(from), start)
            } else if share >= 1.0 {
                (Part::Vertex(to), end)
            } else {
                (Part::Edge(edge), start + along * share)
            };
            let off = point - place;
            if off.dot(off) < best.1 {
                best = (part, off.dot(off));
            }
        }
        if is_over {
            let above = self.normals[face].dot(point - self.vertices[corners[0]]);
            return (Part::Face(face), above * above);
        }
        best
    }

    /// The part of the whole mesh that is nearest, and its distance \[m\].
    fn nearest_of_all(&self, point: Vec3) -> (Part, f64) {
        let mut reach = self.cell_side();
        // The furthest that a double can say, from anywhere.
        while reach < 1e100 {
            let near = self.near(point, reach);
            let found = near.into_iter().map(|face| self.on_face(face, point));
            if let Some((part, square)) = found.min_by(|a, b| a.1.total_cmp(&b.1))
                && square <= reach * reach
            {
                return (part, square.sqrt());
            }
            reach *= 2.0;
        }
        (Part::Vertex(0), f64::INFINITY)
    }

    /// Above 0 if a point that is nearest to `part` is in front of the surface.
    fn side(&self, part: Part, point: Vec3) -> f64 {
        match part {
            Part::Face(face) => self.normals[face].dot(point - self.vertices[self.faces[face][0]]),
            Part::Edge(edge) => {
                let edge = &self.edges[edge];
                if edge.faces.len() == 1 {
                    return 1.0; // beyond the border of an open mesh
                }
                let sum = self.normals[edge.faces[0]] + self.normals[edge.faces[1]];
                sum.dot(point - self.vertices[edge.ends[0]])
            }
            Part::Vertex(vertex) => {
                let tip = self.vertices[vertex];
                let mut sum = Vec3::ZERO;
                for &face in &self.faces_at[vertex] {
                    let sides: Vec<Vec3> = self.faces[face]
                        .iter()
                        .filter(|&&corner| corner != vertex)
                        .map(|&corner| self.vertices[corner] - tip)
                        .collect();
                    let cosine = sides[0].dot(sides[1]) / (sides[0].norm() * sides[1].norm());
                    sum += self.normals[face] * cosine.clamp(-1.0, 1.0).acos();
                }
                sum.dot(point - tip)
            }
        }
    }

    /// From a part over the faces around it to nearer ones, as far as that goes; and on which side of the last the point is.
    fn downhill(&self, from: Part, point: Vec3) -> (Part, f64) {
        let mut best = (from, f64::INFINITY);
        let mut faces = match from {
            Part::Face(face) => vec![face],
            Part::Edge(edge) => self.edges[edge].faces.clone(),
            Part::Vertex(vertex) => self.faces_at[vertex].clone(),
        };
        loop {
            let mut next = None;
            for &face in &faces {
                let (part, square) = self.on_face(face, point);
                if square < best.1 {
                    best = (part, square);
                    next = Some(face);
                }
            }
            let Some(face) = next else {
                return (best.0, self.side(best.0, point));
            };
            faces = self.faces[face]
                .iter()
                .flat_map(|&corner| self.faces_at[corner].iter().copied())
                .collect();
        }
    }

    /// The contacts of a sphere whose centre is in front; if none touches, the nearest part.
    fn in_front(&self, radius: f64, centre: Vec3) -> Vec<OnMesh> {
        let mut pushes = self.minima(radius, centre);
        pushes.sort_by(|a, b| b.depth.total_cmp(&a.depth));
        let Some(&first) = pushes.first() else {
            let (part, distance) = self.nearest_of_all(centre);
            if distance < radius && self.is_on_border(part) {
                return Vec::new(); // beside the border of an open mesh, below its surface
            }
            return vec![OnMesh::Before([Some(part), None, None])];
        };
        pushes.retain(|push| {
            push.normal.dot(first.normal) > SHARP || self.sees(centre, radius, push)
        });
        let mut contacts = Vec::new();
        while let Some(&deepest) = pushes.first() {
            let (beside, others): (Vec<Push>, Vec<Push>) = pushes
                .iter()
                .partition(|push| push.normal.dot(deepest.normal) > SHARP);
            pushes = others;
            contacts.push(OnMesh::Before(holding(&beside)));
        }
        contacts
    }

    /// Every part at which the distance has a minimum that is less than the radius: it is the nearest of some face.
    fn minima(&self, radius: f64, centre: Vec3) -> Vec<Push> {
        let near = self.near(centre, radius);
        let parts: BTreeSet<Part> = near
            .into_iter()
            .map(|face| self.on_face(face, centre))
            .filter(|(_, square)| *square < radius * radius)
            .map(|(part, _)| part)
            .collect();
        parts
            .into_iter()
            .filter(|&part| self.is_minimum(part, centre))
            .filter_map(|part| {
                let lie = self.lie(part, centre, Vec3::ZERO);
                (lie.distance > 0.0 && lie.distance < radius).then_some(Push {
                    part,
                    depth: radius - lie.distance,
                    normal: lie.normal,
                })
            })
            .collect()
    }

    /// Whether the distance to the surface has a minimum at the nearest point of a face, and the centre is in front.
    fn is_minimum(&self, part: Part, centre: Vec3) -> bool {
        let is_before = self.side(part, centre) > 0.0;
        match part {
            Part::Face(_) => is_before,
            Part::Edge(edge) => {
                let Edge { along, off, faces } = self.about(edge, centre);
                let across = off.across(along.direction().unwrap_or(Vec3::ZERO));
                let is_least = faces.iter().all(|&face| {
                    let inward = self.inward(face, edge);
                    inward.dot(across) <= SLACK * inward.norm() * across.norm()
                });
                let is_before = match faces {
                    [face] => self.normals[*face].dot(across) >= 0.0,
                    _ => is_before,
                };
                is_least && is_before
            }
            Part::Vertex(vertex) => {
                let off = centre - self.vertices[vertex];
                let is_least = self.edges_at[vertex].iter().all(|&edge| {
                    let [one, other] = self.edges[edge].ends;
                    let end = if one == vertex { other } else { one };
                    let along = self.vertices[end] - self.vertices[vertex];
                    along.dot(off) <= SLACK * along.norm() * off.norm()
                });
                is_least && is_before
            }
        }
    }

    fn about(&self, edge: usize, centre: Vec3) -> Edge<'_> {
        let [from, to] = self.edges[edge].ends.map(|end| self.vertices[end]);
        Edge {
            along: to - from,
            off: centre - from,
            faces: &self.edges[edge].faces,
        }
    }

    /// Whether no face lies between the centre and the place of a push.
    fn sees(&self, centre: Vec3, radius: f64, push: &Push) -> bool {
        let place = centre - push.normal * (radius - push.depth);
        let own: Vec<usize> = match push.part {
            Part::Face(face) => self.faces[face].to_vec(),
            Part::Edge(edge) => self.edges[edge].ends.to_vec(),
            Part::Vertex(vertex) => vec![vertex],
        };
        !self.near(centre, radius).into_iter().any(|face| {
            if self.faces[face].iter().any(|corner| own.contains(corner)) {
                return false;
            }
            let normal = self.normals[face];
            let corner = self.vertices[self.faces[face][0]];
            let (from, to) = (normal.dot(centre - corner), normal.dot(place - corner));
            if (from > 0.0) == (to > 0.0) {
                return false;
            }
            let through = centre + (place - centre) * (from / (from - to));
            (0..3).all(|k| {
                let off = through - self.vertices[self.faces[face][k]];
                self.inward(face, self.edges_of[face][k]).dot(off) >= 0.0
            })
        })
    }
}

/// An edge as it lies about a centre.
struct Edge<'a> {
    along: Vec3,
    off: Vec3,
    faces: &'a [usize],
}

/// The parts, at most three, whose surfaces the shortest way out of all of them ends on.
fn holding(pushes: &[Push]) -> [Option<Part>; 3] {
    let pushes = &pushes[..pushes.len().min(MOST_TOGETHER)];
    let mut best: Option<(f64, [Option<Part>; 3])> = None;
    let count = pushes.len();
    for subset in 1_u32..1 << count {
        if subset.count_ones() > 3 {
            continue;
        }
        let of: Vec<&Push> = (0..count)
            .filter(|place| subset >> place & 1 == 1)
            .map(|place| &pushes[place])
            .collect();
        let normals: Vec<Vec3> = of.iter().map(|push| push.normal).collect();
        let depths: Vec<f64> = of.iter().map(|push| push.depth).collect();
        let Some(shares) = shares(&normals, &depths) else {
            continue;
        };
        if shares.iter().any(|share| *share < 0.0) {
            continue;
        }
        let mut way = Vec3::ZERO;
        for (normal, share) in normals.iter().zip(&shares) {
            way += *normal * *share;
        }
        let is_out = pushes
            .iter()
            .all(|push| push.normal.dot(way) >= push.depth * (1.0 - SLACK));
        let length = way.norm();
        // Fewer parts where one more adds nothing: those come first where there are as many bits as needed.
        if is_out && best.is_none_or(|(other, _)| length < other * (1.0 - SLACK)) {
            let mut parts = [None; 3];
            let mut sorted: Vec<Part> = of.iter().map(|push| push.part).collect();
            sorted.sort();
            for (place, part) in parts.iter_mut().zip(sorted) {
                *place = Some(part);
            }
            best = Some((length, parts));
        }
    }
    best.map_or(
        [pushes.first().map(|push| push.part), None, None],
        |(_, parts)| parts,
    )
}
