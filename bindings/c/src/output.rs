//! What comes out of a tick, and the books.

use palpate::{
    Fault as CoreFault, Ledger as CoreLedger, Limited, Output as CoreOutput, Phase as CorePhase,
};

use crate::number::Number;
use crate::sized::SizedStruct;

/// What the object is predicted to do in the coming interval.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// No contact.
    Free = 0,
    /// In contact throughout.
    Contact = 1,
    /// Contact begins within the interval.
    Enters = 2,
    /// Contact ends within the interval.
    Leaves = 3,
    /// A fault: the object waits.
    Waiting = 4,
}

/// Why a sample was refused: the force is then 0, and the next sample that can be trusted takes up
/// rendering.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// It was not refused.
    None = 0,
    /// The device position is not a finite number.
    PositionNotFinite = 1,
    /// The virtual force is not a finite number.
    VirtualForceNotFinite = 2,
    /// The time since the sample before is not positive.
    ElapsedNotPositive = 3,
    /// The time since the sample before exceeds the largest gap.
    GapTooLong = 4,
    /// The device position jumped faster than the speed limit.
    JumpTooFast = 5,
    /// The force or the object's motion would not be a finite number.
    Overflow = 6,
    /// The device orientation is not a unit quaternion.
    OrientationNotUnit = 7,
    /// Of a newer core.
    Other = 99,
    /// There was no tick, since an argument is wrong: the contact, the world, the sample or an array is NULL, a struct_size is
    /// too small, a number of poses or wrenches is not that of the devices, has_elapsed is neither 0 nor 1, or a reserved number is
    /// not 0: palpate_last_error.
    Argument = 100,
    /// A defect in the library, which has been caught. Report it, please.
    Internal = 101,
}

impl Fault {
    /// As C has a fault of the core.
    #[inline]
    pub(crate) fn of(fault: Option<CoreFault>) -> Self {
        match fault {
            None => Self::None,
            Some(CoreFault::PositionNotFinite) => Self::PositionNotFinite,
            Some(CoreFault::VirtualForceNotFinite) => Self::VirtualForceNotFinite,
            Some(CoreFault::ElapsedNotPositive) => Self::ElapsedNotPositive,
            Some(CoreFault::GapTooLong) => Self::GapTooLong,
            Some(CoreFault::JumpTooFast) => Self::JumpTooFast,
            Some(CoreFault::Overflow) => Self::Overflow,
            Some(CoreFault::OrientationNotUnit) => Self::OrientationNotUnit,
            Some(_) => Self::Other,
        }
    }
}

/// Limits that changed the force: bits of `limited`.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// It would have pulled, and the contact may only push.
    Pull = 1,
    /// It exceeded the force limit.
    Force = 2,
    /// It changed faster than the slew limit.
    Slew = 4,
    /// It could give out more energy than there is: the guard's bound.
    Guard = 8,
    /// A torque exceeded the torque limit; of worlds.
    Torque = 16,
    /// The offset of a tool's avatar was held at its limit; of worlds.
    Offset = 32,
    /// It was still coming back after a start or a fault; of worlds.
    SoftStart = 64,
    /// No limit but a safety stop: held forces have created energy, and all wrenches stay 0. Free the
    /// world and make it again to go on; of worlds.
    Stopped = 128,
}

/// The answer to a sample, along the contact's axis. palpate_output_empty() makes one to be filled,
/// palpate_output_f32_empty() one in float.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Output<S> {
    /// Size of this struct.
    pub struct_size: usize,
    /// Force on the device: what the motor is to be commanded, and to hold until the next sample [N].
    pub force_on_device: S,
    /// The same force on the object, opposite in sign [N].
    pub force_on_object: S,
    /// Position of the object's surface at this sample [m].
    pub object_position: S,
    /// Velocity of the object at this sample [m/s].
    pub object_velocity: S,
    /// Penetration of the device into the object at this sample, positive in contact on either side [m].
    pub penetration: S,
    /// Instant of the predicted transition, after this sample [s]; 0 where there is none.
    pub transition_after: S,
    /// How far coupled rendering has shifted the object over the last interval [m]; a display takes it
    /// off again.
    pub placement_shift: S,
    /// What the coming interval is predicted to hold.
    pub phase: Phase,
    /// Why the sample was refused.
    pub fault: Fault,
    /// Limits that changed the force: bits of palpate_limit.
    pub limited: u32,
    /// 0.
    pub reserved: u32,
}

// SAFETY: `repr(C)`, a `usize` first, numbers only. It is written, never read from C.
unsafe impl<S: Number> SizedStruct for Output<S> {
    const NAME: &'static str = S::OUTPUT;
}

impl<S: Number> Output<S> {
    /// No force, and why.
    pub fn refused(fault: Fault) -> Self {
        Self {
            struct_size: size_of::<Self>(),
            force_on_device: S::ZERO,
            force_on_object: S::ZERO,
            object_position: S::ZERO,
            object_velocity: S::ZERO,
            penetration: S::ZERO,
            transition_after: S::ZERO,
            placement_shift: S::ZERO,
            phase: Phase::Waiting,
            fault,
            limited: 0,
            reserved: 0,
        }
    }
}

fn bits(limited: Limited) -> u32 {
    let bit = |set: bool, limit: Limit| if set { limit as u32 } else { 0 };
    bit(limited.pull, Limit::Pull)
        | bit(limited.force, Limit::Force)
        | bit(limited.slew, Limit::Slew)
        | bit(limited.guard, Limit::Guard)
}

impl<S: Number> From<CoreOutput<S>> for Output<S> {
    #[inline]
    fn from(output: CoreOutput<S>) -> Self {
        Self {
            struct_size: size_of::<Self>(),
            force_on_device: output.force_on_device,
            force_on_object: output.force_on_object,
            object_position: output.object_position,
            object_velocity: output.object_velocity,
            penetration: output.penetration,
            transition_after: output.transition_after,
            placement_shift: output.placement_shift,
            phase: match output.phase {
                CorePhase::Free => Phase::Free,
                CorePhase::Contact => Phase::Contact,
                CorePhase::Enters => Phase::Enters,
                CorePhase::Leaves => Phase::Leaves,
                CorePhase::Waiting => Phase::Waiting,
            },
            fault: Fault::of(output.fault),
            limited: bits(output.limited),
            reserved: 0,
        }
    }
}

/// Books of the object's energy, positive into the object; they balance at every sample: stored less
/// stored at the start = port_work + virtual_force_work + outside_work + held_leak.
/// palpate_ledger_empty() makes one to be filled, palpate_ledger_f32_empty() one in float.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Ledger<S> {
    /// Size of this struct.
    pub struct_size: usize,
    /// Kinetic energy of the object and elastic energy of the contact at the last sample [J].
    pub stored: S,
    /// Work of the held force on the object's side of the port [J].
    pub port_work: S,
    /// Work of the virtual force on the object [J].
    pub virtual_force_work: S,
    /// Placing the object anew, other parameters, and what passed while no sample could be trusted [J].
    pub outside_work: S,
    /// Energy that the force which was held has created, less what it has destroyed [J].
    pub held_leak: S,
    /// The same over the last closed interval [J].
    pub held_leak_last: S,
    /// Sum of the absolute leaks of all closed intervals [J].
    pub held_leak_absolute: S,
    /// Energy that the plain spring force would have created over the same motion [J].
    pub original_leak: S,
    /// The same over the last closed interval [J].
    pub original_leak_last: S,
    /// Sum of its absolute leaks over all closed intervals [J].
    pub original_leak_absolute: S,
}

// SAFETY: `repr(C)`, a `usize` first, numbers only.
unsafe impl<S: Number> SizedStruct for Ledger<S> {
    const NAME: &'static str = S::LEDGER;
}

impl<S: Number> From<&CoreLedger<S>> for Ledger<S> {
    fn from(ledger: &CoreLedger<S>) -> Self {
        Self {
            struct_size: size_of::<Self>(),
            stored: ledger.stored,
            port_work: ledger.port_work,
            virtual_force_work: ledger.virtual_force_work,
            outside_work: ledger.outside_work,
            held_leak: ledger.held_leak.accumulated,
            held_leak_last: ledger.held_leak.last,
            held_leak_absolute: ledger.held_leak.absolute,
            original_leak: ledger.original_leak.accumulated,
            original_leak_last: ledger.original_leak.last,
            original_leak_absolute: ledger.original_leak.absolute,
        }
    }
}
