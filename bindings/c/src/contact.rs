//! A contact behind a handle.

use core::ffi::c_char;
use core::ptr;

use palpate_core::{ObjectState, Running, Sample as CoreSample};

use crate::contact_params::{ContactParams, rendering};
use crate::edge::{caught, status};
use crate::last_error;
use crate::loop_params::LoopParams;
use crate::output::{Fault, Ledger, Output};
use crate::sample::Sample;
use crate::sized;
use crate::status::{Refusal, Status};
use crate::text;

/// A contact that is rendered. One thread at a time may use it.
pub struct Contact {
    pub(crate) running: Running<f64>,
    /// Whether it is on the heap of this library.
    #[cfg_attr(not(feature = "std"), allow(dead_code))]
    pub(crate) on_heap: bool,
}

/// The contact at `contact`.
///
/// # Safety
/// `contact` is NULL or a contact, which nobody else uses during `'a`.
unsafe fn at<'a>(contact: *mut Contact) -> Result<&'a mut Contact, Refusal<'static>> {
    // SAFETY: as the caller says.
    unsafe { contact.as_mut() }.ok_or(Refusal::Null("contact"))
}

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
    contact: *mut *mut Contact,
) -> Status {
    status(|| {
        // SAFETY: NULL, or a pointer can be written there.
        let out = unsafe { contact.as_mut() }.ok_or(Refusal::Null("contact"))?;
        *out = ptr::null_mut();
        // SAFETY: as the caller says.
        let rendering = unsafe { rendering(params, loop_params) }?;
        let running = Running::new(rendering)?;
        *out = Box::into_raw(Box::new(Contact {
            running,
            on_heap: true,
        }));
        Ok(())
    })
}

/// Frees a contact of palpate_contact_new. NULL, and a contact in memory of the caller's, are left alone.
/// Not in the library for firmware.
///
/// # Safety
/// `contact` is NULL or a contact, and is not used afterwards.
#[cfg(feature = "std")]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_free(contact: *mut Contact) {
    // SAFETY: as the caller says.
    if unsafe { contact.as_ref() }.is_some_and(|contact| contact.on_heap) {
        // SAFETY: `palpate_contact_new` has made it by `Box::into_raw`, and it is not used afterwards.
        drop(unsafe { Box::from_raw(contact) });
    }
}

/// One tick: takes a sample and gives the force on the device [N], to be held until the next one.
///
/// It cannot fail: the force is a finite number for any input, and 0 where a sample is refused or an
/// argument is wrong. It does not allocate, lock, wait, or loop without bound. `output` may be NULL; where
/// it is given, its `fault` says why a sample was refused.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_step(
    contact: *mut Contact,
    sample: *const Sample,
    output: *mut Output,
) -> f64 {
    caught(|| {
        // SAFETY: as the caller says.
        let sampled =
            unsafe { at(contact).and_then(|contact| Ok((contact, sized::read(sample)?))) };
        let answer = match sampled {
            Ok((contact, sample)) => contact.running.step(CoreSample::from(sample)),
            // SAFETY: as the caller says.
            Err(refusal) => return unsafe { refuse(&refusal, output) },
        };
        if output.is_null() {
            return answer.force_on_device;
        }
        // SAFETY: as the caller says.
        match unsafe { sized::write(output, || Output::from(answer)) } {
            Ok(()) => answer.force_on_device,
            // A caller who has not said what it has room for gets no force.
            // SAFETY: NULL is allowed.
            Err(refusal) => unsafe { refuse(&refusal, ptr::null_mut()) },
        }
    })
    .unwrap_or_else(|| {
        // SAFETY: as the caller says.
        let _ = unsafe { sized::write(output, || Output::refused(Fault::Internal)) };
        0.0
    })
}

/// No force, and its reason where there is room for it.
///
/// # Safety
/// `output` is NULL or an output of the size that it begins with.
#[cold]
unsafe fn refuse(refusal: &Refusal<'_>, output: *mut Output) -> f64 {
    last_error::set(refusal);
    // SAFETY: as the caller says.
    let _ = unsafe { sized::write(output, || Output::refused(Fault::Argument)) };
    0.0
}

/// Says which force on the device was really sent for the last tick [N], where it is another one than
/// the tick has given: something between has limited it.
///
/// # Safety
/// `contact` is NULL or a contact.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_report_sent(
    contact: *mut Contact,
    force_on_device: f64,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        unsafe { at(contact) }?
            .running
            .report_sent(-force_on_device);
        Ok(())
    })
}

/// Says which force on the device has really acted since the last sample, in the mean [N], where
/// somebody has measured it.
///
/// # Safety
/// `contact` is NULL or a contact.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_report_held(
    contact: *mut Contact,
    force_on_device: f64,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        unsafe { at(contact) }?
            .running
            .report_held(-force_on_device);
        Ok(())
    })
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
    contact: *mut Contact,
    params: *const ContactParams,
    loop_params: *const LoopParams,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let (contact, rendering) = unsafe { (at(contact)?, rendering(params, loop_params)?) };
        Ok(contact.running.change(rendering)?)
    })
}

/// Puts the object's surface at `position` [m] with the velocity `velocity` [m/s] with the next sample.
/// The energy of it is booked as outside work.
///
/// # Safety
/// `contact` is NULL or a contact.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_teleport(
    contact: *mut Contact,
    position: f64,
    velocity: f64,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let contact = unsafe { at(contact) }?;
        Ok(contact
            .running
            .teleport(ObjectState { position, velocity })?)
    })
}

/// Puts the books up to the last sample into `*ledger`.
///
/// # Safety
/// Each pointer is NULL or to what its type says; structs have the sizes that they begin with.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_ledger(
    contact: *const Contact,
    ledger: *mut Ledger,
) -> Status {
    status(|| {
        // SAFETY: NULL, or a contact that nobody changes meanwhile.
        let contact = unsafe { contact.as_ref() }.ok_or(Refusal::Null("contact"))?;
        // SAFETY: as the caller says.
        unsafe { sized::write(ledger, || contact.running.ledger().into()) }
    })
}

/// Puts what is rendered, in words, into `size` bytes at `memory`, cut to them and ended by a 0. Its
/// whole length without the 0; 0 where `contact` is NULL.
///
/// # Safety
/// `contact` is NULL or a contact; `memory` is NULL, or `size` bytes can be written there.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn palpate_contact_describe(
    contact: *const Contact,
    memory: *mut c_char,
    size: usize,
) -> usize {
    // SAFETY: NULL, or a contact that nobody changes meanwhile.
    let contact = unsafe { contact.as_ref() };
    let described = caught(|| match contact {
        // SAFETY: as the caller says.
        Some(contact) => unsafe { text::put_at(contact.running.rendering(), memory, size) },
        // SAFETY: as the caller says.
        None => unsafe { text::put_at("", memory, size) },
    });
    described.unwrap_or(0)
}
