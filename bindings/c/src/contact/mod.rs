//! Contact handle in `double` or `float`: implementation of the functions in `doubles` and `floats`.

mod doubles;
mod floats;

pub use doubles::*;
pub use floats::*;

use core::ffi::{c_char, c_void};
use core::ptr;

use palpate_core::{Hold, ObjectState, Running, Sample as CoreSample};

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

/// A rendered contact. Its ticks are in double, or in float if the name ends with f32. Only one thread may use it
/// at a time.
pub struct Contact<S> {
    pub(crate) running: Running<S>,
    /// Checked by recorders.
    #[cfg(feature = "worlds")]
    pub(crate) identity: Identity,
    /// Whether this library allocated it on the heap.
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

/// Returns the contact at `contact`.
///
/// # Safety
/// `contact` is NULL or a contact that is not used otherwise during `'a`.
unsafe fn at<'a, S>(contact: *mut Contact<S>) -> Result<&'a mut Contact<S>, Refusal<'static>> {
    // SAFETY: guaranteed by the caller.
    unsafe { contact.as_mut() }.ok_or(Refusal::Null("contact"))
}

/// Implements `palpate_contact_new`.
///
/// # Safety
/// The conditions of that function apply.
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
        // SAFETY: guaranteed by the caller.
        let rendering = unsafe { rendering(params, loop_params) }?;
        let running = Running::new(rendering)?;
        *out = Box::into_raw(Box::new(Contact::new(running, true)));
        Ok(())
    })
}

/// Implements `palpate_contact_free`.
///
/// # Safety
/// The conditions of that function apply.
#[inline]
#[cfg(feature = "std")]
unsafe fn free<S: Number>(contact: *mut Contact<S>) {
    // SAFETY: guaranteed by the caller.
    if unsafe { contact.as_ref() }.is_some_and(|contact| contact.on_heap) {
        // SAFETY: allocated with `Box::into_raw` by `palpate_contact_new`, and not used afterwards.
        drop(unsafe { Box::from_raw(contact) });
    }
}

/// Implements `palpate_contact_step`.
///
/// # Safety
/// The conditions of that function apply.
#[inline]
unsafe fn step<S: Number>(
    contact: *mut Contact<S>,
    sample: *const Sample<S>,
    output: *mut Output<S>,
) -> S {
    caught(|| {
        // Check all arguments before the tick: a rejected call must not change the contact.
        // SAFETY: guaranteed by the caller.
        let given = unsafe {
            at(contact)
                .and_then(|contact| Ok((contact, Sample::at(sample)?, Room::if_asked(output)?)))
        };
        let (contact, sample, room) = match given {
            Ok((contact, _, None)) if holds_lines(contact) => {
                // SAFETY: guaranteed by the caller.
                return unsafe { refuse(&Refusal::Null("output, which has the slope,"), output) };
            }
            Ok(given) => given,
            // SAFETY: guaranteed by the caller.
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
        // SAFETY: guaranteed by the caller.
        let _ = unsafe { sized::write(output, || Output::refused(Fault::Internal)) };
        S::ZERO
    })
}

/// Whether the actuator of the contact holds lines.
fn holds_lines<S: Number>(contact: &Contact<S>) -> bool {
    contact.running.rendering().loop_params.actuation.hold == Hold::Line
}

/// Returns zero force and writes the fault if `output` has room for it.
///
/// # Safety
/// `output` is NULL or points to an output whose first field is its size.
#[cold]
unsafe fn refuse<S: Number>(refusal: &Refusal<'_>, output: *mut Output<S>) -> S {
    last_error::set(refusal);
    // SAFETY: guaranteed by the caller.
    let _ = unsafe { sized::write(output, || Output::refused(Fault::Argument)) };
    S::ZERO
}

/// Returns a reported value if it is finite.
fn reported<S: Number>(
    name: &'static str,
    given: S,
    allowed: &'static str,
) -> Result<S, Refusal<'static>> {
    if given.is_finite() {
        return Ok(given);
    }
    Err(Refusal::Number {
        name,
        given: given.to_f64(),
        allowed,
    })
}

/// Returns a reported force on the object if it is finite.
fn on_object<S: Number>(force_on_device: S) -> Result<S, Refusal<'static>> {
    reported("force_on_device", force_on_device, "finite [N]").map(|force| -force)
}

/// Implements `palpate_contact_report_sent`.
///
/// # Safety
/// The conditions of that function apply.
#[inline]
unsafe fn report_sent<S: Number>(contact: *mut Contact<S>, force_on_device: S) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let contact = unsafe { at(contact) }?;
        contact.running.report_sent(on_object(force_on_device)?);
        Ok(())
    })
}

/// Implements `palpate_contact_report_sent_line`.
///
/// # Safety
/// The conditions of that function apply.
#[inline]
unsafe fn report_sent_line<S: Number>(
    contact: *mut Contact<S>,
    force_on_device: S,
    slope_on_device: S,
) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let contact = unsafe { at(contact) }?;
        let slope = reported("slope_on_device", slope_on_device, "finite [N/s]")?;
        let force = on_object(force_on_device)?;
        contact.running.report_sent_line(force, -slope);
        Ok(())
    })
}

/// Implements `palpate_contact_report_held`.
///
/// # Safety
/// The conditions of that function apply.
#[inline]
unsafe fn report_held<S: Number>(contact: *mut Contact<S>, force_on_device: S) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let contact = unsafe { at(contact) }?;
        contact.running.report_held(on_object(force_on_device)?);
        Ok(())
    })
}

/// Implements `palpate_contact_change`.
///
/// # Safety
/// The conditions of that function apply.
#[inline]
unsafe fn change<S: Number>(
    contact: *mut Contact<S>,
    params: *const ContactParams,
    loop_params: *const LoopParams,
) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let (contact, rendering) = unsafe { (at(contact)?, rendering(params, loop_params)?) };
        Ok(contact.running.change(rendering)?)
    })
}

/// Implements `palpate_contact_teleport`.
///
/// # Safety
/// The conditions of that function apply.
#[inline]
unsafe fn teleport<S: Number>(contact: *mut Contact<S>, position: S, velocity: S) -> Status {
    status(|| {
        // SAFETY: guaranteed by the caller.
        let contact = unsafe { at(contact) }?;
        Ok(contact
            .running
            .teleport(ObjectState { position, velocity })?)
    })
}

/// Implements `palpate_contact_ledger`.
///
/// # Safety
/// The conditions of that function apply.
#[inline]
unsafe fn ledger<S: Number>(contact: *const Contact<S>, ledger: *mut Ledger<S>) -> Status {
    status(|| {
        // SAFETY: NULL, or a contact that is not modified during this call.
        let contact = unsafe { contact.as_ref() }.ok_or(Refusal::Null("contact"))?;
        // SAFETY: guaranteed by the caller.
        unsafe { sized::write(ledger, || contact.running.ledger().into()) }
    })
}

/// Implements `palpate_contact_describe`.
///
/// # Safety
/// The conditions of that function apply.
#[inline]
unsafe fn describe<S: Number>(
    contact: *const Contact<S>,
    memory: *mut c_char,
    size: usize,
) -> usize {
    // SAFETY: NULL, or a contact that is not modified during this call.
    let contact = unsafe { contact.as_ref() };
    let described = caught(|| match contact {
        // SAFETY: guaranteed by the caller.
        Some(contact) => unsafe { text::put_at(contact.running.rendering(), memory, size) },
        // SAFETY: guaranteed by the caller.
        None => unsafe { text::put_at("", memory, size) },
    });
    described.unwrap_or(0)
}

/// Implements `palpate_contact_place`.
///
/// # Safety
/// The conditions of that function apply.
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
        // SAFETY: guaranteed by the caller.
        let rendering = unsafe { rendering(params, loop_params) }?;
        let running = Running::new(rendering)?;
        // SAFETY: not NULL, aligned, and at least `needed` bytes can be written.
        unsafe {
            memory.write(Contact::new(running, false));
        }
        *out = memory;
        Ok(())
    })
}
