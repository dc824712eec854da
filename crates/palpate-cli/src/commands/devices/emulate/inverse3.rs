//! `palpate devices emulate inverse3`: Haply's Inverse Service with an emulated device.

use clap::{Args, ValueEnum};
use palpate_drivers::emulator::inverse3::{
    Body, Emulator, EmulatorError, EmulatorOptions, Latency, TimedFault,
};
use palpate_drivers::inverse3::Form;
use palpate_rt::StopFlag;
use palpate_testbed::hand::{Hand, Intention, Sinusoid};

use super::AmplifierFlags;
use crate::failure::{Failure, tell};
use crate::results::print;
use crate::values::{FrameVector, duration, number, place};

/// Arguments of `devices emulate inverse3`.
#[derive(Args, Debug)]
pub struct Inverse3EmulatorArguments {
    /// Form of the interface
    #[arg(long, value_name = "FORM", value_enum, default_value_t = FormName::V35)]
    pub form: FormName,
    /// Port of the simulation channel; 0: any free port
    #[arg(long, value_name = "PORT", default_value_t = 10001)]
    pub port: u16,
    /// Port of the events channel; 0: any free port
    #[arg(long, value_name = "PORT", default_value_t = 10020)]
    pub events_port: u16,
    /// Name of the device; may be repeated for several devices
    #[arg(long, value_name = "ID", default_value = "049D")]
    pub device_id: Vec<String>,
    /// Shortest duration of an exchange [s]
    #[arg(long, value_name = "s", value_parser = number, default_value = "0")]
    pub latency: f64,
    /// Largest additional duration [s]
    #[arg(long, value_name = "s", value_parser = number, default_value = "0")]
    pub jitter: f64,
    /// Time for which a force is held without a message [s]
    #[arg(long, value_name = "s", value_parser = number, default_value = "0.05")]
    pub idle_after: f64,
    /// Duration [s] [default: until ctrl-C]
    #[arg(long, value_name = "s", value_parser = number)]
    pub duration: Option<f64>,
    /// Fault to inject, with its time
    #[arg(long, value_name = "KIND[=s]@s", value_parser = str::parse::<TimedFault>)]
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

/// The hand at an emulated device with three axes.
#[derive(Args, Debug)]
#[command(next_help_heading = "Hand")]
pub struct HandArguments {
    /// Position at which a spring holds the handle [m] [default: the start position]
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    pub hold: Option<Triple>,
    /// Amplitude of the motion of that position [m]
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    pub sway: Option<Triple>,
    /// Period of that motion [s]
    #[arg(long, value_name = "s", value_parser = number, default_value = "1")]
    pub sway_period: f64,
    /// Additional force of the hand [N]
    #[arg(long, value_name = "X,Y,Z", value_parser = triple, allow_hyphen_values = true)]
    pub push: Option<Triple>,
    /// Stiffness of the spring [N/m]
    #[arg(long, value_name = "N/m", value_parser = number, default_value = "200")]
    pub hand_stiffness: f64,
    /// Damping of the hand [N s/m]
    #[arg(long, value_name = "N s/m", value_parser = number, default_value = "4")]
    pub hand_damping: f64,
}

/// Forms of the interface.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum FormName {
    /// Interface of services from 3.1 on
    #[value(name = "3.1")]
    V31,
    /// Interface of services from 3.5 on
    #[value(name = "3.5")]
    V35,
}

/// Three numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triple(pub [f64; 3]);

/// Parses three numbers.
pub fn triple(text: &str) -> Result<Triple, String> {
    match place(text) {
        Ok(FrameVector(numbers)) if numbers.len() == 3 => {
            Ok(Triple([numbers[0], numbers[1], numbers[2]]))
        }
        _ => Err("three numbers are needed, with commas between, such as 0.01,0,0".into()),
    }
}

/// Emulates until the end.
pub fn run(arguments: &Inverse3EmulatorArguments) -> Result<(), Failure> {
    let until = arguments
        .duration
        .filter(|seconds| *seconds != f64::INFINITY)
        .map(|seconds| duration("--duration", seconds))
        .transpose()?;
    let options = EmulatorOptions {
        form: match arguments.form {
            FormName::V31 => Form::V31,
            FormName::V35 => Form::V35,
        },
        port: arguments.port,
        events_port: arguments.events_port,
        device_ids: arguments.device_id.clone(),
        body: Body {
            mass: arguments.mass,
            start: arguments.start.0,
            hands: hands(&arguments.hand, arguments.start.0)?,
            amplifier: arguments.amplifier.params()?,
            ..Body::default()
        },
        idle_after: duration("--idle-after", arguments.idle_after)?,
        latency: Latency {
            least: duration("--latency", arguments.latency)?,
            jitter: duration("--jitter", arguments.jitter)?,
        },
    };
    let stop = StopFlag::on_signals()
        .map_err(|error| Failure::System(format!("cannot handle signals: {error}")))?;
    let emulator = Emulator::start(&options).map_err(|error| match error {
        EmulatorError::Body(error) => Failure::Arguments(error.to_string()),
        EmulatorError::Port { .. } => Failure::System(format!(
            "{error}; choose others with --port and --events-port, 0 for any free one"
        )),
        EmulatorError::Thread(_) => Failure::System(error.to_string()),
    })?;
    print(&format!("{}\n", emulator.url()))?;
    tell(format_args!(
        "Inverse Service with {}, events on {}; ctrl-C ends it",
        arguments.device_id.join(", "),
        emulator.events_url()
    ));
    let id = arguments.device_id[0].as_str();
    let is_over = |since| stop.is_raised() || until.is_some_and(|until| since >= until);
    emulator.inject_faults(id, &arguments.fault, is_over, |words| tell(words));
    let largest = emulator
        .received()
        .iter()
        .filter_map(|message| message.force)
        .flatten()
        .fold(0.0_f64, |largest, force| largest.max(force.abs()));
    let last = emulator.force(id).unwrap_or_default();
    let served = emulator.served();
    let last = last.map(|force| format!("{force:.3}")).join(", ");
    tell(format_args!(
        "{} sessions, {} messages, forces up to {largest:.3} N along an axis; in the end {last} N",
        served.sessions, served.messages
    ));
    Ok(())
}

/// Returns the hand along x, y and z, at a device that starts at `start` `[m]`.
pub fn hands(hand: &HandArguments, start: [f64; 3]) -> Result<[Hand; 3], Failure> {
    if !(hand.sway_period > 0.0 && hand.sway_period.is_finite()) {
        return Err(Failure::Arguments(format!(
            "--sway-period is {}; allowed: above 0 [s]",
            hand.sway_period
        )));
    }
    let of = |triple: Option<Triple>, axis: usize| triple.map_or(0.0, |triple| triple.0[axis]);
    Ok([0, 1, 2].map(|axis| {
        let sway = of(hand.sway, axis);
        Hand::Impedance {
            mass: 0.0,
            stiffness: hand.hand_stiffness,
            damping: hand.hand_damping,
            intention: Intention {
                tremor: (sway != 0.0).then_some(Sinusoid {
                    amplitude: sway,
                    frequency_hz: 1.0 / hand.sway_period,
                    phase: 0.0,
                }),
                ..Intention::constant(hand.hold.map_or(start, |hold| hold.0)[axis])
            },
            force: of(hand.push, axis),
            tremor: None,
        }
    }))
}
