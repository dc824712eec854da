//! Multirate local models: a low-rate simulator, such as a 60 Hz physics engine, publishes bodies and contacts; a
//! fast loop renders them.

mod host;
mod model;
mod output;
mod params;
mod progress;

pub use host::*;
pub use model::*;
pub use output::*;
pub use params::*;
pub use progress::*;

use core::ptr;

use palpate_device::Wrench as Held;
use palpate_rt::{BoundedLocalWorld, bounded_local_world};
use palpate_world::Sample;

use crate::edge::status;
use crate::output::Fault;
use crate::sized;
use crate::status::{Refusal, Status};
use crate::world::{Pose, WorldSample, Wrench, answer};

/// Loop side of a multirate local model: renders the published bodies and contacts. Only one thread may use it at a
/// time.
pub struct LocalWorld(BoundedLocalWorld);

/// Creates both sides of a local model and stores them in `*world` and `*host`, or NULL on an error. The loop side
/// belongs to the thread that samples the device, the simulator side to the thread of the simulator; neither waits
/// for the other. Free them, in any order, with palpate_local_world_free and palpate_low_rate_simulator_free.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_local_world_new(
    params: *const LocalParams,
    world: *mut *mut LocalWorld,
    host: *mut *mut LowRateSimulator,
) -> Status {
    status(|| {
        // SAFETY: each is NULL, or a pointer can be written there.
        let (mut world, mut host) = unsafe { (world.as_mut(), host.as_mut()) };
        // Clear both outputs before either is checked for NULL.
        if let Some(world) = &mut world {
            **world = ptr::null_mut();
        }
        if let Some(host) = &mut host {
            **host = ptr::null_mut();
        }
        let world = world.ok_or(Refusal::Null("world"))?;
        let host = host.ok_or(Refusal::Null("host"))?;
        // SAFETY: guaranteed by the caller.
        let params = unsafe { sized::read(params) }?;
        let (of_host, of_loop) = bounded_local_world(params.renderer()?, params.limits()?)
            .map_err(|error| Refusal::Numbers(error.to_string()))?;
        *world = Box::into_raw(Box::new(LocalWorld(of_loop)));
        *host = Box::into_raw(Box::new(LowRateSimulator::new(of_host, params.bodies)));
        Ok(())
    })
}

/// Frees the loop side of a local model. NULL is allowed.
///
/// # Safety
/// `world` is NULL or a loop side, and is not used afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_local_world_free(world: *mut LocalWorld) {
    if !world.is_null() {
        // SAFETY: allocated with `Box::into_raw` by `palpate_local_world_new`, and not used afterwards.
        drop(unsafe { Box::from_raw(world) });
    }
}

/// Executes one tick with the newest published model: takes a device sample with one pose and writes the wrench to
/// hold until the next tick to `*wrench`. The orientation is ignored, and the torque is 0.
///
/// It cannot fail: the wrench is finite for any input, and 0 if the sample is rejected or an argument is wrong; the
/// return value is the reason. It does not allocate, lock, wait, or loop without bound. `output` may be NULL.
/// PALPATE_FAULT_ARGUMENT means that an argument is wrong and no tick was executed.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_local_world_step(
    world: *mut LocalWorld,
    sample: *const WorldSample,
    wrench: *mut Wrench,
    output: *mut LocalOutput,
) -> Fault {
    // SAFETY: guaranteed by the caller.
    unsafe {
        answer("wrench", wrench, 1, output, |out| {
            let world = world.as_mut().ok_or(Refusal::Null("world"))?;
            let (sample, poses) = WorldSample::at(sample, 1)?;
            let [out] = out else {
                return Err(Refusal::Null("wrench"));
            };
            let [Pose { position, .. }] = poses else {
                return Err(Refusal::Null("poses"));
            };
            let positions = [*position];
            let held = world.0.step(&Sample {
                elapsed: (sample.has_elapsed != 0).then_some(sample.elapsed),
                ..Sample::at(&positions)
            });
            if let Some(Held { force, torque }) = held.wrenches.first() {
                *out = Wrench {
                    force: *force,
                    torque: *torque,
                    slope: [0.0; 3],
                };
            }
            Ok(LocalOutput::from(&held))
        })
    }
}

/// Reports the force that was actually sent to the device for the last tick, for example after saturation. A non-finite
/// force is rejected.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_local_world_report_sent(
    world: *mut LocalWorld,
    sent: *const Wrench,
) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let world = unsafe { world.as_mut() }.ok_or(Refusal::Null("world"))?;
        // SAFETY: guaranteed by the caller.
        let sent = unsafe { sent.as_ref() }.ok_or(Refusal::Null("sent"))?;
        sent.reported()?;
        let Wrench { force, torque, .. } = *sent;
        world.0.report_sent(0, Held { force, torque });
        Ok(())
    })
}
