//! `palpate run` with a world.

use std::path::Path;

use palpate_device::clock::{Clock, MonotonicClock, SteppedClock};
use palpate_record::recording::RecordingMetadata;
use palpate_rt::realtime::Request;
use palpate_rt::{ControlLoop, OnDevice, RenderedWorld, SetupError, metadata_of_devices};
use palpate_scene::world::WorldFile;
use palpate_study::device_loop::{NotRendered, lacking_axes, rendered};

use super::driving::{Ran, drive, most_periods};
use super::{
    Asked, SafetyArguments, SessionArguments, guarding, limits, outcome, request,
    tell_what_a_loop_has_not,
};
use crate::devices::{FLAGS_OF_A_DEVICE, OpenedInWorld, names, open_for_world};
use crate::failure::{Failure, tell};
use crate::reports::{Energies, RunReport, Subject};
use crate::results::print_report;
use crate::values::duration;
use crate::worlds::{self, wrong_world};

/// Returns the flags of a loop of a world; all other values are in its file.
pub fn known_flags() -> Vec<&'static str> {
    let of_loop = [
        "scene",
        "record",
        "duration",
        "fast",
        "json",
        "method",
        "guard",
        "guard_speed",
        "guard_acceleration",
        "guard_hand_force",
        "guard_mass",
        "guard_recovery",
        "guard_allowance",
        "device",
    ];
    let of_thread_and_safety = [
        "priority",
        "processor",
        "spin",
        "safe_force",
        "safe_slew",
        "safe_speed",
        "soft_start",
        "oscillation",
    ];
    let flags = of_loop.iter().chain(&FLAGS_OF_A_DEVICE);
    flags.chain(&of_thread_and_safety).copied().collect()
}

/// Runs a loop on the world of `file`, which is at `path`, and records it on request.
pub fn run_session(
    file: &WorldFile,
    (path, record): (&Path, Option<&Path>),
    arguments: &SessionArguments,
) -> Result<(), Failure> {
    let mut known = known_flags();
    known.push("stall_after_periods");
    worlds::only(&arguments.given, &known, path)?;
    let session = Session {
        file: &worlds::guarded(&arguments.flags, file),
        path,
        record,
        arguments,
    };
    if arguments.fast {
        session.on(&SteppedClock::new(), Request::nothing())
    } else {
        let spin = duration("--spin", arguments.realtime.spin)?;
        session.on(
            &MonotonicClock::new().with_spin(spin),
            request(&arguments.realtime),
        )
    }
}

struct Session<'a> {
    file: &'a WorldFile,
    path: &'a Path,
    record: Option<&'a Path>,
    arguments: &'a SessionArguments,
}

impl Session<'_> {
    fn on<C: Clock>(&self, clock: &C, request: Request) -> Result<(), Failure> {
        let (arguments, scene) = (self.arguments, &self.file.scene);
        let method = worlds::one_method(&arguments.flags, scene)?;
        let period = scene.timing.period;
        tell_what_a_loop_has_not(&scene.timing.imperfections, scene.timing.delay);
        let guarding = guarding(&arguments.safety, period)?;
        let (device, given) = (&arguments.device, &arguments.given);
        let opened = open_for_world(device, given, scene, clock, &guarding, &[])?;
        let (on, world) = on_devices((self.file, method), &opened, &arguments.safety);
        lacking_axes(scene, &on).iter().for_each(tell);
        let world = world.map_err(|error| match error {
            NotRendered::World(faults) => wrong_world(&arguments.flags, self.file, &faults),
            NotRendered::Devices(error) => self.wrong(error),
        })?;
        let limits = on.iter().map(|on| on.limits);
        let devices = opened.into_iter().map(|opened| opened.device).zip(limits);
        let control = ControlLoop::of_devices(devices.collect(), clock.clone(), world)
            .map_err(|error| self.wrong(error))?;
        let most = most_periods(arguments.duration, control.period())?;
        let record = match self.record {
            Some(out) => {
                let metadata = metadata_of_devices(env!("CARGO_PKG_VERSION"), &on, &request);
                Some((out, put(metadata, self.file, method)?))
            }
            None => None,
        };
        let Ran {
            end,
            answers,
            account,
            recording,
            unwritten,
        } = drive(control, record, request, most, &guarding)?;
        let ledger = end.control.rendered().state().ledger();
        let capabilities: Vec<_> = on.iter().map(|on| &on.capabilities).collect();
        let guarded = guarding.report_of(arguments.device.are_guarded(), &capabilities);
        let report = RunReport::of_devices(
            Subject {
                title: &scene.title,
                method: worlds::known(method),
                period,
            },
            &capabilities,
            &names(scene),
            &end,
            &answers,
            &account,
            recording.as_ref(),
        )
        .with_energies(Energies::of_world(&end, ledger))
        .guarded(guarded);
        print_report(&report, arguments.json)?;
        let asked = Asked {
            duration: arguments.duration,
            device_may_end: false,
            lost: "the device was lost before the end; `palpate run --reconnect` waits for one that \
                   can be opened again",
        };
        let outcome = outcome::of(&end, &asked, &account, unwritten, recording.as_ref());
        outcome::by_device(outcome, &end, &names(scene))
    }

    fn wrong(&self, error: SetupError) -> Failure {
        match error {
            SetupError::Safety(error) => Failure::Arguments(error.to_string()),
            other => Failure::input(format_args!("{}: {other}", self.path.display())),
        }
    }
}

/// Creates the devices and the rendering of a loop on the world of `file`. The devices were `opened` in the order of
/// the file; each has its limits.
///
/// # Errors
/// `method` cannot render the world.
pub fn on_devices(
    (file, method): (&WorldFile, &str),
    opened: &[OpenedInWorld],
    safety: &SafetyArguments,
) -> (Vec<OnDevice>, Result<RenderedWorld, NotRendered>) {
    let on = opened.iter().zip(names(&file.scene)).map(|(opened, name)| {
        let capabilities = opened.device.capabilities().clone();
        OnDevice {
            name: name.to_owned(),
            frame: opened.frame,
            limits: limits(&capabilities, safety),
            capabilities,
        }
    });
    let on: Vec<_> = on.collect();
    let world = rendered(&file.scene, method, &on);
    (on, world)
}

/// Adds the world's file, as it was read with its edits, and the rendering method to the metadata.
pub fn put(
    metadata: RecordingMetadata,
    file: &WorldFile,
    method: &str,
) -> Result<RecordingMetadata, Failure> {
    let text = file.edited_text().map_err(Failure::inputs)?;
    Ok(metadata
        .with("world", &text)
        .with("method", &format!("name = \"{method}\"\n")))
}
