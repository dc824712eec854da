//! Metrics of a rendering: the force held over each period compared with the ideal force.
//!
//! [`ForceEvaluation`] needs only the held forces and applies to closed loops and open-loop replays.
//! [`EnergyEvaluation`] and [`ReboundSpeed`] need the resulting motion, so they apply to closed loops only;
//! [`EnergyEvaluation`] also requires that only the held forces change the loop's energy. All metrics cover one window,
//! that of the [`ForceProfile`].
//!
//! Errors of the force are in percent, after the literature; errors of single collisions and of
//! energy are plain ratios.

pub(crate) mod collisions;
mod energy;
pub(crate) mod fidelity;
mod rebound;

pub use collisions::{CollisionEvaluation, RenderedCollision};
pub use energy::{EnergyEvaluation, Rebound};
pub use fidelity::{Fidelity, FidelityMeter};
pub use rebound::ReboundSpeed;

use thiserror::Error;

use crate::profile::ForceProfile;

/// A record that does not have the length its window asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("the record has {given} entries, but its window has {expected}")]
pub struct WindowMismatch {
    /// Entries given.
    pub given: usize,
    /// Entries expected.
    pub expected: usize,
}

impl WindowMismatch {
    pub(crate) fn unless_equal(given: usize, expected: usize) -> Result<(), Self> {
        if given == expected {
            Ok(())
        } else {
            Err(Self { given, expected })
        }
    }
}

/// How well held forces render an ideal force, in a closed loop or a replay.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceEvaluation {
    /// Errors of the force over the window; `None` if the ideal has no contact in it.
    pub fidelity: Option<Fidelity>,
    /// Each ideal collision that ends within the window, with the rendered one of the same number;
    /// [`RenderedCollision`] says what counts as one.
    pub collisions: Vec<CollisionEvaluation>,
    /// Number of rendered collisions in the window.
    pub rendered_collisions: usize,
    /// Largest held force, pushing or pulling `[N]`; infinite if one is not finite.
    pub peak_force: f64,
}

impl ForceEvaluation {
    /// Evaluates the force on the object `held` over each interval of the window `[N]`.
    ///
    /// # Errors
    ///
    /// `held` does not have one force for each interval of `profile`.
    pub fn new(held: &[f64], profile: &ForceProfile) -> Result<Self, WindowMismatch> {
        Self::evaluated(held, None, profile)
    }

    /// Evaluates lines: the mean force on the object `held` over each interval of the window `[N]`, and its `slopes`
    /// `[N/s]`. The bound is that of lines.
    ///
    /// # Errors
    ///
    /// `held` or `slopes` does not have one entry for each interval of `profile`.
    pub fn of_lines(
        held: &[f64],
        slopes: &[f64],
        profile: &ForceProfile,
    ) -> Result<Self, WindowMismatch> {
        WindowMismatch::unless_equal(slopes.len(), profile.intervals())?;
        Self::evaluated(held, Some(slopes), profile)
    }

    fn evaluated(
        held: &[f64],
        slopes: Option<&[f64]>,
        profile: &ForceProfile,
    ) -> Result<Self, WindowMismatch> {
        WindowMismatch::unless_equal(held.len(), profile.intervals())?;
        let largest = |interval: usize, force: f64| {
            let slope = slopes.map_or(0.0, |slopes| slopes[interval]);
            force.abs() + 0.5 * slope.abs() * profile.grid().duration(interval)
        };
        let runs = collisions::separated(held, profile.grid());
        Ok(Self {
            fidelity: match slopes {
                None => Fidelity::new(held, profile),
                Some(slopes) => Fidelity::of_lines(held, slopes, profile),
            },
            collisions: collisions::evaluated(held, &runs, profile),
            rendered_collisions: runs.len(),
            peak_force: held
                .iter()
                .enumerate()
                .fold(0.0, |peak, (interval, force)| {
                    if force.is_finite() {
                        largest(interval, *force).max(peak)
                    } else {
                        f64::INFINITY
                    }
                }),
        })
    }
}
