//! Moments of inertia of homogeneous shapes.

use crate::{IDENTITY, Shape, Vector};

impl Shape {
    /// Returns the moments of inertia along the shape's axes of a homogeneous body of `mass` `[kg]` `[kg m^2]`.
    /// Returns `None` for a half-space (unbounded), several spheres (they may overlap), and an open mesh. Also
    /// returns `None` for a mesh or hull whose axes do not start at its centre of mass or are not principal;
    /// [`Body::balanced`](crate::Body::balanced) corrects this.
    #[must_use]
    pub fn moments(&self, mass: f64) -> Option<Vector> {
        let of_cylinder = |mass: f64, radius: f64, half_length: f64| {
            let square = radius * radius;
            let across = mass * (square / 4.0 + half_length * half_length / 3.0);
            [across, across, 0.5 * mass * square]
        };
        match *self {
            Self::Sphere { radius } => Some([0.4 * mass * radius * radius; 3]),
            Self::HalfSpace { .. } | Self::Spheres { .. } => None,
            Self::Mesh(ref mesh) => mesh
                .mass_properties(mass)
                .filter(|of| of.centre == [0.0; 3] && of.orientation == IDENTITY)
                .map(|of| of.moments),
            Self::Hull(ref hull) => Self::Mesh(hull.mesh().clone()).moments(mass),
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
                // A cylinder with a half-ball at each end, with its centre of mass 3/8 of the radius beyond.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn holds(shape: &Shape, [x, y, z]: Vector) -> bool {
        match *shape {
            Shape::Sphere { radius } => x * x + y * y + z * z <= radius * radius,
            Shape::HalfSpace { .. } | Shape::Spheres { .. } | Shape::Mesh(_) | Shape::Hull(_) => {
                false
            }
            Shape::Box {
                half_extents: [a, b, c],
            } => x.abs() <= a && y.abs() <= b && z.abs() <= c,
            Shape::Capsule {
                radius,
                half_length,
            } => {
                let off = (z.abs() - half_length).max(0.0);
                x * x + y * y + off * off <= radius * radius
            }
            Shape::Cylinder {
                radius,
                half_length,
            } => z.abs() <= half_length && x * x + y * y <= radius * radius,
        }
    }

    #[test]
    fn moments_are_those_of_many_small_cells() {
        let shapes = [
            Shape::Sphere { radius: 0.8 },
            Shape::Box {
                half_extents: [0.9, 0.5, 0.3],
            },
            Shape::Capsule {
                radius: 0.4,
                half_length: 0.5,
            },
            Shape::Cylinder {
                radius: 0.4,
                half_length: 0.7,
            },
        ];
        const CELLS: u32 = 120;
        for shape in shapes {
            let at = |cell: u32| (2.0 * f64::from(cell) + 1.0) / f64::from(CELLS) - 1.0;
            let (mut count, mut sums) = (0.0, [0.0; 3]);
            for (i, j, k) in (0..CELLS)
                .flat_map(|i| (0..CELLS).flat_map(move |j| (0..CELLS).map(move |k| (i, j, k))))
            {
                let [x, y, z] = [at(i), at(j), at(k)];
                if holds(&shape, [x, y, z]) {
                    count += 1.0;
                    let squares = [y * y + z * z, z * z + x * x, x * x + y * y];
                    sums = [0, 1, 2].map(|axis| sums[axis] + squares[axis]);
                }
            }
            let moments = shape.moments(3.0).unwrap();
            for (moment, sum) in moments.into_iter().zip(sums) {
                let counted = 3.0 * sum / count;
                assert!(
                    (moment / counted - 1.0).abs() < 0.01,
                    "{shape:?}: {moment} {counted}"
                );
            }
        }
    }
}
