//! The ideal motion and force of a scene in continuous time.
//!
//! The equations are integrated by steps of [order 5](super::dormand_prince) under control of their error. No
//! step crosses an event: the begin and the end of a contact, a normal force that damping brings to 0, the
//! change between sticking and slipping, another nearest face or edge. Each event is bracketed by the step's
//! continuous solution and located to round-off; the next step begins there. Impulses and ∫ f² are integrated
//! with the motion, not summed from samples.

use super::contact::WorldError;
use super::motion::System;
use super::prescribed_motion::LedPath;
use super::record::{DeviceProfile, Encounter, WorldState};
use super::run::Run;
use super::scene::WorldScene;
use super::vector::Vec3;
use crate::InvalidParameter;
use crate::error::positive;
use crate::grid::Grid;

/// Local error of a step, relative to 1 mm, 0.1 m/s and the corresponding rotations.
pub const TOLERANCE: f64 = 1e-11;

/// The ideal of a scene over a window.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldIdeal {
    /// Intervals of the window.
    pub grid: Grid,
    /// The force on each device's tool.
    pub devices: Vec<DeviceProfile>,
    /// States at all edges of the grid: one more than it has intervals.
    pub states: Vec<WorldState>,
    /// Every contact from begin to end, in the order in which they begin.
    pub encounters: Vec<Encounter>,
    /// Steps taken.
    pub steps: usize,
    /// Events located.
    pub events: usize,
}

impl WorldIdeal {
    /// The ideal of `scene` over the window of `grid`, which begins at t = 0.
    ///
    /// # Errors
    ///
    /// A parameter of the scene outside its range, a pair of shapes that cannot touch, a window that does not begin
    /// at 0, or more than 200 000 steps in an interval.
    pub fn new(scene: &WorldScene, grid: Grid) -> Result<Self, WorldError> {
        Self::with_tolerance(scene, grid, TOLERANCE)
    }

    /// Solves the ideal with another local error of a step than [`TOLERANCE`].
    ///
    /// # Errors
    ///
    /// Those of [`new`](Self::new), or `tolerance` is not finite and above 0.
    pub fn with_tolerance(
        scene: &WorldScene,
        grid: Grid,
        tolerance: f64,
    ) -> Result<Self, WorldError> {
        Self::solve(scene, grid, tolerance, None)
    }

    /// Solves the ideal of `scene` with position-driven devices that follow a path. Their masses and hands have no
    /// effect.
    ///
    /// # Errors
    ///
    /// Those of [`with_tolerance`](Self::with_tolerance); the path has another number of devices or ends before the
    /// window; or it has no orientations for a device that turns.
    pub fn led(
        scene: &WorldScene,
        grid: Grid,
        path: &LedPath,
        tolerance: f64,
    ) -> Result<Self, WorldError> {
        InvalidParameter::unless(
            path.devices() == scene.devices.len(),
            "path.devices".to_owned(),
            path.devices() as f64,
            "one for each device of the scene",
        )?;
        InvalidParameter::unless(
            grid.end() <= path.end() * (1.0 + 1e-9),
            "grid.end".to_owned(),
            grid.end(),
            "at most the end of the path",
        )?;
        let turns = scene.devices.iter().filter(|it| it.turning.is_some());
        let turns = turns.count();
        InvalidParameter::unless(
            turns == 0 || path.turns(),
            "devices.turning".to_owned(),
            turns as f64,
            "0 on a path without orientations",
        )?;
        Self::solve(&path.unmoved(scene), grid, tolerance, Some(path))
    }

    fn solve(
        scene: &WorldScene,
        grid: Grid,
        tolerance: f64,
        path: Option<&LedPath>,
    ) -> Result<Self, WorldError> {
        let system = System::new(scene)?;
        positive("tolerance".to_owned(), tolerance, "finite and above 0")?;
        InvalidParameter::unless(
            grid.start() == 0.0,
            "grid.start".to_owned(),
            grid.start(),
            "0 s, the start of the scene",
        )?;
        let mut run = Run::new(&system, tolerance);
        let mut devices = vec![DeviceProfile::default(); scene.devices.len()];
        let mut states = vec![run.world_state()];
        for interval in 0..grid.intervals() {
            let end = grid.edge(interval + 1);
            match path {
                Some(path) => path.follow(&mut run, end)?,
                None => run.advance(end)?,
            }
            for (number, profile) in devices.iter_mut().enumerate() {
                let sums = system.layout.device_sums(number);
                profile.impulses.push(Vec3::new(&run.state[sums..]).0);
                profile.squares.push(Vec3::new(&run.state[sums + 3..]).0);
                profile.peaks.push(run.peaks[number]);
                let place = system.layout.moment_sums(number);
                let (middle, moments) = (0.5 * (grid.edge(interval) + end), &run.state[place..]);
                profile.moments.push(std::array::from_fn(|axis| {
                    moments[axis] - run.state[sums + axis] * middle
                }));
                run.state[place..place + 3].fill(0.0);
                // Restart the sums at 0 to avoid differences of large numbers.
                run.state[sums..sums + 6].fill(0.0);
                if scene.devices[number].turning.is_some() {
                    let sums = system.layout.torque_sums(number);
                    let of = |from: usize| Vec3::new(&run.state[from..]).0;
                    profile.torque_impulses.push(of(sums));
                    profile.torque_squares.push(of(sums + 3));
                    run.state[sums..sums + 6].fill(0.0);
                }
            }
            run.peaks.fill(0.0);
            states.push(run.world_state());
        }
        let encounters = run.encounters();
        Ok(Self {
            grid,
            devices,
            states,
            encounters,
            steps: run.steps,
            events: run.events,
        })
    }

    /// Largest penetration of all contacts `[m]`.
    #[must_use]
    pub fn deepest(&self) -> f64 {
        self.encounters
            .iter()
            .fold(0.0, |deepest, encounter| deepest.max(encounter.deepest))
    }
}
