//! Calibration of a device that this program opens itself: a loop like that of `run`, with the safety
//! layer, a supervisor and a guardian between the excitation and the motor.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

use palpate::AlongAxis;
use palpate_calibrate::{ExcitationParams, Phase};
use palpate_device::clock::{Clock, MonotonicClock, SteppedClock};
use palpate_device::{Device, DeviceErrorKind, Vector, Wrench};
use palpate_rt::StopFlag;
use palpate_rt::realtime::Request;
use palpate_rt::safety::{
    Heartbeat, OscillationParams, Rendered, Safety, SafetyParams, Supervisor, Trip,
};
use palpate_scene::{Scene, SceneFile};

use super::CalibrateArguments;
use super::motion::Motion;
use crate::commands::run::request;
use crate::commands::simulate::read_scene;
use crate::devices::guarding::Guarding;
use crate::devices::{Opened, open};
use crate::failure::{Failure, tell};
use crate::values::duration;

/// Part of the samples that may be missing.
const MOST_MISSING: f64 = 0.02;

/// The device and the hand of `--device simulated` where no scene says others.
const SCENE: &str = r#"
scene_format = 1
title = "A device in a hand"

[object]
mass_kg = inf
stiffness_n_per_m = 1000
position_m = 1

[device]
kind = "point-mass"
mass_kg = 0.25
encoder_quantum_m = 1e-5

[hand]
kind = "constant-force"
force_n = 0

[loop]
period_s = 0.001

[measure]
duration_s = 1
"#;

/// Excites the device that the arguments name, until the excitation is complete.
///
/// # Errors
/// The device cannot be opened or is lost, safety or the excitation stopped it, or a signal came.
pub fn excite(arguments: &CalibrateArguments, params: ExcitationParams) -> Result<Motion, Failure> {
    let mut scene = match &arguments.scene {
        Some(path) => read_scene(path)?.scene,
        None => {
            SceneFile::parse("the built-in scene", SCENE)
                .map_err(Failure::inputs)?
                .scene
        }
    };
    scene.loop_params.period = params.period;
    if arguments.fast {
        on(
            arguments,
            params,
            &scene,
            &SteppedClock::new(),
            Request::nothing(),
        )
    } else {
        let spin = duration("--spin", arguments.realtime.spin)?;
        let clock = MonotonicClock::new().with_spin(spin);
        on(
            arguments,
            params,
            &scene,
            &clock,
            request(&arguments.realtime),
        )
    }
}

fn on<C: Clock>(
    arguments: &CalibrateArguments,
    params: ExcitationParams,
    scene: &Scene,
    clock: &C,
    request: Request,
) -> Result<Motion, Failure> {
    let period = duration("--period", params.period)?;
    let stall_limit = SafetyParams::default().stall_after(period);
    let guarding = Guarding::new(stall_limit);
    let Opened { mut device, axis } = open(&arguments.device, scene, clock, &guarding)?;
    let limits = SafetyParams::for_device(device.capabilities());
    let limits = SafetyParams {
        largest_force: params.largest_force.min(limits.largest_force),
        // Nothing is rendered that could create energy.
        oscillation: OscillationParams {
            energy: f64::INFINITY,
            ..limits.oscillation
        },
        ..limits
    };
    let wrong = |error: &dyn std::fmt::Display| Failure::Arguments(error.to_string());
    let heartbeat = Arc::new(Heartbeat::default());
    let watched = Watched::start(device.as_mut(), &heartbeat, clock, &request, stall_limit)?;
    let shaker = Shaker {
        device,
        axis,
        clock: clock.clone(),
        period,
        safety: Safety::new(limits, params.period).map_err(|error| wrong(&error))?,
        heartbeat,
        stall_limit,
        motion: Motion::new(params).map_err(|error| wrong(&error))?,
        start: None,
        reach: 2.0 * params.excursion,
        last: None,
        cuts: 0,
    };
    let stop =
        StopFlag::on_signals().map_err(|error| Failure::System(format!("no signals: {error}")))?;
    let thread = Builder::new()
        .name("palpate calibrate".to_owned())
        .spawn(move || {
            for answer in request.ask().iter().filter(|answer| !answer.is_granted()) {
                tell(format_args!("warning: {answer}"));
            }
            shaker.run(&stop)
        })
        .map_err(|error| Failure::System(format!("no thread for the loop: {error}")))?;
    let ended = thread
        .join()
        .map_err(|_| Failure::System("the loop ended for a fault of the program".into()));
    watched.end();
    let mut motion = ended??;
    let missed = motion.missed();
    if missed as f64 > MOST_MISSING * motion.length() as f64 {
        return Err(Failure::Declined(format!(
            "no calibration: {missed} of {} samples are missing, for deadlines that were missed or for a \
             device that had nothing new; a longer --period, or a --priority that the machine grants, helps",
            motion.length()
        )));
    }
    motion.fill();
    Ok(motion)
}

/// A supervisor on a thread of its own, where the device has a second way to command no force.
struct Watched {
    ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Watched {
    fn start<C: Clock>(
        device: &mut dyn Device,
        heartbeat: &Arc<Heartbeat>,
        clock: &C,
        request: &Request,
        stall_limit: Duration,
    ) -> Result<Self, Failure> {
        let ended = Arc::new(AtomicBool::new(false));
        // On a clock that only sleepers move, nobody is late.
        let zero = device.zero_writer().filter(|_| C::RUNS);
        let start = |zero| {
            let supervisor = Supervisor::new(Arc::clone(heartbeat), zero, stall_limit);
            let request = Request {
                priority: request.priority.map(|priority| (priority + 1).min(99)),
                ..*request
            };
            let (clock, ended) = (clock.clone(), Arc::clone(&ended));
            Builder::new()
                .name("palpate supervisor".to_owned())
                .spawn(move || {
                    // What is refused here is refused to the loop, which says so.
                    let _ = request.ask();
                    supervisor.watch(&clock, stall_limit / 4, &ended);
                })
                .map_err(|error| Failure::System(format!("no thread for the supervisor: {error}")))
        };
        let thread = zero.map(start).transpose()?;
        Ok(Self { ended, thread })
    }

    fn end(self) {
        self.ended.store(true, Ordering::Release);
        if let Some(thread) = self.thread {
            let _ = thread.join();
        }
    }
}

/// The loop: sleep, sample, ask the excitation, pass through safety, command.
struct Shaker<C> {
    device: Box<dyn Device>,
    axis: AlongAxis<f64, 3>,
    clock: C,
    period: Duration,
    safety: Safety,
    heartbeat: Arc<Heartbeat>,
    stall_limit: Duration,
    motion: Motion,
    /// Where the device was at first `[m]`.
    start: Option<Vector>,
    /// How far it may go from there in any direction `[m]`.
    reach: f64,
    /// Time of the last sample.
    last: Option<Duration>,
    cuts: u64,
}

impl<C: Clock> Shaker<C> {
    fn run(mut self, stop: &StopFlag) -> Result<Motion, Failure> {
        let ended = self.until_done(stop);
        // A device that does not take it is asked again once; more cannot be done here.
        if self.device.write(Wrench::NONE).is_err() {
            let _ = self.device.write(Wrench::NONE);
        }
        self.heartbeat.end();
        ended.map(|()| self.motion)
    }

    fn until_done(&mut self, stop: &StopFlag) -> Result<(), Failure> {
        let mut deadline = self.clock.now();
        loop {
            match self.motion.phase() {
                Phase::Running => {}
                Phase::Done => return Ok(()),
                Phase::Stopped(why) => return Err(Failure::Declined(format!("stopped: {why}"))),
            }
            if stop.is_raised() {
                return Err(Failure::Interrupted(
                    "stopped by a signal before the end: no calibration, and no force".into(),
                ));
            }
            self.clock.sleep_until(deadline);
            let woke = self.clock.now();
            self.heartbeat.beat(woke);
            self.tick(woke)?;
            deadline += self.period;
            let now = self.clock.now();
            while now > deadline && self.motion.phase() == Phase::Running {
                deadline += self.period;
                self.motion.miss();
            }
        }
    }

    fn tick(&mut self, woke: Duration) -> Result<(), Failure> {
        let read = self.device.read();
        let late = self.clock.now().saturating_sub(woke) > self.stall_limit;
        let cuts = self.heartbeat.cuts();
        let stalled = late || cuts != self.cuts || self.device.was_cut();
        self.cuts = cuts;
        let pose = match read {
            Ok(pose) if self.last.is_none_or(|last| pose.time > last) => Some(pose),
            Ok(_) => None,
            Err(error) if error.kind == DeviceErrorKind::NothingNew => None,
            Err(error) => return Err(Failure::System(format!("the device: {error}"))),
        };
        let Some(pose) = pose else {
            self.motion.miss();
            let verdict = self.safety.missing();
            return self.command(verdict.wrench);
        };
        let elapsed = self.last.map(|last| (pose.time - last).as_secs_f64());
        self.last = Some(pose.time);
        let start = *self.start.get_or_insert(pose.position);
        let away = distance(pose.position, start);
        if away > self.reach {
            return Err(Failure::Declined(format!(
                "stopped: the device is {:.1} mm from where it started, across the axis that is \
                 calibrated: guide it along the axis",
                away * 1e3
            )));
        }
        let coordinate = self.axis.coordinate(pose.position);
        let force = self.motion.take(Some(pose.time.as_secs_f64()), coordinate);
        let verdict = self.safety.judge(&Rendered {
            elapsed,
            position: pose.position,
            coordinate,
            wrench: Wrench::of_force(self.axis.vector(force)),
            created_energy: 0.0,
            refused: false,
            stalled,
        });
        if stalled {
            self.motion.lose_last();
        }
        let passing = [Trip::StaleSample, Trip::Stalled];
        if let Some(trip) = verdict.tripped.filter(|trip| !passing.contains(trip)) {
            return Err(Failure::Declined(format!(
                "stopped: safety took the force off ({})",
                trip.name()
            )));
        }
        self.command(verdict.wrench)
    }

    /// Commands a wrench, and notes what the device says that it holds.
    fn command(&mut self, wrench: Wrench) -> Result<(), Failure> {
        let sent = self
            .device
            .write(wrench)
            .map_err(|error| Failure::System(format!("the device: {error}")))?;
        let along = self.axis.vector(1.0);
        let force = (0..3).map(|i| sent.force[i] * along[i]).sum();
        self.motion.really_sent(force);
        Ok(())
    }
}

fn distance(a: Vector, b: Vector) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}
