//! `palpate render`: a recording, rendered: its motion as it was, or its hand under the new force.

mod held_force;

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use palpate_io::trace::{self, Trace, TraceError};
use palpate_io::unit::LengthUnit;
use palpate_sim::closed_loop::LoopError;
use palpate_sim::hand_replay::Recording as OfAHand;
use palpate_sim::method::{MethodName, Settings};
use palpate_sim::replay::{Replay, ReplayError, ReplaySetup};
use palpate_sim::run::Run;
use palpate_sim::scene::Timing;

use super::hand_replay::{Recorded, ReplayRuns, close_loop};
use crate::arguments::{RenderArguments, ReplayKind};
use crate::failure::{Failure, tell};
use crate::inside;
use crate::plots;
use crate::progress::Progress;
use crate::report::{Replayed, Report, Subject};
use crate::results::deliver;
use crate::setup::{check_contact, receipt, wrong_on_bench, wrong_setup};

/// Name that stands for standard input.
const STANDARD_INPUT: &str = "-";

/// Renders a recorded motion by the methods that were named.
pub fn run(arguments: &RenderArguments) -> Result<(), Failure> {
    let flags = &arguments.flags;
    let methods = flags.methods(MethodName::default());
    flags.check_settings(&methods)?;
    let setup = flags.replay_setup("render")?;
    arguments.replay.check()?;
    arguments.results.check(&arguments.trace)?;
    let progress = Progress::new(methods.len());
    let name = name(&arguments.trace);
    progress.begin(&format!("reading {name}"));
    let (trace, text) = read_trace(&arguments.trace, &name, arguments.unit)?;
    if let Some(inside) = inside::at_start(&setup, trace.position_m[0], arguments.unit.is_some()) {
        tell(format_args!("warning: {inside}"));
    }
    let settings = flags.settings();
    let ReplayRuns {
        reference,
        runs,
        replayed,
    } = match arguments.replay.replay {
        ReplayKind::Motion => {
            let (replay, runs) = render(setup, &trace, &methods, &settings, &progress)
                .map_err(|error| in_trace(&name, error))?;
            ReplayRuns {
                reference: replay.reference().clone(),
                runs,
                replayed: Replayed::Motion,
            }
        }
        ReplayKind::Hand => {
            let forces = held_force::read(&name, &text)?;
            let device_mass = setup.device_mass.ok_or_else(|| {
                Failure::Arguments(
                    "--replay hand needs --device-mass <kg>, finite and above 0: what the recorded hand \
                     moved; --replay motion needs none"
                        .into(),
                )
            })?;
            check_contact(&setup)?;
            let recorded = Recorded {
                name: &name,
                recording: OfAHand {
                    times: &trace.t_s,
                    positions: &trace.position_m,
                    forces_on_device: forces.as_deref(),
                },
                device_mass,
                at_its_instants: false,
            };
            let settings = methods.iter().map(|&method| (method, settings)).collect();
            close_loop(
                &recorded,
                (&setup, &arguments.replay),
                (&methods, &settings),
                &progress,
                &|_, error| in_loop(&name, error),
            )?
        }
    };
    let title = format!("{}: {name}", replayed.title());
    let subject = Subject {
        title: title.clone(),
        contact: &setup.contact,
        loop_params: &setup.loop_params,
        device_mass: setup.device_mass,
        delay: setup.delay,
        timing: Timing::default(),
    };
    let mut report = Report::new(&subject, &reference, &runs);
    let mut receipt = receipt(&subject, setup.object, setup.virtual_force, &runs);
    receipt.push(("trace".into(), name));
    receipt.extend(replayed.receipt());
    report.replayed(replayed.clone());
    deliver(
        &arguments.results,
        report,
        &receipt,
        &runs,
        || plots::replay(&title, &replayed, &reference, &runs, None),
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

/// A closed loop that cannot be made from the trace called `name`, or from flags.
fn in_loop(name: &str, error: LoopError) -> Failure {
    match error {
        LoopError::Setup(error) => wrong_setup(&error),
        LoopError::Bench(error) => wrong_on_bench(&error),
        other => Failure::input(format!("{name}: {other}")),
    }
}

/// The trace at `path`, its positions in `unit` if one is said, and its text.
pub fn read_trace(
    path: &Path,
    name: &str,
    unit: Option<LengthUnit>,
) -> Result<(Trace, String), Failure> {
    let mut bytes = Vec::new();
    if path == Path::new(STANDARD_INPUT) {
        io::stdin().lock().read_to_end(&mut bytes)
    } else {
        File::open(path).and_then(|mut file| file.read_to_end(&mut bytes))
    }
    .map_err(|error| Failure::System(format!("{name}: {error}")))?;
    let trace = trace::read_in(bytes.as_slice(), name, unit).map_err(|error| match &error {
        TraceError::Unreadable { .. } => Failure::System(error.to_string()),
        TraceError::Invalid { place, .. } => {
            Failure::input_at(&error, place.file(), place.text(), place.span())
        }
    })?;
    inside::check_trace(name, &trace, unit)?;
    Ok((trace, String::from_utf8_lossy(&bytes).into_owned()))
}
