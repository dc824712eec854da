//! Figures of results: runs, comparisons, maps, advice, calibrations, and the report of a device as a page.

mod advice;
mod calibration;
pub mod card;
mod compared;
mod experiment;
mod finding;
pub mod map;
mod multiples;
mod overlay;
pub mod paper;
mod runs;
mod series;
mod sheet;
mod steps;
mod suite;
mod sweep;
mod tune;
mod tune_world;
mod world;

pub use advice::{advice, shown_of};
pub use calibration::{calibration, motion};
pub use compared::compared;
pub use experiment::method_by_method;
pub use runs::{Devices, RunsFigure};
pub use steps::step_by_step;
pub use suite::suite;
pub use sweep::sweep;
pub use tune::tune;
pub use tune_world::tune_world;
pub use world::world;

use crate::figure::Role;
use palpate_scene::method::MethodName;
use palpate_study::sim::run::RunMethod;

/// Default methods of a figure of many methods: the plain spring, the usual remedy, the paper's method, and palpate's
/// default.
pub const SHOWN: [MethodName; 4] = [
    MethodName::Basic,
    MethodName::VirtualDamper,
    MethodName::Hfcr,
    MethodName::Coupled,
];

/// Returns the role of a method, so that it looks the same in every figure.
#[must_use]
pub fn role(method: impl Into<RunMethod>) -> Role {
    let method = match method.into() {
        RunMethod::BuiltIn(method) => method,
        RunMethod::Own(_) => return Role::Compared(10),
    };
    Role::Compared(method.info().colour.into())
}
