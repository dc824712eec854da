//! Input and output of a tick.

use palpate_core::Fault;

use crate::{Effort, Quaternion, Vector};

/// One sample of all devices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<'a> {
    /// Measured position of each tool, in the order of the world's tools `[m]`.
    pub positions: &'a [Vector],
    /// Measured orientation of each tool, in the same order: a unit quaternion `[w, x, y, z]` that rotates the tool's
    /// axes to the world's. Ignored for a tool that does not turn; empty if none turns.
    pub orientations: &'a [Quaternion],
    /// Measured time since the previous sample `[s]`; `None`: one nominal period.
    pub elapsed: Option<f64>,
}

impl<'a> Sample<'a> {
    /// Creates a sample with the tools at `positions` `[m]`, one nominal period after the previous one.
    #[must_use]
    pub fn at(positions: &'a [Vector]) -> Self {
        Self {
            positions,
            orientations: &[],
            elapsed: None,
        }
    }

    /// Sets the orientations of the tools.
    #[must_use]
    pub fn turned(self, orientations: &'a [Quaternion]) -> Self {
        Self {
            orientations,
            ..self
        }
    }

    /// Sets the measured time since the previous sample `[s]`.
    #[must_use]
    pub fn after(self, elapsed: f64) -> Self {
        Self {
            elapsed: Some(elapsed),
            ..self
        }
    }
}

/// Limits that acted in a tick, on any tool.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Limited {
    /// A force exceeded [`WorldLoop::force_limits`](crate::WorldLoop::force_limits).
    pub force: bool,
    /// A torque exceeded [`WorldLoop::torque_limits`](crate::WorldLoop::torque_limits).
    pub torque: bool,
    /// A proxy offset exceeded [`CoupledParams::offset_limit`](crate::CoupledParams::offset_limit) or
    /// [`CoupledParams::turn_limit`](crate::CoupledParams::turn_limit).
    pub offset: bool,
    /// Forces and torques could deliver more energy than available, by the bound of
    /// [`WorldLoop::guard`](crate::WorldLoop::guard).
    pub guard: bool,
    /// A device accelerated beyond the guard's [`WorldHandBound`](crate::WorldHandBound) in the interval that this
    /// sample ends. The bound by speed applies to it.
    pub beyond_guard: bool,
}

impl Limited {
    /// Combines the limits of both.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            force: self.force || other.force,
            torque: self.torque || other.torque,
            offset: self.offset || other.offset,
            guard: self.guard || other.guard,
            beyond_guard: self.beyond_guard || other.beyond_guard,
        }
    }

    /// Returns whether any limit acted.
    #[must_use]
    pub fn any(self) -> bool {
        self.force || self.torque || self.offset || self.guard
    }
}

/// Reason for rejecting a sample. All forces are then 0, and the bodies pause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct WorldFault {
    /// Kind of fault.
    pub fault: Fault,
    /// Index of the tool with the faulty position or orientation, if there is one.
    pub tool: Option<usize>,
}

/// Result of a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output<'a> {
    /// Force on each tool, which its device exerts on the hand until the next sample `[N]`.
    pub forces: &'a [Vector],
    /// Slope of each force `[N/s]`: with a line hold the force is `force + slope (t - T/2)` for t from 0 to the period
    /// T, then its last value; otherwise 0.
    pub slopes: &'a [Vector],
    /// Torque on each tool about its mass centre, along the world's axes, held until the next sample `[N m]`; zero
    /// for a tool that does not turn.
    pub torques: &'a [Vector],
    /// Active limits.
    pub limited: Limited,
    /// Computing effort of the tick, and sub-steps that exceeded the budget.
    pub effort: Effort,
    /// Reason for rejecting the sample, if it was rejected.
    pub fault: Option<WorldFault>,
}
