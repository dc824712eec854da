//! The knob of the example: a rim of 50 g with a 16-bit sensor, on a motor with 20 N at the rim.

use palpate::CoupledParams;
use palpate_firmware_knob::{Drive, KnobParams, WhenSilent};

use crate::handle::{FULL_DUTY, FULL_FORCE, MASS, METRES_PER_COUNT};

/// Its loop runs at 4 kHz.
pub const PARAMS: KnobParams = KnobParams {
    period: 0.000_25,
    metres_per_count: METRES_PER_COUNT,
    wall_at: 0.0,
    stiffness: 5000.0,
    speed_limit: 2.0,
    soft_start: 0.05,
    drive: Drive {
        full_force: FULL_FORCE,
        full_duty: FULL_DUTY,
    },
    when_silent: WhenSilent::GoOn,
};

/// Returns coupled rendering with the mass of the rim and the quantum of the sensor as model values.
pub fn coupled() -> CoupledParams<f32> {
    CoupledParams::new(MASS).with_encoder_quantum(METRES_PER_COUNT)
}
