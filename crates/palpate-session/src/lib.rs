//! Real-time loops on a device: excitation and monitoring of a device during calibration, the result of the watchdog
//! process, and reports on a loop, on this machine and on its devices.
//!
//! [`drive`] runs a loop of `palpate_rt` to its end and reports losses meanwhile. [`RunReport`] describes a loop of
//! `palpate_rt`, [`BenchReport`] the timing of a loop without a device, and [`MachineReport`] the real-time
//! capabilities of the machine. [`DeviceList`] lists the devices that can be opened, and [`MotorsReport`] the wiring
//! of a device's motors. [`Shaker`] shakes a device by the excitation of `palpate_study::calibrate`, through the safety
//! layer; [`Watched`] adds a supervisor. [`rendered`] creates the rendering of a world on its devices.
//! [`RecordedWorld`] reads the world and the device paths from a recording. Reports are types like those of
//! `palpate_study`: fields, a text, and a JSON whose schema is in `docs/schema` (feature `schema`).

mod bench;
mod driving;
mod list;
mod machine;
#[cfg(unix)]
mod motors;
mod on_devices;
mod recorded_world;
mod report;
#[cfg(test)]
mod schemas;
mod settling;
mod shaker;
mod watchdog;
mod watched;

pub use bench::{BenchReport, MeasureError, Measured, measure};
pub use driving::{DriveError, Ran, drive};
pub use list::{DeviceList, LATCH_WARNING};
pub use machine::{MachineReport, RATE, SECONDS};
#[cfg(unix)]
pub use motors::MotorsReport;
pub use on_devices::{NotRendered, lacking_axes, rendered};
pub use recorded_world::{RecordedWorld, RecordedWorldError};
pub use report::{Energies, RunReport, Subject, TimingReport};
pub use shaker::{ShakeDeclined, ShakeError, Shaker};
pub use watchdog::{Guarding, WatchdogReport};
pub use watched::Watched;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
