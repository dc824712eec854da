//! `palpate replay` of a world's recording: its motion by another method.

use palpate_record::files::outputs::Outputs;
use palpate_record::recording::Recording;
use palpate_study::device_loop::{RecordedWorld, RecordedWorldError};

use super::ReplayArguments;
use crate::arguments::Results;
use crate::commands::render::deliver_world;
use crate::failure::{Failure, tell};
use crate::recorded::whole_or_said;
use crate::worlds;

/// Flags of a replay in a world.
const FLAGS: [&str; 2] = ["recording", "method"];

/// Renders the recorded motion in the recording's world, which starts in the state of its file.
pub fn run(
    arguments: &ReplayArguments,
    outputs: &Outputs,
    recording: &Recording,
) -> Result<(), Failure> {
    let known = [&FLAGS[..], &Results::NAMES].concat();
    worlds::only(&arguments.given, &known, &arguments.recording)?;
    let name = arguments.recording.display().to_string();
    let mut recorded = RecordedWorld::edited(recording, &arguments.flags.edits.set).map_err(
        |error| match error {
            RecordedWorldError::World(faults) => Failure::inputs(faults),
            other => Failure::input(other),
        },
    )?;
    arguments
        .flags
        .edits
        .retitle(&mut recorded.file.scene.title);
    // Input files include those of meshes.
    outputs.spare_inputs()?;
    if let Some(gaps) = recorded.gaps() {
        tell(format_args!("{name}: {gaps}"));
    }
    let results = (&arguments.results, outputs);
    let world = (&recorded.file, name.as_str());
    deliver_world(&arguments.flags, results, world, recorded.path, |_| ())?;
    whole_or_said(recording)
}
