//! Tick of a world.

use palpate_device::Wrench as Held;
use palpate_world::{IDENTITY, Sample};

use super::{World, WorldOutput, WorldSample, Wrench};
use crate::array::array_mut;
use crate::edge::{caught, status};
use crate::last_error;
use crate::output::Fault;
use crate::sized::{Room, SizedStruct};
use crate::status::{Refusal, Status};

const NONE: Wrench = Wrench {
    force: [0.0; 3],
    torque: [0.0; 3],
    slope: [0.0; 3],
};

/// Executes one tick: takes a sample of all devices and writes the wrenches to hold until the next tick to `wrenches`.
/// `wrench_count` is the number of devices.
///
/// It cannot fail: the wrenches are finite for any input, and all 0 if the sample is rejected or an argument is
/// wrong; the return value is the reason. It does not allocate, lock, wait, or loop without bound. `output` may be
/// NULL. PALPATE_FAULT_ARGUMENT means that an argument is wrong: no tick was executed, and the world is unchanged.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type, `wrenches` to `wrench_count` of them; the first field of
/// each sized struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_step(
    world: *mut World,
    sample: *const WorldSample,
    wrenches: *mut Wrench,
    wrench_count: usize,
    output: *mut WorldOutput,
) -> Fault {
    // SAFETY: guaranteed by the caller.
    unsafe {
        answer("wrenches", wrenches, wrench_count, output, |out| {
            tick(world, sample, out)
        })
    }
}

/// Output of a tick, in addition to the wrenches.
pub(crate) trait TickOutput: SizedStruct {
    /// Returns an empty output with the given fault.
    fn refused(fault: Fault) -> Self;

    /// Returns the reason for rejecting the sample.
    fn fault(&self) -> Fault;
}

/// Runs a fallible tick. On any failure all wrenches are 0, so none of an earlier tick remains.
///
/// # Safety
/// `wrenches` is NULL or points to `wrench_count` wrenches; `output` is NULL or points to a struct whose first field
/// is its size.
pub(crate) unsafe fn answer<O: TickOutput>(
    name: &'static str,
    wrenches: *mut Wrench,
    wrench_count: usize,
    output: *mut O,
    tick: impl FnOnce(&mut [Wrench]) -> Result<O, Refusal<'static>>,
) -> Fault {
    // Check all arguments before the tick: a rejected call must not change the world.
    // SAFETY: guaranteed by the caller.
    let (out, room) = unsafe {
        (
            array_mut(wrenches, wrench_count, name),
            Room::if_asked(output),
        )
    };
    let (out, mut refused) = match out {
        Ok(out) => (out, None),
        Err(refusal) => (&mut [][..], Some(refusal)),
    };
    let room = room.unwrap_or_else(|refusal| {
        refused = Some(refusal);
        None
    });
    out.fill(NONE);
    let said = caught(|| match refused.map_or_else(|| tick(out), Err) {
        Ok(said) => said,
        Err(refusal) => {
            last_error::set(&refusal);
            O::refused(Fault::Argument)
        }
    })
    .unwrap_or(O::refused(Fault::Internal));
    if said.fault() == Fault::Internal {
        // Clear wrenches that were written before the panic.
        out.fill(NONE);
    }
    let fault = said.fault();
    if let Some(room) = room {
        room.write(said);
    }
    fault
}

/// Checks the arguments and executes the tick.
///
/// # Safety
/// As for `palpate_world_step`.
unsafe fn tick(
    world: *mut World,
    sample: *const WorldSample,
    out: &mut [Wrench],
) -> Result<WorldOutput, Refusal<'static>> {
    // SAFETY: guaranteed by the caller.
    let world = unsafe { world.as_mut() }.ok_or(Refusal::Null("world"))?;
    let devices = world.devices.len();
    if out.len() != devices {
        return Err(Refusal::Count {
            name: "wrench_count",
            given: out.len(),
            needed: devices,
            of: ("the world", "devices"),
        });
    }
    // SAFETY: guaranteed by the caller.
    let (sample, poses) = unsafe { WorldSample::at(sample, devices) }?;
    let room = world.positions.iter_mut().zip(&mut world.orientations);
    for ((position, orientation), (pose, device)) in room.zip(poses.iter().zip(&world.devices)) {
        *position = pose.position;
        *orientation = if device.turns {
            pose.orientation
        } else {
            IDENTITY
        };
    }
    let held = world.bounded.step(&Sample {
        positions: &world.positions,
        orientations: &world.orientations,
        elapsed: (sample.has_elapsed != 0).then_some(sample.elapsed),
    });
    let lines = held.wrenches.iter().zip(held.slopes);
    for (out, (Held { force, torque }, slope)) in out.iter_mut().zip(lines) {
        *out = Wrench {
            force: *force,
            torque: *torque,
            slope: *slope,
        };
    }
    Ok(WorldOutput::from(&held))
}

/// Reports the wrench that was actually sent to a device for the last tick, for example after saturation. A non-finite
/// wrench is rejected.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_report_sent(
    world: *mut World,
    device: usize,
    sent: *const Wrench,
) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let world = unsafe { world.as_mut() }.ok_or(Refusal::Null("world"))?;
        // SAFETY: guaranteed by the caller.
        let sent = unsafe { sent.as_ref() }.ok_or(Refusal::Null("sent"))?;
        let devices = world.devices.len();
        if device >= devices {
            return Err(Refusal::Index {
                name: "device",
                given: device,
                count: devices,
            });
        }
        sent.reported()?;
        let Wrench {
            force,
            torque,
            slope,
        } = *sent;
        world
            .bounded
            .report_sent(device, Held { force, torque }, slope);
        Ok(())
    })
}
