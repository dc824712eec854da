//! The loop that shakes a device: the excitation, and the safety layer between it and the motor.

use std::sync::Arc;
use std::time::Duration;

use palpate::AlongAxis;
use palpate_calibrate::{ExcitationError, ExcitationParams, Phase, Stop};
use palpate_device::clock::Clock;
use palpate_device::{Device, DeviceError, DeviceErrorKind, Pose, Vector, Wrench};
use palpate_rt::StopFlag;
use palpate_rt::safety::{
    Heartbeat, OscillationParams, Rendered, Safety, SafetyError, SafetyParams, Trip,
};
use palpate_study::calibration::ExcitedMotion;

use crate::settling::{PATIENCE, Settling};

/// Part of the samples that may be missing.
const MOST_MISSING: f64 = 0.02;

/// Why a device could not be excited to the end.
#[derive(Debug, thiserror::Error)]
pub enum ShakeError {
    /// A parameter of the excitation out of its range.
    #[error(transparent)]
    Params(#[from] ExcitationError),
    /// A limit out of its range.
    #[error(transparent)]
    Safety(#[from] SafetyError),
    /// The device cannot be read or written.
    #[error("the device: {0}")]
    Lost(DeviceError),
    /// Somebody ended it.
    #[error("stopped by a signal before the end: no calibration, and no force")]
    Signalled,
    /// It, or its hand, does not let anything be said of it.
    #[error(transparent)]
    Declined(#[from] ShakeDeclined),
}

/// Why an excitation says nothing of the device.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShakeDeclined {
    /// Too many samples are missing.
    #[error(
        "no calibration: {missed} of {length} samples are missing, for deadlines that were missed or \
         for a device that had nothing new; a longer --period, or a --priority that the machine \
         grants, helps"
    )]
    Missing {
        /// Samples that are missing.
        missed: usize,
        /// Samples of the whole.
        length: usize,
    },
    /// It did not come to rest.
    #[error(
        "no calibration: the device was never still for half a second within {:.0} s: it moved by \
         more than {:.2} mm, root mean square",
        within.as_secs_f64(),
        tremor * 1e3
    )]
    NeverStill {
        /// How long it was waited for.
        within: Duration,
        /// How far it might tremble, root mean square `[m]`.
        tremor: f64,
    },
    /// The excitation stopped.
    #[error("stopped: {0}")]
    Stopped(Stop),
    /// It went too far in another direction than the axis.
    #[error(
        "stopped: the device is {:.1} mm from where it started, across the axis that is \
         calibrated: guide it along the axis",
        away * 1e3
    )]
    Across {
        /// How far it is from its start `[m]`.
        away: f64,
    },
    /// Safety took the force off.
    #[error("stopped: safety took the force off ({})", .0.name())]
    Tripped(Trip),
}

/// The loop: sleep, sample, ask the excitation, pass through safety, command.
pub struct Shaker<C> {
    device: Box<dyn Device>,
    axis: AlongAxis<f64, 3>,
    clock: C,
    period: Duration,
    safety: Safety,
    heartbeat: Arc<Heartbeat>,
    stall_limit: Duration,
    motion: ExcitedMotion,
    /// How long the hand has to bring the device to its place; none: it is there.
    wait: Option<Duration>,
    /// How far a device that is still may tremble, root mean square `[m]`.
    tremor: f64,
    /// Where the device was at first `[m]`.
    start: Option<Vector>,
    /// How far it may go from there in any direction `[m]`.
    reach: f64,
    /// Time of the last sample.
    last: Option<Duration>,
    cuts: u64,
}

impl<C: Clock> Shaker<C> {
    /// A loop of `period`, which `params` say too, that has not begun, along an axis of a device that is open.
    ///
    /// # Errors
    /// A parameter of the excitation out of its range.
    pub fn new(
        (device, axis): (Box<dyn Device>, AlongAxis<f64, 3>),
        (clock, period): (C, Duration),
        params: ExcitationParams,
        heartbeat: Arc<Heartbeat>,
        stall_limit: Duration,
    ) -> Result<Self, ShakeError> {
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
        Ok(Self {
            device,
            axis,
            clock,
            period,
            safety: Safety::new(limits, params.period)?,
            heartbeat,
            stall_limit,
            motion: ExcitedMotion::new(params)?,
            wait: None,
            tremor: params.tremor,
            start: None,
            reach: 2.0 * params.excursion,
            last: None,
            cuts: 0,
        })
    }

    /// The same loop, but it begins when the device is still, and not before `wait` has passed.
    #[must_use]
    pub fn waiting(self, wait: Option<Duration>) -> Self {
        Self { wait, ..self }
    }

    /// Shakes the device until the excitation is complete; the motion, without gaps.
    ///
    /// # Errors
    /// The device is lost or does not come to rest, safety or the excitation stopped it, a signal came,
    /// or too many samples are missing.
    pub fn run(mut self, stop: &StopFlag) -> Result<ExcitedMotion, ShakeError> {
        let ended = self.until_still(stop).and_then(|()| self.until_done(stop));
        // A device that does not take it is asked again once; more cannot be done here.
        if self.device.write(Wrench::NONE).is_err() {
            let _ = self.device.write(Wrench::NONE);
        }
        self.heartbeat.end();
        ended?;
        let mut motion = self.motion;
        let missed = motion.missed();
        if missed as f64 > MOST_MISSING * motion.length() as f64 {
            let length = motion.length();
            return Err(ShakeDeclined::Missing { missed, length }.into());
        }
        motion.fill();
        Ok(motion)
    }

    /// Waits without force until the device is still.
    fn until_still(&mut self, stop: &StopFlag) -> Result<(), ShakeError> {
        let Some(wait) = self.wait else {
            return Ok(());
        };
        let mut settling = Settling::within(self.tremor);
        let begun = self.clock.now();
        let mut deadline = begun;
        while self.clock.now().saturating_sub(begun) < wait + PATIENCE {
            goes_on(stop)?;
            self.clock.sleep_until(deadline);
            self.heartbeat.beat(self.clock.now());
            if let Some(pose) = self.read()? {
                let is_still = settling.is_still_at(pose.time, pose.position);
                if is_still && self.clock.now().saturating_sub(begun) >= wait {
                    return Ok(());
                }
            }
            self.write(Wrench::NONE)?;
            deadline = (deadline + self.period).max(self.clock.now());
        }
        let (within, tremor) = (wait + PATIENCE, self.tremor);
        Err(ShakeDeclined::NeverStill { within, tremor }.into())
    }

    /// What the device says; nothing where it has nothing new.
    fn read(&mut self) -> Result<Option<Pose>, ShakeError> {
        match self.device.read() {
            Ok(pose) if self.last.is_none_or(|last| pose.time > last) => Ok(Some(pose)),
            Ok(_) => Ok(None),
            Err(error) if error.kind == DeviceErrorKind::NothingNew => Ok(None),
            Err(error) => Err(ShakeError::Lost(error)),
        }
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, ShakeError> {
        self.device.write(wrench).map_err(ShakeError::Lost)
    }

    fn until_done(&mut self, stop: &StopFlag) -> Result<(), ShakeError> {
        let mut deadline = self.clock.now();
        loop {
            match self.motion.phase() {
                Phase::Running => {}
                Phase::Done => return Ok(()),
                Phase::Stopped(why) => return Err(ShakeDeclined::Stopped(why).into()),
            }
            goes_on(stop)?;
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

    fn tick(&mut self, woke: Duration) -> Result<(), ShakeError> {
        let read = self.read();
        let late = self.clock.now().saturating_sub(woke) > self.stall_limit;
        let cuts = self.heartbeat.cuts();
        let stalled = late || cuts != self.cuts || self.device.was_cut();
        self.cuts = cuts;
        let Some(pose) = read? else {
            self.motion.miss();
            let verdict = self.safety.missing();
            return self.command(verdict.wrench);
        };
        let elapsed = self.last.map(|last| (pose.time - last).as_secs_f64());
        self.last = Some(pose.time);
        let start = *self.start.get_or_insert(pose.position);
        let away = distance(pose.position, start);
        if away > self.reach {
            return Err(ShakeDeclined::Across { away }.into());
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
            return Err(ShakeDeclined::Tripped(trip).into());
        }
        self.command(verdict.wrench)
    }

    /// Commands a wrench, and notes what the device says that it holds.
    fn command(&mut self, wrench: Wrench) -> Result<(), ShakeError> {
        let sent = self.write(wrench)?;
        let along = self.axis.vector(1.0);
        let force = (0..3).map(|i| sent.force[i] * along[i]).sum();
        self.motion.really_sent(force);
        Ok(())
    }
}

fn goes_on(stop: &StopFlag) -> Result<(), ShakeError> {
    if stop.is_raised() {
        return Err(ShakeError::Signalled);
    }
    Ok(())
}

fn distance(a: Vector, b: Vector) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}
