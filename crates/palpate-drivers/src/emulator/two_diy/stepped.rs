//! Emulated 2DIY as a device in simulated time, without a port or threads.

use std::collections::VecDeque;
use std::time::Duration;

use crate::two_diy::kinematics::ArmPose;
use crate::two_diy::packet::{Heard, Replies, setup, state};
use crate::two_diy::{Board, Layout, torques};
use palpate_device::clock::{Clock, SteppedClock};
use palpate_device::{Capabilities, Device, DeviceError, DeviceErrorKind, Pose, Wrench};

use super::Settings;
use super::arm::Arm;
use super::firmware::{Did, Firmware, Wire};
use crate::emulator::port::Usb;

/// Emulated 2DIY as a device on a [`SteppedClock`]: runs are reproducible, independent of the load of the machine.
///
/// Board, arm, hand and bytes on the wire are those of the [`Emulator`](super::Emulator). This type replaces driver and
/// port: each `read` sends a STATE with the held torques and advances the time to its answer, and each `write` sends a
/// STATE without waiting, as [`TwoDiy`](crate::two_diy::TwoDiy) does.
#[derive(Debug)]
pub struct SteppedTwoDiy {
    clock: SteppedClock,
    capabilities: Capabilities,
    layout: Layout,
    board: Board,
    firmware: Firmware,
    arm: Arm,
    usb: Usb,
    /// Packets in transit to the board, with their arrival times.
    travelling: VecDeque<(Duration, Vec<u8>)>,
    replies: Replies,
    held: [f32; 2],
    pose: Option<ArmPose>,
}

/// Bytes of one packet and of its answer.
#[derive(Default)]
struct Memory {
    incoming: VecDeque<u8>,
    sent: Vec<u8>,
}

impl Wire for Memory {
    fn byte_now(&mut self) -> Option<u8> {
        self.incoming.pop_front()
    }

    fn byte_soon(&mut self) -> Option<u8> {
        self.incoming.pop_front()
    }

    fn send(&mut self, bytes: &[u8]) {
        self.sent.extend(bytes);
    }
}

impl SteppedTwoDiy {
    /// Creates a device that has been set up, in its start pose. The port of `settings` is not opened.
    ///
    /// # Errors
    /// The arm cannot have these angles, or the amplifier parameters are invalid.
    pub fn new(settings: &Settings, clock: SteppedClock) -> Result<Self, String> {
        let mut layout = settings.generation.layout();
        if let Some(angles) = settings.angles {
            #[expect(clippy::cast_possible_truncation, reason = "the wire has f32")]
            let angles = angles.map(|angle| angle as f32);
            layout = layout.starting_at(angles);
        }
        let capabilities = Capabilities {
            holds_last_force: true,
            ..Capabilities::unknown("Haply 2DIY, in simulated time", 2)
        };
        let mut device = Self {
            clock,
            capabilities,
            layout,
            board: settings.board,
            firmware: Firmware::new(settings.board, settings.strict),
            arm: settings.arm()?,
            usb: settings.usb,
            travelling: VecDeque::new(),
            replies: Replies::new(layout),
            held: [0.0; 2],
            pose: None,
        };
        device.execute(device.clock.now(), setup(&layout).into());
        Ok(device)
    }

    /// Returns the effective mass of the arm in its current pose along the unit vector `direction` `[kg]`.
    #[must_use]
    pub fn effective_mass(&self, direction: [f64; 2]) -> f64 {
        self.arm.effective_mass(direction)
    }

    /// Returns the true position of the end-point `[m]`.
    #[must_use]
    pub fn position(&self) -> [f64; 2] {
        self.arm.position()
    }

    /// Lets the board execute `packet` at `time` and returns the answer.
    fn execute(&mut self, time: Duration, packet: VecDeque<u8>) -> Vec<u8> {
        self.arm.move_to(time);
        let mut memory = Memory {
            incoming: packet,
            sent: Vec::new(),
        };
        while let Some(did) = self.firmware.turn(&mut memory, &mut self.arm) {
            if matches!(did, Did::Commanded(1..)) {
                self.arm.opened();
            }
        }
        memory.sent
    }

    /// Sends a STATE with the held torques and returns its arrival time.
    fn send(&mut self) -> Duration {
        let arrives = self.usb.arrival(self.clock.now());
        let packet = state(&self.layout, self.held).to_vec();
        self.travelling.push_back((arrives, packet));
        arrives
    }
}

impl Device for SteppedTwoDiy {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        let arrived = self.send();
        let mut answer = Vec::new();
        while let Some((at, packet)) = self.travelling.pop_front() {
            answer = self.execute(at, packet.into());
        }
        self.clock.sleep_until(self.usb.arrival(arrived));
        let nothing = |what| DeviceError::new(DeviceErrorKind::NothingNew, what);
        let mut angles = None;
        for byte in answer {
            if let Heard::Angles(heard) = self.replies.hear(byte) {
                angles = Some(heard);
            }
        }
        let angles = angles.ok_or(nothing("the board did not answer"))?;
        let radians = angles.map(|angle| f64::from(angle).to_radians());
        self.pose = self.layout.geometry.pose(radians).ok();
        let pose = self.pose.as_ref().ok_or(nothing("the arm has no pose"))?;
        let [x, y] = pose.position;
        Ok(Pose {
            orientation: None,
            position: [x, y, 0.0],
            time: self.clock.now(),
        })
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        let [x, y, _] = wrench.force;
        let (torques, [given_x, given_y]) = match &self.pose {
            Some(pose) => torques(pose, self.board, [x, y]),
            None => ([0.0; 2], [0.0; 2]),
        };
        self.held = torques;
        self.send();
        Ok(Wrench::of_force([given_x, given_y, 0.0]))
    }
}
