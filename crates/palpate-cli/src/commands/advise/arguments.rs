//! Arguments of `advise`.

use std::convert::Infallible;
use std::path::PathBuf;

use clap::{Args, ValueHint};

use crate::arguments::{Overwriting, PlotFlags};
use crate::values::{Methods, lag, methods, number, period, periods};

/// Arguments of `advise`.
#[derive(Args, Debug)]
pub struct AdviseArguments {
    /// A scene, which is refused
    #[arg(value_name = "SCENE.toml", value_parser = no_scene, hide = true)]
    pub refused: Option<Infallible>,
    /// Effective mass of the device [kg] [default: that of --device-file]
    #[arg(long, value_name = "kg", value_parser = number, allow_hyphen_values = true,
          required_unless_present = "device_file", help_heading = "Device")]
    pub device_mass: Option<f64>,
    /// Period T of the loop [s]
    #[arg(long, value_name = "s", value_parser = period, allow_hyphen_values = true,
          help_heading = "Device")]
    pub period: f64,
    /// Quantum of the device's position sensor [m] [default: that of --device-file, or 0]
    #[arg(long, value_name = "m", value_parser = number, allow_hyphen_values = true,
          help_heading = "Device")]
    pub encoder_quantum: Option<f64>,
    /// Viscous friction b of the device [N s/m]
    #[arg(long, value_name = "N s/m", value_parser = number, default_value_t = 0.0,
          allow_hyphen_values = true, help_heading = "Device")]
    pub viscous_friction: f64,
    /// Coulomb friction f_c of the device [N]
    #[arg(long, value_name = "N", value_parser = number, default_value_t = 0.0,
          allow_hyphen_values = true, help_heading = "Device")]
    pub coulomb_friction: f64,
    /// Time from a sample to the beginning of its force [s] [default: that of --device-file, or 0]
    #[arg(long, value_name = "s", value_parser = number, allow_hyphen_values = true,
          conflicts_with = "delay_periods", help_heading = "Device")]
    pub delay: Option<f64>,
    /// The same in periods; may be fractional
    #[arg(long, value_name = "PERIODS", value_parser = periods, help_heading = "Device")]
    pub delay_periods: Option<f64>,
    /// Time constant of the actuator, a first-order lag after the delay; the renderer models both [s] [default: that of
    /// --device-file, or 0]
    #[arg(long, value_name = "s", value_parser = lag, allow_hyphen_values = true, help_heading = "Device")]
    pub lag: Option<f64>,
    /// Standard deviation of the delay, including its changes from command to command, at most 8 periods [s] [default:
    /// that of --device-file, or 0]
    #[arg(long, value_name = "s", value_parser = number, allow_hyphen_values = true,
          help_heading = "Device")]
    pub delay_deviation: Option<f64>,
    /// Standard deviation of the lag, at most 8 periods [s] [default: that of --device-file, or 0]
    #[arg(long, value_name = "s", value_parser = number, allow_hyphen_values = true,
          help_heading = "Device")]
    pub lag_deviation: Option<f64>,
    /// First resonance of a flexible transmission; stiffer contacts are not recommended [Hz] [default: that of
    /// --device-file, or none]
    #[arg(long, value_name = "Hz", value_parser = number, allow_hyphen_values = true,
          help_heading = "Device")]
    pub resonance: Option<f64>,
    /// Fraction of the device's mass beyond the transmission, seen from the motor, 0 to below 1 [default: that of
    /// --device-file, or 0]
    #[arg(long, value_name = "FRACTION", value_parser = number, allow_hyphen_values = true,
          help_heading = "Device")]
    pub flexible_mass_fraction: Option<f64>,
    /// A device file of `palpate calibrate` (TOML): mass, delay, lag and quantum, with the deviations that the renderer
    /// takes into account, and the resonance, which limits the recommended stiffness
    #[arg(long, value_name = "FILE.toml", value_hint = ValueHint::FilePath, help_heading = "Device")]
    pub device_file: Option<PathBuf>,
    /// Desired contact stiffness K [N/m]
    #[arg(long, value_name = "N/m", value_parser = number, allow_hyphen_values = true,
          help_heading = "Contact")]
    pub stiffness: Option<f64>,
    /// Desired object mass M [kg]; inf is a wall [default: inf]
    #[arg(long, value_name = "kg|inf", value_parser = number, allow_hyphen_values = true,
          help_heading = "Contact")]
    pub mass: Option<f64>,
    /// Methods, separated by commas, or all
    #[arg(long, value_name = "NAME", value_parser = methods, default_value = "all")]
    pub method: Methods,
    /// The figure: largest stiffness over the object's mass, for the named methods; for more than four, of basic,
    /// virtual-damper, hfcr and coupled.
    #[command(flatten)]
    pub picture: PlotFlags,
    /// Overwriting of existing files.
    #[command(flatten)]
    pub overwriting: Overwriting,
    /// Print the advice as JSON
    #[arg(long, help_heading = "Results")]
    pub json: bool,
}

fn no_scene(_: &str) -> Result<Infallible, String> {
    Err("advise takes the numbers of one device and one contact; for methods on a scene: palpate compare SCENE.toml".into())
}
