//! The hand that holds a point mass.

use std::sync::Arc;

use palpate_testbed::recorded_path::RecordedPath;

/// A hand on a point mass: it pushes, may tremble, may have a mass and a spring of its own, and may let go.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hand {
    /// Constant force f_u on the device `[N]`.
    pub force: f64,
    /// Tremor force on the device, its amplitude in `[N]`.
    pub tremor: Option<Wave>,
    /// The hand's own mass, spring and damper, if it has any.
    pub grip: Option<Grip>,
    /// When the hand lets go of the device, for good `[s]`.
    pub release: Option<f64>,
}

impl Hand {
    /// A hand that pushes with a constant `force` `[N]` and does nothing else.
    #[must_use]
    pub fn pushing(force: f64) -> Self {
        Self {
            force,
            ..Self::default()
        }
    }
}

/// Mass, spring and damper of a hand: its mass moves with the device, and the other two pull the device to
/// where the hand wants to be.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grip {
    /// Mass `[kg]`.
    pub mass: f64,
    /// Stiffness `[N/m]`.
    pub stiffness: f64,
    /// Damping `[N s/m]`.
    pub damping: f64,
    /// Where the hand wants to be.
    pub intention: Intention,
}

/// Where a hand wants to be.
#[derive(Clone, Debug, PartialEq)]
pub enum Intention {
    /// At a place, or swinging about it.
    Place {
        /// The place `[m]`.
        position: f64,
        /// Swing about it, its amplitude in `[m]`.
        swing: Option<Wave>,
    },
    /// On a recorded path; the hand rests at its ends.
    Recorded(Arc<RecordedPath>),
}

impl Intention {
    /// At rest at `position` `[m]`.
    #[must_use]
    pub fn at(position: f64) -> Self {
        Self::Place {
            position,
            swing: None,
        }
    }
}

/// At rest where positions count from.
impl Default for Intention {
    fn default() -> Self {
        Self::at(0.0)
    }
}

/// A sine that begins at 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    /// Amplitude, in the unit of what swings.
    pub amplitude: f64,
    /// Frequency `[Hz]`.
    pub frequency_hz: f64,
}
