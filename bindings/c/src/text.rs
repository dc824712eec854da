//! Texts for C: cut to the room there is, and ended by a 0.

use core::ffi::{CStr, c_char};
use core::fmt::{self, Write};
use core::str;

use crate::status::Refusal;

/// Takes a text byte by byte, as far as there is room, and counts what it would need.
struct Cut<Put> {
    put: Put,
    /// Bytes that can be put.
    room: usize,
    /// Bytes of the whole text.
    length: usize,
    /// Bytes that were put.
    kept: usize,
}

impl<Put: FnMut(usize, u8)> Write for Cut<Put> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let whole = self.kept == self.length;
        self.length += text.len();
        if whole {
            let mut take = text.len().min(self.room - self.kept);
            while !text.is_char_boundary(take) {
                take -= 1;
            }
            for &byte in &text.as_bytes()[..take] {
                (self.put)(self.kept, byte);
                self.kept += 1;
            }
        }
        Ok(())
    }
}

/// Puts a text and a 0 behind it into `size` bytes, by place and byte. The length of the whole text.
pub fn put(text: impl fmt::Display, size: usize, put: impl FnMut(usize, u8)) -> usize {
    let Some(room) = size.checked_sub(1) else {
        let mut counted = Cut {
            put: |_, _| {},
            room: 0,
            length: 0,
            kept: 0,
        };
        // Putting never fails.
        let _ = write!(counted, "{text}");
        return counted.length;
    };
    let mut cut = Cut {
        put,
        room,
        length: 0,
        kept: 0,
    };
    let _ = write!(cut, "{text}");
    (cut.put)(cut.kept, 0);
    cut.length
}

/// Puts a text into the caller's memory, as `snprintf` does: cut to `size` bytes with the 0 at its end.
/// The length of the whole text.
///
/// # Safety
/// `memory` is NULL, or `size` bytes can be written there.
pub unsafe fn put_at(text: impl fmt::Display, memory: *mut c_char, size: usize) -> usize {
    let size = if memory.is_null() { 0 } else { size };
    put(text, size, |at, byte| {
        // SAFETY: `put` stays below `size`, and the caller says that these bytes can be written.
        unsafe { memory.cast::<u8>().add(at).write(byte) }
    })
}

/// The text at `text`, called `name` in messages.
///
/// # Safety
/// `text` is NULL, or a 0 ends what it points to, which nobody changes during `'a`.
pub unsafe fn read<'a>(text: *const c_char, name: &'static str) -> Result<&'a str, Refusal<'a>> {
    if text.is_null() {
        return Err(Refusal::Null(name));
    }
    // SAFETY: not NULL, and the caller says that it is ended by a 0.
    let bytes = unsafe { CStr::from_ptr(text) };
    str::from_utf8(bytes.to_bytes()).map_err(|_| Refusal::NotText(name))
}
