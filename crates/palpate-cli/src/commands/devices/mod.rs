//! `palpate devices`: lists the available devices, checks the wiring of one, or emulates one.

mod emulate;

#[cfg(unix)]
use std::time::Duration;

use clap::{Args, Subcommand, ValueEnum};
use palpate_drivers::inverse3::SERVICE;

use crate::devices::DeviceArguments;
use crate::failure::Failure;
use crate::reports::DeviceList;
#[cfg(unix)]
use crate::results::print;
use crate::results::print_report;
use emulate::EmulateArguments;

/// Arguments of `devices`.
#[derive(Args, Debug)]
pub struct DevicesArguments {
    /// Action; none: list the devices.
    #[command(subcommand)]
    pub what: Option<What>,
    /// Inverse Service to query for devices
    #[arg(long, value_name = "URL", default_value = SERVICE)]
    pub service: String,
    /// Print the list as JSON
    #[arg(long)]
    pub json: bool,
}

/// Actions.
#[derive(Subcommand, Debug)]
pub enum What {
    /// Check that each motor turns its own joint in the right direction: the arm MOVES
    #[command(long_about = "\
Check that each motor turns its own joint in the right direction.

Put the arm into its start pose and release it. Each motor gets a short pulse of 0.03 N m forwards and one \
backwards, a quarter of its maximum torque. The arm MOVES by a few degrees, so the check requires --move. At \
the end the torque is 0. The same holds after ctrl-C, SIGTERM or SIGHUP, which end the check with exit code 130.")]
    Check(Box<CheckArguments>),
    /// Emulate a device for trials without hardware
    #[command(override_usage = "\
palpate devices emulate haply-2diy [OPTIONS]
       palpate devices emulate inverse3 [OPTIONS]
       palpate devices emulate force-dimension [OPTIONS]
       palpate devices emulate moteus [OPTIONS]
       palpate devices emulate odrive [OPTIONS]")]
    #[command(long_about = "\
Emulate a device for trials without hardware.

Standard output is the address: `palpate run SCENE.toml --device haply-2diy --port PATH`, or `--device \
inverse3 --service URL`, `--device force-dimension --library PATH`, `--device moteus:PATH,radius_m=0.02` or \
`--device odrive:PATH,radius_m=0.02`, opens it. It moves in real time until ctrl-C.")]
    #[command(after_help = "\
Examples:
  palpate devices emulate haply-2diy --duration 1
  palpate devices emulate haply-2diy --hold 0.019,0.05 --sway 0,0.02 --link my-2diy --duration 1
  palpate devices emulate haply-2diy --generation 2 --board m3 --fault stall=0.1@0.5 --duration 1
  palpate devices emulate inverse3 --port 0 --events-port 0 --hold 0.01,0,0 --duration 1
  palpate devices emulate force-dimension --type delta.3 --hold 0.01,0,0 --duration 1
  palpate devices emulate moteus --hold 0.01 --fault silence=0.2@0.5 --duration 1")]
    Emulate(EmulateArguments),
}

/// Arguments of `devices check`.
#[derive(Args, Debug)]
pub struct CheckArguments {
    /// Which device
    #[arg(value_enum)]
    pub name: Checkable,
    /// Confirm that the arm may move
    #[arg(long = "move")]
    pub may_move: bool,
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
    /// Options for opening the device.
    #[command(flatten)]
    pub device: DeviceArguments,
}

/// Devices that can be checked.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Checkable {
    /// Haply 2DIY on a serial port
    #[value(name = "haply-2diy")]
    Haply2diy,
}

/// Lists the devices, checks one, or emulates one.
pub fn run(arguments: &DevicesArguments) -> Result<(), Failure> {
    match &arguments.what {
        None => list(arguments),
        Some(What::Check(arguments)) => check(arguments),
        Some(What::Emulate(arguments)) => emulate::run(arguments),
    }
}

fn list(arguments: &DevicesArguments) -> Result<(), Failure> {
    let list = DeviceList::new(&arguments.service).map_err(Failure::System)?;
    print_report(&list, arguments.json)
}

#[cfg(unix)]
fn check(arguments: &CheckArguments) -> Result<(), Failure> {
    use crate::reports::Guarding;
    use palpate_device::clock::MonotonicClock;
    use palpate_drivers::two_diy::{Unchecked, Verdict};
    use palpate_rt::StopFlag;

    use crate::reports::MotorsReport;
    use palpate_study::json;

    use crate::devices::two_diy;

    if !arguments.may_move {
        return Err(Failure::Arguments(
            "this moves the arm by a few degrees: put it into its start pose, release it, and pass --move"
                .into(),
        ));
    }
    // Before the motors are on: a signal that ended the program would leave a torque on.
    let stop = StopFlag::on_signals()
        .map_err(|error| Failure::System(format!("cannot handle signals: {error}")))?;
    // A slow response is harmless here.
    let period = Duration::from_millis(20);
    let guarding = Guarding::new(2 * period);
    let clock = MonotonicClock::new();
    let setup = two_diy::setup(&arguments.device);
    let guarding = arguments.device.is_guarded().then_some(&guarding);
    let mut device = two_diy::open(&setup, period, &clock, guarding)?;
    let failed = |error: palpate_device::DeviceError| Failure::System(error.to_string());
    let checked = match device.check_motors(&stop) {
        Ok(checked) => checked,
        Err(unchecked) => {
            device.close().map_err(failed)?;
            return Err(match unchecked {
                Unchecked::Stopped => {
                    Failure::Interrupted(format!("{unchecked}; the board confirmed zero torque"))
                }
                Unchecked::Device(error) => failed(error),
            });
        }
    };
    let board = device.board().name();
    let angles = device.angles();
    device.close().map_err(failed)?;
    let is_fine = checked
        .iter()
        .all(|checked| checked.verdict == Verdict::Fine);
    print(&if arguments.json {
        json(&MotorsReport::new(board, &checked)) + "\n"
    } else {
        let [first, second] = angles;
        let mut text = format!("board {board}, joints at {first:.2} and {second:.2} degrees\n");
        for (motor, checked) in checked.iter().enumerate() {
            let [first, second] = checked.turned;
            text += &format!(
                "motor {}: {} (joint 1 by {first:.1} degrees, joint 2 by {second:.1})\n",
                motor + 1,
                checked.verdict.text()
            );
        }
        text
    })?;
    if is_fine {
        Ok(())
    } else {
        Err(Failure::System(
            "a motor does not turn its joint as expected".into(),
        ))
    }
}

#[cfg(not(unix))]
fn check(_: &CheckArguments) -> Result<(), Failure> {
    Err(Failure::System(
        "the driver of the 2DIY needs Linux or macOS".into(),
    ))
}
