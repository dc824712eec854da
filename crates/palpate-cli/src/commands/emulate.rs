//! `palpate emulate`: a device to try without one.

mod inverse3;

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum, ValueHint};

use crate::failure::Failure;
use crate::values::{BoardName, number, pair, timed_fault};

/// Arguments of `emulate`.
#[derive(Args, Debug)]
pub struct EmulateArguments {
    /// What is emulated.
    #[command(subcommand)]
    pub what: What,
}

/// What can be emulated.
#[derive(Subcommand, Debug)]
pub enum What {
    /// A Haply 2DIY on a pseudo-terminal
    #[command(
        name = "haply-2diy",
        long_about = "\
A Haply 2DIY on a pseudo-terminal, whose path is printed: board, arm and hand in real time, until ctrl-C.

Faults strike by themselves: --fault KIND[=VALUE]@SECONDS, as often as wanted, with the kinds stall \
(for VALUE seconds), unplug (for VALUE seconds), garbage (VALUE bytes), half, lost, late (by VALUE \
seconds), twice, other-id, nan and slip (by VALUE degrees)."
    )]
    Haply2diy(TwoDiyArguments),
    /// A Haply Inverse3 behind an Inverse Service
    #[command(long_about = "\
Haply's Inverse Service on this machine's loopback, whose address is printed, and behind it a point mass \
along each axis in a hand, in real time, until ctrl-C.

Faults strike by themselves: --fault KIND@SECONDS, as often as wanted, with the kinds lost, twice, late, \
garbage, half, half-bytes, disconnect and close for one answer, and stall=s, unplug=s and no-power=s for \
as many seconds.")]
    Inverse3(Box<inverse3::Inverse3EmulatorArguments>),
}

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
    #[arg(long, value_name = "KIND[=VALUE]@s", value_parser = timed_fault)]
    pub fault: Vec<TimedFault>,
    /// The hand.
    #[command(flatten)]
    pub hand: HandArguments,
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

/// A fault and when it strikes [s].
#[derive(Clone, Debug, PartialEq)]
pub struct TimedFault {
    /// When, after the start [s].
    pub at: f64,
    /// Its kind.
    pub kind: FaultKind,
    /// How long, how far, how many.
    pub value: f64,
}

/// Kinds of faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultKind {
    Stall,
    Unplug,
    Garbage,
    Half,
    Lost,
    Late,
    Twice,
    OtherId,
    NotANumber,
    Slip,
}

impl FaultKind {
    /// Every kind with its name and the value that it has if none is given.
    pub const NAMED: [(&'static str, Self, f64); 10] = [
        ("stall", Self::Stall, 0.05),
        ("unplug", Self::Unplug, 2.0),
        ("garbage", Self::Garbage, 5.0),
        ("half", Self::Half, 0.0),
        ("lost", Self::Lost, 0.0),
        ("late", Self::Late, 0.005),
        ("twice", Self::Twice, 0.0),
        ("other-id", Self::OtherId, 0.0),
        ("nan", Self::NotANumber, 0.0),
        ("slip", Self::Slip, 25.0),
    ];
}

/// Emulates until it is over.
pub fn run(arguments: &EmulateArguments) -> Result<(), Failure> {
    match &arguments.what {
        #[cfg(unix)]
        What::Haply2diy(arguments) => two_diy::run(arguments),
        #[cfg(not(unix))]
        What::Haply2diy(_) => Err(Failure::System(
            "this emulator needs pseudo-terminals, of Linux or macOS".into(),
        )),
        What::Inverse3(arguments) => inverse3::run(arguments),
    }
}

#[cfg(unix)]
mod two_diy {
    use std::time::{Duration, Instant};

    use palpate_haply::two_diy::Generation;
    use palpate_haply::two_diy::emulator::{Did, Emulator, Fault, Hand, Settings, Wiring};
    use palpate_rt::StopFlag;

    use super::{FaultKind, HandArguments, TimedFault, TwoDiyArguments, WiringName};
    use crate::devices::two_diy::board;
    use crate::failure::{Failure, tell};
    use crate::results::print;
    use crate::values::duration;

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
            .map(fault)
            .collect::<Result<Vec<_>, _>>()?;
        faults.sort_by_key(|(at, _)| *at);
        let mut faults = faults.into_iter().peekable();
        let settings = Settings {
            strict: !arguments.tolerant,
            wiring: wiring(arguments.wiring),
            hand: hand(&arguments.hand)?,
            hand_waits: true,
            angles: arguments.angles,
            link: arguments.link.clone(),
            ..Settings::of(generation, board)
        };
        let stop = StopFlag::on_signals()
            .map_err(|error| Failure::System(format!("no signals: {error}")))?;
        let emulator = Emulator::start(&settings)
            .map_err(|error| Failure::System(format!("no emulator: {error}")))?;
        let begun = Instant::now();
        print(&format!("{}\n", emulator.path().display()))?;
        let [first, second] = emulator.angles();
        tell(format_args!(
            "a 2DIY of generation {} on the board {}, its arm at {first:.1},{second:.1} degrees until it \
             is opened; ctrl-C ends it",
            generation.number(),
            board.name()
        ));
        let mut path = emulator.path();
        while !stop.is_raised() && until.is_none_or(|until| begun.elapsed() < until) {
            while let Some((at, fault)) = faults.next_if(|(at, _)| begun.elapsed() >= *at) {
                tell(format_args!("at {:.1} s: {fault:?}", at.as_secs_f64()));
                emulator.suffer(fault);
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
        Ok(())
    }

    fn fault(timed: &TimedFault) -> Result<(Duration, Fault), Failure> {
        let value = timed.value;
        let time = || duration("--fault", value);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a cast saturates, and so many bytes nobody sends"
        )]
        let fault = match timed.kind {
            FaultKind::Stall => Fault::Stall(time()?),
            FaultKind::Unplug => Fault::Unplug(time()?),
            FaultKind::Garbage => Fault::Garbage(vec![0x77; (value as usize).min(10_000)]),
            FaultKind::Half => Fault::HalfAnswer,
            FaultKind::Lost => Fault::NoAnswer,
            FaultKind::Late => Fault::LateAnswer(time()?),
            FaultKind::Twice => Fault::TwoAnswers,
            FaultKind::OtherId => Fault::OtherId,
            FaultKind::NotANumber => Fault::NotANumber,
            FaultKind::Slip => Fault::Slip(value),
        };
        Ok((duration("--fault", timed.at)?, fault))
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
}
