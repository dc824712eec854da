//! Time without a delivered force.

use std::time::Duration;

use palpate_record::recording::LoopTime;

/// Accumulates the time with the motors off. It counts time and not ticks, because a stalled loop makes no ticks.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MotorsOff {
    time: LoopTime,
    /// End of the accumulated time; `None` before the first tick and after the outputs were disabled.
    until: Option<Duration>,
    /// Whether the motors are off from then on.
    is_off: bool,
    /// Time at which a supervisor or watchdog process has since removed the force.
    cut: Option<Duration>,
    /// Interval in which a force was assumed to be delivered up to the last command.
    last_on: Option<(Duration, Duration)>,
    /// Current uninterrupted time with the motors off.
    unbroken: Duration,
}

impl MotorsOff {
    /// Records that a supervisor or watchdog process removed the force at `at`. The earliest time counts. The report
    /// may arrive one tick late: a watchdog's report is not readable while a supervisor uses the port, and no report
    /// is read during a stall within a tick.
    pub fn cut(&mut self, at: Duration) {
        self.cut = Some(self.cut.map_or(at, |before| before.min(at)));
        if let Some((from, to)) = self.last_on {
            let since = at.max(from);
            let more = to.saturating_sub(since);
            self.time.motors_off += more;
            // A force commanded since then would have ended it.
            if self.is_off {
                self.unbroken += more;
            }
            self.last_on = Some((from, since.min(to)));
        }
    }

    /// Records that a tick started at `began` and commanded its force at `ended`: zero if `is_off`.
    pub fn tick(&mut self, began: Duration, ended: Duration, is_off: bool) {
        let from = self.until.unwrap_or(began);
        let off_from = if self.is_off {
            from
        } else {
            self.cut.map_or(ended, |cut| cut.max(from))
        };
        self.time.lasted += ended.saturating_sub(from);
        // Usually zero.
        let off_for = ended.saturating_sub(off_from);
        self.time.motors_off += off_for;
        self.unbroken = match (self.is_off, is_off) {
            (true, true) => self.unbroken + off_for,
            (false, true) => off_for,
            (_, false) => Duration::ZERO,
        };
        self.last_on = Some((from, off_from.min(ended)));
        self.until = Some(ended);
        self.is_off = is_off;
        self.cut = None;
    }

    /// Ends or pauses the accumulation; later time does not count.
    pub fn disable_output(&mut self) {
        let Self { time, .. } = *self;
        *self = Self {
            time,
            ..Self::default()
        };
    }

    /// Returns the accumulated times.
    pub fn time(&self) -> LoopTime {
        self.time
    }

    /// Returns the uninterrupted time without a delivered force at the end of the last tick.
    pub fn unbroken(&self) -> Duration {
        self.unbroken
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn ms(count: u64) -> Duration {
        Duration::from_millis(count)
    }

    #[test]
    fn what_is_unbroken_ends_with_the_next_force_and_begins_with_a_cut() {
        let mut off = MotorsOff::default();
        let mut unbroken = |began, ended, is_off| {
            off.tick(ms(began), ms(ended), is_off);
            off.unbroken().as_millis()
        };
        assert_eq!(unbroken(10, 11, true), 0);
        assert_eq!(unbroken(20, 21, true), 10);
        assert_eq!(unbroken(30, 31, false), 0);
        assert_eq!(unbroken(40, 41, true), 0);
        off.cut(ms(35));
        assert_eq!(off.unbroken(), ms(6));
        off.tick(ms(50), ms(51), true);
        assert_eq!(off.unbroken(), ms(16));
        off.cut(ms(60));
        off.tick(ms(3000), ms(3000), false);
        assert_eq!(off.unbroken(), ms(0));
    }

    fn after(ticks: impl FnOnce(&mut MotorsOff)) -> (u128, u128) {
        let mut off = MotorsOff::default();
        ticks(&mut off);
        let LoopTime { lasted, motors_off } = off.time();
        (lasted.as_millis(), motors_off.as_millis())
    }

    #[test]
    fn motors_off_time_spans_stop_command_to_next_force() {
        let came_back = after(|off| {
            off.tick(ms(10), ms(11), false);
            off.tick(ms(20), ms(21), true);
            off.tick(ms(30), ms(31), true);
            off.tick(ms(40), ms(41), false);
            off.tick(ms(50), ms(51), false);
        });
        assert_eq!(came_back, (41, 20));
    }

    /// One tick and a stall of 3 s.
    #[test]
    fn a_stall_counts_from_when_the_force_was_taken_off() {
        let stalled = after(|off| {
            off.tick(ms(0), ms(0), false);
            off.cut(ms(3004));
            off.cut(ms(4));
            off.cut(ms(3005));
            off.tick(ms(3006), ms(3006), true);
            off.tick(ms(3007), ms(3007), false);
        });
        assert_eq!(stalled, (3007, 3003));
        let was_off_before = after(|off| {
            off.tick(ms(0), ms(0), true);
            off.cut(ms(4));
            off.tick(ms(100), ms(100), true);
        });
        assert_eq!(was_off_before, (100, 100));
        // The supervisor's report arrives first, the earlier cut of the watchdog in the next tick.
        let reported_late = after(|off| {
            off.tick(ms(0), ms(0), false);
            off.cut(ms(3004));
            off.tick(ms(1), ms(3006), true);
            off.cut(ms(4));
            off.cut(ms(4));
            off.tick(ms(3007), ms(3007), false);
        });
        assert_eq!(reported_late, (3007, 3003));
        // A stall within a tick that commands a force at its end.
        let within_a_tick = after(|off| {
            off.tick(ms(0), ms(0), false);
            off.tick(ms(1), ms(3000), false);
            off.cut(ms(4));
            off.cut(ms(5));
            assert_eq!(off.unbroken(), ms(0));
            off.tick(ms(3001), ms(3001), true);
        });
        assert_eq!(within_a_tick, (3001, 2997));
    }

    #[test]
    fn a_pause_between_two_runs_counts_as_neither() {
        let paused = after(|off| {
            off.tick(ms(0), ms(1), true);
            off.disable_output();
            off.tick(ms(1000), ms(1001), false);
        });
        assert_eq!(paused, (2, 0));
    }
}
