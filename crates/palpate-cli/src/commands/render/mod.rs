//! `palpate render`: a recording, rendered: its motion as it was, or its hand under the new force.

mod hand;
mod held_force;

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use palpate_io::trace::{self, Trace, TraceError};
use palpate_sim::method::{MethodName, Settings};
use palpate_sim::replay::{Replay, ReplayError, ReplaySetup};
use palpate_sim::run::Run;
use palpate_sim::scene::Timing;

use self::hand::HandRuns;
use crate::arguments::{RenderArguments, ReplayKind};
use crate::failure::Failure;
use crate::plots;
use crate::progress::Progress;
use crate::report::{Replayed, Report, Subject};
use crate::results::deliver;
use crate::setup::{receipt, wrong_on_bench, wrong_setup};

/// Name that stands for standard input.
const STANDARD_INPUT: &str = "-";

/// Renders a recorded motion by the methods that were named.
pub fn run(arguments: &RenderArguments) -> Result<(), Failure> {
    let flags = &arguments.flags;
    let methods = flags.methods(MethodName::default());
    flags.check_settings(&methods)?;
    let setup = flags.replay_setup("render")?;
    if let (ReplayKind::Motion, Some(flag)) =
        (arguments.replay.replay, arguments.replay.of_a_hand())
    {
        return Err(Failure::Arguments(format!(
            "{flag} is for --replay hand; a motion is replayed as it was"
        )));
    }
    arguments.results.check(&arguments.trace)?;
    let progress = Progress::new(methods.len());
    let name = name(&arguments.trace);
    progress.begin(&format!("reading {name}"));
    let (trace, text) = read_trace(&arguments.trace, &name)?;
    let settings = flags.settings();
    let (reference, runs, replayed, what) = match arguments.replay.replay {
        ReplayKind::Motion => {
            let (replay, runs) = render(setup, &trace, &methods, &settings, &progress)
                .map_err(|error| in_trace(&name, error))?;
            let reference = replay.reference().clone();
            (reference, runs, Replayed::Motion, "motion")
        }
        ReplayKind::Hand => {
            let forces = held_force::read(&name, &text)?;
            let recorded = (&trace, forces.as_deref());
            let HandRuns {
                reference,
                runs,
                replayed,
            } = hand::render(
                &name,
                recorded,
                (&setup, &arguments.replay),
                (&methods, &settings),
                &progress,
            )?;
            (reference, runs, replayed, "hand")
        }
    };
    let title = format!("Recorded {what}: {name}");
    let subject = Subject {
        title: title.clone(),
        contact: &setup.contact,
        loop_params: &setup.loop_params,
        device_mass: setup.device_mass,
        delay: setup.delay,
        timing: Timing::default(),
    };
    let mut report = Report::new(&subject, &reference, &runs);
    report.replayed(replayed.clone());
    let mut receipt = receipt(&subject, setup.object, setup.virtual_force, &runs);
    receipt.push(("trace".into(), name));
    receipt.extend(replayed.receipt());
    deliver(
        &arguments.results,
        report,
        &receipt,
        &runs,
        || plots::overlay(&title, &reference, &runs),
        progress,
    )
}

/// Renders a recorded motion by each of `methods`.
pub fn render(
    setup: ReplaySetup,
    trace: &Trace,
    methods: &[MethodName],
    settings: &Settings,
    progress: &Progress,
) -> Result<(Replay, Vec<Run>), ReplayError> {
    progress.begin("ideal");
    let replay = Replay::new(setup, &trace.t_s, &trace.position_m)?;
    let mut runs = Vec::with_capacity(methods.len());
    for &method in methods {
        progress.begin(method.name());
        runs.push(replay.run(method, settings)?);
        progress.advance();
    }
    Ok((replay, runs))
}

/// What a trace is called in messages.
fn name(path: &Path) -> String {
    if path == Path::new(STANDARD_INPUT) {
        "standard input".into()
    } else {
        path.display().to_string()
    }
}

/// A fault of a replay of the trace called `name`, or of the flags that set it up.
fn in_trace(name: &str, error: ReplayError) -> Failure {
    match error {
        ReplayError::Setup(error) => wrong_setup(&error),
        ReplayError::Bench(error) => wrong_on_bench(&error),
        // The reader has checked the recording, so what is left is its length.
        other => Failure::input(format!("{name}: {other}")),
    }
}

/// The trace at `path`, and its text.
pub(super) fn read_trace(path: &Path, name: &str) -> Result<(Trace, String), Failure> {
    let mut bytes = Vec::new();
    if path == Path::new(STANDARD_INPUT) {
        io::stdin().lock().read_to_end(&mut bytes)
    } else {
        File::open(path).and_then(|mut file| file.read_to_end(&mut bytes))
    }
    .map_err(|error| Failure::System(format!("{name}: {error}")))?;
    let trace = trace::read(bytes.as_slice(), name).map_err(|error| match &error {
        TraceError::Unreadable { .. } => Failure::System(error.to_string()),
        TraceError::Invalid { place, .. } => {
            Failure::input_at(&error, place.file(), place.text(), place.span())
        }
    })?;
    Ok((trace, String::from_utf8_lossy(&bytes).into_owned()))
}
