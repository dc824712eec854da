//! C functions of a contact in `float`. `doubles` documents each function.

use core::ffi::{c_char, c_void};

use crate::contact::{self, Contact};
use crate::contact_params::ContactParams;
use crate::loop_params::LoopParams;
use crate::output::{Ledger, Output};
use crate::sample::Sample;
use crate::status::Status;

/// Largest size of a contact in float in bytes, for statically allocated memory; palpate_contact_f32_size()
/// returns the actual size. Its alignment is at most PALPATE_CONTACT_ALIGN_MAX.
pub const PALPATE_CONTACT_F32_SIZE_MAX: usize = 2304;

const _: () = assert!(size_of::<Contact<f32>>() <= PALPATE_CONTACT_F32_SIZE_MAX);
const _: () = assert!(align_of::<Contact<f32>>() <= crate::PALPATE_CONTACT_ALIGN_MAX);

/// As palpate_contact_new, in float: the parameters are rounded once. Not in the firmware library.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[cfg(feature = "std")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_f32_new(
    params: *const ContactParams,
    loop_params: *const LoopParams,
    contact: *mut *mut Contact<f32>,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe { contact::new(params, loop_params, contact) }
}

/// As palpate_contact_free, in float. Not in the firmware library.
///
/// # Safety
/// `contact` is NULL or a contact, and is not used afterwards.
#[cfg(feature = "std")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_f32_free(contact: *mut Contact<f32>) {
    // SAFETY: guaranteed by the caller.
    unsafe { contact::free(contact) }
}

/// As palpate_contact_size, in float.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_contact_f32_size() -> usize {
    size_of::<Contact<f32>>()
}

/// As palpate_contact_align, in float.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_contact_f32_align() -> usize {
    align_of::<Contact<f32>>()
}

/// As palpate_contact_place, in float: the parameters are rounded once.
///
/// # Safety
/// `memory` is NULL, or `size` bytes can be written there. Each other pointer is NULL or points to a value of its
/// type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_f32_place(
    memory: *mut c_void,
    size: usize,
    params: *const ContactParams,
    loop_params: *const LoopParams,
    contact: *mut *mut Contact<f32>,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe { contact::place(memory, size, params, loop_params, contact) }
}

/// As palpate_contact_step, in float.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_f32_step(
    contact: *mut Contact<f32>,
    sample: *const Sample<f32>,
    output: *mut Output<f32>,
) -> f32 {
    // SAFETY: guaranteed by the caller.
    unsafe { contact::step(contact, sample, output) }
}

/// As palpate_contact_report_sent, in float.
///
/// # Safety
/// `contact` is NULL or a contact.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_f32_report_sent(
    contact: *mut Contact<f32>,
    force_on_device: f32,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe { contact::report_sent(contact, force_on_device) }
}

/// As palpate_contact_report_sent_line, in float.
///
/// # Safety
/// `contact` is NULL or a contact.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_f32_report_sent_line(
    contact: *mut Contact<f32>,
    force_on_device: f32,
    slope_on_device: f32,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe { contact::report_sent_line(contact, force_on_device, slope_on_device) }
}

/// As palpate_contact_report_held, in float.
///
/// # Safety
/// `contact` is NULL or a contact.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_f32_report_held(
    contact: *mut Contact<f32>,
    force_on_device: f32,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe { contact::report_held(contact, force_on_device) }
}

/// As palpate_contact_change, in float.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_f32_change(
    contact: *mut Contact<f32>,
    params: *const ContactParams,
    loop_params: *const LoopParams,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe { contact::change(contact, params, loop_params) }
}

/// As palpate_contact_teleport, in float.
///
/// # Safety
/// `contact` is NULL or a contact.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_f32_teleport(
    contact: *mut Contact<f32>,
    position: f32,
    velocity: f32,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe { contact::teleport(contact, position, velocity) }
}

/// As palpate_contact_ledger, in float.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_f32_ledger(
    contact: *const Contact<f32>,
    ledger: *mut Ledger<f32>,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe { contact::ledger(contact, ledger) }
}

/// As palpate_contact_describe, in float.
///
/// # Safety
/// `contact` is NULL or a contact; `memory` is NULL, or `size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_f32_describe(
    contact: *const Contact<f32>,
    memory: *mut c_char,
    size: usize,
) -> usize {
    // SAFETY: guaranteed by the caller.
    unsafe { contact::describe(contact, memory, size) }
}
