//! Contact of two boxes or hulls, or of a capsule or cylinder with another solid: the plane between them that costs least.
//!
//! A face of one solid bounds a half-space, and the other solid overlaps it by corners, as it does a half-space that is a
//! body: E = K/2n sum of p^2 over the corners at depth p > 0, where n corners share the law of the pair: 4 of two boxes, and
//! those of the face with the most corners of two hulls. Two edges that cross have a plane between them too, along
//! both; they overlap by p and E = K/2 p^2. The pair stores the least E of all these planes. Two convex solids are apart where
//! one of the planes separates them (S. Gottschalk, M. C. Lin, D. Manocha, OBBTree, 1996), so the pair pushes exactly while they
//! overlap.
//!
//! The least of smooth functions is continuous, and where two of them are equal it bends downwards only. So the energy has
//! no jump where another plane takes over, and the pair does not stay at such a place.

mod boxes;
mod crossing;
mod cylinders;
mod hulls;
mod rims;
mod rods;
mod shapes;
mod zero;

use crate::law::PointLaw;
use crate::pairs::{MOST_POINTS, Point};
use crate::rigid::{Rigid, Vector3};
use crate::touch::Touch;
use boxes::Placed;
use cylinders::Cylinders;
use hulls::Hulls;
use rods::Rod;

/// Another plane takes over where its depth is less by more than this part of it: round-off decides nothing, and no energy
/// is made.
const PREFERENCE: f64 = 1e-9;
/// Sine of the angle below which two edges are parallel: a face of one of the solids costs less than the plane between
/// them then.
const PARALLEL: f64 = 1e-6;

/// A plane that may be between two solids.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Plane {
    /// A face of the first (0) or second (1), by its number; of a box twice its axis, and 1 more on the positive side. What
    /// numbers mean beside a cylinder: [`cylinders`].
    Face { of: usize, number: usize },
    /// Along an edge of each: of a box the axis along which it is, of a hull its number.
    Edges([usize; 2]),
}

/// All places with normal . x <= offset.
#[derive(Clone, Copy, Debug)]
struct Bound {
    normal: Vector3,
    offset: f64,
}

impl Bound {
    /// How deep a place is `[m]`.
    fn depth(&self, place: &Vector3) -> f64 {
        self.offset - self.normal.dot(place)
    }

    /// The places on the other side.
    fn turned_round(&self) -> Self {
        Self {
            normal: -self.normal,
            offset: -self.offset,
        }
    }
}

/// What is found at one of the points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    /// Below 0 where the point does not touch `[m]`.
    pub penetration: f64,
    /// Midway between the two surfaces `[m]`.
    pub place: Vector3,
}

impl Found {
    fn none() -> Self {
        Self {
            penetration: f64::NEG_INFINITY,
            place: Vector3::zeros(),
        }
    }

    /// Two edges cross at `place`: the first `share` points are there, so that they have the whole law together.
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

/// Two solids as they lie.
trait Between {
    /// The plane of least depth, and that depth: the length p for which E = K/2 p^2, or less than 0, the gap `[m]`. Of nearly
    /// equals it is `before`, or else the first one.
    fn least(&self, before: Option<Plane>) -> (Plane, f64);

    /// Unit vector across a plane from the second to the first.
    fn normal(&self, plane: Plane) -> Vector3;

    /// The points of contact by a plane.
    fn points(&self, plane: Plane, found: &mut [Found]);

    /// Whether the points of a solid are the same corners behind each plane.
    fn keeps_points(&self) -> bool {
        true
    }
}

/// The shapes of a pair.
#[derive(Clone, Debug)]
enum Solids {
    /// Half the lengths of each.
    Boxes([Vector3; 2]),
    Hulls(Hulls),
    Rod(Rod),
    Cylinders(Cylinders),
}

/// How two solids touch.
#[derive(Clone, Debug)]
struct Across {
    plane: Option<Plane>,
    /// How far the two overlap by the plane `[m]`: E = K/2 of its square; below 0 where it separates them.
    depth: f64,
    /// From the second to the first.
    normal: Vector3,
    found: Vec<Found>,
}

/// Two boxes or hulls, or a capsule or cylinder and another solid, that can touch.
#[derive(Clone, Debug)]
pub(crate) struct Blocks {
    /// Their numbers among tools and bodies.
    pub parts: [usize; 2],
    solids: Solids,
    /// The first of their points.
    first_point: usize,
    /// How many points share the law.
    share: usize,
    across: Across,
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
        }
    }

    /// How many points of contact the pair has.
    pub fn points(&self) -> usize {
        self.across.found.len()
    }

    /// The law of each.
    pub fn law(&self, law: &crate::ContactLaw) -> PointLaw {
        PointLaw::share(law, self.share as f64)
    }

    pub fn found(&self, number: usize) -> &Found {
        &self.across.found[number]
    }

    pub fn normal(&self) -> Vector3 {
        self.across.normal
    }

    /// Largest distance of the surface from the centre of each `[m]`.
    pub fn reaches(&self) -> [f64; 2] {
        match &self.solids {
            Solids::Boxes(half) => half.map(|half| half.norm()),
            Solids::Hulls(hulls) => hulls.reaches(),
            Solids::Rod(rod) => rod.reaches(),
            Solids::Cylinders(cylinders) => cylinders.reaches(),
        }
    }

    /// Takes over what another of the same pair remembers, without allocating.
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
        if let (Solids::Cylinders(own), Solids::Cylinders(other)) =
            (&mut self.solids, &other.solids)
        {
            own.copy_from(other);
        }
    }

    /// The solids were put to other places.
    pub fn forget(&mut self) {
        self.across.plane = None;
        self.across.depth = f64::NEG_INFINITY;
    }

    /// Whether they touched or touch by another plane than `other` does.
    pub fn changed_from(&self, other: &Self) -> bool {
        let (one, other) = (&self.across, &other.across);
        one.plane != other.plane && (one.depth > 0.0 || other.depth > 0.0)
    }

    /// Looks for the plane between the solids as they are now. Where another one takes over, their `touches` are handed
    /// on to its points.
    pub fn look(&mut self, first: &Rigid, second: &Rigid, touches: &mut [Touch], points: &[Point]) {
        let reaches = self.reaches();
        let gap = (second.position - first.position).norm() - reaches[0] - reaches[1];
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
        // Where they are apart, nothing is handed on.
        if let Some(before) = before
            && before != plane
            && depth > 0.0
        {
            let mut by_old = [Found::none(); MOST_POINTS];
            let by_old = &mut by_old[..touches.len()];
            between.points(before, by_old);
            let keeps = before.corners_of() == plane.corners_of() && between.keeps_points();
            hand_on(touches, law, by_old, &self.found, keeps);
        }
    }
}

impl Plane {
    /// The solid whose corners or rims touch.
    fn corners_of(&self) -> Option<usize> {
        match self {
            Self::Face { of, .. } => Some(1 - of),
            Self::Edges(_) => None,
        }
    }
}

/// Bristles go from the points of one plane to the nearest ones of another that touch: none is lost while there are as many,
/// and so neither force nor energy of friction. `keeps`: the points are the same corners, and each keeps its own.
fn hand_on(touches: &mut [Touch], law: &PointLaw, old: &[Found], new: &[Found], keeps: bool) {
    let stored =
        |touch: &Touch, found: &Found| law.stored(found.penetration.max(0.0), &touch.bristle);
    let mut by_old = [0.0; MOST_POINTS];
    for (stored_there, (touch, found)) in by_old.iter_mut().zip(touches.iter().zip(old)) {
        *stored_there = stored(touch, found);
    }
    if !keeps {
        let mut goes_to = [None; MOST_POINTS];
        let mut taken = [false; MOST_POINTS];
        // The nearest two that are left, again and again.
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
        let mut before = [Touch::apart(); MOST_POINTS];
        before[..touches.len()].copy_from_slice(touches);
        for (from, to) in goes_to[..touches.len()].iter_mut().enumerate() {
            // What has nowhere to go takes a place that does not touch, where its bristle is let go.
            let free = taken.iter().position(|taken| !taken).unwrap_or(from);
            let to = *to.get_or_insert(free);
            taken[to] = true;
            touches[to] = before[from].at_the_point_of(&before[to]);
        }
    }
    let mut handed = [0.0; MOST_POINTS];
    for (number, (touch, found)) in touches.iter().zip(new).enumerate() {
        handed[number] = stored(touch, found) - by_old[number];
    }
    // All planes cost the same where one takes over; what a sub-step went beyond that is its error.
    let beyond = handed.iter().sum::<f64>() / touches.len() as f64;
    for (touch, handed) in touches.iter_mut().zip(handed) {
        touch.past.handed += handed - beyond;
    }
}

#[cfg(test)]
mod tests;
