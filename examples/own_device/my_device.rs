//! A user-defined device as a shared library in Rust, without a dependency: here a mass of 0.2 kg that a spring holds
//! 5 mm in the wall. `bindings/c/include/palpate_device.h` specifies functions and structures.
//!
//! ```sh
//! rustc --edition 2024 --crate-type cdylib examples/own_device/my_device.rs -o libmine.so
//! palpate run experiments/wall.toml --method basic --device plugin:./libmine.so
//! ```

use std::ffi::{c_char, c_int};
use std::ptr::null;

const OK: c_int = 0;

#[repr(C)]
pub struct PalpateDeviceCapabilities {
    size: u32,
    axes: u32,
    torque_axes: u32,
    has_orientation: u32,
    holds_last_force: u32,
    reserved: u32,
    largest_force_n: f64,
    largest_torque_n_m: f64,
    largest_stiffness_n_per_m: f64,
    largest_damping_n_s_per_m: f64,
    mass_kg: f64,
    quantum_m: f64,
}

#[repr(C)]
pub struct PalpateDeviceSample {
    size: u32,
    has_time: u32,
    time_s: f64,
    position_m: [f64; 3],
    orientation: [f64; 4],
}

#[repr(C)]
pub struct PalpateDeviceWrench {
    size: u32,
    reserved: u32,
    force_n: [f64; 3],
    torque_n_m: [f64; 3],
}

#[derive(Default)]
pub struct MyDevice {
    force: f64,
    position: f64,
    velocity: f64,
}

#[unsafe(no_mangle)]
pub extern "C" fn palpate_device_version() -> u32 {
    1
}

#[unsafe(no_mangle)]
pub extern "C" fn palpate_device_size(structure: u32) -> u32 {
    let size = match structure {
        0 => size_of::<PalpateDeviceCapabilities>(),
        1 => size_of::<PalpateDeviceSample>(),
        2 => size_of::<PalpateDeviceWrench>(),
        _ => 0,
    };
    size as u32
}

/// # Safety
/// `device` is valid for a write.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_device_open(
    _argument: *const c_char,
    device: *mut *mut MyDevice,
) -> c_int {
    unsafe { *device = Box::into_raw(Box::default()) };
    OK
}

#[unsafe(no_mangle)]
pub extern "C" fn palpate_device_name(_device: *mut MyDevice) -> *const c_char {
    c"my device".as_ptr()
}

#[unsafe(no_mangle)]
pub extern "C" fn palpate_device_error(_device: *mut MyDevice) -> *const c_char {
    null()
}

#[unsafe(no_mangle)]
pub extern "C" fn palpate_device_capabilities(
    _device: *mut MyDevice,
    can: &mut PalpateDeviceCapabilities,
) -> c_int {
    can.axes = 1;
    can.largest_force_n = 5.0;
    can.mass_kg = 0.2;
    OK
}

#[unsafe(no_mangle)]
pub extern "C" fn palpate_device_read(
    device: &mut MyDevice,
    sample: &mut PalpateDeviceSample,
) -> c_int {
    // Replace these lines by your sensor.
    let pull = 500.0 * (0.005 - device.position) - 10.0 * device.velocity;
    device.velocity += (device.force + pull) / 0.2 * 0.001;
    device.position += device.velocity * 0.001;
    sample.position_m[0] = device.position;
    OK
}

#[unsafe(no_mangle)]
pub extern "C" fn palpate_device_write(
    device: &mut MyDevice,
    wrench: &PalpateDeviceWrench,
    _held: Option<&mut PalpateDeviceWrench>,
) -> c_int {
    device.force = wrench.force_n[0]; // to your motor
    OK
}

/// # Safety
/// `device` comes from `palpate_device_open` and is not used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_device_close(device: *mut MyDevice) {
    if !device.is_null() {
        drop(unsafe { Box::from_raw(device) });
    }
}
