//! `palpate render`: a recorded motion, rendered open loop.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use palpate_io::trace::{self, Trace, TraceError};
use palpate_sim::method::{MethodName, Settings};
use palpate_sim::replay::{Replay, ReplayError, ReplaySetup};
use palpate_sim::run::Run;

use crate::arguments::RenderArguments;
use crate::failure::Failure;
use crate::plots;
use crate::progress::Progress;
use crate::report::{Report, Subject};
use crate::results::deliver;
use crate::setup::{receipt, wrong_setup};

/// Renders a recorded motion by the methods that were named.
pub fn run(arguments: &RenderArguments) -> Result<(), Failure> {
    let flags = &arguments.flags;
    let methods = flags.methods(MethodName::Hfcr);
    flags.check_settings(&methods)?;
    let setup = flags.replay_setup("render")?;
    let trace = read_trace(&arguments.trace)?;
    let (replay, runs) = render(setup, &trace, &methods, &flags.settings())?;
    let title = format!("Recorded motion {}", arguments.trace.display());
    let subject = Subject {
        title: title.clone(),
        contact: &setup.contact,
        loop_params: &setup.loop_params,
        device_mass: setup.device_mass,
        delay: setup.delay,
    };
    let report = Report::new(&subject, replay.reference(), &runs);
    let mut receipt = receipt(&subject, setup.object, setup.virtual_force, &runs);
    receipt.push(("trace".into(), arguments.trace.display().to_string()));
    deliver(&arguments.results, report, &receipt, &runs, || {
        plots::overlay(&title, replay.reference(), &runs)
    })
}

/// Renders a recorded motion by each of `methods`.
pub fn render(
    setup: ReplaySetup,
    trace: &Trace,
    methods: &[MethodName],
    settings: &Settings,
) -> Result<(Replay, Vec<Run>), Failure> {
    let failure = |error: ReplayError| match error {
        ReplayError::Setup(error) => wrong_setup(&error),
        // The reader has checked the recording, so what is left is its length.
        other => Failure::input(other),
    };
    let replay = Replay::new(setup, &trace.t_s, &trace.position_m).map_err(failure)?;
    let mut progress = Progress::new(methods.len());
    let mut runs = Vec::with_capacity(methods.len());
    for &method in methods {
        progress.begin(method.name());
        runs.push(replay.run(method, settings).map_err(failure)?);
        progress.advance();
    }
    Ok((replay, runs))
}

fn read_trace(path: &Path) -> Result<Trace, Failure> {
    let (name, reader): (String, Box<dyn Read>) = if path == Path::new("-") {
        ("standard input".into(), Box::new(io::stdin().lock()))
    } else {
        let file = File::open(path)
            .map_err(|error| Failure::System(format!("{}: {error}", path.display())))?;
        (path.display().to_string(), Box::new(file))
    };
    trace::read(reader, &name).map_err(|error| match &error {
        TraceError::Unreadable { .. } => Failure::System(error.to_string()),
        TraceError::Invalid { place, .. } => {
            Failure::input_at(&error, place.file(), place.text(), place.span())
        }
    })
}
