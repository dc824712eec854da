//! What a recording is to have, and what it had in the end.

use core::ffi::c_char;
use core::ptr;
use std::format;
use std::string::String;

use palpate_rt::Recorder as Thread;

use crate::edge::status;
use crate::sized::{self, SizedStruct};
use crate::status::{Refusal, Status};
use crate::text;

/// What a recording is to have. palpate_recorder_params_default() makes one with every default.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct RecorderParams {
    /// Size of this struct; palpate_recorder_params_default() sets it.
    pub struct_size: usize,
    /// Name of the device, in UTF-8; NULL: not said.
    pub device: *const c_char,
    /// Text of a scene file of what is rendered, in UTF-8, which `palpate replay` of a contact needs; NULL: none.
    pub scene: *const c_char,
    /// Ticks of one contact that may wait for the disk, 1 to 2^24; each takes about 1 KiB, all at once: PALPATE_STATUS_MEMORY where
    /// the system has not so much. 0: 65536.
    pub room: usize,
}

// SAFETY: `repr(C)`, a `usize` first, numbers and raw pointers only.
unsafe impl SizedStruct for RecorderParams {
    const NAME: &'static str = "palpate_recorder_params";
}

/// What a recording had in the end. palpate_recorded_empty() makes one to be filled.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Recorded {
    /// Size of this struct; palpate_recorded_empty() sets it.
    pub struct_size: usize,
    /// Ticks that the loop made.
    pub ticks_made: u64,
    /// Ticks that the file has; 0 where the system refused to write it to its end.
    pub ticks: u64,
    /// Ticks that found no room on their way to the disk. The file says which.
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

/// Most ticks that may wait: what they take is made at once.
const MOST_ROOM: usize = 1 << 24;

/// Fills parameters of a recording with the defaults. `struct_size` is sizeof(palpate_recorder_params).
///
/// # Safety
/// `params` is NULL, or `struct_size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_recorder_params_init(
    params: *mut RecorderParams,
    struct_size: usize,
) -> Status {
    // SAFETY: as the caller says.
    status(|| unsafe { sized::fill(params, struct_size, DEFAULT) })
}

/// What was asked for, read and checked.
pub(super) struct Asked {
    /// What the receipt says of the device.
    pub device: String,
    pub scene: Option<String>,
    pub room: usize,
}

impl Asked {
    /// What stands at `params`; the defaults where that is NULL.
    ///
    /// # Safety
    /// `params` is NULL or to parameters of the size that they begin with.
    pub unsafe fn at<'a>(params: *const RecorderParams) -> Result<Self, Refusal<'a>> {
        let params = if params.is_null() {
            DEFAULT
        } else {
            // SAFETY: as the caller says.
            unsafe { sized::read(params) }?
        };
        let text = |text: *const c_char, name| {
            if text.is_null() {
                return Ok(None);
            }
            // SAFETY: as the caller says.
            unsafe { text::read(text, name) }.map(|text| Some(String::from(text)))
        };
        if params.room > MOST_ROOM {
            return Err(Refusal::Numbers(format!(
                "room is {} ticks, but must be at most {MOST_ROOM}",
                params.room
            )));
        }
        let device = text(params.device, "device")?;
        Ok(Self {
            device: device.map_or_else(
                || String::from("# name: not said\n"),
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
