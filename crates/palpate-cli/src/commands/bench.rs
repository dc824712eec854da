//! `palpate bench loop`: timing of the loop on this machine.

use clap::{Args, Subcommand};
use palpate_device::clock::MonotonicClock;
use palpate_rt::realtime::Request;
use palpate_study::json;

use super::run::{RealtimeArguments, request};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::reports::{BenchReport, MeasureError, Measured};
use crate::results::print;
use crate::values::{duration, number};

/// Arguments of `bench`.
#[derive(Args, Debug)]
pub struct BenchArguments {
    /// The benchmark.
    #[command(subcommand)]
    pub what: What,
}

/// Benchmarks.
#[derive(Subcommand, Debug)]
pub enum What {
    /// Wake-up lateness and tick duration of the loop, without a device
    Loop(LoopArguments),
}

/// Arguments of `bench loop`.
#[derive(Args, Debug)]
pub struct LoopArguments {
    /// Rates of the loop, separated by commas [Hz]
    #[arg(long, value_name = "Hz", value_delimiter = ',', default_value = "1000,4000",
          value_parser = number)]
    pub rate: Vec<f64>,
    /// Duration at each rate [s]
    #[arg(long, value_name = "s", default_value = "5", value_parser = number)]
    pub duration: f64,
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
    /// Requests to the machine.
    #[command(flatten)]
    pub realtime: RealtimeArguments,
}

/// Runs the benchmark.
pub fn run(arguments: &BenchArguments) -> Result<(), Failure> {
    let What::Loop(arguments) = &arguments.what;
    let spin = duration("--spin", arguments.realtime.spin)?;
    let progress = Progress::new(arguments.rate.len());
    let mut all = Vec::with_capacity(arguments.rate.len());
    for rate in &arguments.rate {
        progress.begin(&format!("{rate} Hz"));
        let clock = MonotonicClock::new().with_spin(spin);
        let request = request(&arguments.realtime);
        let measured = measure(&clock, request, *rate, arguments.duration)?;
        all.push(BenchReport::new(measured));
        progress.advance();
    }
    drop(progress);
    print(&if arguments.json {
        json(&all) + "\n"
    } else {
        let texts: Vec<String> = all.iter().map(|one| one.measured().to_string()).collect();
        texts.join("\n")
    })
}

/// Runs a loop of coupled rendering at `rate` `[Hz]` for `seconds` on no device.
pub fn measure(
    clock: &MonotonicClock,
    request: Request,
    rate: f64,
    seconds: f64,
) -> Result<Measured, Failure> {
    let lasts = duration("--duration", seconds);
    crate::reports::measure(clock, request, rate, lasts?).map_err(|error| match error {
        MeasureError::Rate(error) => Failure::Arguments(format!("--rate {rate}: {error}")),
        MeasureError::Thread(_) => Failure::System(error.to_string()),
    })
}
