//! Loop parameters of a world.

use palpate_core::{Actuation, Range};

use crate::error::out_of_range;
use crate::{SubSteps, Vector, WorldError, WorldField, WorldGuard, WorldPart};

/// Parameters of the loop that renders a world, common to all tools.
#[derive(Clone, Debug, PartialEq)]
pub struct WorldLoop {
    /// Nominal sample period T `[s]`, above 0.
    pub period: f64,
    /// Longest time between two samples that is bridged `[s]`, at least one period. `None`: 20 periods.
    pub largest_gap: Option<f64>,
    /// Maximum plausible device speed `[m/s]`, above 0. `None`: unlimited.
    pub speed_limit: Option<f64>,
    /// Maximum norm of the force on each tool `[N]`, above 0. It applies to the command, and to the command times the
    /// actuation gain. One value per tool, or an empty list.
    pub force_limits: Vec<f64>,
    /// Maximum norm of the torque on each tool `[N m]`: one value per tool, or an empty list.
    pub torque_limits: Vec<f64>,
    /// Maximum plausible angular speed of a device `[rad/s]`, above 0. `None`: unlimited.
    pub turning_limit: Option<f64>,
    /// Actuation model, from a sample to the force on each device.
    pub actuation: Actuation<f64>,
    /// Sub-step settings of an interval.
    pub sub_steps: SubSteps,
    /// Bound on the energy delivered by held forces, over all tools.
    pub guard: WorldGuard,
    /// Least mass of each tool for the guard's bound by acceleration, along each world axis `[kg]`, above 0: one value
    /// per tool, or an empty list for [`WorldHandBound::least_mass`](crate::WorldHandBound::least_mass) of all.
    pub guard_masses: Vec<Vector>,
}

impl WorldLoop {
    /// Creates a loop with nominal `period` `[s]`, plausibility limits of 100 m/s and 100 rad/s, and no force limit.
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
            guard_masses: Vec::new(),
        }
    }

    /// Sets the maximum force of each tool `[N]`.
    #[must_use]
    pub fn with_force_limits(self, force_limits: Vec<f64>) -> Self {
        Self {
            force_limits,
            ..self
        }
    }

    /// Sets the maximum torque of each tool `[N m]`.
    #[must_use]
    pub fn with_torque_limits(self, torque_limits: Vec<f64>) -> Self {
        Self {
            torque_limits,
            ..self
        }
    }

    /// Sets the actuation model.
    #[must_use]
    pub fn with_actuation(self, actuation: Actuation<f64>) -> Self {
        Self { actuation, ..self }
    }

    /// Sets the bound on the energy delivered by the forces.
    #[must_use]
    pub fn with_guard(self, guard: WorldGuard) -> Self {
        Self { guard, ..self }
    }

    /// Sets the least mass of each tool for the guard `[kg]`.
    #[must_use]
    pub fn with_guard_masses(self, guard_masses: Vec<Vector>) -> Self {
        Self {
            guard_masses,
            ..self
        }
    }

    pub(crate) fn bridged_gap(&self) -> f64 {
        self.largest_gap.unwrap_or(20.0 * self.period)
    }

    /// Returns all faults of the loop for a world with this number of tools.
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
        for &mass in self.guard_masses.iter().flatten() {
            above_zero(WorldField::GuardMass, mass);
        }
        if let Some(limit) = self.turning_limit {
            above_zero(WorldField::TurningLimit, limit);
        }
        above_zero(WorldField::Phase, self.sub_steps.phase);
        let limits = [
            (
                WorldField::ForceLimits,
                "force limits",
                self.force_limits.len(),
            ),
            (
                WorldField::TorqueLimits,
                "torque limits",
                self.torque_limits.len(),
            ),
            (
                WorldField::GuardMass,
                "least masses",
                self.guard_masses.len(),
            ),
        ];
        for (field, kind, given) in limits {
            if given != 0 && given != tools {
                fault(
                    field,
                    format!(
                        "there are {given} {kind} and {tools} tools; give one for each, or none"
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
        if !(1 <= least && least <= most && most <= MAX_SUB_STEPS) {
            fault(
                WorldField::SubSteps,
                format!(
                    "sub_steps are {least} to {most}; they have to be at least 1 and at most {MAX_SUB_STEPS}, in \
                     this order"
                ),
            );
        }
        if !(1..=MAX_SUB_STEPS).contains(&finer) {
            fault(
                WorldField::SubSteps,
                format!("finer is {finer}, and has to be 1 to {MAX_SUB_STEPS}"),
            );
        }
        faults.extend(self.guard.faults());
        let mut fault = |field, message: String| {
            faults.push(WorldError::new(WorldPart::Loop, field, "the loop", message));
        };
        let timed = palpate_core::LoopParams {
            actuation: self.actuation,
            ..palpate_core::LoopParams::new(self.period)
        };
        if self.period > 0.0 {
            for error in timed.faults() {
                fault(WorldField::Actuation, error.to_string());
            }
        }
        faults
    }
}

/// Maximum number of sub-steps that can be requested.
const MAX_SUB_STEPS: u32 = 1 << 16;
