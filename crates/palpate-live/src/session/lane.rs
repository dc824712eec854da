//! A rendering of a session: one loop on a device, and its data for the live view.

use std::path::{Path, PathBuf};

use palpate_core::AlongAxis;
use palpate_device::Capabilities;
use palpate_device::clock::MonotonicClock;
use palpate_record::recording::{ContactTick, Flags, Row, Tick};
use palpate_rt::realtime::{Answer, Request};
use palpate_rt::safety::{SafetyParams, SafetyStop};
use palpate_rt::{
    Account, ControlLoop, Durations, Listener, LoopEnd, LoopEvent, LoopThread, Message, Note,
    Rendering, StopFlag, tap,
};
use palpate_scene::method::MethodName;

use super::carried::{Carried, Returned};
use super::recording::{Ending, LaneRecording};
use super::start::{Placed, SessionError};
use crate::message::{LaneStatus, Spread};
use crate::rows::Rows;

/// Ticks of one contact that may wait for the scope: 4 s at 4 kHz.
const ROOM: usize = 1 << 14;

/// Number of past methods that a rendering stores.
const MAX_CHOSEN: usize = 16;

/// End of a rendering's loop.
pub type Ended = LoopEnd<Carried, MonotonicClock>;

/// One loop on a device, and its data for the live view.
pub struct Lane {
    thread: Option<LoopThread<Carried, MonotonicClock>>,
    returned: Returned,
    axis: AlongAxis<f64, 3>,
    listener: Listener,
    rows: Rows,
    recording: Option<LaneRecording>,
    /// The recording that ended with the loop.
    recorded: Option<PathBuf>,
    heard: ClientMessage,
    statistics: Statistics,
    safety_stop: Option<Stopped>,
    /// Selected methods, the newest last.
    chosen: Vec<MethodName>,
    account: Account,
    capabilities: Capabilities,
    answers: Vec<Answer>,
    end: Option<Ended>,
}

/// Cause of a zero force.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stopped {
    /// The reason.
    pub why: String,
    /// The method whose held forces are the reason, if it is a method's.
    pub method: Option<MethodName>,
}

/// Counter of received ticks, by their numbers.
#[derive(Clone, Copy, Debug, Default)]
struct ClientMessage {
    next: u64,
    missing: u64,
}

impl ClientMessage {
    fn hear(&mut self, sequence: u64) {
        self.missing += sequence.saturating_sub(self.next);
        self.next = sequence + 1;
    }
}

/// Statistics of the ticks received from the loop.
#[derive(Default)]
struct Statistics {
    ticks: u64,
    missed_deadlines: u64,
    without_sample: u64,
    lateness: Durations,
    tick: Durations,
}

/// Parameters for running the loop of a rendering.
pub struct Run<'a> {
    /// The clock of loop and device.
    pub clock: &'a MonotonicClock,
    /// Requested scheduling.
    pub request: Request,
    /// Limits between renderer and device.
    pub limits: SafetyParams,
    /// Ends it.
    pub stop: &'a StopFlag,
    /// Number of ticks; `None`: until the loop is stopped.
    pub most: Option<u64>,
}

impl Lane {
    /// Starts a loop that renders a rendering, by the method of that name, on `placed`, and records it
    /// from its first tick on if it is to.
    pub fn start(
        placed: Placed,
        (method, rendering): (MethodName, Rendering),
        run: &Run<'_>,
        recording: Option<LaneRecording>,
    ) -> Result<Self, SessionError> {
        let Placed { device, axis } = placed;
        let capabilities = device.capabilities().clone();
        let (device, returned) = Carried::new(device);
        let (tap, listener) = tap(ROOM);
        let control = ControlLoop::new(device, *run.clock, rendering, run.limits)?
            .along(axis)
            .tapped(tap);
        let thread = LoopThread::start(control, run.request, run.stop, run.most)
            .map_err(|error| SessionError::Other(format!("no thread for the loop: {error}")))?;
        Ok(Self {
            answers: thread.answers().to_vec(),
            thread: Some(thread),
            returned,
            axis,
            listener,
            rows: Rows::new(rendering.loop_params.period),
            recording,
            recorded: None,
            heard: ClientMessage::default(),
            statistics: Statistics::default(),
            safety_stop: None,
            chosen: vec![method],
            account: Account::default(),
            capabilities,
            end: None,
        })
    }

    /// Processes all messages of the loop and passes its events to `note`. Returns whether the loop has ended since the
    /// last call.
    pub fn listen(&mut self, mut note: impl FnMut(&LoopEvent)) -> bool {
        let has_ended = self.thread.as_ref().is_some_and(LoopThread::has_ended);
        while let Some(messages) = self.listener.next() {
            match messages {
                Message::Tick(tick, contacts, _, _) => self.tick(&tick, &contacts),
                Message::Note(noted) => {
                    self.noted(&noted);
                    note(&noted);
                }
            }
        }
        if has_ended && let Some(thread) = self.thread.take() {
            self.end = Some(thread.join());
        }
        has_ended
    }

    fn tick(&mut self, tick: &Tick, contacts: &[ContactTick]) {
        self.heard.hear(tick.sequence);
        let statistics = &mut self.statistics;
        statistics.ticks += 1;
        statistics.without_sample += u64::from(tick.flags.has(Flags::DEVICE_FAULT));
        let duration = |seconds: f64| std::time::Duration::try_from_secs_f64(seconds);
        if let Ok(lateness) = duration(tick.lateness.max(0.0)) {
            statistics.lateness.add(lateness);
        }
        if let Ok(took) = duration(tick.tick_duration) {
            statistics.tick.add(took);
        }
        if !tick.flags.has(Flags::SAFETY_STOPPED) {
            self.safety_stop = None;
        }
        self.account.tick(tick, contacts);
        // The page draws the first contact.
        if let Some(row) = Row::new(*tick, contacts).next() {
            self.rows.add(&row);
        }
        if let Some(recording) = &mut self.recording {
            recording.tick(tick, contacts);
        }
    }

    fn noted(&mut self, noted: &LoopEvent) {
        match noted.note {
            Note::Stopped(safety_stop) => {
                self.safety_stop = Some(Stopped {
                    why: safety_stop.to_string(),
                    method: None,
                });
            }
            Note::Oscillated { method, .. } => {
                self.safety_stop = Some(Stopped {
                    why: SafetyStop::Oscillation.to_string(),
                    method: self.chosen_as(method),
                });
            }
            Note::MissedDeadlines(number) => self.statistics.missed_deadlines += number,
            _ => {}
        }
        self.account.event(noted.event());
        if let Some(recording) = &mut self.recording {
            recording.note(noted);
        }
    }

    /// Rows that have not been shown yet.
    pub fn rows(&mut self) -> &mut Rows {
        &mut self.rows
    }

    /// Whether its loop runs.
    pub fn is_running(&self) -> bool {
        self.thread.is_some()
    }

    /// Returns the cause of a zero force, if there is one.
    pub fn safety_stop(&self) -> Option<&Stopped> {
        self.safety_stop.as_ref()
    }

    /// Ends a trip that stays.
    pub fn rearm(&self) {
        if let Some(thread) = &self.thread {
            thread.rearm();
        }
    }

    /// Changes the rendering and its method from now on.
    ///
    /// # Errors
    /// A message about settings that cannot change while the loop runs.
    pub fn change(&mut self, method: MethodName, rendering: Rendering) -> Result<(), String> {
        if let Some(parameters) = self.thread.as_mut().and_then(LoopThread::parameters) {
            parameters
                .change(rendering)
                .map_err(|error| error.to_string())?;
        }
        if self.chosen.last() != Some(&method) {
            self.chosen.push(method);
            // A page switches between a few.
            let surplus = self.chosen.len().saturating_sub(MAX_CHOSEN);
            self.chosen.drain(..surplus);
        }
        Ok(())
    }

    /// The choice behind the name of a method that the loop gives: HFCR without dissipation has two.
    fn chosen_as(&self, name: &str) -> Option<MethodName> {
        let method = MethodName::named(name)?;
        let is_it = |chosen: &&MethodName| {
            **chosen == method || (method == MethodName::Hfcr && **chosen == MethodName::HfcrModSt)
        };
        let newest = self.chosen.iter().rev().find(is_it);
        Some(newest.copied().unwrap_or(method))
    }

    /// Number of the parameters that were handed over last.
    pub fn generation(&mut self) -> u32 {
        self.thread
            .as_mut()
            .and_then(LoopThread::parameters)
            .map_or(0, |parameters| parameters.generation())
    }

    /// Returns the device position at the last tick `[m]`.
    pub fn position(&self) -> Option<f64> {
        let position = self.account.last?.contact.device_position;
        position.is_finite().then_some(position)
    }

    /// Time of the last tick `[s]`.
    pub fn time(&self) -> f64 {
        self.account.last.map_or(0.0, |row| row.tick.time)
    }

    /// The recording that is being made.
    pub fn recording(&self) -> Option<&LaneRecording> {
        self.recording.as_ref()
    }

    /// Records from now on.
    pub fn record(&mut self, recording: LaneRecording) {
        self.recording = Some(recording);
    }

    /// Records no more.
    pub fn end_recording(&mut self) -> Option<Ending> {
        self.recording.take().map(LaneRecording::end)
    }

    /// Records no more, since the loop is over.
    pub fn end_recording_with_loop(&mut self) -> Option<Ending> {
        let recording = self.recording.take()?;
        self.recorded = Some(recording.path().to_path_buf());
        Some(recording.end_with_loop(&self.listener.counted()))
    }

    /// The recording that ended with the loop.
    pub fn recorded(&self) -> Option<&Path> {
        self.recorded.as_deref()
    }

    /// Returns the capabilities of the device.
    pub fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    /// Returns the scheduling that the system granted.
    pub fn answers(&self) -> Vec<Answer> {
        self.answers.clone()
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
        LaneStatus {
            t_s: self.time(),
            ticks: self.statistics.ticks,
            missed_deadlines: self.statistics.missed_deadlines,
            without_sample: self.statistics.without_sample,
            supervisor_cuts: cuts,
            lateness_s: spread(&self.statistics.lateness),
            tick_s: spread(&self.statistics.tick),
            unsent: self.unsent(),
        }
    }

    /// Returns the number of lost ticks; the most recent ones are known only after the loop has ended.
    fn unsent(&self) -> u64 {
        let made = self.end.as_ref().map_or(0, |end| end.statistics.ticks);
        self.heard.missing + made.saturating_sub(self.heard.next)
    }

    /// Returns the end of the loop, if it has ended.
    pub fn end(&self) -> Option<&Ended> {
        self.end.as_ref()
    }

    /// Waits for a loop that has been stopped, and processes all its messages.
    pub fn finish(&mut self, note: impl FnMut(&LoopEvent)) {
        if let Some(thread) = self.thread.take() {
            self.end = Some(thread.join());
        }
        self.listen(note);
    }

    /// The device of a loop that has ended, if it can be used again.
    pub fn into_device(self) -> Option<Placed> {
        let end = self.end?;
        let usable = matches!(
            end.ending,
            palpate_rt::Ending::Stopped | palpate_rt::Ending::Complete
        );
        drop(end);
        let device = self.returned.try_recv().ok().filter(|_| usable)?;
        Some(Placed {
            device,
            axis: self.axis,
        })
    }

    /// Returns the received data of the loop, and its end.
    pub fn into_account(self) -> Option<(Account, Ended, Vec<Answer>)> {
        let mut account = self.account;
        account.counted(&self.listener.counted());
        Some((account, self.end?, self.answers))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_ticks_are_counted_by_sequence_number() {
        let mut heard = ClientMessage::default();
        for sequence in [2, 3, 4, 7, 8] {
            heard.hear(sequence);
        }
        assert_eq!(heard.missing, 4);
    }
}
