#![cfg_attr(not(feature = "std"), no_std)]
//! palpate from C and C++. The header `include/palpate.h` is made from this crate; what each function
//! means stands in both.
//!
//! Handles are opaque. Structs begin with their own size, so that they can grow. A tick cannot fail: it
//! gives the force on the device, 0 where anything is wrong. Nothing unwinds into the caller.

mod abi;
#[cfg(feature = "worlds")]
mod array;
mod choice;
mod contact;
mod contact_params;
mod edge;
#[cfg(feature = "worlds")]
mod identity;
mod last_error;
#[cfg(feature = "worlds")]
mod local;
mod loop_params;
mod methods;
mod names;
mod number;
mod output;
#[cfg(feature = "worlds")]
mod recorder;
mod sample;
#[cfg(feature = "worlds")]
mod scene;
mod sized;
mod status;
mod text;
#[cfg(feature = "worlds")]
mod world;

pub use contact::*;
pub use contact_params::*;
pub use last_error::palpate_last_error;
#[cfg(feature = "worlds")]
pub use local::*;
pub use loop_params::*;
pub use methods::*;
pub use names::*;
pub use output::*;
#[cfg(feature = "worlds")]
pub use recorder::*;
pub use sample::*;
#[cfg(feature = "worlds")]
pub use scene::*;
pub use status::Status;
#[cfg(feature = "worlds")]
pub use world::*;

use core::ffi::c_char;

/// Version of this interface. It goes up with a change that a compiled program would not survive; what
/// is only added leaves it as it is.
pub const PALPATE_ABI_VERSION: u32 = 1;

/// The version of the interface that the library has: that of the header, `PALPATE_ABI_VERSION`, or the
/// two do not belong together.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_abi_version() -> u32 {
    PALPATE_ABI_VERSION
}

/// The version of the library, such as "0.1.0".
#[unsafe(no_mangle)]
pub extern "C" fn palpate_version() -> *const c_char {
    const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");
    VERSION.as_ptr().cast()
}
