//! `palpate replay`: the motion of a recording, rendered by another method.

use std::io;
use std::path::PathBuf;

use clap::{Args, ValueEnum, ValueHint};
use palpate_io::recording::{Entry, Recording, Tick};
use palpate_sim::replay::{Replay, ReplayError, ReplaySetup};
use palpate_sim::scene::{SceneFile, SetupError, Timing};

use super::simulate::in_file;
use crate::arguments::{Flags, Results};
use crate::failure::Failure;
use crate::plots::{self, Recorded};
use crate::progress::Progress;
use crate::recorded::{open, whole_or_said};
use crate::report::{FromRecording, Replayed, Report, Subject};
use crate::results::deliver;
use crate::setup::{receipt, wrong_flag, wrong_on_bench, wrong_setup};

/// Text of the receipt that holds the scene.
const SCENE: &str = "scene";

/// Arguments of `replay`.
#[derive(Args, Debug)]
pub struct ReplayArguments {
    /// Recording (MCAP)
    #[arg(value_name = "REC.mcap", value_hint = ValueHint::FilePath)]
    pub recording: PathBuf,
    /// What is kept of the recording
    #[arg(long, value_name = "KIND", value_enum, default_value_t = Kept::Motion)]
    pub replay: Kept,
    /// Contact, loop, method and device, where they are not to be those of the recording's scene.
    #[command(flatten)]
    pub flags: Flags,
    /// Where results go.
    #[command(flatten)]
    pub results: Results,
}

/// What a replay keeps of a recording.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept {
    /// Where the device was and when, whatever the force
    Motion,
}

/// Replays the motion by the methods that were named, or by the scene's own.
pub fn run(arguments: &ReplayArguments) -> Result<(), Failure> {
    let Kept::Motion = arguments.replay;
    let flags = &arguments.flags;
    arguments.results.check(&arguments.recording)?;
    let name = arguments.recording.display().to_string();
    let recording = open(&arguments.recording)?;
    let file = scene(&recording, &name)?;
    let methods = flags.methods(file.scene.method);
    flags.check_settings(&methods)?;
    let mut scene = file.scene.clone();
    flags.change(&mut scene, &methods)?;
    let progress = Progress::new(methods.len());
    progress.begin(&format!("reading {name}"));
    let motion = Motion::of(&recording)?;
    let mut setup = ReplaySetup::of_scene(&scene);
    // A flag of its position or velocity puts it elsewhere.
    if !flags.gives("object position") && !flags.gives("object velocity") {
        motion.place_object(&mut setup);
    }
    progress.begin("ideal");
    let failure = |method, error: ReplayError| match error {
        ReplayError::Setup(SetupError::Parameter(parameter))
            if flags.gives(parameter.parameter) =>
        {
            wrong_flag(&parameter)
        }
        ReplayError::Setup(setup) if flags.damping.is_some() => wrong_setup(&setup),
        ReplayError::Setup(setup) => in_file(file.locate(method, &setup)),
        ReplayError::Bench(error) => wrong_on_bench(&error),
        other => Failure::input(format_args!("{name}: {other}")),
    };
    let replay = Replay::at_recorded_instants(setup, &motion.curves.time, &motion.positions)
        .map_err(|error| failure(scene.method, error))?;
    let mut runs = Vec::with_capacity(methods.len());
    for &method in &methods {
        progress.begin(method.name());
        let settings = scene.settings.get(&method).copied().unwrap_or_default();
        let run = replay.run(method, &settings);
        runs.push(run.map_err(|error| failure(method, error))?);
        progress.advance();
    }
    let title = format!("Motion replay: {name}");
    let subject = Subject {
        title: title.clone(),
        contact: &setup.contact,
        loop_params: &setup.loop_params,
        device_mass: setup.device_mass,
        delay: setup.delay,
        timing: Timing::default(),
    };
    let mut report = Report::new(&subject, replay.reference(), &runs);
    report.replayed(Replayed::Motion);
    report.from_recording(FromRecording {
        file: name.clone(),
        recorded_method: file.scene.method.name(),
        complete: recording.complete,
        ticks: recording.ticks,
        ticks_lost: recording.lost(),
        ticks_without_position: motion.without_position,
        parameter_changes: recording.generation,
        recorded_peak_force_n: motion.peak_force,
        recorded_leak_held_j: motion.curves.held_leak.last().copied().unwrap_or(0.0),
    });
    let mut receipt = receipt(&subject, setup.object, setup.virtual_force, &runs);
    receipt.push(("replay".into(), "motion".into()));
    receipt.push(("recording".into(), name.clone()));
    receipt.push(("ticks_lost".into(), recording.lost().to_string()));
    deliver(
        &arguments.results,
        report,
        &receipt,
        &runs,
        || plots::motion_replay(&title, replay.reference(), &runs, &motion.curves),
        progress,
    )?;
    whole_or_said(&recording)
}

/// The scene that the recording was made with.
fn scene(recording: &Recording, name: &str) -> Result<SceneFile, Failure> {
    let receipt = &recording.receipt;
    let text = receipt.texts.get(SCENE).ok_or_else(|| {
        Failure::input(format_args!(
            "{name}: its receipt has no text called {SCENE}, so nothing says what the contact was"
        ))
    })?;
    let mut files = |file: &str| {
        receipt.file(file).map(str::to_owned).ok_or_else(|| {
            io::Error::new(
                io::ErrorKind::NotFound,
                "it is not in the recording's receipt",
            )
        })
    };
    SceneFile::parse_with(&format!("{name} ({SCENE})"), text, &mut files).map_err(in_file)
}

/// What the device did, and what was recorded beside it.
#[derive(Default)]
struct Motion {
    positions: Vec<f64>,
    curves: Recorded,
    first: Option<Tick>,
    without_position: u64,
    peak_force: f64,
}

impl Motion {
    fn of(recording: &Recording) -> Result<Self, Failure> {
        let mut motion = Self::default();
        for entry in recording.entries().map_err(Failure::input)? {
            if let Entry::Tick(tick) = entry.map_err(Failure::input)? {
                motion.add(&tick);
            }
        }
        Ok(motion)
    }

    fn add(&mut self, tick: &Tick) {
        // What was sent counts, whether a position came with it or not.
        self.peak_force = self.peak_force.max(tick.force_on_device.abs());
        if !tick.device_position.is_finite() {
            self.without_position += 1;
            return;
        }
        let first = *self.first.get_or_insert(*tick);
        self.positions.push(tick.device_position);
        self.curves.time.push(tick.time);
        self.curves.object_position.push(tick.object_position);
        self.curves.force_on_object.push(-tick.force_on_device);
        self.curves.held_leak.push(tick.held_leak - first.held_leak);
    }

    /// Puts the object where it was at the first tick.
    fn place_object(&self, setup: &mut ReplaySetup) {
        if let Some(first) = &self.first
            && first.object_position.is_finite()
            && first.object_velocity.is_finite()
        {
            setup.object.position = first.object_position;
            setup.object.velocity = first.object_velocity;
        }
    }
}
