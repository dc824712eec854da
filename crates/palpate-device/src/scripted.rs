//! A device that follows a script, including faults.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use super::{Capabilities, Device, DeviceError, DeviceErrorKind, Pose, Vector, Wrench, ZeroWriter};
use crate::clock::Clock;

/// Behaviour of a scripted device in one period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// Reports this position `[m]`.
    At(Vector),
    /// Repeats the last reading, including the time stamp.
    Stale,
    /// Fails with an error of this kind.
    Fails(DeviceErrorKind),
    /// Reports this position `[m]` and fails to take the force with an error of this kind.
    FailsForce(DeviceErrorKind, Vector),
}

/// List of steps; after its end the last step is repeated.
pub type Script = Vec<Step>;

/// A test device that follows a script and stores the forces written to it.
#[derive(Debug)]
pub struct ScriptedDevice<C> {
    clock: C,
    capabilities: Capabilities,
    script: Script,
    next: usize,
    last: Pose,
    forces: Vec<Vector>,
    zeroed: Arc<AtomicUsize>,
    watchdog: Arc<AtomicBool>,
    /// Whether the last reading detected a cut.
    was_cut: bool,
}

/// Maximum number of stored forces; the memory is allocated before the loop starts.
const REMEMBERED: usize = 100_000;

impl<C: Clock> ScriptedDevice<C> {
    /// Creates a device with `axes` axes that follows `script`.
    #[must_use]
    pub fn new(clock: C, axes: usize, script: Script) -> Self {
        Self {
            clock,
            capabilities: Capabilities::unknown("scripted", axes),
            script,
            next: 0,
            last: Pose {
                orientation: None,
                position: [0.0; 3],
                time: std::time::Duration::ZERO,
            },
            forces: Vec::with_capacity(REMEMBERED),
            zeroed: Arc::default(),
            watchdog: Arc::default(),
            was_cut: false,
        }
    }

    /// Replaces the capabilities.
    #[must_use]
    pub fn with_capabilities(self, capabilities: Capabilities) -> Self {
        Self {
            capabilities,
            ..self
        }
    }

    /// Returns the first 100000 written forces `[N]`.
    #[must_use]
    pub fn forces(&self) -> &[Vector] {
        &self.forces
    }

    /// Returns the counter of calls of the zero writer.
    #[must_use]
    pub fn times_zeroed(&self) -> Arc<AtomicUsize> {
        Arc::clone(&self.zeroed)
    }

    /// Returns a flag that emulates a watchdog process. After it is set, the next read reports a zero-force command
    /// of that process.
    #[must_use]
    pub fn watchdog(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.watchdog)
    }
}

impl<C: Clock> Device for ScriptedDevice<C> {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        self.was_cut |= self.watchdog.swap(false, Ordering::SeqCst);
        let step = self.script.get(self.next).or(self.script.last());
        self.next += 1;
        match step.copied().unwrap_or(Step::Stale) {
            Step::At(position) | Step::FailsForce(_, position) => {
                self.last = Pose {
                    orientation: None,
                    position,
                    time: self.clock.now(),
                };
            }
            Step::Stale => {}
            Step::Fails(kind) => return Err(DeviceError::new(kind, "scripted fault")),
        }
        Ok(self.last)
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        if self.forces.len() < REMEMBERED {
            self.forces.push(wrench.force);
        }
        let now = self.next.saturating_sub(1);
        match self.script.get(now).or(self.script.last()) {
            Some(Step::FailsForce(kind, _)) => Err(DeviceError::new(*kind, "scripted fault")),
            _ => Ok(wrench),
        }
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        struct Counts(Arc<AtomicUsize>);
        impl ZeroWriter for Counts {
            fn write_zero(&mut self) {
                self.0.fetch_add(1, Ordering::SeqCst);
            }
        }
        Some(Box::new(Counts(Arc::clone(&self.zeroed))))
    }

    fn was_cut(&mut self) -> bool {
        std::mem::take(&mut self.was_cut)
    }
}
