//! `palpate devices`: what a loop can run on here, and whether a device is wired as it should be.

use std::fmt;
use std::time::Duration;

use clap::{Args, Subcommand, ValueEnum};
use palpate_haply::inverse3::{self, Found, SERVICE};
use palpate_haply::two_diy::{Guess, Port, ports};
use palpate_study::json;
use serde::Serialize;

use crate::devices::DeviceArguments;
use crate::failure::Failure;
use crate::results::{print, print_report};

/// Name and version of the JSON report.
const FORMAT: &str = "palpate devices 1";

/// What is said of every 2DIY, since it may hurt.
pub const LATCH_WARNING: &str = "the board of a 2DIY has no watchdog: if the cable is pulled, it may \
     hold its last torque until its power is switched off; if the program is killed, a guardian takes \
     the torque off, unless it was started with --guardian off";

/// Arguments of `devices`.
#[derive(Args, Debug)]
pub struct DevicesArguments {
    /// What to do with one; nothing: list them.
    #[command(subcommand)]
    pub what: Option<What>,
    /// Inverse Service that is asked for its devices
    #[arg(long, value_name = "URL", default_value = SERVICE)]
    pub service: String,
    /// Print the list as JSON
    #[arg(long)]
    pub json: bool,
}

/// What can be done.
#[derive(Subcommand, Debug)]
pub enum What {
    /// Look whether each motor turns its own joint, the right way: the arm MOVES
    #[command(long_about = "\
Look whether each motor turns its own joint, the right way.

The arm has to be in its start pose, with nobody holding it. Each motor gets a short pulse of 0.03 N m \
forwards and one backwards, a quarter of what it can give: the arm MOVES, by a few degrees. So it is \
only done with --move. In the end no torque is commanded, nor after ctrl-C, SIGTERM or SIGHUP, which \
end it with exit code 130.")]
    Check(CheckArguments),
}

/// Arguments of `devices check`.
#[derive(Args, Debug)]
pub struct CheckArguments {
    /// Which device
    #[arg(value_enum)]
    pub name: Checkable,
    /// Yes, the arm may move
    #[arg(long = "move")]
    pub may_move: bool,
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
    /// How it is opened.
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

/// Lists, or checks one.
pub fn run(arguments: &DevicesArguments) -> Result<(), Failure> {
    match &arguments.what {
        None => list(arguments),
        Some(What::Check(arguments)) => check(arguments),
    }
}

#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct List {
    #[cfg_attr(test, schemars(extend("const" = FORMAT)))]
    format: &'static str,
    built_in: Vec<BuiltIn>,
    serial_ports: Vec<PortReport>,
    inverse_service: ServiceReport,
}

#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct ServiceReport {
    url: String,
    devices: Vec<Inverse3Report>,
    why_none: Option<String>,
}

#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Inverse3Report {
    device_id: String,
    model: String,
    why_not: Option<String>,
    open: String,
}

/// How long a service may take to answer `[s]`.
const PATIENCE: Duration = Duration::from_millis(500);

impl ServiceReport {
    fn of(url: &str) -> Self {
        let service = if url == SERVICE {
            String::new()
        } else {
            format!(" --service {url}")
        };
        let report = |found: Found| Inverse3Report {
            open: format!("--device inverse3 --device-id {}{service}", found.device_id),
            device_id: found.device_id,
            model: found.model,
            why_not: found.unfit.map(|unfit| unfit.to_string()),
        };
        let (devices, why_none) = match inverse3::devices(url, PATIENCE) {
            Ok(found) => (found.into_iter().map(report).collect(), None),
            Err(error) => (Vec::new(), Some(error.to_string())),
        };
        Self {
            url: url.to_owned(),
            devices,
            why_none,
        }
    }
}

#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct BuiltIn {
    device: &'static str,
    what: &'static str,
    open: &'static str,
}

#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct PortReport {
    path: String,
    description: String,
    guess: &'static str,
    likely_haply_2diy: bool,
    open: Option<String>,
}

const BUILT_IN: [BuiltIn; 3] = [
    BuiltIn {
        device: "simulated",
        what: "device and hand of the scene",
        open: "--device simulated",
    },
    BuiltIn {
        device: "replay",
        what: "a recorded motion",
        open: "--device replay --motion REC.mcap",
    },
    BuiltIn {
        device: "null",
        what: "none: at rest at 0",
        open: "--device null",
    },
];

impl From<Port> for PortReport {
    fn from(port: Port) -> Self {
        let board = match port.guess {
            Guess::M0 => " --board m0",
            Guess::M3 | Guess::Arduino | Guess::OtherUsb | Guess::Other => "",
        };
        let open = format!("--device haply-2diy --port {}{board}", port.path);
        Self {
            guess: match port.guess {
                Guess::M0 => "a Haply M0, if it is one of Haply's",
                Guess::M3 => "a Haply M3 or development kit, if it is one of Haply's",
                Guess::Arduino => "perhaps a board of Haply's",
                Guess::OtherUsb | Guess::Other => "not known",
            },
            likely_haply_2diy: port.guess.is_likely(),
            open: port.guess.is_likely().then_some(open),
            path: port.path,
            description: port.description,
        }
    }
}

fn list(arguments: &DevicesArguments) -> Result<(), Failure> {
    let list = List {
        format: FORMAT,
        built_in: BUILT_IN.into(),
        serial_ports: ports()
            .map_err(Failure::System)?
            .into_iter()
            .map(PortReport::from)
            .collect(),
        inverse_service: ServiceReport::of(&arguments.service),
    };
    print_report(&list, arguments.json)
}

impl fmt::Display for List {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "Always there")?;
        for built_in in &self.built_in {
            let BuiltIn { device, what, open } = built_in;
            writeln!(f, "  {device:<10} {what}\n             {open}")?;
        }
        writeln!(f, "\nSerial ports, the likeliest Haply 2DIY first")?;
        if self.serial_ports.is_empty() {
            writeln!(f, "  none; `palpate emulate haply-2diy` gives one to try")?;
        }
        for port in &self.serial_ports {
            writeln!(f, "  {}  {}: {}", port.path, port.description, port.guess)?;
            if let Some(open) = &port.open {
                writeln!(f, "             {open}")?;
            }
        }
        if self.serial_ports.iter().any(|port| port.likely_haply_2diy) {
            writeln!(f, "\nMind that {LATCH_WARNING}.")?;
        }
        let ServiceReport {
            url,
            devices,
            why_none,
        } = &self.inverse_service;
        writeln!(f, "\nInverse3, behind the service at {url}")?;
        if let Some(why) = why_none {
            writeln!(f, "  {why}")?;
        } else if devices.is_empty() {
            writeln!(f, "  the service has none")?;
        }
        for device in devices {
            let fit = device.why_not.as_deref().unwrap_or("ready");
            writeln!(f, "  {}  {}: {fit}", device.device_id, device.model)?;
            writeln!(f, "             {}", device.open)?;
        }
        Ok(())
    }
}

/// Name and version of the JSON report on motors.
#[cfg(unix)]
const MOTORS_FORMAT: &str = "palpate devices check 1";

/// What the motors of a device did.
#[cfg(unix)]
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct MotorsReport {
    board: &'static str,
    #[cfg_attr(test, schemars(extend("const" = MOTORS_FORMAT)))]
    format: &'static str,
    motors: Vec<MotorReport>,
}

/// What a motor did.
#[cfg(unix)]
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct MotorReport {
    /// By how much each joint turned `[degrees]`.
    turned_deg: [f64; 2],
    verdict: &'static str,
}

#[cfg(unix)]
fn check(arguments: &CheckArguments) -> Result<(), Failure> {
    use palpate_device::clock::MonotonicClock;
    use palpate_haply::two_diy::{Unchecked, Verdict};
    use palpate_rt::StopFlag;

    use crate::devices::guarding::Guarding;
    use crate::devices::two_diy;

    if !arguments.may_move {
        return Err(Failure::Arguments(
            "this moves the arm by a few degrees: put it into its start pose, let go of it, and say \
             --move"
                .into(),
        ));
    }
    // Before a torque can be on: a signal that ended the program would leave it on.
    let stop =
        StopFlag::on_signals().map_err(|error| Failure::System(format!("no signals: {error}")))?;
    // A slow answer does no harm here.
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
                Unchecked::Stopped => Failure::Interrupted(format!(
                    "{unchecked}; the board has answered that it holds no torque"
                )),
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
        let motors = checked.iter().map(|checked| MotorReport {
            turned_deg: checked.turned.map(f64::from),
            verdict: checked.verdict.name(),
        });
        let report = MotorsReport {
            board,
            format: MOTORS_FORMAT,
            motors: motors.collect(),
        };
        json(&report) + "\n"
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
        Err(Failure::System("a motor does not do what it should".into()))
    }
}

#[cfg(not(unix))]
fn check(_: &CheckArguments) -> Result<(), Failure> {
    Err(Failure::System(
        "the driver of the 2DIY needs Linux or macOS".into(),
    ))
}
