//! Texts for C: truncated to the buffer and terminated by a 0.

use core::ffi::{CStr, c_char};
use core::fmt::{self, Write};
use core::str;

use crate::status::Refusal;

/// Writer that stores bytes up to a limit and counts the full length.
struct Cut<Put> {
    put: Put,
    /// Capacity in bytes.
    room: usize,
    /// Length of the full text in bytes.
    length: usize,
    /// Number of stored bytes.
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

/// Passes a text and a terminating 0 to `put(index, byte)`, truncated to `size` bytes. Returns the full length.
pub fn put(text: impl fmt::Display, size: usize, put: impl FnMut(usize, u8)) -> usize {
    let Some(room) = size.checked_sub(1) else {
        let mut counted = Cut {
            put: |_, _| {},
            room: 0,
            length: 0,
            kept: 0,
        };
        // `Cut` never returns an error.
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

/// Writes a text to the caller's memory as `snprintf` does: truncated to `size` bytes including the terminating 0.
/// Returns the full length.
///
/// # Safety
/// `memory` is NULL, or `size` bytes can be written there.
pub unsafe fn put_at(text: impl fmt::Display, memory: *mut c_char, size: usize) -> usize {
    let size = if memory.is_null() { 0 } else { size };
    put(text, size, |at, byte| {
        // SAFETY: `put` stays below `size`, and the caller guarantees `size` writable bytes.
        unsafe { memory.cast::<u8>().add(at).write(byte) }
    })
}

/// Reads the text at `text`, called `name` in messages.
///
/// # Safety
/// `text` is NULL or points to a text that is terminated by a 0 and not modified during `'a`.
pub unsafe fn read<'a>(text: *const c_char, name: &'static str) -> Result<&'a str, Refusal<'a>> {
    if text.is_null() {
        return Err(Refusal::Null(name));
    }
    // SAFETY: not NULL, and the caller guarantees the terminating 0.
    let bytes = unsafe { CStr::from_ptr(text) };
    str::from_utf8(bytes.to_bytes()).map_err(|_| Refusal::NotText(name))
}
