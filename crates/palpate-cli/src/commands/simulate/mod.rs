//! `palpate simulate`: a scene in closed loop.

mod world;

use std::path::Path;
use std::string::FromUtf8Error;

use palpate_record::files::bounded::SCENE;
use palpate_record::unit::{LengthUnit, Spacing};
use palpate_scene::method::MethodName;
use palpate_scene::world::WorldScene;
use palpate_scene::{
    ContactFile, Intention, Measure, Scene, SceneError, SceneFile, SceneParameter, SetupError,
    Source, lag_question, period_question,
};
use palpate_study::sim::closed_loop::{Bench, LoopError};
use palpate_study::studied::Studied;
use palpate_testbed::reference::ReferenceError;

use crate::arguments::{EditFlags, Flags, SimulateArguments, TimingFlags};
use crate::failure::{Failure, tell};
use crate::inside;
use crate::progress::Progress;
use crate::results::deliver;
use crate::setup::{wrong_flag, wrong_setup};
use palpate_plot::{Devices, RunsFigure};
use palpate_study::report::{Report, Subject, actuator_of, metadata, plant_metadata};

/// Simulates a scene by the named methods, or by its own.
pub fn run(arguments: &SimulateArguments) -> Result<(), Failure> {
    let file = match read_any(&arguments.scene, &arguments.flags.edits)? {
        SceneFile::Contact(file) => *file,
        SceneFile::World(file) => return world::run(arguments, &arguments.scene, &file),
    };
    let flags = &arguments.flags;
    let methods = flags.methods(file.scene.method);
    flags.check_settings(&methods)?;
    let mut scene = file.scene.clone();
    flags.change(&mut scene, &methods)?;
    arguments.timing.change(&mut scene)?;
    if let Some(place) = arguments.hand_force_at {
        let Some(device) = scene.device.pantograph_mut() else {
            return Err(Failure::Arguments(format!(
                "--hand-force-at {}: the scene's device is a point mass, and only a pantograph has \
                 motors at joints",
                place.name()
            )));
        };
        device.force_at = place;
    }
    let mut further = scenes_of_seeds(arguments, &scene)?;
    let scene = further.remove(0);
    let outputs = arguments.results.check(&arguments.scene)?;
    let failure = |method, error| explain((flags, &arguments.timing), &file, method, error);
    let progress = Progress::new(methods.len() * (1 + further.len()));
    let run_all = |scene| {
        progress.begin("ideal");
        let bench = Bench::new(scene).map_err(|error| failure(scene.method, error))?;
        let mut runs = Vec::with_capacity(methods.len());
        for &method in &methods {
            progress.begin(method.name());
            runs.push(bench.run(method).map_err(|error| failure(method, error))?);
            progress.advance();
        }
        Ok::<_, Failure>((bench, runs))
    };
    let (bench, runs) = run_all(&scene)?;
    let mut of_further = Vec::with_capacity(further.len());
    for scene in &further {
        let (bench, runs) = run_all(scene)?;
        of_further.push(Report::new(&Subject::new(scene), bench.reference(), &runs));
    }
    let subject = Subject::new(&scene);
    let mut metadata = metadata(&subject, scene.object, scene.virtual_force, &runs);
    metadata.extend(plant_metadata(&scene));
    let actuator = actuator_of(&scene);
    let lines = actuator.iter();
    metadata.extend(lines.map(|(key, value)| (format!("actuator_{key}"), value.to_string())));
    metadata.push(("scene".into(), arguments.scene.display().to_string()));
    let mut report = Report::new(&subject, bench.reference(), &runs);
    report.actuated(actuator);
    if !of_further.is_empty() {
        report.spread_over(&of_further, arguments.several.start_range);
    }
    deliver(
        (&arguments.results, &outputs),
        report,
        &metadata,
        &runs,
        || {
            let figure = RunsFigure {
                of: scene.title.clone(),
                reference: bench.reference(),
                runs: &runs,
                devices: Devices::OfEachRun,
                recorded: None,
            };
            figure.sheet()
        },
        progress,
    )
}

/// Returns the scene with each seed that `--seeds` requests: the scene itself without the flag.
fn scenes_of_seeds(arguments: &SimulateArguments, scene: &Scene) -> Result<Vec<Scene>, Failure> {
    let several = &arguments.several;
    if !several.are_several() {
        return Ok(vec![scene.clone()]);
    }
    let seeds = several.of_scene(scene)?;
    let results = &arguments.results;
    for (flag, is_given) in [
        ("--out", results.out.is_some()),
        ("--plot", results.picture.plot.is_some()),
    ] {
        if is_given {
            return Err(several.refused(&format!(
                "{flag} writes the ticks of one seed; omit --seeds and choose one with --seed"
            )));
        }
    }
    Ok(seeds
        .map(|seed| scene.with_seed(seed, several.start_range))
        .collect())
}

pub(super) fn read_any(path: &Path, edits: &EditFlags) -> Result<SceneFile, Failure> {
    let name = path.display().to_string();
    let source = Source::new(&name, &read_text(path)?).edited(&edits.set);
    let mut file = SceneFile::parse_edited(&source).map_err(Failure::inputs)?;
    match &mut file {
        SceneFile::Contact(file) => {
            tell_doubts(&name, &file.scene);
            edits.retitle(&mut file.scene.title);
        }
        SceneFile::World(file) => {
            tell_doubts_of_world(&name, &file.scene);
            edits.retitle(&mut file.scene.title);
            for note in file.notes() {
                tell(note);
            }
        }
    }
    Ok(file)
}

pub(super) fn read_scene(path: &Path, edits: &EditFlags) -> Result<ContactFile, Failure> {
    match read_any(path, edits)? {
        SceneFile::Contact(file) => Ok(*file),
        SceneFile::World(file) => Err(Failure::inputs(file.not_one_contact())),
    }
}

pub(super) fn read_text(path: &Path) -> Result<String, Failure> {
    let name = path.display().to_string();
    let ending = path.extension().and_then(|ending| ending.to_str());
    let ending = ending.map(str::to_ascii_lowercase).unwrap_or_default();
    let other = match ending.as_str() {
        "csv" => Some("a table, for `palpate render`"),
        "mcap" => Some("a recording, for `palpate replay`, `info` or `convert`"),
        _ => None,
    };
    if let Some(other) = other {
        return Err(Failure::Arguments(format!(
            "{name}: a scene is a TOML file; .{ending} is {other}"
        )));
    }
    let bytes = SCENE
        .bytes(path)
        .map_err(|error| Failure::System(format!("{name}: {error}")))?;
    String::from_utf8(bytes).map_err(|error| not_utf8(&name, &error))
}

/// Smallest number of points of a recorded intention: a path of fewer points is handwritten, and they may be far apart.
const MIN_RECORDED: usize = 20;

/// Warns of a period that is unusual for a haptic loop, and of a motion that is unusual for a hand.
fn tell_doubts(name: &str, scene: &Scene) {
    let period = scene.loop_params.period;
    if let Some(question) = period_question("loop.period_s", "period_s = 0.001", period) {
        tell(format_args!("warning: {name}: {question}"));
    }
    if let Some(question) = lag_question("loop.lag_s", "lag_s = 0.001", scene.actuator.lag) {
        tell(format_args!("warning: {name}: {question}"));
    }
    if let Some(Intention::Recorded(path)) = scene.device.grip().map(|grip| &grip.intention) {
        let at = format!("{name}: device.hand.rest_file");
        let column = |unit: LengthUnit| format!("column {}", unit.position_column());
        tell_doubts_of_rest(&at, path.times(), &[path.positions()], column);
    }
}

/// Warns of motions that are unusual for the hands of a world.
fn tell_doubts_of_world(name: &str, scene: &WorldScene) {
    for (tool, device) in scene.world.tools.iter().zip(&scene.devices) {
        let Some(path) = &device.hand.path else {
            continue;
        };
        let at = format!("{name}: device.hand.rest_file of {}", tool.name);
        let along = |axis: usize| {
            path.positions()
                .iter()
                .map(|point| point[0][axis])
                .collect()
        };
        let along: [Vec<f64>; 3] = [0, 1, 2].map(along);
        let has_one_axis = tool.axes.iter().filter(|has| **has).count() == 1;
        let columns = |unit: LengthUnit| {
            if has_one_axis {
                format!("column {}", unit.position_column())
            } else {
                format!("columns x_{unit}, y_{unit} and z_{unit}")
            }
        };
        tell_doubts_of_rest(
            &at,
            path.times(),
            &along.each_ref().map(Vec::as_slice),
            columns,
        );
    }
}

/// Warns of a hand's rest along some axes, each with its `positions` `[m]` at `times` `[s]`, whose unit is probably
/// wrong. `columns` says how to name the columns of a unit.
fn tell_doubts_of_rest(
    at: &str,
    times: &[f64],
    positions: &[&[f64]],
    columns: impl Fn(LengthUnit) -> String,
) {
    if times.len() >= MIN_RECORDED
        && let Some(spacing) = Spacing::implausible(times)
    {
        let column = spacing.likely_unit().map_or_else(String::new, |unit| {
            format!(" If so, name its column t_{unit}")
        });
        tell(format_args!("warning: {at}: {spacing}{column}"));
    }
    if let Some(excess) = positions
        .iter()
        .find_map(|along| inside::excess(times, along))
    {
        let columns = columns(excess.likely_unit());
        tell(format_args!(
            "warning: {at}: {excess} If so, name its {columns}"
        ));
    }
}

fn not_utf8(name: &str, error: &FromUtf8Error) -> Failure {
    let at = error.utf8_error().valid_up_to();
    let byte = error.as_bytes()[at];
    let before = String::from_utf8_lossy(&error.as_bytes()[..at]);
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
    let message = format!(
        "{name}:{line}:{column}: the byte 0x{byte:02X} is not UTF-8; save the scene as UTF-8 text"
    );
    let text = format!("{before}\u{fffd}");
    Failure::input_at(message, name, &text, at..text.len())
}

pub(super) fn in_file(error: SceneError) -> Failure {
    Failure::inputs([error])
}

/// Explains a scene that cannot run: the error is in a flag if one gave the value, else in the file.
pub(super) fn explain(
    (flags, timing): (&Flags, &TimingFlags),
    file: &ContactFile,
    method: MethodName,
    error: LoopError,
) -> Failure {
    match error {
        LoopError::Setup(SetupError::Parameter(parameter))
            if flags.gives(parameter.parameter) || timing.gives(parameter.parameter) =>
        {
            wrong_flag(&parameter)
        }
        LoopError::Setup(setup @ SetupError::Settings(_)) if flags.explain_settings() => {
            wrong_setup(&setup)
        }
        LoopError::Setup(setup) => in_file(file.locate(method, &setup)),
        LoopError::TooLong(_) if flags.period.is_some() => {
            Failure::Arguments(format!("--period is too short: {error}"))
        }
        // The file alone is valid, or reading it would have failed. These errors may come from the flags, so no line of
        // the file is shown.
        LoopError::TooFewCollisions { .. }
        | LoopError::TooLong(_)
        | LoopError::Ideal(_)
        | LoopError::Bench(_)
            if flags.change_a_scene() =>
        {
            Failure::Arguments(format!("with these flags, {error}"))
        }
        LoopError::TooFewCollisions { .. }
        | LoopError::Ideal(
            ReferenceError::TooFewCollisions { .. } | ReferenceError::NoCollisions,
        ) => in_window(file, SceneParameter::Collisions, &error),
        LoopError::TooLong(_) => match file.scene.measure {
            Measure::Collisions(_) => in_window(file, SceneParameter::Collisions, &error),
            Measure::Duration(_) => in_window(file, SceneParameter::Duration, &error),
        },
        LoopError::Ideal(ReferenceError::Scene(_))
        | LoopError::Bench(_)
        | LoopError::AnotherScene => in_file(file.as_a_whole(error.to_string())),
    }
}

/// Returns an error of the window, at the `parameter` of the file that sets its length.
fn in_window(file: &ContactFile, parameter: SceneParameter, error: &LoopError) -> Failure {
    in_file(file.at(parameter, error.to_string()))
}
