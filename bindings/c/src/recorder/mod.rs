//! Recordings: what a loop did, tick by tick, written by a thread of the library's own.

mod params;
mod ticks;

pub use params::*;
pub use ticks::*;

use core::ffi::c_char;
use core::ptr;
use std::io::ErrorKind;
use std::path::Path;
use std::string::ToString;
use std::time::Duration;

use palpate_record::recording::{LoopTime, Receipt};
use palpate_rt::{Ending, Recorder as Thread, Tap, WorldFrame, WorldRows};

use crate::contact::Contact;
use crate::edge::status;
use crate::identity::Identity;
use crate::sized;
use crate::status::{Refusal, Status};
use crate::text;
use crate::world::World;

/// A recording that is being written. One thread at a time may use it.
pub struct Recorder {
    tap: Tap,
    thread: Thread,
    of: Of,
    /// Number of the next tick.
    sequence: u64,
    /// When the last tick was sampled [s].
    time: f64,
}

/// What is recorded.
enum Of {
    Contact(Identity),
    World {
        world: Identity,
        rows: WorldRows,
        /// How often the world had been changed.
        changes: u64,
        /// Place in the scene of the device that is recorded.
        device: usize,
    },
}

/// Begins the recording of a contact in a new file at `path`, to be ended by palpate_recorder_close, and puts it into
/// `*recorder`; NULL on an error, and no file is left then. A file that is there is not replaced. `params` may be NULL: every
/// default. Not in the library for firmware.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_recorder_of_contact(
    contact: *const Contact<f64>,
    path: *const c_char,
    params: *const RecorderParams,
    recorder: *mut *mut Recorder,
) -> Status {
    // SAFETY: as the caller says.
    unsafe {
        begin(path, params, recorder, |receipt| {
            let contact = contact.as_ref().ok_or(Refusal::Null("contact"))?;
            let rendering = contact.running.rendering();
            let lines = format!(
                "period_s = {}\n# {rendering}\n",
                rendering.loop_params.period
            );
            Ok((
                receipt.with("contact", &lines),
                Of::Contact(contact.identity),
            ))
        })
    }
}

/// Begins the recording of a world of one device, as palpate_recorder_of_contact does of a contact. `palpate replay` renders
/// its motion anew; files of meshes are looked for beside the recording. A world of several devices takes
/// palpate_recorder_of_device.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_recorder_of_world(
    world: *const World,
    path: *const c_char,
    params: *const RecorderParams,
    recorder: *mut *mut Recorder,
) -> Status {
    // SAFETY: as the caller says.
    unsafe {
        begin(path, params, recorder, |receipt| {
            let world = world.as_ref().ok_or(Refusal::Null("world"))?;
            if world.devices.len() != 1 {
                return Err(Refusal::NotOneDevice(world.devices.len()));
            }
            Ok(of_device(receipt, world, 0))
        })
    }
}

/// Begins the recording of one device of a world, by its place in the scene, with all contacts and bodies of the world. The
/// recordings of several devices of a world are several recorders and files; a tick has the same number in each.
/// The rest is as for palpate_recorder_of_contact.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_recorder_of_device(
    world: *const World,
    device: usize,
    path: *const c_char,
    params: *const RecorderParams,
    recorder: *mut *mut Recorder,
) -> Status {
    // SAFETY: as the caller says.
    unsafe {
        begin(path, params, recorder, |receipt| {
            let world = world.as_ref().ok_or(Refusal::Null("world"))?;
            let count = world.devices.len();
            let Some(recorded) = world.devices.get(device) else {
                return Err(Refusal::Index {
                    name: "device",
                    given: device,
                    count,
                });
            };
            let which = format!(
                "name = {:?}\nplace = {device}\nof = {count}\n",
                recorded.name
            );
            Ok(of_device(
                receipt.with("device of the world", &which),
                world,
                device,
            ))
        })
    }
}

/// What the receipt of a recording says of a world, and what is recorded of it.
fn of_device(receipt: Receipt, world: &World, device: usize) -> (Receipt, Of) {
    let receipt = match &world.source {
        Some(source) => receipt.with("world", source),
        // No text says it.
        None => receipt,
    };
    let receipt = receipt
        .with("method", &format!("name = \"{}\"\n", world.method))
        .with("frame", &WorldFrame::the_same().to_string());
    let of = Of::World {
        world: world.identity,
        rows: world.rows.clone(),
        changes: world.changes,
        device,
    };
    (receipt, of)
}

/// Begins a recording of what `of` says, with the receipt that it gives.
///
/// # Safety
/// As for `palpate_recorder_of_contact`.
unsafe fn begin<'a>(
    path: *const c_char,
    params: *const RecorderParams,
    recorder: *mut *mut Recorder,
    of: impl FnOnce(Receipt) -> Result<(Receipt, Of), Refusal<'a>>,
) -> Status {
    status(|| {
        // SAFETY: NULL, or a pointer can be written there.
        let out = unsafe { recorder.as_mut() }.ok_or(Refusal::Null("recorder"))?;
        *out = ptr::null_mut();
        // SAFETY: as the caller says.
        let (path, asked) = unsafe { (text::read(path, "path")?, Asked::at(params)?) };
        let receipt = Receipt::new(env!("CARGO_PKG_VERSION")).with("device", &asked.device);
        let receipt = match &asked.scene {
            Some(scene) => receipt.with("scene", scene),
            None => receipt,
        };
        let (receipt, of) = of(receipt)?;
        let (tap, thread) = Thread::begin_with_room(Path::new(path), &receipt, asked.room)
            .map_err(|error| match error.source.kind() {
                ErrorKind::OutOfMemory => Refusal::NoMemory(error.to_string()),
                _ => Refusal::Recording(error.to_string()),
            })?;
        *out = Box::into_raw(Box::new(Recorder {
            tap,
            thread,
            of,
            sequence: 0,
            time: 0.0,
        }));
        Ok(())
    })
}

/// How many ticks found no room so far, since the disk was slower than the loop; 0 where `recorder` is NULL.
///
/// # Safety
/// `recorder` is NULL or a recorder.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_recorder_lost(recorder: *const Recorder) -> u64 {
    // SAFETY: as the caller says.
    unsafe { recorder.as_ref() }.map_or(0, |recorder| recorder.tap.lost())
}

/// Ends a recording: waits until everything is on its way to the disk, writes how many ticks the loop made, and frees the
/// recorder, whatever it answers. PALPATE_STATUS_RECORDING where the system refused to write; what was written before can
/// be read. `recorded` may be NULL. NULL for a recorder is left alone.
///
/// # Safety
/// Each pointer is NULL or to what its type says; the recorder is not used afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_recorder_close(
    recorder: *mut Recorder,
    recorded: *mut Recorded,
) -> Status {
    status(|| {
        if recorder.is_null() {
            return Ok(());
        }
        // SAFETY: `begin` has made it by `Box::into_raw`, and it is not used afterwards.
        let Recorder { tap, thread, .. } = *unsafe { Box::from_raw(recorder) };
        tap.end(Ending::Stopped);
        let (account, failed) = thread.finish();
        if !recorded.is_null() {
            let value = Recorded {
                struct_size: size_of::<Recorded>(),
                ticks_made: account.ticks_made,
                ticks: account.recording.as_ref().map_or(0, |_| account.ticks),
                lost: account.lost_ticks(),
            };
            // SAFETY: as the caller says.
            unsafe { sized::write(recorded, || value) }?;
        }
        match failed {
            None => Ok(()),
            Some(error) => Err(Refusal::Recording(error.to_string())),
        }
    })
}

impl Recorder {
    /// Goes on to a tick `elapsed` [s] after the one before: its number, when it was sampled, and the time since the
    /// sample before; NaN for the first.
    fn goes_on(&mut self, elapsed: f64) -> (u64, f64, f64) {
        let sequence = self.sequence;
        self.sequence += 1;
        if sequence == 0 {
            return (sequence, self.time, f64::NAN);
        }
        // A sample whose time was refused was taken at an instant that nobody knows.
        if elapsed.is_finite() && elapsed > 0.0 {
            self.time += elapsed;
        }
        (sequence, self.time, elapsed)
    }

    /// Tells how long the loop has run.
    fn ran(&mut self) {
        self.tap.ran(LoopTime {
            lasted: Duration::try_from_secs_f64(self.time).unwrap_or_default(),
            motors_off: Duration::ZERO,
        });
    }
}

/// A tick of something else than what the recorder was made of.
fn other(made_of: &str, given: &str) -> Refusal<'static> {
    Refusal::Recording(format!(
        "the recorder was made of {made_of}, and this is a tick of {given}"
    ))
}
