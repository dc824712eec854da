//! `palpate replay`: renders a recording by another method, with its motion unchanged or its hand under the new force.

mod world;

use std::path::PathBuf;

use clap::{Args, ValueHint};
use palpate_core::Parameter;
use palpate_record::recording::Recording;
use palpate_scene::method::MethodName;
use palpate_scene::{ContactFile, Edit, SetupError};
use palpate_study::device_loop::RecordedWorld;
use palpate_study::sim::closed_loop::LoopError;
use palpate_study::sim::replay::ReplayError;
use palpate_testbed::reference::ReferenceError;

use super::hand_replay::{tell_step, warn_beyond_reach, wrong_hand};
use super::simulate::in_file;
use crate::arguments::{Flags, Given, PartFlags, ReplayFlags, ReplayKind, Results};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::recorded::trace::how_to_cut;
use crate::recorded::{open, whole_or_said};
use crate::results::deliver;
use crate::setup::{wrong_flag, wrong_on_bench, wrong_setup};
use palpate_plot::RunsFigure;
use palpate_study::recording::{
    NoScene, RecordingReplay, RecordingReplayError, ReplayOf, ReplayedRecording, scene_edited,
};

/// Arguments of `replay`.
#[derive(Args, Debug)]
pub struct ReplayArguments {
    /// Flags on the command line. First field, because clap removes values in the order of the fields.
    #[command(flatten)]
    pub given: Given,
    /// Recording (MCAP)
    #[arg(value_name = "REC.mcap", value_hint = ValueHint::FilePath)]
    pub recording: PathBuf,
    /// Contact, loop, method and device; each overrides the recording's scene.
    #[command(flatten)]
    pub flags: Flags,
    /// Motion or hand.
    #[command(flatten)]
    pub replay: ReplayFlags,
    /// Selected part of the recording.
    #[command(flatten, next_help_heading = "Recording")]
    pub part: PartFlags,
    /// Output of the results.
    #[command(flatten)]
    pub results: Results,
}

/// Replays the motion or the hand by the named methods, or by the scene's own.
pub fn run(arguments: &ReplayArguments) -> Result<(), Failure> {
    let flags = &arguments.flags;
    arguments.replay.check()?;
    let outputs = arguments.results.check(&arguments.recording)?;
    let part = arguments.part.part(f64::INFINITY)?;
    let name = arguments.recording.display().to_string();
    let recording = open(&arguments.recording)?;
    if recording.metadata.texts.contains_key(RecordedWorld::TEXT) {
        return world::run(arguments, &outputs, &recording);
    }
    let recorded = scene(&recording, &[])?.scene;
    let file = scene(&recording, &flags.edits.set)?;
    let methods = flags.methods(file.scene.method);
    flags.check_settings(&methods)?;
    let mut scene = file.scene.clone();
    flags.edits.retitle(&mut scene.title);
    flags.change(&mut scene, &methods)?;
    // Input files include a device file from the flags.
    outputs.spare_inputs()?;
    let progress = Progress::new(methods.len());
    progress.begin(&format!("reading {name}"));
    let failures = ReplayFailures {
        flags,
        file: &file,
        name: &name,
    };
    let replay = RecordingReplay {
        recording: &recording,
        recorded: &recorded,
        scene: &scene,
        // A flag of its position or velocity overrides the scene.
        object_as_in_scene: flags.gives(Parameter::ObjectPosition.into())
            || flags.gives(Parameter::ObjectVelocity.into())
            || scene.object != recorded.object,
        part,
        of: match arguments.replay.replay {
            ReplayKind::Motion => ReplayOf::Motion,
            ReplayKind::Hand => ReplayOf::Hand(arguments.replay.stated_hand()),
        },
    };
    let ReplayedRecording {
        report,
        metadata,
        title,
        reference,
        runs,
        replayed,
        curves,
        beyond_reach,
    } = replay
        .by(&methods, tell_step(&progress))
        .map_err(|error| match error {
            RecordingReplayError::Ticks(error) => Failure::input(error),
            RecordingReplayError::Motion(method, error) => failures.of_motion(method, error),
            RecordingReplayError::Hand(error) => wrong_hand(&name, error, &|method, error| {
                failures.of_hand(method, error)
            }),
        })?;
    warn_beyond_reach(&beyond_reach);
    deliver(
        (&arguments.results, &outputs),
        report,
        &metadata,
        &runs,
        || RunsFigure::of_replay(&replayed, &title, (&reference, &runs), Some(&curves)).sheet(),
        progress,
    )?;
    whole_or_said(&recording)
}

/// Conversion of the errors of a replay.
struct ReplayFailures<'a> {
    /// Contact, loop, method and device from the command line.
    flags: &'a Flags,
    /// Scene of the recording.
    file: &'a ContactFile,
    /// Name of the recording in messages.
    name: &'a str,
}

impl ReplayFailures<'_> {
    /// Converts an error of a replay of the motion.
    fn of_motion(&self, method: MethodName, error: ReplayError) -> Failure {
        let Self { flags, file, name } = self;
        match error {
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
        }
    }

    /// Converts an error of a closed loop around the hand.
    fn of_hand(&self, method: MethodName, error: LoopError) -> Failure {
        match error {
            LoopError::Setup(setup) => self.of_motion(method, ReplayError::Setup(setup)),
            LoopError::Bench(error) | LoopError::Ideal(ReferenceError::Scene(error)) => {
                wrong_on_bench(&error)
            }
            other => Failure::input(format_args!("{}: {other}", self.name)),
        }
    }
}

/// Returns the scene of the recording with these edits.
fn scene(recording: &Recording, edits: &[Edit]) -> Result<ContactFile, Failure> {
    scene_edited(recording, edits).map_err(|error| match error {
        NoScene::Invalid(faults) => Failure::inputs(faults),
        other => Failure::input(other),
    })
}
