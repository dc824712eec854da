//! Parameters that dominate the force error of a world independently of the renderer: the quantum of a position sensor,
//! and a stiff hand behind a delay.

use super::ideal::WorldIdeal;
use super::scene::{Member, WorldScene};

/// Influence of the sensor and the hand of a device on its force error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decisive {
    /// q K: by how much a quantum of the position changes the force of the stiffest contact that the ideal makes with
    /// the tool, along the axis with the largest quantum `[N]`; 0 if the ideal does not touch the tool.
    pub quantum_force: f64,
    /// `quantum_force` over the root mean square of the ideal's force on the tool during contact; `None` without
    /// contact.
    pub quantum_over_force: Option<f64>,
    /// k T²/m: stiffness of the hand's spring times the square of the period, over the least mass along an axis.
    pub hand_over_mass: f64,
}

impl Decisive {
    /// Above this part of the force the quantum decides ([`quantum_over_force`](Self::quantum_over_force)).
    pub const SENSOR: f64 = 0.1;
    /// Above this value the hand dominates if forces are delayed ([`hand_over_mass`](Self::hand_over_mass)).
    pub const HAND: f64 = 0.2;

    /// Returns the values for each device of `scene` with this ideal. The period is that of the ideal's grid.
    ///
    /// # Panics
    ///
    /// `ideal` does not belong to `scene` and has fewer devices.
    #[must_use]
    pub fn new(scene: &WorldScene, ideal: &WorldIdeal) -> Vec<Self> {
        let period = ideal.grid.period();
        let of_device = |(number, device): (usize, &super::scene::WorldDevice)| {
            let touches = ideal
                .encounters
                .iter()
                .filter(|it| it.between.contains(&Member::Device(number)));
            let stiffest = touches
                .map(|it| scene.pairs[it.pair].law.stiffness)
                .fold(0.0, f64::max);
            let quantum_force = stiffest * device.quantum.into_iter().fold(0.0, f64::max);
            let (mut squares, mut touched) = (0.0, 0.0);
            for (of_axes, duration) in ideal.devices[number]
                .squares
                .iter()
                .zip(ideal.grid.durations())
            {
                let square: f64 = of_axes.iter().sum();
                if square > 0.0 {
                    squares += square;
                    touched += duration;
                }
            }
            let force = (touched > 0.0).then(|| (squares / touched).sqrt());
            let lightest = device.mass.into_iter().fold(f64::INFINITY, f64::min);
            Self {
                quantum_force,
                quantum_over_force: force.map(|force| quantum_force / force),
                hand_over_mass: device.hand.stiffness * period * period / lightest,
            }
        };
        scene.devices.iter().enumerate().map(of_device).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::Grid;
    use crate::world::{ContactLaw, Pair, Shape, Tool, Vector, WorldBody, WorldDevice, WorldHand};

    fn pressed(quantum: Vector) -> WorldScene {
        WorldScene {
            devices: vec![WorldDevice {
                name: "tool".into(),
                own_axes: None,
                mass_table: None,
                drivetrain: crate::world::Drivetrain::default(),
                mass: [0.5, f64::INFINITY, 0.1],
                position: [0.0, 0.0, -0.001],
                velocity: [0.0; 3],
                tool: Tool::sphere(0.0),
                turning: None,
                hand: WorldHand {
                    force: [0.0, 0.0, -2.0],
                    ..WorldHand::default()
                },
                quantum,
            }],
            bodies: vec![WorldBody {
                name: "floor".into(),
                shape: Shape::HalfSpace {
                    normal: [0.0, 0.0, 1.0],
                    offset: 0.0,
                },
                position: [0.0; 3],
                orientation: [1.0, 0.0, 0.0, 0.0],
                motion: None,
            }],
            pairs: vec![Pair {
                between: [Member::Device(0), Member::Body(0)],
                law: ContactLaw::spring(2000.0),
            }],
            ..WorldScene::default()
        }
    }

    #[test]
    fn a_tool_at_rest_on_a_floor_feels_its_push() {
        let mut scene = pressed([0.0, 0.0, 1e-5]);
        scene.devices[0].hand.stiffness = 10.0;
        scene.devices[0].hand.rest = scene.devices[0].position;
        let ideal = WorldIdeal::new(&scene, Grid::even(0.0, 0.01, 10)).unwrap();
        let [of] = Decisive::new(&scene, &ideal)[..] else {
            panic!("one device");
        };
        assert!((of.quantum_force - 0.02).abs() < 1e-15);
        assert!((of.quantum_over_force.unwrap() - 0.01).abs() < 1e-6);
        assert!((of.hand_over_mass - 10.0 * 1e-4 / 0.1).abs() < 1e-15);
    }

    #[test]
    fn the_largest_quantum_counts_and_no_touch_is_none() {
        let scene = pressed([3e-5, 0.0, 1e-5]);
        let ideal = WorldIdeal::new(&scene, Grid::even(0.0, 0.01, 10)).unwrap();
        let of = Decisive::new(&scene, &ideal)[0];
        assert!((of.quantum_force - 0.06).abs() < 1e-15);
        let mut apart = scene;
        apart.devices[0].position = [0.0, 0.0, 10.0];
        let ideal = WorldIdeal::new(&apart, Grid::even(0.0, 0.01, 10)).unwrap();
        let of = Decisive::new(&apart, &ideal)[0];
        assert_eq!((of.quantum_force, of.quantum_over_force), (0.0, None));
    }
}
