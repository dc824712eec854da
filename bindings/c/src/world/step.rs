//! A tick of a world.

use palpate_device::Wrench as Held;
use palpate_world::{NOT_TURNED, Sample};

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
};

/// One tick: takes a sample of all devices, and puts what each of them is to hold until the next one into `wrenches`, of
/// which there are `wrench_count`, one for each device.
///
/// It cannot fail: the wrenches are finite numbers for any input, and all 0 where a sample is refused or an argument is
/// wrong; what it gives says why. It does not allocate, lock, wait, or loop without bound. `output` may be NULL. Where an
/// argument is wrong, PALPATE_FAULT_ARGUMENT, there was no tick: the world stays as it was.
///
/// # Safety
/// Each pointer is NULL or to what its type says, `wrenches` to `wrench_count` of them; structs have the sizes that they
/// begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_step(
    world: *mut World,
    sample: *const WorldSample,
    wrenches: *mut Wrench,
    wrench_count: usize,
    output: *mut WorldOutput,
) -> Fault {
    // SAFETY: as the caller says.
    unsafe {
        answer("wrenches", wrenches, wrench_count, output, |out| {
            tick(world, sample, out)
        })
    }
}

/// What a tick says beside the wrenches.
pub(crate) trait TickOutput: SizedStruct {
    /// Nothing but why there is no force.
    fn refused(fault: Fault) -> Self;

    /// Why the sample was refused.
    fn fault(&self) -> Fault;
}

/// The answer of a tick that may go wrong: whatever happens, nothing of an earlier one stays in the wrenches.
///
/// # Safety
/// `wrenches` is NULL or to `wrench_count` of them, `output` NULL or to a struct of the size that it begins with.
pub(crate) unsafe fn answer<O: TickOutput>(
    name: &'static str,
    wrenches: *mut Wrench,
    wrench_count: usize,
    output: *mut O,
    tick: impl FnOnce(&mut [Wrench]) -> Result<O, Refusal<'static>>,
) -> Fault {
    // All of it before the tick: one that is refused has not been.
    // SAFETY: as the caller says.
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
        // What was put there before a defect came up.
        out.fill(NONE);
    }
    let fault = said.fault();
    if let Some(room) = room {
        room.write(said);
    }
    fault
}

/// The tick of arguments that may be wrong.
///
/// # Safety
/// As for `palpate_world_step`.
unsafe fn tick(
    world: *mut World,
    sample: *const WorldSample,
    out: &mut [Wrench],
) -> Result<WorldOutput, Refusal<'static>> {
    // SAFETY: as the caller says.
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
    // SAFETY: as the caller says.
    let (sample, poses) = unsafe { WorldSample::at(sample, devices) }?;
    let room = world.positions.iter_mut().zip(&mut world.orientations);
    for ((position, orientation), (pose, device)) in room.zip(poses.iter().zip(&world.devices)) {
        *position = pose.position;
        *orientation = if device.turns {
            pose.orientation
        } else {
            NOT_TURNED
        };
    }
    let held = world.bounded.step(&Sample {
        positions: &world.positions,
        orientations: &world.orientations,
        elapsed: (sample.has_elapsed != 0).then_some(sample.elapsed),
    });
    for (out, Held { force, torque }) in out.iter_mut().zip(held.wrenches) {
        *out = Wrench {
            force: *force,
            torque: *torque,
        };
    }
    Ok(WorldOutput::from(&held))
}

/// Says what was really sent to a device for the last tick, where it is another wrench than the tick has given: something
/// between has limited it. What is not finite is refused.
///
/// # Safety
/// Each pointer is NULL or to what its type says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_world_report_sent(
    world: *mut World,
    device: usize,
    sent: *const Wrench,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let world = unsafe { world.as_mut() }.ok_or(Refusal::Null("world"))?;
        // SAFETY: as the caller says.
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
        let Wrench { force, torque } = *sent;
        world.bounded.report_sent(device, Held { force, torque });
        Ok(())
    })
}
