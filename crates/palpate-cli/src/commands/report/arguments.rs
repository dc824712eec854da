//! Arguments of `report`.

use std::path::PathBuf;

use clap::parser::ValueSource;
use clap::{ArgMatches, Args, Command, Error, FromArgMatches, ValueHint};

use crate::arguments::Overwriting;
use crate::commands::run::{RealtimeArguments, SafetyArguments};
use crate::devices::DeviceArguments;
use crate::values::{Methods, methods, number, period};

/// Arguments of `report`.
#[derive(Args, Debug)]
pub struct ReportArguments {
    /// Recordings of the device (MCAP), at most 3; the contact is that of the first one
    #[arg(value_name = "RECORDING.mcap", value_hint = ValueHint::FilePath, num_args = 0..)]
    pub recordings: Vec<PathBuf>,
    /// Device file (TOML), as `palpate calibrate` writes it; a session uses its values as model values
    #[arg(long, value_name = "FILE.toml", value_hint = ValueHint::FilePath, help_heading = "Sources")]
    pub device_file: Option<PathBuf>,
    /// Report of the calibration (JSON), as `palpate calibrate --report` writes it: the page shows the measured and the
    /// fitted motion
    #[arg(long, value_name = "FILE.json", value_hint = ValueHint::FilePath, requires = "device_file",
          help_heading = "Sources")]
    pub calibration: Option<PathBuf>,
    /// Name of the device [default: that of the recording]
    #[arg(long, value_name = "TEXT", help_heading = "Sources")]
    pub name: Option<String>,
    /// Desired stiffness, also that of a session's wall [N/m] [default: the recording's, or 1000; in a session 300]
    #[arg(long, value_name = "N/m", value_parser = number, help_heading = "Renderable contacts")]
    pub stiffness: Option<f64>,
    /// Period of the loop [s] [default: the recording's, or the device file's; in a session 0.001]
    #[arg(long, value_name = "s", value_parser = period, help_heading = "Renderable contacts")]
    pub period: Option<f64>,
    /// Methods to compare, separated by commas, or all [default: basic,virtual-damper,hfcr,coupled]
    #[arg(long, value_name = "NAME", value_parser = methods, help_heading = "Renderable contacts")]
    pub method: Option<Methods>,
    /// The device of a session.
    #[command(flatten)]
    pub device: SessionDevice,
    /// Scene of the session (TOML) [default: a wall of 300 N/m at 0, by coupled rendering]
    #[arg(long, value_name = "SCENE.toml", value_hint = ValueHint::FilePath, help_heading = "Session")]
    pub scene: Option<PathBuf>,
    /// Duration of the session [s]
    #[arg(long, value_name = "s", default_value = "5", value_parser = number, help_heading = "Session")]
    pub duration: f64,
    /// Do not wait in real time, on a device without a motor
    #[arg(long, help_heading = "Session")]
    pub fast: bool,
    /// Recording of the session (MCAP) [default: the page's name with .mcap]
    #[arg(long, value_name = "REC.mcap", value_hint = ValueHint::FilePath, help_heading = "Session")]
    pub record: Option<PathBuf>,
    /// Requests to the machine.
    #[command(flatten)]
    pub realtime: RealtimeArguments,
    /// Limits between renderer and device.
    #[command(flatten)]
    pub safety: SafetyArguments,
    /// Write the page (HTML)
    #[arg(long, value_name = "PAGE.html", value_hint = ValueHint::FilePath, help_heading = "Results")]
    pub out: Option<PathBuf>,
    /// Print the report as JSON
    #[arg(long, help_heading = "Results")]
    pub json: bool,
    /// Overwriting of existing files.
    #[command(flatten)]
    pub overwriting: Overwriting,
}

/// Device of a session. `is_named` is whether `--device` is given, and thus whether there is a session.
#[derive(Debug, Clone)]
pub struct SessionDevice {
    /// The device, and the contact's axis in its frame.
    pub arguments: DeviceArguments,
    /// Whether the command line names it.
    pub is_named: bool,
}

impl FromArgMatches for SessionDevice {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        Ok(Self {
            arguments: DeviceArguments::from_arg_matches(matches)?,
            // The default does not count as a name.
            is_named: matches.value_source("device") == Some(ValueSource::CommandLine),
        })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for SessionDevice {
    fn augment_args(command: Command) -> Command {
        DeviceArguments::augment_args(command)
    }

    fn augment_args_for_update(command: Command) -> Command {
        DeviceArguments::augment_args_for_update(command)
    }
}
