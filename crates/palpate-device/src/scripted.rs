//! A device that does what it is told beforehand, faults included.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use super::{Capabilities, Device, DeviceError, DeviceErrorKind, Pose, Vector, Wrench, ZeroWriter};
use crate::clock::Clock;

/// What a scripted device does in one period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// It is here `[m]`.
    At(Vector),
    /// It repeats its last reading, time stamp included.
    Stale,
    /// It has no answer.
    Fails(DeviceErrorKind),
    /// It is here `[m]`, and does not take a force.
    RefusesForce(Vector),
}

/// A list of steps; behind its end the last one is repeated.
pub type Script = Vec<Step>;

/// A device that follows a script and remembers which forces it was given, for tests.
#[derive(Debug)]
pub struct ScriptedDevice<C> {
    clock: C,
    capabilities: Capabilities,
    script: Script,
    next: usize,
    last: Pose,
    forces: Vec<Vector>,
    zeroed: Arc<AtomicUsize>,
    guardian: Arc<AtomicBool>,
    /// Whether it has heard of that.
    was_cut: bool,
}

/// Forces that are remembered; there is room for them before the loop starts.
const REMEMBERED: usize = 100_000;

impl<C: Clock> ScriptedDevice<C> {
    /// A device with `axes` axes that follows `script`.
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
            guardian: Arc::default(),
            was_cut: false,
        }
    }

    /// The same device with other capabilities.
    #[must_use]
    pub fn with_capabilities(self, capabilities: Capabilities) -> Self {
        Self {
            capabilities,
            ..self
        }
    }

    /// Forces that were written, the first 100000 of them `[N]`.
    #[must_use]
    pub fn forces(&self) -> &[Vector] {
        &self.forces
    }

    /// How often its zero writer has been used.
    #[must_use]
    pub fn times_zeroed(&self) -> Arc<AtomicUsize> {
        Arc::clone(&self.zeroed)
    }

    /// Raising it plays a guardian that has commanded no force; the device hears of it when it reads.
    #[must_use]
    pub fn guardian(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.guardian)
    }
}

impl<C: Clock> Device for ScriptedDevice<C> {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        self.was_cut |= self.guardian.swap(false, Ordering::SeqCst);
        let step = self.script.get(self.next).or(self.script.last());
        self.next += 1;
        match step.copied().unwrap_or(Step::Stale) {
            Step::At(position) | Step::RefusesForce(position) => {
                self.last = Pose {
                    orientation: None,
                    position,
                    time: self.clock.now(),
                };
            }
            Step::Stale => {}
            Step::Fails(kind) => return Err(DeviceError::new(kind, "so the script says")),
        }
        Ok(self.last)
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        if self.forces.len() < REMEMBERED {
            self.forces.push(wrench.force);
        }
        let now = self.next.saturating_sub(1);
        match self.script.get(now).or(self.script.last()) {
            Some(Step::RefusesForce(_)) => Err(DeviceError::new(
                DeviceErrorKind::Refused,
                "so the script says",
            )),
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
