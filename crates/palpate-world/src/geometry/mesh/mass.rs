//! Centre of mass and moments of inertia of the solid enclosed by a mesh.

use std::sync::Arc;

use nalgebra::{Matrix3, Rotation3, UnitQuaternion};

use super::build::Mesh;
use crate::geometry::rigid::{Rotation, Vector3};
use crate::{Quaternion, Vector};

/// Mass distribution of a homogeneous solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassProperties {
    /// Centre of mass, in the solid's given axes `[m]`.
    pub centre: Vector,
    /// Orientation of the principal axes of inertia in the given axes.
    pub orientation: Quaternion,
    /// Moments of inertia about the centre along the principal axes `[kg m^2]`.
    pub moments: Vector,
}

/// Rounding threshold for products of inertia and centre displacements, relative to the solid's own.
const ROUND_OFF: f64 = 1e-9;

impl Mesh {
    /// Returns centre of mass, principal axes and moments of inertia of a homogeneous body of `mass` `[kg]` inside a
    /// closed mesh; `None` for an open mesh. Axes that are already principal are kept.
    #[must_use]
    pub fn mass_properties(&self, mass: f64) -> Option<MassProperties> {
        if !self.is_closed() {
            return None;
        }
        // Sum cones from a vertex of the mesh: a distant apex would increase rounding errors.
        let tip = self.vertices[0];
        let (mut volume, mut first) = (0.0, Vector3::zeros());
        let mut second = Matrix3::zeros();
        for face in &self.faces {
            let [a, b, c] = face.map(|corner| self.vertices[corner as usize] - tip);
            let cone = a.dot(&b.cross(&c));
            let sum = a + b + c;
            volume += cone / 6.0;
            first += sum * (cone / 24.0);
            let squares = [a, b, c, sum].map(|v| v * v.transpose());
            second += (squares[0] + squares[1] + squares[2] + squares[3]) * (cone / 120.0);
        }
        let middle = first / volume;
        let spread = (second - middle * middle.transpose() * volume) * (mass / volume);
        let inertia = Matrix3::identity() * spread.trace() - spread;
        let (axes, moments) = principal(&inertia);
        let centre = tip + middle;
        let is_off = centre.norm() > ROUND_OFF * self.reach();
        let [x, y, z, w]: [f64; 4] = axes.coords.into();
        Some(MassProperties {
            centre: if is_off { centre.into() } else { [0.0; 3] },
            orientation: [w, x, y, z],
            moments: moments.into(),
        })
    }

    /// Returns the same surface in axes with origin `centre` `[m]` and orientation `orientation`.
    pub(crate) fn seen_from(&self, centre: &Vector3, orientation: &Rotation) -> Arc<Self> {
        let vertices: Vec<_> = self
            .vertices
            .iter()
            .map(|vertex| orientation.inverse_transform_vector(&(vertex - centre)))
            .collect();
        let topology = self.topology.turned(&orientation.inverse());
        let (faces, dropped) = (self.faces.clone(), self.dropped());
        let mut seen = Self::of_parts(vertices, faces, topology, dropped);
        seen.turned = self.turned();
        let grid = self.grid.as_ref();
        seen.grid = grid.map(|grid| Arc::new(grid.seen_from(centre, orientation)));
        let shell = self.shell.as_ref();
        seen.shell = shell.map(|shell| shell.seen_from(centre, orientation));
        Arc::new(seen)
    }
}

/// Returns the principal axes and the moments along them.
fn principal(inertia: &Matrix3<f64>) -> (Rotation, Vector3) {
    let products = [inertia.m12, inertia.m13, inertia.m23];
    let most = products
        .into_iter()
        .fold(0.0, |most: f64, x| most.max(x.abs()));
    if most <= ROUND_OFF * inertia.trace() {
        return (Rotation::identity(), inertia.diagonal());
    }
    let found = inertia.symmetric_eigen();
    let mut axes = found.eigenvectors;
    if axes.determinant() < 0.0 {
        axes.column_mut(2).neg_mut();
    }
    let turned = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    (turned, found.eigenvalues)
}
