//! Message of the last error: per thread, or one for the program if there are no threads.

use core::ffi::c_char;
use core::fmt;
use core::sync::atomic::{AtomicU8, Ordering::Relaxed};

use crate::text;

/// Buffer size for a message with its terminating 0. A message about a scene can be long.
const SIZE: usize = if cfg!(feature = "worlds") { 2048 } else { 384 };

struct LastError([AtomicU8; SIZE]);

impl LastError {
    const fn none() -> Self {
        Self([const { AtomicU8::new(0) }; SIZE])
    }

    fn set(&self, words: impl fmt::Display) {
        text::put(words, SIZE, |at, byte| self.0[at].store(byte, Relaxed));
    }

    fn as_ptr(&self) -> *const c_char {
        self.0.as_ptr().cast()
    }
}

#[cfg(feature = "std")]
std::thread_local! {
    static LAST: LastError = const { LastError::none() };
}

#[cfg(not(feature = "std"))]
static LAST: LastError = LastError::none();

/// Stores the message of an error.
#[cfg(feature = "std")]
pub fn set(words: impl fmt::Display) {
    // The value has no destructor, so the text lives as long as its thread.
    let _ = LAST.try_with(|last| last.set(words));
}

/// Stores the message of an error.
#[cfg(not(feature = "std"))]
pub fn set(words: impl fmt::Display) {
    LAST.set(words);
}

/// Returns the message of the last failed call in UTF-8: what is wrong, the value, and the allowed range.
/// Returns "" before the first failure. Each thread has its own message; the firmware library has one for the
/// whole program. The text is valid until the next failed call, and not after the end of its thread.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_last_error() -> *const c_char {
    #[cfg(feature = "std")]
    return LAST.try_with(LastError::as_ptr).unwrap_or(c"".as_ptr());
    #[cfg(not(feature = "std"))]
    return LAST.as_ptr();
}
