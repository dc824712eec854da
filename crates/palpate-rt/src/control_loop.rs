//! The loop itself: sleep, sample, render, pass through safety, command, note down.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use palpate::AlongAxis;
use palpate_record::recording::{ContactTick, Flags, Row, Tick};

use crate::deadlines::Deadlines;
use crate::held::HeldSince;
use crate::lateness_watch::LatenessWatch;
use crate::motors_off::MotorsOff;
use crate::note::{Ending, Note, Noted};
use crate::rendering::{Fresh, OneContact, Parameters, RenderedWorld, Rendering, Renders};
use crate::safety::{self, Heartbeat, Safety, SafetyParams, Supervisor, Trip, Verdict};
use crate::setup::SetupError;
use crate::statistics::LoopStatistics;
use crate::stop::StopFlag;
use crate::tap::Tap;
use crate::wire::posed;
use palpate_device::clock::Clock;
use palpate_device::{Device, DeviceError, DeviceErrorKind, Pose, Wrench};

/// A haptic loop on one device, which renders `R`: one contact, or a world. Everything that it needs is there before its first tick; a tick
/// allocates nothing, locks nothing and waits for nobody but the clock and the device.
///
/// When it goes, whatever the reason, it commands the device no force.
pub struct ControlLoop<D: Device, C: Clock, R: Renders = OneContact> {
    device: D,
    clock: C,
    rendered: R,
    safety: Safety,
    rearm: Arc<AtomicBool>,
    deadlines: Option<Deadlines>,
    started: Duration,
    period: Duration,
    /// How long the loop may stand still before a supervisor or a guardian takes the force off.
    stall_limit: Duration,
    held: HeldSince,
    /// Whether a trip kept the motors off at the end of the last tick.
    is_off: bool,
    motors_off: MotorsOff,
    last: Option<Pose>,
    heartbeat: Arc<Heartbeat>,
    cuts: u64,
    statistics: LoopStatistics,
    lateness: LatenessWatch,
    tap: Option<Tap>,
    sequence: u64,
    lost: bool,
    /// When the last tick began.
    ticked: Option<Duration>,
    /// The method whose energy is counted now, and the one before it that created the most of late.
    method: &'static str,
    method_before: &'static str,
}

/// Longest period: whoever ends a loop should not have to wait for longer.
const LONGEST_PERIOD: Duration = Duration::from_secs(10);

/// A sample whose time cannot be.
const AHEAD: DeviceError = DeviceError {
    kind: DeviceErrorKind::NothingNew,
    what: "the time stamp of a sample lies more than a period ahead of the loop's clock",
};

/// What a sample came to.
enum Sampled {
    Fresh(Pose),
    Missing,
    Gone(Trip),
}

impl<D: Device, C: Clock> ControlLoop<D, C> {
    /// A loop that renders `rendering` on `device`, along its first axis. It ticks from the first
    /// call of [`tick`](Self::tick) on.
    ///
    /// # Errors
    /// A parameter of the rendering or a limit of the safety outside its range; a period below a
    /// nanosecond or above 10 s.
    pub fn new(
        device: D,
        clock: C,
        rendering: Rendering,
        limits: SafetyParams,
    ) -> Result<Self, SetupError> {
        Self::rendering(device, clock, OneContact::new(rendering)?, limits)
    }

    /// The same loop, its contact's axis placed elsewhere in the device's space.
    #[must_use]
    pub fn along(mut self, axis: AlongAxis<f64, 3>) -> Self {
        self.rendered.place_along(axis);
        self
    }
}

impl<D: Device, C: Clock> ControlLoop<D, C, RenderedWorld> {
    /// A loop that renders a world on `device`. It ticks from the first call of [`tick`](Self::tick) on.
    ///
    /// # Errors
    /// A limit of the safety outside its range; a period below a nanosecond or above 10 s; a tool that turns, and a device
    /// that gives no torque about three axes.
    pub fn of_world(
        device: D,
        clock: C,
        world: RenderedWorld,
        limits: SafetyParams,
    ) -> Result<Self, SetupError> {
        if world.turns() && device.capabilities().torque_axes != 3 {
            return Err(SetupError::SixAxes);
        }
        Self::rendering(device, clock, world, limits)
    }
}

impl<D: Device, C: Clock, R: Renders> ControlLoop<D, C, R> {
    pub(crate) fn rendering(
        device: D,
        clock: C,
        rendered: R,
        limits: SafetyParams,
    ) -> Result<Self, SetupError> {
        let seconds = rendered.period();
        let period = Duration::try_from_secs_f64(seconds)
            .ok()
            .filter(|period| *period > Duration::ZERO && *period <= LONGEST_PERIOD)
            .ok_or(SetupError::Period(seconds))?;
        let method = rendered.method();
        Ok(Self {
            device,
            clock,
            rendered,
            safety: Safety::new(limits, seconds)?,
            rearm: Arc::default(),
            deadlines: None,
            started: Duration::ZERO,
            period,
            stall_limit: limits.stall_after(period),
            held: HeldSince::default(),
            is_off: false,
            motors_off: MotorsOff::default(),
            last: None,
            heartbeat: Arc::default(),
            cuts: 0,
            statistics: LoopStatistics::new(),
            lateness: LatenessWatch::default(),
            tap: None,
            sequence: 0,
            lost: false,
            ticked: None,
            method,
            method_before: method,
        })
    }

    /// The same loop, telling `tap` what it does.
    #[must_use]
    pub fn tapped(mut self, tap: Tap) -> Self {
        self.tap = Some(tap);
        self
    }

    /// The other end of the parameters; there is one, for whoever asks first.
    pub fn parameters(&mut self) -> Option<Parameters> {
        self.rendered.parameters()
    }

    /// What is rendered.
    pub fn rendered(&self) -> &R {
        &self.rendered
    }

    /// Raising it ends a trip that stays, with the next tick.
    pub fn rearm(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.rearm)
    }

    pub(crate) fn heartbeat(&self) -> Arc<Heartbeat> {
        Arc::clone(&self.heartbeat)
    }

    /// A supervisor for another thread; none if the device has no second way to command no force.
    pub fn supervisor(&mut self) -> Option<Supervisor> {
        let zero = self.device.zero_writer()?;
        let heartbeat = Arc::clone(&self.heartbeat);
        Some(Supervisor::new(heartbeat, zero, self.stall_limit))
    }

    pub(crate) fn clock(&self) -> C {
        self.clock.clone()
    }

    /// The period of the deadlines.
    pub fn period(&self) -> Duration {
        self.period
    }

    /// The device.
    pub fn device(&self) -> &D {
        &self.device
    }

    /// How the loop kept time so far.
    pub fn statistics(&self) -> &LoopStatistics {
        &self.statistics
    }

    /// How often a supervisor has commanded no force.
    pub fn cuts(&self) -> u64 {
        self.heartbeat.cuts()
    }

    /// The trip that holds the force at none, if one does.
    pub fn trip(&self) -> Option<Trip> {
        self.safety.trip()
    }

    /// Ticks until `stop` is raised, `most` periods are over or the device is gone, then commands no
    /// force. It can go on afterwards. A deadline that was missed is a period too: a run takes as long
    /// as it was asked to, however busy the machine is.
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
        self.let_go();
        ending
    }

    /// Commands no force in the other way that the device may have, where its own has failed.
    pub(crate) fn cut_off(&mut self) {
        self.heartbeat.end();
        if let Some(mut zero) = self.device.zero_writer() {
            zero.write_zero();
        }
    }

    /// Tells the tap why the loop has ended, and that nothing more will come.
    pub(crate) fn close_tap(&mut self, ending: Ending) {
        // It belongs to the last tick: the next one never was.
        if let Some(last) = self.sequence.checked_sub(1) {
            self.sequence = last;
            self.note(Note::Ended(ending));
        }
        if let Some(tap) = self.tap.take() {
            tap.end(ending);
        }
    }

    /// Commands the device no force, and stands the supervisor down.
    pub fn let_go(&mut self) {
        // A device that does not take it is asked again once; more cannot be done here.
        if self.device.write(Wrench::NONE).is_err() {
            let _ = self.device.write(Wrench::NONE);
        }
        self.held.change(Wrench::NONE, self.clock.now());
        self.motors_off.let_go();
        self.safety.let_go();
        self.heartbeat.end();
    }

    /// One period: sleeps until its deadline, then samples, renders and commands.
    pub fn tick(&mut self) -> Row {
        let deadline = self.deadline();
        self.clock.sleep_until(deadline);
        let woke = self.clock.now();
        let before = self.ticked.replace(woke);
        let has_overslept = self.has_overslept(before, woke);
        let mut cut = self.supervisor_cut();
        self.heartbeat.beat(woke);
        if self.rearm.swap(false, Ordering::AcqRel) && self.safety.rearm() {
            self.note(Note::Rearmed);
        }
        if let Some((generation, rendering)) = self.rendered.take_change() {
            self.note(Note::Changed {
                generation,
                rendering,
            });
        }
        if let Some(generation) = self.rendered.take_other_world() {
            self.note(Note::OtherWorld(generation, self.rendered.method()));
        }

        let (sampled, answered) = self.sample();
        // The device may have been the one that stood still.
        cut = first(cut, self.supervisor_cut());
        let stood_still_in_read = answered.saturating_sub(woke) > self.stall_limit;
        if has_overslept || stood_still_in_read || cut.is_some() {
            // Not before: a device hears of its guardian when it reads. A supervisor that stood still
            // with the loop comes too late.
            let in_read = stood_still_in_read && !has_overslept;
            let since = before.filter(|_| !in_read).unwrap_or(woke);
            cut = first(cut, self.guardian_cut(since));
        }
        let stalled = has_overslept || cut.is_some();
        self.book_cut(cut);
        let elapsed = match (&sampled, &self.last) {
            (Sampled::Fresh(now), Some(before)) => {
                Some(now.time.saturating_sub(before.time).as_secs_f64())
            }
            _ => None,
        };
        let mut fault = None;
        let mut verdict = match sampled {
            Sampled::Fresh(reading) => {
                let held = self.held.take(reading.time);
                let answer = self.rendered.step(&Fresh {
                    position: reading.position,
                    orientation: reading.orientation,
                    elapsed,
                    held,
                    was_off: self.is_off && held == Some(Wrench::NONE),
                });
                fault = answer.fault;
                self.last = Some(reading);
                self.safety.judge(&safety::Rendered {
                    elapsed,
                    position: reading.position,
                    coordinate: answer.coordinate,
                    wrench: answer.wrench,
                    created_energy: self.rendered.created_energy(),
                    refused: fault.is_some(),
                    stalled,
                })
            }
            Sampled::Missing => {
                self.statistics.without_sample += 1;
                if stalled {
                    self.safety.trip_on(Trip::Stalled)
                } else {
                    self.safety.missing()
                }
            }
            Sampled::Gone(trip) => self.safety.trip_on(trip),
        };
        self.notes_of(&verdict);
        let (lateness, period) = (self.rendered.learned_lateness(), self.rendered.period());
        if let Some(lateness) = self.lateness.news(lateness, period, woke) {
            self.note(Note::LearnedLateness(lateness));
        }
        let cut = self.supervisor_cut();
        if cut.is_some() {
            self.book_cut(cut);
            // Just now: what the supervisor has taken off is not put on again.
            verdict = self.safety.trip_on(Trip::Stalled);
            self.notes_of(&verdict);
        }
        if let Some(fault) = fault {
            self.note(Note::Fault(fault));
        }
        // Not before: the interval that this sample ended was the former method's.
        self.follow_method();
        let delivered = self.command(verdict.wrench);

        let ended = self.clock.now();
        let missed = self.deadlines.as_mut().map_or(0, |d| d.ended(woke, ended));
        if missed > 0 {
            self.note(Note::MissedDeadlines(missed));
        }
        self.is_off = self.safety.trip().is_some();
        if ended.saturating_sub(answered) > self.stall_limit {
            let cut = self.guardian_cut(woke);
            self.book_cut(cut);
        }
        self.motors_off.tick(woke, ended, self.is_off);
        let is_fresh = matches!(sampled, Sampled::Fresh(_));
        let flags = Flags::default()
            .with(Flags::FAULT, fault.is_some())
            .with(Flags::SAFETY_LIMITED, verdict.bounded.any())
            .with(Flags::SAFETY_TRIPPED, self.is_off)
            .with(Flags::MISSED_DEADLINE, missed > 0)
            .with(Flags::DEVICE_FAULT, !is_fresh);
        self.rendered.account(self.sequence, delivered.force);
        let tick = Tick {
            lateness: woke.as_secs_f64() - deadline.as_secs_f64(),
            period: elapsed.unwrap_or(f64::NAN),
            commanded_force: verdict.wrench.force,
            commanded_torque: verdict.wrench.torque,
            delivered_force: delivered.force,
            delivered_torque: delivered.torque,
            tick_duration: (ended - answered).as_secs_f64(),
            device_round_trip: (answered - woke).as_secs_f64(),
            created_energy: self.rendered.created_energy(),
            flags: flags.with(self.rendered.flags(), true),
            ..self.seen(woke)
        };
        self.statistics.ticks += 1;
        self.statistics.missed_deadlines += missed;
        self.statistics.motors_off += u64::from(self.is_off);
        self.statistics.time = self.motors_off.time();
        self.statistics.lateness.add(woke - deadline.min(woke));
        self.statistics.tick.add(ended - answered);
        self.statistics.round_trip.add(answered - woke);
        if let Some(tap) = &mut self.tap {
            tap.tick_with_bodies(&tick, self.rendered.contacts(), self.rendered.bodies());
            tap.ran(self.motors_off.time());
        }
        self.sequence += 1;
        let contact = self.rendered.contacts().first().copied();
        Row {
            tick: Tick {
                contacts: u32::try_from(self.rendered.contacts().len()).unwrap_or(u32::MAX),
                bodies: u32::try_from(self.rendered.bodies().len()).unwrap_or(u32::MAX),
                ..tick
            },
            contact: contact.unwrap_or(ContactTick::UNKNOWN),
            ..Row::UNKNOWN
        }
    }

    /// Takes note of another method that renders from this sample on.
    fn follow_method(&mut self) {
        let method = self.rendered.method();
        if method == self.method {
            return;
        }
        // Of several changes in a row, the one that is to blame is remembered.
        if !self.safety.oscillation_is_from_before() {
            self.method_before = self.method;
        }
        self.method = method;
        self.safety.another_method();
    }

    fn deadline(&mut self) -> Duration {
        if let Some(deadlines) = &self.deadlines {
            return deadlines.next();
        }
        self.started = self.clock.now();
        self.deadlines = Some(Deadlines::new(self.period, self.started));
        self.started
    }

    /// When the supervisor has commanded no force, if it has since this was asked last.
    fn supervisor_cut(&mut self) -> Option<Duration> {
        let cuts = self.heartbeat.cuts();
        let was_cut = cuts != self.cuts;
        self.cuts = cuts;
        was_cut.then(|| self.heartbeat.cut_at())
    }

    /// When a guardian has commanded no force, if it has since this was asked last. It is as patient as
    /// a supervisor, and the loop has been silent since `since`.
    fn guardian_cut(&mut self, since: Duration) -> Option<Duration> {
        let at = since.saturating_add(self.stall_limit);
        self.device.was_cut().then(|| at.min(self.clock.now()))
    }

    /// The books learn that no force was held from `cut` on.
    fn book_cut(&mut self, cut: Option<Duration>) {
        if let Some(at) = cut {
            self.held.cut(at);
            self.motors_off.cut(at);
        }
    }

    /// Whether the loop woke so late that a supervisor would have cut it, had there been one awake.
    fn has_overslept(&self, before: Option<Duration>, woke: Duration) -> bool {
        let longest = self.period.saturating_add(self.stall_limit);
        before.is_some_and(|last| woke.saturating_sub(last) > longest)
    }

    /// What the device says, and when it has said it.
    fn sample(&mut self) -> (Sampled, Duration) {
        let read = self.device.read();
        let answered = self.clock.now();
        let sampled = match read {
            // Believed, it would make every sample up to then an old one.
            Ok(reading) if reading.time > answered.saturating_add(self.period) => {
                if self.safety.trip().is_none() {
                    self.note(Note::Device(AHEAD));
                }
                Sampled::Missing
            }
            Ok(reading) => {
                let last = self.last.as_ref().map(|last| last.time);
                if last.is_some_and(|last| reading.time <= last) {
                    Sampled::Missing
                } else {
                    Sampled::Fresh(reading)
                }
            }
            Err(error) => {
                if self.safety.trip() != Some(Trip::DeviceRefused)
                    && error.kind != DeviceErrorKind::NothingNew
                {
                    self.note(Note::Device(error));
                }
                match error.kind {
                    DeviceErrorKind::NothingNew => Sampled::Missing,
                    DeviceErrorKind::Refused => Sampled::Gone(Trip::DeviceRefused),
                    DeviceErrorKind::Disconnected => {
                        self.lost = true;
                        Sampled::Gone(Trip::DeviceLost)
                    }
                }
            }
        };
        (sampled, answered)
    }

    /// Commands a wrench; the one that is held from now on.
    fn command(&mut self, wrench: Wrench) -> Wrench {
        let written = self.device.write(wrench);
        let delivered = match written {
            Ok(held) => held,
            Err(error) => {
                self.note(Note::Device(error));
                let trip = if error.kind == DeviceErrorKind::Disconnected {
                    self.lost = true;
                    Trip::DeviceLost
                } else {
                    Trip::DeviceRefused
                };
                let verdict = self.safety.trip_on(trip);
                self.notes_of(&verdict);
                // It may take none where it does not take some.
                let _ = self.device.write(Wrench::NONE);
                Wrench::NONE
            }
        };
        self.held.change(delivered, self.clock.now());
        let sent = written.ok().and_then(|_| self.device.last_sent());
        self.rendered.report_written(delivered, sent);
        delivered
    }

    /// What is to be said of the device at the last sample.
    fn seen(&self, woke: Duration) -> Tick {
        let reading = self.last.as_ref();
        let time = reading.map_or(woke, |reading| reading.time);
        Tick {
            sequence: self.sequence,
            time: time.saturating_sub(self.started).as_secs_f64(),
            generation: self.rendered.generation(),
            ..reading.map_or(Tick::UNKNOWN, |reading| {
                posed(reading, self.device.capabilities().axes)
            })
        }
    }

    fn notes_of(&mut self, verdict: &Verdict) {
        if let Some(trip) = verdict.recovered {
            self.note(Note::Recovered(trip));
        }
        if let Some(trip) = verdict.tripped {
            self.note(match trip {
                Trip::Oscillation => Note::Oscillated {
                    method: if self.safety.oscillation_is_from_before() {
                        self.method_before
                    } else {
                        self.method
                    },
                    renders_now: self.rendered.method(),
                },
                other => Note::Tripped(other),
            });
        }
    }

    fn note(&mut self, note: Note) {
        if let Some(tap) = &mut self.tap {
            tap.note(&Noted {
                sequence: self.sequence,
                time: (self.clock.now().saturating_sub(self.started)).as_secs_f64(),
                note,
            });
        }
    }
}

impl<D: Device, C: Clock, R: Renders> Drop for ControlLoop<D, C, R> {
    fn drop(&mut self) {
        // A device that panics here would end the program, and nobody else could let go of anything.
        if catch_unwind(AssertUnwindSafe(|| self.let_go())).is_err() {
            let _ = catch_unwind(AssertUnwindSafe(|| self.cut_off()));
        }
    }
}

/// The earlier of two instants.
fn first(a: Option<Duration>, b: Option<Duration>) -> Option<Duration> {
    a.into_iter().chain(b).min()
}
