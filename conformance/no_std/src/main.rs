//! The first collision of the paper's Fig. 2 scene, rendered by HFCR and by coupled rendering in a program without std:
//! no allocator, no unwinding, output through libc. Exits with 0 if every force equals its reference value, in both
//! precisions.
//!
//! ```text
//! cargo run --manifest-path conformance/no_std/Cargo.toml
//! ```
#![no_std]
#![no_main]

use core::ffi::{CStr, c_int};
use core::panic::PanicInfo;

use palpate::{
    AnyParams, AnyRenderer, Contact, CoupledParams, Fault, HfcrParams, LoopParams, ObjectState,
    Sample, Scalar,
};

/// Tick of the first nonzero force.
const FIRST_CONTACT: usize = 10;
/// Forces on the object from then on `[N]`, from an independent implementation: `fig2_hfcr.csv` of
/// `crates/palpate-study/tests/it/vectors`.
const HFCR: [f64; 10] = [
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

/// Means of the ideal force over the same periods `[N]`, in closed form: p(t) of two bodies of
/// 0.1 kg that meet at sqrt(0.2 / 19.62) s under 19.62 m/s^2, integrated between the ticks.
const COUPLED: [f64; 10] = [
    0.821_727_662_791,
    2.773_403_080_878,
    4.381_701_761_976,
    5.321_120_461_369,
    5.406_886_033_260,
    4.622_129_349_402,
    3.121_203_267_846,
    1.199_323_153_022,
    0.009_138_617_708,
    0.0,
];

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    // SAFETY: `abort` has no arguments and does not return.
    unsafe { libc::abort() }
}

/// The precompiled `core` refers to it even without unwinding; it is never called.
#[unsafe(no_mangle)]
extern "C" fn rust_eh_personality() {}

/// Runs the scene and returns the largest difference from the reference forces `[N]`.
fn largest_difference<S: Scalar>(method: AnyParams<S>, stated: &[f64; 10]) -> f64 {
    let of = S::from_f64;
    let contact = Contact::object(of(100.0), of(0.1));
    let start = ObjectState::at_rest(of(0.1));
    let Ok(renderer) = AnyRenderer::new(contact, LoopParams::new(of(0.01)), method) else {
        return f64::INFINITY;
    };
    let Ok(mut state) = renderer.start(start) else {
        return f64::INFINITY;
    };
    let (mut position, mut velocity) = (0.0, 0.0);
    let mut largest = 0.0;
    for tick in 0..FIRST_CONTACT + stated.len() {
        let sample = Sample::at(of(position)).with_virtual_force(of(-0.981));
        let output = renderer.step(&mut state, sample);
        let expected = tick
            .checked_sub(FIRST_CONTACT)
            .map_or(0.0, |contact| stated[contact]);
        let difference = Scalar::abs(output.force_on_object.to_f64() - expected);
        // A NaN is kept, because no value exceeds it.
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
    // SAFETY: the format requires two strings and two doubles, which are passed.
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

/// Both methods in one precision.
fn largest_differences<S: Scalar>() -> [f64; 2] {
    let hfcr = AnyParams::Hfcr(HfcrParams::with_damping(S::from_f64(0.02)));
    let coupled = AnyParams::Coupled(CoupledParams::new(S::from_f64(0.1)));
    [
        largest_difference(hfcr, &HFCR),
        largest_difference(coupled, &COUPLED),
    ]
}

/// Entry point that the C runtime calls.
#[unsafe(no_mangle)]
pub extern "C" fn main(_count: c_int, _arguments: *const *const u8) -> c_int {
    let double = largest_differences::<f64>();
    let single = largest_differences::<f32>();
    let agree = [
        report(c"hfcr, f64", double[0], 1e-9),
        report(c"hfcr, f32", single[0], 1e-3),
        // The observer's remaining uncertainty about the device after ten free ticks.
        report(c"coupled, f64", double[1], 1e-7),
        report(c"coupled, f32", single[1], 1e-4),
    ];
    c_int::from(agree.contains(&false))
}
