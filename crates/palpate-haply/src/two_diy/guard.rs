//! A guardian for a 2DIY: what takes its torque off when the program can not.

use std::os::fd::AsFd;
use std::process::Command;
use std::sync::Arc;
use std::time::Duration;

use palpate_rt::guardian::{Guardian, GuardianAccount, GuardianError, Orders};

use super::driver::TwoDiy;
use super::packet::{REPLY_LENGTH, release, state};

impl<C> TwoDiy<C> {
    /// What a guardian of this device has to do when the driver was silent for `limit`.
    #[must_use]
    pub fn orders(&self, limit: Duration) -> Orders {
        Orders {
            limit,
            release: release(self.layout()).to_vec(),
            probe: state(self.layout(), [0.0; 2]).to_vec(),
            answer: REPLY_LENGTH,
        }
    }

    /// The same device with a guardian: the process of `command`, which calls
    /// [`serve`](palpate_rt::guardian::serve). It commands no torque as soon as this program is gone,
    /// and when the driver has sent nothing for `limit` while a torque is on. It ends when the device
    /// is closed. If it ends before that, the device commands no torque any more and says
    /// [`Refused`](palpate_device::DeviceErrorKind::Refused).
    ///
    /// What the guardian has done is counted in `account`.
    ///
    /// # Errors
    /// The process does not start. The device is closed, and holds no torque.
    pub fn guarded_by(
        self,
        command: Command,
        limit: Duration,
        account: Arc<GuardianAccount>,
    ) -> Result<Self, GuardianError> {
        let port = self.line.serial().as_fd();
        let guardian = Guardian::start(command, port, &self.orders(limit), account)?;
        self.line.guard(guardian);
        Ok(self)
    }
}
