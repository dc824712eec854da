//! Records the trace for boards and desktop: a constant force drives a light device against a block, rendered by HFCR
//! in `f64`, with injected faults.

use std::error::Error;
use std::fmt::Write;

use palpate::{Contact, HfcrParams, LoopParams, ObjectState, Renderer, Sample};

/// Ticks of the trace.
const TICK_COUNT: usize = 800;
const PERIOD: f64 = 0.001;
/// Mass of the device `[kg]`.
const DEVICE_MASS: f64 = 0.1;
/// Force of the hand on it, and its opposite on the block `[N]`.
const HAND: f64 = 3.0;

/// Returns the samples of the committed trace for a program in C: a line per sample, as bits of a `float`.
pub fn in_c() -> String {
    let mut text = String::new();
    for sample in palpate_firmware_trace::samples() {
        let elapsed = sample.elapsed.unwrap_or_default().to_bits();
        let (position, force) = (sample.device_position, sample.virtual_force);
        let _ = writeln!(
            text,
            "{{0x{:08x}, 0x{elapsed:08x}, 0x{:08x}, {}}},",
            position.to_bits(),
            force.to_bits(),
            u32::from(sample.elapsed.is_some()),
        );
    }
    text
}

/// Returns the text of the trace. Cells are rounded to a nanometre, like a fine encoder.
pub fn recorded() -> Result<String, Box<dyn Error>> {
    let contact = Contact::object(1000.0, 0.1);
    let renderer = Renderer::new(contact, LoopParams::new(PERIOD), HfcrParams::default())?;
    let mut state = renderer.start(ObjectState::at_rest(0.01))?;
    let (mut position, mut velocity) = (0.0, 0.0);
    let mut text = String::from("position_m,elapsed_s,virtual_force_n\n");
    for tick in 0..TICK_COUNT {
        let late = tick % 37 == 17;
        let elapsed = if late { 0.0013 } else { PERIOD };
        // The device moves as if no sample had been modified.
        let sample = Sample::at(position).with_virtual_force(-HAND);
        let output = renderer.step(&mut state, sample.after(elapsed));
        let shown = if late { "0.0013" } else { "" };
        let clean = (
            format!("{position:.9}"),
            shown.to_string(),
            format!("{}", -HAND),
        );
        let (position_m, elapsed_s, virtual_force_n) = match tick {
            150 => ("nan".into(), clean.1, clean.2),
            220 | 221 => ("inf".into(), clean.1, clean.2),
            290 => (clean.0, "0".into(), clean.2),
            291 => (clean.0, "-0.001".into(), clean.2),
            360 => (clean.0, "0.5".into(), clean.2),
            430 => (format!("{:.9}", position + 0.02), clean.1, clean.2),
            500 => (clean.0, clean.1, "nan".into()),
            570 => (clean.0, clean.1, "-3e38".into()),
            _ => clean,
        };
        writeln!(text, "{position_m},{elapsed_s},{virtual_force_n}")?;
        let acceleration = (HAND + output.force_on_device) / DEVICE_MASS;
        position += (velocity + 0.5 * acceleration * PERIOD) * PERIOD;
        velocity += acceleration * PERIOD;
    }
    Ok(text)
}
