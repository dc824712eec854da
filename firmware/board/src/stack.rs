//! Stack that a call uses: what lies below is painted before it, and the lowest byte that has lost its colour
//! is looked for after it.
#![allow(unsafe_code)] // it writes below the stack pointer

use core::ptr;

/// Depth that is painted `[bytes]`.
const PAINTED: usize = 32 * 1024;
/// What lies between the stack pointer and the paint `[bytes]`: the frame of the painter.
const MARGIN: usize = 64;
const COLOUR: u8 = 0xA5;

/// Depth of the stack that `call` uses below its caller `[bytes]`, at least [`MARGIN`]. No interrupt may be
/// running meanwhile.
#[inline(never)]
pub fn depth(call: &mut dyn FnMut()) -> usize {
    let base = usize::try_from(cortex_m::register::msp::read()).unwrap_or(0);
    paint(base);
    call();
    base - lowest(base)
}

/// Paints what lies below `base`.
#[inline(never)]
fn paint(base: usize) {
    for address in base - PAINTED..base - MARGIN {
        let byte = ptr::with_exposed_provenance_mut::<u8>(address);
        // SAFETY: memory below the stack pointer, and below this function's own frame, which is smaller
        // than MARGIN; the stack has 3 MiB down to the statics, so nothing else lies here.
        unsafe { byte.write_volatile(COLOUR) };
    }
}

/// The lowest address below `base` that is not painted any more.
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
