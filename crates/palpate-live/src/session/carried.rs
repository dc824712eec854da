//! A device that outlives its loop.

use std::sync::mpsc::{Receiver, Sender, channel};

use palpate_device::{
    Capabilities, Connection, Device, DeviceError, DeviceErrorKind, Line, Pose, Wrench, ZeroWriter,
};

/// A device in a loop that is returned when dropped.
pub struct Carried {
    /// Copy of the capabilities, available after the device has been returned.
    capabilities: Capabilities,
    device: Option<Box<dyn Device>>,
    back: Sender<Box<dyn Device>>,
}

/// Channel on which the device is returned.
pub type Returned = Receiver<Box<dyn Device>>;

impl Carried {
    /// `device`, and where it will be when its loop is gone.
    pub fn new(device: Box<dyn Device>) -> (Self, Returned) {
        let (back, returned) = channel();
        let carried = Self {
            capabilities: device.capabilities().clone(),
            device: Some(device),
            back,
        };
        (carried, returned)
    }

    fn device(&mut self) -> Result<&mut Box<dyn Device>, DeviceError> {
        let gone = DeviceError::new(DeviceErrorKind::Disconnected, "the device was returned");
        self.device.as_mut().ok_or(gone)
    }
}

impl Device for Carried {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        self.device()?.read()
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        self.device()?.write(wrench)
    }

    fn write_line(&mut self, line: Line) -> Result<Line, DeviceError> {
        self.device()?.write_line(line)
    }

    fn last_sent(&self) -> Option<Line> {
        self.device.as_ref()?.last_sent()
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        self.device.as_mut()?.zero_writer()
    }

    fn was_cut(&mut self) -> bool {
        self.device.as_mut().is_some_and(Device::was_cut)
    }

    fn connection(&self) -> Option<Connection> {
        self.device.as_ref()?.connection()
    }
}

impl Drop for Carried {
    fn drop(&mut self) {
        if let Some(device) = self.device.take() {
            // The receiver may be gone.
            let _ = self.back.send(device);
        }
    }
}
