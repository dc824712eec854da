//! Devices of a loop, each with its safety, last sample and held wrench.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::slice;
use std::time::Duration;

use palpate_device::clock::Clock;
use palpate_device::{Device, DeviceError, DeviceErrorKind, Line, Pose, Wrench, ZeroWriter};
use palpate_record::recording::{DeviceTick, Flags};

use crate::held::HeldSince;
use crate::note::Note;
use crate::rendering::DeviceSample;
use crate::safety::{Bounded, Observation, Rendered, Safety, SafetyStop, Verdict};
use crate::tap::Teller;
use crate::wire::posed;

/// A sample with an invalid time stamp.
const AHEAD: DeviceError = DeviceError {
    kind: DeviceErrorKind::NothingNew,
    what: "the time stamp of a sample is more than a period ahead of the loop's clock",
};

/// Result of reading a device.
#[derive(Clone, Copy, Debug)]
enum Sampled {
    DeviceSamples(Pose),
    Missing,
    Gone(SafetyStop),
}

/// A device of a loop with its state.
pub(crate) struct Driven<D> {
    pub device: D,
    pub safety: Safety,
    /// Index of the device in a loop with several devices.
    pub number: Option<u32>,
    held: HeldSince,
    /// Last fresh sample.
    last: Option<Pose>,
    /// Time of its last rendered sample.
    rendered_at: Option<Duration>,
    sampled: Sampled,
    round_trip: Duration,
    /// Whether a supervisor has a zero writer for it.
    pub is_supervised: bool,
    /// Time at which a supervisor or watchdog process commanded zero force, until it is recorded in the ledger.
    cut: Option<Duration>,
    /// Output of the renderer in this tick and result of its safety check.
    looked: Option<(Rendered, Observation)>,
    /// Wrench to command.
    pub verdict: Verdict,
    /// Held line, as reported by the device.
    pub delivered: Line,
    /// Line sent to the motors, if the device reports it separately.
    pub sent: Option<Line>,
    /// Whether it rejected the command of this tick.
    has_failed: bool,
    /// Whether it is disconnected.
    pub is_lost: bool,
}

impl<D: Device> Driven<D> {
    fn new(device: D, safety: Safety, number: Option<u32>) -> Self {
        Self {
            device,
            safety,
            number,
            held: HeldSince::default(),
            last: None,
            rendered_at: None,
            sampled: Sampled::Missing,
            round_trip: Duration::ZERO,
            is_supervised: false,
            cut: None,
            looked: None,
            verdict: Verdict {
                wrench: Wrench::NONE,
                slope: [0.0; 3],
                bounded: Bounded::default(),
                stopped: None,
                recovered: None,
            },
            delivered: Line::NONE,
            sent: None,
            has_failed: false,
            is_lost: false,
        }
    }

    /// Reads the device. Returns the time of the answer.
    pub fn sample<C: Clock>(
        &mut self,
        clock: &C,
        asked: Duration,
        period: Duration,
        teller: &mut Teller,
    ) -> Duration {
        let read = self.device.read();
        let answered = clock.now();
        self.round_trip = answered.saturating_sub(asked);
        let mut messages = None;
        self.sampled = match read {
            // Accepting it would make every sample up to that time outdated.
            Ok(reading) if reading.time > answered.saturating_add(period) => {
                messages = Some(AHEAD).filter(|_| self.safety.safety_stop().is_none());
                Sampled::Missing
            }
            Ok(reading) => {
                let last = self.last.as_ref().map(|last| last.time);
                if last.is_some_and(|last| reading.time <= last) {
                    Sampled::Missing
                } else {
                    self.last = Some(reading);
                    Sampled::DeviceSamples(reading)
                }
            }
            Err(error) => {
                messages = Some(error).filter(|error| self.is_news(error));
                match error.kind {
                    DeviceErrorKind::NothingNew => Sampled::Missing,
                    DeviceErrorKind::Interrupted => Sampled::Gone(SafetyStop::StaleSample),
                    DeviceErrorKind::Refused => Sampled::Gone(SafetyStop::DeviceRefused),
                    DeviceErrorKind::Disconnected => {
                        self.is_lost = true;
                        Sampled::Gone(SafetyStop::DeviceLost)
                    }
                }
            }
        };
        if let Some(error) = messages {
            teller.note(clock.now(), self.number, Note::Device(error));
        }
        answered
    }

    /// Returns whether the listener does not know of an error yet: while its stop is active, it repeats every tick.
    fn is_news(&self, error: &DeviceError) -> bool {
        let safety_stop = self.safety.safety_stop();
        match error.kind {
            DeviceErrorKind::NothingNew => false,
            DeviceErrorKind::Interrupted => safety_stop.is_none(),
            DeviceErrorKind::Disconnected => true,
            DeviceErrorKind::Refused => safety_stop != Some(SafetyStop::DeviceRefused),
        }
    }

    /// Returns the fresh sample of the device, if any, for the renderer.
    fn fresh(&mut self) -> Option<DeviceSample> {
        let Sampled::DeviceSamples(reading) = self.sampled else {
            return None;
        };
        Some(DeviceSample {
            position: reading.position,
            orientation: reading.orientation,
            held: self.held.take(reading.time),
        })
    }

    fn is_fresh(&self) -> bool {
        matches!(self.sampled, Sampled::DeviceSamples(_))
    }

    /// Checks the sample for a reason to stop.
    fn look(&mut self, of_loop: Rendered, comes_in: bool) {
        let Sampled::DeviceSamples(reading) = self.sampled else {
            return;
        };
        let before = self.rendered_at.replace(reading.time);
        let rendered = Rendered {
            elapsed: before.map(|before| reading.time.saturating_sub(before).as_secs_f64()),
            position: reading.position,
            ..of_loop
        };
        let looked = self.safety.look(&rendered, comes_in);
        self.looked = Some((rendered, looked));
    }

    /// Determines the wrench to command: zero if any device of the loop `is_off`.
    fn answer(&mut self, is_off: bool) {
        if let Some((rendered, looked)) = self.looked.take() {
            self.verdict = self.safety.answer(&rendered, looked, is_off);
        }
    }

    /// Determines the wrench in a tick without rendering, because this or another device has no sample.
    fn go_without(&mut self, stalled: bool) {
        self.verdict = match self.sampled {
            Sampled::Gone(safety_stop) => self.safety.stop_on(safety_stop),
            _ if stalled => self.safety.stop_on(SafetyStop::Stalled),
            Sampled::Missing => self.safety.missing(),
            Sampled::DeviceSamples(_) => self.safety.wait(),
        };
    }

    /// Commands zero force because another device of the loop has no force.
    fn withhold(&mut self) {
        if self.safety.safety_stop().is_none() {
            let messages = self.verdict;
            self.verdict = Verdict {
                stopped: messages.stopped,
                recovered: messages.recovered,
                ..self.safety.withhold()
            };
        }
    }

    /// Commands the wrench, or its line in a loop of `period`. Returns whether the device accepted it.
    fn command<C: Clock>(&mut self, clock: &C, period: Duration, teller: &mut Teller) -> bool {
        let line = self.verdict.line(period);
        let written = if line.is_constant() {
            self.device.write(line.wrench).map(Line::from)
        } else {
            self.device.write_line(line)
        };
        self.delivered = match written {
            Ok(held) => held,
            Err(error) => {
                // A device that rejects a force may accept zero.
                let _ = self.device.write(Wrench::NONE);
                self.has_failed = true;
                if self.is_news(&error) {
                    teller.note(clock.now(), self.number, Note::Device(error));
                }
                let safety_stop = match error.kind {
                    DeviceErrorKind::NothingNew | DeviceErrorKind::Interrupted => {
                        SafetyStop::StaleSample
                    }
                    DeviceErrorKind::Disconnected => {
                        self.is_lost = true;
                        SafetyStop::DeviceLost
                    }
                    DeviceErrorKind::Refused => SafetyStop::DeviceRefused,
                };
                if let Some(safety_stop) = self.safety.stop_on(safety_stop).stopped {
                    teller.note(clock.now(), self.number, Note::Stopped(safety_stop));
                }
                Line::NONE
            }
        };
        self.held.change(self.delivered, clock.now());
        self.sent = written.ok().and_then(|_| self.device.last_sent());
        !self.has_failed
    }

    fn may_hold_a_force(&self) -> bool {
        !self.has_failed && (self.verdict.wrench != Wrench::NONE || self.delivered != Line::NONE)
    }

    /// Records that a supervisor or watchdog process commanded zero force at `at`. The earliest time counts.
    fn was_cut_at(&mut self, at: Duration) {
        self.cut = Some(self.cut.map_or(at, |before| before.min(at)));
    }

    /// Commands zero force, a second time if the device rejects it; nothing more is possible here.
    fn disable_output<C: Clock>(&mut self, clock: &C) {
        if self.device.write(Wrench::NONE).is_err() {
            let _ = self.device.write(Wrench::NONE);
        }
        self.held.change(Wrench::NONE, clock.now());
        self.safety.disable_output();
    }

    /// Returns the recorded data of the device at a tick.
    fn said(&self, devices: u32, started: Duration) -> DeviceTick {
        let axes = self.device.capabilities().axes;
        let pose = self.last.as_ref();
        let place = pose.map(|pose| posed(pose, axes));
        let unknown = DeviceTick::UNKNOWN;
        DeviceTick {
            device: self.number.unwrap_or(0),
            devices,
            flags: Flags::default()
                .with(Flags::SAFETY_LIMITED, self.verdict.bounded.any())
                .with(Flags::SAFETY_STOPPED, self.safety.safety_stop().is_some())
                .with(Flags::DEVICE_FAULT, !self.is_fresh()),
            time: pose.map_or(f64::NAN, |pose| {
                pose.time.saturating_sub(started).as_secs_f64()
            }),
            round_trip: self.round_trip.as_secs_f64(),
            axes: place.map_or(unknown.axes, |place| place.device_axes),
            orientation: place.map_or(unknown.orientation, |place| place.device_orientation),
            commanded_force: self.verdict.wrench.force,
            commanded_torque: self.verdict.wrench.torque,
            delivered_force: self.delivered.wrench.force,
            delivered_slope: self.delivered.slope,
            delivered_torque: self.delivered.wrench.torque,
            ..unknown
        }
    }
}

/// All devices of a loop, one or more, in their order. If one has no force, no device has one.
pub(crate) struct Devices<D> {
    all: Vec<Driven<D>>,
    /// Scratch buffer for a sample of all devices.
    samples: Vec<DeviceSample>,
    /// Requested line of each device; scratch buffer of a tick.
    asked: Vec<Line>,
    /// Recorded data of each device at the last tick; empty for a single device.
    ticks: Vec<DeviceTick>,
}

impl<D: Device> Devices<D> {
    /// Creates the devices; `None` for an empty list.
    pub fn new(devices: impl IntoIterator<Item = (D, Safety)>) -> Option<Self> {
        let devices: Vec<_> = devices.into_iter().collect();
        let number = devices.len();
        let is_one = number == 1;
        let driven = (0..).zip(devices).map(|(place, (device, safety))| {
            Driven::new(device, safety, Some(place).filter(|_| !is_one))
        });
        let all: Vec<_> = driven.collect();
        all.first()?;
        Some(Self {
            all,
            samples: Vec::with_capacity(number),
            asked: vec![Line::NONE; number],
            ticks: if is_one {
                Vec::new()
            } else {
                vec![DeviceTick::UNKNOWN; number]
            },
        })
    }

    /// Returns all devices: at least one.
    pub fn iter(&self) -> slice::Iter<'_, Driven<D>> {
        self.all.iter()
    }

    pub fn iter_mut(&mut self) -> slice::IterMut<'_, Driven<D>> {
        self.all.iter_mut()
    }

    /// Returns the time of the newest sample, if any.
    pub fn sampled_at(&self) -> Option<Duration> {
        let times = self.iter().filter_map(|driven| driven.last.as_ref());
        times.map(|pose| pose.time).max()
    }

    /// Returns the first device.
    #[allow(clippy::indexing_slicing, reason = "there is one, and no tick asks")]
    pub fn first_device(&self) -> &D {
        &self.all[0].device
    }

    /// Returns the commanded wrench and the held line of the first device.
    pub fn first_wrenches(&self) -> (Wrench, Line) {
        let first = self.all.first();
        first.map_or((Wrench::NONE, Line::NONE), |first| {
            (first.verdict.wrench, first.delivered)
        })
    }

    /// Notifies the safety that monitors the generated energy of another method. Returns whether most of that energy
    /// was generated before the current method.
    pub fn another_method(&mut self) -> bool {
        let Some(first) = self.all.first_mut() else {
            return false;
        };
        let is_from_before = first.safety.oscillation_is_from_before();
        first.safety.another_method();
        is_from_before
    }

    /// Returns the last sample of the first device and its number of axes.
    pub fn first_pose(&self) -> Option<(&Pose, usize)> {
        let first = self.all.first()?;
        let axes = first.device.capabilities().axes;
        first.last.as_ref().map(|pose| (pose, axes))
    }

    pub fn are_fresh(&self) -> bool {
        self.iter().all(Driven::is_fresh)
    }

    /// Returns whether a connected device gave no sample in this tick.
    pub fn lack_a_sample(&self) -> bool {
        let mut sampled = self.iter().map(|driven| driven.sampled);
        sampled.any(|sampled| matches!(sampled, Sampled::Missing))
    }

    /// Returns the samples of all devices, if all are fresh, and the buffer for the requested lines.
    pub fn samples(&mut self) -> (&[DeviceSample], &mut [Line]) {
        self.samples.clear();
        let devices = self.all.iter_mut();
        self.samples.extend(devices.filter_map(Driven::fresh));
        (&self.samples, &mut self.asked)
    }

    /// Limits the requested wrench of each device by its safety, in two rounds: a stop of one device removes the
    /// forces of all devices. `of_loop` contains the data common to all. Only the first safety monitors the generated
    /// energy, which belongs to the whole loop.
    pub fn evaluate(&mut self, of_loop: &Rendered) {
        let comes_in = self.iter().any(|driven| driven.safety.is_not_all_there());
        let mut created_energy = of_loop.created_energy;
        for (driven, asked) in self.all.iter_mut().zip(&self.asked) {
            let rendered = Rendered {
                wrench: asked.wrench,
                slope: asked.slope,
                created_energy,
                ..*of_loop
            };
            driven.look(rendered, comes_in);
            created_energy = 0.0;
        }
        let are_off = self.are_off();
        for driven in self.iter_mut() {
            driven.answer(are_off);
        }
    }

    /// Determines the wrenches of a tick without rendering: the last forces for one period, then zero.
    pub fn go_without(&mut self, stalled: bool) {
        for driven in self.iter_mut() {
            driven.go_without(stalled);
        }
        self.withhold_where_one_is_off();
    }

    /// Removes the forces of all devices because the loop stalled.
    pub fn stall(&mut self) {
        for driven in self.iter_mut() {
            driven.verdict = driven.safety.stop_on(SafetyStop::Stalled);
        }
        self.withhold_where_one_is_off();
    }

    fn withhold_where_one_is_off(&mut self) {
        if self.are_off() {
            for driven in self.iter_mut() {
                driven.withhold();
            }
        }
    }

    /// Commands the wrenches. If a device rejects its wrench, no device keeps a force: devices commanded earlier get
    /// a zero command immediately. Returns whether a device is gone.
    pub fn command<C: Clock>(&mut self, clock: &C, period: Duration, teller: &mut Teller) -> bool {
        let mut has_failed = false;
        for driven in self.iter_mut() {
            driven.has_failed = false;
            if has_failed {
                driven.withhold();
            }
            has_failed |= !driven.command(clock, period, teller);
        }
        if has_failed {
            for driven in self.iter_mut().filter(|driven| driven.may_hold_a_force()) {
                driven.withhold();
                driven.command(clock, period, teller);
            }
        }
        self.iter().any(|driven| driven.is_lost)
    }

    /// Returns whether a safety stop of any device keeps all forces off.
    pub fn are_off(&self) -> bool {
        self.iter()
            .any(|driven| driven.safety.safety_stop().is_some())
    }

    /// Returns whether a limit changed the requested wrench of any device.
    pub fn are_bounded(&self) -> bool {
        self.iter().any(|driven| driven.verdict.bounded.any())
    }

    /// Returns the active safety stop with the index of its device; a latched stop precedes a self-clearing one.
    pub fn safety_stop(&self) -> Option<(usize, SafetyStop)> {
        let safety_stops = self.iter().enumerate();
        let safety_stops = safety_stops
            .filter_map(|(number, driven)| Some((number, driven.safety.safety_stop()?)));
        safety_stops.min_by_key(|(_, safety_stop)| safety_stop.is_passing())
    }

    /// Ends the latched safety stops. Returns whether there was one.
    pub fn rearm(&mut self) -> bool {
        let rearmed = self.iter_mut().map(|driven| driven.safety.rearm());
        rearmed.fold(false, |any, rearmed| any | rearmed)
    }

    /// Records that a supervisor commanded zero force at `at`.
    pub fn were_cut_at(&mut self, at: Duration) {
        for driven in self.iter_mut().filter(|driven| driven.is_supervised) {
            driven.was_cut_at(at);
        }
    }

    /// Returns whether a watchdog process has commanded zero force on a device since the last call; `at` is then the
    /// time.
    pub fn were_cut_by_watchdogs(&mut self, at: Duration) -> bool {
        let mut were_cut = false;
        for driven in self.iter_mut() {
            if driven.device.was_cut() {
                driven.was_cut_at(at);
                were_cut = true;
            }
        }
        were_cut
    }

    /// Records in the ledger which devices held no force and since when. Returns the time since which no device held
    /// a force, if all were cut.
    pub fn record_cuts(&mut self) -> Option<Duration> {
        let mut all = Some(Duration::ZERO);
        for driven in self.iter_mut() {
            let cut = driven.cut.take();
            if let Some(at) = cut {
                driven.held.cut(at);
            }
            all = all.zip(cut).map(|(all, at)| all.max(at));
        }
        all
    }

    /// Returns one zero writer that combines those of all devices; `None` if no device has one.
    pub fn zero_writer(&mut self) -> Option<Box<dyn ZeroWriter>> {
        let mut writers = Vec::new();
        for driven in self.iter_mut() {
            let writer = driven.device.zero_writer();
            driven.is_supervised = writer.is_some();
            writers.extend(writer);
        }
        if writers.len() < 2 {
            return writers.pop();
        }
        Some(Box::new(All(writers)))
    }

    /// Commands zero force on each device. A panic of one device does not affect the others.
    ///
    /// # Panics
    /// A device panicked; all devices have been commanded by then.
    pub fn disable_output<C: Clock>(&mut self, clock: &C) {
        self.each(|driven| driven.disable_output(clock));
    }

    /// Commands zero force through the zero writers of the devices, in the same manner as
    /// [`disable_output`](Self::disable_output).
    ///
    /// # Panics
    /// A device panicked; all devices have been commanded by then.
    pub fn cut_off(&mut self) {
        self.each(|driven| {
            if let Some(mut zero) = driven.device.zero_writer() {
                zero.write_zero();
            }
        });
    }

    fn each(&mut self, mut act: impl FnMut(&mut Driven<D>)) {
        let mut panic: Option<Box<dyn Any + Send>> = None;
        for driven in self.iter_mut() {
            if let Err(payload) = catch_unwind(AssertUnwindSafe(|| act(driven))) {
                panic = Some(payload);
            }
        }
        if let Some(payload) = panic {
            resume_unwind(payload);
        }
    }

    /// Collects the recorded data of each device, if there are several.
    pub fn take_down(&mut self, sequence: u64, started: Duration) {
        let number = u32::try_from(self.ticks.len()).unwrap_or(u32::MAX);
        for (tick, driven) in self.ticks.iter_mut().zip(&self.all) {
            *tick = DeviceTick {
                sequence,
                ..driven.said(number, started)
            };
        }
    }

    /// Returns the recorded data of each device at the last tick; empty for a single device.
    pub fn ticks(&self) -> &[DeviceTick] {
        &self.ticks
    }
}

/// Several zero writers combined into one.
struct All(Vec<Box<dyn ZeroWriter>>);

impl ZeroWriter for All {
    fn write_zero(&mut self) {
        for zero in &mut self.0 {
            // A panic of one writer does not affect the others.
            let _ = catch_unwind(AssertUnwindSafe(|| zero.write_zero()));
        }
    }
}
