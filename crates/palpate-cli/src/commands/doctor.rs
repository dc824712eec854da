//! `palpate doctor`: real-time properties of this machine.

use std::io;

use clap::Args;
use palpate_device::clock::MonotonicClock;

use super::bench::measure;
use super::run::{RealtimeArguments, request};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::reports::{MachineReport, RATE, SECONDS};
use crate::results::print_report;
use crate::values::duration;

/// Arguments of `doctor`.
#[derive(Args, Debug)]
pub struct DoctorArguments {
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
    /// Requests to the machine.
    #[command(flatten)]
    pub realtime: RealtimeArguments,
}

/// Queries the machine, and tries a loop.
pub fn run(arguments: &DoctorArguments) -> Result<(), Failure> {
    let progress = Progress::new(1);
    progress.begin("querying the machine, running a loop");
    let request = request(&arguments.realtime);
    // On a separate thread, because granted properties stay with the requesting thread.
    let answers = std::thread::Builder::new()
        .spawn(move || request.ask())
        .and_then(|thread| {
            thread
                .join()
                .map_err(|_| io::Error::other("the thread panicked"))
        })
        .map_err(|error| Failure::System(format!("cannot query the machine: {error}")))?;
    let spin = duration("--spin", arguments.realtime.spin)?;
    let clock = MonotonicClock::new().with_spin(spin);
    let measured = measure(&clock, request, RATE, SECONDS)?;
    #[cfg(unix)]
    let watchdog = crate::devices::guarding::command();
    #[cfg(not(unix))]
    let watchdog = Err(io::ErrorKind::Unsupported.into());
    let report = MachineReport::new(&answers, measured, watchdog);
    drop(progress);
    print_report(&report, arguments.json)
}
