//! The triangles about a place, kept while a sphere stays near it.

use super::build::Mesh;
use super::topology::NONE;
use super::tree::size;
use super::triangle;
use crate::rigid::Vector3;

/// Most triangles that are looked at in a sub-step.
pub(super) const MOST_TRIANGLES: usize = 256;

/// A triangle, and how far it was from the place at which it was gathered `[m]`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    pub triangle: u32,
    pub distance: f64,
}

/// The triangles that a sphere can touch while its centre stays within a way of a place. What they are does not depend
/// on when they were gathered, so a tick has the same forces with any.
#[derive(Clone, Debug)]
pub(super) struct Gathered {
    near: Box<[Near]>,
    count: usize,
    /// Of those, how many come first on which the distance may have a minimum.
    pushing: usize,
    /// Least distance of the others `[m]`.
    others: f64,
    /// Whether one of them goes on over a hollow edge.
    is_hollow: bool,
    /// Which number each triangle of the mesh has, if it is one of them.
    numbers: Box<[u16]>,
    place: Vector3,
    /// How far the centre may be from the place; below 0 before anything was gathered `[m]`.
    way: f64,
    left_out: u32,
}

/// What [`Gathered::about`] finds.
#[derive(Clone, Copy, Debug)]
pub(super) struct About<'a> {
    pub near: &'a [Near],
    /// How many of them, the first ones, may push a centre that is within the way.
    pub pushing: usize,
    /// Least distance of the others at the place `[m]`.
    pub others: f64,
    pub off: f64,
    pub reach: f64,
    /// Where they were gathered.
    pub place: Vector3,
    numbers: &'a [u16],
    /// Triangles within the sphere that did not fit, the furthest ones.
    pub left_out: u32,
}

impl About<'_> {
    /// Which of them a triangle is.
    pub fn number(&self, triangle: u32) -> Option<usize> {
        let number = usize::from(self.numbers[triangle as usize]);
        // Of other triangles the number may be from an earlier time.
        (self.near.get(number)?.triangle == triangle).then_some(number)
    }
}

/// How far a centre may go before triangles are gathered anew: this, and a share of the radius `[m]`.
const WAY: f64 = 2e-4;
const SHARE_OF_RADIUS: f64 = 0.02;
/// The least share of that, where there are many triangles.
const LEAST_SHARE: f64 = 0.2;
/// Most triangles that are looked at to find the nearest ones.
const MOST_SEEN: usize = 1024;

impl Gathered {
    /// Of a mesh of so many triangles.
    pub fn none(triangles: usize) -> Self {
        let nothing = Near {
            triangle: 0,
            distance: f64::INFINITY,
        };
        Self {
            near: vec![nothing; MOST_SEEN].into(),
            count: 0,
            pushing: 0,
            others: f64::INFINITY,
            is_hollow: false,
            numbers: vec![0; triangles].into(),
            place: Vector3::zeros(),
            way: -1.0,
            left_out: 0,
        }
    }

    /// The triangles that a sphere of `radius` `[m]` about `centre` may touch, and how far the centre is from where
    /// they were gathered `[m]`: none of them is nearer than its distance there less that. Nothing else is nearer to that
    /// place than `reach` `[m]`.
    pub fn about(&mut self, mesh: &Mesh, centre: &Vector3, radius: f64) -> About<'_> {
        let mut off = (centre - self.place).norm();
        // A centre that is no number finds nothing.
        if off > self.way || off.is_nan() {
            self.gather(mesh, centre, radius);
            off = 0.0;
        }
        About {
            near: &self.near[..self.count],
            pushing: self.pushing,
            others: self.others,
            off,
            reach: radius + self.way,
            place: self.place,
            numbers: &self.numbers,
            left_out: self.left_out,
        }
    }

    /// Whether these are the triangles that a sphere with that centre may touch, and all that are `more` further away `[m]`.
    pub fn holds(&self, centre: &Vector3, more: f64) -> bool {
        (centre - self.place).norm() + more <= self.way
    }

    /// Whether one of the triangles about the place goes on over a hollow edge.
    pub fn is_hollow(&self) -> bool {
        self.is_hollow
    }

    fn gather(&mut self, mesh: &Mesh, centre: &Vector3, radius: f64) {
        let most = WAY + SHARE_OF_RADIUS * radius;
        let reach = radius + most;
        let mut count = 0;
        let near = &mut self.near;
        let is_all = mesh.tree.within(centre, reach, |number| {
            let (nearest, _) = triangle::nearest(mesh.corners(number), centre);
            let distance = (centre - nearest).norm();
            if distance > reach {
                return true;
            }
            let has_room = count < near.len();
            if has_room {
                near[count] = Near {
                    triangle: number,
                    distance,
                };
                count += 1;
            }
            has_room
        });
        self.place = *centre;
        self.way = most;
        self.count = count.min(MOST_TRIANGLES);
        self.left_out = u32::from(!is_all);
        if count > MOST_TRIANGLES {
            let by_distance = |a: &Near, b: &Near| a.distance.total_cmp(&b.distance);
            let found = &mut near[..count];
            let (_, first_out, out) = found.select_nth_unstable_by(MOST_TRIANGLES, by_distance);
            // All that are nearer than the first that does not fit are there.
            self.way = (first_out.distance - radius).clamp(LEAST_SHARE * most, most);
            let within = radius + self.way;
            let is_within = |it: &&Near| it.distance < within;
            let left_out = std::iter::once(&*first_out).chain(&*out).filter(is_within);
            self.left_out += size(left_out.count());
        }
        self.pushing = 0;
        self.others = f64::INFINITY;
        self.is_hollow = false;
        for number in 0..self.count {
            let near = self.near[number];
            self.is_hollow |= mesh.topology.bends[near.triangle as usize].is_hollow();
            if may_push(mesh, near.triangle, centre, self.way) {
                self.near.swap(number, self.pushing);
                self.pushing += 1;
            } else {
                self.others = self.others.min(near.distance);
            }
        }
        for (number, near) in (0_u16..).zip(&self.near[..self.count]) {
            self.numbers[near.triangle as usize] = number;
        }
    }
}

/// Whether the distance of a centre within `way` `[m]` of `centre` may have a minimum inside of a triangle, on one of its edges or
/// at one of its corners. Of the many triangles below a large sphere few pass, and only these are looked at in a sub-step.
fn may_push(mesh: &Mesh, triangle: u32, centre: &Vector3, way: f64) -> bool {
    let corners = mesh.corners(triangle);
    let normals = &mesh.topology.normals;
    let own = &normals[triangle as usize];
    let along = [0, 1, 2].map(|k| corners[(k + 1) % 3] - corners[k]);
    let off = corners.map(|corner| centre - corner);
    // The way times the length of each edge, squared: what is compared has the length of the edge as a factor.
    let square = along.map(|along| way * way * along.norm_squared());
    let is_least = |value: f64, k: usize| value >= 0.0 || value * value <= square[k];
    let is_most = |value: f64, k: usize| is_least(-value, k);
    // How far the centre is inside of each edge, as it is seen along the normal of one of the two triangles there.
    let inside = [0, 1, 2].map(|k| own.cross(&along[k]).dot(&off[k]));
    if (0..3).all(|k| is_least(inside[k], k)) {
        return true;
    }
    (0..3).any(|k| {
        let before = (k + 2) % 3;
        // Beyond a corner, against both edges that end there.
        let of_corner = || {
            is_most(along[k].dot(&off[k]), k)
                && is_least(along[before].dot(&off[k]), before)
                && is_beyond_all(mesh, mesh.faces[triangle as usize][k], &off[k], way)
        };
        let of_edge = || {
            is_most(inside[k], k)
                && match mesh.topology.neighbours[triangle as usize][k] {
                    NONE => true,
                    other => {
                        let normal = &normals[other as usize];
                        is_most(along[k].cross(normal).dot(&off[k]), k)
                    }
                }
        };
        of_edge() || of_corner()
    })
}

/// Whether a place that is `off` a vertex is beyond the end of all edges there, but for `way`.
fn is_beyond_all(mesh: &Mesh, vertex: u32, off: &Vector3, way: f64) -> bool {
    let around = mesh.topology.around(vertex);
    around.iter().all(|&number| {
        let corners = mesh.faces[number as usize];
        let next = (0..3)
            .find(|&k| corners[k] == vertex)
            .map_or(0, |k| (k + 1) % 3);
        let ends = [next, (next + 1) % 3].map(|k| mesh.vertices[corners[k] as usize]);
        ends.iter().all(|end| {
            let along = end - mesh.vertices[vertex as usize];
            along.dot(off) <= way * along.norm()
        })
    })
}

#[cfg(test)]
mod tests {
    use super::super::surface::minimum;
    use super::*;

    /// Bumps and hollows with edges of about a tenth.
    fn bumps() -> Mesh {
        let row = 21_u32;
        let at = |k: u32| 0.1 * f64::from(k) - 1.0;
        let vertices: Vec<_> = (0..row * row)
            .map(|k| {
                let (x, y) = (at(k % row), at(k / row));
                [x, y, 0.15 * (5.0 * x).sin() * (4.0 * y).cos()]
            })
            .collect();
        let squares = (0..row - 1).flat_map(|i| (0..row - 1).map(move |j| j * row + i));
        let faces: Vec<_> = squares
            .flat_map(|a| [[a, a + 1, a + row + 1], [a, a + row + 1, a + row]])
            .collect();
        Mesh::new(&vertices, &faces).unwrap()
    }

    /// Every triangle on which a centre within the way has a minimum is among those that may push; most others are not.
    #[test]
    fn no_triangle_that_pushes_is_left_out() {
        let mesh = bumps();
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
                let may = may_push(&mesh, triangle, &centre, way);
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
}
