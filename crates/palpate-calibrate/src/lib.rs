#![doc = include_str!("../README.md")]

mod calibration;
mod file;
mod quantity;

pub use calibration::{Calibration, Known};
pub use file::CalibrationError;
pub use quantity::{Quantity, Range};
