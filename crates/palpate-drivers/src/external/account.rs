//! Account of the messages of a session: which sample is fresh, what is missing, and how long an answer takes.

use std::time::Duration;

use palpate_device::Connection;
use palpate_rt::Durations;

use super::protocol::Sample;
use crate::device_time::{DeviceTime, Stamp};

/// Number of stored send times: more than the messages of [`answers_within`] at 4 kHz.
const REMEMBERED: usize = 1024;
/// Number of earlier samples whose late arrival and repetition are distinguished.
const WINDOW: u64 = 64;
/// Longest time from a message to its answer. A later answer counts as missing.
pub fn answers_within(period: Duration, sends_every: Option<Duration>) -> Duration {
    let longest = period.max(sends_every.unwrap_or_default());
    longest.saturating_mul(3).max(Duration::from_millis(10))
}

/// Use of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Taken {
    /// It is fresh, sampled at this time of the loop's clock.
    Fresh(Duration),
    /// It counts as missing.
    Missing,
    /// The device's time is not in seconds.
    NotSeconds,
}

/// Messages of a session.
#[derive(Debug)]
pub struct Account {
    /// Whether the device answers requests; otherwise it sends samples by itself.
    answers_requests: bool,
    answers_within: Duration,
    /// Age of an unanswered request at which it is repeated once, because a message may be lost.
    repeats_after: Duration,
    has_repeated: bool,
    /// Number of the last message to the device.
    sent: u64,
    sent_at: [Duration; REMEMBERED],
    /// Request without an answer.
    asked: Option<u64>,
    /// Number of the newest sample, and a bit for each of the [`WINDOW`] before it.
    newest: Option<u64>,
    window: u64,
    /// Largest number of a message that the device has answered.
    answered: u64,
    time: DeviceTime,
    is_old_by_its_clock: bool,
    round_trips: Durations,
    counts: Connection,
}

impl Account {
    /// Creates the account of a loop of `period` on a device that sends samples by itself every `sends_every`, or
    /// answers requests. `loses`: messages may be lost on their way.
    pub fn new(period: Duration, sends_every: Option<Duration>, loses: bool) -> Self {
        let answers_within = answers_within(period, sends_every);
        Self {
            answers_requests: sends_every.is_none(),
            answers_within,
            // In the next tick, also if that is a little early.
            repeats_after: if loses {
                period.mul_f64(0.75)
            } else {
                answers_within
            },
            has_repeated: false,
            sent: 0,
            sent_at: [Duration::ZERO; REMEMBERED],
            asked: None,
            newest: None,
            window: 0,
            answered: 0,
            time: DeviceTime::default(),
            is_old_by_its_clock: false,
            round_trips: Durations::new(),
            counts: Connection::default(),
        }
    }

    /// Returns the number of the next message, sent at `now`.
    pub fn sends(&mut self, now: Duration) -> u64 {
        self.sent += 1;
        let place = self.place(self.sent);
        if let Some(at) = self.sent_at.get_mut(place) {
            *at = now;
        }
        self.sent
    }

    /// Begins the count, after samples that were only for the opening.
    pub fn begins(&mut self) {
        self.counts = Connection::default();
        self.newest = None;
        self.window = 0;
        self.asked = None;
    }

    /// Returns the number of a request for a sample. `None`: the device sends by itself, or it owes an answer that may
    /// still come, and further requests would only make it later.
    pub fn asks(&mut self, now: Duration) -> Option<u64> {
        if !self.answers_requests {
            return None;
        }
        if let Some(asked) = self.asked {
            let patience = if self.has_repeated {
                self.answers_within
            } else {
                self.repeats_after
            };
            if now.saturating_sub(self.at(asked)) <= patience {
                return None;
            }
            self.counts.lost += 1;
            self.has_repeated = true;
        }
        let number = self.sends(now);
        self.asked = Some(number);
        Some(number)
    }

    /// Whether an answer is expected soon.
    pub fn is_waiting(&self) -> bool {
        self.asked.is_some()
    }

    /// Counts an invalid message.
    pub fn garbage(&mut self) {
        self.counts.unreadable += 1;
    }

    /// Counts a command that the device did not take.
    pub fn untaken(&mut self) {
        self.counts.untaken += 1;
    }

    /// Takes a sample that arrived at `now`.
    pub fn takes(&mut self, sample: &Sample, now: Duration) -> Taken {
        if sample.answers > self.sent {
            self.garbage();
            return Taken::Missing;
        }
        if !self.is_next(sample.number) {
            return Taken::Missing;
        }
        let is_in_time = if self.answers_requests {
            self.answers_the_request(sample.answers, now)
        } else {
            self.follows_commands(sample.answers, now)
        };
        let stamp = match sample.time {
            Some(time) => self.time.of(time, now),
            None => Stamp::At(now),
        };
        self.is_old_by_its_clock = is_in_time
            && matches!(stamp, Stamp::At(stamp) if now.saturating_sub(stamp) > self.answers_within);
        match stamp {
            Stamp::At(stamp) if is_in_time && now.saturating_sub(stamp) <= self.answers_within => {
                self.counts.samples += 1;
                Taken::Fresh(stamp)
            }
            Stamp::At(_) => {
                self.counts.late += 1;
                Taken::Missing
            }
            Stamp::NotLater => {
                self.garbage();
                Taken::Missing
            }
            Stamp::NotSeconds => Taken::NotSeconds,
        }
    }

    /// Whether the last sample arrived in time, and was too old only by the device's clock.
    pub fn is_old_by_its_clock(&self) -> bool {
        self.is_old_by_its_clock
    }

    /// Returns whether the sample is newer than all before, and counts those between.
    fn is_next(&mut self, number: u64) -> bool {
        let Some(newest) = self.newest else {
            self.newest = Some(number);
            return true;
        };
        if number > newest {
            let ahead = number - newest;
            // The bit of the newest sample is behind those of the window.
            self.window = match ahead {
                1..WINDOW => (self.window << ahead) | (1 << (ahead - 1)),
                WINDOW => 1 << (WINDOW - 1),
                _ => 0,
            };
            self.newest = Some(number);
            if !self.answers_requests {
                self.counts.lost += ahead - 1;
            }
            return true;
        }
        let behind = newest - number;
        let bit = match behind {
            1..=WINDOW => 1 << (behind - 1),
            _ => 0,
        };
        if behind == 0 || self.window & bit != 0 {
            self.counts.duplicate += 1;
        } else {
            self.window |= bit;
            self.counts.reordered += 1;
            if !self.answers_requests {
                self.counts.lost = self.counts.lost.saturating_sub(1);
            }
        }
        false
    }

    /// Returns whether this answers a request in time.
    fn answers_the_request(&mut self, answers: u64, now: Duration) -> bool {
        let age = now.saturating_sub(self.at(answers));
        if self.asked == Some(answers) {
            self.asked = None;
            self.has_repeated = false;
        } else {
            // The request was given up, and its answer comes after all.
            self.counts.lost = self.counts.lost.saturating_sub(1);
        }
        self.round_trips.add(age);
        age <= self.answers_within
    }

    /// Returns whether the device receives the commands: it has answered every one that is old enough.
    fn follows_commands(&mut self, answers: u64, now: Duration) -> bool {
        if answers > self.answered {
            self.answered = answers;
            self.round_trips.add(now.saturating_sub(self.at(answers)));
        }
        let next = answers + 1;
        next > self.sent || now.saturating_sub(self.at(next)) <= self.answers_within
    }

    /// Returns when a message was sent; 0 if that is forgotten.
    fn at(&self, number: u64) -> Duration {
        let is_kept = number > 0 && number + REMEMBERED as u64 > self.sent;
        let at = self.sent_at.get(self.place(number)).copied();
        at.filter(|_| is_kept).unwrap_or_default()
    }

    #[allow(clippy::cast_possible_truncation, reason = "a remainder is small")]
    fn place(&self, number: u64) -> usize {
        (number % REMEMBERED as u64) as usize
    }

    /// Returns the statistics.
    pub fn connection(&self) -> Connection {
        let times = &self.round_trips;
        let round_trip = (times.count() > 0)
            .then(|| [times.quantile(0.5), times.quantile(0.99), times.longest()]);
        Connection {
            round_trip,
            ..self.counts
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: Duration = Duration::from_millis(1);

    fn sample(number: u64, answers: u64) -> Sample {
        Sample {
            number,
            answers,
            time: None,
            position: [0.0; 3],
            orientation: None,
        }
    }

    /// An account of a device that sends every 1 ms, which has received a command at each of the first 20 ms.
    fn sending() -> Account {
        let mut account = Account::new(MS, Some(MS), true);
        for at in 1..=20 {
            account.sends(MS * at);
        }
        account
    }

    #[test]
    fn gaps_are_lost_until_they_arrive_out_of_order_and_repetitions_are_told_apart() {
        let mut account = sending();
        let now = MS * 20;
        for number in [5, 6, 9] {
            assert_eq!(account.takes(&sample(number, 20), now), Taken::Fresh(now));
        }
        assert_eq!(account.connection().lost, 2);
        for number in [7, 7, 9, 6] {
            assert_eq!(account.takes(&sample(number, 20), now), Taken::Missing);
        }
        let found = account.connection();
        assert_eq!(
            (found.samples, found.lost, found.reordered, found.duplicate),
            (3, 1, 1, 3)
        );
        // A jump beyond the window.
        account.takes(&sample(9 + WINDOW, 20), now);
        account.takes(&sample(9, 20), now);
        account.takes(&sample(500, 20), now);
        account.takes(&sample(9, 20), now);
        let found = account.connection();
        assert_eq!((found.duplicate, found.reordered), (4, 2));
    }

    #[test]
    fn a_device_that_does_not_hear_the_commands_sends_no_sample() {
        let mut account = sending();
        // The command 2 is 18 ms old, and unanswered.
        assert_eq!(account.takes(&sample(1, 1), MS * 20), Taken::Missing);
        assert_eq!(account.takes(&sample(2, 8), MS * 20), Taken::Missing);
        assert_eq!(
            account.takes(&sample(3, 15), MS * 20),
            Taken::Fresh(MS * 20)
        );
        // Of a message that was never sent.
        assert_eq!(account.takes(&sample(4, 21), MS * 20), Taken::Missing);
        let found = account.connection();
        assert_eq!((found.late, found.unreadable, found.samples), (2, 1, 1));
        assert_eq!(found.round_trip.unwrap()[2].as_millis(), 19);
    }

    #[test]
    fn a_request_is_repeated_only_when_it_is_given_up() {
        let mut account = Account::new(MS, None, false);
        assert_eq!(account.asks(MS), Some(1));
        assert_eq!(account.asks(MS * 2), None);
        assert_eq!(account.takes(&sample(1, 1), MS * 2), Taken::Fresh(MS * 2));
        assert_eq!(account.asks(MS * 3), Some(2));
        assert_eq!(account.asks(MS * 14), Some(3));
        assert_eq!(account.connection().lost, 1);
        // The answer to the first of the two is late, not lost; the answer to the second is a sample.
        assert_eq!(account.takes(&sample(2, 2), MS * 15), Taken::Missing);
        assert_eq!(account.takes(&sample(3, 3), MS * 15), Taken::Fresh(MS * 15));
        let found = account.connection();
        assert_eq!((found.lost, found.late, found.samples), (0, 1, 2));
        assert_eq!(found.round_trip.unwrap()[2].as_millis(), 12);
    }

    #[test]
    fn a_request_that_may_be_lost_is_repeated_once() {
        let mut account = Account::new(MS, None, true);
        let asked = [1, 2, 3, 12, 13].map(|at| account.asks(MS * at));
        assert_eq!(asked, [Some(1), Some(2), None, None, Some(3)]);
        // The answer to the first is too late, that to the second is not the last one but in time.
        assert_eq!(account.takes(&sample(1, 1), MS * 13), Taken::Missing);
        assert_eq!(account.takes(&sample(2, 3), MS * 14), Taken::Fresh(MS * 14));
        let found = account.connection();
        assert_eq!((found.lost, found.late, found.samples), (1, 1, 1));
        let asked = [15, 16].map(|at| account.asks(MS * at));
        assert_eq!(asked, [Some(4), Some(5)]);
        assert_eq!(account.takes(&sample(3, 4), MS * 16), Taken::Fresh(MS * 16));
        assert_eq!(account.connection().lost, 1);
    }
}
