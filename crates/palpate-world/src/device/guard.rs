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
//! The port work is that of the mean force over the measured displacement. A quantum of the sensors, and a force that
//! changes between two samples, can hide work from it. The largest hidden energy is deducted, and decreases by
//! [`WorldGuardParams::recovery`], as in the guard of one contact ([`palpate_core::GuardParams`]).
//!
//! With a [`WorldHandBound`] the last step of each device limits its next one. The largest common factor by the speeds
//! or by the accelerations is used.
//!
//! A force may act later than the loop's actuation model. With `late` samples, the work at the ports is computed for
//! each whole number of samples of additional delay up to `late`, and the largest value is used.

mod hand;

use palpate_core::{Range, Uneven};

use hand::{Price, ToolMotion};

use crate::device::commands::Commands;
use crate::dynamics::ledger::EnergyLedger;
use crate::error::out_of_range;
use crate::geometry::rigid::Vector3;
use crate::{WorldError, WorldField, WorldLoop, WorldPart};

pub use hand::{WorldHandBound, WorldHandLimit};

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
    /// Additional delay of the forces over the loop's actuation model, in samples, at most [`MAX_LATE`]; 0 with a
    /// bound on the acceleration.
    pub late: usize,
    /// Largest quantum of the position along an axis of any device `[m]`, at least 0.
    pub quantum: f64,
    /// Largest quantum of the rotation about an axis of any device `[rad]`, at least 0.
    pub angle_quantum: f64,
    /// Power by which the energy that may have been given out unnoticed is forgiven `[W]`, at least 0. The guarantee of
    /// a force that changes between two samples, or of a sensor with a quantum, is the allowance plus this power times
    /// the time.
    pub recovery: f64,
    /// Bound on the acceleration of the devices. `None`: the bound by speed only.
    pub hand: Option<WorldHandBound>,
}

impl WorldGuardParams {
    /// Creates the bound by the largest speed `[m/s]` and angular speed `[rad/s]` with an allowance `[J]`, for sensors
    /// without a quantum, strict.
    #[must_use]
    pub const fn by_speed(largest_speed: f64, largest_turning: f64, allowance: f64) -> Self {
        Self {
            largest_speed,
            largest_turning,
            allowance,
            late: 0,
            quantum: 0.0,
            angle_quantum: 0.0,
            recovery: 0.0,
            hand: None,
        }
    }

    /// Returns the energy that the quanta hide at a change of force and torque `[J]`.
    fn in_quanta(&self, [force, torque]: &Both) -> f64 {
        0.5 * (self.quantum * force.lp_norm(1) + self.angle_quantum * torque.lp_norm(1))
    }

    /// Returns the largest energy that a force and a torque with these means and bounds gave out beyond their port work
    /// `[J]`, while the device `moved` in `elapsed` `[s]`.
    fn hidden_by_speed(
        &self,
        held: &Both,
        [force, torque]: &[Uneven<f64>; 2],
        moved: &Both,
        elapsed: f64,
    ) -> f64 {
        let power = self.largest_speed * force.course + self.largest_turning * torque.course;
        let by_course = 4.0 * power / elapsed;
        if self.late > 0 {
            // The force acts over a later motion.
            return by_course;
        }
        let size = [
            force.size.max(held[0].norm() * elapsed),
            torque.size.max(held[1].norm() * elapsed),
        ];
        let most = self.largest_speed * size[0] + self.largest_turning * size[1]
            - held[0].dot(&moved[0])
            - held[1].dot(&moved[1])
            + 2.0 * self.in_quanta(held);
        by_course.min(most.max(0.0))
    }
}

/// Maximum unmodelled delay of a guard, in samples.
pub const MAX_LATE: usize = 8;

impl WorldGuard {
    /// Returns the parameters of the bound; `None` if the guard is off.
    #[must_use]
    pub fn params(&self) -> Option<&WorldGuardParams> {
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
        let own = [
            (
                WorldField::GuardLargestSpeed,
                params.largest_speed,
                Range::Positive,
            ),
            (
                WorldField::GuardLargestTurning,
                params.largest_turning,
                Range::Positive,
            ),
            (
                WorldField::GuardAllowance,
                params.allowance,
                Range::NotNegative,
            ),
            (WorldField::GuardQuantum, params.quantum, Range::NotNegative),
            (
                WorldField::GuardAngleQuantum,
                params.angle_quantum,
                Range::NotNegative,
            ),
            (
                WorldField::GuardRecovery,
                params.recovery,
                Range::NotNegative,
            ),
        ];
        let of_hand = params.hand.map(|hand| hand.ranges());
        for (field, value, range) in own.into_iter().chain(of_hand.into_iter().flatten()) {
            if let Some(message) = out_of_range(field, value, range) {
                fault(field, message);
            }
        }
        if params.late > 0 && params.hand.is_some() {
            let late = params.late;
            let message = format!(
                "guard.late is {late}, and a bound on the acceleration needs forces that act by the actuation model; \
                 put the delay into the actuation, or leave out guard.hand"
            );
            fault(WorldField::GuardLate, message);
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
    /// Motion of each tool; empty without a guard.
    motions: Vec<ToolMotion>,
    /// Bounds on force and torque of each tool in the interval that is about to pass; empty without a guard.
    uneven: Vec<[Uneven<f64>; 2]>,
    /// Energy that may have been delivered unnoticed `[J]`.
    hidden: f64,
    /// Energy that the forces of the last output could still deliver to the hands, by the largest speeds `[J]`.
    left: f64,
    /// The same, by the largest accelerations `[J]`.
    left_by_acceleration: f64,
}

impl Account {
    /// Creates the state for a loop before its first sample, without energy.
    pub fn new(loop_params: &WorldLoop, tools: usize) -> Self {
        let params = loop_params.guard.params();
        let kept = params.map_or(0, |params| params.late + 1);
        let tracked = if kept > 0 { tools } else { 0 };
        let hand = params.and_then(|params| params.hand);
        let motion =
            |tool: usize| ToolMotion::new(hand, loop_params.guard_masses.get(tool).copied());
        Self {
            there: 0.0,
            ports: [0.0; MAX_LATE + 1],
            acted: vec![[Vector3::zeros(); 2]; kept * tools],
            tools,
            motions: (0..tracked).map(motion).collect(),
            uneven: vec![[Uneven::default(); 2]; tracked],
            hidden: 0.0,
            left: 0.0,
            left_by_acceleration: 0.0,
        }
    }

    /// Copies the state of `other`, which has the same guard and number of tools. It does not allocate.
    pub fn copy_from(&mut self, other: &Self) {
        self.there = other.there;
        self.ports = other.ports;
        self.hidden = other.hidden;
        self.left = other.left;
        self.left_by_acceleration = other.left_by_acceleration;
        self.motions.copy_from_slice(&other.motions);
        self.uneven.copy_from_slice(&other.uneven);
        for (own, other) in self.acted.iter_mut().zip(&other.acted) {
            *own = *other;
        }
    }

    /// Restarts with the current energy of bodies, contacts, joints and fields, for ledgers that started earlier. The action
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
        let fields: f64 = ledger.fields.iter().map(|entry| entry.stored).sum();
        self.there = bodies + contacts + joints + fields - had(ledger);
    }

    /// Adds energy that appeared in the contacts, at a first sample of a tool or a change of the world `[J]`.
    pub fn appeared(&mut self, energy: f64) {
        self.there += energy;
    }

    /// Notes the bounds on the forces in an interval of `elapsed` `[s]` that is about to pass.
    pub fn foresee(&mut self, (commands, torque_commands): (&Commands, &Commands), elapsed: f64) {
        for (tool, uneven) in self.uneven.iter_mut().enumerate() {
            *uneven = [commands, torque_commands].map(|commands| commands.uneven(tool, elapsed));
        }
    }

    /// Returns whether a device accelerated beyond the bound in the last interval.
    pub fn is_exceeded(&self) -> bool {
        self.motions.iter().any(ToolMotion::is_exceeded)
    }

    /// Ends an interval of `elapsed` `[s]` with the forces in `commands`. `moved`: translation and rotation of each
    /// device in it; `None` if unknown. In that case the largest possible work is assumed.
    pub fn pass(
        &mut self,
        params: &WorldGuardParams,
        (commands, torque_commands): (&Commands, &Commands),
        moved: Option<impl Fn(usize) -> Both>,
        elapsed: f64,
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
                None => most(params, acted) * elapsed,
            };
        }
        self.hidden = (self.hidden - params.recovery * elapsed).max(0.0);
        let motions = self.motions.iter_mut().zip(&self.uneven).enumerate();
        for (tool, (motion, uneven)) in motions {
            self.hidden += match &moved {
                Some(moved) => {
                    let acting = [commands.passed(tool), torque_commands.acting_or_none(tool)];
                    motion.pass(params, acting, uneven, &moved(tool), elapsed)
                }
                // A mean can be smaller than the force that changed around it.
                None => {
                    let [force, torque] = uneven;
                    let [sent, turning] = self.acted[tool];
                    let sizes = [
                        (force.size - sent.norm() * elapsed).max(0.0),
                        (torque.size - turning.norm() * elapsed).max(0.0),
                    ];
                    let beyond =
                        params.largest_speed * sizes[0] + params.largest_turning * sizes[1];
                    motion.lose(params) + beyond
                }
            };
        }
    }

    /// Computes the energy that may still be given to the hands over one interval of `period` `[s]`.
    pub fn count(
        &mut self,
        params: &WorldGuardParams,
        ledger: &EnergyLedger,
        (commands, torque_commands): (&Commands, &Commands),
        period: f64,
    ) {
        let mut by_speed = 0.0;
        let mut by_acceleration = 0.0;
        for (tool, motion) in self.motions.iter_mut().enumerate() {
            let on_way = [commands, torque_commands].map(|commands| commands.ahead(tool, period));
            let [force, torque] = on_way.map(|on_way| (on_way.push + on_way.pull).sum());
            by_speed += force * params.largest_speed + torque * params.largest_turning;
            by_acceleration += motion.claim(params, on_way);
        }
        let mut at_ends: f64 = self
            .motions
            .iter()
            .map(|one| one.hidden_at_end(params))
            .sum();
        if params.late > 0 {
            // Forces that act later end later.
            at_ends = self.acted.iter().map(|acted| params.in_quanta(acted)).sum();
        }
        let there = self.there + had(ledger) + params.allowance - self.hidden - at_ends;
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
        self.left = (least - by_speed).max(0.0);
        self.left_by_acceleration = least - by_acceleration;
    }

    /// Returns the part of the wrenches on the tools that the guard allows, if it is less than all of them. `wrenches`
    /// yields the delivered force `[N]` and torque `[N m]` of each tool, to be held for a `period` `[s]`.
    pub fn kept(
        &self,
        params: &WorldGuardParams,
        wrenches: impl Iterator<Item = Both>,
        period: f64,
    ) -> Option<f64> {
        let (mut asked, mut price) = (0.0, Price::default());
        for (motion, wrench) in self.motions.iter().zip(wrenches) {
            asked += most(params, &[wrench]) * period;
            let Price { linear, square } = motion.price(params, &wrench, period);
            price.linear += linear;
            price.square += square;
        }
        if asked <= self.left {
            return None;
        }
        // `asked` is above 0, or not a number.
        let by_speed = self.left / asked;
        let by_speed = if by_speed.is_nan() { 0.0 } else { by_speed };
        let by_acceleration = match params.hand {
            Some(_) => price.affordable(self.left_by_acceleration),
            None => 0.0,
        };
        let part = by_speed.max(by_acceleration);
        (part < 1.0).then_some(part)
    }
}

/// Returns the energy available since the start of the ledger, without the initial energy and the work at the ports
/// `[J]`. It is the work of the constant forces and of external changes, minus the energy dissipated by
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
    let fields = ledger.fields.iter().chain([&gone.fields]);
    let supplied: f64 = fields.map(|entry| entry.supplied).sum();
    bodies - contacts - joints + supplied
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
