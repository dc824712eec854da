//! Overlap of a world's surfaces for any poses of its tools and bodies.

use super::contact::{Placed, WorldError};
use super::motion::System;
use super::scene::{Vector, WorldScene};
use super::vector::{Rotation, Vec3};

/// Contacts of a scene, for computing the penetrations in a rendered pose.
#[derive(Debug, Clone)]
pub struct Overlap {
    system: System,
}

impl Overlap {
    /// Creates the contacts of `scene`.
    ///
    /// # Errors
    ///
    /// Those of [`WorldIdeal::new`](super::WorldIdeal::new).
    pub fn new(scene: &WorldScene) -> Result<Self, WorldError> {
        Ok(Self {
            system: System::new(scene)?,
        })
    }

    /// Returns the penetration of each contact `[m]`, negative for a gap, for tools at `tools` `[m]` and bodies at
    /// `bodies`, each given by the centre of mass `[m]` and a unit quaternion `[w, x, y, z]`, in the order of the
    /// scene. The contacts are in the order of [`WorldState::contacts`](super::WorldState). Missing tools and bodies
    /// are in their initial pose.
    #[must_use]
    pub fn penetrations(&self, tools: &[Vector], bodies: &[(Vector, [f64; 4])]) -> Vec<f64> {
        let mut placed = self.system.start_places();
        let of_tools = &mut placed[..self.system.devices.len()];
        for (placed, position) in of_tools.iter_mut().zip(tools) {
            placed.position = Vec3(*position);
        }
        self.of_placed(placed, bodies)
    }

    /// Returns the penetrations for tools that also turn, with a position and a unit quaternion of each.
    #[must_use]
    pub fn penetrations_of_poses(
        &self,
        tools: &[(Vector, [f64; 4])],
        bodies: &[(Vector, [f64; 4])],
    ) -> Vec<f64> {
        let mut placed = self.system.start_places();
        let devices = self.system.devices.len();
        for (placed, (position, orientation)) in placed[..devices].iter_mut().zip(tools) {
            placed.position = Vec3(*position);
            placed.rotation = Rotation::of_quaternion(*orientation);
        }
        self.of_placed(placed, bodies)
    }

    fn of_placed(&self, mut placed: Vec<Placed>, bodies: &[(Vector, [f64; 4])]) -> Vec<f64> {
        let of_bodies = &mut placed[self.system.devices.len()..];
        for (placed, (position, orientation)) in of_bodies.iter_mut().zip(bodies) {
            placed.position = Vec3(*position);
            placed.rotation = Rotation::of_quaternion(*orientation);
        }
        let contacts = self.system.contacts.iter();
        contacts
            .map(|contact| contact.touch(contact.feature(&placed), &placed).penetration)
            .collect()
    }

    /// The largest of them, 0 where nothing overlaps `[m]`.
    #[must_use]
    pub fn deepest(&self, tools: &[Vector], bodies: &[(Vector, [f64; 4])]) -> f64 {
        self.penetrations(tools, bodies)
            .into_iter()
            .fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::world::WorldIdeal;
    use crate::world::benchmarks::pinch;

    #[test]
    fn overlaps_are_those_of_the_ideal_at_its_own_poses() {
        let benchmark = pinch();
        let ideal = WorldIdeal::new(&benchmark.scene, Grid::even(0.0, 0.001, 60)).unwrap();
        let overlap = Overlap::new(&benchmark.scene).unwrap();
        let mut deepest = 0.0_f64;
        for state in &ideal.states {
            let tools: Vec<Vector> = state.devices.iter().map(|d| d.position).collect();
            let bodies: Vec<(Vector, [f64; 4])> = state
                .bodies
                .iter()
                .map(|body| (body.position, body.orientation))
                .collect();
            let found = overlap.penetrations(&tools, &bodies);
            for (found, contact) in found.iter().zip(&state.contacts) {
                assert!((found - contact.penetration).abs() < 1e-12);
            }
            deepest = deepest.max(overlap.deepest(&tools, &bodies));
        }
        assert!(deepest > 1e-4 && deepest <= ideal.deepest());
    }
}
