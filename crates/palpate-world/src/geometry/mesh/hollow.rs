//! Concave curved surfaces that surround a sphere, and obstacles on the sphere's way out of them.
//!
//! A sphere in a conical hole is not above every face that it overlaps, and on its way out of one face it may hit
//! another. The faces directly below it are therefore not sufficient. The sphere is lifted along its way out. A face
//! also pushes if the lifted sphere is above it and overlaps it, and if both positions belong to one surface. They do
//! if a path leads from face to face over edges that are not convex and bend by less than 30 degrees, through faces
//! that the sphere overlaps. A face thus begins to push when the lifted sphere begins to touch it, and the force has
//! no jump.

use super::build::Mesh;
use super::cluster::Push;
use super::gather::{About, Gathered, MAX_TRIANGLES};
use super::triangle::{Region, inside, nearest, outside};
use crate::geometry::rigid::Vector3;

/// Radius factor of the sphere that connects the faces of one curved surface. Faces that bend by 30 degrees extend
/// beyond a sphere that touches all of them by 4 % of its radius.
const WIDE: f64 = 1.05;

/// A sphere and the triangles near it.
pub(super) struct Around<'a> {
    pub mesh: &'a Mesh,
    pub gathered: &'a mut Gathered,
    /// Triangles near the lifted sphere, if they differ.
    pub lifted: &'a mut Gathered,
    /// Centre in the mesh's axes, in front of the surface `[m]`.
    pub centre: &'a Vector3,
    pub radius: f64,
    /// Largest number of near triangles beyond the capacity.
    pub left_out: &'a mut u32,
}

/// Set of triangles near a sphere, as bits.
#[derive(Clone, Copy, Default)]
struct Numbers([u64; MAX_TRIANGLES / 64]);

impl Numbers {
    fn has(&self, number: usize) -> bool {
        self.0[number / 64] >> (number % 64) & 1 == 1
    }

    fn insert(&mut self, number: usize) {
        self.0[number / 64] |= 1 << (number % 64);
    }

    fn pop(&mut self) -> Option<usize> {
        let (word, bits) = (0..).zip(&mut self.0).find(|(_, bits)| **bits != 0)?;
        let bit = bits.trailing_zeros() as usize;
        *bits &= *bits - 1;
        Some(64 * word + bit)
    }
}

impl Around<'_> {
    /// Returns whether a near triangle continues over a concave edge. Otherwise there is no concave curved surface
    /// here.
    pub fn is_hollow(&self) -> bool {
        self.gathered.is_hollow()
    }

    /// Returns the triangles near the sphere.
    pub fn about(&mut self) -> About<'_> {
        self.gathered.about(self.mesh, self.centre, self.radius)
    }

    /// Returns the triangles near the sphere at centre `place`, within the extent of one curved surface.
    fn about_wide(&mut self, place: &Vector3) -> About<'_> {
        let wider = (WIDE - 1.0) * self.radius;
        let about = match self.gathered.held(place, wider) {
            Some(off) => self.gathered.at(off, self.radius),
            None => self.lifted.about(self.mesh, place, self.radius + wider),
        };
        *self.left_out = about.left_out.max(*self.left_out);
        about
    }

    /// Returns a predicate: whether a triangle forms one curved surface with one of the given triangles.
    pub fn reached(&mut self, from: impl Iterator<Item = u32>) -> impl Fn(u32) -> bool {
        let (mesh, centre, radius) = (self.mesh, self.centre, self.radius);
        let about = self.about_wide(centre);
        let reached = reached(mesh, &about, from, centre, WIDE * radius);
        move |triangle| {
            about
                .number(triangle)
                .is_some_and(|number| reached.has(number))
        }
    }

    /// Returns the face with the largest overlap above `slack` with the sphere lifted along `way` `[m]`, among faces
    /// below the lifted sphere that form one curved surface with the given triangles. Its depth is that before
    /// lifting.
    pub fn in_the_way(
        &mut self,
        from: impl Iterator<Item = u32> + Clone,
        way: &Vector3,
        slack: f64,
    ) -> Option<Push> {
        let (mesh, radius) = (self.mesh, self.radius);
        let goes_on = |triangle: u32| mesh.topology.bends[triangle as usize].goes_on_at_all();
        if !from.clone().any(goes_on) {
            return None; // if all edges are convex, no curved surface continues
        }
        let lifted = self.centre + way;
        let about = self.about_wide(&lifted);
        about.by_face.go_to(&lifted, about.near.len());
        let mut joined = None;
        let mut most: Option<Push> = None;
        let mut least = slack;
        let mut seen = 0;
        while let Some(number) = about.by_face.next(&mut seen) {
            let found = about.near[number];
            if from.clone().any(|triangle| triangle == found.triangle) {
                continue; // already resolved up to rounding
            }
            let normal = &mesh.topology.normals[found.triangle as usize];
            let corners = mesh.corners(found.triangle);
            let height = normal.dot(&(lifted - corners[0]));
            let short = radius - height;
            let way_over = || outside(&inside(corners, normal, &lifted));
            if short <= least || height <= 0.0 {
                let way = way_over().max(-short.min(height));
                about.by_face.spare(number, way);
                continue;
            }
            let (_, region) = nearest(corners, &lifted);
            if region != Region::Inside {
                about.by_face.spare(number, way_over());
                continue;
            }
            let joined = joined
                .get_or_insert_with(|| reached(mesh, &about, from.clone(), &lifted, WIDE * radius));
            let number = about.number(found.triangle);
            if number.is_some_and(|number| joined.has(number)) {
                least = short;
                most = Some(Push {
                    normal: *normal,
                    depth: short + normal.dot(way),
                    triangle: found.triangle,
                    is_face: true,
                });
            }
        }
        most
    }
}

/// Returns the near triangles that are connected to the given ones over continuing edges, through triangles that the
/// sphere at centre `place` overlaps.
fn reached(
    mesh: &Mesh,
    about: &About,
    from: impl Iterator<Item = u32>,
    place: &Vector3,
    radius: f64,
) -> Numbers {
    let off = (place - about.place).norm();
    let overlaps = |number: usize| {
        let near = &about.near[number];
        let (least, most) = (near.distance - off, near.distance + off);
        least < radius
            && (most < radius || {
                let (on_triangle, _) = nearest(mesh.corners(near.triangle), place);
                (place - on_triangle).norm_squared() < radius * radius
            })
    };
    let mut reached = Numbers::default();
    let mut border = Numbers::default();
    for number in from.filter_map(|triangle| about.number(triangle)) {
        reached.insert(number);
        border.insert(number);
    }
    while let Some(number) = border.pop() {
        let triangle = about.near[number].triangle as usize;
        let topology = &mesh.topology;
        for (k, &other) in topology.neighbours[triangle].iter().enumerate() {
            if !topology.bends[triangle].goes_on(k) {
                continue;
            }
            if let Some(next) = about.number(other)
                && !reached.has(next)
                && overlaps(next)
            {
                reached.insert(next);
                border.insert(next);
            }
        }
    }
    reached
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;
    use std::sync::Arc;

    use super::super::surface::{POINTS_PER_MESH, Surface};
    use super::*;
    use crate::geometry::rigid::{Rigid, Rotation};

    const RADIUS: f64 = 0.003;

    /// Returns a conical hole with `count` sides at `lean` degrees to its axis, z. Its tip is at 0, or it continues
    /// as a bore above `bore` [m].
    fn hole(count: u32, lean: f64, bore: f64) -> Arc<Mesh> {
        let ring = |from_tip: f64, z: f64| {
            let from_axis = from_tip * lean.to_radians().tan();
            (0..count).map(move |number| {
                let about = TAU * f64::from(number) / f64::from(count);
                [from_axis * about.cos(), from_axis * about.sin(), z]
            })
        };
        let next = |number: u32| (number + 1) % count;
        let (mut vertices, mut faces) = (Vec::new(), Vec::new());
        if bore > 0.0 {
            for (from_tip, z) in [(bore, bore - 0.02), (bore, bore), (0.02, 0.02)] {
                vertices.extend(ring(from_tip, z));
            }
            for (first, number) in [0, count]
                .into_iter()
                .flat_map(|first| (0..count).map(move |n| (first, n)))
            {
                let [a, b] = [number, next(number)].map(|number| first + number);
                faces.extend([[a, a + count, b + count], [a, b + count, b]]);
            }
        } else {
            vertices.push([0.0; 3]);
            vertices.extend(ring(0.02, 0.02));
            faces.extend((0..count).map(|number| [0, 1 + number, 1 + next(number)]));
        }
        Arc::new(Mesh::new(&vertices, &faces).unwrap())
    }

    /// Returns the sum of the surface's pushes on a sphere [m], at each position of a path.
    fn along(mesh: &Arc<Mesh>, way: impl Iterator<Item = Vector3>) -> Vec<(Vector3, Vector3)> {
        let at = |position| Rigid {
            position,
            orientation: Rotation::identity(),
            velocity: Vector3::zeros(),
            spin: Vector3::zeros(),
        };
        let mut surface = Surface::new(mesh.clone(), [0, 1], Vector3::zeros(), RADIUS);
        surface.look(&at(Vector3::z() * 0.012), &at(Vector3::zeros()));
        way.map(|place| {
            surface.look(&at(place), &at(Vector3::zeros()));
            assert_eq!(surface.take_left_out(), 0);
            let found = (0..POINTS_PER_MESH).filter_map(|point| surface.found(point));
            let pushes = found.map(|found| found.normal * (RADIUS - found.distance));
            (place, pushes.sum())
        })
        .collect()
    }

    /// The way out of a convex hollow changes by at most the displacement, and the work over a closed path is zero.
    #[test]
    #[allow(clippy::print_stdout)] // prints the measured values
    fn the_force_in_a_conical_hole_has_no_jump() {
        let holes = [12, 13, 24, 64].into_iter().flat_map(|count| {
            let leans = [
                (30.0, 0.0),
                (45.0, 0.0),
                (59.0, 0.0),
                (45.0, 0.0003),
                (59.0, 0.0001),
            ];
            leans.map(|(lean, bore)| (count, lean, bore))
        });
        for (count, lean, bore) in holes {
            let mesh = hole(count, lean, bore);
            let tip = RADIUS / lean.to_radians().sin();
            let (mut jump, mut work, mut largest) = (0.0_f64, 0.0_f64, 0.0_f64);
            for (below, beside, turn) in [
                (3e-4, 0.0, 0.1_f64),
                (2e-4, 1e-4, 1.3),
                (-2e-4, 0.0, 0.7),
                (8e-4, 2e-4, 2.9),
            ] {
                let (sine, cosine) = turn.sin_cos();
                let line = (-200..=200).map(|k| {
                    let x = 6e-6 * f64::from(k);
                    Vector3::new(
                        cosine * x - sine * beside,
                        sine * x + cosine * beside,
                        tip - below,
                    )
                });
                for two in along(&mesh, line).windows(2) {
                    let change = (two[1].1 - two[0].1).norm() - (two[1].0 - two[0].0).norm();
                    jump = jump.max(change);
                    largest = largest.max(two[0].1.norm());
                }
                let ring = (0..=2000).map(|k| {
                    let about = TAU * f64::from(k) / 2000.0;
                    let up = tip - below + 1e-4 * (2.0 * about + turn).sin();
                    Vector3::new(4e-4 * about.cos() + 2.0 * beside, 6e-4 * about.sin(), up)
                });
                let closed: f64 = along(&mesh, ring)
                    .windows(2)
                    .map(|two| 0.5 * (two[0].1 + two[1].1).dot(&(two[1].0 - two[0].0)))
                    .sum();
                work = work.max(closed.abs());
            }
            println!(
                "{count} sides at {lean} degrees, bore {bore}: jump {jump:.1e} of {largest:.1e} m, work {work:.1e} m2"
            );
            assert!(largest > 1e-3 && jump < 1e-14 && work < 5e-12);
        }
    }

    /// More small triangles than the capacity are in reach of the lifted, enlarged sphere, but not of the sphere
    /// itself.
    #[test]
    fn triangles_about_a_lifted_sphere_that_do_not_fit_are_said() {
        const SIDES: u32 = 24;
        const PARTS: u32 = 8;
        let (sine, _) = 45.0_f64.to_radians().sin_cos();
        let foot = 0.003;
        let corner = |slant: f64, side: u32, part: u32| {
            let [from, to] = [side, side + 1].map(|number| {
                let about = TAU * f64::from(number) / f64::from(SIDES);
                Vector3::new(about.cos(), about.sin(), 1.0) * slant * sine
            });
            let place = from + (to - from) * (f64::from(part) / f64::from(PARTS));
            <[f64; 3]>::from(place)
        };
        let mut vertices = vec![[0.0; 3]];
        vertices.extend((0..SIDES).map(|side| corner(foot, side, 0)));
        let all = SIDES * PARTS;
        for slant in [foot + 0.001, foot + 0.00105] {
            vertices.extend((0..all).map(|k| corner(slant, k / PARTS, k % PARTS)));
        }
        let mut faces = Vec::new();
        for side in 0..SIDES {
            let [a, b] = [side, side + 1].map(|number| 1 + number % SIDES);
            faces.push([0, a, b]);
            let on_ring = |k: u32| 1 + SIDES + k % all;
            for k in side * PARTS..(side + 1) * PARTS {
                let [c, d] = [k, k + 1].map(on_ring);
                faces.extend([[a, c, d], [c, c + all, d + all], [c, d + all, d]]);
            }
            faces.push([a, on_ring((side + 1) * PARTS), b]);
        }
        let mesh = Arc::new(Mesh::new(&vertices, &faces).unwrap());
        let left_out = |below: f64| {
            let at = |position| Rigid {
                position,
                orientation: Rotation::identity(),
                velocity: Vector3::zeros(),
                spin: Vector3::zeros(),
            };
            let mut surface = Surface::new(mesh.clone(), [0, 1], Vector3::zeros(), RADIUS);
            let tip = RADIUS / sine;
            for height in [0.012, tip - below] {
                surface.look(&at(Vector3::z() * height), &at(Vector3::zeros()));
            }
            surface.take_left_out()
        };
        assert_eq!(left_out(-1e-4), 0);
        assert!(left_out(2e-4) > 0);
    }
}
