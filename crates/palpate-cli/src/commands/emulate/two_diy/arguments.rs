//! What an emulated 2DIY is asked for.

use std::path::PathBuf;

use clap::{Args, ValueEnum, ValueHint};
#[cfg(unix)]
use palpate_haply_emulator::two_diy::TimedFault;

use crate::commands::emulate::AmplifierFlags;
use crate::values::{BoardName, number, pair};

/// Arguments of `emulate haply-2diy`.
#[derive(Args, Debug)]
pub struct TwoDiyArguments {
    /// Generation
    #[arg(long, value_name = "1..3", default_value_t = 3,
          value_parser = clap::value_parser!(u8).range(1..=3))]
    pub generation: u8,
    /// Board [default: the one that it came with]
    #[arg(long, value_name = "NAME", value_enum)]
    pub board: Option<BoardName>,
    /// Wait for single bytes that are late; the real boards read 0xFF in their place
    #[arg(long)]
    pub tolerant: bool,
    /// A symbolic link to the port, which stays when the device is plugged in again
    #[arg(long, value_name = "PATH", value_hint = ValueHint::AnyPath)]
    pub link: Option<PathBuf>,
    /// A Unix socket at this path in place of a pseudo-terminal: a busy machine does not delay its bytes
    #[arg(long, value_name = "PATH", value_hint = ValueHint::AnyPath, conflicts_with = "link")]
    pub socket: Option<PathBuf>,
    /// How the motors are wired
    #[arg(long, value_name = "NAME", value_enum, default_value_t = WiringName::AsSold)]
    pub wiring: WiringName,
    /// Angles of the arm at the start [degrees] [default: the start pose]
    #[arg(long, value_name = "A1,A2", value_parser = pair, allow_hyphen_values = true)]
    pub angles: Option<[f64; 2]>,
    /// How long [s] [default: until ctrl-C]
    #[arg(long, value_name = "s", value_parser = number)]
    pub duration: Option<f64>,
    /// Something that goes wrong, and when
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
    /// Packets travel at the beginning of the next USB frame of this length, 0.001 on full-speed USB, 0 to
    /// 0.1; 0: at any time [s]
    #[arg(long, value_name = "s", value_parser = number, default_value = "0")]
    pub usb_frame: f64,
    /// Time that a packet takes each way before it waits for a frame, 0 to 1 [s]
    #[arg(long, value_name = "s", value_parser = number, default_value = "0")]
    pub latency: f64,
}

/// The hand at an emulated device.
#[derive(Args, Debug)]
#[command(next_help_heading = "Hand")]
pub struct HandArguments {
    /// It pushes with this force [N]
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true,
          conflicts_with = "hold")]
    pub push: Option<[f64; 2]>,
    /// It holds the handle at this place, by a spring [m]
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true)]
    pub hold: Option<[f64; 2]>,
    /// The place goes this far to either side [m]
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true,
          requires = "hold")]
    pub sway: Option<[f64; 2]>,
    /// How long that takes there and back [s]
    #[arg(long, value_name = "s", value_parser = number, default_value = "1")]
    pub sway_period: f64,
    /// Stiffness of the spring [N/m]
    #[arg(long, value_name = "N/m", value_parser = number, default_value = "200")]
    pub hand_stiffness: f64,
    /// Damping of the hand [N s/m]
    #[arg(long, value_name = "N s/m", value_parser = number, default_value = "4")]
    pub hand_damping: f64,
}

/// How motors are wired.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum WiringName {
    /// As the generation was sold
    AsSold,
    /// Each motor's cable in the other's port
    Swapped,
    /// Motor 1 the wrong way round
    #[value(name = "reversed-1")]
    Reversed1,
    /// Motor 2 the wrong way round
    #[value(name = "reversed-2")]
    Reversed2,
    /// Motor 1 does nothing
    #[value(name = "dead-1")]
    Dead1,
    /// Motor 2 does nothing
    #[value(name = "dead-2")]
    Dead2,
}
