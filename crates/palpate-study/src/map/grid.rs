//! The cells of a map: the scene of each index.

use super::bounce::{Bounce, BounceDevice, Forces, Plant};
use palpate_scene::Model;
use palpate_scene::method::MethodName;

/// Range of both axes.
pub(crate) const AXIS: (f64, f64) = (1e-3, 10.0);

/// Parameters of a map: two maps with the same parameters and version are equal.
#[derive(Clone, Debug, PartialEq)]
pub struct MapParams {
    /// Number of cells along each axis; a column of walls is added.
    pub cells: usize,
    /// Methods, in the order of [`MethodName::ALL`].
    pub methods: Vec<MethodName>,
    /// The device; its friction is that of the damped plant.
    pub device: BounceDevice,
    /// Period T `[s]`.
    pub period: f64,
    /// Forces that drive device and object together.
    pub forces: Forces,
    /// Distance of device and object at the start `[m]`.
    pub gap: f64,
    /// Time from a sample to the start of its force `[periods]`; may be fractional.
    pub delay: f64,
    /// Time constant of the following first-order lag `[periods]`.
    pub lag: f64,
    /// Standard deviation of the delay in the renderer's model `[periods]`.
    pub delay_deviation: f64,
    /// Standard deviation of the lag in the renderer's model `[periods]`.
    pub lag_deviation: f64,
    /// Model period of the renderer over the true period.
    pub model_period: f64,
}

/// Reason for rejecting the parameters of a map.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ParamsError {
    /// Too few or too many cells.
    #[error("a map has 2 to 1000 cells along each axis, not {0}")]
    Cells(usize),
    /// There is no method.
    #[error("a map needs a method")]
    NoMethod,
}

/// A cell: its position on the axes and its scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Index, counted from 0.
    pub index: usize,
    /// K T²/m.
    pub kappa: f64,
    /// K T²/M; 0 for a wall.
    pub object_kappa: f64,
    /// The scene, with the friction of the damped plant.
    pub bounce: Bounce,
}

impl Default for MapParams {
    /// Returns experiment 1 of the paper with a point mass, except for stiffness and object mass.
    fn default() -> Self {
        Self {
            cells: 65,
            methods: MethodName::ALL.to_vec(),
            device: BounceDevice {
                mass: 0.25,
                // Friction of the joints of the virtual pantograph of `experiments/fig4.toml` along y at its home
                // pose.
                viscous_friction: 0.0394,
                coulomb_friction: 0.0,
                encoder_quantum: 0.0,
                model_mass: 1.0,
            },
            period: 0.02,
            // The 1 N of its hand and the weight of its 0.1 kg: 1/0.25 + 9.81 m/s².
            forces: Forces::Balanced(13.81),
            gap: 0.05,
            delay: 0.0,
            lag: 0.0,
            delay_deviation: 0.0,
            lag_deviation: 0.0,
            model_period: 1.0,
        }
    }
}

impl MapParams {
    /// Checks the parameters that the scenes do not check.
    ///
    /// # Errors
    /// There are too few or too many cells, or there is no method.
    pub fn check(&self) -> Result<(), ParamsError> {
        if !(2..=1000).contains(&self.cells) {
            return Err(ParamsError::Cells(self.cells));
        }
        if self.methods.is_empty() {
            return Err(ParamsError::NoMethod);
        }
        Ok(())
    }

    /// Returns the number of columns: one of walls, then those of the axis.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.cells + 1
    }

    /// Returns the number of cells.
    #[must_use]
    pub fn len(&self) -> usize {
        self.cells * self.columns()
    }

    /// Whether there is no cell at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the cell of an index: rows of equal kappa, the wall first, then by increasing Kc.
    #[must_use]
    pub fn cell(&self, index: usize) -> Cell {
        let (row, column) = (index / self.columns(), index % self.columns());
        let kappa = self.on_axis(row);
        let object_kappa = if column == 0 {
            0.0
        } else {
            self.on_axis(column - 1)
        };
        let per_period = self.device.mass / (self.period * self.period);
        Cell {
            index,
            kappa,
            object_kappa,
            bounce: Bounce {
                device: self.device,
                stiffness: kappa * per_period,
                object_mass: if column == 0 {
                    f64::INFINITY
                } else {
                    self.device.mass * kappa / object_kappa
                },
                forces: self.forces,
                gap: self.gap,
                period: self.period,
                model_period: self.model_period,
                delay: self.delay,
                lag: self.lag * self.period,
                model: Model {
                    delay_deviation: Some(self.delay_deviation * self.period),
                    lag_deviation: Some(self.lag_deviation * self.period),
                    ..Model::default()
                },
            },
        }
    }

    /// Returns the indices of a shard, counted from 1. Neighbours, which have similar costs, go to different shards.
    #[must_use]
    pub fn shard(&self, shard: usize, of: usize) -> Vec<usize> {
        (shard.saturating_sub(1)..self.len())
            .step_by(of.max(1))
            .collect()
    }

    /// Returns the number of entries of each cell.
    #[must_use]
    pub fn entries(&self) -> usize {
        Plant::ALL.len() * self.methods.len()
    }

    fn on_axis(&self, i: usize) -> f64 {
        let (low, high) = AXIS;
        let share = i as f64 / (self.cells - 1) as f64;
        // The ends are exact, without the rounding of logarithm and exponential.
        if i == 0 {
            low
        } else if i + 1 == self.cells {
            high
        } else {
            low * (high / low).powf(share)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axes_reach_from_end_to_end_and_walls_come_first() {
        let params = MapParams {
            cells: 5,
            ..MapParams::default()
        };
        assert_eq!((params.columns(), params.len()), (6, 30));
        let wall = params.cell(6);
        assert!((wall.kappa - 0.01).abs() < 1e-15);
        assert_eq!(wall.object_kappa, 0.0);
        assert!(wall.bounce.is_wall());
        let last = params.cell(29);
        assert_eq!((last.kappa, last.object_kappa), (10.0, 10.0));
        assert!((last.bounce.stiffness - 6250.0).abs() < 1e-9);
        assert!((last.bounce.object_mass - 0.25).abs() < 1e-15);
    }

    #[test]
    fn shards_part_the_cells() {
        let params = MapParams {
            cells: 4,
            ..MapParams::default()
        };
        for of in [1, 2, 3, 7, 100] {
            let mut all: Vec<usize> = (1..=of).flat_map(|n| params.shard(n, of)).collect();
            all.sort_unstable();
            assert_eq!(all, (0..params.len()).collect::<Vec<_>>(), "{of}");
        }
    }
}
