//! A contact in memory of the caller's: for firmware, and for whoever has no heap in a loop.

use core::ffi::c_void;

use palpate_core::Running;

use crate::contact::Contact;
use crate::contact_params::{ContactParams, rendering};
use crate::edge::status;
use crate::loop_params::LoopParams;
use crate::status::{Refusal, Status};

/// Bytes that a contact has at most, for memory that is laid out by the compiler;
/// palpate_contact_size() says how many it has.
pub const PALPATE_CONTACT_SIZE_MAX: usize = 4096;

/// A multiple of this is where a contact may begin; palpate_contact_align() says what it needs.
pub const PALPATE_CONTACT_ALIGN_MAX: usize = 8;

const _: () = assert!(size_of::<Contact>() <= PALPATE_CONTACT_SIZE_MAX);
const _: () = assert!(align_of::<Contact>() <= PALPATE_CONTACT_ALIGN_MAX);

/// Bytes that a contact has.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_contact_size() -> usize {
    size_of::<Contact>()
}

/// A multiple of this is where a contact may begin.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_contact_align() -> usize {
    align_of::<Contact>()
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
    contact: *mut *mut Contact,
) -> Status {
    status(|| {
        // SAFETY: NULL, or a pointer can be written there.
        let out = unsafe { contact.as_mut() }.ok_or(Refusal::Null("contact"))?;
        *out = core::ptr::null_mut();
        let memory = memory.cast::<Contact>();
        let needed = size_of::<Contact>();
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
            let needed = align_of::<Contact>();
            return Err(Refusal::NotAligned { needed });
        }
        // SAFETY: as the caller says.
        let rendering = unsafe { rendering(params, loop_params) }?;
        let running = Running::new(rendering)?;
        // SAFETY: not NULL, aligned, and as many bytes as needed can be written.
        unsafe {
            memory.write(Contact {
                running,
                on_heap: false,
            });
        }
        *out = memory;
        Ok(())
    })
}
