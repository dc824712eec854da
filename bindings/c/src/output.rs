//! Output of a tick, and the energy ledger.

use palpate_core::{
    Fault as CoreFault, Ledger as CoreLedger, Limited, Output as CoreOutput, Phase as CorePhase,
};

use crate::number::Number;
use crate::sized::SizedStruct;

/// Predicted contact phase of the object in the coming interval.
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
    /// Waiting after a fault: the object is held still.
    Waiting = 4,
}

/// Reason for rejecting a sample. The force is then 0; rendering resumes at the next valid sample.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The sample was accepted.
    None = 0,
    /// The device position is not a finite number.
    PositionNotFinite = 1,
    /// The virtual force is not a finite number.
    VirtualForceNotFinite = 2,
    /// The time since the previous sample is not positive.
    ElapsedNotPositive = 3,
    /// The time since the previous sample exceeds the largest gap.
    GapTooLong = 4,
    /// The device position jumped faster than the speed limit.
    JumpTooFast = 5,
    /// The force or the object's motion would not be a finite number.
    Overflow = 6,
    /// The device orientation is not a unit quaternion.
    OrientationNotUnit = 7,
    /// A fault that a newer core defines.
    Other = 99,
    /// An argument is wrong, and no tick was executed: the contact, world, sample or an array is NULL, a
    /// struct_size is too small, the number of poses or wrenches differs from the number of devices, has_elapsed
    /// is neither 0 nor 1, or a reserved field is not 0. palpate_last_error has the details.
    Argument = 100,
    /// A defect in the library was caught. Please report it.
    Internal = 101,
}

impl Fault {
    /// Converts a fault of the core.
    #[inline]
    pub(crate) fn new(fault: Option<CoreFault>) -> Self {
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

/// Limits that changed the force, and PALPATE_LIMIT_BEYOND_GUARD, which changes none: bits of `limited`.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// A pulling force was removed, because the contact may only push.
    Pull = 1,
    /// The force exceeded the force limit.
    Force = 2,
    /// The force changed faster than the slew limit.
    Slew = 4,
    /// The force exceeded the guard's bound: it could generate more energy than the balance allows.
    Guard = 8,
    /// A torque exceeded the torque limit (worlds only).
    Torque = 16,
    /// The proxy offset of a tool was clamped to its limit (worlds only).
    Offset = 32,
    /// The soft start after a start or a fault reduced the force (worlds only).
    SoftStart = 64,
    /// Safety stop: held forces have generated energy, and all wrenches stay 0 (worlds only). To resume, free the
    /// world and create it again.
    Stopped = 128,
    /// The device accelerated beyond guard_acceleration in the interval that this sample ends. For the next force the
    /// guard uses its bound by speed.
    BeyondGuard = 256,
}

/// Result of a tick, along the contact's axis. palpate_output_empty() returns an empty one to be filled,
/// palpate_output_f32_empty() one in float.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Output<S> {
    /// Size of this struct.
    pub struct_size: usize,
    /// Force on the device: command it to the motor and hold it until the next sample [N].
    pub force_on_device: S,
    /// Opposite force, on the object [N].
    pub force_on_object: S,
    /// Slope of the force on the device [N/s]: with PALPATE_HOLD_LINE command `force_on_device + slope_on_device (t -
    /// T/2)` for t from 0 to the period T, and hold the last value if no command follows. Otherwise 0.
    pub slope_on_device: S,
    /// Position of the object's surface at this sample [m].
    pub object_position: S,
    /// Velocity of the object at this sample [m/s].
    pub object_velocity: S,
    /// Penetration of the device into the object at this sample, positive in contact for either side [m].
    pub penetration: S,
    /// Time from this sample to the predicted transition [s]; 0 if there is none.
    pub transition_after: S,
    /// Shift of the object by coupled rendering over the last interval [m]; subtract it before drawing
    /// the object.
    pub proxy_shift: S,
    /// Predicted contact phase in the coming interval.
    pub phase: Phase,
    /// Reason for rejecting the sample.
    pub fault: Fault,
    /// Active limits: bits of palpate_limit.
    pub limited: u32,
    /// Unused; 0.
    pub reserved: u32,
}

// SAFETY: `repr(C)`, a `usize` first, numbers only. It is written, never read from C.
unsafe impl<S: Number> SizedStruct for Output<S> {
    const NAME: &'static str = S::OUTPUT;
}

impl<S: Number> Output<S> {
    /// Returns an output with zero force and the given fault.
    pub fn refused(fault: Fault) -> Self {
        Self {
            struct_size: size_of::<Self>(),
            force_on_device: S::ZERO,
            force_on_object: S::ZERO,
            slope_on_device: S::ZERO,
            object_position: S::ZERO,
            object_velocity: S::ZERO,
            penetration: S::ZERO,
            transition_after: S::ZERO,
            proxy_shift: S::ZERO,
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
        | bit(limited.beyond_guard, Limit::BeyondGuard)
}

impl<S: Number> From<CoreOutput<S>> for Output<S> {
    #[inline]
    fn from(output: CoreOutput<S>) -> Self {
        Self {
            struct_size: size_of::<Self>(),
            force_on_device: output.force_on_device,
            force_on_object: output.force_on_object,
            slope_on_device: output.slope_on_device,
            object_position: output.object_position,
            object_velocity: output.object_velocity,
            penetration: output.penetration,
            transition_after: output.transition_after,
            proxy_shift: output.proxy_shift,
            phase: match output.phase {
                CorePhase::Free => Phase::Free,
                CorePhase::Contact => Phase::Contact,
                CorePhase::Enters => Phase::Enters,
                CorePhase::Leaves => Phase::Leaves,
                CorePhase::Waiting => Phase::Waiting,
            },
            fault: Fault::new(output.fault),
            limited: bits(output.limited),
            reserved: 0,
        }
    }
}

/// Energy ledger of the object, positive into the object. At every sample it balances: stored energy less
/// initial stored energy = port_work + virtual_force_work + outside_work + held_leak.
/// palpate_ledger_empty() returns an empty one to be filled, palpate_ledger_f32_empty() one in float.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Ledger<S> {
    /// Size of this struct.
    pub struct_size: usize,
    /// Kinetic energy of the object and elastic energy of the contact at the last sample [J].
    pub stored: S,
    /// Work of the held force on the object [J].
    pub port_work: S,
    /// Work of the virtual force on the object [J].
    pub virtual_force_work: S,
    /// Energy added by teleporting the object, by parameter changes and during faults [J].
    pub outside_work: S,
    /// Remaining leak: energy generated by the held force, less energy dissipated by it [J].
    pub held_leak: S,
    /// Remaining leak over the last closed interval [J].
    pub held_leak_last: S,
    /// Sum of the absolute remaining leaks of all closed intervals [J].
    pub held_leak_absolute: S,
    /// Original leak: energy that the sampled spring would have generated over the same motion [J].
    pub original_leak: S,
    /// Original leak over the last closed interval [J].
    pub original_leak_last: S,
    /// Sum of the absolute original leaks of all closed intervals [J].
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
