//! What is likely to be a mistake about where the device is: inside the object at the start, or in
//! another unit.

use palpate::Side;
use palpate_record::trace::Trace;
use palpate_record::unit::{Excess, HandMotion, LengthUnit};
use palpate_sim::replay::ReplaySetup;

use crate::failure::Failure;
use palpate_study::text::digits;

/// Depth beyond which the unit of the positions is likely to be another one `[m]`.
const DEEP: f64 = 1.0;

/// Says that a device which starts at `position` `[m]` is inside the object, and what to change; none
/// if it is not. The unit may be the mistake, unless it was given.
pub fn at_start(setup: &ReplaySetup, position: f64, is_unit_given: bool) -> Option<String> {
    let surface = setup.object.position;
    let depth = setup.contact.side.sign::<f64>() * (position - surface);
    if depth <= 0.0 || depth.is_nan() {
        return None;
    }
    let beyond = match setup.contact.side {
        Side::Positive => "or more",
        Side::Negative => "or less",
    };
    let unit = if depth > DEEP && !is_unit_given {
        let unit = LengthUnit::Millimetre;
        format!(", or say its unit (--unit {unit})")
    } else {
        String::new()
    };
    Some(format!(
        "the device starts {} m inside the object, whose surface is at {surface} m: to begin without \
         contact, put the object at {position} m {beyond} (--object-position), or start with the \
         device outside{unit}",
        digits(depth)
    ))
}

/// Refuses a trace that no hand has made, where nobody has said its unit.
pub fn check_trace(name: &str, trace: &Trace, unit: Option<LengthUnit>) -> Result<(), Failure> {
    if unit.is_some() {
        return Ok(());
    }
    match excess(&trace.t_s, &trace.position_m) {
        Some(excess) => Err(Failure::input(format!("{name}: {}", not_a_hand(&excess)))),
        None => Ok(()),
    }
}

/// What no hand does in a motion of `positions` `[m]` at `times` `[s]`.
pub fn excess(times: &[f64], positions: &[f64]) -> Option<Excess> {
    let mut motion = HandMotion::default();
    for (time, position) in times.iter().zip(positions) {
        motion.add(*time, *position);
    }
    motion.excess()
}

/// What is said of a motion that no hand makes, with what to do.
pub fn not_a_hand(excess: &Excess) -> String {
    format!(
        "{excess} --unit {} takes it so, and --unit m says that metres are right",
        excess.likely_unit()
    )
}
