//! The first collision of the paper's Fig. 2 scene, rendered by HFCR in a program without std:
//! no allocator, no unwinding, output through libc. Exits with 0 if every force is the stated one,
//! in both precisions.
//!
//! ```text
//! cargo run --manifest-path conformance/no_std/Cargo.toml
//! ```
#![no_std]
#![no_main]

use core::ffi::{CStr, c_int};
use core::panic::PanicInfo;

use palpate::{
    AnyParams, AnyRenderer, Contact, Fault, HfcrParams, LoopParams, ObjectState, Sample, Scalar,
};

/// Tick of the first force that is not 0.
const FIRST_CONTACT: usize = 10;
/// Forces on the object from then on `[N]`, of an independent implementation:
/// `fig2_hfcr.csv` of `crates/palpate-sim/tests/vectors`.
const STATED: [f64; 10] = [
    1.241_618_935_297_262,
    3.300_190_570_569_963_5,
    4.830_206_339_889_713,
    5.592_082_157_570_045,
    5.435_059_771_666_094,
    4.389_823_895_652_823,
    2.664_139_616_614_174_4,
    0.601_597_020_409_206_9,
    -0.000_766_124_472_979_279_7,
    0.0,
];

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    // SAFETY: `abort` takes nothing and does not return.
    unsafe { libc::abort() }
}

/// The precompiled `core` refers to it, even where nothing unwinds; it is never called.
#[unsafe(no_mangle)]
extern "C" fn rust_eh_personality() {}

/// Runs the scene and gives the largest difference from the stated forces `[N]`.
fn largest_difference<S: Scalar>() -> f64 {
    let of = S::from_f64;
    let contact = Contact::object(of(100.0), of(0.1));
    let method = AnyParams::Hfcr(HfcrParams::with_damping(of(0.02)));
    let start = ObjectState::at_rest(of(0.1));
    let Ok(renderer) = AnyRenderer::new(contact, LoopParams::new(of(0.01)), method) else {
        return f64::INFINITY;
    };
    let Ok(mut state) = renderer.start(start) else {
        return f64::INFINITY;
    };
    let (mut position, mut velocity) = (0.0, 0.0);
    let mut largest = 0.0;
    for tick in 0..FIRST_CONTACT + STATED.len() {
        let sample = Sample::at(of(position)).with_virtual_force(of(-0.981));
        let output = renderer.step(&mut state, sample);
        let stated = tick
            .checked_sub(FIRST_CONTACT)
            .map_or(0.0, |contact| STATED[contact]);
        let difference = Scalar::abs(output.force_on_object.to_f64() - stated);
        // A NaN is kept, since nothing exceeds it.
        if difference.is_nan() || difference > largest {
            largest = difference;
        }
        // A device of 0.1 kg, pushed with 0.981 N.
        let acceleration = (0.981 + output.force_on_device.to_f64()) / 0.1;
        position += (velocity + 0.5 * acceleration * 0.01) * 0.01;
        velocity += acceleration * 0.01;
    }
    let refused = renderer.step(&mut state, Sample::at(of(f64::NAN)));
    if refused.fault == Some(Fault::PositionNotFinite) {
        largest
    } else {
        f64::INFINITY
    }
}

fn report(precision: &CStr, difference: f64, tolerance: f64) -> bool {
    let agrees = difference <= tolerance;
    let verdict = if agrees { c"ok" } else { c"FAILED" };
    // SAFETY: the format takes two strings and two doubles, and gets them.
    unsafe {
        libc::printf(
            c"%s: forces within %.1e N of the stated ones (%.0e allowed): %s\n".as_ptr(),
            precision.as_ptr(),
            difference,
            tolerance,
            verdict.as_ptr(),
        );
    }
    agrees
}

/// Entry point that the C runtime calls.
#[unsafe(no_mangle)]
pub extern "C" fn main(_count: c_int, _arguments: *const *const u8) -> c_int {
    let double = report(c"f64", largest_difference::<f64>(), 1e-9);
    let single = report(c"f32", largest_difference::<f32>(), 1e-3);
    c_int::from(!(double && single))
}
