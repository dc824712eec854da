//! Non-blocking state shared by the loop's thread, the reader and the writer.

use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use palpate_device::{DeviceError, DeviceErrorKind, Vector};

use super::super::fitness::Unfit;

/// Command of the loop.
#[derive(Clone, Copy, Debug)]
pub(super) struct Order {
    /// Counts from 1; 0: no order yet.
    pub number: u64,
    /// Force `[N]`.
    pub force: Vector,
    /// Time on the loop's clock.
    pub at: Duration,
}

/// Sample of the device position.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arrival {
    /// Counts from 1; 0: no sample yet.
    pub number: u64,
    /// Position `[m]`.
    pub position: Vector,
    /// Time of arrival of the frame, on the loop's clock.
    pub time: Duration,
}

/// Reason why the device receives no force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Cause {
    /// The connection is cut.
    Cut = 1,
    /// The service closed the connection.
    Closed,
    /// No frame arrived for too long.
    Silent,
    /// The frames no longer contain the device.
    DeviceGone,
    /// The service reported that the device was unplugged.
    Unplugged,
    /// Invalid frames arrive.
    Unreadable,
    /// The safety system of the device acted.
    Safety,
    NoPower,
    NotStarted,
    NotCalibrated,
    NotReady,
}

impl Cause {
    const ALL: [Self; 11] = [
        Self::Cut,
        Self::Closed,
        Self::Silent,
        Self::DeviceGone,
        Self::Unplugged,
        Self::Unreadable,
        Self::Safety,
        Self::NoPower,
        Self::NotStarted,
        Self::NotCalibrated,
        Self::NotReady,
    ];

    fn new(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|cause| *cause as u8 == code)
    }

    /// Returns whether only a new connection helps.
    fn is_final(self) -> bool {
        matches!(
            self,
            Self::Cut | Self::Closed | Self::Silent | Self::DeviceGone | Self::Unplugged
        )
    }

    fn error(self) -> DeviceError {
        let kind = if self.is_final() {
            DeviceErrorKind::Disconnected
        } else {
            DeviceErrorKind::Refused
        };
        DeviceError::new(
            kind,
            match self {
                Self::Cut => "the connection to the Inverse Service is cut",
                Self::Closed => "the Inverse Service has closed the connection",
                Self::Silent => "the Inverse Service does not answer",
                Self::DeviceGone => "the Inverse Service no longer lists the device",
                Self::Unplugged => "the service reports that the Inverse3 was unplugged",
                Self::Unreadable => "the Inverse Service sends invalid frames",
                Self::Safety => "the service reports a safety stop of the Inverse3",
                Self::NoPower => Unfit::NoPower.text(),
                Self::NotStarted => Unfit::NotStarted.text(),
                Self::NotCalibrated => Unfit::NotCalibrated.text(),
                Self::NotReady => Unfit::NotReady.text(),
            },
        )
    }
}

impl From<Unfit> for Cause {
    fn from(unfit: Unfit) -> Self {
        match unfit {
            Unfit::NoPower => Self::NoPower,
            Unfit::NotStarted => Self::NotStarted,
            Unfit::NotCalibrated => Self::NotCalibrated,
            // `open` already checked for another user and another model.
            Unfit::NotReady | Unfit::InUse | Unfit::OtherModel => Self::NotReady,
        }
    }
}

/// Number of stored send times: more than the number of messages in flight.
const REMEMBERED: usize = 16;

/// State shared by the three threads.
#[derive(Debug)]
pub(super) struct Link {
    origin: Instant,
    sent: AtomicU64,
    answered: AtomicU64,
    sent_at: [AtomicU64; REMEMBERED],
    last_frame: AtomicU64,
    gone: AtomicU8,
    /// Current reason why the device accepts no forces.
    unfit: AtomicU8,
    /// Earlier reason that the loop has not yet received.
    unmodelled: AtomicU8,
    cut: AtomicBool,
    ending: AtomicBool,
    pub counts: AtomicCounts,
}

/// Match of an answer with the sent messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fits {
    /// Answers a message of this age.
    Answers(Duration),
    /// Every message was already answered.
    Surplus,
}

impl Link {
    pub fn new() -> Self {
        Self {
            origin: Instant::now(),
            sent: AtomicU64::new(0),
            answered: AtomicU64::new(0),
            sent_at: Default::default(),
            last_frame: AtomicU64::new(0),
            gone: AtomicU8::new(0),
            unfit: AtomicU8::new(0),
            unmodelled: AtomicU8::new(0),
            cut: AtomicBool::new(false),
            ending: AtomicBool::new(false),
            counts: AtomicCounts::default(),
        }
    }

    fn nanoseconds(&self, now: Instant) -> u64 {
        let since = now.saturating_duration_since(self.origin).as_nanos();
        u64::try_from(since).unwrap_or(u64::MAX)
    }

    #[allow(clippy::cast_possible_truncation, reason = "a remainder is small")]
    fn sent_at(&self, number: u64) -> &AtomicU64 {
        &self.sent_at[(number % REMEMBERED as u64) as usize]
    }

    /// Records a message. Called before sending it, because the answer may arrive immediately.
    pub fn sends(&self, now: Instant) {
        let number = self.sent.load(Ordering::Acquire) + 1;
        self.sent_at(number)
            .store(self.nanoseconds(now), Ordering::Release);
        self.sent.store(number, Ordering::Release);
    }

    /// Records a received frame. Each message has one answer, in order.
    pub fn comes(&self, now: Instant) -> Fits {
        let came = self.nanoseconds(now);
        self.last_frame.store(came, Ordering::Release);
        loop {
            let answered = self.answered.load(Ordering::Acquire);
            if answered >= self.sent.load(Ordering::Acquire) {
                return Fits::Surplus;
            }
            let sent_at = self.sent_at(answered + 1).load(Ordering::Acquire);
            let exchange = self.answered.compare_exchange(
                answered,
                answered + 1,
                Ordering::AcqRel,
                Ordering::Acquire,
            );
            if exchange.is_ok() {
                return Fits::Answers(Duration::from_nanos(came.saturating_sub(sent_at)));
            }
        }
    }

    /// Returns the number of unanswered messages and the age of the oldest one.
    pub fn owed(&self, now: Instant) -> (u64, Duration) {
        let answered = self.answered.load(Ordering::Acquire);
        let owed = self.sent.load(Ordering::Acquire).saturating_sub(answered);
        let sent_at = self.sent_at(answered + 1).load(Ordering::Acquire);
        let age = self.nanoseconds(now).saturating_sub(sent_at);
        (owed, Duration::from_nanos(age))
    }

    /// Returns the number of answers and the time since the last frame.
    pub fn heard(&self, now: Instant) -> (u64, Duration) {
        let last = self.last_frame.load(Ordering::Acquire);
        let since = self.nanoseconds(now).saturating_sub(last);
        (
            self.answered.load(Ordering::Acquire),
            Duration::from_nanos(since),
        )
    }

    /// Gives up all unanswered messages, unless an answer has arrived since there were `heard` answers.
    pub fn write_off(&self, heard: u64) {
        let sent = self.sent.load(Ordering::Acquire);
        let exchange =
            self.answered
                .compare_exchange(heard, sent, Ordering::AcqRel, Ordering::Acquire);
        if exchange.is_ok() {
            let lost = sent.saturating_sub(heard);
            self.counts.lost.fetch_add(lost, Ordering::Relaxed);
        }
    }

    /// Records a failure that only a new connection repairs; the first cause is kept.
    pub fn lose(&self, cause: Cause) {
        let _ = self
            .gone
            .compare_exchange(0, cause as u8, Ordering::AcqRel, Ordering::Acquire);
    }

    /// Sets or clears the reason why the device accepts no forces. A temporary reason is kept until the loop has
    /// received it.
    pub fn set_unfit(&self, cause: Option<Cause>) {
        let code = cause.map_or(0, |cause| cause as u8);
        if self.unfit.swap(code, Ordering::AcqRel) != code && code != 0 {
            // Keep the first cause.
            let _ = self
                .unmodelled
                .compare_exchange(0, code, Ordering::AcqRel, Ordering::Acquire);
        }
    }

    /// Records a reason without an end of its own.
    pub fn was_unfit(&self, cause: Cause) {
        self.unmodelled.store(cause as u8, Ordering::Release);
    }

    /// Returns whether only a new connection helps.
    pub fn is_lost(&self) -> bool {
        self.gone.load(Ordering::Acquire) != 0
    }

    /// Returns the reason why the device receives no force now, if any.
    pub fn unfit(&self) -> Option<Cause> {
        Cause::new(self.unmodelled.load(Ordering::Acquire))
            .or_else(|| Cause::new(self.unfit.load(Ordering::Acquire)))
    }

    /// Returns the error for the loop, if any.
    pub fn error(&self) -> Option<DeviceError> {
        Cause::new(self.gone.load(Ordering::Acquire))
            .or(self.unfit())
            .map(Cause::error)
    }

    /// Returns the error for the loop. An earlier reason is then cleared, but the loop's older orders stay cut.
    pub fn tell(&self) -> Option<DeviceError> {
        let unmodelled = self.unmodelled.load(Ordering::Acquire);
        let error = self.error()?;
        if unmodelled != 0 {
            self.cut();
            // Clear only the reported reason; another one may have followed.
            let _ = self.unmodelled.compare_exchange(
                unmodelled,
                0,
                Ordering::AcqRel,
                Ordering::Acquire,
            );
        }
        Some(error)
    }

    /// Commands zero force until the loop's next order. Called by the supervisor.
    pub fn cut(&self) {
        self.cut.store(true, Ordering::Release);
    }

    /// Ends a cut, because the loop has ordered a force.
    pub fn uncut(&self) {
        self.cut.store(false, Ordering::Release);
    }

    pub fn is_cut(&self) -> bool {
        self.cut.load(Ordering::Acquire)
    }

    /// Asks both threads to end.
    pub fn end(&self) {
        self.ending.store(true, Ordering::Release);
    }

    pub fn is_ending(&self) -> bool {
        self.ending.load(Ordering::Acquire)
    }
}

/// Counters of a connection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Sent messages.
    pub sent: u64,
    /// Answers used as a sample.
    pub fresh: u64,
    /// Answers that arrived too late.
    pub late: u64,
    /// Frames without a message to answer.
    pub surplus: u64,
    /// Rejected frames.
    pub garbage: u64,
    /// Answers that never arrived.
    pub lost: u64,
    /// Times that the service stalled for longer than the reply timeout.
    pub stalls: u64,
    /// Longest round trip of a sample.
    pub longest_round_trip: Duration,
}

/// Atomic counterpart of `Counts`.
#[derive(Debug, Default)]
pub(super) struct AtomicCounts {
    pub fresh: AtomicU64,
    pub late: AtomicU64,
    pub surplus: AtomicU64,
    pub garbage: AtomicU64,
    pub lost: AtomicU64,
    pub stalls: AtomicU64,
    pub longest: AtomicU64,
}

impl AtomicCounts {
    pub fn add(count: &AtomicU64) {
        count.fetch_add(1, Ordering::Relaxed);
    }

    pub fn round_trip(&self, duration: Duration) {
        let nanoseconds = u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX);
        self.longest.fetch_max(nanoseconds, Ordering::Relaxed);
    }
}

impl Link {
    /// Returns the counters.
    pub fn counted(&self) -> Counts {
        let of = |count: &AtomicU64| count.load(Ordering::Relaxed);
        Counts {
            sent: self.sent.load(Ordering::Acquire),
            fresh: of(&self.counts.fresh),
            late: of(&self.counts.late),
            surplus: of(&self.counts.surplus),
            garbage: of(&self.counts.garbage),
            lost: of(&self.counts.lost),
            stalls: of(&self.counts.stalls),
            longest_round_trip: Duration::from_nanos(of(&self.counts.longest)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_message_has_one_answer_in_order() {
        let link = Link::new();
        let at = |ms| link.origin + Duration::from_millis(ms);
        assert_eq!(link.comes(at(1)), Fits::Surplus);
        link.sends(at(2));
        link.sends(at(5));
        assert_eq!(link.owed(at(6)), (2, Duration::from_millis(4)));
        assert_eq!(link.comes(at(8)), Fits::Answers(Duration::from_millis(6)));
        assert_eq!(link.owed(at(9)), (1, Duration::from_millis(4)));
        assert_eq!(link.comes(at(9)), Fits::Answers(Duration::from_millis(4)));
        assert_eq!(link.comes(at(9)), Fits::Surplus);
        assert_eq!(link.owed(at(9)).0, 0);
    }

    #[test]
    fn what_is_written_off_is_not_waited_for() {
        let link = Link::new();
        let now = link.origin;
        link.sends(now);
        link.sends(now);
        link.comes(now);
        // Another answer has arrived: nothing is given up.
        link.write_off(0);
        assert_eq!(link.owed(now).0, 1);
        link.write_off(1);
        assert_eq!(link.owed(now).0, 0);
        assert_eq!(link.counted().lost, 1);
        assert_eq!(link.comes(now), Fits::Surplus);
    }

    #[test]
    fn first_final_cause_is_reported() {
        let link = Link::new();
        assert_eq!(link.error(), None);
        link.set_unfit(Some(Cause::NotReady));
        assert_eq!(link.error().unwrap().kind, DeviceErrorKind::Refused);
        link.set_unfit(None);
        let error = link.tell().unwrap();
        assert!(error.what.contains("no longer ready"), "{error}");
        assert_eq!(link.error(), None);
        link.lose(Cause::Silent);
        link.lose(Cause::Cut);
        let error = link.error().unwrap();
        assert_eq!(error.kind, DeviceErrorKind::Disconnected);
        assert!(error.what.contains("does not answer"));
    }

    #[test]
    fn cause_of_disabled_force_persists_until_reported() {
        let link = Link::new();
        for _ in 0..3 {
            link.set_unfit(Some(Cause::NoPower));
            link.set_unfit(None);
        }
        assert_eq!(link.unfit(), Some(Cause::NoPower));
        let messages = link.tell();
        assert_eq!(messages, Some(Cause::NoPower.error()));
        assert_eq!((link.unfit(), link.tell()), (None, None));
        // Orders older than the report are ignored.
        assert!(link.is_cut());
        // A lasting reason applies before and after it is reported.
        link.set_unfit(Some(Cause::NotReady));
        for _ in 0..3 {
            assert_eq!(link.tell(), Some(Cause::NotReady.error()));
        }
        assert_eq!(link.unfit(), Some(Cause::NotReady));
        link.set_unfit(None);
        assert_eq!(link.unfit(), None);
    }

    #[test]
    fn every_cause_has_a_code_of_its_own() {
        for cause in Cause::ALL {
            assert_eq!(Cause::new(cause as u8), Some(cause));
        }
        assert_eq!(Cause::new(0), None);
    }
}
