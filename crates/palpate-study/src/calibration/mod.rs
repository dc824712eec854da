//! Results of a calibration besides the device file: the motion that it is computed from, and its report.

mod gain;
mod motion;
mod motion_card;
mod report;
mod shown;

pub use gain::{GainFrom, GainUnknown};
pub use motion::ExcitedMotion;
pub use motion_card::MotionCard;
pub use report::{CalibrationReport, Found};
pub use shown::shown;
