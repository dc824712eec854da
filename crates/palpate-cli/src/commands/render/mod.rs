//! `palpate render`: a recording, rendered: its motion as it was, or its hand under the new force.

use std::fs::File;
use std::io;
use std::path::Path;

use palpate_io::trace::{self, HeldTrace, Part, Trace, TraceError, TraceFault};
use palpate_io::unit::LengthUnit;
use palpate_scene::Timing;
use palpate_scene::method::{MethodName, Settings};
use palpate_sim::closed_loop::LoopError;
use palpate_sim::hand_replay::Recording as OfAHand;
use palpate_sim::replay::{Replay, ReplayError, ReplaySetup};
use palpate_sim::run::{MOST_PERIODS, Run};

use super::hand_replay::{Recorded, ReplayRuns, close_loop};
use crate::arguments::{RenderArguments, ReplayKind};
use crate::failure::{Failure, tell};
use crate::inside;
use crate::progress::Progress;
use crate::report::{Replayed, Report, Subject, digits};
use crate::results::deliver;
use crate::setup::{check_contact, receipt, wrong_on_bench, wrong_setup};

/// Name that stands for standard input.
const STANDARD_INPUT: &str = "-";

/// Where so many periods as fit are less than this `[s]`, the period is wrong, not the trace.
const SHORTEST_FIT: f64 = 1.0;

/// Renders a recorded motion by the methods that were named.
pub fn run(arguments: &RenderArguments) -> Result<(), Failure> {
    let flags = &arguments.flags;
    let methods = flags.methods(MethodName::default());
    flags.check_settings(&methods)?;
    let setup = flags.replay_setup("render")?;
    check_contact(&setup)?;
    arguments.replay.check()?;
    let outputs = arguments.results.check(&arguments.trace)?;
    let period = setup.loop_params.period;
    // One more, so that it is refused only where it cannot fit.
    let part = arguments.part.part((MOST_PERIODS + 1) as f64 * period)?;
    let progress = Progress::new(methods.len());
    let name = name(&arguments.trace);
    progress.begin(&format!("reading {name}"));
    let HeldTrace {
        trace,
        force_on_device_n: forces,
    } = read_trace(&arguments.trace, &name, &part, arguments.unit)?;
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
                .map_err(|error| in_trace(&name, period, error))?;
            ReplayRuns {
                reference: replay.reference().clone(),
                runs,
                replayed: Replayed::Motion,
            }
        }
        ReplayKind::Hand => {
            let device_mass = setup.device_mass.ok_or_else(|| {
                Failure::Arguments(
                    "--replay hand needs --device-mass <kg>, finite and above 0: what the recorded hand \
                     moved; --replay motion needs none"
                        .into(),
                )
            })?;
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
    let part = arguments.part.receipt();
    receipt.extend(part.map(|(key, value)| (format!("trace_{key}"), value)));
    receipt.extend(replayed.receipt());
    report.replayed(replayed.clone());
    deliver(
        (&arguments.results, &outputs),
        report,
        &receipt,
        &runs,
        || replayed.figure(&title, &reference, &runs, None).sheet(),
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
fn in_trace(name: &str, period: f64, error: ReplayError) -> Failure {
    match error {
        ReplayError::TooLong(periods) => Failure::input(format!(
            "{name}: the recording has {periods} periods of {period} s; {}",
            how_to_cut()
        )),
        ReplayError::Setup(error) => wrong_setup(&error),
        ReplayError::Bench(error) => wrong_on_bench(&error),
        // The reader has checked the recording, so what is left is its length.
        other => Failure::input(format!("{name}: {other}")),
    }
}

/// What to do with a recording that has too many periods.
pub fn how_to_cut() -> String {
    format!(
        "at most {MOST_PERIODS} fit, so take a part of it with --from and --to [s], or a longer --period"
    )
}

/// A closed loop that cannot be made from the trace called `name`, or from flags.
fn in_loop(name: &str, error: LoopError) -> Failure {
    match error {
        LoopError::Setup(error) => wrong_setup(&error),
        LoopError::Bench(error) => wrong_on_bench(&error),
        other => Failure::input(format!("{name}: {other}")),
    }
}

/// A part of the trace at `path`, its positions in `unit` if one is said, with the force that was held,
/// where it says so.
pub fn read_trace(
    path: &Path,
    name: &str,
    part: &Part,
    unit: Option<LengthUnit>,
) -> Result<HeldTrace, Failure> {
    if path
        .extension()
        .is_some_and(|extension| extension == "mcap")
    {
        return Err(Failure::Arguments(format!(
            "{name} is a recording: `palpate replay` takes it, and `--motion` of `run --device replay`"
        )));
    }
    let read = if path == Path::new(STANDARD_INPUT) {
        trace::read_part(io::stdin().lock(), name, part, unit)
    } else {
        let file = File::open(path).map_err(|error| Failure::System(format!("{name}: {error}")))?;
        trace::read_part(file, name, part, unit)
    };
    let held = read.map_err(|error| match &error {
        TraceError::Unreadable { .. } => Failure::System(error.to_string()),
        // The last line that was read is not what is wrong.
        TraceError::Invalid {
            fault: TraceFault::TooLong { longest, first },
            ..
        } => {
            let fits = longest * MOST_PERIODS as f64 / (MOST_PERIODS + 1) as f64;
            let message = format!(
                "{name}: the trace goes on for more than {MOST_PERIODS} periods ({} s) after its first \
                 sample at {first} s; {}",
                digits(fits),
                how_to_cut()
            );
            if fits < SHORTEST_FIT {
                Failure::Arguments(format!("--period is too short: {message}"))
            } else {
                Failure::input(message)
            }
        }
        TraceError::Invalid { place, .. } => {
            Failure::input_at(&error, place.file(), place.text(), place.span())
        }
    })?;
    inside::check_trace(name, &held.trace, unit)?;
    Ok(held)
}
