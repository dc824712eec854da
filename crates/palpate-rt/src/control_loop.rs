//! The control loop: sleep, sample, render, limit, command, record.

#[path = "tick_phases.rs"]
mod tick_phases;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use palpate_core::{AlongAxis, Hold};
use palpate_record::recording::{DeviceTick, Row, Tick};

use tick_phases::TickTimes;

use crate::deadlines::Deadlines;
use crate::driven::Devices;
use crate::lateness_watch::LatenessWatch;
use crate::motors_off::MotorsOff;
use crate::note::{Ending, Note};
use crate::rendering::{
    Answer, DeviceSamples, OneContact, Parameters, RenderedWorld, Rendering, Renders,
};
use crate::safety::{Heartbeat, Rendered, Safety, SafetyParams, SafetyStop, Supervisor};
use crate::setup::{SetupError, can_turn};
use crate::statistics::LoopStatistics;
use crate::stop::StopFlag;
use crate::tap::{Tap, Teller};
use crate::wire::posed;
use palpate_device::clock::Clock;
use palpate_device::{Device, Wrench};

/// A haptic loop on one or several devices that renders `R`: one contact, or a world. All memory is allocated before
/// the first tick. A tick does not allocate or lock, and waits only for the clock and the devices.
///
/// If one of several devices has no force, no device has one. When the loop is dropped for any reason, it commands
/// zero force on each device.
pub struct ControlLoop<D: Device, C: Clock, R: Renders = OneContact> {
    devices: Devices<D>,
    clock: C,
    rendered: R,
    rearm: Arc<AtomicBool>,
    deadlines: Option<Deadlines>,
    period: Duration,
    /// Maximum time between ticks before a supervisor or a watchdog process removes the force.
    stall_limit: Duration,
    /// Whether a safety stop kept the motors off at the end of the last tick.
    is_off: bool,
    motors_off: MotorsOff,
    /// Sampling time of the last rendered sample.
    rendered_at: Option<Duration>,
    heartbeat: Arc<Heartbeat>,
    cuts: u64,
    statistics: LoopStatistics,
    lateness: LatenessWatch,
    teller: Teller,
    lost: bool,
    /// Start of the last tick.
    ticked: Option<Duration>,
    /// The method to which generated energy is attributed now, and the earlier method that recently generated the
    /// most.
    method: &'static str,
    method_before: &'static str,
}

/// Longest period. It bounds the time that ending a loop takes.
const LONGEST_PERIOD: Duration = Duration::from_secs(10);

impl<D: Device, C: Clock> ControlLoop<D, C> {
    /// Creates a loop that renders `rendering` on `device`, along its first axis. It starts at the first call of
    /// [`tick`](Self::tick).
    ///
    /// # Errors
    /// A rendering parameter or a safety limit outside its range; a period below a nanosecond or above 10 s.
    pub fn new(
        device: D,
        clock: C,
        rendering: Rendering,
        limits: SafetyParams,
    ) -> Result<Self, SetupError> {
        Self::rendering(vec![(device, limits)], clock, OneContact::new(rendering)?)
    }

    /// Sets the axis of the contact in the device's frame.
    #[must_use]
    pub fn along(mut self, axis: AlongAxis<f64, 3>) -> Self {
        self.rendered.place_along(axis);
        self
    }
}

impl<D: Device, C: Clock> ControlLoop<D, C, RenderedWorld> {
    /// Creates a loop that renders a world on `device`. It starts at the first call of [`tick`](Self::tick).
    ///
    /// # Errors
    /// A world of several devices; a safety limit outside its range; a period below a nanosecond or above 10 s; a
    /// rotating tool on a device that measures no orientation; a tool with a torque on a device without a torque
    /// about three axes.
    pub fn of_world(
        device: D,
        clock: C,
        world: RenderedWorld,
        limits: SafetyParams,
    ) -> Result<Self, SetupError> {
        Self::of_devices(vec![(device, limits)], clock, world)
    }

    /// Creates a loop that renders a world on several devices, each with its own limits: one for each tool of the
    /// world, in their order. Devices of different kinds are boxed: `D` is `Box<dyn Device>`.
    ///
    /// In each tick the loop reads all devices, one after the other, then advances the world by one step and commands
    /// all devices. The world's time is that of the newest sample. If one device has no valid sample, rejects its
    /// force, is cut or exceeds its limits, no device has a force, and an event names that device.
    ///
    /// # Errors
    /// A number of devices that differs from the number of tools; those of [`of_world`](Self::of_world).
    pub fn of_devices(
        devices: Vec<(D, SafetyParams)>,
        clock: C,
        world: RenderedWorld,
    ) -> Result<Self, SetupError> {
        can_turn(&world, devices.iter().map(|(device, _)| device))?;
        Self::rendering(devices, clock, world)
    }
}

impl<D: Device, C: Clock, R: Renders> ControlLoop<D, C, R> {
    pub(crate) fn rendering(
        devices: Vec<(D, SafetyParams)>,
        clock: C,
        rendered: R,
    ) -> Result<Self, SetupError> {
        let seconds = rendered.period();
        let period = Duration::try_from_secs_f64(seconds)
            .ok()
            .filter(|period| *period > Duration::ZERO && *period <= LONGEST_PERIOD)
            .ok_or(SetupError::Period(seconds))?;
        let wrong = SetupError::Devices {
            world: rendered.devices(),
            given: devices.len(),
        };
        if devices.len() != rendered.devices() {
            return Err(wrong);
        }
        let mut held = devices.iter().map(|(device, _)| device.capabilities());
        if rendered.actuation().hold == Hold::Line && !held.all(|held| held.holds_lines) {
            return Err(SetupError::HoldsConstant);
        }
        // The shortest limit of all devices applies.
        let stall_limits = devices.iter().map(|(_, limits)| limits.stall_after(period));
        let stall_limit = stall_limits.min().ok_or(wrong)?;
        let devices = devices.into_iter().map(|(device, limits)| {
            let safety = Safety::new(limits, seconds)?
                .rendering(&rendered.actuation(), rendered.slew_limit());
            Ok::<_, SetupError>((device, safety))
        });
        let devices = devices.collect::<Result<Vec<_>, _>>()?;
        let method = rendered.method();
        Ok(Self {
            devices: Devices::new(devices).ok_or(wrong)?,
            clock,
            rendered,
            rearm: Arc::default(),
            deadlines: None,
            period,
            stall_limit,
            is_off: false,
            motors_off: MotorsOff::default(),
            rendered_at: None,
            heartbeat: Arc::default(),
            cuts: 0,
            statistics: LoopStatistics::new(),
            lateness: LatenessWatch::default(),
            teller: Teller::default(),
            lost: false,
            ticked: None,
            method,
            method_before: method,
        })
    }

    /// Connects `tap`, which receives ticks and events.
    #[must_use]
    pub fn tapped(mut self, tap: Tap) -> Self {
        if self.devices.iter().nth(1).is_some() {
            let names = (0..self.rendered.devices()).map(|device| {
                let name = self.rendered.device_name(device);
                name.map_or_else(|| (device + 1).to_string(), str::to_owned)
            });
            tap.name_devices(names.collect());
        }
        self.teller.tap = Some(tap);
        self
    }

    /// Returns the other end of the parameters. Only the first call returns it.
    pub fn parameters(&mut self) -> Option<Parameters> {
        self.rendered.parameters()
    }

    /// Returns the rendering.
    pub fn rendered(&self) -> &R {
        &self.rendered
    }

    /// Returns a flag that, once set, ends a latched safety stop at the next tick.
    pub fn rearm(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.rearm)
    }

    pub(crate) fn heartbeat(&self) -> Arc<Heartbeat> {
        Arc::clone(&self.heartbeat)
    }

    /// Returns a supervisor for another thread, or `None` if no device has a zero writer. It supervises the loop for
    /// all devices that have one.
    pub fn supervisor(&mut self) -> Option<Supervisor> {
        let zero = self.devices.zero_writer()?;
        let heartbeat = Arc::clone(&self.heartbeat);
        Some(Supervisor::new(heartbeat, zero, self.stall_limit))
    }

    pub(crate) fn clock(&self) -> C {
        self.clock.clone()
    }

    /// Returns the period of the deadlines.
    pub fn period(&self) -> Duration {
        self.period
    }

    /// Returns the device, or the first of several.
    pub fn device(&self) -> &D {
        self.devices.first_device()
    }

    /// Returns all devices in their order.
    pub fn devices(&self) -> impl Iterator<Item = &D> {
        self.devices.iter().map(|driven| &driven.device)
    }

    /// Returns the recorded data of each device at the last tick. It is empty for a single device, whose data are in
    /// the tick.
    pub fn device_ticks(&self) -> &[DeviceTick] {
        self.devices.ticks()
    }

    /// Returns the timing statistics of the loop.
    pub fn statistics(&self) -> &LoopStatistics {
        &self.statistics
    }

    /// Returns how often a supervisor has commanded zero force.
    pub fn cuts(&self) -> u64 {
        self.heartbeat.cuts()
    }

    /// Returns the safety stop that holds the forces at 0, if any; of several stops, a latched one.
    pub fn safety_stop(&self) -> Option<SafetyStop> {
        self.stopped_device().map(|(_, safety_stop)| safety_stop)
    }

    /// Returns the same stop with the index of the stopped device.
    pub fn stopped_device(&self) -> Option<(usize, SafetyStop)> {
        self.devices.safety_stop()
    }

    /// Ticks until `stop` is raised, `most` periods are over or the device is gone, then commands zero force. The
    /// loop can be continued afterwards. A missed deadline counts as a period, so the duration of a run does not
    /// depend on the load of the machine.
    pub fn run(&mut self, stop: &StopFlag, most: Option<u64>) -> Ending {
        let ending = loop {
            if stop.is_raised() {
                break Ending::Stopped;
            }
            if most.is_some_and(|most| self.statistics.periods() >= most) {
                break Ending::Complete;
            }
            self.tick();
            if self.lost {
                break Ending::DeviceLost;
            }
        };
        self.disable_output();
        ending
    }

    /// Commands zero force through the zero writers of the devices, after the devices themselves failed.
    pub(crate) fn cut_off(&mut self) {
        self.heartbeat.end();
        self.devices.cut_off();
    }

    /// Sends the ending to the tap and closes it.
    pub(crate) fn close_tap(&mut self, ending: Ending) {
        // The ending belongs to the last tick: the next one does not exist.
        if let Some(last) = self.teller.sequence.checked_sub(1) {
            self.teller.sequence = last;
            self.note(Note::Ended(ending));
        }
        if let Some(tap) = self.teller.tap.take() {
            tap.end(ending);
        }
    }

    /// Commands zero force on each device and deactivates the supervisor.
    pub fn disable_output(&mut self) {
        self.devices.disable_output(&self.clock);
        self.motors_off.disable_output();
        self.heartbeat.end();
    }

    /// Performs one period: sleeps until its deadline, then samples, renders and commands.
    pub fn tick(&mut self) -> Row {
        let deadline = self.deadline();
        self.clock.sleep_until(deadline);
        self.tick_now(deadline)
    }

    /// Performs one period now, on the thread of another scheduler, unless the loop has ended: then commands zero force.
    /// The next deadline is a period after this tick.
    pub(crate) fn tick_unless(
        &mut self,
        stop: &StopFlag,
        most: Option<u64>,
    ) -> Result<Row, Ending> {
        let ending = if stop.is_raised() {
            Some(Ending::Stopped)
        } else if most.is_some_and(|most| self.statistics.periods() >= most) {
            Some(Ending::Complete)
        } else {
            self.lost.then_some(Ending::DeviceLost)
        };
        if let Some(ending) = ending {
            self.disable_output();
            return Err(ending);
        }
        let deadline = self.deadline();
        let row = self.tick_now(deadline);
        let next = self.ticked.unwrap_or(deadline).saturating_add(self.period);
        self.deadlines = Some(Deadlines::new(self.period, next));
        Ok(row)
    }

    /// Samples, renders and commands.
    fn tick_now(&mut self, deadline: Duration) -> Row {
        let woke = self.clock.now();
        let before = self.ticked.replace(woke);
        let was_cut = self.supervisor_cut();
        self.heartbeat.beat(woke);
        self.take_changes();

        let answered = self.sample(woke);
        let stalled = self.detect_stall(before, woke, answered, was_cut);
        let step = self.render_or_wait(stalled);
        self.report_stops(woke);
        self.count_refusals(&step);
        // Only now: the interval that this sample ended belongs to the previous method.
        self.follow_method();
        self.command();

        let ended = self.clock.now();
        let times = TickTimes {
            deadline,
            woke,
            answered,
            ended,
        };
        let missed = self.end_period(&times);
        let tick = self.tick_data(&times, &step, missed);
        self.devices
            .take_down(self.teller.sequence, self.teller.started);
        self.count_tick(&times, missed);
        self.pass_on(tick)
    }

    /// Accepts rearming, a changed rendering and another world.
    #[inline]
    fn take_changes(&mut self) {
        if self.rearm.swap(false, Ordering::AcqRel) && self.devices.rearm() {
            self.note(Note::Rearmed);
        }
        if let Some((generation, rendering)) = self.rendered.take_change() {
            self.follow_limits();
            self.note(Note::Changed {
                generation,
                rendering,
            });
        }
        if let Some(generation) = self.rendered.take_other_world() {
            self.note(Note::OtherWorld(generation, self.rendered.method()));
        }
    }

    /// Passes the modelled gain and the slew limit of a changed rendering to each safety.
    fn follow_limits(&mut self) {
        let (actuation, slew) = (self.rendered.actuation(), self.rendered.slew_limit());
        for driven in self.devices.iter_mut() {
            driven.safety.follow(&actuation, slew);
        }
    }

    /// Detects a change of the method that renders from this sample on.
    fn follow_method(&mut self) {
        let method = self.rendered.method();
        if method == self.method {
            return;
        }
        // After several changes, keep the method that generated the energy.
        if !self.devices.another_method() {
            self.method_before = self.method;
        }
        self.method = method;
    }

    fn deadline(&mut self) -> Duration {
        if let Some(deadlines) = &self.deadlines {
            return deadlines.next();
        }
        let started = self.clock.now();
        self.teller.started = started;
        self.deadlines = Some(Deadlines::new(self.period, started));
        started
    }

    /// Returns whether the supervisor has commanded zero force since the last call.
    fn supervisor_cut(&mut self) -> bool {
        let cuts = self.heartbeat.cuts();
        let was_cut = cuts != self.cuts;
        self.cuts = cuts;
        if was_cut {
            self.devices.were_cut_at(self.heartbeat.cut_at());
        }
        was_cut
    }

    /// Returns whether a watchdog process has commanded zero force since the last call. Its limit is that of a
    /// supervisor, and the loop has been silent since `since`.
    fn watchdog_cut(&mut self, since: Duration) -> bool {
        let at = since.saturating_add(self.stall_limit);
        self.devices.were_cut_by_watchdogs(at.min(self.clock.now()))
    }

    /// Records in the ledger which devices held no force and since when.
    fn record_cuts(&mut self) {
        if let Some(at) = self.devices.record_cuts() {
            self.motors_off.cut(at);
        }
    }

    /// Returns whether the loop woke so late that a running supervisor would have cut it.
    fn has_overslept(&self, before: Option<Duration>, woke: Duration) -> bool {
        let longest = self.period.saturating_add(self.stall_limit);
        before.is_some_and(|last| woke.saturating_sub(last) > longest)
    }

    /// Reads all devices, one after the other. Returns the time of the last answer.
    fn sample(&mut self, woke: Duration) -> Duration {
        let mut answered = woke;
        for driven in self.devices.iter_mut() {
            answered = driven.sample(&self.clock, answered, self.period, &mut self.teller);
            self.lost |= driven.is_lost;
        }
        answered
    }

    /// Returns the time since the last rendered sample `[s]`, if all devices have a fresh sample.
    fn elapsed(&mut self) -> Option<f64> {
        let now = self.devices.sampled_at()?;
        let before = self.rendered_at.replace(now)?;
        Some(now.saturating_sub(before).as_secs_f64())
    }

    /// Renders a fresh sample of all devices and limits the result by the safety of each.
    fn render(&mut self, elapsed: Option<f64>, stalled: bool) -> Answer {
        let (devices, asked) = self.devices.samples();
        let held_none = devices
            .iter()
            .all(|device| device.held == Some(Wrench::NONE));
        let sample = DeviceSamples {
            elapsed,
            was_off: self.is_off && held_none,
            devices,
        };
        let answer = self.rendered.step(&sample, asked);
        self.devices.evaluate(&Rendered {
            elapsed,
            position: [0.0; 3],
            coordinate: answer.coordinate,
            wrench: Wrench::NONE,
            slope: [0.0; 3],
            created_energy: self.rendered.created_energy(),
            refused: answer.fault.is_some(),
            stalled,
        });
        answer
    }

    /// Commands the wrenches and reports the delivered ones to the renderer.
    fn command(&mut self) {
        self.lost |= self
            .devices
            .command(&self.clock, self.period, &mut self.teller);
        for (number, driven) in self.devices.iter().enumerate() {
            self.rendered
                .report_written(number, driven.delivered, driven.sent);
        }
    }

    /// Returns the data of the first device at the last sample.
    fn seen(&self, woke: Duration) -> Tick {
        let time = self.devices.sampled_at().unwrap_or(woke);
        let pose = self.devices.first_pose();
        Tick {
            sequence: self.teller.sequence,
            time: time.saturating_sub(self.teller.started).as_secs_f64(),
            generation: self.rendered.generation(),
            ..pose.map_or(Tick::UNKNOWN, |(pose, axes)| posed(pose, axes))
        }
    }

    /// Reports the safety stops that have begun or ended. Stops of the whole loop are reported once.
    fn send_safety_stops(&mut self) {
        let mut is_first = true;
        for driven in self.devices.iter_mut() {
            let is_told = |safety_stop: &SafetyStop| is_first || !safety_stop.is_of_the_loop();
            let of =
                |safety_stop: SafetyStop| driven.number.filter(|_| !safety_stop.is_of_the_loop());
            if let Some(safety_stop) = driven.verdict.recovered.take().filter(is_told) {
                let now = self.clock.now();
                self.teller
                    .note(now, of(safety_stop), Note::Recovered(safety_stop));
            }
            if let Some(safety_stop) = driven.verdict.stopped.take().filter(is_told) {
                let note = match safety_stop {
                    SafetyStop::Oscillation => Note::Oscillated {
                        method: if driven.safety.oscillation_is_from_before() {
                            self.method_before
                        } else {
                            self.method
                        },
                        renders_now: self.rendered.method(),
                    },
                    other => Note::Stopped(other),
                };
                self.teller.note(self.clock.now(), of(safety_stop), note);
            }
            is_first = false;
        }
    }

    fn note(&mut self, note: Note) {
        self.teller.note(self.clock.now(), None, note);
    }
}

impl<D: Device, C: Clock, R: Renders> Drop for ControlLoop<D, C, R> {
    fn drop(&mut self) {
        // A driver panic that escapes `drop` can abort the process. Catch it, then disable the outputs through the
        // zero writers.
        if catch_unwind(AssertUnwindSafe(|| self.disable_output())).is_err() {
            let _ = catch_unwind(AssertUnwindSafe(|| self.cut_off()));
        }
    }
}
