//! `palpate devices emulate`: emulated devices.

#[cfg(unix)]
mod force_dimension;
mod inverse3;
#[cfg(unix)]
mod motor_drive;
mod two_diy;

use clap::{Args, Subcommand};
#[cfg(unix)]
use palpate_drivers::emulator::drive::Maker;
use palpate_testbed::actuator::ActuatorParams;

use crate::failure::Failure;
use crate::values::number;

/// Arguments of `devices emulate`.
#[derive(Args, Debug)]
pub struct EmulateArguments {
    /// The device to emulate.
    #[command(subcommand)]
    pub what: What,
}

/// Emulated devices.
#[derive(Subcommand, Debug)]
pub enum What {
    /// A Haply 2DIY on a pseudo-terminal or a Unix socket
    #[command(
        name = "haply-2diy",
        long_about = "\
A Haply 2DIY on a pseudo-terminal, whose path is printed, or on a Unix socket. Board, arm and hand run in \
real time until ctrl-C.

Faults are injected at given times: --fault KIND[=VALUE]@SECONDS, repeatable, with the kinds stall \
(for VALUE seconds), unplug (for VALUE seconds), garbage (VALUE bytes), half, lost, late (by VALUE \
seconds), twice, other-id, nan and slip (by VALUE degrees)."
    )]
    Haply2diy(Box<two_diy::arguments::TwoDiyArguments>),
    /// A Haply Inverse3 behind an Inverse Service
    #[command(long_about = "\
Haply's Inverse Service on this machine's loopback interface, whose address is printed. Its device is a point \
mass along each axis in a hand, and runs in real time until ctrl-C.

Faults are injected at given times: --fault KIND@SECONDS, repeatable, with the kinds lost, twice, late, \
garbage, half, half-bytes, disconnect and close for one answer, and stall=s, unplug=s and no-power=s for \
s seconds.")]
    Inverse3(Box<inverse3::Inverse3EmulatorArguments>),
    /// A device of Force Dimension behind a library libdrd.so
    #[cfg(unix)]
    #[command(long_about = "\
A library with functions of Force Dimension's libdrd, whose path is printed, and a device behind it: a point mass \
along each axis in a hand, which runs in real time until ctrl-C. The library is compiled by cc.

Faults are injected at given times: --fault KIND[=VALUE]@SECONDS, repeatable, with the kinds unplug, plug-in, stale \
(VALUE reads without a new sample), saturate (motors above VALUE newtons) and uncalibrated.")]
    ForceDimension(Box<force_dimension::ForceDimensionEmulatorArguments>),
    /// A moteus drive behind a CAN adapter, on a pseudo-terminal or a Unix socket
    #[cfg(unix)]
    #[command(long_about = "\
A moteus drive behind a CAN adapter on a pseudo-terminal, whose path is printed, or on a Unix socket. Motor, handle and hand run in real time from \
the first line on, until ctrl-C.

Faults are injected at given times: --fault KIND[=VALUE]@SECONDS, repeatable, with the kinds silence (for VALUE seconds), \
mode (the drive leaves its mode), code (a fault with the code VALUE), jump (of the encoder, VALUE turns) and torn (an \
answer).")]
    Moteus(Box<motor_drive::MotorDriveArguments>),
    /// An axis of an ODrive on a pseudo-terminal or a Unix socket
    #[cfg(unix)]
    #[command(long_about = "\
An axis of an ODrive on a pseudo-terminal, whose path is printed, or on a Unix socket. Motor, handle and hand run in real time from \
the first line on, until ctrl-C.

Faults are injected at given times: --fault KIND[=VALUE]@SECONDS, repeatable, with the kinds silence (for VALUE seconds), \
mode (the drive leaves its mode), code (a fault with the code VALUE), jump (of the encoder, VALUE turns) and torn (an \
answer).")]
    Odrive(Box<motor_drive::MotorDriveArguments>),
}

/// The amplifiers of an emulated device.
#[derive(Args, Debug, Clone, Copy)]
#[command(next_help_heading = "Amplifier")]
pub struct AmplifierFlags {
    /// Time constant of the force, 0 to 0.05 [s]
    #[arg(long, value_name = "s", value_parser = number, default_value = "0")]
    pub lag: f64,
    /// Delivered over commanded force of the motors, 0.1 to 10
    #[arg(long, value_name = "RATIO", value_parser = number, default_value = "1")]
    pub gain: f64,
}

impl AmplifierFlags {
    /// Returns gain and lag, if they are within their ranges.
    fn params(self) -> Result<ActuatorParams, Failure> {
        let Self { lag, gain } = self;
        within("--lag", lag, [0.0, 0.05], "0 to 0.05 [s]")?;
        within("--gain", gain, [0.1, 10.0], "0.1 to 10")?;
        Ok(ActuatorParams { gain, lag })
    }
}

/// Rejects a value outside its range.
fn within(flag: &str, value: f64, [least, most]: [f64; 2], allowed: &str) -> Result<(), Failure> {
    if (least..=most).contains(&value) {
        return Ok(());
    }
    Err(Failure::Arguments(format!(
        "{flag} is {value}; allowed: {allowed}"
    )))
}

/// Emulates until the end.
pub fn run(arguments: &EmulateArguments) -> Result<(), Failure> {
    match &arguments.what {
        What::Haply2diy(arguments) => two_diy::run(arguments),
        What::Inverse3(arguments) => inverse3::run(arguments),
        #[cfg(unix)]
        What::ForceDimension(arguments) => force_dimension::run(arguments),
        #[cfg(unix)]
        What::Moteus(arguments) => motor_drive::run(Maker::Moteus, arguments),
        #[cfg(unix)]
        What::Odrive(arguments) => motor_drive::run(Maker::Odrive, arguments),
    }
}
