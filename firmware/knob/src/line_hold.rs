//! Holds the lines of a host between its messages.

use crate::Drive;

/// A force that changes linearly over the period of a host, for the sample of one of its ticks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HostLine {
    /// Number of the tick at which the host's sample was taken.
    pub sampled: u32,
    /// Mean of the force on the rim `[N]`.
    pub mean: f32,
    /// Slope of the force `[N/s]`.
    pub slope: f32,
}

/// Parameters of a [`LineHold`].
#[derive(Clone, Copy, Debug)]
pub struct LineHoldParams {
    /// Period of a tick `[s]`.
    pub period: f32,
    /// Duration of a line in ticks: the period of the host.
    pub ticks: u32,
    /// Ticks from the sample to the beginning of its line, at most `2 ticks`. The host has this delay in its model.
    pub lead: u32,
    /// Ticks after the end of a line from which a silent host's force is 0.
    pub silent_after: u32,
    /// Duration of the soft start `[s]`, greater than 0.
    pub soft_start: f32,
    /// The motor driver.
    pub drive: Drive,
}

/// Motor of a knob that is rendered by a host at 100 to 1000 Hz. The board ticks faster and holds the host's line.
///
/// Each line has its place in time, whenever its message arrives: it begins `lead` ticks after its sample, and its last
/// value is held from its end to the next line. A late line begins late, but ends in time.
#[derive(Clone, Copy, Debug)]
pub struct LineHold {
    params: LineHoldParams,
    line: Option<HostLine>,
    /// Lines that begin later, in their order.
    next: [Option<HostLine>; 2],
    /// Factor of the soft start on the force, 0 to 1.
    share: f32,
}

impl LineHold {
    /// Creates a motor without a force.
    pub fn new(params: LineHoldParams) -> Self {
        Self {
            params,
            line: None,
            next: [None; 2],
            share: 0.0,
        }
    }

    /// Takes a message of the host, which waits behind the one before it. Two can wait; a third replaces the second.
    pub fn take(&mut self, line: HostLine) {
        let [first, second] = &mut self.next;
        if first.is_none() {
            *first = Some(line);
        } else {
            *second = Some(line);
        }
    }

    /// Returns the duty of the period that begins with the tick after `tick`. It does not panic or wait.
    pub fn tick(&mut self, tick: u32) -> i16 {
        let begins = tick.wrapping_add(1);
        for _ in 0..self.next.len() {
            let [first, second] = self.next;
            if first.is_some_and(|first| self.age(&first, begins) >= 0) {
                (self.line, self.next) = (first, [second, None]);
            }
        }
        let Some(line) = self.line else {
            return 0;
        };
        let age = self.age(&line, begins).unsigned_abs();
        if age >= self.params.ticks.saturating_add(self.params.silent_after) {
            // A later line comes in with a soft start.
            *self = Self::new(self.params);
            return 0;
        }
        let rise = self.params.period / self.params.soft_start;
        self.share = (self.share + rise).min(1.0);
        self.params.drive.duty(self.share * self.force(&line, age))
    }

    /// Returns the mean force `[N]` over the tick of this `age`.
    fn force(&self, line: &HostLine, age: u32) -> f32 {
        let length = self.params.ticks as f32;
        let middle = (age as f32 + 0.5).min(length);
        line.mean + line.slope * (middle - 0.5 * length) * self.params.period
    }

    /// Returns the age of a line at `tick`, below 0 before it begins; tick numbers wrap.
    fn age(&self, line: &HostLine, tick: u32) -> i32 {
        let begins = line.sampled.wrapping_add(self.params.lead);
        tick.wrapping_sub(begins).cast_signed()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    const PARAMS: LineHoldParams = LineHoldParams {
        period: 0.000_25,
        ticks: 8,
        lead: 2,
        silent_after: 20,
        soft_start: 0.000_25,
        drive: Drive {
            full_force: 20.0,
            full_duty: 1000,
        },
    };

    fn line(sampled: u32) -> HostLine {
        HostLine {
            sampled,
            mean: 4.0,
            slope: 1000.0,
        }
    }

    /// Duty of the mean of a line over the tick of this age: 2 ms at 1000 N/s around 4 N.
    fn expected(age: u32) -> i16 {
        PARAMS
            .drive
            .duty(4.0 + 1000.0 * 0.000_25 * (age as f32 + 0.5 - 4.0))
    }

    #[test]
    fn a_line_begins_after_its_lead_and_keeps_its_last_value() {
        for start in [0, u32::MAX - 3] {
            let mut hold = LineHold::new(PARAMS);
            hold.take(line(start));
            let mut tick = start;
            let mut next = || {
                let duty = hold.tick(tick);
                tick = tick.wrapping_add(1);
                duty
            };
            // The duty of the tick after the sample's.
            assert_eq!(next(), 0);
            for age in 0..8 {
                assert_eq!(next(), expected(age));
            }
            // 4 N and half of the 2 N of its rise.
            for _ in 0..20 {
                assert_eq!(next(), 250);
            }
            for _ in 0..5 {
                assert_eq!(next(), 0);
            }
        }
    }

    #[test]
    fn a_late_line_ends_in_time() {
        let mut hold = LineHold::new(PARAMS);
        hold.take(line(0));
        let duties = (0..10).map(|tick| hold.tick(tick));
        assert_eq!(duties.last(), Some(250));
        // The message for the sample of tick 8 arrives 5 ticks late.
        for tick in 10..14 {
            assert_eq!(hold.tick(tick), 250);
        }
        hold.take(line(8));
        assert_eq!(hold.tick(14), expected(5));
        assert_eq!(hold.tick(15), expected(6));
        assert_eq!(hold.tick(16), expected(7));
        assert_eq!(hold.tick(17), 250);
    }

    /// A line that waits is not lost when the next message arrives before it begins.
    #[test]
    fn every_line_is_held_with_a_lead_longer_than_a_line() {
        for lead in [PARAMS.ticks, PARAMS.ticks + 3, 2 * PARAMS.ticks] {
            let mut hold = LineHold::new(LineHoldParams { lead, ..PARAMS });
            for tick in 0..64 {
                if tick % PARAMS.ticks == 0 {
                    hold.take(HostLine {
                        mean: (tick / PARAMS.ticks) as f32,
                        slope: 0.0,
                        ..line(tick)
                    });
                }
                let number = (tick + 1).saturating_sub(lead) / PARAMS.ticks;
                let expected = PARAMS.drive.duty(number as f32);
                assert_eq!(hold.tick(tick), expected, "lead {lead}, tick {tick}");
            }
        }
        // Of two messages that arrive together the older one is held until the newer one begins.
        let mut hold = LineHold::new(PARAMS);
        hold.take(line(0));
        hold.take(line(8));
        assert_eq!(hold.tick(8), expected(7));
        assert_eq!(hold.tick(9), expected(0));
    }

    #[test]
    fn a_host_that_returns_comes_in_softly_and_no_force_exceeds_the_drive() {
        let params = LineHoldParams {
            soft_start: 0.001,
            ..PARAMS
        };
        let mut hold = LineHold::new(params);
        hold.take(HostLine {
            slope: 0.0,
            ..line(0)
        });
        let duties: Vec<i16> = (0..8).map(|tick| hold.tick(tick)).collect();
        assert_eq!(duties, [0, 50, 100, 150, 200, 200, 200, 200]);
        for (mean, slope) in [(1e30, -1e30), (f32::NAN, 0.0), (3.0, f32::INFINITY)] {
            let mut hold = LineHold::new(params);
            hold.take(HostLine {
                sampled: 0,
                mean,
                slope,
            });
            for tick in 0..40 {
                assert!(hold.tick(tick).abs() <= 1000);
            }
        }
    }
}
