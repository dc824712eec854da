//! The loop in which a world is rendered.

use palpate::{Actuation, Range};

use crate::fault::out_of_range;
use crate::{SubSteps, WorldError, WorldField, WorldGuard, WorldPart};

/// The loop in which a world is rendered: the same for every tool.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldLoop {
    /// Nominal time from sample to sample T `[s]`, above 0.
    pub period: f64,
    /// Longest time between two samples that is bridged `[s]`, at least one period. `None`: 20 periods.
    pub largest_gap: Option<f64>,
    /// Fastest motion of a device that is believed `[m/s]`, above 0. `None`: any.
    pub speed_limit: Option<f64>,
    /// Largest force on each tool, by its norm `[N]`, above 0: of the command, and of the command times the gain of the
    /// actuation. One number for each tool, or none at all.
    pub force_limits: Vec<f64>,
    /// Largest torque on each tool `[N m]`: one number for each tool, or an empty list.
    pub torque_limits: Vec<f64>,
    /// Fastest turning of a device that is believed `[rad/s]`, above 0. `None`: any.
    pub turning_limit: Option<f64>,
    /// What is known of the way from a sample to the force on each device.
    pub actuation: Actuation<f64>,
    /// How finely an interval is integrated.
    pub sub_steps: SubSteps,
    /// Bound on the energy that held forces give out, of all tools together.
    pub guard: WorldGuard,
}

impl WorldLoop {
    /// A loop of nominal `period` `[s]` that believes device speeds up to 100 m/s and 100 rad/s and limits no force.
    #[must_use]
    pub fn new(period: f64) -> Self {
        Self {
            period,
            largest_gap: None,
            speed_limit: Some(100.0),
            force_limits: Vec::new(),
            torque_limits: Vec::new(),
            turning_limit: Some(100.0),
            actuation: Actuation::default(),
            sub_steps: SubSteps::default(),
            guard: WorldGuard::Off,
        }
    }

    /// The same loop with a largest force for each tool `[N]`.
    #[must_use]
    pub fn with_force_limits(self, force_limits: Vec<f64>) -> Self {
        Self {
            force_limits,
            ..self
        }
    }

    /// The same loop with a largest torque for each tool `[N m]`.
    #[must_use]
    pub fn with_torque_limits(self, torque_limits: Vec<f64>) -> Self {
        Self {
            torque_limits,
            ..self
        }
    }

    /// The same loop with what is known of its actuators.
    #[must_use]
    pub fn with_actuation(self, actuation: Actuation<f64>) -> Self {
        Self { actuation, ..self }
    }

    /// The same loop with a bound on the energy that its forces give out.
    #[must_use]
    pub fn with_guard(self, guard: WorldGuard) -> Self {
        Self { guard, ..self }
    }

    pub(crate) fn bridged_gap(&self) -> f64 {
        self.largest_gap.unwrap_or(20.0 * self.period)
    }

    /// Everything that is wrong with the loop of a world of so many tools.
    pub(crate) fn faults(&self, tools: usize) -> Vec<WorldError> {
        let mut faults = Vec::new();
        let mut fault = |field, message: String| {
            faults.push(WorldError::new(WorldPart::Loop, field, "the loop", message));
        };
        let mut above_zero = |field: WorldField, value: f64| {
            if let Some(message) = out_of_range(field, value, Range::Positive) {
                fault(field, message);
            }
        };
        above_zero(WorldField::Period, self.period);
        if let Some(limit) = self.speed_limit {
            above_zero(WorldField::SpeedLimit, limit);
        }
        for &limit in &self.force_limits {
            above_zero(WorldField::ForceLimits, limit);
        }
        for &limit in &self.torque_limits {
            above_zero(WorldField::TorqueLimits, limit);
        }
        if let Some(limit) = self.turning_limit {
            above_zero(WorldField::TurningLimit, limit);
        }
        above_zero(WorldField::Phase, self.sub_steps.phase);
        let limits = [
            (WorldField::ForceLimits, "force", self.force_limits.len()),
            (WorldField::TorqueLimits, "torque", self.torque_limits.len()),
        ];
        for (field, kind, given) in limits {
            if given != 0 && given != tools {
                fault(
                    field,
                    format!(
                        "there are {given} {kind} limits and {tools} tools; give one for each, or none"
                    ),
                );
            }
        }
        if let Some(gap) = self.largest_gap
            && !(gap >= self.period && gap.is_finite())
        {
            fault(
                WorldField::LargestGap,
                format!("largest_gap is {gap} s, and has to be at least one period"),
            );
        }
        let SubSteps {
            least, most, finer, ..
        } = self.sub_steps;
        if !(1 <= least && least <= most && most <= MOST_SUB_STEPS) {
            fault(
                WorldField::SubSteps,
                format!(
                    "sub_steps are {least} to {most}; they have to be at least 1 and at most {MOST_SUB_STEPS}, in \
                     this order"
                ),
            );
        }
        if !(1..=MOST_SUB_STEPS).contains(&finer) {
            fault(
                WorldField::SubSteps,
                format!("finer is {finer}, and has to be 1 to {MOST_SUB_STEPS}"),
            );
        }
        faults.extend(self.guard.faults());
        let mut fault = |field, message: String| {
            faults.push(WorldError::new(WorldPart::Loop, field, "the loop", message));
        };
        let timed = palpate::LoopParams {
            actuation: self.actuation,
            ..palpate::LoopParams::new(self.period)
        };
        if self.period > 0.0 {
            for error in timed.faults() {
                fault(WorldField::Actuation, error.to_string());
            }
        }
        faults
    }
}

/// Most sub-steps that may be asked for.
const MOST_SUB_STEPS: u32 = 1 << 16;
