//! Detection of likely mistakes about the device's position: inside the object at the start, or in another unit.

use palpate_core::Side;
use palpate_record::unit::{Excess, HandMotion, LengthUnit, Spacing};
use palpate_study::sim::replay::ReplaySetup;

use crate::arguments::TraceFlags;
use crate::failure::Failure;
use palpate_study::text::digits;

/// Depth beyond which the unit of the positions is probably wrong `[m]`.
const DEEP: f64 = 1.0;
/// Penetration above which the unit of a recorded motion is probably wrong `[m]`.
const DEEP_FOR_A_MOTION: f64 = 0.1;
/// Distance from a device's position in a scene beyond which the unit is probably wrong `[m]`.
const FAR: f64 = 2.0;

/// Returns a message with the remedy for a device that starts at `position` `[m]` inside the object, or `None`. The
/// unit may be the mistake, unless it was given.
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
        format!(", or set its unit (--unit {unit})")
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

/// Returns a message for a penetration deeper than the thickness of a desktop body. Returns `None` if there is none, or
/// if the unit was given.
pub fn deep(depth: f64, is_unit_given: bool) -> Option<String> {
    (depth > DEEP_FOR_A_MOTION && !is_unit_given).then(|| {
        let unit = LengthUnit::Millimetre;
        format!(
            "the recorded motion penetrates an object by {} m; if the positions are in {unit}, pass --unit {unit}; if \
             they are in metres, pass --unit m",
            digits(depth)
        )
    })
}

/// Rejects a motion along some axes, each with its `positions` `[m]` at `times` `[s]`, whose unit is probably wrong,
/// unless it was given.
pub fn check_motion(
    name: &str,
    times: &[f64],
    positions: &[&[f64]],
    flags: &TraceFlags,
) -> Result<(), Failure> {
    if flags.time_unit.is_none()
        && let Some(spacing) = Spacing::implausible(times)
    {
        let take = spacing.likely_unit().map_or_else(String::new, |unit| {
            format!("If so, pass --time-unit {unit}; ")
        });
        return Err(Failure::input(format!(
            "{name}: {spacing}{} {take}if the times are in seconds, pass --time-unit s",
            if take.is_empty() { ";" } else { "" }
        )));
    }
    if flags.unit.is_some() {
        return Ok(());
    }
    match positions.iter().find_map(|along| excess(times, along)) {
        Some(excess) => Err(Failure::input(format!("{name}: {}", not_a_hand(&excess)))),
        None => Ok(()),
    }
}

/// Rejects a motion of the device called `device` that begins far from its position in the scene, unless its unit was
/// given.
pub fn check_start(
    name: &str,
    device: &str,
    (of_scene, of_motion): ([f64; 3], [f64; 3]),
    flags: &TraceFlags,
) -> Result<(), Failure> {
    let apart = of_scene.iter().zip(of_motion).map(|(a, b)| (a - b).abs());
    let apart = apart.fold(0.0, f64::max);
    if flags.unit.is_some() || apart <= FAR {
        return Ok(());
    }
    let unit = LengthUnit::Millimetre;
    Err(Failure::input(format!(
        "{name}: the motion of {device} begins {} m from its position in the scene; if the positions are in {unit}, \
         pass --unit {unit}; if they are in metres, pass --unit m",
        digits(apart)
    )))
}

/// Returns an implausible part of a motion of `positions` `[m]` at `times` `[s]`.
pub fn excess(times: &[f64], positions: &[f64]) -> Option<Excess> {
    let mut motion = HandMotion::default();
    for (time, position) in times.iter().zip(positions) {
        motion.add(*time, *position);
    }
    motion.excess()
}

/// Returns the message for an implausible motion, with the remedy.
pub fn not_a_hand(excess: &Excess) -> String {
    format!(
        "{excess} If so, pass --unit {}; if the positions are in metres, pass --unit m",
        excess.likely_unit()
    )
}
