//! `palpate replay`: a recording under another method: its motion as it was, or its hand under the new
//! force.

mod world;

use std::path::PathBuf;

use clap::{Args, ValueHint};
use palpate::Parameter;
use palpate_record::recording::Recording;
use palpate_scene::method::MethodName;
use palpate_scene::{Scene, SceneFile, SetupError, Timing};
use palpate_sim::closed_loop::LoopError;
use palpate_sim::hand_replay::Recording as OfAHand;
use palpate_sim::replay::{Replay, ReplayError, ReplaySetup};

use super::hand_replay::{Recorded, ReplayRuns, close_loop};
use super::simulate::in_file;
use crate::arguments::{Flags, Given, PartFlags, ReplayFlags, ReplayKind, Results};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::recorded::trace::how_to_cut;
use crate::recorded::{open, whole_or_said};
use crate::results::deliver;
use crate::setup::{wrong_flag, wrong_on_bench, wrong_setup};
use palpate_plot::RunsFigure;
use palpate_study::recording::{NoScene, Ticks, scene_of};
use palpate_study::report::{FromRecording, Replayed, Report, Subject, receipt, told_lines};

/// Arguments of `replay`.
#[derive(Args, Debug)]
pub struct ReplayArguments {
    /// What stands on the command line; first, since the fields are read in their order and taken out.
    #[command(flatten)]
    pub given: Given,
    /// Recording (MCAP)
    #[arg(value_name = "REC.mcap", value_hint = ValueHint::FilePath)]
    pub recording: PathBuf,
    /// Contact, loop, method and device, where they are not to be those of the recording's scene.
    #[command(flatten)]
    pub flags: Flags,
    /// Motion or hand.
    #[command(flatten)]
    pub replay: ReplayFlags,
    /// Which part of the recording.
    #[command(flatten, next_help_heading = "Recording")]
    pub part: PartFlags,
    /// Where results go.
    #[command(flatten)]
    pub results: Results,
}

/// Replays the motion or the hand by the methods that were named, or by the scene's own.
pub fn run(arguments: &ReplayArguments) -> Result<(), Failure> {
    let flags = &arguments.flags;
    arguments.replay.check()?;
    let outputs = arguments.results.check(&arguments.recording)?;
    let part = arguments.part.part(f64::INFINITY)?;
    let name = arguments.recording.display().to_string();
    let recording = open(&arguments.recording)?;
    if let Some(text) = recording.receipt.texts.get(world::WORLD) {
        return world::run(arguments, &outputs, &recording, text);
    }
    let file = scene(&recording)?;
    let methods = flags.methods(file.scene.method);
    flags.check_settings(&methods)?;
    let mut scene = file.scene.clone();
    flags.change(&mut scene, &methods)?;
    let progress = Progress::new(methods.len());
    progress.begin(&format!("reading {name}"));
    let mut ticks = Ticks::of(&recording, &part).map_err(Failure::input)?;
    let mut setup = ReplaySetup::of_scene(&scene);
    // A flag of its position or velocity puts it elsewhere.
    if !flags.gives(Parameter::ObjectPosition.into())
        && !flags.gives(Parameter::ObjectVelocity.into())
    {
        ticks.place_object(&mut setup, arguments.replay.replay == ReplayKind::Hand);
    }
    let failure = |method, error: ReplayError| match error {
        ReplayError::Setup(SetupError::Parameter(parameter))
            if flags.gives(parameter.parameter) =>
        {
            wrong_flag(&parameter)
        }
        ReplayError::Setup(setup) if flags.explain_settings() => wrong_setup(&setup),
        ReplayError::Setup(setup) => in_file(file.locate(method, &setup)),
        ReplayError::Bench(error) => wrong_on_bench(&error),
        ReplayError::TooLong(periods) => Failure::input(format_args!(
            "{name}: the recording has {periods} periods; {}",
            how_to_cut()
        )),
        other => Failure::input(format_args!("{name}: {other}")),
    };
    let ReplayRuns {
        reference,
        mut runs,
        replayed,
    } = match arguments.replay.replay {
        ReplayKind::Motion => motion(&ticks, setup, (&scene, &methods), &progress, &failure)?,
        ReplayKind::Hand => {
            let delay = file.scene.delay;
            let longest_gap = setup.loop_params.bridged_gap();
            let period = file.scene.loop_params.period;
            let held = ticks.held_device(&name, delay, period, longest_gap);
            let held = held.map_err(Failure::input)?;
            if let Some(start) = held.times.first() {
                ticks.curves.count_from(*start);
            }
            let recorded = Recorded {
                name: &name,
                recording: OfAHand {
                    times: &held.times,
                    positions: &held.positions,
                    forces_on_device: Some(&held.forces),
                },
                device_mass: scene.device.mass(),
                at_its_instants: true,
            };
            let failure = |method, error| match error {
                LoopError::Setup(setup) => failure(method, ReplayError::Setup(setup)),
                LoopError::Bench(error) => wrong_on_bench(&error),
                other => Failure::input(format_args!("{name}: {other}")),
            };
            close_loop(
                &recorded,
                (&setup, &arguments.replay),
                (&methods, &scene.settings),
                &progress,
                &failure,
            )?
        }
    };
    // A recording has the object's place; its scene says where the centre is.
    let centre = scene.centre_offset();
    runs.iter_mut().for_each(|run| run.centre_offset = centre);
    let object = ticks.curves.object_position.iter_mut();
    object.for_each(|position| *position += centre);
    let title = format!("{}: {name}", replayed.title());
    let subject = Subject {
        title: title.clone(),
        contact: &setup.contact,
        loop_params: &setup.loop_params,
        device_mass: setup.device_mass,
        delay: setup.delay().0,
        timing: Timing {
            delay_fraction: setup.delay().1,
            ..Timing::default()
        },
    };
    let mut report = Report::new(&subject, &reference, &runs);
    report.recorded(FromRecording {
        file: name.clone(),
        recorded_method: file.scene.method.name(),
        complete: recording.is_complete(),
        ticks: recording.ticks,
        ticks_lost: recording.lost(),
        ticks_without_position: ticks.without_position,
        parameter_changes: recording.generation,
        recorded_peak_force_n: ticks.peak_force,
        recorded_leak_held_j: ticks.curves.held_leak.last().copied().unwrap_or(0.0),
    });
    let mut receipt = receipt(&subject, setup.object, setup.virtual_force, &runs);
    receipt.extend(replayed.receipt());
    let told = told_lines(&setup.actuation, setup.delay().0, setup.loop_params.period);
    let told: Vec<_> = told.collect();
    let lines = told.iter();
    receipt.extend(lines.map(|(key, value)| (format!("actuator_{key}"), value.to_string())));
    report.actuated(told);
    receipt.push(("recording".into(), name.clone()));
    let taken = arguments.part.receipt();
    receipt.extend(taken.map(|(key, value)| (format!("recording_{key}"), value)));
    receipt.push(("ticks_lost".into(), recording.lost().to_string()));
    report.replayed(replayed.clone());
    deliver(
        (&arguments.results, &outputs),
        report,
        &receipt,
        &runs,
        || {
            let recorded = Some(&ticks.curves);
            RunsFigure::of_replay(&replayed, &title, (&reference, &runs), recorded).sheet()
        },
        progress,
    )?;
    whole_or_said(&recording)
}

/// The motion as it was, rendered by each of `methods` at the instants at which it was sampled.
fn motion(
    ticks: &Ticks,
    setup: ReplaySetup,
    (scene, methods): (&Scene, &[MethodName]),
    progress: &Progress,
    failure: &dyn Fn(MethodName, ReplayError) -> Failure,
) -> Result<ReplayRuns, Failure> {
    progress.begin("ideal");
    let motion = &ticks.curves;
    let replay = Replay::at_recorded_instants(setup, &motion.time, &motion.device_position)
        .map_err(|error| failure(scene.method, error))?;
    let mut runs = Vec::with_capacity(methods.len());
    for &method in methods {
        progress.begin(method.name());
        let settings = scene.settings.get(&method).copied().unwrap_or_default();
        let run = replay.run(method, &settings);
        runs.push(run.map_err(|error| failure(method, error))?);
        progress.advance();
    }
    Ok(ReplayRuns {
        reference: replay.reference().clone(),
        runs,
        replayed: Replayed::Motion,
    })
}

/// The scene that the recording was made with.
fn scene(recording: &Recording) -> Result<SceneFile, Failure> {
    scene_of(recording).map_err(|error| match error {
        NoScene::Invalid(faults) => Failure::inputs(faults),
        other => Failure::input(other),
    })
}
