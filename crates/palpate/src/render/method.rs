//! What a rendering method is: from the situation at a sample to a plan for the interval.

use core::fmt::Debug;

use crate::Scalar;
use crate::actuator::{Ahead, Held};
use crate::contact::{Contact, LoopParams};
use crate::motion::{Displacement, ObjectMotion, Rule, Start};
use crate::parameter::{ParameterError, ParameterValue};
use crate::predict::Measurement;

/// Parameters of a method, still unchecked.
pub trait MethodParams<S: Scalar> {
    /// The method they describe.
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

    /// The method's name, as files, flags and reports spell it.
    fn name(&self) -> &'static str;

    /// Gives every parameter to `take`: its key as files and reports spell it, with the unit at its
    /// end, and its value. A method without parameters gives none.
    fn describe(&self, _take: &mut dyn FnMut(&'static str, ParameterValue<S>)) {}

    /// The same parameters with the value that `method`, made from them, has derived in place of each
    /// choice to derive one.
    #[must_use]
    fn derived(self, _method: &Self::Method) -> Self
    where
        Self: Sized,
    {
        self
    }
}

/// A rendering method: a force law and the object motion that goes with it, with checked
/// parameters. Total, like the tick it runs in.
pub trait Method<S: Scalar>: Copy + Debug {
    /// What it remembers between samples besides the ledger; the default begins anew.
    type Memory: Copy + Debug + Default;

    /// Plans the interval that begins with this situation.
    fn plan(
        &self,
        motion: &ObjectMotion<S>,
        situation: &Situation<'_, S>,
        memory: &mut Self::Memory,
    ) -> Plan<S>;

    /// How the interval that a sample ends has moved the object: as it was planned, unless the
    /// method takes the sample into account.
    #[inline]
    fn conclude(
        &self,
        motion: &ObjectMotion<S>,
        ended: &Ended<S>,
        _memory: &mut Self::Memory,
    ) -> Displacement<S> {
        ended.as_planned(motion)
    }

    /// Something from outside changed the contact, so that past forces and motions no longer say
    /// anything about it. `device_known`: the device has been followed all the time. `object_known`:
    /// the object is where the last interval has left it, and was not put elsewhere.
    #[inline]
    fn begin_anew(&self, memory: &mut Self::Memory, _device_known: bool, _object_known: bool) {
        *memory = Self::Memory::default();
    }

    /// How far the object was shifted in the last interval so that the held force does not
    /// change its motion against the device `[m]`.
    #[inline]
    fn placement_shift(&self, _memory: &Self::Memory) -> S {
        S::ZERO
    }

    /// By how much later than it was told the commands begin, by what the method has learned `[s]`.
    #[inline]
    fn lateness(&self, _memory: &Self::Memory) -> S {
        S::ZERO
    }

    /// Whether the method has planned the last force within the force limit, and without the limit it would be another.
    #[inline]
    fn is_limited(&self, _memory: &Self::Memory) -> bool {
        false
    }

    /// Whether the object moves as if the contact were a spring up to the force limit and that force beyond it.
    #[inline]
    fn yields_to_limit(&self) -> bool {
        false
    }

    /// Damping B with which the object moves in contact `[N s/m]`.
    fn contact_damping(&self) -> S {
        S::ZERO
    }
}

/// What is known at a sample, on the canonical side.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'a, S> {
    /// Penetration, velocities and virtual force.
    pub start: Start<S>,
    /// Penetration at the previous sample, as measured: it may be negative `[m]`. Equal to the
    /// present one where contact begins to be followed.
    pub previous_penetration: S,
    /// Time since the previous sample `[s]`.
    pub elapsed: S,
    /// Energy that has gone into the object through the port, E_i of the passivity observers
    /// `[J]`.
    pub port_work: S,
    /// Accumulated leak of the held force `[J]`: what is stored beyond what was put in.
    pub held_leak: S,
    /// The forces that were computed before and still act, or have yet to.
    pub ahead: Ahead<'a, S>,
}

/// An interval that a sample ends.
#[derive(Clone, Copy, Debug)]
pub struct Ended<S> {
    /// How it began.
    pub start: Start<S>,
    /// How the object was to move.
    pub rule: Rule<S>,
    /// Where that brings it over a nominal period.
    pub planned: Displacement<S>,
    /// Displacement of the device `[m]`.
    pub device_moved: S,
    /// Its duration `[s]`.
    pub elapsed: S,
    /// Whether that counts as the nominal period.
    pub nominal: bool,
    /// Mean of what the method had asked for, for this interval, as a force on the object `[N]`.
    pub intended_force: S,
    /// Force on the object that the device felt.
    pub held: Held<S>,
}

impl<S: Scalar> Ended<S> {
    /// What its end tells of the device.
    #[inline]
    pub(crate) fn measurement(&self) -> Measurement<S> {
        Measurement {
            moved: self.device_moved,
            elapsed: self.elapsed,
            held: self.held,
        }
    }

    /// The object's displacement by the rule of the interval's start.
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
    /// Whether the device presses the object; touching counts as free.
    #[inline]
    pub fn in_contact(&self) -> bool {
        self.start.penetration > S::ZERO
    }

    /// Force of the undamped contact spring, Eq. (6b) `[N]`: 0 when free.
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

/// What to do until the next sample.
#[derive(Clone, Copy, Debug)]
pub struct Plan<S> {
    /// Force on the object to hold `[N]`, before limits.
    pub force: S,
    /// How the object moves.
    pub rule: Rule<S>,
    /// Where that brings it over one nominal period.
    pub moved: Displacement<S>,
}
