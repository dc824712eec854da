//! `palpate doctor --bench`: timing of the loop on this machine.

use clap::Args;
use palpate_device::clock::MonotonicClock;
use palpate_rt::realtime::Request;
use palpate_study::json;

use crate::failure::Failure;
use crate::progress::Progress;
use crate::reports::{BenchReport, MeasureError, Measured};
use crate::results::print;
use crate::values::{duration, number};

/// Arguments of `doctor --bench`.
#[derive(Args, Debug)]
#[command(next_help_heading = "Benchmark")]
pub struct BenchArguments {
    /// Measure only the wake-up lateness and the tick duration of the loop, without a device
    #[arg(long)]
    pub bench: bool,
    /// Rates of the loop, separated by commas [Hz]
    #[arg(long, value_name = "Hz", value_delimiter = ',', default_value = "1000,4000",
          value_parser = number, requires = "bench")]
    pub rate: Vec<f64>,
    /// Duration at each rate [s]
    #[arg(long, value_name = "s", default_value = "5", value_parser = number, requires = "bench")]
    pub duration: f64,
}

/// Runs a loop at each rate and prints its timing.
pub fn run(
    arguments: &BenchArguments,
    clock: &MonotonicClock,
    request: Request,
    is_json: bool,
) -> Result<(), Failure> {
    let progress = Progress::new(arguments.rate.len());
    let mut all = Vec::with_capacity(arguments.rate.len());
    for rate in &arguments.rate {
        progress.begin(&format!("{rate} Hz"));
        let measured = measure(clock, request, *rate, arguments.duration)?;
        all.push(BenchReport::new(measured));
        progress.advance();
    }
    drop(progress);
    print(&if is_json {
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
