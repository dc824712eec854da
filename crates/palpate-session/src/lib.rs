//! What a loop in real time on a device is, beside its ticks: how a device is excited and watched while it is calibrated,
//! what its guardian did, and the reports on a loop, on this machine, and on the devices that are here.
//!
//! [`drive`] runs a loop of `palpate_rt` to its end and tells what is lost meanwhile. [`RunReport`] says how a loop of `palpate_rt` went, [`BenchReport`] how one keeps time without a device, and
//! [`MachineReport`] what the machine grants. [`DeviceList`] has the devices that can be opened, [`MotorsReport`] how the
//! motors of one are wired. [`Shaker`] shakes a device by the excitation of `palpate_calibrate`, through the safety layer;
//! [`Watched`] lets a supervisor watch it. [`rendered`] makes what a loop renders of a world on its devices, and [`RecordedWorld`] reads
//! from a recording the world and where its devices went. Reports are types as those of `palpate_study`: fields, a text, and a JSON whose
//! schema is in `docs/schema` (feature `schema`).

mod bench;
mod driving;
mod guardian;
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
mod watched;

pub use bench::{BenchReport, MeasureError, Measured, measure};
pub use driving::{DriveError, Ran, drive};
pub use guardian::{GuardianReport, Guarding};
pub use list::{DeviceList, LATCH_WARNING};
pub use machine::{MachineReport, RATE, SECONDS};
#[cfg(unix)]
pub use motors::MotorsReport;
pub use on_devices::{NotRendered, lacking_axes, rendered};
pub use recorded_world::{RecordedWorld, RecordedWorldError};
pub use report::{Energies, RunReport, Subject, TimingReport};
pub use shaker::{ShakeDeclined, ShakeError, Shaker};
pub use watched::Watched;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExamples;
