//! A contact behind a handle, in `double` or in `float`: what the functions of `doubles` and `floats` do.

mod doubles;
mod floats;

pub use doubles::*;
pub use floats::*;

use core::ffi::{c_char, c_void};
use core::ptr;

use palpate::{ObjectState, Running, Sample as CoreSample};

use crate::contact_params::{ContactParams, rendering};
use crate::edge::{caught, status};
#[cfg(feature = "worlds")]
use crate::identity::Identity;
use crate::last_error;
use crate::loop_params::LoopParams;
use crate::number::Number;
use crate::output::{Fault, Ledger, Output};
use crate::sample::Sample;
use crate::sized::{self, Room};
use crate::status::{Refusal, Status};
use crate::text;

/// A contact that is rendered; its ticks are in double, or in float where its name ends with f32. One thread at a
/// time may use it.
pub struct Contact<S> {
    pub(crate) running: Running<S>,
    /// For recorders.
    #[cfg(feature = "worlds")]
    pub(crate) identity: Identity,
    /// Whether it is on the heap of this library.
    #[cfg_attr(not(feature = "std"), allow(dead_code))]
    on_heap: bool,
}

impl<S> Contact<S> {
    fn new(running: Running<S>, on_heap: bool) -> Self {
        Self {
            running,
            #[cfg(feature = "worlds")]
            identity: Identity::next(),
            on_heap,
        }
    }
}

/// The contact at `contact`.
///
/// # Safety
/// `contact` is NULL or a contact, which nobody else uses during `'a`.
unsafe fn at<'a, S>(contact: *mut Contact<S>) -> Result<&'a mut Contact<S>, Refusal<'static>> {
    // SAFETY: as the caller says.
    unsafe { contact.as_mut() }.ok_or(Refusal::Null("contact"))
}

/// `palpate_contact_new`.
///
/// # Safety
/// As said of that function.
#[inline]
#[cfg(feature = "std")]
unsafe fn new<S: Number>(
    params: *const ContactParams,
    loop_params: *const LoopParams,
    contact: *mut *mut Contact<S>,
) -> Status {
    status(|| {
        // SAFETY: NULL, or a pointer can be written there.
        let out = unsafe { contact.as_mut() }.ok_or(Refusal::Null("contact"))?;
        *out = ptr::null_mut();
        // SAFETY: as the caller says.
        let rendering = unsafe { rendering(params, loop_params) }?;
        let running = Running::new(rendering)?;
        *out = Box::into_raw(Box::new(Contact::new(running, true)));
        Ok(())
    })
}

/// `palpate_contact_free`.
///
/// # Safety
/// As said of that function.
#[inline]
#[cfg(feature = "std")]
unsafe fn free<S: Number>(contact: *mut Contact<S>) {
    // SAFETY: as the caller says.
    if unsafe { contact.as_ref() }.is_some_and(|contact| contact.on_heap) {
        // SAFETY: `palpate_contact_new` has made it by `Box::into_raw`, and it is not used afterwards.
        drop(unsafe { Box::from_raw(contact) });
    }
}

/// `palpate_contact_step`.
///
/// # Safety
/// As said of that function.
#[inline]
unsafe fn step<S: Number>(
    contact: *mut Contact<S>,
    sample: *const Sample<S>,
    output: *mut Output<S>,
) -> S {
    caught(|| {
        // All of it before the tick: one that is refused has not been.
        // SAFETY: as the caller says.
        let given = unsafe {
            at(contact)
                .and_then(|contact| Ok((contact, Sample::at(sample)?, Room::if_asked(output)?)))
        };
        let (contact, sample, room) = match given {
            Ok(given) => given,
            // SAFETY: as the caller says.
            Err(refusal) => return unsafe { refuse(&refusal, output) },
        };
        let answer = contact.running.step(CoreSample::from(sample));
        let force_on_device = answer.force_on_device;
        if let Some(room) = room {
            room.write(Output::from(answer));
        }
        force_on_device
    })
    .unwrap_or_else(|| {
        // SAFETY: as the caller says.
        let _ = unsafe { sized::write(output, || Output::refused(Fault::Internal)) };
        S::ZERO
    })
}

/// No force, and its reason where there is room for it.
///
/// # Safety
/// `output` is NULL or an output of the size that it begins with.
#[cold]
unsafe fn refuse<S: Number>(refusal: &Refusal<'_>, output: *mut Output<S>) -> S {
    last_error::set(refusal);
    // SAFETY: as the caller says.
    let _ = unsafe { sized::write(output, || Output::refused(Fault::Argument)) };
    S::ZERO
}

/// A force that is reported, if it is a number.
fn reported<S: Number>(force_on_device: S) -> Result<S, Refusal<'static>> {
    if force_on_device.is_finite() {
        return Ok(force_on_device);
    }
    Err(Refusal::Number {
        name: "force_on_device",
        given: force_on_device.to_f64(),
        allowed: "finite [N]",
    })
}

/// `palpate_contact_report_sent`.
///
/// # Safety
/// As said of that function.
#[inline]
unsafe fn report_sent<S: Number>(contact: *mut Contact<S>, force_on_device: S) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let contact = unsafe { at(contact) }?;
        contact.running.report_sent(-reported(force_on_device)?);
        Ok(())
    })
}

/// `palpate_contact_report_held`.
///
/// # Safety
/// As said of that function.
#[inline]
unsafe fn report_held<S: Number>(contact: *mut Contact<S>, force_on_device: S) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let contact = unsafe { at(contact) }?;
        contact.running.report_held(-reported(force_on_device)?);
        Ok(())
    })
}

/// `palpate_contact_change`.
///
/// # Safety
/// As said of that function.
#[inline]
unsafe fn change<S: Number>(
    contact: *mut Contact<S>,
    params: *const ContactParams,
    loop_params: *const LoopParams,
) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let (contact, rendering) = unsafe { (at(contact)?, rendering(params, loop_params)?) };
        Ok(contact.running.change(rendering)?)
    })
}

/// `palpate_contact_teleport`.
///
/// # Safety
/// As said of that function.
#[inline]
unsafe fn teleport<S: Number>(contact: *mut Contact<S>, position: S, velocity: S) -> Status {
    status(|| {
        // SAFETY: as the caller says.
        let contact = unsafe { at(contact) }?;
        Ok(contact
            .running
            .teleport(ObjectState { position, velocity })?)
    })
}

/// `palpate_contact_ledger`.
///
/// # Safety
/// As said of that function.
#[inline]
unsafe fn ledger<S: Number>(contact: *const Contact<S>, ledger: *mut Ledger<S>) -> Status {
    status(|| {
        // SAFETY: NULL, or a contact that nobody changes meanwhile.
        let contact = unsafe { contact.as_ref() }.ok_or(Refusal::Null("contact"))?;
        // SAFETY: as the caller says.
        unsafe { sized::write(ledger, || contact.running.ledger().into()) }
    })
}

/// `palpate_contact_describe`.
///
/// # Safety
/// As said of that function.
#[inline]
unsafe fn describe<S: Number>(
    contact: *const Contact<S>,
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

/// `palpate_contact_place`.
///
/// # Safety
/// As said of that function.
#[inline]
unsafe fn place<S: Number>(
    memory: *mut c_void,
    size: usize,
    params: *const ContactParams,
    loop_params: *const LoopParams,
    contact: *mut *mut Contact<S>,
) -> Status {
    status(|| {
        // SAFETY: NULL, or a pointer can be written there.
        let out = unsafe { contact.as_mut() }.ok_or(Refusal::Null("contact"))?;
        *out = ptr::null_mut();
        let memory = memory.cast::<Contact<S>>();
        let needed = size_of::<Contact<S>>();
        if memory.is_null() {
            return Err(Refusal::Null("memory"));
        }
        if size < needed {
            return Err(Refusal::TooSmall {
                given: size,
                needed,
            });
        }
        if !memory.is_aligned() {
            let needed = align_of::<Contact<S>>();
            return Err(Refusal::NotAligned { needed });
        }
        // SAFETY: as the caller says.
        let rendering = unsafe { rendering(params, loop_params) }?;
        let running = Running::new(rendering)?;
        // SAFETY: not NULL, aligned, and as many bytes as needed can be written.
        unsafe {
            memory.write(Contact::new(running, false));
        }
        *out = memory;
        Ok(())
    })
}
