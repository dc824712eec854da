//! Reports on a loop, on this machine and on its devices, as text and as JSON (schemas in `docs/schema`).

use palpate_study::text::counted;

mod bench;
mod connection;
mod device_list;
mod machine;
#[cfg(unix)]
mod motors;
mod run;
mod watchdog;

pub use bench::{BenchReport, MeasureError, Measured, measure};
pub use connection::ConnectionReport;
pub use device_list::DeviceList;
pub use machine::{MachineReport, RATE, SECONDS};
#[cfg(unix)]
pub use motors::MotorsReport;
pub use run::{Energies, RunReport, Subject, TimingReport};
pub use watchdog::{Guarding, WatchdogReport};

/// Returns the clause about the ticks or lines, `unit`, with ignored triangles or shell points.
pub(crate) fn crowded(count: u64, unit: &str) -> String {
    format!(
        "{} with more near triangles or shell points than the renderer can hold: the furthest ignored",
        counted(count, unit)
    )
}

/// Returns the condition of a generated energy, and whether the method compares the samples with the modelled timing.
pub(crate) fn if_as_modelled(checks_timing: bool) -> &'static str {
    if checks_timing {
        "if the loop is as modelled"
    } else {
        "if the loop is as modelled, which is not checked"
    }
}
