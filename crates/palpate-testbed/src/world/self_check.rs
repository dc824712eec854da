//! Self-check of the ideal: whether the motion of a scene can be computed.
//!
//! In a sequence of contacts, each contact amplifies a small difference. After enough of them the round-off of the
//! computation dominates the ideal, and it is no longer a valid reference solution.

use super::contact::WorldError;
use super::ideal::{TOLERANCE, WorldIdeal};
use super::prescribed_motion::LedPath;
use super::scene::WorldScene;
use crate::grid::Grid;

/// Largest E of the ideal against itself `[%]`.
pub const LARGEST_ERROR: f64 = 0.01;

/// The local error of the other solution, over [`TOLERANCE`]: steps about four times as long.
const COARSER: f64 = 1000.0;

/// An ideal that has been computed twice, with steps of about one and four lengths.
#[derive(Debug, Clone, PartialEq)]
pub struct CheckedIdeal {
    /// The finer one, over the part of the window for which both agree.
    pub ideal: WorldIdeal,
    /// Mean-force error E of the coarser one against it, over that part `[%]`; below [`LARGEST_ERROR`]. All
    /// devices and axes together, in the norm of the devices' mobility.
    pub error: f64,
    /// Time from which on they do not agree `[s]`; `None` if they do so for the whole window.
    pub chaotic_from: Option<f64>,
}

impl CheckedIdeal {
    /// Solves `scene` over the window of `grid`, and again with longer steps. If the two solutions diverge, the scene
    /// is chaotic and the window is shortened.
    ///
    /// # Errors
    ///
    /// Those of [`WorldIdeal::new`], or the two solutions diverge in the first interval.
    pub fn new(scene: &WorldScene, grid: Grid) -> Result<Self, WorldError> {
        Self::of(scene, grid, |grid, tolerance| {
            WorldIdeal::with_tolerance(scene, grid, tolerance)
        })
    }

    /// Solves a scene whose position-driven devices follow a path.
    ///
    /// # Errors
    ///
    /// Those of [`WorldIdeal::led`], or the two solutions diverge in the first interval.
    pub fn led(scene: &WorldScene, grid: Grid, path: &LedPath) -> Result<Self, WorldError> {
        Self::of(scene, grid, |grid, tolerance| {
            WorldIdeal::led(scene, grid, path, tolerance)
        })
    }

    fn of(
        scene: &WorldScene,
        grid: Grid,
        solve: impl Fn(Grid, f64) -> Result<WorldIdeal, WorldError>,
    ) -> Result<Self, WorldError> {
        let ideal = solve(grid.clone(), TOLERANCE)?;
        let other = solve(grid, COARSER * TOLERANCE)?;
        let errors = errors(scene, &ideal, &other);
        let agree = errors
            .iter()
            .position(|error| error.is_nan() || *error >= LARGEST_ERROR)
            .unwrap_or(errors.len());
        if agree == errors.len() {
            return Ok(Self {
                error: errors.last().copied().unwrap_or(0.0),
                ideal,
                chaotic_from: None,
            });
        }
        let time = ideal.grid.edge(agree);
        if agree == 0 {
            return Err(WorldError::Chaotic { time });
        }
        let ideal = solve(ideal.grid.shortened(agree), TOLERANCE)?;
        Ok(Self {
            ideal,
            error: errors[agree - 1],
            chaotic_from: Some(time),
        })
    }
}

/// E `[%]` of one solution against the other over the first interval, the first two, and so on.
fn errors(scene: &WorldScene, ideal: &WorldIdeal, other: &WorldIdeal) -> Vec<f64> {
    let (mut of_ideal, mut apart) = (0.0, 0.0);
    (0..ideal.grid.intervals())
        .map(|interval| {
            let duration = ideal.grid.duration(interval);
            for (number, device) in scene.devices.iter().enumerate() {
                let [one, two] = [ideal, other].map(|ideal| &ideal.devices[number]);
                for axis in 0..3 {
                    let mobility = 1.0 / device.mass[axis];
                    let difference = one.impulses[interval][axis] - two.impulses[interval][axis];
                    apart += mobility * difference * difference / duration;
                    of_ideal += mobility * one.squares[interval][axis];
                }
                let Some(turning) = &device.turning else {
                    continue;
                };
                for (axis, mobility) in turning.mobility().into_iter().enumerate() {
                    let impulses = [one, two].map(|it| it.torque_impulses[interval][axis]);
                    apart += mobility * (impulses[0] - impulses[1]).powi(2) / duration;
                    of_ideal += mobility * one.torque_squares[interval][axis];
                }
            }
            if apart == 0.0 {
                0.0
            } else {
                100.0 * (apart / of_ideal).sqrt()
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;
    use crate::world::benchmarks::paddle;

    /// The ball on a paddle over 20 periods, checked against a coarser solution that `change` has changed.
    fn checked_against(change: impl Fn(&mut WorldIdeal)) -> Result<CheckedIdeal, WorldError> {
        let scene = paddle().start(0);
        let solved = Cell::new(0);
        CheckedIdeal::of(&scene, Grid::even(0.0, 0.01, 20), |grid, tolerance| {
            let mut ideal = WorldIdeal::with_tolerance(&scene, grid, tolerance)?;
            if solved.replace(solved.get() + 1) == 1 {
                change(&mut ideal);
            }
            Ok(ideal)
        })
    }

    #[test]
    fn a_solution_without_a_number_agrees_with_nothing_from_there_on() {
        let whole = checked_against(|_| ()).unwrap();
        assert_eq!(whole.chaotic_from, None);
        assert!(whole.error < LARGEST_ERROR, "{}", whole.error);
        for not_a_number in [f64::NAN, f64::INFINITY] {
            let found =
                checked_against(|ideal| ideal.devices[0].impulses[7][2] = not_a_number).unwrap();
            assert_eq!(found.chaotic_from, Some(whole.ideal.grid.edge(7)));
            assert_eq!(found.ideal.grid.intervals(), 7);
            assert!(found.error < LARGEST_ERROR, "{}", found.error);
            let at_once = checked_against(|ideal| ideal.devices[0].impulses[0][2] = not_a_number);
            assert!(
                matches!(at_once, Err(WorldError::Chaotic { time: 0.0 })),
                "{at_once:?}"
            );
        }
    }
}
