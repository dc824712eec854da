//! Selection of a device, and the contact's axis in its frame.

use std::ffi::OsStr;
use std::io::IsTerminal;
use std::path::PathBuf;

use clap::builder::{EnumValueParser, PossibleValue, TypedValueParser};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Args, Command, Error, Parser, ValueEnum, ValueHint};
use palpate_drivers::external::{Place, words};

use super::motor_drive::{Maker, MotorDrive};
use crate::arguments::{PartFlags, TraceFlags};
use crate::failure::Failure;
use crate::values::{BoardName, FrameVector, StartPose, WorldAxes, place, start_pose, world_axes};

/// Selection of a device, and the contact's axis in its frame.
#[derive(Args, Debug, Clone)]
#[command(next_help_heading = "Device")]
pub struct DeviceArguments {
    /// Device; for each device of a world with several, --device "NAME=DEVICE FLAGS", with its name in the scene and
    /// its flags in the same quotes, such as 'left=process:"COMMAND" --normal 1,0'. A device of your own: process:"COMMAND", udp:ADDRESS:PORT
    /// or plugin:LIBRARY[,ARGUMENT]
    #[arg(long, value_name = "NAME", value_parser = ChoiceParser, default_value = "simulated")]
    pub device: Vec<Choice>,
    /// Motion of the device `replay`: a recording (.mcap), or CSV with the columns t_s,position_m
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath,
          required_if_eq("device", "replay"))]
    pub motion: Option<PathBuf>,
    /// Layout of a trace of --motion.
    #[command(flatten)]
    pub table: TraceFlags,
    /// Selected part of the motion.
    #[command(flatten)]
    pub part: PartFlags,
    /// Serial port of the device `haply-2diy` [default: the only matching port]
    #[arg(long, value_name = "PATH", value_hint = ValueHint::FilePath)]
    pub port: Option<PathBuf>,
    /// Generation of the 2DIY [default: 3]
    #[arg(long, value_name = "1..3", value_parser = clap::value_parser!(u8).range(1..=3))]
    pub generation: Option<u8>,
    /// Board of the 2DIY [default: inferred from its first angles, if possible]
    #[arg(long, value_name = "NAME", value_enum)]
    pub board: Option<BoardName>,
    /// Pose of the 2DIY's arm during opening: retracted, extended, or two angles [degrees] [default: retracted]
    #[arg(long, value_name = "POSE", value_parser = start_pose, allow_hyphen_values = true)]
    pub start_pose: Option<StartPose>,
    /// Wait for a lost device and continue when it returns; with a 2DIY, after enter confirms that its arm is in the
    /// start pose
    #[arg(long)]
    pub reconnect: bool,
    /// Instead of enter: a promise that the arm of a returned 2DIY is at rest in the start pose within 3 s; in any
    /// other pose forces have wrong directions
    #[arg(long, requires = "reconnect")]
    pub reconnect_in_start_pose: bool,
    /// Watchdog process that disables the output if this program is killed, stopped or hangs, for a device that holds
    /// its last force (haply-2diy, process, udp) [default: on]
    #[arg(long, value_name = "on|off", value_enum)]
    pub watchdog: Option<OnOff>,
    /// Permit a device `udp` on another machine; its packets are neither encrypted nor authenticated
    #[arg(long)]
    pub allow_remote: bool,
    /// Flags of the Inverse3.
    #[command(flatten)]
    pub inverse3: Inverse3Arguments,
    /// Flags of Force Dimension's devices.
    #[command(flatten)]
    pub force_dimension: ForceDimensionArguments,
    /// Origin of the contact's coordinate in the frame of a device with several axes; in a world: the device position
    /// of its tool's position_m [m]
    #[arg(long, value_name = "X,Y[,Z]", value_parser = place, allow_hyphen_values = true)]
    pub origin: Option<FrameVector>,
    /// Direction of the contact's coordinate in the same frame; of any length
    #[arg(long, value_name = "X,Y[,Z]", value_parser = place, allow_hyphen_values = true)]
    pub normal: Option<FrameVector>,
    /// World axis of each axis of the device, with - for the opposite direction, such as x,z or x,-y,z [default: x,y,z,
    /// as many as the device has]
    #[arg(long, value_name = "AXES", value_parser = world_axes, allow_hyphen_values = true)]
    pub world_axes: Option<WorldAxes>,
}

/// Devices, by the name that `--device` takes.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceName {
    /// Device and hand of the scene
    Simulated,
    /// A recorded motion, independent of the force
    Replay,
    /// No device: at rest at 0
    Null,
    /// The scene's device in a hand that the page of `palpate live` moves; in other commands it stays at its start
    Pointer,
    /// Haply 2DIY on a serial port
    #[value(name = "haply-2diy")]
    Haply2diy,
    /// Haply Inverse3 behind its service
    Inverse3,
    /// An omega, delta, sigma or lambda of Force Dimension, or a Falcon, by the manufacturer's library
    ForceDimension,
    /// A moteus drive behind a CAN adapter; further settings: travel_m, zero_turns, torque_nm, id
    #[value(name = "moteus:PORT,radius_m=R")]
    Moteus,
    /// An axis of an ODrive 3.x; further settings: travel_m, zero_turns, torque_nm, axis
    #[value(name = "odrive:PORT,radius_m=R")]
    Odrive,
    /// A device of your own: a program that this command starts
    #[value(name = "process:COMMAND")]
    Process,
    /// A device of your own: a program that answers packets
    #[value(name = "udp:ADDRESS:PORT")]
    Udp,
    /// A device of your own: a shared library
    #[value(name = "plugin:LIBRARY[,ARGUMENT]")]
    Plugin,
}

/// Switch of an option.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnOff {
    /// Yes
    On,
    /// No
    Off,
}

impl DeviceArguments {
    /// Whether a device that holds its last force gets a watchdog process, which cannot reach the device of a library and
    /// needs a Unix system.
    pub fn is_guarded(&self) -> bool {
        let is_library = matches!(self.kind(), DeviceName::Plugin | DeviceName::ForceDimension);
        cfg!(unix) && self.watchdog != Some(OnOff::Off) && !is_library
    }

    /// Returns the kind of the first named device.
    pub fn kind(&self) -> DeviceName {
        self.device
            .first()
            .map_or(DeviceName::Simulated, |choice| match choice {
                Choice::Of { arguments, .. } => arguments.kind(),
                Choice::Kind(kind) => *kind,
                Choice::Own(own) => own.kind(),
            })
    }

    /// Returns the location of a user-defined device.
    pub fn own(&self) -> Option<&OwnDevice> {
        match &self.device[..] {
            [Choice::Own(own)] => Some(own),
            _ => None,
        }
    }

    /// Whether each device that holds its last force gets a watchdog process.
    pub fn are_guarded(&self) -> bool {
        self.device.iter().all(|choice| match choice {
            Choice::Kind(_) | Choice::Own(_) => self.is_guarded(),
            Choice::Of { arguments, .. } => arguments.is_guarded(),
        })
    }

    /// Rejects flags of another device, and several devices.
    pub fn check(&self) -> Result<(), Failure> {
        let [Choice::Kind(_) | Choice::Own(_)] = self.device[..] else {
            return Err(Failure::Arguments(
                "--device: this command takes one device, by its kind; several, as NAME=DEVICE, are for `palpate run` \
                 and `palpate live` of a world with several"
                    .into(),
            ));
        };
        let device = self.kind();
        self.inverse3.check(device)?;
        self.force_dimension.check(device)?;
        if self.motion.is_some() && device != DeviceName::Replay {
            return Err(Failure::Arguments("--motion is for --device replay".into()));
        }
        if let (Some(flag), None) = (self.table.given(), &self.motion) {
            return Err(Failure::Arguments(format!(
                "{flag} is for the trace of --motion"
            )));
        }
        if self.part.is_given() && self.motion.is_none() {
            return Err(Failure::Arguments(
                "--from and --to select a part of --motion, which is missing".into(),
            ));
        }
        let of_the_2diy = [
            ("--port", self.port.is_some()),
            ("--generation", self.generation.is_some()),
            ("--board", self.board.is_some()),
            ("--start-pose", self.start_pose.is_some()),
            ("--reconnect-in-start-pose", self.reconnect_in_start_pose),
        ];
        let is_own = matches!(device, DeviceName::Process | DeviceName::Udp);
        let goes = matches!(
            device,
            DeviceName::Haply2diy
                | DeviceName::Inverse3
                | DeviceName::ForceDimension
                | DeviceName::Moteus
                | DeviceName::Odrive
        );
        if self.reconnect && !goes && !is_own {
            return Err(Failure::Arguments(
                "--reconnect is for devices that can be lost: haply-2diy, inverse3, force-dimension, moteus, odrive, process and udp"
                    .into(),
            ));
        }
        if self.watchdog.is_some() && !is_own && device != DeviceName::Haply2diy {
            return Err(Failure::Arguments(
                "--watchdog is for devices that hold their last force: haply-2diy, process and udp"
                    .into(),
            ));
        }
        if self.allow_remote && device != DeviceName::Udp {
            return Err(Failure::Arguments(
                "--allow-remote is for --device udp".into(),
            ));
        }
        let is_promised = self.reconnect_in_start_pose || std::io::stdin().is_terminal();
        if self.reconnect && device == DeviceName::Haply2diy && !is_promised {
            return Err(Failure::Arguments(
                "--reconnect: a reopened 2DIY counts from its present pose, and without a terminal, enter cannot \
                 confirm its start pose; --reconnect-in-start-pose promises that the arm is always there"
                    .into(),
            ));
        }
        match of_the_2diy.iter().find(|(_, given)| *given) {
            Some((flag, _)) if device != DeviceName::Haply2diy => Err(Failure::Arguments(format!(
                "{flag} is for --device haply-2diy"
            ))),
            _ => Ok(()),
        }
    }
}

/// Flags of the Inverse3.
#[derive(Args, Debug, Clone)]
pub struct Inverse3Arguments {
    /// Inverse Service of the device `inverse3` [default: ws://localhost:10001]
    #[arg(long, value_name = "URL")]
    pub service: Option<String>,
    /// Its events channel, usually ws://localhost:10020, which reports the reason of a lost device [default: unused]
    #[arg(long, value_name = "URL")]
    pub events: Option<String>,
    /// ID of the Inverse3 at the service [default: the only one]
    #[arg(long, value_name = "ID")]
    pub device_id: Option<String>,
    /// Priority under SCHED_FIFO of the threads for the service, 0: none [default: 79]
    #[arg(long, value_name = "0..99", value_parser = clap::value_parser!(u8).range(0..=99))]
    pub service_priority: Option<u8>,
}

impl Inverse3Arguments {
    /// Rejects a flag of another device.
    pub fn check(&self, device: DeviceName) -> Result<(), Failure> {
        let given = [
            ("--service", self.service.is_some()),
            ("--events", self.events.is_some()),
            ("--device-id", self.device_id.is_some()),
            ("--service-priority", self.service_priority.is_some()),
        ];
        match given.iter().find(|(_, given)| *given) {
            Some((flag, _)) if device != DeviceName::Inverse3 => Err(Failure::Arguments(format!(
                "{flag} is for --device inverse3"
            ))),
            _ => Ok(()),
        }
    }
}

/// Flags of Force Dimension's devices.
#[derive(Args, Debug, Clone)]
pub struct ForceDimensionArguments {
    /// Library libdrd of the device `force-dimension` [default: in the SDK's folder $FDSDK, ~/.local/lib,
    /// /usr/local/lib or /usr/lib]
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub library: Option<PathBuf>,
    /// Serial number of the device `force-dimension` [default: the only one]
    #[arg(long, value_name = "NUMBER", value_parser = clap::value_parser!(i32).range(0..))]
    pub serial: Option<i32>,
    /// Use the gripper of the device `force-dimension`, along its opening, in place of the handle
    #[arg(long)]
    pub gripper: bool,
    /// Switch off the gravity compensation of the device `force-dimension`
    #[arg(long)]
    pub no_gravity_compensation: bool,
}

impl ForceDimensionArguments {
    /// Rejects a flag of another device.
    pub fn check(&self, device: DeviceName) -> Result<(), Failure> {
        let given = [
            ("--library", self.library.is_some()),
            ("--serial", self.serial.is_some()),
            ("--gripper", self.gripper),
            ("--no-gravity-compensation", self.no_gravity_compensation),
        ];
        match given.iter().find(|(_, given)| *given) {
            Some((flag, _)) if device != DeviceName::ForceDimension => Err(Failure::Arguments(
                format!("{flag} is for --device force-dimension"),
            )),
            _ => Ok(()),
        }
    }
}

/// Value of one `--device`.
#[derive(Clone, Debug)]
pub enum Choice {
    /// A kind of device.
    Kind(DeviceName),
    /// A user-defined device.
    Own(OwnDevice),
    /// The device of one tool of a world.
    Of {
        /// Name of the device in the scene.
        name: String,
        /// The device, with its flags.
        arguments: Box<DeviceArguments>,
    },
}

/// Location of a user-defined device.
#[derive(Clone, Debug)]
pub enum OwnDevice {
    /// Another program.
    Program(Place),
    /// A shared library.
    Plugin {
        /// Its file.
        library: PathBuf,
        /// Text for the library.
        argument: String,
    },
    /// A motor drive.
    Drive(MotorDrive),
}

impl OwnDevice {
    fn kind(&self) -> DeviceName {
        match self {
            #[cfg(unix)]
            Self::Program(Place::Process(_)) => DeviceName::Process,
            Self::Program(Place::Udp(_)) => DeviceName::Udp,
            Self::Plugin { .. } => DeviceName::Plugin,
            Self::Drive(drive) => match drive.maker {
                Maker::Moteus => DeviceName::Moteus,
                Maker::Odrive => DeviceName::Odrive,
            },
        }
    }

    /// Parses the device that `text` names; `None` if it is another kind.
    ///
    /// # Errors
    /// The command, the address or a setting is wrong.
    fn parse(text: &str) -> Option<Result<Self, String>> {
        if let Some(command) = text.strip_prefix("process:") {
            #[cfg(unix)]
            return Some(match words(command) {
                Ok(words) => Ok(Self::Program(Place::Process(words))),
                Err(error) => Err(format!(
                    "{error}; needed: process:\"COMMAND\", such as process:\"python my_device.py\""
                )),
            });
            #[cfg(not(unix))]
            return Some(Err(format!(
                "{command}: a device `process` needs Linux or macOS; use udp:ADDRESS:PORT"
            )));
        }
        if let Some(library) = text.strip_prefix("plugin:") {
            let (library, argument) = library.split_once(',').unwrap_or((library, ""));
            return Some(if library.is_empty() {
                Err("needed: plugin:LIBRARY, such as plugin:./libmine.so".into())
            } else {
                Ok(Self::Plugin {
                    library: library.into(),
                    argument: argument.to_owned(),
                })
            });
        }
        for (name, maker) in [("moteus:", Maker::Moteus), ("odrive:", Maker::Odrive)] {
            if let Some(text) = text.strip_prefix(name) {
                return Some(MotorDrive::parse(maker, text).map(Self::Drive));
            }
        }
        let address = text.strip_prefix("udp:")?;
        let place = Place::udp(address).map_err(|error| {
            format!("{error}; needed: udp:ADDRESS:PORT, such as udp:127.0.0.1:5005")
        });
        Some(place.map(Self::Program))
    }
}

/// Parser of a [`Choice`]: `KIND`, or `NAME=KIND FLAGS` with the flags of a device.
#[derive(Clone, Copy, Debug)]
pub struct ChoiceParser;

/// A device and its flags, as written after a name.
#[derive(Parser, Debug)]
#[command(no_binary_name = true, disable_help_flag = true)]
struct Behind {
    /// The device and its flags.
    #[command(flatten)]
    arguments: DeviceArguments,
}

impl TypedValueParser for ChoiceParser {
    type Value = Choice;

    fn parse_ref(
        &self,
        command: &Command,
        arg: Option<&Arg>,
        value: &OsStr,
    ) -> Result<Choice, Error> {
        let refused = |why: &str| {
            let mut error = Error::new(ErrorKind::ValueValidation).with_cmd(command);
            let text = value.to_string_lossy().into_owned();
            let flag = arg.map_or_else(|| "--device".to_owned(), ToString::to_string);
            error.insert(ContextKind::InvalidArg, ContextValue::String(flag));
            error.insert(ContextKind::InvalidValue, ContextValue::String(text));
            error.insert(
                ContextKind::Suggested,
                ContextValue::StyledStrs(vec![why.to_owned().into()]),
            );
            error
        };
        if let Some(own) = value.to_str().and_then(OwnDevice::parse) {
            return own.map(Choice::Own).map_err(|why| refused(&why));
        }
        let named = value.to_str().and_then(|text| text.split_once('='));
        let Some((name, flags)) = named else {
            let kinds = EnumValueParser::<DeviceName>::new();
            return kinds.parse_ref(command, arg, value).map(Choice::Kind);
        };
        if name.trim().is_empty() || flags.trim().is_empty() {
            return Err(refused(
                "NAME=DEVICE FLAGS is needed, such as \"left=inverse3 --device-id 049D\"",
            ));
        }
        let is_program = flags.trim_start().starts_with("process:");
        let flags = words(flags).map_err(|why| refused(&why))?;
        let flags = std::iter::once("--device".to_owned()).chain(flags);
        let behind = Behind::try_parse_from(flags).map_err(|error| {
            let text = error.to_string();
            let first = text.lines().next().unwrap_or_default();
            let first = first.strip_prefix("error: ").unwrap_or(first);
            if is_program {
                return refused(&format!(
                    "{first}; a command with spaces needs quotes of its own: --device '{}=process:\"COMMAND\" FLAGS'",
                    name.trim()
                ));
            }
            refused(first)
        })?;
        if !matches!(
            behind.arguments.device[..],
            [Choice::Kind(_) | Choice::Own(_)]
        ) {
            return Err(refused(
                "a name takes one device, which has no name of its own",
            ));
        }
        Ok(Choice::Of {
            name: name.trim().to_owned(),
            arguments: Box::new(behind.arguments),
        })
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let kinds = <DeviceName as clap::ValueEnum>::value_variants().iter();
        Some(Box::new(
            kinds.filter_map(clap::ValueEnum::to_possible_value),
        ))
    }
}
