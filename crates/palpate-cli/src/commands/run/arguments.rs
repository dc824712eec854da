//! Arguments of the commands that run a loop.

use std::path::PathBuf;

use clap::{Args, ValueHint};

use crate::arguments::{Flags, Given};
use crate::devices::DeviceArguments;
use crate::values::{number, range, whole};

/// Arguments of `run`.
#[derive(Args, Debug)]
pub struct RunArguments {
    /// Scene file (TOML): contact, loop, method, and the device and hand that are simulated; or a world
    #[arg(value_name = "SCENE.toml", value_hint = ValueHint::FilePath)]
    pub scene: PathBuf,
    /// Write a recording (MCAP); a file that is there is not overwritten
    #[arg(long, value_name = "REC.mcap", value_hint = ValueHint::FilePath)]
    pub record: Option<PathBuf>,
    /// What is run, and on what.
    #[command(flatten)]
    pub session: SessionArguments,
}

/// Arguments of `record`.
#[derive(Args, Debug)]
pub struct RecordArguments {
    /// Scene file (TOML): contact, loop, method, and the device and hand that are simulated; or a world
    #[arg(value_name = "SCENE.toml", value_hint = ValueHint::FilePath)]
    pub scene: PathBuf,
    /// Recording to write (MCAP); a file that is there is not overwritten
    #[arg(value_name = "REC.mcap", value_hint = ValueHint::FilePath)]
    pub record: PathBuf,
    /// What is run, and on what.
    #[command(flatten)]
    pub session: SessionArguments,
}

/// What is run, and on what.
#[derive(Args, Debug)]
pub struct SessionArguments {
    /// What stands on the command line; first, since whatever is read from it is gone for those behind.
    #[command(flatten)]
    pub given: Given,
    /// How long [s], deadlines that were missed included; inf: until ctrl-C, which ends it at any time
    #[arg(long, value_name = "s", default_value = "10", value_parser = number)]
    pub duration: f64,
    /// Do not wait for the time to pass: every tick follows the one before at once
    #[arg(long)]
    pub fast: bool,
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
    /// The device.
    #[command(flatten)]
    pub device: DeviceArguments,
    /// What the machine is asked for.
    #[command(flatten)]
    pub realtime: RealtimeArguments,
    /// Limits between renderer and device.
    #[command(flatten)]
    pub safety: SafetyArguments,
    /// Contact, loop, method and device.
    #[command(flatten)]
    pub flags: Flags,
}

/// What the machine is asked for.
#[derive(Args, Debug, Clone)]
#[command(next_help_heading = "Real time")]
pub struct RealtimeArguments {
    /// Priority under SCHED_FIFO, 1 to 98; 0: do not ask for one. The supervisor has one more
    #[arg(long, value_name = "1..98", default_value_t = 80,
          value_parser = clap::value_parser!(u8).range(0..=98))]
    pub priority: u8,
    /// Processor to run on
    #[arg(long, value_name = "NUMBER", value_parser = whole::<usize>)]
    pub processor: Option<usize>,
    /// Stay awake for the last stretch before each deadline [s]
    #[arg(long, value_name = "s", default_value = "0", value_parser = number)]
    pub spin: f64,
}

/// Limits between renderer and device.
#[derive(Args, Debug, Clone)]
#[command(next_help_heading = "Safety")]
pub struct SafetyArguments {
    /// Largest force on the device [N]: of the command, and of the command times --gain [default: 20, or that of the device]
    #[arg(long, value_name = "N", value_parser = number)]
    pub safe_force: Option<f64>,
    /// Largest change of the force [N/s] [default: none]
    #[arg(long, value_name = "N/s", value_parser = number)]
    pub safe_slew: Option<f64>,
    /// Largest speed of the device [m/s] [default: 5]
    #[arg(long, value_name = "m/s", value_parser = number)]
    pub safe_speed: Option<f64>,
    /// Where the device may be along the contact's axis [m] [default: anywhere]
    #[arg(long, value_name = "FROM,TO", value_parser = range, allow_hyphen_values = true)]
    pub safe_range: Option<(f64, f64)>,
    /// Time over which a force comes in that a start or a recovery finds on [s] [default: 0.2]
    #[arg(long, value_name = "s", value_parser = number)]
    pub soft_start: Option<f64>,
    /// Energy created within a fifth of a second that counts as oscillation [J]; inf: none does
    /// [default: 0.05]
    #[arg(long, value_name = "J", value_parser = number)]
    pub oscillation: Option<f64>,
    /// Periods from one tick to the next after which a supervisor, or a guardian, commands no force
    /// [default: 1.5, or what a period and 3 ms are if that is more: wake-ups are late by up to 3 ms]
    #[arg(long, value_name = "PERIODS", value_parser = number)]
    pub stall_after: Option<f64>,
}
