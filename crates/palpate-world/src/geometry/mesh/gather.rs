//! Cache of the triangles near a sphere.

use super::build::Mesh;
use super::spared::Spared;
use super::topology::NONE;
use super::tree::size;
use super::triangle;
use crate::geometry::rigid::Vector3;

/// Maximum number of triangles considered in a sub-step.
pub(super) const MAX_TRIANGLES: usize = 256;

/// A triangle, and its distance from the cache centre `[m]`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    pub triangle: u32,
    pub distance: f64,
}

/// The triangles that a sphere can touch while its centre stays within a distance of the cache centre. Results do not
/// depend on when they were gathered, so the forces of a tick are independent of the cache state.
#[derive(Clone, Debug)]
pub(super) struct Gathered {
    near: Box<[Near]>,
    count: usize,
    /// Smallest distance `[m]`.
    least: f64,
    /// Whether one of the triangles continues over a concave edge.
    is_hollow: bool,
    /// Index in the cache of each triangle of the mesh, if present.
    numbers: Box<[u16]>,
    place: Vector3,
    /// Validity radius: allowed distance of the sphere's centre from the cache centre; negative before the first use
    /// `[m]`.
    way: f64,
    /// Factor on the default validity radius for the next attempt; smaller where triangles are dense.
    times: f64,
    /// Schedule of the search for minima of the distance.
    by_minimum: Spared,
    /// Schedule of the search for faces below the sphere.
    by_face: Spared,
    left_out: u32,
}

/// Result of [`Gathered::about`].
#[derive(Debug)]
pub(super) struct About<'a> {
    pub near: &'a [Near],
    /// Smallest distance from the cache centre `[m]`.
    pub least: f64,
    pub off: f64,
    pub reach: f64,
    /// Cache centre.
    pub place: Vector3,
    numbers: &'a [u16],
    /// Schedule of the search for minima of the distance within the radius.
    pub by_minimum: &'a mut Spared,
    /// Schedule of the search for faces that come below the sphere.
    pub by_face: &'a mut Spared,
    /// Number of triangles within the sphere beyond the capacity (the most distant ones).
    pub left_out: u32,
}

impl About<'_> {
    /// Returns the cache index of a triangle.
    pub fn number(&self, triangle: u32) -> Option<usize> {
        let number = usize::from(self.numbers[triangle as usize]);
        // The stored index of other triangles may be out of date.
        (self.near.get(number)?.triangle == triangle).then_some(number)
    }
}

/// Default validity radius: this value plus a fraction of the sphere's radius `[m]`.
const WAY: f64 = 2e-4;
const SHARE_OF_RADIUS: f64 = 0.02;
/// Maximum factor on the default validity radius, where triangles are sparse.
const MAX_TIMES: f64 = 2.0;
/// Minimum fraction of the default validity radius, where triangles are dense.
const MIN_SHARE: f64 = 0.2;
/// Maximum number of triangles in the search for the nearest ones.
const MAX_SEEN: usize = 1024;

impl Gathered {
    /// Creates an empty cache for a mesh with this number of triangles.
    pub fn none(triangles: usize) -> Self {
        let nothing = Near {
            triangle: 0,
            distance: f64::INFINITY,
        };
        Self {
            near: vec![nothing; MAX_SEEN].into(),
            count: 0,
            least: f64::INFINITY,
            is_hollow: false,
            numbers: vec![0; triangles].into(),
            place: Vector3::zeros(),
            way: -1.0,
            times: MAX_TIMES,
            by_minimum: Spared::none(),
            by_face: Spared::none(),
            left_out: 0,
        }
    }

    /// Returns the triangles that a sphere of `radius` `[m]` at `centre` may touch, and the distance `off` of the
    /// centre from the cache centre `[m]`. The distance of a triangle is at least its cached distance minus `off`.
    /// All other triangles are at least `reach` from the cache centre `[m]`.
    #[inline]
    pub fn about(&mut self, mesh: &Mesh, centre: &Vector3, radius: f64) -> About<'_> {
        let mut off = (centre - self.place).norm();
        // A NaN centre finds no triangle.
        if off > self.way || off.is_nan() {
            self.gather(mesh, centre, radius);
            off = 0.0;
        }
        self.at(off, radius)
    }

    /// Returns the cached triangles for a centre at a distance `off` from the cache centre `[m]`.
    #[inline]
    pub fn at(&mut self, off: f64, radius: f64) -> About<'_> {
        About {
            near: &self.near[..self.count],
            least: self.least,
            off,
            reach: radius + self.way,
            place: self.place,
            numbers: &self.numbers,
            by_minimum: &mut self.by_minimum,
            by_face: &mut self.by_face,
            left_out: self.left_out,
        }
    }

    /// Returns the distance of a centre from the cache centre `[m]`, if the cache contains all triangles that a
    /// sphere there may touch, enlarged by `more` `[m]`.
    pub fn held(&self, centre: &Vector3, more: f64) -> Option<f64> {
        let off = (centre - self.place).norm();
        (off + more <= self.way).then_some(off)
    }

    /// Returns whether one of the cached triangles continues over a concave edge.
    pub fn is_hollow(&self) -> bool {
        self.is_hollow
    }

    #[cold]
    #[inline(never)]
    fn gather(&mut self, mesh: &Mesh, centre: &Vector3, radius: f64) {
        let way = WAY + SHARE_OF_RADIUS * radius;
        let least_way = MIN_SHARE * way;
        let mut most = self.times * way;
        let mut seen = self.see(mesh, centre, radius + most, radius + least_way);
        if !seen.had_room && self.times > 1.0 {
            most = way;
            seen = self.see(mesh, centre, radius + most, radius + least_way);
        }
        let count = seen.count;
        self.times = if !seen.had_room {
            1.0
        } else if count > MAX_TRIANGLES {
            (0.5 * self.times).max(1.0)
        } else if 4 * count < MAX_TRIANGLES {
            (2.0 * self.times).min(MAX_TIMES)
        } else {
            self.times
        };
        self.place = *centre;
        self.way = most;
        self.count = count.min(MAX_TRIANGLES);
        self.left_out = seen.too_many;
        if count > MAX_TRIANGLES {
            let found = &mut self.near[..count];
            let (_, first_out, out) = found.select_nth_unstable_by(MAX_TRIANGLES, by_distance);
            // The cache contains all triangles nearer than the first one that does not fit.
            self.way = (first_out.distance - radius).max(least_way).min(most);
            let within = radius + self.way;
            let is_within = |it: &&Near| it.distance < within;
            let left_out = std::iter::once(&*first_out).chain(&*out).filter(is_within);
            self.left_out += size(left_out.count());
        }
        self.least = f64::INFINITY;
        self.is_hollow = false;
        for near in &self.near[..self.count] {
            self.least = self.least.min(near.distance);
            self.is_hollow |= mesh.topology.bends[near.triangle as usize].is_hollow();
        }
        let near = &self.near[..self.count];
        let ways = || near.iter().map(|near| near.distance - radius);
        let reach = radius + most;
        self.by_minimum.begin(centre, reach, ways());
        self.by_face.begin(centre, reach, ways());
        for (number, near) in (0_u16..).zip(&self.near[..self.count]) {
            self.numbers[near.triangle as usize] = number;
        }
    }

    /// Fills `near` with the triangles within `reach` of a position `[m]`, or with the nearest ones if the capacity
    /// is exceeded. Counts the visited triangles within `least` `[m]` that did not fit.
    fn see(&mut self, mesh: &Mesh, place: &Vector3, reach: f64, least: f64) -> Seen {
        let near = &mut self.near;
        let mut reach = reach;
        let mut seen = Seen {
            count: 0,
            had_room: true,
            too_many: 0,
        };
        mesh.tree.nearest(place, |number| {
            let (nearest, _) = triangle::nearest(mesh.corners(number), place);
            let distance = (place - nearest).norm();
            if distance <= reach && seen.count == near.len() {
                // From here on the search accepts only nearer triangles.
                let (_, furthest, out) = near.select_nth_unstable_by(MAX_TRIANGLES, by_distance);
                reach = furthest.distance;
                let is_counted = |it: &&Near| it.distance < least;
                seen.too_many += size(out.iter().filter(is_counted).count());
                (seen.count, seen.had_room) = (MAX_TRIANGLES + 1, false);
            }
            if distance <= reach {
                near[seen.count] = Near {
                    triangle: number,
                    distance,
                };
                seen.count += 1;
            } else if !seen.had_room && distance < least {
                seen.too_many += 1;
            }
            reach * reach
        });
        seen
    }
}

/// Result of [`Gathered::see`].
struct Seen {
    count: usize,
    /// Whether all triangles fitted.
    had_room: bool,
    /// Number of near triangles that did not fit.
    too_many: u32,
}

fn by_distance(a: &Near, b: &Near) -> std::cmp::Ordering {
    a.distance.total_cmp(&b.distance)
}

/// Returns a lower bound of the distance that a centre must travel until its distance may have a minimum inside a
/// triangle, on one of its edges or at one of its corners `[m]`. For a large sphere few of the many triangles are
/// close to that, and only these are evaluated in a sub-step.
pub(super) fn way_to_push(mesh: &Mesh, triangle: u32, centre: &Vector3) -> f64 {
    let corners = mesh.corners(triangle);
    let normals = &mesh.topology.normals;
    let own = &normals[triangle as usize];
    let along = triangle::edges(corners);
    let off = [
        centre - corners[0],
        centre - corners[1],
        centre - corners[2],
    ];
    let lengths = [along[0].norm(), along[1].norm(), along[2].norm()];
    // Signed distances of the centre from each edge line, and beyond its two ends.
    let inside = triangle::inside_of(&along, &lengths, own, &off);
    let begin = |k: usize| -along[k].dot(&off[k]) / lengths[k];
    let before = [begin(0), begin(1), begin(2)];
    let end = |k: usize| -before[k] - lengths[k];
    let after = [end(0), end(1), end(2)];
    let mut least = triangle::outside(&inside);
    for k in 0..3 {
        // A minimum on an edge is attributed to the first of its triangles.
        let of_edge = inside[k].max(before[k]).max(after[k]).max(0.0);
        if of_edge < least {
            let beyond = match mesh.topology.neighbours[triangle as usize][k] {
                NONE => 0.0,
                other if other < triangle => f64::INFINITY,
                other => along[k].cross(&normals[other as usize]).dot(&off[k]) / lengths[k],
            };
            least = of_edge.max(beyond).min(least);
        }
        // Distance beyond a corner, with respect to both edges that end there.
        let of_two = (-before[k]).max(-after[(k + 2) % 3]);
        if of_two < least {
            least = way_beyond_all(mesh, triangle, k, &off[k], least);
        }
    }
    least
}

/// Returns a lower bound of the distance that a position at `off` from a triangle's corner must travel to be beyond
/// the end of all edges there `[m]`, if it is less than `most` `[m]` and a minimum at this corner is attributed to
/// this triangle.
fn way_beyond_all(mesh: &Mesh, triangle: u32, corner: usize, off: &Vector3, most: f64) -> f64 {
    let vertex = mesh.faces[triangle as usize][corner];
    let around = mesh.topology.around(vertex);
    if around.first() != Some(&triangle) {
        return most;
    }
    let mut way = 0.0_f64;
    for end in around
        .iter()
        .flat_map(|&number| mesh.faces[number as usize])
    {
        if end == vertex {
            continue;
        }
        let along = mesh.vertices[end as usize] - mesh.vertices[vertex as usize];
        way = way.max(along.dot(off) / along.norm());
        if way >= most {
            return most;
        }
    }
    way
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::super::surface::{Surface, minimum};
    use super::*;
    use crate::geometry::rigid::{Rigid, Rotation};

    /// Returns bumps and hollows with edges of about a tenth of a size.
    fn bumps(size: f64) -> Mesh {
        let row = 21_u32;
        let at = |k: u32| 0.1 * f64::from(k) - 1.0;
        let vertices: Vec<_> = (0..row * row)
            .map(|k| {
                let (x, y) = (at(k % row), at(k / row));
                [x, y, 0.15 * (5.0 * x).sin() * (4.0 * y).cos()].map(|x| size * x)
            })
            .collect();
        let squares = (0..row - 1).flat_map(|i| (0..row - 1).map(move |j| j * row + i));
        let faces: Vec<_> = squares
            .flat_map(|a| [[a, a + 1, a + row + 1], [a, a + row + 1, a + row]])
            .collect();
        Mesh::new(&vertices, &faces).unwrap()
    }

    /// All triangles with a minimum for a centre within the validity radius are scheduled; most others are not.
    #[test]
    fn no_triangle_that_pushes_is_left_out() {
        let mesh = bumps(1.0);
        let part = |k: u32, prime: f64| 2.0 * (f64::from(k) * prime).fract() - 1.0;
        let (mut minima, mut looked_at, mut all) = (0, 0, 0);
        for case in 1..300_u32 {
            let vector = |shift: f64| {
                let at = [0.618_034, 0.414_214, 0.732_051].map(|prime| part(case, prime + shift));
                Vector3::from(at)
            };
            let centre =
                vector(0.0).component_mul(&Vector3::new(0.9, 0.9, 0.4)) + Vector3::z() * 0.4;
            let way = 0.02 * f64::from(case % 3);
            let moved = centre + vector(0.1).normalize() * (0.999 * way);
            for triangle in 0..size(mesh.faces.len()) {
                let (place, region) = triangle::nearest(mesh.corners(triangle), &moved);
                let out = moved - place;
                let may = way_to_push(&mesh, triangle, &centre) <= way;
                if minimum(&mesh, triangle, region, &out, out.norm()).is_some() {
                    assert!(may, "{case} {triangle} {region:?}");
                    minima += 1;
                }
                looked_at += u32::from(may);
                all += 1;
            }
        }
        assert!(
            minima > 300 && looked_at < all / 10,
            "{minima} {looked_at} {all}"
        );
    }

    /// Along a path to and fro over bumps and hollows, in long and short steps, each evaluation gives the same result
    /// as with an empty cache.
    #[test]
    fn what_is_left_alone_for_a_while_does_not_push() {
        let size = 0.01;
        let mesh = Arc::new(bumps(size));
        let at = |position| Rigid {
            position,
            orientation: Rotation::identity(),
            velocity: Vector3::zeros(),
            spin: Vector3::zeros(),
        };
        let (mut several, mut touched) = (0, 0);
        for (radius, above) in [(0.04, 0.02), (0.3, 0.25), (0.6, 0.5)] {
            let new = || Surface::new(mesh.clone(), [0, 1], Vector3::zeros(), size * radius);
            let mut surface = new();
            // The second surface is at another position, and both exchange their caches.
            let mut other = new();
            let mut look = |time: f64| {
                let (x, y) = (0.6 * (1.1 * time).sin(), 0.6 * (1.7 * time).cos());
                let height = 0.15 * (5.0 * x).sin() * (4.0 * y).cos();
                let place = Vector3::new(x, y, height + above + 0.02 * (9.0 * time).sin());
                let place = place * size;
                let mut anew = new();
                anew.copy_from(&surface);
                anew.look(&at(place), &at(Vector3::zeros()));
                other.look(&at(place + Vector3::x() * 1e-4), &at(Vector3::zeros()));
                surface.exchange_gathered(&mut other);
                surface.look(&at(place), &at(Vector3::zeros()));
                let found = |surface: &Surface| [0, 1, 2, 3].map(|k| surface.found(k).copied());
                assert_eq!(found(&surface), found(&anew), "{radius} {time}");
                let count = found(&surface).iter().flatten().count();
                touched += u32::from(count > 0);
                several += u32::from(count > 1);
            };
            for step in 0..3000_u32 {
                let time = 2e-4 * f64::from(step) * (1.0 + f64::from(step / 1000));
                look(time);
                if step % 7 == 0 {
                    look(time + 0.02);
                }
            }
        }
        assert!(touched > 5000 && several > 500, "{touched} {several}");
    }

    /// If more triangles lie within the maximum validity radius than the capacity, the radius is reduced, and no
    /// touched triangle is omitted.
    #[test]
    fn among_many_triangles_the_way_is_shorter() {
        let (row, cell) = (61_u32, 5.8e-5);
        let vertices: Vec<_> = (0..row * row)
            .map(|k| [k % row, k / row].map(|k| cell * (f64::from(k) - 30.0)))
            .map(|[x, y]| [x, y, 0.0])
            .collect();
        let squares = (0..row - 1).flat_map(|i| (0..row - 1).map(move |j| j * row + i));
        let faces: Vec<_> = squares
            .flat_map(|a| [[a, a + 1, a + row + 1], [a, a + row + 1, a + row]])
            .collect();
        let mesh = Mesh::new(&vertices, &faces).unwrap();
        let radius = 5e-4;
        let centre = Vector3::new(1e-5, 2e-5, 4.6e-4);
        let mut gathered = Gathered::none(faces.len());
        let way = WAY + SHARE_OF_RADIUS * radius;
        let seen = gathered.see(&mesh, &centre, radius + MAX_TIMES * way, 0.0);
        assert!(
            !seen.had_room,
            "the mesh has too few triangles for this test"
        );
        let moved = centre + Vector3::new(0.6, 0.0, -0.8) * (0.9 * MIN_SHARE * way);
        let mut touched = 0;
        for place in [centre, moved] {
            let about = gathered.about(&mesh, &place, radius);
            assert_eq!(about.left_out, 0);
            assert!(place == centre || about.off > 0.0, "it was gathered anew");
            for triangle in 0..size(mesh.faces.len()) {
                let nearest = triangle::nearest_point(mesh.corners(triangle), &place);
                if (place - nearest).norm() < radius {
                    assert!(about.number(triangle).is_some(), "{triangle}");
                    touched += 1;
                }
            }
        }
        assert!(touched > 100, "{touched}");
    }

    /// At the pole of a latitude-longitude sphere more triangles are in reach than the capacity: the nearest ones are
    /// kept.
    #[test]
    fn of_too_many_triangles_the_nearest_are_kept() {
        let (rings, radius) = (200_u32, 0.04);
        let at = |ring: u32, meridian: u32| {
            let [polar, around] =
                [1.0, 2.0].map(|turns| turns * std::f64::consts::PI / f64::from(rings));
            let (sin, cos) = (polar * f64::from(ring)).sin_cos();
            let (y, x) = (around * f64::from(meridian)).sin_cos();
            [radius * sin * x, radius * sin * y, radius * cos]
        };
        let vertices: Vec<_> = (0..=rings)
            .flat_map(|ring| (0..rings).map(move |meridian| at(ring, meridian)))
            .collect();
        let squares = (0..rings)
            .flat_map(|i| (0..rings).map(move |j| [i * rings + j, i * rings + (j + 1) % rings]));
        let faces: Vec<_> = squares
            .flat_map(|[a, b]| [[a, a + rings, b + rings], [a, b + rings, b]])
            .collect();
        let mesh = Mesh::new(&vertices, &faces).unwrap();
        assert!(mesh.is_closed());
        let mut gathered = Gathered::none(mesh.faces.len());
        let mut was_too_many = 0;
        for step in 0..40_u32 {
            let tilt = 2e-3 * (f64::from(step) - 20.0);
            let centre = Vector3::new(tilt.sin(), 1e-4, tilt.cos()) * (radius + 0.002);
            let about = gathered.about(&mesh, &centre, 0.003);
            let all = (0..size(mesh.faces.len())).map(|triangle| {
                let nearest = triangle::nearest_point(mesh.corners(triangle), &centre);
                (centre - nearest).norm()
            });
            let least = all.fold(f64::INFINITY, f64::min);
            let of_near = about.near.iter().map(|near| {
                let nearest = triangle::nearest_point(mesh.corners(near.triangle), &centre);
                (centre - nearest).norm()
            });
            assert_eq!(of_near.fold(f64::INFINITY, f64::min), least, "{tilt}");
            was_too_many += u32::from(about.left_out > 0);
        }
        assert!(was_too_many > 10, "{was_too_many}");
    }
}
