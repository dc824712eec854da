//! The edge to C: nothing unwinds across it, and every refusal leaves its words.

use crate::last_error;
use crate::status::{Refusal, Status};

/// What `call` gives; nothing where it panicked.
#[cfg(feature = "std")]
pub fn caught<T>(call: impl FnOnce() -> T) -> Option<T> {
    // What a call that panicked has left half done is a contact's state, which is plain numbers.
    let call = std::panic::AssertUnwindSafe(call);
    std::panic::catch_unwind(call).ok().or_else(|| {
        last_error::set("a defect in palpate was caught; please report it");
        None
    })
}

/// What `call` gives. Without std nothing unwinds.
#[cfg(not(feature = "std"))]
pub fn caught<T>(call: impl FnOnce() -> T) -> Option<T> {
    Some(call())
}

/// The status of a call; the words of a refusal are kept.
pub fn status<'a>(call: impl FnOnce() -> Result<(), Refusal<'a>>) -> Status {
    caught(|| match call() {
        Ok(()) => Status::Ok,
        Err(refusal) => {
            last_error::set(&refusal);
            refusal.status()
        }
    })
    .unwrap_or(Status::Internal)
}

/// A firmware that has panicked must take its force off, and only the firmware knows how.
#[cfg(all(not(feature = "std"), not(test)))]
mod panic {
    unsafe extern "C" {
        /// Given by the firmware: takes the force off the motors, and does not return.
        fn palpate_panicked() -> !;
    }

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
        // SAFETY: the firmware has it, or nothing would link; it takes nothing and does not return.
        unsafe { palpate_panicked() }
    }

    /// The precompiled `core` refers to it on systems that could unwind; it is never called.
    #[cfg(target_os = "linux")]
    #[unsafe(no_mangle)]
    extern "C" fn rust_eh_personality() {}
}
