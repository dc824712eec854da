//! Arguments of an emulated 2DIY.

use std::path::PathBuf;

use clap::{Args, ValueEnum, ValueHint};
#[cfg(unix)]
use palpate_drivers::emulator::two_diy::TimedFault;

use crate::commands::devices::emulate::AmplifierFlags;
use crate::values::{BoardName, number, pair};

/// Arguments of `devices emulate haply-2diy`.
#[derive(Args, Debug)]
pub struct TwoDiyArguments {
    /// Generation
    #[arg(long, value_name = "1..3", default_value_t = 3,
          value_parser = clap::value_parser!(u8).range(1..=3))]
    pub generation: u8,
    /// Board [default: that of the generation]
    #[arg(long, value_name = "NAME", value_enum)]
    pub board: Option<BoardName>,
    /// Wait for late bytes; the real boards read 0xFF instead
    #[arg(long)]
    pub tolerant: bool,
    /// A symbolic link to the port, which stays valid when the device is plugged in again
    #[arg(long, value_name = "PATH", value_hint = ValueHint::AnyPath)]
    pub link: Option<PathBuf>,
    /// Path of a Unix socket instead of a pseudo-terminal: a busy machine does not delay its bytes
    #[arg(long, value_name = "PATH", value_hint = ValueHint::AnyPath, conflicts_with = "link")]
    pub socket: Option<PathBuf>,
    /// Wiring of the motors
    #[arg(long, value_name = "NAME", value_enum, default_value_t = WiringName::AsSold)]
    pub wiring: WiringName,
    /// Angles of the arm at the start [degrees] [default: the start pose]
    #[arg(long, value_name = "A1,A2", value_parser = pair, allow_hyphen_values = true)]
    pub angles: Option<[f64; 2]>,
    /// Duration [s] [default: until ctrl-C]
    #[arg(long, value_name = "s", value_parser = number)]
    pub duration: Option<f64>,
    /// Fault to inject, with its time
    #[cfg(unix)]
    #[arg(long, value_name = "KIND[=VALUE]@s", value_parser = str::parse::<TimedFault>)]
    pub fault: Vec<TimedFault>,
    /// The line to the board.
    #[command(flatten)]
    pub usb: UsbFlags,
    /// The amplifiers.
    #[command(flatten)]
    pub amplifier: AmplifierFlags,
    /// The hand.
    #[command(flatten)]
    pub hand: HandArguments,
}

/// The line to an emulated board.
#[derive(Args, Debug, Clone, Copy)]
#[command(next_help_heading = "USB")]
pub struct UsbFlags {
    /// Length of a USB frame: packets travel at the beginning of the next frame; 0.001 on full-speed USB, 0 to 0.1; 0:
    /// at any time [s]
    #[arg(long, value_name = "s", value_parser = number, default_value = "0")]
    pub usb_frame: f64,
    /// Travel time of a packet each way before it waits for a frame, 0 to 1 [s]
    #[arg(long, value_name = "s", value_parser = number, default_value = "0")]
    pub latency: f64,
}

/// The hand at an emulated device.
#[derive(Args, Debug)]
#[command(next_help_heading = "Hand")]
pub struct HandArguments {
    /// Force of the hand [N]
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true,
          conflicts_with = "hold")]
    pub push: Option<[f64; 2]>,
    /// Position at which a spring holds the handle [m]
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true)]
    pub hold: Option<[f64; 2]>,
    /// Amplitude of the motion of that position, with `--hold` only [m]
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true,
          requires = "hold")]
    pub sway: Option<[f64; 2]>,
    /// Period of that motion [s]
    #[arg(long, value_name = "s", value_parser = number, default_value = "1", requires = "sway")]
    pub sway_period: f64,
    /// Stiffness of the spring [N/m]
    #[arg(long, value_name = "N/m", value_parser = number, default_value = "200",
          requires = "hold")]
    pub hand_stiffness: f64,
    /// Damping of the hand [N s/m]
    #[arg(long, value_name = "N s/m", value_parser = number, default_value = "4",
          requires = "hold")]
    pub hand_damping: f64,
}

/// Wirings of the motors.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum WiringName {
    /// As the generation was sold
    AsSold,
    /// Each motor's cable in the other's port
    Swapped,
    /// Motor 1 reversed
    #[value(name = "reversed-1")]
    Reversed1,
    /// Motor 2 reversed
    #[value(name = "reversed-2")]
    Reversed2,
    /// Motor 1 without effect
    #[value(name = "dead-1")]
    Dead1,
    /// Motor 2 without effect
    #[value(name = "dead-2")]
    Dead2,
}
