//! Force Dimension's devices: their setup from flags, and their messages.

use palpate_device::Device;
use palpate_device::clock::Clock;
use palpate_drivers::force_dimension::{ForceDimension, OpenError, Options, Part};
use palpate_drivers::prepared::Reopen;

use super::arguments::ForceDimensionArguments;
use super::{DeviceArguments, reconnecting};
use crate::failure::{Failure, tell};
use crate::reports::Guarding;
use crate::values::duration;

impl ForceDimensionArguments {
    fn options(&self, period: f64, guarding: &Guarding) -> Result<Options, Failure> {
        Ok(Options {
            library: self.library.clone(),
            serial: self.serial,
            part: if self.gripper {
                Part::Gripper
            } else {
                Part::Handle
            },
            gravity_compensation: !self.no_gravity_compensation,
            ..Options::new(duration("--period", period)?, guarding.limit)
        })
    }
}

/// Opens the device for a loop of `period` `[s]`. Returns it with its identity.
pub fn open<C: Clock>(
    arguments: &DeviceArguments,
    period: f64,
    clock: &C,
    guarding: &Guarding,
) -> Result<(Box<dyn Device>, String), Failure> {
    if !C::RUNS {
        return Err(Failure::Arguments(
            "--fast is for devices without a motor; this one runs in real time".into(),
        ));
    }
    let options = arguments.force_dimension.options(period, guarding)?;
    let device = ForceDimension::open(&options, clock.clone(), tell).map_err(refused)?;
    let name = device.capabilities().name.clone();
    if let Some(limit) = device.watchdog() {
        tell(format_args!(
            "{name}: its firmware takes the force off {} ms after the last command",
            limit.as_secs_f64() * 1e3
        ));
    }
    if let Some(mass) = device.mass() {
        let listed = |of: &[f64]| {
            let of: Vec<_> = of.iter().map(|value| format!("{value:.4}")).collect();
            of.join(", ")
        };
        tell(format_args!(
            "{name}: the mean mass at the present pose is {:.3} kg, for --device-mass; for a mass_table: [{}] kg at [{}] m",
            mass.mean(),
            listed(&mass.matrix),
            listed(&mass.position)
        ));
    }
    let identity = format!("device {} of Force Dimension's library", device.id());
    let device: Box<dyn Device> = Box::new(device);
    if !arguments.reconnect {
        return Ok((device, identity));
    }
    let (clock, axes) = (clock.clone(), device.capabilities().clone());
    let reopen: Reopen = Box::new(move || {
        let device = ForceDimension::open(&options, clock.clone(), tell);
        let device = device.map_err(|error| error.to_string())?;
        let found = device.capabilities();
        if (&found.name, found.holds_last_force) != (&axes.name, axes.holds_last_force) {
            return Err("the device that is back is another one".into());
        }
        Ok(Box::new(device))
    });
    Ok((reconnecting(device, reopen)?, identity))
}

fn refused(error: OpenError) -> Failure {
    match error {
        OpenError::Several(_) => Failure::Arguments(format!("{error} (--serial)")),
        OpenError::NotFound(_) => Failure::System(format!("{error} (--library)")),
        OpenError::NoGripper(_) | OpenError::TooSlow { .. } => {
            Failure::Arguments(error.to_string())
        }
        _ => Failure::System(error.to_string()),
    }
}
