//! The triangles about a place, kept while a sphere stays near it.

use super::build::Mesh;
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
    place: Vector3,
    /// How far the centre may be from the place; below 0 before anything was gathered `[m]`.
    way: f64,
    left_out: u32,
}

/// What [`Gathered::about`] finds.
#[derive(Clone, Copy, Debug)]
pub(super) struct About<'a> {
    pub near: &'a [Near],
    pub off: f64,
    pub reach: f64,
    /// Triangles within the sphere that did not fit, the furthest ones.
    pub left_out: u32,
}

/// How far a centre may go before triangles are gathered anew: this, and a share of the radius `[m]`.
const WAY: f64 = 2e-4;
const SHARE_OF_RADIUS: f64 = 0.02;
/// The least share of that, where there are many triangles.
const LEAST_SHARE: f64 = 0.2;
/// Most triangles that are looked at to find the nearest ones.
const MOST_SEEN: usize = 1024;

impl Gathered {
    pub fn none() -> Self {
        let nothing = Near {
            triangle: 0,
            distance: f64::INFINITY,
        };
        Self {
            near: vec![nothing; MOST_SEEN].into(),
            count: 0,
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
            off,
            reach: radius + self.way,
            left_out: self.left_out,
        }
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
    }
}
