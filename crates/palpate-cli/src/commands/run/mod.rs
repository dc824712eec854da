//! `palpate run`: a real-time loop on a device.

mod arguments;
mod driving;
pub mod outcome;
pub mod world;

use std::path::Path;

use palpate_device::Capabilities;
use palpate_device::clock::{Clock, MonotonicClock, SteppedClock};
use palpate_rt::realtime::Request;
use palpate_rt::safety::SafetyParams;
use palpate_rt::{ControlLoop, SetupError, metadata};
use palpate_scene::method::MethodName;
use palpate_scene::{ContactFile, Delay, Scene, SceneFile, Timing};
use palpate_study::recording::put_scene;

pub use arguments::{RealtimeArguments, RunArguments, SafetyArguments, SessionArguments};
pub use outcome::Asked;

use crate::devices::{DeviceName, Opened, open, replayed};
use crate::failure::{Failure, tell};
use crate::results::print_report;
use crate::values::duration;
use driving::{Ran, drive, most_periods};

use super::simulate::read_any;
use crate::reports::{Guarding, RunReport, Subject};

/// Runs a loop, and records it on request.
pub fn run(arguments: &RunArguments) -> Result<(), Failure> {
    let (path, record) = (arguments.scene.as_path(), arguments.record.as_deref());
    let arguments = &arguments.session;
    let file = match read_any(path, &arguments.flags.edits)? {
        SceneFile::Contact(file) => *file,
        SceneFile::World(file) => return world::run_session(&file, (path, record), arguments),
    };
    run_session(&file, (path, record), arguments, &|report| {
        print_report(report, arguments.json)
    })
}

/// Runs a loop on the scene of `file`, which is at `path`, and records it on request. `model` receives the report of a
/// completed loop.
///
/// # Errors
/// The loop could not begin, or it failed.
pub fn run_session(
    file: &ContactFile,
    (path, record): (&Path, Option<&Path>),
    arguments: &SessionArguments,
    model: Model<'_>,
) -> Result<(), Failure> {
    let flags = &arguments.flags;
    let methods = flags.methods(file.scene.method);
    let [method] = methods[..] else {
        return Err(Failure::Arguments(
            "--method: a loop runs one method; `palpate simulate` compares several".into(),
        ));
    };
    flags.check_settings(&methods)?;
    let mut scene = file.scene.clone();
    flags.change(&mut scene, &methods)?;
    scene.method = method;
    tell_what_a_loop_has_not(&scene.timing, scene.delay);
    let session = Session {
        scene: &scene,
        path,
        record,
        arguments,
        method,
        model,
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

/// Reports properties of a scene's loop that a real-time loop lacks.
pub fn tell_what_a_loop_has_not(timing: &Timing, delay: Delay) {
    if *timing != Timing::default() || delay.fraction() != 0.0 {
        tell(
            "warning: the scene's jitter, drops and delay fraction are for simulation; this loop has its own",
        );
    }
}

/// Returns the requests to the machine.
pub fn request(arguments: &RealtimeArguments) -> Request {
    Request {
        priority: (arguments.priority > 0).then_some(arguments.priority),
        lock_memory: arguments.priority > 0,
        processor: arguments.processor,
    }
}

struct Session<'a> {
    scene: &'a Scene,
    path: &'a Path,
    record: Option<&'a Path>,
    arguments: &'a SessionArguments,
    method: MethodName,
    model: Model<'a>,
}

/// Receiver of a loop's report.
type Model<'a> = &'a dyn Fn(&RunReport) -> Result<(), Failure>;

impl Session<'_> {
    fn on<C: Clock>(&self, clock: &C, request: Request) -> Result<(), Failure> {
        let guarding = guarding(&self.arguments.safety, self.scene.loop_params.period)?;
        let arguments = &self.arguments.device;
        let Opened { device, axis } = open(arguments, self.scene, clock, &guarding)?;
        let limits = limits(device.capabilities(), &self.arguments.safety);
        let wrong = |error: SetupError| match error {
            SetupError::Safety(error) => Failure::Arguments(error.to_string()),
            other => Failure::input(format_args!("{}: {other}", self.path.display())),
        };
        let rendering = self.scene.rendering(self.method).map_err(Failure::input)?;
        let capabilities = device.capabilities().clone();
        let control = ControlLoop::new(device, clock.clone(), rendering, limits)
            .map_err(wrong)?
            .along(axis);
        let most = most_periods(self.arguments.duration, control.period())?;
        let record = match self.record {
            Some(out) => {
                let version = env!("CARGO_PKG_VERSION");
                let metadata = metadata(version, &capabilities, &limits, &request);
                let metadata = put_scene(metadata, self.scene, self.path)?;
                Some((out, metadata))
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
        let report = RunReport::new(
            Subject {
                title: &self.scene.title,
                method: self.method.name(),
                period: self.scene.loop_params.period,
            },
            &capabilities,
            &end,
            &answers,
            &account,
            recording.as_ref(),
        )
        .guarded(guarding.report(arguments.is_guarded(), &capabilities));
        (self.model)(&report)?;
        let asked = Asked {
            duration: self.arguments.duration,
            // A recorded motion ends by itself.
            device_may_end: self.arguments.device.kind() == DeviceName::Replay,
            lost: "the device was lost before the end; `palpate run --reconnect` waits for one that \
                   can be opened again",
        };
        outcome::with_motion(
            outcome::of(&end, &asked, &account, unwritten, recording.as_ref()),
            replayed::whole_or_said(&self.arguments.device),
        )
    }
}

/// Returns watchdog processes for a loop of `period` `[s]`; their timeout is that of its supervisor.
pub fn guarding(arguments: &SafetyArguments, period: f64) -> Result<Guarding, Failure> {
    let limits = limits(&Capabilities::unknown("any", 1), arguments);
    let period = duration("--period", period)?;
    Ok(Guarding::new(limits.stall_after(period)))
}

/// Returns the limits of a device, overridden by flags.
pub fn limits(device: &Capabilities, arguments: &SafetyArguments) -> SafetyParams {
    let mut limits = SafetyParams::for_device(device);
    let set = |limit: &mut f64, flag: Option<f64>| *limit = flag.unwrap_or(*limit);
    set(&mut limits.largest_force, arguments.safe_force);
    set(&mut limits.slew_limit, arguments.safe_slew);
    set(&mut limits.largest_speed, arguments.safe_speed);
    set(&mut limits.soft_start, arguments.soft_start);
    set(&mut limits.oscillation.energy, arguments.oscillation);
    set(
        &mut limits.stall_after_periods,
        arguments.stall_after_periods,
    );
    if arguments.stall_after_periods.is_some() {
        // Exactly this number of periods.
        limits.tolerated_lateness = 0.0;
    }
    limits.range = arguments.safe_range.map(|(from, to)| [from, to]);
    limits
}
