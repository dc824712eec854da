//! `palpate replay` of a recording of a world: its motion, under another method.

use palpate_files::outputs::Outputs;
use palpate_record::recording::Recording;
use palpate_rt::WorldFrame;
use palpate_scene::world::WorldFile;
use palpate_study::recording::world_path;

use super::ReplayArguments;
use crate::commands::render::deliver_world;
use crate::devices::names;
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
    let mut file = WorldFile::parse(&name, text).map_err(Failure::inputs)?;
    outputs.spare_inputs()?;
    let several = file.scene.devices.len() > 1;
    let frames = names(&file.scene).into_iter().map(|device| {
        let (text, of) = if several {
            (format!("frame {device}"), format!("the device {device}"))
        } else {
            ("frame".to_owned(), "the device".to_owned())
        };
        let frame = recording.receipt.texts.get(&text);
        let frame = frame.and_then(|frame| WorldFrame::read(frame));
        frame.ok_or_else(|| {
            Failure::input(format_args!(
                "{name}: its receipt does not say where {of} stands in the world"
            ))
        })
    });
    let frames = frames.collect::<Result<Vec<_>, _>>()?;
    // The motors of the recorded device could not push along an axis that it lacks, so nothing is judged there.
    for (number, frame) in frames.iter().enumerate() {
        let axes = [0, 1, 2].map(|axis| frame.has(axis));
        file.scene = file.scene.with_axes(number, axes);
    }
    let devices = file.scene.devices.iter();
    let turns: Vec<bool> = devices.map(|device| device.turning.is_some()).collect();
    let in_world = |device: usize, place| frames[device].in_world(place);
    let (path, without) = world_path(recording, &turns, in_world).map_err(Failure::input)?;
    if without > 0 {
        let ticks = palpate_study::text::counted(without, "tick");
        tell(format_args!(
            "{name}: {ticks} without a position; straight lines stand there"
        ));
    }
    let results = (&arguments.results, outputs);
    deliver_world(&arguments.flags, results, (&file, &name), path)?;
    whole_or_said(recording)
}
