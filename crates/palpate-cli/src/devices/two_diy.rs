//! The Haply 2DIY on a serial port: its setup from flags, and its messages.

use std::io::stdin;
use std::time::Duration;

use palpate_device::Device;
use palpate_device::clock::Clock;
use palpate_drivers::prepared::Reopen;
use palpate_drivers::prepared::two_diy::{DisableOutput, OpenError, PortError, Setup};
use palpate_drivers::two_diy::{Board, Calibration, Generation, TwoDiy};
use palpate_rt::watchdog::WatchdogError;
use rustix::termios::{QueueSelector, tcflush};

use super::DeviceArguments;
use super::guarding::guard;
use crate::failure::{Failure, tell};
use crate::reports::Guarding;
use crate::values::{BoardName, StartPose};

/// Returns the setup from the flags.
pub fn setup(arguments: &DeviceArguments) -> Setup {
    Setup {
        port: arguments.port.clone(),
        generation: match arguments.generation {
            Some(1) => Generation::One,
            Some(2) => Generation::Two,
            _ => Generation::Three,
        },
        board: arguments.board.map(board),
        calibration: match &arguments.start_pose {
            None | Some(StartPose::Retracted) => Calibration::Retracted,
            Some(StartPose::Extended) => Calibration::Extended,
            Some(StartPose::Angles(angles)) => Calibration::At(*angles),
        },
    }
}

/// Returns the board of a name.
pub fn board(name: BoardName) -> Board {
    match name {
        BoardName::M0 => Board::M0,
        BoardName::M3 => Board::M3,
        BoardName::Dev => Board::DevKit,
    }
}

/// Opens the device for a loop of `period`, with a watchdog process on request.
pub fn open<C: Clock>(
    setup: &Setup,
    period: Duration,
    clock: &C,
    guarding: Option<&Guarding>,
) -> Result<TwoDiy<C>, Failure> {
    let guard = guarding
        .map(guard)
        .transpose()
        .map_err(|error| refused(OpenError::Watchdog(WatchdogError::Spawn(error))))?;
    setup.open(period, clock.clone(), guard).map_err(refused)
}

fn refused(error: OpenError) -> Failure {
    match error {
        OpenError::StartPose(error) => Failure::Arguments(format!("--start-pose: {error}")),
        OpenError::Port(error) => no_port(error),
        OpenError::Device(_) => Failure::System(error.to_string()),
        OpenError::Watchdog(_) => Failure::System(format!("{error}; --watchdog off disables it")),
    }
}

/// Explains that no port can be that of a 2DIY.
pub fn no_port(error: PortError) -> Failure {
    match error {
        PortError::System(_) => Failure::System(error.to_string()),
        PortError::NoneLikely => Failure::System(format!("{error}; name one with --port")),
        PortError::SeveralLikely(_) => Failure::Arguments(format!("{error}; name one with --port")),
    }
}

/// Time for moving the arm to its start pose after the promise to do so.
const TO_START_POSE: Duration = Duration::from_secs(3);

/// Reopens the device on the port of `setup`. The board then counts from the arm's present pose, which it cannot
/// measure. Therefore the user must confirm that the arm is in its start pose, unless `is_promised`.
pub fn reopen<C: Clock>(
    setup: Setup,
    is_promised: bool,
    period: Duration,
    clock: C,
    guarding: Option<Guarding>,
) -> Reopen {
    let mut is_asked = false;
    Box::new(move || {
        let path = setup.port().map_err(|error| no_port(error).message())?;
        if !path.exists() {
            return Err(format!("{}: not found", path.display()));
        }
        if is_promised {
            tell(format_args!(
                "{} is back: hold the arm still in its start pose; it counts from there in {} s",
                path.display(),
                TO_START_POSE.as_secs()
            ));
            std::thread::sleep(TO_START_POSE);
        } else {
            if !is_asked {
                // Discard earlier input, which says nothing about the arm's present pose.
                let _ = tcflush(stdin(), QueueSelector::IFlush);
                tell(format_args!(
                    "{} is back, without force: move the arm into its start pose, hold it still, press enter; in \
                     another pose forces point in wrong directions",
                    path.display()
                ));
                is_asked = true;
            }
            match stdin().read_line(&mut String::new()) {
                Ok(1..) => is_asked = false,
                _ => {
                    return Err(
                        "standard input has ended, so enter cannot confirm the start pose".into(),
                    );
                }
            }
        }
        let opened = open(&setup, period, &clock, guarding.as_ref());
        Ok(watched(opened.map_err(|error| error.message())?, false))
    })
}

/// Wraps the device to warn at its end if its board has not confirmed that the torques are off; after the loss of the
/// port only if `says_gone`.
pub fn watched<C: Clock>(device: TwoDiy<C>, says_gone: bool) -> Box<dyn Device> {
    Box::new(DisableOutput::new(device, move |not| {
        if says_gone || !not.was_gone {
            tell(format_args!(
                "warning: the output of the 2DIY could not be disabled: {}; switch its motors off",
                not.error
            ));
        }
    }))
}
