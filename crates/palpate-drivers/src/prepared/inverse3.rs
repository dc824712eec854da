//! An Inverse3 that reports connection faults when it is dropped.

use crate::inverse3::{Inspector, Inverse3};
use palpate_device::clock::Clock;
use palpate_device::{Capabilities, Device, DeviceError, Pose, Wrench, ZeroWriter};

/// Returns a name of the Inverse3 that is the same for two addresses of one service.
#[must_use]
pub fn identity(service: &str, device_id: &str) -> String {
    let service = service.replace("//localhost", "//127.0.0.1");
    format!("Inverse3 {device_id} of {}", service.trim_end_matches('/'))
}

/// An Inverse3 that reports connection faults when it is dropped.
pub struct Overheard<C> {
    device: Inverse3<C>,
    inspector: Inspector,
    /// Whether to report why the device is gone, because no other component does.
    says_why: bool,
    tell: Box<dyn FnMut(String) + Send>,
}

impl<C: Clock> Overheard<C> {
    /// Wraps `device`. On drop, `tell` receives the connection faults and, if `says_why`, the reason why the device
    /// is gone.
    pub fn new(
        device: Inverse3<C>,
        says_why: bool,
        tell: impl FnMut(String) + Send + 'static,
    ) -> Self {
        Self {
            inspector: device.inspector(),
            device,
            says_why,
            tell: Box::new(tell),
        }
    }
}

impl<C: Clock> Device for Overheard<C> {
    fn capabilities(&self) -> &Capabilities {
        self.device.capabilities()
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        self.device.read()
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        self.device.write(wrench)
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        self.device.zero_writer()
    }

    fn was_cut(&mut self) -> bool {
        self.device.was_cut()
    }
}

impl<C> Drop for Overheard<C> {
    fn drop(&mut self) {
        if let Some(why) = self.inspector.lost().filter(|_| self.says_why) {
            (self.tell)(format!("the Inverse3 is gone: {why}"));
        }
        let counts = self.inspector.counts();
        let said: Vec<String> = [
            (counts.late, "late"),
            (counts.lost, "lost"),
            (counts.surplus, "surplus"),
            (counts.garbage, "invalid"),
        ]
        .iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, what)| format!("{count} {what}"))
        .collect();
        if !said.is_empty() {
            (self.tell)(format!(
                "answers of the service to {} messages: {}",
                counts.sent,
                said.join(", ")
            ));
        }
    }
}
