//! `palpate devices emulate moteus` and `odrive`: an emulated motor drive.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::{Args, ValueHint};
use palpate_drivers::emulator::drive::{Emulator, Maker, Settings, TimedFault};
use palpate_drivers::emulator::port::PortSettings;
use palpate_rt::StopFlag;
use palpate_testbed::hand::{Hand, Intention, Sinusoid};

use super::AmplifierFlags;
use crate::failure::{Failure, tell};
use crate::results::print;
use crate::values::{duration, number};

/// Arguments of `devices emulate moteus` and `odrive`.
#[derive(Args, Debug)]
pub struct MotorDriveArguments {
    /// A symbolic link to the port
    #[arg(long, value_name = "PATH", value_hint = ValueHint::AnyPath)]
    pub link: Option<PathBuf>,
    /// Path of a Unix socket instead of a pseudo-terminal: a busy machine does not delay its bytes
    #[arg(long, value_name = "PATH", value_hint = ValueHint::AnyPath, conflicts_with = "link")]
    pub socket: Option<PathBuf>,
    /// Number of the drive, or of its axis [default: 1 for moteus, 0 for odrive]
    #[arg(long, value_name = "NUMBER")]
    pub id: Option<u8>,
    /// Radius of the pulley or lever [m]
    #[arg(long, value_name = "m", value_parser = number, default_value = "0.02")]
    pub radius: f64,
    /// Moved mass at the handle [kg]
    #[arg(long, value_name = "kg", value_parser = number, default_value = "0.1")]
    pub mass: f64,
    /// Start position of the handle [m]
    #[arg(long, value_name = "m", value_parser = number, allow_hyphen_values = true,
          default_value = "0")]
    pub start: f64,
    /// Duration [s] [default: until ctrl-C]
    #[arg(long, value_name = "s", value_parser = number)]
    pub duration: Option<f64>,
    /// Fault to inject, with its time
    #[arg(long, value_name = "KIND[=VALUE]@s", value_parser = str::parse::<TimedFault>)]
    pub fault: Vec<TimedFault>,
    /// The amplifier.
    #[command(flatten)]
    pub amplifier: AmplifierFlags,
    /// The hand.
    #[command(flatten)]
    pub hand: HandArguments,
}

/// The hand at an emulated device with one axis.
#[derive(Args, Debug)]
#[command(next_help_heading = "Hand")]
pub struct HandArguments {
    /// Position at which a spring holds the handle [m] [default: the start position]
    #[arg(long, value_name = "m", value_parser = number, allow_hyphen_values = true)]
    pub hold: Option<f64>,
    /// Amplitude of the motion of that position [m]
    #[arg(long, value_name = "m", value_parser = number, default_value = "0")]
    pub sway: f64,
    /// Period of that motion [s]
    #[arg(long, value_name = "s", value_parser = number, default_value = "1")]
    pub sway_period: f64,
    /// Stiffness of the spring [N/m]
    #[arg(long, value_name = "N/m", value_parser = number, default_value = "200")]
    pub hand_stiffness: f64,
    /// Damping of the hand [N s/m]
    #[arg(long, value_name = "N s/m", value_parser = number, default_value = "4")]
    pub hand_damping: f64,
}

impl HandArguments {
    /// Returns the hand at a handle that starts at `start` `[m]`.
    fn hand(&self, start: f64) -> Result<Hand, Failure> {
        if !(self.sway_period > 0.0 && self.sway_period.is_finite()) {
            return Err(Failure::Arguments(format!(
                "--sway-period is {}; allowed: above 0 [s]",
                self.sway_period
            )));
        }
        Ok(Hand::Impedance {
            mass: 0.0,
            stiffness: self.hand_stiffness,
            damping: self.hand_damping,
            intention: Intention {
                tremor: (self.sway != 0.0).then_some(Sinusoid {
                    amplitude: self.sway,
                    frequency_hz: 1.0 / self.sway_period,
                    phase: 0.0,
                }),
                ..Intention::constant(self.hold.unwrap_or(start))
            },
            force: 0.0,
            tremor: None,
        })
    }
}

/// Interval at which due faults are injected and the watchdog is polled.
const LOOK: Duration = Duration::from_millis(5);

/// Emulates until the end.
pub fn run(maker: Maker, arguments: &MotorDriveArguments) -> Result<(), Failure> {
    let until = arguments
        .duration
        .filter(|seconds| *seconds != f64::INFINITY)
        .map(|seconds| duration("--duration", seconds))
        .transpose()?;
    let radius = arguments.radius;
    super::within("--radius", radius, [1e-4, 1.0], "0.0001 to 1 [m]")?;
    let usual = Settings::new(maker);
    let settings = Settings {
        number: arguments.id.unwrap_or(usual.number),
        travel: std::f64::consts::TAU * radius,
        mass: arguments.mass,
        start: arguments.start,
        hand: arguments.hand.hand(arguments.start)?,
        amplifier: arguments.amplifier.params()?,
        port: match &arguments.socket {
            Some(path) => PortSettings::Socket { path: path.clone() },
            None => PortSettings::Terminal {
                link: arguments.link.clone(),
            },
        },
        ..usual
    };
    let stop = StopFlag::on_signals()
        .map_err(|error| Failure::System(format!("cannot handle signals: {error}")))?;
    let emulator = Emulator::start(&settings)
        .map_err(|error| Failure::System(format!("cannot start the emulator: {error}")))?;
    let begun = Instant::now();
    print(&format!("{}\n", emulator.path().display()))?;
    tell(format_args!(
        "number {}, radius {radius} m; ctrl-C ends it",
        settings.number
    ));
    let mut faults = arguments.fault.clone();
    let mut largest = 0.0_f64;
    let mut was_cut = false;
    while !stop.is_raised() && until.is_none_or(|until| begun.elapsed() < until) {
        faults.retain(|timed| {
            let is_due = timed.at <= begun.elapsed();
            if is_due {
                tell(format_args!(
                    "at {} s: {}",
                    timed.at.as_secs_f64(),
                    timed.fault
                ));
                emulator.inject(timed.fault);
            }
            !is_due
        });
        largest = largest.max(emulator.torque().abs());
        if emulator.was_cut() != was_cut {
            was_cut = true;
            tell("the drive's watchdog took the torque off");
        }
        std::thread::sleep(LOOK);
    }
    tell(format_args!(
        "{} lines, torques up to {largest:.4} N m; in the end {:.4} N m",
        emulator.lines(),
        emulator.torque()
    ));
    Ok(())
}
