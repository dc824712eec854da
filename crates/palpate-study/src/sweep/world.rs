//! Sweep of one key of a world.

use palpate_scene::world::WorldScene;

use super::at_each;
use crate::sim::world::{WorldBench, WorldBenchError};
use palpate_testbed::metrics::Fidelity;

/// Results of a method on a world at a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SweptWorld {
    /// Errors over all devices and axes.
    pub own: Fidelity,
    /// Strongest held force on a device `[N]`.
    pub peak_force: f64,
    /// Strongest force of the ideal on a device `[N]`.
    pub ideal_peak_force: f64,
    /// Generated energy of the held forces `[J]`.
    pub created: f64,
    /// Number of samples that the renderer rejected.
    pub refused: usize,
}

/// Reason why a world cannot be evaluated at a value.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WorldSweepError {
    /// The ideal has no contact, so there is no error.
    #[error("at {key} {value}: the ideal touches no tool in the window, so there is no error")]
    NoContact {
        /// The key.
        key: String,
        /// Its value.
        value: f64,
    },
    /// The world or a method cannot be run.
    #[error("at {key} {value}: {error}")]
    World {
        /// The key.
        key: String,
        /// Its value.
        value: f64,
        /// Cause of the error.
        error: WorldBenchError,
    },
}

/// Runs every method on worlds that differ in the value of one key; returns, per value, the results in the order of
/// `methods`. Calls `done` after each value.
///
/// # Errors
/// A world has no ideal or no contact, or a method cannot render it.
pub fn sweep_worlds(
    key: &str,
    worlds: &[(f64, WorldScene)],
    methods: &[&str],
    done: impl Fn() + Sync,
) -> Result<Vec<Vec<SweptWorld>>, WorldSweepError> {
    at_each(worlds, done, |(value, world)| {
        let found = SweptWorld::of(world, methods).map_err(|error| WorldSweepError::World {
            key: key.into(),
            value: *value,
            error,
        })?;
        let found: Option<Vec<_>> = found.into_iter().collect();
        found.ok_or_else(|| WorldSweepError::NoContact {
            key: key.into(),
            value: *value,
        })
    })
}

impl SweptWorld {
    /// Returns the results of each method on a world; `None` where the ideal touches no tool.
    ///
    /// # Errors
    /// The world has no ideal, or a method cannot render it.
    pub fn of(world: &WorldScene, methods: &[&str]) -> Result<Vec<Option<Self>>, WorldBenchError> {
        let bench = WorldBench::new(world)?;
        let ideal = bench.ideal().devices.iter();
        let peaks = ideal.flat_map(|device| device.peaks.iter().copied());
        let ideal_peak_force = peaks.fold(0.0, f64::max);
        let of = |method: &&str| {
            let renderer = world.renderer(method)?;
            let run = bench.run(method, &renderer)?;
            let peaks = run
                .evaluation
                .devices
                .iter()
                .map(|device| device.peak_force);
            Ok(run.evaluation.sum.map(|own| Self {
                own,
                peak_force: peaks.fold(0.0, f64::max),
                ideal_peak_force,
                created: run.created(),
                refused: run.refused,
            }))
        };
        methods.iter().map(of).collect()
    }
}
