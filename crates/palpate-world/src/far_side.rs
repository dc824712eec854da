//! Spheres that leave a solid through another side than they entered it.
//!
//! The force on a sphere whose centre is inside a solid is away from the nearest face, which a force can push it past: it then goes on
//! through the far side. Meshes and hulls follow their surface, and a sphere stays where it entered them.

use crate::WorldRenderer;
use crate::pairs::Point;
use crate::rigid::Vector3;
use crate::solid::Solid;
use crate::state::{ContactState, Progress};

/// Cosine of the angle between the normals from which on they are of sides that lie opposite: that of a tetrahedron's faces is
/// -0.33, and that of a box's neighbouring ones 0.
const OPPOSITE: f64 = -0.2;

/// How a sphere's centre is inside a solid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Entry {
    /// The normal of where it went in, in the axes of the solid's body; none while the centre is outside.
    normal: Option<Vector3>,
    /// Whether it has come to the opposite side at the last sample.
    pub is_through: bool,
}

impl WorldRenderer {
    /// Looks at the contacts of the last sample.
    pub(crate) fn watch_sides(&self, state: &mut Progress) {
        for ((point, contact), side) in self
            .points
            .iter()
            .zip(&state.contacts)
            .zip(&mut state.sides)
        {
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

/// Whether the centre of a sphere is inside a solid that has a far side.
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
