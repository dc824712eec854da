//! The Haply Inverse3 behind its service.

use palpate_device::clock::Clock;
use palpate_device::{Device, Vector};
use palpate_drivers::inverse3::{
    ConnectError, Inverse3, Inverse3Options, OpenError, Pace, SERVICE,
};
use palpate_drivers::prepared::inverse3::{Overheard, identity};
use palpate_drivers::prepared::{FIRST_AXIS, Reopen};

use super::arguments::Inverse3Arguments;
use super::{DeviceArguments, reconnecting};
use crate::failure::{Failure, tell};
use crate::values::duration;

/// One below the priority of a loop.
const PRIORITY: u8 = 79;

impl Inverse3Arguments {
    fn options(&self) -> Inverse3Options {
        let priority = self.service_priority.unwrap_or(PRIORITY);
        Inverse3Options {
            service: self.service.clone().unwrap_or_else(|| SERVICE.to_owned()),
            events: self.events.clone(),
            device_id: self.device_id.clone(),
            priority: (priority > 0).then_some(priority),
            ..Inverse3Options::default()
        }
    }
}

/// Opens the device for a loop of `period` `[s]`. Returns it with the position of its cursor `[m]` and its identity.
pub fn open<C: Clock>(
    arguments: &DeviceArguments,
    period: f64,
    clock: &C,
) -> Result<(Box<dyn Device>, Vector, String), Failure> {
    if !C::RUNS {
        return Err(Failure::Arguments(
            "--fast is for devices without a motor; this one runs in real time".into(),
        ));
    }
    let mut options = arguments.inverse3.options();
    options.pace = Pace::for_period(duration("--period", period)?);
    let device = Inverse3::open(&options, clock.clone()).map_err(refused)?;
    // Reconnect only to the same device.
    options.device_id = Some(device.device_id().to_owned());
    let round_trip = device.round_trip().as_secs_f64();
    tell(format_args!(
        "Inverse3 {}: the round trip to its service takes {:.2} ms",
        device.device_id(),
        round_trip * 1e3
    ));
    if round_trip > period {
        tell(format_args!(
            "warning: that exceeds the period of {:.2} ms: some ticks will have no sample, and from twice the period \
             on there will be no force; use --period {}",
            period * 1e3,
            (round_trip * 1.5 * 1e4).ceil() / 1e4
        ));
    }
    let opened_at = device.opened_at();
    let identity = identity(&options.service, device.device_id());
    let device = watched(device, !arguments.reconnect);
    if !arguments.reconnect {
        return Ok((device, opened_at, identity));
    }
    let clock = clock.clone();
    let reopen: Reopen = Box::new(move || {
        let device = Inverse3::open(&options, clock.clone()).map_err(|error| error.to_string())?;
        Ok(watched(device, false))
    });
    Ok((reconnecting(device, reopen)?, opened_at, identity))
}

fn watched<C: Clock>(device: Inverse3<C>, says_why: bool) -> Box<dyn Device> {
    Box::new(Overheard::new(device, says_why, tell))
}

/// Returns the unit direction of the contact's axis. An invalid direction is rejected where the axis is placed.
pub fn direction(arguments: &DeviceArguments) -> Vector {
    let Some(&[x, y, z]) = arguments.normal.as_ref().map(|place| &place.0[..]) else {
        return FIRST_AXIS.1;
    };
    let length = (x * x + y * y + z * z).sqrt();
    if length > 0.0 && length.is_finite() {
        [x / length, y / length, z / length]
    } else {
        FIRST_AXIS.1
    }
}

fn refused(error: OpenError) -> Failure {
    match error {
        OpenError::Connect(ConnectError::Address { .. })
        | OpenError::Several { .. }
        | OpenError::NotThere { .. } => Failure::Arguments(error.to_string()),
        _ => Failure::System(error.to_string()),
    }
}
