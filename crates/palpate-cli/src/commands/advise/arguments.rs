//! Arguments of `advise`.

use clap::Args;

use crate::arguments::{Overwriting, PlotFlags};
use crate::values::{Methods, methods, number, samples};

/// Arguments of `advise`.
#[derive(Args, Debug)]
pub struct AdviseArguments {
    /// Effective mass of the device [kg]
    #[arg(long, value_name = "kg", value_parser = number, allow_hyphen_values = true,
          help_heading = "Device")]
    pub device_mass: f64,
    /// Period T of the loop [s]
    #[arg(long, value_name = "s", value_parser = number, allow_hyphen_values = true,
          help_heading = "Device")]
    pub period: f64,
    /// Quantum of the device's position sensor [m]
    #[arg(long, value_name = "m", value_parser = number, default_value_t = 0.0,
          allow_hyphen_values = true, help_heading = "Device")]
    pub encoder_quantum: f64,
    /// Viscous friction b of the device [N s/m]
    #[arg(long, value_name = "N s/m", value_parser = number, default_value_t = 0.0,
          allow_hyphen_values = true, help_heading = "Device")]
    pub viscous_friction: f64,
    /// Coulomb friction f_c of the device [N]
    #[arg(long, value_name = "N", value_parser = number, default_value_t = 0.0,
          allow_hyphen_values = true, help_heading = "Device")]
    pub coulomb_friction: f64,
    /// Samples between measuring and actuating
    #[arg(long, value_name = "SAMPLES", value_parser = samples, default_value = "0",
          help_heading = "Device")]
    pub delay: usize,
    /// Contact stiffness K you would like [N/m]
    #[arg(long, value_name = "N/m", value_parser = number, allow_hyphen_values = true,
          help_heading = "Contact")]
    pub stiffness: Option<f64>,
    /// Object mass M you would like [kg]; inf is a wall [default: inf]
    #[arg(long, value_name = "kg|inf", value_parser = number, allow_hyphen_values = true,
          help_heading = "Contact")]
    pub mass: Option<f64>,
    /// Methods, separated by commas, or all
    #[arg(long, value_name = "NAME", value_parser = methods, default_value = "all")]
    pub method: Methods,
    /// The figure: how stiff over the object's mass, for the methods that are named; of more than four,
    /// for basic, virtual-damper, hfcr and coupled.
    #[command(flatten)]
    pub picture: PlotFlags,
    /// Files that are there already.
    #[command(flatten)]
    pub overwriting: Overwriting,
    /// Print the advice as JSON
    #[arg(long, help_heading = "Results")]
    pub json: bool,
}
