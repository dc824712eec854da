//! Force that a device holds, readable outside the loop.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use palpate_device::{
    Capabilities, Connection, Device, DeviceError, Line, Pose, Vector, Wrench, ZeroWriter,
};

/// Reported held force of a device, readable by any thread.
#[derive(Clone, Debug, Default)]
pub struct Held(Arc<[AtomicU64; 3]>);

impl Held {
    /// Returns the force, of a line its mean `[N]`; NaN if the device did not confirm the last command. Each component
    /// is atomic on its own.
    pub fn force(&self) -> Vector {
        [0, 1, 2].map(|axis| f64::from_bits(self.0[axis].load(Ordering::Acquire)))
    }

    fn publish(&self, written: Option<Wrench>) {
        self.hold(written.map_or([f64::NAN; 3], |held| held.force));
    }

    fn hold(&self, force: Vector) {
        for (held, force) in self.0.iter().zip(force) {
            held.store(force.to_bits(), Ordering::Release);
        }
    }
}

/// A device wrapper that publishes the held force.
pub struct Telling {
    device: Box<dyn Device>,
    held: Held,
}

impl Telling {
    /// Wraps `device`, which publishes to `held`.
    pub fn new(device: Box<dyn Device>, held: Held) -> Self {
        Self { device, held }
    }
}

impl Device for Telling {
    fn capabilities(&self) -> &Capabilities {
        self.device.capabilities()
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        self.device.read()
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        let written = self.device.write(wrench);
        self.held.publish(written.ok());
        written
    }

    fn write_line(&mut self, line: Line) -> Result<Line, DeviceError> {
        let written = self.device.write_line(line);
        self.held.publish(written.ok().map(|held| held.wrench));
        written
    }

    fn last_sent(&self) -> Option<Line> {
        self.device.last_sent()
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        let zero = self.device.zero_writer()?;
        let held = self.held.clone();
        Some(Box::new(TellingZero { zero, held }))
    }

    fn was_cut(&mut self) -> bool {
        self.device.was_cut()
    }

    fn connection(&self) -> Option<Connection> {
        self.device.connection()
    }
}

struct TellingZero {
    zero: Box<dyn ZeroWriter>,
    held: Held,
}

impl ZeroWriter for TellingZero {
    fn write_zero(&mut self) {
        self.zero.write_zero();
        self.held.hold([0.0; 3]);
    }
}
