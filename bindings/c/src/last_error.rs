//! The words of the last error: of each thread, or of the whole program where there are no threads.

use core::ffi::c_char;
use core::fmt;
use core::sync::atomic::{AtomicU8, Ordering::Relaxed};

use crate::text;

/// Room for the words of an error, with the 0 at their end. A scene may have many.
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

/// Keeps the words of an error.
#[cfg(feature = "std")]
pub fn set(words: impl fmt::Display) {
    // There is nothing to destroy, so the text lives as long as its thread.
    let _ = LAST.try_with(|last| last.set(words));
}

/// Keeps the words of an error.
#[cfg(not(feature = "std"))]
pub fn set(words: impl fmt::Display) {
    LAST.set(words);
}

/// What was wrong with the last call that failed: what, which value, and what is allowed, in UTF-8. ""
/// before the first one. Each thread has its own; in the library for firmware there is one for the whole
/// program. The text is there until the next call that fails, at most as long as its thread.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_last_error() -> *const c_char {
    #[cfg(feature = "std")]
    return LAST.try_with(LastError::as_ptr).unwrap_or(c"".as_ptr());
    #[cfg(not(feature = "std"))]
    return LAST.as_ptr();
}
