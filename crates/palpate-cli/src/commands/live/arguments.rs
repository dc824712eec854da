//! Arguments of `live`.

use std::net::{SocketAddr, ToSocketAddrs};
use std::path::PathBuf;

use clap::{Args, ValueHint};

use crate::arguments::{Flags, Given};
use crate::commands::run::{RealtimeArguments, SafetyArguments};
use crate::devices::DeviceArguments;
use crate::values::number;

/// Arguments of `live`.
#[derive(Args, Debug)]
pub struct LiveArguments {
    /// Flags on the command line. First field, because clap removes values in the order of the fields.
    #[command(flatten)]
    pub given: Given,
    /// Scene file (TOML): contact, loop, method and device; or a world [default: a light block at 100 Hz]
    #[arg(value_name = "SCENE.toml", value_hint = ValueHint::FilePath)]
    pub scene: Option<PathBuf>,
    /// Record from the first tick on (MCAP); with two methods, each into its own file. Recordings started on the page
    /// go to the same folder, else to the current one; no file is overwritten
    #[arg(long, value_name = "REC.mcap", value_hint = ValueHint::FilePath)]
    pub record: Option<PathBuf>,
    /// Duration [s]; inf: until ctrl-C, which ends it at any time
    #[arg(long, value_name = "s", default_value = "inf", value_parser = number)]
    pub duration: f64,
    /// Address of the page; port 0 selects any free port
    #[arg(long, value_name = "ADDRESS:PORT", default_value_t = palpate_live::DEFAULT_ADDRESS,
          value_parser = address, help_heading = "Page")]
    pub listen: SocketAddr,
    /// Additional host name of this server, besides localhost and addresses
    #[arg(long, value_name = "NAME[:PORT]", help_heading = "Page")]
    pub allow_host: Vec<String>,
    /// The device.
    #[command(flatten)]
    pub device: DeviceArguments,
    /// Requests to the machine.
    #[command(flatten)]
    pub realtime: RealtimeArguments,
    /// Limits between renderer and device.
    #[command(flatten)]
    pub safety: SafetyArguments,
    /// Contact, loop, method and device.
    #[command(flatten)]
    pub flags: Flags,
}

/// Parses an address and a port; `localhost` is accepted.
fn address(text: &str) -> Result<SocketAddr, String> {
    let needed = || "an address and a port are needed, such as 127.0.0.1:7777".to_owned();
    let mut found = text.to_socket_addrs().map_err(|_| needed())?;
    found.next().ok_or_else(needed)
}
