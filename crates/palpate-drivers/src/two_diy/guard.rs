//! Watchdog process of a 2DIY, which removes the torque if the program cannot.

use std::os::fd::AsFd;
use std::process::Command;
use std::sync::Arc;
use std::time::Duration;

use palpate_rt::watchdog::{Orders, Watchdog, WatchdogAccount, WatchdogError};

use super::driver::TwoDiy;
use super::packet::{REPLY_LENGTH, release, state};

impl<C> TwoDiy<C> {
    /// Returns the orders for a watchdog process that acts after `limit` without a message from the driver.
    #[must_use]
    pub fn orders(&self, limit: Duration) -> Orders {
        Orders {
            limit,
            release: release(self.layout()).to_vec(),
            probe: state(self.layout(), [0.0; 2]).to_vec(),
            answer: REPLY_LENGTH,
        }
    }

    /// Starts a watchdog process with `command`, which calls [`serve`](palpate_rt::watchdog::serve). The process
    /// commands zero torque if this program ends, or if the driver sends nothing for `limit` while a torque is on. It
    /// ends when the device is closed. If it ends earlier, the device commands only zero torque and returns
    /// [`Refused`](palpate_device::DeviceErrorKind::Refused).
    ///
    /// `account` records the actions of the watchdog process.
    ///
    /// # Errors
    /// The process does not start. The device is closed, and holds no torque.
    pub fn guarded_by(
        self,
        command: Command,
        limit: Duration,
        account: Arc<WatchdogAccount>,
    ) -> Result<Self, WatchdogError> {
        let port = self.line.serial().as_fd();
        let watchdog = Watchdog::start(command, port, &self.orders(limit), account)?;
        self.line.guard(watchdog);
        Ok(self)
    }
}
