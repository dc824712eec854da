//! What gives poses and takes wrenches: the [`Device`] trait, which a driver implements, and the
//! [clocks](clock) that a loop can run on.
//!
//! A driver needs this crate alone. [`NullDevice`], [`ScriptedDevice`] and [`ReplayDevice`] stand in
//! for a device in tests; `palpate-sim` has simulated ones.

// What the loop calls does not panic, and prints nothing: what may stands in set-up only.
#![warn(
    clippy::expect_used,
    clippy::indexing_slicing,
    clippy::panic,
    clippy::print_stderr,
    clippy::unreachable,
    clippy::unwrap_used
)]

mod capabilities;
pub mod clock;
mod cut;
mod null;
mod pose;
mod replay;
mod scripted;

use std::fmt;

pub use capabilities::Capabilities;
pub use cut::Cut;
pub use null::NullDevice;
pub use pose::{Pose, Vector, Wrench};
pub use replay::ReplayDevice;
pub use scripted::{Script, ScriptedDevice, Step};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;

/// A haptic device with one end-point: up to three axes with a force, up to three with a torque.
///
/// Each period the loop reads once and writes once, in this order. The device holds a written force
/// until the next write. Neither call may allocate, lock or panic, and both return well within a
/// period: a device that answers by request does its round trip in [`read`](Self::read), repeating
/// the force that it holds; one that sends on its own returns what came last.
///
/// A device of one's own, a knob that turns about z and has one motor:
///
/// ```
/// use palpate_device::clock::{Clock, SteppedClock};
/// use palpate_device::{Capabilities, Device, DeviceError, Pose, Wrench};
///
/// struct Knob<C> {
///     clock: C,
///     capabilities: Capabilities,
///     angle: f64,  // [rad], as an encoder would give it
///     torque: f64, // [N m], as an amplifier would hold it
/// }
///
/// impl<C: Clock> Device for Knob<C> {
///     fn capabilities(&self) -> &Capabilities {
///         &self.capabilities
///     }
///
///     fn read(&mut self) -> Result<Pose, DeviceError> {
///         let (sin, cos) = (self.angle / 2.0).sin_cos();
///         Ok(Pose {
///             orientation: Some([cos, 0.0, 0.0, sin]),
///             ..Pose::at([0.0; 3], self.clock.now())
///         })
///     }
///
///     fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
///         let [.., about_z] = wrench.torque;
///         self.torque = about_z.clamp(-0.1, 0.1);
///         // What it really gives: no force, and no torque about x and y.
///         Ok(Wrench {
///             torque: [0.0, 0.0, self.torque],
///             ..Wrench::NONE
///         })
///     }
/// }
///
/// let mut knob = Knob {
///     clock: SteppedClock::new(),
///     capabilities: Capabilities {
///         torque_axes: 1,
///         largest_torque: Some(0.1),
///         ..Capabilities::unknown("knob", 1)
///     },
///     angle: 0.3,
///     torque: 0.0,
/// };
/// assert_eq!(knob.read()?.position, [0.0; 3]);
/// let asked = Wrench { force: [2.0, 0.0, 0.0], torque: [0.0, 0.0, 0.5] };
/// assert_eq!(knob.write(asked)?.torque, [0.0, 0.0, 0.1]);
/// # Ok::<(), DeviceError>(())
/// ```
pub trait Device: Send {
    /// What the device can do; it stays the same while the device lives.
    fn capabilities(&self) -> &Capabilities;

    /// Where the end-point is, and how it is turned where the device measures that.
    ///
    /// # Errors
    /// [`DeviceErrorKind::NothingNew`]: there was no sample in this period; go on with the last force
    /// for a period, then with none. [`DeviceErrorKind::Disconnected`]: the device is gone, and only
    /// opening it again helps. [`DeviceErrorKind::Refused`]: the device is there and does not do what
    /// it was asked; whoever runs it has to look at it.
    fn read(&mut self) -> Result<Pose, DeviceError>;

    /// Commands `wrench` on the end-point, and says which one is held from now on as far as is known: a
    /// driver that clamps, rounds or delays returns what it really gives, and 0 on axes that have no
    /// motor. [`Wrench::NONE`] is always taken, and on any doubt.
    ///
    /// # Errors
    /// As [`read`](Self::read). The force that is held is then not known.
    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError>;

    /// What is sent to the motors of the wrench that was written last, where that is not what
    /// [`write`](Self::write) has returned: a device that knows of its delay returns what is held now,
    /// and says here what will be held later. `None`, the default: what `write` has returned.
    fn last_sent(&self) -> Option<Wrench> {
        None
    }

    /// A second way to command no force, for a supervisor on another thread while this one is not
    /// answering. `None`: there is none, and a stalled loop leaves the last force on.
    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        None
    }

    /// Whether somebody beside this program, the guardian of `palpate-rt`, has commanded no force since
    /// this was asked last. A loop asks after it has stood still and has read.
    fn was_cut(&mut self) -> bool {
        false
    }
}

/// Commands no force, apart from the device that it belongs to.
pub trait ZeroWriter: Send {
    /// Commands no force at the first moment possible. Returns at once, whatever the device does.
    fn write_zero(&mut self);
}

/// What a caller can do about an error of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceErrorKind {
    /// No new sample yet: try again in the next period.
    NothingNew,
    /// The device is gone: command no force, open it anew.
    Disconnected,
    /// The device does not do what it is asked: command no force, look at it.
    Refused,
}

/// Why a device did not do what it was asked. It carries no text of its own making: errors arise in
/// the loop, where nothing may be allocated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub struct DeviceError {
    /// What can be done about it.
    pub kind: DeviceErrorKind,
    /// What happened, in a few words.
    pub what: &'static str,
}

impl DeviceError {
    /// An error of this kind.
    #[must_use]
    pub fn new(kind: DeviceErrorKind, what: &'static str) -> Self {
        Self { kind, what }
    }
}

impl fmt::Display for DeviceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.what)
    }
}

impl<D: Device + ?Sized> Device for Box<D> {
    fn capabilities(&self) -> &Capabilities {
        (**self).capabilities()
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        (**self).read()
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        (**self).write(wrench)
    }

    fn last_sent(&self) -> Option<Wrench> {
        (**self).last_sent()
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        (**self).zero_writer()
    }

    fn was_cut(&mut self) -> bool {
        (**self).was_cut()
    }
}
