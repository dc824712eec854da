//! The loop itself: sleep, sample, render, pass through safety, command, note down.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use palpate::AlongAxis;
use palpate_record::recording::{ContactTick, DeviceTick, Flags, Row, Tick};

use crate::deadlines::Deadlines;
use crate::driven::Devices;
use crate::lateness_watch::LatenessWatch;
use crate::motors_off::MotorsOff;
use crate::note::{Ending, Note};
use crate::rendering::{Answer, Fresh, OneContact, Parameters, RenderedWorld, Rendering, Renders};
use crate::safety::{Heartbeat, Rendered, Safety, SafetyParams, Supervisor, Trip};
use crate::setup::{SetupError, can_turn};
use crate::statistics::LoopStatistics;
use crate::stop::StopFlag;
use crate::tap::{Tap, Teller};
use crate::wire::posed;
use palpate_device::clock::Clock;
use palpate_device::{Device, Wrench};

/// A haptic loop on one device or several, which renders `R`: one contact, or a world. Everything that it needs is there before
/// its first tick; a tick allocates nothing, locks nothing and waits for nobody but the clock and the devices.
///
/// Where one of several devices has no force, none has. When the loop goes, whatever the reason, it commands each device no
/// force.
pub struct ControlLoop<D: Device, C: Clock, R: Renders = OneContact> {
    devices: Devices<D>,
    clock: C,
    rendered: R,
    rearm: Arc<AtomicBool>,
    deadlines: Option<Deadlines>,
    period: Duration,
    /// How long the loop may stand still before a supervisor or a guardian takes the force off.
    stall_limit: Duration,
    /// Whether a trip kept the motors off at the end of the last tick.
    is_off: bool,
    motors_off: MotorsOff,
    /// When the devices were sampled for the last sample that was rendered.
    rendered_at: Option<Duration>,
    heartbeat: Arc<Heartbeat>,
    cuts: u64,
    statistics: LoopStatistics,
    lateness: LatenessWatch,
    teller: Teller,
    lost: bool,
    /// When the last tick began.
    ticked: Option<Duration>,
    /// The method whose energy is counted now, and the one before it that created the most of late.
    method: &'static str,
    method_before: &'static str,
}

/// Longest period: whoever ends a loop should not have to wait for longer.
const LONGEST_PERIOD: Duration = Duration::from_secs(10);

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
        Self::rendering(vec![(device, limits)], clock, OneContact::new(rendering)?)
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
    /// A world of several devices; a limit of the safety outside its range; a period below a nanosecond or above 10 s; a
    /// tool that turns, and a device that measures no orientation; a tool that feels a torque, and a device that gives none about
    /// three axes.
    pub fn of_world(
        device: D,
        clock: C,
        world: RenderedWorld,
        limits: SafetyParams,
    ) -> Result<Self, SetupError> {
        Self::of_devices(vec![(device, limits)], clock, world)
    }

    /// A loop that renders a world on several devices, each with its own limits: one for each tool of the world, in their
    /// order. Devices of different kinds are boxed: `D` is `Box<dyn Device>`.
    ///
    /// In each tick all devices are read, one after the other, then the world makes one step, and then all are commanded.
    /// The world's time is that of the newest sample. Where one device has no good sample, does not take its force, is cut or
    /// outside its limits, no device has a force, and a note names that one.
    ///
    /// # Errors
    /// Another number of devices than the world has tools; as [`of_world`](Self::of_world).
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
        // The most impatient of the devices counts.
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

    /// The same loop, telling `tap` what it does.
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

    /// A supervisor for another thread; none if no device has a second way to command no force. It watches the loop for all
    /// devices that have one.
    pub fn supervisor(&mut self) -> Option<Supervisor> {
        let zero = self.devices.zero_writer()?;
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

    /// The device; the first one where there are several.
    pub fn device(&self) -> &D {
        self.devices.first_device()
    }

    /// All devices, in their order.
    pub fn devices(&self) -> impl Iterator<Item = &D> {
        self.devices.iter().map(|driven| &driven.device)
    }

    /// What recordings have of each device at the last tick; none where the loop has one, of which the tick says it.
    pub fn device_ticks(&self) -> &[DeviceTick] {
        self.devices.ticks()
    }

    /// How the loop kept time so far.
    pub fn statistics(&self) -> &LoopStatistics {
        &self.statistics
    }

    /// How often a supervisor has commanded no force.
    pub fn cuts(&self) -> u64 {
        self.heartbeat.cuts()
    }

    /// The trip that holds the forces at none, if one does; of several one that stays.
    pub fn trip(&self) -> Option<Trip> {
        self.tripped_device().map(|(_, trip)| trip)
    }

    /// The same, with the number of the device that has tripped, from 0.
    pub fn tripped_device(&self) -> Option<(usize, Trip)> {
        self.devices.trip()
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
        self.devices.cut_off();
    }

    /// Tells the tap why the loop has ended, and that nothing more will come.
    pub(crate) fn close_tap(&mut self, ending: Ending) {
        // It belongs to the last tick: the next one never was.
        if let Some(last) = self.teller.sequence.checked_sub(1) {
            self.teller.sequence = last;
            self.note(Note::Ended(ending));
        }
        if let Some(tap) = self.teller.tap.take() {
            tap.end(ending);
        }
    }

    /// Commands each device no force, and stands the supervisor down.
    pub fn let_go(&mut self) {
        self.devices.let_go(&self.clock);
        self.motors_off.let_go();
        self.heartbeat.end();
    }

    /// One period: sleeps until its deadline, then samples, renders and commands.
    pub fn tick(&mut self) -> Row {
        let deadline = self.deadline();
        self.clock.sleep_until(deadline);
        let woke = self.clock.now();
        let before = self.ticked.replace(woke);
        let has_overslept = self.has_overslept(before, woke);
        let mut was_cut = self.supervisor_cut();
        self.heartbeat.beat(woke);
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

        let answered = self.sample(woke);
        // A device may have been what stood still.
        was_cut |= self.supervisor_cut();
        let stood_still_in_read = answered.saturating_sub(woke) > self.stall_limit;
        if has_overslept || stood_still_in_read || was_cut {
            // Not before: a device hears of its guardian when it reads. A supervisor that stood still
            // with the loop comes too late.
            let in_read = stood_still_in_read && !has_overslept;
            let since = before.filter(|_| !in_read).unwrap_or(woke);
            was_cut |= self.guardian_cut(since);
        }
        let stalled = has_overslept || was_cut;
        if was_cut {
            self.book_cuts();
        }
        let are_fresh = self.devices.are_fresh();
        let mut elapsed = None;
        let mut fault = None;
        if are_fresh {
            elapsed = self.elapsed();
            fault = self.render(elapsed, stalled).fault;
        } else {
            self.statistics.without_sample += u64::from(self.devices.lack_a_sample());
            self.devices.go_without(stalled);
        }
        self.tell_of_trips();
        let (lateness, period) = (self.rendered.learned_lateness(), self.rendered.period());
        if let Some(lateness) = self.lateness.news(lateness, period, woke) {
            self.note(Note::LearnedLateness(lateness));
        }
        if self.supervisor_cut() {
            self.book_cuts();
            // Just now: what the supervisor has taken off is not put on again.
            self.devices.stall();
            self.tell_of_trips();
        }
        if let Some(fault) = fault {
            self.statistics.refused += 1;
            self.statistics.refused_at_end += 1;
            self.note(Note::Fault(fault));
        } else if are_fresh {
            self.statistics.refused_at_end = 0;
        }
        // Not before: the interval that this sample ended was the former method's.
        self.follow_method();
        self.command();

        let ended = self.clock.now();
        let missed = self.deadlines.as_mut().map_or(0, |d| d.ended(woke, ended));
        if missed > 0 {
            self.note(Note::MissedDeadlines(missed));
        }
        self.is_off = self.devices.are_off();
        if ended.saturating_sub(answered) > self.stall_limit {
            self.guardian_cut(woke);
            self.book_cuts();
        }
        self.motors_off.tick(woke, ended, self.is_off);
        let flags = Flags::default()
            .with(Flags::FAULT, fault.is_some())
            .with(Flags::SAFETY_LIMITED, self.devices.are_bounded())
            .with(Flags::SAFETY_TRIPPED, self.is_off)
            .with(Flags::MISSED_DEADLINE, missed > 0)
            .with(Flags::DEVICE_FAULT, !are_fresh);
        let (commanded, delivered) = self.devices.first_wrenches();
        self.rendered.account(self.teller.sequence, delivered.force);
        let tick = Tick {
            lateness: woke.as_secs_f64() - deadline.as_secs_f64(),
            period: elapsed.unwrap_or(f64::NAN),
            commanded_force: commanded.force,
            commanded_torque: commanded.torque,
            delivered_force: delivered.force,
            delivered_torque: delivered.torque,
            tick_duration: (ended - answered).as_secs_f64(),
            device_round_trip: (answered - woke).as_secs_f64(),
            created_energy: self.rendered.created_energy(),
            flags: flags.with(self.rendered.flags(), true),
            ..self.seen(woke)
        };
        self.devices
            .take_down(self.teller.sequence, self.teller.started);
        self.statistics.ticks += 1;
        self.statistics.missed_deadlines += missed;
        self.statistics.motors_off += u64::from(self.is_off);
        self.statistics.time = self.motors_off.time();
        self.statistics.off_at_end = self.motors_off.unbroken();
        self.statistics.lateness.add(woke - deadline.min(woke));
        self.statistics.tick.add(ended - answered);
        self.statistics.round_trip.add(answered - woke);
        let (contacts, bodies) = (self.rendered.contacts(), self.rendered.bodies());
        if let Some(tap) = &mut self.teller.tap {
            tap.tick_with_devices(&tick, contacts, bodies, self.devices.ticks());
            tap.ran(self.motors_off.time());
        }
        self.teller.sequence += 1;
        Row {
            tick: Tick {
                contacts: u32::try_from(contacts.len()).unwrap_or(u32::MAX),
                bodies: u32::try_from(bodies.len()).unwrap_or(u32::MAX),
                ..tick
            },
            contact: contacts.first().copied().unwrap_or(ContactTick::UNKNOWN),
            ..Row::UNKNOWN
        }
    }

    /// Hands the modelled gain and the slew limit of a changed rendering to each safety.
    fn follow_limits(&mut self) {
        let (actuation, slew) = (self.rendered.actuation(), self.rendered.slew_limit());
        for driven in self.devices.iter_mut() {
            driven.safety.follow(&actuation, slew);
        }
    }

    /// Takes note of another method that renders from this sample on.
    fn follow_method(&mut self) {
        let method = self.rendered.method();
        if method == self.method {
            return;
        }
        // Of several changes in a row, the one that is to blame is remembered.
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

    /// Whether the supervisor has commanded no force since this was asked last.
    fn supervisor_cut(&mut self) -> bool {
        let cuts = self.heartbeat.cuts();
        let was_cut = cuts != self.cuts;
        self.cuts = cuts;
        if was_cut {
            self.devices.were_cut_at(self.heartbeat.cut_at());
        }
        was_cut
    }

    /// Whether a guardian has commanded no force since this was asked last. It is as patient as a supervisor, and the loop
    /// has been silent since `since`.
    fn guardian_cut(&mut self, since: Duration) -> bool {
        let at = since.saturating_add(self.stall_limit);
        self.devices.were_cut_by_guardians(at.min(self.clock.now()))
    }

    /// The books learn which devices held no force, and from when on.
    fn book_cuts(&mut self) {
        if let Some(at) = self.devices.book_cuts() {
            self.motors_off.cut(at);
        }
    }

    /// Whether the loop woke so late that a supervisor would have cut it, had there been one awake.
    fn has_overslept(&self, before: Option<Duration>, woke: Duration) -> bool {
        let longest = self.period.saturating_add(self.stall_limit);
        before.is_some_and(|last| woke.saturating_sub(last) > longest)
    }

    /// Asks all devices, one after the other. When the last one has answered.
    fn sample(&mut self, woke: Duration) -> Duration {
        let mut answered = woke;
        for driven in self.devices.iter_mut() {
            answered = driven.sample(&self.clock, answered, self.period, &mut self.teller);
            self.lost |= driven.is_lost;
        }
        answered
    }

    /// Time since the sample that was rendered last, where all devices have a fresh one `[s]`.
    fn elapsed(&mut self) -> Option<f64> {
        let now = self.devices.sampled_at()?;
        let before = self.rendered_at.replace(now)?;
        Some(now.saturating_sub(before).as_secs_f64())
    }

    /// Renders a fresh sample of all devices, and puts the answer through the safety of each.
    fn render(&mut self, elapsed: Option<f64>, stalled: bool) -> Answer {
        let (devices, asked) = self.devices.samples();
        let held_none = devices
            .iter()
            .all(|device| device.held == Some(Wrench::NONE));
        let sample = Fresh {
            elapsed,
            was_off: self.is_off && held_none,
            devices,
        };
        let answer = self.rendered.step(&sample, asked);
        self.devices.judge(&Rendered {
            elapsed,
            position: [0.0; 3],
            coordinate: answer.coordinate,
            wrench: Wrench::NONE,
            created_energy: self.rendered.created_energy(),
            refused: answer.fault.is_some(),
            stalled,
        });
        answer
    }

    /// Commands what was decided, and tells the renderer what came of it.
    fn command(&mut self) {
        self.lost |= self.devices.command(&self.clock, &mut self.teller);
        for (number, driven) in self.devices.iter().enumerate() {
            self.rendered
                .report_written(number, driven.delivered, driven.sent);
        }
    }

    /// What is to be said of the first device at the last sample.
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

    /// Tells which trips have begun and ended: of those that are of the loop as a whole, once.
    fn tell_of_trips(&mut self) {
        let mut is_first = true;
        for driven in self.devices.iter_mut() {
            let is_told = |trip: &Trip| is_first || !trip.is_of_the_loop();
            let of = |trip: Trip| driven.number.filter(|_| !trip.is_of_the_loop());
            if let Some(trip) = driven.verdict.recovered.take().filter(is_told) {
                let now = self.clock.now();
                self.teller.note(now, of(trip), Note::Recovered(trip));
            }
            if let Some(trip) = driven.verdict.tripped.take().filter(is_told) {
                let note = match trip {
                    Trip::Oscillation => Note::Oscillated {
                        method: if driven.safety.oscillation_is_from_before() {
                            self.method_before
                        } else {
                            self.method
                        },
                        renders_now: self.rendered.method(),
                    },
                    other => Note::Tripped(other),
                };
                self.teller.note(self.clock.now(), of(trip), note);
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
        // A device that panics here would end the program, and nobody else could let go of anything.
        if catch_unwind(AssertUnwindSafe(|| self.let_go())).is_err() {
            let _ = catch_unwind(AssertUnwindSafe(|| self.cut_off()));
        }
    }
}
