#![no_std]
#![no_main]
#![forbid(unsafe_code)]
//! The smallest program with one method or none: the linked code of a method is its code size.

use core::hint::black_box;
use core::panic::PanicInfo;

use cortex_m_rt::entry;
use palpate::Sample;

/// A loop that renders a wall by one method, for successive positions.
#[cfg(any(feature = "hfcr", feature = "coupled"))]
fn render<P: palpate::MethodParams<f32>>(params: P) {
    use palpate::{ObjectState, Renderer};

    let contact = palpate_firmware_trace::wall();
    let loop_params = palpate_firmware_trace::loop_params();
    let Ok(renderer) = Renderer::new(black_box(contact), black_box(loop_params), params) else {
        return;
    };
    let Ok(mut state) = renderer.start(ObjectState::at_rest(black_box(0.0))) else {
        return;
    };
    loop {
        let sample = black_box(Sample::at(0.0_f32));
        black_box(renderer.step(&mut state, sample).force_on_device);
    }
}

#[entry]
fn main() -> ! {
    #[cfg(feature = "hfcr")]
    render(black_box(palpate_firmware_trace::hfcr()));
    #[cfg(feature = "coupled")]
    render(black_box(palpate_firmware_trace::coupled()));
    loop {
        black_box(Sample::at(0.0_f32));
    }
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    loop {
        cortex_m::asm::bkpt();
    }
}
