//! Boundary to C: stops unwinding and stores the message of each error.

use crate::last_error;
use crate::status::{Refusal, Status};

/// Returns the result of `call`, or `None` after a panic.
#[cfg(feature = "std")]
pub fn caught<T>(call: impl FnOnce() -> T) -> Option<T> {
    // A panic can only leave plain numbers of a contact half updated.
    let call = std::panic::AssertUnwindSafe(call);
    std::panic::catch_unwind(call).ok().or_else(|| {
        last_error::set("a defect in palpate was caught; please report it");
        None
    })
}

/// Returns the result of `call`. Without std nothing unwinds.
#[cfg(not(feature = "std"))]
pub fn caught<T>(call: impl FnOnce() -> T) -> Option<T> {
    Some(call())
}

/// Returns the status of a call and stores the message of an error.
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

/// Panic handler: the firmware provides the function that sets the force to zero.
#[cfg(all(not(feature = "std"), not(test)))]
mod panic {
    unsafe extern "C" {
        /// Defined by the firmware: sets the motor forces to zero and does not return.
        fn palpate_panicked() -> !;
    }

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
        // SAFETY: the linker requires the firmware to define it; it has no arguments and does not return.
        unsafe { palpate_panicked() }
    }

    /// Symbol that the precompiled `core` references on systems with unwinding; never called.
    #[cfg(target_os = "linux")]
    #[unsafe(no_mangle)]
    extern "C" fn rust_eh_personality() {}
}
