//! A capsule and another convex solid, and the plane between them.
//!
//! The capsule's two ends overlap a plane with the other solid behind it at depths p1 and p2. Such a plane would
//! store K/4 (p1^2 + p2^2), as a half-space does. The pair stores the minimum over all such planes. Outside the other
//! solid, the minimum can be found with a sphere that moves along the capsule's segment and overlaps by p(s) at the
//! fraction s:
//!
//! E = K/2 max over s of p(s)^2/(2 ((1 - s)^2 + s^2)),
//!
//! This follows from the duality of norms (R. T. Rockafellar, Convex Analysis, 1970, section 31): the weights of the
//! two ends at the minimum are the maximising ones. p is concave along the segment, because the distance from a
//! convex solid is convex. The maximum is therefore unique and moves continuously. The ends overlap the plane by p1 =
//! 2 c (1 - s) p and p2 = 2 c s p, with c = 1/(2 ((1 - s)^2 + s^2)).

use std::sync::Arc;

use super::zero::rising_zero;
use super::{Between, Found, Plane};
use crate::geometry::hull::Corners;
use crate::geometry::mesh::nearest_of_triangle;
use crate::geometry::rigid::{Rigid, Vector3};
use crate::geometry::solid::{Nearest, Solid};

/// Number of points of a capsule, which share the law.
pub(super) const ENDS: usize = 2;
/// Distance below which the direction is undefined `[m]`.
const NO_DIRECTION: f64 = 1e-12;

/// The solid that a capsule touches.
#[derive(Clone, Debug)]
pub(super) enum Other {
    Round(Solid),
    Flat(Arc<Corners>),
}

/// A capsule and another solid at their current poses.
#[derive(Clone, Debug)]
pub(super) struct Rod {
    /// Index of the capsule in the pair.
    side: usize,
    radius: f64,
    pub(super) half_length: f64,
    other: Other,
    /// Depth as in [`Between::least`] `[m]`.
    pub(super) depth: f64,
    /// Unit normal out of the other solid.
    pub(super) out: Vector3,
    found: [Found; ENDS],
}

/// Overlap at a position on the segment.
#[derive(Clone, Copy)]
struct SegmentPoint {
    /// Overlap of a sphere there with the other solid `[m]`.
    overlap: f64,
    /// Unit normal out of that solid.
    out: Vector3,
    /// Negative if E increases further along the segment.
    slope: f64,
}

impl Rod {
    /// Creates the pair. `side`: the capsule is the first (0) or second (1) solid.
    pub fn new(side: usize, radius: f64, half_length: f64, other: Other) -> Self {
        Self {
            side,
            radius,
            half_length,
            other,
            depth: f64::NEG_INFINITY,
            out: Vector3::x(),
            found: [Found::none(); ENDS],
        }
    }

    pub fn reaches(&self) -> [f64; 2] {
        let own = self.radius + self.half_length;
        let other = match &self.other {
            Other::Round(solid) => solid.reach(),
            Other::Flat(corners) => corners.reach(),
        };
        if self.side == 0 {
            [own, other]
        } else {
            [other, own]
        }
    }

    /// Sets the current poses.
    pub fn place(&mut self, rigids: [&Rigid; 2]) {
        let (rod, other) = (rigids[self.side], rigids[1 - self.side]);
        let half = rod.orientation * Vector3::new(0.0, 0.0, self.half_length);
        let ends = [rod.position - half, rod.position + half];
        let (s, at) = self.most(&ends, other);
        let weights = [1.0 - s, s];
        let square = weights.iter().map(|weight| weight * weight).sum::<f64>();
        let nearest = ends[0] * weights[0] + ends[1] * weights[1];
        self.out = at.out;
        self.depth = if at.overlap > 0.0 {
            at.overlap / (2.0 * square).sqrt()
        } else {
            at.overlap
        };
        for ((found, weight), end) in self.found.iter_mut().zip(weights).zip(ends) {
            let penetration = if at.overlap > 0.0 && weight > 0.0 {
                at.overlap * weight / square
            } else {
                // The end is above the plane through the nearest point.
                at.overlap - at.out.dot(&(end - nearest))
            };
            *found = Found {
                penetration,
                place: end - at.out * (self.radius - 0.5 * penetration),
            };
        }
    }

    fn nearest(&self, other: &Rigid, point: &Vector3) -> Nearest {
        match &self.other {
            Other::Round(solid) => solid.nearest(other, point),
            Other::Flat(corners) => {
                let off = point - other.position;
                let nearest = corners.nearest(&other.orientation.inverse_transform_vector(&off));
                Nearest {
                    normal: other.orientation * nearest.normal,
                    ..nearest
                }
            }
        }
    }

    fn look(&self, ends: &[Vector3; 2], other: &Rigid, s: f64) -> SegmentPoint {
        let along = ends[1] - ends[0];
        let nearest = self.nearest(other, &(ends[0] + along * s));
        let overlap = self.radius - nearest.distance;
        let rises = nearest.normal.dot(&along);
        let slope = if overlap > 0.0 {
            rises * ((1.0 - s).powi(2) + s * s) + overlap * (2.0 * s - 1.0)
        } else {
            rises
        };
        SegmentPoint {
            overlap,
            out: nearest.normal,
            slope,
        }
    }

    /// Returns the position of maximum energy on the segment, as a fraction of its length.
    fn most(&self, ends: &[Vector3; 2], other: &Rigid) -> (f64, SegmentPoint) {
        let look = |s: f64| self.look(ends, other, s);
        let (first, last) = (look(0.0), look(1.0));
        if first.slope >= 0.0 {
            return (0.0, first);
        }
        if last.slope <= 0.0 {
            return (1.0, last);
        }
        let mut here = first;
        let (low, high) = ((0.0, first.slope), (1.0, last.slope));
        let s = rising_zero(low, high, |s| {
            here = look(s);
            here.slope
        });
        (s, here)
    }
}

impl Between for Rod {
    fn least(&self, _: Option<Plane>) -> (Plane, f64) {
        let plane = Plane::Face {
            of: 1 - self.side,
            number: 0,
        };
        (plane, self.depth)
    }

    fn normal(&self, _: Plane) -> Vector3 {
        if self.side == 0 { self.out } else { -self.out }
    }

    fn points(&self, _: Plane, found: &mut [Found]) {
        for (found, own) in found.iter_mut().zip(self.found) {
            *found = own;
        }
    }
}

impl Corners {
    /// Returns the largest distance of a corner from the origin of the axes `[m]`.
    pub(crate) fn reach(&self) -> f64 {
        self.places.iter().map(Vector3::norm).fold(0.0, f64::max)
    }

    /// Returns the nearest point of the surface; for an interior point, the point of least depth.
    pub(crate) fn nearest(&self, point: &Vector3) -> Nearest {
        let height = |face: &crate::geometry::convex::Polygon| face.normal.dot(point) - face.offset;
        let mut highest = Nearest::exact(f64::NEG_INFINITY, Vector3::x());
        for face in &self.faces {
            let height = height(face);
            if height > highest.distance {
                highest = Nearest::exact(height, face.normal);
            }
        }
        if highest.distance <= NO_DIRECTION {
            return highest;
        }
        // The nearest point lies on a face with the query point in front of it.
        let (mut least, mut way) = (f64::INFINITY, Vector3::zeros());
        for face in self.faces.iter().filter(|face| height(face) > 0.0) {
            let corner = |number: usize| &self.places[number];
            let (first, others) = (corner(face.corners[0]), &face.corners[1..]);
            for two in others.windows(2) {
                let corners = [first, corner(two[0]), corner(two[1])];
                let off = point - nearest_of_triangle(corners, point);
                let square = off.norm_squared();
                if square < least {
                    (least, way) = (square, off);
                }
            }
        }
        let distance = least.sqrt();
        Nearest::exact(distance, way / distance)
    }
}
