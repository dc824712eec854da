//! The emulated 2DIY, in real time.

use std::time::{Duration, Instant};

use palpate_drivers::emulator::port::{PortSettings, Usb};
use palpate_drivers::emulator::two_diy::{Did, Emulator, Hand, Settings, Wiring};
use palpate_drivers::two_diy::Generation;
use palpate_rt::StopFlag;

use super::arguments::{HandArguments, TwoDiyArguments, UsbFlags, WiringName};
use crate::commands::devices::emulate::within;
use crate::devices::two_diy::board;
use crate::failure::{Failure, tell};
use crate::results::print;
use crate::values::{duration, no_time};

pub fn run(arguments: &TwoDiyArguments) -> Result<(), Failure> {
    let generation = match arguments.generation {
        1 => Generation::One,
        2 => Generation::Two,
        _ => Generation::Three,
    };
    let board = arguments.board.map_or(generation.usual_board(), board);
    let until = arguments
        .duration
        .filter(|seconds| *seconds != f64::INFINITY)
        .map(|seconds| duration("--duration", seconds))
        .transpose()?;
    let mut faults = arguments
        .fault
        .iter()
        .map(|timed| timed.fault().map_err(|seconds| no_time("--fault", seconds)))
        .collect::<Result<Vec<_>, _>>()?;
    faults.sort_by_key(|(at, _)| *at);
    let mut faults = faults.into_iter().peekable();
    let settings = Settings {
        strict: !arguments.tolerant,
        wiring: wiring(arguments.wiring),
        hand: hand(&arguments.hand)?,
        hand_waits: true,
        angles: arguments.angles,
        usb: usb(arguments.usb)?,
        amplifier: arguments.amplifier.params()?,
        port: match &arguments.socket {
            Some(path) => PortSettings::Socket { path: path.clone() },
            None => PortSettings::Terminal {
                link: arguments.link.clone(),
            },
        },
        ..Settings::new(generation, board)
    };
    let stop = StopFlag::on_signals()
        .map_err(|error| Failure::System(format!("cannot handle signals: {error}")))?;
    let emulator = Emulator::start(&settings)
        .map_err(|error| Failure::System(format!("cannot start the emulator: {error}")))?;
    let begun = Instant::now();
    print(&format!("{}\n", emulator.path().display()))?;
    let [first, second] = emulator.angles();
    tell(format_args!(
        "2DIY of generation {}, board {}, arm at {first:.1},{second:.1} degrees until it is opened; ctrl-C ends it",
        generation.number(),
        board.name()
    ));
    let mut path = emulator.path();
    while !stop.is_raised() && until.is_none_or(|until| begun.elapsed() < until) {
        while let Some((at, fault)) = faults.next_if(|(at, _)| begun.elapsed() >= *at) {
            tell(format_args!("at {:.1} s: {fault}", at.as_secs_f64()));
            emulator.inject_faults(fault);
        }
        if emulator.path() != path {
            path = emulator.path();
            tell(format_args!("plugged in again: {}", path.display()));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let seen = emulator.seen();
    let commands = seen
        .iter()
        .filter(|seen| matches!(seen.did, Did::Commanded(_)))
        .count();
    let largest = seen
        .iter()
        .flat_map(|seen| seen.torques)
        .fold(0.0_f64, |largest, torque| largest.max(torque.abs()));
    let [first, second] = emulator.torques();
    tell(format_args!(
        "{commands} commands, torques up to {largest:.3} N m; in the end {first} and {second}"
    ));
    let [along_x, along_y] = [[1.0, 0.0], [0.0, 1.0]].map(|axis| emulator.effective_mass(axis));
    tell(format_args!(
        "mass at the final pose: {along_x:.4} kg along x and {along_y:.4} kg along y"
    ));
    Ok(())
}

fn usb(flags: UsbFlags) -> Result<Usb, Failure> {
    within("--usb-frame", flags.usb_frame, [0.0, 0.1], "0 to 0.1 [s]")?;
    within("--latency", flags.latency, [0.0, 1.0], "0 to 1 [s]")?;
    Ok(Usb {
        frame: duration("--usb-frame", flags.usb_frame)?,
        latency: duration("--latency", flags.latency)?,
    })
}

fn wiring(name: WiringName) -> Wiring {
    let sold = Wiring::default();
    match name {
        WiringName::AsSold => sold,
        WiringName::Swapped => Wiring {
            swapped: true,
            ..sold
        },
        WiringName::Reversed1 => Wiring {
            reversed: [true, false],
            ..sold
        },
        WiringName::Reversed2 => Wiring {
            reversed: [false, true],
            ..sold
        },
        WiringName::Dead1 => Wiring {
            dead: [true, false],
            ..sold
        },
        WiringName::Dead2 => Wiring {
            dead: [false, true],
            ..sold
        },
    }
}

fn hand(arguments: &HandArguments) -> Result<Hand, Failure> {
    if let Some(force) = arguments.push {
        return Ok(Hand::Push(force));
    }
    let Some(place) = arguments.hold else {
        return Ok(Hand::None);
    };
    let of = |flag: &str, value: f64, fine: bool, allowed: &str| {
        if fine && value.is_finite() {
            Ok(value)
        } else {
            Err(Failure::Arguments(format!(
                "{flag} is {value}; allowed: {allowed}"
            )))
        }
    };
    let (period, stiffness, damping) = (
        arguments.sway_period,
        arguments.hand_stiffness,
        arguments.hand_damping,
    );
    Ok(Hand::Holds {
        place,
        sway: arguments.sway.unwrap_or_default(),
        period: of("--sway-period", period, period > 0.0, "above 0 [s]")?,
        stiffness: of(
            "--hand-stiffness",
            stiffness,
            stiffness >= 0.0,
            "0 or above [N/m]",
        )?,
        damping: of(
            "--hand-damping",
            damping,
            damping >= 0.0,
            "0 or above [N s/m]",
        )?,
    })
}
