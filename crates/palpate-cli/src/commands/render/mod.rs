//! `palpate render`: renders a recorded motion, or a recorded hand in closed loop.

mod world;

pub use world::{deliver as deliver_world, deliver_files};

use std::path::Path;

use palpate_record::trace::{HeldTrace, Trace};
use palpate_scene::method::{MethodName, Settings};
use palpate_study::sim::closed_loop::LoopError;
use palpate_study::sim::hand_replay::Recording as OfAHand;
use palpate_study::sim::replay::{Replay, ReplayError, ReplaySetup};
use palpate_study::sim::run::{MAX_PERIODS, Run};
use palpate_testbed::reference::ReferenceError;

use super::hand_replay::{Recorded, ReplayRuns, close_loop};
use crate::arguments::{RenderArguments, ReplayKind};
use crate::failure::{Failure, tell};
use crate::inside;
use crate::progress::Progress;
use crate::recorded::ends_in;
use crate::recorded::trace::{STANDARD_INPUT, how_to_cut, read_trace, reject_recording, tell_gap};
use crate::results::deliver;
use crate::setup::{check_contact, wrong_on_bench, wrong_setup};
use palpate_plot::RunsFigure;
use palpate_study::report::{RecordedMotion, Replayed, Report, Subject, actuation_lines, metadata};

/// Renders a recorded motion by the named methods.
pub fn run(arguments: &RenderArguments) -> Result<(), Failure> {
    if let Some(input) = &arguments.input {
        return world::run(arguments, input);
    }
    reject_recording(&arguments.trace, &name(&arguments.trace))?;
    reject_scene(&arguments.trace)?;
    let flags = &arguments.flags;
    let methods = flags.methods(MethodName::default());
    flags.check_settings(&methods)?;
    let setup = flags.replay_setup("render")?;
    check_contact(&setup)?;
    arguments.replay.check()?;
    if arguments.trace == Path::new(STANDARD_INPUT) {
        // A shell may have redirected a file.
        palpate_record::files::inputs::note(Path::new("/dev/stdin"));
    }
    let outputs = arguments.results.check(&arguments.trace)?;
    let period = setup.loop_params.period;
    // One more period, so that only a recording that cannot fit is rejected.
    let part = arguments.part.part((MAX_PERIODS + 1) as f64 * period)?;
    let progress = Progress::new(methods.len());
    let name = name(&arguments.trace);
    progress.begin(&format!("reading {name}"));
    let HeldTrace {
        trace,
        force_on_device_n: forces,
        virtual_force_n,
        notes,
    } = read_trace(&arguments.trace, &name, &part, &arguments.table)?;
    let motion = RecordedMotion::new(&trace.t_s, period, notes.left_out);
    tell_gap(&name, &motion);
    let is_unit_given = arguments.table.unit.is_some();
    if let Some(inside) = inside::at_start(&setup, trace.position_m[0], is_unit_given) {
        tell(format_args!("warning: {inside}"));
    }
    let replay = TraceReplay {
        arguments,
        name: &name,
        setup,
        trace: &trace,
        forces: forces.as_deref(),
        virtual_forces: virtual_force_n.as_deref(),
        methods: &methods,
        progress: &progress,
    };
    let replayed = match arguments.replay.replay {
        ReplayKind::Motion => replay.by_motion()?,
        ReplayKind::Hand => replay.by_hand()?,
    };
    let title = format!("{}: {name}", replayed.replayed.title());
    let (report, metadata) = replay.report(&replayed, &title, motion);
    let ReplayRuns {
        reference,
        runs,
        replayed,
    } = replayed;
    deliver(
        (&arguments.results, &outputs),
        report,
        &metadata,
        &runs,
        || RunsFigure::of_replay(&replayed, &title, (&reference, &runs), None).sheet(),
        progress,
    )
}

/// Rejects a scene at the place of a table of positions.
fn reject_scene(trace: &Path) -> Result<(), Failure> {
    if ends_in(trace, "toml") {
        return Err(Failure::Arguments(format!(
            "{}: a .toml file is a scene, for `palpate simulate` or `palpate run`; render requires a table of positions; \
             for a world, pass it with --input RECORDING.csv, with the columns t,x,y,z, or others with --columns",
            trace.display()
        )));
    }
    Ok(())
}

/// Replay of a trace.
struct TraceReplay<'a> {
    /// Arguments of the command.
    arguments: &'a RenderArguments,
    /// Name of the trace in messages.
    name: &'a str,
    /// Contact, loop and device.
    setup: ReplaySetup,
    /// Recorded motion.
    trace: &'a Trace,
    /// Recorded forces on the device `[N]`, if the trace has them.
    forces: Option<&'a [f64]>,
    /// Virtual forces in addition to that of the flags `[N]`, if the trace has them.
    virtual_forces: Option<&'a [f64]>,
    /// Methods to render by.
    methods: &'a [MethodName],
    /// Progress of the command.
    progress: &'a Progress,
}

impl TraceReplay<'_> {
    /// Renders the recorded motion.
    fn by_motion(&self) -> Result<ReplayRuns, Failure> {
        let period = self.setup.loop_params.period;
        let settings = self.arguments.flags.settings();
        let (replay, runs) = render(
            self.setup,
            (self.trace, self.virtual_forces.unwrap_or_default()),
            self.methods,
            &settings,
            self.progress,
        )
        .map_err(|error| in_trace(self.name, period, error))?;
        Ok(ReplayRuns {
            reference: replay.reference().clone(),
            runs,
            replayed: Replayed::Motion,
        })
    }

    /// Renders the recorded hand in closed loop.
    fn by_hand(&self) -> Result<ReplayRuns, Failure> {
        if self.virtual_forces.is_some() {
            return Err(Failure::input(format!(
                "{}: virtual_force_n: the closed loop of --replay hand has a constant virtual force; pass --force, and \
                 remove or rename the column; --replay motion uses it",
                self.name
            )));
        }
        let device_mass = self.setup.device_mass.ok_or_else(|| {
            Failure::Arguments(
                "--replay hand needs --device-mass <kg>, finite and above 0: the mass that the recorded hand \
                 moved; --replay motion needs none"
                    .into(),
            )
        })?;
        let recorded = Recorded {
            name: self.name,
            recording: OfAHand {
                times: &self.trace.t_s,
                positions: &self.trace.position_m,
                forces_on_device: self.forces,
            },
            device_mass,
            at_its_instants: false,
        };
        let settings = self.arguments.flags.settings();
        let methods = self.methods.iter();
        let settings = methods.map(|&method| (method, settings)).collect();
        close_loop(
            &recorded,
            (&self.setup, &self.arguments.replay),
            (self.methods, &settings),
            self.progress,
            &|_, error| loop_params(self.name, error),
        )
    }

    /// Returns the report of the runs and the metadata of a run file.
    fn report(
        &self,
        of: &ReplayRuns,
        title: &str,
        motion: RecordedMotion,
    ) -> (Report, Vec<(String, String)>) {
        let (setup, runs) = (&self.setup, &of.runs);
        let subject = Subject::of_replay(title.to_owned(), setup);
        let mut report = Report::new(&subject, &of.reference, runs);
        let mut metadata = metadata(&subject, setup.object, setup.virtual_force, runs);
        metadata.push(("trace".into(), self.name.to_owned()));
        let part = self.arguments.part.metadata();
        metadata.extend(part.map(|(key, value)| (format!("trace_{key}"), value)));
        metadata.extend(of.replayed.metadata());
        let model = actuation_lines(
            &setup.actuation,
            setup.delay().whole_samples(),
            setup.loop_params.period,
        );
        let model: Vec<_> = model.collect();
        let lines = model.iter();
        metadata.extend(lines.map(|(key, value)| (format!("actuator_{key}"), value.to_string())));
        report.actuated(model);
        report.replayed(of.replayed.clone());
        report.moved(motion);
        (report, metadata)
    }
}

/// Renders a recorded motion by each of `methods`.
pub fn render(
    setup: ReplaySetup,
    (trace, virtual_forces): (&Trace, &[f64]),
    methods: &[MethodName],
    settings: &Settings,
    progress: &Progress,
) -> Result<(Replay, Vec<Run>), ReplayError> {
    progress.begin("ideal");
    let replay = Replay::pushed(setup, &trace.t_s, &trace.position_m, virtual_forces)?;
    let mut runs = Vec::with_capacity(methods.len());
    for &method in methods {
        progress.begin(method.name());
        runs.push(replay.run(method, settings)?);
        progress.advance();
    }
    Ok((replay, runs))
}

/// Returns the name of a trace in messages.
fn name(path: &Path) -> String {
    if path == Path::new(STANDARD_INPUT) {
        "standard input".into()
    } else {
        path.display().to_string()
    }
}

/// Converts an error of a replay of the trace called `name`, or of the flags of its setup.
fn in_trace(name: &str, period: f64, error: ReplayError) -> Failure {
    match error {
        ReplayError::TooLong(periods) => Failure::input(format!(
            "{name}: the recording has {periods} periods of {period} s; {}",
            how_to_cut()
        )),
        ReplayError::Setup(error) => wrong_setup(&error),
        ReplayError::Bench(error) => wrong_on_bench(&error),
        // The reader has checked the recording, so only its length remains.
        other => Failure::input(format!("{name}: {other}")),
    }
}

/// Converts the error of a closed loop from the trace called `name`, or from flags.
fn loop_params(name: &str, error: LoopError) -> Failure {
    match error {
        LoopError::Setup(error) => wrong_setup(&error),
        LoopError::Bench(error) | LoopError::Ideal(ReferenceError::Scene(error)) => {
            wrong_on_bench(&error)
        }
        other => Failure::input(format!("{name}: {other}")),
    }
}
