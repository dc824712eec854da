//! Devices for a loop, opened by name.
//!
//! A command flattens [`DeviceArguments`] into its own, and calls [`open`] once. Each device has its own module.

mod arguments;
mod drive;
mod force_dimension;
#[cfg(unix)]
pub mod guarding;
pub mod inverse3;
mod motor_drive;
mod own;
mod placed;
pub mod replayed;
mod several;
#[cfg(unix)]
pub mod two_diy;
mod watched;

pub use arguments::{DeviceArguments, DeviceName};
pub use drive::drive;
pub use several::{FLAGS_OF_A_DEVICE, kinds, names, open_for_world};
pub use watched::Watched;

use palpate_core::AlongAxis;
use palpate_device::clock::Clock;
use palpate_device::{Device, NullDevice, Vector};
use palpate_drivers::prepared::{Axis, FIRST_AXIS, Reconnecting, Reopen};
use palpate_rt::WorldFrame;
use palpate_scene::Scene;
use palpate_scene::world::WorldScene;
use palpate_study::sim::device::{
    PointerDevice, PointerHand, PointerParams, SimulatedDevice, SpatialDevice, SpatialHand,
    SpatialPointer,
};

use crate::failure::{Failure, tell};
use crate::reports::Guarding;
#[cfg(unix)]
use crate::values::duration;
#[cfg(unix)]
use palpate_drivers::prepared::two_diy::{identity, usual_axis};

/// Ratio of the masses of a device and of its model from which a warning is given.
const ANOTHER_MASS: f64 = 2.0;

/// Warns of a device whose own mass differs clearly from that of the renderer's `model` `[kg]`.
fn warn_of_another_mass(device: &dyn Device, model: f64) {
    let can = device.capabilities();
    if let Some(mass) = can.effective_mass
        && (mass > ANOTHER_MASS * model || model > ANOTHER_MASS * mass)
    {
        tell(format_args!(
            "warning: {} states a mass of {mass} kg, but the renderer's model has {model} kg; --device-mass {mass} sets it",
            can.name
        ));
    }
}

/// An open device with the contact's axis in its frame.
pub struct Opened {
    /// The device.
    pub device: Box<dyn Device>,
    /// Origin and direction of the contact's axis in the device's frame.
    pub axis: AlongAxis<f64, 3>,
}

/// Opens the device in `arguments` for the scene to render, with a watchdog process if it holds its last force, unless
/// `arguments` disable it.
pub fn open<C: Clock>(
    arguments: &DeviceArguments,
    scene: &Scene,
    clock: &C,
    guarding: &Guarding,
) -> Result<Opened, Failure> {
    arguments.check()?;
    if arguments.world_axes.is_some() {
        return Err(Failure::Arguments(
            "--world-axes is for a world; a scene of one contact has --normal".into(),
        ));
    }
    let (device, usual): (Box<dyn Device>, _) = match arguments.kind() {
        DeviceName::Simulated => {
            let device = SimulatedDevice::new(scene, clock.clone()).map_err(Failure::input)?;
            (Box::new(device), FIRST_AXIS)
        }
        DeviceName::Null => (Box::new(NullDevice::new(clock.clone())), FIRST_AXIS),
        DeviceName::Replay => (replayed::open(arguments, clock)?, FIRST_AXIS),
        DeviceName::Pointer => {
            let params = PointerParams::new(scene);
            let hand = PointerHand::at(params.position);
            let device =
                PointerDevice::new(params, &hand, clock.clone()).map_err(Failure::input)?;
            (Box::new(device), FIRST_AXIS)
        }
        DeviceName::Haply2diy => {
            let (device, axis, _) =
                open_two_diy(arguments, scene.loop_params.period, clock, guarding)?;
            (device, axis)
        }
        DeviceName::Inverse3 => {
            let (device, mut origin, _) =
                inverse3::open(arguments, scene.loop_params.period, clock)?;
            // The present position of the cursor corresponds to the scene's start position of the device.
            let direction = inverse3::direction(arguments);
            for (origin, along) in origin.iter_mut().zip(direction) {
                *origin -= along * scene.device.position();
            }
            (device, (origin, FIRST_AXIS.1))
        }
        DeviceName::ForceDimension => {
            let period = scene.loop_params.period;
            let (device, _) = force_dimension::open(arguments, period, clock, guarding)?;
            (device, FIRST_AXIS)
        }
        DeviceName::Process
        | DeviceName::Udp
        | DeviceName::Plugin
        | DeviceName::Moteus
        | DeviceName::Odrive => {
            let period = scene.loop_params.period;
            let (device, _) = own::open(arguments, period, clock, guarding)?;
            let model = scene.model_device_mass.unwrap_or(scene.device.mass());
            warn_of_another_mass(device.as_ref(), model);
            (device, FIRST_AXIS)
        }
    };
    warn_if_unguarded(device.as_ref(), arguments);
    let axis = placed::axis(arguments, device.capabilities(), usual)?;
    Ok(Opened { device, axis })
}

/// An open device with its frame in a world.
pub struct OpenedInWorld {
    /// The device.
    pub device: Box<dyn Device>,
    /// Its frame.
    pub frame: WorldFrame,
    /// Identity of a real device, unique on this machine.
    identity: Option<String>,
}

/// Opens the device in `arguments` as the device of a world at the index `number`, as [`open`] does for one contact.
/// `hand` moves the device `pointer`; without a hand that device stays at its start.
fn open_as<C: Clock>(
    (scene, number): (&WorldScene, usize),
    arguments: &DeviceArguments,
    clock: &C,
    guarding: &Guarding,
    hand: Option<&SpatialHand>,
) -> Result<OpenedInWorld, Failure> {
    arguments.check()?;
    let own = &scene.devices[number];
    let mut identity = None;
    let period = scene.timing.period;
    let wrong = |error: palpate_testbed::InvalidParameter| Failure::input(error);
    // The device position that corresponds to its tool's start position in the world.
    let (device, usual): (Box<dyn Device>, Option<Vector>) = match arguments.kind() {
        DeviceName::Simulated => {
            let device = SpatialDevice::new(scene, number, clock.clone());
            (Box::new(device.map_err(wrong)?), None)
        }
        DeviceName::Pointer => {
            let hand = hand
                .cloned()
                .unwrap_or_else(|| SpatialHand::at(own.position));
            let device = SpatialPointer::new(scene, number, &hand, clock.clone());
            (Box::new(device.map_err(wrong)?), None)
        }
        DeviceName::Null | DeviceName::Replay => {
            return Err(Failure::Arguments(
                "--device: a world runs on simulated, pointer, haply-2diy, inverse3, force-dimension, moteus, odrive, \
                 process, udp and plugin; null and replay have one axis"
                    .into(),
            ));
        }
        DeviceName::Haply2diy => {
            let (device, (origin, _), port) = open_two_diy(arguments, period, clock, guarding)?;
            identity = Some(port);
            (device, Some(origin))
        }
        DeviceName::Inverse3 => {
            let (device, origin, at) = inverse3::open(arguments, period, clock)?;
            identity = Some(at);
            (device, Some(origin))
        }
        DeviceName::ForceDimension => {
            let (device, which) = force_dimension::open(arguments, period, clock, guarding)?;
            identity = Some(which);
            (device, None)
        }
        DeviceName::Process
        | DeviceName::Udp
        | DeviceName::Plugin
        | DeviceName::Moteus
        | DeviceName::Odrive => {
            let (device, at) = own::open(arguments, period, clock, guarding)?;
            identity = at;
            (device, None)
        }
    };
    let is_simulated = matches!(
        arguments.kind(),
        DeviceName::Simulated | DeviceName::Pointer
    );
    let tool = &scene.world.tools[number];
    if is_simulated && tool.mass_table.is_some() {
        tell(format_args!(
            "warning: the mass_table of {} is for the renderer and for `simulate`; the device {} has its mass at the \
             start everywhere",
            tool.name,
            device.capabilities().name
        ));
    }
    warn_if_unguarded(device.as_ref(), arguments);
    let frame = placed::frame(arguments, device.capabilities(), usual, own.position)?;
    Ok(OpenedInWorld {
        device,
        frame,
        identity,
    })
}

fn warn_if_unguarded(device: &dyn Device, arguments: &DeviceArguments) {
    if device.capabilities().holds_last_force && !arguments.is_guarded() {
        let why = match arguments.kind() {
            DeviceName::Plugin => "no watchdog process reaches the device of a plug-in",
            DeviceName::ForceDimension => {
                "the firmware of this device has no watchdog, and no watchdog process reaches it"
            }
            _ if cfg!(not(unix)) => "a watchdog process needs Linux or macOS",
            _ => "--watchdog off",
        };
        tell(format_args!(
            "warning: {why}: if this program is killed or stopped while a force is on, the device holds that force"
        ));
    }
}

#[cfg(unix)]
fn open_two_diy<C: Clock>(
    arguments: &DeviceArguments,
    period_seconds: f64,
    clock: &C,
    guarding: &Guarding,
) -> Result<(Box<dyn Device>, Axis, String), Failure> {
    if !C::RUNS {
        return Err(Failure::Arguments(
            "--fast is for devices without a motor; this one runs in real time".into(),
        ));
    }
    let period = duration("--period", period_seconds)?;
    let mut setup = two_diy::setup(arguments);
    let axis = usual_axis(setup.generation);
    // Reconnect only to the same device.
    let port = setup.port().map_err(two_diy::no_port)?;
    let identity = identity(&port);
    setup.port = Some(port);
    let guarding = arguments.is_guarded().then_some(guarding);
    let device = two_diy::open(&setup, period, clock, guarding)?;
    let [first, second] = device.angles();
    tell(format_args!(
        "{}: the present pose counts as {first:.1},{second:.1} degrees; if the arm was not in its start pose, forces \
         point in wrong directions",
        device.capabilities().name
    ));
    let device = two_diy::watched(device, !arguments.reconnect);
    if !arguments.reconnect {
        return Ok((device, axis, identity));
    }
    let reopen = two_diy::reopen(
        setup,
        arguments.reconnect_in_start_pose,
        period,
        clock.clone(),
        guarding.cloned(),
    );
    Ok((reconnecting(device, reopen)?, axis, identity))
}

/// Returns a device that is awaited after its loss.
fn reconnecting(device: Box<dyn Device>, reopen: Reopen) -> Result<Box<dyn Device>, Failure> {
    Reconnecting::new(device, reopen, |words| tell(words))
        .map(|device| Box::new(device) as Box<dyn Device>)
        .map_err(|error| Failure::System(format!("cannot start the reconnecting thread: {error}")))
}

#[cfg(not(unix))]
fn open_two_diy<C: Clock>(
    _: &DeviceArguments,
    _: f64,
    _: &C,
    _: &Guarding,
) -> Result<(Box<dyn Device>, Axis, String), Failure> {
    Err(Failure::System(
        "the driver of the 2DIY needs Linux or macOS".into(),
    ))
}
