//! Arguments of `calibrate`.

use std::path::PathBuf;
use std::time::Duration;

use clap::{ArgGroup, Args, ValueHint};
use palpate_study::calibrate::ExcitationParams;

use crate::arguments::{Overwriting, PlotFlags};
use crate::commands::run::RealtimeArguments;
use crate::devices::{DeviceArguments, DeviceName};
use crate::failure::Failure;
use crate::values::{duration, number, whole};

/// Time for moving a 2DIY from its start pose to the calibration position `[s]`.
const USUAL_WAIT: f64 = 3.0;
const LONGEST_WAIT: f64 = 60.0;

/// Arguments of `calibrate`.
#[derive(Args, Debug)]
#[command(group(ArgGroup::new("calibrated").required(true).args(["pipe", "device"])))]
pub struct CalibrateArguments {
    /// Positions arrive on standard input and forces leave on standard output, line by line
    #[arg(long, conflicts_with = "device")]
    pub pipe: bool,
    /// Each line is a time and a position, `t_s,position_m`; without it a line is a position
    #[arg(long, requires = "pipe")]
    pub time: bool,
    /// Period of the loop [s]
    #[arg(long, value_name = "s", value_parser = number, default_value = "0.001")]
    pub period: f64,
    /// Limits of the excitation.
    #[command(flatten)]
    pub excitation: ExcitationFlags,
    /// Known values besides the motion.
    #[command(flatten)]
    pub model: KnownFlags,
    /// The device, and the axis that is calibrated.
    #[command(flatten)]
    pub device: DeviceArguments,
    /// Scene file (TOML) with the device and the hand of --device simulated
    #[arg(long, value_name = "SCENE.toml", value_hint = ValueHint::FilePath, conflicts_with = "pipe")]
    pub scene: Option<PathBuf>,
    /// Time for moving the device to its calibration position, 0 to 60; then the force begins once the device has been
    /// still for 0.5 s [s] [default: 3 for haply-2diy, whose arm is opened in its start pose; other devices are already
    /// there]
    #[arg(long, value_name = "s", value_parser = number, conflicts_with = "pipe")]
    pub wait: Option<f64>,
    /// Do not wait in real time, on a device without a motor
    #[arg(long, conflicts_with = "pipe")]
    pub fast: bool,
    /// Requests to the machine.
    #[command(flatten)]
    pub realtime: RealtimeArguments,
    /// Output of the results.
    #[command(flatten)]
    pub results: CalibrateResults,
}

/// Limits of the excitation.
#[derive(Args, Debug, Clone, Copy)]
#[command(next_help_heading = "Excitation")]
pub struct ExcitationFlags {
    /// Largest force on the device [N]
    #[arg(long, value_name = "N", value_parser = number, default_value = "0.5")]
    pub largest_force: f64,
    /// Duration, 2 to 120 [s]; the first 0.5 s are without force
    #[arg(long, value_name = "s", value_parser = number, default_value = "8")]
    pub seconds: f64,
    /// Largest distance from the start position [m]; beyond it the force is 0 and the command ends
    #[arg(long = "box", value_name = "m", value_parser = number, default_value = "0.01")]
    pub excursion: f64,
    /// Largest tremor of the hand, root mean square, before the force begins [m]
    #[arg(long, value_name = "m", value_parser = number, default_value = "0.001")]
    pub tremor: f64,
    /// Seed of the random force steps
    #[arg(long, value_name = "NUMBER", default_value_t = 1, value_parser = whole::<u64>)]
    pub seed: u64,
}

/// Known values besides the motion.
#[derive(Args, Debug, Clone, Default)]
#[command(next_help_heading = "Known values")]
pub struct KnownFlags {
    /// Delivered over commanded force of the motor, if measured
    #[arg(long, value_name = "RATIO", value_parser = number, conflicts_with_all = ["spring", "added_mass"])]
    pub gain: Option<f64>,
    /// Stiffness of a spring that the device is fixed to, without a hand [N/m]: determines the gain
    #[arg(long, value_name = "N/m", value_parser = number, conflicts_with = "added_mass")]
    pub spring: Option<f64>,
    /// Mass fixed to the device after the calibration of --before, without a hand [kg]: determines the gain
    #[arg(long, value_name = "kg", value_parser = number, requires = "before")]
    pub added_mass: Option<f64>,
    /// Device file of the same device without that mass
    #[arg(long, value_name = "DEVICE.toml", value_hint = ValueHint::FilePath, requires = "added_mass")]
    pub before: Option<PathBuf>,
}

/// Output of the results.
#[derive(Args, Debug)]
pub struct CalibrateResults {
    /// Write the device file (TOML)
    #[arg(long, value_name = "DEVICE.toml", value_hint = ValueHint::FilePath, help_heading = "Results")]
    pub out: Option<PathBuf>,
    /// Print the report as JSON
    #[arg(long, help_heading = "Results")]
    pub json: bool,
    /// Write the report (JSON) with a part of the motion and its fit, for `palpate report --calibration`
    #[arg(long, value_name = "FILE.json", value_hint = ValueHint::FilePath, help_heading = "Results")]
    pub report: Option<PathBuf>,
    /// The figure: measured against fitted.
    #[command(flatten)]
    pub picture: PlotFlags,
    /// Overwriting of existing files.
    #[command(flatten)]
    pub overwriting: Overwriting,
}

impl CalibrateArguments {
    /// Returns the time for moving the device to its calibration position, or `None` if it is already there.
    pub fn wait(&self) -> Result<Option<Duration>, Failure> {
        let usual = (self.device.kind() == DeviceName::Haply2diy).then_some(USUAL_WAIT);
        let Some(wait) = self.wait.or(usual) else {
            return Ok(None);
        };
        if !(0.0..=LONGEST_WAIT).contains(&wait) {
            return Err(Failure::Arguments(format!(
                "--wait is {wait}; allowed: 0 to {LONGEST_WAIT} [s]"
            )));
        }
        duration("--wait", wait).map(Some)
    }

    /// Returns the parameters of the excitation.
    pub fn params(&self) -> ExcitationParams {
        let flags = &self.excitation;
        ExcitationParams {
            period: self.period,
            largest_force: flags.largest_force,
            duration: flags.seconds,
            excursion: flags.excursion,
            tremor: flags.tremor,
            seed: flags.seed,
        }
    }
}

impl KnownFlags {
    /// Rejects values out of range.
    pub fn check(&self) -> Result<(), Failure> {
        for (flag, value) in [
            ("--gain", self.gain),
            ("--spring", self.spring),
            ("--added-mass", self.added_mass),
        ] {
            if let Some(value) = value
                && !(value > 0.0 && value.is_finite())
            {
                return Err(Failure::Arguments(format!(
                    "{flag} is {value}, but must be a finite number above 0"
                )));
            }
        }
        Ok(())
    }
}
