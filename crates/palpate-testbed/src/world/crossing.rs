//! Planes that touch a rim of each of two cylinders.
//!
//! The line between the two points that such a plane touches is along its normal, hence perpendicular to both rims: the
//! two points are closest points of the two circles. The closest point of the larger circle is known for each point of
//! the smaller one, which leaves a single root. The normal is perpendicular to both tangents.

use super::cylinder::Lying;
use super::ridders::falls_through_zero;
use super::tangent::Turn;
use super::tube::{Moving, Tube, side_of};
use super::vector::Vec3;

/// Number of points at which the distance between the rims is evaluated: around a whole rim, and near a named point.
const AROUND: usize = 64;
const NEARBY: usize = 8;
/// Search range for a plane about its previous angle, in name steps.
const ABOUT: f64 = 3.0;
/// Number of points that are evaluated next to a root, each half as far from it as the one before.
const BESIDE: i32 = 8;
/// Sine of the angle of parallel tangents.
const PARALLEL: f64 = 1e-6;

/// A rim of the cylinder and one of the other, and how their tangents cross: two places where they cross in the two
/// ways can be near to each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Crossing {
    pub rims: [u8; 2],
    is_left: bool,
}

/// A place of the smaller circle and the nearest one of the larger.
struct Near {
    /// Half of the slope of the squared way between the two.
    slope: f64,
    /// Out of the cylinder with the smaller circle.
    normal: Vec3,
    overlap: f64,
    is_left: bool,
    /// Whether the plane has both cylinders on their sides and less overlap than those beside it.
    is_between: bool,
    /// For both rims: the points, the outward directions there, and the tangents.
    places: [Vec3; 2],
    out: [Vec3; 2],
    along: [Vec3; 2],
}

/// The places from `low` to `high` at which a function rises through 0. Those beside a root may be close to it.
fn rises(of: impl Fn(f64) -> f64, low: f64, high: f64, count: usize) -> Vec<f64> {
    let at = |number: usize| low + (high - low) * number as f64 / count as f64;
    let root = |low: f64, high: f64| falls_through_zero(|place| -of(place), low, high);
    let mut found = Vec::new();
    let mut before = of(low);
    for number in 1..=count {
        let (low, high) = (at(number - 1), at(number));
        let after = of(high);
        if before < 0.0 && after >= 0.0 {
            let one = root(low, high);
            found.push(one);
            let beside =
                |end: f64| (1..=BESIDE).map(move |halves| one + (end - one) * 0.5_f64.powi(halves));
            if let Some(place) = beside(low).find(|place| of(*place) > 0.0) {
                found.push(root(low, place));
            }
            if let Some(place) = beside(high).find(|place| of(*place) < 0.0) {
                found.push(root(place, high));
            }
        }
        before = after;
    }
    found
}

impl Lying<'_> {
    /// Returns the tubes, the one with the smaller circles first, and whether they were swapped.
    fn by_size(&self) -> ([&Tube<'_>; 2], bool) {
        let other = self.other.as_ref().unwrap_or(&self.tube);
        if other.radius < self.tube.radius {
            ([other, &self.tube], true)
        } else {
            ([&self.tube, other], false)
        }
    }

    /// Their rims in the same order.
    fn rims_by_size(&self, rims: [u8; 2]) -> [usize; 2] {
        let [one, other] = rims.map(usize::from);
        if self.by_size().1 {
            [other, one]
        } else {
            [one, other]
        }
    }

    fn near(&self, rims: [u8; 2], turn: &Turn, angle: f64) -> Near {
        let ([smaller, larger], _) = self.by_size();
        let rims = self.rims_by_size(rims);
        let (out, along) = turn.at(angle);
        let place = smaller.centre(rims[0]) + out * smaller.radius;
        let centre = larger.centre(rims[1]);
        let over = (place - centre).across(larger.axis);
        let larger_out = over.direction().unwrap_or(Vec3::ZERO);
        let larger_along = larger.axis.cross(larger_out);
        let nearest = centre + larger_out * larger.radius;
        let way = place - nearest;
        let cross = along.cross(larger_along);
        let sine = cross.norm();
        let is_left = cross.dot(out) > 0.0;
        let side = if is_left { 1.0 } else { -1.0 };
        let normal = cross * (side / sine.max(PARALLEL));
        let overlap = normal.dot(way);
        // The planes beside it have more overlap where both circles are wide enough.
        let [p, q] = [
            smaller.radius / normal.dot(out),
            -larger.radius / normal.dot(larger_out),
        ];
        let cosine = along.dot(larger_along);
        let is_least =
            overlap < p.min(q) && (p - overlap) * (q - overlap) > p * q * cosine * cosine;
        Near {
            slope: way.dot(along),
            normal,
            overlap,
            is_left,
            is_between: sine > PARALLEL
                && p > 0.0
                && q > 0.0
                && is_least
                && normal.dot(smaller.axis) * side_of(rims[0]) > 0.0
                && normal.dot(larger.axis) * side_of(rims[1]) < 0.0,
            places: [place, nearest],
            out: [out, larger_out],
            along: [along, larger_along],
        }
    }

    /// All planes of this kind, and the overlap of each.
    pub fn crossings(&self) -> Vec<(Crossing, u8, f64)> {
        let turn = Turn::about(self.by_size().0[0]);
        let mut found = Vec::new();
        for rims in [[0, 0], [0, 1], [1, 0], [1, 1]] {
            let slope = |angle: f64| self.near(rims, &turn, angle).slope;
            for angle in rises(slope, 0.0, std::f64::consts::TAU, AROUND) {
                let near = self.near(rims, &turn, angle);
                if near.is_between {
                    let is_left = near.is_left;
                    let name = turn.name(angle, None);
                    found.push((Crossing { rims, is_left }, name, near.overlap));
                }
            }
        }
        found
    }

    /// The angle of the plane of that name.
    fn angle_of_rims(&self, crossing: Crossing, turn: &Turn, name: u8) -> Option<f64> {
        let about = turn.angle(name);
        let reach = ABOUT * turn.part();
        let near = |angle: f64| self.near(crossing.rims, turn, angle);
        let all = rises(
            |angle| near(angle).slope,
            about - reach,
            about + reach,
            NEARBY,
        );
        all.into_iter()
            .filter(|angle| near(*angle).is_left == crossing.is_left)
            .min_by(|one, other| (one - about).abs().total_cmp(&(other - about).abs()))
    }

    /// Returns the overlap of the plane with that name, and its present name.
    pub fn overlap_of_rims(&self, crossing: Crossing, name: u8) -> (f64, u8) {
        let turn = Turn::about(self.by_size().0[0]);
        let Some(angle) = self.angle_of_rims(crossing, &turn, name) else {
            return (f64::INFINITY, name);
        };
        let near = self.near(crossing.rims, &turn, angle);
        if near.is_between {
            (near.overlap, turn.name(angle, Some(name)))
        } else {
            (f64::INFINITY, name)
        }
    }

    /// The plane of that name: with the way w(n) between the places that it touches, w = D n.
    pub fn between_rims(&self, crossing: Crossing, name: u8) -> Moving {
        let ([smaller, larger], is_swapped) = self.by_size();
        let rims = self.rims_by_size(crossing.rims);
        let turn = Turn::about(smaller);
        let angle = self.angle_of_rims(crossing, &turn, name);
        let near = self.near(
            crossing.rims,
            &turn,
            angle.unwrap_or_else(|| turn.angle(name)),
        );
        let normal = near.normal;
        // How w changes while n stays: the rims turn below it.
        let [one, two] = [(smaller, 0, 1.0), (larger, 1, -1.0)].map(|(tube, number, side)| {
            let out = near.out[number];
            let rate =
                tube.axis * tube.axis_rate.dot(normal) + tube.axis_rate * tube.axis.dot(normal);
            let size = side * normal.dot(out);
            let out_rate = rate.across(out) * (-side / size);
            let centre = tube.centre(rims[number]);
            tube.placed.velocity_at(centre) + out_rate * tube.radius
        });
        let way_rate = one - two;
        // (dw/dn - D) n' = -w', of which the parts along two directions across n are left.
        let [p, q] = [
            smaller.radius / normal.dot(near.out[0]),
            -larger.radius / normal.dot(near.out[1]),
        ];
        let first = near.along[0];
        let second = normal.cross(first);
        let (c, s) = (near.along[1].dot(first), near.along[1].dot(second));
        let [xx, xy, yy] = [
            p + q * c * c - near.overlap,
            q * c * s,
            q * s * s - near.overlap,
        ];
        let (x, y) = (-way_rate.dot(first), -way_rate.dot(second));
        let size = xx * yy - xy * xy;
        let normal_rate = if size > 0.0 {
            (first * (yy * x - xy * y) + second * (xx * y - xy * x)) * (1.0 / size)
        } else {
            Vec3::ZERO
        };
        let on = near.places[usize::from(is_swapped)];
        let side = if is_swapped { -1.0 } else { 1.0 };
        Moving {
            normal: normal * side,
            normal_rate: normal_rate * side,
            on,
            on_velocity: self.tube.placed.velocity_at(on),
        }
    }
}
