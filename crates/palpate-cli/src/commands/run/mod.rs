//! `palpate run` and `palpate record`: a loop in real time, on a device.

mod arguments;
pub mod outcome;
mod receipt;
pub mod report;
pub mod scene_text;

use std::path::Path;
use std::time::Duration;

use palpate_device::clock::{Clock, MonotonicClock, SteppedClock};
use palpate_device::{Capabilities, Device};
use palpate_rt::realtime::Request;
use palpate_rt::safety::SafetyParams;
use palpate_rt::{ControlLoop, LoopThread, Recorder, SetupError, StopFlag};
use palpate_scene::method::MethodName;
use palpate_scene::{Scene, SceneFile, Timing};

pub use arguments::{
    RealtimeArguments, RecordArguments, RunArguments, SafetyArguments, SessionArguments,
};
pub use outcome::Asked;
pub use receipt::receipt;
pub use report::Report;
pub use report::TimingReport;

use crate::devices::guarding::Guarding;
use crate::devices::{DeviceName, Opened, open, replayed};
use crate::failure::{Failure, tell};
use crate::progress::Progress;
use crate::recorded::open as open_recording;
use crate::results::print_report;
use crate::values::duration;

/// Runs a loop, and records it if it is to.
pub fn run(arguments: &RunArguments) -> Result<(), Failure> {
    session(
        &arguments.scene,
        arguments.record.as_deref(),
        &arguments.session,
    )
}

/// Runs a loop and records it.
pub fn record(arguments: &RecordArguments) -> Result<(), Failure> {
    session(
        &arguments.scene,
        Some(&arguments.record),
        &arguments.session,
    )
}

fn session(
    path: &Path,
    record: Option<&Path>,
    arguments: &SessionArguments,
) -> Result<(), Failure> {
    let file = super::simulate::read_scene(path)?;
    run_session(&file, (path, record), arguments, &|report| {
        print_report(report, arguments.json)
    })
}

/// Runs a loop on the scene of `file`, which is at `path`, and records it if it is to. What there is to say of
/// a loop that ran goes to `told`.
///
/// # Errors
/// The loop could not begin, or it did not do what it was asked to.
pub fn run_session(
    file: &SceneFile,
    (path, record): (&Path, Option<&Path>),
    arguments: &SessionArguments,
    told: Told<'_>,
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
    tell_what_a_loop_has_not(&scene);
    let session = Session {
        scene: &scene,
        path,
        record,
        arguments,
        method,
        told,
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

/// Says what of a scene's loop a loop in real time has not.
pub fn tell_what_a_loop_has_not(scene: &Scene) {
    let simulated_only = Timing {
        delay_seconds: 0.0,
        ..scene.timing.clone()
    };
    if simulated_only != Timing::default() {
        tell(
            "warning: the scene's jitter, drops and fractions of a delay are for the simulator; this loop has its own",
        );
    }
}

/// What the machine is asked for.
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
    told: Told<'a>,
}

/// Who is told what a loop did.
type Told<'a> = &'a dyn Fn(&Report) -> Result<(), Failure>;

impl Session<'_> {
    fn on<C: Clock>(&self, clock: &C, request: Request) -> Result<(), Failure> {
        let guarding = guarding(&self.arguments.safety, self.scene)?;
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
        let most = self.most_periods(control.period())?;
        let (tap, recorder) = match self.record {
            Some(out) => {
                let receipt = receipt(&capabilities, &limits, &request);
                let receipt = scene_text::put(receipt, self.scene, self.path)?;
                Recorder::begin(out, &receipt)
                    .map_err(|error| Failure::System(error.to_string()))?
            }
            None => Recorder::without_file()
                .map_err(|error| Failure::System(format!("no thread to listen: {error}")))?,
        };
        // Nobody waits for a loop that runs as fast as it can.
        let tap = if C::RUNS { tap } else { tap.waiting() };
        let stop = StopFlag::on_signals()
            .map_err(|error| Failure::System(format!("no signals: {error}")))?;
        let progress = Progress::new(1);
        progress.begin("running; ctrl-C ends it");
        let running = LoopThread::start(control.tapped(tap), request, &stop, most)
            .map_err(|error| Failure::System(format!("no thread for the loop: {error}")))?;
        let refused = running
            .answers()
            .iter()
            .filter(|answer| !answer.is_granted());
        for answer in refused {
            tell(format_args!("warning: {answer}"));
        }
        let answers = running.answers().to_vec();
        tell_of_losses(&running, &recorder, &guarding);
        let end = running.join();
        // What the run was is told whether or not it could be written.
        let (account, unwritten) = recorder.finish();
        let unwritten = unwritten.map(|error| Failure::System(error.to_string()));
        drop(progress);
        let recording = match (&unwritten, self.record) {
            (None, Some(path)) => Some(open_recording(path)?),
            _ => None,
        };
        let report = Report::new(
            self.scene,
            self.method,
            &capabilities,
            &end,
            &answers,
            &account,
            recording.as_ref(),
        )
        .guarded(guarding.report(arguments, &capabilities));
        (self.told)(&report)?;
        let asked = Asked {
            duration: self.arguments.duration,
            // A recorded motion is over when it is over.
            device_may_end: self.arguments.device.device == DeviceName::Replay,
            lost: "the device was lost before the end; `palpate run --reconnect` waits for one that \
                   can be opened again",
        };
        outcome::with_motion(
            outcome::of(&end, &asked, unwritten, recording.as_ref()),
            replayed::whole_or_said(&self.arguments.device),
        )
    }

    fn most_periods(&self, period: Duration) -> Result<Option<u64>, Failure> {
        let seconds = self.arguments.duration;
        if seconds == f64::INFINITY {
            return Ok(None);
        }
        let periods = duration("--duration", seconds)?
            .as_nanos()
            .div_ceil(period.as_nanos());
        Ok(Some(u64::try_from(periods).unwrap_or(u64::MAX)))
    }
}

/// How often it is looked whether the loop has ended, or can no longer be written down.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// Waits for the end of the loop. A recording that cannot be written and a guardian that is lost are told
/// at once: the rest of a session would be for nothing, and nobody would know.
fn tell_of_losses<D: Device, C: Clock>(
    running: &LoopThread<D, C>,
    recorder: &Recorder,
    guarding: &Guarding,
) {
    let mut is_told = false;
    let mut is_guardian_told = false;
    while !running.has_ended() {
        if let Some((_, lost)) = guarding.lost().filter(|_| !is_guardian_told) {
            is_guardian_told = true;
            tell(format_args!(
                "warning: {lost}; the loop commands no force until the device is opened anew"
            ));
        }
        if let Some(why) = recorder.failure().filter(|_| !is_told) {
            is_told = true;
            tell(format_args!(
                "warning: {why}; the loop goes on, and is not recorded any more"
            ));
        }
        std::thread::sleep(LOOK_EVERY);
    }
}

/// Guardians for a loop of `scene`: they wait for as long as its supervisor.
pub fn guarding(arguments: &SafetyArguments, scene: &Scene) -> Result<Guarding, Failure> {
    let limits = limits(&Capabilities::unknown("any", 1), arguments);
    let period = duration("--period", scene.loop_params.period)?;
    Ok(Guarding::new(limits.stall_after(period)))
}

/// The limits of a device, as far as flags do not say otherwise.
pub fn limits(device: &Capabilities, arguments: &SafetyArguments) -> SafetyParams {
    let mut limits = SafetyParams::for_device(device);
    let set = |limit: &mut f64, flag: Option<f64>| *limit = flag.unwrap_or(*limit);
    set(&mut limits.largest_force, arguments.safe_force);
    set(&mut limits.slew_limit, arguments.safe_slew);
    set(&mut limits.largest_speed, arguments.safe_speed);
    set(&mut limits.soft_start, arguments.soft_start);
    set(&mut limits.oscillation.energy, arguments.oscillation);
    set(&mut limits.stall_after_periods, arguments.stall_after);
    if arguments.stall_after.is_some() {
        // These periods, and nothing else.
        limits.tolerated_lateness = 0.0;
    }
    limits.range = arguments.safe_range.map(|(from, to)| [from, to]);
    limits
}
