//! Options of a loop, in addition to device and renderer.

use std::path::PathBuf;
use std::time::Duration;

use palpate_device::Capabilities;
use palpate_rt::realtime::Request;
use palpate_rt::safety::SafetyParams;
use pyo3::prelude::*;

use super::heard::LARGEST;
use crate::names::refused;

/// Options of a loop from Python, in addition to device and renderer.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Options {
    pub record: Option<PathBuf>,
    pub scene: Option<String>,
    pub ring: usize,
    largest_speed: f64,
    range: Option<[f64; 2]>,
    oscillation: f64,
    stall_after_periods: Option<f64>,
    priority: u8,
    lock_memory: bool,
    processor: Option<usize>,
    spin: f64,
}

impl Options {
    /// Returns the busy-wait time before a deadline.
    ///
    /// # Errors
    /// An invalid option, by its name.
    pub fn checked_spin(&self) -> PyResult<Duration> {
        if self.ring == 0 || self.ring > LARGEST {
            return Err(refused(format!(
                "ring is {} ticks, but must be 1 to {LARGEST}",
                self.ring
            )));
        }
        if self.priority > 98 {
            return Err(refused(format!(
                "priority is {}, but must be 0 (none) to 98",
                self.priority
            )));
        }
        let spin = Duration::try_from_secs_f64(self.spin).ok();
        spin.filter(|spin| *spin <= Duration::from_secs(1))
            .ok_or_else(|| refused(format!("spin is {} s, but must be 0 to 1", self.spin)))
    }

    /// Returns `limits` with the requested stall limit.
    pub fn patient(&self, limits: SafetyParams) -> SafetyParams {
        match self.stall_after_periods {
            // Exactly these periods, without the tolerated lateness.
            Some(periods) => SafetyParams {
                stall_after_periods: periods,
                tolerated_lateness: 0.0,
                ..limits
            },
            None => limits,
        }
    }

    /// Returns the limits between a renderer with its own limits and `device`.
    pub fn limits(
        &self,
        device: &Capabilities,
        force_limit: Option<f64>,
        soft_start: f64,
    ) -> SafetyParams {
        let usual = SafetyParams::for_device(device);
        let asked = force_limit.unwrap_or(f64::MAX);
        let mut limits = self.patient(SafetyParams {
            largest_force: asked.min(device.largest_force.unwrap_or(f64::MAX)),
            soft_start,
            largest_speed: self.largest_speed,
            range: self.range,
            ..usual
        });
        limits.oscillation.energy = self.oscillation;
        limits
    }

    /// Returns the real-time requests to the system.
    pub fn request(&self) -> Request {
        Request {
            priority: (self.priority > 0).then_some(self.priority),
            lock_memory: self.lock_memory,
            processor: self.processor,
        }
    }
}
