//! Moments of inertia of shapes that are filled evenly.

use crate::{Shape, Vector};

impl Shape {
    /// Moments of inertia along the shape's own axes of a body of `mass` `[kg]` that fills the shape evenly
    /// `[kg m^2]`; `None` for a half-space, which has no end.
    #[must_use]
    pub fn moments(&self, mass: f64) -> Option<Vector> {
        let of_cylinder = |mass: f64, radius: f64, half_length: f64| {
            let square = radius * radius;
            let across = mass * (square / 4.0 + half_length * half_length / 3.0);
            [across, across, 0.5 * mass * square]
        };
        match *self {
            Self::Sphere { radius } => Some([0.4 * mass * radius * radius; 3]),
            Self::HalfSpace { .. } => None,
            Self::Box { half_extents } => {
                let [a, b, c] = half_extents.map(|half| half * half * mass / 3.0);
                Some([b + c, c + a, a + b])
            }
            Self::Cylinder {
                radius,
                half_length,
            } => Some(of_cylinder(mass, radius, half_length)),
            Self::Capsule {
                radius,
                half_length,
            } => {
                // A cylinder with half a ball at each end, whose centres of mass lie 3/8 of the radius beyond.
                let (middle, ends) = (2.0 * half_length, 4.0 / 3.0 * radius);
                let of_ends = mass * ends / (middle + ends);
                let [across, _, along] = of_cylinder(mass - of_ends, radius, half_length);
                let square = radius * radius;
                let off = half_length * half_length + 0.75 * half_length * radius;
                let across = across + of_ends * (0.4 * square + off);
                Some([across, across, along + 0.4 * of_ends * square])
            }
        }
    }
}
