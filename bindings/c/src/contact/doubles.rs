//! C functions of a contact in `double`.

use core::ffi::{c_char, c_void};

use crate::contact::{self, Contact};
use crate::contact_params::ContactParams;
use crate::loop_params::LoopParams;
use crate::output::{Ledger, Output};
use crate::sample::Sample;
use crate::status::Status;

/// Largest size of a contact in bytes, for statically allocated memory; palpate_contact_size() returns the
/// actual size.
pub const PALPATE_CONTACT_SIZE_MAX: usize = 4608;

/// Largest alignment of a contact in bytes; palpate_contact_align() returns the actual alignment.
pub const PALPATE_CONTACT_ALIGN_MAX: usize = 8;

const _: () = assert!(size_of::<Contact<f64>>() <= PALPATE_CONTACT_SIZE_MAX);
const _: () = assert!(align_of::<Contact<f64>>() <= PALPATE_CONTACT_ALIGN_MAX);

/// Creates a contact and stores it in `*contact`, or NULL on an error. Free it with palpate_contact_free.
/// Not in the firmware library.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[cfg(feature = "std")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_new(
    params: *const ContactParams,
    loop_params: *const LoopParams,
    contact: *mut *mut Contact<f64>,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe { contact::new(params, loop_params, contact) }
}

/// Frees a contact of palpate_contact_new. NULL and a contact in caller-owned memory are ignored.
/// Not in the firmware library.
///
/// # Safety
/// `contact` is NULL or a contact, and is not used afterwards.
#[cfg(feature = "std")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_free(contact: *mut Contact<f64>) {
    // SAFETY: guaranteed by the caller.
    unsafe { contact::free(contact) }
}

/// Returns the size of a contact in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_contact_size() -> usize {
    size_of::<Contact<f64>>()
}

/// Returns the alignment of a contact in bytes.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_contact_align() -> usize {
    align_of::<Contact<f64>>()
}

/// Creates a contact in `size` bytes of caller-owned memory and stores its address in `*contact`, or NULL on
/// an error. The contact lives as long as the memory and need not be freed.
///
/// # Safety
/// `memory` is NULL, or `size` bytes can be written there. Each other pointer is NULL or points to a value of its
/// type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_place(
    memory: *mut c_void,
    size: usize,
    params: *const ContactParams,
    loop_params: *const LoopParams,
    contact: *mut *mut Contact<f64>,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe { contact::place(memory, size, params, loop_params, contact) }
}

/// Executes one tick: takes a sample and returns the force on the device [N], to be held until the next tick.
///
/// It cannot fail: the force is finite for any input, and 0 if the sample is rejected or an argument is
/// wrong. It does not allocate, lock, wait, or loop without bound. `output` may be NULL, except with
/// PALPATE_HOLD_LINE, whose force is the mean of a line; otherwise its `fault` is the reason for rejecting a sample. PALPATE_FAULT_ARGUMENT means that an argument is wrong: no tick was
/// executed, and the contact is unchanged.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_step(
    contact: *mut Contact<f64>,
    sample: *const Sample<f64>,
    output: *mut Output<f64>,
) -> f64 {
    // SAFETY: guaranteed by the caller.
    unsafe { contact::step(contact, sample, output) }
}

/// Reports the force that was actually sent to the device for the last tick, for example after saturation [N].
/// A non-finite force is rejected.
///
/// # Safety
/// `contact` is NULL or a contact.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_report_sent(
    contact: *mut Contact<f64>,
    force_on_device: f64,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe { contact::report_sent(contact, force_on_device) }
}

/// Reports the line that was actually sent to the device for the last tick: its mean [N] and its slope [N/s]. With
/// PALPATE_HOLD_LINE palpate_contact_report_sent reports a constant. A non-finite value is rejected.
///
/// # Safety
/// `contact` is NULL or a contact.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_report_sent_line(
    contact: *mut Contact<f64>,
    force_on_device: f64,
    slope_on_device: f64,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe { contact::report_sent_line(contact, force_on_device, slope_on_device) }
}

/// Reports the measured mean force on the device since the last sample [N]. A non-finite force is rejected.
///
/// # Safety
/// `contact` is NULL or a contact.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_report_held(
    contact: *mut Contact<f64>,
    force_on_device: f64,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe { contact::report_held(contact, force_on_device) }
}

/// Changes the rendering from the next tick on, without a step in the force: stiffness, mass, virtual force
/// and the difference between two methods are blended over 0.1 s. The energy of the change is recorded as
/// outside work. The object's position does not change (see palpate_contact_teleport), nor do the period and
/// the side. On an error nothing changes.
///
/// It does not allocate or wait, so the loop thread can call it between two ticks.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_change(
    contact: *mut Contact<f64>,
    params: *const ContactParams,
    loop_params: *const LoopParams,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe { contact::change(contact, params, loop_params) }
}

/// Moves the object's surface to `position` [m] with velocity `velocity` [m/s] at the next sample. The energy
/// of the move is recorded as outside work.
///
/// # Safety
/// `contact` is NULL or a contact.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_teleport(
    contact: *mut Contact<f64>,
    position: f64,
    velocity: f64,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe { contact::teleport(contact, position, velocity) }
}

/// Writes the energy ledger up to the last sample to `*ledger`.
///
/// # Safety
/// Each pointer is NULL or points to a value of its type; the first field of each struct is its size.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_ledger(
    contact: *const Contact<f64>,
    ledger: *mut Ledger<f64>,
) -> Status {
    // SAFETY: guaranteed by the caller.
    unsafe { contact::ledger(contact, ledger) }
}

/// Writes a description of the rendering to `memory`, truncated to `size` bytes and terminated by a 0.
/// Returns the untruncated length without the 0, or 0 if `contact` is NULL.
///
/// # Safety
/// `contact` is NULL or a contact; `memory` is NULL, or `size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_describe(
    contact: *const Contact<f64>,
    memory: *mut c_char,
    size: usize,
) -> usize {
    // SAFETY: guaranteed by the caller.
    unsafe { contact::describe(contact, memory, size) }
}
