//! Flags of the actuation: the path from a sample to the force on the device.

use std::path::PathBuf;

use clap::{Args, ValueHint};

use crate::values::{lag, number, periods};

/// Delay, lag and gain, each with its standard deviation, a flexible transmission, and the device file of a
/// calibration.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "Actuator")]
pub struct ActuationFlags {
    /// Time from a sample to the beginning of its force [s] [default: 0, or the scene's]
    #[arg(long, value_name = "s", value_parser = number, allow_hyphen_values = true, conflicts_with = "delay_periods")]
    pub delay: Option<f64>,
    /// The same in periods; may be fractional
    #[arg(long, value_name = "PERIODS", value_parser = periods, allow_hyphen_values = true)]
    pub delay_periods: Option<f64>,
    /// Standard deviation of the delay, including its changes from command to command, at most 8 periods [s]
    /// [default: 0, or the scene's]
    #[arg(long, value_name = "s", value_parser = number, allow_hyphen_values = true)]
    pub delay_deviation: Option<f64>,
    /// Time constant of the actuator, a first-order lag after the delay [s] [default: 0, or the scene's]
    #[arg(long, value_name = "s", value_parser = lag, allow_hyphen_values = true)]
    pub lag: Option<f64>,
    /// Standard deviation of the lag, at most 8 periods [s] [default: 0, or the scene's]
    #[arg(long, value_name = "s", value_parser = number, allow_hyphen_values = true)]
    pub lag_deviation: Option<f64>,
    /// Delivered over commanded force [default: 1, or the scene's]
    #[arg(long, value_name = "FACTOR", value_parser = number, allow_hyphen_values = true)]
    pub gain: Option<f64>,
    /// Standard deviation of the gain, at most the gain [default: 0, or the scene's]
    #[arg(long, value_name = "FACTOR", value_parser = number, allow_hyphen_values = true)]
    pub gain_deviation: Option<f64>,
    /// Model value of the delay [s]; simulate and tune only, whose actuator has its own delay [default: the true one,
    /// or the scene's]
    #[arg(long, value_name = "s", value_parser = number, allow_hyphen_values = true)]
    pub model_delay: Option<f64>,
    /// Model value of the lag [s]; simulate and tune only [default: the true one, or the scene's]
    #[arg(long, value_name = "s", value_parser = number, allow_hyphen_values = true)]
    pub model_lag: Option<f64>,
    /// Model value of the gain; simulate and tune only [default: the true one, or the scene's]
    #[arg(long, value_name = "FACTOR", value_parser = number, allow_hyphen_values = true)]
    pub model_gain: Option<f64>,
    /// Model value of the first resonance of a flexible transmission, with free motor and free handle [Hz]; needs
    /// --resonance-damping-ratio and --flexible-mass-fraction, or those of a scene or a device file [default: none, or
    /// the scene's]
    #[arg(long, value_name = "Hz", value_parser = number, allow_hyphen_values = true)]
    pub resonance: Option<f64>,
    /// Model value of the damping ratio of that resonance, 0 to 1
    #[arg(long, value_name = "RATIO", value_parser = number, allow_hyphen_values = true)]
    pub resonance_damping_ratio: Option<f64>,
    /// Model value of the fraction of the device's mass beyond the transmission, seen from the motor, 0 to below 1
    #[arg(long, value_name = "FRACTION", value_parser = number, allow_hyphen_values = true)]
    pub flexible_mass_fraction: Option<f64>,
    /// Device file of `palpate calibrate` (TOML) with the model values of the device: mass, delay, lag and gain with
    /// their deviations, the sensor's quantum, and a flexible transmission; other flags override its values
    #[arg(long, value_name = "FILE.toml", value_hint = ValueHint::FilePath)]
    pub device_file: Option<PathBuf>,
}
