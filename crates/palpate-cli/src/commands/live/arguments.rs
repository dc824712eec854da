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
    /// What stands on the command line; first, since whatever is read from it is gone for those behind.
    #[command(flatten)]
    pub given: Given,
    /// Scene file (TOML): contact, loop, method and device; or a world [default: a light block at 100 Hz]
    #[arg(value_name = "SCENE.toml", value_hint = ValueHint::FilePath)]
    pub scene: Option<PathBuf>,
    /// Record from the first tick on (MCAP); of two methods each has its own file. What the page
    /// records goes beside it, else to the current folder; no file is overwritten
    #[arg(long, value_name = "REC.mcap", value_hint = ValueHint::FilePath)]
    pub record: Option<PathBuf>,
    /// How long [s]; inf: until ctrl-C, which ends it at any time
    #[arg(long, value_name = "s", default_value = "inf", value_parser = number)]
    pub duration: f64,
    /// Where the page is served; a port of 0 takes any that is free
    #[arg(long, value_name = "ADDRESS:PORT", default_value_t = palpate_scope::DEFAULT_ADDRESS,
          value_parser = address, help_heading = "Page")]
    pub listen: SocketAddr,
    /// A name by which browsers may call this server, beside localhost and addresses
    #[arg(long, value_name = "NAME[:PORT]", help_heading = "Page")]
    pub allow_host: Vec<String>,
    /// The device.
    #[command(flatten)]
    pub device: DeviceArguments,
    /// What the machine is asked for.
    #[command(flatten)]
    pub realtime: RealtimeArguments,
    /// Limits between renderer and device.
    #[command(flatten)]
    pub safety: SafetyArguments,
    /// Contact, loop, method and device.
    #[command(flatten)]
    pub flags: Flags,
}

/// An address and a port; `localhost` is an address, too.
fn address(text: &str) -> Result<SocketAddr, String> {
    let needed = || "an address and a port are needed, such as 127.0.0.1:7777".to_owned();
    let mut found = text.to_socket_addrs().map_err(|_| needed())?;
    found.next().ok_or_else(needed)
}
