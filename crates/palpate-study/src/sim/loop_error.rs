//! Errors that prevent a scene from running.

use palpate_scene::SetupError;
use palpate_testbed::InvalidParameter;
use palpate_testbed::reference::ReferenceError;

use crate::sim::run::MAX_PERIODS;

/// Reason why a scene cannot run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LoopError {
    /// The method cannot be set up.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The bench refuses a value.
    #[error(transparent)]
    Bench(#[from] InvalidParameter),
    /// No ideal can be integrated.
    #[error(transparent)]
    Ideal(#[from] ReferenceError),
    /// The ideal in closed form does not collide as often as the window asks.
    #[error(
        "the window requires {asked} collisions, but the ideal has only {found}; give a duration instead"
    )]
    TooFewCollisions {
        /// Requested number of collisions.
        asked: usize,
        /// Collisions of the ideal.
        found: usize,
    },
    /// A run is to vary what the ideal depends on.
    #[error(
        "the scene differs from the bench's in more than method settings, guard, model values and, if the loop is \
         perfect, delay; create another bench for it"
    )]
    AnotherScene,
    /// The window is too long.
    #[error("the window has {0} periods; at most {MAX_PERIODS} fit")]
    TooLong(f64),
}
