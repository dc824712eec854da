//! Contact of two boxes or hulls, or of a capsule or cylinder with another solid, by the separating plane of lowest
//! energy.
//!
//! A face of one solid bounds a half-space. The corners of the other solid overlap it as they overlap a half-space
//! body: E = K/2n sum of p^2 over the corners at depth p > 0. Here n corners share the law of the pair: 4 for two
//! boxes, and the number of corners of the largest face for two hulls. Two crossing edges define a plane parallel to
//! both; they overlap by p with E = K/2 p^2. The pair stores the lowest E of all these planes. Two convex solids are
//! apart if one of the planes separates them (S. Gottschalk, M. C. Lin, D. Manocha, OBBTree, 1996), so the pair
//! pushes exactly while they overlap.
//!
//! The minimum of smooth functions is continuous, and its kinks are concave. The energy therefore has no jump at a
//! switch of planes, and the pair moves away from a switch.

mod boxes;
mod crossing;
mod cylinders;
mod hulls;
mod rims;
mod rods;
mod shapes;
mod zero;

use crate::contact::law::PointLaw;
use crate::contact::pairs::Point;
use crate::contact::point::Touch;
use crate::dynamics::moving_body::Part;
use crate::geometry::hull::MAX_CORNERS;
use crate::geometry::rigid::{Rigid, Vector3};
use boxes::Placed;
use cylinders::Cylinders;
use hulls::Hulls;
use rods::Rod;

/// Relative decrease in depth required to switch to another plane. The margin prevents switching by rounding errors
/// and is too small to generate energy.
const PREFERENCE: f64 = 1e-9;
/// Sine of the angle below which two edges are parallel. A face of one of the solids then has lower energy than the
/// plane of the edges.
const PARALLEL: f64 = 1e-6;

/// Fraction of the gap by which separated solids move before they are evaluated again.
const CLOSER: f64 = 0.9;

/// A candidate for the plane between two solids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Plane {
    /// A face of the first (0) or second (1) solid. For a box `number` is twice the axis, plus 1 on the positive
    /// side. For a pair with a cylinder see [`cylinders`].
    Face { of: usize, number: usize },
    /// The plane of an edge of each: the axis along the edge for a box, the edge index for a hull.
    Edges([usize; 2]),
}

/// The half-space normal . x <= offset.
#[derive(Clone, Copy, Debug)]
struct Bound {
    normal: Vector3,
    offset: f64,
}

impl Bound {
    /// Returns the depth of a position `[m]`.
    fn depth(&self, place: &Vector3) -> f64 {
        self.offset - self.normal.dot(place)
    }

    /// Returns the complementary half-space.
    fn turned_round(&self) -> Self {
        Self {
            normal: -self.normal,
            offset: -self.offset,
        }
    }
}

/// Contact geometry at one of the points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    /// Penetration, negative if apart `[m]`.
    pub penetration: f64,
    /// Midpoint between the two surfaces `[m]`.
    pub place: Vector3,
}

impl Found {
    fn none() -> Self {
        Self {
            penetration: f64::NEG_INFINITY,
            place: Vector3::zeros(),
        }
    }

    /// Places the first `share` points at the crossing of two edges, so that together they have the whole law.
    fn cross(found: &mut [Self], penetration: f64, place: Vector3, share: usize) {
        for (number, found) in found.iter_mut().enumerate() {
            *found = Self {
                penetration: if number < share {
                    penetration
                } else {
                    f64::NEG_INFINITY
                },
                place,
            };
        }
    }
}

/// Two solids at their current poses.
trait Between {
    /// Returns the plane of least depth and that depth: the length p with E = K/2 p^2, or the negative gap `[m]`.
    /// Near-ties go to `before`, otherwise to the first candidate.
    fn least(&self, before: Option<Plane>) -> (Plane, f64);

    /// Returns the unit normal of a plane, from the second to the first.
    fn normal(&self, plane: Plane) -> Vector3;

    /// Computes the contact points for a plane.
    fn points(&self, plane: Plane, found: &mut [Found]);

    /// Returns whether the points of a solid are the same corners for each plane.
    fn keeps_points(&self) -> bool {
        true
    }
}

/// Shapes of a pair.
#[derive(Clone, Debug)]
enum Solids {
    /// Half-extents of each box.
    Boxes([Vector3; 2]),
    Hulls(Hulls),
    Rod(Rod),
    Cylinders(Cylinders),
}

/// Contact state of two solids.
#[derive(Clone, Debug)]
struct Across {
    plane: Option<Plane>,
    /// Overlap in the direction of the plane `[m]`, with E = K/2 times its square; negative if the plane separates
    /// the solids.
    depth: f64,
    /// Unit normal from the second to the first.
    normal: Vector3,
    found: Vec<Found>,
}

/// Two boxes or hulls, or a capsule or cylinder and another solid, that may touch.
#[derive(Clone, Debug)]
pub(crate) struct Blocks {
    /// Indices among tools and bodies.
    pub parts: [usize; 2],
    solids: Solids,
    /// Index of the first contact point.
    first_point: usize,
    /// Number of points that share the law.
    share: usize,
    across: Across,
    /// Displacement since the interval began below which the separated solids cannot touch; 0 if unknown `[m]`.
    clear: f64,
    /// Whether the solids have moved since they were last evaluated.
    is_stale: bool,
}

impl Blocks {
    fn new(
        parts: [usize; 2],
        solids: Solids,
        first_point: usize,
        share: usize,
        points: usize,
    ) -> Self {
        Self {
            parts,
            solids,
            first_point,
            share,
            across: Across {
                plane: None,
                depth: f64::NEG_INFINITY,
                normal: Vector3::x(),
                found: vec![Found::none(); points],
            },
            clear: 0.0,
            is_stale: false,
        }
    }

    /// Returns the number of contact points of the pair.
    pub fn points(&self) -> usize {
        self.across.found.len()
    }

    /// Returns the law of each point.
    pub fn law(&self, law: &crate::ContactLaw) -> PointLaw {
        PointLaw::share(law, self.share as f64)
    }

    pub fn found(&self, number: usize) -> &Found {
        &self.across.found[number]
    }

    pub fn normal(&self) -> Vector3 {
        self.across.normal
    }

    /// Returns the largest distance of each surface from its centre `[m]`.
    pub fn reaches(&self) -> [f64; 2] {
        match &self.solids {
            Solids::Boxes(half) => half.map(|half| half.norm()),
            Solids::Hulls(hulls) => hulls.reaches(),
            Solids::Rod(rod) => rod.reaches(),
            Solids::Cylinders(cylinders) => cylinders.reaches(),
        }
    }

    /// Returns the plane of the second, if it is a half-space: normal and offset in its axes `[m]`.
    pub fn plane(&self) -> Option<(Vector3, f64)> {
        match &self.solids {
            Solids::Cylinders(cylinders) => cylinders.plane(),
            _ => None,
        }
    }

    /// Copies the state of another instance of the same pair, without allocation.
    pub fn copy_from(&mut self, other: &Self) {
        let Across {
            plane,
            depth,
            normal,
            found,
        } = &other.across;
        self.across.plane = *plane;
        self.across.depth = *depth;
        self.across.normal = *normal;
        self.across.found.copy_from_slice(found);
        (self.clear, self.is_stale) = (other.clear, other.is_stale);
        if let (Solids::Cylinders(own), Solids::Cylinders(other)) =
            (&mut self.solids, &other.solids)
        {
            own.copy_from(other);
        }
    }

    /// Resets the state after the solids have been displaced.
    pub fn forget(&mut self) {
        self.across.plane = None;
        self.across.depth = f64::NEG_INFINITY;
        self.clear = 0.0;
    }

    /// Returns whether they touched or touch by a different plane from that of `other`.
    pub fn changed_from(&self, other: &Self) -> bool {
        let (one, other) = (&self.across, &other.across);
        one.plane != other.plane && (one.depth > 0.0 || other.depth > 0.0)
    }

    /// Begins an interval: evaluates solids that have moved, and counts their displacements from here on.
    pub fn update(&mut self, sides: [&Part; 2], touches: &mut [Touch], points: &[Point]) {
        if self.is_stale {
            let [first, second] = sides.map(|part| &part.rigid);
            self.look(first, second, touches, points);
        }
        self.clear = 0.0;
    }

    /// Updates the plane for the current poses, unless the solids are separated and have moved by less than their gap
    /// within the interval. The rims of a cylinder turn with the plane, so it is always updated.
    #[inline]
    pub fn look_if_near(&mut self, sides: [&Part; 2], touches: &mut [Touch], points: &[Point]) {
        let [first, second] = sides;
        if matches!(self.solids, Solids::Cylinders(_)) {
            self.look(&first.rigid, &second.rigid, touches, points);
            return;
        }
        let [one, other] = self.reaches();
        let moved = first.way + second.way + first.turned * one + second.turned * other;
        if moved < self.clear {
            self.is_stale = true;
            return;
        }
        self.look(&first.rigid, &second.rigid, touches, points);
        self.clear = moved - CLOSER * self.across.depth.min(0.0);
    }

    /// Updates the plane for the current poses. At a switch the contact states in `touches` are transferred to the
    /// points of the new plane.
    pub fn look(&mut self, first: &Rigid, second: &Rigid, touches: &mut [Touch], points: &[Point]) {
        let reaches = self.reaches();
        let gap = (second.position - first.position).norm() - reaches[0] - reaches[1];
        self.is_stale = false;
        let across = &mut self.across;
        if gap > 0.0 && across.depth <= 0.0 {
            across.plane = None;
            across.depth = -gap;
            for found in &mut across.found {
                found.penetration = -gap;
            }
            return;
        }
        let range = self.first_point..self.first_point + across.found.len();
        let law = &points[self.first_point].law;
        match &mut self.solids {
            Solids::Boxes(half) => {
                across.look_at(
                    &Placed::new([first, second], *half),
                    &mut touches[range],
                    law,
                );
            }
            Solids::Hulls(hulls) => {
                hulls.place([first, second]);
                across.look_at(hulls, &mut touches[range], law);
            }
            Solids::Rod(rod) => {
                rod.place([first, second]);
                across.look_at(rod, &mut touches[range], law);
            }
            Solids::Cylinders(cylinders) => {
                cylinders.place([first, second], across.plane);
                across.look_at(cylinders, &mut touches[range], law);
                if let Some(plane) = across.plane {
                    cylinders.turn(plane);
                }
            }
        }
    }
}

impl Across {
    fn look_at(&mut self, between: &dyn Between, touches: &mut [Touch], law: &PointLaw) {
        let before = if self.depth > 0.0 { self.plane } else { None };
        let (plane, depth) = between.least(before);
        self.plane = Some(plane);
        self.depth = depth;
        self.normal = between.normal(plane);
        between.points(plane, &mut self.found);
        // Separated solids transfer no contact state.
        if let Some(before) = before
            && before != plane
            && depth > 0.0
        {
            let mut by_old = [Found::none(); MAX_CORNERS];
            let by_old = &mut by_old[..touches.len()];
            between.points(before, by_old);
            let keeps = before.corners_of() == plane.corners_of() && between.keeps_points();
            hand_on(touches, law, by_old, &self.found, keeps);
        }
    }
}

impl Plane {
    /// Returns the solid whose corners or rims touch.
    fn corners_of(&self) -> Option<usize> {
        match self {
            Self::Face { of, .. } => Some(1 - of),
            Self::Edges(_) => None,
        }
    }
}

/// Transfers bristles from the points of one plane to the nearest touching points of another. None is lost if the
/// number of touching points does not decrease, so friction force and energy are continuous. `keeps`: the points are
/// the same corners, and each keeps its own bristle.
fn hand_on(touches: &mut [Touch], law: &PointLaw, old: &[Found], new: &[Found], keeps: bool) {
    let stored =
        |touch: &Touch, found: &Found| law.stored(found.penetration.max(0.0), &touch.bristle);
    let mut by_old = [0.0; MAX_CORNERS];
    for (stored_there, (touch, found)) in by_old.iter_mut().zip(touches.iter().zip(old)) {
        *stored_there = stored(touch, found);
    }
    if !keeps {
        let mut goes_to = [None; MAX_CORNERS];
        let mut taken = [false; MAX_CORNERS];
        // Repeatedly match the nearest remaining pair.
        for _ in 0..touches.len() {
            let mut nearest: Option<(f64, usize, usize)> = None;
            for (from, touch) in touches.iter().enumerate() {
                if goes_to[from].is_some() || touch.is_apart() {
                    continue;
                }
                for (to, found) in new.iter().enumerate() {
                    if taken[to] || found.penetration <= 0.0 {
                        continue;
                    }
                    let way = (found.place - touch.place).norm_squared();
                    if nearest.is_none_or(|(least, ..)| way < least) {
                        nearest = Some((way, from, to));
                    }
                }
            }
            let Some((_, from, to)) = nearest else {
                break;
            };
            goes_to[from] = Some(to);
            taken[to] = true;
        }
        let mut before = [Touch::apart(); MAX_CORNERS];
        before[..touches.len()].copy_from_slice(touches);
        for (from, to) in goes_to[..touches.len()].iter_mut().enumerate() {
            // A bristle without a target moves to a free point that does not touch, where it is discarded.
            let free = taken.iter().position(|taken| !taken).unwrap_or(from);
            let to = *to.get_or_insert(free);
            taken[to] = true;
            touches[to] = before[from].at_the_point_of(&before[to]);
        }
    }
    let mut handed = [0.0; MAX_CORNERS];
    for (number, (touch, found)) in touches.iter().zip(new).enumerate() {
        handed[number] = stored(touch, found) - by_old[number];
    }
    // At a switch all planes have equal energy; the remaining difference is the sub-step error.
    let beyond = handed.iter().sum::<f64>() / touches.len() as f64;
    for (touch, handed) in touches.iter_mut().zip(handed) {
        touch.past.handed += handed - beyond;
    }
}

#[cfg(test)]
mod tests;
