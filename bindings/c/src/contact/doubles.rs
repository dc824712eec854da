//! A contact in `double`, as C calls it.

use core::ffi::{c_char, c_void};

use crate::contact::{self, Contact};
use crate::contact_params::ContactParams;
use crate::loop_params::LoopParams;
use crate::output::{Ledger, Output};
use crate::sample::Sample;
use crate::status::Status;

/// Bytes that a contact has at most, for memory that is laid out by the compiler;
/// palpate_contact_size() says how many it has.
pub const PALPATE_CONTACT_SIZE_MAX: usize = 4096;

/// A multiple of this is where a contact may begin; palpate_contact_align() says what it needs.
pub const PALPATE_CONTACT_ALIGN_MAX: usize = 8;

const _: () = assert!(size_of::<Contact<f64>>() <= PALPATE_CONTACT_SIZE_MAX);
const _: () = assert!(align_of::<Contact<f64>>() <= PALPATE_CONTACT_ALIGN_MAX);

/// Makes a contact, to be freed by palpate_contact_free, and puts it into `*contact`; NULL on an error.
/// Not in the library for firmware.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[cfg(feature = "std")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_new(
    params: *const ContactParams,
    loop_params: *const LoopParams,
    contact: *mut *mut Contact<f64>,
) -> Status {
    // SAFETY: as the caller says.
    unsafe { contact::new(params, loop_params, contact) }
}

/// Frees a contact of palpate_contact_new. NULL, and a contact in memory of the caller's, are left alone.
/// Not in the library for firmware.
///
/// # Safety
/// `contact` is NULL or a contact, and is not used afterwards.
#[cfg(feature = "std")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_free(contact: *mut Contact<f64>) {
    // SAFETY: as the caller says.
    unsafe { contact::free(contact) }
}

/// Bytes that a contact has.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_contact_size() -> usize {
    size_of::<Contact<f64>>()
}

/// A multiple of this is where a contact may begin.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_contact_align() -> usize {
    align_of::<Contact<f64>>()
}

/// Makes a contact in `size` bytes of the caller's at `memory`, and puts it into `*contact`; NULL on an
/// error. It is there as long as the memory is; nothing has to be freed.
///
/// # Safety
/// `memory` is NULL, or `size` bytes can be written there. Each other pointer is NULL or to what its type
/// says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_place(
    memory: *mut c_void,
    size: usize,
    params: *const ContactParams,
    loop_params: *const LoopParams,
    contact: *mut *mut Contact<f64>,
) -> Status {
    // SAFETY: as the caller says.
    unsafe { contact::place(memory, size, params, loop_params, contact) }
}

/// One tick: takes a sample and gives the force on the device [N], to be held until the next one.
///
/// It cannot fail: the force is a finite number for any input, and 0 where a sample is refused or an
/// argument is wrong. It does not allocate, lock, wait, or loop without bound. `output` may be NULL; where
/// it is given, its `fault` says why a sample was refused. Where an argument is wrong, PALPATE_FAULT_ARGUMENT, there was no tick:
/// the contact stays as it was.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_step(
    contact: *mut Contact<f64>,
    sample: *const Sample<f64>,
    output: *mut Output<f64>,
) -> f64 {
    // SAFETY: as the caller says.
    unsafe { contact::step(contact, sample, output) }
}

/// Says which force on the device was really sent for the last tick [N], where it is another one than
/// the tick has given: something between has limited it. What is not finite is refused.
///
/// # Safety
/// `contact` is NULL or a contact.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_report_sent(
    contact: *mut Contact<f64>,
    force_on_device: f64,
) -> Status {
    // SAFETY: as the caller says.
    unsafe { contact::report_sent(contact, force_on_device) }
}

/// Says which force on the device has really acted since the last sample, in the mean [N], where
/// somebody has measured it. What is not finite is refused.
///
/// # Safety
/// `contact` is NULL or a contact.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_report_held(
    contact: *mut Contact<f64>,
    force_on_device: f64,
) -> Status {
    // SAFETY: as the caller says.
    unsafe { contact::report_held(contact, force_on_device) }
}

/// Renders something else from the next tick on, without a step in the force: stiffness, mass and
/// virtual force pass over to the new ones in 0.1 s, and so does the difference that another method
/// makes. The energy of it is booked as outside work. Where the object is does not change: that is
/// palpate_contact_teleport. The period and the side stay. On an error all is as it was.
///
/// It does not allocate or wait, so the thread of the loop can call it between two ticks.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_change(
    contact: *mut Contact<f64>,
    params: *const ContactParams,
    loop_params: *const LoopParams,
) -> Status {
    // SAFETY: as the caller says.
    unsafe { contact::change(contact, params, loop_params) }
}

/// Puts the object's surface at `position` [m] with the velocity `velocity` [m/s] with the next sample.
/// The energy of it is booked as outside work.
///
/// # Safety
/// `contact` is NULL or a contact.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_teleport(
    contact: *mut Contact<f64>,
    position: f64,
    velocity: f64,
) -> Status {
    // SAFETY: as the caller says.
    unsafe { contact::teleport(contact, position, velocity) }
}

/// Puts the books up to the last sample into `*ledger`.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_ledger(
    contact: *const Contact<f64>,
    ledger: *mut Ledger<f64>,
) -> Status {
    // SAFETY: as the caller says.
    unsafe { contact::ledger(contact, ledger) }
}

/// Puts what is rendered, in words, into `size` bytes at `memory`, cut to them and ended by a 0. Its
/// whole length without the 0; 0 where `contact` is NULL.
///
/// # Safety
/// `contact` is NULL or a contact; `memory` is NULL, or `size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_describe(
    contact: *const Contact<f64>,
    memory: *mut c_char,
    size: usize,
) -> usize {
    // SAFETY: as the caller says.
    unsafe { contact::describe(contact, memory, size) }
}
