//! The guard: a bound on the energy that held forces can give to the hands before anybody can know.
//!
//! A force is fixed before the hand moves. Over one interval it can give out as much as `|f| v T` at a speed v, whatever
//! it was computed from, and a torque `|t| w T` at a turning w. So whoever wants a guarantee and not an estimate limits
//! forces and torques themselves, of all devices together:
//!
//! ```text
//! sum of (|f| v_max + |t| w_max) T <= balance + allowance - what is on its way
//! balance = what was there at the start or appeared + work of the bodies' constant forces
//!           - what damping and friction took - work at the ports
//! ```
//!
//! While devices keep below v_max and w_max and samples come within the nominal period, what the hands have been given
//! never exceeds what there was for them and the allowance. Damping and friction count as they are known at the sample.
//!
//! A force may act later than the loop says. With `late` samples the work at the ports is reckoned for each
//! whole number of samples up to that by which all forces may be late, and the largest counts.

use palpate::Range;

use crate::books::Books;
use crate::commands::Commands;
use crate::fault::out_of_range;
use crate::rigid::Vector3;
use crate::{Vector, WorldError, WorldField, WorldPart};

/// Whether the energy given out is bounded, and how.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum WorldGuard {
    /// No bound.
    #[default]
    Off,
    /// Forces beyond the bound are held, and reported in [`Limited::guard`](crate::Limited::guard).
    Report(WorldGuardParams),
    /// The forces and torques on all devices are made smaller by one factor where they exceed the bound, down to none.
    Limit(WorldGuardParams),
}

/// What the guard reckons with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorldGuardParams {
    /// Fastest motion of each device against which the bound holds, v_max `[m/s]`, above 0.
    pub largest_speed: f64,
    /// Fastest turning of each device that turns, w_max `[rad/s]`, above 0.
    pub largest_turning: f64,
    /// Energy that may be given out beyond the balance `[J]`, at least 0. Without any, a contact that has stored nothing
    /// yet could not begin to push.
    pub allowance: f64,
    /// By how many samples forces may act later than the loop's actuation says, at most [`MOST_LATE`].
    pub late: usize,
}

/// Most samples of an untold delay that a guard reckons with.
pub const MOST_LATE: usize = 8;

impl WorldGuard {
    pub(crate) fn params(&self) -> Option<&WorldGuardParams> {
        match self {
            Self::Off => None,
            Self::Report(params) | Self::Limit(params) => Some(params),
        }
    }

    /// Whether it makes forces smaller.
    pub(crate) fn limits(&self) -> bool {
        matches!(self, Self::Limit(_))
    }

    /// Each of its parameters outside its range.
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
        if params.late > MOST_LATE {
            let late = params.late;
            let message = format!("guard.late is {late}, and has to be at most {MOST_LATE}");
            fault(WorldField::GuardLate, message);
        }
        faults
    }
}

/// A force `[N]` and a torque `[N m]`, or a way `[m]` and a turn `[rad]`.
pub(crate) type Both = [Vector3; 2];

/// The guard's account, besides what the books have.
#[derive(Clone, Debug)]
pub(crate) struct Account {
    /// What was there at the start, and what has appeared with a first sample since `[J]`.
    there: f64,
    /// Work at the ports if forces were so many samples later than the loop says `[J]`.
    ports: [f64; MOST_LATE + 1],
    /// What acted on each tool in the intervals that have ended, by what the loop says, the newest first.
    acted: Vec<Both>,
    tools: usize,
    /// Energy that the forces of the last output could give the hands `[J]`.
    pub left: f64,
}

impl Account {
    /// Of a world at its start, with that energy `[J]`.
    pub fn new(guard: &WorldGuard, tools: usize, there: f64) -> Self {
        let kept = guard.params().map_or(0, |params| params.late + 1);
        Self {
            there,
            ports: [0.0; MOST_LATE + 1],
            acted: vec![[Vector3::zeros(); 2]; kept * tools],
            tools,
            left: 0.0,
        }
    }

    /// Comes to be as `other`, of the same guard and as many tools. It does not allocate.
    pub fn copy_from(&mut self, other: &Self) {
        self.there = other.there;
        self.ports = other.ports;
        self.left = other.left;
        for (own, other) in self.acted.iter_mut().zip(&other.acted) {
            *own = *other;
        }
    }

    /// Begins with the energy that bodies, contacts and joints have now, by books that began before. What acted in the last
    /// interval counts for those before it, too. It does not allocate.
    pub fn begin_at(&mut self, books: &Books, (commands, torque_commands): (&Commands, &Commands)) {
        for (place, acted) in self.acted.iter_mut().enumerate() {
            let tool = place % self.tools;
            *acted = [
                commands.passed(tool).sent,
                torque_commands.passed_or_none(tool),
            ];
        }
        let bodies: f64 = books.bodies.iter().map(|book| book.kinetic).sum();
        let contacts: f64 = books.contacts.iter().map(|book| book.stored).sum();
        let joints: f64 = books.joints.iter().map(|book| book.stored).sum();
        self.there = bodies + contacts + joints - had(books);
    }

    /// Energy appeared in the contacts, as a tool was found in them or the world was changed `[J]`.
    pub fn appeared(&mut self, energy: f64) {
        self.there += energy;
    }

    /// An interval has ended, whose forces `commands` have let pass. `moved`: by how much each device went and turned in
    /// it; `None`: nobody knows, so as far as it can in a `period` `[s]`, to its gain.
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

    /// Energy that the hands may still be given over one interval `[J]`, for which `expected` of what is on its way has a
    /// claim `[J]`.
    pub fn free(
        &self,
        params: &WorldGuardParams,
        books: &Books,
        expected: f64,
        period: f64,
    ) -> f64 {
        let there = self.there + had(books) + params.allowance - expected;
        let mut claimed = 0.0;
        let mut least = f64::INFINITY;
        let late = self.acted.chunks_exact(self.tools.max(1));
        for (port, acted) in self.ports.iter().zip(late) {
            let left = there - port - claimed;
            // What is no number lets nothing pass.
            least = if left.is_nan() { 0.0 } else { left.min(least) };
            // If forces are one sample later yet, this one is still to act.
            claimed += most(params, acted) * period;
        }
        least.max(0.0)
    }
}

/// What there was since the books began, besides what was there and what went through the ports `[J]`: work of the bodies'
/// constant forces and from outside, less what damping and friction took. Work of the mechanism of a device that lacks an axis does
/// not count, nor does that of a hand that turns a tool without a torque: whoever does it feels no motor, so that energy is not
/// there for a hand.
fn had(books: &Books) -> f64 {
    let gone = &books.gone;
    let bodies = books.bodies.iter().chain([&gone.bodies]);
    let bodies: f64 = bodies.map(|book| book.outside - book.potential).sum();
    let contacts = books.contacts.iter().chain([&gone.contacts]);
    let contacts: f64 = contacts.map(|book| book.dissipated).sum();
    let joints = books.joints.iter().chain([&gone.joints]);
    let joints: f64 = joints.map(|book| book.dissipated).sum();
    bodies - contacts - joints
}

/// Work of what acted on the tools over what they moved by `[J]`.
fn work(acted: &[Both], moved: impl Fn(usize) -> Both) -> f64 {
    let each = acted.iter().enumerate().map(|(tool, [force, torque])| {
        let [way, turn] = moved(tool);
        force.dot(&way) + torque.dot(&turn)
    });
    each.sum()
}

/// Largest power of what acts on the tools `[W]`.
fn most(params: &WorldGuardParams, acting: &[Both]) -> f64 {
    let each = acting.iter().map(|[force, torque]| {
        force.norm() * params.largest_speed + torque.norm() * params.largest_turning
    });
    each.sum()
}

/// Power that what is to be sent can have `[W]`, by its size alone.
pub(crate) fn most_of(params: &WorldGuardParams, forces: &[Vector], torques: &[Vector]) -> f64 {
    let size = |vectors: &[Vector]| -> f64 {
        let sizes = vectors.iter().map(|vector| Vector3::from(*vector).norm());
        sizes.sum()
    };
    size(forces) * params.largest_speed + size(torques) * params.largest_turning
}
