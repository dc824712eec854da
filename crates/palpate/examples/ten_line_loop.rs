//! Minimal loop: a light block at 1 kHz, with a simulated device.
//!
//! `cargo run -p palpate --example ten_line_loop`

#![allow(clippy::print_stdout)] // an example prints what it found

use palpate::{Contact, HfcrParams, LoopParams, ObjectState, Renderer, Sample};

fn main() -> Result<(), palpate::ParameterError> {
    let contact = Contact::object(400.0, 0.1); // stiffness [N/m], mass [kg]
    let loop_params = LoopParams::new(0.001).with_force_limit(20.0); // period [s], largest force [N]
    let renderer = Renderer::new(contact, loop_params, HfcrParams::default())?;
    let mut state = renderer.start(ObjectState::at_rest(0.02))?; // [m]
    for tick in 0..2000 {
        let sample = Sample::at(read_device(tick)).with_virtual_force(-0.981); // weight [N]
        let output = renderer.step(&mut state, sample);
        command_device(tick, output.force_on_device);
    }
    println!(
        "energy created by sampling: {:.3} mJ; a plain spring would have created {:.3} mJ",
        1e3 * state.ledger().held_leak.accumulated,
        1e3 * state.ledger().original_leak.accumulated,
    );
    Ok(())
}

/// Replaces the position of your device `[m]`: a slow 10 mm oscillation.
fn read_device(tick: u32) -> f64 {
    0.01 * (f64::from(tick) * 0.001 * std::f64::consts::TAU).sin()
}

/// Replaces your motor: prints ten times a second.
fn command_device(tick: u32, force: f64) {
    if tick.is_multiple_of(100) {
        println!("t = {:.1} s  {force:+.3} N", f64::from(tick) * 0.001);
    }
}
