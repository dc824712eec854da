//! Pairs of shapes that are handled by a separating plane.

use std::sync::Arc;

use super::boxes::ON_A_FACE;
use super::cylinders::{Cylinders, Form};
use super::hulls::Hulls;
use super::rims::Cylinder;
use super::rods::{ENDS, Other, Rod};
use super::{Blocks, Solids};
use crate::Shape;
use crate::geometry::hull::Corners;
use crate::geometry::solid::Solid;

impl Blocks {
    /// Creates a pair of two boxes or hulls, or of a capsule or cylinder and another solid; `None` for other shapes.
    pub fn between(shapes: [&Shape; 2], parts: [usize; 2], first_point: usize) -> Option<Self> {
        if let [
            Shape::Box { half_extents: a },
            Shape::Box { half_extents: b },
        ] = shapes
        {
            let solids = Solids::Boxes([a, b].map(|half| (*half).into()));
            // One point per corner of either box.
            return Some(Self::new(parts, solids, first_point, ON_A_FACE, 8));
        }
        if let Some(rod) = capsule(shapes) {
            return Some(Self::new(parts, Solids::Rod(rod), first_point, ENDS, ENDS));
        }
        if let Some((cylinders, share)) = cylinders(shapes) {
            let points = cylinders.points();
            let solids = Solids::Cylinders(cylinders);
            return Some(Self::new(parts, solids, first_point, share, points));
        }
        let [one, other] = shapes;
        let hulls = [flat(one)?, flat(other)?];
        let most = |of: fn(&Corners) -> usize| hulls.iter().map(|hull| of(hull)).max();
        let share = most(Corners::most_on_a_face).unwrap_or(1);
        let points = most(|hull| hull.places.len()).unwrap_or(1);
        let solids = Solids::Hulls(Hulls::new(hulls, share));
        Some(Self::new(parts, solids, first_point, share, points))
    }
}

/// Creates a pair of a capsule and a convex solid that is not a sphere. Of two capsules, the shorter is the capsule;
/// ties go to the first.
fn capsule(shapes: [&Shape; 2]) -> Option<Rod> {
    let capsule = |side: usize| match shapes[side] {
        &Shape::Capsule {
            radius,
            half_length,
        } => Some((radius, half_length)),
        _ => None,
    };
    let (side, (radius, half_length)) = match (capsule(0), capsule(1)) {
        (Some(one), Some(other)) if other.1 < one.1 => (1, other),
        (Some(one), _) => (0, one),
        (None, other) => (1, other?),
    };
    let other = match shapes[1 - side] {
        Shape::Hull(hull) => Other::Flat(hull.by_corners().clone()),
        shape @ (Shape::Box { .. } | Shape::Capsule { .. } | Shape::Cylinder { .. }) => {
            Other::Round(Solid::new(shape)?)
        }
        _ => return None,
    };
    Some(Rod::new(side, radius, half_length, other))
}

/// Returns the corners of a box or hull.
fn flat(shape: &Shape) -> Option<Arc<Corners>> {
    match shape {
        Shape::Hull(hull) => Some(hull.by_corners().clone()),
        Shape::Box { half_extents } => Some(Arc::new(Corners::of_box((*half_extents).into()))),
        _ => None,
    }
}

/// Creates a pair of a cylinder and a half-space, box, hull or cylinder, and returns the number of points that share
/// the law. Of two cylinders, the shorter is the cylinder; ties go to the first.
fn cylinders(shapes: [&Shape; 2]) -> Option<(Cylinders, usize)> {
    let cylinder = |side: usize| match *shapes[side] {
        Shape::Cylinder {
            radius,
            half_length,
        } => Some((radius, half_length)),
        _ => None,
    };
    let side = match (cylinder(0), cylinder(1)) {
        (Some(one), Some(other)) => usize::from(other.1 < one.1),
        (Some(_), None) => 0,
        (None, _) => 1,
    };
    let (radius, half_length) = cylinder(side)?;
    // As many as the corners on a face of the other solid, so that both yield alike.
    let most = flat(shapes[1 - side]).map_or(0, |corners| corners.most_on_a_face());
    let share = ON_A_FACE.max(most);
    let rims = |radius, half_length| Cylinder::new(radius, half_length, share);
    let other = match *shapes[1 - side] {
        Shape::Cylinder {
            radius,
            half_length,
        } => Form::Cylinder(rims(radius, half_length)),
        Shape::HalfSpace { normal, offset } => Form::half_space(normal.into(), offset),
        ref other => Form::flat(flat(other)?),
    };
    let own = rims(radius, half_length);
    Some((Cylinders::new(side, own, other, share), share))
}
