//! Local models: a slow host, such as a physics engine of 60 Hz, publishes bodies and contacts, and a fast loop renders them.

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

/// What a slow host publishes, as the fast loop renders it: the loop's end. One thread at a time may use it.
pub struct LocalWorld(BoundedLocalWorld);

/// Makes both ends of a local model, and puts them into `*world` and `*host`; NULL on an error. The loop's end belongs to the
/// thread that samples the device, the host's end to the thread of the host; neither ever waits for the other one. Each is to be
/// freed, in any order, by palpate_local_world_free and palpate_slow_host_free.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_local_world_new(
    params: *const LocalParams,
    world: *mut *mut LocalWorld,
    host: *mut *mut SlowHost,
) -> Status {
    status(|| {
        // SAFETY: each is NULL, or a pointer can be written there.
        let (mut world, mut host) = unsafe { (world.as_mut(), host.as_mut()) };
        // Both, before either is asked for: whichever is there says what became of it.
        if let Some(world) = &mut world {
            **world = ptr::null_mut();
        }
        if let Some(host) = &mut host {
            **host = ptr::null_mut();
        }
        let world = world.ok_or(Refusal::Null("world"))?;
        let host = host.ok_or(Refusal::Null("host"))?;
        // SAFETY: as the caller says.
        let params = unsafe { sized::read(params) }?;
        let (of_host, of_loop) = bounded_local_world(params.renderer()?, params.limits()?)
            .map_err(|error| Refusal::Numbers(error.to_string()))?;
        *world = Box::into_raw(Box::new(LocalWorld(of_loop)));
        *host = Box::into_raw(Box::new(SlowHost::new(of_host, params.bodies)));
        Ok(())
    })
}

/// Frees the loop's end of a local model. NULL is allowed.
///
/// # Safety
/// `world` is NULL or such an end, and is not used afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_local_world_free(world: *mut LocalWorld) {
    if !world.is_null() {
        // SAFETY: `palpate_local_world_new` has made it by `Box::into_raw`, and it is not used afterwards.
        drop(unsafe { Box::from_raw(world) });
    }
}

/// One tick: takes a sample of the device, with one pose, and puts what it is to hold until the next one into `*wrench`, by the
/// newest model that the host has published. The orientation is not looked at, and the torque is 0.
///
/// It cannot fail: the wrench has finite numbers for any input, and is all 0 where a sample is refused or an argument is wrong;
/// what it gives says why. It does not allocate, lock, wait, or loop without bound. `output` may be NULL. Where an argument is
/// wrong, PALPATE_FAULT_ARGUMENT, there was no tick.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_local_world_step(
    world: *mut LocalWorld,
    sample: *const WorldSample,
    wrench: *mut Wrench,
    output: *mut LocalOutput,
) -> Fault {
    // SAFETY: as the caller says.
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
                };
            }
            Ok(LocalOutput::from(&held))
        })
    }
}

/// Says what was really sent to the device for the last tick, where it is another force than the tick has given: something
/// between has limited it. What is not finite is refused.
///
/// # Safety
/// Each pointer is NULL or to what its type says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_local_world_report_sent(
    world: *mut LocalWorld,
    sent: *const Wrench,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let world = unsafe { world.as_mut() }.ok_or(Refusal::Null("world"))?;
        // SAFETY: as the caller says.
        let sent = unsafe { sent.as_ref() }.ok_or(Refusal::Null("sent"))?;
        sent.reported()?;
        let Wrench { force, torque } = *sent;
        world.0.report_sent(0, Held { force, torque });
        Ok(())
    })
}
