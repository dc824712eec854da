//! `palpate bench loop`: how the loop keeps time on this machine.

use std::fmt;

use clap::{Args, Subcommand};
use palpate::{AnyParams, Contact, LoopParams, ObjectState};
use palpate_device::NullDevice;
use palpate_device::clock::MonotonicClock;
use palpate_rt::realtime::{Answer, Request};
use palpate_rt::safety::SafetyParams;
use palpate_rt::{ControlLoop, LoopThread, Rendering, StopFlag};
use palpate_study::json;
use serde::Serialize;

use super::run::{RealtimeArguments, TimingReport, request};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::results::print;
use crate::values::{duration, number};

/// Arguments of `bench`.
#[derive(Args, Debug)]
pub struct BenchArguments {
    /// What is measured.
    #[command(subcommand)]
    pub what: What,
}

/// What can be measured.
#[derive(Subcommand, Debug)]
pub enum What {
    /// How late the loop wakes, and how long its ticks are, without a device
    Loop(LoopArguments),
}

/// Arguments of `bench loop`.
#[derive(Args, Debug)]
pub struct LoopArguments {
    /// Rates of the loop, separated by commas [Hz]
    #[arg(long, value_name = "Hz", value_delimiter = ',', default_value = "1000,4000",
          value_parser = number)]
    pub rate: Vec<f64>,
    /// How long each is run [s]
    #[arg(long, value_name = "s", default_value = "5", value_parser = number)]
    pub duration: f64,
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
    /// What the machine is asked for.
    #[command(flatten)]
    pub realtime: RealtimeArguments,
}

/// Measures.
pub fn run(arguments: &BenchArguments) -> Result<(), Failure> {
    let What::Loop(arguments) = &arguments.what;
    let spin = duration("--spin", arguments.realtime.spin)?;
    let progress = Progress::new(arguments.rate.len());
    let mut all = Vec::with_capacity(arguments.rate.len());
    for rate in &arguments.rate {
        progress.begin(&format!("{rate} Hz"));
        let clock = MonotonicClock::new().with_spin(spin);
        let request = request(&arguments.realtime);
        all.push(Report {
            format: FORMAT,
            measured: measure(&clock, request, *rate, arguments.duration)?,
        });
        progress.advance();
    }
    drop(progress);
    print(&if arguments.json {
        json(&all) + "\n"
    } else {
        let texts: Vec<String> = all.iter().map(|one| one.measured.to_string()).collect();
        texts.join("\n")
    })
}

/// Name and version of the JSON report, which is a list of these.
const FORMAT: &str = "palpate bench loop 1";

/// The report on one rate.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Report {
    #[cfg_attr(test, schemars(extend("const" = FORMAT)))]
    format: &'static str,
    #[serde(flatten)]
    measured: Measured,
}

/// A loop that was measured.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Measured {
    rate_hz: f64,
    refused: Vec<String>,
    timing: TimingReport,
}

/// Runs a loop of coupled rendering at `rate` `[Hz]` for `seconds` on no device.
pub fn measure(
    clock: &MonotonicClock,
    request: Request,
    rate: f64,
    seconds: f64,
) -> Result<Measured, Failure> {
    let period = 1.0 / rate;
    let wrong = |error: &dyn fmt::Display| Failure::Arguments(format!("--rate {rate}: {error}"));
    // Pressed 1 mm into a wall, so that every tick renders.
    let rendering = Rendering {
        contact: Contact::object(1000.0, f64::INFINITY),
        loop_params: LoopParams::new(period),
        params: AnyParams::Coupled(palpate::CoupledParams::new(0.2)),
        virtual_force: 0.0,
        object: ObjectState {
            position: -1e-3,
            velocity: 0.0,
        },
    };
    let device = NullDevice::new(*clock);
    let control = ControlLoop::new(device, *clock, rendering, SafetyParams::default())
        .map_err(|error| wrong(&error))?;
    let periods = duration("--duration", seconds)?
        .as_nanos()
        .div_ceil(control.period().as_nanos());
    let most = Some(u64::try_from(periods).unwrap_or(u64::MAX));
    let running = LoopThread::start(control, request, &StopFlag::new(), most)
        .map_err(|error| Failure::System(format!("no thread for the loop: {error}")))?;
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
