//! `palpate run` and `palpate record` with a world.

use std::path::Path;

use palpate_device::Capabilities;
use palpate_device::clock::{Clock, MonotonicClock, SteppedClock};
use palpate_files::bounded::SCENE;
use palpate_record::recording::Receipt;
use palpate_rt::realtime::Request;
use palpate_rt::safety::SafetyParams;
use palpate_rt::{ControlLoop, RenderedWorld, SetupError, WorldFrame, receipt};
use palpate_scene::world::{WorldFile, WorldScene};
use palpate_session::{Energies, RunReport, Subject};
use palpate_sim::device::told_of;

use super::driving::{Ran, drive, most_periods};
use super::{Asked, SessionArguments, guarding, limits, outcome, request};
use crate::devices::{OpenedInWorld, open_in_world};
use crate::failure::Failure;
use crate::results::print_report;
use crate::values::duration;
use crate::worlds::{self, wrong_world};

/// What a loop of a world takes beside its file; everything else is said in the file.
pub const FLAGS: [&str; 31] = [
    "scene",
    "record",
    "duration",
    "fast",
    "json",
    "method",
    "guard",
    "guard_speed",
    "guard_allowance",
    "device",
    "port",
    "generation",
    "board",
    "start_pose",
    "reconnect",
    "reconnect_in_start_pose",
    "guardian",
    "service",
    "events",
    "device_id",
    "service_priority",
    "origin",
    "world_axes",
    "priority",
    "processor",
    "spin",
    "safe_force",
    "safe_slew",
    "safe_speed",
    "soft_start",
    "oscillation",
];

/// Runs a loop on the world of `file`, which is at `path`, and records it if it is to.
pub fn run_session(
    file: &WorldFile,
    (path, record): (&Path, Option<&Path>),
    arguments: &SessionArguments,
) -> Result<(), Failure> {
    let mut known = FLAGS.to_vec();
    known.push("stall_after");
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
        let guarding = guarding(&arguments.safety, period)?;
        let OpenedInWorld { device, frame } =
            open_in_world(&arguments.device, scene, clock, &guarding)?;
        let limits = limits(device.capabilities(), &arguments.safety);
        let capabilities = device.capabilities().clone();
        let world = rendered(self.file, method, (&frame, &capabilities), &limits)
            .map_err(|faults| wrong_world(&arguments.flags, self.file, &faults))?
            .map_err(|error| self.wrong(error))?;
        let control = ControlLoop::of_world(device, clock.clone(), world, limits)
            .map_err(|error| self.wrong(error))?;
        let most = most_periods(arguments.duration, control.period())?;
        let record = match self.record {
            Some(out) => {
                let version = env!("CARGO_PKG_VERSION");
                let receipt = receipt(version, &capabilities, &limits, &request);
                Some((out, put(receipt, self.path, method, &frame)?))
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
        let books = end.control.rendered().state().books();
        let report = RunReport::new(
            Subject {
                title: &scene.title,
                method: worlds::known(method),
                period,
            },
            &capabilities,
            &end,
            &answers,
            &account,
            recording.as_ref(),
        )
        .with_energies(Energies::of_world(&end, books))
        .guarded(guarding.report(arguments.device.is_guarded(), &capabilities));
        print_report(&report, arguments.json)?;
        let asked = Asked {
            duration: arguments.duration,
            device_may_end: false,
            lost: "the device was lost before the end; `palpate run --reconnect` waits for one that \
                   can be opened again",
        };
        outcome::of(&end, &asked, unwritten, recording.as_ref())
    }

    fn wrong(&self, error: SetupError) -> Failure {
        match error {
            SetupError::Safety(error) => Failure::Arguments(error.to_string()),
            other => Failure::input(format_args!("{}: {other}", self.path.display())),
        }
    }
}

/// What a loop renders of a world, on a device that stands in it as `frame` says and is given no more than `limits` say. The renderer is told how coarse the device's sensor is, and that the device does not move along the axes that it
/// has not.
pub fn rendered(
    file: &WorldFile,
    method: &str,
    (frame, device): (&WorldFrame, &Capabilities),
    limits: &SafetyParams,
) -> Result<Result<RenderedWorld, SetupError>, Vec<palpate_world::WorldError>> {
    let has_axis = |axis| frame.has(axis);
    let (force, torque) = (limits.largest_force, limits.largest_torque);
    let scene: WorldScene = told_of(&file.scene, device, has_axis, force, torque);
    let renderer = scene.renderer(method)?;
    let method = worlds::known(method);
    Ok(RenderedWorld::new(&scene.world, renderer, method, *frame))
}

/// The receipt with the world as its file has it, by which method it is rendered, and where the device stands in it.
pub fn put(
    receipt: Receipt,
    path: &Path,
    method: &str,
    frame: &WorldFrame,
) -> Result<Receipt, Failure> {
    let name = path.display().to_string();
    let text = SCENE
        .text(path)
        .map_err(|error| Failure::System(format!("{name}: {error}")))?;
    Ok(receipt
        .with("world", &text)
        .with("method", &format!("name = \"{method}\"\n"))
        .with("frame", &frame.to_string()))
}
