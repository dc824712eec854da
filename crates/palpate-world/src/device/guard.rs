//! Passivity guard: a bound on the energy that held forces can give to the hands.
//!
//! A force is fixed before the hand moves. Over one interval it can deliver up to `|f| v T` at speed v, regardless of
//! its origin, and a torque `|t| w T` at angular speed w. A guarantee therefore requires a limit on the forces and
//! torques themselves, over all devices together:
//!
//! ```text
//! sum of (|f| v_max + |t| w_max) T <= balance + allowance - what is on its way
//! balance = what was there at the start or appeared + work of the bodies' constant forces
//!           - what damping and friction took - work at the ports
//! ```
//!
//! While device speeds stay below v_max and w_max and samples arrive within the nominal period, the energy given to
//! the hands never exceeds the available energy plus the allowance. Damping and friction are included as known at the
//! sample.
//!
//! A force may act later than the loop's actuation model. With `late` samples, the work at the ports is computed for
//! each whole number of samples of additional delay up to `late`, and the largest value is used.

use palpate_core::Range;

use crate::device::commands::Commands;
use crate::dynamics::ledger::EnergyLedger;
use crate::error::out_of_range;
use crate::geometry::rigid::Vector3;
use crate::{Vector, WorldError, WorldField, WorldPart};

/// Bound on the delivered energy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum WorldGuard {
    /// No bound.
    #[default]
    Off,
    /// Forces beyond the bound are sent, and reported in [`Limited::guard`](crate::Limited::guard).
    Report(WorldGuardParams),
    /// Forces and torques on all devices are scaled by a common factor between 0 and 1 to respect the bound.
    Limit(WorldGuardParams),
}

/// Parameters of the guard.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldGuardParams {
    /// Maximum speed of each device for which the bound holds, v_max `[m/s]`, above 0.
    pub largest_speed: f64,
    /// Maximum angular speed of each device that turns, w_max `[rad/s]`, above 0.
    pub largest_turning: f64,
    /// Energy that may be delivered in excess of the balance `[J]`, at least 0. With 0, a contact that has not yet
    /// stored energy could not begin to push.
    pub allowance: f64,
    /// Additional delay of the forces over the loop's actuation model, in samples, at most [`MAX_LATE`].
    pub late: usize,
}

/// Maximum unmodelled delay of a guard, in samples.
pub const MAX_LATE: usize = 8;

impl WorldGuard {
    pub(crate) fn params(&self) -> Option<&WorldGuardParams> {
        match self {
            Self::Off => None,
            Self::Report(params) | Self::Limit(params) => Some(params),
        }
    }

    /// Returns whether the guard limits forces.
    pub(crate) fn limits(&self) -> bool {
        matches!(self, Self::Limit(_))
    }

    /// Returns a fault for each parameter out of range.
    pub(crate) fn faults(&self) -> Vec<WorldError> {
        let mut faults = Vec::new();
        let Some(params) = self.params() else {
            return faults;
        };
        let mut fault = |field, message: String| {
            faults.push(WorldError::new(WorldPart::Loop, field, "the loop", message));
        };
        let above_zero = [
            (WorldField::GuardLargestSpeed, params.largest_speed),
            (WorldField::GuardLargestTurning, params.largest_turning),
        ];
        for (field, value) in above_zero {
            if let Some(message) = out_of_range(field, value, Range::Positive) {
                fault(field, message);
            }
        }
        let field = WorldField::GuardAllowance;
        if let Some(message) = out_of_range(field, params.allowance, Range::NotNegative) {
            fault(field, message);
        }
        if params.late > MAX_LATE {
            let late = params.late;
            let message = format!("guard.late is {late}, and has to be at most {MAX_LATE}");
            fault(WorldField::GuardLate, message);
        }
        faults
    }
}

/// A force `[N]` and a torque `[N m]`, or a displacement `[m]` and a rotation `[rad]`.
pub(crate) type Both = [Vector3; 2];

/// State of the guard in addition to the energy ledger.
#[derive(Clone, Debug)]
pub(crate) struct Account {
    /// Initial energy, plus energy that has appeared at first samples since `[J]`.
    there: f64,
    /// Work at the ports for each number of samples of additional delay `[J]`.
    ports: [f64; MAX_LATE + 1],
    /// Action on each tool in the last intervals by the actuation model, newest first.
    acted: Vec<Both>,
    tools: usize,
    /// Energy that the forces of the last output could still deliver to the hands `[J]`.
    pub left: f64,
}

impl Account {
    /// Creates the state for a world with this initial energy `[J]`.
    pub fn new(guard: &WorldGuard, tools: usize, there: f64) -> Self {
        let kept = guard.params().map_or(0, |params| params.late + 1);
        Self {
            there,
            ports: [0.0; MAX_LATE + 1],
            acted: vec![[Vector3::zeros(); 2]; kept * tools],
            tools,
            left: 0.0,
        }
    }

    /// Copies the state of `other`, which has the same guard and number of tools. It does not allocate.
    pub fn copy_from(&mut self, other: &Self) {
        self.there = other.there;
        self.ports = other.ports;
        self.left = other.left;
        for (own, other) in self.acted.iter_mut().zip(&other.acted) {
            *own = *other;
        }
    }

    /// Restarts with the current energy of bodies, contacts and joints, for ledgers that started earlier. The action
    /// in the last interval is also used for the intervals before it. It does not allocate.
    pub fn begin_at(
        &mut self,
        ledger: &EnergyLedger,
        (commands, torque_commands): (&Commands, &Commands),
    ) {
        for (place, acted) in self.acted.iter_mut().enumerate() {
            let tool = place % self.tools;
            *acted = [
                commands.passed(tool).sent,
                torque_commands.passed_or_none(tool),
            ];
        }
        let bodies: f64 = ledger.bodies.iter().map(|entry| entry.kinetic).sum();
        let contacts: f64 = ledger.contacts.iter().map(|entry| entry.stored).sum();
        let joints: f64 = ledger.joints.iter().map(|entry| entry.stored).sum();
        self.there = bodies + contacts + joints - had(ledger);
    }

    /// Adds energy that appeared in the contacts, at a first sample of a tool or a change of the world `[J]`.
    pub fn appeared(&mut self, energy: f64) {
        self.there += energy;
    }

    /// Ends an interval with the forces in `commands`. `moved`: translation and rotation of each device in it; `None`
    /// if unknown. In that case the largest possible work over a `period` `[s]` is assumed.
    pub fn pass(
        &mut self,
        params: &WorldGuardParams,
        (commands, torque_commands): (&Commands, &Commands),
        moved: Option<impl Fn(usize) -> Both>,
        period: f64,
    ) {
        let tools = self.tools;
        self.acted.rotate_right(tools);
        for (tool, acted) in self.acted.iter_mut().take(tools).enumerate() {
            *acted = [
                commands.passed(tool).sent,
                torque_commands.passed_or_none(tool),
            ];
        }
        let late = self.acted.chunks_exact(tools.max(1));
        for (port, acted) in self.ports.iter_mut().zip(late) {
            *port += match &moved {
                Some(moved) => work(acted, moved),
                None => most(params, acted) * period,
            };
        }
    }

    /// Returns the energy that may still be given to the hands over one interval `[J]`. `expected` is the claim of
    /// pending forces `[J]`.
    pub fn free(
        &self,
        params: &WorldGuardParams,
        ledger: &EnergyLedger,
        expected: f64,
        period: f64,
    ) -> f64 {
        let there = self.there + had(ledger) + params.allowance - expected;
        let mut claimed = 0.0;
        let mut least = f64::INFINITY;
        let late = self.acted.chunks_exact(self.tools.max(1));
        for (port, acted) in self.ports.iter().zip(late) {
            let left = there - port - claimed;
            // A non-finite balance blocks all forces.
            least = if left.is_nan() { 0.0 } else { left.min(least) };
            // With one more sample of delay, this force has yet to act.
            claimed += most(params, acted) * period;
        }
        least.max(0.0)
    }
}

/// Returns the energy available since the start of the ledger, without the initial energy and the work at the ports
/// `[J]`. It is the work of the bodies' constant forces and of external changes, minus the energy dissipated by
/// damping and friction. Excluded are the work of a mechanism that lacks an axis and that of a hand that turns a tool
/// without a torque: a hand that feels no motor cannot receive this energy.
fn had(ledger: &EnergyLedger) -> f64 {
    let gone = &ledger.gone;
    let bodies = ledger.bodies.iter().chain([&gone.bodies]);
    let bodies: f64 = bodies.map(|entry| entry.outside - entry.potential).sum();
    let contacts = ledger.contacts.iter().chain([&gone.contacts]);
    let contacts: f64 = contacts.map(|entry| entry.dissipated).sum();
    let joints = ledger.joints.iter().chain([&gone.joints]);
    let joints: f64 = joints.map(|entry| entry.dissipated).sum();
    bodies - contacts - joints
}

/// Returns the work of the actions on the tools over their motions `[J]`.
fn work(acted: &[Both], moved: impl Fn(usize) -> Both) -> f64 {
    let each = acted.iter().enumerate().map(|(tool, [force, torque])| {
        let [way, turn] = moved(tool);
        force.dot(&way) + torque.dot(&turn)
    });
    each.sum()
}

/// Returns the maximum power of the actions on the tools `[W]`.
fn most(params: &WorldGuardParams, acting: &[Both]) -> f64 {
    let each = acting.iter().map(|[force, torque]| {
        force.norm() * params.largest_speed + torque.norm() * params.largest_turning
    });
    each.sum()
}

/// Returns the maximum power of the forces and torques to be sent, from their magnitudes `[W]`.
pub(crate) fn most_of(params: &WorldGuardParams, forces: &[Vector], torques: &[Vector]) -> f64 {
    let size = |vectors: &[Vector]| -> f64 {
        let sizes = vectors.iter().map(|vector| Vector3::from(*vector).norm());
        sizes.sum()
    };
    size(forces) * params.largest_speed + size(torques) * params.largest_turning
}
