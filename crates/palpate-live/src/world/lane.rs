//! A rendering of a world: one loop on its devices, and its data for the page.

use std::time::Duration;

use palpate_device::clock::MonotonicClock;
use palpate_device::{Capabilities, Device, Vector};
use palpate_record::recording::{BodyTick, ContactTick, DeviceTick, Event, Flags, Tick};
use palpate_rt::realtime::{Answer, Request};
use palpate_rt::safety::SafetyStop;
use palpate_rt::{
    Account, ControlLoop, Durations, Listener, LoopEvent, LoopThread, Message, Note, RenderedWorld,
    StopFlag, WorldFrame, tap,
};

use super::{WorldEnded, WorldLane, WorldLaneEnd, shown};
use crate::message::{LaneStatus, Spread};
use crate::rows::{Frame, Rows};
use crate::session::SessionError;

/// Ticks of one contact that may wait for the scope.
const ROOM: usize = 1 << 15;

/// Parameters for running the loop of a rendering.
pub struct Run<'a> {
    pub clock: &'a MonotonicClock,
    pub request: Request,
    pub stop: &'a StopFlag,
    pub duration: Option<Duration>,
}

/// One loop on its devices, and its data for the live view.
pub struct Lane {
    pub method: &'static str,
    /// The devices.
    pub capabilities: Vec<Capabilities>,
    /// Frames of the devices in the world.
    frames: Vec<WorldFrame>,
    pub answers: Vec<Answer>,
    thread: Option<LoopThread<Box<dyn Device>, MonotonicClock, RenderedWorld>>,
    listener: Listener,
    rows: Rows,
    newest: Option<Newest>,
    is_shown: bool,
    /// Cause of a zero force, for each device.
    safety_stops: Vec<Option<String>>,
    account: Account,
    ticks: u64,
    next: u64,
    missing: u64,
    missed_deadlines: u64,
    without_sample: u64,
    lateness: Durations,
    tick: Durations,
    end: Option<WorldEnded>,
}

/// Newest received tick.
struct Newest {
    tick: Tick,
    contacts: Vec<ContactTick>,
    bodies: Vec<BodyTick>,
    devices: Vec<DeviceTick>,
}

impl Lane {
    /// Starts the loop of an open rendering.
    pub fn start(
        method: &'static str,
        opened: WorldLane,
        run: &Run<'_>,
    ) -> Result<Self, SessionError> {
        let WorldLane { devices, world } = opened;
        let capabilities = devices.iter().map(|(device, _)| device.capabilities());
        let capabilities: Vec<Capabilities> = capabilities.cloned().collect();
        let frames = world.frames().to_vec();
        let (tap, listener) = tap(ROOM);
        let control = ControlLoop::of_devices(devices, *run.clock, world)?.tapped(tap);
        let period = control.period();
        let periods = |lasts: Duration| lasts.as_nanos().div_ceil(period.as_nanos().max(1));
        let most = run.duration.map(periods);
        let most = most.map(|most| u64::try_from(most).unwrap_or(u64::MAX));
        let thread = LoopThread::start(control, run.request, run.stop, most)
            .map_err(|error| SessionError::Other(format!("no thread for the loop: {error}")))?;
        Ok(Self {
            method,
            frames,
            answers: thread.answers().to_vec(),
            thread: Some(thread),
            listener,
            rows: Rows::with_further(period.as_secs_f64(), capabilities.len().saturating_sub(1)),
            newest: None,
            is_shown: true,
            safety_stops: vec![None; capabilities.len()],
            capabilities,
            account: Account::default(),
            ticks: 0,
            next: 0,
            missing: 0,
            missed_deadlines: 0,
            without_sample: 0,
            lateness: Durations::new(),
            tick: Durations::new(),
            end: None,
        })
    }

    /// Processes all messages of the loop and passes its events to `note`. Returns whether the loop has ended since the
    /// last call.
    pub fn listen(&mut self, mut note: impl FnMut(&LoopEvent, Event)) -> bool {
        let has_ended = self.thread.as_ref().is_some_and(LoopThread::has_ended);
        while let Some(messages) = self.listener.next() {
            match messages {
                Message::Tick(tick, contacts, bodies, devices) => self.take(Newest {
                    tick,
                    contacts,
                    bodies,
                    devices,
                }),
                Message::Note(noted) => {
                    match noted.note {
                        Note::Stopped(safety_stop) => self.stopped(&noted, safety_stop),
                        Note::Oscillated { .. } => self.stopped(&noted, SafetyStop::Oscillation),
                        Note::MissedDeadlines(number) => self.missed_deadlines += number,
                        _ => {}
                    }
                    let event = noted.event_of(self.listener.device_names());
                    self.account.event(event.clone());
                    note(&noted, event);
                }
            }
        }
        if has_ended && let Some(thread) = self.thread.take() {
            self.end = Some(thread.join());
        }
        has_ended
    }

    /// A device has tripped; the only one where none is named.
    fn stopped(&mut self, noted: &LoopEvent, safety_stop: SafetyStop) {
        let device = noted.device.and_then(|device| usize::try_from(device).ok());
        let of = device.unwrap_or(0);
        let name = device.and_then(|_| self.listener.device_names().get(of));
        let text = match name {
            Some(name) => format!("{name}: {safety_stop}"),
            None => safety_stop.to_string(),
        };
        if let Some(own) = self.safety_stops.get_mut(of) {
            *own = Some(text);
        }
    }

    fn take(&mut self, newest: Newest) {
        let tick = &newest.tick;
        self.missing += tick.sequence.saturating_sub(self.next);
        self.next = tick.sequence + 1;
        self.ticks += 1;
        self.without_sample += u64::from(tick.flags.has(Flags::DEVICE_FAULT));
        let duration = |seconds: f64| Duration::try_from_secs_f64(seconds.max(0.0));
        if let Ok(lateness) = duration(tick.lateness) {
            self.lateness.add(lateness);
        }
        if let Ok(took) = duration(tick.tick_duration) {
            self.tick.add(took);
        }
        if !tick.flags.has(Flags::SAFETY_STOPPED) {
            self.safety_stops.fill(None);
        }
        for (device, safety_stop) in newest.devices.iter().zip(&mut self.safety_stops) {
            if !device.flags.has(Flags::SAFETY_STOPPED) {
                *safety_stop = None;
            }
        }
        self.account.tick(tick, &newest.contacts);
        let further = newest.devices.iter().skip(1);
        let further: Vec<f64> = further
            .map(|device| shown::length(device.delivered_force))
            .collect();
        self.rows
            .add_with(&shown::row(tick, &newest.contacts), &further);
        self.newest = Some(newest);
        self.is_shown = false;
    }

    /// Frames that have not been shown yet: the rows of the charts, and the newest state of the world.
    pub fn frames(&mut self, number: u8, run: u32) -> impl Iterator<Item = Frame> + use<> {
        let rows = self.rows.take_frame(number, run);
        let world = self
            .newest
            .as_ref()
            .filter(|_| !self.is_shown)
            .map(|newest| {
                let own = newest.devices.iter().map(|device| device.delivered_force);
                let forces: Vec<Vector> = if newest.devices.is_empty() {
                    vec![newest.tick.delivered_force]
                } else {
                    own.collect()
                };
                let in_world = self.frames.iter().zip(forces);
                let forces: Vec<Vector> = in_world
                    .map(|(frame, force)| frame.of_device(force))
                    .collect();
                let Newest {
                    tick,
                    contacts,
                    bodies,
                    ..
                } = newest;
                shown::frame((number, run), tick, (contacts, bodies), &forces)
            });
        self.is_shown = true;
        rows.into_iter().chain(world)
    }

    /// Whether its loop runs.
    pub fn is_running(&self) -> bool {
        self.thread.is_some()
    }

    /// Returns the cause of a zero force, if there is one.
    pub fn safety_stop(&self) -> Option<String> {
        let safety_stops: Vec<&str> = self
            .safety_stops
            .iter()
            .flatten()
            .map(String::as_str)
            .collect();
        (!safety_stops.is_empty()).then(|| safety_stops.join("; "))
    }

    /// Ends a trip that stays.
    pub fn rearm(&self) {
        if let Some(thread) = &self.thread {
            thread.rearm();
        }
    }

    /// Returns the end of the loop, if it has ended.
    pub fn end(&self) -> Option<&WorldEnded> {
        self.end.as_ref()
    }

    /// Waits for a loop that has been stopped, and processes all its messages.
    pub fn finish(&mut self) {
        if let Some(thread) = self.thread.take() {
            self.end = Some(thread.join());
        }
        self.listen(|_, _| {});
    }

    /// Returns the final state, for a report.
    pub fn into_end(self) -> Option<WorldLaneEnd> {
        let mut account = self.account;
        account.counted(&self.listener.counted());
        Some(WorldLaneEnd {
            method: self.method,
            capabilities: self.capabilities,
            end: self.end?,
            answers: self.answers,
            account,
        })
    }

    /// Returns the timing status of the loop.
    pub fn status(&self) -> LaneStatus {
        let spread = |durations: &Durations| Spread {
            median: durations.quantile(0.5).as_secs_f64(),
            p99: durations.quantile(0.99).as_secs_f64(),
            longest: durations.longest().as_secs_f64(),
        };
        let cuts = match (&self.thread, &self.end) {
            (Some(thread), _) => thread.cuts(),
            (None, Some(end)) => end.cuts,
            (None, None) => 0,
        };
        let made = self.end.as_ref().map_or(0, |end| end.statistics.ticks);
        LaneStatus {
            t_s: self.newest.as_ref().map_or(0.0, |newest| newest.tick.time),
            ticks: self.ticks,
            missed_deadlines: self.missed_deadlines,
            without_sample: self.without_sample,
            supervisor_cuts: cuts,
            lateness_s: spread(&self.lateness),
            tick_s: spread(&self.tick),
            unsent: self.missing + made.saturating_sub(self.next),
        }
    }
}
