//! The emulated Inverse3 as the device of a loop in simulated time, without sockets and threads.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use palpate_device::clock::{Clock, SteppedClock};
use palpate_device::{
    Capabilities, Device as LoopDevice, DeviceError, DeviceErrorKind, Pose, Vector, Wrench,
};
use palpate_testbed::InvalidParameter;

use super::device::{Body, EmulatedDevice};
use super::fault::{Latency, SplitMix64};

/// The emulated Inverse3 as the device of a loop on a [`SteppedClock`]: every run is the same, however
/// busy the machine is.
///
/// The device and the latency are those of the [`Emulator`](super::Emulator). In the place of driver and
/// service messages are exchanged at the pace of the driver's
/// [`Pace`](palpate_haply::inverse3::Pace): a force that was written goes out at once, or as soon as the
/// answer to the message before has come; the same again after `exchange_every`. Half of the latency
/// passes before the service takes a message and sees where the device is, half of it after that.
#[derive(Debug)]
pub struct SteppedInverse3 {
    clock: SteppedClock,
    capabilities: Capabilities,
    device: EmulatedDevice,
    /// The instant that stands for the clock's origin.
    origin: Instant,
    latency: Latency,
    random: SplitMix64,
    exchange_every: Duration,
    /// When the last message was sent, and when its answer came.
    sent: Duration,
    answered: Duration,
    /// The answer that is owed, and when it comes.
    owed: Option<(Duration, Seen)>,
    /// The force that was written and not sent yet, and when the device was seen before.
    order: Option<(Vector, Duration)>,
    force: Vector,
    /// What came last and was not read yet, and when it came.
    arrived: Option<(Duration, Seen)>,
    /// When the service saw what was read last.
    seen: Duration,
    delays: Delays,
}

/// Where a device was, and when.
#[derive(Clone, Copy, Debug)]
struct Seen {
    at: Duration,
    position: Vector,
}

/// How long it took from where a device was seen to the force that followed from that.
#[derive(Clone, Debug, Default)]
pub struct Delays {
    /// `[ns]`
    sum: Arc<AtomicU64>,
    count: Arc<AtomicU64>,
}

impl Delays {
    fn add(&self, delay: Duration) {
        let delay = u64::try_from(delay.as_nanos()).unwrap_or(u64::MAX);
        self.sum.fetch_add(delay, Ordering::Relaxed);
        self.count.fetch_add(1, Ordering::Relaxed);
    }

    /// Their mean; none before the first force.
    #[must_use]
    pub fn mean(&self) -> Option<Duration> {
        let sum = self.sum.load(Ordering::Relaxed);
        let mean = sum.checked_div(self.count.load(Ordering::Relaxed))?;
        Some(Duration::from_nanos(mean))
    }
}

impl SteppedInverse3 {
    /// A device that is `body`, behind a service of this latency.
    ///
    /// # Errors
    /// A quantity of the body outside its range.
    pub fn new(
        body: &Body,
        latency: Latency,
        exchange_every: Duration,
        clock: SteppedClock,
    ) -> Result<Self, InvalidParameter> {
        let start = clock.now();
        Ok(Self {
            sent: start,
            answered: start,
            clock,
            capabilities: Capabilities::unknown("Haply Inverse3, in simulated time", 3),
            device: EmulatedDevice::new("stepped".to_owned(), body, Duration::from_secs(1))?,
            origin: Instant::now(),
            latency,
            random: SplitMix64(1),
            exchange_every,
            owed: None,
            order: Some(([0.0; 3], start)),
            force: [0.0; 3],
            arrived: None,
            seen: start,
            delays: Delays::default(),
        })
    }

    /// The delays so far; they go on being counted.
    #[must_use]
    pub fn delays(&self) -> Delays {
        self.delays.clone()
    }

    /// Exchanges messages up to now.
    fn exchange(&mut self) {
        let now = self.clock.now();
        loop {
            if let Some((at, seen)) = self.owed {
                if at > now {
                    return;
                }
                self.owed = None;
                self.answered = at;
                self.arrived = Some((at, seen));
                // An order that has waited goes with the answer.
                if self.order.is_some() {
                    self.send(at);
                }
            } else if self.order.is_some() {
                self.send(now);
            } else {
                let due = self.answered.max(self.sent + self.exchange_every);
                if due > now {
                    return;
                }
                self.send(due);
            }
        }
    }

    /// Sends the last order at `time`, or the same force again.
    fn send(&mut self, time: Duration) {
        let takes = self.latency.draw(&mut self.random);
        self.sent = time;
        let taken = time + takes / 2;
        if let Some((force, seen)) = self.order.take() {
            self.force = force;
            self.delays.add(taken.saturating_sub(seen));
        }
        self.device.command(self.force, self.origin + taken);
        let seen = Seen {
            at: taken,
            position: self.device.position(),
        };
        self.owed = Some((time + takes, seen));
    }
}

impl LoopDevice for SteppedInverse3 {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn read(&mut self) -> Result<Pose, DeviceError> {
        self.exchange();
        let nothing = DeviceError::new(DeviceErrorKind::NothingNew, "no answer since the last one");
        let (time, seen) = self.arrived.take().ok_or(nothing)?;
        self.seen = seen.at;
        Ok(Pose {
            orientation: None,
            position: seen.position,
            time,
        })
    }

    fn write(&mut self, wrench: Wrench) -> Result<Wrench, DeviceError> {
        self.order = Some((wrench.force, self.seen));
        self.exchange();
        Ok(wrench)
    }
}
