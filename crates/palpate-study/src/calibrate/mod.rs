//! Parameters of a real haptic device that a renderer needs, and their measurement.
//!
//! [`Calibration`] holds each value with its standard deviation and origin, and reads and writes it as a file.
//! [`Excitation`] returns a bounded force for each position; [`measure`] fits the recorded motion.

mod calibration;
mod cogging;
mod consistency;
mod excitation;
mod exponential;
mod file;
mod filter;
mod fit;
mod flexible;
mod gain;
mod measure;
mod model;
mod outcome;
mod quantity;
mod quantum;
mod start;

pub use calibration::{Calibration, Known};
pub use excitation::{
    Excitation, ExcitationError, ExcitationParams, LONGEST, PERIODS, Phase, SHORTEST, Stop,
};
pub use file::CalibrationError;
pub use measure::{Declined, Measured, measure};
pub use outcome::Fitted;
pub use quantity::{Quantity, Range};
