#![cfg_attr(not(feature = "std"), no_std)]
//! C and C++ API of palpate. The header `include/palpate.h` is generated from this crate, including the
//! documentation of each function.
//!
//! Handles are opaque. Each struct begins with its own size, so later versions can add fields. A tick cannot
//! fail: it returns the force on the device, or 0 on any error. Nothing unwinds into the caller.

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

/// Version of this interface. It increases with changes that break compiled programs; pure additions
/// do not change it.
pub const PALPATE_ABI_VERSION: u32 = 1;

/// Returns the interface version of the library. It must equal `PALPATE_ABI_VERSION` of the header; otherwise
/// header and library are incompatible.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_abi_version() -> u32 {
    PALPATE_ABI_VERSION
}

/// Returns the version of the library, such as "0.1.0".
#[unsafe(no_mangle)]
pub extern "C" fn palpate_version() -> *const c_char {
    const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), "\0");
    VERSION.as_ptr().cast()
}
