//! Devices that a loop can run on, opened by their name.
//!
//! A command flattens [`DeviceArguments`] into its own, and calls [`open`] once. What is particular
//! to a device has a file of its own.

mod arguments;
pub mod guarding;
pub mod inverse3;
mod placed;
mod reconnecting;
pub mod replayed;
#[cfg(unix)]
pub mod two_diy;

pub use arguments::{DeviceArguments, DeviceName};

use palpate::AlongAxis;
use palpate_device::clock::Clock;
use palpate_device::{Device, NullDevice};
use palpate_scene::Scene;
use palpate_sim::device::{PointerDevice, PointerHand, PointerParams, SimulatedDevice};

use crate::failure::{Failure, tell};
#[cfg(unix)]
use crate::values::duration;
use guarding::Guarding;
use reconnecting::{Reconnecting, Reopen};

/// A device that is ready, and where the contact's axis lies in it.
pub struct Opened {
    /// The device.
    pub device: Box<dyn Device>,
    /// Origin and direction of the contact's axis in the device's frame.
    pub axis: AlongAxis<f64, 3>,
}

/// Opens the device that `arguments` name, for the scene that will be rendered on it; with a guardian
/// if it holds its last force, unless `arguments` say otherwise.
pub fn open<C: Clock>(
    arguments: &DeviceArguments,
    scene: &Scene,
    clock: &C,
    guarding: &Guarding,
) -> Result<Opened, Failure> {
    arguments.check()?;
    let (device, usual): (Box<dyn Device>, _) = match arguments.device {
        DeviceName::Simulated => {
            let device = SimulatedDevice::of(scene, clock.clone()).map_err(Failure::input)?;
            (Box::new(device), placed::FIRST_AXIS)
        }
        DeviceName::Null => (Box::new(NullDevice::new(clock.clone())), placed::FIRST_AXIS),
        DeviceName::Replay => (replayed::open(arguments, clock)?, placed::FIRST_AXIS),
        DeviceName::Pointer => {
            let params = PointerParams::of(scene);
            let hand = PointerHand::at(params.position);
            let device =
                PointerDevice::new(params, &hand, clock.clone()).map_err(Failure::input)?;
            (Box::new(device), placed::FIRST_AXIS)
        }
        DeviceName::Haply2diy => open_two_diy(arguments, scene, clock, guarding)?,
        DeviceName::Inverse3 => inverse3::open(arguments, scene, clock)?,
    };
    if device.capabilities().holds_last_force && !arguments.is_guarded() {
        tell(
            "warning: --guardian off: if this program is killed or stopped while a force is on, the \
             device holds that force",
        );
    }
    let axis = placed::axis(arguments, device.capabilities(), usual)?;
    Ok(Opened { device, axis })
}

#[cfg(unix)]
fn open_two_diy<C: Clock>(
    arguments: &DeviceArguments,
    scene: &Scene,
    clock: &C,
    guarding: &Guarding,
) -> Result<(Box<dyn Device>, placed::Axis), Failure> {
    if !C::RUNS {
        return Err(Failure::Arguments(
            "--fast is for devices without a motor: this one keeps its own time".into(),
        ));
    }
    let period = duration("--period", scene.loop_params.period)?;
    let axis = two_diy::usual_axis(two_diy::generation(arguments));
    // Only this one is gone on with.
    let arguments = DeviceArguments {
        port: Some(two_diy::port(arguments)?),
        ..arguments.clone()
    };
    let device = two_diy::open(&arguments, period, clock, guarding)?;
    let [first, second] = device.angles();
    tell(format_args!(
        "{}: it counts from here as {first:.1},{second:.1} degrees; if the arm was not in its start \
         pose, forces point in wrong directions",
        device.capabilities().name
    ));
    let device = two_diy::watched(device, !arguments.reconnect);
    if !arguments.reconnect {
        return Ok((device, axis));
    }
    let reopen = two_diy::reopen(arguments, period, clock.clone(), guarding.clone());
    Ok((Box::new(Reconnecting::new(device, reopen)?), axis))
}

#[cfg(not(unix))]
fn open_two_diy<C: Clock>(
    _: &DeviceArguments,
    _: &Scene,
    _: &C,
    _: &Guarding,
) -> Result<(Box<dyn Device>, placed::Axis), Failure> {
    Err(Failure::System(
        "the driver of the 2DIY needs Linux or macOS".into(),
    ))
}
