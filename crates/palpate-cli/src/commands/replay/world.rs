//! `palpate replay` of a recording of a world: its motion, under another method.

use palpate_files::outputs::Outputs;
use palpate_record::recording::{Flags, Recording};
use palpate_rt::WorldFrame;
use palpate_scene::world::WorldFile;
use palpate_testbed::world::LedPath;

use super::ReplayArguments;
use crate::commands::render::deliver_world;
use crate::failure::{Failure, tell};
use crate::recorded::whole_or_said;
use crate::worlds;

/// Text of the receipt that holds the world.
pub const WORLD: &str = "world";
/// What a replay in a world takes.
const FLAGS: [&str; 5] = ["recording", "method", "out", "overwrite", "json"];

/// Renders the recorded motion in the recording's world, which begins as its file says.
pub fn run(
    arguments: &ReplayArguments,
    outputs: &Outputs,
    recording: &Recording,
    text: &str,
) -> Result<(), Failure> {
    worlds::only(&arguments.given, &FLAGS, &arguments.recording)?;
    let name = arguments.recording.display().to_string();
    // Files of meshes are looked for beside the recording.
    let file = WorldFile::parse(&name, text).map_err(Failure::inputs)?;
    let frame = recording.receipt.texts.get("frame");
    let frame = frame
        .and_then(|frame| WorldFrame::read(frame))
        .ok_or_else(|| {
            Failure::input(format_args!(
                "{name}: its receipt does not say where the device stands in the world"
            ))
        })?;
    let (mut times, mut positions): (Vec<f64>, Vec<_>) = (Vec::new(), Vec::new());
    let mut start = 0.0;
    let mut without = 0_u64;
    let mut last = None;
    for row in recording.rows().map_err(Failure::input)? {
        let tick = row.map_err(Failure::input)?.tick;
        if last.replace(tick.sequence) == Some(tick.sequence) {
            continue;
        }
        // An axis that the device has not is none of the frame's.
        let place = frame.in_world(tick.device_axes.map(|x| if x.is_nan() { 0.0 } else { x }));
        if tick.flags.has(Flags::DEVICE_FAULT) || tick.device_axes[0].is_nan() {
            without += 1;
            continue;
        }
        if times.is_empty() {
            start = tick.time;
        }
        times.push(tick.time - start);
        positions.push(vec![place]);
    }
    if without > 0 {
        let ticks = palpate_study::text::counted(without, "tick");
        tell(format_args!(
            "{name}: {ticks} without a position; straight lines stand there"
        ));
    }
    let path = LedPath::new(times, positions)
        .map_err(|error| Failure::input(format_args!("{name}: {error}")))?;
    let results = (&arguments.results, outputs);
    deliver_world(&arguments.flags, results, (&file, &name), path)?;
    whole_or_said(recording)
}
