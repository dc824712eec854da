//! Input and output of a tick.

use core::fmt;

use crate::Scalar;

/// One sample of the device.
///
/// ```
/// use palpate_core::Sample;
///
/// let sample = Sample::at(0.012).with_virtual_force(-0.981).after(0.0011);
/// assert_eq!(sample.elapsed, Some(0.0011));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<S> {
    /// Measured position xi of the device's end-point along the contact's axis `[m]`.
    pub device_position: S,
    /// Time since the previous sample `[s]`, if it was measured; `None`: one nominal period.
    pub elapsed: Option<S>,
    /// Virtual force f_V on the object over the coming interval `[N]`, for example its weight; positive along the axis.
    pub virtual_force: S,
}

impl<S: Scalar> Sample<S> {
    /// Creates a sample at `device_position` `[m]`, one nominal period after the previous one, without virtual force.
    #[inline]
    pub fn at(device_position: S) -> Self {
        Self {
            device_position,
            elapsed: None,
            virtual_force: S::ZERO,
        }
    }

    /// Returns the sample with a virtual force on the object `[N]`.
    #[inline]
    #[must_use]
    pub fn with_virtual_force(self, virtual_force: S) -> Self {
        Self {
            virtual_force,
            ..self
        }
    }

    /// Returns the sample, taken a measured time after the previous one `[s]`.
    #[inline]
    #[must_use]
    pub fn after(self, elapsed: S) -> Self {
        Self {
            elapsed: Some(elapsed),
            ..self
        }
    }
}

/// Reason for rejecting a sample. The force is then 0; the object completes its interval as planned and waits there.
/// The next valid sample resumes rendering, as if the device had come to rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Fault {
    /// The device position is NaN or infinite.
    PositionNotFinite,
    /// The virtual force is NaN or infinite.
    VirtualForceNotFinite,
    /// The elapsed time is NaN, infinite, zero or negative.
    ElapsedNotPositive,
    /// The elapsed time exceeds [`LoopParams::largest_gap`](crate::LoopParams::largest_gap).
    GapTooLong,
    /// The device moved faster than [`LoopParams::speed_limit`](crate::LoopParams::speed_limit).
    JumpTooFast,
    /// The device orientation is not a unit quaternion, or it is missing.
    OrientationNotUnit,
    /// The force or the object's motion would not be a finite number; in a world also a position beyond 1e154 m.
    Overflow,
}

impl Fault {
    /// Returns the short name in kebab case used in run files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::PositionNotFinite => "position-not-finite",
            Self::VirtualForceNotFinite => "virtual-force-not-finite",
            Self::ElapsedNotPositive => "elapsed-not-positive",
            Self::GapTooLong => "gap-too-long",
            Self::JumpTooFast => "jump-too-fast",
            Self::OrientationNotUnit => "orientation-not-unit",
            Self::Overflow => "overflow",
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::PositionNotFinite => "the device position is not a finite number",
            Self::VirtualForceNotFinite => "the virtual force is not a finite number",
            Self::ElapsedNotPositive => "the time since the previous sample is not positive",
            Self::GapTooLong => "the time since the previous sample exceeds the largest gap",
            Self::JumpTooFast => "the device jumped faster than its speed limit",
            Self::OrientationNotUnit => {
                "the device orientation is missing or is not a unit quaternion"
            }
            Self::Overflow => {
                "the force or a motion would not be a finite number: a contact may be too stiff or too damped for its \
                 masses at this period"
            }
        })
    }
}

/// Predicted contact of the coming interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// No contact.
    Free,
    /// In contact throughout.
    Contact,
    /// Contact begins within the interval.
    Enters,
    /// Contact ends within the interval.
    Leaves,
    /// A fault: the object waits.
    Waiting,
}

impl Phase {
    /// Returns the short name used in run files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Contact => "contact",
            Self::Enters => "enters",
            Self::Leaves => "leaves",
            Self::Waiting => "waiting",
        }
    }
}

/// Which limits changed the method's force.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Limited {
    /// It would have pulled, and [`Contact::unilateral`](crate::Contact::unilateral) is set.
    pub pull: bool,
    /// It exceeded the force limit.
    pub force: bool,
    /// It changed faster than the slew limit.
    pub slew: bool,
    /// It could give out more energy than the [`Guard`](crate::Guard)'s bound.
    pub guard: bool,
    /// The device accelerated beyond the guard's [`HandBound`](crate::HandBound) in the interval that this sample ends.
    /// For the next force the guard uses the bound by speed. It changes no force by itself.
    pub beyond_guard: bool,
}

impl Limited {
    /// Returns whether any limit acted.
    #[inline]
    #[must_use]
    pub fn any(self) -> bool {
        self.pull || self.force || self.slew || self.guard
    }
}

/// Result of one sample. Positions, velocities and forces are along the contact's axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output<S> {
    /// Force on the device `[N]`: command it to the motor, and hold it until the next sample.
    pub force_on_device: S,
    /// The same force on the object `[N]`, opposite in sign: f of the paper.
    pub force_on_object: S,
    /// Slope s of the force on the device `[N/s]`: the actuator holds `force_on_device + s (t - T/2)` for t from 0 to
    /// the nominal period T. 0 unless the loop has a line [`Hold`](crate::Hold).
    pub slope_on_device: S,
    /// Position of the object at this sample `[m]`. `coupled` includes the proxy offset, so that the device penetrates
    /// the object as deep as the proxy. A wall therefore moves too, until the offset has decayed.
    pub object_position: S,
    /// Velocity of the object at this sample `[m/s]`.
    pub object_velocity: S,
    /// Penetration p of the device into the object at this sample `[m]`; positive in contact, independent of the side
    /// of the object. 0 after a fault.
    pub penetration: S,
    /// Predicted contact in the coming interval.
    pub phase: Phase,
    /// Instant of the predicted transition, after this sample `[s]`; 0 if there is none.
    pub transition_after: S,
    /// Shift of the object over the last interval, which compensates the effect of a held force on the device `[m]`.
    /// Subtract it before drawing the object. Only [`Coupled`](crate::Coupled) uses it; the sum of a wall's shifts is
    /// its offset from its true position.
    pub proxy_shift: S,
    /// Limits that changed the force.
    pub limited: Limited,
    /// Reason for rejecting the sample, if it was rejected.
    pub fault: Option<Fault>,
}
