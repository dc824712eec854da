//! The device in a loop.

use std::time::Duration;

use palpate_device::clock::Clock;
use palpate_device::{
    Capabilities, Connection, Device, DeviceError, DeviceErrorKind, Pose, Vector, Wrench,
};

use super::kinds::Kind;
use super::open::{Part, PoseMass, forces_of};
use super::rotation::quaternion;
use super::velocity::VelocityCheck;
use crate::plugin::library::dhd::{DhdDevice, Forces};
use crate::prepared::on_axes;

/// Result of a read without a new sample.
const NO_NEW_SAMPLE: i32 = 1;
/// Result of a command that saturates a motor.
const SATURATED: i32 = 2;

/// A device of Force Dimension, or a Falcon.
///
/// The manufacturer's library is called in the tick, so the loop has the guarantees of that code. When this is dropped,
/// the last command is zero force. If the loop stalls, or this program is killed or stopped, the firmware takes the force
/// off after [`watchdog`](Self::watchdog).
pub struct ForceDimension<C: Clock> {
    pub(super) clock: C,
    pub(super) capabilities: Capabilities,
    pub(super) device: DhdDevice,
    pub(super) kind: Kind,
    pub(super) part: Part,
    pub(super) watchdog: Option<Duration>,
    pub(super) mass: Option<PoseMass>,
    /// Time of the last command; the first one is that of the opening.
    pub(super) commanded_at: Duration,
    /// Whether that command was a force.
    pub(super) has_force: bool,
    pub(super) was_cut: bool,
    pub(super) connection: Connection,
    pub(super) velocity: VelocityCheck,
    /// First failure; its text is that of the end.
    pub(super) reason: Option<DeviceError>,
    pub(super) tell: Box<dyn Fn(String) + Send>,
}

impl<C: Clock> std::fmt::Debug for ForceDimension<C> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ForceDimension")
            .field("capabilities", &self.capabilities)
            .field("watchdog", &self.watchdog)
            .finish_non_exhaustive()
    }
}

impl<C: Clock> ForceDimension<C> {
    /// Returns the error of a failed call, by the status of the device.
    fn failed(&mut self) -> DeviceError {
        let refused = |what| DeviceError::new(DeviceErrorKind::Refused, what);
        let error = match self.device.status() {
            None | Some([_, 0, ..]) => DeviceError::new(
                DeviceErrorKind::Disconnected,
                "the device is unplugged, or does not answer",
            ),
            Some([0, ..]) => refused("the device has no power"),
            Some([_, _, _, reset, ..]) if reset != 0 => {
                refused("the device is no longer calibrated")
            }
            Some(_) => refused("the manufacturer's library reports an error"),
        };
        self.reason.get_or_insert(error);
        error
    }

    /// Returns the wrong value of a sample as an error.
    fn wrong(&mut self, what: &'static str) -> DeviceError {
        self.connection.unreadable += 1;
        let error = DeviceError::new(DeviceErrorKind::Interrupted, what);
        self.reason.get_or_insert(error);
        error
    }

    /// Returns whether the firmware has taken the force off by `now`.
    fn is_cut_by(&self, now: Duration) -> bool {
        let silence = now.saturating_sub(self.commanded_at);
        self.watchdog.is_some_and(|limit| silence > limit)
    }

    fn sample(&mut self) -> (i32, Vector, Option<[[f64; 3]; 3]>) {
        match self.part {
            Part::Gripper => {
                let (result, gap) = self.device.gripper_gap();
                (result, [gap, 0.0, 0.0], None)
            }
            Part::Handle if self.kind.has_wrist => {
                let (result, position, matrix) = self.device.frame();
                (result, position, Some(matrix))
            }
            Part::Handle => {
                let (result, position) = self.device.position();
                (result, position, None)
            }
        }
    }
}

impl<C: Clock> Device for ForceDimension<C> {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        let (result, position, matrix) = self.sample();
        let time = self.clock.now();
        self.was_cut |= self.has_force && self.is_cut_by(time);
        if result < 0 {
            return Err(self.failed());
        }
        if result == NO_NEW_SAMPLE {
            self.connection.lost += 1;
            return Err(DeviceError::new(
                DeviceErrorKind::NothingNew,
                "the library has no new sample",
            ));
        }
        if !position.iter().all(|part| part.is_finite()) {
            return Err(self.wrong("the library returns a position that is no number"));
        }
        let orientation = match matrix.map(|matrix| quaternion(&matrix)) {
            Some(None) => {
                return Err(self.wrong("the library returns an orientation that is no rotation"));
            }
            Some(found) => found,
            None => None,
        };
        if self.part == Part::Handle
            && let Some(velocity) = self.device.velocity()
        {
            self.velocity.compare(time, position, velocity);
        }
        self.connection.samples += 1;
        Ok(Pose {
            position,
            orientation,
            time,
        })
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        let held = on_axes(&self.capabilities, wrench);
        let [along, ..] = held.force;
        let forces = match self.part {
            Part::Handle => Forces {
                force: held.force,
                torque: Some(held.torque),
                gripper: None,
            },
            Part::Gripper => Forces {
                gripper: Some(along),
                ..Forces::default()
            },
        };
        let now = self.clock.now();
        // The firmware disables the forces when its watchdog acts.
        if self.is_cut_by(now) && self.device.enable_force(true) < 0 {
            return Err(self.failed());
        }
        let result = self.device.command(&forces_of(&self.kind, forces));
        if result < 0 {
            return Err(self.failed());
        }
        self.connection.untaken += u64::from(result == SATURATED);
        self.commanded_at = now;
        self.has_force = held != Wrench::NONE;
        if !wrench.is_finite() {
            let what = "the force of the command is no number";
            return Err(DeviceError::new(DeviceErrorKind::Refused, what));
        }
        Ok(held)
    }

    fn was_cut(&mut self) -> bool {
        std::mem::take(&mut self.was_cut)
    }

    fn connection(&self) -> Option<Connection> {
        Some(self.connection)
    }
}

impl<C: Clock> Drop for ForceDimension<C> {
    fn drop(&mut self) {
        let zero = self
            .device
            .command(&forces_of(&self.kind, Forces::default()));
        let name = self.kind.name;
        if let Some(reason) = self.reason {
            (self.tell)(format!("the {name}: {reason}; {}", self.device.error()));
        } else if zero < 0 {
            (self.tell)(format!(
                "warning: the {name} did not take the last command, a force of 0: {}",
                self.device.error()
            ));
        }
        let Connection {
            samples, untaken, ..
        } = self.connection;
        if untaken > 0 {
            (self.tell)(format!(
                "warning: {untaken} of about {samples} commands saturated motors of the {name}, so it held less than was \
                 commanded; lower the largest force"
            ));
        }
        if let Some(message) = self.velocity.message() {
            (self.tell)(format!("warning: the {name}: {message}"));
        }
    }
}
