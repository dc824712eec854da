//! Conversion of ticks for recordings.

use palpate_core::{Limited, Output as CoreOutput, Phase as CorePhase};
use palpate_device::Wrench as Held;
use palpate_record::recording::{ContactTick, Flags, Tick};
use palpate_rt::answered;

use super::{Of, Recorder, other};
use crate::contact::Contact;
use crate::edge::status;
use crate::output::{Fault, Limit, Output, Phase};
use crate::sample::Sample;
use crate::sized::{self, SizedStruct};
use crate::status::{Refusal, Status};
use crate::world::{World, WorldOutput, WorldSample, Wrench};

/// Records a tick of the recorder's contact after its palpate_contact_step: the sample, the output, and the force
/// that was actually sent to the device [N], or NaN if it is unknown. A tick of another contact is rejected.
///
/// It does not allocate, lock or wait, so the loop thread can call it. If the queue is full, the tick is dropped and
/// counted. Call it once for each tick, including rejected ones.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_recorder_contact_tick(
    recorder: *mut Recorder,
    contact: *const Contact<f64>,
    sample: *const Sample<f64>,
    output: *const Output<f64>,
    sent_force: f64,
    sent_slope: f64,
) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let recorder = unsafe { recorder.as_mut() }.ok_or(Refusal::Null("recorder"))?;
        // SAFETY: NULL, or a contact that is not modified during this call.
        let contact = unsafe { contact.as_ref() }.ok_or(Refusal::Null("contact"))?;
        match recorder.of {
            Of::Contact(made_of) if made_of == contact.identity => {}
            Of::Contact(_) => return Err(other("a contact", "another one")),
            Of::World { .. } => return Err(other("a world", "a contact")),
        }
        // SAFETY: guaranteed by the caller.
        let sample = unsafe { Sample::at(sample) }?;
        // SAFETY: guaranteed by the caller.
        let output = unsafe { sized::read(output.cast::<Answer>()) }?;
        let elapsed = if sample.has_elapsed != 0 {
            sample.elapsed
        } else {
            contact.running.rendering().loop_params.period
        };
        let (sequence, time, period) = recorder.goes_on(elapsed);
        let ledger = contact.running.ledger();
        let said = ContactTick {
            sequence,
            device_position: sample.device_position,
            force_on_device: sent_force,
            ..answered(&output.of_core(), ledger)
        };
        let is_refused = output.fault != Fault::None as u32;
        let tick = Tick {
            sequence,
            time,
            period,
            device_axes: [sample.device_position, f64::NAN, f64::NAN],
            commanded_force: [output.force_on_device, 0.0, 0.0],
            commanded_torque: [0.0; 3],
            delivered_force: [sent_force, 0.0, 0.0],
            delivered_slope: [sent_slope, 0.0, 0.0],
            delivered_torque: [0.0; 3],
            generation: 0,
            created_energy: ledger.created(),
            flags: said.flags.with(Flags::FAULT, is_refused),
            ..Tick::UNKNOWN
        };
        recorder.tap.tick(&tick, &[said]);
        recorder.ran();
        Ok(())
    })
}

/// Records a tick of the recorder's world after its palpate_world_step: the sample, the output, and the wrench that was
/// actually sent to the recorded device. A tick of another world, or of a world that was changed since the start of the
/// recording, is rejected. Otherwise as palpate_recorder_contact_tick.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_recorder_world_tick(
    recorder: *mut Recorder,
    world: *const World,
    sample: *const WorldSample,
    output: *const WorldOutput,
    sent: *const Wrench,
) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let recorder = unsafe { recorder.as_mut() }.ok_or(Refusal::Null("recorder"))?;
        // SAFETY: NULL, or a world that is not modified during this call.
        let world = unsafe { world.as_ref() }.ok_or(Refusal::Null("world"))?;
        let device = recorded_device(recorder, world)?;
        let devices = world.devices.len();
        // SAFETY: guaranteed by the caller.
        let (sample, poses) = unsafe { WorldSample::at(sample, devices) }?;
        // SAFETY: guaranteed by the caller.
        let output = unsafe { sized::read(output.cast::<WorldAnswer>()) }?;
        // SAFETY: guaranteed by the caller.
        let sent = unsafe { sent.as_ref() }.ok_or(Refusal::Null("sent"))?;
        let (Some(of_device), Some(pose)) = (world.devices.get(device), poses.get(device)) else {
            return Err(Refusal::Index {
                name: "the device of the recorder",
                given: device,
                count: devices,
            });
        };
        let elapsed = if sample.has_elapsed != 0 {
            sample.elapsed
        } else {
            world.bounded.renderer().loop_params().period
        };
        let (sequence, time, period) = recorder.goes_on(elapsed);
        let state = world.bounded.state();
        let Recorder { of, tap, .. } = recorder;
        let Of::World { rows, .. } = of else {
            return Ok(());
        };
        rows.fill(sequence, state);
        let flags = output.flags(!rows.contacts().is_empty());
        // After an argument error no tick was executed, and the world still holds the wrenches of the previous tick.
        let has_been = output.fault != Fault::Argument as u32;
        let given = world.bounded.wrenches().get(device);
        let given = given.filter(|_| has_been).copied().unwrap_or(Held::NONE);
        let tick = Tick {
            sequence,
            time,
            period,
            device_axes: pose.position,
            device_orientation: if of_device.turns {
                pose.orientation
            } else {
                Tick::UNKNOWN.device_orientation
            },
            commanded_force: given.force,
            commanded_torque: given.torque,
            delivered_force: sent.force,
            delivered_slope: sent.slope,
            delivered_torque: sent.torque,
            generation: 0,
            created_energy: state.created_at_ports(),
            flags,
            ..Tick::UNKNOWN
        };
        tap.tick_with_bodies(&tick, rows.contacts(), rows.bodies());
        recorder.ran();
        Ok(())
    })
}

/// Returns the index of the recorded device, or rejects a world that is not as the recorder was made for.
fn recorded_device(recorder: &Recorder, world: &World) -> Result<usize, Refusal<'static>> {
    let Of::World {
        world: made_of,
        device,
        changes,
        ..
    } = recorder.of
    else {
        return Err(other("a contact", "a world"));
    };
    if made_of != world.identity {
        return Err(other("a world", "another one"));
    }
    if changes != world.changes {
        return Err(Refusal::Recording(
            "the bodies of the world have changed since the recorder was made: close it and make another recorder"
                .into(),
        ));
    }
    Ok(device)
}

/// A palpate_output read from C, where an enum field may have any value.
#[repr(C)]
#[derive(Clone, Copy)]
struct Answer {
    struct_size: usize,
    force_on_device: f64,
    force_on_object: f64,
    slope_on_device: f64,
    object_position: f64,
    object_velocity: f64,
    penetration: f64,
    transition_after: f64,
    proxy_shift: f64,
    phase: u32,
    fault: u32,
    limited: u32,
    reserved: u32,
}

const _: () = {
    use core::mem::offset_of;
    assert!(size_of::<Answer>() == size_of::<Output<f64>>());
    assert!(offset_of!(Answer, proxy_shift) == offset_of!(Output<f64>, proxy_shift));
    assert!(offset_of!(Answer, phase) == offset_of!(Output<f64>, phase));
    assert!(offset_of!(Answer, limited) == offset_of!(Output<f64>, limited));
    assert!(size_of::<WorldAnswer>() == size_of::<WorldOutput>());
    assert!(offset_of!(WorldAnswer, fault) == offset_of!(WorldOutput, fault));
    assert!(offset_of!(WorldAnswer, limited) == offset_of!(WorldOutput, limited));
};

// SAFETY: `repr(C)`, a `usize` first, numbers only.
unsafe impl SizedStruct for Answer {
    const NAME: &'static str = Output::<f64>::NAME;
}

impl Answer {
    /// Converts to the output of the core, except for the fault, which the tick stores.
    fn of_core(&self) -> CoreOutput<f64> {
        let is = |limit: Limit| self.limited & limit as u32 != 0;
        CoreOutput {
            force_on_device: self.force_on_device,
            force_on_object: self.force_on_object,
            slope_on_device: self.slope_on_device,
            object_position: self.object_position,
            object_velocity: self.object_velocity,
            penetration: self.penetration,
            transition_after: self.transition_after,
            proxy_shift: self.proxy_shift,
            phase: match self.phase {
                phase if phase == Phase::Free as u32 => CorePhase::Free,
                phase if phase == Phase::Contact as u32 => CorePhase::Contact,
                phase if phase == Phase::Enters as u32 => CorePhase::Enters,
                phase if phase == Phase::Leaves as u32 => CorePhase::Leaves,
                _ => CorePhase::Waiting,
            },
            limited: Limited {
                pull: is(Limit::Pull),
                force: is(Limit::Force),
                slew: is(Limit::Slew),
                guard: is(Limit::Guard),
                beyond_guard: is(Limit::BeyondGuard),
            },
            fault: None,
        }
    }
}

/// A palpate_world_output read from C.
#[repr(C)]
#[derive(Clone, Copy)]
struct WorldAnswer {
    struct_size: usize,
    fault: u32,
    fault_device: u32,
    limited: u32,
    rest: [u32; 5],
}

// SAFETY: `repr(C)`, a `usize` first, numbers only.
unsafe impl SizedStruct for WorldAnswer {
    const NAME: &'static str = WorldOutput::NAME;
}

impl WorldAnswer {
    /// Returns the flags of a tick.
    fn flags(&self, is_in_contact: bool) -> Flags {
        let is = |limits: u32| self.limited & limits != 0;
        Flags::default()
            .with(Flags::CONTACT, is_in_contact)
            .with(
                Flags::LIMITED_FORCE,
                is(Limit::Force as u32 | Limit::Torque as u32),
            )
            .with(Flags::LIMITED_GUARD, is(Limit::Guard as u32))
            .with(Flags::BEYOND_GUARD, is(Limit::BeyondGuard as u32))
            .with(
                Flags::SAFETY_LIMITED,
                is(Limit::Slew as u32 | Limit::SoftStart as u32),
            )
            .with(Flags::SAFETY_STOPPED, is(Limit::Stopped as u32))
            .with(Flags::FAULT, self.fault != Fault::None as u32)
    }
}
