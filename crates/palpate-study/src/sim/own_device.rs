//! A device of the caller's own in the place of a scene's.

use std::fmt;

use palpate_testbed::device::DevicePlant;

/// A [`DevicePlant`] that the bench can copy and send to other threads. Every device that is `Clone`, `Debug`,
/// `Send` and `Sync` is one.
pub trait OwnDevice: DevicePlant + fmt::Debug + Send + Sync {
    /// A copy of it, in the same state.
    fn copied(&self) -> Box<dyn OwnDevice>;
}

impl<D: DevicePlant + Clone + fmt::Debug + Send + Sync + 'static> OwnDevice for D {
    fn copied(&self) -> Box<dyn OwnDevice> {
        Box::new(self.clone())
    }
}

/// A device in the user's frame, seen from the canonical side.
#[derive(Debug)]
pub(crate) struct Seen {
    device: Box<dyn OwnDevice>,
    sign: f64,
}

impl Seen {
    pub fn new(device: Box<dyn OwnDevice>, sign: f64) -> Self {
        Self { device, sign }
    }
}

impl Clone for Seen {
    fn clone(&self) -> Self {
        Self::new(self.device.copied(), self.sign)
    }
}

impl DevicePlant for Seen {
    fn position(&self) -> f64 {
        self.sign * self.device.position()
    }

    fn velocity(&self) -> f64 {
        self.sign * self.device.velocity()
    }

    fn advance(&mut self, force_on_object: f64, duration: f64) -> f64 {
        // Force and motion change their signs together, so the work keeps its own.
        self.device.advance(self.sign * force_on_object, duration)
    }

    fn sample(&mut self, period: f64) {
        self.device.sample(period);
    }

    fn stored_energy(&self) -> f64 {
        self.device.stored_energy()
    }
}
