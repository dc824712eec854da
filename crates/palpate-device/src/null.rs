//! A device without motion.

use super::{Capabilities, Device, DeviceError, Pose, Wrench, ZeroWriter};
use crate::clock::Clock;

/// A device that rests at the origin and ignores every force. It serves to measure the loop itself.
#[derive(Clone, Debug)]
pub struct NullDevice<C> {
    clock: C,
    capabilities: Capabilities,
}

impl<C: Clock> NullDevice<C> {
    /// Creates a null device with one axis and time stamps of `clock`.
    #[must_use]
    pub fn new(clock: C) -> Self {
        Self {
            clock,
            capabilities: Capabilities {
                encoder_quantum: Some(0.0),
                ..Capabilities::unknown("null", 1)
            },
        }
    }
}

impl<C: Clock> Device for NullDevice<C> {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        Ok(Pose {
            orientation: None,
            position: [0.0; 3],
            time: self.clock.now(),
        })
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        Ok(wrench)
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        struct Nobody;
        impl ZeroWriter for Nobody {
            fn write_zero(&mut self) {}
        }
        Some(Box::new(Nobody))
    }
}
