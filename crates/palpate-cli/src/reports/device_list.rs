//! Devices that a loop can run on here.

use std::fmt;
use std::time::Duration;

use palpate_drivers::inverse3::{self, Found, SERVICE};
use palpate_drivers::two_diy::{Guess, Port, ports};
use palpate_study::text::{hanging, wrapped};
use serde::Serialize;

/// Name and version of the JSON report.
const FORMAT: &str = "palpate devices 1";

/// Warning for every 2DIY, since it can cause injury.
pub const LATCH_WARNING: &str = "the board of a 2DIY has no watchdog: if the cable is pulled, it may \
     hold its last torque until its power is switched off; if the program is killed, a watchdog sets the torque to \
     0, unless the program runs with --watchdog off";

/// Devices that a loop can run on here.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct DeviceList {
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

/// Time limit for the answer of a service.
const PATIENCE: Duration = Duration::from_millis(500);

impl ServiceReport {
    fn new(url: &str) -> Self {
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
        what: "no device: at rest at 0",
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
                Guess::M0 => "a Haply M0, if it is a Haply board",
                Guess::M3 => "a Haply M3 or development kit, if it is a Haply board",
                Guess::Arduino => "possibly a Haply board",
                Guess::OtherUsb | Guess::Other => "unknown",
            },
            likely_haply_2diy: port.guess.is_likely(),
            open: port.guess.is_likely().then_some(open),
            path: port.path,
            description: port.description,
        }
    }
}

impl DeviceList {
    /// Lists the built-in devices, the devices on serial ports, and the devices of the Inverse Service at `service`.
    ///
    /// # Errors
    /// The serial ports cannot be listed.
    pub fn new(service: &str) -> Result<Self, String> {
        Ok(Self {
            format: FORMAT,
            built_in: BUILT_IN.into(),
            serial_ports: ports()?.into_iter().map(PortReport::from).collect(),
            inverse_service: ServiceReport::new(service),
        })
    }
}

impl fmt::Display for DeviceList {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "Built in")?;
        for built_in in &self.built_in {
            let BuiltIn { device, what, open } = built_in;
            writeln!(f, "  {device:<10} {what}\n             {open}")?;
        }
        writeln!(f, "\nSerial ports, the most likely Haply 2DIY first")?;
        if self.serial_ports.is_empty() {
            writeln!(
                f,
                "  none; `palpate devices emulate haply-2diy` emulates one"
            )?;
        }
        for port in &self.serial_ports {
            let said = format!("  {}  {}: {}", port.path, port.description, port.guess);
            writeln!(f, "{}", hanging(&said, 4))?;
            if let Some(open) = &port.open {
                writeln!(f, "             {open}")?;
            }
        }
        if self.serial_ports.iter().any(|port| port.likely_haply_2diy) {
            writeln!(f, "\n{}", wrapped(&format!("Note: {LATCH_WARNING}.")))?;
        }
        let ServiceReport {
            url,
            devices,
            why_none,
        } = &self.inverse_service;
        writeln!(f, "\nInverse3, from the service at {url}")?;
        if let Some(why) = why_none {
            writeln!(f, "{}", hanging(&format!("  {why}"), 4))?;
        } else if devices.is_empty() {
            writeln!(f, "  the service has none")?;
        }
        for device in devices {
            let fit = device.why_not.as_deref().unwrap_or("ready");
            let said = format!("  {}  {}: {fit}", device.device_id, device.model);
            writeln!(f, "{}", hanging(&said, 4))?;
            writeln!(f, "             {}", device.open)?;
        }
        Ok(())
    }
}
