//! Time as the loop sees it: a clock that says what time it is and sleeps until a given time.
//!
//! Times are [`Duration`]s since the clock's origin. The loop takes its clock as a type parameter,
//! so that the whole of it runs on a clock that a test moves by hand.

mod monotonic;
mod stepped;

use std::time::Duration;

pub use monotonic::MonotonicClock;
pub use stepped::SteppedClock;

/// A clock that never runs backwards. Clones show the same time.
pub trait Clock: Clone + Send + 'static {
    /// Whether time passes by itself. Where it passes only for whoever sleeps, nobody is late, and
    /// nobody else may sleep on the clock of a loop.
    const RUNS: bool;

    /// Time since the origin.
    fn now(&self) -> Duration;

    /// Returns at `deadline` or later; at once if that has passed.
    fn sleep_until(&self, deadline: Duration);
}
