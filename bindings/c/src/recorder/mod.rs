//! Recordings of the ticks of a loop, written by a thread of the library.

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

use palpate_record::recording::{LoopTime, RecordingMetadata};
use palpate_rt::{Ending, Recorder as Thread, Tap, WorldFrame, WorldRows};

use crate::contact::Contact;
use crate::edge::status;
use crate::identity::Identity;
use crate::sized;
use crate::status::{Refusal, Status};
use crate::text;
use crate::world::World;

/// A recording in progress. Only one thread may use it at a time.
pub struct Recorder {
    tap: Tap,
    thread: Thread,
    of: Of,
    /// Number of the next tick.
    sequence: u64,
    /// Sampling time of the last tick [s].
    time: f64,
}

/// The recorded object.
enum Of {
    Contact(Identity),
    World {
        world: Identity,
        rows: WorldRows,
        /// Number of changes of the world so far.
        changes: u64,
        /// Index in the scene of the recorded device.
        device: usize,
    },
}

/// Starts the recording of a contact in a new file at `path` and stores the recorder in `*recorder`, or NULL on an
/// error, which leaves no file. An existing file is not replaced. End the recording with palpate_recorder_close.
/// `params` may be NULL: all defaults. Not in the firmware library.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_recorder_of_contact(
    contact: *const Contact<f64>,
    path: *const c_char,
    params: *const RecorderParams,
    recorder: *mut *mut Recorder,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe {
        begin(path, params, recorder, |metadata| {
            let contact = contact.as_ref().ok_or(Refusal::Null("contact"))?;
            let rendering = contact.running.rendering();
            let lines = format!(
                "period_s = {}\n# {rendering}\n",
                rendering.loop_params.period
            );
            Ok((
                metadata.with("contact", &lines),
                Of::Contact(contact.identity),
            ))
        })
    }
}

/// Starts the recording of a world of one device, as palpate_recorder_of_contact does for a contact. `palpate
/// replay` renders the motion again; it looks for mesh files beside the recording. For a world of several devices
/// use palpate_recorder_of_device.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_recorder_of_world(
    world: *const World,
    path: *const c_char,
    params: *const RecorderParams,
    recorder: *mut *mut Recorder,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe {
        begin(path, params, recorder, |metadata| {
            let world = world.as_ref().ok_or(Refusal::Null("world"))?;
            if world.devices.len() != 1 {
                return Err(Refusal::NotOneDevice(world.devices.len()));
            }
            Ok(of_device(metadata, world, 0))
        })
    }
}

/// Starts the recording of one device of a world, given by its index in the scene, with all contacts and bodies of
/// the world. For several devices use one recorder and file each; a tick has the same number in every file.
/// Otherwise as palpate_recorder_of_contact.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_recorder_of_device(
    world: *const World,
    device: usize,
    path: *const c_char,
    params: *const RecorderParams,
    recorder: *mut *mut Recorder,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe {
        begin(path, params, recorder, |metadata| {
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
                metadata.with("device of the world", &which),
                world,
                device,
            ))
        })
    }
}

/// Adds a world to the metadata of a recording and returns it with the recorded object.
fn of_device(metadata: RecordingMetadata, world: &World, device: usize) -> (RecordingMetadata, Of) {
    let metadata = match &world.source {
        Some(source) => metadata.with("world", source),
        // A world that was not read from a text has no source.
        None => metadata,
    };
    let metadata = metadata
        .with("method", &format!("name = \"{}\"\n", world.method))
        .with("frame", &WorldFrame::the_same().to_string());
    let of = Of::World {
        world: world.identity,
        rows: world.rows.clone(),
        changes: world.changes,
        device,
    };
    (metadata, of)
}

/// Starts a recording of the object that `of` returns, with its metadata.
///
/// # Safety
/// As for `palpate_recorder_of_contact`.
unsafe fn begin<'a>(
    path: *const c_char,
    params: *const RecorderParams,
    recorder: *mut *mut Recorder,
    of: impl FnOnce(RecordingMetadata) -> Result<(RecordingMetadata, Of), Refusal<'a>>,
) -> Status {
    status(|| {
        // SAFETY: NULL, or a pointer can be written there.
        let out = unsafe { recorder.as_mut() }.ok_or(Refusal::Null("recorder"))?;
        *out = ptr::null_mut();
        // SAFETY: guaranteed by the caller.
        let (path, asked) = unsafe { (text::read(path, "path")?, Asked::at(params)?) };
        let metadata =
            RecordingMetadata::new(env!("CARGO_PKG_VERSION")).with("device", &asked.device);
        let metadata = match &asked.scene {
            Some(scene) => metadata.with("scene", scene),
            None => metadata,
        };
        let (metadata, of) = of(metadata)?;
        let (tap, thread) = Thread::begin_with_room(Path::new(path), &metadata, asked.room)
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

/// Returns the number of ticks dropped so far because the disk was slower than the loop; 0 if `recorder` is NULL.
///
/// # Safety
/// `recorder` is NULL or a recorder.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_recorder_lost(recorder: *const Recorder) -> u64 {
    // SAFETY: guaranteed by the caller.
    unsafe { recorder.as_ref() }.map_or(0, |recorder| recorder.tap.lost())
}

/// Ends a recording: waits until all data is passed to the system, writes the number of ticks of the loop, and
/// always frees the recorder. Returns PALPATE_STATUS_RECORDING if writing failed; the data written before is
/// readable. `recorded` may be NULL. A NULL recorder is ignored.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the recorder is not used afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_recorder_close(
    recorder: *mut Recorder,
    recorded: *mut Recorded,
) -> Status {
    status(|| {
        if recorder.is_null() {
            return Ok(());
        }
        // SAFETY: allocated with `Box::into_raw` by `begin`, and not used afterwards.
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
            // SAFETY: guaranteed by the caller.
            unsafe { sized::write(recorded, || value) }?;
        }
        match failed {
            None => Ok(()),
            Some(error) => Err(Refusal::Recording(error.to_string())),
        }
    })
}

impl Recorder {
    /// Advances to a tick `elapsed` [s] after the previous one. Returns its number, its sampling time and the
    /// elapsed time, which is NaN for the first tick.
    fn goes_on(&mut self, elapsed: f64) -> (u64, f64, f64) {
        let sequence = self.sequence;
        self.sequence += 1;
        if sequence == 0 {
            return (sequence, self.time, f64::NAN);
        }
        // The sampling time of a sample with a rejected elapsed time is unknown.
        if elapsed.is_finite() && elapsed > 0.0 {
            self.time += elapsed;
        }
        (sequence, self.time, elapsed)
    }

    /// Reports the run time of the loop.
    fn ran(&mut self) {
        self.tap.ran(LoopTime {
            lasted: Duration::try_from_secs_f64(self.time).unwrap_or_default(),
            motors_off: Duration::ZERO,
        });
    }
}

/// Returns the error for a tick of another object than the recorded one.
fn other(made_of: &str, given: &str) -> Refusal<'static> {
    Refusal::Recording(format!(
        "the recorder is for {made_of}, but this is a tick of {given}"
    ))
}
