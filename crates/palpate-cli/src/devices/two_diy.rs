//! The Haply 2DIY on a serial port.

use std::io::stdin;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use palpate_device::clock::Clock;
use palpate_device::{
    Capabilities, Device, DeviceError, DeviceErrorKind, Pose, Wrench, ZeroWriter,
};
use palpate_haply::two_diy::{Board, Calibration, Generation, Options, TwoDiy};
use palpate_rt::guardian::GuardianError;
use rustix::termios::{QueueSelector, tcflush};

use super::guarding::{Guarding, command};
use super::placed::Axis;
use super::{DeviceArguments, Reopen};
use crate::failure::{Failure, tell};
use crate::values::{BoardName, StartPose};

/// The axis of the contact on a 2DIY: away from the base, along the middle line.
pub fn usual_axis(generation: Generation) -> Axis {
    let [x, y] = generation.usual_origin();
    ([x, y, 0.0], [0.0, 1.0, 0.0])
}

/// The generation that the flags name.
pub fn generation(arguments: &DeviceArguments) -> Generation {
    match arguments.generation {
        Some(1) => Generation::One,
        Some(2) => Generation::Two,
        _ => Generation::Three,
    }
}

/// The board that a name stands for.
pub fn board(name: BoardName) -> Board {
    match name {
        BoardName::M0 => Board::M0,
        BoardName::M3 => Board::M3,
        BoardName::Dev => Board::DevKit,
    }
}

/// Opens it, for a loop of `period`, with a guardian unless `arguments` say otherwise.
pub fn open<C: Clock>(
    arguments: &DeviceArguments,
    period: Duration,
    clock: &C,
    guarding: &Guarding,
) -> Result<TwoDiy<C>, Failure> {
    let generation = generation(arguments);
    let calibration = match &arguments.start_pose {
        None | Some(StartPose::Retracted) => Calibration::Retracted,
        Some(StartPose::Extended) => Calibration::Extended,
        Some(StartPose::Angles(angles)) => Calibration::At(*angles),
    };
    let options = Options::of(generation, calibration, period)
        .map_err(|error| Failure::Arguments(format!("--start-pose: {error}")))?;
    let options = Options {
        board: arguments.board.map(board),
        ..options
    };
    let path = port(arguments)?;
    let device = TwoDiy::open(&path, &options, clock.clone())
        .map_err(|error| Failure::System(error.to_string()))?;
    if !arguments.is_guarded() {
        return Ok(device);
    }
    command()
        .map_err(GuardianError::Spawn)
        .and_then(|command| {
            let account = Arc::clone(&guarding.account);
            device.guarded_by(command, guarding.limit, account)
        })
        .map_err(|error| {
            Failure::System(format!(
                "no guardian: {error}. If this program is killed or stopped, only a guardian takes \
                 the force off this device, which holds it; --guardian off goes without one"
            ))
        })
}

/// How long somebody who has promised so has to bring the arm into its start pose.
const TO_START_POSE: Duration = Duration::from_secs(3);

/// Opens it anew on the port of `arguments`. The board then counts from where the arm is, and cannot
/// tell where that is; so it is not opened before somebody says that this is its start pose.
pub fn reopen<C: Clock>(
    arguments: DeviceArguments,
    period: Duration,
    clock: C,
    guarding: Guarding,
) -> Reopen {
    let mut is_asked = false;
    Box::new(move || {
        let path = port(&arguments)?;
        if !path.exists() {
            return Err(Failure::System(format!("{}: not there", path.display())));
        }
        if arguments.reconnect_in_start_pose {
            tell(format_args!(
                "{} is there: hold the arm still in its start pose, it counts from there in {} s",
                path.display(),
                TO_START_POSE.as_secs()
            ));
            std::thread::sleep(TO_START_POSE);
        } else {
            if !is_asked {
                // What was typed before says nothing about where the arm is now.
                let _ = tcflush(stdin(), QueueSelector::IFlush);
                tell(format_args!(
                    "{} is there, and no force: bring the arm into its start pose, hold it still, \
                     press enter; elsewhere forces point in wrong directions",
                    path.display()
                ));
                is_asked = true;
            }
            match stdin().read_line(&mut String::new()) {
                Ok(1..) => is_asked = false,
                _ => return Err(Failure::System("nobody can press enter any more".into())),
            }
        }
        Ok(watched(open(&arguments, period, &clock, &guarding)?, false))
    })
}

/// The same device, telling in the end if its board has not said that it holds no torque; of a port
/// that has gone `says_gone` or somebody else.
pub fn watched<C: Clock>(device: TwoDiy<C>, says_gone: bool) -> Box<dyn Device> {
    Box::new(Watched {
        capabilities: device.capabilities().clone(),
        device: Some(device),
        says_gone,
        is_gone: false,
    })
}

struct Watched<C> {
    capabilities: Capabilities,
    /// There until it is closed.
    device: Option<TwoDiy<C>>,
    says_gone: bool,
    is_gone: bool,
}

impl<C: Clock> Watched<C> {
    fn with<T>(
        &mut self,
        ask: impl FnOnce(&mut TwoDiy<C>) -> Result<T, DeviceError>,
    ) -> Result<T, DeviceError> {
        let closed = DeviceError::new(DeviceErrorKind::Disconnected, "the 2DIY is closed");
        let answer = self.device.as_mut().ok_or(closed).and_then(ask);
        self.is_gone |= answer
            .as_ref()
            .is_err_and(|error| error.kind == DeviceErrorKind::Disconnected);
        answer
    }
}

impl<C: Clock> Device for Watched<C> {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        self.with(Device::read)
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        self.with(|device| device.write(wrench))
    }

    fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        self.device.as_mut()?.zero_writer()
    }

    fn was_cut(&mut self) -> bool {
        self.device.as_mut().is_some_and(Device::was_cut)
    }
}

impl<C> Drop for Watched<C> {
    fn drop(&mut self) {
        let closed = self.device.take().map_or(Ok(()), TwoDiy::close);
        if let Err(error) = closed
            && (self.says_gone || !self.is_gone)
        {
            tell(format_args!(
                "warning: the 2DIY could not be let go of as it should: {error}; switch its motors off"
            ));
        }
    }
}

/// The port that the flags name, or the one that is likely.
pub fn port(arguments: &DeviceArguments) -> Result<PathBuf, Failure> {
    if let Some(port) = &arguments.port {
        return Ok(port.clone());
    }
    let ports = palpate_haply::two_diy::ports().map_err(Failure::System)?;
    let likely: Vec<_> = ports.iter().filter(|port| port.guess.is_likely()).collect();
    match likely[..] {
        [port] => Ok(port.path.clone().into()),
        [] => Err(Failure::System(
            "no serial port looks like a Haply board; `palpate devices` lists them, --port names one"
                .into(),
        )),
        _ => Err(Failure::Arguments(format!(
            "several boards may be a 2DIY: {}; --port names one",
            likely
                .iter()
                .map(|port| port.path.as_str())
                .collect::<Vec<_>>()
                .join(", ")
        ))),
    }
}
