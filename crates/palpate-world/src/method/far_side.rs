//! Detection of spheres that leave a solid through another side than they entered.
//!
//! If the centre of a sphere is inside a solid, the force points away from the nearest face. A strong push can move
//! the centre past the middle; the sphere then leaves through the far side. Meshes and hulls track the surface, so a
//! sphere stays on the side of entry.

use crate::WorldRenderer;
use crate::contact::pairs::Point;
use crate::geometry::rigid::Vector3;
use crate::geometry::solid::Solid;
use crate::method::state::{ContactState, Progress, Shown};

/// Cosine of the angle between two normals below which their sides are opposite. The cosine is -0.33 for the faces of
/// a tetrahedron and 0 for adjacent faces of a box.
const OPPOSITE: f64 = -0.2;

/// State of a sphere's centre inside a solid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Entry {
    /// Normal at the point of entry, in the axes of the solid's body; `None` while the centre is outside.
    normal: Option<Vector3>,
    /// Whether it reached the opposite side at the last sample.
    pub is_through: bool,
}

impl WorldRenderer {
    /// Checks the contacts of the last sample.
    pub(crate) fn watch_sides(&self, state: &mut Progress) {
        let Shown { numbers, sides } = &mut state.shown;
        for &number in numbers.all() {
            let (point, contact) = (&self.points[number], &state.contacts[number]);
            let side = &mut sides[number];
            side.is_through = false;
            if !is_inside(point, contact) {
                side.normal = None;
                continue;
            }
            let orientation = &state.now.parts[point.second].rigid.orientation;
            let normal = orientation.inverse_transform_vector(&contact.normal.into());
            let entered = *side.normal.get_or_insert(normal);
            if entered.dot(&normal) < OPPOSITE {
                *side = Entry {
                    normal: Some(normal),
                    is_through: true,
                };
            }
        }
    }
}

/// Returns whether the centre of a sphere is inside a solid that has a far side.
fn is_inside(point: &Point, contact: &ContactState) -> bool {
    contact.penetration > point.radius
        && matches!(
            point.solid,
            Solid::Ball { .. }
                | Solid::Block { .. }
                | Solid::Capsule { .. }
                | Solid::Cylinder { .. }
                | Solid::Hull { .. }
        )
}
