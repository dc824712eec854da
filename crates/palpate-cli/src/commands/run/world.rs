//! `palpate run` and `palpate record` with a world.

use std::path::Path;

use palpate_device::Capabilities;
use palpate_device::clock::{Clock, MonotonicClock, SteppedClock};
use palpate_files::bounded::SCENE;
use palpate_record::recording::Receipt;
use palpate_rt::realtime::Request;
use palpate_rt::safety::SafetyParams;
use palpate_rt::{
    ControlLoop, ReceiptOf, RenderedWorld, SetupError, WorldFrame, receipt_of_devices,
};
use palpate_scene::world::{WorldFile, WorldScene};
use palpate_session::{Energies, RunReport, Subject};
use palpate_sim::device::{Told, told_of_devices};
use palpate_world::Tool;

use super::driving::{Ran, drive, most_periods};
use super::{Asked, SafetyArguments, SessionArguments, guarding, limits, outcome, request};
use crate::devices::{FLAGS_OF_A_DEVICE, OpenedInWorld, names, open_for_world};
use crate::failure::{Failure, tell};
use crate::results::print_report;
use crate::values::duration;
use crate::worlds::{self, wrong_world};

/// What a loop of a world takes beside its file; everything else is said in the file.
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

/// Runs a loop on the world of `file`, which is at `path`, and records it if it is to.
pub fn run_session(
    file: &WorldFile,
    (path, record): (&Path, Option<&Path>),
    arguments: &SessionArguments,
) -> Result<(), Failure> {
    let mut known = known_flags();
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
        let (device, given) = (&arguments.device, &arguments.given);
        let opened = open_for_world(device, given, scene, clock, &guarding, &[])?;
        let opened_as = |opened| OnDevice::of(opened, &arguments.safety);
        let on: Vec<OnDevice> = opened.iter().map(opened_as).collect();
        tell_of_axes(scene, &on);
        let world = rendered(self.file, method, &on)
            .map_err(|faults| wrong_world(&arguments.flags, self.file, &faults))?
            .map_err(|error| self.wrong(error))?;
        let limits = on.iter().map(|on| on.limits);
        let devices = opened.into_iter().map(|opened| opened.device).zip(limits);
        let control = ControlLoop::of_devices(devices.collect(), clock.clone(), world)
            .map_err(|error| self.wrong(error))?;
        let most = most_periods(arguments.duration, control.period())?;
        let record = match self.record {
            Some(out) => {
                let each = on.iter().zip(names(scene)).map(|(on, name)| ReceiptOf {
                    name,
                    capabilities: &on.capabilities,
                    limits: &on.limits,
                    frame: &on.frame,
                });
                let each: Vec<_> = each.collect();
                let receipt = receipt_of_devices(env!("CARGO_PKG_VERSION"), &each, &request);
                Some((out, put(receipt, self.path, method)?))
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
        .with_energies(Energies::of_world(&end, books))
        .guarded(guarded);
        print_report(&report, arguments.json)?;
        let asked = Asked {
            duration: arguments.duration,
            device_may_end: false,
            lost: "the device was lost before the end; `palpate run --reconnect` waits for one that \
                   can be opened again",
        };
        let outcome = outcome::of(&end, &asked, unwritten, recording.as_ref());
        outcome::by_device(outcome, &end, &names(scene))
    }

    fn wrong(&self, error: SetupError) -> Failure {
        match error {
            SetupError::Safety(error) => Failure::Arguments(error.to_string()),
            other => Failure::input(format_args!("{}: {other}", self.path.display())),
        }
    }
}

/// A device of a loop that renders a world.
pub struct OnDevice {
    /// Where it stands in the world.
    pub frame: WorldFrame,
    /// What it can do.
    pub capabilities: Capabilities,
    /// What may reach it.
    pub limits: SafetyParams,
}

impl OnDevice {
    /// A device that is open, with what may reach it.
    pub fn of(opened: &OpenedInWorld, safety: &SafetyArguments) -> Self {
        let capabilities = opened.device.capabilities().clone();
        Self {
            frame: opened.frame,
            limits: limits(&capabilities, safety),
            capabilities,
        }
    }
}

/// Says which axes of the file's devices those of the loop lack: the loop renders none there, and what the file is simulated with
/// has a motor.
pub fn tell_of_axes(scene: &WorldScene, on: &[OnDevice]) {
    for (tool, on) in scene.world.tools.iter().zip(on) {
        if tool.own_axes.is_some() {
            continue;
        }
        let left = Tool::new(tool.name.clone(), tool.shape.clone())
            .along([0, 1, 2].map(|axis| tool.axes[axis] && on.frame.has(axis)));
        if left.axes == tool.axes || left.axes == [false; 3] {
            continue;
        }
        let names = ["x", "y", "z"].into_iter().zip(left.axes);
        let names = names.filter(|(_, has)| *has);
        let names: Vec<_> = names.map(|(name, _)| format!("\"{name}\"")).collect();
        tell(format_args!(
            "{name}: the file says {says}, and the device has {moves} of the world ({device}): no force is rendered along the rest, \
             where the mechanism holds the tool; `axes = [{names}]` in [[device]] says so to `simulate`, `compare` and `tune`, too",
            name = tool.name,
            device = on.capabilities.name,
            moves = left.names_of_axes(),
            says = tool.names_of_axes(),
            names = names.join(", ")
        ));
    }
}

/// What a loop renders of a world, on devices that stand in it and are given no more than their limits say. The renderer is told
/// how coarse the sensors of the devices are, and which axes of the world they lack.
pub fn rendered(
    file: &WorldFile,
    method: &str,
    on: &[OnDevice],
) -> Result<Result<RenderedWorld, SetupError>, Vec<palpate_world::WorldError>> {
    let told = on.iter().map(|on| Told {
        device: &on.capabilities,
        has_axes: [0, 1, 2].map(|axis| on.frame.has(axis)),
        largest_force: on.limits.largest_force,
        largest_torque: on.limits.largest_torque,
    });
    let scene: WorldScene = told_of_devices(&file.scene, &told.collect::<Vec<_>>());
    let renderer = scene.renderer(method)?;
    let method = worlds::known(method);
    let frames = on.iter().map(|on| on.frame).collect();
    Ok(RenderedWorld::of_devices(
        &scene.world,
        renderer,
        method,
        frames,
    ))
}

/// The receipt with the world as its file has it, and by which method it is rendered.
pub fn put(receipt: Receipt, path: &Path, method: &str) -> Result<Receipt, Failure> {
    let name = path.display().to_string();
    let text = SCENE
        .text(path)
        .map_err(|error| Failure::System(format!("{name}: {error}")))?;
    Ok(receipt
        .with("world", &text)
        .with("method", &format!("name = \"{method}\"\n")))
}
