//! Parameters and result of a recording.

use core::ffi::c_char;
use core::ptr;
use std::format;
use std::string::String;

use palpate_rt::Recorder as Thread;

use crate::edge::status;
use crate::sized::{self, SizedStruct};
use crate::status::{Refusal, Status};
use crate::text;

/// Parameters of a recording. palpate_recorder_params_default() returns the defaults.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct RecorderParams {
    /// Size of this struct; palpate_recorder_params_default() sets it.
    pub struct_size: usize,
    /// Name of the device, in UTF-8; NULL: unknown.
    pub device: *const c_char,
    /// Text of a scene file of the rendered contact, in UTF-8; `palpate replay` of a contact needs it. NULL: none.
    pub scene: *const c_char,
    /// Capacity of the queue to the disk in ticks of one contact, 1 to 2^24. Each takes about 1 KiB, allocated at
    /// the start: PALPATE_STATUS_MEMORY if the system has too little. 0: 65536.
    pub room: usize,
}

// SAFETY: `repr(C)`, a `usize` first, numbers and raw pointers only.
unsafe impl SizedStruct for RecorderParams {
    const NAME: &'static str = "palpate_recorder_params";
}

/// Result of a recording. palpate_recorded_empty() returns an empty one to be filled.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Recorded {
    /// Size of this struct; palpate_recorded_empty() sets it.
    pub struct_size: usize,
    /// Ticks that the loop made.
    pub ticks_made: u64,
    /// Ticks in the file; 0 if the file could not be completed.
    pub ticks: u64,
    /// Ticks dropped because the queue was full. The file lists them.
    pub lost: u64,
}

// SAFETY: `repr(C)`, a `usize` first, numbers only. It is written, never read from C.
unsafe impl SizedStruct for Recorded {
    const NAME: &'static str = "palpate_recorded";
}

const DEFAULT: RecorderParams = RecorderParams {
    struct_size: size_of::<RecorderParams>(),
    device: ptr::null(),
    scene: ptr::null(),
    room: 0,
};

/// Largest queue capacity [ticks], because the queue is allocated at the start.
const MAX_ROOM: usize = 1 << 24;

/// Fills recording parameters with the defaults. `struct_size` is sizeof(palpate_recorder_params).
///
/// # Safety
/// `params` is NULL, or `struct_size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_recorder_params_init(
    params: *mut RecorderParams,
    struct_size: usize,
) -> Status {
    // SAFETY: guaranteed by the caller.
    status(|| unsafe { sized::fill(params, struct_size, DEFAULT) })
}

/// Checked parameters of a recording.
pub(super) struct Asked {
    /// Device name for the metadata.
    pub device: String,
    pub scene: Option<String>,
    pub room: usize,
}

impl Asked {
    /// Reads and checks the parameters at `params`; NULL means the defaults.
    ///
    /// # Safety
    /// `params` is NULL or points to parameters whose first field is their size.
    pub unsafe fn at<'a>(params: *const RecorderParams) -> Result<Self, Refusal<'a>> {
        let params = if params.is_null() {
            DEFAULT
        } else {
            // SAFETY: guaranteed by the caller.
            unsafe { sized::read(params) }?
        };
        let text = |text: *const c_char, name| {
            if text.is_null() {
                return Ok(None);
            }
            // SAFETY: guaranteed by the caller.
            unsafe { text::read(text, name) }.map(|text| Some(String::from(text)))
        };
        if params.room > MAX_ROOM {
            return Err(Refusal::Numbers(format!(
                "room is {} ticks, but must be at most {MAX_ROOM}",
                params.room
            )));
        }
        let device = text(params.device, "device")?;
        Ok(Self {
            device: device.map_or_else(
                || String::from("# name: unknown\n"),
                |name| format!("name = {name:?}\n"),
            ),
            scene: text(params.scene, "scene")?,
            room: if params.room == 0 {
                Thread::ROOM
            } else {
                params.room
            },
        })
    }
}
