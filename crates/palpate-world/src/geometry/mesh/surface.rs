//! A sphere in contact with a mesh.
//!
//! If the sphere's centre is in front of the surface, the contacts are the visible minima of the centre's distance: a
//! face below it, a convex edge or a convex corner. Once the centre has passed through a triangle it is *behind* it
//! until it returns through the surface. It is then pushed to the surface point found by descending in distance from
//! triangle to triangle, never to a point that is nearer only through a wall.

use std::sync::Arc;

use super::build::Mesh;
use super::cluster::{Push, Pushes};
use super::gather::{About, Gathered, Near, way_to_push};
use super::hollow::Around;
use super::nearest::{nearest_of, side};
use super::topology::NONE;
use super::triangle::{Region, crossing, nearest};
use crate::geometry::rigid::{Rigid, Vector3};

/// Maximum number of simultaneous contacts of a sphere with a mesh.
pub(crate) const POINTS_PER_MESH: usize = 4;
/// A displacement between two evaluations of more than this plus the diameter is not treated as a straight path
/// `[m]`.
const LEAP: f64 = 0.02;
/// Maximum number of triangles that the contact point behind the surface crosses between two evaluations.
const MAX_WALKED: usize = 32;
/// Maximum number of triangles tested for the first crossing of a path.
const MAX_CROSSED: u32 = 4096;
/// Angles and ratios below this value are treated as zero.
const SLACK: f64 = 1e-9;

/// A contact: distance of the nearest surface point from the sphere's centre, negative behind the surface `[m]`, and
/// the outward unit normal in the mesh's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Found {
    pub distance: f64,
    pub normal: Vector3,
}

/// Side of the surface on which the centre is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Standing {
    /// Unknown: not yet evaluated.
    Unknown,
    /// Inside since it was first seen. Nothing pushes until the whole sphere has come out, which takes a displacement
    /// of at least `way` from `place` `[m]`.
    Inside { place: Vector3, way: f64 },
    /// In front, with the centre at that time.
    Front { centre: Vector3 },
    /// Behind this triangle, or one reached from it.
    Behind { triangle: u32 },
}

/// State of a sphere and a mesh between evaluations.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Memory {
    standing: Standing,
    found: [Option<Found>; POINTS_PER_MESH],
    /// Lower bound of the centre's distance from the surface `[m]`.
    clearance: f64,
}

/// A sphere and a mesh.
#[derive(Clone, Debug)]
pub(crate) struct Surface {
    mesh: Arc<Mesh>,
    /// Indices of the sphere's and the mesh's parts.
    first: usize,
    second: usize,
    /// Centre of the sphere, in the axes of the first part `[m]`.
    centre: Vector3,
    radius: f64,
    gathered: Gathered,
    /// Triangles near the sphere when it is lifted out of a hollow.
    lifted: Gathered,
    /// Scratch buffer for the pushes of an evaluation.
    pushes: Pushes,
    memory: Memory,
    left_out: u32,
}

impl Surface {
    /// Creates a sphere at `centre`, in the axes of the first of the two parts `[m]`, with the mesh of the second.
    pub fn new(mesh: Arc<Mesh>, [first, second]: [usize; 2], centre: Vector3, radius: f64) -> Self {
        Self {
            gathered: Gathered::none(mesh.faces.len()),
            lifted: Gathered::none(mesh.faces.len()),
            pushes: Pushes::none(),
            mesh,
            first,
            second,
            centre,
            radius,
            memory: Memory {
                standing: Standing::Unknown,
                found: [None; POINTS_PER_MESH],
                clearance: 0.0,
            },
            left_out: 0,
        }
    }

    /// Returns the indices of the sphere's and the mesh's parts.
    pub fn parts(&self) -> [usize; 2] {
        [self.first, self.second]
    }

    /// Resets the state: the sphere may be anywhere.
    pub fn forget(&mut self) {
        self.memory.standing = Standing::Unknown;
        self.memory.found = [None; POINTS_PER_MESH];
    }

    /// Copies the state of another surface with the same sphere and mesh, without allocation.
    pub fn copy_from(&mut self, other: &Self) {
        let Memory {
            standing,
            found,
            clearance,
        } = &other.memory;
        self.memory.standing = *standing;
        self.memory.clearance = *clearance;
        for (own, found) in self.memory.found.iter_mut().zip(found) {
            // Most entries are `None` in both.
            if own.is_some() || found.is_some() {
                *own = *found;
            }
        }
    }

    /// Exchanges the triangle caches with another surface of the same sphere and mesh. Results do not depend on them.
    pub fn exchange_gathered(&mut self, other: &mut Self) {
        std::mem::swap(&mut self.gathered, &mut other.gathered);
        std::mem::swap(&mut self.lifted, &mut other.lifted);
    }

    /// Returns the contact at this contact point, as of the last evaluation.
    pub fn found(&self, point: usize) -> Option<&Found> {
        self.memory.found[point].as_ref()
    }

    /// Returns a lower bound of the centre's distance from the surface, as of the last evaluation `[m]`.
    pub fn clearance(&self) -> f64 {
        self.memory.clearance
    }

    /// Returns the largest number of triangles or contacts that an evaluation has left out since the last call.
    pub fn take_left_out(&mut self) -> u32 {
        std::mem::take(&mut self.left_out)
    }

    /// Returns the sphere's centre in the mesh's axes, for the given poses of the parts.
    fn centre_in(&self, first: &Rigid, second: &Rigid) -> Vector3 {
        let mut off = first.position - second.position;
        if self.centre != Vector3::zeros() {
            off += first.orientation * self.centre;
        }
        second.orientation.inverse_transform_vector(&off)
    }

    /// Returns the unsigned distance of the surface from the sphere's centre `[m]`.
    pub fn distance(&self, sphere: &Rigid, placed: &Rigid) -> f64 {
        let nearest = nearest_of(&self.mesh, &self.centre_in(sphere, placed));
        nearest.map_or(f64::INFINITY, |(distance, _)| distance)
    }

    /// Evaluates the contacts at the sphere's current position.
    pub fn look(&mut self, sphere: &Rigid, placed: &Rigid) {
        let centre = self.centre_in(sphere, placed);
        self.pushes.clear();
        let is_behind = self.is_behind(&centre);
        self.memory.clearance = 0.0;
        if is_behind {
            self.push_from_behind(&centre);
        }
        match self.memory.standing {
            Standing::Front { .. } => self.push_from_front(&centre),
            Standing::Inside { place, way } => {
                self.memory.clearance = self.radius + (way - (centre - place).norm()).max(0.0);
            }
            Standing::Unknown | Standing::Behind { .. } => {}
        }
        self.meet(&centre);
        self.left_out = self.left_out.max(self.pushes.left_out);
    }

    /// Updates the side on which the centre is. Returns whether it is behind a triangle.
    fn is_behind(&mut self, centre: &Vector3) -> bool {
        let standing = match self.memory.standing {
            Standing::Behind { triangle } => Standing::Behind { triangle },
            Standing::Front { centre: before } => {
                let way = (centre - before).norm();
                let crossed = if way < self.memory.clearance {
                    Some(None)
                } else if way > LEAP + 2.0 * self.radius || way.is_nan() {
                    None
                } else {
                    Some(self.crossed(&before, centre))
                };
                match crossed {
                    None => first_seen(&self.mesh, centre, self.radius, false),
                    Some(Some(triangle)) => Standing::Behind { triangle },
                    Some(None) => Standing::Front { centre: *centre },
                }
            }
            Standing::Inside { place, way } if (centre - place).norm() < way => {
                Standing::Inside { place, way }
            }
            Standing::Inside { .. } => first_seen(&self.mesh, centre, self.radius, true),
            Standing::Unknown => first_seen(&self.mesh, centre, self.radius, false),
        };
        self.memory.standing = standing;
        matches!(standing, Standing::Behind { .. })
    }

    /// Returns the first triangle that a path crosses from front to back.
    fn crossed(&mut self, from: &Vector3, to: &Vector3) -> Option<u32> {
        if from == to {
            return None;
        }
        let mesh = &*self.mesh;
        let mut first: Option<(f64, u32)> = None;
        let mut look_at = |triangle: u32| {
            let normal = &mesh.topology.normals[triangle as usize];
            let corners = mesh.corners(triangle);
            if normal.dot(&(from - corners[0])) <= 0.0 {
                return;
            }
            if let Some(share) = crossing(corners, normal, from, to)
                && first.is_none_or(|(other, _)| share < other)
            {
                first = Some((share, triangle));
            }
        };
        let way = (to - from).norm();
        let about = self.gathered.about(mesh, to, self.radius);
        if about.off + way <= about.reach && about.left_out == 0 {
            for near in about.near {
                if near.distance - about.off <= way {
                    look_at(near.triangle);
                }
            }
        } else {
            let middle = (from + to) * 0.5;
            let reach = 0.5 * way * (1.0 + SLACK) + f64::MIN_POSITIVE;
            let mut left = MAX_CROSSED;
            let is_all = mesh.tree.within(&middle, reach, |triangle| {
                look_at(triangle);
                left -= 1;
                left > 0
            });
            self.left_out = self.left_out.max(u32::from(!is_all));
        }
        first.map(|(_, triangle)| triangle)
    }

    /// Collects the minima of the distance within the radius, in front of the surface.
    fn push_from_front(&mut self, centre: &Vector3) {
        let (mesh, pushes) = (&*self.mesh, &mut self.pushes);
        let radius = self.radius;
        let About {
            near,
            least,
            off,
            reach,
            by_minimum,
            left_out,
            ..
        } = self.gathered.about(mesh, centre, radius);
        by_minimum.go_to(centre, near.len());
        let mut seen = 0;
        while let Some(number) = by_minimum.next(&mut seen) {
            let found = near[number];
            let (place, region) = nearest(mesh.corners(found.triangle), centre);
            let out = centre - place;
            let distance = out.norm();
            let pushed = if distance < radius {
                minimum(mesh, found.triangle, region, &out, distance)
            } else {
                None
            };
            let Some(normal) = pushed else {
                let way = way_to_push(mesh, found.triangle, centre);
                by_minimum.spare(number, way.max(distance - radius));
                continue;
            };
            pushes.add(Push {
                normal,
                depth: radius - distance,
                triangle: found.triangle,
                is_face: region == Region::Inside,
            });
        }
        self.memory.clearance = least.min(reach) - off;
        pushes.left_out = pushes.left_out.max(left_out);
        if !pushes.are_several() {
            return;
        }
        // Visible faces hide those behind them.
        let mut around = Around {
            mesh,
            gathered: &mut self.gathered,
            lifted: &mut self.lifted,
            centre,
            radius,
            left_out: &mut self.left_out,
        };
        let surface = pushes.deepest_surface(Some(&mut around));
        let near = around.about().near;
        pushes.hide(surface, |push| is_seen(mesh, near, centre, push, radius));
    }

    /// Collects the push from behind the surface to the tracked surface point. The centre may turn out to be in
    /// front.
    fn push_from_behind(&mut self, centre: &Vector3) {
        let Standing::Behind { triangle } = self.memory.standing else {
            return;
        };
        let mesh = &*self.mesh;
        let (triangle, place, region) = downhill(mesh, triangle, centre);
        let off = centre - place;
        if side(mesh, triangle, region, &off).is_none_or(|side| side > 0.0) {
            self.memory.standing = Standing::Front { centre: *centre };
            return;
        }
        self.memory.standing = Standing::Behind { triangle };
        let distance = off.norm();
        self.pushes.add(Push {
            normal: if distance > SLACK * self.mesh.reach() {
                -off / distance
            } else {
                self.mesh.topology.normals[triangle as usize]
            },
            depth: self.radius + distance,
            triangle,
            is_face: false,
        });
    }

    /// Combines the pushes into contacts, and assigns each to the contact point that had the most similar normal.
    fn meet(&mut self, centre: &Vector3) {
        let is_in_front = matches!(self.memory.standing, Standing::Front { .. });
        let mut around = is_in_front.then_some(Around {
            mesh: &self.mesh,
            gathered: &mut self.gathered,
            lifted: &mut self.lifted,
            centre,
            radius: self.radius,
            left_out: &mut self.left_out,
        });
        let before = std::mem::take(&mut self.memory.found);
        let now = &mut self.memory.found;
        let mut count = 0;
        while self.pushes.are_left()
            && let Some((depth, normal)) = self.pushes.take_surface(around.as_mut())
        {
            if count == POINTS_PER_MESH {
                self.left_out += 1;
                break;
            }
            count += 1;
            // The most similar free point; ties go to the first.
            let mut best = None;
            let mut most = f64::NEG_INFINITY;
            for (place, before) in now.iter_mut().zip(&before) {
                let likeness = before.map_or(0.0, |other| other.normal.dot(&normal));
                if place.is_none() && likeness > most {
                    (best, most) = (Some(place), likeness);
                }
            }
            if let Some(place) = best {
                *place = Some(Found {
                    distance: self.radius - depth,
                    normal,
                });
            }
        }
    }
}

impl Surface {
    /// Returns whether the centre was inside when first seen and the sphere has not come out since.
    pub fn is_inside(&self) -> bool {
        matches!(self.memory.standing, Standing::Inside { .. })
    }
}

/// Returns the side of a centre with an unknown or inside state.
fn first_seen(mesh: &Mesh, centre: &Vector3, radius: f64, was_inside: bool) -> Standing {
    let Some((distance, triangle)) = nearest_of(mesh, centre) else {
        return Standing::Unknown;
    };
    let (place, region) = nearest(mesh.corners(triangle), centre);
    let is_inside = side(mesh, triangle, region, &(centre - place)).is_some_and(|side| side <= 0.0);
    let inside = |way| Standing::Inside {
        place: *centre,
        way,
    };
    if is_inside {
        inside(distance + radius)
    } else if was_inside && distance < radius {
        inside(radius - distance)
    } else {
        Standing::Front { centre: *centre }
    }
}

/// Returns the contact normal at a triangle's nearest point, from the vector `out` to the centre, if the distance has
/// a minimum there and the centre is in front. A minimum on an edge or a corner is attributed to only one of its
/// triangles.
pub(super) fn minimum(
    mesh: &Mesh,
    triangle: u32,
    region: Region,
    out: &Vector3,
    distance: f64,
) -> Option<Vector3> {
    let topology = &mesh.topology;
    let own = &topology.normals[triangle as usize];
    match region {
        Region::Inside => (own.dot(out) > 0.0).then_some(*own),
        _ if distance <= 0.0 => None,
        Region::Edge(k) => {
            let other = topology.neighbours[triangle as usize][k];
            if other == NONE {
                return (own.dot(out) >= 0.0).then(|| out / distance);
            }
            let other_normal = &topology.normals[other as usize];
            let corners = mesh.corners(triangle);
            let along = corners[(k + 1) % 3] - corners[k];
            // Into the other triangle, across the edge.
            let into = along.cross(other_normal);
            let is_minimum = into.dot(out) <= SLACK * along.norm() * distance;
            let in_front = (own + other_normal).dot(out) > 0.0;
            (is_minimum && in_front && triangle < other).then(|| out / distance)
        }
        Region::Corner(k) => {
            let corner = mesh.faces[triangle as usize][k];
            let around = topology.around(corner);
            if around.first() != Some(&triangle)
                || topology.vertex_normals[corner as usize].dot(out) <= 0.0
            {
                return None;
            }
            let tip = mesh.vertices[corner as usize];
            let ends = around.iter().flat_map(|&number| mesh.corners(number));
            let is_minimum = ends.into_iter().all(|end| {
                let along = end - tip;
                along.dot(out) <= SLACK * along.norm() * distance
            });
            is_minimum.then(|| out / distance)
        }
    }
}

/// Returns whether the line from the centre to the contact on a triangle is free.
fn is_seen(mesh: &Mesh, near: &[Near], centre: &Vector3, push: &Push, radius: f64) -> bool {
    let place = centre - push.normal * (radius - push.depth);
    let own = mesh.faces[push.triangle as usize];
    !near.iter().any(|other| {
        let corners = &mesh.faces[other.triangle as usize];
        if corners.iter().any(|corner| own.contains(corner)) {
            return false;
        }
        let normal = &mesh.topology.normals[other.triangle as usize];
        crossing(mesh.corners(other.triangle), normal, centre, &place).is_some()
    })
}

/// Descends from a triangle to its neighbours as long as they are nearer to the centre.
fn downhill(mesh: &Mesh, from: u32, centre: &Vector3) -> (u32, Vector3, Region) {
    let look_at = |number: u32| {
        let (place, region) = nearest(mesh.corners(number), centre);
        ((centre - place).norm_squared(), number, place, region)
    };
    let mut best = look_at(from);
    for _ in 0..MAX_WALKED {
        let here = best.1;
        let corners = mesh.faces[here as usize];
        for (k, &corner) in corners.iter().enumerate() {
            for &number in mesh.topology.around(corner) {
                // Visit each triangle once: skip those at earlier corners, which include the current one.
                let is_seen = |corner: &u32| mesh.faces[number as usize].contains(corner);
                if number == here || corners[..k].iter().any(is_seen) {
                    continue;
                }
                let other = look_at(number);
                if other.0 < best.0 {
                    best = other;
                }
            }
        }
        if best.1 == here {
            break;
        }
    }
    let (_, triangle, place, region) = best;
    (triangle, place, region)
}
