//! `palpate pipe` with a world: the positions of all devices in, a force on each of them out.

use std::io;
use std::path::Path;

use crate::pipe::world::{
    DeviceColumns, Names, WorldFormat, WorldMemory, WorldStream, WorldSummary,
};
use palpate_rt::BoundedWorld;
use palpate_rt::safety::SafetyParams;
use palpate_scene::world::WorldFile;
use palpate_world::Tool;

use super::answering::{MISTAKES, answer, messages};
use super::{PipeArguments, check_slope, limits_in_words, soft_start};
use crate::failure::Failure;
use crate::worlds::{self, wrong_world};

/// Flags of a pipe of a world; all other values are in its file.
const FLAGS: [&str; 17] = [
    "file",
    "scene",
    "time",
    "unit",
    "header",
    "columns",
    "soft_start",
    "force_limit",
    "method",
    "guard",
    "guard_speed",
    "guard_acceleration",
    "guard_hand_force",
    "guard_mass",
    "guard_recovery",
    "guard_allowance",
    "json",
];

/// Answers every line of standard input until it ends or a signal arrives.
pub fn run(arguments: &PipeArguments, path: &Path, file: &WorldFile) -> Result<(), Failure> {
    worlds::only(&arguments.given, &FLAGS, path)?;
    answer(|| set_up(arguments, file), arguments.json)
}

/// Sets up the stream from arguments and file, without any input or output.
fn set_up(arguments: &PipeArguments, file: &WorldFile) -> Result<WorldStream, Failure> {
    let flags = &arguments.flags;
    let file = &worlds::guarded(flags, file);
    let mut scene = file.scene.clone();
    let method = worlds::one_method(flags, &file.scene)?;
    let defaults = SafetyParams::default();
    let is_given = flags.force_limit.or(scene.render.force_limit).is_some();
    let usual = [defaults.largest_force, defaults.largest_torque];
    scene.settle_limits([flags.force_limit, None], usual);
    let (force_limit, torque_limit) = (scene.render.force_limit, scene.render.torque_limit);
    let soft_start = soft_start(arguments, &defaults)?;
    let renderer = scene
        .renderer(method)
        .map_err(|faults| wrong_world(flags, file, &faults))?;
    let limits = SafetyParams::bounding(force_limit, torque_limit, soft_start);
    let hold = renderer.loop_params().actuation.hold;
    let columns = &arguments.stream.columns;
    if !columns.are_of_world() {
        return Err(Failure::Arguments(
            "--columns of a world: allowed is force, or force,slope with loop.hold = \"line\""
                .into(),
        ));
    }
    check_slope(hold, columns)?;
    let world = BoundedWorld::new(renderer, limits)
        .map_err(|error| Failure::Arguments(error.to_string()))?;
    let devices = scene.world.tools.iter().map(|tool| DeviceColumns {
        name: tool.name.clone(),
        turns: tool.turns,
        gives_torque: tool.feels_torque(),
    });
    let format = WorldFormat {
        time: arguments.stream.time,
        unit: arguments.stream.unit.unwrap_or_default(),
        is_unit_given: arguments.stream.unit.is_some(),
        slopes: columns.have_slope(),
        devices: devices.collect(),
    };
    let mut messages = messages()?;
    if let Some(limits) = limits_in_words(
        force_limit.filter(|_| !is_given),
        Some(soft_start).filter(|_| arguments.stream.soft_start.is_none()),
    ) {
        messages.tell(limits);
    }
    Ok(WorldStream {
        names: Names::new(&scene.world),
        world,
        period: scene.timing.period,
        format,
        is_header_asked: arguments.stream.header,
        output: Box::new(io::stdout()),
        messages: Some(messages),
        mistakes: MISTAKES,
        summary: WorldSummary::new(
            force_limit,
            torque_limit.filter(|_| scene.world.tools.iter().any(Tool::feels_torque)),
            soft_start,
        ),
        memory: WorldMemory::default(),
    })
}
