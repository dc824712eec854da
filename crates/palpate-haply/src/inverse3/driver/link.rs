//! What the loop's thread, the reader and the writer tell each other without waiting.

use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use palpate_device::{DeviceError, DeviceErrorKind, Vector};

use super::super::fitness::Unfit;

/// What the loop wants to be commanded.
#[derive(Clone, Copy, Debug)]
pub(super) struct Order {
    /// They count from 1; 0: nothing yet.
    pub number: u64,
    /// `[N]`.
    pub force: Vector,
    /// On the loop's clock.
    pub at: Duration,
}

/// Where the device was.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arrival {
    /// They count from 1; 0: nothing yet.
    pub number: u64,
    /// `[m]`.
    pub position: Vector,
    /// When the frame came, on the loop's clock.
    pub time: Duration,
}

/// Why no force goes to the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Cause {
    /// The connection is cut.
    Cut = 1,
    /// The service closed it.
    Closed,
    /// Nothing came for too long.
    Silent,
    /// The device is no longer in the frames.
    DeviceGone,
    /// The service has told that it was unplugged.
    Unplugged,
    /// Frames come that are none.
    Unreadable,
    /// The device's own safety acted.
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

    fn of(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|cause| *cause as u8 == code)
    }

    /// Whether only connecting anew helps.
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
                Self::DeviceGone => "the Inverse Service no longer has the device",
                Self::Unplugged => "the Inverse3 was unplugged, says its service",
                Self::Unreadable => "the Inverse Service sends frames that are none",
                Self::Safety => "the Inverse3's own safety has acted, says its service",
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
            // Who else commands it, and what it is, is asked when it is opened.
            Unfit::NotReady | Unfit::InUse | Unfit::OtherModel => Self::NotReady,
        }
    }
}

/// Send times that are remembered: more messages than can be under way.
const REMEMBERED: usize = 16;

/// Shared by the three.
#[derive(Debug)]
pub(super) struct Link {
    origin: Instant,
    sent: AtomicU64,
    answered: AtomicU64,
    sent_at: [AtomicU64; REMEMBERED],
    last_frame: AtomicU64,
    gone: AtomicU8,
    /// Why the device takes no forces now.
    unfit: AtomicU8,
    /// Why it took none, which the loop has not been told yet.
    untold: AtomicU8,
    cut: AtomicBool,
    ending: AtomicBool,
    pub counts: AtomicCounts,
}

/// How an answer fits what was sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fits {
    /// It answers a message of this age.
    Answers(Duration),
    /// Every message had its answer already.
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
            untold: AtomicU8::new(0),
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

    /// The writer is about to send a message. Said before it is done: no answer is faster.
    pub fn sends(&self, now: Instant) {
        let number = self.sent.load(Ordering::Acquire) + 1;
        self.sent_at(number)
            .store(self.nanoseconds(now), Ordering::Release);
        self.sent.store(number, Ordering::Release);
    }

    /// A frame has come. Each message has one answer, in order.
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

    /// Messages without an answer, and how long ago the oldest of them was sent.
    pub fn owed(&self, now: Instant) -> (u64, Duration) {
        let answered = self.answered.load(Ordering::Acquire);
        let owed = self.sent.load(Ordering::Acquire).saturating_sub(answered);
        let sent_at = self.sent_at(answered + 1).load(Ordering::Acquire);
        let age = self.nanoseconds(now).saturating_sub(sent_at);
        (owed, Duration::from_nanos(age))
    }

    /// Answers so far, and how long ago the last frame came.
    pub fn heard(&self, now: Instant) -> (u64, Duration) {
        let last = self.last_frame.load(Ordering::Acquire);
        let since = self.nanoseconds(now).saturating_sub(last);
        (
            self.answered.load(Ordering::Acquire),
            Duration::from_nanos(since),
        )
    }

    /// Answers that were owed when `heard` were there will not come any more.
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

    /// Only connecting anew helps from now on; the first cause is the one to know.
    pub fn lose(&self, cause: Cause) {
        let _ = self
            .gone
            .compare_exchange(0, cause as u8, Ordering::AcqRel, Ordering::Acquire);
    }

    /// The device does not take forces, for this cause, or does. A cause that comes and goes stays
    /// until the loop has been told.
    pub fn set_unfit(&self, cause: Option<Cause>) {
        let code = cause.map_or(0, |cause| cause as u8);
        if self.unfit.swap(code, Ordering::AcqRel) != code && code != 0 {
            // The first one is what happened.
            let _ = self
                .untold
                .compare_exchange(0, code, Ordering::AcqRel, Ordering::Acquire);
        }
    }

    /// The device took no forces for a moment, for this cause, which has no end of its own.
    pub fn was_unfit(&self, cause: Cause) {
        self.untold.store(cause as u8, Ordering::Release);
    }

    /// Whether only connecting anew helps.
    pub fn is_lost(&self) -> bool {
        self.gone.load(Ordering::Acquire) != 0
    }

    /// Why no force goes to the device for now, if so.
    pub fn unfit(&self) -> Option<Cause> {
        Cause::of(self.untold.load(Ordering::Acquire))
            .or_else(|| Cause::of(self.unfit.load(Ordering::Acquire)))
    }

    /// What the loop is to be told.
    pub fn error(&self) -> Option<DeviceError> {
        Cause::of(self.gone.load(Ordering::Acquire))
            .or(self.unfit())
            .map(Cause::error)
    }

    /// Tells the loop. What is over is over from then on, but not for what it ordered before.
    pub fn tell(&self) -> Option<DeviceError> {
        let untold = self.untold.load(Ordering::Acquire);
        let error = self.error()?;
        if untold != 0 {
            self.cut();
            // Only what was told: there may be another one by now.
            let _ = self
                .untold
                .compare_exchange(untold, 0, Ordering::AcqRel, Ordering::Acquire);
        }
        Some(error)
    }

    /// The supervisor commands no force, until the loop's next order.
    pub fn cut(&self) {
        self.cut.store(true, Ordering::Release);
    }

    /// The loop has ordered a force.
    pub fn uncut(&self) {
        self.cut.store(false, Ordering::Release);
    }

    pub fn is_cut(&self) -> bool {
        self.cut.load(Ordering::Acquire)
    }

    /// Both threads are to end.
    pub fn end(&self) {
        self.ending.store(true, Ordering::Release);
    }

    pub fn is_ending(&self) -> bool {
        self.ending.load(Ordering::Acquire)
    }
}

/// What went over the connection so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Messages that were sent.
    pub sent: u64,
    /// Answers that were taken as a sample.
    pub fresh: u64,
    /// Answers that came too late to be one.
    pub late: u64,
    /// Frames that answered nothing.
    pub surplus: u64,
    /// Frames that were not believed.
    pub garbage: u64,
    /// Answers that never came.
    pub lost: u64,
    /// How often the service stood still for longer than an answer may take.
    pub stalls: u64,
    /// Longest round trip that gave a sample.
    pub longest_round_trip: Duration,
}

/// The same, while they change.
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
    /// What went over it so far.
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
        // Another one came meanwhile: nothing is written off.
        link.write_off(0);
        assert_eq!(link.owed(now).0, 1);
        link.write_off(1);
        assert_eq!(link.owed(now).0, 0);
        assert_eq!(link.counted().lost, 1);
        assert_eq!(link.comes(now), Fits::Surplus);
    }

    #[test]
    fn the_first_cause_that_is_final_is_told() {
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
    fn what_keeps_a_device_from_forces_lasts_until_it_is_told() {
        let link = Link::new();
        for _ in 0..3 {
            link.set_unfit(Some(Cause::NoPower));
            link.set_unfit(None);
        }
        assert_eq!(link.unfit(), Some(Cause::NoPower));
        let told = link.tell();
        assert_eq!(told, Some(Cause::NoPower.error()));
        assert_eq!((link.unfit(), link.tell()), (None, None));
        // What was ordered before it was told does not count.
        assert!(link.is_cut());
        // And as long as it is so, told or not.
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
            assert_eq!(Cause::of(cause as u8), Some(cause));
        }
        assert_eq!(Cause::of(0), None);
    }
}
