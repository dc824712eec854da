//! Flags of the way from a sample to the force on the device.

use std::path::PathBuf;

use clap::{Args, ValueHint};

use crate::values::{number, periods};

/// Delay, lag and gain, each with its standard deviation, a flexible transmission, and the file that a
/// calibration leaves.
#[derive(Args, Debug, Default)]
#[command(next_help_heading = "Actuator")]
pub struct ActuationFlags {
    /// Time from a sample to the beginning of its force, in periods; fractions are taken [default: 0,
    /// or the scene's]
    #[arg(long, value_name = "PERIODS", value_parser = periods, allow_hyphen_values = true)]
    pub delay: Option<f64>,
    /// Standard deviation of the delay, its changes from command to command included, in periods
    /// [default: 0, or the scene's]
    #[arg(long, value_name = "PERIODS", value_parser = number, allow_hyphen_values = true)]
    pub delay_deviation: Option<f64>,
    /// Time constant of the actuator, a first-order lag after the delay [s] [default: 0, or the scene's]
    #[arg(long, value_name = "s", value_parser = number, allow_hyphen_values = true)]
    pub lag: Option<f64>,
    /// Standard deviation of the lag [s] [default: 0, or the scene's]
    #[arg(long, value_name = "s", value_parser = number, allow_hyphen_values = true)]
    pub lag_deviation: Option<f64>,
    /// Delivered over commanded force [default: 1, or the scene's]
    #[arg(long, value_name = "FACTOR", value_parser = number, allow_hyphen_values = true)]
    pub gain: Option<f64>,
    /// Standard deviation of the gain [default: 0, or the scene's]
    #[arg(long, value_name = "FACTOR", value_parser = number, allow_hyphen_values = true)]
    pub gain_deviation: Option<f64>,
    /// Delay as the renderer is told, in periods; simulate and tune only, whose actuator has a delay of
    /// its own [default: the true one, or the scene's]
    #[arg(long, value_name = "PERIODS", value_parser = number, allow_hyphen_values = true)]
    pub told_delay: Option<f64>,
    /// Lag as the renderer is told [s]; simulate and tune only [default: the true one, or the scene's]
    #[arg(long, value_name = "s", value_parser = number, allow_hyphen_values = true)]
    pub told_lag: Option<f64>,
    /// Gain as the renderer is told; simulate and tune only [default: the true one, or the scene's]
    #[arg(long, value_name = "FACTOR", value_parser = number, allow_hyphen_values = true)]
    pub told_gain: Option<f64>,
    /// First resonance of a flexible transmission, with the motor free and nothing held, as the renderer is
    /// told [Hz]; it comes with --resonance-damping-ratio and --flexible-mass-fraction, or with those of a
    /// scene or a device file [default: none, or the scene's]
    #[arg(long, value_name = "Hz", value_parser = number, allow_hyphen_values = true)]
    pub resonance: Option<f64>,
    /// Damping ratio of that resonance as the renderer is told, 0 to 1
    #[arg(long, value_name = "RATIO", value_parser = number, allow_hyphen_values = true)]
    pub resonance_damping_ratio: Option<f64>,
    /// Part of the device's mass beyond the transmission, seen from the motor, as the renderer is told,
    /// 0 to below 1
    #[arg(long, value_name = "FRACTION", value_parser = number, allow_hyphen_values = true)]
    pub flexible_mass_fraction: Option<f64>,
    /// What the renderer is told of the device, as `palpate calibrate` has found it (TOML): mass, delay,
    /// lag and gain with their deviations, the quantum of the sensor, and a flexible transmission; a flag
    /// given beside it counts in its place
    #[arg(long, value_name = "FILE.toml", value_hint = ValueHint::FilePath)]
    pub device_file: Option<PathBuf>,
}
