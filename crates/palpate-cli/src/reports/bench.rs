//! Loop timing on this machine.

use std::fmt;
use std::io;
use std::time::Duration;

use palpate_core::{AnyParams, Contact, LoopParams, ObjectState};
use palpate_device::NullDevice;
use palpate_device::clock::MonotonicClock;
use palpate_rt::realtime::{Answer, Request};
use palpate_rt::safety::SafetyParams;
use palpate_rt::{ControlLoop, LoopThread, Rendering, SetupError, StopFlag};
use serde::Serialize;

use crate::reports::TimingReport;

/// Name and version of the JSON report, which is a list of [`BenchReport`].
const FORMAT: &str = "palpate bench loop 1";

/// Report on one rate.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct BenchReport {
    #[cfg_attr(test, schemars(extend("const" = FORMAT)))]
    format: &'static str,
    #[serde(flatten)]
    measured: Measured,
}

/// Measurements of a loop.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Measured {
    rate_hz: f64,
    refused: Vec<String>,
    timing: TimingReport,
}

impl BenchReport {
    /// Creates the report of a measured loop.
    #[must_use]
    pub fn new(measured: Measured) -> Self {
        Self {
            format: FORMAT,
            measured,
        }
    }

    /// Returns the measurements of the loop.
    #[must_use]
    pub fn measured(&self) -> &Measured {
        &self.measured
    }
}

/// Reason for a failed measurement.
#[derive(Debug, thiserror::Error)]
pub enum MeasureError {
    /// The rate is invalid.
    #[error(transparent)]
    Rate(#[from] SetupError),
    /// The system cannot start a thread.
    #[error("no thread for the loop: {0}")]
    Thread(io::Error),
}

/// Runs a loop of coupled rendering at `rate` `[Hz]` without a device, for the given duration.
///
/// # Errors
/// The rate is invalid, or the system cannot start a thread.
pub fn measure(
    clock: &MonotonicClock,
    request: Request,
    rate: f64,
    lasts: Duration,
) -> Result<Measured, MeasureError> {
    let period = 1.0 / rate;
    // The device is pressed 1 mm into a wall, so that every tick renders.
    let rendering = Rendering {
        contact: Contact::object(1000.0, f64::INFINITY),
        loop_params: LoopParams::new(period),
        params: AnyParams::Coupled(palpate_core::CoupledParams::new(0.2)),
        virtual_force: 0.0,
        object: ObjectState {
            position: -1e-3,
            velocity: 0.0,
        },
    };
    let device = NullDevice::new(*clock);
    let control = ControlLoop::new(device, *clock, rendering, SafetyParams::default())?;
    let periods = lasts.as_nanos().div_ceil(control.period().as_nanos());
    let most = Some(u64::try_from(periods).unwrap_or(u64::MAX));
    let running = LoopThread::start(control, request, &StopFlag::new(), most)
        .map_err(MeasureError::Thread)?;
    let refused = running
        .answers()
        .iter()
        .filter(|answer| !answer.is_granted());
    let refused = refused.map(Answer::to_string).collect();
    Ok(Measured {
        rate_hz: rate,
        refused,
        timing: (&running.join().statistics).into(),
    })
}

impl fmt::Display for Measured {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} Hz: {}", self.rate_hz, self.timing)?;
        for refused in &self.refused {
            writeln!(f, "{refused}")?;
        }
        Ok(())
    }
}
