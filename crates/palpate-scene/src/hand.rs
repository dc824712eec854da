//! The hand that holds a point mass.

use std::sync::Arc;

use palpate_testbed::recorded_path::RecordedPath;

/// A hand on a point mass: a push, with optional tremor, own mass and spring, and release.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Hand {
    /// Constant force f_u on the device `[N]`.
    pub force: f64,
    /// Tremor force on the device, its amplitude in `[N]`.
    pub tremor: Option<Wave>,
    /// The hand's own mass, spring and damper, if it has any.
    pub grip: Option<Grip>,
    /// Time at which the hand releases the device permanently `[s]`.
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

/// Mass, spring and damper of a hand. The mass moves with the device; spring and damper pull the device to the hand's
/// intended position.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grip {
    /// Mass `[kg]`.
    pub mass: f64,
    /// Stiffness `[N/m]`.
    pub stiffness: f64,
    /// Damping `[N s/m]`.
    pub damping: f64,
    /// Intended position of the hand.
    pub intention: Intention,
}

/// Intended position of a hand.
#[derive(Clone, Debug, PartialEq)]
pub enum Intention {
    /// A constant position, or an oscillation about it.
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
    /// Creates a constant intended position `[m]`.
    #[must_use]
    pub fn at(position: f64) -> Self {
        Self::Place {
            position,
            swing: None,
        }
    }
}

/// Constant position at the origin.
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
