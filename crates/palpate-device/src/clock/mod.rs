//! Clocks of a loop: the [`Clock`] trait returns the current time and sleeps until a deadline.
//!
//! Times are [`Duration`]s since the clock's origin. The clock is a type parameter of the loop, so tests can run the
//! whole loop on a manually stepped clock.

mod monotonic;
mod stepped;

use std::time::Duration;

pub use monotonic::MonotonicClock;
pub use stepped::SteppedClock;

/// A monotonic clock. Clones show the same time.
pub trait Clock: Clone + Send + 'static {
    /// Whether time advances by itself. If it advances only in [`sleep_until`](Self::sleep_until), a loop is never
    /// late, and only the loop may sleep on its clock.
    const RUNS: bool;

    /// Returns the time since the origin.
    fn now(&self) -> Duration;

    /// Sleeps until `deadline` or later; returns immediately if it has passed.
    fn sleep_until(&self, deadline: Duration);
}
