#![doc = include_str!("../README.md")]
//!
//! # Overview
//!
//! Driver interface of haptic devices: the [`Device`] trait and the [clocks](clock) of a loop.
//!
//! A driver depends on this crate alone. [`NullDevice`], [`ScriptedDevice`] and [`ReplayDevice`] are test devices;
//! `palpate-study` contains simulated ones.

// Functions that a loop calls neither panic nor print; only set-up code may.
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
mod connection;
mod cut;
mod null;
mod pose;
mod replay;
mod scripted;

use std::fmt;

pub use capabilities::Capabilities;
pub use connection::Connection;
pub use cut::Cut;
pub use null::NullDevice;
pub use pose::{Line, Pose, Vector, Wrench};
pub use replay::ReplayDevice;
pub use scripted::{Script, ScriptedDevice, Step};

/// A haptic device with one end-point: up to three axes with a force, up to three with a torque.
///
/// Each period the loop reads once and writes once, in this order. The device holds a written force
/// until the next write. Neither call may allocate, lock or panic, and both return well within a period. A
/// request-response device exchanges its messages in [`read`](Self::read) and repeats the held force; a streaming
/// device returns the latest sample.
///
/// Example of a driver, for a knob that turns about z and has one motor:
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
///         // The delivered wrench: no force, and no torque about x and y.
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
    /// Returns the capabilities. They are constant during the device's lifetime.
    fn capabilities(&self) -> &Capabilities;

    /// Returns the position of the end-point and, if measured, its orientation.
    ///
    /// # Errors
    /// [`DeviceErrorKind::NothingNew`]: there was no sample in this period; the loop keeps the last force for one
    /// period, then commands zero. [`DeviceErrorKind::Interrupted`]: it commands zero at once, until a sample arrives.
    /// [`DeviceErrorKind::Disconnected`]: the device is disconnected and must be reopened.
    /// [`DeviceErrorKind::Refused`]: the device is connected but has a lasting fault; the operator must inspect it.
    fn read(&mut self) -> Result<Pose, DeviceError>;

    /// Commands `wrench` on the end-point and returns the wrench held from now on, as far as known. A driver that
    /// clamps, rounds or delays returns the actual wrench, with 0 on axes without a motor. Every driver accepts
    /// [`Wrench::NONE`] at any time.
    ///
    /// # Errors
    /// Those of [`read`](Self::read). The held force is then unknown.
    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError>;

    /// Commands `line` on the end-point, from now on, and returns what is held, as [`write`](Self::write) does. A
    /// driver that clamps returns a line whose two ends are within its limits. When the line is over and no other
    /// command has come, the device holds its last value. Called only with [`Capabilities::holds_lines`]; by default
    /// the mean is written as a constant, and returned.
    ///
    /// # Errors
    /// Those of [`read`](Self::read). The held force is then unknown.
    fn write_line(&mut self, line: Line) -> Result<Line, DeviceError> {
        self.write(line.wrench).map(Line::from)
    }

    /// Returns the part of the last command that is sent to the motors, if it differs from the result of
    /// [`write`](Self::write) or [`write_line`](Self::write_line). A device that models its delay returns the
    /// currently held line from these, and the line held later from this function. `None`, the default: the result of
    /// these.
    fn last_sent(&self) -> Option<Line> {
        None
    }

    /// Returns a second path to command zero force, for a supervisor on another thread while this thread is blocked.
    /// `None`: there is no such path, and a stalled loop leaves the last force on.
    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        None
    }

    /// Returns whether another process, the watchdog of `palpate-rt`, has commanded zero force since the last call. A
    /// loop calls it after a stall, once it has read the device.
    fn was_cut(&mut self) -> bool {
        false
    }

    /// Returns the statistics of the connection, for the report of a run. `None`, the default: the driver has none. Not
    /// called in a tick.
    fn connection(&self) -> Option<Connection> {
        None
    }
}

/// Path to command zero force independently of the device object.
pub trait ZeroWriter: Send {
    /// Commands zero force as soon as possible. Returns immediately, whatever the state of the device.
    fn write_zero(&mut self);
}

/// Kinds of device errors, by the caller's possible response. What ends with its cause is [`NothingNew`](Self::NothingNew)
/// or [`Interrupted`](Self::Interrupted), for every driver; the force then returns with a soft start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceErrorKind {
    /// No new sample yet: keep the last force for one period, then command zero, and try again.
    NothingNew,
    /// The device is faulty for now: it reports an error, returns a value that is not a number, or takes no command.
    /// Command zero force at once, and try again.
    Interrupted,
    /// The device is disconnected: command zero force and reopen it.
    Disconnected,
    /// A fault that lasts, or that no later sample disproves: power or calibration is lost, the watchdog process has
    /// ended, the clock is wrong. Command zero force until the operator has inspected the device.
    Refused,
}

/// Failure of a device. Its text is static, because errors occur in the loop, where allocation is forbidden.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub struct DeviceError {
    /// Possible response of the caller.
    pub kind: DeviceErrorKind,
    /// Short description of the failure.
    pub what: &'static str,
}

impl DeviceError {
    /// Creates an error of this kind.
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

    fn write_line(&mut self, line: Line) -> Result<Line, DeviceError> {
        (**self).write_line(line)
    }

    fn last_sent(&self) -> Option<Line> {
        (**self).last_sent()
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        (**self).zero_writer()
    }

    fn was_cut(&mut self) -> bool {
        (**self).was_cut()
    }

    fn connection(&self) -> Option<Connection> {
        (**self).connection()
    }
}
