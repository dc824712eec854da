//! User-defined devices: their setup from flags, and their messages.

use std::time::Duration;

use palpate_device::Device;
use palpate_device::clock::Clock;
use palpate_drivers::external::{External, OpenError, Place};
use palpate_drivers::plugin::Plugin;
use palpate_drivers::prepared::Reopen;

use super::arguments::OwnDevice;
use super::{DeviceArguments, motor_drive, reconnecting};
use crate::failure::{Failure, tell};
use crate::reports::Guarding;
use crate::values::duration;

/// Opens the device for a loop of `period` `[s]`, with a watchdog process unless `arguments` disable it. Returns it with
/// its identity.
pub fn open<C: Clock>(
    arguments: &DeviceArguments,
    period: f64,
    clock: &C,
    guarding: &Guarding,
) -> Result<(Box<dyn Device>, Option<String>), Failure> {
    if !C::RUNS {
        return Err(Failure::Arguments(
            "--fast is for devices without a motor; this one runs in real time".into(),
        ));
    }
    match arguments.own() {
        Some(OwnDevice::Program(place)) => program(place, arguments, period, clock, guarding),
        Some(OwnDevice::Plugin { library, argument }) => {
            let device = Plugin::open(library, argument, clock.clone(), tell);
            let device = device.map_err(|error| {
                Failure::System(format!("the plug-in {}: {error}", library.display()))
            })?;
            let identity = format!("plugin:{},{argument}", library.display());
            Ok((Box::new(device), Some(identity)))
        }
        Some(OwnDevice::Drive(drive)) => {
            let (device, identity) =
                motor_drive::open(drive, arguments.reconnect, period, clock, guarding)?;
            Ok((device, Some(identity)))
        }
        None => {
            let needed = "--device: process:COMMAND, udp:ADDRESS:PORT or plugin:LIBRARY is needed";
            Err(Failure::Arguments(needed.into()))
        }
    }
}

/// Opens the device of another program.
fn program<C: Clock>(
    place: &Place,
    arguments: &DeviceArguments,
    period: f64,
    clock: &C,
    guarding: &Guarding,
) -> Result<(Box<dyn Device>, Option<String>), Failure> {
    if let Place::Udp(address) = place
        && !address.ip().is_loopback()
        && !arguments.allow_remote
    {
        return Err(Failure::Arguments(format!(
            "--device udp:{address}: this address is on another machine; --allow-remote permits it, for packets that are \
             neither encrypted nor authenticated"
        )));
    }
    let times = (duration("--period", period)?, guarding.limit);
    let guarding = arguments.is_guarded().then(|| guarding.clone());
    let device = open_once(place, times, clock, guarding.as_ref()).map_err(refused)?;
    if let Some(round_trip) = device.round_trip() {
        let seconds = round_trip.as_secs_f64();
        tell(format_args!(
            "{}: the round trip takes {:.2} ms",
            device.capabilities().name,
            seconds * 1e3
        ));
        if seconds > 0.5 * period {
            tell(format_args!(
                "warning: that exceeds half the period of {:.2} ms: ticks will have no sample in time; use --period {}",
                period * 1e3,
                (seconds * 3.0 * 1e4).ceil() / 1e4
            ));
        }
    }
    let identity = place.identity();
    let device: Box<dyn Device> = Box::new(device);
    if !arguments.reconnect {
        return Ok((device, identity));
    }
    let (place, clock) = (place.clone(), clock.clone());
    let axes = device.capabilities().clone();
    let reopen: Reopen = Box::new(move || {
        let device = open_once(&place, times, &clock, guarding.as_ref());
        let device = device.map_err(|error| error.to_string())?;
        if *device.capabilities() != axes {
            return Err("the device that is back has other capabilities".into());
        }
        Ok(Box::new(device))
    });
    Ok((reconnecting(device, reopen)?, identity))
}

fn open_once<C: Clock>(
    place: &Place,
    times: (Duration, Duration),
    clock: &C,
    guarding: Option<&Guarding>,
) -> Result<External<C>, OpenError> {
    let device = External::open(place, times, clock.clone(), tell)?;
    #[cfg(unix)]
    if let Some(guarding) = guarding {
        use palpate_rt::watchdog::WatchdogError;
        let guard = super::guarding::guard(guarding);
        let guard = guard.map_err(|error| OpenError::Watchdog(WatchdogError::Spawn(error)))?;
        return device.guarded_by(guard);
    }
    #[cfg(not(unix))]
    let _ = guarding;
    Ok(device)
}

fn refused(error: OpenError) -> Failure {
    #[cfg(unix)]
    if let OpenError::Watchdog(_) = error {
        return Failure::System(format!(
            "the device of your own: {error}; --watchdog off disables it"
        ));
    }
    Failure::System(format!("the device of your own: {error}"))
}
