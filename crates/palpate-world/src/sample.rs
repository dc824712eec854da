//! What goes into a tick of a world and what comes out of it.

use palpate::Fault;

use crate::{Effort, Quaternion, Vector};

/// One sample of all devices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<'a> {
    /// Measured position of each tool, in the order of the world's tools `[m]`.
    pub positions: &'a [Vector],
    /// Measured orientation of each tool, in the same order: a unit quaternion `[w, x, y, z]` that turns the tool's
    /// axes into the world's. That of a tool that does not turn is not looked at; empty if none turns.
    pub orientations: &'a [Quaternion],
    /// Time since the previous sample, if it was measured `[s]`; `None`: one nominal period.
    pub elapsed: Option<f64>,
}

impl<'a> Sample<'a> {
    /// A sample with the tools at `positions` `[m]`, one nominal period after the previous one.
    #[must_use]
    pub fn at(positions: &'a [Vector]) -> Self {
        Self {
            positions,
            orientations: &[],
            elapsed: None,
        }
    }

    /// The same sample with the tools turned by `orientations`.
    #[must_use]
    pub fn turned(self, orientations: &'a [Quaternion]) -> Self {
        Self {
            orientations,
            ..self
        }
    }

    /// The same sample, taken a measured time after the previous one `[s]`.
    #[must_use]
    pub fn after(self, elapsed: f64) -> Self {
        Self {
            elapsed: Some(elapsed),
            ..self
        }
    }
}

/// Which limits acted in a tick, on any tool.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Limited {
    /// A force exceeded [`WorldLoop::force_limits`](crate::WorldLoop::force_limits).
    pub force: bool,
    /// A torque exceeded [`WorldLoop::torque_limits`](crate::WorldLoop::torque_limits).
    pub torque: bool,
    /// An offset of an avatar exceeded [`CoupledParams::offset_limit`](crate::CoupledParams::offset_limit)
    /// or [`CoupledParams::turn_limit`](crate::CoupledParams::turn_limit).
    pub offset: bool,
    /// Forces and torques could give out more energy than there is: the bound of
    /// [`WorldLoop::guard`](crate::WorldLoop::guard).
    pub guard: bool,
}

impl Limited {
    /// Limits of either.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            force: self.force || other.force,
            torque: self.torque || other.torque,
            offset: self.offset || other.offset,
            guard: self.guard || other.guard,
        }
    }

    /// Whether any limit acted.
    #[must_use]
    pub fn any(self) -> bool {
        self.force || self.torque || self.offset || self.guard
    }
}

/// Why a sample was refused: all forces are then 0, and the bodies wait.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct WorldFault {
    /// What is wrong.
    pub fault: Fault,
    /// The tool whose position or orientation it is, where it is one's.
    pub tool: Option<usize>,
}

/// The answer to one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output<'a> {
    /// Force on each tool `[N]`: what its device is to give to the hand, and to hold until the next sample.
    pub forces: &'a [Vector],
    /// Torque on each tool about its mass centre, along the world's axes `[N m]`, to be held likewise; zero for a tool
    /// that does not turn.
    pub torques: &'a [Vector],
    /// Limits that acted.
    pub limited: Limited,
    /// What the tick has cost, and what did not fit in it.
    pub effort: Effort,
    /// Why the sample was refused, if it was.
    pub fault: Option<WorldFault>,
}
