//! Prediction of the device's motion beyond its samples.

mod covariance;
mod lateness;
mod observer;
mod placed;
mod prediction;
mod sensor_noise;
mod steps;
mod transmission;

pub(crate) use lateness::Lateness;
pub(crate) use observer::{EstimatedMotion, Measurement, Observer, ObserverParams, Update};
pub(crate) use placed::Placed;
pub(crate) use prediction::{LONGEST_WINDOW_SETTING, PREDICTION, Predictor};
pub use prediction::{Prediction, PredictionMemory, PredictionName};
pub use sensor_noise::{SensorInterval, SensorNoise};
pub use steps::LONGEST_WINDOW;
pub(crate) use transmission::{Flexure, Sway};
