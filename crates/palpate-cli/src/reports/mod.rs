//! Reports on a loop, on this machine and on its devices, as text and as JSON (schemas in `docs/schema`).

mod bench;
mod device_list;
mod machine;
#[cfg(unix)]
mod motors;
mod run;
mod watchdog;

pub use bench::{BenchReport, MeasureError, Measured, measure};
pub use device_list::DeviceList;
pub use machine::{MachineReport, RATE, SECONDS};
#[cfg(unix)]
pub use motors::MotorsReport;
pub use run::{Energies, RunReport, Subject, TimingReport};
pub use watchdog::{Guarding, WatchdogReport};
