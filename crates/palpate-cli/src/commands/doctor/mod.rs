//! `palpate doctor`: real-time properties of this machine.

mod bench;

use std::io;

use clap::Args;
use palpate_device::clock::MonotonicClock;

use super::run::{RealtimeArguments, request};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::reports::{MachineReport, RATE, SECONDS};
use crate::results::print_report;
use crate::values::duration;
use bench::{BenchArguments, measure};

/// Arguments of `doctor`.
#[derive(Args, Debug)]
pub struct DoctorArguments {
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
    /// Benchmark of the loop.
    #[command(flatten)]
    pub bench: BenchArguments,
    /// Requests to the machine.
    #[command(flatten)]
    pub realtime: RealtimeArguments,
}

/// Queries the machine, and tries a loop. With `--bench`, measures the timing of the loop.
pub fn run(arguments: &DoctorArguments) -> Result<(), Failure> {
    let request = request(&arguments.realtime);
    let spin = duration("--spin", arguments.realtime.spin)?;
    let clock = MonotonicClock::new().with_spin(spin);
    if arguments.bench.bench {
        return bench::run(&arguments.bench, &clock, request, arguments.json);
    }
    let progress = Progress::new(1);
    progress.begin("querying the machine, running a loop");
    // On a separate thread, because granted properties stay with the requesting thread.
    let answers = std::thread::Builder::new()
        .spawn(move || request.ask())
        .and_then(|thread| {
            thread
                .join()
                .map_err(|_| io::Error::other("the thread panicked"))
        })
        .map_err(|error| Failure::System(format!("cannot query the machine: {error}")))?;
    let measured = measure(&clock, request, RATE, SECONDS)?;
    #[cfg(unix)]
    let watchdog = crate::devices::guarding::command();
    #[cfg(not(unix))]
    let watchdog = Err(io::ErrorKind::Unsupported.into());
    let report = MachineReport::new(&answers, measured, watchdog);
    drop(progress);
    print_report(&report, arguments.json)
}
