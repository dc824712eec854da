//! `palpate devices emulate force-dimension`: Force Dimension's library with an emulated device.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueHint};
use palpate_device::clock::{Clock, MonotonicClock};
use palpate_drivers::emulator::force_dimension::{
    Emulator, EmulatorError, EmulatorOptions, TimedFault,
};
use palpate_drivers::emulator::inverse3::Body;
use palpate_drivers::force_dimension::{KINDS, Kind};
use palpate_rt::StopFlag;

use super::AmplifierFlags;
use super::inverse3::{HandArguments, Triple, hands, triple};
use crate::failure::{Failure, tell};
use crate::results::print;
use crate::values::{duration, number};

/// Arguments of `devices emulate force-dimension`.
#[derive(Args, Debug)]
pub struct ForceDimensionEmulatorArguments {
    /// Type of the device, such as omega.3 or sigma.7-right
    #[arg(long = "type", value_name = "NAME", value_parser = kind, default_value = "omega.3")]
    pub kind: Kind,
    /// Serial number of the device
    #[arg(long, value_name = "NUMBER", default_value_t = 1234)]
    pub serial: i32,
    /// Folder for libdrd.so, which exists [default: a new temporary one, deleted at the end]
    #[arg(long, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    pub folder: Option<PathBuf>,
    /// Emulate a firmware without a watchdog
    #[arg(long)]
    pub no_watchdog: bool,
    /// Duration [s] [default: until ctrl-C]
    #[arg(long, value_name = "s", value_parser = number)]
    pub duration: Option<f64>,
    /// Fault to inject, with its time
    #[arg(long, value_name = "KIND[=VALUE]@s", value_parser = str::parse::<TimedFault>)]
    pub fault: Vec<TimedFault>,
    /// Mass of the device along each axis [kg]
    #[arg(long, value_name = "kg", value_parser = number, default_value = "0.2")]
    pub mass: f64,
    /// Start position [m]
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true,
          default_value = "0,0,0")]
    pub start: Triple,
    /// The amplifiers.
    #[command(flatten)]
    pub amplifier: AmplifierFlags,
    /// The hand.
    #[command(flatten)]
    pub hand: HandArguments,
}

fn kind(name: &str) -> Result<Kind, String> {
    Kind::of_name(name).ok_or_else(|| {
        let names = KINDS.map(|kind| kind.name).join(", ");
        format!("allowed: {names}")
    })
}

/// Interval at which due faults are injected and the watchdog is polled.
const LOOK: Duration = Duration::from_millis(5);

/// Emulates until the end.
pub fn run(arguments: &ForceDimensionEmulatorArguments) -> Result<(), Failure> {
    let until = arguments
        .duration
        .filter(|seconds| *seconds != f64::INFINITY)
        .map(|seconds| duration("--duration", seconds))
        .transpose()?;
    let options = EmulatorOptions {
        kind: arguments.kind,
        serial: arguments.serial,
        body: Body {
            mass: arguments.mass,
            start: arguments.start.0,
            hands: hands(&arguments.hand, arguments.start.0)?,
            amplifier: arguments.amplifier.params()?,
            ..Body::default()
        },
        has_watchdog: !arguments.no_watchdog,
        ..EmulatorOptions::default()
    };
    let stop = StopFlag::on_signals()
        .map_err(|error| Failure::System(format!("cannot handle signals: {error}")))?;
    let own = std::env::temp_dir().join(format!("palpate-libdrd-{}", std::process::id()));
    let folder = arguments.folder.as_ref().unwrap_or(&own);
    if arguments.folder.is_none() {
        std::fs::create_dir(&own)
            .map_err(|error| Failure::System(format!("{}: {error}", own.display())))?;
    }
    let clock = MonotonicClock::new();
    let emulator = Emulator::start(folder, &options, &clock).map_err(|error| match error {
        EmulatorError::Body(error) => Failure::Arguments(error.to_string()),
        _ => Failure::System(error.to_string()),
    });
    let ran = emulator.and_then(|emulator| emulate(&emulator, arguments, until, &clock, &stop));
    if arguments.folder.is_none() {
        let _ = std::fs::remove_dir_all(&own);
    }
    ran
}

fn emulate(
    emulator: &Emulator,
    arguments: &ForceDimensionEmulatorArguments,
    until: Option<Duration>,
    clock: &MonotonicClock,
    stop: &StopFlag,
) -> Result<(), Failure> {
    print(&format!("{}\n", emulator.library().display()))?;
    tell(format_args!(
        "{} with the serial number {}; ctrl-C ends it",
        arguments.kind.name, arguments.serial
    ));
    let begun = clock.now();
    let mut faults = arguments.fault.clone();
    let mut largest = 0.0_f64;
    let mut was_cut = false;
    loop {
        let since = clock.now() - begun;
        if stop.is_raised() || until.is_some_and(|until| since >= until) {
            break;
        }
        faults.retain(|fault| {
            let is_due = fault.at <= since;
            if is_due {
                fault.inject(emulator);
            }
            !is_due
        });
        let (force, ..) = emulator.held(clock);
        largest = force
            .iter()
            .fold(largest, |largest, force| largest.max(force.abs()));
        if emulator.was_cut() != was_cut {
            was_cut = true;
            tell("the firmware's watchdog took the force off");
        }
        std::thread::sleep(LOOK);
    }
    let (force, ..) = emulator.held(clock);
    let last = force.map(|force| format!("{force:.3}")).join(", ");
    tell(format_args!(
        "{} calls, forces up to {largest:.3} N along an axis; in the end {last} N",
        emulator.calls()
    ));
    Ok(())
}
