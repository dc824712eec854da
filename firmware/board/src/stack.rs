//! Stack depth of a call: the stack below is painted before the call, and the lowest changed byte is found after it.
#![allow(unsafe_code)] // it writes below the stack pointer

use core::ptr;

/// Painted depth `[bytes]`.
const PAINTED: usize = 32 * 1024;
/// Distance between the stack pointer and the paint `[bytes]`: the frame of the painter.
const MARGIN: usize = 64;
const COLOUR: u8 = 0xA5;

/// Returns the stack depth of `call` below its caller `[bytes]`, at least [`MARGIN`]. Interrupts must be off meanwhile.
#[inline(never)]
pub fn depth(call: &mut dyn FnMut()) -> usize {
    let base = usize::try_from(cortex_m::register::msp::read()).unwrap_or(0);
    paint(base);
    call();
    base - lowest(base)
}

/// Paints the stack below `base`.
#[inline(never)]
fn paint(base: usize) {
    for address in base - PAINTED..base - MARGIN {
        let byte = ptr::with_exposed_provenance_mut::<u8>(address);
        // SAFETY: memory below the stack pointer, and below this function's own frame, which is smaller than MARGIN;
        // the stack has 3 MiB above the statics, so it contains nothing else.
        unsafe { byte.write_volatile(COLOUR) };
    }
}

/// Returns the lowest address below `base` whose paint has changed.
#[inline(never)]
fn lowest(base: usize) -> usize {
    (base - PAINTED..base - MARGIN)
        .find(|&address| {
            let byte = ptr::with_exposed_provenance::<u8>(address);
            // SAFETY: as above, and painted, so initialised.
            unsafe { byte.read_volatile() != COLOUR }
        })
        .unwrap_or(base - MARGIN)
}
