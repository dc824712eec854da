//! Calls of shared libraries: by the interface of `bindings/c/include/palpate_device.h`, and in [`dhd`] of a
//! manufacturer's.
//!
//! The only module of the workspace's crates with unsafe code: a call of foreign code cannot be checked. The header
//! states what a library must do. Here a pointer is used only between `open` and `close`, structures have the sizes that
//! the library was compiled with, and nothing that the library returns is used unchecked.
#![allow(unsafe_code, reason = "a call of foreign code")]
#![deny(unsafe_op_in_unsafe_fn)]
#![warn(clippy::undocumented_unsafe_blocks)]

pub mod dhd;

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::Path;
use std::ptr::{NonNull, null_mut};

use libloading::{Library, Symbol};

/// Version of the interface.
pub const VERSION: u32 = 1;

/// Results of calls.
pub const OK: c_int = 0;
pub const NOTHING_NEW: c_int = 1;
pub const DISCONNECTED: c_int = 2; // any other: refused

/// `PalpateDeviceCapabilities`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct RawCapabilities {
    pub size: u32,
    pub axes: u32,
    pub torque_axes: u32,
    pub has_orientation: u32,
    pub holds_last_force: u32,
    pub reserved: u32,
    pub largest_force_n: f64,
    pub largest_torque_n_m: f64,
    pub largest_stiffness_n_per_m: f64,
    pub largest_damping_n_s_per_m: f64,
    pub mass_kg: f64,
    pub quantum_m: f64,
}

/// `PalpateDeviceSample`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct RawSample {
    pub size: u32,
    pub has_time: u32,
    pub time_s: f64,
    pub position_m: [f64; 3],
    pub orientation: [f64; 4],
}

/// `PalpateDeviceWrench`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct RawWrench {
    pub size: u32,
    pub reserved: u32,
    pub force_n: [f64; 3],
    pub torque_n_m: [f64; 3],
}

/// Structures of the interface, by the number that `palpate_device_size` takes.
const SIZES: [(&str, usize); 3] = [
    ("PalpateDeviceCapabilities", size_of::<RawCapabilities>()),
    ("PalpateDeviceSample", size_of::<RawSample>()),
    ("PalpateDeviceWrench", size_of::<RawWrench>()),
];

type Version = unsafe extern "C" fn() -> u32;
type Size = unsafe extern "C" fn(u32) -> u32;
type Open = unsafe extern "C" fn(*const c_char, *mut *mut c_void) -> c_int;
type Name = unsafe extern "C" fn(*mut c_void) -> *const c_char;
type Read = unsafe extern "C" fn(*mut c_void, *mut RawSample) -> c_int;
type Write = unsafe extern "C" fn(*mut c_void, *const RawWrench, *mut RawWrench) -> c_int;
type Capable = unsafe extern "C" fn(*mut c_void, *mut RawCapabilities) -> c_int;
type Act = unsafe extern "C" fn(*mut c_void);

/// Reason why a library cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LibraryError {
    /// The file is missing or no library.
    #[error("{}", reason(.0))]
    Load(libloading::Error),
    /// A function is missing.
    #[error("it has no function {0}; palpate_device.h lists all")]
    Symbol(&'static str),
    /// A function of Force Dimension's library is missing.
    #[error("it has no function {0}; install Force Dimension's SDK 3.16 or later")]
    OldSdk(&'static str),
    /// Another version.
    #[error(
        "it has version {0} of the interface; allowed: {VERSION}; compile it with the present palpate_device.h"
    )]
    Version(u32),
    /// Another size of a structure.
    #[error("its {0} has {1} bytes; allowed: {2}; compile it with the present palpate_device.h")]
    Size(&'static str, u32, usize),
    /// The argument cannot be passed.
    #[error("its argument contains a zero byte")]
    Argument,
    /// The device cannot be opened.
    #[error("it cannot open the device (code {code}){}", .text.as_ref().map_or_else(String::new, |text| format!(": {text}")))]
    Open {
        /// Result of the call.
        code: i32,
        /// The library's own words.
        text: Option<String>,
    },
}

/// Returns the words of the system.
fn reason(error: &libloading::Error) -> String {
    let source = std::error::Error::source(error);
    source.map_or_else(|| error.to_string(), ToString::to_string)
}

/// An open device of a library.
#[derive(Debug)]
pub struct Opened {
    device: NonNull<c_void>,
    read: Read,
    write: Write,
    capable: Capable,
    name: Name,
    error: Name,
    zero: Option<Act>,
    close: Act,
    /// After the functions, which it contains.
    _library: Library,
}

// SAFETY: The header demands that each function may be called on any thread, one at a time, except
// `palpate_device_zero`, which may run beside the others.
unsafe impl Send for Opened {}
// SAFETY: As above: by a shared reference, only `zero` is called from another thread (see `Plugin`).
unsafe impl Sync for Opened {}

impl Opened {
    /// Loads the library at `path` and opens its device with `argument`.
    pub fn open(path: &Path, argument: &str) -> Result<Self, LibraryError> {
        let argument = CString::new(argument).map_err(|_| LibraryError::Argument)?;
        let library = load(path)?;
        let version: Version = function(&library, "palpate_device_version")?;
        // SAFETY: The header declares this signature.
        let found = unsafe { version() };
        if found != VERSION {
            return Err(LibraryError::Version(found));
        }
        let size: Size = function(&library, "palpate_device_size")?;
        for (number, (name, expected)) in (0..).zip(SIZES) {
            // SAFETY: The header declares this signature.
            let found = unsafe { size(number) };
            if usize::try_from(found) != Ok(expected) {
                return Err(LibraryError::Size(name, found, expected));
            }
        }
        let open: Open = function(&library, "palpate_device_open")?;
        let error: Name = function(&library, "palpate_device_error")?;
        let (read, write) = (
            function(&library, "palpate_device_read")?,
            function(&library, "palpate_device_write")?,
        );
        let (capable, name) = (
            function(&library, "palpate_device_capabilities")?,
            function(&library, "palpate_device_name")?,
        );
        let close = function(&library, "palpate_device_close")?;
        let zero = function(&library, "palpate_device_zero").ok();
        let mut device = null_mut();
        // SAFETY: Both pointers are valid for the call.
        let code = unsafe { open(argument.as_ptr(), &raw mut device) };
        let device = NonNull::new(device).filter(|_| code == OK).ok_or_else(|| {
            // SAFETY: The header permits a null device after a failed `open`.
            let text = text(unsafe { error(null_mut()) });
            LibraryError::Open { code, text }
        })?;
        Ok(Self {
            device,
            read,
            write,
            capable,
            name,
            error,
            zero,
            close,
            _library: library,
        })
    }

    /// Returns the capabilities, or the code of the failure.
    pub fn capabilities(&self) -> Result<RawCapabilities, c_int> {
        let mut found = RawCapabilities {
            size: u32_size::<RawCapabilities>(),
            ..RawCapabilities::default()
        };
        // SAFETY: The device is open; the library was compiled with this size.
        match unsafe { (self.capable)(self.device.as_ptr(), &raw mut found) } {
            OK => Ok(found),
            code => Err(code),
        }
    }

    /// Returns a sample, or the code of the failure.
    pub fn read(&self) -> Result<RawSample, c_int> {
        let mut found = RawSample {
            size: u32_size::<RawSample>(),
            ..RawSample::default()
        };
        // SAFETY: The device is open; the library was compiled with this size.
        match unsafe { (self.read)(self.device.as_ptr(), &raw mut found) } {
            OK => Ok(found),
            code => Err(code),
        }
    }

    /// Commands a wrench and returns the held one, or the code of the failure.
    pub fn write(&self, wrench: &RawWrench) -> Result<RawWrench, c_int> {
        let mut held = *wrench;
        // SAFETY: The device is open; the library was compiled with this size.
        match unsafe { (self.write)(self.device.as_ptr(), wrench, &raw mut held) } {
            OK => Ok(held),
            code => Err(code),
        }
    }

    /// Returns the name of the device.
    pub fn name(&self) -> Option<String> {
        // SAFETY: The device is open.
        text(unsafe { (self.name)(self.device.as_ptr()) })
    }

    /// Returns the last error in the library's own words.
    pub fn error(&self) -> Option<String> {
        // SAFETY: The device is open.
        text(unsafe { (self.error)(self.device.as_ptr()) })
    }

    /// Whether the library can command zero force on another thread.
    pub fn has_zero(&self) -> bool {
        self.zero.is_some()
    }

    /// Commands zero force, on any thread.
    pub fn zero(&self) {
        if let Some(zero) = self.zero {
            // SAFETY: The device is open; the header permits this call beside others.
            unsafe { zero(self.device.as_ptr()) };
        }
    }
}

impl Drop for Opened {
    fn drop(&mut self) {
        // SAFETY: The device is open, and this is the last use of it.
        unsafe { (self.close)(self.device.as_ptr()) };
    }
}

/// Loads a library with all functions that it calls: one that is missing is an error here, and not in a tick.
fn load(path: &Path) -> Result<Library, LibraryError> {
    // The system looks for a bare name elsewhere than in the current folder.
    let is_here = path.components().count() == 1 && path.exists();
    let path = if is_here {
        Path::new(".").join(path)
    } else {
        path.to_path_buf()
    };
    #[cfg(unix)]
    let loaded = {
        use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};
        // SAFETY: Loading runs the library's initializers. The user names the library, as the program that is run.
        unsafe { Library::open(Some(path), RTLD_NOW | RTLD_LOCAL) }.map(Into::into)
    };
    #[cfg(not(unix))]
    // SAFETY: As above.
    let loaded = unsafe { Library::new(path) };
    loaded.map_err(LibraryError::Load)
}

/// Returns a function of the library; `F` is its type in the header.
fn function<F: Copy>(library: &Library, name: &'static str) -> Result<F, LibraryError> {
    // SAFETY: The type is that of the header, whose version the library has. A symbol may be null.
    let found: Result<Symbol<'_, Option<F>>, _> = unsafe { library.get(name.as_bytes()) };
    found
        .ok()
        .and_then(|found| *found)
        .ok_or(LibraryError::Symbol(name))
}

/// Copies a text of the library.
fn text(from: *const c_char) -> Option<String> {
    if from.is_null() {
        return None;
    }
    // SAFETY: The header demands a text that ends with a zero byte and lasts until the next call.
    let text = unsafe { CStr::from_ptr(from) };
    Some(text.to_string_lossy().into_owned()).filter(|text| !text.is_empty())
}

#[allow(clippy::cast_possible_truncation, reason = "the structures are small")]
pub fn u32_size<T>() -> u32 {
    size_of::<T>() as u32
}
