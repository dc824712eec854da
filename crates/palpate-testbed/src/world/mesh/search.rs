//! Finds the parts of a mesh that push a sphere, from all parts near it.

use std::collections::BTreeSet;

use super::parts::{OnMesh, Part, nearest, shares};
use super::triangles::{SHARP, TriangleMesh};
use crate::world::vector::Vec3;

/// Contacts of a sphere with a mesh at once.
pub(in crate::world) const MAX_CONTACTS: usize = 4;
/// The longest way out of a bent surface over its largest depth.
const STEEP: f64 = 3.0;
/// A way ends on a part, or beyond it, if it falls short by no more than this share of the largest depth.
pub(super) const ENDS: f64 = 1e-10;
/// Relative tolerance at the end of a part.
const SLACK: f64 = 1e-12;

/// A part with the sphere's depth in it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Push {
    pub part: Part,
    pub depth: f64,
    pub normal: Vec3,
}

/// Returns the required state of each contact, for the present states `now` and the sphere's centre at `centre` in the
/// mesh's axes.
pub(in crate::world) fn wanted(
    mesh: &TriangleMesh,
    now: &[OnMesh; MAX_CONTACTS],
    radius: f64,
    centre: Vec3,
) -> [OnMesh; MAX_CONTACTS] {
    let found = match mesh.standing(now, radius, centre) {
        OnMesh::Inside => vec![OnMesh::Inside],
        behind @ OnMesh::Behind(_) => vec![behind],
        _ => mesh.in_front(now, radius, centre),
    };
    // Each state goes to the most similar present contact.
    let normal = |at| match at {
        OnMesh::Nothing | OnMesh::Inside => Vec3::ZERO,
        at => nearest(mesh, at, radius, centre, Vec3::ZERO).1,
    };
    let before = now.map(normal);
    let mut wanted = [OnMesh::Nothing; MAX_CONTACTS];
    for at in found.into_iter().take(MAX_CONTACTS) {
        let likeness = |place: usize| before[place].dot(normal(at));
        let free = (0..MAX_CONTACTS).filter(|&place| wanted[place] == OnMesh::Nothing);
        // Ties go to the first.
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
    fn standing(&self, now: &[OnMesh; MAX_CONTACTS], radius: f64, centre: Vec3) -> OnMesh {
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

    /// Whether the parts that were nearest until now are all on the border of an open mesh, where no surface was
    /// crossed.
    fn is_beyond_border(&self, now: &[OnMesh; MAX_CONTACTS]) -> bool {
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
    pub(super) fn on_face(&self, face: usize, point: Vec3) -> (Part, f64) {
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

    /// The part of the whole mesh that is nearest, and its distance `[m]`.
    fn nearest_of_all(&self, point: Vec3) -> (Part, f64) {
        let mut reach = self.cell_side();
        // Limit of the reach in double precision.
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

    /// Moves from a part over adjacent faces to nearer ones as far as possible. Returns the last one, and the side of
    /// the point.
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
    fn in_front(&self, now: &[OnMesh; MAX_CONTACTS], radius: f64, centre: Vec3) -> Vec<OnMesh> {
        let mut pushes = self.minima(radius, centre);
        pushes.sort_by(|a, b| b.depth.total_cmp(&a.depth));
        if pushes.is_empty() {
            let (part, distance) = self.nearest_of_all(centre);
            if distance < radius && self.is_on_border(part) {
                return Vec::new(); // beside the border of an open mesh, below its surface
            }
            return vec![OnMesh::Before([Some(part), None, None])];
        }
        let (surface, others) = self.bent(pushes, radius, centre);
        let seen = others
            .into_iter()
            .filter(|push| self.sees(centre, radius, push));
        let mut pushes: Vec<Push> = surface.into_iter().chain(seen).collect();
        pushes.sort_by(|a, b| b.depth.total_cmp(&a.depth));
        let mut contacts = Vec::new();
        while let Some(&deepest) = pushes.first() {
            let (surface, others) = self.bent(pushes, radius, centre);
            let longest = STEEP * deepest.depth;
            if let Some(parts) = self.out_of_all(&surface, now, radius, centre, longest) {
                contacts.push(OnMesh::Before(parts));
                pushes = others;
                continue;
            }
            // No way out, or too long a one: what is about the deepest.
            let (beside, left): (Vec<Push>, Vec<Push>) = surface
                .into_iter()
                .partition(|push| push.normal.dot(deepest.normal) > SHARP);
            let parts = holding(&beside, now, among(&beside))
                .map_or([Some(deepest.part), None, None], |(_, parts)| parts);
            contacts.push(OnMesh::Before(parts));
            pushes = left.into_iter().chain(others).collect();
            pushes.sort_by(|a, b| b.depth.total_cmp(&a.depth));
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

/// At most three parts that push together.
pub(super) type Parts = [Option<Part>; 3];

/// The first and those of the faces `with`, and whose normals differ by less than 30° from these, from one to the next;
/// and the others. Both in the order that they had.
pub(super) fn parted(pushes: Vec<Push>, with: &BTreeSet<usize>) -> (Vec<Push>, Vec<Push>) {
    let is_with = |push: &Push| matches!(push.part, Part::Face(face) if with.contains(&face));
    let mut is_joined: Vec<bool> = pushes.iter().map(is_with).collect();
    if let Some(first) = is_joined.first_mut() {
        *first = true;
    }
    let mut reached: Vec<usize> = (0..pushes.len()).filter(|&at| is_joined[at]).collect();
    while let Some(from) = reached.pop() {
        for to in 0..pushes.len() {
            if !is_joined[to] && pushes[to].normal.dot(pushes[from].normal) > SHARP {
                is_joined[to] = true;
                reached.push(to);
            }
        }
    }
    let mut joined = is_joined.into_iter();
    pushes
        .into_iter()
        .partition(|_| joined.next().unwrap_or(false))
}

/// Returns the shortest way out of all parts, the deepest of which comes first, and the at most three parts on whose
/// surfaces it ends. Keeps the present parts, with the depths of `depth`, if they still give that way. `None` if there
/// is no way.
pub(super) fn holding(
    pushes: &[Push],
    now: &[OnMesh; MAX_CONTACTS],
    depth: impl Fn(Part) -> Option<Push>,
) -> Option<(Vec3, Parts)> {
    let slack = ENDS * pushes.first()?.depth;
    let found = shortest(pushes, &[], slack)?;
    // At the tip of a cone any three of its faces determine the way.
    let same = now.iter().find_map(|at| {
        let OnMesh::Before(parts) = at else {
            return None;
        };
        let of: Option<Vec<Push>> = parts.iter().flatten().map(|&part| depth(part)).collect();
        let way = on(&of?)?;
        ((way - found.way).norm() <= slack).then_some(*parts)
    });
    let parts = same.unwrap_or_else(|| {
        let mut sorted: Vec<Part> = found.of.iter().map(|push| push.part).collect();
        sorted.sort();
        let mut parts = [None; 3];
        for (place, part) in parts.iter_mut().zip(sorted) {
            *place = Some(part);
        }
        parts
    });
    Some((found.way, parts))
}

/// Returns the push at a given part.
pub(super) fn among(pushes: &[Push]) -> impl Fn(Part) -> Option<Push> {
    |part| pushes.iter().find(|push| push.part == part).copied()
}

/// A way, and the parts on whose surfaces it ends.
struct Way {
    way: Vec3,
    of: Vec<Push>,
}

impl Push {
    /// Whether a way ends within this surface.
    fn is_short(&self, way: Vec3, slack: f64) -> bool {
        self.depth - self.normal.dot(way) > slack
    }
}

/// The shortest way that ends on all of these surfaces. `None` if their normals are dependent.
fn on(surfaces: &[Push]) -> Option<Vec3> {
    let normals: Vec<Vec3> = surfaces.iter().map(|push| push.normal).collect();
    let depths: Vec<f64> = surfaces.iter().map(|push| push.depth).collect();
    let shares = shares(&normals, &depths)?;
    let mut way = Vec3::ZERO;
    for (normal, share) in normals.iter().zip(&shares) {
        way += *normal * *share;
    }
    Some(way)
}

/// The shortest way that ends on the surfaces of `tight`, two at most, and out of all of `pushes`, one after the other:
/// the first that such a way is short of, is one on which it has to end (Welzl 1991, for balls and ellipsoids).
fn shortest(pushes: &[Push], tight: &[Push], slack: f64) -> Option<Way> {
    let mut found = Way {
        way: on(tight)?,
        of: tight.to_vec(),
    };
    for (number, push) in pushes.iter().enumerate() {
        if !push.is_short(found.way, slack) {
            continue;
        }
        let of = [tight, &[*push]].concat();
        found = if of.len() < 3 {
            shortest(&pushes[..number], &of, slack)?
        } else {
            Way { way: on(&of)?, of }
        };
    }
    // Along a line, one that came before may be in the way: then there is none.
    let is_out = pushes.iter().all(|push| !push.is_short(found.way, slack));
    is_out.then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(count: usize, from_axis: f64, depth: impl Fn(f64) -> f64) -> Vec<Push> {
        let mut pushes: Vec<Push> = (0..count)
            .map(|number| {
                let about = std::f64::consts::TAU * number as f64 / count as f64;
                let (sine, cosine) = about.sin_cos();
                let (across, along) = (from_axis.cos(), from_axis.sin());
                Push {
                    part: Part::Face(number),
                    depth: depth(about),
                    normal: Vec3([cosine * across, sine * across, along]),
                }
            })
            .collect();
        pushes.sort_by(|a, b| b.depth.total_cmp(&a.depth));
        pushes
    }

    /// In a cone, whose faces surround the sphere, the way out leads to the tip.
    #[test]
    fn a_cone_of_many_faces_is_one_surface() {
        for from_axis in [0.4, 0.8, 1.3_f64] {
            let tip = Vec3([1e-5, -2e-5, 1e-3]);
            let pushes = ring(96, from_axis, |about| {
                let (sine, cosine) = about.sin_cos();
                let normal = Vec3([
                    cosine * from_axis.cos(),
                    sine * from_axis.cos(),
                    from_axis.sin(),
                ]);
                normal.dot(tip)
            });
            let (surface, others) = parted(pushes.clone(), &BTreeSet::new());
            assert_eq!((surface.len(), others.len()), (96, 0));
            let (way, parts) =
                holding(&pushes, &[OnMesh::Nothing; MAX_CONTACTS], among(&pushes)).unwrap();
            assert!((way - tip).norm() < 1e-9 * tip.norm(), "{way:?}");
            // The same parts hold while the sphere is pressed in slightly deeper.
            let deeper = ring(96, from_axis, |about| {
                let (sine, cosine) = about.sin_cos();
                let normal = Vec3([
                    cosine * from_axis.cos(),
                    sine * from_axis.cos(),
                    from_axis.sin(),
                ]);
                normal.dot(tip * 1.01)
            });
            let now = [
                OnMesh::Before(parts),
                OnMesh::Nothing,
                OnMesh::Nothing,
                OnMesh::Nothing,
            ];
            assert_eq!(holding(&deeper, &now, among(&deeper)).unwrap().1, parts);
        }
    }

    #[test]
    fn there_is_no_way_out_of_a_tube() {
        let pushes = ring(24, 0.0, |_| 1e-4);
        assert_eq!(
            holding(&pushes, &[OnMesh::Nothing; MAX_CONTACTS], among(&pushes)),
            None
        );
    }
}
