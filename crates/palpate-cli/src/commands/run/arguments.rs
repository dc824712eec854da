//! Arguments of the commands that run a loop.

use std::path::PathBuf;

use clap::{Args, ValueHint};

use crate::arguments::{Flags, Given};
use crate::devices::DeviceArguments;
use crate::values::{number, range, whole};

/// Arguments of `run`.
#[derive(Args, Debug)]
pub struct RunArguments {
    /// Scene file (TOML): contact, loop, method, and the simulated device and hand; or a world
    #[arg(value_name = "SCENE.toml", value_hint = ValueHint::FilePath)]
    pub scene: PathBuf,
    /// Write every tick to a recording (MCAP); an existing file is not overwritten
    #[arg(long, value_name = "REC.mcap", value_hint = ValueHint::FilePath)]
    pub record: Option<PathBuf>,
    /// Loop and device.
    #[command(flatten)]
    pub session: SessionArguments,
}

/// Loop and device of a session.
#[derive(Args, Debug)]
pub struct SessionArguments {
    /// Flags on the command line. First field, because clap removes values in the order of the fields.
    #[command(flatten)]
    pub given: Given,
    /// Duration [s], including missed deadlines; inf: until ctrl-C, which ends it at any time
    #[arg(long, value_name = "s", default_value = "10", value_parser = number)]
    pub duration: f64,
    /// Do not wait in real time: every tick follows the previous one at once
    #[arg(long)]
    pub fast: bool,
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
    /// The device.
    #[command(flatten)]
    pub device: DeviceArguments,
    /// Requests to the machine.
    #[command(flatten)]
    pub realtime: RealtimeArguments,
    /// Limits between renderer and device.
    #[command(flatten)]
    pub safety: SafetyArguments,
    /// Contact, loop, method and device.
    #[command(flatten)]
    pub flags: Flags,
}

/// Requests to the machine.
#[derive(Args, Debug, Clone)]
#[command(next_help_heading = "Real time")]
pub struct RealtimeArguments {
    /// Priority under SCHED_FIFO, 1 to 98; 0: none. The supervisor has one more
    #[arg(long, value_name = "1..98", default_value_t = 80,
          value_parser = clap::value_parser!(u8).range(0..=98))]
    pub priority: u8,
    /// Processor to run on
    #[arg(long, value_name = "NUMBER", value_parser = whole::<usize>)]
    pub processor: Option<usize>,
    /// Busy-wait for this long before each deadline [s]
    #[arg(long, value_name = "s", default_value = "0", value_parser = number)]
    pub spin: f64,
}

/// Limits between renderer and device.
#[derive(Args, Debug, Clone)]
#[command(next_help_heading = "Safety")]
pub struct SafetyArguments {
    /// Largest force on the device [N]: of the command, and of the command times --gain [default: 20, or that of the
    /// device]
    #[arg(long, value_name = "N", value_parser = number)]
    pub safe_force: Option<f64>,
    /// Largest change of the force [N/s] [default: none]
    #[arg(long, value_name = "N/s", value_parser = number)]
    pub safe_slew: Option<f64>,
    /// Largest speed of the device [m/s] [default: 5]
    #[arg(long, value_name = "m/s", value_parser = number)]
    pub safe_speed: Option<f64>,
    /// Allowed range of the device along the contact's axis [m] [default: unlimited]
    #[arg(long, value_name = "FROM,TO", value_parser = range, allow_hyphen_values = true)]
    pub safe_range: Option<(f64, f64)>,
    /// Duration of the soft start if a start or a recovery finds a force [s] [default: 0.2]
    #[arg(long, value_name = "s", value_parser = number)]
    pub soft_start: Option<f64>,
    /// Energy generated within a fifth of a second that counts as oscillation [J]; inf: never [default: 0.05]
    #[arg(long, value_name = "J", value_parser = number)]
    pub oscillation: Option<f64>,
    /// Periods from one tick to the next after which the supervisor or the watchdog process disables the force
    /// [default: 1.5, or a period plus 3 ms if that is more: wake-ups are late by up to 3 ms]
    #[arg(long, value_name = "PERIODS", value_parser = number)]
    pub stall_after_periods: Option<f64>,
}
