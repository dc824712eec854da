//! Phases of a tick after the devices were read.

use std::time::Duration;

use palpate_core::Fault;
use palpate_record::recording::{ContactTick, Flags, Row, Tick};

use super::ControlLoop;
use crate::note::Note;
use crate::rendering::Renders;
use palpate_device::Device;
use palpate_device::clock::Clock;

/// Instants of a tick, on the loop's clock.
pub(super) struct TickTimes {
    /// Deadline of the tick.
    pub deadline: Duration,
    /// Time at which the loop woke.
    pub woke: Duration,
    /// Time of the last device's answer.
    pub answered: Duration,
    /// Time after the command.
    pub ended: Duration,
}

/// Result of rendering in a tick.
pub(super) struct RenderedStep {
    /// Whether all devices had a fresh sample.
    are_fresh: bool,
    /// Time since the last rendered sample `[s]`, if known.
    elapsed: Option<f64>,
    /// Reason for rejecting the sample, if the renderer rejected it.
    fault: Option<Fault>,
}

impl<D: Device, C: Clock, R: Renders> ControlLoop<D, C, R> {
    /// Returns whether the loop stalled between the last tick at `before` and the devices' answer, and records cuts by
    /// a supervisor or a watchdog. `was_cut`: whether the supervisor had cut the loop before the read.
    #[inline]
    pub(super) fn detect_stall(
        &mut self,
        before: Option<Duration>,
        woke: Duration,
        answered: Duration,
        mut was_cut: bool,
    ) -> bool {
        let has_overslept = self.has_overslept(before, woke);
        // The read of a device may have caused the stall.
        was_cut |= self.supervisor_cut();
        let stood_still_in_read = answered.saturating_sub(woke) > self.stall_limit;
        if has_overslept || stood_still_in_read || was_cut {
            // Check only after the read: a device detects its watchdog's command in a read. A supervisor that stalled
            // together with the loop acts too late.
            let in_read = stood_still_in_read && !has_overslept;
            let since = before.filter(|_| !in_read).unwrap_or(woke);
            was_cut |= self.watchdog_cut(since);
        }
        let stalled = has_overslept || was_cut;
        if was_cut {
            self.record_cuts();
        }
        stalled
    }

    /// Renders the samples if all of them are fresh; otherwise counts a tick without a sample.
    #[inline]
    pub(super) fn render_or_wait(&mut self, stalled: bool) -> RenderedStep {
        let are_fresh = self.devices.are_fresh();
        let mut elapsed = None;
        let mut fault = None;
        if are_fresh {
            elapsed = self.elapsed();
            let answer = self.render(elapsed, stalled);
            fault = answer.fault;
            self.statistics.crowded += u64::from(answer.is_crowded);
        } else {
            self.statistics.without_sample += u64::from(self.devices.lack_a_sample());
            self.devices.go_without(stalled);
        }
        RenderedStep {
            are_fresh,
            elapsed,
            fault,
        }
    }

    /// Reports safety stops and a newly learned delay, and withdraws the force if the supervisor has cut the loop.
    #[inline]
    pub(super) fn report_stops(&mut self, woke: Duration) {
        self.send_safety_stops();
        let (lateness, period) = (self.rendered.learned_lateness(), self.rendered.period());
        if let Some(lateness) = self.lateness.news(lateness, period, woke) {
            self.note(Note::LearnedLateness(lateness));
        }
        if self.supervisor_cut() {
            self.record_cuts();
            // The force that the supervisor has just removed must not be commanded again.
            self.devices.stall();
            self.send_safety_stops();
        }
    }

    /// Counts and reports a rejected sample.
    #[inline]
    pub(super) fn count_refusals(&mut self, step: &RenderedStep) {
        if let Some(fault) = step.fault {
            self.statistics.refused += 1;
            self.statistics.refused_at_end += 1;
            self.note(Note::Fault(fault));
        } else if step.are_fresh {
            self.statistics.refused_at_end = 0;
        }
    }

    /// Ends the period after the command. Returns the number of missed deadlines.
    #[inline]
    pub(super) fn end_period(&mut self, times: &TickTimes) -> u64 {
        let (woke, ended) = (times.woke, times.ended);
        let missed = self.deadlines.as_mut().map_or(0, |d| d.ended(woke, ended));
        if missed > 0 {
            self.note(Note::MissedDeadlines(missed));
        }
        self.is_off = self.devices.are_off();
        if ended.saturating_sub(times.answered) > self.stall_limit {
            self.watchdog_cut(woke);
            self.record_cuts();
        }
        self.motors_off.tick(woke, ended, self.is_off);
        missed
    }

    /// Accounts for the delivered force and returns the recorded data of the tick.
    #[inline]
    pub(super) fn tick_data(
        &mut self,
        times: &TickTimes,
        step: &RenderedStep,
        missed: u64,
    ) -> Tick {
        let TickTimes {
            deadline,
            woke,
            answered,
            ended,
        } = *times;
        let flags = Flags::default()
            .with(Flags::FAULT, step.fault.is_some())
            .with(Flags::SAFETY_LIMITED, self.devices.are_bounded())
            .with(Flags::SAFETY_STOPPED, self.is_off)
            .with(Flags::MISSED_DEADLINE, missed > 0)
            .with(Flags::DEVICE_FAULT, !step.are_fresh);
        let (commanded, delivered) = self.devices.first_wrenches();
        self.rendered
            .account(self.teller.sequence, delivered.wrench.force);
        Tick {
            lateness: woke.as_secs_f64() - deadline.as_secs_f64(),
            period: step.elapsed.unwrap_or(f64::NAN),
            commanded_force: commanded.force,
            commanded_torque: commanded.torque,
            delivered_force: delivered.wrench.force,
            delivered_slope: delivered.slope,
            delivered_torque: delivered.wrench.torque,
            tick_duration: (ended - answered).as_secs_f64(),
            device_round_trip: (answered - woke).as_secs_f64(),
            created_energy: self.rendered.created_energy(),
            flags: flags.with(self.rendered.flags(), true),
            ..self.seen(woke)
        }
    }

    /// Adds the tick and its durations to the statistics.
    #[inline]
    pub(super) fn count_tick(&mut self, times: &TickTimes, missed: u64) {
        let TickTimes {
            deadline,
            woke,
            answered,
            ended,
        } = *times;
        self.statistics.ticks += 1;
        self.statistics.missed_deadlines += missed;
        self.statistics.motors_off += u64::from(self.is_off);
        self.statistics.time = self.motors_off.time();
        self.statistics.off_at_end = self.motors_off.unbroken();
        self.statistics.lateness.add(woke - deadline.min(woke));
        self.statistics.tick.add(ended - answered);
        self.statistics.round_trip.add(answered - woke);
    }

    /// Sends the tick to the tap and returns its row.
    #[inline]
    pub(super) fn pass_on(&mut self, tick: Tick) -> Row {
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
}
