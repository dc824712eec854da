//! Interface of a rendering method: from the situation at a sample to a plan for the interval.

use core::fmt::Debug;

use crate::Scalar;
use crate::actuator::{Ahead, Held};
use crate::contact::{Contact, LoopParams};
use crate::motion::{Displacement, ObjectMotion, Rule, Start};
use crate::parameter::{ParameterError, ParameterValue};
use crate::render::predict::Measurement;

/// Unchecked parameters of a method.
pub trait MethodParams<S: Scalar> {
    /// The method of these parameters.
    type Method: Method<S>;

    /// Checks the parameters against each other, the contact and the loop.
    ///
    /// # Errors
    /// The first parameter outside its range.
    fn check(
        self,
        contact: &Contact<S>,
        loop_params: &LoopParams<S>,
    ) -> Result<Self::Method, ParameterError>;

    /// Returns the method's name in files, flags and reports.
    fn name(&self) -> &'static str;

    /// Passes every parameter to `take`: its key in files and reports, with the unit as suffix, and its value. A method
    /// without parameters passes none.
    fn describe(&self, _take: &mut dyn FnMut(&'static str, ParameterValue<S>)) {}

    /// Returns the parameters with every value to be derived replaced by the value that `method`, made from them, has
    /// derived.
    #[must_use]
    fn derived(self, _method: &Self::Method) -> Self
    where
        Self: Sized,
    {
        self
    }
}

/// A rendering method: a force law and the object motion that belongs to it, with checked parameters. Its functions are
/// total, like the tick.
pub trait Method<S: Scalar>: Copy + Debug {
    /// Memory between samples besides the ledger; the default restarts the method.
    type Memory: Copy + Debug + Default;

    /// Plans the interval that begins with this situation.
    fn plan(
        &self,
        motion: &ObjectMotion<S>,
        situation: &Situation<'_, S>,
        memory: &mut Self::Memory,
    ) -> Plan<S>;

    /// Returns the displacement of the object in the interval that a sample ends: as planned, unless the method takes
    /// the sample into account.
    #[inline]
    fn conclude(
        &self,
        motion: &ObjectMotion<S>,
        ended: &Ended<S>,
        _memory: &mut Self::Memory,
    ) -> Displacement<S> {
        ended.as_planned(motion)
    }

    /// Restarts the memory after a change of the contact from outside, which invalidates past forces and motions.
    /// `device_known`: the device was tracked without interruption. `object_known`: the object is at its position at
    /// the end of the last interval, and was not moved elsewhere.
    #[inline]
    fn begin_anew(&self, memory: &mut Self::Memory, _device_known: bool, _object_known: bool) {
        *memory = Self::Memory::default();
    }

    /// Returns the shift of the object in the last interval, by which the held force does not change its motion
    /// relative to the device `[m]`.
    #[inline]
    fn proxy_shift(&self, _memory: &Self::Memory) -> S {
        S::ZERO
    }

    /// Returns the estimated actuation delay minus its model value `[s]`.
    #[inline]
    fn lateness(&self, _memory: &Self::Memory) -> S {
        S::ZERO
    }

    /// Returns whether the force limit affected the last planned force.
    #[inline]
    fn is_limited(&self, _memory: &Self::Memory) -> bool {
        false
    }

    /// Returns whether the method plans lines for a line [`Hold`](crate::Hold).
    #[inline]
    fn plans_lines(&self) -> bool {
        false
    }

    /// Returns the slope of the last planned force `[N/s]`.
    #[inline]
    fn slope(&self, _memory: &Self::Memory) -> S {
        S::ZERO
    }

    /// Returns the estimated mean acceleration of the device over the last concluded interval `[m/s^2]`: the ledger's
    /// work of a line.
    #[inline]
    fn device_acceleration(&self, _memory: &Self::Memory) -> S {
        S::ZERO
    }

    /// Returns whether the object moves as if the contact were a spring up to the force limit and that force beyond it.
    #[inline]
    fn yields_to_limit(&self) -> bool {
        false
    }

    /// Returns the damping B of the object's motion in contact `[N s/m]`.
    fn contact_damping(&self) -> S {
        S::ZERO
    }
}

/// Information at a sample, in canonical coordinates.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'a, S> {
    /// Penetration, velocities and virtual force.
    pub start: Start<S>,
    /// Penetration at the previous sample, as measured: it may be negative `[m]`. Equal to the present one if tracking
    /// of the contact begins here.
    pub previous_penetration: S,
    /// Time since the previous sample `[s]`.
    pub elapsed: S,
    /// Energy that has entered the object through the port, E_i of the passivity observers `[J]`.
    pub port_work: S,
    /// Accumulated leak of the held force `[J]`: stored energy minus supplied energy.
    pub held_leak: S,
    /// Earlier forces that still act or have yet to act.
    pub ahead: Ahead<'a, S>,
}

/// An interval that a sample ends.
#[derive(Clone, Copy, Debug)]
pub struct Ended<S> {
    /// State at its beginning.
    pub start: Start<S>,
    /// Planned motion of the object.
    pub rule: Rule<S>,
    /// Displacement by the rule over a nominal period.
    pub planned: Displacement<S>,
    /// Displacement of the device `[m]`.
    pub device_moved: S,
    /// Duration `[s]`.
    pub elapsed: S,
    /// Whether the duration counts as the nominal period.
    pub nominal: bool,
    /// Mean of the force planned by the method for this interval, as a force on the object `[N]`.
    pub intended_force: S,
    /// Force on the object that the device felt.
    pub held: Held<S>,
}

impl<S: Scalar> Ended<S> {
    /// Returns the measurement of the device at the end.
    #[inline]
    pub(crate) fn measurement(&self) -> Measurement<S> {
        Measurement {
            moved: self.device_moved,
            elapsed: self.elapsed,
            held: self.held,
        }
    }

    /// Returns the object's displacement by the rule of the interval's start.
    #[inline]
    pub fn as_planned(&self, motion: &ObjectMotion<S>) -> Displacement<S> {
        if self.nominal {
            self.planned
        } else {
            motion.advance(self.rule, &self.start, self.elapsed)
        }
    }
}

impl<S: Scalar> Situation<'_, S> {
    /// Returns whether the device presses the object; touching counts as free.
    #[inline]
    pub fn in_contact(&self) -> bool {
        self.start.penetration > S::ZERO
    }

    /// Returns the force of the undamped contact spring, Eq. (6b) `[N]`: 0 when free.
    #[inline]
    pub fn spring_force(&self, motion: &ObjectMotion<S>) -> S {
        motion.stiffness() * self.start.penetration.max(S::ZERO)
    }

    /// The paper's two-mode object with the mode chosen at the sample: free or in contact
    /// throughout, with the force `in_contact` `[N]` if in contact.
    #[inline]
    pub fn unswitched(&self, motion: &ObjectMotion<S>, in_contact: impl FnOnce() -> S) -> Plan<S> {
        if self.in_contact() {
            Plan {
                force: in_contact(),
                rule: Rule::Contact,
                moved: motion.press(&self.start),
            }
        } else {
            Plan {
                force: S::ZERO,
                rule: Rule::Free,
                moved: motion.fly(&self.start, motion.period()),
            }
        }
    }
}

/// Plan until the next sample.
#[derive(Clone, Copy, Debug)]
pub struct Plan<S> {
    /// Force on the object to hold `[N]`, before limits.
    pub force: S,
    /// Motion of the object.
    pub rule: Rule<S>,
    /// Displacement of the object over one nominal period.
    pub moved: Displacement<S>,
}
